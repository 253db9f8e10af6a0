//! Symmetric sparse matrices as Matrix Market files, which SciPy, MATLAB, Julia and Eigen read.

use std::io::Write;
use std::path::Path;

use super::{FieldError, write_whole};
use crate::fem::SymmetricMatrix;

/// Writes a matrix as `coordinate real symmetric`: the lower triangle, column by column, indices from 1, every stored place
/// (zeros included) with as many digits as give the same number back.
///
/// # Errors
/// [`FieldError::Io`].
pub fn write_matrix_market(path: &Path, matrix: &SymmetricMatrix) -> Result<(), FieldError> {
    let (n, pattern) = (matrix.n(), matrix.pattern());
    let lower = |j: usize| {
        let entries = pattern.rows_of(j).iter().zip(&matrix.values()[pattern.range(j)]);
        entries.filter(move |(i, _)| **i as usize >= j)
    };
    let count: usize = (0..n).map(|j| lower(j).count()).sum();
    write_whole(path, |out| {
        writeln!(out, "%%MatrixMarket matrix coordinate real symmetric\n{n} {n} {count}")?;
        for j in 0..n {
            for (i, value) in lower(j) {
                writeln!(out, "{} {} {value:e}", i + 1, j + 1)?;
            }
        }
        Ok(())
    })
}
