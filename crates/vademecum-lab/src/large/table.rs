//! Result of a comparison at large displacements: one row per method and length of its own step.

use std::fmt;

use serde::{Serialize, Serializer};

use crate::method::Precision;
use crate::table::{Column, column, figures, part, whole};

/// Everything a comparison found. Errors are relative L2 over all dofs and steps in the mass norm.
#[derive(Serialize)]
pub struct LargeBenchTable {
    /// Title of the problem.
    pub title: String,
    /// Free dofs.
    pub dofs: usize,
    /// Coordinates of the file.
    pub coordinates: usize,
    /// Rows of its strain map.
    pub strain_rows: usize,
    /// Steps of the file behind the errors.
    pub steps: usize,
    /// Step of the file \[s\].
    pub time_step: f64,
    /// Steps in the first natural period.
    pub steps_per_first_period: f64,
    /// Largest displacement of the loadable surface at full order \[m\].
    pub displacement: f64,
    /// The least principal stretch in any element and step, at full order.
    pub least_stretch: f64,
    /// Distance of the reference, from which all errors are measured, from a march with twice its step. Of a
    /// smooth motion the error of the reference is about a third of it.
    pub truth_error: f64,
    /// Steps of the reference in a step of the file.
    pub truth_parts: usize,
    /// Steps of one timed burst of a file.
    pub burst: usize,
    /// Rounds in which the files took turns.
    pub rounds: usize,
    /// Of the clock and the loop, in the time of every step of a file \[ns\].
    pub clock_ns_per_step: f64,
    /// Relative distance of the medians of the rounds.
    pub noise: f64,
    /// One per method and length of its own step.
    pub methods: Vec<LargeRow>,
}

/// Method of a row. Its text is the row's name in every record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LargeMethod {
    /// The file, through the evaluator.
    File(Precision),
    /// The linear model of the same coordinates, moved exactly, through the evaluator.
    Linear,
    /// The strain of all elements on the same coordinates: Bathe's method, and Newton's in the coordinates.
    Galerkin,
    /// Bathe's method at full order.
    FullOrder,
}

impl fmt::Display for LargeMethod {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::File(Precision::Double) => "file f64",
            Self::File(Precision::Single) => "file f32",
            Self::Linear => "linear model f64",
            Self::Galerkin => "galerkin over all elements, bathe and newton",
            Self::FullOrder => "full order, bathe and newton",
        })
    }
}

impl Serialize for LargeMethod {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// One method with one length of its own step.
#[derive(Serialize)]
pub struct LargeRow {
    /// Method.
    pub name: LargeMethod,
    /// Coordinates; absent at full order.
    pub modes: Option<usize>,
    /// Sub-steps, or steps of its own, in a step of the file.
    pub substeps: usize,
    /// Wall time of everything it needs before the first step \[s\].
    pub offline_seconds: f64,
    /// Bytes of its file; absent without a file.
    pub file_bytes: Option<usize>,
    /// Median time of a step of the file, all sub-steps \[ns\].
    pub step_ns_p50: f64,
    /// 99th percentile \[ns\].
    pub step_ns_p99: f64,
    /// Time of four steps at full order over that of the row.
    pub times_full_order: f64,
    /// Errors.
    #[serde(flatten)]
    pub errors: LargeErrors,
}

/// Error of a method and its parts; the parts a method does not have, or that were not told apart, are
/// `None`.
///
/// ```text
/// reference ─basis─ its projection ─closure─ the file with very short sub-steps ─time─ the file ─rounding─
/// in f32
/// ```
///
/// Each part is the distance between two neighbours, so the total is at most their sum.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct LargeErrors {
    /// From the reference.
    pub error_total: f64,
    /// From the reference to its projection on the basis: the projection error.
    pub error_basis: Option<f64>,
    /// From there to the motion of the strain map, with sub-steps so short that they make no difference.
    pub error_closure: Option<f64>,
    /// From there to the sub-steps of the row; at full order the whole error.
    pub error_time: Option<f64>,
    /// From f64 to f32.
    pub error_rounding: Option<f64>,
}

/// All columns.
pub const LARGE_COLUMNS: [Column<LargeRow>; 13] = [
    column("name", |row: &LargeRow| row.name.to_string()),
    column("modes", |row| whole(row.modes)),
    column("substeps", |row| row.substeps.to_string()),
    column("offline_seconds", |row| figures(row.offline_seconds)),
    column("file_bytes", |row| whole(row.file_bytes)),
    column("step_ns_p50", |row| figures(row.step_ns_p50)),
    column("step_ns_p99", |row| figures(row.step_ns_p99)),
    column("times_full_order", |row| figures(row.times_full_order)),
    column("error_total", |row| format!("{:.3e}", row.errors.error_total)),
    column("error_basis", |row| part(row.errors.error_basis)),
    column("error_closure", |row| part(row.errors.error_closure)),
    column("error_time", |row| part(row.errors.error_time)),
    column("error_rounding", |row| part(row.errors.error_rounding)),
];
