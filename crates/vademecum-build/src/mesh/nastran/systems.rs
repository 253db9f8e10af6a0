//! Coordinate systems of Nastran models: rectangular, cylindrical and spherical, nested in each other.

use std::collections::{HashMap, HashSet};

use super::cards::{Card, Cards};
use super::points::{GridPoint, grid_points};
use crate::linalg::vec3::{cross, dot, norm, sub};
use crate::mesh::error::MeshError;

/// Kind of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Coordinates {
    Rectangular,
    Cylindrical,
    Spherical,
}

/// A coordinate system in the basic one.
#[derive(Clone, Copy, Debug)]
struct Frame {
    kind: Coordinates,
    origin: [f64; 3],
    /// Unit vectors of its rectangular coordinates, as rows.
    axes: [[f64; 3]; 3],
}

const BASIC: Frame = Frame {
    kind: Coordinates::Rectangular,
    origin: [0.0; 3],
    axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
};

/// The coordinate systems of a model, by their numbers; 0 is the basic one.
#[derive(Clone, Debug, Default)]
pub struct Systems {
    frames: HashMap<u64, Frame>,
}

impl Systems {
    /// A point of a system in basic coordinates; none if there is no such system. Angles are in degrees: r,
    /// θ, z of a cylindrical system; r, θ from the z axis, φ about it of a spherical one.
    pub fn point(&self, system: u64, coordinates: [f64; 3]) -> Option<[f64; 3]> {
        Some(self.frame(system)?.point(coordinates))
    }

    /// Unit vectors of a system's coordinates at a point in basic coordinates, one a row; none if there is no
    /// such system. On the axis of a cylinder or sphere the first one is that of angle 0.
    pub fn axes(&self, system: u64, at: [f64; 3]) -> Option<[[f64; 3]; 3]> {
        Some(self.frame(system)?.axes_at(at))
    }

    /// True of a system whose axes are the same everywhere.
    pub fn is_rectangular(&self, system: u64) -> bool {
        self.frame(system).is_some_and(|frame| matches!(frame.kind, Coordinates::Rectangular))
    }

    /// A point and the direction of the line of a cylindrical system; none of other systems.
    pub fn cylinder(&self, system: u64) -> Option<([f64; 3], [f64; 3])> {
        let frame = self.frame(system)?;
        matches!(frame.kind, Coordinates::Cylindrical).then_some((frame.origin, frame.axes[2]))
    }

    fn frame(&self, system: u64) -> Option<&Frame> {
        if system == 0 { Some(&BASIC) } else { self.frames.get(&system) }
    }
}

/// The coordinate systems that a model defines.
///
/// # Errors
/// [`MeshError`] with file and line if a card is malformed, names a system or point that the model does not
/// define, or if systems stand on each other in a circle.
pub fn systems(cards: &Cards) -> Result<Systems, MeshError> {
    systems_of(cards, &grid_points(cards)?)
}

/// The same with the grid points at hand.
pub(crate) fn systems_of(cards: &Cards, points: &[GridPoint]) -> Result<Systems, MeshError> {
    let mut definitions = HashMap::new();
    let mut order = Vec::new();
    for card in &cards.bulk {
        for (id, definition) in definitions_on(card)? {
            if id == 0 || definitions.insert(id, definition).is_some() {
                let found = format!("coordinate system {id} a second time");
                return Err(card.malformed(found, "every number above 0 once"));
            }
            order.push(id);
        }
    }
    if definitions.is_empty() {
        return Ok(Systems::default());
    }
    let points = points.iter().map(|point| (point.id, (point.system, point.position))).collect();
    let mut solver = FrameSolver { definitions, points, found: Systems::default() };
    for id in order {
        solver.solve(id)?;
    }
    Ok(solver.found)
}

/// A card that defines a system.
struct Definition<'a> {
    card: &'a Card,
    kind: Coordinates,
    by: Points,
}

/// Origin, a point of the z axis, and a point of the xz plane.
enum Points {
    /// In another system.
    In(u64, [[f64; 3]; 3]),
    /// Three grid points.
    Grids([u64; 3]),
}

/// The systems on a card: one or two; none on cards of other kinds.
fn definitions_on(card: &Card) -> Result<Vec<(u64, Definition<'_>)>, MeshError> {
    let kind = match card.name.as_str() {
        "CORD1R" | "CORD2R" => Coordinates::Rectangular,
        "CORD1C" | "CORD2C" => Coordinates::Cylindrical,
        "CORD1S" | "CORD2S" => Coordinates::Spherical,
        _ => return Ok(vec![]),
    };
    let number = |field: usize| -> Result<u64, MeshError> {
        let fault = || card.malformed(format!("nothing in its field {}", field + 2), "a whole number");
        card.id(field)?.ok_or_else(fault)
    };
    if card.name.starts_with("CORD2") {
        let mut points = [[0.0; 3]; 3];
        for (k, x) in points.as_flattened_mut().iter_mut().enumerate() {
            *x = card.real(2 + k)?.unwrap_or(0.0);
        }
        let by = Points::In(card.id(1)?.unwrap_or(0), points);
        return Ok(vec![(number(0)?, Definition { card, kind, by })]);
    }
    let mut found = Vec::new();
    for first in [0, 4].into_iter().filter(|&first| first == 0 || !card.field(first).is_empty()) {
        let by = Points::Grids([number(first + 1)?, number(first + 2)?, number(first + 3)?]);
        found.push((number(first)?, Definition { card, kind, by }));
    }
    Ok(found)
}

