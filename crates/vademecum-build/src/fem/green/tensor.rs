//! Small tensors: products, Green's strain, principal values.

/// A 3 × 3 matrix, row by row.
pub(super) type Tensor = [[f64; 3]; 3];

/// The part of a symmetric tensor with no negative principal value.
#[inline]
pub(super) fn tensile(t: &Tensor) -> Tensor {
    let (values, axes) = principal(t);
    let mut out = [[0.0; 3]; 3];
    for k in 0..3 {
        for i in 0..3 {
            for j in 0..3 {
                out[i][j] += values[k].max(0.0) * axes[i][k] * axes[j][k];
            }
        }
    }
    out
}

/// Principal values and axes (as columns) by Jacobi's rotations.
pub(super) fn principal(t: &Tensor) -> ([f64; 3], Tensor) {
    let (mut a, mut axes) = (*t, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let size = a.as_flattened().iter().map(|x| x.abs()).fold(0.0, f64::max);
    // Each sweep squares what is left off the diagonal; five leave nothing that double precision shows.
    for _ in 0..8 {
        for [p, q] in [[0, 1], [1, 2], [0, 2]] {
            if a[p][q].abs() <= f64::EPSILON * size {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let c = 1.0 / tangent.hypot(1.0);
            let s = tangent * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (from_p, from_q) = (a[p], a[q]);
            for k in 0..3 {
                (a[p][k], a[q][k]) = (c * from_p[k] - s * from_q[k], s * from_p[k] + c * from_q[k]);
            }
            for row in &mut axes {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], axes)
}

/// `A B`.
#[inline]
pub(super) fn product(a: &Tensor, b: &Tensor) -> Tensor {
    a.map(|row| std::array::from_fn(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

/// `Aᵀ B`.
#[inline]
pub(super) fn transposed_product(a: &Tensor, b: &Tensor) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[k][i] * b[k][j]).sum()))
}

/// `½ (A + Aᵀ)`.
#[inline]
pub(super) fn symmetric(a: &Tensor) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (a[i][j] + a[j][i])))
}

#[inline]
pub(super) fn scaled(a: &Tensor, factor: f64) -> Tensor {
    a.map(|row| row.map(|x| factor * x))
}

/// `F = I + H`.
#[inline]
pub(super) fn deformation(h: &Tensor) -> Tensor {
    let mut f = *h;
    (0..3).for_each(|i| f[i][i] += 1.0);
    f
}

/// `½ (H + Hᵀ + HᵀH)`: no difference of large numbers at small displacements.
#[inline]
pub(super) fn green(h: &Tensor) -> Tensor {
    let (small, square) = (symmetric(h), transposed_product(h, h));
    std::array::from_fn(|i| std::array::from_fn(|j| small[i][j] + 0.5 * square[i][j]))
}
