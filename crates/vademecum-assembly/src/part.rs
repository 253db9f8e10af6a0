//! A body of an assembly, as joining needs it: the numbers of its file, turned and moved to its place.

use faer::Mat;
use vademecum_build::linalg::symmetric_eigen;
use vademecum_format::{BASE_PATTERNS, File, Numbers, PORT_FACET_NODES, PortKind, PortRange, SectionKind};

use crate::error::AssemblyError;
use crate::pose::Pose;

/// Motions of a free body.
const MOTIONS: usize = 6;

/// A port at its place.
pub(crate) struct Port {
    pub name: String,
    pub kind: PortKind,
    /// Its first row among those of the part.
    pub first: usize,
    /// Origin.
    pub origin: [f64; 3],
    /// Axes along which the rows of a frame are.
    pub axes: [[f64; 3]; 3],
    /// Places of the nodes of a patch.
    pub nodes: Vec<[f64; 3]>,
    /// Facets of a patch, over its nodes.
    pub facets: Vec<Vec<u32>>,
}

/// A body at its place.
pub(crate) struct Part<'a> {
    pub name: String,
    pub file: File<'a>,
    pub pose: Pose,
    /// Squares of angular frequencies, those of rigid motions, which are zero, first.
    pub eigenvalues: Vec<f64>,
    /// `2σ` of each coordinate.
    pub damping: Vec<f64>,
    /// Rows of dashpots that couple the coordinates.
    pub dashpots: Mat<f64>,
    pub ports: Vec<Port>,
    /// `G B`, `G R Gᵀ`, `G R M R Gᵀ`.
    pub rows: Mat<f64>,
    pub compliance: Mat<f64>,
    pub inertia: Option<Mat<f64>>,
    /// Places of the surface nodes, the loadable ones first.
    pub places: Vec<[f64; 3]>,
    /// `B` and `R Gᵀ` at the surface nodes, three rows each.
    pub basis: Mat<f64>,
    pub residual: Mat<f64>,
    /// Names, and rows over the coordinates and over the rows of ports.
    pub patterns: Inputs,
    pub probes: Inputs,
}

/// Load patterns or probes of a part.
pub(crate) struct Inputs {
    pub names: Vec<String>,
    /// Shape (count, r).
    pub modal: Mat<f64>,
    /// Shape (count, rows of ports).
    pub ports: Mat<f64>,
}

/// Mass, centre and principal axes of a free body.
struct Rigid {
    mass: f64,
    centre: [f64; 3],
    moments: Vec<f64>,
    axes: Mat<f64>,
}

impl Rigid {
    fn of(numbers: &[f64]) -> Option<Self> {
        let &[mass, x, y, z, xx, xy, xz, yy, yz, zz, ..] = numbers else { return None };
        let inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let (moments, axes) = symmetric_eigen(Mat::from_fn(3, 3, |i, j| inertia[i][j]).as_ref()).ok()?;
        Some(Self { mass, centre: [x, y, z], moments, axes })
    }

    /// Rotation of a motion whose mass is 1.
    fn turn(&self, motion: usize) -> [f64; 3] {
        match motion.checked_sub(3) {
            None => [0.0; 3],
            Some(k) => std::array::from_fn(|c| self.axes[(c, k)] / self.moments[k].sqrt()),
        }
    }

    /// Displacement of a point by it.
    fn at(&self, motion: usize, x: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.turn(motion);
        let [x, y, z] = std::array::from_fn(|k| x[k] - self.centre[k]);
        let mut moved = [b * z - c * y, c * x - a * z, a * y - b * x];
        if motion < 3 {
            moved[motion] += self.mass.sqrt().recip();
        }
        moved
    }

    /// Work of a force and a moment about the centre on it.
    fn work(&self, motion: usize, force: &[f64]) -> f64 {
        let moved = self.at(motion, self.centre).into_iter().chain(self.turn(motion));
        moved.zip(force).map(|(moved, force)| moved * force).sum()
    }
}

/// Sections of a file by name of the part.
struct Source<'a, 'n> {
    part: &'n str,
    file: File<'a>,
}

