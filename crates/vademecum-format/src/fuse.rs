//! The stages of a scheme fused into one increment map.
//!
//! With `K → s_K K`, `M → s_ρ M` and `C = αM + βK`, stage `i` has the matrix `m̃ (M + θ_i K)` with
//! `m̃ = s_ρ (m + d Δt α)`, `k̃ = s_K (k Δt² + d Δt β)` and `θ_i = k̃ / m̃`. Everything the reduced step needs of it is
//! `C(θ_i) = BᵀM (M + θ_i K)⁻¹ M B = I + E_i`, because `Π A⁻¹M B = (I + E_i)/m̃` and `Π A⁻¹K B = −E_i/k̃`.
//!
//! Written for the increments `x_i = ζ_i − ζ`, with `a_j = s_ρ (h^M_j + Δt α h^C_j)` and
//! `b_j = s_K (Δt² h^K_j + Δt β h^C_j)`, and `y = (ζ, Δt ζ̇, Δt² ζ̈)`:
//!
//! ```text
//! x_i = c_i E_i y_0 + Σ_{j=1,2} [(a_j/m̃)(I + E_i) − (b_j/k̃) E_i] y_j
//!                   + Σ_{l<i}   [(a_l/m̃)(I + E_i) − (b_l/k̃) E_i] x_l + (Δt²/m̃) p_i g_i
//! ```
//!
//! `c_i = s_K Δt²/k̃` (from `k − Σh^K = 1`). A consistent table has `Σ a_j = m̃` over the displacements, so `y_0` enters through
//! `E_i` alone: the large identity parts cancel on paper, not in the arithmetic. The odd thing: that makes
//! consistency a condition, and [`SchemeTable::check`] refuses a table without it.

use crate::scheme::{HISTORY, MAX_STAGES, SchemeTable, Stage};
use core::fmt;

/// Sums that a table owes exactly may miss by this much, relative to the terms added: a table is computed in `f64` from
/// a few scheme constants, so its sums carry a few roundings (2⁻⁵²) times the size of the terms; 2⁻⁴⁰ leaves 4 000 of them.
const CONSISTENCY: f64 = 1.0 / (1u64 << 40) as f64;

/// The parameters a fused step depends on beside the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepParameters {
    /// Time step `Δt` \[s\], positive.
    pub time_step: f64,
    /// Rayleigh `α` \[1/s\]: `C = αM + βK`.
    pub alpha: f64,
    /// Rayleigh `β` \[s\].
    pub beta: f64,
    /// `s_ρ`: scale of the mass matrix, 1 is the file's.
    pub density: f64,
    /// `s_K`: scale of the stiffness matrix, 1 is the file's.
    pub stiffness: f64,
}

/// Why a table or a fused step was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SchemeError {
    /// The number of stages is not 1 to [`MAX_STAGES`].
    StageCount {
        /// What the table says.
        found: u8,
    },
    /// A coefficient of this stage (or of `finish`, for the number of stages) is not finite.
    NotFinite {
        /// The stage.
        stage: usize,
    },
    /// `m` or `k` of this stage is not positive, or its history uses a stage not solved yet.
    BadStage {
        /// The stage.
        stage: usize,
    },
    /// A sum that a consistent scheme owes is missed: constant displacement must be no motion, `k − Σh^K = Σf = 1`.
    Inconsistent {
        /// The stage, or the number of stages for `finish`.
        stage: usize,
        /// What the sum misses by.
        by: f64,
    },
    /// A step parameter is not finite or not in its range, or makes `m̃` or `k̃` of a stage not positive.
    BadParameter {
        /// The parameter's place in [`StepParameters`] (0 to 4), or 5 + the stage.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A lent or given slice has the wrong length.
    Length {
        /// Length found.
        found: usize,
        /// Length needed.
        needed: usize,
    },
}

impl fmt::Display for SchemeError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::StageCount { found } => write!(
                out,
                "a scheme of {found} stages; 1 to {MAX_STAGES} are possible"
            ),
            Self::NotFinite { stage } => write!(
                out,
                "stage {stage} of the scheme holds a number that is not finite"
            ),
            Self::BadStage { stage } => write!(
                out,
                "stage {stage} of the scheme needs positive m and k and may use earlier stages only"
            ),
            Self::Inconsistent { stage, by } => write!(
                out,
                "stage {stage} of the scheme misses a consistency sum by {by:e}: constant displacement must stay constant"
            ),
            Self::BadParameter { index, value } => {
                let names = [
                    "time step",
                    "alpha",
                    "beta",
                    "density scale",
                    "stiffness scale",
                ];
                match names.get(index) {
                    Some(name) => {
                        write!(out, "{name} = {value:e} is not finite or not in its range")
                    }
                    None => write!(
                        out,
                        "the parameters make a matrix weight of stage {} {value:e}",
                        index - 5
                    ),
                }
            }
            Self::Length { found, needed } => write!(
                out,
                "a slice of {found} numbers was lent where {needed} are needed"
            ),
        }
    }
}

