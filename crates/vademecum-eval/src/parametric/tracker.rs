//! Online tracking of live parameters from sensors: an extended Kalman filter over the modal state and the
//! parameters.
//!
//! The modes stay those of the values at which they were found last. Between, the motion changes by the exact
//! first-order change of a step ([`SlopeStep`]). When an estimate has moved by one percent, the eigenproblem
//! is solved again, and state and covariance are carried over by the projection of [`Tuned::carry`].
//!
//! Sources: Kalman 1960; Jazwinski 1970 (extended filter).

use crate::base::error::ParameterError;
use crate::base::lend::Lender;
use crate::kernels::dense::{add_scaled, at, dot, row, row_mut, set};
use crate::parametric::error::ParametricError;
use crate::parametric::model::Parametric;
use crate::parametric::rows::along;
use crate::parametric::slope_step::SlopeStep;
use crate::parametric::tracked::{Covariance, Tracked};
use crate::sections::rows::Field;

/// A sensor: a probe of the file, its displacement or its velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Number of the probe.
    pub probe: usize,
    /// Displacement or velocity.
    pub field: Field,
    /// Standard deviation of the noise, in the unit of the measured number.
    pub deviation: f64,
}

/// Settings of a [`Tracker`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackerOptions<'o> {
    /// Number of modes.
    pub modes: usize,
    /// Parameters that are tracked; the others stay as they were given.
    pub tracked: &'o [Tracked],
    /// Sensors.
    pub sensors: &'o [Sensor],
    /// Standard deviation of unknown loads along each mode \[N/√kg\] over a step: what neither the known
    /// loads nor the parameters explain.
    pub load_deviation: f64,
    /// Change of an estimate, as a share of its value (or of its range, if that begins at 0 or below), after
    /// which the eigenproblem is solved again; 0.01 is usual.
    pub resolve: f64,
}

/// An extended Kalman filter over modal coordinates, their rates and live parameters, in lent memory.
#[derive(Debug)]
pub struct Tracker<'m, 'f, 'o> {
    model: Parametric<'f>,
    options: TrackerOptions<'o>,
    step: SlopeStep<'m>,
    /// Modes at two sets of values: those in use, and those that are found next.
    modes: [&'m mut [f64]; 2],
    current: usize,
    /// Values of all parameters at which the modes were found, and those estimated.
    found_at: &'m mut [f64],
    values: &'m mut [f64],
    /// `(q, q̇)`, then the coordinate of each tracked parameter.
    state: &'m mut [f64],
    covariance: Covariance<'m>,
    /// Rows of the sensors over the modes.
    rows: &'m mut [f64],
    starts: &'m mut [f64],
    ends: &'m mut [f64],
    /// First-order changes of a step for each parameter of the file.
    changes: &'m mut [f64],
    work: &'m mut [f64],
    /// Sum of the squares of the innovations over their variances, and their number.
    innovations: [f64; 2],
    solved: usize,
}

impl Parametric<'_> {
    /// Numbers of memory to lend for a [`Tracker`].
    ///
    /// # Errors
    /// [`ParametricError::Modes`], [`ParametricError::Format`].
    pub fn tracker_len(&self, options: &TrackerOptions<'_>) -> Result<usize, ParametricError> {
        let (m, p, r) = (options.modes, self.n_parameters(), self.n_basis());
        let sizes = self.sizes(m)?;
        let n = 2 * m + options.tracked.len();
        let work = sizes.work.max(SlopeStep::work(self, m)).max(m * m + 3 * r);
        let own = 2 * p + n + options.sensors.len() * m + 2 * m + 2 * m * p;
        Ok(SlopeStep::len(self, m) + 2 * sizes.memory + Covariance::len(n) + own + work)
    }
}

