//! Damping: what the material gives to each mode, and what the time scheme adds of its own.
//!
//! Rayleigh damping `C = α M + β K` gives a mode of circular frequency `ω` the ratio `ζ = α/(2ω) + βω/2`.
//! Numerical damping is computed from the eigenvalues of its step on one oscillator, the 3 × 3 matrix that
//! maps `(u, Δt u̇, Δt² ü)` from one step to the next: a pair `ρ e^{±iφ}` moves like an oscillator of
//! frequency `φ/Δt` and ratio `−ln ρ / |ln ρ + iφ|`.

use faer::Mat;
use serde::{Deserialize, Serialize};
use vademecum_format::scheme::{HISTORY, SchemeTable};

use crate::linalg::eigenvalues;

/// Coefficients of `C = α M + β K`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rayleigh {
    /// Weight of the mass, 1/s.
    pub alpha: f64,
    /// Weight of the stiffness, s.
    pub beta: f64,
}

/// Damping as a problem may state it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Damping {
    /// None.
    #[default]
    None,
    /// `α` and `β`.
    Rayleigh(Rayleigh),
    /// The ratio at two frequencies, `(ζ, f in Hz)` each.
    Ratios([(f64, f64); 2]),
}

/// Damping data that describe no damping.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DampingError {
    /// A coefficient is negative or not finite.
    #[error("Rayleigh damping needs alpha >= 0 and beta >= 0; found alpha = {}, beta = {}", .0.alpha, .0.beta)]
    Negative(Rayleigh),
    /// Frequencies are not two different positive numbers, or a ratio is negative.
    #[error("two (ratio, frequency) pairs need ratios >= 0 and two different frequencies > 0; found {0:?}")]
    Pairs([(f64, f64); 2]),
    /// The two ratios ask for a negative coefficient: the ratio would be negative at other frequencies.
    #[error(
        "these pairs give alpha = {}, beta = {}: one is negative, so modes at some frequency would gain energy; \
         bring the two ratios closer together", .0.alpha, .0.beta
    )]
    GainsEnergy(Rayleigh),
}

impl Damping {
    /// The Rayleigh coefficients.
    ///
    /// # Errors
    /// [`DampingError`] for coefficients or ratios that are negative, not finite, or would feed energy to
    /// some mode.
    pub(crate) fn rayleigh(&self) -> Result<Rayleigh, DampingError> {
        match *self {
            Damping::None => Ok(Rayleigh::default()),
            Damping::Rayleigh(r) if r.is_sound() => Ok(r),
            Damping::Rayleigh(r) => Err(DampingError::Negative(r)),
            Damping::Ratios(pairs) => rayleigh_of_ratios(pairs),
        }
    }
}

/// Solves `α/(2ω) + βω/2 = ζ` at both frequencies.
fn rayleigh_of_ratios(pairs: [(f64, f64); 2]) -> Result<Rayleigh, DampingError> {
    let [(z1, f1), (z2, f2)] = pairs;
    let sound = |x: f64, least: f64| x.is_finite() && x >= least;
    if !(sound(z1, 0.0) && sound(z2, 0.0) && sound(f1, f64::MIN_POSITIVE) && sound(f2, f64::MIN_POSITIVE))
        || f1 == f2
    {
        return Err(DampingError::Pairs(pairs));
    }
    let [w1, w2] = [f1, f2].map(|f| std::f64::consts::TAU * f);
    // Differences of squares as products: nothing cancels when the frequencies are close.
    let scale = 2.0 / ((w2 - w1) * (w2 + w1));
    let rayleigh =
        Rayleigh { alpha: scale * w1 * w2 * (z1 * w2 - z2 * w1), beta: scale * (z2 * w2 - z1 * w1) };
    if rayleigh.is_sound() { Ok(rayleigh) } else { Err(DampingError::GainsEnergy(rayleigh)) }
}

impl Rayleigh {
    /// True if no mode gains energy: both coefficients finite and not negative.
    pub(crate) fn is_sound(&self) -> bool {
        [self.alpha, self.beta].iter().all(|x| *x >= 0.0 && x.is_finite())
    }

    /// Damping ratio a mode of frequency `f`, Hz, receives.
    pub fn ratio(&self, frequency: f64) -> f64 {
        let omega = std::f64::consts::TAU * frequency;
        0.5 * (self.alpha / omega + self.beta * omega)
    }
}

/// Damping ratios of the natural modes in addition to Rayleigh's, in ascending order of the modes; the last
/// one holds for all further modes. None of them: none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModalRatios(pub Vec<f64>);

impl ModalRatios {
    /// True if there is no modal damping.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Ratio of a mode.
    pub fn of(&self, mode: usize) -> f64 {
        self.0.get(mode).or(self.0.last()).copied().unwrap_or(0.0)
    }

    /// Decay \[1/s\] of any mode of a body by its stiffness `λ` \[rad²/s²\], where `eigenvalues` are those of
    /// the lowest natural modes, ascending: Rayleigh's and `ζ√λ`, with the ratio of the natural mode that is
    /// nearest. A mode a thousandth beyond the last of them has the ratio of the next one.
    ///
    /// A reference finds only the modes that its loads excite, so the place of one among those it found says
    /// nothing.
    pub fn decay(&self, rayleigh: &Rayleigh, eigenvalues: &[f64], lambda: f64) -> f64 {
        const BEYOND: f64 = 1e-3;
        let above = eigenvalues.partition_point(|&value| value < lambda);
        let mode = match (above.checked_sub(1).map(|k| eigenvalues[k]), eigenvalues.get(above)) {
            (Some(below), Some(&value)) if lambda - below < value - lambda => above - 1,
            (Some(below), None) if lambda <= below * (1.0 + BEYOND) => above - 1,
            _ => above,
        };
        0.5 * (rayleigh.alpha + rayleigh.beta * lambda) + self.of(mode) * lambda.sqrt()
    }
}

