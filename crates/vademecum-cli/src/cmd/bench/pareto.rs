//! The pictures of a comparison: time against error, both logarithmic, with the front no row beats in both.

use std::path::Path;

use super::output::{EXACT, Report, Row};
use crate::failure::{Cause, Failure};
use crate::pictures::{Chart, Cloud, scatter};

/// Draws pareto.svg (the error of the reduction) and pareto-total.svg (the total error).
pub fn draw(folder: &Path, report: &Report) -> Result<(), Failure> {
    scatter_of(&folder.join("pareto.svg"), &of_reduction(report))?;
    scatter_of(&folder.join("pareto-total.svg"), &of_everything(report))
}

/// What reduction costs in accuracy: against full order at the same Δt.
fn of_reduction(report: &Report) -> Picture<'_> {
    // In print f64 lies on f32, and the natural modes of either structure on each other.
    let shown = |name: &str| {
        !name.starts_with("full order")
            && !name.starts_with("natural modes, block")
            && name != EXACT
            && (name.ends_with("f32")
                || ["two-stage", "dense solves", "canonical"].iter().any(|part| name.contains(part)))
    };
    let points = report.methods.iter().filter(|row| {
        row.time_step == report.time_step && shown(&row.name) && !row.errors.trajectory_error.is_nan()
    });
    Picture {
        title: "time against error of the reduction; beside the points modes and terms",
        x: "median time of a step [ns]",
        y: "relative error against full order with the same Δt",
        points: points
            .map(|row| {
                (row.name.as_str(), row.step_ns_p50, row.errors.trajectory_error, row.words(report.time_step))
            })
            .collect(),
    }
}

/// What everything costs in accuracy, the time scheme included; of the reduced methods those with the most modes, the
/// others lie on them.
fn of_everything(report: &Report) -> Picture<'_> {
    let cloud = |row: &'_ Row| -> Option<&'static str> {
        let shown = [
            "full order",
            "pod-galerkin, dense solves f64",
            "ritz diagonal f32",
            "ritz separated f32",
            EXACT,
        ];
        shown.into_iter().find(|name| row.name.starts_with(name))
    };
    let most = report.methods.iter().filter_map(|row| row.modes).max();
    let point = |row: &Row| {
        if row.terms.is_none() && row.modes.is_some_and(|r| Some(r) != most) {
            return None;
        }
        let scheme = row.name.strip_prefix("full order, ");
        let words = [scheme.map(str::to_string), Some(row.words(report.time_step))];
        let words: Vec<String> = words.into_iter().flatten().filter(|w| !w.is_empty()).collect();
        let time = row.steps_per_step * row.step_ns_p50;
        Some((cloud(row)?, time, row.errors.error_total, words.join(", ")))
    };
    Picture {
        title: "time against total error; beside the points modes, terms, and Δt where it is another",
        x: "median time of a march per Δt of the problem [ns]",
        y: "relative error against the fine full-order march",
        points: report.methods.iter().filter_map(point).collect(),
    }
}

/// Points of time and error to be drawn, each with its cloud and a word beside it.
struct Picture<'a> {
    title: &'a str,
    x: &'a str,
    y: &'a str,
    points: Vec<(&'a str, f64, f64, String)>,
}

fn scatter_of(path: &Path, picture: &Picture<'_>) -> Result<(), Failure> {
    let mut clouds: Vec<Cloud<'_>> = vec![];
    for (name, time, error, word) in &picture.points {
        let point = (*time, *error, word.clone());
        match clouds.iter_mut().find(|cloud| cloud.name == *name) {
            Some(cloud) => cloud.points.push(point),
            None => clouds.push(Cloud { name, points: vec![point] }),
        }
    }
    let chart = Chart { title: picture.title, x: picture.x, y: picture.y, log_y: true };
    let failed = |error: Box<dyn std::error::Error>| Failure::new(Cause::Machine, error.to_string());
    scatter(path, &chart, &clouds, &front(&clouds)).map_err(failed)
}

/// Points are on the front if no faster one comes within this factor of their error: digits that differ behind the second
/// figure are no reason to step slower.
pub const BETTER: f64 = 0.99;

/// The points no other point beats in both time and error, fastest first.
fn front(clouds: &[Cloud<'_>]) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> =
        clouds.iter().flat_map(|c| c.points.iter().map(|p| (p.0, p.1))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    points.retain(|p| {
        let better = p.1 < BETTER * least;
        least = least.min(p.1);
        better
    });
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_falls() {
        let points = [(3.0, 0.5), (1.0, 0.9), (2.0, 1.0), (4.0, 0.6), (5.0, 0.1), (6.0, 0.0999)];
        let cloud = |p: &[(f64, f64)]| p.iter().map(|&(x, y)| (x, y, String::new())).collect();
        let clouds = [
            Cloud { name: "a", points: cloud(&points[..2]) },
            Cloud { name: "b", points: cloud(&points[2..]) },
        ];
        assert_eq!(front(&clouds), [(1.0, 0.9), (3.0, 0.5), (5.0, 0.1)]);
    }
}
