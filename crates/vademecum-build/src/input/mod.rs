//! Problem files, and the reading of TOML files in general.

mod problem;
pub mod toml_file;

pub(crate) use problem::CENTRIFUGAL;
pub use problem::{
    BaseEntry, BasisEntry, BasisKind, BlockSource, ChapterEntry, Component, DampingEntry, FILE_KEYS, Fields,
    GaugeEntry, InnerProduct, LargeEntry, LoadEntry, MaterialEntry, MatricesSource, MeshSource, ModelKind,
    OrderEntry, OutputEntry, ParameterEntry, ParameterKind, ParameterScale, PatternEntry, Precision,
    ProbeEntry, Problem, ProblemError, Projection, RegionEntry, Repair, Representation, STRESS_UNASKED,
    SnapshotPlan, StressPlaces, SupportEntry, TablesSource, TimeEntry, Tolerances, problem_schema,
    range_table,
};
