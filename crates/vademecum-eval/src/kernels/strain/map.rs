//! From the sections of the strain structure to the numbers of its step.
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
//! The weight `w` of a row is `W`, but for rows with a tail coordinate ([`tail`]). Rows are multiplied by
//! `√w` here, once.

use crate::base::error::BindError;
use crate::base::lend::{Short, put};
use crate::base::options::SceneOptions;
use crate::base::scalar::Scalar;
use crate::kernels::strain::memory::{ROW, StrainShape};
use crate::kernels::strain::tail::{self, TAIL};
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

    /// The step that options ask for, if every number of its map is finite in this precision. Writes nothing.
    pub fn checked<T: Scalar>(
        sections: &StrainSections<'_>,
        shape: StrainShape,
        asked: &StepParameters,
        options: &SceneOptions,
    ) -> Result<Self, BindError> {
        let step = Self::new(asked, options.substeps.unwrap_or(sections.substeps), options.viscosity)?;
        let finite = lay_out_strain::<T>(sections, shape, &step, None)?;
        let force = step.of_force(asked.density);
        let numbers = [step.mass, step.drag, 2.0 / (step.step * step.step), force, 1.0 / force];
        let finite = finite && numbers.iter().all(|&x| T::from_f64(x).to_f64().is_finite());
        if finite { Ok(step) } else { Err(BindError::NotFinite) }
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

/// Lays the map out for a step; `false` if a number of it is not finite in this precision. What is not in the
/// map (padding) is left alone. Without a map nothing is written.
pub(crate) fn lay_out_strain<T: Scalar>(
    sections: &StrainSections<'_>,
    shape: StrainShape,
    step: &StrainStep,
    mut map: Option<&mut [T]>,
) -> Result<bool, Short> {
    let (n, row_len) = (shape.padded(), shape.row_len());
    let quadratic = shape.rows * n;
    let rows = quadratic + shape.rows * row_len;
    let tails = rows + shape.rows * ROW;
    let inertia = tails + shape.tail * TAIL;
    let roots = inertia + shape.coordinates();
    let mut finite = true;
    let mut set = |at: usize, value: f64| {
        let value = T::from_f64(value);
        finite &= value.to_f64().is_finite();
        map.as_deref_mut().map_or(Ok(()), |map| put(map, at, value))
    };
    let pairs = shape.file_sizes();
    let n_pairs = pairs.pairs();
    for k in 0..shape.rows {
        let own = sections.linear.chunks_exact(shape.leading.max(1)).nth(k).unwrap_or(&[]);
        let numbers = row_numbers(sections, shape, step, own, k);
        let root = libm::sqrt(numbers.weight);
        let scale = step.scale * root;
        for (j, &value) in own.iter().enumerate() {
            set(k * n + j, scale * f64::from_le_bytes(value))?;
        }
        let line = quadratic + k * row_len;
        let values = sections.quadratic.row(k * n_pairs, n_pairs);
        let short = Short { found: sections.quadratic.len(), needed: shape.rows * n_pairs };
        for ((a, b), value) in pairs.pair_list().zip(values.ok_or(short)?.iter()) {
            if a == b {
                set(line + place(shape, a, a), 2.0 * scale * value)?;
            } else {
                set(line + place(shape, a, b), scale * value)?;
                set(line + place(shape, b, a), scale * value)?;
            }
        }
        set(rows + ROW * k, 2.0 / numbers.weight)?;
        set(rows + ROW * k + 1, (numbers.factor - 1.0) / numbers.weight)?;
        for (i, value) in numbers.tail.into_iter().flatten().enumerate() {
            set(tails + TAIL * (k - shape.leading) + i, value)?;
        }
    }
    for j in 0..shape.coordinates() {
        let root = step.root_of_inertia(sections, j);
        set(inertia + j, root * root)?;
        set(roots + j, root)?;
    }
    Ok(finite)
}

/// The numbers of row `k`, of this linear part.
fn row_numbers(
    sections: &StrainSections<'_>,
    shape: StrainShape,
    step: &StrainStep,
    linear: &[[u8; 8]],
    k: usize,
) -> RowNumbers {
    if let Some(numbers) = tail::row_numbers(sections, shape, step, k) {
        return numbers;
    }
    // Without a linear part it is 0.
    let square: f64 = linear.iter().map(|&l| f64::from_le_bytes(l) * f64::from_le_bytes(l)).sum();
    let factor = step.factor(step.scale * libm::sqrt(square));
    RowNumbers { factor, weight: factor, tail: None }
}

/// Index at which the quadratic part of a row has the factor of coordinate `column` in the product of number
/// `row`.
pub(crate) const fn place(shape: StrainShape, row: usize, column: usize) -> usize {
    let (width, mut start, mut at) = (shape.width(), 0, 0);
    while start + width <= row {
        at += shape.columns(start) * width;
        start += width;
    }
    at + column * width + (row - start)
}

/// Loads of a step: what a unit force, at the start and at the end of the step, adds to the right-hand sides:
/// their value at the start of the step, and how much they grow over it.
pub(crate) fn lay_out_force<T: Scalar>(step: &StrainStep, density: f64, stride: usize, maps: &mut [T]) {
    let force = T::from_f64(step.of_force(density));
    let less = T::ZERO - force;
    for (map, values) in maps.chunks_exact_mut(stride.max(1)).zip([force, less, T::ZERO, force]) {
        map.fill(values);
    }
}

/// At least `|L|` and `|Q|`: `|z(q)| ≤ |L| |q| + |Q| |q|²`.
pub(crate) fn bounds(sections: &StrainSections<'_>) -> [f64; 2] {
    let square = |numbers: &[[u8; 8]]| -> f64 {
        numbers.iter().map(|&x| f64::from_le_bytes(x) * f64::from_le_bytes(x)).sum()
    };
    let quadratic: f64 = sections.quadratic.iter().map(|x| x * x).sum();
    [libm::sqrt(square(sections.linear) + square(sections.tail)), libm::sqrt(quadratic)]
}

/// `|W q|`.
pub(crate) fn distance<T: Scalar>(rows: &[[u8; 8]], q: &[T]) -> f64 {
    let mut sum = 0.0;
    for row in rows.chunks_exact(q.len().max(1)) {
        let along: f64 = row.iter().zip(q).map(|(&w, q)| f64::from_le_bytes(w) * q.to_f64()).sum();
        sum += along * along;
    }
    libm::sqrt(sum)
}
