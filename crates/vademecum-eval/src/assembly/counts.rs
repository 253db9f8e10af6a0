//! Counts of a joined body and the memory that joining wants, from the parts and the joints alone.

use crate::assembly::error::{AssemblyError, PartFault};
use crate::assembly::joint::{Joint, Offset, of_joint};
use crate::assembly::part::{MOTIONS, Part, SPIN};
use crate::assembly::rows::ROW;
use crate::assembly::text::lines;
use crate::kernels::eigen::eigen_work;
use vademecum_format::{BASE_PATTERNS, MAX_MODES, SectionKind};

/// Largest number of rows of all joints, whose matrix is dense.
const MAX_ROWS: usize = 8192;

/// Name of the load pattern of joints that are made as they stand.
pub(crate) const GLUE: &str = "glue";

/// Counts of a joined body.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub joints: usize,
    /// Coordinates of all parts, and rows of all joints.
    pub r: usize,
    pub m: usize,
    /// The first mode that the file has: 6 of a free body, whose rigid motions are none, else 0.
    pub first_mode: usize,
    pub nodes: usize,
    pub load_nodes: usize,
    pub triangles: usize,
    pub load_triangles: usize,
    pub quadrangles: usize,
    pub quadrangle_width: usize,
    /// Patterns of the parts, and all patterns.
    pub own_patterns: usize,
    pub patterns: usize,
    pub probes: usize,
    pub pairs: usize,
    /// True if a joint has an offset.
    pub glued: bool,
    /// True if nothing holds the body.
    pub free: bool,
    /// True if every part has residual flexibility under contacts.
    pub residual: bool,
    /// True if every row of a joint holds.
    pub rigid: bool,
    /// True if all parts are damped alike, so that no modes are coupled.
    pub alike: bool,
    /// Lengths of the names.
    pub pattern_text: usize,
    pub probe_text: usize,
    pub unit_text: usize,
}

/// Bytes of a text of one name a line.
struct Text(usize);

impl Text {
    fn add(&mut self, length: usize) {
        self.0 += length + usize::from(self.0 > 0);
    }
}

impl Counts {
    /// Counts of these parts and joints.
    pub fn of(parts: &[Part<'_>], joints: &[Joint<'_>]) -> Result<Self, AssemblyError> {
        if parts.is_empty() {
            return Err(AssemblyError::Count { what: "parts", found: 0, most: MAX_MODES as usize });
        }
        let mut own =
            Self { joints: joints.len(), rigid: true, residual: true, free: true, ..Self::default() };
        let (mut patterns, mut probes, mut units) = (Text(0), Text(0), Text(0));
        for (index, part) in parts.iter().enumerate() {
            if !part.pose.is_sound() {
                return Err(AssemblyError::Part { part: index, fault: PartFault::Pose });
            }
            let sound = |k: usize| (0.0..f64::INFINITY).contains(&part.eigenvalue(k));
            if !(0..part.n_coordinates()).all(sound) {
                let kind = SectionKind::Eigenvalues;
                return Err(AssemblyError::Part { part: index, fault: PartFault::Disagrees { kind } });
            }
            let metadata = part.file.metadata();
            own.r += part.n_coordinates();
            own.nodes += part.n_surface;
            own.load_nodes += part.n_load;
            own.triangles += metadata.n_triangles as usize;
            own.load_triangles += metadata.n_load_triangles as usize;
            own.quadrangles += part.quadrangles.len().checked_div(part.quadrangle_width).unwrap_or(0);
            own.quadrangle_width = own.quadrangle_width.max(part.quadrangle_width);
            own.own_patterns += part.n_patterns;
            own.probes += part.n_probes;
            own.pairs += part.pairs.len() / 2;
            own.free &= part.rigid.is_some();
            own.residual &= part.n_load == 0 || part.contact_residual.is_some();
            let prefix = part.name.len() + 1;
            let lengths = |names, count| padded(names, count, "").map(move |name| prefix + name.len());
            lengths(part.pattern_names, part.n_patterns).for_each(|length| patterns.add(length));
            lengths(part.probe_names, part.n_probes).for_each(|length| probes.add(length));
            padded(part.probe_units.unwrap_or(""), part.n_probes, "m").for_each(|unit| units.add(unit.len()));
        }
        own.count_joints(parts, joints)?;
        if own.r > MAX_MODES as usize {
            return Err(AssemblyError::Count { what: "modes", found: own.r, most: MAX_MODES as usize });
        }
        own.residual &= own.load_nodes > 0;
        own.patterns = own.own_patterns;
        if own.glued {
            own.patterns += 1;
            patterns.add(GLUE.len());
        }
        if own.free {
            own.first_mode = MOTIONS;
            own.patterns += SPIN;
            spin_names().for_each(|name| patterns.add(name.len()));
        }
        own.pattern_text = patterns.0;
        own.probe_text = probes.0;
        own.unit_text = if parts.iter().any(|part| part.probe_units.is_some()) { units.0 } else { 0 };
        own.alike = alike(parts, own.rigid);
        if own.n_modes() == 0 {
            let kind = SectionKind::Eigenvalues;
            return Err(AssemblyError::Part { part: 0, fault: PartFault::Missing { kind } });
        }
        Ok(own)
    }

