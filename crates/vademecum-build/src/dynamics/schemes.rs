//! Time schemes, each written once as the table that full-order solver, reduced solver and vademecum read.
//!
//! Every scheme here is collocation: velocity and acceleration at an instant are linear forms in the old
//! state and the displacements found so far, and one stage asks for equilibrium at that instant,
//!
//! ```text
//! M (Δt² ü) + Δt C (Δt u̇) + Δt² K u = Δt² F
//! ```
//!
//! so a scheme is its few forms, and the table follows by sorting the unknown to the left. The one odd thing:
//! the forms of a later stage contain those of an earlier one, which is how Bathe's `28 u½ − 19 u − 5 Δt u̇`
//! comes about.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use vademecum_format::scheme::{HISTORY, MAX_STAGES, SchemeTable, Stage};

/// A linear form in the history `(u, Δt u̇, Δt² ü, u_1, u_2, u_3)`.
type Form = [f64; HISTORY];

/// Places in a history.
const U: usize = 0;
const V: usize = 1;
const A: usize = 2;
const STAGE: usize = 3;

/// A time scheme by name, as the problem file has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    tag = "name",
    rename_all = "kebab-case",
    deny_unknown_fields,
    expecting = "a table with the scheme's name, such as { name = \"bathe\" }"
)]
pub enum SchemeKind {
    /// No scheme: each mode is moved exactly, for loads that are linear over a step.
    Exact {},
    /// Trapezoidal rule to the half step, three-point backward difference to the end (Bathe and Baig 2005).
    // With braces: serde lets a unit variant take any key.
    Bathe {},
    /// Two sub-steps with prescribed damping of the highest modes (Noh and Bathe 2019).
    RhoBathe {
        /// Spectral radius at infinite frequency, 0 to 1.
        rho_infinity: f64,
    },
    /// Newmark (1959); `β = ¼, γ = ½` is the trapezoidal rule.
    Newmark {
        /// `β`, at least `γ/2`.
        beta: f64,
        /// `γ`, at least ½.
        gamma: f64,
    },
    /// Hilber, Hughes and Taylor (1977).
    HhtAlpha {
        /// `α` in [−⅓, 0].
        alpha: f64,
    },
    /// Chung and Hulbert (1993).
    GeneralizedAlpha {
        /// Spectral radius at infinite frequency, 0 to 1.
        rho_infinity: f64,
    },
}

impl Default for SchemeKind {
    fn default() -> Self {
        Self::Bathe {}
    }
}

impl std::fmt::Display for SchemeKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Exact {} => write!(f, "exact"),
            Self::Bathe {} => write!(f, "bathe"),
            Self::RhoBathe { rho_infinity } => write!(f, "rho-bathe rho_infinity={rho_infinity}"),
            Self::Newmark { beta, gamma } => write!(f, "newmark beta={beta} gamma={gamma}"),
            Self::HhtAlpha { alpha } => write!(f, "hht-alpha alpha={alpha}"),
            Self::GeneralizedAlpha { rho_infinity } => {
                write!(f, "generalized-alpha rho_infinity={rho_infinity}")
            }
        }
    }
}

/// A scheme parameter outside its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SchemeError {
    /// `ρ∞` outside [0, 1].
    #[error("rho_infinity = {0} lies outside [0, 1]")]
    RhoInfinity(f64),
    /// `α` outside [−⅓, 0].
    #[error("alpha = {0} lies outside [-1/3, 0]")]
    Alpha(f64),
    /// Newmark constants without unconditional stability.
    #[error(
        "Newmark is unconditionally stable for 2 beta >= gamma >= 1/2 only; found beta = {beta}, gamma = {gamma}"
    )]
    Newmark {
        /// `β`.
        beta: f64,
        /// `γ`.
        gamma: f64,
    },
}

impl SchemeKind {
    /// The table of the scheme; [`SchemeTable::EXACT`] for none.
    ///
    /// # Errors
    /// [`SchemeError`] for a parameter outside its range.
    pub fn table(&self) -> Result<SchemeTable, SchemeError> {
        match *self {
            SchemeKind::Exact {} => Ok(SchemeTable::EXACT),
            SchemeKind::Bathe {} => Ok(bathe()),
            SchemeKind::RhoBathe { rho_infinity } => rho_bathe(rho_infinity),
            SchemeKind::Newmark { beta, gamma } => newmark(beta, gamma),
            SchemeKind::HhtAlpha { alpha } => hht_alpha(alpha),
            SchemeKind::GeneralizedAlpha { rho_infinity } => generalized_alpha(rho_infinity),
        }
    }
}

