//! Files of parts.

use vademecum_build::store::read_regular;
use vademecum_build::suggest::did_you_mean;
use vademecum_eval::Parametric;
use vademecum_format::{File, SectionKind};
use vademecum_rewrite::{check_limited, default_limit, unpack};

use crate::error::AssemblyError;
use crate::file::AssemblyFile;

/// The bytes of the file of part `i`, checked, unpacked, and of the mesh that the assembly file says. A
/// parametric model is set to the values of its parameters: in a world with the modes that are stepped unless
/// others are asked for, and with all of them where parts are joined.
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
    let opened = File::parse(&bytes)?;
    let found = hex(&opened.metadata().mesh_hash);
    if let Some(expected) = entry.hash.as_ref().filter(|expected| **expected != found) {
        let words =
            format!("`{found}`, the hash of the mesh of this file: the part was built anew on another mesh");
        return Err(file
            .refuse(&format!("part[{}].hash", entry.entry), format!("`{expected}`"), words)
            .into());
    }
    Ok(at_values(file, i, &opened)?.unwrap_or(bytes))
}

/// A parametric model at the values that its part says; `None` of any other file.
fn at_values(file: &AssemblyFile, i: usize, opened: &File<'_>) -> Result<Option<Vec<u8>>, AssemblyError> {
    let entry = &file.parts[i];
    let key = format!("part[{}].parameters", entry.entry);
    let of_part = |fault| AssemblyError::Parameters { part: entry.name.clone(), fault };
    if opened.section(SectionKind::LiveParameters).is_none() {
        let Some(name) = entry.parameters.keys().next() else { return Ok(None) };
        let expected = "none, or a file with live regions (a parametric model)";
        return Err(file.refuse(&key, format!("`{name}`"), expected).into());
    }
    let model = Parametric::new(opened).map_err(of_part)?;
    let mut values = vec![0.0; model.n_parameters()];
    model.nominal_into(&mut values);
    for (name, &value) in &entry.parameters {
        let Some(index) = model.find(name) else {
            let known: Vec<_> = model.parameters().map(|parameter| format!("`{}`", parameter.name)).collect();
            let nearest = did_you_mean(name, model.parameters().map(|parameter| parameter.name));
            return Err(file.refuse(&key, format!("`{name}`"), known.join(", ") + &nearest).into());
        };
        if let Err(fault) = model.set(&mut values, &[(index, value)]) {
            return Err(file.refuse(&key, format!("`{name}`"), fault.to_string()).into());
        }
    }
    let modes = if file.world.is_some() { model.usual_modes() } else { model.n_basis() };
    model.body_at(&values, modes).map(Some).map_err(of_part)
}

/// Bytes in hexadecimal.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