impl<'a> Source<'a, '_> {
    fn numbers(&self, kind: SectionKind) -> Result<Option<Numbers<'a>>, AssemblyError> {
        Ok(self.file.section(kind).map(|section| section.numbers()).transpose()?)
    }

    fn needed(&self, kind: SectionKind) -> Result<Numbers<'a>, AssemblyError> {
        let missing = || AssemblyError::Missing { part: self.part.into(), kind };
        self.numbers(kind)?.ok_or_else(missing)
    }

    fn text(&self, kind: SectionKind) -> Result<Vec<String>, AssemblyError> {
        let Some(section) = self.file.section(kind) else { return Ok(vec![]) };
        let text = section.text()?;
        Ok(if text.is_empty() { vec![] } else { text.split('\n').map(str::to_string).collect() })
    }
}

/// A matrix of the numbers of a section, row by row.
fn matrix(numbers: Option<Numbers<'_>>, rows: usize, columns: usize) -> Mat<f64> {
    let mut found = Mat::zeros(rows, columns);
    for (k, value) in numbers.iter().flat_map(Numbers::iter).enumerate() {
        found[(k / columns, k % columns)] = value;
    }
    found
}

impl<'a> Part<'a> {
    /// Reads an unpacked, checked file.
    ///
    /// # Errors
    /// [`AssemblyError`]: a file of another structure, or one that was stripped of what joining needs.
    pub fn new(name: &str, pose: Pose, file: File<'a>) -> Result<Self, AssemblyError> {
        use SectionKind as S;
        let source = Source { part: name, file };
        let metadata = *file.metadata();
        let kind =
            |found: &str, expected| AssemblyError::Kind { part: name.into(), found: found.into(), expected };
        if !metadata.diagonal || !metadata.scheme.is_exact() {
            let found = "has no natural modes that are moved exactly";
            return Err(kind(found, "a linear body with exact steps and no live stiffness of a region"));
        }
        let elastic = metadata.n_modes as usize;
        let rigid = match source.numbers(S::RigidBody)? {
            None => None,
            Some(numbers) => {
                let numbers: Vec<f64> = numbers.iter().collect();
                let rigid = Rigid::of(&numbers).ok_or(AssemblyError::NoConvergence)?;
                Some((rigid, numbers))
            }
        };
        let own = if rigid.is_some() { MOTIONS } else { 0 };
        let r = own + elastic;
        let eigenvalues = source.needed(S::Eigenvalues)?.iter();
        let eigenvalues: Vec<f64> = std::iter::repeat_n(0.0, own).chain(eigenvalues).collect();

        // Along rigid motions too, Rayleigh's damping is that of the matrix `α M + β K` of the whole body.
        let ratios = source.numbers(S::DampingRatios)?;
        let ratio = |k: usize| ratios.and_then(|all| all.get(k)).unwrap_or(0.0);
        let of_mode = |(k, value): (usize, &f64)| {
            let ratio = k.checked_sub(own).map_or(0.0, ratio);
            metadata.alpha + metadata.beta * value + 2.0 * ratio * value.sqrt()
        };
        let damping = eigenvalues.iter().enumerate().map(of_mode).collect();
        let rows = source.numbers(S::DampingRows)?;
        let count = rows.map_or(0, |rows| rows.len() / elastic.max(1));
        let of_rows = matrix(rows, count, elastic);
        let dashpots = Mat::from_fn(count, r, |i, k| k.checked_sub(own).map_or(0.0, |k| of_rows[(i, k)]));

        let n = metadata.n_surface_nodes as usize;
        let coordinates = matrix(Some(source.needed(S::NodeCoordinates)?), metadata.n_nodes as usize, 3);
        let local = |node: usize| -> [f64; 3] { std::array::from_fn(|c| coordinates[(node, c)]) };
        let motion = |k: usize, x: [f64; 3]| rigid.as_ref().map_or([0.0; 3], |(rigid, _)| rigid.at(k, x));
        let turn = |k: usize| rigid.as_ref().map_or([0.0; 3], |(rigid, _)| rigid.turn(k));

        let surface = matrix(Some(source.needed(S::SurfaceBasis)?), 3 * n, elastic);
        let mut basis = Mat::zeros(3 * n, r);
        for node in 0..n {
            for k in 0..r {
                let moved = match k.checked_sub(own) {
                    None => motion(k, local(node)),
                    Some(k) => std::array::from_fn(|c| surface[(3 * node + c, k)]),
                };
                pose.turn(moved).into_iter().enumerate().for_each(|(c, u)| basis[(3 * node + c, k)] = u);
            }
        }

        let ports = local_ports(&source, &local)?;
        let m = source.file.section(S::PortRows).map_or(0, |section| section.shape()[0] as usize);
        let own_rows = matrix(source.numbers(S::PortRows)?, m, elastic);
        let mut rows = Mat::zeros(m, r);
        for port in &ports {
            let (first, count) = (port.first, port.rows());
            for (row, k) in (0..count).flat_map(|row| (0..r).map(move |k| (row, k))) {
                rows[(first + row, k)] = match k.checked_sub(own) {
                    Some(k) => own_rows[(first + row, k)],
                    None => port.local_row(row, |x| motion(k, x), turn(k)),
                };
            }
        }
        let ports = ports.into_iter().map(|port| port.placed(&pose)).collect();
        let compliance = matrix(source.numbers(S::PortCompliance)?, m, m);
        let inertia = source.numbers(S::PortInertia)?.map(|numbers| matrix(Some(numbers), m, m));
        let of_ports = source.numbers(S::PortResidual)?;
        if m > 0 && n > 0 && of_ports.is_none() {
            return Err(AssemblyError::Missing { part: name.into(), kind: S::PortResidual });
        }
        let mut residual = Mat::zeros(3 * n, m);
        if let Some(numbers) = of_ports {
            let local = matrix(Some(numbers), m, 3 * n);
            for (row, node) in (0..m).flat_map(|row| (0..n).map(move |node| (row, node))) {
                let moved = pose.turn(std::array::from_fn(|c| local[(row, 3 * node + c)]));
                moved.into_iter().enumerate().for_each(|(c, u)| residual[(3 * node + c, row)] = u);
            }
        }

        // The motions of a base and the centrifugal patterns of a free body are none of the joined body.
        let all = metadata.n_patterns as usize;
        let base = if file.section(S::BaseFrame).is_some() { BASE_PATTERNS.len() } else { 0 };
        let kept = all.saturating_sub(base + own);
        let modal = matrix(source.numbers(S::PatternBasis)?, all, elastic);
        let of_pattern = |p: usize, k: usize| match (k.checked_sub(own), &rigid) {
            (Some(k), _) => modal[(p, k)],
            (None, Some((rigid, numbers))) => rigid.work(k, &numbers[11 + 6 * p..17 + 6 * p]),
            (None, None) => 0.0,
        };
        let at_ports = matrix(source.numbers(S::PortPatterns)?, m, all);
        let patterns = Inputs {
            names: source.text(S::PatternNames)?.into_iter().take(kept).collect(),
            modal: Mat::from_fn(kept, r, of_pattern),
            ports: Mat::from_fn(kept, m, |p, row| at_ports[(row, p)]),
        };

        let count = metadata.n_probes as usize;
        let modal = matrix(source.numbers(S::ProbeRows)?, count, elastic);
        let moved = match (&rigid, count) {
            (Some(_), 1..) => matrix(Some(source.needed(S::ProbeMotions)?), count, MOTIONS),
            _ => Mat::zeros(count, MOTIONS),
        };
        let of_probe = |p: usize, k: usize| match (k.checked_sub(own), &rigid) {
            (Some(k), _) => modal[(p, k)],
            (None, Some((rigid, _))) => {
                let turned = rigid.at(k, rigid.centre).into_iter().chain(rigid.turn(k)).enumerate();
                turned.map(|(c, motion)| moved[(p, c)] * motion).sum()
            }
            (None, None) => 0.0,
        };
        let at_ports = matrix(source.numbers(S::PortProbes)?, m, count);
        let probes = Inputs {
            names: source.text(S::ProbeNames)?,
            modal: Mat::from_fn(count, r, of_probe),
            ports: Mat::from_fn(count, m, |p, row| at_ports[(row, p)]),
        };
        let places = (0..n).map(|node| pose.place(local(node))).collect();
        Ok(Self {
            name: name.into(),
            file,
            pose,
            eigenvalues,
            damping,
            dashpots,
            ports,
            rows,
            compliance,
            inertia,
            places,
            basis,
            residual,
            patterns,
            probes,
        })
    }

