//! Results that several commands print.

use vademecum_build::certificate::{LargeReport, StructureReport};
use vademecum_build::report::BuildReport;
use vademecum_build::report::ChapterReport;
use vademecum_study::parameters::ParameterValue;
use vademecum_study::verify::{LargeVerification, Verification};

use crate::mesh_error;

/// A value as JSON text.
pub fn json(value: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(value).expect("what is printed has string keys and finite nesting")
}

/// Prints a value as JSON on standard output.
pub fn print_json(value: &impl serde::Serialize) {
    println!("{}", json(value));
}

/// A length for people.
pub(crate) fn bytes(length: usize) -> String {
    match length {
        0..10_000 => format!("{length} bytes"),
        10_000..10_000_000 => format!("{:.1} kB", length as f64 / 1e3),
        _ => format!("{:.1} MB", length as f64 / 1e6),
    }
}

/// Prints a build's report.
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
    println!("\nmode  frequency [Hz]  energy     damping: material  scheme     period");
    for (k, row) in report.mode_table.iter().enumerate() {
        // Natural modes have no share of the energy of any snapshots.
        let energy = if row.energy.is_nan() { "-".into() } else { format!("{:.2e}", row.energy) };
        println!(
            "{:>4}  {:>14.6}  {energy:>9}  {:>17.3e}  {:>9.2e}  {:>+9.2e}",
            k + 1,
            row.frequency_hz,
            row.physical_damping,
            row.numerical_damping,
            row.period_elongation
        );
    }
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
            "stage {}: {} terms, map error {:.2e} (state {:.2e}, load {:.2e})",
            i + 1,
            s.terms,
            s.error,
            s.state_error,
            s.load_error
        );
    }
}

fn print_structure(name: &str, s: &StructureReport) {
    let ratio = if s.floor_ratio.is_finite() { format!("{:.3}", s.floor_ratio) } else { "-".into() };
    println!(
        "{name:<9}  {:>16.3e}  {:>9.3e}  {ratio:>11}  1 {:>+13.1e}  {:>12.9}  {:>13.9}  {:>11.1e}",
        s.trajectory_error,
        s.projection_floor,
        s.spectral_radius - 1.0,
        s.energy_ratio,
        s.energy_growth,
        s.reciprocity
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
    }
    if let Some(error) = v.stress_error {
        println!("stress                 {error:.3e}  (largest von Mises of the difference, of the largest)");
    }
    if let Some(bound) = &v.bound {
        println!(
            "error of any point load: median {:.1e}, 95th percentile {:.1e}, worst {:.1e} ({}, without the static part)",
            bound.median, bound.p95, bound.worst, bound.kind
        );
    }
    println!("spectral radius        1 {:+.2e}", v.spectral_radius - 1.0);
    println!(
        "energy after release   {:+.3e}  (full order {:+.3e}); largest ÷ at release {:.9}",
        v.energy_drift, v.energy_drift_full_order, v.energy_ratio
    );
    print_seconds(v.vademecum_seconds_per_step, v.full_order_seconds_per_step);
}

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
    }
    println!(
        "energy identity        {:.1e}  (largest violation in a step, over the largest energy)",
        v.energy_identity
    );
    println!(
        "energy after release   {:+.3e}  (full order {:+.3e})",
        v.energy_drift, v.energy_drift_full_order
    );
    print_seconds(v.vademecum_seconds_per_step, v.full_order_seconds_per_step);
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
