//! Refusals of a world.

use crate::base::error::{LoadError, StepError};
use crate::base::lend::Short;
use thiserror::Error;

/// Why a world could not be made or stepped.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A member that a world cannot have.
    #[error("member {member}: {reason}")]
    Member {
        /// Its number.
        member: usize,
        /// The reason.
        reason: &'static str,
    },
    /// A pair that cannot touch.
    #[error(
        "pair {pair}: two different members of this world, one of them a body of a file, with a friction of 0 or \
             more and a restitution from 0 to 1 are expected"
    )]
    Pair {
        /// Its number.
        pair: usize,
    },
    /// A joint whose anchors do not fit it.
    #[error(
        "joint {joint}: two different members of this world with an anchor that each has are expected: a place \
             of a body for a ball joint or a cable, a port of a body that is a frame, or a point of a rigid body"
    )]
    Joint {
        /// Its number.
        joint: usize,
    },
    /// A joint whose rows follow from those of others.
    #[error("joint {joint} holds what other joints hold already, or nothing that can move")]
    Redundant {
        /// Its number.
        joint: usize,
    },
    /// An option that is not a number, or negative.
    #[error("an option of the world is not finite or negative")]
    Option,
    /// Members other than those the world was made for.
    #[error("the members are not those the world was made for")]
    Mismatch,
    /// Too little lent memory.
    #[error("lent memory of {found}, {needed} are needed")]
    LentMemory {
        /// Its length.
        found: usize,
        /// The length that is needed.
        needed: usize,
    },
    /// A step of a member was refused.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A load of a member was refused.
    #[error(transparent)]
    Load(#[from] LoadError),
}

impl From<Short> for WorldError {
    fn from(Short { found, needed }: Short) -> Self {
        Self::LentMemory { found, needed }
    }
}
