//! Table of modes: effect of scheme and damping on each.

use faer::Mat;
use vademecum_format::scheme::SchemeTable;

use super::damping::{ModalRatios, Rayleigh, numerical_damping};

/// A mode as engineers ask for it.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct ModeRow {
    /// √(Rayleigh quotient)/2π \[Hz\].
    pub frequency_hz: f64,
    /// φᵀKφ ÷ φᵀMφ \[rad²/s²\].
    pub rayleigh_quotient: f64,
    /// Fraction of the snapshot energy; NaN for natural modes without snapshots.
    pub energy: f64,
    /// Damping ratio the material gives it.
    pub physical_damping: f64,
    /// Damping ratio the scheme adds at this step.
    pub numerical_damping: f64,
    /// Relative lengthening of its period by the scheme.
    pub period_elongation: f64,
}

/// One row per mode from its Rayleigh quotient φᵀKφ ÷ φᵀMφ \[rad²/s²\] and its share of the snapshot energy
/// (NaN where `energy` is shorter: natural modes without snapshots), at the step `dt` \[s\]; `ratios` are in
/// addition to Rayleigh's damping.
pub fn mode_table(
    quotients: &[f64],
    energy: &[f64],
    scheme: &SchemeTable,
    (rayleigh, ratios): (&Rayleigh, &ModalRatios),
    dt: f64,
) -> Vec<ModeRow> {
    let row = |(k, &quotient): (usize, &f64)| {
        let frequency_hz = quotient.sqrt() / std::f64::consts::TAU;
        let physical_damping = rayleigh.ratio(frequency_hz) + ratios.of(k);
        let numerical = numerical_damping(scheme, quotient.sqrt() * dt, physical_damping);
        ModeRow {
            frequency_hz,
            rayleigh_quotient: quotient,
            energy: energy.get(k).copied().unwrap_or(f64::NAN),
            physical_damping,
            numerical_damping: numerical.ratio.map_or(f64::NAN, |ratio| ratio - physical_damping),
            period_elongation: numerical.period_elongation.unwrap_or(f64::NAN),
        }
    };
    quotients.iter().enumerate().map(row).collect()
}

/// The table as the file keeps it, shape (r, 6).
pub fn table_matrix(rows: &[ModeRow]) -> Mat<f64> {
    Mat::from_fn(rows.len(), 6, |i, j| {
        let row = &rows[i];
        [
            row.frequency_hz,
            row.rayleigh_quotient,
            row.energy,
            row.physical_damping,
            row.numerical_damping,
            row.period_elongation,
        ][j]
    })
}
