//! Rows of joints, over the rows of the ports they join.

use vademecum_build::fem::{Facet, anchors};
use vademecum_build::linalg::unit;
use vademecum_build::linalg::vec3::{dot, norm, sub};
use vademecum_build::mesh::Mesh;
use vademecum_format::PortKind;

use crate::error::AssemblyError;
use crate::file::{AssemblyFile, GROUND, JointEntry, JointKind};
use crate::part::{Part, Port};

/// Distance of ports that meet, as a share of the size of the larger one, or of that of the parts.
const NEAR: f64 = 1e-3;

/// Largest number of rows of all joints, whose matrix is dense.
const MAX_ROWS: usize = 8192;

/// A row of a joint: `Σ weight · row` of parts is zero, or the compliance times the force of the joint.
pub(crate) struct JointRow {
    /// Its joint.
    pub joint: usize,
    /// Part, row of its ports, and weight.
    pub terms: Vec<(usize, usize, f64)>,
    /// Compliance \[m/N\]; 0 of rows that hold.
    pub compliance: f64,
}

/// A joint as a report names it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct JointReport {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: JointKind,
    /// The ports it joins.
    pub between: [String; 2],
    /// Number of its rows.
    pub rows: usize,
    /// Largest distance between the ports \[m\].
    pub distance: f64,
}

/// A port of a joint.
#[derive(Clone, Copy)]
struct Side<'p> {
    part: usize,
    port: &'p Port,
}

impl Side<'_> {
    /// Terms of the displacement of a node of a patch, or of the origin of a frame, along a direction.
    fn moved(
        &self,
        node: usize,
        along: [f64; 3],
        sign: f64,
    ) -> impl Iterator<Item = (usize, usize, f64)> + use<> {
        self.rows(3 * node, along, sign)
    }

    /// Terms of the rotation of a frame about a direction.
    fn turned(&self, about: [f64; 3], sign: f64) -> impl Iterator<Item = (usize, usize, f64)> + use<> {
        self.rows(3, about, sign)
    }

    fn rows(
        &self,
        first: usize,
        along: [f64; 3],
        sign: f64,
    ) -> impl Iterator<Item = (usize, usize, f64)> + use<> {
        let (part, first, axes) = (self.part, self.port.first + first, self.port.axes);
        let terms = (0..3).map(move |k| (part, first + k, sign * dot(axes[k], along)));
        terms.filter(|term| term.2 != 0.0)
    }
}

/// Directions of space.
const SPACE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Rows of all joints, and what is said of each joint.
///
/// # Errors
/// [`AssemblyError::File`]: ports that there are not, that do not fit the joint, or that do not meet.
pub(crate) fn joint_rows(
    file: &AssemblyFile,
    parts: &[Part<'_>],
) -> Result<(Vec<JointRow>, Vec<JointReport>), AssemblyError> {
    let (mut rows, mut reports) = (vec![], vec![]);
    for (index, entry) in file.joints.iter().enumerate() {
        let first = side(file, parts, index, 0)?;
        let second = match entry.between[1] == GROUND {
            true => None,
            false => Some(side(file, parts, index, 1)?),
        };
        let extent = [Some(first), second].into_iter().flatten();
        let extent = extent.map(|side| size(&parts[side.part].places)).fold(0.0, f64::max);
        let joint = Joint { file, index, entry, first, second, extent };
        let (own, distance) = joint.rows()?;
        reports.push(JointReport {
            name: entry.name(index),
            kind: entry.kind,
            between: entry.between.clone(),
            rows: own.len(),
            distance,
        });
        rows.extend(own);
        if rows.len() > MAX_ROWS {
            let expected = format!("at most {MAX_ROWS}: fewer nodes in the ports, or frames");
            return Err(file.refuse("joint", format!("{} rows of joints", rows.len()), expected).into());
        }
    }
    Ok((rows, reports))
}

/// The port that a joint names.
fn side<'p>(
    file: &AssemblyFile,
    parts: &'p [Part<'_>],
    index: usize,
    place: usize,
) -> Result<Side<'p>, AssemblyError> {
    let name = &file.joints[index].between[place];
    let known: Vec<String> = parts
        .iter()
        .flat_map(|part| part.ports.iter().map(move |port| format!("{}.{}", part.name, port.name)))
        .collect();
    let found = name.split_once('.').and_then(|(part, port)| {
        let part = parts.iter().position(|other| other.name == part)?;
        let port = parts[part].ports.iter().find(|other| other.name == port)?;
        Some(Side { part, port })
    });
    found.ok_or_else(|| {
        let expected = match known.is_empty() {
            true => "a port, `part.port`; no part has one: build it with `[[port]]`".to_string(),
            false => format!("a port, `part.port`, one of {}", known.join(", ")),
        };
        file.refuse(&format!("joint[{index}].between"), format!("`{name}`"), expected).into()
    })
}

