//! The state of a body as bytes: a tag of 16, then little-endian numbers (`formats/state-1.md`).

use core::fmt;

use crate::base::scalar::Scalar;
use crate::body::body::Body;
use crate::flight::rigid::RigidMotion;
use crate::scene::scene::Scene;
use crate::scene::state::State;
use crate::sections::residual::Statics;

/// First bytes of every saved state; the last of them is the version of the layout.
const MAGIC: [u8; 4] = *b"VDS\x01";
/// Bytes of the tag.
const TAG: usize = 16;

/// The body has not started yet.
const UNSTARTED: u8 = 1;
/// The body rests.
const AT_REST: u8 = 2;
/// The forces of the last step are there.
const FORCES: u8 = 4;
/// The rigid motion of a flight is there.
const FLIGHT: u8 = 8;
/// The filtered forces of the residual flexibility are there.
const FILTERED: u8 = 16;
/// Every flag that this version knows.
const KNOWN: u8 = UNSTARTED | AT_REST | FORCES | FLIGHT | FILTERED;

/// Result of [`Body::restore`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Restored {
    /// Every bit is as it was saved.
    AsSaved,
    /// The state was saved at other parameters or in another precision: displacement and velocity are what
    /// they were, their numbers were scaled or rounded.
    Carried,
}

/// Why a state was neither saved nor restored; nothing has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SavedError {
    /// The bytes do not begin with the tag of a saved state of this version.
    Untagged,
    /// There are fewer or more bytes than the state has.
    Length {
        /// Bytes lent.
        found: usize,
        /// Bytes needed.
        needed: usize,
    },
    /// The state is that of another file.
    OtherFile,
    /// The state is that of another structure.
    OtherStructure,
    /// The state holds what this version does not know, or a flight that the body does not have.
    OtherContents,
    /// A number is not finite, or leaves the precision of the body.
    NotFinite,
    /// The forces of the last step stand on more nodes than the body has room for.
    TooManyContacts,
}

impl fmt::Display for SavedError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Untagged => write!(out, "these bytes are no saved state of this version"),
            Self::Length { found, needed } => {
                write!(out, "{found} bytes for a saved state of {needed} bytes")
            }
            Self::OtherFile => write!(out, "the saved state is that of another file"),
            Self::OtherStructure => write!(out, "the saved state is that of another structure"),
            Self::OtherContents => write!(
                out,
                "the saved state holds what this version does not know, or a rigid motion that this body does \
                 not have"
            ),
            Self::NotFinite => {
                write!(out, "a number of the saved state is not finite in the precision of the body")
            }
            Self::TooManyContacts => write!(
                out,
                "the saved state has forces on more nodes than there is room for; raise \
                 `SceneOptions::contacts`"
            ),
        }
    }
}

impl core::error::Error for SavedError {}

/// Writes numbers one after the other.
struct Pen<'a> {
    left: &'a mut [u8],
    written: usize,
}

impl Pen<'_> {
    fn number(&mut self, number: f64) -> Option<()> {
        let (place, left) = core::mem::take(&mut self.left).split_first_chunk_mut()?;
        *place = number.to_le_bytes();
        (self.left, self.written) = (left, self.written + 8);
        Some(())
    }

    fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) -> Option<()> {
        numbers.into_iter().try_for_each(|number| self.number(number))
    }

    /// Counts, forces on nodes, and amplitudes of patterns.
    fn forces<T: Scalar>(&mut self, forces: &Statics<'_, T>, patterns: usize) -> Option<()> {
        self.numbers([forces.forces().count() as f64, patterns as f64])?;
        for (node, [x, y, z]) in forces.forces() {
            self.numbers([node as f64, x, y, z])?;
        }
        self.numbers(forces.all_amplitudes())
    }
}

/// Reads them again.
#[derive(Clone, Copy)]
struct Cursor<'a> {
    left: &'a [[u8; 8]],
}

impl Cursor<'_> {
    fn number(&mut self) -> Option<f64> {
        let (&bytes, left) = self.left.split_first()?;
        self.left = left;
        Some(f64::from_le_bytes(bytes))
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        numbers.iter_mut().try_for_each(|number| self.number().map(|read| *number = read))?;
        Some(numbers)
    }

    /// Takes forces that were checked.
    fn forces<T: Scalar>(&mut self, forces: &mut Statics<'_, T>) {
        forces.clear();
        let [nodes, patterns] = self.numbers().unwrap_or_default();
        for _ in 0..nodes as usize {
            let Some([node, force @ ..]) = self.numbers::<4>() else { break };
            forces.add_force(node, force);
        }
        for index in 0..patterns as usize {
            let amplitude = self.number().unwrap_or_default();
            if amplitude != 0.0 {
                forces.add_pattern(index, amplitude);
            }
        }
    }
}

