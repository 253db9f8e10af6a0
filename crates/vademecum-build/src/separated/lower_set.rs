//! Polynomials of several variables from few values: interpolation on a lower set of degrees.
//!
//! A box of five parameters has 10⁵ grid points and more, but a smooth function needs only the degrees below
//! a simplex, `Σ_a ν_a/(n_a − 1) ≤ level`, some thousands of them. With the Chebyshev points of each axis in
//! Leja order, value number `ν` of the grid belongs to degree `ν`: as many values as degrees, and both
//! transforms (values to Newton's coefficients, those to Chebyshev's) go axis by axis, because every fibre of
//! a lower set starts at zero. A whole grid is a lower set too, so nothing here asks which of the two it has
//! (Chkifa, Cohen and Schwab 2014, sec. 2).

use std::collections::HashMap;

use faer::Mat;

use super::axis::chebyshev_cosine;

/// Degrees `ν`, one per axis, such that with `ν` every smaller one is in the set; in ascending order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LowerSet {
    lengths: Vec<usize>,
    index: Vec<Vec<usize>>,
}

impl LowerSet {
    /// The whole grid if it has at most `most` points, else the largest simplex that has.
    pub(crate) fn new(lengths: &[usize], most: usize) -> LowerSet {
        let (mut low, mut high) = (0.0, lengths.len() as f64);
        let set = |level: f64| {
            let mut index = vec![];
            collect(lengths, level, &mut vec![], &mut index, most);
            index
        };
        let whole = set(high + 1e-9);
        if whole.len() <= most {
            return LowerSet { lengths: lengths.to_vec(), index: whole };
        }
        // 30 halvings tell apart any two levels that differ in a point.
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if set(middle).len() <= most {
                low = middle;
            } else {
                high = middle;
            }
        }
        LowerSet { lengths: lengths.to_vec(), index: set(low) }
    }

    /// The degrees.
    pub(crate) fn index(&self) -> &[Vec<usize>] {
        &self.index
    }

    /// Whether it is the whole grid.
    pub(crate) fn is_whole(&self) -> bool {
        self.lengths.iter().fold(1usize, |n, l| n.saturating_mul(*l)) == self.index.len()
    }

    /// Coefficients in the orthonormal Chebyshev polynomials of the polynomial with these values at the
    /// points of the set; both `(width, n_points)`.
    pub(crate) fn transform_in_place(&self, values: &mut Mat<f64>) {
        let axes: Vec<(Mat<f64>, Mat<f64>)> = self.lengths.iter().map(|n| newton(*n)).collect();
        (0..axes.len()).for_each(|a| self.along(a, &axes[a].0, values));
        (0..axes.len()).for_each(|a| self.along(a, &axes[a].1, values));
    }

    /// Applies a triangular matrix along the fibres of an axis.
    fn along(&self, a: usize, matrix: &Mat<f64>, values: &mut Mat<f64>) {
        let place: HashMap<&[usize], usize> =
            self.index.iter().enumerate().map(|(p, nu)| (nu.as_slice(), p)).collect();
        for start in self.index.iter().filter(|nu| nu[a] == 0) {
            let mut at = start.clone();
            let next = |k: usize| {
                at[a] = k;
                place.get(at.as_slice()).copied()
            };
            let fibre: Vec<usize> = (0..self.lengths[a]).map_while(next).collect();
            let old = Mat::from_fn(values.nrows(), fibre.len(), |i, k| values[(i, fibre[k])]);
            let corner = matrix.as_ref().submatrix(0, 0, fibre.len(), fibre.len());
            let new = super::linalg::product(old.as_ref(), corner.transpose());
            for (k, &p) in fibre.iter().enumerate() {
                values.col_as_slice_mut(p).copy_from_slice(new.col_as_slice(k));
            }
        }
    }
}

/// Appends all degrees below the level; stops one beyond `most`.
fn collect(lengths: &[usize], left: f64, head: &mut Vec<usize>, to: &mut Vec<Vec<usize>>, most: usize) {
    if head.len() == lengths.len() {
        to.push(head.clone());
        return;
    }
    let steps = (lengths[head.len()] - 1).max(1) as f64;
    for k in 0..lengths[head.len()] {
        let rest = left - k as f64 / steps;
        if rest < 0.0 || to.len() > most {
            return;
        }
        head.push(k);
        collect(lengths, rest, head, to, most);
        head.pop();
    }
}

