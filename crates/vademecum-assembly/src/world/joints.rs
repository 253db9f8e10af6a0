//! Joints of a world, from the ports of an assembly file.

use vademecum_build::linalg::vec3::{dot, norm, sub};
use vademecum_eval::{Anchor, JointKind as Kind, WorldJoint};
use vademecum_format::PortKind;

use crate::error::AssemblyError;
use crate::file::{AssemblyFile, GROUND, JointKind};
use crate::world::parts::PortAt;
use vademecum_eval::Pose;

/// Distance of anchors that meet, as a share of the size of the larger part.
const NEAR: f64 = 1e-3;

/// Ports and sizes of the parts, for joints.
pub(crate) struct Joined<'a> {
    pub file: &'a AssemblyFile,
    /// Ports of each part; none of a rigid body.
    pub ports: &'a [Vec<PortAt>],
    /// Sizes of the parts \[m\].
    pub sizes: &'a [f64],
}

/// A side of a joint.
struct Side {
    member: usize,
    /// Number and place of a port; none of a rigid body and of the ground.
    port: Option<(usize, [[f64; 3]; 4])>,
}

impl Joined<'_> {
    /// The joints of the file; the ground is the member behind the parts.
    pub fn joints(&self) -> Result<Vec<WorldJoint>, AssemblyError> {
        (0..self.file.joints.len()).map(|index| self.joint(index)).collect()
    }

    fn joint(&self, index: usize) -> Result<WorldJoint, AssemblyError> {
        let entry = &self.file.joints[index];
        let key = |name: &str| format!("joint[{index}].{name}");
        let sides = [self.side(index, 0)?, self.side(index, 1)?];
        let members = [sides[0].member, sides[1].member];
        let between = format!("`{}` and `{}`", entry.between[0], entry.between[1]);
        if members[0] == members[1] {
            return Err(self.file.refuse(&key("between"), between, "ports of two parts").into());
        }
        let places = sides.each_ref().map(|side| side.port.map(|(_, frame)| frame[0]));
        let cable = entry.kind == JointKind::Cable;
        let other = if cable { None } else { places[0].or(places[1]) };
        let open = places.contains(&None);
        if !open && entry.at.is_some() {
            let expected = "no point: both sides are ports";
            return Err(self.file.refuse(&key("at"), "given", expected).into());
        }
        if cable && places == [None, None] {
            let expected = "a cable with a port on one side";
            return Err(self.file.refuse(&key("between"), between, expected).into());
        }
        let Some(point) = entry.at.or(other).or(if open { None } else { Some([0.0; 3]) }) else {
            let expected = "`at`, the point in space where the joint holds a rigid body or the ground";
            return Err(self.file.refuse(&key("between"), between, expected).into());
        };
        let [first, second] = places.map(|place| place.unwrap_or(point));
        let apart = sub(second, first);
        let larger = members.iter().filter_map(|member| self.sizes.get(*member)).copied().fold(0.0, f64::max);
        let allowed = entry.distance.unwrap_or(NEAR * larger);
        let distance = match entry.kind {
            JointKind::Slider => {
                let axis = self.third_axis(&sides[0]);
                let along = dot(apart, axis);
                norm(std::array::from_fn(|k| apart[k] - along * axis[k]))
            }
            _ => norm(apart),
        };
        if !cable && distance > allowed {
            let found = format!("{between}, {distance:.3e} m apart");
            let expected = format!("ports at most {allowed:.3e} m apart; `distance` allows more");
            return Err(self.file.refuse(&key("between"), found, expected).into());
        }
        let length = entry.length.unwrap_or(distance);
        if cable && length < distance - allowed {
            let found = format!("{length}, and its ends are {distance:.6} m apart at the start");
            let expected = "a length of at least that";
            return Err(self.file.refuse(&key("length"), found, expected).into());
        }
        let kind = match entry.kind {
            JointKind::Hinge => Kind::Hinge,
            JointKind::Slider => Kind::Slider,
            JointKind::Cable => Kind::Cable { length },
            _ => Kind::Ball,
        };
        let anchors = sides.map(|side| self.anchor(&side, point));
        let stiffness = entry.stiffness.as_ref().and_then(|all| all.first());
        Ok(WorldJoint {
            compliance: stiffness.map_or(0.0, |k| 1.0 / k),
            breaks_at: entry.breaks_at.unwrap_or(f64::INFINITY),
            ..WorldJoint::new(kind, members, anchors)
        })
    }

    fn side(&self, index: usize, place: usize) -> Result<Side, AssemblyError> {
        let name = &self.file.joints[index].between[place];
        if name == GROUND && place == 1 {
            return Ok(Side { member: self.file.parts.len(), port: None });
        }
        if let Some(member) = self.file.part(name).filter(|part| self.file.parts[*part].rigid.is_some()) {
            return Ok(Side { member, port: None });
        }
        let found = name.split_once('.').and_then(|(part, port)| {
            let member = self.file.part(part)?;
            let number = self.ports[member].iter().position(|other| other.name == port)?;
            Some((member, number))
        });
        let key = format!("joint[{index}].between");
        let Some((member, number)) = found else {
            let of_part = |(part, ports): (&crate::file::PartEntry, &Vec<PortAt>)| -> Vec<String> {
                ports.iter().map(|port| format!("{}.{}", part.name, port.name)).collect()
            };
            let known: Vec<String> = self.file.parts.iter().zip(self.ports).flat_map(of_part).collect();
            let expected = match known.is_empty() {
                true => "a port, `part.port`; no part has one: build it with `[[port]]`".to_string(),
                false => format!("a port, `part.port`, one of {}, or a rigid body", known.join(", ")),
            };
            return Err(self.file.refuse(&key, format!("`{name}`"), expected).into());
        };
        let port = &self.ports[member][number];
        if port.kind != PortKind::Frame {
            let found = format!("`{name}`, a patch");
            return Err(self.file.refuse(&key, found, "ports that are frames").into());
        }
        let pose = self.pose(member);
        let [origin, x, y, z] = port.frame;
        Ok(Side {
            member,
            port: Some((number, [pose.place(origin), pose.turn(x), pose.turn(y), pose.turn(z)])),
        })
    }

    fn pose(&self, member: usize) -> Pose {
        match self.file.parts.get(member) {
            Some(part) => Pose::new(part.position, part.rotation),
            None => Pose::new([0.0; 3], [1.0, 0.0, 0.0, 0.0]),
        }
    }

    fn third_axis(&self, side: &Side) -> [f64; 3] {
        side.port.map_or_else(|| self.pose(side.member).turn([0.0, 0.0, 1.0]), |(_, frame)| frame[3])
    }

    fn anchor(&self, side: &Side, point: [f64; 3]) -> Anchor {
        match side.port {
            Some((number, _)) => Anchor::Frame(number),
            None => {
                let pose = self.pose(side.member);
                let away = sub(point, pose.place([0.0; 3]));
                Anchor::point(pose.turn_back(away))
            }
        }
    }
}
