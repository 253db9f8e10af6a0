//! What can go wrong, apart by who can act: binding (options or memory), loading, stepping, reading.

use crate::sections::place::PlaceError;
use core::fmt;
use vademecum_format::scheme::TableError;
use vademecum_format::{FormatError, ParameterRole, SectionKind};

/// Why a scene could not be bound.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BindError {
    /// The file is refused, or a section it needs is compressed.
    Format(FormatError),
    /// Scheme or step parameters are refused.
    Scheme(TableError),
    /// A parameter was not set.
    Parameter(ParameterError),
    /// The structure asked for is not in the file.
    NoStructure,
    /// The file has only the chapter's structure (`representation = "canonical"`), which an ordinary scene
    /// does not step. The evaluator's feature `chapter` has a scene for it.
    OnlyChapter,
    /// The evaluator was built without its feature `full`: it takes exact steps only.
    LeftOut,
    /// The scene was bound to the other structure; its memory has not the room for this one.
    OtherStructure,
    /// A region has a scale of its own, and the diagonal structure knows none: its modes are those of the
    /// whole body.
    NotDiagonal,
    /// A region has a scale of its own, and the strain structure knows only those of the whole body.
    WholeBody,
    /// The file has what the strain structure cannot do: a free body, or a base that moves.
    NotWithStrain {
        /// The section.
        kind: SectionKind,
    },
    /// The scale of a region is not a positive number.
    BadScale {
        /// The region, and whether it is its stiffness or its density.
        role: ParameterRole,
        /// The scale.
        value: f64,
    },
    /// The block structure was built for this region as it is: no parameter and axis carry its scale.
    FixedRegion {
        /// The region, and whether it is its stiffness or its density.
        role: ParameterRole,
        /// The scale asked for.
        value: f64,
    },
    /// The state was made for a scene of another shape.
    Mismatch,
    /// The block structure was built for other parameters: no parameter and axis carry what the options
    /// change.
    Fixed {
        /// The stage.
        stage: usize,
        /// `θ` \[s²\] the options ask for.
        requested: f64,
        /// `θ` the file was built for.
        built: f64,
    },
    /// A coordinate lies outside its axis (or between the points of an index axis).
    OutsideAxis {
        /// The axis.
        axis: usize,
        /// The value.
        value: f64,
    },
    /// An axis has a role or kind this evaluator does not know.
    UnknownAxis {
        /// The axis.
        axis: usize,
    },
    /// Memory lent to the scene, the state or the loads is too short.
    LentMemory {
        /// Numbers lent.
        found: usize,
        /// Numbers needed.
        needed: usize,
    },
    /// The rest threshold, the tolerance or the viscosity is negative or not a number, or the sub-steps are
    /// not 1 to 1024.
    BadOption {
        /// Its value.
        value: f64,
    },
    /// So many terms cannot be had: a file without live parameters needs all it has, others at least one; a
    /// bound scene keeps its number.
    Terms {
        /// Terms asked for.
        asked: usize,
        /// Terms there are.
        found: usize,
    },
    /// The stages of the block structure have no eigenvectors in common; step it dense.
    NotDiagonalisable {
        /// What is left beside the diagonals.
        remainder: f64,
        /// What was accepted.
        tolerance: f64,
    },
    /// A coefficient of the fused step, or the state carried over to it, is not finite in the chosen
    /// precision.
    NotFinite,
}

/// Why a parameter was not set.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParameterError {
    /// The file has no such parameter, or it is of a role this evaluator does not know.
    Unknown {
        /// Its place.
        index: usize,
    },
    /// The parameter is set twice at once.
    Twice {
        /// Its place.
        parameter: usize,
    },
    /// The value is outside the parameter's range, or not a number.
    OutsideRange {
        /// The parameter's place.
        parameter: usize,
        /// The value.
        value: f64,
        /// Smallest value allowed.
        lower: f64,
        /// Largest value allowed.
        upper: f64,
    },
}

/// Why a load was not added; the accumulated loads are unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LoadError {
    /// A force, moment or amplitude is not finite.
    NotFinite,
    /// The place is refused.
    Place(PlaceError),
    /// The node is not loadable.
    NotLoadable {
        /// The node, in file order.
        node: u32,
        /// Loadable nodes.
        limit: u32,
    },
    /// There is no such pattern.
    NoPattern {
        /// The pattern.
        index: usize,
        /// Patterns in the file.
        count: usize,
    },
    /// A section this needs is not in the file, or is compressed.
    Missing {
        /// Its kind.
        kind: SectionKind,
    },
    /// The contacts stand on more nodes than the options made room for.
    TooManyContacts {
        /// [`SceneOptions::contacts`](crate::SceneOptions::contacts).
        contacts: usize,
    },
    /// The body was bound without room for kept loads.
    NoRoom,
    /// The loads were made for a scene of another shape.
    Mismatch,
    /// The loads hold contacts from before the scene's parameters changed; clear them and add again.
    Stale,
    /// The compliance of the strain structure depends on the state; ask
    /// [`Scene::compliance_at`](crate::Scene::compliance_at).
    NeedsState,
    /// The strain structure tells the compliance over one sub-step only, and the scene has more of them.
    Substeps {
        /// How many.
        substeps: usize,
    },
    /// The batch has no such instance.
    NoInstance {
        /// The instance.
        index: usize,
        /// Instances in the batch.
        count: usize,
    },
}

