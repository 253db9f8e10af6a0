//! The boundary nodes of a superelement as a table, for the modal assemblies of Chrono.

use std::fmt::Write as _;

use vademecum_build::superelement::FullOrder;

use super::body::ReducedBody;
use super::error::PortError;

/// Axes of space.
const SPACE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The table of boundary nodes, in the order of the rows of the matrices at full order, and these.
///
/// # Errors
/// [`PortError::NotForChrono`]: supports or attachments, an averaging frame, a frame of axes of its own.
pub fn chrono(body: &ReducedBody) -> Result<(String, &FullOrder), PortError> {
    let refused = |found: String| PortError::NotForChrono { found };
    let full = body.superelement.full_order.as_ref().filter(|_| body.is_bare_and_free());
    let full =
        full.ok_or_else(|| refused("a body with supports or attachments, or a vademecum file".into()))?;
    let mut text = String::from("kind,x,y,z,interface\n");
    for interface in &body.superelement.interfaces {
        let name = &interface.name;
        let mut row = |kind: &str, [x, y, z]: [f64; 3]| {
            writeln!(text, "{kind},{x:e},{y:e},{z:e},{name}").expect("writing to a string cannot fail");
        };
        match interface.kind {
            "rigid" if interface.axes == SPACE => row("frame", interface.origin),
            "rigid" => return Err(refused(format!("`{name}` with axes of its own"))),
            "patch" | "nodes" => {
                interface.nodes.iter().for_each(|&node| row("node", body.nodes[node as usize]));
            }
            kind => return Err(refused(format!("`{name}` of kind {kind}"))),
        }
    }
    Ok((text, full))
}
