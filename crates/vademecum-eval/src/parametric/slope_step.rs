//! A step of the stepped modes, and its first-order change with the parameters.
//!
//! The modes stay those of the values that they were found at. A change of the matrices couples them
//! ([`coupling`](crate::parametric::coupling)), and a change of density changes the loads along them:
//!
//! ```text
//! δ(q, q̇)_i = Σ_j N_ij L_ij (q, q̇, f₀, f₁)_j − Σ_j D_ij (step of mode i under f_j)
//! ```
//!
//! Modal damping ratios beside Rayleigh's damping stay with their modes: they add the divided difference of
//! their rates over the eigenvalues to `β` in the source of `L_ij`.

use crate::base::lend::Lender;
use crate::kernels::dense::{at, dot, row};
use crate::parametric::coupling::{STEP, coupling, doublings, of_ends, step_of_ends, steps_into, store};
use crate::parametric::damped::Damped;
use crate::parametric::error::ParametricError;
use crate::parametric::model::Parametric;
use crate::parametric::tuned::Tuned;
use vademecum_format::{ParameterRole, SectionKind};

/// Parameters of each kind.
#[derive(Clone, Copy)]
struct Kinds {
    /// Parameters that couple modes.
    coupled: usize,
    /// Parameters of density.
    dense: usize,
}

/// True of a parameter of stiffness or density, and of density.
const fn kind(role: ParameterRole) -> [bool; 2] {
    use ParameterRole as R;
    let dense = matches!(role, R::Density | R::RegionDensity { .. });
    [dense || matches!(role, R::Stiffness | R::RegionStiffness { .. }), dense]
}

fn kinds(model: &Parametric<'_>) -> Kinds {
    model.parameters().fold(Kinds { coupled: 0, dense: 0 }, |sum, parameter| {
        let [coupled, dense] = kind(parameter.role).map(usize::from);
        Kinds { coupled: sum.coupled + coupled, dense: sum.dense + dense }
    })
}

/// A step and its slopes, in lent memory.
#[derive(Debug)]
pub(crate) struct SlopeStep<'m> {
    modes: usize,
    /// `λ`, a number for each mode.
    eigenvalues: &'m mut [f64],
    /// Steps of the modes from the loads at the ends.
    steps: &'m mut [f64],
    /// Changes of the steps with the damping rate.
    of_rates: &'m mut [f64],
    /// `L_ij`.
    couplings: &'m mut [f64],
    /// `N_ij` of each parameter that couples modes.
    stiffness: &'m mut [f64],
    /// `D_ij` of each parameter of density.
    mass: &'m mut [f64],
    /// `L_ij (q, q̇, f₀, f₁)_j`, two numbers for each pair.
    pushed: &'m mut [f64],
}

impl<'m> SlopeStep<'m> {
    /// Numbers that it keeps.
    pub fn len(model: &Parametric<'_>, m: usize) -> usize {
        let Kinds { coupled, dense } = kinds(model);
        m + 2 * STEP * m + (STEP + 2 + coupled + dense) * m * m
    }

    /// Numbers of work of [`SlopeStep::fill`].
    pub fn work(model: &Parametric<'_>, m: usize) -> usize {
        // Steps of each mode over halves of halves, of which there are at most 48.
        (STEP * 49 * m).max(model.slope_work() + m * m)
    }

    /// Memory for so many modes.
    pub fn new(
        model: &Parametric<'_>,
        m: usize,
        lender: &mut Lender<&'m mut [f64]>,
    ) -> Result<Self, ParametricError> {
        model.check_derivatives()?;
        let Kinds { coupled, dense } = kinds(model);
        let mut take = |n| lender.take(n).map_err(|_| ParametricError::NoConvergence);
        Ok(Self {
            modes: m,
            eigenvalues: take(m)?,
            steps: take(STEP * m)?,
            of_rates: take(STEP * m)?,
            couplings: take(STEP * m * m)?,
            stiffness: take(coupled * m * m)?,
            mass: take(dense * m * m)?,
            pushed: take(2 * m * m)?,
        })
    }

