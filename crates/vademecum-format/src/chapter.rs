//! The chapter's structure: the stage maps of chapter 5 as it prints them (equations 5.8 and 5.9, key
//! `chapter5` of `docs/reference/bibliography.md`), kept as a baseline. The file format calls it the
//! *canonical* structure, and the sections and refusals keep that name because files stay readable for ever.
//!
//! Every coordinate of the state, the magnitude of the load and its position is an axis with one-dimensional
//! functions of its own. Stage `i` of the scheme is `ζ_i = Σ_parts Σ_t (Π_a g_ta(x_a)) f_t` with
//! `f_t = ΠF_t`, which are r numbers per term. A part has terms over some of the axes: over all of them
//! (a *joint* part, as the chapter prints it), or over the state alone and the load alone. The new state
//! follows from `ζ` and the `ζ_i` by the scheme's `finish`. There are more axes than the metadata have places
//! for, so they are a table of numbers, which is checked when the file is opened.

use crate::error::FormatError;
use crate::kind::{CHAPTER_AXIS, SectionKind};
use crate::metadata::{MAX_TERMS, Metadata};
use crate::read::File;
use crate::scheme::{HISTORY, MAX_STAGES};
use core::fmt;

/// Most points an axis of the chapter's structure may have.
pub const MAX_CHAPTER_POINTS: usize = 1 << 20;

/// What runs along an axis. The order is that of the axes of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ChapterRole {
    /// Entry `mode` of family `family` of the history `(ζ, Δt ζ̇, Δt² ζ̈, ζ_1, …)`.
    State {
        /// Place in the history.
        family: usize,
        /// Mode, counted from 0.
        mode: usize,
    },
    /// Magnitude of the load \[N\].
    Magnitude,
    /// Component of the load's direction, 0 to 2.
    Component {
        /// x, y, z.
        component: usize,
    },
    /// Place in the list of load positions.
    Position,
}

impl fmt::Display for ChapterRole {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::State { family: 0, mode } => write!(out, "zeta of mode {}", mode + 1),
            Self::State { family: 1, mode } => write!(out, "zeta_dot of mode {}", mode + 1),
            Self::State { family: 2, mode } => write!(out, "zeta_ddot of mode {}", mode + 1),
            Self::State { family, mode } => {
                write!(out, "zeta after stage {} of mode {}", family.saturating_sub(2), mode + 1)
            }
            Self::Magnitude => write!(out, "the magnitude of the load"),
            Self::Component { component } => write!(out, "component {} of the load", component + 1),
            Self::Position => write!(out, "the position of the load"),
        }
    }
}

/// Codes of the roles after the families.
const MAGNITUDE: usize = HISTORY;
const COMPONENT: usize = HISTORY + 1;
const POSITION: usize = HISTORY + 2;

/// One axis of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChapterAxis {
    /// What runs along it.
    pub role: ChapterRole,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// Points, equidistant, with hat functions between them; a position axis has one per position and nothing
    /// between.
    pub points: usize,
    /// The axis' coordinate is this times the entry of the history (1 for the load's axes).
    pub factor: f64,
}

impl ChapterAxis {
    /// Its row in the file.
    #[must_use]
    pub fn row(&self) -> [f64; CHAPTER_AXIS] {
        let (role, index) = match self.role {
            ChapterRole::State { family, mode } => (family, mode),
            ChapterRole::Magnitude => (MAGNITUDE, 0),
            ChapterRole::Component { component } => (COMPONENT, component),
            ChapterRole::Position => (POSITION, 0),
        };
        [role as f64, index as f64, self.lower, self.upper, self.points as f64, self.factor]
    }

