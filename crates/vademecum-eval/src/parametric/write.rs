//! Sections of the file at values of the parameters: one rule for each kind.

use crate::base::lend::Lender;
use crate::kernels::dense::at;
use crate::parametric::error::ParametricError;
use crate::parametric::model::{Parametric, Scales};
use crate::parametric::ports::PortAnswers;
use crate::parametric::reactions::SupportShapes;
use crate::parametric::residual::{Statics, solved};
use crate::parametric::rows::{Reals, along, read_row};
use crate::parametric::tuned::Tuned;
use vademecum_format::{Codec, Element, File, FormatError, Numbers, Section, SectionInput, SectionKind as S};

/// Most sections.
const MOST: usize = 56;
/// Columns of the table of modes.
const COLUMNS: usize = 6;

/// Origin of a section of the file at given values.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rule {
    /// The bytes of the model.
    Same,
    /// Rows over the basis as rows over the modes.
    Rows,
    /// Written anew.
    Anew,
    /// Not in the file.
    Gone,
}

fn rule(kind: S) -> Rule {
    match kind {
        S::NodeIds
        | S::NodeCoordinates
        | S::Triangles
        | S::Quadrangles
        | S::EmbeddedNodes
        | S::EmbeddedWeights
        | S::EmbeddedTriangles
        | S::PatternNames
        | S::ProbeNames
        | S::ProbeUnits
        | S::ProbeMotions
        | S::BaseFrame
        | S::RigidBody
        | S::ResidualPairs
        | S::PatchPairs
        | S::ContactPatch
        | S::StressPoints
        | S::MeshError
        | S::Losses
        | S::SupportNames
        | S::SupportPoints
        | S::PortNames
        | S::PortTable
        | S::PortFrames
        | S::PortNodes
        | S::PortFacets => Rule::Same,
        S::SurfaceBasis | S::InteriorBasis | S::PatternBasis | S::ProbeRows | S::PortRows => Rule::Rows,
        S::Eigenvalues
        | S::DampingRatios
        | S::DampingRows
        | S::ModeTable
        | S::StressBasis
        | S::ElasticConstants
        | S::Compliance
        | S::ContactResidual
        | S::PairResidual
        | S::PatchResidual
        | S::ProbeResidual
        | S::PatternResidual
        | S::PatternProbeResidual
        | S::StressResidual
        | S::PatternStress
        | S::ReactionBasis
        | S::ReactionLoads
        | S::PatternReaction
        | S::PortCompliance
        | S::PortInertia
        | S::PortResidual
        | S::PortProbes
        | S::PortPatterns => Rule::Anew,
        _ => Rule::Gone,
    }
}

/// Sections of the file at given values, without their bytes.
pub(crate) struct Planned([SectionInput<'static>; MOST]);

impl Planned {
    pub const NONE: Self = Self(
        [SectionInput {
            kind: S::NodeIds,
            element: Element::U8,
            codec: Codec::Raw,
            required: false,
            shape: [0; 3],
            decoded_length: 0,
            stored: &[],
        }; MOST],
    );
}

/// The sections, in the order of the model.
pub(crate) fn planned<'p>(
    file: &File<'_>,
    modes: usize,
    room: &'p mut Planned,
) -> Result<&'p [SectionInput<'static>], FormatError> {
    let mut count = 0;
    for section in file.sections().filter(|section| rule(section.kind()) != Rule::Gone) {
        let kind = section.kind();
        if section.codec() != Codec::Raw {
            return Err(FormatError::Compressed { kind: kind.number(), codec: section.codec() as u8 });
        }
        let mut shape = section.shape();
        // The place of the modes in the shape.
        let place = match kind {
            S::Eigenvalues | S::DampingRatios | S::ModeTable => Some(0),
            S::PatternBasis | S::ProbeRows | S::PortRows => Some(1),
            S::SurfaceBasis | S::InteriorBasis | S::StressBasis | S::ReactionBasis => Some(2),
            _ => None,
        };
        if let Some(extent) = place.and_then(|place| shape.get_mut(place)) {
            *extent = modes as u64;
        }
        if kind == S::DampingRows {
            shape = [shape[0].min(modes as u64), modes as u64, 1];
        }
        let element = if section.element() == Element::I16 { Element::F32 } else { section.element() };
        let input = SectionInput {
            kind,
            element,
            codec: Codec::Raw,
            required: section.is_required(),
            shape,
            decoded_length: element.decoded_length(shape).unwrap_or(u64::MAX),
            stored: &[],
        };
        let limit = MOST as u32;
        let full = FormatError::SectionCount { found: limit + 1, limit };
        *room.0.get_mut(count).ok_or(full)? = input;
        count += 1;
    }
    Ok(room.0.get(..count).unwrap_or_default())
}

