//! A folder of finished stages, one file each.
//!
//! A file is named for its stage and its address and holds the XXH3-128 of address and content, then the
//! content (bincode, fixed-width little-endian). Files appear whole (see [`write_atomic`]) and are never
//! changed, so builds may share a folder. What does not match its checksum is not used.

use std::io;
use std::path::{Path, PathBuf};

use bincode::config::{Configuration, Fixint, LittleEndian};
use serde::Serialize;
use serde::de::DeserializeOwned;
use xxhash_rust::xxh3::Xxh3;

use super::disk::write_atomic;
use super::part::remove_left_behind;
use super::read::read_regular;

/// Ending of a stage's file.
const ENDING: &str = ".stage";
/// Bytes of the checksum at the front.
const CHECKSUM: usize = 16;

/// Folder of finished stages.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
    fresh: bool,
}

/// Result of a look-up of a stage.
pub(crate) enum CachedStage<T> {
    /// The result.
    Whole(T),
    /// A file that is not what was written.
    Damaged(PathBuf),
    /// Results for other inputs only.
    Other,
    /// Nothing.
    Nothing,
}

impl Store {
    /// A store in `folder`, which is made when the first stage is kept. A `fresh` one does not look at what
    /// is there.
    pub fn new(folder: &Path, fresh: bool) -> Self {
        Self { folder: folder.into(), fresh }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// True if any stage is kept.
    pub fn holds_stages(&self) -> bool {
        self.names().iter().any(|name| name.ends_with(ENDING))
    }

    /// Removes the stages, and the folder if nothing else is in it.
    ///
    /// # Errors
    /// The error of the system.
    pub fn remove(&self) -> io::Result<()> {
        remove_left_behind(&self.folder);
        for name in self.names().iter().filter(|name| name.ends_with(ENDING)) {
            std::fs::remove_file(self.folder.join(name))?;
        }
        match std::fs::remove_dir(&self.folder) {
            Err(error)
                if ![io::ErrorKind::NotFound, io::ErrorKind::DirectoryNotEmpty].contains(&error.kind()) =>
            {
                Err(error)
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn read<T: DeserializeOwned>(&self, stage: &str, address: u128) -> CachedStage<T> {
        if self.fresh {
            return CachedStage::Nothing;
        }
        let path = self.path(stage, address);
        match read_regular(&path) {
            Ok(bytes) => decode(address, &bytes).map_or(CachedStage::Damaged(path), CachedStage::Whole),
            Err(error) if error.kind() != io::ErrorKind::NotFound => CachedStage::Damaged(path),
            Err(_) if self.names().iter().any(|name| stage_of(name) == Some(stage)) => CachedStage::Other,
            Err(_) => CachedStage::Nothing,
        }
    }

    pub(crate) fn write(&self, stage: &str, address: u128, result: &impl Serialize) -> io::Result<()> {
        std::fs::create_dir_all(&self.folder)?;
        write_atomic(&self.path(stage, address), &encode(address, result)?)
    }

    /// Removes one result; what cannot be removed stays until [`Store::remove`].
    pub(crate) fn forget(&self, stage: &str, address: u128) {
        let _ = std::fs::remove_file(self.path(stage, address));
    }

    fn path(&self, stage: &str, address: u128) -> PathBuf {
        self.folder.join(format!("{stage}-{address:032x}{ENDING}"))
    }

    /// Names of the files in the folder; none if it cannot be read.
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        entries.filter_map(|entry| entry.file_name().into_string().ok()).collect()
    }
}

fn stage_of(name: &str) -> Option<&str> {
    name.strip_suffix(ENDING)?.rsplit_once('-').map(|(stage, _)| stage)
}

fn configuration() -> Configuration<LittleEndian, Fixint> {
    bincode::config::standard().with_little_endian().with_fixed_int_encoding()
}

fn checksum(address: u128, content: &[u8]) -> [u8; CHECKSUM] {
    let mut state = Xxh3::new();
    state.update(&address.to_le_bytes());
    state.update(content);
    state.digest128().to_le_bytes()
}

fn encode(address: u128, result: &impl Serialize) -> io::Result<Vec<u8>> {
    let mut bytes = vec![0; CHECKSUM];
    bincode::serde::encode_into_std_write(result, &mut bytes, configuration()).map_err(io::Error::other)?;
    let (checked, content) = bytes.split_at_mut(CHECKSUM);
    checked.copy_from_slice(&checksum(address, content));
    Ok(bytes)
}

fn decode<T: DeserializeOwned>(address: u128, bytes: &[u8]) -> Option<T> {
    let (written, content) = bytes.split_first_chunk::<CHECKSUM>()?;
    if *written != checksum(address, content) {
        return None;
    }
    let (result, length) = bincode::serde::decode_from_slice(content, configuration()).ok()?;
    (length == content.len()).then_some(result)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(found: CachedStage<Vec<f64>>) -> Option<Vec<f64>> {
        match found {
            CachedStage::Whole(result) => Some(result),
            _ => None,
        }
    }

    #[test]
    fn what_is_kept_comes_back_bit_by_bit_and_only_for_its_address() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(&folder.path().join("work"), false);
        assert!(matches!(store.read::<Vec<f64>>("a", 1), CachedStage::Nothing));
        assert!(!store.holds_stages());
        let numbers = vec![0.1, -0.0, f64::MIN_POSITIVE / 2.0, f64::NAN];
        store.write("a", 1, &numbers).unwrap();
        let back = whole(store.read("a", 1)).expect("kept");
        assert!(back.iter().zip(&numbers).all(|(a, b)| a.to_bits() == b.to_bits()));
        assert!(matches!(store.read::<Vec<f64>>("a", 2), CachedStage::Other));
        assert!(matches!(store.read::<Vec<f64>>("b", 1), CachedStage::Nothing));
        assert!(whole(Store::new(store.folder(), true).read("a", 1)).is_none());
    }

    #[test]
    fn a_damaged_file_is_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path(), false);
        store.write("a", 1, &vec![1.0, 2.0]).unwrap();
        let path = store.path("a", 1);
        let bytes = std::fs::read(&path).unwrap();
        let damaged = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            matches!(store.read::<Vec<f64>>("a", 1), CachedStage::Damaged(_))
        };
        assert!((0..bytes.len()).all(|length| damaged(&bytes[..length])));
        for place in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[place] ^= 1;
            assert!(damaged(&flipped));
        }
        // Whole, but of another address, or of another type.
        std::fs::write(store.path("a", 2), &bytes).unwrap();
        assert!(matches!(store.read::<Vec<f64>>("a", 2), CachedStage::Damaged(_)));
        std::fs::write(&path, &bytes).unwrap();
        assert!(matches!(store.read::<u8>("a", 1), CachedStage::Damaged(_)));
        assert!(whole(store.read("a", 1)).is_some());
    }

    #[test]
    fn removing_takes_what_the_store_wrote_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(&folder.path().join("work"), false);
        store.remove().unwrap();
        store.write("a", 1, &1).unwrap();
        std::fs::write(store.folder().join(".vademecum-x.part"), b"half").unwrap();
        std::fs::write(store.folder().join("notes.txt"), b"mine").unwrap();
        store.remove().unwrap();
        assert_eq!(store.names(), ["notes.txt"]);
        std::fs::remove_file(store.folder().join("notes.txt")).unwrap();
        store.remove().unwrap();
        assert!(!store.folder().exists());
    }
}
