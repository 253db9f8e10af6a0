//! Histories of a parametric model and their exact derivatives with respect to its parameters, side by side.

use crate::base::lend::Lender;
use crate::kernels::dense::{add_scaled, at, row};
use crate::parametric::error::ParametricError;
use crate::parametric::model::Parametric;
use crate::parametric::rows::along;
use crate::parametric::slope_step::SlopeStep;
use crate::parametric::tuned::Tuned;
use crate::sections::rows::Field;

/// Memory to lend for a march with derivatives: [`Tangents`], or a
/// [`CheckpointedMarch`](crate::CheckpointedMarch).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TangentSizes {
    /// Numbers that the march keeps.
    pub memory: usize,
    /// Numbers of work while it is begun.
    pub work: usize,
}

/// A march of the stepped modes from rest, and the derivative of the motion with respect to each parameter
/// (forward mode): steps of the file, loads that are linear over each, exact in time.
///
/// The derivative is that of the motion in the span of the stepped modes. Where all modes of the basis are
/// stepped, it is the derivative of the whole answer of the basis to rounding. With fewer it leaves out that
/// the span turns; residual flexibility is in neither. A parameter of the time step has zeros. Modes of one
/// frequency and different damping ratios beside Rayleigh's damping have no derivative; the mean of the
/// ratios is taken.
#[derive(Debug)]
pub struct Tangents<'m, 'f> {
    model: Parametric<'f>,
    tuned: Tuned<'m>,
    step: SlopeStep<'m>,
    state: &'m mut [f64],
    /// `(q, q̇)` of each parameter, before a step and its change.
    slopes: &'m mut [f64],
    changes: &'m mut [f64],
    starts: &'m mut [f64],
    ends: &'m mut [f64],
}

impl Parametric<'_> {
    /// Memory to lend for [`Tangents`] of so many stepped modes.
    #[must_use]
    pub fn tangent_sizes(&self, modes: usize) -> TangentSizes {
        let state = 2 * modes * (1 + 2 * self.n_parameters()) + 2 * modes;
        let memory = SlopeStep::len(self, modes) + state;
        TangentSizes { memory, work: SlopeStep::work(self, modes) }
    }
}

impl<'m, 'f> Tangents<'m, 'f> {
    /// A body at rest with its modes at given values. Lends [`TangentSizes`]. `O(m² log) + O(P m r²)`.
    ///
    /// # Errors
    /// [`ParametricError::LentMemory`], [`ParametricError::LossFactors`], [`ParametricError::Dashpots`].
    pub fn new(
        model: &Parametric<'f>,
        tuned: Tuned<'m>,
        memory: &'m mut [f64],
        work: &mut [f64],
    ) -> Result<Self, ParametricError> {
        let m = tuned.eigenvalues.len();
        let (found, needed) = (memory.len(), model.tangent_sizes(m).memory);
        let short = ParametricError::LentMemory { what: "numbers of memory", found, needed };
        if found < needed {
            return Err(short);
        }
        let mut lender = Lender::new(memory);
        let mut step = SlopeStep::new(model, m, &mut lender)?;
        step.fill(model, &tuned, work)?;
        let mut take = |n| lender.take(n).map_err(|_| short);
        let all = 2 * m * model.n_parameters();
        let (state, slopes, changes) = (take(2 * m)?, take(all)?, take(all)?);
        let (starts, ends) = (take(m)?, take(m)?);
        state.fill(0.0);
        slopes.fill(0.0);
        Ok(Self { model: *model, tuned, step, state, slopes, changes, starts, ends })
    }

    /// Takes a step under loads along the basis, `r` numbers each, at its start and at its end; between them
    /// they are linear. Rows of loads are those of [`Parametric::pattern_row`] and [`Parametric::node_row`].
    /// `O(P m²)`.
    pub fn step(&mut self, start: &[f64], end: &[f64]) {
        let shapes = self.tuned.shapes;
        self.starts.iter_mut().zip(along(shapes, start)).for_each(|(to, from)| *to = from);
        self.ends.iter_mut().zip(along(shapes, end)).for_each(|(to, from)| *to = from);
        self.step.slopes_into(&self.model, self.state, self.starts, self.ends, self.changes);
        let width = self.state.len().max(1);
        for (slope, change) in self.slopes.chunks_exact_mut(width).zip(self.changes.chunks_exact(width)) {
            self.step.advance(slope, &[], &[]);
            add_scaled(slope, 1.0, change);
        }
        self.step.advance(self.state, self.starts, self.ends);
    }

    /// Displacement or velocity along a row of the basis, `r` numbers.
    #[must_use]
    pub fn value(&self, row: &[f64], field: Field) -> f64 {
        self.read(self.state, row, field)
    }

    /// Derivative of the same with respect to a parameter; 0 of one that there is not.
    #[must_use]
    pub fn slope(&self, row_of_basis: &[f64], field: Field, parameter: usize) -> f64 {
        self.read(row(self.slopes, parameter, self.state.len()), row_of_basis, field)
    }

    fn read(&self, state: &[f64], row: &[f64], field: Field) -> f64 {
        let m = self.tuned.eigenvalues.len();
        let first = if field == Field::Displacement { 0 } else { m };
        along(self.tuned.shapes, row).enumerate().map(|(k, part)| part * at(state, first + k)).sum()
    }
}