impl<T: Scalar> Body<'_, T> {
    /// Bytes that [`Body::save_into`] writes at most.
    #[must_use]
    pub fn saved_len(&self) -> usize {
        let shape = &self.scene.shape;
        let forces = 2usize.saturating_add(4 * shape.statics[0]).saturating_add(shape.statics[1]);
        let filtered = if shape.is_filtered() {
            4usize.saturating_add(4 * shape.filtered[0]).saturating_add(shape.filtered[1])
        } else {
            0
        };
        let numbers = parameters(&self.scene).count() + self.scene.state_numbers() + forces + filtered + 13;
        TAG + numbers.saturating_mul(8)
    }

    /// Writes everything that a step changes: elastic motion, forces of the last step, and the rigid motion
    /// of a flight; and the parameters they belong to. Loads are not part of it. Gives the bytes written.
    ///
    /// # Errors
    /// [`SavedError::Length`].
    pub fn save_into(&self, out: &mut [u8]) -> Result<usize, SavedError> {
        let short = SavedError::Length { found: out.len(), needed: self.saved_len() };
        let (tag, numbers) = out.split_first_chunk_mut::<TAG>().ok_or(short)?;
        let y = &self.state.y;
        let flag = |flag: u8, there: bool| if there { flag } else { 0 };
        let flags = flag(UNSTARTED, y.unstarted)
            | flag(AT_REST, y.at_rest)
            | flag(FORCES, !self.state.statics.forgotten)
            | flag(FLIGHT, self.flight.is_some())
            | flag(FILTERED, self.scene.shape.is_filtered());
        *tag = self.tag(size_of::<T>() as u8, flags);
        let mut pen = Pen { left: numbers, written: TAG };
        pen.numbers(parameters(&self.scene)).ok_or(short)?;
        for part in 0..self.scene.shape.n_parts() {
            pen.numbers(y.part(part).iter().map(|x| x.to_f64())).ok_or(short)?;
        }
        let statics = &self.state.statics;
        pen.forces(statics, self.scene.shape.statics[1]).ok_or(short)?;
        if self.scene.shape.is_filtered() {
            let filtered = &self.state.filtered;
            pen.forces(&filtered.forces, self.scene.shape.filtered[1]).ok_or(short)?;
            pen.numbers(filtered.largest.map(T::to_f64)).ok_or(short)?;
        }
        if let Some(free) = &self.flight {
            let RigidMotion { position, attitude, momentum, angular_momentum } = *free.motion();
            let all = position.into_iter().chain(attitude).chain(momentum).chain(angular_momentum);
            pen.numbers(all).ok_or(short)?;
        }
        Ok(pen.written)
    }

    /// Takes back what [`Body::save_into`] of a body of the same file and structure wrote. At other
    /// parameters, and in the other precision, displacement and velocity stay what they were (the basis is
    /// the same, so this is the projection in the mass of the body), and so do the velocities of a flight.
    ///
    /// # Errors
    /// [`SavedError`]; the body is then unchanged.
    pub fn restore(&mut self, saved: &[u8]) -> Result<Restored, SavedError> {
        let (tag, rest) = saved.split_first_chunk::<TAG>().ok_or(SavedError::Untagged)?;
        let [m, a, g, v, .., structure, precision, flags, reserved] = *tag;
        if [m, a, g, v] != MAGIC {
            return Err(SavedError::Untagged);
        }
        let own = self.tag(precision, flags);
        if tag.get(..12) != own.get(..12) {
            return Err(SavedError::OtherFile);
        }
        if Some(&structure) != own.get(12) {
            return Err(SavedError::OtherStructure);
        }
        let flies = self.flight.is_some() == (flags & FLIGHT != 0);
        if flags & !KNOWN != 0 || reserved != 0 || ![4, 8].contains(&precision) || !flies {
            return Err(SavedError::OtherContents);
        }
        // All of it is read before anything is written.
        let (words, odd) = rest.as_chunks();
        let mut cursor = Cursor { left: words };
        let found = saved.len();
        let cut = SavedError::Length { found, needed: self.saved_len() };
        let mut same = usize::from(precision) == size_of::<T>();
        let [time_step, density] = [self.scene.parameters.time_step, self.scene.parameters.density];
        let (mut saved_step, mut saved_density) = (time_step, density);
        for (place, own) in parameters(&self.scene).enumerate() {
            let value = cursor.number().ok_or(cut)?;
            same &= value.to_bits() == own.to_bits();
            match place {
                0 => saved_step = value,
                1 => saved_density = value,
                _ => {}
            }
        }
        let (shape, r) = (self.scene.shape, self.scene.n_modes());
        let ratio = time_step / saved_step;
        let coordinates = cursor;
        for part in 0..shape.n_parts() {
            for _ in 0..r {
                scaled::<T>(cursor.number().ok_or(cut)?, ratio, part).ok_or(SavedError::NotFinite)?;
            }
        }
        let forces = cursor;
        self.check_forces(&mut cursor, shape.statics, cut)?;
        let filtered = cursor;
        if flags & FILTERED != 0 {
            // A body without the filter reads over them.
            let room = if shape.is_filtered() { shape.filtered } else { [usize::MAX, 0] };
            self.check_forces(&mut cursor, room, cut)?;
            for largest in cursor.numbers::<2>().ok_or(cut)? {
                T::from_f64(largest).in_range().then_some(()).ok_or(SavedError::NotFinite)?;
            }
        }
        let motion = match self.flight {
            None => None,
            Some(_) => {
                let (position, attitude) = (cursor.numbers().ok_or(cut)?, cursor.numbers().ok_or(cut)?);
                let scale = density / saved_density;
                let momenta: [[f64; 3]; 2] = [cursor.numbers().ok_or(cut)?, cursor.numbers().ok_or(cut)?];
                let [momentum, angular_momentum] =
                    if scale == 1.0 { momenta } else { momenta.map(|m| m.map(|x| scale * x)) };
                let motion = RigidMotion { position, attitude, momentum, angular_momentum };
                // Every bit comes back, so nothing is made of length one here.
                motion.normalised().ok_or(SavedError::NotFinite)?;
                Some(motion)
            }
        };
        if !cursor.left.is_empty() || !odd.is_empty() {
            return Err(SavedError::Length { found, needed: found - 8 * cursor.left.len() - odd.len() });
        }
        let mut from = coordinates;
        for part in 0..shape.n_parts() {
            for out in self.state.y.part_mut(part) {
                *out = from.number().and_then(|x| scaled(x, ratio, part)).unwrap_or_default();
            }
        }
        self.state.y.time_step = time_step;
        (self.state.y.at_rest, self.state.y.unstarted) = (flags & AT_REST != 0, flags & UNSTARTED != 0);
        let State { statics, filtered: slow, .. } = &mut self.state;
        let mut forces = forces;
        forces.forces(statics);
        if flags & FORCES == 0 {
            statics.forget();
        }
        if shape.is_filtered() {
            if flags & FILTERED == 0 {
                slow.settle(statics);
            } else {
                let mut filtered = filtered;
                filtered.forces(&mut slow.forces);
                slow.largest = filtered.numbers().unwrap_or_default().map(T::from_f64);
            }
        }
        if let (Some(free), Some(motion)) = (&mut self.flight, motion) {
            free.follow(&self.scene);
            free.set_motion(motion);
        }
        Ok(if same { Restored::AsSaved } else { Restored::Carried })
    }

    /// Reads over forces, and refuses those that the body has no room for.
    fn check_forces(
        &self,
        cursor: &mut Cursor<'_>,
        room: [usize; 2],
        cut: SavedError,
    ) -> Result<(), SavedError> {
        let [nodes, patterns] = cursor.numbers().ok_or(cut)?;
        let whole = |number: f64| number >= 0.0 && libm::floor(number) == number;
        let other = patterns != room[1] as f64 && patterns != 0.0 && room[1] != 0;
        if other || !whole(nodes) || !whole(patterns) {
            return Err(SavedError::OtherContents);
        }
        for _ in 0..nodes as usize {
            let [node, x, y, z] = cursor.numbers().ok_or(cut)?;
            let loadable = whole(node) && node < f64::from(self.scene.metadata.n_load_nodes);
            let sound = [x, y, z].into_iter().all(|x| T::from_f64(x).in_range());
            if !loadable || !sound {
                return Err(SavedError::NotFinite);
            }
        }
        if nodes as usize > room[0] {
            return Err(SavedError::TooManyContacts);
        }
        for _ in 0..patterns as usize {
            let amplitude = T::from_f64(cursor.number().ok_or(cut)?);
            amplitude.in_range().then_some(()).ok_or(SavedError::NotFinite)?;
        }
        Ok(())
    }

    /// Magic, file, structure, precision, contents, and a zero.
    fn tag(&self, precision: u8, flags: u8) -> [u8; TAG] {
        let ([m, a, g, v], [b, c, d, e, p, q, r, s]) = (MAGIC, self.identity);
        [m, a, g, v, b, c, d, e, p, q, r, s, self.scene.structure() as u8, precision, flags, 0]
    }
}

/// `Δt`, density and the other parameters of a scene.
fn parameters<T>(scene: &Scene<'_, T>) -> impl Iterator<Item = f64> {
    let p = scene.parameters;
    let n = scene.metadata.n_regions as usize;
    let regions = scene.options.regions;
    let of = move |scales: &[f64], k: usize| scales.get(k).copied().unwrap_or(1.0);
    let stiffness = (0..n).map(move |k| of(regions.stiffness(), k));
    let density = (0..n).map(move |k| of(regions.density(), k));
    [p.time_step, p.density, p.stiffness, p.alpha, p.beta].into_iter().chain(stiffness).chain(density)
}

/// A number of `ζ`, `Δt ζ̇` or `Δt² ζ̈` at another `Δt`, if it is one of the precision.
fn scaled<T: Scalar>(number: f64, ratio: f64, part: usize) -> Option<T> {
    let factor = match part {
        _ if ratio == 1.0 => 1.0,
        0 => 1.0,
        1 => ratio,
        _ => ratio * ratio,
    };
    let value = T::from_f64(number * factor);
    value.in_range().then_some(value)
}