/// Why a step was not taken; the state is unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum StepError {
    /// The new state is not finite: a load too large, or a state set too large, for the precision.
    NotFinite,
    /// State or loads were made for a scene of another shape, or given numbers have the wrong length.
    Mismatch,
    /// The loads were added before the scene's parameters changed; clear them and add again.
    StaleLoads,
    /// The state belongs to another `Δt` than the scene's; carry it over with
    /// [`State::carry`](crate::State::carry).
    NotCarried,
    /// The file's region masses do not sum to a positive definite matrix.
    BadMass,
    /// The batch has no such instance.
    NoInstance,
    /// The modes were found before the scene's parameters changed; find them again.
    StaleModes,
}

/// Why an output could not be given.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum OutputError {
    /// The place is refused.
    Place(PlaceError),
    /// A section this needs is not in the file, or is compressed.
    Missing {
        /// Its kind.
        kind: SectionKind,
    },
    /// There is no such probe or node.
    OutOfRange {
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// The output slice has the wrong length.
    Length {
        /// Its length.
        found: usize,
        /// The length needed.
        needed: usize,
    },
    /// The state was made for a scene of another shape.
    Mismatch,
    /// A reaction of a scene, or a state, that does not remember the forces of its last step.
    ForcesForgotten,
    /// The velocity of a quantity that has none.
    NoVelocity,
    /// A place was given for what is counted, or a number for what is read at a place.
    NotAPlace,
    /// The strain structure does not know it: a stress, a reaction, a fused map.
    NotWithStrain,
    /// The scene has no strain structure, or the file no training box.
    NoTraining,
}

impl fmt::Display for BindError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Format(error) => error.fmt(out),
            Self::Scheme(error) => error.fmt(out),
            Self::NoStructure => {
                write!(out, "the file does not hold the structure asked for; choose the other or build it")
            }
            Self::LeftOut => write!(
                out,
                "this program was built for exact steps only; take them, or build it with the evaluator's \
                 feature `full`"
            ),
            Self::Fixed { stage, requested, built } => write!(
                out,
                "stage {stage} needs theta = {requested:e} s², the block structure was built for {built:e}: \
                 keep the file's time step, damping and scales, or use the diagonal structure"
            ),
            Self::OutsideAxis { axis, value } => {
                write!(out, "{value:e} is not on axis {axis}; the file's ranges are in its metadata")
            }
            Self::UnknownAxis { axis } => {
                write!(out, "axis {axis} is of a role or kind unknown to this evaluator")
            }
            Self::Parameter(error) => error.fmt(out),
            Self::OnlyChapter => write!(
                out,
                "the file has only the chapter's structure (representation = \"canonical\"), which this \
                 scene does not step: \
                 use `vademecum run`, or `ChapterScene` of the evaluator's feature `chapter`, or build \
                 the file without that line"
            ),
            Self::OtherStructure => {
                write!(
                    out,
                    "the scene holds the other structure; bind a new one, or leave the choice to Auto"
                )
            }
            Self::NotDiagonal => {
                write!(
                    out,
                    "a region has a scale of its own: only the block structure can do that, ask for it"
                )
            }
            Self::WholeBody => write!(
                out,
                "a region has a scale of its own: large displacements know only scales of the whole body"
            ),
            Self::NotWithStrain { kind } => write!(
                out,
                "the file has section {} ({kind:?}), which the strain structure cannot use: large \
                 displacements are those of a body with supports that stand still",
                kind.number()
            ),
            Self::BadScale { role, value } => {
                write!(out, "{role:?}: a scale of {value:e}, expected a positive number")
            }
            Self::FixedRegion { role, value } => {
                write!(
                    out,
                    "{role:?} = {value:e}: the file has no such parameter; build it with one, or leave it \
                     at 1"
                )
            }
            Self::NotDiagonalisable { remainder, tolerance } => write!(
                out,
                "the stages share their modes only up to {remainder:.1e}, {tolerance:.1e} was asked for: \
                 step dense"
            ),
            Self::Mismatch => write!(out, "this state belongs to a scene of another shape"),
            Self::LentMemory { found, needed } => {
                write!(out, "{found} numbers were lent, {needed} are needed")
            }
            Self::BadOption { value } => {
                write!(
                    out,
                    "tolerance, rest threshold, viscosity or sub-steps {value:e}: expected a finite number of 0 or \
                     more, and 1 to 1024 sub-steps"
                )
            }
            Self::Terms { asked, found } => {
                write!(
                    out,
                    "{asked} of {found} terms: a stage axis needs every term, a bound scene keeps its own"
                )
            }
            Self::NotFinite => write!(out, "the fused step is not finite in this precision; use f64"),
        }
    }
}

