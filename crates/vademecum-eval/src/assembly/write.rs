//! Sections of the joined file, each written where it belongs.

use crate::assembly::counts::{Counts, GLUE, padded, spin_names, with_firsts};
use crate::assembly::damping::Damping;
use crate::assembly::inputs::Inputs;
use crate::assembly::part::{MOTIONS, Part};
use crate::assembly::residual::{Doubles, Residual, residual_rows, write_pattern_probes, write_rigid};
use crate::assembly::synthesis::Synthesis;
use crate::base::vec3::{add, cross, minus};
use crate::kernels::dense::{at, dot, row};
use vademecum_format::{Codec, Element, FormatError, SectionInput, SectionKind as S};

/// Most sections of a joined file.
const MOST: usize = 24;

/// Columns of the table of modes.
const COLUMNS: usize = 6;

/// The joined body, to be written.
pub(crate) struct Joined<'j> {
    pub parts: &'j [Part<'j>],
    pub counts: &'j Counts,
    pub synthesis: &'j Synthesis<'j>,
    pub damping: &'j Damping<'j>,
    pub inputs: &'j Inputs<'j>,
    pub residual: Option<Residual<'j>>,
}

/// The sections of a joined file, without their bytes.
pub(crate) struct Sections {
    all: [SectionInput<'static>; MOST],
    count: usize,
}

impl Sections {
    /// Those of these counts; `ratios` and `dashpots`: whether there are damping ratios, and rows of a
    /// damping matrix.
    pub fn of(counts: &Counts, ratios: bool, dashpots: usize) -> Self {
        let n = counts.n_modes();
        let mut own = Self { all: [input(S::NodeIds, Element::U64, [0; 3]); MOST], count: 0 };
        let (triangles, quadrangles) = (counts.triangles, counts.quadrangles);
        let (patterns, probes, load) = (counts.patterns, counts.probes, counts.load_nodes);
        let residual = counts.residual;
        let real = Element::F64;
        let sections = [
            (true, S::NodeIds, Element::U64, [counts.nodes, 1, 1]),
            (true, S::NodeCoordinates, real, [counts.nodes, 3, 1]),
            (true, S::Triangles, Element::U32, [triangles, 3, 1]),
            (quadrangles > 0, S::Quadrangles, Element::U32, [quadrangles, counts.quadrangle_width, 1]),
            (true, S::Eigenvalues, real, [n, 1, 1]),
            (ratios, S::DampingRatios, real, [n, 1, 1]),
            (dashpots > 0, S::DampingRows, real, [dashpots, n, 1]),
            (true, S::SurfaceBasis, real, [counts.nodes, 3, n]),
            (patterns > 0, S::PatternBasis, real, [patterns, n, 1]),
            (patterns > 0, S::PatternNames, Element::U8, [counts.pattern_text, 1, 1]),
            (probes > 0, S::ProbeRows, real, [probes, n, 1]),
            (probes > 0, S::ProbeNames, Element::U8, [counts.probe_text, 1, 1]),
            (counts.unit_text > 0, S::ProbeUnits, Element::U8, [counts.unit_text, 1, 1]),
            (residual, S::ContactResidual, real, [load, 6, 1]),
            (residual && counts.pairs > 0, S::ResidualPairs, Element::U32, [counts.pairs, 2, 1]),
            (residual && counts.pairs > 0, S::PairResidual, real, [counts.pairs, 9, 1]),
            (residual && probes > 0, S::ProbeResidual, real, [probes, load, 3]),
            (residual && patterns > 0, S::PatternResidual, real, [patterns, load, 3]),
            (residual && patterns > 0 && probes > 0, S::PatternProbeResidual, real, [patterns, probes, 1]),
            (counts.free, S::RigidBody, real, [11 + MOTIONS * patterns, 1, 1]),
            (counts.free && probes > 0, S::ProbeMotions, real, [probes, MOTIONS, 1]),
            (true, S::ModeTable, real, [n, COLUMNS, 1]),
        ];
        // In the order of their numbers.
        let mut last = 0;
        while let Some((_, kind, element, shape)) = next_section(&sections, last) {
            if let Some(place) = own.all.get_mut(own.count) {
                *place = input(kind, element, shape.map(|n| n as u64));
                own.count += 1;
            }
            last = kind.number();
        }
        own
    }

