//! The principal values and axes of a symmetric 3×3 matrix.

use crate::base::vec3::{add, dot};

/// Sweeps of turns; three are enough for rounding.
const SWEEPS: usize = 8;

pub(crate) const UNITS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's turns.
pub(crate) fn principal(matrix: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let image = |v: [f64; 3]| matrix.map(|row| dot(row, v));
    let mut axes = UNITS;
    for _ in 0..SWEEPS {
        let [mut a, mut b, mut c] = axes;
        (a, b) = apart(image, a, b);
        (b, c) = apart(image, b, c);
        (c, a) = apart(image, c, a);
        axes = [a, b, c];
    }
    (axes.map(|axis| dot(axis, image(axis))), axes)
}

/// Two directions turned in their plane, so that the matrix does not couple them.
fn apart(image: impl Fn([f64; 3]) -> [f64; 3], a: [f64; 3], b: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let (of_a, of_b) = (image(a), image(b));
    let coupling = dot(a, of_b);
    let difference = dot(b, of_b) - dot(a, of_a);
    if coupling == 0.0 {
        return (a, b);
    }
    let ratio = 0.5 * difference / coupling;
    let root = libm::sqrt(1.0 + ratio * ratio);
    let tangent = if ratio < 0.0 { -1.0 / (root - ratio) } else { 1.0 / (root + ratio) };
    let cosine = 1.0 / libm::sqrt(1.0 + tangent * tangent);
    let sine = tangent * cosine;
    (add(a.map(|x| cosine * x), -sine, b), add(b.map(|x| cosine * x), sine, a))
}
