//! Natural modes, and why none were found.

use faer::Mat;

use crate::fem::{EngineError, FactorError};
use crate::linalg::NoConvergence;
use crate::progress::Cancelled;

/// Natural modes in ascending order.
#[derive(Clone, Debug)]
#[doc(alias("normal modes", "eigenvectors"))]
pub struct Modes {
    /// `λ = ω²`, 1/s².
    pub eigenvalues: Vec<f64>,
    /// `φ`, shape `(n, count)`, column-major, `φᵀ M φ = I`; the largest entry of each is positive.
    pub vectors: Mat<f64>,
    /// `‖K⁻¹M φ − φ/λ‖ λ` in the mass norm, one per mode: a bound on the relative error of its eigenvalue.
    /// Beyond 1e-8 the search ran out of room before all modes converged.
    pub residuals: Vec<f64>,
}

impl Modes {
    /// `√λ / 2π`, Hz.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        self.eigenvalues.iter().map(|l| l.sqrt() / std::f64::consts::TAU).collect()
    }
}

/// Why no modes were found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModesError {
    /// More modes asked for than the body has dofs, or none.
    #[error("{count} modes asked for; the body has {n} dofs")]
    Count {
        /// Modes asked for.
        count: usize,
        /// Free dofs, less six of a body without supports.
        n: usize,
    },
    /// The stiffness does not factorise.
    #[error("stiffness matrix")]
    Factor(#[from] FactorError),
    /// The lowest frequency is lost in rounding.
    #[error(
        "the first natural frequency is lost in rounding ({share:.0e} of its square): a part of the body can move freely \
         (parts that share only an edge or a node, supports in a line), is too slender for double precision, or is made of \
         regions whose stiffness or density differ by too many decades"
    )]
    LostInRounding {
        /// `ε λ_max / λ_1`, from below; infinite if the stiffness does not factorise.
        share: f64,
    },
    /// Ranks that searched together had to stop.
    #[error("the search for natural modes on several ranks")]
    Engine(#[from] EngineError),
    /// The user wants to stop.
    #[error("the search for natural modes")]
    Cancelled(#[from] Cancelled),
    /// The search for modes met numbers that double precision does not hold.
    #[error("the search for natural modes")]
    NoConvergence(#[from] NoConvergence),
    /// Fewer modes than asked for have a finite frequency: the mass is singular.
    #[error("only {found} modes have a finite frequency: the mass matrix is singular")]
    SingularMass {
        /// Modes found.
        found: usize,
    },
}
