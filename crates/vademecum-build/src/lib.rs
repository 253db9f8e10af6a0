//! The offline stage: mesh → model → snapshots → basis → vademecum → bytes.

pub mod field;
pub mod mesh;
