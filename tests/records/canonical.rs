//! The record of `docs/measurements/chapter.md`: the chapter's representation, each repair alone and all
//! together, on one body.
//!
//! `cargo run --release -p vademecum-tests --example canonical [-- PROBLEM.toml]`; without arguments the
//! fixture `canonical-beam.toml`.

use std::time::Instant;

use vademecum_build::dynamics::FullOrder;
use vademecum_build::export::NodeOrder;
use vademecum_build::input::{BasisKind, ChapterEntry, Problem, Repair};
use vademecum_build::progress::Silent;
use vademecum_chapter::{ChapterCertificate, ChapterMap, ChapterSetting, ChapterUnseen, certify_chapter};
use vademecum_eval::{Contact, Place};
use vademecum_format::{Chapter, File};
use vademecum_lab::chapter_bytes;
use vademecum_study::parts::Study;
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
        "| basis | r | canonical | terms | stage errors (load part) | offline s | ns a step, f64 | error \
         | floor | left at |"
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
        chapter_bytes(study, &basis, map, &ChapterCertificate::of_maps(map)).expect("the writer takes it")
    };
    let bytes: Vec<Vec<u8>> = rows.iter().map(|row| measured(&row.1)).collect();
    let files: Vec<(&ChapterMap, &[u8])> =
        rows.iter().zip(&bytes).map(|(row, bytes)| (&row.1, &bytes[..])).collect();
    let order = NodeOrder::new(&prepared.body);
    let unseen = ChapterUnseen::draw(&rows[0].1, &prepared.body, &order, study.runs(), STEPS);
    let certificates = certify_chapter(&files, &unseen, pencil.mass(), &full, &basis, &Silent);
    for ((name, map, seconds), c) in rows.iter().zip(certificates.expect("a march")) {
        let bytes = chapter_bytes(study, &basis, map, &c).expect("the writer takes it");
        let nanoseconds = step_nanoseconds(&bytes);
        let errors: Vec<String> =
            c.stages.iter().map(|e| format!("{:.1e} ({:.0e})", e.total, e.load)).collect();
        println!(
            "| {name_of_basis} | {modes} | {name} | {} | {} | {seconds:.1} | {nanoseconds:.0} | {:.2e} \
             | {:.2e} | {} |",
            c.terms.iter().max().expect("a stage"),
            errors.join(", "),
            c.structure.certificate.trajectory_error,
            c.structure.certificate.projection_floor,
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
    with_chapter(bytes, |scene, state, loads| {
        let contact = Contact::new(Place::triangle([node; 3], [1.0, 0.0, 0.0]), [0.0, 0.0, 1.0]);
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
