//! The block vademecum stepped stage by stage: the same responses as the fused step, not fused.
//!
//! With the increments `x_i = ζ_i − ζ` of a stage (format's `fuse`),
//!
//! ```text
//! x_i = Σ_j a_j y_j + Σ_{l<i} a_l x_l + E_i (Σ_j b_j y_j + Σ_{l<i} b_l x_l) + (Δt²/m̃) H_iᵀF_i
//! ```
//!
//! so a step costs one product with an r × r matrix per stage, `2 r²` multiply-adds for Bathe's scheme,
//! against `9 r²` of the fused map. What fusing saves is the passes over short vectors between the products;
//! what it costs are products.

use faer::MatRef;
use vademecum_format::scheme::{SchemeTable, StageCoefficients, StepParameters, TableError};

use super::staged::{Frame, ReducedSolver, add_product, add_weighted, axpy};
use vademecum_build::basis::Basis;
use vademecum_build::dynamics::INSTANTS;
use vademecum_build::linalg::project;
use vademecum_build::prepared::Prepared;
use vademecum_build::response::StageResponse;
use vademecum_study::StudyError;
use vademecum_study::parts::{Study, Timed};

/// A reduced model that applies the responses of its stages one after the other.
pub struct TwoStage {
    frame: Frame,
    table: SchemeTable,
    stages: Vec<StageCoefficients>,
    responses: Vec<StageResponse>,
}

impl TwoStage {
    /// The solver of a study in a basis, with its scheme and step.
    ///
    /// # Errors
    /// [`StudyError`]: a parameter the scheme cannot take.
    pub fn of_study(
        study: &Study,
        basis: &Basis,
        responses: &[StageResponse],
    ) -> Result<Timed<Self>, StudyError> {
        let Prepared { scheme, step, .. } = study.prepared();
        Timed::of(|| Ok(Self::new(basis.vectors.as_ref(), responses, scheme, step)?))
    }

    /// Joins a basis and its stage responses, one per stage of the scheme.
    ///
    /// # Errors
    /// If a parameter is unusable for the scheme.
    pub fn new(
        basis: MatRef<'_, f64>,
        responses: &[StageResponse],
        table: &SchemeTable,
        parameters: &StepParameters,
    ) -> Result<Self, TableError> {
        let stage = |i| StageCoefficients::new(table, parameters, i);
        Ok(Self {
            frame: Frame::staged(basis, table, parameters.time_step),
            table: *table,
            stages: (0..table.active().len()).map(stage).collect::<Result<_, _>>()?,
            responses: responses.to_vec(),
        })
    }
}

impl ReducedSolver for TwoStage {
    fn frame(&self) -> &Frame {
        &self.frame
    }

    fn responses(&self, force: &[f64]) -> [Vec<f64>; INSTANTS] {
        let base = project(self.frame.basis.as_ref(), force);
        let rows: Vec<Vec<f64>> =
            self.responses.iter().map(|s| project(s.increment.as_ref(), force)).collect();
        let stages = || self.table.active().iter().zip(&self.stages).zip(&rows);
        let at = |j: usize| {
            let mut out = Vec::with_capacity(self.load_len());
            for ((stage, known), increment) in stages() {
                let weight = known.load * stage.load[j];
                out.extend(base.iter().zip(increment).map(|(b, i)| weight * (b + i)));
            }
            out
        };
        std::array::from_fn(at)
    }

    fn step(&self, state: &mut [f64], load: &[f64], work: &mut [f64]) {
        let r = self.frame.n_modes();
        let (x, combined) = work[..2 * r].split_at_mut(r);
        for (index, (stage, response)) in self.stages.iter().zip(&self.responses).enumerate() {
            let known = 3 + index;
            x.copy_from_slice(&load[index * r..][..r]);
            combined.fill(0.0);
            add_weighted(&stage.identity[..known], state, x);
            add_weighted(&stage.increment[..known], state, combined);
            add_product(&response.state, combined, x);
            state[known * r..][..r].copy_from_slice(x);
        }
        // The weights of u are 1, 0, 0 once the stages are increments.
        let known = 3 + self.stages.len();
        work.fill(0.0);
        for (row, new) in self.table.finish.iter().zip(work.chunks_exact_mut(r)) {
            add_weighted(&row[1..known], &state[r..], new);
        }
        axpy(1.0, &work[..r], &mut state[..r]);
        state[r..3 * r].copy_from_slice(&work[r..]);
    }
}
