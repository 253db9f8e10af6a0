//! Results that several commands print.

use std::path::Path;

use vademecum_build::certificate::{LargeReport, StructureReport, TestLoad};
use vademecum_build::dynamics::ModeRow;
use vademecum_build::report::BuildReport;
use vademecum_build::report::ChapterReport;
use vademecum_deck::{Deck, LeftOut};
use vademecum_format::File;
use vademecum_study::FileError;
use vademecum_study::parameters::ParameterValue;
use vademecum_study::verify::{LargeVerification, Verification};

use crate::accuracy::{Accuracy, bound_words};
use crate::mesh_error;
use crate::words::{bytes, duration, hertz};

/// A value as JSON text.
pub fn json(value: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(value).expect("what is printed has string keys and finite nesting")
}

/// Prints a value as JSON on standard output.
pub fn print_json(value: &impl serde::Serialize) {
    println!("{}", json(value));
}

/// Prints what a deck holds, its units, and the cards that were not taken.
pub(crate) fn print_left_out(deck: &Deck) {
    let mesh = &deck.mesh;
    println!(
        "{}: dialect of {}; units {}; {} nodes, {} elements",
        deck.file.display(),
        deck.program,
        deck.units.words(),
        mesh.nodes.len(),
        mesh.element_count()
    );
    deck.notes.iter().for_each(|note| println!("note: {note}"));
    println!("{}", if deck.left_out.is_empty() { "every card was taken" } else { "not taken:" });
    for LeftOut { card, line, count, meaning, .. } in &deck.left_out {
        let more = if *count > 1 { format!(" (and {} more)", count - 1) } else { String::new() };
        println!("  line {line}{more}, {card}: {meaning}");
    }
}

/// Prints a build in a few lines: body, frequencies, what is known of the error, file.
///
/// # Errors
/// As [`Accuracy::of`].
pub(crate) fn print_summary(report: &BuildReport, file: &File<'_>, path: &Path) -> Result<(), FileError> {
    let BuildReport { nodes, elements, dofs, modes, mode_table, .. } = report;
    println!("{nodes} nodes, {elements} elements, {dofs} free dofs; {modes} modes");
    let frequencies = || mode_table.iter().map(|row| row.frequency_hz);
    let [first, last] = [frequencies().fold(f64::INFINITY, f64::min), frequencies().fold(0.0, f64::max)];
    let m = file.metadata();
    println!(
        "natural frequencies {} to {}; time step {}{}",
        hertz(first),
        hertz(last),
        duration(m.time_step),
        if m.scheme.is_exact() && report.large.is_none() { ", exact at any step" } else { "" }
    );
    Accuracy::of(file)?.lines().iter().for_each(|line| println!("{line}"));
    report.mesh_error.iter().for_each(|estimate| println!("{}", mesh_error::in_a_line(estimate)));
    let seconds = report.timings.iter().map(|timing| timing.seconds).sum();
    let path = path.display();
    println!("wrote {path} ({}) in {}", bytes(report.file_bytes), duration(seconds));
    Ok(())
}

/// Prints a build's report: modes, certificate, stages.
pub(crate) fn print_report(report: &BuildReport) {
    println!(
        "{} nodes, {} elements, {} free dofs; {} snapshots; {} modes; {:.1} steps per first period",
        report.nodes,
        report.elements,
        report.dofs,
        report.snapshots,
        report.modes,
        report.steps_per_first_period
    );
    print_modes(&report.mode_table);
    if let Some(large) = &report.large {
        print_large(large);
        print_mesh_error(report);
        return print_timings(report);
    }
    println!(
        "\nstructure  trajectory error  floor      error/floor  spectral radius  energy ratio  energy growth  reciprocity"
    );
    let certificate = &report.certificate;
    for (name, structure) in [("diagonal", &certificate.diagonal), ("block", &certificate.block)] {
        if let Some(s) = structure {
            print_structure(name, s);
        }
    }
    if let Some(c) = &certificate.chapter {
        print_chapter(c);
    }
    for TestLoad { point: [x, y, z], force: [fx, fy, fz], end } in &report.test_loads {
        println!(
            "test run: a push at ({x:.6}, {y:.6}, {z:.6}) by ({fx:.4}, {fy:.4}, {fz:.4}) N for {}",
            duration(*end)
        );
    }
    if let Some(s) = &report.separation {
        println!(
            "\nseparated: {} terms on axes of {:?} points, from {} full-order solves ({} vectors); stopped \
             by {}",
            s.terms, s.axis_points, s.samples, s.reduced_size, s.stop
        );
        let block = report.certificate.block.as_ref();
        if let Some(c) = block {
            println!(
                "map error over fresh points {:.2e} rms, {:.2e} worst",
                c.map_error_rms, c.map_error_max
            );
        }
        println!(
            "worst trajectory at {}; largest spectral radius at {}",
            s.place(&s.worst_trajectory_at),
            s.place(&s.worst_radius_at)
        );
        s.repairs.iter().for_each(|done| println!("repaired: {done}"));
    }
    print_mesh_error(report);
    print_timings(report);
}

