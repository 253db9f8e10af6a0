//! Errors, apart by who can act: binding (options or memory), loading, stepping, reading.

use core::fmt;

use crate::sections::place::PlaceError;
use thiserror::Error;
use vademecum_format::scheme::TableError;
use vademecum_format::{FormatError, ParameterRole, SectionKind};

/// Why a scene could not be bound.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BindError {
    /// The file is refused, or a section it needs is compressed.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Scheme or step parameters are refused.
    #[error(transparent)]
    Scheme(#[from] TableError),
    /// A parameter was not set.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No live parameters of regions, or such that do not fit the matrices of the file, or matrices that are
    /// not definite.
    #[error(
        "the file has no live parameters of regions, or they do not fit its matrices, or these are not \
         definite: build it again with live regions"
    )]
    LiveParameters,
    /// The structure asked for is not in the file.
    #[error("the file does not hold the structure asked for; choose the other or build it")]
    NoStructure,
    /// The file has only the chapter's structure (`representation = "chapter"`), which an ordinary scene
    /// does not step. The crate `vademecum-chapter` has a scene for it.
    #[error(
        "the file has only the chapter's structure (representation = \"chapter\"), which this scene \
         does not step: use `vademecum run`, or `ChapterScene` of the crate `vademecum-chapter`, or build \
         the file without that line"
    )]
    OnlyChapter,
    /// The evaluator was built without its feature `full`: it takes exact steps only.
    #[error(
        "this program was built for exact steps only, of modes that no dashpots couple; take them, or build \
         it with the evaluator's feature `full`"
    )]
    LeftOut,
    /// The evaluator was built without its feature `filter`, and the body has residual flexibility and a β.
    #[error(
        "this program was built without residual flexibility under stiffness-proportional damping; bind \
         without the residual or with a beta of 0, or build it with the evaluator's feature `filter`"
    )]
    FilterLeftOut,
    /// A scene that was bound without stiffness-proportional damping has no room for the filter of its
    /// residual flexibility.
    #[error(
        "the scene was bound without stiffness-proportional damping, so its residual flexibility has no \
         filter: bind it with a beta, or without the residual"
    )]
    NoFilter,
    /// The scene was bound to the other structure; its memory has not the room for this one.
    #[error("the scene holds the other structure; bind a new one, or leave the choice to Auto")]
    OtherStructure,
    /// A region has a scale of its own, and the diagonal structure knows none: its modes are those of the
    /// whole body.
    #[error("a region has a scale of its own: only the block structure can do that, ask for it")]
    NotDiagonal,
    /// A region has a scale of its own, and the strain structure knows only those of the whole body.
    #[error("a region has a scale of its own: large displacements know only scales of the whole body")]
    WholeBody,
    /// The file has what the strain structure cannot do: a free body, or a base that moves.
    #[error(
        "the file has section {} ({kind}), which the strain structure cannot use: large displacements are \
         those of a body with supports that stand still",
        kind.number()
    )]
    NotWithStrain {
        /// The section.
        kind: SectionKind,
    },
    /// The file has what only exact steps use, and another structure is asked for.
    #[error(
        "the file has section {} ({kind}), which only exact steps use: dashpots couple its modes; ask for \
         exact steps, or leave the choice to Auto",
        kind.number()
    )]
    OnlyExact {
        /// The section.
        kind: SectionKind,
    },
    /// The scale of a region is not a positive number.
    #[error("{}: a scale of {value:e}, expected a positive number", Subject(*role))]
    BadScale {
        /// The region, and whether it is its stiffness or its density.
        role: ParameterRole,
        /// The scale.
        value: f64,
    },
    /// The block structure was built for this region as it is: no parameter and axis carry its scale.
    #[error(
        "{} = {value:e}: the file has no such parameter; build it with one, or leave it at 1",
        Subject(*role)
    )]
    FixedRegion {
        /// The region, and whether it is its stiffness or its density.
        role: ParameterRole,
        /// The scale asked for.
        value: f64,
    },
    /// The state was made for a scene of another shape.
    #[error("this state belongs to a scene of another shape")]
    Mismatch,
    /// The block structure was built for other parameters: no parameter and axis carry what the options
    /// change.
    #[error(
        "stage {stage} needs theta = {requested:e} s², the block structure was built for {built:e}: keep \
         the file's time step, damping and scales, or use the diagonal structure"
    )]
    Fixed {
        /// The stage.
        stage: usize,
        /// `θ` \[s²\] the options ask for.
        requested: f64,
        /// `θ` the file was built for.
        built: f64,
    },
    /// A coordinate lies outside its axis (or between the points of an index axis).
    #[error("{value:e} is not on axis {axis}; the file's ranges are in its metadata")]
    OutsideAxis {
        /// The axis.
        axis: usize,
        /// The value.
        value: f64,
    },
    /// An axis has a role or kind this evaluator does not know.
    #[error("axis {axis} is of a role or kind unknown to this evaluator")]
    UnknownAxis {
        /// The axis.
        axis: usize,
    },
    /// Memory lent to the scene, the state or the loads is too short.
    #[error("{found} numbers were lent, {needed} are needed")]
    LentMemory {
        /// Numbers lent.
        found: usize,
        /// Numbers needed.
        needed: usize,
    },
    /// A number of memory that no machine has: so many contacts or places are asked for, or so large is what
    /// the file holds.
    #[error("{asked} {what} are asked for; there is room for {most} at most")]
    TooLarge {
        /// Contacts, places or numbers.
        what: &'static str,
        /// As many as were asked for.
        asked: usize,
        /// Largest number.
        most: usize,
    },
    /// The rest threshold, the tolerance or the viscosity is negative or not a number, or the sub-steps are
    /// not 1 to 1024.
    #[error(
        "tolerance, rest threshold, viscosity or sub-steps {value:e}: expected a finite number of 0 or \
         more, and 1 to 1024 sub-steps"
    )]
    BadOption {
        /// Its value.
        value: f64,
    },
    /// So many terms cannot be had: a file without live parameters needs all it has, others at least one; a
    /// bound scene keeps its number.
    #[error("{asked} of {found} terms: a stage axis needs every term, a bound scene keeps its own")]
    Terms {
        /// Terms asked for.
        asked: usize,
        /// Terms there are.
        found: usize,
    },
    /// A coefficient of the fused step, or the state carried over to it, is not finite in the chosen
    /// precision.
    #[error("the fused step is not finite in this precision; use f64")]
    NotFinite,
}