struct Joint<'p> {
    file: &'p AssemblyFile,
    index: usize,
    entry: &'p JointEntry,
    first: Side<'p>,
    second: Option<Side<'p>>,
    /// Size of the larger part.
    extent: f64,
}

impl Joint<'_> {
    fn refused<T>(&self, key: &str, found: impl ToString, expected: &str) -> Result<T, AssemblyError> {
        Err(self.file.refuse(&format!("joint[{}].{key}", self.index), found, expected).into())
    }

    fn row(&self, terms: Vec<(usize, usize, f64)>, compliance: f64) -> JointRow {
        JointRow { joint: self.index, terms, compliance }
    }

    /// Its rows, and the largest distance between its ports.
    fn rows(&self) -> Result<(Vec<JointRow>, f64), AssemblyError> {
        let kinds = [Some(self.first.port.kind), self.second.map(|side| side.port.kind)];
        let patch = kinds[0] == Some(PortKind::Patch);
        if kinds[1].is_some() && kinds[0] != kinds[1] {
            return self.refused("between", "a patch and a frame", "two patches, or two frames");
        }
        if patch && !matches!(self.entry.kind, JointKind::Weld | JointKind::Bushing) {
            return self.refused(
                "kind",
                format!("`{}` of patches", self.entry.kind.word()),
                "`weld` or `bushing`; other joints are those of frames",
            );
        }
        if patch { self.of_patches() } else { self.of_frames() }
    }

    /// Compliances of a bushing, of which those without stiffness are none; of other joints zeros.
    fn compliances(&self, count: usize) -> Result<Vec<Option<f64>>, AssemblyError> {
        let Some(stiffness) = &self.entry.stiffness else { return Ok(vec![Some(0.0); count]) };
        if stiffness.len() != count {
            let expected = match count {
                1 => "one number, along the line between the frames",
                3 => "three numbers, along the axes of space, for each node of the first patch",
                _ => "six numbers, along and about the axes of the first frame",
            };
            return self.refused("stiffness", format!("a list of {}", stiffness.len()), expected);
        }
        Ok(stiffness.iter().map(|k| (*k > 0.0).then(|| k.recip())).collect())
    }

    /// Each node of the first patch follows the facets of the second.
    fn of_patches(&self) -> Result<(Vec<JointRow>, f64), AssemblyError> {
        let compliances = self.compliances(3)?;
        let first = self.first;
        let mut rows = vec![];
        let mut push = |node: usize, others: &[(usize, f64)]| {
            for (along, compliance) in SPACE.into_iter().zip(&compliances) {
                let Some(compliance) = compliance else { continue };
                let mut terms: Vec<_> = first.moved(node, along, 1.0).collect();
                for &(other, weight) in others {
                    terms.extend(self.second.iter().flat_map(|side| side.moved(other, along, -weight)));
                }
                rows.push(self.row(terms, *compliance));
            }
        };
        let nodes = &first.port.nodes;
        let Some(second) = self.second else {
            (0..nodes.len()).for_each(|node| push(node, &[]));
            return Ok((rows, 0.0));
        };
        let facets: Vec<Facet> = second.port.facets.iter().filter_map(|nodes| Facet::of(nodes)).collect();
        let mesh = Mesh::of_points(second.port.nodes.clone());
        let mut distance: f64 = 0.0;
        for (node, anchor) in anchors(&mesh, &facets, nodes).into_iter().enumerate() {
            let Some(anchor) = anchor else {
                return self.refused("between", "a patch without facets", "two patches of facets");
            };
            distance = distance.max(anchor.distance);
            let others: Vec<(usize, f64)> =
                anchor.weights.iter().map(|&(node, weight)| (node as usize, weight)).collect();
            push(node, &others);
        }
        let size = [first.port, second.port].into_iter().map(|port| size(&port.nodes)).fold(0.0, f64::max);
        self.meets(distance, NEAR * size, "patches")?;
        Ok((rows, distance))
    }

    /// Motions of two frames against each other, along and about the axes of the first.
    fn of_frames(&self) -> Result<(Vec<JointRow>, f64), AssemblyError> {
        let (first, axes) = (self.first, self.first.port.axes);
        let apart = self.second.map_or([0.0; 3], |second| sub(second.port.origin, first.port.origin));
        if self.entry.kind == JointKind::Spring {
            if norm(apart) == 0.0 {
                let expected = "two frames whose origins are apart; a `bushing` joins frames at one place";
                return self.refused("between", "frames at one place", expected);
            }
            let along = unit(apart);
            let [Some(compliance)] = self.compliances(1)?[..] else { return Ok((vec![], norm(apart))) };
            let ends = [(Some(first), 1.0), (self.second, -1.0)];
            let terms = ends
                .into_iter()
                .flat_map(|(side, sign)| side.into_iter().flat_map(move |side| side.moved(0, along, sign)));
            return Ok((vec![self.row(terms.collect(), compliance)], norm(apart)));
        }
        let held: &[usize] = match self.entry.kind {
            JointKind::Hinge => &[0, 1, 2, 3, 4],
            JointKind::Ball => &[0, 1, 2],
            JointKind::Slider => &[0, 1, 3, 4, 5],
            _ => &[0, 1, 2, 3, 4, 5],
        };
        let compliances = self.compliances(6)?;
        let mut rows = vec![];
        for &motion in held {
            let Some(compliance) = compliances[motion] else { continue };
            let axis = axes[motion % 3];
            let terms = |side: Side<'_>, sign: f64| -> Vec<_> {
                if motion < 3 {
                    side.moved(0, axis, sign).collect()
                } else {
                    side.turned(axis, sign).collect()
                }
            };
            let mut all = terms(first, 1.0);
            all.extend(self.second.iter().flat_map(|side| terms(*side, -1.0)));
            rows.push(self.row(all, compliance));
        }
        // A slider may stand anywhere on its axis.
        let along = dot(apart, axes[2]);
        let off = match self.entry.kind {
            JointKind::Slider => norm(std::array::from_fn(|c| apart[c] - along * axes[2][c])),
            _ => norm(apart),
        };
        self.meets(off, NEAR * self.extent, "origins of the frames")?;
        Ok((rows, norm(apart)))
    }

    /// Refuses ports that are farther apart than they may be.
    fn meets(&self, distance: f64, usual: f64, what: &str) -> Result<(), AssemblyError> {
        let most = self.entry.distance.unwrap_or(usual);
        if distance <= most {
            return Ok(());
        }
        let expected = format!(
            "{what} at most {most:.3e} m apart: check `position` and `rotation` of the parts, or set `distance`"
        );
        self.refused("between", format!("{what} {distance:.3e} m apart"), &expected)
    }
}

/// Diagonal of the box around points.
fn size(points: &[[f64; 3]]) -> f64 {
    let end = |pick: fn(f64, f64) -> f64, start: f64| -> [f64; 3] {
        std::array::from_fn(|c| points.iter().map(|x| x[c]).fold(start, pick))
    };
    let extent = sub(end(f64::max, f64::NEG_INFINITY), end(f64::min, f64::INFINITY));
    if points.is_empty() { 0.0 } else { norm(extent) }
}
