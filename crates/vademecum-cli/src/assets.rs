//! Modules that the program carries, compressed by its build script.

const EVALUATOR: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/evaluator.wasm.zst"));
const WORLD: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/world.wasm.zst"));
const FMU_LIBRARY: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/fmu-x86_64-linux.so.zst"));

/// The evaluator for browsers, made by `crates/vademecum-web/build`.
pub(crate) fn evaluator() -> Vec<u8> {
    unpacked(EVALUATOR)
}

/// The module of worlds for browsers, made there, too.
pub(crate) fn world() -> Vec<u8> {
    unpacked(WORLD)
}

/// The library of FMUs for Linux on 64-bit Intel and AMD processors, made by `crates/vademecum-fmu/build`.
pub(crate) fn fmu_library() -> Vec<u8> {
    unpacked(FMU_LIBRARY)
}

fn unpacked(packed: &[u8]) -> Vec<u8> {
    zstd::decode_all(packed).expect("what the build script compressed")
}
