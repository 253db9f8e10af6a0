//! The record of `docs/benchmarks/chapter.md`: the chapter's representation, each repair alone and all
//! together, and the block representation, on one body.
//!
//! `cargo run --release -p vademecum-tests --example canonical [-- PROBLEM.toml]`; without arguments the
//! fixture `canonical-beam.toml`, whose two regions the block rows need.

use std::time::Instant;

use vademecum_build::Matrix;
use vademecum_build::chapter::{ChapterCertificate, ChapterMap, ChapterSetting, certify_chapter};
use vademecum_build::dynamics::FullOrder;
use vademecum_build::export::NodeOrder;
use vademecum_build::fem::{Solve, Symbolic, SymmetricMatrix};
use vademecum_build::input::{BasisKind, ChapterEntry, Problem, Repair};
use vademecum_build::progress::Silent;
use vademecum_build::separated::{
    Axis, AxisKind, BlockProblem, EnrichmentOptions, ReductionOptions, SeparatedError, Space, reduce,
};
use vademecum_eval::Contact;
use vademecum_format::scheme::theta;
use vademecum_format::{Chapter, File};
use vademecum_study::bench::Study;
use vademecum_tests::program::repository;
use vademecum_tests::stage::with_chapter;

const STEPS: usize = 2000;

fn main() {
    let given = std::env::args().nth(1).map(std::path::PathBuf::from);
    let path = given.unwrap_or_else(|| repository().join("fixtures/problems/canonical-beam.toml"));
    let problem = Problem::read(&path).unwrap_or_else(|error| panic!("{error}"));
    let study = Study::new(&problem, 8, &Silent).expect("a study");
    println!("## {}\n", study.problem().title);
    println!(
        "{} dofs, {:.1} steps per first period, {STEPS} steps of three unseen loads.\n",
        study.prepared().body.n_dof(),
        study.first_period() / study.time_step()
    );
    println!(
        "| basis | r | canonical | terms | stage errors (load part) | offline s | ns a step, f64 | error | \
         floor | left at |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for modes in [6, 8] {
        record(&study, BasisKind::Pod, modes, &variants(modes));
    }
    // Ritz vectors are orthogonal in the stages' own matrices, which is half of what greedy enrichment lacks.
    for modes in [6, 8] {
        let rows = variants(modes);
        let ends: Vec<_> = rows.into_iter().filter(|(name, ..)| name == "chapter" || name == "all").collect();
        record(&study, BasisKind::Ritz, modes, &ends);
    }
    if study.prepared().body.model.pencil().n_regions() == 2 {
        block_rows(&study);
    }
}

/// Name, repairs and most terms of a row (`None`: the rank of the exact map).
type Row = (String, Vec<Repair>, Option<usize>);

fn variants(modes: usize) -> Vec<Row> {
    let chapter: &[Option<usize>] = if modes == 6 { &[Some(20), Some(40), None] } else { &[Some(100), None] };
    let mut all: Vec<_> = chapter.iter().map(|terms| ("chapter".to_string(), vec![], *terms)).collect();
    all.extend(Repair::ALL.map(|repair| (format!("{repair:?}"), vec![repair], None)));
    let but = |left: Repair| Repair::ALL.into_iter().filter(|r| *r != left).collect::<Vec<_>>();
    all.push(("all but OneAxisStart".into(), but(Repair::OneAxisStart), None));
    all.push(("all".into(), Repair::ALL.to_vec(), None));
    all
}

fn record(study: &Study, kind: BasisKind, modes: usize, variants: &[Row]) {
    let prepared = study.prepared();
    let pencil = prepared.body.model.pencil();
    let (dt, rayleigh) = (study.time_step(), prepared.rayleigh());
    let full = FullOrder::new(pencil, &prepared.symbolic, &prepared.scheme, dt, rayleigh).expect("a march");
    let basis = study.basis(kind, modes).expect("a basis").value;
    let entry = study.problem().chapter().unwrap_or_default();
    let setting =
        ChapterSetting::new(&entry, prepared, &basis, &full, study.runs(), &Silent).expect("ranges");
    let name_of_basis = format!("{kind:?}").to_lowercase();
    let mut rows = vec![];
    for (name, repairs, max_terms) in variants.iter().cloned() {
        let clock = Instant::now();
        let options = ChapterEntry { repairs, max_terms, ..entry.clone() };
        let map = setting.with(options).separate(prepared, &basis).expect("a separation");
        rows.push((name, map, clock.elapsed().as_secs_f64()));
    }
    let measured = |map: &ChapterMap| {
        study.canonical_bytes(&basis, map, &ChapterCertificate::of_maps(map)).expect("the writer takes it")
    };
    let bytes: Vec<Vec<u8>> = rows.iter().map(|row| measured(&row.1)).collect();
    let files: Vec<(&ChapterMap, &[u8])> =
        rows.iter().zip(&bytes).map(|(row, bytes)| (&row.1, &bytes[..])).collect();
    let order = NodeOrder::new(&prepared.body);
    let certificates = certify_chapter(&files, &order, prepared, &full, &basis, study.runs(), STEPS, &Silent);
    for ((name, map, seconds), c) in rows.iter().zip(certificates.expect("a march")) {
        let bytes = study.canonical_bytes(&basis, map, &c).expect("the writer takes it");
        let nanoseconds = step_nanoseconds(&bytes);
        let errors: Vec<String> =
            c.stages.iter().map(|e| format!("{:.1e} ({:.0e})", e.total, e.load)).collect();
        println!(
            "| {name_of_basis} | {modes} | {name} | {} | {} | {seconds:.1} | {nanoseconds:.0} | {:.2e} | \
             {:.2e} | {} |",
            c.terms.iter().max().expect("a stage"),
            errors.join(", "),
            c.structure.trajectory_error,
            c.structure.projection_floor,
            c.left.map_or("never".into(), |(step, outside)| format!("{step}: {outside}"))
        );
    }
}

