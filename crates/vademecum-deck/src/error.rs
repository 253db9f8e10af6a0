//! Reasons why a deck has no answer.

use std::fmt;
use std::path::PathBuf;

use vademecum_build::dynamics::ModesError;
use vademecum_build::fem::{Contradiction, FactorError, LoadError, ModelError};
use vademecum_build::mesh::MeshError;

/// A card that cannot be used: position, what was found, what was expected, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CardFault {
    /// The file.
    pub file: PathBuf,
    /// The line, counted from 1.
    pub line: usize,
    /// The card as the deck spells it.
    pub card: String,
    /// The text found, shortened.
    pub found: String,
    /// The expected content.
    pub expected: String,
    /// The remedy.
    pub remedy: String,
}

impl fmt::Display for CardFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, card, found, expected, remedy } = self;
        write!(f, "{}, line {line}, in {card}: found {found}, expected {expected}; {remedy}", file.display())
    }
}

/// Why a deck has no answer.
#[derive(Debug, thiserror::Error)]
pub enum DeckError {
    /// The mesh of the deck.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A card that cannot be used.
    #[error("{0}")]
    Card(Box<CardFault>),
    /// The deck has elements that are no solids.
    #[error("{0}")]
    Structural(Box<CardFault>),
    /// A region without a material.
    #[error("region `{region}` has no material: its elements are in no section with a material")]
    NoMaterial {
        /// Name of the region.
        region: String,
    },
    /// A material without a modulus or a density that the answer needs.
    #[error("material `{material}` has no {quantity}; expected {card} in the deck")]
    Incomplete {
        /// Name of the material.
        material: String,
        /// Missing quantity.
        quantity: &'static str,
        /// Card that gives it.
        card: &'static str,
    },
    /// Axes of a material that turn about a line, in a problem file.
    #[error(
        "region `{region}`: the axes of its material turn about a line, and a problem file has one stiffness for a \
         region; `static` and `modes` answer the deck as it is; expected an orientation of type RECTANGULAR for each \
         part of the body"
    )]
    TurningAxes {
        /// Name of the region.
        region: String,
    },
    /// Rotations or moments along axes of a node that are not those of space.
    #[error(
        "node {node}: a rotation that is held, or a moment, along own axes of the node; expected it along the axes \
         of space"
    )]
    OwnRotations {
        /// Number of the node.
        node: u64,
    },
    /// Constraints that cannot hold at once.
    #[error(transparent)]
    Contradiction(#[from] Contradiction),
    /// A load on a face that is none.
    #[error("a pressure or a tie")]
    Load(#[from] LoadError),
    /// The matrices.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Something can move freely.
    #[error(
        "the model is not held: a part of it can move without a force (its elements form {parts} bodies; one node of \
         each: {nodes}{contact}); expected supports, and ties or couplings between bodies"
    )]
    NotHeld {
        /// Bodies that share no node.
        parts: usize,
        /// A node of each of the first ones.
        nodes: String,
        /// Contact of the deck between them, in words.
        contact: String,
    },
    /// A static step that the body does not stand.
    #[error(
        "the body buckles under {factor:.3} of the loads of the static step {step}, about which it is to move; expected \
         a smaller load, or more supports"
    )]
    Buckled {
        /// Name of the step.
        step: String,
        /// Share of its loads.
        factor: f64,
    },
    /// The stiffness does not factorise.
    #[error("the stiffness of the deck does not factorise")]
    Factor(#[from] FactorError),
    /// The natural modes.
    #[error("natural modes of the deck")]
    Modes(#[from] ModesError),
    /// Nothing tells the units.
    #[error(
        "{}: the units of the deck are unknown (its modulus and density fit no usual system); expected `--units`, such \
         as `--units mm-t-N`, or `--units none` to keep its numbers",
        .file.display()
    )]
    UnknownUnits {
        /// The file.
        file: PathBuf,
    },
    /// The deck has no static step.
    #[error("{}: the deck has no static step ({found}); `vademecum modes` prints its natural frequencies", .file.display())]
    NoStaticStep {
        /// The file.
        file: PathBuf,
        /// Steps that it has.
        found: String,
    },
}
