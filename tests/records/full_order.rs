//! The full-order side in numbers: factorisation, solves and the Bathe step on beams of linear tetrahedra.
//!
//! `cargo run --release -p vademecum-tests --example full_order` prints the table of
//! `docs/measurements/full-order.md`: best of five (three for the largest) in one run.

use std::time::Instant;

use vademecum_build::Matrix;
use vademecum_build::dynamics::{FullOrder, Rayleigh, schemes};
use vademecum_build::fem::{Material, Model, Solve, Symbolic};
use vademecum_build::mesh::{Order, block};

fn best(times: usize, mut work: impl FnMut()) -> f64 {
    let once = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..times).map(once).fold(f64::MAX, f64::min)
}

fn main() {
    println!(
        "| dofs | assemble | order, analyse | factor | both Bathe factors | solve 1 | 8 | 16 | Bathe step, \
         1 | 16 trajectories |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for divisions in [[40, 4, 4], [130, 8, 8], [200, 12, 12]] {
        row(divisions);
    }
}

fn row(divisions: [usize; 3]) {
    let lengths = [divisions[0] as f64 * 0.01, divisions[1] as f64 * 0.01, divisions[2] as f64 * 0.01];
    let mesh = block(lengths, divisions, Order::Linear);
    let constrained: Vec<bool> = mesh.nodes.iter().flat_map(|n| [n[0] == 0.0; 3]).collect();
    let material = Material::isotropic(2.1e9, 0.3, 1200.0);
    let assemble = || Model::assemble(mesh.clone(), &[material], &constrained).expect("a supported block");
    let model = assemble();
    let pencil = model.pencil();
    let n = pencil.n_dof();
    let times = if n > 50_000 { 3 } else { 5 };
    let symbolic = Symbolic::analyze(pencil).expect("a pattern");
    let dt = 1e-4;
    let factor = symbolic.factorize(pencil.combine(16.0, dt * dt)).expect("positive definite");
    let table = schemes::bathe();
    let march = || FullOrder::new(pencil, &symbolic, &table, dt, Rayleigh::default()).expect("a scheme");
    let full = march();

    let seconds =
        |value: f64| if value < 0.1 { format!("{:.2} ms", 1e3 * value) } else { format!("{value:.2} s") };
    let solve = |columns: usize| {
        let mut solver = Solve::new(&symbolic, columns, false);
        let mut rhs = Matrix::from_fn(n, columns, |i, j| ((i + j) % 7) as f64 - 3.0);
        best(times, || solver.solve_in_place(&factor, rhs.as_mut()))
    };
    let step = |columns: usize| {
        let zero = Matrix::zeros(n, columns);
        let force = Matrix::from_fn(n, columns, |i, j| if i % 97 == j { 1.0 } else { 0.0 });
        let mut state = full.initial_state(zero.as_ref(), zero.as_ref(), None).expect("rest");
        let mut work = full.workspace(columns, false);
        let loads = [Some(force.as_ref()); 4];
        best(times, || full.step(&mut state, &loads, &mut work))
    };
    let cells = [
        best(times, || drop(assemble())),
        best(times, || drop(Symbolic::analyze(pencil).expect("a pattern"))),
        best(times, || drop(symbolic.factorize(pencil.combine(16.0, dt * dt)).expect("positive definite"))),
        best(times, || drop(march())),
        solve(1),
        solve(8),
        solve(16),
        step(1),
        step(16),
    ];
    let cells: Vec<String> = cells.into_iter().map(seconds).collect();
    println!("| {n} | {} |", cells.join(" | "));
}
