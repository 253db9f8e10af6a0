//! The pictures of a comparison: time against error, both logarithmic, with the front no row beats in both.

use std::path::Path;

use vademecum_build::input::BasisKind;
use vademecum_build::store::Outputs;
use vademecum_lab::{BenchTable, Identity, LargeBenchTable, LargeRow, Row, Way, front};

use super::scatter::{Cloud, scatter};
use super::words::words;
use vademecum_cli::Failure;
use vademecum_cli::front::{Chart, DrawResult, write_picture};

/// Draws pareto.svg (the error of the reduction) and pareto-total.svg (the total error).
pub fn draw(outputs: &Outputs, folder: &Path, table: &BenchTable) -> Result<(), Failure> {
    let draw = |name: &str, picture| write_picture(outputs, &folder.join(name), scatter_of(picture));
    draw("pareto.svg", of_reduction(table))?;
    draw("pareto-total.svg", of_everything(table))?;
    Ok(())
}

/// Draws pareto.svg of a comparison at large displacements: the total error.
pub fn draw_large(outputs: &Outputs, folder: &Path, table: &LargeBenchTable) -> Result<(), Failure> {
    let point = |row: &LargeRow| Point {
        cloud: row.name.to_string(),
        time: row.step_ns_p50,
        error: row.errors.error_total,
        word: row.substeps.to_string(),
    };
    let picture = Picture {
        title: "time against total error at large displacements; beside the points sub-steps, or steps in a step",
        x: "median time of a step of the file [ns]",
        y: "relative error against a fine march at full order",
        points: table.methods.iter().map(point).collect(),
    };
    write_picture(outputs, &folder.join("pareto.svg"), scatter_of(picture))?;
    Ok(())
}

/// Error of the reduction: against full order at the same Δt.
fn of_reduction(table: &BenchTable) -> Picture {
    // In print f64 lies on f32, and the natural modes of either structure on each other.
    let shown = |name: Identity| match name.way() {
        None | Some(Way::ExactMotion | Way::Exact) => false,
        Some(Way::TwoStage | Way::Block) if name.is_on(BasisKind::Modes) => false,
        Some(Way::DenseSolves | Way::TwoStage | Way::Chapter | Way::Repaired) => true,
        Some(_) => name.is_single(),
    };
    let points = table.methods.iter().filter(|row| {
        row.time_step == table.time_step && shown(row.name) && !row.errors.trajectory_error.is_nan()
    });
    let point = |row: &Row| Point {
        cloud: row.name.to_string(),
        time: row.step_ns_p50,
        error: row.errors.trajectory_error,
        word: words(row, table.time_step),
    };
    Picture {
        title: "time against error of the reduction; beside the points modes and terms",
        x: "median time of a step [ns]",
        y: "relative error against full order with the same Δt",
        points: points.map(point).collect(),
    }
}

/// Total error, time scheme included; of the methods that move by stages those with
/// the most modes, the others lie on them.
fn of_everything(table: &BenchTable) -> Picture {
    let shown = |name: Identity| match name.way() {
        None | Some(Way::DenseSolves) => true,
        Some(Way::Exact) => name.is_single(),
        Some(Way::Diagonal | Way::Separated) => name.is_on(BasisKind::Ritz) && name.is_single(),
        Some(_) => false,
    };
    let most = table.methods.iter().filter_map(|row| row.modes).max();
    let point = |row: &Row| {
        // What exact steps miss are modes.
        let by_modes = row.name.way() == Some(Way::Exact) && row.time_step == table.time_step;
        let fewer = row.terms.is_none() && !by_modes && row.modes.is_some_and(|r| Some(r) != most);
        if fewer || !shown(row.name) {
            return None;
        }
        // All schemes are one cloud.
        let (cloud, scheme) = match row.name {
            Identity::FullOrder(scheme) => ("full order".to_string(), Some(scheme.to_string())),
            reduced => (reduced.to_string(), None),
        };
        let parts = [scheme, Some(words(row, table.time_step))];
        let parts: Vec<String> = parts.into_iter().flatten().filter(|part| !part.is_empty()).collect();
        let time = row.steps_per_step * row.step_ns_p50;
        Some(Point { cloud, time, error: row.errors.error_total, word: parts.join(", ") })
    };
    Picture {
        title: "time against total error; beside the points modes, terms, and Δt where it is another",
        x: "median time of a march per Δt of the problem [ns]",
        y: "total error: against the motion exact in time",
        points: table.methods.iter().filter_map(point).collect(),
    }
}

/// Points of time and error to be drawn.
struct Picture {
    title: &'static str,
    x: &'static str,
    y: &'static str,
    points: Vec<Point>,
}

/// One of them, with its cloud and a word beside it.
struct Point {
    cloud: String,
    time: f64,
    error: f64,
    word: String,
}

fn scatter_of(picture: Picture) -> DrawResult {
    let mut clouds: Vec<Cloud> = vec![];
    let points: Vec<(f64, f64)> = picture.points.iter().map(|p| (p.time, p.error)).collect();
    for Point { cloud: name, time, error, word } in picture.points {
        match clouds.iter_mut().find(|cloud| cloud.name == name) {
            Some(cloud) => cloud.points.push((time, error, word)),
            None => clouds.push(Cloud { name, points: vec![(time, error, word)] }),
        }
    }
    let chart = Chart { title: picture.title, x: picture.x, y: picture.y, log_y: true };
    scatter(&chart, &clouds, &front(points))
}
