//! The text of a proposed problem file.

use std::fmt::Write as _;
use std::path::Path;

use vademecum_build::mesh::Mesh;

use super::known::KnownParts;
use super::materials::NamedMaterial;
use super::support::{Shape, Supports};
use super::toml::{one_line, quoted};

/// Error that is accepted of a compact body: a sudden push at one node of its surface rings in more modes
/// than a file should hold, and beside the support it moves little else.
const COMPACT_ERROR: f64 = 0.5;

/// Everything that the text is made of.
pub(super) struct Draft<'a> {
    /// The mesh file as the problem file names it.
    pub(super) mesh_name: &'a str,
    pub(super) mesh: &'a Mesh,
    pub(super) shape: &'a Shape<'a>,
    pub(super) material: NamedMaterial,
    /// Materials of a deck, in place of it.
    pub(super) known: Option<&'a KnownParts>,
    pub(super) scale: f64,
    /// True if mid-side nodes are added.
    pub(super) raised: bool,
    pub(super) cells: Option<u32>,
    /// Smallest share of the elements that a part must have, where parts are left out.
    pub(super) smallest_part: Option<f64>,
    pub(super) supports: &'a Supports,
}

impl Draft<'_> {
    pub(super) fn text(&self, time_step: f64, modes: usize, probes: &[([f64; 3], [f64; 3])]) -> String {
        let mut text = self.mesh_and_material();
        self.write_supports(&mut text);
        let NamedMaterial { name, damping, .. } = self.material;
        let sum_of_modes = self.known.is_some_and(|known| known.modes.is_some());
        let moves = self.known.is_some_and(|known| known.modes.is_some() || known.time_step.is_some());
        let damping = match self.known.and_then(|known| known.damping.as_deref()) {
            Some(lines) => format!("[damping]\n{}", lines.trim_end()),
            None if moves => {
                "# None, as the motion of the deck. `ratio = 0.01` gives each mode one.\n[damping]"
                    .to_string()
            }
            None => format!("[damping]\nratio = {damping:?} # of each mode; usual for parts of {name}"),
        };
        let precision = if sum_of_modes { "f64" } else { "f32" };
        let _ = write!(
            text,
            "# The whole surface can be loaded; `surface = {{ group = \"…\" }}` narrows it.\n[load]\n\n\
             {damping}\n\n\
             [time]\nstep = {time_step:?} # s; how often a load may change: steps are exact at any length\n\n\
             [basis]\nkind = \"modes\"\nmodes = {modes}\n\n[output]\nprecision = \"{precision}\"\n",
        );
        if self.cells.is_some() {
            let name = quoted(self.mesh_name);
            let _ = writeln!(text, "embedded = {name} # drawn in place of the surface of the tetrahedra");
        }
        if sum_of_modes {
            text += "# The deck sums so many modes; true adds what the others answer to a static load.\n\
                     residual = false\n";
        }
        if let Some(known) = self.known.filter(|known| !known.patterns.is_empty()) {
            text = text + "\n" + known.patterns.trim_end() + "\n";
        }
        text += self.known.map_or("", |known| &known.probes);
        if sum_of_modes {
            text += "\n# The sum of so many modes is taken as it is, whatever its error under other loads.\n\
                     [tolerance]\nerror = 1.0\n";
        } else if self.shape.long_axis().is_none() {
            let _ = write!(
                text,
                "\n# A sudden push at one node of a compact body excites more modes than these. `vademecum info` says\n\
                 # what was reached; without this key more than 5e-2 is refused.\n\
                 [tolerance]\nerror = {COMPACT_ERROR:?}\n"
            );
        }
        for (point, direction) in probes {
            let _ = write!(
                text,
                "\n# Where the first mode moves most, along its motion.\n\
                 [[output.probe]]\nname = \"most\"\npoint = {point:?}\ndirection = {direction:?}\n"
            );
        }
        text
    }

    fn mesh_and_material(&self) -> String {
        let Self { mesh_name, scale, .. } = self;
        let name = quoted(mesh_name);
        let title = Path::new(mesh_name).file_stem().map_or("body".into(), |s| s.to_string_lossy());
        let longest = self.shape.longest_side();
        let own_units = self.known.is_some_and(|known| known.own_units);
        let unit = match *scale {
            1.0 if own_units => "the units of the deck".to_string(),
            1.0 if self.known.is_some() => "the deck is in metres".to_string(),
            1.0 => "the longest side is taken to be in metres".to_string(),
            scale => {
                format!("metres in a unit of the mesh: {longest:.4} units become {:.4} m", longest * scale)
            }
        };
        let mut text = format!(
            "# Proposed by `vademecum init`: everything here can be changed. Keys: `vademecum help problem`\n\
             title = {}\n{}\n[mesh]\nfile = {name}\n",
            quoted(&title),
            if own_units { "units = \"those of the deck\"\n" } else { "" }
        );
        if let Some(cells) = self.cells {
            let _ = writeln!(
                text,
                "cells = {cells} # along the longest side; the surface is filled with tetrahedra"
            );
        }
        if self.raised {
            text +=
                "order = \"quadratic\" # the mesh has linear tetrahedra, which are too stiff in bending\n";
        }
        if let Some(smallest) = self.smallest_part {
            let _ = writeln!(
                text,
                "smallest_part = {smallest:?} # of the elements; smaller loose parts are left out"
            );
        }
        if let Some(known) = self.known {
            let _ = write!(text, "scale = {scale:?} # {unit}\n\n");
            for line in &known.comments {
                let _ = writeln!(text, "# {}", one_line(line));
            }
            return text + &known.materials + &known.attachments;
        }
        let m = &self.material;
        let _ = write!(
            text,
            "scale = {scale:?} # {unit}\n\n\
             # {}: {}\n[[material]]\nyoung = {:e} # Pa\npoisson = {:?}\ndensity = {:?} # kg/m³\n\n",
            m.name, m.source, m.young, m.poisson, m.density
        );
        text
    }

    fn write_supports(&self, text: &mut String) {
        let Supports { on, words, others } = self.supports;
        let groups: Vec<&str> = self.mesh.node_groups.keys().map(String::as_str).take(12).collect();
        if !groups.is_empty() {
            let _ = writeln!(text, "# Groups of the mesh: {}", one_line(&groups.join(", ")));
        }
        let _ = writeln!(text, "# Held: {words}");
        for on in on {
            let _ = writeln!(text, "[[support]]\non = {on}");
        }
        if !others.is_empty() {
            let _ = writeln!(text, "# Instead, or in addition:");
        }
        for other in others.iter().take(12) {
            let _ = writeln!(text, "# on = {{ group = {} }}", quoted(other));
        }
        text.push('\n');
    }
}
