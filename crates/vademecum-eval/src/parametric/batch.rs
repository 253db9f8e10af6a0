//! Many bodies of one parametric file, each at parameters of its own.
//!
//! A body keeps its modes along the basis and their steps, `m (r + 13) + 2 r` numbers, in place of a file:
//! 500 bodies of 32 modes and 128 vectors take 19 MB. Loads and outputs are rows over the basis: the modes
//! feel `Xᵀ (BᵀF)`, and a row `b` shows `b X q`.

use core::ops::Deref;

use crate::base::lend::{Cut, Lender, Short};
use crate::base::scalar::Scalar;
use crate::kernels::dense::{add_scaled, at, dot, set};
use crate::parametric::error::ParametricError;
use crate::parametric::memory::{Carried, project};
use crate::parametric::model::Parametric;
use crate::parametric::tuned::Tuned;
use vademecum_format::SectionKind;
use vademecum_format::exact::Propagator;

/// Numbers of a step for each mode: `D` column by column, then its answers to the load at both ends.
const STEP: usize = 8;

/// Many bodies of one parametric file in lent memory, each with its own values of the parameters, motion and
/// load. Steps are exact in time, of the stepped modes at the values of each body.
///
/// Outputs are those of the stepped modes; residual flexibility is left out, as
/// [`Batch::get`](crate::Batch::get) leaves it out. A [`Simulation`](crate::Simulation) or a
/// [`LiveMemory`](crate::LiveMemory) of its own gives a body all that a file has. Files with dashpots, which
/// couple modes, are refused. A batch knows no threads: a caller with several cores makes a batch for each.
#[derive(Debug)]
pub struct ParametricBatch<'m> {
    modes: usize,
    basis: usize,
    parameters: usize,
    bodies: &'m mut [f64],
    /// Modes at new values.
    memory: &'m mut [f64],
    work: &'m mut [f64],
}

/// The numbers of one body.
struct OneBody<S> {
    values: S,
    eigenvalues: S,
    shapes: S,
    /// [`STEP`] numbers a mode, one kind after the other.
    steps: S,
    /// `BᵀF` at the start and at the end of a step.
    forces: S,
    /// Contribution of the load to `q` and `Δt q̇` in a step.
    increment: S,
    /// `q`, then `Δt q̇`.
    motion: S,
    /// `Δt` \[s\].
    time_step: S,
}

/// Numbers of one body of so many parameters, modes and vectors.
const fn body_len(parameters: usize, modes: usize, basis: usize) -> usize {
    let of_modes = modes.saturating_mul(basis.saturating_add(STEP + 5));
    of_modes.saturating_add(parameters).saturating_add(basis.saturating_mul(2)).saturating_add(1)
}

impl<S: Cut + Deref<Target = [f64]>> OneBody<S> {
    fn of(numbers: S, parameters: usize, modes: usize, basis: usize) -> Result<Self, Short> {
        let mut lender = Lender::new(numbers);
        Ok(Self {
            values: lender.take(parameters)?,
            eigenvalues: lender.take(modes)?,
            shapes: lender.take(modes.saturating_mul(basis))?,
            steps: lender.take(modes.saturating_mul(STEP))?,
            forces: lender.take(basis.saturating_mul(2))?,
            increment: lender.take(modes.saturating_mul(2))?,
            motion: lender.take(modes.saturating_mul(2))?,
            time_step: lender.take(1)?,
        })
    }