impl<'m, 'f, 'o> Tracker<'m, 'f, 'o> {
    /// A body at rest, with parameters at these values. Lends [`Parametric::tracker_len`].
    ///
    /// # Errors
    /// [`ParametricError`]: a parameter or probe that there is not, values out of the box, memory that is too
    /// short.
    pub fn new(
        model: &Parametric<'f>,
        options: &TrackerOptions<'o>,
        values: &[f64],
        memory: &'m mut [f64],
    ) -> Result<Self, ParametricError> {
        let (m, p) = (options.modes, model.n_parameters());
        let (found, needed) = (memory.len(), model.tracker_len(options)?);
        let short = ParametricError::LentMemory { what: "numbers of memory", found, needed };
        if found < needed {
            return Err(short);
        }
        if let Some(own) = options.tracked.iter().find(|own| own.parameter >= p) {
            return Err(ParameterError::Unknown { index: own.parameter }.into());
        }
        if values.len() != p {
            return Err(ParametricError::Values { found: values.len(), needed: p });
        }
        let each = model.sizes(m)?.memory;
        let mut lender = Lender::new(memory);
        let step = SlopeStep::new(model, m, &mut lender)?;
        let n = 2 * m + options.tracked.len();
        let covariance = Covariance::new(n, &mut lender).ok_or(short)?;
        let mut take = |n| lender.take(n).map_err(|_| short);
        let modes = [take(each)?, take(each)?];
        let (found_at, own_values, state) = (take(p)?, take(p)?, take(n)?);
        let rows = take(options.sensors.len() * m)?;
        let (starts, ends, changes) = (take(m)?, take(m)?, take(2 * m * p)?);
        own_values.copy_from_slice(values);
        state.fill(0.0);
        starts.fill(0.0);
        let mut tracker = Self {
            model: *model,
            options: *options,
            step,
            modes,
            current: 0,
            found_at,
            values: own_values,
            state,
            covariance,
            rows,
            starts,
            ends,
            changes,
            work: lender.rest(),
            innovations: [0.0; 2],
            solved: 0,
        };
        for (place, own) in options.tracked.iter().enumerate() {
            let value = at(tracker.values, own.parameter);
            let coordinate = tracker.axis(place).coordinate(value);
            set(tracker.state, 2 * m + place, coordinate);
            tracker.covariance.set_own(2 * m + place, own.deviation * own.deviation);
        }
        tracker.solve()?;
        Ok(tracker)
    }

    fn axis(&self, place: usize) -> Axis {
        let parameter = self.options.tracked.get(place).and_then(|own| self.model.live.get(own.parameter));
        parameter.map_or(Axis { lower: 0.0, upper: 0.0 }, |own| Axis { lower: own.lower, upper: own.upper })
    }

    /// Finds the modes at the estimates, and what belongs to them.
    fn solve(&mut self) -> Result<(), ParametricError> {
        let m = self.options.modes;
        let [first, second] = &mut self.modes;
        let (memory, before) = if self.current == 0 { (second, first) } else { (first, second) };
        let tuned = self.model.solve(self.values, m, memory, self.work)?;
        self.step.fill(&self.model, &tuned, self.work)?;
        if self.solved > 0 {
            let from = self.model.view(m, before).ok_or(ParametricError::NoConvergence)?;
            let (turn, work) = self.work.split_at_mut(m * m);
            let (unit, work) = work.split_at_mut(m);
            // Columns of `X'ᵀ B' X`, one for each mode before.
            for k in 0..m {
                unit.fill(0.0);
                set(unit, k, 1.0);
                tuned.carry(&from, unit, row_mut(turn, k, m), work)?;
            }
            self.covariance.turn(m, turn, self.state);
        }
        let r = self.model.n_basis();
        for (sensor, out) in self.options.sensors.iter().zip(self.rows.chunks_exact_mut(m.max(1))) {
            let over_basis = self.work.get_mut(..r).unwrap_or_default();
            self.model.probe_row(sensor.probe, over_basis)?;
            out.iter_mut().zip(along(tuned.shapes, over_basis)).for_each(|(to, from)| *to = from);
        }
        self.found_at.copy_from_slice(self.values);
        self.current = 1 - self.current;
        self.solved += 1;
        Ok(())
    }

    /// Takes a step under loads along the basis, `r` numbers each, at its start and its end, and one measured
    /// number of each sensor at its end; one that is not finite is left out. `O((2m + P)²)` beside
    /// `O(P m²)`, and `O(r³)` where the modes are found again. Allocates nothing.
    ///
    /// # Errors
    /// [`ParametricError::NoConvergence`]: modes that cannot be found at the estimates.
    pub fn step(&mut self, start: &[f64], end: &[f64], measured: &[f64]) -> Result<(), ParametricError> {
        self.predict(start, end)?;
        let m = self.options.modes;
        for (index, (sensor, &measured)) in self.options.sensors.iter().zip(measured).enumerate() {
            if !measured.is_finite() {
                continue;
            }
            let first = if sensor.field == Field::Displacement { 0 } else { m };
            let own = row(self.rows, index, m);
            let expected = dot(own, self.state.get(first..first + m).unwrap_or_default());
            let variance = sensor.deviation * sensor.deviation;
            let surprise = measured - expected;
            let total = self.covariance.update(first, own, variance, surprise, self.state);
            self.innovations[0] += surprise * surprise / total;
            self.innovations[1] += 1.0;
        }
        self.read_values();
        let moved = self.options.tracked.iter().enumerate().any(|(place, own)| {
            let axis = self.axis(place);
            let [now, before] =
                [&*self.values, &*self.found_at].map(|all| axis.coordinate(at(all, own.parameter)));
            (now - before).abs() > self.options.resolve * axis.width()
        });
        if moved { self.solve() } else { Ok(()) }
    }