/// Why a parameter was not set.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// The file has no such parameter, or it is of a role this evaluator does not know.
    #[error("the file has no parameter {index}, or one this evaluator does not know")]
    Unknown {
        /// Its place.
        index: usize,
    },
    /// The value is outside the parameter's range, or not a number.
    #[error("parameter {parameter} = {value:e} is outside its range {lower:e} to {upper:e}")]
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
    /// The parameter is set twice at once.
    #[error("parameter {parameter} is set twice")]
    Twice {
        /// Its place.
        parameter: usize,
    },
}

/// Why a body has no place nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LocateError {
    /// The file has no loadable surface, or it is compressed.
    #[error("the file has no loadable surface, or it is compressed")]
    NoSurface,
    /// The point has a coordinate that is not finite.
    #[error("the point has a coordinate that is not finite")]
    NotFinite,
    /// The point is further away from the loadable surface than the body is large.
    #[error(
        "the point is {distance:.3e} away from the loadable surface, and the body is {reach:.3e} large: \
         is it in the unit of the file?"
    )]
    Far {
        /// Distance to the nearest point of the loadable surface.
        distance: f64,
        /// [`Surface::reach`](crate::Surface::reach), which it may have at most.
        reach: f64,
    },
}

/// Why a load was not added; the accumulated loads are unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// A force, moment or amplitude is not finite or larger than [`Scalar::LARGEST`](crate::Scalar::LARGEST),
    /// or what was computed of it is not finite.
    #[error(
        "a force, moment or amplitude is not finite, or above the largest of this precision (1e18 in f32, \
         1e75 in f64)"
    )]
    NotFinite,
    /// The place is refused.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The node is not loadable.
    #[error("node {node} is not loadable; the first {limit} nodes are")]
    NotLoadable {
        /// The node, in file order.
        node: u32,
        /// Loadable nodes.
        limit: u32,
    },
    /// There is no such pattern.
    #[error("there is no load pattern {index}; the file has {count}")]
    NoPattern {
        /// The pattern.
        index: usize,
        /// Patterns in the file.
        count: usize,
    },
    /// A section this needs is not in the file, or is compressed.
    #[error("section {} ({kind}) is not in the file or is compressed", kind.number())]
    Missing {
        /// Its kind.
        kind: SectionKind,
    },
    /// The contacts stand on more nodes than the options made room for.
    #[error(
        "more contacts on nodes of their own than the {contacts} there is room for; raise \
         `SceneOptions::contacts`"
    )]
    TooManyContacts {
        /// [`SceneOptions::contacts`](crate::SceneOptions::contacts).
        contacts: usize,
    },
    /// The loads were made for a scene of another shape.
    #[error("these loads belong to a scene of another shape")]
    Mismatch,
    /// The loads hold contacts from before the scene's parameters changed; clear them and add again.
    #[error("the loads are from before the parameters changed; clear them and add again")]
    Stale,
    /// The compliance of the strain structure depends on the state; ask
    /// [`Scene::compliance_at`](crate::Scene::compliance_at).
    #[error("the compliance of large displacements depends on the state: ask `Scene::compliance_at`")]
    NeedsState,
    /// The strain structure tells the compliance over one sub-step only, and the scene has more of them.
    #[error(
        "a step of this scene has {substeps} sub-steps, and the compliance of the strain structure is \
         that of one: bind it with one sub-step and a shorter step"
    )]
    Substeps {
        /// Number of contacts.
        substeps: usize,
    },
    /// The body was bound without room for kept loads.
    #[error("there is no room for kept loads: bind the body with `BodyOptions::keep_loads`")]
    NoRoom,
    /// The batch has no such instance.
    #[error("there is no instance {index}; the batch has {count}")]
    NoInstance {
        /// The instance.
        index: usize,
        /// Instances in the batch.
        count: usize,
    },
}