struct FrameSolver<'a> {
    definitions: HashMap<u64, Definition<'a>>,
    /// System and position of grid points.
    points: HashMap<u64, (u64, [f64; 3])>,
    found: Systems,
}

impl FrameSolver<'_> {
    /// Finds a system after those it stands on, without recursion: chains may be as long as the file.
    fn solve(&mut self, id: u64) -> Result<(), MeshError> {
        if self.found.frame(id).is_some() {
            return Ok(());
        }
        let mut path = vec![id];
        let mut open = HashSet::from([id]);
        while let Some(&top) = path.last() {
            let Some(definition) = self.definitions.get(&top) else { break };
            let points = self.points_of(definition)?;
            let below = points.iter().map(|(system, _)| *system).find(|&s| self.found.frame(s).is_none());
            if let Some(below) = below {
                let known = self.definitions.contains_key(&below);
                if !known || !open.insert(below) {
                    let found = format!("coordinate system {below}");
                    let expected = if known { "systems that form no circle" } else { DEFINED };
                    return Err(definition.card.malformed(found, expected));
                }
                path.push(below);
                continue;
            }
            let places = points.map(|(system, x)| self.found.point(system, x).unwrap_or_default());
            let Some(frame) = Frame::through(definition.kind, places) else {
                let found = format!("coordinate system {top} by three points on a line");
                return Err(definition.card.malformed(found, "an origin, a z axis and an xz plane"));
            };
            self.found.frames.insert(top, frame);
            open.remove(&top);
            path.pop();
        }
        Ok(())
    }

    /// System and position of the three points of a definition.
    fn points_of(&self, definition: &Definition<'_>) -> Result<[(u64, [f64; 3]); 3], MeshError> {
        match &definition.by {
            Points::In(system, points) => Ok(points.map(|point| (*system, point))),
            Points::Grids(ids) => {
                let mut points = [(0, [0.0; 3]); 3];
                for (point, id) in points.iter_mut().zip(ids) {
                    let fault = || definition.card.malformed(format!("GRID {id}"), "a point of the model");
                    *point = *self.points.get(id).ok_or_else(fault)?;
                }
                Ok(points)
            }
        }
    }
}

/// Expected where a system is missing.
pub(crate) const DEFINED: &str = "a system that the model defines by CORD1R, CORD2R, CORD1C, CORD2C, CORD1S \
                                  or CORD2S";

impl Frame {
    /// The frame with this origin, through a point of its z axis and one of its xz plane; none of three
    /// points on a line.
    fn through(kind: Coordinates, [origin, on_axis, on_plane]: [[f64; 3]; 3]) -> Option<Self> {
        let z = unit(sub(on_axis, origin))?;
        let side = sub(on_plane, origin);
        // A plane within rounding of the axis has no direction.
        let y = cross(z, side);
        let y = unit(y).filter(|_| norm(y) > 1e-12 * norm(side))?;
        Some(Self { kind, origin, axes: [cross(y, z), y, z] })
    }

    fn point(&self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        let local = match self.kind {
            Coordinates::Rectangular => [a, b, c],
            Coordinates::Cylindrical => {
                let (sin, cos) = sin_cos(b);
                [a * cos, a * sin, c]
            }
            Coordinates::Spherical => {
                let ((sin, cos), (sin_phi, cos_phi)) = (sin_cos(b), sin_cos(c));
                [a * sin * cos_phi, a * sin * sin_phi, a * cos]
            }
        };
        combined(&self.axes, local, self.origin)
    }

    fn axes_at(&self, at: [f64; 3]) -> [[f64; 3]; 3] {
        let local = self.axes.map(|axis| dot(axis, sub(at, self.origin)));
        let radius = local[0].hypot(local[1]);
        let (cos, sin) = if radius > 0.0 { (local[0] / radius, local[1] / radius) } else { (1.0, 0.0) };
        let rows = match self.kind {
            Coordinates::Rectangular => return self.axes,
            Coordinates::Cylindrical => [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]],
            Coordinates::Spherical => {
                let distance = radius.hypot(local[2]);
                let (down, out) =
                    if distance > 0.0 { (local[2] / distance, radius / distance) } else { (1.0, 0.0) };
                [[out * cos, out * sin, down], [down * cos, down * sin, -out], [-sin, cos, 0.0]]
            }
        };
        rows.map(|row| combined(&self.axes, row, [0.0; 3]))
    }
}