    /// State and covariance after a step, before it is measured.
    fn predict(&mut self, start: &[f64], end: &[f64]) -> Result<(), ParametricError> {
        let m = self.options.modes;
        let shapes = {
            let own = self.modes.get(self.current).ok_or(ParametricError::NoConvergence)?;
            self.model.view(m, own).ok_or(ParametricError::NoConvergence)?.shapes
        };
        self.starts.iter_mut().zip(along(shapes, start)).for_each(|(to, from)| *to = from);
        self.ends.iter_mut().zip(along(shapes, end)).for_each(|(to, from)| *to = from);
        let motion = self.state.get(..2 * m).unwrap_or_default();
        self.step.slopes_into(&self.model, motion, self.starts, self.ends, self.changes);
        // Slopes in the coordinates of the tracked parameters, and the change that their moves make.
        for (place, own) in self.options.tracked.iter().enumerate() {
            let axis = self.axis(place);
            let base = at(self.found_at, own.parameter);
            let slope = axis.slope(base);
            row_mut(self.changes, own.parameter, 2 * m).iter_mut().for_each(|change| *change *= slope);
        }
        let (motion, _) = self.state.split_at_mut(2 * m);
        self.step.advance(motion, self.starts, self.ends);
        for (place, own) in self.options.tracked.iter().enumerate() {
            let axis = self.axis(place);
            let moved = at(self.state, 2 * m + place) - axis.coordinate(at(self.found_at, own.parameter));
            let change = row(self.changes, own.parameter, 2 * m);
            add_scaled(self.state.get_mut(..2 * m).unwrap_or_default(), moved, change);
        }
        let time_step = self.model.scales(self.found_at).time_step;
        self.covariance.predict(m, &self.step, self.changes, self.options.tracked);
        let unrest = self.options.load_deviation;
        for k in 0..m {
            let [of_q, of_v] = self.step.of_load(k);
            self.covariance.add_load(m, k, [unrest * of_q, unrest * of_v]);
        }
        for (place, own) in self.options.tracked.iter().enumerate() {
            self.covariance.add_own(2 * m + place, own.drift * own.drift * time_step);
        }
        Ok(())
    }

    /// Values of the tracked parameters from their coordinates, held inside the box.
    fn read_values(&mut self) {
        let m = self.options.modes;
        for (place, own) in self.options.tracked.iter().enumerate() {
            let axis = self.axis(place);
            let value = axis.value(at(self.state, 2 * m + place)).clamp(axis.lower, axis.upper);
            set(self.state, 2 * m + place, axis.coordinate(value));
            set(self.values, own.parameter, value);
        }
    }

    /// Values of all parameters, those that are tracked as estimated.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        self.values
    }

    /// Standard deviation of tracked parameter `place`: relative, if its range lies above 0, and else in its
    /// unit; 0 of one that there is not.
    #[must_use]
    pub fn deviation(&self, place: usize) -> f64 {
        if place >= self.options.tracked.len() {
            return 0.0;
        }
        libm::sqrt(self.covariance.own(2 * self.options.modes + place).max(0.0))
    }

    /// Mean square of the innovations over their variances since the last call: near 1 where model, noise and
    /// drift are what they are said to be. None before anything was measured.
    pub fn take_consistency(&mut self) -> Option<f64> {
        let [sum, count] = core::mem::take(&mut self.innovations);
        (count > 0.0).then(|| sum / count)
    }

    /// Number of eigenproblems solved so far.
    #[must_use]
    pub const fn solved(&self) -> usize {
        self.solved
    }
}

/// A parameter in the coordinate that it is tracked in: its logarithm, if its range lies above 0.
#[derive(Clone, Copy)]
struct Axis {
    lower: f64,
    upper: f64,
}

impl Axis {
    fn is_log(self) -> bool {
        self.lower > 0.0
    }

    fn coordinate(self, value: f64) -> f64 {
        if self.is_log() { libm::log(value) } else { value }
    }

    fn value(self, coordinate: f64) -> f64 {
        if self.is_log() { libm::exp(coordinate) } else { coordinate }
    }

    /// Derivative of the value with respect to the coordinate.
    fn slope(self, value: f64) -> f64 {
        if self.is_log() { value } else { 1.0 }
    }

    /// Length that a share is of.
    fn width(self) -> f64 {
        if self.is_log() { 1.0 } else { self.upper - self.lower }
    }
}
