//! The variable of a value reference: the same list for the model description and for the instance.
//!
//! The references of a kind are consecutive, and kinds follow each other in the order of [`Variable`].

use vademecum_eval::format::{File, Metadata, ParameterRole, SectionKind};
use vademecum_eval::{Quantity, RigidBody};

/// Counts of everything that a value reference can name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Named points.
    pub points: u32,
    /// Load patterns of the file.
    pub patterns: u32,
    /// Probes of the file.
    pub probes: u32,
    /// Parameters of the file.
    pub parameters: u32,
    /// Places whose stress is reported.
    pub stresses: u32,
    /// Nodes of the arrays at most; there are none for 0.
    pub surface: u32,
    /// Supports whose reactions the file gives.
    pub supports: u32,
    /// 1 for a free body, 0 for one with supports.
    pub free: u32,
    /// 1 for a file with exact steps, which may be of any length and whose whole body can be scaled; else 0.
    pub exact: u32,
    /// True of a body whose step is linear: it neither flies nor bends far.
    pub linear: bool,
}

/// Meaning of each value reference: the number of references of each kind, counted once.
#[derive(Clone, Copy, Debug)]
pub struct References {
    lengths: [u32; 25],
    points: u32,
}

/// Meaning of a value reference. Points, patterns, probes and parameters are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// Time \[s\], the independent variable.
    Time,
    /// `Δt` \[s\], the internal step.
    Step,
    /// Kinetic plus elastic energy \[J\].
    Energy,
    /// Component 0 to 2 of the force on a point \[N\].
    Force(u32, u32),
    /// Component 0 to 2 of a point's displacement \[m\].
    Displacement(u32, u32),
    /// Component 0 to 2 of a point's velocity \[m/s\].
    Velocity(u32, u32),
    /// Amplitude of a load pattern.
    Pattern(u32),
    /// Displacement of a probe \[m\].
    Probe(u32),
    /// Velocity of a probe \[m/s\].
    ProbeVelocity(u32),
    /// A parameter of the file.
    Parameter(u32),
    /// Von Mises' equivalent stress of a place \[Pa\].
    VonMises(u32),
    /// Component 0 to 2 of the force that a support exerts on the body \[N\].
    ReactionForce(u32, u32),
    /// Component 0 to 2 of its moment about the point of the support \[N m\].
    ReactionMoment(u32, u32),
    /// Component 0 to 2 of the force on the centre of a free body \[N\].
    BodyForce(u32),
    /// Component 0 to 2 of where the centre of a free body is \[m\].
    BodyPosition(u32),
    /// Component 0 to 3 of the quaternion that turns a free body; the real part is the last one.
    BodyAttitude(u32),
    /// Component 0 to 2 of the velocity of the centre of a free body \[m/s\].
    BodyVelocity(u32),
    /// Component 0 to 2 of the angular velocity of a free body in space \[rad/s\].
    BodySpin(u32),
    /// A further scalar of the whole body, of [`Variable::total`].
    Total(u32),
    /// 0 to 3 of a file with exact steps: scale of the stiffness and of the density of the whole body,
    /// Rayleigh `α` \[1/s\] and `β` \[s\].
    Whole(u32),
    /// Number of surface nodes in use: the first dimension of the arrays.
    SurfaceNodes,
    /// Positions of the surface nodes at rest \[m\], an array.
    SurfacePosition,
    /// Forces on them \[N\], an array.
    SurfaceForce,
    /// Their displacements \[m\], an array.
    SurfaceDisplacement,
    /// Their velocities \[m/s\], an array.
    SurfaceVelocity,
    /// Component 0 to 2 of the position of a place at rest \[m\]: an element, without a reference of its own.
    Position(u32, u32),
}

impl Variable {
    /// The scalars of the whole body behind the energy, in the order of the evaluator's table.
    pub fn totals() -> impl Iterator<Item = Quantity> {
        Quantity::totals().filter(|quantity| *quantity != Quantity::Energy)
    }

    /// The quantity of number `index` among [`Variable::totals`].
    #[must_use]
    pub fn total(index: u32) -> Option<Quantity> {
        Self::totals().nth(index as usize)
    }