    fn from_row(row: &[[u8; 8]]) -> Option<Self> {
        let number = |place: usize| row.get(place).map(|&bytes| f64::from_le_bytes(bytes));
        let whole = |place: usize| {
            let value = number(place)?;
            let count = value as usize; // saturates; NaN gives 0
            (count as f64 == value && count <= MAX_CHAPTER_POINTS).then_some(count)
        };
        let index = whole(1)?;
        let role = match whole(0)? {
            family if family < HISTORY => ChapterRole::State { family, mode: index },
            MAGNITUDE => ChapterRole::Magnitude,
            COMPONENT => ChapterRole::Component { component: index },
            POSITION => ChapterRole::Position,
            _ => return None,
        };
        Some(Self { role, lower: number(2)?, upper: number(3)?, points: whole(4)?, factor: number(5)? })
    }

    /// Whether it is an axis of the state.
    #[must_use]
    pub const fn is_state(&self) -> bool {
        matches!(self.role, ChapterRole::State { .. })
    }

    fn is_sound(&self, stage: usize, n_modes: usize, n_positions: usize) -> bool {
        use ChapterRole as R;
        let ordered = self.lower.is_finite() && self.upper.is_finite() && self.lower < self.upper;
        let hat = ordered && self.points >= 2 && self.factor.is_finite() && self.factor > 0.0;
        match self.role {
            R::State { family, mode } => hat && family < 3 + stage && mode < n_modes,
            R::Magnitude => hat && self.factor == 1.0,
            R::Component { component } => hat && component < 3 && self.factor == 1.0,
            R::Position => {
                let ends = self.lower == 0.0 && self.upper + 1.0 == n_positions as f64;
                ends && self.points == n_positions && self.points >= 1 && self.factor == 1.0
            }
        }
    }
}

/// Terms over some axes of one stage.
#[derive(Clone, Copy, Debug)]
pub struct ChapterPart<'a> {
    /// The stage, counted from 0.
    pub stage: usize,
    /// Number of terms.
    pub n_terms: usize,
    axes: &'a [[u8; 8]],
    /// Factors of its axes, one axis after the other, each `(n_points, n_terms)`.
    pub factors: &'a [[u8; 8]],
    /// `(n_terms, r)`: the projected space functions.
    pub terms: &'a [[u8; 8]],
}

impl<'a> ChapterPart<'a> {
    /// Its axes.
    pub fn axes(&self) -> impl Iterator<Item = ChapterAxis> + use<'a> {
        self.axes.chunks_exact(CHAPTER_AXIS).filter_map(ChapterAxis::from_row)
    }

    /// Points of all its axes.
    fn n_points(&self) -> Option<usize> {
        self.axes().try_fold(0usize, |sum, axis| sum.checked_add(axis.points))
    }

    /// Whether it has axes of the state: they come first.
    #[must_use]
    pub fn has_state(&self) -> bool {
        self.axes().next().is_some_and(|axis| axis.is_state())
    }

    /// Whether it has axes of the load: they come last.
    #[must_use]
    pub fn has_load(&self) -> bool {
        let last = self.axes.chunks_exact(CHAPTER_AXIS).next_back().and_then(ChapterAxis::from_row);
        last.is_some_and(|axis| !axis.is_state())
    }
}

/// The first `length` numbers, which `from` loses; `None` if it has fewer.
fn take<'a>(from: &mut &'a [[u8; 8]], length: usize) -> Option<&'a [[u8; 8]]> {
    let (front, rest) = from.split_at_checked(length)?;
    *from = rest;
    Some(front)
}

/// The chapter's structure of a file, checked.
#[derive(Clone, Copy, Debug)]
pub struct Chapter<'a> {
    n_modes: usize,
    parts: &'a [[u8; 4]],
    axes: &'a [[u8; 8]],
    factors: &'a [[u8; 8]],
    terms: &'a [[u8; 8]],
    positions: &'a [[u8; 4]],
    direction: Option<[f64; 3]>,
}

