//! The bytes of a mesh file.

use std::path::Path;

use super::error::MeshError;
use crate::store::read_regular;

/// The whole file.
pub(crate) fn load(path: &Path) -> Result<Vec<u8>, MeshError> {
    read_regular(path).map_err(|source| MeshError::Io { file: path.to_path_buf(), source })
}