/// Chebyshev points of an axis on [−1, 1], ascending.
fn points(n: usize) -> Vec<f64> {
    (0..n).map(|j| -chebyshev_cosine(j, n)).collect()
}

/// Point numbers in Leja order from the middle: each the farthest from those before it in the product of
/// distances, so that Newton's interpolation is stable at every length.
pub(crate) fn leja_order(n: usize) -> Vec<usize> {
    let x = points(n);
    let mut order = vec![n / 2];
    while order.len() < n {
        let apart = |j: usize| order.iter().map(|&i| (x[j] - x[i]).abs().ln()).sum::<f64>();
        let next = (0..n).filter(|j| !order.contains(j)).max_by(|&i, &j| apart(i).total_cmp(&apart(j)));
        order.extend(next);
    }
    order
}

/// Values in Leja order to divided differences (lower triangular), and those to orthonormal Chebyshev
/// coefficients (upper triangular).
fn newton(n: usize) -> (Mat<f64>, Mat<f64>) {
    let x = points(n);
    let z: Vec<f64> = leja_order(n).into_iter().map(|j| x[j]).collect();
    let difference = |k: usize, l: usize| {
        let others = (0..=k).filter(|&i| i != l);
        if l > k { 0.0 } else { others.map(|i| z[l] - z[i]).product::<f64>().recip() }
    };
    let mut chebyshev = Mat::zeros(n, n);
    chebyshev[(0, 0)] = 1.0;
    for k in 1..n {
        // (x − z) Σ c_m T_m, with x T_m = (T_{m+1} + T_{|m−1|})/2.
        for m in 0..k {
            let c = chebyshev[(m, k - 1)];
            chebyshev[(m, k)] -= z[k - 1] * c;
            chebyshev[(m + 1, k)] += 0.5 * c;
            chebyshev[(m.abs_diff(1), k)] += 0.5 * c;
        }
    }
    let orthonormal = |m: usize| if m == 0 { 1.0 } else { std::f64::consts::FRAC_1_SQRT_2 };
    let scaled = Mat::from_fn(n, n, |m, k| orthonormal(m) * chebyshev[(m, k)]);
    (Mat::from_fn(n, n, difference), scaled)
}

/// Values of the orthonormal Chebyshev polynomials at `x ∈ [−1, 1]`: `T_0`, `√2 T_1`, …
pub(crate) fn orthonormal_chebyshev(n: usize, x: f64) -> Vec<f64> {
    let angle = x.clamp(-1.0, 1.0).acos();
    let value = |k: usize| if k == 0 { 1.0 } else { std::f64::consts::SQRT_2 * (k as f64 * angle).cos() };
    (0..n).map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Random;

    #[test]
    fn a_polynomial_of_the_set_is_found_from_its_values() {
        for most in [60, 10_000] {
            let lengths = [9, 5, 7];
            let set = LowerSet::new(&lengths, most);
            assert_eq!(set.is_whole(), most > 315);
            assert!(set.index().len() <= most && set.index().len() >= 50, "{}", set.index().len());
            let mut random = Random::new(3);
            let wanted = Mat::from_fn(2, set.index().len(), |_, _| random.uniform() - 0.5);
            let tables: Vec<Vec<Vec<f64>>> = lengths
                .iter()
                .map(|&n| leja_order(n).iter().map(|&j| orthonormal_chebyshev(n, points(n)[j])).collect())
                .collect();
            let at = |nu: &[usize], i: usize| -> f64 {
                let basis = |mu: &[usize]| -> f64 { (0..3).map(|a| tables[a][nu[a]][mu[a]]).product() };
                set.index().iter().enumerate().map(|(p, mu)| wanted[(i, p)] * basis(mu)).sum()
            };
            let mut found = Mat::from_fn(2, set.index().len(), |i, p| at(&set.index()[p], i));
            set.transform_in_place(&mut found);
            // Sums of hundreds of terms of size one, Lebesgue constants below ten on each axis.
            assert!((&found - &wanted).norm_max() < 1e-11, "{}", (&found - &wanted).norm_max());
        }
    }

    #[test]
    fn every_fibre_starts_at_zero_and_sets_are_nested() {
        let (small, large) = (LowerSet::new(&[8, 8, 14], 100), LowerSet::new(&[8, 8, 14], 200));
        assert!(small.index().iter().all(|nu| large.index().contains(nu)));
        for nu in large.index() {
            for a in (0..3).filter(|&a| nu[a] > 0) {
                let mut below = nu.clone();
                below[a] -= 1;
                assert!(large.index().contains(&below));
            }
        }
    }
}
