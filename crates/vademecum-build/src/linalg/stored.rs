//! faer's matrices under serde: rows, columns, numbers column by column.
//! `#[serde(with = "crate::linalg::stored")]`.

use faer::{Mat, MatRef};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

#[derive(Serialize, Deserialize)]
struct Stored {
    rows: usize,
    columns: usize,
    numbers: Vec<f64>,
}

impl Stored {
    fn new(matrix: MatRef<'_, f64>) -> Self {
        let numbers = matrix.col_iter().flat_map(|column| column.iter().copied()).collect();
        Self { rows: matrix.nrows(), columns: matrix.ncols(), numbers }
    }

    fn matrix(self) -> Option<Mat<f64>> {
        let whole = self.rows.checked_mul(self.columns) == Some(self.numbers.len());
        whole.then(|| Mat::from_fn(self.rows, self.columns, |i, j| self.numbers[i + j * self.rows]))
    }
}

const TORN: &str = "a matrix has another number of entries than its shape";

/// Writes a matrix.
pub(crate) fn serialize<S: Serializer>(matrix: &Mat<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    Stored::new(matrix.as_ref()).serialize(serializer)
}

/// Reads a matrix.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Mat<f64>, D::Error> {
    Stored::deserialize(deserializer)?.matrix().ok_or_else(|| D::Error::custom(TORN))
}

/// The same for a list of matrices.
pub(crate) mod list {
    use super::*;

    /// Writes matrices.
    pub(crate) fn serialize<S: Serializer>(matrices: &[Mat<f64>], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(matrices.iter().map(|matrix| Stored::new(matrix.as_ref())))
    }

    /// Reads matrices.
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Mat<f64>>, D::Error> {
        let stored = Vec::<Stored>::deserialize(deserializer)?;
        stored.into_iter().map(|s| s.matrix().ok_or_else(|| D::Error::custom(TORN))).collect()
    }
}
