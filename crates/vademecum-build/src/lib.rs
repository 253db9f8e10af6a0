//! The offline stage: mesh → model → snapshots → basis → vademecum → bytes.

pub mod dynamics;
pub mod fem;
pub mod mesh;
pub mod pod;