/// Why a step was not taken; the state is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StepError {
    /// The new state is not finite, or its numbers sum to more than
    /// [`Scalar::LARGEST`](crate::Scalar::LARGEST): a load too large, or a state set too large, for the
    /// precision.
    #[error(
        "the new state is not finite or too large for the precision; the old one was kept: reduce the load"
    )]
    NotFinite,
    /// State or loads were made for a scene of another shape, or given numbers have the wrong length.
    #[error("state, loads or numbers belong to a scene of another shape")]
    Mismatch,
    /// The loads were added before the scene's parameters changed; clear them and add again.
    #[error("the loads are from before the parameters changed; clear them and add again")]
    StaleLoads,
    /// The state belongs to another `Δt` than the scene's; carry it over with
    /// [`State::carry`](crate::State::carry).
    #[error("the state is scaled by another time step; carry it over to the scene first")]
    NotCarried,
    /// The file's region masses do not sum to a positive definite matrix.
    #[error("the mass of the regions is not positive definite; build the file again")]
    BadMass,
    /// The batch has no such instance.
    #[error("the batch has no such instance")]
    NoInstance,
    /// Under stiffness-proportional damping the residual flexibility still follows forces on other nodes, and
    /// there is no room for those of this step.
    #[error(
        "the filtered forces of the residual stand on more than {nodes} nodes: raise \
         `SceneOptions::filtered_nodes`"
    )]
    TooManyNodes {
        /// Nodes that there is room for.
        nodes: usize,
    },
}

/// Why an output could not be given.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The place is refused.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// A section this needs is not in the file, or is compressed.
    #[error("section {} ({kind}) is not in the file or is compressed", kind.number())]
    Missing {
        /// Its kind.
        kind: SectionKind,
    },
    /// There is no such probe or node.
    #[error("index {index} of {count}")]
    OutOfRange {
        /// The index.
        index: usize,
        /// Number in the file.
        count: usize,
    },
    /// The output slice has the wrong length.
    #[error("an output of {found} numbers was lent, {needed} are written")]
    Length {
        /// Its length.
        found: usize,
        /// The length needed.
        needed: usize,
    },
    /// The state was made for a scene of another shape.
    #[error("this state belongs to a scene of another shape")]
    Mismatch,
    /// The number overflows: the motion is too large for it.
    #[error("the motion is so large that this number is not finite")]
    NotFinite,
    /// A reaction of a scene, or a state, that does not remember the forces of its last step.
    #[error(
        "the forces of the last step, which reactions are made of, are not remembered: bind the scene \
         with `SceneOptions::contacts` above 0, and give a state that is restored or taken from a batch \
         its loads (`State::restore_under`, `Batch::get_under`)"
    )]
    ForcesForgotten,
    /// The velocity of a quantity that has none.
    #[error("this quantity has no velocity")]
    NoVelocity,
    /// A place was given for what is counted, or a number for what is read at a place.
    #[error("this quantity is read at a place; every other one by its index")]
    NotAPlace,
    /// The strain structure does not know it: a stress, a reaction, a fused map.
    #[error(
        "the strain structure does not give this: stress, strain, reactions and the fused map belong to \
         small displacements"
    )]
    NotWithStrain,
    /// The scene has no strain structure, or the file no training box.
    #[error("the file has no training box of the strain structure (sections 64 and 65)")]
    NoTraining,
}

/// The words for a parameter's role in a message; regions are counted from 0, as in the file.
struct Subject(ParameterRole);

impl fmt::Display for Subject {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            ParameterRole::Stiffness => out.write_str("stiffness"),
            ParameterRole::RegionStiffness { region } => write!(out, "stiffness of region {region}"),
            ParameterRole::Density => out.write_str("density"),
            ParameterRole::RegionDensity { region } => write!(out, "density of region {region}"),
            ParameterRole::Alpha => out.write_str("damping alpha"),
            ParameterRole::Beta => out.write_str("damping beta"),
            ParameterRole::TimeStep => out.write_str("time step"),
            ParameterRole::Damping { group } => write!(out, "damping of dashpots {group}"),
            ParameterRole::LossFactor { region } => write!(out, "loss factor of region {region}"),
            _ => out.write_str("a parameter of an unknown role"),
        }
    }
}
