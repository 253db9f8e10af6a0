//! The fused step of plain matrices, for what is proved of it without a body.

use faer::{Mat, MatRef};
use vademecum_format::scheme::{SchemeTable, StepParameters, TableError, fuse_into, fuse_work_len};

/// Spectral radius of the fused step of the given `E_i = C_i − I`, shape (r, r), one per stage.
///
/// # Errors
/// If the table or a parameter is unusable.
///
/// # Panics
/// If the eigenvalues do not converge.
pub fn fused_radius(
    table: &SchemeTable,
    parameters: &StepParameters,
    states: &[Mat<f64>],
) -> Result<f64, TableError> {
    let r = states.first().map_or(0, Mat::nrows);
    let packed: Vec<f64> = states.iter().flat_map(|s| (0..r * r).map(|k| s[(k / r, k % r)])).collect();
    let mut increment = vec![0.0; 9 * r * r];
    let mut loads = vec![0.0; states.len() * 3 * r * r];
    let mut work = vec![0.0; fuse_work_len(r)];
    fuse_into(table, parameters, r, &packed, &mut increment, &mut loads, &mut work)?;
    let increment = MatRef::from_column_major_slice(&increment, 3 * r, 3 * r);
    let eigenvalues = increment.eigenvalues().expect("a finite matrix has eigenvalues");
    Ok(eigenvalues.iter().map(|l| (1.0 + l.re).hypot(l.im)).fold(0.0, f64::max))
}
