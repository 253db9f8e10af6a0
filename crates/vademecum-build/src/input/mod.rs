//! Problem files, and the reading of TOML files in general.

mod interface;
mod lengths;
mod problem;
pub mod toml_file;

pub use interface::{InterfaceEntry, InterfaceKind};
pub use problem::{
    BaseEntry, BasisEntry, BasisKind, BlockSource, ChapterEntry, Component, CouplingEntry, CouplingKind,
    DampingEntry, DashpotEntry, EquationEntry, EquationNode, EquationTerm, FILE_KEYS, Fields, LargeEntry,
    LoadEntry, MaterialEntry, MatricesSource, MeshSource, ModelKind, Motion, NodalForce, OWN_COLUMNS,
    OrderEntry, OutputEntry, ParameterEntry, ParameterKind, ParameterScale, PatternEntry, PointMassEntry,
    PortEntry, PortKind, PrestressEntry, ProbeEntry, Problem, ProblemError, Projection, RaisedOrder,
    ReferencePointEntry, RegionEntry, Repair, SnapshotPlan, SpringEntry, StressPlaces, SupportEntry,
    TablesSource, TieEntry, TimeEntry, Tolerances, problem_schema, range_table,
};
pub(crate) use problem::{CENTRIFUGAL, GaugeEntry, InnerProduct, Precision, STRESS_UNASKED, perpendicular};
