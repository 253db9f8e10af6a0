//! The offline stage on many processes: natural modes and static answers by MPI, PETSc and MUMPS, or by
//! conjugate gradients where no factor fits.
//!
//! `mpirun` starts the program on every rank. The first rank builds as it does alone; where it needs a
//! matrix, a product, the factor of a stiffness, a solve or a search for modes, it says so to the others,
//! which wait for that word and nothing else. The rows of matrices lie on the ranks in the order of
//! elimination, so that a rank has rows that are coupled with each other: each assembles its own of the
//! elements at its nodes, or is dealt them where the entries come from elsewhere. The mathematics of the
//! search is that of `vademecum_build::dynamics::search_on`, the same on every rank and with every engine.
//!
//! A rank that fails names the cause on standard error and ends the job. Nothing is written then: the first
//! rank writes the file in one step, as the last of all.
//!
//! Without the feature `petsc` the crate is empty and needs nothing.

#[cfg(feature = "petsc")]
mod calls;
#[cfg(feature = "petsc")]
mod deal;
#[cfg(feature = "petsc")]
mod engine;
#[cfg(feature = "petsc")]
mod job;
#[cfg(feature = "petsc")]
mod ranks;
#[cfg(feature = "petsc")]
mod rows;
#[cfg(feature = "petsc")]
mod serve;
#[cfg(feature = "petsc")]
mod work;

#[cfg(feature = "petsc")]
pub use engine::run;
#[cfg(feature = "petsc")]
pub use job::{Options, TOLERANCE};