/// Bathe's method (docs/explanation/3-schemes.md; chapter eqs. 5.5 and 5.6 with damping).
///
/// ```text
/// u̇½ = 4/Δt (u½ − u) − u̇,         ü½ = 4/Δt (u̇½ − u̇) − ü
/// u̇¹ = (u − 4u½ + 3u¹)/Δt,        ü¹ = (u̇ − 4u̇½ + 3u̇¹)/Δt
/// ```
pub fn bathe() -> SchemeTable {
    let (half_v, half_a) = trapezoidal(0.5);
    let end_v = sum(&[(1.0, unit(U)), (-4.0, unit(STAGE)), (3.0, unit(STAGE + 1))]);
    let end_a = sum(&[(1.0, unit(V)), (-4.0, half_v), (3.0, end_v)]);
    two_stages(0.5, [half_v, half_a], [end_v, end_a])
}

/// The ρ∞-Bathe method with its default splitting ratio `γ₀` (Noh and Bathe 2019, eqs. 12–15):
///
/// ```text
/// u¹ = u + Δt (q₀ u̇ + q₁ u̇_γ + q₂ u̇¹),   u̇¹ = u̇ + Δt (q₀ ü + q₁ ü_γ + q₂ ü¹)
/// ```
///
/// # Errors
/// [`SchemeError::RhoInfinity`].
pub(crate) fn rho_bathe(rho_infinity: f64) -> Result<SchemeTable, SchemeError> {
    let rho = checked_rho(rho_infinity)?;
    // γ₀ = (2 − √(2(1+ρ)))/(1 − ρ) with numerator and denominator multiplied by 2 + √(2(1+ρ)): no 0/0 at
    // ρ = 1.
    let gamma = 2.0 / (2.0 + (2.0 * (1.0 + rho)).sqrt());
    let q1 = (rho + 1.0) / (2.0 * gamma * (rho - 1.0) + 4.0);
    let q0 = (gamma - 1.0) * q1 + 0.5;
    let q2 = -gamma * q1 + 0.5;
    let (mid_v, mid_a) = trapezoidal(gamma);
    let end_v =
        sum(&[(1.0 / q2, unit(STAGE + 1)), (-1.0 / q2, unit(U)), (-q0 / q2, unit(V)), (-q1 / q2, mid_v)]);
    let end_a = sum(&[(1.0 / q2, end_v), (-1.0 / q2, unit(V)), (-q0 / q2, unit(A)), (-q1 / q2, mid_a)]);
    Ok(two_stages(gamma, [mid_v, mid_a], [end_v, end_a]))
}

/// Newmark's method; `newmark(0.25, 0.5)` is the trapezoidal rule.
///
/// # Errors
/// [`SchemeError::Newmark`] unless `2β ≥ γ ≥ ½`.
pub(crate) fn newmark(beta: f64, gamma: f64) -> Result<SchemeTable, SchemeError> {
    // Written so that a NaN is refused too.
    if !(2.0 * beta >= gamma && gamma >= 0.5 && beta.is_finite()) {
        return Err(SchemeError::Newmark { beta, gamma });
    }
    Ok(alpha_family(0.0, 0.0, beta, gamma))
}

/// The HHT-α method: `β = (1 − α)²/4`, `γ = ½ − α`, forces between the step's ends weighted by `1 + α` and
/// `−α`.
///
/// # Errors
/// [`SchemeError::Alpha`].
pub(crate) fn hht_alpha(alpha: f64) -> Result<SchemeTable, SchemeError> {
    if !(-1.0 / 3.0..=0.0).contains(&alpha) {
        return Err(SchemeError::Alpha(alpha));
    }
    Ok(alpha_family(0.0, -alpha, 0.25 * (1.0 - alpha).powi(2), 0.5 - alpha))
}

/// The generalized-α method with the least low-frequency damping for its `ρ∞` (Chung and Hulbert 1993,
/// eq. 25).
///
/// # Errors
/// [`SchemeError::RhoInfinity`].
pub fn generalized_alpha(rho_infinity: f64) -> Result<SchemeTable, SchemeError> {
    let rho = checked_rho(rho_infinity)?;
    let (alpha_m, alpha_f) = ((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0));
    let gamma = 0.5 - alpha_m + alpha_f;
    let beta = 0.25 * (1.0 - alpha_m + alpha_f).powi(2);
    Ok(alpha_family(alpha_m, alpha_f, beta, gamma))
}