/// Nanoseconds of a step under a held contact, the least of twenty bursts; the body starts anew with each
/// burst.
fn step_nanoseconds(bytes: &[u8]) -> f64 {
    const BURST: usize = 50;
    let opened = File::parse(bytes).expect("a file");
    let node = Chapter::read(&opened).expect("sound").expect("present").positions().next().expect("one");
    with_chapter::<f64, _>(bytes, |scene, state, loads| {
        let contact = Contact { nodes: [node; 3], weights: [1.0, 0.0, 0.0], force: [0.0, 0.0, 1.0] };
        loads.add_contact(scene, &contact).expect("a contact");
        let mut burst = || {
            state.rest();
            let clock = Instant::now();
            let taken = (0..BURST).take_while(|_| scene.step(state, loads).is_ok()).count();
            clock.elapsed().as_secs_f64() / taken.max(1) as f64
        };
        1e9 * (0..20).map(|_| burst()).fold(f64::INFINITY, f64::min)
    })
}

/// `M`, `θK_1`, `θK_2` of the first stage.
struct Regions<'a> {
    matrices: Vec<SymmetricMatrix>,
    symbolic: &'a Symbolic,
}

impl Space for Regions<'_> {
    fn n_rows(&self) -> usize {
        self.matrices[0].n()
    }

    fn n_operators(&self) -> usize {
        self.matrices.len()
    }

    fn apply(&self, t: usize, block: faer::MatRef<'_, f64>) -> Matrix {
        let mut image = Matrix::zeros(block.nrows(), block.ncols());
        self.matrices[t].mul_into(block, image.as_mut());
        image
    }

    fn solve(&self, weights: &[f64], rhs: faer::MatRef<'_, f64>) -> Result<Matrix, SeparatedError> {
        let parts: Vec<(f64, &SymmetricMatrix)> = weights.iter().copied().zip(&self.matrices).collect();
        let factor = self
            .symbolic
            .factorize(SymmetricMatrix::combine(&parts))
            .map_err(|_| SeparatedError::NotPositiveDefinite { what: "weighted space operator" })?;
        let mut x = rhs.to_owned();
        Solve::new(self.symbolic, x.ncols(), true).solve_in_place(&factor, x.as_mut());
        Ok(x)
    }
}

/// The increment `H − B` over two stiffnesses in [½, 2], in blocks of r columns, greedy and updated.
fn block_rows(study: &Study) {
    let prepared = study.prepared();
    let pencil = prepared.body.model.pencil();
    let theta = theta(&prepared.scheme, &prepared.step, 0).expect("a stage");
    let scaled = |q| SymmetricMatrix::combine(&[(theta, pencil.region_stiffness(q))]);
    let space =
        Regions { matrices: vec![pencil.mass().clone(), scaled(0), scaled(1)], symbolic: &prepared.symbolic };
    let axis = |name: &str| {
        Axis::new(name, "1", 0.5, 2.0, AxisKind::Chebyshev { points: 15 }, true).expect("an axis")
    };
    let basis = study.basis(BasisKind::Ritz, 8).expect("a basis").value;
    let problem = BlockProblem::increment(
        vec![axis("kappa_1"), axis("kappa_2")],
        &[vec![0.0, 0.0]],
        &[vec![1.0, 0.0], vec![0.0, 1.0]],
        space,
        basis.vectors.as_ref(),
    )
    .expect("shapes");
    let mass = |x: faer::MatRef<'_, f64>| {
        let mut image = Matrix::zeros(x.nrows(), x.ncols());
        pencil.mass().mul_into(x, image.as_mut());
        image
    };
    let weights: Vec<f64> = (0..pencil.n_dof()).map(|i| 1.0 / pencil.mass().diagonal(i)).collect();
    let clock = Instant::now();
    let reduction = reduce(&problem, &mass, &weights, &ReductionOptions::default()).expect("samples");
    let sampling = clock.elapsed().as_secs_f64();
    println!(
        "\nBlock, two regions in [½, 2], r = 8: {} vectors from {} solves, {sampling:.1} s.\n",
        reduction.basis.ncols(),
        reduction.points.len()
    );
    println!("| block | terms | error of the increment | separation s |\n|---|---|---|---|");
    for (name, update_sweeps) in [("greedy", 0), ("all factors updated", 3)] {
        for max_terms in [10, 20, 30] {
            let options = EnrichmentOptions {
                tolerance: 1e-13,
                max_terms,
                update_sweeps,
                patience: 100,
                ..Default::default()
            };
            let clock = Instant::now();
            let (_, report) = reduction.problem.separate(1000, &options, None).expect("a separation");
            println!(
                "| {name} | {max_terms} | {:.1e} | {:.1} |",
                report.error,
                clock.elapsed().as_secs_f64()
            );
        }
    }
}