/// Rows of a section; 0 of none.
fn rows_of(file: &File<'_>, kind: S) -> usize {
    file.section(kind).map_or(0, |section| section.shape()[0] as usize)
}

/// Numbers of work of a [`Filler`].
pub(crate) fn write_work(model: &Parametric<'_>, modes: usize) -> usize {
    let (r, metadata, file) = (model.live.n_modes, model.file.metadata(), &model.file);
    let load = metadata.n_load_nodes as usize;
    let statics = if file.section(S::ContactResidual).is_some() {
        let rows = 3 * load + metadata.n_probes as usize + metadata.n_patterns as usize;
        Statics::len(rows, r, modes)
    } else {
        0
    };
    let supports = SupportShapes::len(rows_of(file, S::ReactionBasis), r);
    let ports = PortAnswers::len(rows_of(file, S::PortRows), r);
    let damping = modes + model.loss_work() + model.dashpot_work(modes);
    let others = load + 6 * (r + modes) + 2 * r + damping;
    statics.saturating_add(supports).saturating_add(ports).saturating_add(others)
}

/// Writes the sections.
pub(crate) struct Filler<'w, 'f> {
    model: &'w Parametric<'f>,
    tuned: &'w Tuned<'w>,
    scales: &'w Scales<'w>,
    statics: Option<Statics<'w>>,
    supports: Option<SupportShapes<'w>>,
    ports: Option<PortAnswers<'w>>,
    /// `√ρ` of each loadable node.
    roots: &'w [f64],
    /// Damping ratios of the stepped modes, where regions have loss factors.
    ratios: Option<&'w [f64]>,
    /// Work for dashpots.
    dashpots: &'w mut [f64],
    /// A row over the basis, and six rows over basis and modes.
    row: &'w mut [f64],
    solved: &'w mut [f64],
}

impl<'w, 'f> Filler<'w, 'f> {
    pub fn new(
        model: &'w Parametric<'f>,
        tuned: &'w Tuned<'w>,
        scales: &'w Scales<'w>,
        work: &'w mut [f64],
    ) -> Result<Self, ParametricError> {
        let (r, m, metadata) = (model.n_basis(), tuned.eigenvalues.len(), model.file.metadata());
        let found = work.len();
        let needed = write_work(model, m);
        let short = |_| ParametricError::LentMemory { what: "numbers of work", found, needed };
        let mut lender = Lender::new(work);
        let row = lender.take(2 * r).map_err(short)?;
        let solved = lender.take(6 * (r + m)).map_err(short)?;
        let [load, probes, patterns] =
            [metadata.n_load_nodes, metadata.n_probes, metadata.n_patterns].map(|n| n as usize);
        let roots = lender.take(load).map_err(short)?;
        model.roots_into(scales, roots);
        let roots: &[f64] = roots;
        let (ratios, lent) = (lender.take(m).map_err(short)?, lender.take(model.loss_work()).map_err(short)?);
        let ratios = if model.ratios_into(tuned, scales, ratios, lent) { Some(&*ratios) } else { None };
        let dashpots = lender.take(model.dashpot_work(m)).map_err(short)?;
        let mut statics = None;
        if model.file.section(S::ContactResidual).is_some() {
            let numbers = |kind| model.file.section(kind).map(|section| section.numbers()).transpose();
            let sections = [
                (numbers(S::SurfaceBasis)?, 3 * load),
                (numbers(S::ProbeRows)?, probes),
                (numbers(S::PatternBasis)?, patterns),
            ];
            let lent = lender.take(Statics::len(3 * load + probes + patterns, r, m)).map_err(short)?;
            statics = Some(Statics::new(tuned, r, &sections, lent));
        }
        let at = (tuned, scales);
        let mut supports = None;
        if model.file.section(S::ReactionBasis).is_some() {
            let count = rows_of(&model.file, S::ReactionBasis);
            let lent = lender.take(SupportShapes::len(count, r)).map_err(short)?;
            supports = Some(SupportShapes::new(model, at, lent)?);
        }
        let mut ports = None;
        if model.file.section(S::PortRows).is_some() {
            let lent = lender.take(PortAnswers::len(rows_of(&model.file, S::PortRows), r)).map_err(short)?;
            ports = Some(PortAnswers::new(model, at, roots, (&mut *row, lent))?);
        }
        Ok(Self { model, tuned, scales, statics, supports, ports, roots, ratios, dashpots, row, solved })
    }