    /// The modes, without what only a change needs of new ones.
    fn tuned(&self) -> Tuned<'_> {
        let (values, eigenvalues, shapes) = (&*self.values, &*self.eigenvalues, &*self.shapes);
        Tuned { values, eigenvalues, shapes, lower: &[], mass: &[], density: 1.0 }
    }

    /// Each shape along the basis, with its `q` and its `q̇`.
    fn modes(&self) -> impl Iterator<Item = (&[f64], f64, f64)> {
        let m = self.eigenvalues.len();
        let (q, v) = self.motion.split_at(m.min(self.motion.len()));
        let basis = self.shapes.len().checked_div(m).unwrap_or(0).max(1);
        let time_step = at(&self.time_step, 0);
        let motions = q.iter().zip(v);
        self.shapes.chunks_exact(basis).zip(motions).map(move |(shape, (q, v))| (shape, *q, v / time_step))
    }

    /// One step, from `motion` to `next`; the sum of the magnitudes.
    fn step(&self, next: &mut [f64]) -> f64 {
        let m = self.eigenvalues.len();
        let (q, v) = self.motion.split_at(m.min(self.motion.len()));
        let (of_q, of_v) = self.increment.split_at(m.min(self.increment.len()));
        let (next_q, next_v) = next.split_at_mut(m.min(next.len()));
        let mut kinds = self.steps.chunks_exact(m.max(1));
        let mut kind = || kinds.next().unwrap_or_default();
        let (qq, vq, qv, vv) = (kind(), kind(), kind(), kind());
        let mut sum = 0.0;
        let blocks = qq.iter().zip(vq).zip(qv.iter().zip(vv));
        let now = q.iter().zip(v).zip(of_q.iter().zip(of_v)).zip(blocks);
        for ((next_q, next_v), (((q, v), (of_q, of_v)), ((qq, vq), (qv, vv)))) in
            next_q.iter_mut().zip(next_v).zip(now)
        {
            *next_q = q + (of_q + (qq * q + qv * v));
            *next_v = v + (of_v + (vq * q + vv * v));
            sum += next_q.abs() + next_v.abs();
        }
        sum
    }

    fn is_at_rest(&self) -> bool {
        self.motion.iter().chain(&*self.increment).all(|x| *x == 0.0)
    }
}

impl OneBody<&mut [f64]> {
    /// Carries the motion over to other modes, with velocities scaled by their `Δt` \[s\].
    fn carry(
        &mut self,
        tuned: &Tuned<'_>,
        time_step: f64,
        work: &mut [f64],
    ) -> Result<Carried, ParametricError> {
        let m = self.eigenvalues.len();
        let mut lender = Lender::new(work);
        let (rates, next) = (lender.take(m).map_err(cut)?, lender.take(m).map_err(cut)?);
        let next_rates = lender.take(m).map_err(cut)?;
        let before = at(self.time_step, 0);
        let (q, v) = self.motion.split_at(m.min(self.motion.len()));
        rates.iter_mut().zip(v).for_each(|(rate, v)| *rate = v / before);
        let carried = project((&self.tuned(), q, rates), (tuned, next, next_rates), lender.rest())?;
        let (q, v) = self.motion.split_at_mut(m.min(self.motion.len()));
        copy(q, next);
        v.iter_mut().zip(&*next_rates).for_each(|(v, rate)| *v = time_step * rate);
        Ok(carried)
    }

    /// Takes modes over, with their steps.
    fn take(
        &mut self,
        model: &Parametric<'_>,
        tuned: &Tuned<'_>,
        work: &mut [f64],
    ) -> Result<(), ParametricError> {
        copy(self.values, tuned.values);
        copy(self.eigenvalues, tuned.eigenvalues);
        copy(self.shapes, tuned.shapes);
        let scales = model.scales(tuned.values);
        let mut lender = Lender::new(work);
        let ratios = lender.take(self.eigenvalues.len()).map_err(cut)?;
        if !model.ratios_into(tuned, &scales, ratios, lender.rest()) {
            let built = model.file.section(SectionKind::DampingRatios);
            let built = built.map(|section| section.numbers()).transpose()?;
            let ratio = |k: usize| built.and_then(|built| built.get(k)).unwrap_or(0.0);
            ratios.iter_mut().enumerate().for_each(|(k, to)| *to = ratio(k));
        }
        let m = self.eigenvalues.len();
        for (k, &lambda) in self.eigenvalues.iter().enumerate() {
            let sigma = 0.5 * (scales.alpha + scales.beta * lambda) + at(ratios, k) * libm::sqrt(lambda);
            let Propagator { d, held, rising } = Propagator::new(lambda, sigma, scales.time_step);
            let of_start = [held[0] - rising[0], held[1] - rising[1]];
            let all = [d[0], d[2], d[1], d[3], of_start[0], of_start[1], rising[0], rising[1]];
            for (kind, value) in all.into_iter().enumerate() {
                set(self.steps, kind * m + k, value);
            }
        }
        set(self.time_step, 0, scales.time_step);
        self.drive();
        Ok(())
    }

