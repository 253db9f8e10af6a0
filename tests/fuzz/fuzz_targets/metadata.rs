//! Any bytes as the metadata of a file without sections: decoding and checking them never panics, and takes
//! no more memory than they have.
#![no_main]

mod seal;

use libfuzzer_sys::fuzz_target;
use vademecum_format::{BLOCK, File, MAGIC};

/// Header, no directory, these metadata.
fn file(metadata: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0; BLOCK];
    bytes[..8].copy_from_slice(&MAGIC);
    bytes[8] = 1;
    bytes[24..32].copy_from_slice(&(BLOCK as u64).to_le_bytes());
    bytes[32..40].copy_from_slice(&(metadata.len() as u64).to_le_bytes());
    bytes.extend(metadata);
    seal::seal(bytes)
}

fuzz_target!(|bytes: &[u8]| {
    // The seeds are whole files: their metadata follow header and directory.
    let sections = bytes.get(12).map_or(0, |&n| usize::from(n));
    let metadata = if bytes.starts_with(&MAGIC) { bytes.get(BLOCK * (1 + sections)..) } else { Some(bytes) };
    if let Some(metadata) = metadata {
        assert!(
            File::parse(&file(metadata)).is_err(),
            "nothing to step with, or the sections for it are missing"
        );
    }
});