fn checked_rho(rho: f64) -> Result<f64, SchemeError> {
    if (0.0..=1.0).contains(&rho) { Ok(rho) } else { Err(SchemeError::RhoInfinity(rho)) }
}

/// Newmark's forms with equilibrium of weighted ends:
/// `M ((1−αm) ü¹ + αm ü) + C ((1−αf) u̇¹ + αf u̇) + K ((1−αf) u¹ + αf u) = (1−αf) F¹ + αf F`.
fn alpha_family(alpha_m: f64, alpha_f: f64, beta: f64, gamma: f64) -> SchemeTable {
    // u¹ = u + Δt u̇ + Δt² ((½ − β) ü + β ü¹),  u̇¹ = u̇ + Δt ((1 − γ) ü + γ ü¹).
    let end_a = sum(&[
        (1.0 / beta, unit(STAGE)),
        (-1.0 / beta, unit(U)),
        (-1.0 / beta, unit(V)),
        (1.0 - 0.5 / beta, unit(A)),
    ]);
    let end_v = sum(&[(1.0, unit(V)), (1.0 - gamma, unit(A)), (gamma, end_a)]);
    let mut load = [0.0; 1 + MAX_STAGES];
    (load[0], load[1]) = (alpha_f, 1.0 - alpha_f);
    let stage = equilibrium(
        0,
        1.0,
        load,
        sum(&[(1.0 - alpha_m, end_a), (alpha_m, unit(A))]),
        sum(&[(1.0 - alpha_f, end_v), (alpha_f, unit(V))]),
        sum(&[(1.0 - alpha_f, unit(STAGE)), (alpha_f, unit(U))]),
    );
    let mut stages = [Stage::default(); MAX_STAGES];
    stages[0] = stage;
    SchemeTable { n_stages: 1, stages, finish: [unit(STAGE), end_v, end_a] }
}

/// Velocity and acceleration after a trapezoidal step of length `γ Δt` to the first stage.
fn trapezoidal(gamma: f64) -> (Form, Form) {
    let v = sum(&[(2.0 / gamma, unit(STAGE)), (-2.0 / gamma, unit(U)), (-1.0, unit(V))]);
    let a = sum(&[(2.0 / gamma, v), (-2.0 / gamma, unit(V)), (-1.0, unit(A))]);
    (v, a)
}

/// A first stage at `γ Δt` and a second at the end, each in equilibrium; forms are (velocity, acceleration).
fn two_stages(gamma: f64, mid: [Form; 2], end: [Form; 2]) -> SchemeTable {
    let load = |stage: usize| std::array::from_fn(|j| if j == stage + 1 { 1.0 } else { 0.0 });
    let mut stages = [Stage::default(); MAX_STAGES];
    stages[0] = equilibrium(0, gamma, load(0), mid[1], mid[0], unit(STAGE));
    stages[1] = equilibrium(1, 1.0, load(1), end[1], end[0], unit(STAGE + 1));
    SchemeTable { n_stages: 2, stages, finish: [unit(STAGE + 1), end[0], end[1]] }
}

/// The stage that solves `M a + Δt C v + Δt² K u = Δt² Σ load_j F_j` for its own displacement.
fn equilibrium(stage: usize, time: f64, load: [f64; 1 + MAX_STAGES], a: Form, v: Form, u: Form) -> Stage {
    let split = |form: Form| {
        let mut history = form.map(|x| 0.0 - x);
        history[STAGE + stage] = 0.0;
        (form[STAGE + stage], history)
    };
    let ((mass, mass_history), (damping, damping_history)) = (split(a), split(v));
    let (stiffness, stiffness_history) = split(u);
    Stage { mass, damping, stiffness, time, load, mass_history, damping_history, stiffness_history }
}

/// The form that reads one entry of the history.
fn unit(place: usize) -> Form {
    std::array::from_fn(|i| if i == place { 1.0 } else { 0.0 })
}

/// A weighted sum of forms.
fn sum(parts: &[(f64, Form)]) -> Form {
    let mut total = [0.0; HISTORY];
    for (weight, form) in parts {
        for i in 0..HISTORY {
            total[i] += weight * form[i];
        }
    }
    total
}