    /// Number of its coordinates.
    pub fn n_modes(&self) -> usize {
        self.eigenvalues.len()
    }

    /// The damping ratio of every mode beside Rayleigh's, if it is the same of all and no dashpots act.
    pub fn ratio(&self) -> Option<f64> {
        let ratios = self.file.section(SectionKind::DampingRatios).and_then(|section| section.numbers().ok());
        let first = ratios.and_then(|ratios| ratios.get(0)).unwrap_or(0.0);
        let alike = ratios.iter().flat_map(Numbers::iter).all(|ratio| ratio == first);
        (alike && self.dashpots.nrows() == 0).then_some(first)
    }

    /// True of a body that nothing holds.
    pub fn is_free(&self) -> bool {
        self.file.section(SectionKind::RigidBody).is_some()
    }

    /// Number of its loadable nodes.
    pub fn n_load(&self) -> usize {
        self.file.metadata().n_load_nodes as usize
    }
}

impl Port {
    /// Number of its rows.
    pub fn rows(&self) -> usize {
        match self.kind {
            PortKind::Patch => 3 * self.nodes.len(),
            PortKind::Frame => MOTIONS,
        }
    }

    /// A row under a motion of the part before it is moved to its place.
    fn local_row(&self, row: usize, moved: impl Fn([f64; 3]) -> [f64; 3], turned: [f64; 3]) -> f64 {
        let along = |k: usize, v: [f64; 3]| self.axes[k].iter().zip(v).map(|(a, v)| a * v).sum();
        match (self.kind, row) {
            (PortKind::Patch, _) => moved(self.nodes[row / 3])[row % 3],
            (PortKind::Frame, 0..3) => along(row, moved(self.origin)),
            (PortKind::Frame, _) => along(row - 3, turned),
        }
    }