    /// True of outputs.
    #[must_use]
    pub const fn is_output(self) -> bool {
        match self {
            Self::Time | Self::Step | Self::Parameter(_) | Self::Whole(_) => false,
            Self::Force(..) | Self::Pattern(_) | Self::BodyForce(_) | Self::SurfaceForce => false,
            Self::SurfaceNodes | Self::SurfacePosition | Self::Position(..) => false,
            Self::SurfaceDisplacement | Self::SurfaceVelocity => true,
            Self::Energy | Self::Total(_) | Self::Displacement(..) | Self::Velocity(..) => true,
            Self::Probe(_) | Self::ProbeVelocity(_) | Self::VonMises(_) => true,
            Self::ReactionForce(..) | Self::ReactionMoment(..) => true,
            Self::BodyPosition(_) | Self::BodyAttitude(_) => true,
            Self::BodyVelocity(_) | Self::BodySpin(_) => true,
        }
    }

    /// True of variables of floating point; false of structural parameters, which are counts.
    #[must_use]
    pub const fn is_number(&self) -> bool {
        !matches!(self, Self::SurfaceNodes)
    }

    /// True of inputs.
    #[must_use]
    pub const fn is_input(self) -> bool {
        matches!(self, Self::Force(..) | Self::Pattern(_) | Self::BodyForce(_) | Self::SurfaceForce)
    }

    /// True of arrays, whose dimensions are the surface nodes in use and 3.
    #[must_use]
    pub const fn is_array(self) -> bool {
        matches!(
            self,
            Self::SurfacePosition | Self::SurfaceForce | Self::SurfaceDisplacement | Self::SurfaceVelocity
        )
    }

    /// Number of its values with so many surface nodes.
    #[must_use]
    pub const fn length(self, nodes: u32) -> u32 {
        if self.is_array() { nodes.saturating_mul(3) } else { 1 }
    }

    /// Value `index` of it, row by row, with so many named points: places are numbered behind them.
    #[must_use]
    pub const fn element(self, points: u32, index: u32) -> Self {
        let (place, component) = (points.saturating_add(index / 3), index % 3);
        match self {
            Self::SurfacePosition => Self::Position(place, component),
            Self::SurfaceForce => Self::Force(place, component),
            Self::SurfaceDisplacement => Self::Displacement(place, component),
            Self::SurfaceVelocity => Self::Velocity(place, component),
            scalar => scalar,
        }
    }

    /// Array, row and column of an element of an array, with so many named points; `None` of others.
    #[must_use]
    pub const fn in_array(self, points: u32) -> Option<(Self, u32, u32)> {
        let (array, place, component) = match self {
            Self::Position(place, c) => (Self::SurfacePosition, place, c),
            Self::Force(place, c) => (Self::SurfaceForce, place, c),
            Self::Displacement(place, c) => (Self::SurfaceDisplacement, place, c),
            Self::Velocity(place, c) => (Self::SurfaceVelocity, place, c),
            _ => return None,
        };
        match place.checked_sub(points) {
            Some(row) => Some((array, row, component)),
            None => None,
        }
    }

    /// First part of its name, and last part for a component: `force.NAME.x`.
    #[must_use]
    pub fn kind(self) -> (&'static str, Option<&'static str>) {
        const fn component(component: u32) -> Option<&'static str> {
            match component {
                0 => Some("x"),
                1 => Some("y"),
                2 => Some("z"),
                _ => Some("w"),
            }
        }
        match self {
            Self::Time => ("time", None),
            Self::Step => ("internal_step", None),
            Self::Energy => ("energy", None),
            Self::Force(_, c) => ("force", component(c)),
            Self::Displacement(_, c) => ("displacement", component(c)),
            Self::Velocity(_, c) => ("velocity", component(c)),
            Self::Pattern(_) => ("pattern", None),
            Self::Probe(_) => ("probe", None),
            Self::ProbeVelocity(_) => ("probe_velocity", None),
            Self::Parameter(_) => ("parameter", None),
            Self::VonMises(_) => ("von_mises", None),
            Self::ReactionForce(_, c) => ("reaction_force", component(c)),
            Self::ReactionMoment(_, c) => ("reaction_moment", component(c)),
            Self::BodyForce(c) => ("body_force", component(c)),
            Self::BodyPosition(c) => ("body_position", component(c)),
            Self::BodyAttitude(c) => ("body_attitude", component(c)),
            Self::BodyVelocity(c) => ("body_velocity", component(c)),
            Self::BodySpin(c) => ("body_angular_velocity", component(c)),
            Self::Total(index) => (Self::total(index).map_or("", Quantity::name), None),
            Self::Whole(0) => ("body_stiffness", None),
            Self::Whole(1) => ("body_density", None),
            Self::Whole(2) => ("body_alpha", None),
            Self::Whole(_) => ("body_beta", None),
            Self::SurfaceNodes => ("surface_nodes", None),
            Self::SurfacePosition => ("surface_position", None),
            Self::SurfaceForce => ("surface_force", None),
            Self::SurfaceDisplacement => ("surface_displacement", None),
            Self::SurfaceVelocity => ("surface_velocity", None),
            Self::Position(_, c) => ("position", component(c)),
        }
    }
}

