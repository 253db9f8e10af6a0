//! Checks of ports, and of the keys that they exclude.

use super::check::{Words, perpendicular};
use super::{PortKind, Problem, ProblemError};

/// Largest number of ports of a body.
const MAX_PORTS: usize = 1000;

impl Problem {
    /// Ports, and what they exclude.
    pub(super) fn check_ports(&self) -> Result<(), ProblemError> {
        if self.ports.is_empty() {
            return Ok(());
        }
        self.require(self.ports.len() <= MAX_PORTS, "port", self.ports.len(), "at most 1000 ports")?;
        for (i, port) in self.ports.iter().enumerate() {
            let key = |name: &str| format!("port[{i}].{name}");
            let twice = self.ports[..i].iter().any(|other| other.name == port.name);
            let name = !port.name.is_empty() && !port.name.contains(['\n', ',', '"']) && !twice;
            let expected = "a name of one line without comma and quotation mark that no other port has";
            self.require(name, &key("name"), &port.name, expected)?;
            let frame = port.kind == PortKind::Frame;
            if let Some(reference) = &port.reference {
                self.require(frame, &key("reference"), reference, "none, or `kind = \"frame\"`")?;
                self.named_point(&key("reference"), reference)?;
                let expected = "a point that a coupling, an equation, a spring, a mass or `held` moves";
                self.require(self.moves(reference), &key("reference"), reference, expected)?;
            }
            let one = port.on.is_some() != port.reference.is_some();
            let found = Words(if port.on.is_some() { "beside `reference`" } else { "no nodes" });
            self.require(
                one,
                &key("on"),
                found,
                "the nodes of the port by `on`, or the `reference` of a frame",
            )?;
            let own = frame && port.on.is_some();
            self.require(
                own || port.at.is_none(),
                &key("at"),
                Words("given"),
                "the place of a frame of nodes",
            )?;
            if let Some(axes) = port.axes {
                let sound = frame && perpendicular(axes);
                self.require(sound, &key("axes"), axes, "two perpendicular directions, of a frame")?;
            }
        }
        let found = if self.mesh.matrices.is_some() {
            Some("beside `mesh.matrices`, which have no facets")
        } else if self.is_large() {
            Some("beside `model = \"large-displacement\"`")
        } else if self.is_parametric() {
            None
        } else {
            self.without_exact_modes()
        };
        let expected = "natural modes of a linear body that are moved exactly";
        self.require(found.is_none(), "port", Words(found.unwrap_or_default()), expected)
    }
}