    /// As the format takes them.
    pub fn inputs(&self) -> &[SectionInput<'static>] {
        self.all.get(..self.count).unwrap_or_default()
    }
}

/// A section that may be in the file, with its shape.
type Planned = (bool, S, Element, [usize; 3]);

/// The section of the smallest number above another one.
fn next_section(sections: &[Planned], last: u32) -> Option<Planned> {
    let there = sections.iter().filter(|section| section.0 && section.1.number() > last);
    there.min_by_key(|section| section.1.number()).copied()
}

fn input(kind: S, element: Element, shape: [u64; 3]) -> SectionInput<'static> {
    SectionInput {
        kind,
        element,
        codec: Codec::Raw,
        // Without the damping a reader would step with less.
        required: matches!(kind, S::DampingRatios | S::DampingRows),
        shape,
        decoded_length: element.decoded_length(shape).unwrap_or(u64::MAX),
        stored: &[],
    }
}

/// Writes bytes one after the other.
struct Bytes<'b>(core::slice::IterMut<'b, u8>);

impl Bytes<'_> {
    fn push(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| {
            if let Some(place) = self.0.next() {
                *place = *byte;
            }
        });
    }
}

/// Writes names, one a line.
struct Lines<'b>(Bytes<'b>, bool);

impl<'b> Lines<'b> {
    fn new(bytes: &'b mut [u8]) -> Self {
        Self(Bytes(bytes.iter_mut()), false)
    }

    fn push(&mut self, words: &[&str]) {
        // As `Counts` has it: no line end before the first byte.
        if self.1 {
            self.0.push(b"\n");
        }
        words.iter().for_each(|word| self.0.push(word.as_bytes()));
        self.1 |= words.iter().any(|word| !word.is_empty());
    }
}

