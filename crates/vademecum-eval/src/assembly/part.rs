//! A body of an assembly: the numbers of its file, turned to its place where they are read.

use crate::assembly::error::PartFault;
use crate::assembly::port::{Port, Ports};
use crate::base::pose::Pose;
use crate::base::vec3::{add, cross, dot, minus};
use crate::flight::rigid::RigidBody;
use crate::kernels::dense::at;
use vademecum_format::{BASE_PATTERNS, File, FormatError, Numbers, SectionKind as S};

/// Motions of a free body.
pub(crate) const MOTIONS: usize = 6;

/// Patterns of the angular velocity of a free body, the last of [`BASE_PATTERNS`].
pub(crate) const SPIN: usize = 6;

/// Numbers of [`S::RigidBody`] before those of the patterns.
const RIGID: usize = 11;

/// Directions of space.
pub(crate) const SPACE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A body of an assembly: a file, and where it is.
///
/// Its coordinates are those of the file, after six of rigid motion where the body is free: displacements
/// along x, y, z times the root of its mass, and rotations about its principal axes ([`RigidBody::axes`])
/// times the root of the moment of inertia.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    pub(crate) name: &'a str,
    pub(crate) file: File<'a>,
    pub(crate) pose: Pose,
    pub(crate) rigid: Option<RigidBody>,
    rigid_numbers: &'a [[u8; 8]],
    pub(crate) ports: Ports<'a>,
    /// Natural modes.
    elastic: usize,
    pub(crate) n_surface: usize,
    pub(crate) n_load: usize,
    /// Patterns and probes that the joined body has too, and all patterns of the file.
    pub(crate) n_patterns: usize,
    pub(crate) n_probes: usize,
    all_patterns: usize,
    pub(crate) n_dashpots: usize,
    eigenvalues: Numbers<'a>,
    ratios: Option<Numbers<'a>>,
    dashpots: Option<Numbers<'a>>,
    coordinates: Numbers<'a>,
    surface: Option<Numbers<'a>>,
    rows: Option<Numbers<'a>>,
    compliance: Option<Numbers<'a>>,
    inertia: Option<Numbers<'a>>,
    residual: Option<Numbers<'a>>,
    pattern_rows: Option<Numbers<'a>>,
    pattern_ports: Option<Numbers<'a>>,
    probe_rows: Option<Numbers<'a>>,
    probe_ports: Option<Numbers<'a>>,
    probe_motions: Option<Numbers<'a>>,
    pub(crate) contact_residual: Option<Numbers<'a>>,
    pub(crate) pair_residual: Option<Numbers<'a>>,
    pub(crate) pairs: &'a [[u8; 4]],
    pub(crate) probe_residual: Option<Numbers<'a>>,
    pub(crate) pattern_residual: Option<Numbers<'a>>,
    pub(crate) pattern_probes: Option<Numbers<'a>>,
    pub(crate) triangles: &'a [[u8; 4]],
    pub(crate) quadrangles: &'a [[u8; 4]],
    pub(crate) quadrangle_width: usize,
    pub(crate) pattern_names: &'a str,
    pub(crate) probe_names: &'a str,
    pub(crate) probe_units: Option<&'a str>,
}

/// A number of a section; 0 where there is none.
pub(crate) fn number(numbers: Option<Numbers<'_>>, index: usize) -> f64 {
    numbers.and_then(|numbers| numbers.get(index)).unwrap_or(0.0)
}

