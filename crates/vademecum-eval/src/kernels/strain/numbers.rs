//! Sections of the strain structure, and the parameters of its step.
//!
//! With the sub-step `k` and `s = k/2 √(s_K/s_ρ)`, a row becomes `L̂ = s L` and `Q̂ = s (Q + Qᵀ)`. A row's
//! strain rate is damped with the factor
//!
//! ```text
//! W = 1 + 2β/k + c (s σ)²      σ: length of a row of L, 0 without a linear part
//! ```
//!
//! A natural mode of frequency `Ω` swings with it if its inertia is fitted to the sub-step: `m = x²/tan²x`
//! with `x = s Ω`, and 1 for other coordinates and for modes with fewer than four sub-steps in a period.
//!
//! The weight `w` of a row is `W`, but for rows with a tail coordinate ([`crate::kernels::strain::tail`]).
//! Rows are multiplied by `√w` here, once.

use crate::base::error::BindError;
use crate::kernels::strain::memory::{StrainShape, TAIL};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{File, FormatError, Numbers, SectionKind, StrainSizes};

/// The sections of the strain structure; empty for the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StrainSections<'m> {
    pub linear: &'m [[u8; 8]],
    pub tail: &'m [[u8; 8]],
    pub quadratic: Numbers<'m>,
    /// `Ω` of natural modes, 0 of other coordinates; empty where no inertia is fitted.
    pub modes: &'m [[u8; 8]],
    /// Sub-steps of a step as built.
    pub substeps: usize,
    /// `W` of the training box, and its two limits; `None` if absent or compressed.
    pub training: Option<[&'m [[u8; 8]]; 2]>,
}

impl Default for StrainSections<'_> {
    fn default() -> Self {
        let quadratic = Numbers::F64(&[]);
        Self { linear: &[], tail: &[], quadratic, modes: &[], substeps: 1, training: None }
    }
}

impl<'m> StrainSections<'m> {
    /// Looks the sections up.
    pub fn of(file: &File<'m>) -> Result<Self, FormatError> {
        use SectionKind as S;
        let section =
            |kind: SectionKind| file.section(kind).ok_or(FormatError::Missing { kind: kind.number() });
        let given = |kind| file.section(kind).map(|section| section.f64s()).transpose();
        let optional = |kind| file.section(kind).and_then(|section| section.f64s().ok());
        Ok(Self {
            substeps: sizes(file)?.substeps,
            linear: section(S::StrainLinear)?.f64s()?,
            tail: given(S::StrainTail)?.unwrap_or(&[]),
            modes: given(S::StrainModes)?.unwrap_or(&[]),
            quadratic: section(S::StrainQuadratic)?.numbers()?,
            training: optional(S::StrainBox).zip(optional(S::StrainLimits)).map(|(w, limits)| [w, limits]),
        })
    }
}

fn sizes(file: &File<'_>) -> Result<StrainSizes, FormatError> {
    let kind = SectionKind::StrainSizes.number();
    file.strain_sizes()?.ok_or(FormatError::Missing { kind })
}

/// The lengths of a file's strain structure.
pub(crate) fn strain_shape(file: &File<'_>) -> Result<StrainShape, FormatError> {
    let sizes = sizes(file)?;
    let (interacting, leading, tail) = (sizes.interacting, sizes.leading(), sizes.tail());
    Ok(StrainShape { interacting, leading, tail, rows: sizes.rows })
}

/// Parameters of a step; zeros for the other structures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StrainStep {
    /// Sub-steps of a step.
    pub substeps: usize,
    /// `c`: the viscosity of rows.
    pub viscosity: f64,
    /// `k` \[s\].
    pub step: f64,
    /// `s`.
    pub scale: f64,
    /// `μ`.
    pub mass: f64,
    /// `1 + 2β/k`.
    pub drag: f64,
}

impl StrainStep {
    /// Of these parameters.
    pub fn new(asked: &StepParameters, substeps: usize, viscosity: f64) -> Result<Self, BindError> {
        asked.check()?;
        if !viscosity.is_finite() || viscosity < 0.0 {
            return Err(BindError::BadOption { value: viscosity });
        }
        if substeps == 0 || substeps > vademecum_format::MAX_SUBSTEPS as usize {
            return Err(BindError::BadOption { value: substeps as f64 });
        }
        let step = asked.time_step / substeps as f64;
        Ok(Self {
            substeps,
            viscosity,
            step,
            scale: 0.5 * step * libm::sqrt(asked.stiffness / asked.density),
            mass: 1.0 + 0.5 * step * asked.alpha,
            drag: 1.0 + 2.0 * asked.beta / step,
        })
    }

    /// `W` of a row whose linear part has the scaled length `x`.
    pub fn factor(&self, x: f64) -> f64 {
        self.drag + self.viscosity * x * x
    }

    /// `true` if anything takes energy.
    pub const fn is_damped(&self) -> bool {
        self.viscosity > 0.0 || self.mass > 1.0 || self.drag > 1.0
    }

    /// `√m` of a coordinate.
    pub fn root_of_inertia(&self, sections: &StrainSections<'_>, coordinate: usize) -> f64 {
        let omega = sections.modes.get(coordinate).map_or(0.0, |&omega| f64::from_le_bytes(omega));
        let x = self.scale * omega;
        if x > 0.0 && x <= core::f64::consts::FRAC_PI_4 { over_tangent(x) } else { 1.0 }
    }

    /// Addition of a unit reduced force to the right-hand side of a sub-step: `k²/(2 s_ρ)`.
    pub fn of_force(&self, density: f64) -> f64 {
        0.5 * self.step * self.step / density
    }
}

/// `x/tan x` for `x` up to π/4, by Lambert's continued fraction `1 − x²/(3 − x²/(5 − …))`, which takes less
/// code than a sine and a cosine.
fn over_tangent(x: f64) -> f64 {
    /// The first odd number left out adds less than 1e-17.
    const LAST: f64 = 19.0;
    let odd = (0..9).rev().map(|n| f64::from(2 * n + 1));
    odd.fold(LAST, |below, odd| odd - x * x / below)
}

/// The numbers of a row that depend on the parameters.
pub(crate) struct RowNumbers {
    /// `W`.
    pub factor: f64,
    /// `w`.
    pub weight: f64,
    /// Those of its tail coordinate.
    pub tail: Option<[f64; TAIL]>,
}
