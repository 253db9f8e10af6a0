//! Compresses the modules that the program carries for browsers and for FMUs: 1 MB becomes a third.

use std::path::Path;

/// Level of compression: the slowest that needs no more memory to decompress.
const LEVEL: i32 = 19;

fn main() {
    let out = std::env::var_os("OUT_DIR").expect("a folder for what is made");
    for name in ["evaluator.wasm", "world.wasm", "fmu-x86_64-linux.so"] {
        let path = Path::new("assets").join(name);
        println!("cargo::rerun-if-changed={}", path.display());
        let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let packed = zstd::encode_all(&bytes[..], LEVEL).expect("memory for compression");
        let packed_path = Path::new(&out).join(format!("{name}.zst"));
        std::fs::write(&packed_path, packed)
            .unwrap_or_else(|error| panic!("{}: {error}", packed_path.display()));
    }
}