/// Numerical damping and period elongation of one oscillator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumericalDamping {
    /// Largest modulus of the step's three eigenvalues.
    pub spectral_radius: f64,
    /// Damping ratio of the computed motion (that of the oscillator itself included); `None` once it no
    /// longer oscillates.
    pub ratio: Option<f64>,
    /// Computed period over the true one, less 1; `None` once it no longer oscillates.
    pub period_elongation: Option<f64>,
}

/// Damping ratio and period elongation of a scheme on `ü + 2ζω u̇ + ω² u = 0` at `Ω = ωΔt`.
///
/// The elongation is measured against the damped period `2π/(ω√(1−ζ²))`. An `Ω` so large or small that the
/// step has no finite entries has no radius (NaN) and no motion.
pub fn numerical_damping(table: &SchemeTable, omega_dt: f64, ratio: f64) -> NumericalDamping {
    if table.is_exact() {
        return exact(omega_dt, ratio);
    }
    let step = step_matrix(table, omega_dt, ratio);
    let matrix = Mat::from_fn(3, 3, |i, j| step[i][j]);
    let none = NumericalDamping { spectral_radius: f64::NAN, ratio: None, period_elongation: None };
    if !step.iter().flatten().all(|entry| entry.is_finite()) {
        return none;
    }
    let Ok(values) = eigenvalues(matrix.as_ref()) else { return none };
    let spectral_radius = values.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let pair = values.iter().filter(|z| z.im > 0.0).max_by(|a, b| a.norm().total_cmp(&b.norm()));
    let Some(pair) = pair else {
        return NumericalDamping { spectral_radius, ratio: None, period_elongation: None };
    };
    let (decay, angle) = (-pair.norm().ln(), pair.arg());
    NumericalDamping {
        spectral_radius,
        ratio: Some(decay / decay.hypot(angle)),
        period_elongation: Some(omega_dt * (1.0 - ratio * ratio).sqrt() / angle - 1.0),
    }
}

/// Of an exact step: what the oscillator has itself.
fn exact(omega_dt: f64, ratio: f64) -> NumericalDamping {
    let swings = ratio < 1.0;
    // Beyond critical damping the slower of two decays is what is left.
    let decay = if swings { ratio } else { 1.0 / (ratio + (ratio * ratio - 1.0).sqrt()) };
    NumericalDamping {
        spectral_radius: (-decay * omega_dt).exp(),
        ratio: swings.then_some(ratio),
        period_elongation: swings.then_some(0.0),
    }
}

/// The step of a scheme on one unloaded oscillator, `y ← T y` with `y = (u, Δt u̇, Δt² ü)`; `omega_dt = ωΔt`,
/// `ratio = ζ`.
pub(crate) fn step_matrix(table: &SchemeTable, omega_dt: f64, ratio: f64) -> [[f64; 3]; 3] {
    let (damping, stiffness) = (2.0 * ratio * omega_dt, omega_dt * omega_dt);
    // Row p of the history: what entry p of (u, Δt u̇, Δt² ü, u_1, …) is of the old state.
    let mut history = [[0.0; 3]; HISTORY];
    for p in 0..3 {
        history[p][p] = 1.0;
    }
    for (i, stage) in table.stages[..table.n_stages as usize].iter().enumerate() {
        let weight = stage.mass + stage.damping * damping + stage.stiffness * stiffness;
        let mut row = [0.0; 3];
        for p in 0..3 + i {
            let coefficient = stage.mass_history[p]
                + damping * stage.damping_history[p]
                + stiffness * stage.stiffness_history[p];
            for k in 0..3 {
                row[k] += coefficient * history[p][k];
            }
        }
        history[3 + i] = row.map(|x| x / weight);
    }
    table.finish.map(|form| std::array::from_fn(|k| (0..HISTORY).map(|p| form[p] * history[p][k]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_has_the_ratio_of_the_nearest_natural_mode_whatever_its_place() {
        let ratios = ModalRatios(vec![0.1, 0.2, 0.4]);
        let decay = |lambda: f64| ratios.decay(&Rayleigh::default(), &[1.0, 4.0], lambda) / lambda.sqrt();
        for (lambda, ratio) in [(0.9, 0.1), (1.0, 0.1), (2.4, 0.1), (2.6, 0.2), (4.0, 0.2), (4.001, 0.2)] {
            assert!((decay(lambda) - ratio).abs() < 1e-15, "{lambda}");
        }
        for lambda in [4.1, 9.0, 1e9] {
            assert!((decay(lambda) - 0.4).abs() < 1e-15, "{lambda}");
        }
        let rayleigh = Rayleigh { alpha: 0.3, beta: 0.02 };
        assert_eq!(ModalRatios::default().decay(&rayleigh, &[], 9.0), rayleigh.decay(9.0));
        let all = ModalRatios(vec![0.05]);
        assert_eq!(all.decay(&Rayleigh::default(), &[1.0], 16.0), 0.05 * 4.0);
        assert_eq!([all.of(0), all.of(7)], [0.05, 0.05]);
    }
}
