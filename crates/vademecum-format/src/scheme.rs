//! A time scheme as a table, the way one writes a Butcher tableau.
//!
//! With the scaled state `y = (u, Δt u̇, Δt² ü)` every coefficient is a pure number. Stage `i` solves
//!
//! ```text
//! (m_i M + d_i Δt C + k_i Δt² K) u_i = Δt² Σ_j f_ij F_j + M h^M_i·z + Δt C h^C_i·z + Δt² K h^K_i·z
//! ```
//!
//! where the history `z = (u, Δt u̇, Δt² ü, u_1, …, u_{i−1})` holds the old state and the earlier stages, and
//! `F_0 = F(t_n)`, `F_j = F(t_n + c_j Δt)`. The new state is a linear combination of `(u, Δt u̇, Δt² ü, u_1, …, u_s)`.
//! Full-order solver, reduced solver and vademecum read this same table (`docs/theory/`).

use bincode::{BorrowDecode, Encode};

pub use crate::fuse::{
    SchemeError, StageCoefficients, StepParameters, fuse_into, fuse_work_len, theta,
};

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
    /// Number of stages in use, 1 to [`MAX_STAGES`].
    pub n_stages: u8,
    /// The stages; those past `n_stages` are zero.
    pub stages: [Stage; MAX_STAGES],
    /// Rows: new `u`, `Δt u̇`, `Δt² ü`; columns: `(u, Δt u̇, Δt² ü, u_1, …, u_s)`.
    pub finish: [[f64; HISTORY]; 3],
}
