//! Problem files, and the reading of TOML files in general.

mod lengths;
mod problem;
pub mod toml_file;

pub(crate) use problem::CENTRIFUGAL;
pub use problem::{
    BaseEntry, BasisEntry, BasisKind, BlockSource, ChapterEntry, Component, CouplingEntry, CouplingKind,
    DampingEntry, DashpotEntry, EquationEntry, EquationNode, EquationTerm, FILE_KEYS, Fields, LargeEntry,
    LoadEntry, MaterialEntry, MatricesSource, MeshSource, ModelKind, Motion, NodalForce, OWN_COLUMNS,
    OrderEntry, OutputEntry, ParameterEntry, ParameterKind, ParameterScale, PatternEntry, PointMassEntry,
    PortEntry, PortKind, PrestressEntry, ProbeEntry, Problem, ProblemError, Projection, RaisedOrder,
    ReferencePointEntry, RegionEntry, Repair, SnapshotPlan, SpringEntry, StressPlaces, SupportEntry,
    TablesSource, TieEntry, TimeEntry, Tolerances, problem_schema, range_table,
};
pub(crate) use problem::{GaugeEntry, InnerProduct, Precision, STRESS_UNASKED};