impl core::error::Error for SchemeError {}

impl StepParameters {
    /// Checks the ranges: `Δt, s_ρ, s_K > 0`, `α, β ≥ 0`, all finite.
    ///
    /// # Errors
    /// [`SchemeError::BadParameter`].
    pub fn check(&self) -> Result<(), SchemeError> {
        let values = [
            self.time_step,
            self.alpha,
            self.beta,
            self.density,
            self.stiffness,
        ];
        for (index, &value) in values.iter().enumerate() {
            let may_vanish = index == 1 || index == 2;
            if !value.is_finite() || value < 0.0 || (value == 0.0 && !may_vanish) {
                return Err(SchemeError::BadParameter { index, value });
            }
        }
        Ok(())
    }
}

impl SchemeTable {
    /// The stages in use.
    #[must_use]
    pub fn active(&self) -> &[Stage] {
        self.stages
            .get(..usize::from(self.n_stages))
            .unwrap_or(&self.stages)
    }

    /// Instants at which a step needs the load, as fractions of it: 0, then `c_i` of each stage; the rest is zero.
    #[must_use]
    pub fn instants(&self) -> [f64; 1 + MAX_STAGES] {
        let mut instants = [0.0; 1 + MAX_STAGES];
        for (instant, stage) in instants.iter_mut().skip(1).zip(self.active()) {
            *instant = stage.time;
        }
        instants
    }

    /// Checks that the table is finite and consistent: `Σh^M = m`, `Σh^C = d`, `k − Σh^K = 1` over the displacement
    /// columns, `Σf = 1`, and `finish` rows summing to 1, 0, 0 over them.
    ///
    /// # Errors
    /// [`SchemeError`] naming the stage.
    pub fn check(&self) -> Result<(), SchemeError> {
        if self.n_stages == 0 || usize::from(self.n_stages) > MAX_STAGES {
            return Err(SchemeError::StageCount {
                found: self.n_stages,
            });
        }
        for (index, stage) in self.active().iter().enumerate() {
            check_stage(stage, index)?;
        }
        let n_stages = usize::from(self.n_stages);
        for (row, owed) in self.finish.iter().zip([1.0, 0.0, 0.0]) {
            if row.iter().any(|f| !f.is_finite()) {
                return Err(SchemeError::NotFinite { stage: n_stages });
            }
            owes(row, n_stages, owed, n_stages)?;
        }
        Ok(())
    }
}

fn check_stage(stage: &Stage, index: usize) -> Result<(), SchemeError> {
    let histories = [
        &stage.mass_history,
        &stage.damping_history,
        &stage.stiffness_history,
    ];
    let scalars = [stage.mass, stage.damping, stage.stiffness, stage.time];
    let mut all = histories
        .iter()
        .flat_map(|h| h.iter())
        .chain(&scalars)
        .chain(&stage.load);
    if all.any(|value| !value.is_finite()) {
        return Err(SchemeError::NotFinite { stage: index });
    }
    let looks_ahead = histories
        .iter()
        .any(|h| h.iter().skip(3 + index).any(|&c| c != 0.0));
    if stage.mass <= 0.0 || stage.stiffness <= 0.0 || looks_ahead {
        return Err(SchemeError::BadStage { stage: index });
    }
    owes(&stage.mass_history, index, stage.mass, index)?;
    owes(&stage.damping_history, index, stage.damping, index)?;
    owes(
        &stage.stiffness_history,
        index,
        stage.stiffness - 1.0,
        index,
    )?;
    let by = stage.load.iter().sum::<f64>() - 1.0;
    let size = 1.0 + stage.load.iter().map(|f| f.abs()).sum::<f64>();
    if by.abs() > CONSISTENCY * size {
        return Err(SchemeError::Inconsistent { stage: index, by });
    }
    Ok(())
}

/// The displacement columns of `row` (the old one and `earlier` stages) must sum to `owed`.
fn owes(row: &[f64; HISTORY], earlier: usize, owed: f64, stage: usize) -> Result<(), SchemeError> {
    let columns = || row.iter().take(1).chain(row.iter().skip(3).take(earlier));
    let by = columns().sum::<f64>() - owed;
    let size = 1.0 + owed.abs() + columns().map(|c| c.abs()).sum::<f64>();
    if by.abs() > CONSISTENCY * size {
        return Err(SchemeError::Inconsistent { stage, by });
    }
    Ok(())
}

