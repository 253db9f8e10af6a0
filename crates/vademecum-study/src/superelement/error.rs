//! Why there is no superelement, or none for a program.

use vademecum_eval::PartFault;

/// Why a file gives no superelement.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PortError {
    /// A part that cannot be read.
    #[error(transparent)]
    Fault(#[from] PartFault),
    /// A file without ports.
    #[error("the file has no ports: build it with a `[[port]]` at each interface, or give its problem file")]
    NoPorts,
    /// A name that is none of a port.
    #[error("--interface {name}: the file has no port of this name; there are {known}")]
    Unknown {
        /// The name.
        name: String,
        /// Names of its ports.
        known: String,
    },
    /// An interface that is no port.
    #[error(
        "--interface {name}: a file has no interfaces but its ports; expected the name of one, or its problem file"
    )]
    NotAPort {
        /// The interface.
        name: String,
    },
    /// A method that a file has no modes for.
    #[error(
        "--method {method}: a file has natural modes and residual flexibility, and no modes with fixed interfaces; expected \
         rubin or macneal, or the problem file"
    )]
    Method {
        /// The method.
        method: &'static str,
    },
    /// A file without the inertia of the residual flexibility.
    #[error(
        "--method rubin: the file does not hold the inertia of its residual flexibility; expected macneal"
    )]
    NoInertia,
    /// More modes than the file has.
    #[error("--modes {asked}: the file has {found} modes; expected 1 to {found}")]
    Modes {
        /// Modes asked for.
        asked: usize,
        /// Modes of the file.
        found: usize,
    },
    /// A body that Chrono's matrices of other programs do not take.
    #[error(
        "--format chrono: found {found}; expected a free body of elements alone, with interfaces of kind rigid, patch or \
         nodes, along the axes of space"
    )]
    NotForChrono {
        /// Body or interface.
        found: String,
    },
    /// A flexibility that is singular.
    #[error(
        "the residual flexibility of the file at the {coordinates} coordinates of its ports is singular: name fewer ports"
    )]
    Singular {
        /// Coordinates of the ports.
        coordinates: usize,
    },
}
