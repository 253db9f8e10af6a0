//! Sections of the factor of the stiffness: whole fields with the whole static answer.

use faer::Mat;
use vademecum_format::SectionKind as S;

use super::draft::Draft;
use super::order::NodeOrder;
use crate::fem::{FactorError, Solve, Symbolic};
use crate::input::Precision;
use crate::prepared::Body;

/// Sections 42 to 46 of a body: the factor of its stiffness, and its answers to the load patterns.
///
/// One factorisation, and a solve for each pattern. Memory: the factor twice.
///
/// # Errors
/// [`FactorError`].
pub(crate) fn factor_sections(
    body: &Body,
    symbolic: &Symbolic,
    order: &NodeOrder,
    precision: Precision,
) -> Result<Vec<Draft>, FactorError> {
    let symbolic = &symbolic.here();
    let factor = symbolic.factor_of(body.model.pencil().stiffness())?;
    let columns = factor.columns();
    let n = columns.order.len();
    let dofs = body.model.dofs().dof_of_free();
    let place = |&row: &u32| {
        let dof = dofs[row as usize];
        3 * order.file_node[dof as usize / 3] + dof % 3
    };
    let mut answers = Mat::zeros(n, body.patterns.len());
    for (j, (_, force)) in body.patterns.iter().enumerate() {
        answers.col_as_slice_mut(j).copy_from_slice(force);
    }
    Solve::new(symbolic, body.patterns.len(), true).solve_in_place(&factor, answers.as_mut());
    drop(factor);
    let (groups, rows) = (columns.groups.len(), columns.rows.len());
    let mut drafts = vec![
        Draft::u32s(S::FactorOrder, [n, 1, 1], columns.order.iter().map(place)),
        Draft::u32s(S::FactorGroups, [groups, 2, 1], columns.groups.into_iter().flatten()),
        Draft::u32s(S::FactorRows, [rows, 1, 1], columns.rows),
        Draft::fitting(S::FactorValues, precision, [columns.values.len(), 1, 1], &columns.values),
    ];
    if !body.patterns.is_empty() {
        let columns_of_patterns = (0..body.patterns.len()).map(|j| answers.col_as_slice(j));
        let in_order = |answer: &[f64]| columns.order.iter().map(|&row| answer[row as usize]).collect();
        let values: Vec<f64> = columns_of_patterns.flat_map(|a| -> Vec<f64> { in_order(a) }).collect();
        drafts.push(Draft::fitting(S::PatternAnswer, precision, [body.patterns.len(), n, 1], &values));
    }
    Ok(drafts)
}