/// The largest departure of a table from what a rigid translation demands, relative to its coefficients:
/// histories of mass and damping that sum (over `u` and the stages) to the weight of the unknown, a load of
/// total weight 1 that the stiffness balances, and a finish that keeps `u` and invents neither velocity nor
/// acceleration.
pub(crate) fn inconsistency(table: &SchemeTable) -> f64 {
    let still = |form: &Form| form[U] + form[STAGE..].iter().sum::<f64>();
    let size = |form: &Form| form.iter().map(|x| x.abs()).fold(1.0, f64::max);
    let mut worst = 0.0_f64;
    let finite = |form: &Form| form.iter().all(|x| x.is_finite());
    if !table.finish.iter().all(finite) {
        return f64::INFINITY; // `max` would lose a NaN
    }
    for stage in &table.stages[..table.n_stages as usize] {
        let histories = [stage.mass_history, stage.damping_history, stage.stiffness_history];
        let weights = [stage.mass, stage.damping, stage.stiffness];
        if !(histories.iter().all(finite) && weights.iter().chain(&stage.load).all(|x| x.is_finite())) {
            return f64::INFINITY;
        }
        let off = [
            (still(&stage.mass_history) - stage.mass) / size(&stage.mass_history),
            (still(&stage.damping_history) - stage.damping) / size(&stage.damping_history),
            still(&stage.stiffness_history) - stage.stiffness + 1.0,
            stage.load.iter().sum::<f64>() - 1.0,
        ];
        worst = off.iter().fold(worst, |w, x| w.max(x.abs()));
    }
    for (row, expected) in table.finish.iter().zip([1.0, 0.0, 0.0]) {
        worst = worst.max(((still(row) - expected) / size(row)).abs());
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<SchemeTable> {
        let mut tables = vec![bathe(), newmark(0.25, 0.5).unwrap(), newmark(0.4, 0.6).unwrap()];
        for rho in [0.0, 0.3, 0.8, 1.0] {
            tables.extend([rho_bathe(rho).unwrap(), generalized_alpha(rho).unwrap()]);
        }
        tables.extend([hht_alpha(0.0).unwrap(), hht_alpha(-0.1).unwrap(), hht_alpha(-1.0 / 3.0).unwrap()]);
        tables
    }

    #[test]
    fn bathe_is_the_printed_table() {
        let table = bathe();
        let [first, second] = [table.stages[0], table.stages[1]];
        assert_eq!((first.mass, first.damping, first.stiffness, first.time), (16.0, 4.0, 1.0, 0.5));
        assert_eq!(first.mass_history, [16.0, 8.0, 1.0, 0.0, 0.0, 0.0]);
        assert_eq!(first.damping_history, [4.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!((second.mass, second.damping, second.stiffness, second.time), (9.0, 3.0, 1.0, 1.0));
        assert_eq!(second.mass_history, [-19.0, -5.0, 0.0, 28.0, 0.0, 0.0]);
        assert_eq!(second.damping_history, [-1.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
        assert_eq!(table.finish[1], [1.0, 0.0, 0.0, -4.0, 3.0, 0.0]);
    }

    #[test]
    fn every_table_is_consistent_to_rounding() {
        for table in all() {
            // A handful of sums of six terms relative to the largest.
            assert!(inconsistency(&table) < 20.0 * f64::EPSILON, "{table:?}");
        }
    }

    #[test]
    fn stage_histories_only_look_back() {
        for table in all() {
            for (i, stage) in table.stages[..table.n_stages as usize].iter().enumerate() {
                for history in [stage.mass_history, stage.damping_history, stage.stiffness_history] {
                    assert!(history[STAGE + i..].iter().all(|&x| x == 0.0));
                }
                assert!(stage.load[i + 2..].iter().all(|&x| x == 0.0));
            }
        }
    }

    #[test]
    fn limits_agree_with_each_other() {
        // HHT with α = 0 is the trapezoidal rule; ρ∞-Bathe at ρ∞ = 1 splits the step in halves.
        assert_eq!(hht_alpha(0.0).unwrap(), newmark(0.25, 0.5).unwrap());
        assert_eq!(rho_bathe(1.0).unwrap().stages[0].time, 0.5);
        let gamma = rho_bathe(0.0).unwrap().stages[0].time;
        assert!((gamma - (2.0 - 2.0_f64.sqrt())).abs() < 2.0 * f64::EPSILON);
    }

    #[test]
    fn parameters_outside_their_range_are_refused() {
        assert_eq!(rho_bathe(1.1), Err(SchemeError::RhoInfinity(1.1)));
        assert_eq!(hht_alpha(-0.5), Err(SchemeError::Alpha(-0.5)));
        assert_eq!(newmark(1.0 / 6.0, 0.5), Err(SchemeError::Newmark { beta: 1.0 / 6.0, gamma: 0.5 }));
        assert!(generalized_alpha(f64::NAN).is_err());
    }
}
