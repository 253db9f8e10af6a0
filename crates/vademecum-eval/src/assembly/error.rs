//! Errors of joining bodies, by who can act: the part, the joint, the assembly, memory.

use thiserror::Error;
use vademecum_format::{FormatError, SectionKind};

/// Why bodies are not joined. Parts and joints are counted from 0, in the order in which they were given.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AssemblyError {
    /// A part cannot be joined.
    #[error("part {part}: {fault}")]
    Part {
        /// The part.
        part: usize,
        /// Its fault.
        fault: PartFault,
    },
    /// A joint cannot be made.
    #[error("joint {joint}: {fault}")]
    Joint {
        /// The joint.
        joint: usize,
        /// Its fault.
        fault: JointFault,
    },
    /// A body that moves without stiffness, and not as one free body.
    #[error(
        "the joined body moves without stiffness in {motions} ways; hold its parts, or leave it free as one body \
         of free parts"
    )]
    Moves {
        /// Number of motions without stiffness.
        motions: usize,
        /// Bit `k` is that of part `k`, which moves; the last bit is that of all parts from 63 on.
        parts: u64,
    },
    /// No parts, or more modes or rows of joints than there can be.
    #[error("{found} {what}; expected 1 to {most}")]
    Count {
        /// Parts, modes or rows of joints.
        what: &'static str,
        /// As many as there are.
        found: usize,
        /// Largest number.
        most: usize,
    },
    /// An option or a number of a state is not finite or out of its range.
    #[error("{what}: expected finite numbers, a time step above 0")]
    Number {
        /// Its name.
        what: &'static str,
    },
    /// Numbers of parts that double precision does not hold.
    #[error("the eigenproblem of the joined body does not converge: numbers of its parts are not finite")]
    NoConvergence,
    /// Memory that is too short.
    #[error("{found} {what} were lent, {needed} are needed")]
    LentMemory {
        /// Bytes of the file, numbers of memory or of work.
        what: &'static str,
        /// As many as were lent.
        found: usize,
        /// As many as are needed.
        needed: usize,
    },
    /// A list of numbers of another length.
    #[error("{what} of {found} numbers; expected {expected}")]
    Length {
        /// The list.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length expected.
        expected: usize,
    },
    /// The joined file cannot be written.
    #[error("the joined file: {0}")]
    Format(#[from] FormatError),
}

/// Why a part cannot be joined.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PartFault {
    /// A body without natural modes that are moved exactly, or with live stiffness of a region.
    #[error("the file has no natural modes that are moved exactly")]
    NotExact,
    /// A section that joining needs.
    #[error("the file has no section {kind}; build it with `[[port]]`, and do not strip it")]
    Missing {
        /// The section.
        kind: SectionKind,
    },
    /// A section of another shape than others.
    #[error("section {kind} does not fit the others of the file")]
    Disagrees {
        /// The section.
        kind: SectionKind,
    },
    /// A place or a rotation that is none.
    #[error("position and rotation: expected finite numbers and a quaternion of unit length")]
    Pose,
    /// A section that is compressed, or of another element.
    #[error(transparent)]
    Format(#[from] FormatError),
}

/// Why a joint cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum JointFault {
    /// A part or a port that there is not.
    #[error("there is no port {port} of part {part}")]
    NoPort {
        /// The part.
        part: usize,
        /// The port.
        port: usize,
    },
    /// A patch and a frame.
    #[error("a patch and a frame; expected two patches, or two frames")]
    Mixed,
    /// A joint that patches cannot have.
    #[error("a joint of patches other than a weld and a bushing; other joints are those of frames")]
    OfPatches,
    /// Numbers of stiffness that do not fit, are negative, or all zero.
    #[error("{found} numbers of stiffness; expected {expected} of 0 or more, one of them above 0")]
    Stiffness {
        /// Numbers given.
        found: usize,
        /// Numbers of this joint.
        expected: usize,
    },
    /// A patch that others cannot follow.
    #[error("a patch without facets; expected two patches of facets")]
    NoFacets,
    /// A spring between frames at one place has no direction.
    #[error("frames at one place; expected two frames whose origins are apart")]
    OnePlace,
    /// Ports that do not meet.
    #[error("ports {distance:.3e} m apart; expected at most {most:.3e} m")]
    Apart {
        /// True of frames.
        frames: bool,
        /// Their largest distance \[m\].
        distance: f64,
        /// The distance allowed \[m\].
        most: f64,
    },
    /// Rows that follow from others.
    #[error("its rows follow from those of joints before it, or both sides are held")]
    Redundant,
    /// A list of offsets of another length than the joint has rows.
    #[error("{found} offsets; expected {expected}, one for each row")]
    Offsets {
        /// Offsets given.
        found: usize,
        /// Rows of the joint.
        expected: usize,
    },
    /// A joint before it is made as things stand: such joints come last.
    #[error("a joint before it is made as it stands; joints as they stand come last")]
    Order,
    /// There is no such joint.
    #[error("there is no such joint")]
    Unknown,
}