fn print_mesh_error(report: &BuildReport) {
    if let Some(estimate) = &report.mesh_error {
        println!();
        mesh_error::lines(estimate).iter().for_each(|line| println!("{line}"));
    }
}

/// Prints the table of modes, without columns that say nothing: natural modes have no share of the energy of
/// snapshots, and exact steps neither damp nor stretch.
fn print_modes(table: &[ModeRow]) {
    type Column = (&'static str, fn(&ModeRow) -> String);
    let all: [Column; 5] = [
        ("frequency [Hz]", |row| format!("{:.6}", row.frequency_hz)),
        ("energy", |row| format!("{:.2e}", row.energy)),
        ("damping ratio", |row| format!("{:.3e}", row.physical_damping)),
        ("of the scheme", |row| format!("{:.2e}", row.numerical_damping)),
        ("period", |row| format!("{:+.2e}", row.period_elongation)),
    ];
    let columns = all.into_iter().filter(|(name, _)| match *name {
        "energy" => table.iter().any(|row| !row.energy.is_nan()),
        "of the scheme" => table.iter().any(|row| row.numerical_damping != 0.0),
        "period" => table.iter().any(|row| row.period_elongation != 0.0),
        _ => true,
    });
    let columns: Vec<Column> = columns.collect();
    let line = |cells: Vec<String>| cells.iter().map(|cell| format!("  {cell:>14}")).collect::<String>();
    println!("\nmode{}", line(columns.iter().map(|(name, _)| name.to_string()).collect()));
    for (k, row) in table.iter().enumerate() {
        println!("{:>4}{}", k + 1, line(columns.iter().map(|(_, value)| value(row)).collect()));
    }
}

/// Prints the certificate of large displacements.
fn print_large(large: &LargeReport) {
    println!("\nlarge displacements: {}", large.strain_map);
    println!(
        "push   moves [m]  least stretch  error     floor     strain map  sub-steps  reference  linear model  energy \
         identity"
    );
    for run in &large.runs {
        println!(
            "{:<5}  {:>9.3e}  {:>13.2}  {:.2e}  {:.2e}  {:>10.2e}  {:>9.2e}  {:>9.2e}  {:>12.2e}  {:>15.1e}",
            if run.pulse { "pulse" } else { "held" },
            run.displacement,
            run.least_stretch,
            run.error,
            run.floor,
            run.closure_error,
            run.time_error,
            run.reference_error,
            run.linear_error,
            run.energy_identity
        );
    }
}

fn print_timings(report: &BuildReport) {
    println!("\nstage                     seconds  peak memory");
    for timing in &report.timings {
        let memory = timing.peak_memory_bytes.map_or("?".into(), |b| bytes(b as usize));
        println!("{:<24}  {:>7.2}  {:>11}", timing.stage, timing.seconds, memory);
    }
}

/// Prints the certificate of the chapter's structure.
pub(crate) fn print_chapter(c: &ChapterReport) {
    print_structure("chapter", &c.structure);
    if let Some(step) = c.left_at {
        println!("a trajectory left the parameter ranges at step {step}; errors are of the steps before");
    }
    for (i, s) in c.stages.iter().enumerate() {
        println!(
            "stage {}: {} terms, map error {} (state {}, load {})",
            i + 1,
            s.terms,
            figure(s.error, |x| format!("{x:.2e}")),
            figure(s.state_error, |x| format!("{x:.2e}")),
            figure(s.load_error, |x| format!("{x:.2e}"))
        );
    }
}

/// A number in words, or a dash for one that is not known.
pub(crate) fn figure(value: f64, text: impl Fn(f64) -> String) -> String {
    if value.is_finite() { text(value) } else { "-".into() }
}

fn print_structure(name: &str, s: &StructureReport) {
    println!(
        "{name:<9}  {:>16}  {:>9}  {:>11}  {:>15}  {:>12}  {:>13}  {:>11}",
        figure(s.trajectory_error, |x| format!("{x:.3e}")),
        figure(s.projection_floor, |x| format!("{x:.3e}")),
        figure(s.floor_ratio, |x| format!("{x:.3}")),
        figure(s.spectral_radius, |x| format!("1 {:>+13.1e}", x - 1.0)),
        figure(s.energy_ratio, |x| format!("{x:.9}")),
        figure(s.energy_growth, |x| format!("{x:.9}")),
        figure(s.reciprocity, |x| format!("{x:.1e}"))
    );
}

/// Reciprocity of a structure, and the largest gain of energy of free motions; empty where a file does not
/// say.
pub(crate) fn symmetry(s: &StructureReport) -> String {
    if s.reciprocity.is_nan() {
        return String::new();
    }
    format!(
        "; reciprocity error {:.1e}; largest energy of free motions in a million steps {:.6} of the initial one",
        s.reciprocity, s.energy_growth
    )
}

/// Prints what a verification measured.
pub(crate) fn print_verification(v: &Verification) {
    println!("{} steps, {} free dofs, {} modes, {} structure", v.steps, v.dofs, v.modes, v.structure);
    print_parameters(&v.parameters);
    println!(
        "trajectory error       {:.3e}  (relative L2, mass norm, all dofs and steps)",
        v.trajectory_error
    );
    println!(
        "projection error       {:.3e}  (error ÷ projection error {:.4})",
        v.projection_floor, v.floor_ratio
    );
    let truth = &v.truth;
    println!(
        "total error            {:.3e}  (against a reference exact in time, whose own error is about {:.0e}: {} vectors)",
        truth.total_error, truth.truth_error, truth.truth_vectors
    );
    match truth.time_error {
        Some(error) => println!("  time integration     {error:.3e}  (the same scheme at full order)"),
        None => println!("  time integration     none       (exact in time)"),
    }
    println!("  basis                {:.3e}  (projection error)", truth.basis_error);
    println!("  evaluation           {:.3e}  (added by the coordinates of the file)", truth.rest_error);
    if let Some(error) = truth.contact_error {
        println!("under the contacts     {error:.3e}  (along the force, while it acts; the largest)");
        print_contacts(&truth.contact_errors);
    }
    if let Some(error) = v.stress_error {
        println!("stress                 {error:.3e}  (largest von Mises of the difference, of the largest)");
    }
    if let Some(bound) = &v.bound {
        println!("{} (without residual flexibility)", bound_words(bound));
    }
    println!("spectral radius        1 {:+.2e}", v.spectral_radius - 1.0);
    match (v.energy_drift, v.energy_drift_full_order, v.energy_ratio) {
        (Some(own), Some(full), Some(ratio)) => println!(
            "energy after release   {own:+.3e}  (full order {full:+.3e}); largest ÷ at release {ratio:.9}"
        ),
        _ => println!("{NOT_RELEASED}"),
    }
    print_seconds(v.vademecum_seconds_per_step, v.full_order_seconds_per_step);
}

/// In place of the energy after release.
const NOT_RELEASED: &str = "energy after release   not measured: a load acts to the end";

/// The same beside a march at large displacements.
pub(crate) fn print_large_verification(v: &LargeVerification) {
    println!("{} steps, {} free dofs, {} coordinates, {} structure", v.steps, v.dofs, v.modes, v.structure);
    print_parameters(&v.parameters);
    println!("surface moves by       {:.3e} m at most, at full order", v.displacement);
    println!(
        "trajectory error       {:.3e}  (relative L2, mass norm, all dofs and steps)",
        v.trajectory_error
    );
    println!("projection error       {:.3e}  (best approximation in the basis)", v.projection_floor);
    println!("linear model           {:.3e}  (of the same basis, stepped exactly)", v.linear_error);
    println!(
        "reference              {:.3e}  (its distance, in {} steps for one of the file, from a march in half as many)",
        v.truth_error, v.truth_parts
    );
    if let Some(error) = v.contact_error {
        println!("under the contacts     {error:.3e}  (along the force, while it acts; the largest)");
        print_contacts(&v.contact_errors);
    }
    println!(
        "energy identity        {:.1e}  (largest violation in a step, over the largest energy)",
        v.energy_identity
    );
    match (v.energy_drift, v.energy_drift_full_order) {
        (Some(own), Some(full)) => println!("energy after release   {own:+.3e}  (full order {full:+.3e})"),
        _ => println!("{NOT_RELEASED}"),
    }
    print_seconds(v.vademecum_seconds_per_step, v.full_order_seconds_per_step);
}

/// Prints the error under each of several contacts.
fn print_contacts(errors: &[Option<f64>]) {
    for (number, error) in errors.iter().enumerate().filter(|_| errors.len() > 1) {
        let error = error.map_or("-         (moves nothing)".into(), |error| format!("{error:.3e}"));
        println!("  {:<21}{error}", format!("contact[{number}]"));
    }
}

fn print_parameters(parameters: &[ParameterValue]) {
    if !parameters.is_empty() {
        let values: Vec<_> = parameters.iter().map(|p| format!("`{}` = {}", p.name, p.value)).collect();
        println!("at                     {}", values.join(", "));
    }
}

fn print_seconds(own: f64, full_order: f64) {
    println!(
        "seconds per step       {own:.3e}  (full order {full_order:.3e}, {:.0} times as long)",
        full_order / own
    );
}
