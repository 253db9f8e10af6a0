//! The record of `docs/measurements/basis.md`: bases and structures beside the full-order march, long
//! marches, precision.
//!
//! `cargo run --release -p vademecum-tests --example basis [-- PROBLEM.toml ...]`; without arguments the
//! cantilever and the liver of the fixtures (the liver's mesh lies in `../shared`; it is left out where that
//! is absent).

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::progress::Silent;
use vademecum_eval::StructureChoice;
use vademecum_study::parts::Study;
use vademecum_tests::bases::{Row, VARIANTS, Variant, compare, file};
use vademecum_tests::long_march::{energy_ratio, precision};
use vademecum_tests::program::repository;
use vademecum_tests::shared::shared;

const MODES: [usize; 4] = [8, 16, 32, 64];
const STEPS: usize = 2000;
const LONG: usize = 10_000_000;
const SINGLE: usize = 200_000;

fn main() {
    let given: Vec<PathBuf> = std::env::args().skip(1).map(PathBuf::from).collect();
    let problems = if given.is_empty() { fixtures() } else { given };
    for path in problems {
        let problem = Problem::read(&path).unwrap_or_else(|error| panic!("{error}"));
        record(&Study::new(&problem, *MODES.last().expect("some"), &Silent).expect("a study"));
    }
}

fn fixtures() -> Vec<PathBuf> {
    let fixture = |name: &str| repository().join("fixtures/problems").join(name);
    let liver = shared("meshes/vtu/liverFine.vtu").map(|_| fixture("liver.toml"));
    std::iter::once(fixture("cantilever.toml")).chain(liver).collect()
}

fn record(study: &Study) {
    let dofs = study.prepared().body.n_dof();
    println!("## {}\n", study.problem().title);
    println!(
        "{dofs} dofs, {:.1} steps per first period, {} snapshots of {} loads, {STEPS} steps of three unseen \
         loads.\n",
        study.first_period() / study.time_step(),
        study.pod().n_snapshots,
        study.runs().count()
    );
    let rows = compare(study, &VARIANTS, &MODES, STEPS, &Silent);
    println!(
        "| basis, structure | r | error | floor | error ÷ floor | spectral radius \
         |\n|---|---|---|---|---|---|"
    );
    for variant in VARIANTS {
        rows.iter().filter(|row| row.variant == variant).for_each(print);
    }
    println!(
        "\n| structure | r | energy over {LONG:.0e} free steps ÷ at release | f32 − f64, held | f32 − f64, \
         ringing |"
    );
    println!("|---|---|---|---|---|");
    for modes in MODES {
        let bytes = file(study, modes);
        for (name, structure) in [("diagonal", StructureChoice::Diagonal), ("block", StructureChoice::Block)]
        {
            let ratio = energy_ratio::<f64>(&bytes, structure, LONG);
            let p = precision(&bytes, structure, SINGLE);
            println!("| {name} | {modes} | {ratio:.9} | {:.1e} | {:.1e} |", p.held, p.released);
        }
    }
    println!();
}

fn print(row: &Row) {
    let name = match row.variant {
        Variant::RitzDiagonal => "**ritz, diagonal**",
        Variant::RitzBlock => "**ritz, block**",
        Variant::PlainRitzDiagonal => "ritz of the POD alone, diagonal",
        Variant::PlainRitzBlock => "ritz of the POD alone, block",
        Variant::PodGalerkin => "pod, Galerkin",
        Variant::PodBlock => "pod, block",
    };
    println!(
        "| {name} | {} | {:.2e} | {:.2e} | {:.3} | 1 {:+.0e} |",
        row.modes,
        row.error,
        row.floor,
        row.ratio,
        row.spectral_radius - 1.0
    );
}
