//! Joints between ports, and their rows.

use crate::assembly::error::{AssemblyError, JointFault};
use crate::assembly::part::{Part, SPACE, extent};
use crate::assembly::port::Port;
use crate::assembly::rows::RowWriter;
use crate::assembly::text::at_dot;
use crate::base::vec3::{add, dot, minus};
use vademecum_format::PortKind;

/// Distance of ports that meet, as a share of the size of the larger one, or of that of the parts.
const NEAR: f64 = 1e-3;

/// A port of a part, both counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct End {
    /// The part.
    pub part: usize,
    /// The port.
    pub port: usize,
}

impl End {
    /// The port `part.port` of these parts.
    #[must_use]
    pub fn find(parts: &[Part<'_>], name: &str) -> Option<Self> {
        let (part, port) = at_dot(name)?;
        let part = parts.iter().position(|other| other.name == part)?;
        Some(Self { part, port: parts.get(part)?.port(port)? })
    }
}

/// Kind of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Weld,
    Bushing,
    Spring,
    Hinge,
    Ball,
    Slider,
}

/// Offsets of the rows of a joint, whose gap is then not zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Offset<'a> {
    /// None.
    None,
    /// Of each row \[m, rad\].
    Of(&'a [f64]),
    /// The gap at the instant of joining.
    AsItStands,
}

/// A joint between two ports, or between a port and the ground.
///
/// The second end is an [`End`], or `None` for the ground. Displacements and angles are small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint<'a> {
    kind: Kind,
    first: End,
    second: Option<End>,
    stiffness: &'a [f64],
    distance: Option<f64>,
    pub(crate) offset: Offset<'a>,
}

/// A row of a joint, as its first port has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowPlace {
    /// Node of a patch.
    pub node: usize,
    /// Direction in space.
    pub along: [f64; 3],
    /// True of a rotation about the direction.
    pub turns: bool,
    /// Compliance; 0 of a row that holds.
    pub compliance: f64,
}

impl<'a> Joint<'a> {
    const fn new(kind: Kind, first: End, second: Option<End>, stiffness: &'a [f64]) -> Self {
        Self { kind, first, second, stiffness, distance: None, offset: Offset::None }
    }

    /// All motions: each node of the first patch follows the facets of the second, or six motions of frames.
    pub fn weld(first: End, second: impl Into<Option<End>>) -> Self {
        Self::new(Kind::Weld, first, second.into(), &[])
    }

    /// Springs \[N/m, N m\] along three axes of space for each node of the first patch, or along and about
    /// the axes of the first frame. A stiffness of 0 leaves its motion free.
    pub fn bushing(first: End, second: impl Into<Option<End>>, stiffness: &'a [f64]) -> Self {
        Self::new(Kind::Bushing, first, second.into(), stiffness)
    }

    /// A spring along the line between the origins of two frames: one stiffness \[N/m\].
    pub fn spring(first: End, second: impl Into<Option<End>>, stiffness: &'a [f64]) -> Self {
        Self::new(Kind::Spring, first, second.into(), stiffness)
    }

    /// All motions of frames but the rotation about the third axis of the first one.
    pub fn hinge(first: End, second: impl Into<Option<End>>) -> Self {
        Self::new(Kind::Hinge, first, second.into(), &[])
    }

    /// The displacement of frames.
    pub fn ball(first: End, second: impl Into<Option<End>>) -> Self {
        Self::new(Kind::Ball, first, second.into(), &[])
    }

    /// All motions of frames but the displacement along the third axis of the first one.
    pub fn slider(first: End, second: impl Into<Option<End>>) -> Self {
        Self::new(Kind::Slider, first, second.into(), &[])
    }

    /// With another largest distance between its ports \[m\] than a thousandth of their size.
    #[must_use]
    pub const fn within(self, distance: f64) -> Self {
        Self { distance: Some(distance), ..self }
    }

    /// Made at the displacements that its ports have against each other at the instant of joining, which are
    /// those of the states that the options give. Such joints come after all others.
    #[must_use]
    pub const fn as_it_stands(self) -> Self {
        Self { offset: Offset::AsItStands, ..self }
    }

    /// Made at these displacements of its rows \[m, rad\], those of
    /// [`Assembly::offsets`](crate::Assembly::offsets) of an assembly that had this joint before.
    #[must_use]
    pub const fn at(self, offsets: &'a [f64]) -> Self {
        Self { offset: Offset::Of(offsets), ..self }
    }

