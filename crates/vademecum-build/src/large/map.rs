//! The reduced Green–Lagrange strain, quadratic in the coordinates, and its rows in a file.
//!
//! The strain of St. Venant and Kirchhoff is quadratic in the displacement, so over a basis
//!
//! ```text
//! z(q) = A_l q + A_q m(q)        V(q) = ½ |z(q)|²
//! ```
//!
//! with `m` the products of coordinates that interact. With `VᵀMV = I` and `VᵀKV = diag(ω²)` the columns
//! `U = A_l diag(1/ω)` are orthonormal, and the energy depends on `UᵀA_q` and on the Gram matrix of what is
//! left of `A_q` alone. So a few rows hold it: one for each coordinate, exact in the linear and the cubic
//! terms, and as many more as the rest of the quartic term needs.

use faer::{Mat, MatRef};

use crate::linalg::symmetric_eigen;
use crate::linalg::{NoConvergence, Random, product, symmetric_part};

/// Products of coordinates: each pair once, in the order of its first coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Pairs {
    /// Coordinates whose products all count.
    pub(crate) interacting: usize,
}

impl Pairs {
    /// The pairs `(a, b)`, `a ≤ b`.
    pub fn iter(self) -> impl Iterator<Item = (usize, usize)> {
        let n = self.interacting;
        (0..n).flat_map(move |a| (a..n).map(move |b| (a, b)))
    }

    /// Their number.
    pub fn count(self) -> usize {
        let n = self.interacting;
        n * (n + 1) / 2
    }

    /// The products of coordinates.
    pub fn products(self, q: &[f64]) -> Vec<f64> {
        self.iter().map(|(a, b)| q[a] * q[b]).collect()
    }

    /// The same of coordinates that stand in columns, one state a column.
    pub(crate) fn products_of(self, q: MatRef<'_, f64>) -> Mat<f64> {
        let pairs: Vec<_> = self.iter().collect();
        Mat::from_fn(pairs.len(), q.ncols(), |j, s| q[(pairs[j].0, s)] * q[(pairs[j].1, s)])
    }
}

/// A reduced Green–Lagrange strain by rows: `z_k = ω_k q_k + Q_k · m(q)` for `k < R`, `Q_k · m(q)` after.
#[derive(Clone, Debug)]
#[doc(alias("strain map", "reduced Green-Lagrange strain"))]
pub(crate) struct ReducedStrain {
    /// `ω`, one for each coordinate \[rad/s\].
    pub(crate) frequencies: Vec<f64>,
    /// The products that count.
    pub(crate) pairs: Pairs,
    /// `Q`, shape (rows, products).
    pub(crate) quadratic: Mat<f64>,
}

/// Gram matrix of full strains, from which the rows of a reduced strain are selected.
#[derive(Clone, Debug)]
pub(crate) struct StrainGram {
    /// `ω`.
    pub(crate) frequencies: Vec<f64>,
    /// The products that count.
    pub(crate) pairs: Pairs,
    /// `UᵀA_q`, shape (R, products).
    pub(crate) top: Mat<f64>,
    /// `A_qᵀA_q`, shape (products, products).
    pub(crate) gram: Mat<f64>,
}

impl StrainGram {
    /// The rows: one for each coordinate and `extra` more, those that hold most of the rest on `states`
    /// (their coordinates, one a column). What is left out only lowers the energy. Where more rows are asked
    /// for than the states could choose, they are those that hold most of the rest by itself.
    ///
    /// # Errors
    /// [`NoConvergence`].
    pub(crate) fn rows(&self, states: MatRef<'_, f64>, extra: usize) -> Result<ReducedStrain, NoConvergence> {
        let Self { top, gram, pairs, .. } = self;
        let (r, extra) = (top.nrows(), extra.min(pairs.count()));
        let rest = symmetric_part((gram - product(top.transpose(), top.as_ref())).as_ref());
        let beside = if 2 * extra <= states.ncols() && 2 * extra <= pairs.count() {
            rows_on_states(rest.as_ref(), pairs.products_of(states).as_ref(), extra)?
        } else {
            let (squares, axes) = symmetric_eigen(rest.as_ref())?;
            // Eigenvalues ascend.
            let of = |k: usize| squares.len() - 1 - k;
            Mat::from_fn(extra, squares.len(), |k, j| squares[of(k)].max(0.0).sqrt() * axes[(j, of(k))])
        };
        let mut quadratic = Mat::zeros(r + extra, pairs.count());
        quadratic.subrows_mut(0, r).copy_from(top);
        quadratic.subrows_mut(r, extra).copy_from(&beside);
        Ok(ReducedStrain { frequencies: self.frequencies.clone(), pairs: *pairs, quadratic })
    }
}

/// The rows of `C`, with `CᵀC` the rest, along the principal directions of `C P`, the products of states a
/// column. With `y` the right singular vectors of `C P` and `σ` its singular values they are
/// `(CᵀC P y / σ)ᵀ`, which needs no `C`. The vectors come from a few block iterations on `PᵀCᵀC P`; however
/// far these have converged, the directions are orthonormal.
fn rows_on_states(
    rest: MatRef<'_, f64>,
    products: MatRef<'_, f64>,
    count: usize,
) -> Result<Mat<f64>, NoConvergence> {
    const ITERATIONS: usize = 6;
    /// Below this part of the largest square a direction is rounding.
    const MIN_SQUARE: f64 = 1e-13;
    let n = products.ncols();
    let weighted = product(rest, products);
    let image = |x: MatRef<'_, f64>| product(products.transpose(), product(weighted.as_ref(), x).as_ref());
    let mut random = Random::new(1);
    let mut x = Mat::from_fn(n, (count + count / 2 + 8).min(n), |_, _| random.uniform() - 0.5);
    for _ in 0..ITERATIONS {
        x = image(x.as_ref()).qr().compute_thin_Q();
    }
    let spread = symmetric_part(product(x.transpose(), image(x.as_ref()).as_ref()).as_ref());
    let (squares, axes) = symmetric_eigen(spread.as_ref())?;
    let last = squares.len() - 1;
    let scaled = Mat::from_fn(last + 1, count, |i, k| match squares[last - k] {
        square if square > MIN_SQUARE * squares[last] => axes[(i, last - k)] / square.sqrt(),
        _ => 0.0,
    });
    let vectors = product(x.as_ref(), scaled.as_ref());
    Ok(product(weighted.as_ref(), vectors.as_ref()).transpose().to_owned())
}
