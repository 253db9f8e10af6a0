//! A time scheme as a table, the way one writes a Butcher tableau.
//!
//! With the scaled state `y = (u, Δt u̇, Δt² ü)` every coefficient is a pure number. Stage `i` solves
//!
//! ```text
//! (m_i M + d_i Δt C + k_i Δt² K) u_i = Δt² Σ_j f_ij F_j + M h^M_i·z + Δt C h^C_i·z + Δt² K h^K_i·z
//! ```
//!
//! where the history `z = (u, Δt u̇, Δt² ü, u_1, …, u_{i−1})` holds the old state and the earlier stages, and
//! `F_0 = F(t_n)`, `F_j = F(t_n + c_j Δt)`. The new state is a linear combination of
//! `(u, Δt u̇, Δt² ü, u_1, …, u_s)`. Full-order solver, reduced solver and vademecum read this same table
//! (`docs/explanation/`).

use bincode::{BorrowDecode, Encode};
use core::fmt;
use thiserror::Error;

pub use crate::fuse::{StageCoefficients, fuse_into, fuse_work_len, theta};

/// Sums that a table owes exactly may miss by this much, relative to the terms added: a table is computed in
/// `f64` from a few scheme constants, so its sums carry a few roundings (2⁻⁵²) times the size of the terms;
/// 2⁻⁴⁰ leaves 4 000 of them.
const CONSISTENCY: f64 = 1.0 / (1u64 << 40) as f64;

/// Most stages a table can hold.
pub const MAX_STAGES: usize = 3;
/// Length of a history: the old state and all stages.
pub const HISTORY: usize = 3 + MAX_STAGES;

/// One solve of a scheme; all coefficients are pure numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Encode, BorrowDecode)]
pub struct Stage {
    /// `m_i`: weight of `M`.
    pub mass: f64,
    /// `d_i`: weight of `Δt C`.
    pub damping: f64,
    /// `k_i`: weight of `Δt² K`.
    pub stiffness: f64,
    /// `c_i`: the instant of this stage, as a fraction of the step.
    pub time: f64,
    /// `f_ij`: weights of `F(t_n)` and of the force at each stage's instant; their sum is 1.
    pub load: [f64; 1 + MAX_STAGES],
    /// `h^M_i` over `(u, Δt u̇, Δt² ü, u_1, …)`.
    pub mass_history: [f64; HISTORY],
    /// `h^C_i` over the same history.
    pub damping_history: [f64; HISTORY],
    /// `h^K_i` over the same history.
    pub stiffness_history: [f64; HISTORY],
}

/// A time scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Encode, BorrowDecode)]
pub struct SchemeTable {
    /// Number of stages in use, 1 to [`MAX_STAGES`]; 0 in [`SchemeTable::EXACT`].
    pub n_stages: u8,
    /// The stages; those past `n_stages` are zero.
    pub stages: [Stage; MAX_STAGES],
    /// Rows: new `u`, `Δt u̇`, `Δt² ü`; columns: `(u, Δt u̇, Δt² ü, u_1, …, u_s)`.
    pub finish: [[f64; HISTORY]; 3],
}

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
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// The number of stages is not 1 to [`MAX_STAGES`].
    #[error("a scheme of {found} stages; 1 to {MAX_STAGES} are possible")]
    StageCount {
        /// Number in the table.
        found: u8,
    },
    /// A scheme of stages beside the strain structure, which has a step of its own.
    #[error(
        "a scheme of {found} stages beside the strain structure, which has a step of its own; expected \
         none"
    )]
    StagesBesideStrain {
        /// Stages of the scheme.
        found: u8,
    },
    /// A coefficient of this stage (or of `finish`, for the number of stages) is not finite.
    #[error("stage {stage} of the scheme holds a number that is not finite")]
    NotFinite {
        /// The stage.
        stage: usize,
    },
    /// `m` or `k` of this stage is not positive, or its history uses a stage not solved yet.
    #[error("stage {stage} of the scheme needs positive m and k and may use earlier stages only")]
    BadStage {
        /// The stage.
        stage: usize,
    },
    /// A sum that a consistent scheme owes is missed: constant displacement must be no motion,
    /// `k − Σh^K = Σf = 1`.
    #[error(
        "stage {stage} of the scheme misses a consistency sum by {by:e}: constant displacement must stay \
         constant"
    )]
    Inconsistent {
        /// The stage, or the number of stages for `finish`.
        stage: usize,
        /// Error of the sum.
        by: f64,
    },
    /// A step parameter is not finite or not in its range, or makes `m̃` or `k̃` of a stage not positive.
    #[error(fmt = bad_parameter)]
    BadParameter {
        /// The parameter's place in [`StepParameters`] (0 to 4), or 5 + the stage.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A lent or given slice has the wrong length.
    #[error("a slice of {found} numbers was lent where {needed} are needed")]
    Length {
        /// Length found.
        found: usize,
        /// Length needed.
        needed: usize,
    },
}

fn bad_parameter(index: &usize, value: &f64, out: &mut fmt::Formatter<'_>) -> fmt::Result {
    let names = ["time step", "alpha", "beta", "density scale", "stiffness scale"];
    match names.get(*index) {
        Some(name) => write!(out, "{name} = {value:e} is not finite or not in its range"),
        None => {
            let stage = index.saturating_sub(names.len());
            write!(out, "the parameters make a matrix weight of stage {stage} {value:e}")
        }
    }
}

