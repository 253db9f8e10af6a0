//! The state of a world with its parts, as bytes.

use vademecum_eval::{Member, Pose, Restored, RigidMotion, SavedError, WorldError};

use crate::world::simulation::WorldSimulation;

/// First bytes of a saved world.
const MAGIC: [u8; 8] = *b"VDWORLD1";

/// Numbers of a rigid motion, and of a placement.
const MOTION: usize = 13;
const POSE: usize = 7;

/// Why the state of a world was not taken back.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WorldSavedError {
    /// Bytes that are no saved world.
    #[error("the bytes are no saved world")]
    Untagged,
    /// Bytes of another world.
    #[error("the bytes are those of another world: other parts, pairs, joints or options")]
    Other,
    /// The state of a part.
    #[error("part {part}: {source}")]
    Part {
        /// Its number.
        part: usize,
        /// The reason.
        source: SavedError,
    },
}

impl From<WorldError> for WorldSavedError {
    fn from(_: WorldError) -> Self {
        Self::Other
    }
}

/// Bytes that are read from the front.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn bytes(&mut self, n: usize) -> Result<&'a [u8], WorldSavedError> {
        let (front, rest) = self.0.split_at_checked(n).ok_or(WorldSavedError::Other)?;
        self.0 = rest;
        Ok(front)
    }

    fn count(&mut self) -> Result<u64, WorldSavedError> {
        Ok(u64::from_le_bytes(self.bytes(8)?.try_into().map_err(|_| WorldSavedError::Other)?))
    }

    fn numbers(&mut self, n: usize) -> Result<Vec<f64>, WorldSavedError> {
        let bytes = self.bytes(n.checked_mul(8).ok_or(WorldSavedError::Other)?)?;
        Ok(bytes.as_chunks().0.iter().map(|word| f64::from_le_bytes(*word)).collect())
    }
}

fn put(bytes: &mut Vec<u8>, numbers: &[f64]) {
    bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

fn motion_of(numbers: &[f64]) -> Option<RigidMotion> {
    let [a, b, c, d, e, f, g, rest @ ..] = *<&[f64; MOTION]>::try_from(numbers).ok()?;
    let [h, i, j, k, l, m] = rest;
    let (position, attitude) = ([a, b, c], [d, e, f, g]);
    Some(RigidMotion { position, attitude, momentum: [h, i, j], angular_momentum: [k, l, m] })
}

impl WorldSimulation {
    /// Everything that a step changes, contacts and joints among it, and the placements of held parts. Loads
    /// are not part of it. The world goes on from there bit by bit.
    pub fn save(&mut self) -> Vec<u8> {
        let (steps, stands) = self.kept();
        let mut bytes = MAGIC.to_vec();
        bytes.extend(steps.to_le_bytes());
        bytes.extend((stands.len() as u64).to_le_bytes());
        self.with(|world, members| {
            let mut numbers = vec![0.0; world.saved_len()];
            world.save_into(&mut numbers).expect("numbers of that length");
            bytes.extend((numbers.len() as u64).to_le_bytes());
            put(&mut bytes, &numbers);
            for (member, stand) in members.iter().zip(stands) {
                let mut own = vec![];
                match member {
                    Member::Held(body, _) | Member::Free(body) => {
                        own = vec![0; body.saved_len()];
                        let written = body.save_into(&mut own).expect("bytes of that length");
                        own.truncate(written);
                    }
                    Member::Rigid(shape) => {
                        let RigidMotion { position, attitude, momentum, angular_momentum } = *shape.motion();
                        let all = [&position[..], &attitude, &momentum, &angular_momentum].concat();
                        put(&mut own, &all);
                    }
                }
                bytes.extend((own.len() as u64).to_le_bytes());
                bytes.extend(own);
                if let Some(stand) = stand {
                    put(&mut bytes, &[&stand.position()[..], &stand.attitude()].concat());
                }
            }
        });
        bytes
    }

    /// Takes back what [`WorldSimulation::save`] of a world of the same parts, pairs, joints and options
    /// gave.
    ///
    /// # Errors
    /// [`WorldSavedError`]; nothing has changed then.
    pub fn restore(&mut self, saved: &[u8]) -> Result<(), WorldSavedError> {
        let before = self.save();
        self.take(saved).inspect_err(|_| self.take(&before).expect("its own state"))
    }

    fn take(&mut self, saved: &[u8]) -> Result<(), WorldSavedError> {
        let rest = saved.strip_prefix(&MAGIC).ok_or(WorldSavedError::Untagged)?;
        let mut reader = Reader(rest);
        let (steps, count) = (reader.count()?, reader.count()?);
        let (_, mut stands) = self.kept();
        if count != stands.len() as u64 {
            return Err(WorldSavedError::Other);
        }
        self.with(|world, members| {
            let length = reader.count()?;
            if length != world.saved_len() as u64 {
                return Err(WorldSavedError::Other);
            }
            world.restore(&reader.numbers(length as usize)?)?;
            for (part, (member, stand)) in members.iter_mut().zip(&mut stands).enumerate() {
                let length = usize::try_from(reader.count()?).map_err(|_| WorldSavedError::Other)?;
                let own = reader.bytes(length)?;
                match member {
                    Member::Held(body, _) | Member::Free(body) => {
                        let restored = body.restore(own);
                        let restored = restored.map_err(|source| WorldSavedError::Part { part, source })?;
                        if restored != Restored::AsSaved {
                            return Err(WorldSavedError::Other);
                        }
                    }
                    Member::Rigid(shape) => {
                        let motion = motion_of(&Reader(own).numbers(own.len() / 8)?);
                        motion.and_then(|motion| shape.restore(motion)).ok_or(WorldSavedError::Other)?;
                    }
                }
                if let Some(stand) = stand {
                    let numbers = reader.numbers(POSE)?;
                    let numbers = <[f64; POSE]>::try_from(numbers).map_err(|_| WorldSavedError::Other)?;
                    let [x, y, z, a, b, c, d] = numbers;
                    *stand = Pose::new([x, y, z], [a, b, c, d]);
                    if !stand.is_sound() {
                        return Err(WorldSavedError::Other);
                    }
                }
            }
            Ok(())
        })?;
        if !reader.0.is_empty() {
            return Err(WorldSavedError::Other);
        }
        self.keep(steps, &stands);
        Ok(())
    }
}
