//! Programs that give the same names different meanings.

/// Program whose meaning the names of a deck have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// C3D8 takes the mean dilatation; linear elements have a lumped mass.
    Abaqus,
    /// C3D8 is fully integrated; every mass is consistent.
    CalculiX,
}
