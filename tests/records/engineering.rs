//! The record of `docs/measurements/engineering.md`: published benchmarks, and CalculiX on the same meshes.
//!
//! `cargo run --release -p vademecum-tests --example engineering [-- NAME ...]` writes meshes and problems to
//! `target/engineering`, and prints the tables. `vademecum modes target/engineering/NAME.toml` then shows the
//! same frequencies.

use vademecum_tests::program::repository;
use vademecum_tests::witness::{calculix, markdown, measure, witness, witnesses};

fn main() {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let folder = repository().join("target/engineering");
    std::fs::create_dir_all(&folder).expect("a folder");
    let asked = calculix::is_there();
    let all = || witnesses().iter().map(|witness| witness.name.to_string()).collect();
    let names: Vec<String> = if names.is_empty() { all() } else { names };
    for name in &names {
        let witness = witness(name);
        println!("{}", markdown(&witness, &measure(&witness, &folder, asked)));
    }
}
