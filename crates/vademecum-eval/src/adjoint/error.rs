//! Errors of adjoint marches.

use crate::base::error::{BindError, LoadError, OutputError, StepError};
use crate::base::lend::Short;
use crate::base::options::Structure;
#[cfg(feature = "parametric")]
use crate::parametric::error::ParametricError;
use thiserror::Error;

/// Why an adjoint march is refused.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AdjointError {
    /// A scene that does not take exact steps.
    #[error(
        "gradients are those of exact steps of modes, and this scene has the {} structure: {}",
        words(*found),
        remedy(*found)
    )]
    Structure {
        /// Its structure.
        found: Structure,
    },
    /// A body whose frame moves freely.
    #[error(
        "the body flies, and its rigid motion has no adjoint: bind it with `flight: false` for gradients of \
         its elastic motion, or build it with supports"
    )]
    Flies,
    /// An adjoint march that belongs to other parameters of the scene.
    #[error(
        "the parameters of the scene have changed since the adjoint march was begun, or the cotangents made: \
             begin others"
    )]
    Stale,
    /// An adjoint march, or cotangents, of another scene.
    #[error("this adjoint march, or these cotangents, belong to a scene of another shape")]
    Mismatch,
    /// More nodes with outputs than there is room for.
    #[error(
        "outputs at more than {nodes} nodes of the load surface: bind the scene with more \
         `SceneOptions::contacts` or `SceneOptions::filtered_nodes`, or without the residual flexibility"
    )]
    TooManyNodes {
        /// Room for these.
        nodes: usize,
    },
    /// A gradient, or a cotangent, that is not finite or too large for the precision.
    #[error("a cotangent or a gradient is not finite, or is too large for the precision")]
    NotFinite,
    /// Numbers for the wrong count of weights or coordinates.
    #[error("{found} numbers, {needed} are needed")]
    Length {
        /// Numbers given.
        found: usize,
        /// Numbers needed.
        needed: usize,
    },
    /// Modes that dashpots couple, which have no gradients with respect to parameters.
    #[error(
        "dashpots couple the modes of this scene: gradients with respect to loads and the start are there, \
         with respect to parameters they are not"
    )]
    Coupled,
    /// A gradient of a march that was not taken, or was refused.
    #[error("there is no march to go back over: take one first")]
    NoMarch,
    /// No load of this number in a march that is kept.
    #[error("load {index} of {count}")]
    NoLoad {
        /// The number asked for.
        index: usize,
        /// Loads of the march.
        count: usize,
    },
    /// No instance of this number in a batch.
    #[error("the batch has no instance of this number")]
    NoInstance,
    /// An output that the scene does not have.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A load that the scene does not take.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// Memory that is too short.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// A parametric model that is refused.
    #[cfg(feature = "parametric")]
    #[error(transparent)]
    Parametric(#[from] ParametricError),
}

impl From<Short> for AdjointError {
    fn from(short: Short) -> Self {
        Self::Bind(short.into())
    }
}

impl From<StepError> for AdjointError {
    fn from(error: StepError) -> Self {
        match error {
            StepError::NotFinite => Self::NotFinite,
            StepError::NoInstance => Self::NoInstance,
            _ => Self::Mismatch,
        }
    }
}

const fn words(structure: Structure) -> &'static str {
    match structure {
        Structure::Diagonal => "diagonal",
        Structure::Block => "block",
        Structure::Exact => "exact",
        Structure::Strain => "strain",
    }
}

const fn remedy(structure: Structure) -> &'static str {
    match structure {
        Structure::Diagonal | Structure::Exact => "bind the file with `StructureChoice::Exact`",
        Structure::Block => {
            "a file with a separated solution has no adjoint; build it without `representation = \"separated\"`"
        }
        Structure::Strain => "large displacements have no adjoint; build the file for small displacements",
    }
}
