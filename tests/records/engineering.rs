//! The record of `docs/benchmarks/engineering.md`: published benchmarks, and CalculiX on the same meshes.
//!
//! `cargo run --release -p vademecum-tests --example engineering [-- NAME ...]` writes meshes and problems to
//! `target/engineering`, and prints the tables.

use vademecum_tests::program::repository;
use vademecum_tests::witness::{calculix, compare, frequencies_table, measure, witnesses};

fn main() {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let folder = repository().join("target/engineering");
    std::fs::create_dir_all(&folder).expect("a folder");
    let asked = calculix::is_there();
    for witness in witnesses() {
        if !names.is_empty() && !names.iter().any(|name| name == witness.name) {
            continue;
        }
        let found = measure(&witness, &folder, asked);
        println!("## {}\n\n{}\n\n{} dofs.\n", witness.name, witness.what, found.dofs);
        println!("{}", frequencies_table(&witness, &found));
        if let Some(answer) = &found.calculix {
            let (frequencies, statics) = compare(&found, answer);
            println!("Frequencies differ from CalculiX by at most {frequencies:.1e}.");
            if let Some(statics) = statics {
                println!("Displacements under the load differ by at most {statics:.1e} of the largest one.");
            }
            println!();
        }
    }
}
