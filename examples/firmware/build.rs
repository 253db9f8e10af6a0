//! Hands the linker its script, and the compiler the file and the clock of the board.

use std::path::PathBuf;

fn main() {
    let folder = std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo");
    let variable = |name: &str| {
        println!("cargo::rerun-if-env-changed={name}");
        std::env::var(name).unwrap_or_else(|_| panic!("{name} is not set; build with ./check"))
    };
    let board = variable("BOARD");
    let clock: u32 = match board.as_str() {
        "an386" => 25_000_000,
        "an505" => 20_000_000,
        _ => panic!("BOARD is {board}; expected an386 or an505"),
    };
    let body = PathBuf::from(variable("BODY")).canonicalize().expect("BODY is the path of a vademecum file");
    println!("cargo::rerun-if-changed={}", body.display());
    println!("cargo::rustc-env=BODY={}", body.display());
    println!("cargo::rustc-env=CLOCK={clock}");
    println!("cargo::rustc-link-arg=-L{folder}/link");
    println!("cargo::rustc-link-arg=-T{board}.x");
    println!("cargo::rerun-if-changed=link");
}