impl<'a> Chapter<'a> {
    /// Reads and checks the structure; `None` if the file does not have it. Costs one look at the tables of
    /// parts, axes and positions; factors and terms are not touched.
    ///
    /// # Errors
    /// Refusals 26, 28 (a section is compressed) and 32 to 35.
    pub fn read(file: &File<'a>) -> Result<Option<Self>, FormatError> {
        use SectionKind as S;
        let Some(parts) = file.section(S::CanonicalParts) else { return Ok(None) };
        let section = |kind: S| file.section(kind).ok_or(FormatError::Missing { kind: kind.number() });
        let direction = match file.section(S::CanonicalDirection) {
            None => None,
            Some(section) => section.f64s()?.first_chunk::<3>().map(|d| d.map(f64::from_le_bytes)),
        };
        section(S::CanonicalCertificate)?;
        let chapter = Self {
            n_modes: file.metadata().n_modes as usize,
            parts: parts.u32s()?,
            axes: section(S::CanonicalAxes)?.f64s()?,
            factors: section(S::CanonicalFactors)?.f64s()?,
            terms: section(S::CanonicalTerms)?.f64s()?,
            positions: section(S::CanonicalPositions)?.u32s()?,
            direction,
        };
        chapter.check(file.metadata())?;
        Ok(Some(chapter))
    }

    /// The parts, stage by stage.
    pub fn parts(&self) -> impl Iterator<Item = ChapterPart<'a>> + use<'a> {
        let (n_modes, mut factors, mut terms) = (self.n_modes, self.factors, self.terms);
        // The sums of both lengths have been checked: no part is left out.
        self.table().map_while(move |part| {
            let factors = take(&mut factors, part.n_points()?.checked_mul(part.n_terms)?)?;
            let terms = take(&mut terms, part.n_terms.checked_mul(n_modes)?)?;
            Some(ChapterPart { factors, terms, ..part })
        })
    }

    /// The parts with their axes, without factors and terms.
    fn table(&self) -> impl Iterator<Item = ChapterPart<'a>> + use<'a> {
        let (parts, mut axes) = (self.parts.as_chunks::<3>().0, self.axes);
        parts.iter().map_while(move |part| {
            let [stage, n_axes, n_terms] = part.map(|bytes| u32::from_le_bytes(bytes) as usize);
            let axes = take(&mut axes, n_axes.checked_mul(CHAPTER_AXIS)?)?;
            Some(ChapterPart { stage, n_terms, axes, factors: &[], terms: &[] })
        })
    }

    /// Numbers of all factors, and of all terms.
    #[must_use]
    pub const fn lengths(&self) -> (usize, usize) {
        (self.factors.len(), self.terms.len())
    }

    /// Most terms of a part.
    #[must_use]
    pub fn max_terms(&self) -> usize {
        self.parts().map(|part| part.n_terms).fold(0, usize::max)
    }

    /// Number of load positions.
    #[must_use]
    pub const fn n_positions(&self) -> usize {
        self.positions.len()
    }

