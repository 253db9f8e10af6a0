//! Problem files, and the reading of TOML files in general.

mod problem;
pub mod toml_file;

pub(crate) use problem::CENTRIFUGAL;
pub use problem::{
    BaseEntry, BasisEntry, BasisKind, BlockSource, ChapterEntry, Component, DampingEntry, FILE_KEYS, Fields,
    LargeEntry, LoadEntry, MaterialEntry, MatricesSource, MeshSource, ModelKind, OWN_COLUMNS, OrderEntry,
    OutputEntry, ParameterEntry, ParameterKind, ParameterScale, PatternEntry, ProbeEntry, Problem,
    ProblemError, Projection, RaisedOrder, RegionEntry, Repair, SnapshotPlan, StressPlaces, SupportEntry,
    TablesSource, TimeEntry, Tolerances, problem_schema, range_table,
};
pub(crate) use problem::{GaugeEntry, InnerProduct, Precision, STRESS_UNASKED};
