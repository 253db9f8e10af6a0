//! Seconds and memory of the stages of a build against dofs, modes, parameters and loadable nodes.
//!
//! Every build is a process of its own, so that the largest memory is its own; blocks of quadratic
//! tetrahedra, 4 : 1 : 1.

use serde_json::Value;
use vademecum_tests::program::vademecum;

use crate::fit::{Column, print};

/// What a build is asked for.
#[derive(Clone, Copy)]
struct Case {
    /// Elements across the block; four times as many along it.
    across: usize,
    modes: usize,
    /// Live parameters, at most four.
    parameters: usize,
    /// Share of the length that is loadable.
    loadable: f64,
}

/// Everything else stands still while one of these moves.
const PLAIN: Case = Case { across: 3, modes: 8, parameters: 0, loadable: 1.0 };

/// What a build reported.
struct Found {
    dofs: f64,
    file_bytes: f64,
    /// Stage, seconds, largest memory so far in megabytes.
    stages: Vec<(String, f64, f64)>,
}

/// Prints all tables; meshes of up to `largest` dofs.
pub fn run(largest: usize) {
    let all: Vec<usize> = [3, 4, 5, 7, 10, 14].into_iter().filter(|&a| dofs(a) <= largest).collect();
    let found: Vec<Found> = all.iter().map(|&across| build(&Case { across, ..PLAIN })).collect();
    let sizes: Vec<f64> = found.iter().map(|f| f.dofs).collect();
    table("Dofs (8 modes, 6 snapshot runs of 100 steps)", "dofs", &sizes, &found);

    sweep("Modes (3 528 dofs)", "modes", &[4, 8, 16, 32, 64], |modes| Case { modes, ..PLAIN });
    sweep("Live parameters (3 528 dofs, 8 modes)", "parameters", &[1, 2, 3, 4], |parameters| Case {
        parameters,
        ..PLAIN
    });
    sweep("Loadable part of the surface, in eighths (13 068 dofs, 8 modes)", "eighths", &[1, 2, 4, 8], |n| {
        Case { across: 5, loadable: n as f64 / 8.0, ..PLAIN }
    });
}

/// Free dofs of a block, clamped at one end.
fn dofs(across: usize) -> usize {
    3 * 8 * across * (2 * across + 1).pow(2)
}

fn sweep(title: &str, size: &str, values: &[usize], case: impl Fn(usize) -> Case) {
    let found: Vec<Found> = values.iter().map(|&value| build(&case(value))).collect();
    let sizes: Vec<f64> = values.iter().map(|&v| v as f64).collect();
    table(title, size, &sizes, &found);
}

/// A column per stage that takes at least a hundredth of the largest build, then their sum, memory and file.
fn table(title: &str, size: &str, sizes: &[f64], found: &[Found]) {
    let Some(last) = found.last() else { return };
    let total = |f: &Found| f.stages.iter().map(|s| s.1).sum::<f64>();
    let seconds = |f: &Found, name: &str| f.stages.iter().find(|s| s.0 == name).map_or(f64::NAN, |s| s.1);
    let matters = |name: &str| seconds(last, name) >= 0.01 * total(last);
    let names = last.stages.iter().map(|s| s.0.clone()).filter(|name| matters(name));
    let mut columns: Vec<Column> = names
        .map(|name| Column {
            values: found.iter().map(|f| seconds(f, &name)).collect(),
            name: format!("{name}, s"),
        })
        .collect();
    let memory = |f: &Found| f.stages.iter().map(|s| s.2).fold(f64::NAN, f64::max);
    let more: [(&str, Vec<f64>); 3] = [
        ("all, s", found.iter().map(total).collect()),
        ("memory, MB", found.iter().map(memory).collect()),
        ("file, MB", found.iter().map(|f| f.file_bytes / 1e6).collect()),
    ];
    columns.extend(more.into_iter().map(|(name, values)| Column { name: name.into(), values }));
    print(title, size, sizes, &columns);
}

fn build(case: &Case) -> Found {
    let folder = tempfile::tempdir().expect("a folder");
    let (problem, file) = (folder.path().join("problem.toml"), folder.path().join("body.vdm"));
    std::fs::write(&problem, text(case)).expect("a problem");
    let [problem, file] = [&problem, &file].map(|p| p.to_str().expect("UTF-8"));
    // The tolerance is not the question here.
    let report = vademecum(&["build", problem, "-o", file, "--json", "--keep-missed"]).json();
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let stage = |t: &Value| {
        let name = t["stage"].as_str().expect("a name").to_string();
        (name, number(&t["seconds"]), number(&t["peak_memory_bytes"]) / 1e6)
    };
    let stages = report["timings"].as_array().expect("a list").iter().map(stage).collect();
    Found { dofs: number(&report["dofs"]), file_bytes: number(&report["file_bytes"]), stages }
}

fn text(case: &Case) -> String {
    let Case { across, modes, parameters, loadable } = *case;
    let along = 4 * across;
    let mut text = format!(
        "title = \"a block\"\n\
         [mesh]\nblock = {{ lengths = [1.0, 0.25, 0.25], divisions = [{along}, {across}, {across}] }}\n\
         [[mesh.region]]\nname = \"far\"\non = {{ fraction = {{ axis = \"x\", side = \"max\", fraction = \
         0.5 }} }}\n\
         [[material]]\nyoung = 2.1e9\npoisson = 0.3\ndensity = 1200.0\n\
         [[support]]\non = {{ group = \"x_min\" }}\n\
         [load]\nsurface = {{ fraction = {{ axis = \"x\", side = \"max\", fraction = {loadable} }} }}\n\
         [time]\nscheme.name = \"bathe\"\nstep = 1e-4\n\
         [snapshots]\npositions = 2\nduration = 1e-2\nhold = 3e-3\nstride = 2\n\
         [basis]\nmodes = {modes}\n\
         [tolerance]\nsteps = 100\nmap = 1e-5\n"
    );
    let ranges = [
        ("time-step", "*", 1e-4),
        ("stiffness", "far", 1.0),
        ("stiffness", "body", 1.0),
        ("density", "far", 1.0),
    ];
    for (i, (kind, region, nominal)) in ranges.iter().take(parameters).enumerate() {
        text.push_str(&format!(
            "[[parameter]]\nname = \"p{i}\"\nkind = \"{kind}\"\nregion = \"{region}\"\nrange = [{:e}, \
             {:e}]\nscale = \"log\"\n",
            nominal / 2.0,
            nominal * 2.0
        ));
    }
    text
}
