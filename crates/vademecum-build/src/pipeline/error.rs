//! Why a build ended without a file.

use vademecum_format::FormatError;

use crate::basis::BasisError;
use crate::certificate::CertificateError;
use crate::dynamics::large::LargeError;
use crate::dynamics::{FullOrderError, ModesError, TooMuchWork};
use crate::fem::{ElementError, FactorError, GreenError};
use crate::large::LearnError;
use crate::limits::{TooMuchMemory, memory_in_words};
use crate::mesh_error::MeshErrorFailure;
use crate::parametric::ParametricError;
use crate::prepared::{PrepareError, TimeStepError};
use crate::residual::ResidualError;
use crate::response::ResponseError;

/// Why a build ended without a file, by stage.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The problem cannot be computed with.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    /// More memory than there is.
    #[error(transparent)]
    Memory(#[from] TooMuchMemory),
    /// More full-order work than was asked for by name.
    #[error(transparent)]
    Work(#[from] TooMuchWork),
    /// A time step that does not fit the body.
    #[error(transparent)]
    TimeStep(#[from] TimeStepError),
    /// No first natural mode.
    #[error("natural modes")]
    Modes(#[from] ModesError),
    /// The full-order march cannot start.
    #[error("the full-order march cannot start")]
    FullOrder(#[from] FullOrderError),
    /// No basis.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// No residual flexibility.
    #[error("the residual flexibility")]
    Residual(#[from] ResidualError),
    /// No factor of the stiffness for whole fields.
    #[error("the factor of the stiffness, for whole fields")]
    Factor(#[from] FactorError),
    /// The stress of an element cannot be taken.
    #[error("the stress of an element")]
    Stress(#[from] ElementError),
    /// No reactions.
    #[error("the reactions of the supports")]
    Reactions(#[source] FactorError),
    /// A stage has no response.
    #[error(transparent)]
    Response(#[from] ResponseError),
    /// The separated solution over the parameters failed.
    #[error("the separated solution over the parameters")]
    Parametric(#[from] ParametricError),
    /// The parametric model that was built cannot be set to values of its parameters.
    #[error("the parametric reduced-order model")]
    Model(#[from] vademecum_eval::ParametricError),
    /// The problem asks for the chapter's representation, which another crate builds.
    #[error("`representation = \"chapter\"` is built by the crate `vademecum-chapter`")]
    OtherCrate,
    /// The road of another crate failed.
    #[error("the chapter's representation")]
    Other(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// The certificate could not be taken.
    #[error(transparent)]
    Certificate(#[from] CertificateError),
    /// Damping ratios of modes that are not there.
    #[error(
        "{path}: `damping.modal` is a list of {given}; the basis has {modes} modes: expected at most as many \
         ratios, the last of which holds for all further modes, or more `basis.modes`"
    )]
    RatiosBeyond {
        /// The problem file and line.
        path: String,
        /// Ratios.
        given: usize,
        /// Modes of the basis.
        modes: usize,
    },
    /// More independent dashpots than vectors of a parametric basis.
    #[error(
        "{path}: groups of dashpots have {rows} independent rows over a basis of {modes} vectors; expected at most as \
         many: more `basis.modes`, or dashpots without a name of their own"
    )]
    DashpotsBeyond {
        /// The key.
        path: String,
        /// Rows of the dashpots.
        rows: usize,
        /// Vectors of the basis.
        modes: usize,
    },
    /// Modes of one frequency with different damping ratios.
    #[error(
        "{path}: `damping.modal` gives the modes {mode} and {} the ratios {first} and {second}, but both have \
         {hertz:.6} Hz, so that any two motions of their plane are modes; expected the same ratio",
        mode + 1
    )]
    RatiosOfOneFrequency {
        /// The problem file and line.
        path: String,
        /// The first of them, counted from 1.
        mode: usize,
        /// Their frequency \[Hz\].
        hertz: f64,
        /// Ratio of the first.
        first: f64,
        /// Ratio of the second.
        second: f64,
    },
    /// More pairs of near loadable nodes than a file should hold.
    #[error(
        "{path}: `output.contact_patch` is {distance}: pairs of loadable nodes that are so near each other take more \
         than {}; expected {}",
        memory_in_words(*.limit), smaller_patch(*.largest)
    )]
    PatchSize {
        /// The problem file and line.
        path: String,
        /// The distance asked for \[m\].
        distance: f64,
        /// Bytes that pairs may take.
        limit: u64,
        /// The largest distance whose pairs fit \[m\]; none if those of one facet do not.
        largest: Option<f64>,
    },
    /// The discretisation error could not be estimated.
    #[error("the estimate of the discretisation error")]
    MeshError(#[from] MeshErrorFailure),
    /// No strain map.
    #[error(transparent)]
    Learn(#[from] LearnError),
    /// No strain field.
    #[error(transparent)]
    Strain(#[from] GreenError),
    /// No motion at full order to compare with.
    #[error("a push at full order, beside which large displacements are certified")]
    Large(#[from] LargeError),
    /// The file cannot hold what was built.
    #[error("the file cannot hold what was built")]
    Format(#[from] FormatError),
}

/// The way out of a patch that is too large; the distance is rounded down to three digits.
fn smaller_patch(largest: Option<f64>) -> String {
    let Some(largest) = largest.filter(|largest| *largest > 0.0) else {
        return "no `contact_patch`, or fewer loadable nodes by `load.surface`".into();
    };
    let unit = 10.0_f64.powi(largest.log10().floor() as i32 - 2);
    let rounded = (largest / unit).floor() * unit;
    format!("at most {rounded:.2e} m, or fewer loadable nodes by `load.surface`")
}
