//! Live regions set to values. `cargo bench -p vademecum-tests --bench parameters` prints the time of the
//! eigenproblem for 32 stepped modes, beside faer's whole symmetric eigendecomposition of the same matrix on
//! one core, and of the file at these values.

use std::path::PathBuf;
use std::sync::OnceLock;

use divan::Bencher;
use faer::{Mat, Side};
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::Parametric;
use vademecum_format::File;

fn main() {
    faer::set_global_parallelism(faer::Par::Seq);
    divan::main();
}

/// Vectors of the basis.
const SIZE: usize = 256;
/// Stepped modes.
const MODES: usize = 32;

/// A beam of four regions of live stiffness.
fn beam() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| built(""))
}

/// The same, and the density of its last quarter is live.
fn dense_beam() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        built(
            "[[parameter]]\nname = \"density\"\nkind = \"density\"\nregion = \"r3\"\nrange = [0.5, 2.0]\n\
             scale = \"log\"\n",
        )
    })
}

fn built(more: &str) -> Vec<u8> {
    let region = |k: usize| {
        let share = f64::from(k as u32) / 4.0;
        format!(
            "[[mesh.region]]\nname = \"r{k}\"\n\
                 on = {{ fraction = {{ axis = \"x\", side = \"max\", fraction = {share} }} }}\n"
        )
    };
    let parameter = |name: &str| {
        format!(
            "[[parameter]]\nname = \"{name}\"\nkind = \"stiffness\"\nregion = \"{name}\"\n\
                 range = [0.33, 3.0]\nscale = \"log\"\n"
        )
    };
    let regions: String = (1..4).rev().map(region).collect();
    let names = ["body", "r1", "r2", "r3"];
    let parameters: String = names.into_iter().map(parameter).collect();
    let text = format!(
        "representation = \"parametric\"\n[mesh]\n\
             block = {{ lengths = [1.0, 0.08, 0.1], divisions = [24, 2, 2], order = \"quadratic\" }}\n{regions}\
             [[material]]\nyoung = 2e9\npoisson = 0.3\ndensity = 1000.0\n[[support]]\non = {{ group = \"x_min\" }}\n\
             [load]\nsurface = {{ group = \"x_max\" }}\n[time]\nstep = 1e-3\n[basis]\nmodes = {SIZE}\n\
             [tolerance]\nsteps = 20\n{parameters}{more}"
    );
    let problem = Problem::parse(&text, "beam.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}

/// Values of the parameters.
const VALUES: [f64; 4] = [0.5, 2.0, 0.75, 2.5];

/// The lowest modes at given values.
#[divan::bench]
fn solve(bencher: Bencher<'_, '_>) {
    solved(bencher, beam(), &VALUES);
}

/// The same with a live density.
#[divan::bench]
fn solve_with_density(bencher: Bencher<'_, '_>) {
    let values: Vec<f64> = VALUES.into_iter().chain([1.5]).collect();
    solved(bencher, dense_beam(), &values);
}

fn solved(bencher: Bencher<'_, '_>, bytes: &[u8], values: &[f64]) {
    let file = File::parse(bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    assert_eq!(model.n_basis(), SIZE);
    let sizes = model.sizes(MODES).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    bencher.bench_local(|| model.solve(values, MODES, &mut memory, &mut work).expect("solved").frequency(0));
}

/// All modes by faer.
#[divan::bench]
fn faer_all(bencher: Bencher<'_, '_>) {
    let file = File::parse(beam()).expect("a file");
    let live = file.live_parameters().expect("sections").expect("a model");
    let packed = SIZE * (SIZE + 1) / 2;
    let matrix = Mat::from_fn(SIZE, SIZE, |i, j| {
        let (i, j) = (i.max(j), i.min(j));
        let entry = |q: usize| f64::from_le_bytes(live.stiffness[q * packed + i * (i + 1) / 2 + j]);
        entry(0) + VALUES.iter().enumerate().map(|(q, value)| value * entry(q + 1)).sum::<f64>()
    });
    bencher.bench_local(|| matrix.self_adjoint_eigen(Side::Lower).expect("eigenvectors").U()[(0, 0)]);
}

/// The file at given values.
#[divan::bench]
fn write(bencher: Bencher<'_, '_>) {
    let file = File::parse(beam()).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let sizes = model.sizes(MODES).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let tuned = model.solve(&VALUES, MODES, &mut memory, &mut work).expect("solved");
    let (mut bytes, mut work) = (vec![0; sizes.bytes], vec![0.0; sizes.write_work]);
    bencher.bench_local(|| tuned.write(&model, &mut bytes, &mut work).expect("written").bytes().len());
}