/// True of a file that an FMU steps exactly in time.
#[must_use]
pub fn is_exact(file: &File<'_>) -> bool {
    let metadata = file.metadata();
    let strain = file.section(SectionKind::StrainSizes).is_some();
    metadata.scheme.is_exact() && metadata.diagonal && !strain && !has_live_regions(metadata)
}

/// True of a body whose step is linear: it neither flies nor bends far.
#[must_use]
pub fn is_linear(file: &File<'_>) -> bool {
    RigidBody::of(file).is_none() && file.section(SectionKind::StrainSizes).is_none()
}

/// True of a file with a live parameter of a region.
#[must_use]
pub fn has_live_regions(metadata: &Metadata<'_>) -> bool {
    let of_region =
        |role| matches!(role, ParameterRole::RegionStiffness { .. } | ParameterRole::RegionDensity { .. });
    metadata.active_parameters().iter().any(|parameter| of_region(parameter.role))
}

impl Counts {
    /// Those of a file with so many points, places of stress and surface nodes.
    #[must_use]
    pub fn of(file: &File<'_>, points: u32, stresses: u32, surface: u32) -> Self {
        let metadata = file.metadata();
        let free = RigidBody::of(file);
        // The patterns of the angular velocity are the last ones, and a step adds them itself.
        let patterns = free.and_then(|body| u32::try_from(body.first_pattern).ok());
        let supports = file.section(SectionKind::ReactionBasis).map_or(0, |section| section.shape()[0]);
        Self {
            points,
            patterns: patterns.unwrap_or(metadata.n_patterns),
            probes: metadata.n_probes,
            parameters: file.parameters().fold(0, |count, _| count + 1),
            stresses,
            surface,
            supports: u32::try_from(supports).unwrap_or(0),
            free: u32::from(free.is_some()),
            exact: u32::from(is_exact(file)),
            linear: is_linear(file),
        }
    }

    /// Number of references of each kind, in their order.
    fn lengths(&self) -> [u32; 25] {
        let Self { points, patterns, probes, parameters, stresses, surface, supports, free, exact, .. } =
            *self;
        let arrays = if surface > 0 { 1 } else { 0 };
        let (moved, held, flown) =
            (points.saturating_mul(3), supports.saturating_mul(3), free.saturating_mul(3));
        let turned = free.saturating_mul(4);
        [
            1,
            1,
            1,
            moved,
            moved,
            moved,
            patterns,
            probes,
            probes,
            parameters,
            stresses,
            held,
            held,
            flown,
            flown,
            turned,
            flown,
            flown,
            Variable::totals().fold(0, |count, _| count + 1),
            exact.saturating_mul(4),
            arrays,
            arrays,
            arrays,
            arrays,
            arrays,
        ]
    }

    /// Meaning of each reference.
    #[must_use]
    pub fn references(&self) -> References {
        References { lengths: self.lengths(), points: self.points }
    }

    /// The variable of a reference.
    #[must_use]
    pub fn variable(&self, reference: u32) -> Option<Variable> {
        self.references().variable(reference)
    }

    /// The reference of a variable.
    #[must_use]
    pub fn reference(&self, variable: Variable) -> Option<u32> {
        (0..).zip(self.all()).find(|(_, known)| *known == variable).map(|(reference, _)| reference)
    }

    /// All variables in the order of their references, which count from 0.
    pub fn all(&self) -> impl Iterator<Item = Variable> {
        let references = self.references();
        let count = references.lengths.into_iter().fold(0, u32::wrapping_add);
        (0..count).filter_map(move |reference| references.variable(reference))
    }
}

impl References {
    /// The variable of a reference.
    #[must_use]
    pub fn variable(&self, reference: u32) -> Option<Variable> {
        use Variable as V;
        let mut at = reference;
        for (kind, &length) in self.lengths.iter().enumerate() {
            let Some(beyond) = at.checked_sub(length) else {
                let (item, component) = (at / 3, at % 3);
                return Some(match kind {
                    0 => V::Time,
                    1 => V::Step,
                    2 => V::Energy,
                    3 => V::Force(item, component),
                    4 => V::Displacement(item, component),
                    5 => V::Velocity(item, component),
                    6 => V::Pattern(at),
                    7 => V::Probe(at),
                    8 => V::ProbeVelocity(at),
                    9 => V::Parameter(at),
                    10 => V::VonMises(at),
                    11 => V::ReactionForce(item, component),
                    12 => V::ReactionMoment(item, component),
                    13 => V::BodyForce(at),
                    14 => V::BodyPosition(at),
                    15 => V::BodyAttitude(at),
                    16 => V::BodyVelocity(at),
                    17 => V::BodySpin(at),
                    18 => V::Total(at),
                    19 => V::Whole(at),
                    20 => V::SurfaceNodes,
                    21 => V::SurfacePosition,
                    22 => V::SurfaceForce,
                    23 => V::SurfaceDisplacement,
                    _ => V::SurfaceVelocity,
                });
            };
            at = beyond;
        }
        None
    }