impl Joined<'_> {
    /// Writes the bytes of a section; lends four rows over the coordinates and three over the joints.
    ///
    /// # Errors
    /// [`FormatError`]: none but of a section that a joined file does not have.
    pub fn fill(&self, kind: S, bytes: &mut [u8], scratch: &mut [f64]) -> Result<(), FormatError> {
        match kind {
            S::NodeIds => {
                let places = bytes.as_chunks_mut::<8>().0.iter_mut();
                (1u64..).zip(places).for_each(|(id, place)| *place = id.to_le_bytes());
            }
            S::NodeCoordinates => {
                let mut out = Doubles::new(bytes);
                self.each_node(|_, part, node| part.place(node).into_iter().for_each(|x| out.push(x)));
            }
            S::Triangles => self.write_triangles(bytes),
            S::Quadrangles => self.write_quadrangles(bytes),
            S::Eigenvalues => {
                let mut out = Doubles::new(bytes);
                self.eigenvalues().iter().for_each(|value| out.push(*value));
            }
            S::DampingRatios => {
                let mut out = Doubles::new(bytes);
                self.damping.ratios.iter().for_each(|ratio| out.push(*ratio));
            }
            S::DampingRows => {
                let mut out = Doubles::new(bytes);
                self.damping.rows.iter().for_each(|value| out.push(*value));
            }
            S::SurfaceBasis => self.write_basis(bytes, scratch),
            S::PatternBasis => self.write_inputs(0, self.counts.patterns, bytes),
            S::ProbeRows => self.write_inputs(self.counts.patterns, self.counts.probes, bytes),
            S::PatternNames => {
                let mut lines = Lines::new(bytes);
                self.pattern_names(&mut lines);
                if self.counts.glued {
                    lines.push(&[GLUE]);
                }
                spin_names().filter(|_| self.counts.free).for_each(|name| lines.push(&[name]));
            }
            S::ProbeNames => {
                let mut lines = Lines::new(bytes);
                for part in self.parts {
                    let names = padded(part.probe_names, part.n_probes, "");
                    names.for_each(|name| lines.push(&[part.name, ".", name]));
                }
            }
            S::ProbeUnits => {
                let mut lines = Lines::new(bytes);
                for part in self.parts {
                    let units = padded(part.probe_units.unwrap_or(""), part.n_probes, "m");
                    units.for_each(|unit| lines.push(&[unit]));
                }
            }
            S::ResidualPairs => self.write_pairs(bytes),
            S::ContactResidual | S::PairResidual | S::ProbeResidual | S::PatternResidual => {
                if let Some(residual) = &self.residual {
                    residual.write(kind, (self.parts, self.counts), self.inputs, bytes);
                }
            }
            S::PatternProbeResidual => {
                write_pattern_probes(self.parts, self.counts, self.inputs, bytes);
            }
            S::RigidBody => write_rigid(self.parts, self.counts, self.synthesis, bytes),
            S::ProbeMotions => self.write_probe_motions(bytes),
            S::ModeTable => self.write_table(bytes),
            _ => return Err(FormatError::Missing { kind: kind.number() }),
        }
        Ok(())
    }

    fn eigenvalues(&self) -> &[f64] {
        self.synthesis.eigenvalues.get(self.counts.first_mode..).unwrap_or_default()
    }

    /// Shapes of the modes of the file, a row each.
    fn shapes(&self) -> &[f64] {
        self.synthesis.shapes.get(self.counts.first_mode * self.counts.r..).unwrap_or_default()
    }

    /// Part with its number and node of the part, of each node of the joined file.
    fn each_node(&self, mut with: impl FnMut(usize, &Part<'_>, usize)) {
        for load in [true, false] {
            for (index, part) in self.parts.iter().enumerate() {
                let nodes = if load { 0..part.n_load } else { part.n_load..part.n_surface };
                nodes.for_each(|node| with(index, part, node));
            }
        }
    }

    /// A node of a part in the joined file.
    fn node(part: &Part<'_>, [load, other]: [usize; 2], node: u32) -> u32 {
        let node = node as usize;
        (if node < part.n_load { load + node } else { other + node - part.n_load }) as u32
    }

    fn write_triangles(&self, bytes: &mut [u8]) {
        let mut out = bytes.as_chunks_mut::<4>().0.iter_mut();
        for load in [true, false] {
            for (index, part) in self.parts.iter().enumerate() {
                let starts = self.counts.node_starts(self.parts, index);
                let first = 3 * part.file.metadata().n_load_triangles as usize;
                let (skip, take) = if load { (0, first) } else { (first, usize::MAX) };
                for corner in part.triangles.iter().skip(skip).take(take) {
                    if let Some(place) = out.next() {
                        *place = Self::node(part, starts, u32::from_le_bytes(*corner)).to_le_bytes();
                    }
                }
            }
        }
    }

    fn write_quadrangles(&self, bytes: &mut [u8]) {
        let mut rows = bytes.as_chunks_mut::<4>().0.chunks_exact_mut(self.counts.quadrangle_width.max(1));
        let mut first = 0;
        for (index, part) in self.parts.iter().enumerate() {
            let starts = self.counts.node_starts(self.parts, index);
            for own in part.quadrangles.chunks_exact(part.quadrangle_width.max(1)) {
                let Some(out) = rows.next() else { return };
                out.fill(u32::MAX.to_le_bytes());
                for (place, (out, number)) in out.iter_mut().zip(own).enumerate() {
                    let number = u32::from_le_bytes(*number);
                    let joined = match place {
                        0 => number.wrapping_add(first),
                        1 => number,
                        _ if number == u32::MAX => number,
                        _ => Self::node(part, starts, number),
                    };
                    *out = joined.to_le_bytes();
                }
            }
            first += part.file.metadata().n_load_triangles;
        }
    }

    fn write_pairs(&self, bytes: &mut [u8]) {
        let mut out = bytes.as_chunks_mut::<4>().0.iter_mut();
        let mut first = 0;
        for part in self.parts {
            for node in part.pairs.iter().take(part.pairs.len() / 2 * 2) {
                if let Some(place) = out.next() {
                    *place = (first + u32::from_le_bytes(*node)).to_le_bytes();
                }
            }
            first += part.n_load as u32;
        }
    }

    /// `B − R GᵀL` of each surface node along the modes.
    fn write_basis(&self, bytes: &mut [u8], scratch: &mut [f64]) {
        let Counts { r, m, .. } = *self.counts;
        let mut out = Doubles::new(bytes);
        let Some((of_part, rest)) = scratch.split_at_mut_checked(3 * r) else { return };
        let Some((whole, rest)) = rest.split_at_mut_checked(r) else { return };
        let ports = rest.get_mut(..3 * m).unwrap_or_default();
        let starts = |index: usize| with_firsts(self.parts).nth(index).map_or(0, |(first, _)| first);
        self.each_node(|index, part, node| {
            let (first, n) = (starts(index), part.n_coordinates());
            part.node_rows(node, of_part.get_mut(..3 * n).unwrap_or_default());
            residual_rows(part, index, self.synthesis, node, ports);
            for c in 0..3 {
                whole.fill(0.0);
                let own = row(of_part, c, n);
                whole.iter_mut().skip(first).zip(own).for_each(|(to, from)| *to = *from);
                self.synthesis.take_forces(row(ports, c, m), whole);
                self.shapes().chunks_exact(r.max(1)).for_each(|shape| out.push(dot(shape, whole)));
            }
        });
    }

    fn write_inputs(&self, first: usize, count: usize, bytes: &mut [u8]) {
        let r = self.counts.r;
        let mut out = Doubles::new(bytes);
        for input in first..first + count {
            let own = row(self.inputs.rows, input, r);
            self.shapes().chunks_exact(r.max(1)).for_each(|shape| out.push(dot(shape, own)));
        }
    }

    fn pattern_names(&self, lines: &mut Lines<'_>) {
        for part in self.parts {
            let names = padded(part.pattern_names, part.n_patterns, "");
            names.for_each(|name| lines.push(&[part.name, ".", name]));
        }
    }

    /// Values of the probes as the body moves along and turns about the axes of space through its centre.
    fn write_probe_motions(&self, bytes: &mut [u8]) {
        let mut out = Doubles::new(bytes);
        let Some(rigid) = &self.synthesis.rigid else { return };
        for part in self.parts {
            let centre = part.rigid.map_or([0.0; 3], |own| part.pose.place(own.centre));
            let arm = minus(centre, rigid.centre);
            for probe in 0..part.n_probes {
                let [along, about] = part.probe_motions(probe).map(|v| part.pose.turn(v));
                along.into_iter().for_each(|x| out.push(x));
                // The centre of the part moves by e × arm.
                add(about, 1.0, cross(arm, along)).into_iter().for_each(|x| out.push(x));
            }
        }
    }

    /// Frequency \[Hz\], eigenvalue, no energy of snapshots, damping ratio, and what an exact step adds to it
    /// and to the period: nothing.
    fn write_table(&self, bytes: &mut [u8]) {
        let mut out = Doubles::new(bytes);
        let [alpha, beta] = self.damping.rayleigh;
        for (k, &value) in self.eigenvalues().iter().enumerate() {
            let omega = libm::sqrt(value);
            let ratio = 0.5 * (alpha / omega + beta * omega) + at(self.damping.ratios, k);
            let added = if ratio < 1.0 { 0.0 } else { f64::NAN };
            let row = [omega / core::f64::consts::TAU, value, f64::NAN, ratio, added, added];
            row.into_iter().for_each(|x| out.push(x));
        }
    }
}