impl<'a> Part<'a> {
    /// A file at a place; `name` goes before the names of its patterns and probes in the joined file. Reads
    /// the sections of its ports.
    ///
    /// # Errors
    /// [`PartFault`]: a body of another structure than exact steps of natural modes, sections that are
    /// missing or do not fit one another, or are compressed.
    pub fn new(name: &'a str, file: File<'a>, pose: Pose) -> Result<Self, PartFault> {
        let metadata = *file.metadata();
        if !metadata.diagonal || !metadata.scheme.is_exact() {
            return Err(PartFault::NotExact);
        }
        let numbers = |kind: S| -> Result<Option<Numbers<'a>>, PartFault> {
            Ok(file.section(kind).map(|section| section.numbers()).transpose()?)
        };
        let needed = |kind: S| numbers(kind)?.ok_or(PartFault::Missing { kind });
        let text = |kind: S| -> Result<Option<&'a str>, PartFault> {
            Ok(file.section(kind).map(|section| section.text()).transpose()?)
        };
        let indices = |kind: S| -> Result<&'a [[u8; 4]], PartFault> {
            match file.indices(kind) {
                Ok(found) => Ok(found.unwrap_or_default()),
                Err(FormatError::Index { .. }) => Err(PartFault::Disagrees { kind }),
                Err(error) => Err(error.into()),
            }
        };
        let count = |n: u32| n as usize;
        let [elastic, n_surface] = [metadata.n_modes, metadata.n_surface_nodes].map(count);
        let all_patterns = count(metadata.n_patterns);
        let rigid_section = file.section(S::RigidBody);
        let rigid = match rigid_section {
            None => None,
            Some(_) => Some(RigidBody::of(&file).ok_or(PartFault::Disagrees { kind: S::RigidBody })?),
        };
        let rigid_numbers = rigid_section.map(|section| section.f64s()).transpose()?.unwrap_or_default();
        // The patterns of the angular velocity, or of the base, are the last ones.
        let last = match (&rigid, file.section(S::BaseFrame)) {
            (Some(rigid), _) if rigid.first_pattern + SPIN != all_patterns => {
                return Err(PartFault::Disagrees { kind: S::RigidBody });
            }
            (Some(_), _) => SPIN,
            (None, Some(_)) => BASE_PATTERNS.len(),
            (None, None) => 0,
        };
        let ports = Ports::of(&file)?;
        let residual = numbers(S::PortResidual)?;
        if ports.rows > 0 && n_surface > 0 && residual.is_none() {
            return Err(PartFault::Missing { kind: S::PortResidual });
        }
        let compliance = if ports.rows > 0 { Some(needed(S::PortCompliance)?) } else { None };
        let n_probes = count(metadata.n_probes);
        let probe_motions = match (&rigid, n_probes) {
            (Some(_), 1..) => Some(needed(S::ProbeMotions)?),
            _ => None,
        };
        let dashpots = numbers(S::DampingRows)?;
        Ok(Self {
            name,
            file,
            pose,
            rigid,
            rigid_numbers,
            ports,
            elastic,
            n_surface,
            n_load: count(metadata.n_load_nodes),
            n_patterns: all_patterns.saturating_sub(last),
            n_probes,
            all_patterns,
            n_dashpots: dashpots.map_or(0, |rows| rows.len().checked_div(elastic).unwrap_or(0)),
            eigenvalues: needed(S::Eigenvalues)?,
            ratios: numbers(S::DampingRatios)?,
            dashpots,
            coordinates: needed(S::NodeCoordinates)?,
            surface: if n_surface > 0 { Some(needed(S::SurfaceBasis)?) } else { None },
            rows: numbers(S::PortRows)?,
            compliance,
            inertia: numbers(S::PortInertia)?,
            residual,
            pattern_rows: numbers(S::PatternBasis)?,
            pattern_ports: numbers(S::PortPatterns)?,
            probe_rows: numbers(S::ProbeRows)?,
            probe_ports: numbers(S::PortProbes)?,
            probe_motions,
            contact_residual: numbers(S::ContactResidual)?,
            pair_residual: numbers(S::PairResidual)?,
            pairs: indices(S::ResidualPairs)?,
            probe_residual: numbers(S::ProbeResidual)?,
            pattern_residual: numbers(S::PatternResidual)?,
            pattern_probes: numbers(S::PatternProbeResidual)?,
            triangles: indices(S::Triangles)?,
            quadrangles: indices(S::Quadrangles)?,
            quadrangle_width: file
                .section(S::Quadrangles)
                .map_or(0, |section| count(section.shape()[1] as u32)),
            pattern_names: text(S::PatternNames)?.unwrap_or(""),
            probe_names: text(S::ProbeNames)?.unwrap_or(""),
            probe_units: text(S::ProbeUnits)?,
        })
    }

    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'a str {
        self.name
    }

    /// Its file.
    #[must_use]
    pub const fn file(&self) -> &File<'a> {
        &self.file
    }

    /// Its place and rotation.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Mass, centre and moments of inertia of a body that nothing holds, before it is moved to its place.
    #[must_use]
    pub const fn rigid(&self) -> Option<&RigidBody> {
        self.rigid.as_ref()
    }

    /// Names of its ports, in the order of the file.
    pub fn port_names(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.ports.names()
    }

    /// The place of the port of this name.
    #[must_use]
    pub fn port(&self, name: &str) -> Option<usize> {
        self.ports.find(name)
    }

    /// Number of its coordinates: six of rigid motion of a free body, and one of each mode.
    #[must_use]
    pub const fn n_coordinates(&self) -> usize {
        self.n_rigid() + self.elastic
    }

    /// Number of rows of all its ports.
    #[must_use]
    pub const fn n_port_rows(&self) -> usize {
        self.ports.rows
    }

    /// The first elastic coordinate: 6 of a free body, else 0.
    #[must_use]
    pub const fn n_rigid(&self) -> usize {
        if self.rigid.is_some() { MOTIONS } else { 0 }
    }

    /// Place of a surface node in space \[m\].
    #[must_use]
    pub fn place(&self, node: usize) -> [f64; 3] {
        self.pose.place(self.local(node))
    }

    /// Place of a node in the part.
    pub(crate) fn local(&self, node: usize) -> [f64; 3] {
        let x = |c: usize| node.checked_mul(3).and_then(|first| self.coordinates.get(first + c));
        [x(0).unwrap_or(0.0), x(1).unwrap_or(0.0), x(2).unwrap_or(0.0)]
    }

    /// Diagonal of the box around its surface nodes \[m\].
    pub(crate) fn extent(&self) -> f64 {
        extent((0..self.n_surface).map(|node| self.place(node)))
    }

    /// Square of the angular frequency of a coordinate \[rad²/s²\].
    pub(crate) fn eigenvalue(&self, k: usize) -> f64 {
        k.checked_sub(self.n_rigid()).and_then(|k| self.eigenvalues.get(k)).unwrap_or(0.0)
    }

    /// `2σ` of a coordinate. Along rigid motions too, Rayleigh's damping is that of the matrix `α M + β K` of
    /// the whole body.
    pub(crate) fn damping(&self, k: usize) -> f64 {
        let [alpha, beta] = self.rayleigh();
        let value = self.eigenvalue(k);
        let ratio = k.checked_sub(self.n_rigid()).map_or(0.0, |k| number(self.ratios, k));
        alpha + beta * value + 2.0 * ratio * libm::sqrt(value)
    }

    /// Rayleigh's `α` and `β`.
    pub(crate) fn rayleigh(&self) -> [f64; 2] {
        [self.file.metadata().alpha, self.file.metadata().beta]
    }

    /// The damping ratio of every mode beside Rayleigh's, if it is the same of all and no dashpots act.
    pub(crate) fn ratio(&self) -> Option<f64> {
        let first = number(self.ratios, 0);
        let alike = self.ratios.is_none_or(|ratios| ratios.iter().all(|ratio| ratio == first));
        (alike && self.n_dashpots == 0).then_some(first)
    }

    /// A row of dashpots that couple the coordinates.
    pub(crate) fn dashpot(&self, row: usize, out: &mut [f64]) {
        self.elastic_row(self.dashpots, row, out);
    }

    /// `G R Gᵀ` of two rows of ports.
    pub(crate) fn compliance(&self, a: usize, b: usize) -> f64 {
        number(self.compliance, a * self.ports.rows + b)
    }

    /// `G R M R Gᵀ` of two rows of ports.
    pub(crate) fn inertia(&self, a: usize, b: usize) -> f64 {
        number(self.inertia, a * self.ports.rows + b)
    }

    /// True if the inertia of what its modes leave out is known at its ports.
    pub(crate) const fn has_inertia(&self) -> bool {
        self.inertia.is_some() || self.ports.rows == 0
    }

    /// Row `row` of a section over the modes, after zeros for rigid motions.
    fn elastic_row(&self, numbers: Option<Numbers<'a>>, row: usize, out: &mut [f64]) {
        out.fill(0.0);
        let start = row * self.elastic;
        let places = out.iter_mut().skip(self.n_rigid());
        places.enumerate().for_each(|(k, out)| *out = number(numbers, start + k));
    }

    /// A row of a port over the coordinates, `G B`.
    pub(crate) fn port_row(&self, port: &Port<'_>, row: usize, out: &mut [f64]) {
        self.elastic_row(self.rows, port.first + row, out);
        let Some(rigid) = &self.rigid else { return };
        for (k, out) in out.iter_mut().take(MOTIONS).enumerate() {
            *out = port.row(row, |node| self.local(node), |x| moved(rigid, k, x), turned(rigid, k));
        }
    }

    /// Rows of a surface node over the coordinates, `B` turned to its place, three rows of as many numbers.
    pub(crate) fn node_rows(&self, node: usize, out: &mut [f64]) {
        let (r, own) = (self.n_coordinates(), self.n_rigid());
        for k in 0..r {
            let local = match (&self.rigid, k.checked_sub(own)) {
                (Some(rigid), None) => moved(rigid, k, self.local(node)),
                (_, mode) => {
                    let k = mode.unwrap_or(k);
                    let value = |c: usize| number(self.surface, (3 * node + c) * self.elastic + k);
                    [value(0), value(1), value(2)]
                }
            };
            for (c, u) in self.pose.turn(local).into_iter().enumerate() {
                if let Some(out) = out.get_mut(c * r + k) {
                    *out = u;
                }
            }
        }
    }

    /// `R Gᵀ` of a row of ports at a surface node, in space.
    pub(crate) fn node_residual(&self, node: usize, row: usize) -> [f64; 3] {
        let start = 3 * (row * self.n_surface + node);
        let value = |c: usize| number(self.residual, start + c);
        self.pose.turn([value(0), value(1), value(2)])
    }

    /// `BᵀF` of a pattern over the coordinates; of all patterns of the file.
    pub(crate) fn pattern_row(&self, pattern: usize, out: &mut [f64]) {
        self.elastic_row(self.pattern_rows, pattern, out);
        let Some(rigid) = &self.rigid else { return };
        let wrench = self.pattern_wrench(pattern);
        out.iter_mut().take(MOTIONS).enumerate().for_each(|(k, out)| *out = work(rigid, k, wrench));
    }

    /// `G R F` of a pattern at a row of ports.
    pub(crate) fn pattern_port(&self, pattern: usize, row: usize) -> f64 {
        number(self.pattern_ports, row * self.all_patterns + pattern)
    }

    /// Force and moment about the centre of a pattern of a free body, in the part.
    pub(crate) fn pattern_wrench(&self, pattern: usize) -> [[f64; 3]; 2] {
        let start = RIGID + MOTIONS * pattern;
        let value =
            |k: usize| self.rigid_numbers.get(start + k).map_or(0.0, |bytes| f64::from_le_bytes(*bytes));
        [[value(0), value(1), value(2)], [value(3), value(4), value(5)]]
    }

    /// Moments of inertia about the centre, in space.
    pub(crate) fn inertia_tensor(&self) -> [[f64; 3]; 3] {
        let value = |k: usize| self.rigid_numbers.get(k).map_or(0.0, |bytes| f64::from_le_bytes(*bytes));
        let [xx, xy, xz, yy, yz, zz] = [value(4), value(5), value(6), value(7), value(8), value(9)];
        self.pose.turn_matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }

    /// A probe over the coordinates.
    pub(crate) fn probe_row(&self, probe: usize, out: &mut [f64]) {
        self.elastic_row(self.probe_rows, probe, out);
        let Some(rigid) = &self.rigid else { return };
        let motions = self.probe_motions(probe);
        out.iter_mut().take(MOTIONS).enumerate().for_each(|(k, out)| *out = work(rigid, k, motions));
    }

    /// Value of a probe as the part moves along and turns about its axes through its centre.
    pub(crate) fn probe_motions(&self, probe: usize) -> [[f64; 3]; 2] {
        let value = |k: usize| number(self.probe_motions, MOTIONS * probe + k);
        [[value(0), value(1), value(2)], [value(3), value(4), value(5)]]
    }

    /// A probe's value of `R Gᵀ` of a row of ports.
    pub(crate) fn probe_port(&self, probe: usize, row: usize) -> f64 {
        number(self.probe_ports, row * self.n_probes + probe)
    }

    /// Coordinates of a rigid motion of a free body: a displacement of its centre and a small rotation about
    /// it, in the part, or their rates. Nothing of a body that is held.
    #[must_use]
    pub fn rigid_coordinates(&self, moved: [f64; 3], turned: [f64; 3]) -> [f64; 6] {
        let Some(rigid) = &self.rigid else { return [0.0; 6] };
        let [x, y, z] = moved.map(|u| libm::sqrt(rigid.mass) * u);
        let about = |k: usize| {
            let (axis, moment) = (rigid.axes.get(k), rigid.moments.get(k));
            axis.zip(moment).map_or(0.0, |(axis, moment)| libm::sqrt(*moment) * dot(*axis, turned))
        };
        [x, y, z, about(0), about(1), about(2)]
    }

    /// The displacement of the centre of a free body and its small rotation, in the part, of its coordinates;
    /// or their rates.
    #[must_use]
    pub fn rigid_motion(&self, coordinates: &[f64]) -> [[f64; 3]; 2] {
        let Some(rigid) = &self.rigid else { return [[0.0; 3]; 2] };
        let mut motion = [[0.0; 3]; 2];
        for k in 0..MOTIONS {
            let q = at(coordinates, k);
            motion[0] = add(motion[0], q, moved(rigid, k, rigid.centre));
            motion[1] = add(motion[1], q, turned(rigid, k));
        }
        motion
    }
}