    /// Moves it to the place of its part.
    fn placed(self, pose: &Pose) -> Self {
        Self {
            origin: pose.place(self.origin),
            axes: self.axes.map(|axis| pose.turn(axis)),
            nodes: self.nodes.into_iter().map(|x| pose.place(x)).collect(),
            ..self
        }
    }
}

/// The ports of a file, where they are before the part is moved.
fn local_ports(
    source: &Source<'_, '_>,
    local: &impl Fn(usize) -> [f64; 3],
) -> Result<Vec<Port>, AssemblyError> {
    use SectionKind as S;
    let names = source.text(S::PortNames)?;
    let frames: Vec<f64> = source.numbers(S::PortFrames)?.iter().flat_map(Numbers::iter).collect();
    let u32s = |kind| -> Result<Vec<u32>, AssemblyError> {
        let Some(section) = source.file.section(kind) else { return Ok(vec![]) };
        Ok(section.u32s()?.iter().map(|number| u32::from_le_bytes(*number)).collect())
    };
    let (nodes, facets) = (u32s(S::PortNodes)?, u32s(S::PortFacets)?);
    let mut found = vec![];
    let ranges = source.file.port_table()?.iter().filter_map(PortRange::of);
    for ((name, range), frame) in names.into_iter().zip(ranges).zip(frames.as_chunks::<12>().0) {
        let [first, count] = range.nodes;
        let own = &nodes[first..first + count];
        let facet = |facet: &[u32; PORT_FACET_NODES]| -> Vec<u32> {
            facet.iter().copied().take_while(|&node| node != u32::MAX).collect()
        };
        let [first_facet, n_facets] = range.facets;
        let of_port = facets.as_chunks::<PORT_FACET_NODES>().0[first_facet..first_facet + n_facets].iter();
        found.push(Port {
            name,
            kind: range.kind,
            first: range.rows[0],
            origin: std::array::from_fn(|c| frame[c]),
            axes: std::array::from_fn(|k| std::array::from_fn(|c| frame[3 + 3 * k + c])),
            nodes: own.iter().map(|&node| local(node as usize)).collect(),
            facets: of_port.map(facet).collect(),
        });
    }
    Ok(found)
}