    /// Loadable nodes the load can stand at, in the order of the position axis.
    pub fn positions(&self) -> impl Iterator<Item = u32> + use<'a> {
        self.positions.iter().map(|&bytes| u32::from_le_bytes(bytes))
    }

    /// Direction of the load, of length 1; `None` when its components are axes.
    #[must_use]
    pub const fn direction(&self) -> Option<[f64; 3]> {
        self.direction
    }

    /// Refusals 32 to 35.
    fn check(&self, metadata: &Metadata<'_>) -> Result<(), FormatError> {
        let (table, rest) = self.parts.as_chunks::<3>();
        let part = |place: usize| FormatError::CanonicalPart { part: place as u32 };
        if table.len() > 2 * MAX_STAGES || !rest.is_empty() {
            return Err(part(table.len()));
        }
        self.check_axes(metadata)?;
        let n_stages = usize::from(metadata.scheme.n_stages);
        let mut kinds = [[0u8; 3]; MAX_STAGES];
        let mut latest = 0;
        for (place, p) in self.table().enumerate() {
            let kind = match (p.has_state(), p.has_load()) {
                (true, false) => 0,
                (false, true) => 1,
                _ => 2,
            };
            let terms = p.n_terms >= 1 && p.n_terms <= MAX_TERMS as usize;
            let count = kinds.get_mut(p.stage).and_then(|kinds| kinds.get_mut(kind));
            let (true, Some(count)) = (terms && p.stage < n_stages && p.stage >= latest, count) else {
                return Err(part(place));
            };
            *count = count.saturating_add(1);
            latest = p.stage;
        }
        // Every stage alike: state and load apart, or together.
        let alike = |whole: [u8; 3]| kinds.iter().take(n_stages).all(|kinds| *kinds == whole);
        if !alike([1, 1, 0]) && !alike([0, 0, 1]) {
            return Err(part(table.len()));
        }
        self.check_lengths()?;
        self.check_load(metadata)
    }

    /// Refusal 33, and 32 where the parts do not ask for all axes.
    fn check_axes(&self, metadata: &Metadata<'_>) -> Result<(), FormatError> {
        let (mut rows, mut place) = (self.axes.chunks_exact(CHAPTER_AXIS), 0u32);
        for (number, part) in self.parts.as_chunks::<3>().0.iter().enumerate() {
            let [stage, n_axes, _] = part.map(|bytes| u32::from_le_bytes(bytes) as usize);
            let (mut before, mut load) = (None, [false; 2]);
            for _ in 0..n_axes {
                let row = rows.next().ok_or(FormatError::CanonicalPart { part: number as u32 })?;
                let axis = ChapterAxis::from_row(row).filter(|axis| {
                    axis.is_sound(stage, metadata.n_modes as usize, self.positions.len())
                        && before.is_none_or(|role| role < axis.role)
                });
                let axis = axis.ok_or(FormatError::CanonicalAxis { axis: place })?;
                before = Some(axis.role);
                load[0] |= axis.role == ChapterRole::Magnitude;
                load[1] |= axis.role == ChapterRole::Position;
                place = place.saturating_add(1);
            }
            // A load has a magnitude and a position, or the part knows none of it.
            if n_axes == 0 || load[0] != load[1] {
                return Err(FormatError::CanonicalPart { part: number as u32 });
            }
        }
        if rows.next().is_some() {
            return Err(FormatError::CanonicalAxis { axis: place });
        }
        Ok(())
    }

    /// Refusal 34.
    fn check_lengths(&self) -> Result<(), FormatError> {
        let (mut factors, mut terms) = (0u64, 0u64);
        for part in self.table() {
            let points: u64 = part.axes().map(|axis| axis.points as u64).sum();
            factors = factors.saturating_add(points.saturating_mul(part.n_terms as u64));
            terms = terms.saturating_add((part.n_terms as u64).saturating_mul(self.n_modes as u64));
        }
        for (kind, found, expected) in [
            (SectionKind::CanonicalFactors, self.factors.len() as u64, factors),
            (SectionKind::CanonicalTerms, self.terms.len() as u64, terms),
        ] {
            if found != expected {
                return Err(FormatError::CanonicalLength { kind: kind.number(), found, expected });
            }
        }
        Ok(())
    }

    /// Refusal 35.
    fn check_load(&self, metadata: &Metadata<'_>) -> Result<(), FormatError> {
        let bad = self.positions().position(|node| node >= metadata.n_load_nodes);
        if let Some(place) = bad {
            return Err(FormatError::CanonicalLoad { place: place as u32 });
        }
        let components = self
            .parts()
            .flat_map(|part| part.axes())
            .any(|axis| matches!(axis.role, ChapterRole::Component { .. }));
        let finite = self.direction.is_none_or(|d| d.iter().all(|x| x.is_finite()));
        if finite && components != self.direction.is_some() {
            return Ok(());
        }
        Err(FormatError::CanonicalLoad { place: self.positions.len() as u32 })
    }
}
