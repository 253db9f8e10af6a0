//! Rows of the table of a world: positions, forces of pairs, energy.

use vademecum_build::linalg::vec3::dot;
use vademecum_eval::{Field, Member, OutputError, Place, Pose, Touch, Touching};

use crate::error::AssemblyError;
use crate::file::AssemblyFile;
use crate::world::overlap::Skin;
use crate::world::parts::{Bound, PartSurface};

/// A place whose position is shown.
pub(crate) enum Shown {
    /// Centre of a part that moves freely.
    Centre,
    /// Place of a body of a file, and its position at rest.
    Place(Place, [f64; 3]),
    /// Point of a rigid body, in its own coordinates.
    Point([f64; 3]),
}

/// The places of the outputs of a file.
pub(crate) fn outputs(
    file: &AssemblyFile,
    bound: &[Bound<'_>],
    shapes: &[PartSurface],
) -> Result<Vec<(usize, Shown)>, AssemblyError> {
    let each = file.outputs.iter().enumerate().map(|(i, output)| {
        let part = file.part(&output.part).expect("was checked");
        let key = format!("output[{i}].{}", if output.point.is_some() { "point" } else { "part" });
        let shown = match (&bound[part], output.point) {
            (Bound::Elastic(body, _), None) if body.motion().is_some() => Shown::Centre,
            (Bound::Rigid(shape), None) if shape.body().is_some() => Shown::Centre,
            (_, None) => {
                let found = format!("`{}` without `point`", output.part);
                let expected = "a `point`: the part does not move freely";
                return Err(file.refuse(&key, found, expected).into());
            }
            (Bound::Elastic(body, _), Some(point)) => {
                let located = body.locate(point).map_err(|error| {
                    let expected = "a point near the surface of the part, in its coordinates";
                    file.refuse(&key, format!("{} ({error})", crate::entries::listed(&point)), expected)
                })?;
                Shown::Place(located.place, located.position)
            }
            (Bound::Rigid(_), Some(point)) => {
                let PartSurface { nodes, triangles } = &shapes[part];
                Shown::Point(Skin { nodes: nodes.clone(), triangles }.nearest(point).1)
            }
        };
        Ok((part, shown))
    });
    each.collect()
}

/// Names of the columns of the table, with units.
pub(crate) fn columns(file: &AssemblyFile) -> Vec<String> {
    let mut columns = vec!["time_s".to_string(), "energy_J".to_string()];
    for output in &file.outputs {
        columns.extend(["x", "y", "z"].map(|axis| format!("{} {axis} [m]", output.name())));
    }
    for contact in file.contacts.iter().filter(|contact| !contact.is_meant) {
        let [a, b] = &contact.between;
        columns.extend(["x", "y", "z"].map(|axis| format!("force of {b} on {a} {axis} [N]")));
        columns.push(format!("contacts of {a} and {b}"));
    }
    columns
}

/// Position of a place in space \[m\].
pub(crate) fn position(member: &Member<'_, '_, f64>, shown: &Shown) -> Result<[f64; 3], OutputError> {
    Ok(match (member, shown) {
        (Member::Free(body), Shown::Place(place, _)) => body.in_space(place, Field::Displacement)?,
        (Member::Free(body), _) => body.motion().map_or([f64::NAN; 3], |motion| motion.position),
        (Member::Held(body, stand), Shown::Place(place, rest)) => {
            let moved = body.point(place, Field::Displacement)?;
            stand.place(std::array::from_fn(|k| rest[k] + moved[k]))
        }
        (Member::Rigid(shape), Shown::Point(point)) => {
            let motion = shape.motion();
            let centre = shape.body().map_or([0.0; 3], |body| body.centre);
            let arm = motion.to_space(std::array::from_fn(|k| point[k] - centre[k]));
            std::array::from_fn(|k| motion.position[k] + arm[k])
        }
        (Member::Rigid(shape), _) => shape.motion().position,
        (Member::Held(..), _) => [f64::NAN; 3],
    })
}

/// Adds force \[N\] on the first part and number of pressed contacts of each pair.
pub(crate) fn add_pairs(file: &AssemblyFile, pairs: &[Touching], touches: &[Touch], row: &mut Vec<f64>) {
    let named = pairs.iter().zip(&file.contacts).filter(|(_, contact)| !contact.is_meant);
    for (pair, _) in named {
        let (mut force, mut pressed) = ([0.0; 3], 0);
        for touch in touches {
            let [node, surface] = touch.members();
            let sign = match pair.members {
                [a, b] if [a, b] == [node, surface] => 1.0,
                [a, b] if [b, a] == [node, surface] => -1.0,
                _ => continue,
            };
            force.iter_mut().zip(touch.force()).for_each(|(sum, x)| *sum += sign * x);
            pressed += u32::from(touch.pressure() > 0.0);
        }
        row.extend(force);
        row.push(f64::from(pressed));
    }
}

/// Potential of gravity \[J\] of the members that move freely.
pub(crate) fn potential(members: &[Member<'_, '_, f64>], gravity: [f64; 3]) -> f64 {
    let of = |member: &Member<'_, '_, f64>| match member {
        Member::Free(body) => body
            .rigid_body()
            .zip(body.motion())
            .map_or(0.0, |(rigid, motion)| -rigid.mass * dot(gravity, motion.position)),
        Member::Rigid(shape) => {
            shape.body().map_or(0.0, |body| -body.mass * dot(gravity, shape.motion().position))
        }
        Member::Held(..) => 0.0,
    };
    members.iter().map(of).sum()
}

/// Nodes of the surface of a part in space.
pub(crate) fn nodes_of(
    member: &Member<'_, '_, f64>,
    shape: &PartSurface,
    out: &mut [[f64; 3]],
) -> Result<(), OutputError> {
    let moved = out.as_flattened_mut();
    moved.fill(0.0);
    let (position, attitude, centre) = match member {
        Member::Held(body, stand) => {
            body.surface_into(Field::Displacement, moved)?;
            (stand.position(), stand.attitude(), [0.0; 3])
        }
        Member::Free(body) => {
            body.surface_into(Field::Displacement, moved)?;
            let (rigid, motion) = body.rigid_body().zip(body.motion().copied()).expect("it flies");
            (motion.position, motion.attitude, rigid.centre)
        }
        Member::Rigid(shape) => {
            let centre = shape.body().map_or([0.0; 3], |body| body.centre);
            (shape.motion().position, shape.motion().attitude, centre)
        }
    };
    let pose = Pose::new(position, attitude);
    for (out, node) in out.iter_mut().zip(&shape.nodes) {
        *out = pose.place(std::array::from_fn(|k| node[k] - centre[k] + out[k]));
    }
    Ok(())
}