/// What one stage becomes at given parameters; see the module's equation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageCoefficients {
    /// `θ = k̃/m̃` \[s²\].
    pub theta: f64,
    /// `m̃`: weight of `M` in the stage's matrix.
    pub mass: f64,
    /// `k̃`: weight of `K` in the stage's matrix \[s²\].
    pub stiffness: f64,
    /// `Δt²/m̃`: weight of the reduced load \[s²\].
    pub load: f64,
    /// Weights of the identity on `(ζ, Δt ζ̇, Δt² ζ̈, x_1, …)`: `a_j/m̃`, zero for `ζ`.
    pub identity: [f64; HISTORY],
    /// Weights of `E_i` on the same: `s_K Δt²/k̃` for `ζ`, `a_j/m̃ − b_j/k̃` for the others.
    pub increment: [f64; HISTORY],
}

impl StageCoefficients {
    /// The coefficients of `stage` (counted from 0) of `table`.
    ///
    /// # Errors
    /// [`SchemeError`] if a parameter is out of range or the stage does not exist.
    pub fn new(
        table: &SchemeTable,
        parameters: &StepParameters,
        stage: usize,
    ) -> Result<Self, SchemeError> {
        parameters.check()?;
        let n_stages = table.n_stages;
        let row = table
            .active()
            .get(stage)
            .ok_or(SchemeError::StageCount { found: n_stages })?;
        let StepParameters {
            time_step: dt,
            alpha,
            beta,
            density,
            stiffness,
        } = *parameters;
        let m = density * (row.mass + row.damping * dt * alpha);
        let k = stiffness * (row.stiffness * dt * dt + row.damping * dt * beta);
        for value in [m, k, k / m] {
            if !value.is_finite() || value <= 0.0 {
                return Err(SchemeError::BadParameter {
                    index: 5 + stage,
                    value,
                });
            }
        }
        let mut identity = [0.0; HISTORY];
        let mut increment = [0.0; HISTORY];
        increment[0] = stiffness * dt * dt / k; // k − Σh^K = 1, which `check` holds the table to
        for j in 1..HISTORY {
            let a = density * (row.mass_history[j] + dt * alpha * row.damping_history[j]);
            let b = stiffness
                * (dt * dt * row.stiffness_history[j] + dt * beta * row.damping_history[j]);
            identity[j] = a / m;
            increment[j] = a / m - b / k;
        }
        Ok(Self {
            theta: k / m,
            mass: m,
            stiffness: k,
            load: dt * dt / m,
            identity,
            increment,
        })
    }
}

/// `θ_i = k̃/m̃` \[s²\] of a stage (counted from 0): the one number through which `Δt`, uniform stiffness and density,
/// `α` and `β` reach the stage's matrix.
///
/// # Errors
/// As [`StageCoefficients::new`].
pub fn theta(
    table: &SchemeTable,
    parameters: &StepParameters,
    stage: usize,
) -> Result<f64, SchemeError> {
    Ok(StageCoefficients::new(table, parameters, stage)?.theta)
}

/// Length of the work slice [`fuse_into`] wants for `r` modes.
#[must_use]
pub const fn fuse_work_len(r: usize) -> usize {
    (MAX_STAGES + 1) * r
}

/// Fuses one step: `y ← y + D y + Σ_i p_i L_i g_i`, `y = (ζ, Δt ζ̇, Δt² ζ̈)` of length `3r`.
///
/// - `e`: `(n_stages, r, r)`, the symmetric `E_i = C(θ_i) − I` (pure numbers), each row-major;
/// - `d`: `(3r, 3r)` column-major, receives `D`;
/// - `loads`: `(n_stages, 3r, r)`, each `L_i` column-major, receives the map from `g_i` (row of `H_i` at the loaded dof times
///   the force, `Σ_dof H_i[dof, ·] F[dof]`) to the state; `p_i = Σ_j f_ij F_j` is the load's amplitude in stage `i`;
/// - `work`: at least [`fuse_work_len`].
///
/// With `r = 1` and `E = −θλ/(1 + θλ)` it gives the 3×3 block of one mode of the diagonal structure.
/// Cost `O(n_stages (3 + n_stages) r³)` multiply-adds; nothing is allocated.
///
/// # Errors
/// [`SchemeError`] if the table, a parameter or a length is wrong; the outputs are then unspecified.
pub fn fuse_into(
    table: &SchemeTable,
    parameters: &StepParameters,
    r: usize,
    e: &[f64],
    d: &mut [f64],
    loads: &mut [f64],
    work: &mut [f64],
) -> Result<(), SchemeError> {
    table.check()?;
    let n_stages = table.active().len();
    let square = r.saturating_mul(r);
    expect_len(e.len(), n_stages.saturating_mul(square))?;
    expect_len(d.len(), square.saturating_mul(9))?;
    expect_len(
        loads.len(),
        n_stages.saturating_mul(square).saturating_mul(3),
    )?;
    if work.len() < fuse_work_len(r) {
        return Err(SchemeError::Length {
            found: work.len(),
            needed: fuse_work_len(r),
        });
    }
    let mut stages = [StageCoefficients::default(); MAX_STAGES];
    for (index, stage) in stages.iter_mut().take(n_stages).enumerate() {
        *stage = StageCoefficients::new(table, parameters, index)?;
    }
    let short = SchemeError::Length {
        found: work.len(),
        needed: fuse_work_len(r),
    };
    let (increments, rest) = work.split_at_mut_checked(MAX_STAGES * r).ok_or(short)?;
    let combined = rest.get_mut(..r).ok_or(short)?;
    let stages = stages.get(..n_stages).unwrap_or_default();
    let r = r.max(1);
    let mut march = Propagation {
        stages,
        e,
        r,
        increments,
        combined,
    };
    for (column, out) in d.chunks_exact_mut(r.saturating_mul(3).max(1)).enumerate() {
        let unit = Unit {
            block: column / r,
            row: column % r,
            load_stage: MAX_STAGES,
        };
        march.run(unit);
        march.finish(table, unit, out);
    }
    for (column, out) in loads
        .chunks_exact_mut(r.saturating_mul(3).max(1))
        .enumerate()
    {
        let unit = Unit {
            block: HISTORY,
            row: column % r,
            load_stage: column / r,
        };
        march.run(unit);
        march.finish(table, unit, out);
    }
    Ok(())
}

