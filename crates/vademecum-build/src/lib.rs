//! The offline stage: mesh → model → snapshots → basis → vademecum → bytes.

pub mod mesh;
pub mod separated;