    fn count_joints(&mut self, parts: &[Part<'_>], joints: &[Joint<'_>]) -> Result<(), AssemblyError> {
        let mut standing = false;
        for (index, joint) in joints.iter().enumerate() {
            let refused = of_joint(index);
            let sides = joint.ports(parts).map_err(&refused)?;
            let (mut count, mut rigid) = (0, true);
            let counted = joint.each_row(&sides, |place| {
                count += 1;
                rigid &= place.compliance == 0.0;
            });
            counted.map_err(&refused)?;
            self.m += count;
            self.rigid &= rigid;
            self.free &= joint.second().is_some();
            use crate::assembly::error::JointFault as F;
            match joint.offset {
                Offset::None if standing => return Err(refused(F::Order)),
                Offset::Of(_) if standing => return Err(refused(F::Order)),
                Offset::Of(given) if given.len() != count => {
                    return Err(refused(F::Offsets { found: given.len(), expected: count }));
                }
                Offset::None => {}
                Offset::Of(_) => self.glued = true,
                Offset::AsItStands => (self.glued, standing) = (true, true),
            }
            if self.m > MAX_ROWS {
                return Err(AssemblyError::Count { what: "rows of joints", found: self.m, most: MAX_ROWS });
            }
        }
        Ok(())
    }

    /// Modes that the file has.
    pub const fn n_modes(&self) -> usize {
        self.r.saturating_sub(self.first_mode)
    }

    /// Numbers that the assembly keeps.
    pub fn memory_len(&self) -> usize {
        let Self { r, m, joints, .. } = *self;
        joints + m * ROW + m * m + m * r + 2 * r * r + m + r
    }

    /// Numbers of work of the synthesis.
    pub fn synthesis_work(&self) -> usize {
        let Self { r, m, .. } = *self;
        2 * r * r + eigen_work(r) + m * m + m * r + r
    }

    /// Numbers that damping leaves in the work, and those it takes.
    pub fn damping_work(&self) -> [usize; 2] {
        let (r, m, n) = (self.r, self.m, self.n_modes());
        if self.alike {
            return [n, 0];
        }
        [n + n * n, 3 * r * r + n + eigen_work(n) + m * m + m * r + 4 * n * n + 2 * n + r]
    }

    /// Numbers of work of the sections.
    pub fn section_work(&self) -> usize {
        let Self { r, m, .. } = *self;
        let nodes = if self.residual { 3 * self.load_nodes } else { 0 };
        (self.patterns + self.probes) * (r + m) + nodes * m + 4 * r + 3 * m
    }

    /// Numbers of work altogether.
    pub fn work_len(&self) -> usize {
        let [kept, damping] = self.damping_work();
        kept + self.synthesis_work().max(damping).max(self.section_work())
    }

    /// The place in the joined file of the first loadable and of the first other node of a part.
    pub fn node_starts(&self, parts: &[Part<'_>], part: usize) -> [usize; 2] {
        let before = parts.iter().take(part);
        before.fold([0, self.load_nodes], |[load, other], part| {
            [load + part.n_load, other + part.n_surface.saturating_sub(part.n_load)]
        })
    }
}

/// Names of the patterns of the angular velocity.
pub(crate) fn spin_names() -> impl Iterator<Item = &'static str> {
    BASE_PATTERNS.into_iter().skip(BASE_PATTERNS.len() - SPIN)
}

/// So many lines of a text, `filler` where there are fewer.
pub(crate) fn padded<'a>(text: &'a str, count: usize, filler: &'a str) -> impl Iterator<Item = &'a str> {
    lines(text).chain(core::iter::repeat(filler)).take(count)
}

/// True if all parts have one Rayleigh damping and one ratio, so that the joined body has these.
fn alike(parts: &[Part<'_>], rigid: bool) -> bool {
    let of = |part: &Part<'_>| Some((part.rayleigh(), part.ratio()?));
    let Some(first) = parts.first().and_then(of) else { return false };
    let ([_, beta], _) = first;
    parts.iter().all(|part| of(part) == Some(first)) && (rigid || beta == 0.0)
}

/// The coordinate at which each part begins, with the part.
pub(crate) fn with_firsts<'p, 'a>(
    parts: &'p [Part<'a>],
) -> impl Iterator<Item = (usize, &'p Part<'a>)> + Clone + use<'p, 'a> {
    parts.iter().scan(0, |next, part| {
        let first = *next;
        *next += part.n_coordinates();
        Some((first, part))
    })
}
