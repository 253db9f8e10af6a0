//! From a POD to the basis the vademecum uses: M-orthonormal, and diagonal where that is possible.

use faer::{Mat, MatRef};

use super::pod::{Apply, Pod, gram, lower_gram_factor, weighted_svd};
use crate::linalg::symmetric_eigen;
use crate::linalg::{NoConvergence, symmetric_part};
use crate::store::{Inputs, StageInput};

/// The basis of a vademecum.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Basis {
    /// `B`, shape (n, r), `BᵀMB = I`, most energetic first.
    #[serde(with = "crate::linalg::stored")]
    pub vectors: Mat<f64>,
    /// `BᵀKB`, shape (r, r) \[rad²/s²\].
    #[serde(with = "crate::linalg::stored")]
    pub stiffness: Mat<f64>,
    /// Its diagonal where `BᵀKB` is diagonal (Ritz vectors, natural modes).
    pub eigenvalues: Option<Vec<f64>>,
    /// Fraction of the snapshot energy in each coordinate, length r; empty for natural modes without
    /// snapshots.
    pub energy: Vec<f64>,
    /// Singular values of the POD below it.
    pub singular_values: Vec<f64>,
}

impl Basis {
    /// Number of modes r.
    pub fn n_modes(&self) -> usize {
        self.vectors.ncols()
    }

    /// Rayleigh quotient φᵀKφ ÷ φᵀMφ of each mode \[rad²/s²\].
    pub fn quotients(&self) -> Vec<f64> {
        (0..self.n_modes()).map(|k| self.stiffness[(k, k)]).collect()
    }
}

/// Its provenance is not part of the address.
impl StageInput for Basis {
    fn add_to(&self, inputs: Inputs) -> Inputs {
        inputs.matrix(self.vectors.as_ref()).matrix(self.stiffness.as_ref()).value(&self.eigenvalues)
    }
}

/// The chapter's basis: the `count` leading POD vectors, made M-orthonormal without leaving their span.
///
/// # Errors
/// [`NoConvergence`]: matrices or snapshots outside the range of double precision.
pub fn pod_basis(
    mass: Apply<'_>,
    stiffness: Apply<'_>,
    pod: &Pod,
    count: usize,
) -> Result<Basis, NoConvergence> {
    let leading = pod.vectors.subcols(0, count.min(pod.vectors.ncols()));
    let (vectors, lower) = mass_orthonormal(mass, leading)?;
    let energy = coordinate_energy(lower.transpose().to_owned().as_ref(), pod);
    let stiffness = symmetric_gram(stiffness, vectors.as_ref());
    let singular_values = pod.singular_values.clone();
    Ok(Basis { vectors, stiffness, eigenvalues: None, energy, singular_values })
}

/// Ritz vectors of the carrier `[V, K⁻¹MV]`, with `V` the `oversampling × count` leading POD vectors; the
/// `count` that carry most snapshot energy stay.
///
/// `BᵀKB` is diagonalised inside a space larger than the basis, so what is kept is nearly invariant under the
/// dynamics and little leaks out of it step by step. `V` alone is not enough: under a point load the POD
/// holds local, stiff shapes in addition to every mode, and what they leave in a Ritz vector shifts its
/// frequency; `static_response` (`K⁻¹M x`) damps them by their eigenvalue
/// (`docs/explanation/why-these-defaults.md`).
///
/// # Errors
/// [`NoConvergence`]: matrices or snapshots outside the range of double precision.
pub fn ritz_basis(
    mass: Apply<'_>,
    stiffness: Apply<'_>,
    static_response: Apply<'_>,
    pod: &Pod,
    count: usize,
    oversampling: usize,
) -> Result<Basis, NoConvergence> {
    let width = (count * oversampling).min(pod.vectors.ncols());
    let carrier = carrier(mass, static_response, pod.vectors.subcols(0, width))?;
    let carried = symmetric_gram(stiffness, carrier.as_ref());
    let (values, rotation) = symmetric_eigen(carried.as_ref())?;
    let coordinates = rotation.transpose() * gram(mass, carrier.as_ref(), pod.vectors.subcols(0, width));
    let energy = coordinate_energy(coordinates.as_ref(), pod);
    let kept = most_energetic(&energy, count.min(width));
    let mut chosen = Mat::zeros(carrier.ncols(), kept.len());
    for (j, &k) in kept.iter().enumerate() {
        chosen.col_mut(j).copy_from(rotation.col(k));
    }
    let eigenvalues: Vec<f64> = kept.iter().map(|&k| values[k]).collect();
    Ok(Basis {
        vectors: fix_signs(carrier * chosen),
        stiffness: Mat::from_fn(kept.len(), kept.len(), |i, j| if i == j { eigenvalues[i] } else { 0.0 }),
        eigenvalues: Some(eigenvalues),
        energy: kept.iter().map(|&k| energy[k]).collect(),
        singular_values: pod.singular_values.clone(),
    })
}

