//! Any bytes, unpacked: no panic, and never more bytes than the limit allows. What unpacks is a sound file
//! that packs and unpacks to itself.
#![no_main]

mod seal;
use libfuzzer_sys::fuzz_target;
use vademecum_rewrite as rewrite;

/// Bytes all sections may decode to.
const LIMIT: u64 = 1 << 24;

fuzz_target!(|bytes: &[u8]| {
    let sealed = seal::seal(bytes.to_vec());
    let Ok(raw) = rewrite::unpack(&sealed, LIMIT) else { return };
    assert!(
        raw.len() as u64 <= LIMIT + (1 << 20) + 64 * 600,
        "header, directory, metadata, padding beside the sections"
    );
    let _ = rewrite::check(&raw);
    let packed = rewrite::pack(&raw, 1).expect("a raw file packs");
    assert!(rewrite::unpack(&packed, LIMIT).expect("what was packed unpacks") == raw);
    for keep in [rewrite::Keep::Probes, rewrite::Keep::Surface] {
        let _ = rewrite::strip(&packed, keep);
    }
});