    /// The variables of references with so many surface nodes in use, arrays row by row; references of
    /// anything else than numbers are left out.
    pub fn elements(self, references: &[u32], nodes: u32) -> Elements<'_> {
        let (array, rest) = (Variable::Time, references.iter());
        Elements { known: self, nodes, rest, array, at: 0, length: 0, has_unknown: false }
    }
}

/// Iterator of [`References::elements`].
#[derive(Clone, Debug)]
pub struct Elements<'r> {
    known: References,
    nodes: u32,
    rest: core::slice::Iter<'r, u32>,
    /// The array whose elements are next, the next one, and their number.
    array: Variable,
    at: u32,
    length: u32,
    /// True if a reference was left out.
    has_unknown: bool,
}

impl Elements<'_> {
    /// True at the end, if no reference was left out.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        !self.has_unknown && self.at >= self.length && self.rest.len() == 0
    }
}

impl Iterator for Elements<'_> {
    type Item = Variable;

    fn next(&mut self) -> Option<Variable> {
        while self.at >= self.length {
            let variable = self.known.variable(*self.rest.next()?);
            let Some(variable) = variable.filter(Variable::is_number) else {
                self.has_unknown = true;
                continue;
            };
            if !variable.is_array() {
                return Some(variable);
            }
            (self.array, self.at, self.length) = (variable, 0, variable.length(self.nodes));
        }
        let element = self.array.element(self.known.points, self.at);
        self.at += 1;
        Some(element)
    }
}

#[cfg(test)]
mod tests {
    use super::{Counts, Quantity, Variable as V};

    #[test]
    fn references_follow_each_other() {
        let (stresses, supports, free, exact) = (1, 2, 1, 1);
        let (points, patterns, probes, parameters) = (2, 1, 2, 1);
        let linear = false;
        let counts = Counts {
            points,
            patterns,
            probes,
            parameters,
            stresses,
            surface: 7,
            supports,
            free,
            exact,
            linear,
        };
        let all: Vec<V> = counts.all().collect();
        assert_eq!(
            all.len(),
            3 + 3 * 6 + 1 + 2 * 2 + 1 + 1 + 2 * 6 + 4 * 3 + 4 + V::totals().count() + 4 + 5
        );
        assert_eq!(all[..5], [V::Time, V::Step, V::Energy, V::Force(0, 0), V::Force(0, 1)]);
        assert_eq!(all[8..10], [V::Force(1, 2), V::Displacement(0, 0)]);
        let tail = [V::Velocity(1, 2), V::Pattern(0), V::Probe(0), V::Probe(1), V::ProbeVelocity(0)];
        assert_eq!(all[20..25], tail);
        assert_eq!(all[25..28], [V::ProbeVelocity(1), V::Parameter(0), V::VonMises(0)]);
        assert_eq!(all[33..35], [V::ReactionForce(1, 2), V::ReactionMoment(0, 0)]);
        assert_eq!(all[49..51], [V::BodyAttitude(3), V::BodyVelocity(0)]);
        assert_eq!(all[55..58], [V::BodySpin(2), V::Total(0), V::Total(1)]);
        assert_eq!(Some(V::Total(1).kind().0), V::total(1).map(Quantity::name));
        assert_eq!(all[all.len() - 6..all.len() - 4], [V::Whole(3), V::SurfaceNodes]);
        assert_eq!(all.last(), Some(&V::SurfaceVelocity));
        assert_eq!((V::SurfaceForce.length(7), V::Energy.length(7)), (21, 1));
        assert_eq!(V::SurfaceForce.element(2, 20), V::Force(8, 2));
        assert_eq!(V::Force(8, 2).in_array(2), Some((V::SurfaceForce, 6, 2)));
        assert_eq!((V::Force(1, 2).in_array(2), V::Energy.element(2, 0)), (None, V::Energy));
        assert_eq!(counts.variable(all.len() as u32), None);
        assert_eq!(Counts::default().all().count(), 3 + V::totals().count());
    }
}
