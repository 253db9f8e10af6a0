//! Costs of a bound scene: bytes of the file that each move reads, and multiply-adds.
//! Computed from the sizes of things; nothing is counted while stepping.
//!
//! A test poisons every number of a file that is not in these counts and finds the same bits
//! (`tests/tests/evaluator/needless.rs`).

use crate::base::options::Structure;
use crate::base::scalar::Scalar;
use crate::scene::scene::Scene;
use vademecum_format::Numbers;

/// Costs of a scene's moves. Bytes are those of the file, apart from [`Cost::step_bytes`]. Sections that are
/// not there count nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Terms of the separated solution that binding adds up; 0 for the diagonal structure.
    pub terms: usize,
    /// Read by binding and by every change of parameters.
    pub bind_bytes: usize,
    /// Multiply-adds of a step. A step reads nothing of the file.
    pub step_operations: usize,
    /// Memory of the scene, the state and the loads that a step reads or writes; a body at rest touches none.
    pub step_bytes: usize,
    /// Rows that a contact reads when it is added: nine dofs, once and once a term in use.
    pub contact_rows: usize,
    /// Read when a contact is added; a held contact costs nothing per step.
    pub contact_bytes: usize,
    /// Read when a load pattern is added.
    pub pattern_bytes: usize,
    /// Read by one probe.
    pub probe_bytes: usize,
    /// Read by one node.
    pub node_bytes: usize,
    /// Read by the surface.
    pub surface_bytes: usize,
    /// Read by the whole body.
    pub body_bytes: usize,
}

impl<T: Scalar> Scene<'_, T> {
    /// Costs of this scene, as it is bound now.
    #[must_use]
    pub fn cost(&self) -> Cost {
        let (shape, sections, metadata) = (&self.shape, &self.sections, &self.metadata);
        let r = shape.r;
        let row = |numbers: Option<Numbers<'_>>| r * numbers.map_or(0, width);
        let separated = &sections.separated;
        let (bind_numbers, step_operations) = match shape.structure() {
            Structure::Diagonal => (r, 9 * r),
            Structure::Strain => {
                let n = shape.strain.padded();
                let rows = shape.strain.rows * (shape.strain.row_len() + 3 * n + n * (n + 1) / 2);
                let of_file = sections.strain.linear.len() + sections.strain.tail.len();
                (of_file, self.strain.substeps * (rows + n * n * n / 6 + n * n + 4 * r))
            }
            Structure::Exact if shape.is_coupled() => {
                (r * (1 + usize::from(sections.damping_ratios.is_some()) + shape.damping_rows), 4 * r * r)
            }
            Structure::Exact => (r * (1 + usize::from(sections.damping_ratios.is_some())), 4 * r),
            Structure::Block => {
                let factors = shape.n_terms * separated.points.len();
                (shape.n_terms * r * r + separated.points.len() + factors, 9 * r * r)
            }
        };
        // A term is read once if some stage has a weight for it.
        let used =
            |t: usize| self.weights.iter().skip(t).step_by(shape.n_terms.max(1)).any(|&w| w != T::ZERO);
        let separated_terms = if shape.is_block() { shape.n_terms } else { 0 };
        let in_use = (0..separated_terms).filter(|&t| used(t)).count();
        let (surface, interior) = (row(sections.rows.surface), row(sections.rows.interior));
        let (n_surface, n_nodes) = (metadata.n_surface_nodes as usize, metadata.n_nodes as usize);
        let pattern_row = if separated_terms > 0 { row(sections.pattern_block) } else { 0 };
        Cost {
            terms: in_use,
            bind_bytes: 8 * (bind_numbers - (separated_terms - in_use) * r * r)
                + sections.strain.quadratic.len() * width(sections.strain.quadratic),
            step_operations,
            step_bytes: size_of::<T>() * (shape.map_len() + 3 * shape.padded()),
            contact_rows: 9 * (1 + in_use),
            contact_bytes: 9 * (surface + in_use * row(sections.block_load)),
            pattern_bytes: row(sections.pattern_basis) + in_use * pattern_row,
            probe_bytes: row(sections.rows.probes),
            node_bytes: 3 * surface,
            surface_bytes: 3 * n_surface * surface,
            body_bytes: 3 * n_surface * surface + 3 * (n_nodes - n_surface.min(n_nodes)) * interior,
        }
    }
}

/// Bytes of a number; of a quantised one without its scale, which it shares with 127 others.
const fn width(numbers: Numbers<'_>) -> usize {
    match numbers {
        Numbers::I16(_) => 2,
        Numbers::F32(_) => 4,
        Numbers::F64(_) => 8,
    }
}