    /// Contribution of the forces in a step.
    fn drive(&mut self) {
        let m = self.eigenvalues.len();
        let (start, end) = self.forces.split_at(self.forces.len() / 2);
        for (k, shape) in self.shapes.chunks_exact(start.len().max(1)).enumerate() {
            let (start, end) = (dot(shape, start), dot(shape, end));
            let part = |kind: usize| at(self.steps, kind * m + k);
            let added = [part(4) * start + part(6) * end, part(5) * start + part(7) * end];
            set(self.increment, k, added[0]);
            set(self.increment, m + k, added[1]);
        }
    }
}

fn copy(to: &mut [f64], from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// Memory that is shorter than its own length; there is no such.
const fn cut(Short { found, needed }: Short) -> ParametricError {
    ParametricError::LentMemory { what: "numbers of a body", found, needed }
}

impl<'m> ParametricBatch<'m> {
    /// Numbers to lend for so many bodies of so many stepped modes.
    ///
    /// # Errors
    /// [`ParametricError::Modes`]: a number of modes that there is not.
    pub fn len_for(model: &Parametric<'_>, modes: usize, bodies: usize) -> Result<usize, ParametricError> {
        let each = body_len(model.n_parameters(), modes, model.n_basis());
        let once = model.sizes(modes)?.memory.saturating_add(work_len(model, modes)?);
        Ok(each.saturating_mul(bodies).saturating_add(once))
    }

    /// `bodies` at the values as built, at rest and without loads. `memory` holds at least
    /// [`ParametricBatch::len_for`] numbers; what is in it does not matter. `O(r³)`.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # use vademecum_eval::format::File;
    /// # use vademecum_eval::{Parametric, ParametricBatch};
    /// # let bytes =
    /// #     include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/parametric.vdm"));
    /// # let file = File::parse(bytes)?;
    /// let model = Parametric::new(&file)?;
    /// let mut memory = vec![0.0; ParametricBatch::len_for(&model, 2, 500)?];
    /// let mut batch = ParametricBatch::new(&model, 2, 500, &mut memory)?;
    /// let mut values = vec![0.0; model.n_parameters()];
    /// model.nominal_into(&mut values);
    /// model.set(&mut values, &[(0, 1.5)])?;
    /// batch.set_parameters(&model, 7, &values)?;
    ///
    /// let (mut push, mut tip) = (vec![0.0; model.n_basis()], vec![0.0; model.n_basis()]);
    /// model.pattern_row(0, &mut push)?;
    /// model.probe_row(0, &mut tip)?;
    /// for body in 0..500 {
    ///     batch.load(body, &push, &push)?; // held
    /// }
    /// assert_eq!(batch.step(), 0); // none was refused
    /// let [stiffer, softer] = [7, 8].map(|body| batch.value(body, &tip));
    /// assert!(stiffer? != softer?);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`ParametricError`]: memory that is too short, a number of modes that there is not, dashpots that
    /// couple modes.
    pub fn new(
        model: &Parametric<'_>,
        modes: usize,
        bodies: usize,
        memory: &'m mut [f64],
    ) -> Result<Self, ParametricError> {
        if model.file.section(SectionKind::DampingRows).is_some() {
            return Err(ParametricError::Dashpots);
        }
        let (found, needed) = (memory.len(), Self::len_for(model, modes, bodies)?);
        let short = ParametricError::LentMemory { what: "numbers of a batch", found, needed };
        let mut lender = Lender::new(memory.get_mut(..needed).ok_or(short)?);
        let memory = lender.take(model.sizes(modes)?.memory).map_err(cut)?;
        let work = lender.take(work_len(model, modes)?).map_err(cut)?;
        let (parameters, basis, bodies) = (model.n_parameters(), model.n_basis(), lender.rest());
        bodies.fill(0.0);
        let each = body_len(parameters, modes, basis);
        if let Some((first, others)) = bodies.split_at_mut_checked(each) {
            let values = first.get_mut(..parameters).unwrap_or_default();
            model.nominal_into(values);
            let tuned = model.solve(values, modes, memory, work)?;
            OneBody::of(&mut *first, parameters, modes, basis).map_err(cut)?.take(model, &tuned, work)?;
            others.chunks_exact_mut(each.max(1)).for_each(|other| copy(other, first));
        }
        Ok(Self { modes, basis, parameters, bodies, memory, work })
    }

    const fn each(&self) -> usize {
        body_len(self.parameters, self.modes, self.basis)
    }

    /// Number of bodies.
    #[must_use]
    pub const fn n_bodies(&self) -> usize {
        // Never divides by zero: a body has its time step.
        match self.bodies.len().checked_div(self.each()) {
            Some(count) => count,
            None => 0,
        }
    }

    fn body(&self, body: usize) -> Result<OneBody<&[f64]>, ParametricError> {
        let none = ParametricError::NoBody { body, bodies: self.n_bodies() };
        let numbers = self.bodies.chunks_exact(self.each().max(1)).nth(body).ok_or(none)?;
        OneBody::of(numbers, self.parameters, self.modes, self.basis).map_err(cut)
    }

    fn body_mut(&mut self, body: usize) -> Result<OneBody<&mut [f64]>, ParametricError> {
        let none = ParametricError::NoBody { body, bodies: self.n_bodies() };
        let each = self.each().max(1);
        let numbers = self.bodies.chunks_exact_mut(each).nth(body).ok_or(none)?;
        OneBody::of(numbers, self.parameters, self.modes, self.basis).map_err(cut)
    }

    /// Sets all parameters of a body. Its motion is carried over in the mass, as [`Tuned::carry`] does; its
    /// load stays. `O(r³)`.
    ///
    /// # Errors
    /// [`ParametricError::NoBody`]; values out of the box; matrices that are not definite. Nothing has
    /// changed then.
    pub fn set_parameters(
        &mut self,
        model: &Parametric<'_>,
        body: usize,
        values: &[f64],
    ) -> Result<Carried, ParametricError> {
        let (each, bodies) = (self.each().max(1), self.n_bodies());
        let Self { modes, basis, parameters, memory, work, .. } = self;
        if model.n_basis() != *basis || model.n_parameters() != *parameters {
            return Err(ParametricError::OtherModel);
        }
        let none = ParametricError::NoBody { body, bodies };
        let numbers = self.bodies.chunks_exact_mut(each).nth(body).ok_or(none)?;
        let mut body = OneBody::of(numbers, *parameters, *modes, *basis).map_err(cut)?;
        let tuned = model.solve(values, *modes, memory, work)?;
        let carried = body.carry(&tuned, model.scales(values).time_step, work)?;
        body.take(model, &tuned, work)?;
        Ok(carried)
    }

    /// Values of the parameters of a body; none of one that there is not.
    #[must_use]
    pub fn values(&self, body: usize) -> &[f64] {
        self.body(body).map_or(&[], |body| body.values)
    }

    /// Squares of the angular frequencies of the stepped modes of a body \[rad²/s²\], ascending.
    #[must_use]
    pub fn eigenvalues(&self, body: usize) -> &[f64] {
        self.body(body).map_or(&[], |body| body.eigenvalues)
    }

    /// Loads a body with forces along the basis \[N kg^-½\] at the start and at the end of a step, linear
    /// between, in place of what it had: sums of [`Parametric::pattern_row`] and [`Parametric::node_row`].
    /// They stay until the next call. `O(m r)`.
    ///
    /// # Errors
    /// [`ParametricError::NoBody`], [`ParametricError::Forces`]: another number of them than `r`, or not
    /// finite.
    pub fn load(&mut self, body: usize, start: &[f64], end: &[f64]) -> Result<(), ParametricError> {
        let (found, basis) = (start.len().min(end.len()), self.basis);
        let sound = start.iter().chain(end).all(|force| force.in_range());
        if start.len() != basis || end.len() != basis || !sound {
            return Err(ParametricError::Forces { found, needed: basis });
        }
        let mut body = self.body_mut(body)?;
        let (of_start, of_end) = body.forces.split_at_mut(basis.min(body.forces.len()));
        of_start.iter_mut().zip(start).for_each(|(to, from)| *to = *from);
        of_end.iter_mut().zip(end).for_each(|(to, from)| *to = *from);
        body.drive();
        Ok(())
    }

    /// One step of every body, each over its own `Δt`; the number of bodies whose new motion would not be
    /// finite, which keep the one that they have. Bodies at rest without load cost nothing.
    pub fn step(&mut self) -> usize {
        let each = self.each().max(1);
        let mut refused = 0;
        for numbers in self.bodies.chunks_exact_mut(each) {
            let Ok(body) = OneBody::of(numbers, self.parameters, self.modes, self.basis) else { continue };
            if body.is_at_rest() {
                continue;
            }
            let Some(next) = self.work.get_mut(..2 * self.modes) else { continue };
            if body.step(next).in_range() {
                body.motion.iter_mut().zip(&*next).for_each(|(to, from)| *to = *from);
            } else {
                refused += 1;
            }
        }
        refused
    }

    /// Displacement and velocity of a body along a row over the basis, such as [`Parametric::probe_row`]
    /// \[the unit of the row, and over s\]. `O(m r)`.
    ///
    /// # Errors
    /// [`ParametricError::NoBody`], [`ParametricError::Forces`].
    pub fn value(&self, body: usize, row: &[f64]) -> Result<[f64; 2], ParametricError> {
        let (found, needed) = (row.len(), self.basis);
        if found != needed {
            return Err(ParametricError::Forces { found, needed });
        }
        let mut sums = [0.0; 2];
        for (shape, q, rate) in self.body(body)?.modes() {
            let along = dot(shape, row);
            sums = [sums[0] + along * q, sums[1] + along * rate];
        }
        Ok(sums)
    }

    /// Displacement and velocity of a body over the basis, `r` numbers each \[m kg^½, m kg^½/s\]: coordinates
    /// of a [`State`](crate::State) of the file as built, which shows fields and stress. `O(m r)`.
    ///
    /// # Errors
    /// As [`ParametricBatch::value`].
    pub fn motion_into(
        &self,
        body: usize,
        displacement: &mut [f64],
        velocity: &mut [f64],
    ) -> Result<(), ParametricError> {
        let (found, needed) = (displacement.len().min(velocity.len()), self.basis);
        if displacement.len() != needed || velocity.len() != needed {
            return Err(ParametricError::Forces { found, needed });
        }
        displacement.fill(0.0);
        velocity.fill(0.0);
        for (shape, q, rate) in self.body(body)?.modes() {
            add_scaled(displacement, q, shape);
            add_scaled(velocity, rate, shape);
        }
        Ok(())
    }
}

/// Numbers of work of a change: an eigenproblem, two states carried over, ratios.
fn work_len(model: &Parametric<'_>, modes: usize) -> Result<usize, ParametricError> {
    let carried = 3 * modes + 2 * model.n_basis();
    Ok(model.sizes(modes)?.work.max(carried).max(modes + model.loss_work()))
}
