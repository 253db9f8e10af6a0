//! Any bytes with their checksums corrected, through the deep check: no panic, no more memory than the limit
//! allows, and packing changes nothing of what it says.
#![no_main]

mod seal;

use libfuzzer_sys::fuzz_target;
use vademecum_format::File;
use vademecum_rewrite as rewrite;

/// Bytes all sections may decode to.
const LIMIT: u64 = 1 << 24;

fuzz_target!(|bytes: &[u8]| {
    let sealed = seal::seal(bytes.to_vec());
    let Ok(file) = File::parse(&sealed) else { return };
    let verdict = rewrite::check_limited(&sealed, LIMIT);
    let _ = rewrite::unpack_wanted(&file, |_| true, LIMIT).map(|raw| {
        let file = File::parse(&raw).expect("what was unpacked opens");
        let _ = rewrite::check_coordinates(&file);
        let of_raw = rewrite::check_limited(&raw, LIMIT);
        assert_eq!(verdict.is_ok(), of_raw.is_ok(), "the same numbers, packed or not");
        let Ok(packed) = rewrite::pack(&raw, 1) else {
            assert!(of_raw.is_err(), "a raw file that is sound packs");
            return;
        };
        let of_packed = rewrite::check_limited(&packed, LIMIT);
        assert_eq!(of_raw.is_ok(), of_packed.is_ok(), "the same numbers, packed anew");
    });
});