impl StepParameters {
    /// Checks the ranges: `Δt, s_ρ, s_K > 0`, `α, β ≥ 0`, all finite.
    ///
    /// # Errors
    /// [`TableError::BadParameter`].
    pub fn check(&self) -> Result<(), TableError> {
        let values = [self.time_step, self.alpha, self.beta, self.density, self.stiffness];
        for (index, &value) in values.iter().enumerate() {
            let may_vanish = index == 1 || index == 2;
            if !value.is_finite() || value < 0.0 || (value == 0.0 && !may_vanish) {
                return Err(TableError::BadParameter { index, value });
            }
        }
        Ok(())
    }
}

impl SchemeTable {
    /// Not a scheme but the exact step of each mode ([`crate::exact`]): a table without stages. Only the
    /// diagonal structure has it.
    pub const EXACT: Self = {
        let nothing = [0.0; HISTORY];
        let stage = Stage {
            mass: 0.0,
            damping: 0.0,
            stiffness: 0.0,
            time: 0.0,
            load: [0.0; 1 + MAX_STAGES],
            mass_history: nothing,
            damping_history: nothing,
            stiffness_history: nothing,
        };
        Self { n_stages: 0, stages: [stage; MAX_STAGES], finish: [nothing; 3] }
    };

    /// True for exact integration of modes, which has no stages.
    #[must_use]
    pub const fn is_exact(&self) -> bool {
        self.n_stages == 0
    }

    /// The stages in use.
    #[must_use]
    pub fn active(&self) -> &[Stage] {
        self.stages.get(..usize::from(self.n_stages)).unwrap_or(&self.stages)
    }

    /// Instants at which a step needs the load, as fractions of it: 0, then `c_i` of each stage; the rest is
    /// zero. An exact step needs it at its start and at its end, and takes it as linear between.
    #[must_use]
    pub fn instants(&self) -> [f64; 1 + MAX_STAGES] {
        let mut instants = [0.0; 1 + MAX_STAGES];
        if self.is_exact() {
            instants[1] = 1.0;
        }
        for (instant, stage) in instants.iter_mut().skip(1).zip(self.active()) {
            *instant = stage.time;
        }
        instants
    }

    /// Checks that the table is [`SchemeTable::EXACT`], or finite and consistent: `Σh^M = m`, `Σh^C = d`,
    /// `k − Σh^K = 1` over the displacement columns, `Σf = 1`, and `finish` rows summing to 1, 0, 0 over
    /// them.
    ///
    /// # Errors
    /// [`TableError`] naming the stage.
    pub fn check(&self) -> Result<(), TableError> {
        if *self == Self::EXACT {
            return Ok(());
        }
        if !cfg!(feature = "full") || self.n_stages == 0 || usize::from(self.n_stages) > MAX_STAGES {
            return Err(TableError::StageCount { found: self.n_stages });
        }
        for (index, stage) in self.active().iter().enumerate() {
            check_stage(stage, index)?;
        }
        let n_stages = usize::from(self.n_stages);
        for (row, owed) in self.finish.iter().zip([1.0, 0.0, 0.0]) {
            if row.iter().any(|f| !f.is_finite()) {
                return Err(TableError::NotFinite { stage: n_stages });
            }
            owes(row, n_stages, owed, n_stages)?;
        }
        Ok(())
    }
}

fn check_stage(stage: &Stage, index: usize) -> Result<(), TableError> {
    let histories = [&stage.mass_history, &stage.damping_history, &stage.stiffness_history];
    let scalars = [stage.mass, stage.damping, stage.stiffness, stage.time];
    let mut all = histories.iter().flat_map(|h| h.iter()).chain(&scalars).chain(&stage.load);
    if all.any(|value| !value.is_finite()) {
        return Err(TableError::NotFinite { stage: index });
    }
    let looks_ahead = histories.iter().any(|h| h.iter().skip(3 + index).any(|&c| c != 0.0));
    if stage.mass <= 0.0 || stage.stiffness <= 0.0 || looks_ahead {
        return Err(TableError::BadStage { stage: index });
    }
    owes(&stage.mass_history, index, stage.mass, index)?;
    owes(&stage.damping_history, index, stage.damping, index)?;
    owes(&stage.stiffness_history, index, stage.stiffness - 1.0, index)?;
    let by = stage.load.iter().sum::<f64>() - 1.0;
    let size = 1.0 + stage.load.iter().map(|f| f.abs()).sum::<f64>();
    if by.abs() > CONSISTENCY * size {
        return Err(TableError::Inconsistent { stage: index, by });
    }
    Ok(())
}

/// The displacement columns of `row` (the old one and `earlier` stages) must sum to `owed`.
fn owes(row: &[f64; HISTORY], earlier: usize, owed: f64, stage: usize) -> Result<(), TableError> {
    let columns = || row.iter().take(1).chain(row.iter().skip(3).take(earlier));
    let by = columns().sum::<f64>() - owed;
    let size = 1.0 + owed.abs() + columns().map(|c| c.abs()).sum::<f64>();
    if by.abs() > CONSISTENCY * size {
        return Err(TableError::Inconsistent { stage, by });
    }
    Ok(())
}
