//! Files of parts.

use vademecum_build::store::read_regular;
use vademecum_format::File;
use vademecum_rewrite::{check_limited, default_limit, unpack};

use crate::error::AssemblyError;
use crate::file::AssemblyFile;

/// The bytes of the file of part `i`, checked, unpacked, and of the mesh that the assembly file says.
///
/// # Errors
/// [`AssemblyError`].
pub(crate) fn read_part(file: &AssemblyFile, i: usize) -> Result<Vec<u8>, AssemblyError> {
    let entry = &file.parts[i];
    let (part, path) = (entry.name.clone(), file.resolve(entry));
    let bytes = match read_regular(&path) {
        Ok(bytes) => bytes,
        Err(source) => return Err(AssemblyError::Unreadable { part, path, source }),
    };
    let limit = default_limit(bytes.len());
    let unpacked = check_limited(&bytes, limit).and_then(|_| unpack(&bytes, limit));
    let bytes = unpacked.map_err(|source| AssemblyError::Part { part, path, source })?;
    let found = hex(&File::parse(&bytes)?.metadata().mesh_hash);
    if let Some(expected) = entry.hash.as_ref().filter(|expected| **expected != found) {
        let words =
            format!("`{found}`, the hash of the mesh of this file: the part was built anew on another mesh");
        return Err(file
            .refuse(&format!("part[{}].hash", entry.entry), format!("`{expected}`"), words)
            .into());
    }
    Ok(bytes)
}

/// Bytes in hexadecimal.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
