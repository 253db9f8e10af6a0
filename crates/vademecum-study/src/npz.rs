//! Archives of arrays as NumPy reads them (`.npz`). Entries are stored as they are and bear no time: the same
//! input gives the same bytes.

use std::io::{Cursor, Write};

use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::field::{DenseMatrix, NpyArray, NpyValues, npy_array_into, npy_into, npy_texts_into};
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Bytes beyond which an entry has sizes of 64 bits.
const LARGE: usize = 1 << 31;

/// An archive that is being written.
pub(crate) struct NpzArchive(ZipWriter<Cursor<Vec<u8>>>);

impl Default for NpzArchive {
    fn default() -> Self {
        Self(ZipWriter::new(Cursor::new(vec![])))
    }
}

impl NpzArchive {
    /// An entry of about so many bytes.
    fn put(
        &mut self,
        name: &str,
        bytes: usize,
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<(), ZipError> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .large_file(bytes > LARGE);
        self.0.start_file(format!("{name}.npy"), options)?;
        Ok(write(&mut self.0)?)
    }

    fn array(&mut self, name: &str, array: &NpyArray<'_>) -> Result<(), ZipError> {
        let bytes = 8 * array.shape.iter().product::<usize>();
        self.put(name, bytes, |out| npy_array_into(out, array))
    }

    /// A matrix, column-major.
    pub fn matrix(&mut self, name: &str, matrix: &DenseMatrix) -> Result<(), ZipError> {
        self.put(name, 8 * matrix.data.len(), |out| npy_into(out, matrix))
    }

    /// Numbers, row-major.
    pub fn rows(&mut self, name: &str, shape: &[usize], values: &[f64]) -> Result<(), ZipError> {
        self.array(name, &NpyArray { shape, values: NpyValues::Rows(values) })
    }

    /// Integers, row-major.
    pub fn integers(&mut self, name: &str, shape: &[usize], values: &[i64]) -> Result<(), ZipError> {
        self.array(name, &NpyArray { shape, values: NpyValues::Integers(values) })
    }

    /// A vector of texts.
    pub fn texts(&mut self, name: &str, texts: &[&str]) -> Result<(), ZipError> {
        self.put(name, 0, |out| npy_texts_into(out, texts))
    }

    /// A symmetric matrix as SciPy's compressed rows, which are its columns too.
    pub fn sparse(&mut self, name: &str, matrix: &SymmetricMatrix) -> Result<(), ZipError> {
        let (pattern, n) = (matrix.pattern(), matrix.n());
        let starts: Vec<i64> =
            std::iter::once(0).chain((0..n).map(|j| pattern.range(j).end as i64)).collect();
        let rows: Vec<i64> = (0..n).flat_map(|j| pattern.rows_of(j)).map(|&row| i64::from(row)).collect();
        self.rows(&format!("{name}_data"), &[rows.len()], matrix.values())?;
        self.integers(&format!("{name}_indices"), &[rows.len()], &rows)?;
        self.integers(&format!("{name}_indptr"), &[n + 1], &starts)
    }

    /// The bytes of the archive.
    pub fn finish(self) -> Result<Vec<u8>, ZipError> {
        Ok(self.0.finish()?.into_inner())
    }
}