fn expect_len(found: usize, needed: usize) -> Result<(), SchemeError> {
    if found == needed {
        Ok(())
    } else {
        Err(SchemeError::Length { found, needed })
    }
}

/// A unit input: entry `row` of block `block` of the state, or of the load of `load_stage`.
#[derive(Clone, Copy)]
struct Unit {
    block: usize,
    row: usize,
    load_stage: usize,
}

/// The stages applied to one unit input at a time.
struct Propagation<'a> {
    stages: &'a [StageCoefficients],
    e: &'a [f64],
    r: usize,
    /// `x_l`, one after the other, each of length r.
    increments: &'a mut [f64],
    /// What `E_i` multiplies.
    combined: &'a mut [f64],
}

impl Propagation<'_> {
    fn run(&mut self, unit: Unit) {
        let r = self.r.max(1);
        let square = r.saturating_mul(r).max(1);
        for ((i, stage), e) in self
            .stages
            .iter()
            .enumerate()
            .zip(self.e.chunks_exact(square))
        {
            let Some((earlier, rest)) = self.increments.split_at_mut_checked(i * r) else {
                return;
            };
            let Some(x) = rest.get_mut(..r) else { return };
            x.fill(0.0);
            self.combined.fill(0.0);
            let weights = stage.identity.iter().zip(&stage.increment);
            for (x_l, (identity, increment)) in earlier.chunks_exact(r).zip(weights.clone().skip(3))
            {
                for ((x, w), &known) in x.iter_mut().zip(self.combined.iter_mut()).zip(x_l) {
                    *x += identity * known;
                    *w += increment * known;
                }
            }
            if let Some((identity, increment)) = weights.clone().take(3).nth(unit.block) {
                add_at(x, unit.row, *identity);
                add_at(self.combined, unit.row, *increment);
            }
            if unit.load_stage == i {
                add_at(x, unit.row, stage.load);
            }
            for (x, row) in x.iter_mut().zip(e.chunks_exact(r)) {
                *x += row
                    .iter()
                    .zip(self.combined.iter())
                    .map(|(e, w)| e * w)
                    .sum::<f64>();
            }
        }
    }

    fn finish(&self, table: &SchemeTable, unit: Unit, out: &mut [f64]) {
        out.fill(0.0);
        let r = self.r.max(1);
        for (block, (row, out)) in table.finish.iter().zip(out.chunks_exact_mut(r)).enumerate() {
            let stages = row
                .iter()
                .skip(3)
                .zip(self.increments.chunks_exact(r))
                .take(self.stages.len());
            for (&weight, x) in stages {
                for (out, x) in out.iter_mut().zip(x) {
                    *out += weight * x;
                }
            }
            // The columns of ζ are consistent: what they keep and what the stages carry of them cancel on paper.
            if let Some(weight) = row
                .iter()
                .take(3)
                .nth(unit.block)
                .filter(|_| unit.block != 0)
            {
                let kept = if block == unit.block { 1.0 } else { 0.0 };
                add_at(out, unit.row, weight - kept);
            }
        }
    }
}

fn add_at(out: &mut [f64], index: usize, value: f64) {
    if let Some(out) = out.get_mut(index) {
        *out += value;
    }
}