    /// Its first end.
    #[must_use]
    pub const fn first(&self) -> End {
        self.first
    }

    /// Its second end; `None` of the ground.
    #[must_use]
    pub const fn second(&self) -> Option<End> {
        self.second
    }

    /// Its ports.
    pub(crate) fn ports<'p>(&self, parts: &'p [Part<'p>]) -> Result<Sides<'p>, JointFault> {
        let side = |end: End| {
            let part = parts.get(end.part);
            let found =
                part.and_then(|part| Some(Side { index: end.part, part, port: part.ports.get(end.port)? }));
            found.ok_or(JointFault::NoPort { part: end.part, port: end.port })
        };
        let (first, second) = (side(self.first)?, self.second.map(side).transpose()?);
        if second.as_ref().is_some_and(|second| second.port.kind != first.port.kind) {
            return Err(JointFault::Mixed);
        }
        if first.port.kind == PortKind::Patch && !matches!(self.kind, Kind::Weld | Kind::Bushing) {
            return Err(JointFault::OfPatches);
        }
        let axes = first.port.placed_axes(&first.part.pose);
        Ok(Sides { first, second, axes })
    }

    /// Compliance of a motion; `None` of one that is left free.
    fn compliance(&self, motion: usize) -> Option<f64> {
        match self.kind {
            Kind::Bushing | Kind::Spring => self.stiffness.get(motion).filter(|k| **k > 0.0).map(|k| 1.0 / k),
            _ => Some(0.0),
        }
    }

    fn check_stiffness(&self, expected: usize) -> Result<(), JointFault> {
        if !matches!(self.kind, Kind::Bushing | Kind::Spring) {
            return Ok(());
        }
        let found = self.stiffness.len();
        let sound = self.stiffness.iter().all(|k| *k >= 0.0 && k.is_finite());
        let some = self.stiffness.iter().any(|k| *k > 0.0);
        if found == expected && sound && some {
            Ok(())
        } else {
            Err(JointFault::Stiffness { found, expected })
        }
    }

    /// Its rows in turn.
    pub(crate) fn each_row(
        &self,
        sides: &Sides<'_>,
        mut with: impl FnMut(RowPlace),
    ) -> Result<(), JointFault> {
        let port = &sides.first.port;
        if port.kind == PortKind::Patch {
            self.check_stiffness(3)?;
            for node in 0..port.count {
                for (motion, along) in SPACE.into_iter().enumerate() {
                    let Some(compliance) = self.compliance(motion) else { continue };
                    with(RowPlace { node, along, turns: false, compliance });
                }
            }
            return Ok(());
        }
        let held: &[usize] = match self.kind {
            Kind::Spring => {
                self.check_stiffness(1)?;
                let apart = sides.apart();
                let distance = length(apart);
                if distance == 0.0 {
                    return Err(JointFault::OnePlace);
                }
                if let Some(compliance) = self.compliance(0) {
                    let along = apart.map(|x| x / distance);
                    with(RowPlace { node: 0, along, turns: false, compliance });
                }
                return Ok(());
            }
            Kind::Hinge => &[0, 1, 2, 3, 4],
            Kind::Ball => &[0, 1, 2],
            Kind::Slider => &[0, 1, 3, 4, 5],
            Kind::Weld | Kind::Bushing => &[0, 1, 2, 3, 4, 5],
        };
        self.check_stiffness(6)?;
        for &motion in held {
            let axis = sides.axes.get(motion % 3).copied().unwrap_or_default();
            let Some(compliance) = self.compliance(motion) else { continue };
            with(RowPlace { node: 0, along: axis, turns: motion >= 3, compliance });
        }
        Ok(())
    }

    /// Number of its rows.
    ///
    /// # Errors
    /// [`JointFault`].
    pub fn n_rows(&self, parts: &[Part<'_>]) -> Result<usize, JointFault> {
        let mut count = 0;
        self.each_row(&self.ports(parts)?, |_| count += 1)?;
        Ok(count)
    }

    /// Writes its rows, and gives the largest distance between its ports \[m\].
    pub(crate) fn write(&self, parts: &[Part<'_>], rows: &mut RowWriter<'_>) -> Result<f64, JointFault> {
        let sides = self.ports(parts)?;
        if sides.first.port.kind == PortKind::Patch {
            return self.write_patches(&sides, rows);
        }
        self.each_row(&sides, |place| {
            rows.begin(place.compliance);
            sides.first.terms(&place, 1.0, rows);
            if let Some(second) = &sides.second {
                second.terms(&place, -1.0, rows);
            }
        })?;
        let apart = sides.apart();
        let distance = length(apart);
        let off = match (self.kind, sides.axes) {
            // A slider may be anywhere on its axis, a spring anywhere.
            (Kind::Spring, _) => return Ok(distance),
            (Kind::Slider, [.., axis]) => length(add(apart, -dot(apart, axis), axis)),
            _ => distance,
        };
        let others = sides.second.iter().map(|second| second.part.extent());
        let usual = NEAR * others.fold(sides.first.part.extent(), f64::max);
        self.meets(true, off, usual)?;
        Ok(distance)
    }

    /// Each node of the first patch follows the facets of the second.
    fn write_patches(&self, sides: &Sides<'_>, rows: &mut RowWriter<'_>) -> Result<f64, JointFault> {
        let (first, mut distance) = (&sides.first, 0.0f64);
        let mut current = usize::MAX;
        let mut nearest = None;
        self.each_row(sides, |place| {
            if let Some(second) = sides.second.as_ref().filter(|_| place.node != current) {
                current = place.node;
                let point = first.part.place(first.port.node(place.node));
                let at = |node: usize| second.part.place(second.port.node(node));
                nearest = second.port.nearest(point, at);
                distance = distance.max(nearest.map_or(f64::NAN, |(_, found)| found.distance));
            }
            rows.begin(place.compliance);
            first.terms(&place, 1.0, rows);
            let Some((second, (nodes, found))) = sides.second.as_ref().zip(nearest) else { return };
            for (node, weight) in nodes.into_iter().zip(found.weights) {
                if weight != 0.0 {
                    second.terms(&RowPlace { node, ..place }, -weight, rows);
                }
            }
        })?;
        let Some(second) = &sides.second else { return Ok(0.0) };
        if nearest.is_none() {
            return Err(JointFault::NoFacets);
        }
        let size = first.size().max(second.size());
        self.meets(false, distance, NEAR * size)?;
        Ok(distance)
    }

    /// Refuses ports that are farther apart than they may be.
    fn meets(&self, frames: bool, distance: f64, usual: f64) -> Result<(), JointFault> {
        let most = self.distance.unwrap_or(usual);
        if distance <= most { Ok(()) } else { Err(JointFault::Apart { frames, distance, most }) }
    }
}

/// A port of a joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side<'p> {
    index: usize,
    pub part: &'p Part<'p>,
    pub port: Port<'p>,
}

/// The ports of a joint, and the axes of the first one in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sides<'p> {
    pub first: Side<'p>,
    pub second: Option<Side<'p>>,
    axes: [[f64; 3]; 3],
}

impl Sides<'_> {
    /// From the origin of the first to that of the second.
    fn apart(&self) -> [f64; 3] {
        self.second.as_ref().map_or([0.0; 3], |second| minus(second.origin(), self.first.origin()))
    }
}

