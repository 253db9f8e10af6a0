//! Bonds of the parts of a world: pairs that may touch, and joints.

use vademecum_eval::{Nodes, Pose, Touching, WorldJoint};
use vademecum_format::File;

use crate::entries::NodesEntry;
use crate::file::AssemblyFile;
use crate::world::error::WorldRunError;
use crate::world::joints::Joined;
use crate::world::overlap::{Skin, overlap};
use crate::world::parts::{PartSurface, ports};

/// Pairs that may touch, and joints.
pub(crate) struct Bonds {
    pub pairs: Vec<Touching>,
    pub joints: Vec<WorldJoint>,
}

/// Pairs and joints; parts that overlap are refused.
pub(crate) fn bonds(
    file: &AssemblyFile,
    opened: &[Option<File<'_>>],
    shapes: &[PartSurface],
) -> Result<Bonds, WorldRunError> {
    let skin = |part: usize| {
        let pose = Pose::new(file.parts[part].position, file.parts[part].rotation);
        let nodes = shapes[part].nodes.iter().map(|node| pose.place(*node)).collect();
        Skin { nodes, triangles: &shapes[part].triangles }
    };
    let mut pairs = vec![];
    for contact in &file.contacts {
        let members = contact.between.each_ref().map(|name| file.part(name).expect("was checked"));
        if let Some(depth) = overlap(&skin(members[0]), &skin(members[1])) {
            let [a, b] = &contact.between;
            let found = format!("`{a}` and `{b}`, which overlap by {depth:.3e} m at the start");
            let expected = "parts that are apart or touch";
            let key = format!("contact[{}].between", contact.entry);
            return Err(file.refuse(&key, found, expected).into());
        }
        let nodes = match contact.nodes {
            NodesEntry::Both => Nodes::Both,
            NodesEntry::First => Nodes::First,
            NodesEntry::Second => Nodes::Second,
        };
        let (friction, restitution) = (contact.friction, contact.restitution);
        pairs.push(Touching { members, friction, restitution, nodes });
    }
    let of_part = |opened: &Option<File<'_>>| opened.as_ref().map_or(Ok(vec![]), ports);
    let ports = opened.iter().map(of_part).collect::<Result<Vec<_>, _>>()?;
    let sizes: Vec<f64> = (0..shapes.len()).map(|part| skin(part).size()).collect();
    let joints = Joined { file, ports: &ports, sizes: &sizes }.joints()?;
    Ok(Bonds { pairs, joints })
}