    fn section(&self, kind: S) -> Result<Section<'f>, FormatError> {
        self.model.file.section(kind).ok_or(FormatError::Missing { kind: kind.number() })
    }

    /// Writes the bytes of a section.
    pub fn fill(&mut self, kind: S, bytes: &mut [u8]) -> Result<(), FormatError> {
        let section = self.section(kind)?;
        if rule(kind) == Rule::Same {
            bytes.iter_mut().zip(section.raw()?).for_each(|(to, from)| *to = *from);
            return Ok(());
        }
        let element = if section.element() == Element::I16 { Element::F32 } else { section.element() };
        let (numbers, mut out) = (section.numbers()?, Reals::new(element, bytes));
        match kind {
            S::Eigenvalues => self.tuned.eigenvalues.iter().for_each(|value| out.push(*value)),
            S::DampingRatios => match self.ratios {
                Some(ratios) => ratios.iter().for_each(|ratio| out.push(*ratio)),
                None => numbers.iter().take(self.tuned.eigenvalues.len()).for_each(|ratio| out.push(ratio)),
            },
            S::DampingRows => {
                let work = (&mut *self.row, &mut *self.dashpots, &mut out);
                self.model.write_dashpots(self.tuned, self.scales, &numbers, work);
            }
            S::ModeTable => self.write_table(&mut out),
            S::StressBasis => self.write_stress(&numbers, section.shape()[0] as usize, &mut out)?,
            S::ElasticConstants | S::Compliance => self.write_elasticity(kind, &numbers, &mut out),
            S::ContactResidual => self.write_own(&numbers, &mut out),
            S::PairResidual => self.write_pairs(S::ResidualPairs, &numbers, &mut out)?,
            S::PatchResidual => self.write_pairs(S::PatchPairs, &numbers, &mut out)?,
            S::ProbeResidual | S::PatternResidual => self.write_beside_nodes(kind, &numbers, &mut out),
            S::PatternProbeResidual => self.write_pattern_probes(&numbers, &mut out),
            S::StressResidual | S::PatternStress => self.write_stress_residual(kind, &numbers, &mut out)?,
            S::ReactionBasis | S::ReactionLoads | S::PatternReaction => {
                self.write_reactions(kind, &numbers, &mut out)?;
            }
            S::PortCompliance | S::PortInertia | S::PortResidual | S::PortProbes | S::PortPatterns => {
                self.write_ports(kind, &numbers, &mut out)?;
            }
            _ => {
                let r = self.model.n_basis();
                let row = self.row.get_mut(..r).unwrap_or_default();
                for index in 0..numbers.len().checked_div(r).unwrap_or(0) {
                    read_row(&numbers, index, row);
                    along(self.tuned.shapes, row).for_each(|value| out.push(value));
                }
            }
        }
        Ok(())
    }

    /// Frequency \[Hz\], eigenvalue, no energy of snapshots, damping ratio, and what an exact step adds to it
    /// and to the period: nothing.
    fn write_table(&self, out: &mut Reals<'_>) {
        let ratios = self.model.file.section(S::DampingRatios).and_then(|section| section.numbers().ok());
        for (k, &value) in self.tuned.eigenvalues.iter().enumerate() {
            let omega = libm::sqrt(value);
            let built = || ratios.and_then(|ratios| ratios.get(k)).unwrap_or(0.0);
            let own = self.ratios.map_or_else(built, |ratios| at(ratios, k));
            let ratio = 0.5 * (self.scales.alpha / omega + self.scales.beta * omega) + own;
            let added = if ratio < 1.0 { 0.0 } else { f64::NAN };
            let row: [f64; COLUMNS] = [omega / core::f64::consts::TAU, value, f64::NAN, ratio, added, added];
            row.into_iter().for_each(|x| out.push(x));
        }
    }

    /// Factor of the stiffness of a region of the mesh.
    fn stiffness_of(&self, region: usize) -> f64 {
        let live = self.model.live.regions.get(region).map_or(0, |live| u32::from_le_bytes(*live));
        self.model.scale_of(self.scales, live as usize, false)
    }

    /// Factor of the stiffness at each point of known stress.
    fn stress_scale(&self, point: usize) -> Result<f64, FormatError> {
        let points = self.section(S::StressPoints)?.u32s()?;
        let region = points.get(2 * point + 1).map_or(0, |region| u32::from_le_bytes(*region));
        Ok(self.stiffness_of(region as usize))
    }

    fn write_stress(
        &mut self,
        numbers: &Numbers<'_>,
        points: usize,
        out: &mut Reals<'_>,
    ) -> Result<(), FormatError> {
        let r = self.model.n_basis();
        for point in 0..points {
            let scale = self.stress_scale(point)?;
            for component in 0..6 {
                let row = self.row.get_mut(..r).unwrap_or_default();
                read_row(numbers, 6 * point + component, row);
                along(self.tuned.shapes, row).for_each(|value| out.push(scale * value));
            }
        }
        Ok(())
    }

    /// Moduli, or compliances, of each region of the mesh.
    fn write_elasticity(&self, kind: S, numbers: &Numbers<'_>, out: &mut Reals<'_>) {
        let (columns, constants) = if kind == S::Compliance { (21, false) } else { (2, true) };
        for (place, value) in numbers.iter().enumerate() {
            let scale = self.stiffness_of(place / columns);
            let scaled = match (constants, place % columns) {
                (true, 0) => value * scale,
                (true, _) => value,
                (false, _) => value / scale,
            };
            out.push(scaled);
        }
    }

    fn statics(&self, a: usize, b: usize) -> f64 {
        self.statics.as_ref().map_or(0.0, |statics| statics.between(a, b))
    }

    fn write_own(&self, numbers: &Numbers<'_>, out: &mut Reals<'_>) {
        const PLACES: [[usize; 2]; 6] = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];
        let mut built = numbers.iter();
        for node in 0..numbers.len() / 6 {
            let scale = at(self.roots, node) * at(self.roots, node);
            for [i, j] in PLACES {
                let outside = built.next().unwrap_or(0.0);
                out.push(scale * outside + self.statics(3 * node + i, 3 * node + j));
            }
        }
    }

    fn write_pairs(&self, pairs: S, numbers: &Numbers<'_>, out: &mut Reals<'_>) -> Result<(), FormatError> {
        let mut built = numbers.iter();
        for pair in self.section(pairs)?.u32s()?.as_chunks::<2>().0 {
            let [a, b] = pair.map(|node| u32::from_le_bytes(node) as usize);
            let scale = at(self.roots, a) * at(self.roots, b);
            for place in 0..9 {
                let outside = built.next().unwrap_or(0.0);
                out.push(scale * outside + self.statics(3 * a + place / 3, 3 * b + place % 3));
            }
        }
        Ok(())
    }

    /// Rows of probes or patterns beside the loadable nodes.
    fn write_beside_nodes(&self, kind: S, numbers: &Numbers<'_>, out: &mut Reals<'_>) {
        let metadata = self.model.file.metadata();
        let [load, probes] = [metadata.n_load_nodes, metadata.n_probes].map(|n| n as usize);
        let first = if kind == S::ProbeResidual { 3 * load } else { 3 * load + probes };
        for (place, outside) in numbers.iter().enumerate() {
            let (row, dof) = (place / (3 * load).max(1), place % (3 * load).max(1));
            let scale = at(self.roots, dof / 3) * at(self.roots, dof / 3);
            out.push(scale * outside + self.statics(first + row, dof));
        }
    }

    fn write_pattern_probes(&self, numbers: &Numbers<'_>, out: &mut Reals<'_>) {
        let metadata = self.model.file.metadata();
        let [load, probes] = [metadata.n_load_nodes, metadata.n_probes].map(|n| n as usize);
        let mean = self.roots.iter().map(|root| root * root).sum::<f64>() / self.roots.len().max(1) as f64;
        for (place, outside) in numbers.iter().enumerate() {
            let (pattern, probe) = (place / probes.max(1), place % probes.max(1));
            out.push(mean * outside + self.statics(3 * load + probes + pattern, 3 * load + probe));
        }
    }

    /// Reactions of the supports.
    fn write_reactions(
        &mut self,
        kind: S,
        numbers: &Numbers<'_>,
        out: &mut Reals<'_>,
    ) -> Result<(), FormatError> {
        let Some(supports) = &self.supports else { return Ok(()) };
        if kind == S::ReactionBasis {
            let at = (self.tuned, self.scales);
            return supports.write_inertia(self.model, at, numbers, (self.row, out));
        }
        let of_nodes = kind == S::ReactionLoads;
        let loads = self.section(if of_nodes { S::SurfaceBasis } else { S::PatternBasis })?.numbers()?;
        supports.write_loads(numbers, (&loads, of_nodes), (self.row, out));
        Ok(())
    }

    /// Residual flexibility of the ports.
    fn write_ports(
        &mut self,
        kind: S,
        numbers: &Numbers<'_>,
        out: &mut Reals<'_>,
    ) -> Result<(), FormatError> {
        let Some(ports) = &self.ports else { return Ok(()) };
        let others = match kind {
            S::PortCompliance => S::PortRows,
            S::PortResidual => S::SurfaceBasis,
            S::PortProbes => S::ProbeRows,
            _ => S::PatternBasis,
        };
        match kind {
            S::PortInertia => ports.write_inertia(self.tuned, numbers, (self.row, out)),
            S::PortCompliance => {
                ports.write_compliance(&self.section(others)?.numbers()?, numbers, (self.row, out));
            }
            _ => {
                let roots = if kind == S::PortResidual { self.roots } else { &[] };
                ports.write_others(&self.section(others)?.numbers()?, roots, numbers, (self.row, out));
            }
        }
        Ok(())
    }

    /// Stress of the residual flexibility, under forces at loadable nodes or under patterns.
    fn write_stress_residual(
        &mut self,
        kind: S,
        numbers: &Numbers<'_>,
        out: &mut Reals<'_>,
    ) -> Result<(), FormatError> {
        let (r, m) = (self.model.n_basis(), self.tuned.eigenvalues.len());
        let metadata = self.model.file.metadata();
        let [load, probes, patterns] =
            [metadata.n_load_nodes, metadata.n_probes, metadata.n_patterns].map(|n| n as usize);
        let basis = self.section(S::StressBasis)?;
        let (points, basis) = (basis.shape()[0] as usize, basis.numbers()?);
        let of_nodes = kind == S::StressResidual;
        let outer = if of_nodes { 1 } else { patterns };
        for pattern in 0..outer {
            for point in 0..points {
                let scale = self.stress_scale(point)?;
                for (component, rows) in self.solved.chunks_exact_mut((r + m).max(1)).enumerate() {
                    let (row, of_modes) = rows.split_at_mut(r.min(rows.len()));
                    read_row(&basis, 6 * point + component, row);
                    solved(self.tuned, row, of_modes);
                }
                let statics = |load: usize, component: usize| {
                    let rows = self.solved.get(component * (r + m)..(component + 1) * (r + m));
                    let (row, of_modes) = rows.unwrap_or_default().split_at_checked(r).unwrap_or_default();
                    self.statics.as_ref().map_or(0.0, |statics| statics.with(load, (of_modes, row)))
                };
                // Outside of the basis the point is as stiff as its region.
                let outside = libm::sqrt(scale);
                if !of_nodes {
                    for component in 0..6 {
                        let built = numbers.get(6 * (pattern * points + point) + component).unwrap_or(0.0);
                        out.push(built + scale * statics(3 * load + probes + pattern, component));
                    }
                    continue;
                }
                for node in 0..load {
                    for place in 0..18 {
                        let built = numbers.get(18 * (point * load + node) + place).unwrap_or(0.0);
                        let inside = statics(3 * node + place % 3, place / 3);
                        out.push(outside * at(self.roots, node) * built + scale * inside);
                    }
                }
            }
        }
        Ok(())
    }
}
