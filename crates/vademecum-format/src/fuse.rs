//! The stages of a scheme fused into one increment map.
//!
//! With `K → s_K K`, `M → s_ρ M` and `C = αM + βK`, stage `i` has the matrix `m̃ (M + θ_i K)` with
//! `m̃ = s_ρ (m + d Δt α)`, `k̃ = s_K (k Δt² + d Δt β)` and `θ_i = k̃ / m̃`. Everything the reduced step
//! needs of it is `C(θ_i) = BᵀM (M + θ_i K)⁻¹ M B = I + E_i`, because `Π A⁻¹M B = (I + E_i)/m̃` and
//! `Π A⁻¹K B = −E_i/k̃`.
//!
//! Written for the increments `x_i = ζ_i − ζ`, with `a_j = s_ρ (h^M_j + Δt α h^C_j)` and
//! `b_j = s_K (Δt² h^K_j + Δt β h^C_j)`, and `y = (ζ, Δt ζ̇, Δt² ζ̈)`:
//!
//! ```text
//! x_i = c_i E_i y_0 + Σ_{j=1,2} [(a_j/m̃)(I + E_i) − (b_j/k̃) E_i] y_j
//!                   + Σ_{l<i}   [(a_l/m̃)(I + E_i) − (b_l/k̃) E_i] x_l + (Δt²/m̃) p_i g_i
//! ```
//!
//! Region scales change `M` and `K` themselves. With `M = Σ ρ_q M_q` and the basis normalised in the nominal
//! mass `M_0`, the projection is `Π = BᵀM_0` and `C(θ) = BᵀM_0 (M + θK)⁻¹ M B`; both identities above stay,
//! only the symmetry of `E_i` goes.
//!
//! `c_i = s_K Δt²/k̃` (from `k − Σh^K = 1`). A consistent table has `Σ a_j = m̃` over the displacements, so
//! `y_0` enters through `E_i` alone: the large identity parts cancel on paper, not in the arithmetic. The odd
//! thing: that makes consistency a condition, and [`SchemeTable::check`] refuses a table without it.

use crate::scheme::{HISTORY, MAX_STAGES, SchemeTable, StepParameters, TableError};

/// Coefficients of one stage at given parameters; see the module's equation.
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
    /// [`TableError`] if a parameter is out of range or the stage does not exist.
    pub fn new(table: &SchemeTable, parameters: &StepParameters, stage: usize) -> Result<Self, TableError> {
        parameters.check()?;
        let n_stages = table.n_stages;
        let row = table.active().get(stage).ok_or(TableError::StageCount { found: n_stages })?;
        let StepParameters { time_step: dt, alpha, beta, density, stiffness } = *parameters;
        let m = density * (row.mass + row.damping * dt * alpha);
        let k = stiffness * (row.stiffness * dt * dt + row.damping * dt * beta);
        for value in [m, k, k / m] {
            if !value.is_finite() || value <= 0.0 {
                return Err(TableError::BadParameter { index: 5 + stage, value });
            }
        }
        let mut identity = [0.0; HISTORY];
        let mut increment = [0.0; HISTORY];
        increment[0] = stiffness * dt * dt / k; // k − Σh^K = 1, which `check` holds the table to
        for j in 1..HISTORY {
            let a = density * (row.mass_history[j] + dt * alpha * row.damping_history[j]);
            let b = stiffness * (dt * dt * row.stiffness_history[j] + dt * beta * row.damping_history[j]);
            identity[j] = a / m;
            increment[j] = a / m - b / k;
        }
        Ok(Self { theta: k / m, mass: m, stiffness: k, load: dt * dt / m, identity, increment })
    }
}

/// `θ_i = k̃/m̃` \[s²\] of a stage (counted from 0): the one number through which `Δt`, uniform stiffness and
/// density, `α` and `β` reach the stage's matrix.
///
/// # Errors
/// As [`StageCoefficients::new`].
pub fn theta(table: &SchemeTable, parameters: &StepParameters, stage: usize) -> Result<f64, TableError> {
    Ok(StageCoefficients::new(table, parameters, stage)?.theta)
}

/// Length of the work slice [`fuse_into`] wants for `r` modes.
#[must_use]
pub const fn fuse_work_len(r: usize) -> usize {
    (MAX_STAGES + 1) * r
}