/// M-orthonormal basis of `[V, K⁻¹MV]`; directions both parts share to eight digits count once.
fn carrier(
    mass: Apply<'_>,
    static_response: Apply<'_>,
    vectors: MatRef<'_, f64>,
) -> Result<Mat<f64>, NoConvergence> {
    const DEPENDENT: f64 = 1e-8;
    let (n, width) = (vectors.nrows(), vectors.ncols());
    let (orthonormal, _) = mass_orthonormal(mass, vectors)?;
    let mut columns = Mat::zeros(n, 2 * width);
    columns.subcols_mut(0, width).copy_from(&orthonormal);
    static_response(orthonormal.as_ref(), columns.subcols_mut(width, width));
    let norms = gram(mass, columns.subcols(width, width), columns.subcols(width, width));
    for j in 0..width {
        let scale = 1.0 / norms[(j, j)].sqrt();
        columns.col_mut(width + j).iter_mut().for_each(|v| *v *= scale);
    }
    let (vectors, values) = weighted_svd(mass, columns.as_ref())?;
    let rank = values.iter().take_while(|&&s| s > DEPENDENT * values[0]).count();
    Ok(mass_orthonormal(mass, vectors.subcols(0, rank))?.0)
}

/// The same subspace in Ritz coordinates, in which `BᵀKB` is diagonal.
///
/// `eigenvalues` stays empty: the basis is made for many stiffnesses and diagonal for one.
///
/// # Errors
/// [`NoConvergence`]: a stiffness that is not finite.
pub(crate) fn ritz_coordinates(basis: Basis) -> Result<Basis, NoConvergence> {
    let (values, rotation) = symmetric_eigen(basis.stiffness.as_ref())?;
    let r = values.len();
    let energy = (0..r).map(|k| (0..r).map(|j| rotation[(j, k)].powi(2) * basis.energy[j]).sum()).collect();
    Ok(Basis {
        vectors: fix_signs(&basis.vectors * &rotation),
        stiffness: Mat::from_fn(r, r, |i, j| if i == j { values[i] } else { 0.0 }),
        energy,
        ..basis
    })
}

/// Natural modes as a basis: `vectors` are M-orthonormal with eigenvalues `values`.
pub fn modes_basis(vectors: Mat<f64>, values: Vec<f64>) -> Basis {
    let r = values.len();
    Basis {
        vectors: fix_signs(vectors),
        stiffness: Mat::from_fn(r, r, |i, j| if i == j { values[i] } else { 0.0 }),
        eigenvalues: Some(values),
        energy: vec![],
        singular_values: vec![],
    }
}

/// `(V L⁻ᵀ, L)` with `VᵀMV = L Lᵀ`, orthonormalised twice: the second pass removes what the condition of the
/// first cost.
fn mass_orthonormal(
    mass: Apply<'_>,
    vectors: MatRef<'_, f64>,
) -> Result<(Mat<f64>, Mat<f64>), NoConvergence> {
    let mut result = vectors.to_owned();
    let mut lower = Mat::<f64>::identity(vectors.ncols(), vectors.ncols());
    for _ in 0..2 {
        let factor = lower_gram_factor(mass, result.as_ref())?;
        let mut transposed = result.transpose().to_owned();
        factor.solve_lower_triangular_in_place(transposed.as_mut());
        result = transposed.transpose().to_owned();
        lower = lower * factor;
    }
    Ok((result, lower))
}

/// Fraction of the snapshot energy in each row of `coordinates` (rows: coordinates, columns: leading POD
/// vectors).
fn coordinate_energy(coordinates: MatRef<'_, f64>, pod: &Pod) -> Vec<f64> {
    let energy = |i: usize| -> f64 {
        (0..coordinates.ncols()).map(|j| (coordinates[(i, j)] * pod.singular_values[j]).powi(2)).sum()
    };
    let energies: Vec<f64> = (0..coordinates.nrows()).map(energy).collect();
    let total: f64 = energies.iter().sum();
    energies.iter().map(|e| if total > 0.0 { e / total } else { 0.0 }).collect()
}

/// Indices of the `count` largest values, largest first; ties by index.
fn most_energetic(energy: &[f64], count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..energy.len()).collect();
    order.sort_by(|&a, &b| energy[b].total_cmp(&energy[a]).then(a.cmp(&b)));
    order.truncate(count);
    order
}

/// The largest entry of each column is made positive, so that the same subspace gives the same file.
fn fix_signs(mut vectors: Mat<f64>) -> Mat<f64> {
    for column in vectors.col_iter_mut() {
        let mut column = column;
        let largest =
            column.as_ref().iter().copied().fold(0.0_f64, |a, b| if b.abs() > a.abs() { b } else { a });
        if largest < 0.0 {
            column.as_mut().iter_mut().for_each(|v| *v = -*v);
        }
    }
    vectors
}

/// Exactly symmetric `VᵀWV`.
fn symmetric_gram(operator: Apply<'_>, vectors: MatRef<'_, f64>) -> Mat<f64> {
    symmetric_part(gram(operator, vectors, vectors).as_ref())
}
