//! The identity of a file in saved states.

use vademecum_format::{File, SectionKind, checksum};

/// Checksums of the mesh and its counts, and of the reduced stiffness, which defines the coordinates: the
/// same for a file and for all that are made of it without another build.
pub(crate) fn identity(file: &File<'_>) -> [u8; 8] {
    let metadata = file.metadata();
    let mut mesh = metadata.mesh_hash;
    for (at, n) in [metadata.n_modes, metadata.n_patterns, metadata.n_regions].into_iter().enumerate() {
        let place = mesh.iter_mut().skip(4 * at);
        place.zip(n.to_le_bytes()).for_each(|(to, byte)| *to ^= byte);
    }
    let kinds = [SectionKind::Eigenvalues, SectionKind::ReducedStiffness, SectionKind::StrainLinear];
    let sections = kinds.into_iter().filter_map(|kind| file.section(kind)?.raw().ok());
    let [b, c, d, e] = checksum(&mesh).to_le_bytes();
    let [p, q, r, s] = sections.fold(0, |sum, bytes| sum ^ checksum(bytes)).to_le_bytes();
    [b, c, d, e, p, q, r, s]
}