/// Sine and cosine of an angle in degrees, exact at right angles.
fn sin_cos(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => degrees.to_radians().sin_cos(),
    }
}

fn unit(vector: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(vector);
    Some(vector.map(|x| x / length)).filter(|_| length > 0.0 && length.is_finite())
}

/// The sum of the rows with these factors, and an offset.
fn combined(rows: &[[f64; 3]; 3], factors: [f64; 3], offset: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| offset[k] + (0..3).map(|i| factors[i] * rows[i][k]).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::cards::cards;
    use super::*;

    fn read(text: &str) -> Result<Systems, MeshError> {
        systems(&cards(Path::new("a.bdf"), text.as_bytes())?)
    }

    fn near(found: Option<[f64; 3]>, expected: [f64; 3]) {
        let found = found.unwrap();
        assert!(norm(sub(found, expected)) < 1e-12, "{found:?} is not {expected:?}");
    }

    #[test]
    fn systems_stand_on_systems_and_points() {
        // 1: moved by x = 1, its z along the basic x and its x along the basic y. 2: cylinder in 1. 3:
        // sphere. 4, 5: rectangular through points of the cylinder.
        let text = "CORD2C,2,1,0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.\n\
                    CORD2R,1,,1.,0.,0.,2.,0.,0.,+\n+,1.,1.,0.\n\
                    CORD2S,3,0,0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.\n\
                    GRID,10,2,1.,90.,0.\nGRID,11,2,1.,90.,5.\nGRID,12,2,2.,90.,0.\n\
                    CORD1R,4,10,11,12,5,10,12,11\n";
        let systems = read(text).unwrap();
        near(systems.point(0, [1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        near(systems.point(1, [1.0, 2.0, 3.0]), [4.0, 1.0, 2.0]);
        near(systems.point(2, [2.0, 90.0, 3.0]), [4.0, 0.0, 2.0]);
        near(systems.point(2, [2.0, 30.0, 0.0]), [1.0, 3f64.sqrt(), 1.0]);
        near(systems.point(3, [2.0, 90.0, 90.0]), [0.0, 2.0, 0.0]);
        near(systems.point(3, [2.0, 60.0, 0.0]), [3f64.sqrt(), 0.0, 1.0]);
        // Grid 10 lies at (1, 0, 1); z along the basic x, x along the basic z.
        near(systems.point(4, [1.0, 0.0, 0.0]), [1.0, 0.0, 2.0]);
        near(systems.point(4, [0.0, 0.0, 1.0]), [2.0, 0.0, 1.0]);
        near(systems.point(5, [1.0, 0.0, 0.0]), [2.0, 0.0, 1.0]);
        assert_eq!(systems.point(6, [0.0; 3]), None);
        assert_eq!(systems.axes(6, [0.0; 3]), None);
        let axes = systems.axes(2, [7.0, 0.0, 3.0]).unwrap();
        near(Some(axes[0]), [0.0, 0.0, 1.0]);
        near(Some(axes[1]), [0.0, -1.0, 0.0]);
        near(Some(axes[2]), [1.0, 0.0, 0.0]);
        let axes = systems.axes(3, [0.0, 2.0, 0.0]).unwrap();
        near(Some(axes[0]), [0.0, 1.0, 0.0]);
        near(Some(axes[1]), [0.0, 0.0, -1.0]);
        near(Some(axes[2]), [-1.0, 0.0, 0.0]);
        near(Some(systems.axes(3, [0.0; 3]).unwrap()[0]), [0.0, 0.0, 1.0]);
        near(Some(systems.axes(1, [9.0; 3]).unwrap()[0]), [0.0, 1.0, 0.0]);
        near(Some(systems.axes(0, [9.0; 3]).unwrap()[1]), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn circles_and_missing_systems_are_refused() {
        let rest = "0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.\n";
        let cases = [
            (format!("CORD2R,1,2,{rest}CORD2R,2,1,{rest}"), "no circle"),
            (format!("CORD2R,1,1,{rest}"), "no circle"),
            (format!("CORD2R,1,7,{rest}"), "coordinate system 7"),
            (format!("CORD2R,1,,{rest}CORD2C,1,,{rest}"), "a second time"),
            ("CORD2R,1,,0.,0.,0.,0.,0.,1.,+\n+,0.,0.,2.\n".into(), "three points on a line"),
            ("CORD1R,1,1,2,3\nGRID,1\nGRID,2,,1.\n".into(), "GRID 3"),
            ("CORD1R,1,1,2,3\nGRID,1,1\nGRID,2,,1.\nGRID,3,,,1.\n".into(), "no circle"),
            ("CORD1R,1,1\n".into(), "field 4"),
        ];
        for (text, part) in cases {
            let said = read(&text).unwrap_err().to_string();
            assert!(said.contains(part), "{text}: {said}");
        }
        let mut chain: String = (1..5000).map(|i| format!("CORD2R,{},{},{rest}", i + 1, i)).collect();
        chain += &format!("CORD2R,1,,{rest}");
        near(read(&chain).unwrap().point(5000, [1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    }
}