/// Fuses one step: `y ← y + D y + Σ_i p_i L_i g_i`, `y = (ζ, Δt ζ̇, Δt² ζ̈)` of length `3r`.
///
/// - `e`: `(n_stages, r, r)`, `E_i = C(θ_i) − I` (pure numbers), each row-major and used as a general matrix:
///   row `k` gives `x_i[k]` (region densities make it unsymmetric);
/// - `d`: `(3r, 3r)` column-major, receives `D`;
/// - `loads`: `(n_stages, 3r, r)`, each `L_i` column-major, receives the map from `g_i` (row of `H_i` at the
///   loaded dof times the force, `Σ_dof H_i[dof, ·] F[dof]`) to the state; `p_i = Σ_j f_ij F_j` is the load's
///   amplitude in stage `i`;
/// - `work`: at least [`fuse_work_len`].
///
/// With `r = 1` and `E = −θλ/(1 + θλ)` it gives the 3×3 block of one mode of the diagonal structure.
/// Cost at most `n_stages (3 + n_stages) r³` multiply-adds; nothing is allocated.
///
/// # Errors
/// [`TableError`] if the table, a parameter or a length is wrong; the outputs are then unspecified.
pub fn fuse_into(
    table: &SchemeTable,
    parameters: &StepParameters,
    r: usize,
    e: &[f64],
    d: &mut [f64],
    loads: &mut [f64],
    work: &mut [f64],
) -> Result<(), TableError> {
    table.check()?;
    if table.is_exact() {
        return Err(TableError::StageCount { found: 0 });
    }
    let n_stages = table.active().len();
    let square = r.saturating_mul(r);
    expect_len(e.len(), n_stages.saturating_mul(square))?;
    expect_len(d.len(), square.saturating_mul(9))?;
    expect_len(loads.len(), n_stages.saturating_mul(square).saturating_mul(3))?;
    if work.len() < fuse_work_len(r) {
        return Err(TableError::Length { found: work.len(), needed: fuse_work_len(r) });
    }
    let mut stages = [StageCoefficients::default(); MAX_STAGES];
    for (index, stage) in stages.iter_mut().take(n_stages).enumerate() {
        *stage = StageCoefficients::new(table, parameters, index)?;
    }
    let short = TableError::Length { found: work.len(), needed: fuse_work_len(r) };
    let (increments, rest) = work.split_at_mut_checked(MAX_STAGES * r).ok_or(short)?;
    let combined = rest.get_mut(..r).ok_or(short)?;
    let stages = stages.get(..n_stages).ok_or(TableError::StageCount { found: table.n_stages })?;
    let r = r.max(1);
    let mut march = Propagation { stages, e, r, increments, combined };
    for (column, out) in d.chunks_exact_mut(r.saturating_mul(3).max(1)).enumerate() {
        let unit = Unit { block: column / r, row: column % r, load_stage: MAX_STAGES };
        march.run(unit).ok_or(short)?;
        march.finish(table, unit, out).ok_or(short)?;
    }
    for (column, out) in loads.chunks_exact_mut(r.saturating_mul(3).max(1)).enumerate() {
        let unit = Unit { block: HISTORY, row: column % r, load_stage: column / r };
        march.run(unit).ok_or(short)?;
        march.finish(table, unit, out).ok_or(short)?;
    }
    Ok(())
}

fn expect_len(found: usize, needed: usize) -> Result<(), TableError> {
    if found == needed { Ok(()) } else { Err(TableError::Length { found, needed }) }
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
    /// The factor of `E_i`.
    combined: &'a mut [f64],
}

impl Propagation<'_> {
    /// `None` if a slice is shorter than `r` asks for; so with the functions below.
    fn run(&mut self, unit: Unit) -> Option<()> {
        let r = self.r.max(1);
        let square = r.saturating_mul(r).max(1);
        for ((i, stage), e) in self.stages.iter().enumerate().zip(self.e.chunks_exact(square)) {
            let (earlier, rest) = self.increments.split_at_mut_checked(i * r)?;
            let x = rest.get_mut(..r)?;
            x.fill(0.0);
            self.combined.fill(0.0);
            let weights = stage.identity.iter().zip(&stage.increment);
            for (x_l, (identity, increment)) in earlier.chunks_exact(r).zip(weights.clone().skip(3)) {
                for ((x, w), &known) in x.iter_mut().zip(self.combined.iter_mut()).zip(x_l) {
                    *x += identity * known;
                    *w += increment * known;
                }
            }
            if let Some((identity, increment)) = weights.clone().take(3).nth(unit.block) {
                add_at(x, unit.row, *identity)?;
                add_at(self.combined, unit.row, *increment)?;
            }
            if unit.load_stage == i {
                add_at(x, unit.row, stage.load)?;
            }
            add_product(e, self.combined, x)?;
        }
        Some(())
    }

    fn finish(&self, table: &SchemeTable, unit: Unit, out: &mut [f64]) -> Option<()> {
        out.fill(0.0);
        let r = self.r.max(1);
        for (block, (row, out)) in table.finish.iter().zip(out.chunks_exact_mut(r)).enumerate() {
            let stages = row.iter().skip(3).zip(self.increments.chunks_exact(r)).take(self.stages.len());
            for (&weight, x) in stages {
                for (out, x) in out.iter_mut().zip(x) {
                    *out += weight * x;
                }
            }
            // The columns of ζ are consistent: what they keep and what the stages carry of them cancel on
            // paper.
            if let Some(weight) = row.iter().take(3).nth(unit.block).filter(|_| unit.block != 0) {
                let kept = if block == unit.block { 1.0 } else { 0.0 };
                add_at(out, unit.row, weight - kept)?;
            }
        }
        Some(())
    }
}

/// `x += E w`, `E` row by row. A unit input meets its first stage as a `w` of one number, and later ones as
/// none if it is another stage's load: most products are a column or nothing.
fn add_product(e: &[f64], w: &[f64], x: &mut [f64]) -> Option<()> {
    let mut present = w.iter().enumerate().filter(|&(_, &w)| w != 0.0);
    let (first, second) = (present.next(), present.next());
    // `next`, not `zip`: zipped chunks divide by their sizes, which the compiler cannot see are not zero.
    let mut rows = e.chunks_exact(w.len().max(1));
    match (first, second) {
        (None, _) => {}
        (Some((column, w)), None) => {
            for x in x {
                *x += rows.next()?.get(column)? * w;
            }
        }
        _ => {
            for x in x {
                *x += dot(rows.next()?, w);
            }
        }
    }
    Some(())
}

/// Eight sums side by side: one alone waits for itself.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h)) + rest
}

fn add_at(out: &mut [f64], index: usize, value: f64) -> Option<()> {
    *out.get_mut(index)? += value;
    Some(())
}