/// Rotation by a rigid motion whose mass is 1.
fn turned(rigid: &RigidBody, motion: usize) -> [f64; 3] {
    let k = motion.wrapping_sub(3);
    let (axis, moment) = (rigid.axes.get(k), rigid.moments.get(k));
    axis.zip(moment).map_or([0.0; 3], |(axis, moment)| axis.map(|a| a / libm::sqrt(*moment)))
}

/// Displacement of a point by it.
fn moved(rigid: &RigidBody, motion: usize, x: [f64; 3]) -> [f64; 3] {
    let by_turn = cross(turned(rigid, motion), minus(x, rigid.centre));
    SPACE.get(motion).map_or(by_turn, |along| add(by_turn, 1.0 / libm::sqrt(rigid.mass), *along))
}

/// Work of a force and a moment about the centre on it.
pub(crate) fn work(rigid: &RigidBody, motion: usize, [force, moment]: [[f64; 3]; 2]) -> f64 {
    dot(moved(rigid, motion, rigid.centre), force) + dot(turned(rigid, motion), moment)
}

/// Diagonal of the box around points.
pub(crate) fn extent(points: impl Iterator<Item = [f64; 3]>) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        let corners = low.iter_mut().zip(&mut high).zip(point);
        corners.for_each(|((low, high), x)| (*low, *high) = (low.min(x), high.max(x)));
    }
    let sides = minus(high, low);
    if sides[0] < 0.0 { 0.0 } else { libm::sqrt(dot(sides, sides)) }
}