impl Side<'_> {
    /// Its origin in space.
    pub fn origin(&self) -> [f64; 3] {
        self.part.pose.place(self.port.origin)
    }

    /// Diagonal of the box around the nodes of a patch.
    fn size(&self) -> f64 {
        extent((0..self.port.count).map(|node| self.part.place(self.port.node(node))))
    }

    /// Terms of a row: the displacement of a node, or of the origin of a frame, or its rotation.
    fn terms(&self, place: &RowPlace, weight: f64, rows: &mut RowWriter<'_>) {
        // The rows of a patch are along the axes of its part.
        let axes = match self.port.kind {
            PortKind::Patch => SPACE.map(|axis| self.part.pose.turn(axis)),
            PortKind::Frame => self.port.placed_axes(&self.part.pose),
        };
        let motion = if place.turns { 3 } else { 0 };
        let first = self.port.first + 3 * place.node + motion;
        for (k, axis) in axes.into_iter().enumerate() {
            rows.term(self.index, first + k, weight * dot(axis, place.along));
        }
    }
}

fn length(x: [f64; 3]) -> f64 {
    libm::sqrt(dot(x, x))
}

/// The fault of a joint, with its number.
pub(crate) fn of_joint(joint: usize) -> impl Fn(JointFault) -> AssemblyError {
    move |fault| AssemblyError::Joint { joint, fault }
}
