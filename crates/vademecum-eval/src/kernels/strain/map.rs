//! From the sections of the strain structure to the map of its step. Rows are multiplied by the root of their
//! weight here, once (see [`crate::kernels::strain::numbers`]).

use crate::base::error::BindError;
use crate::base::lend::{Short, put};
use crate::base::options::SceneOptions;
use crate::base::scalar::Scalar;
use crate::kernels::strain::memory::{ROW, StrainShape, TAIL};
use crate::kernels::strain::numbers::{RowNumbers, StrainSections, StrainStep};
use crate::kernels::strain::tail;
use vademecum_format::scheme::StepParameters;

/// The step that options ask for, if every number of its map is finite in this precision. Writes nothing.
pub(crate) fn checked_step<T: Scalar>(
    sections: &StrainSections<'_>,
    shape: StrainShape,
    asked: &StepParameters,
    options: &SceneOptions,
) -> Result<StrainStep, BindError> {
    let step = StrainStep::new(asked, options.substeps.unwrap_or(sections.substeps), options.viscosity)?;
    let finite = lay_out_strain::<T>(sections, shape, &step, None)?;
    let force = step.of_force(asked.density);
    let numbers = [step.mass, step.drag, 2.0 / (step.step * step.step), force, 1.0 / force];
    let finite = finite && numbers.iter().all(|&x| T::from_f64(x).to_f64().is_finite());
    if finite { Ok(step) } else { Err(BindError::NotFinite) }
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