    /// Fills it for the modes at these values.
    pub fn fill(
        &mut self,
        model: &Parametric<'_>,
        tuned: &Tuned<'_>,
        work: &mut [f64],
    ) -> Result<(), ParametricError> {
        let m = self.modes;
        let (found, needed) = (work.len(), Self::work(model, m));
        let short = ParametricError::LentMemory { what: "numbers of work", found, needed };
        let work = work.get_mut(..needed).ok_or(short)?;
        self.eigenvalues.copy_from_slice(tuned.eigenvalues.get(..m).ok_or(short)?);
        let scales = model.scales(tuned.values);
        let h = scales.time_step;
        let ratios = model.file.section(SectionKind::DampingRatios).and_then(|own| own.numbers().ok());
        let ratio = |k: usize| ratios.and_then(|ratios| ratios.get(k)).unwrap_or(0.0);
        let damped = Damped { eigenvalues: self.eigenvalues, ratio, alpha: scales.alpha, beta: scales.beta };
        let mode = |k: usize| damped.mode(k);
        let count = doublings((0..m).map(mode), h);
        let length = STEP * (count as usize + 1);
        for (k, steps) in work.chunks_exact_mut(length).take(m).enumerate() {
            steps_into(mode(k), h, count, steps);
        }
        let steps = |k: usize| row(work, k, length);
        let own = self.steps.chunks_exact_mut(STEP).zip(self.of_rates.chunks_exact_mut(STEP));
        for (k, (own, of_rate)) in own.enumerate() {
            store(&step_of_ends(mode(k), h), own);
            let one = (mode(k), steps(k));
            store(&of_ends(&coupling(one, one, [0.0, 1.0], h, count), h), of_rate);
        }
        for (place, out) in self.couplings.chunks_exact_mut(STEP).enumerate() {
            let (i, j) = (place / m.max(1), place % m.max(1));
            let source = [1.0, damped.rate(i, j)];
            let l = coupling((mode(i), steps(i)), (mode(j), steps(j)), source, h, count);
            store(&of_ends(&l, h), out);
        }
        let (mut of_stiffness, mut of_mass) =
            (self.stiffness.chunks_exact_mut((m * m).max(1)), self.mass.chunks_exact_mut((m * m).max(1)));
        let (zeros, work) = work.split_at_mut_checked(m * m).ok_or(short)?;
        for (index, parameter) in model.parameters().enumerate() {
            let [coupled, dense] = kind(parameter.role);
            if coupled {
                let own = of_stiffness.next().unwrap_or_default();
                let mass = if dense { of_mass.next().unwrap_or_default() } else { &mut *zeros };
                tuned.couplings_into(model, index, own, mass, work)?;
            }
        }
        Ok(())
    }

    /// Modes after a step from `(q, q̇)` and the loads along the modes at its ends, `(q, q̇)` again.
    pub fn advance(&self, state: &mut [f64], starts: &[f64], ends: &[f64]) {
        let (q, v) = state.split_at_mut(self.modes.min(state.len()));
        for (k, (q, v)) in q.iter_mut().zip(v).enumerate() {
            let y = [*q, *v, at(starts, k), at(ends, k)];
            let step = row(self.steps, k, STEP).as_chunks().0;
            [*q, *v] = core::array::from_fn(|i| dot_four(step.get(i), &y));
        }
    }

    /// Rows of the exact step of mode `k` without loads.
    pub fn free(&self, k: usize) -> [[f64; 2]; 2] {
        let own = row(self.steps, k, STEP);
        [[at(own, 0), at(own, 1)], [at(own, 4), at(own, 5)]]
    }

    /// Answer of mode `k` to a unit load held over the step.
    pub fn of_load(&self, k: usize) -> [f64; 2] {
        let own = row(self.steps, k, STEP);
        [at(own, 2) + at(own, 3), at(own, 6) + at(own, 7)]
    }

    /// First-order changes of the state after a step, `(q, q̇)` for each parameter; `state` is that before
    /// the step.
    pub fn slopes_into(
        &mut self,
        model: &Parametric<'_>,
        state: &[f64],
        starts: &[f64],
        ends: &[f64],
        out: &mut [f64],
    ) {
        let m = self.modes;
        let y = |k: usize| [at(state, k), at(state, m + k), at(starts, k), at(ends, k)];
        let (of_q, of_v) = self.pushed.split_at_mut(m * m);
        for (i, (of_q, of_v)) in
            of_q.chunks_exact_mut(m.max(1)).zip(of_v.chunks_exact_mut(m.max(1))).enumerate()
        {
            let steps = row(self.couplings, i, STEP * m).as_chunks::<4>().0.as_chunks::<2>().0;
            for (j, (([first, second], of_q), of_v)) in steps.iter().zip(of_q).zip(of_v).enumerate() {
                let y = y(j);
                (*of_q, *of_v) = (dot_four(Some(first), &y), dot_four(Some(second), &y));
            }
        }
        let (mut of_stiffness, mut of_mass) =
            (self.stiffness.chunks_exact((m * m).max(1)), self.mass.chunks_exact((m * m).max(1)));
        for (parameter, out) in model.parameters().zip(out.chunks_exact_mut((2 * m).max(1))) {
            let (q, v) = out.split_at_mut(m);
            let [coupled, dense] = kind(parameter.role);
            let stiffness = if coupled { of_stiffness.next() } else { None }.unwrap_or_default();
            let mass = if dense { of_mass.next() } else { None }.unwrap_or_default();
            for (i, (q, v)) in q.iter_mut().zip(v).enumerate() {
                let own = row(stiffness, i, m);
                *q = dot(own, row(of_q, i, m));
                *v = dot(own, row(of_v, i, m));
                if dense {
                    let own = row(mass, i, m);
                    let loads = [0.0, 0.0, -dot(own, starts), -dot(own, ends)];
                    let step = row(self.steps, i, STEP).as_chunks().0;
                    *q += dot_four(step.first(), &loads);
                    *v += dot_four(step.get(1), &loads);
                }
                let rate = match parameter.role {
                    ParameterRole::Alpha => 1.0,
                    ParameterRole::Beta => at(self.eigenvalues, i),
                    _ => continue,
                };
                let step = row(self.of_rates, i, STEP).as_chunks().0;
                *q += rate * dot_four(step.first(), &y(i));
                *v += rate * dot_four(step.get(1), &y(i));
            }
        }
    }
}

fn dot_four(row: Option<&[f64; 4]>, y: &[f64; 4]) -> f64 {
    row.map_or(0.0, |row| row.iter().zip(y).map(|(a, y)| a * y).sum())
}