impl fmt::Display for ParameterError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Unknown { index } => {
                write!(out, "the file has no parameter {index}, or one this evaluator does not know")
            }
            Self::Twice { parameter } => write!(out, "parameter {parameter} is set twice"),
            Self::OutsideRange { parameter, value, lower, upper } => {
                write!(out, "parameter {parameter} = {value:e} is outside its range {lower:e} to {upper:e}")
            }
        }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotFinite => write!(out, "a force, moment or amplitude is not finite"),
            Self::Place(error) => error.fmt(out),
            Self::NotLoadable { node, limit } => {
                write!(out, "node {node} is not loadable; the first {limit} nodes are")
            }
            Self::NoPattern { index, count } => {
                write!(out, "there is no load pattern {index}; the file has {count}")
            }
            Self::Missing { kind } => missing(out, kind),
            Self::TooManyContacts { contacts } => write!(
                out,
                "more contacts on nodes of their own than the {contacts} there is room for; raise \
                 `SceneOptions::contacts`"
            ),
            Self::NoRoom => {
                write!(out, "there is no room for kept loads: bind the body with `BodyOptions::keep_loads`")
            }
            Self::Mismatch => write!(out, "these loads belong to a scene of another shape"),
            Self::NeedsState => write!(
                out,
                "the compliance of large displacements depends on the state: ask `Scene::compliance_at`"
            ),
            Self::Substeps { substeps } => write!(
                out,
                "a step of this scene has {substeps} sub-steps, and the compliance of the strain structure is \
                 that of one: bind it with one sub-step and a shorter step"
            ),
            Self::NoInstance { index, count } => {
                write!(out, "there is no instance {index}; the batch has {count}")
            }
            Self::Stale => {
                write!(out, "the loads are from before the parameters changed; clear them and add again")
            }
        }
    }
}

impl fmt::Display for StepError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotFinite => {
                write!(out, "the new state is not finite; the old one was kept: reduce the load")
            }
            Self::Mismatch => write!(out, "state, loads or numbers belong to a scene of another shape"),
            Self::StaleLoads => {
                write!(out, "the loads are from before the parameters changed; clear them and add again")
            }
            Self::NotCarried => {
                write!(out, "the state is scaled by another time step; carry it over to the scene first")
            }
            Self::NoInstance => write!(out, "the batch has no such instance"),
            Self::StaleModes => {
                write!(out, "the modes are from before the parameters changed; bind them again")
            }
            Self::BadMass => {
                write!(out, "the mass of the regions is not positive definite; build the file again")
            }
        }
    }
}

impl fmt::Display for OutputError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Place(error) => error.fmt(out),
            Self::Missing { kind } => missing(out, kind),
            Self::OutOfRange { index, count } => write!(out, "index {index} of {count}"),
            Self::Length { found, needed } => {
                write!(out, "an output of {found} numbers was lent, {needed} are written")
            }
            Self::Mismatch => write!(out, "this state belongs to a scene of another shape"),
            Self::NoVelocity => write!(out, "this quantity has no velocity"),
            Self::NotAPlace => {
                write!(out, "a point is read at a place, and everything else by its number")
            }
            Self::NotWithStrain => write!(
                out,
                "the strain structure does not give this: stress, strain, reactions and the fused map belong to \
                 small displacements"
            ),
            Self::NoTraining => {
                write!(out, "the file has no training box of the strain structure (sections 64 and 65)")
            }
            Self::ForcesForgotten => write!(
                out,
                "the forces of the last step, which reactions are made of, are not remembered: bind the \
                 scene with `SceneOptions::contacts` above 0, and give a state that is restored or taken \
                 from a batch its loads (`State::restore_under`, `Batch::get_under`)"
            ),
        }
    }
}

fn missing(out: &mut fmt::Formatter<'_>, kind: SectionKind) -> fmt::Result {
    write!(out, "section {} ({kind:?}) is not in the file or is compressed", kind.number())
}

impl core::error::Error for BindError {}
impl core::error::Error for ParameterError {}
impl core::error::Error for LoadError {}
impl core::error::Error for StepError {}
impl core::error::Error for OutputError {}

impl From<PlaceError> for LoadError {
    fn from(error: PlaceError) -> Self {
        Self::Place(error)
    }
}

impl From<PlaceError> for OutputError {
    fn from(error: PlaceError) -> Self {
        Self::Place(error)
    }
}

impl From<FormatError> for BindError {
    fn from(error: FormatError) -> Self {
        Self::Format(error)
    }
}

impl From<ParameterError> for BindError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl From<TableError> for BindError {
    fn from(error: TableError) -> Self {
        Self::Scheme(error)
    }
}
