//! The arrays of a superelement in one archive, as NumPy reads them.

use std::io::{Cursor, Write};

use vademecum_build::Matrix;
use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::field::{NpyArray, NpyValues, npy_array_into};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::body::{ReducedBody, columns_of};
use crate::error::StudyError;

/// Bytes beyond which an entry has sizes of 64 bits.
const LARGE: usize = 1 << 31;

/// An archive that is being written.
struct Archive(ZipWriter<Cursor<Vec<u8>>>);

/// The bytes of `superelement.npz`; `full` with the matrices of the full order, where there are. Entries bear
/// no time: the same input gives the same bytes.
///
/// # Errors
/// [`StudyError::Archive`].
pub fn npz(body: &ReducedBody, full: bool) -> Result<Vec<u8>, StudyError> {
    let found = &body.superelement;
    let mut archive = Archive(ZipWriter::new(Cursor::new(vec![])));
    archive.matrix("mass", &found.mass)?;
    archive.matrix("stiffness", &found.stiffness)?;
    archive.matrix("damping", &found.damping)?;
    archive.matrix("transformation", &found.transformation)?;
    if let Some(motions) = &found.rigid_motions {
        archive.matrix("rigid_motions", motions)?;
    }
    archive.rows("frequencies_hz", &[found.frequencies_hz.len()], &found.frequencies_hz)?;
    archive.rows("nodes", &[body.nodes.len(), 3], body.nodes.as_flattened())?;
    let ids: Vec<i64> = body.node_ids.iter().map(|&id| id as i64).collect();
    archive.integers("node_ids", &[ids.len()], &ids)?;
    let corners: Vec<i64> = body.triangles.iter().flatten().map(|&node| i64::from(node)).collect();
    archive.integers("triangles", &[body.triangles.len(), 3], &corners)?;
    let coordinates: Vec<i64> = (0..)
        .zip(&found.interfaces)
        .flat_map(|(place, interface)| {
            interface
                .coordinates
                .iter()
                .flat_map(move |own| [place, own.node.map_or(-1, i64::from), own.motion as i64])
        })
        .collect();
    archive.integers("coordinates", &[found.coordinates, 3], &coordinates)?;
    let frames: Vec<f64> = found
        .interfaces
        .iter()
        .flat_map(|interface| interface.origin.into_iter().chain(interface.axes.into_iter().flatten()))
        .collect();
    archive.rows("frames", &[found.interfaces.len(), 12], &frames)?;
    let nodes: Vec<i64> =
        found.interfaces.iter().flat_map(|one| &one.nodes).map(|&node| i64::from(node)).collect();
    let weights: Vec<f64> = found.interfaces.iter().flat_map(|one| &one.weights).copied().collect();
    let mut starts = vec![0];
    for interface in &found.interfaces {
        starts.push(starts[starts.len() - 1] + interface.nodes.len() as i64);
    }
    archive.integers("interface_nodes", &[nodes.len()], &nodes)?;
    archive.rows("interface_weights", &[weights.len()], &weights)?;
    archive.integers("interface_starts", &[starts.len()], &starts)?;
    if let Some(model) = body.model.as_ref().filter(|_| full) {
        let pencil = model.pencil();
        archive.sparse("full_mass", pencil.mass())?;
        archive.sparse("full_stiffness", pencil.stiffness())?;
        let dofs = model.dofs().dof_of_free();
        let dofs: Vec<i64> = dofs.iter().map(|&dof| i64::from(dof)).collect();
        archive.integers("full_dofs", &[dofs.len()], &dofs)?;
    }
    Ok(archive.0.finish()?.into_inner())
}

impl Archive {
    fn put(&mut self, name: &str, shape: &[usize], values: NpyValues<'_>) -> Result<(), StudyError> {
        let bytes = 8 * shape.iter().product::<usize>();
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .large_file(bytes > LARGE);
        self.0.start_file(format!("{name}.npy"), options)?;
        let mut buffer = vec![];
        let written = npy_array_into(&mut buffer, &NpyArray { shape, values });
        written.and_then(|()| self.0.write_all(&buffer)).map_err(zip::result::ZipError::from)?;
        Ok(())
    }

    fn matrix(&mut self, name: &str, matrix: &Matrix) -> Result<(), StudyError> {
        let columns = columns_of(matrix);
        self.put(name, &[columns.rows, columns.columns], NpyValues::Columns(&columns.data))
    }

    fn rows(&mut self, name: &str, shape: &[usize], values: &[f64]) -> Result<(), StudyError> {
        self.put(name, shape, NpyValues::Rows(values))
    }

    fn integers(&mut self, name: &str, shape: &[usize], values: &[i64]) -> Result<(), StudyError> {
        self.put(name, shape, NpyValues::Integers(values))
    }

    /// A symmetric matrix as SciPy's compressed rows, which are its columns too.
    fn sparse(&mut self, name: &str, matrix: &SymmetricMatrix) -> Result<(), StudyError> {
        let (pattern, n) = (matrix.pattern(), matrix.n());
        let starts: Vec<i64> =
            std::iter::once(0).chain((0..n).map(|j| pattern.range(j).end as i64)).collect();
        let rows: Vec<i64> = (0..n).flat_map(|j| pattern.rows_of(j)).map(|&row| i64::from(row)).collect();
        self.rows(&format!("{name}_data"), &[rows.len()], matrix.values())?;
        self.integers(&format!("{name}_indices"), &[rows.len()], &rows)?;
        self.integers(&format!("{name}_indptr"), &[n + 1], &starts)
    }
}
