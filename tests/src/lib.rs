//! What crosses crates is tested here.

pub mod annotate;
pub mod bases;
pub mod bending;
pub mod by_hand;
pub mod calibration;
pub mod canonical;
pub mod complex_step;
pub mod denormals;
pub mod exact_beam;
pub mod fused;
pub mod golden;
pub mod held_rows;
pub mod hostile;
pub mod large;
pub mod largest;
pub mod live_beam;
pub mod live_point;
pub mod long_march;
pub mod matrices;
pub mod normal;
pub mod page;
pub mod program;
pub mod random_terms;
pub mod regions;
pub mod shared;
#[cfg(unix)]
pub mod soak;
pub mod soft_cube;
pub mod stage;
pub mod strained;
pub mod stress;
pub mod synthetic;
pub mod textbook;
pub mod total_error;
pub mod witness;

/// The lowest minor version of the format that has everything a file is stepped and shown with: the
/// discretisation error of a build is beside that.
#[must_use]
pub fn needed_minor(file: &vademecum_format::File<'_>) -> u16 {
    let kinds = file.sections().map(|section| section.kind());
    kinds
        .filter(|kind| *kind != vademecum_format::SectionKind::MeshError)
        .map(|kind| kind.since())
        .max()
        .unwrap_or(0)
}
