//! The stage responses at one point of the box, in the full space or in a compressed one.
//!
//! Loads need `Z = (M + θK)⁻¹ M₀ B − B` (reciprocity: its rows), the state needs `E = BᵀM₀ X`. With regions
//! live the eigenvectors turn with the contrast and a fixed basis `B` cannot follow: taking `u = Bζ` for the
//! state misplaces what `B` does not span, and frequencies shift. So the state is lifted at the parameters
//! themselves,
//!
//! ```text
//! u = B̃ ζ,   B̃ = G²B (BᵀM₀ G²B)⁻¹,   G = K⁻¹M        X = −(M + θK)⁻¹ θK B̃
//! ```
//!
//! `G²B` is two steps of inverse iteration from `B`: nearly invariant there, rational in the parameters, and
//! normalised so that `BᵀM₀B̃ = I`, which leaves every formula of the fused step as it is
//! (`docs/explanation/why-these-defaults.md`).

use faer::linalg::solvers::DenseSolveCore as _;
use faer::{Mat, MatRef};

use super::axis_map::{AxisMap, weights};
use super::error::ParametricError;
use crate::fem::{Pencil, Solve, Symbolic, SymmetricMatrix};
use crate::parallel;
use crate::progress::Listener;
use crate::separated::{DenseSpace, Energy, SeparatedError, Space, compress};

/// Steps of inverse iteration from `B` to the lifted basis.
const INVERSE_ITERATIONS: usize = 2;

/// The operators of a pencil, factorised with its own symbolic analysis.
pub(super) struct PencilSpace<'a> {
    matrices: Vec<&'a SymmetricMatrix>,
    symbolic: &'a Symbolic,
}

impl Space for PencilSpace<'_> {
    fn n_rows(&self) -> usize {
        self.matrices[0].n()
    }

    fn n_operators(&self) -> usize {
        self.matrices.len()
    }

    fn apply(&self, t: usize, block: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(block.nrows(), block.ncols());
        self.matrices[t].mul_into(block, out.as_mut());
        out
    }

    fn solve(&self, weights: &[f64], rhs: MatRef<'_, f64>) -> Result<Mat<f64>, SeparatedError> {
        let parts: Vec<(f64, &SymmetricMatrix)> =
            weights.iter().copied().zip(self.matrices.iter().copied()).collect();
        let factor = self.symbolic.factorize(SymmetricMatrix::combine(&parts)).map_err(|_| {
            SeparatedError::NotPositiveDefinite { what: "stage matrix at a parameter sample" }
        })?;
        let mut x = rhs.to_owned();
        Solve::new(self.symbolic, x.ncols(), true).solve_in_place(&factor, x.as_mut());
        Ok(x)
    }
}

/// The problem in one space, full or compressed: operators, basis and `M₀ B` in its coordinates.
pub(super) struct Responses<'a, S> {
    pub(super) space: S,
    pub(super) map: &'a AxisMap,
    pub(super) basis: Mat<f64>,
    pub(super) weighted: Mat<f64>,
    /// `s_k`, see [`mode_scales`]; states are separated as `S⁻¹ E S⁻¹`.
    pub(super) scales: Vec<f64>,
    /// Whether the state is lifted; without live regions `B̃ = B` for every basis that a build makes.
    pub(super) lift: bool,
}

/// What is separated at one point.
pub(super) struct Response {
    /// `Z`, shape (n, r).
    pub(super) load: Mat<f64>,
    /// `S⁻¹ E S⁻¹`, shape (r, r).
    pub(super) state: Mat<f64>,
    /// Other vectors a compressed space must hold to find the same.
    auxiliary: Vec<Mat<f64>>,
}

impl<S: Space> Responses<'_, S> {
    fn apply(&self, weights: &[f64], range: std::ops::Range<usize>, block: MatRef<'_, f64>) -> Mat<f64> {
        let mut sum = Mat::zeros(block.nrows(), block.ncols());
        for t in range {
            sum += self.space.apply(t, block) * faer::Scale(weights[t]);
        }
        sum
    }

    /// `S⁻¹ E S⁻¹`.
    pub(super) fn scaled(&self, state: Mat<f64>) -> Mat<f64> {
        Mat::from_fn(state.nrows(), state.ncols(), |i, j| state[(i, j)] / (self.scales[i] * self.scales[j]))
    }

    /// The response at a point on the axes.
    pub(super) fn at(&self, point: &[f64]) -> Result<Response, SeparatedError> {
        let regions = self.map.n_regions;
        let (masses, stiffnesses) = (0..regions, regions..2 * regions);
        let weights = weights(self.map, point);
        let mut stiffness_only = weights.clone();
        stiffness_only[..regions].fill(0.0);
        let mass = |x: &Mat<f64>| self.apply(&weights, masses.clone(), x.as_ref());
        let stiffness = |x: &Mat<f64>| self.apply(&weights, stiffnesses.clone(), x.as_ref());
        let static_response = |x: &Mat<f64>| self.space.solve(&stiffness_only, mass(x).as_ref());

        if !self.lift {
            // M₀B − M(ρ)B vanishes without live densities; the rest is the increment, not a difference of
            // large numbers.
            let mut rhs = &self.weighted - mass(&self.basis);
            rhs -= stiffness(&self.basis);
            let load = self.space.solve(&weights, rhs.as_ref())?;
            let state = self.scaled(self.weighted.transpose() * &load);
            return Ok(Response { load, state, auxiliary: vec![] });
        }
        let mut lifted = self.basis.clone();
        let mut auxiliary = vec![];
        for _ in 0..INVERSE_ITERATIONS {
            let next = static_response(&lifted)?;
            // Normalised at every step: the columns would all turn to the lowest modes otherwise.
            lifted = &next * (self.weighted.transpose() * &next).partial_piv_lu().inverse();
            auxiliary.push(normalised(next));
        }
        let reduced_mass = lifted.transpose() * mass(&lifted);
        let reduced_stiffness = lifted.transpose() * stiffness(&lifted);
        let inverse = (&reduced_mass + &reduced_stiffness).partial_piv_lu().inverse();
        let state = self.scaled(&inverse * reduced_stiffness * faer::Scale(-1.0));
        let load = &lifted * inverse - &self.basis;
        Ok(Response { load, state, auxiliary })
    }
}

/// `s_k² = x/(1 + x)` with `x = θλ_k` at the middle θ: the size of mode k's entry of `E`.
///
/// `E` spans the decades between the lowest and the highest mode. An error of 1e-6 of its norm is one of 1e-2
/// of the entry of a mode with `θλ = 1e-4`, and shifts that mode's frequency by half as much; scaled, every
/// mode gets the tolerance.
pub(super) fn mode_scales(stiffness: MatRef<'_, f64>, theta: (f64, f64)) -> Vec<f64> {
    let middle = (theta.0 * theta.1).sqrt();
    let scale = |k: usize| {
        let x = middle * stiffness[(k, k)];
        (x / (1.0 + x)).sqrt()
    };
    (0..stiffness.nrows()).map(scale).collect()
}

/// Columns scaled to unit length: only their span counts.
fn normalised(mut block: Mat<f64>) -> Mat<f64> {
    for j in 0..block.ncols() {
        let length = block.col(j).norm_l2();
        block.col_as_slice_mut(j).iter_mut().for_each(|v| *v /= length);
    }
    block
}

/// Operators of all regions over the free dofs.
pub(super) fn full_space<'a>(pencil: &'a Pencil, symbolic: &'a Symbolic, regions: usize) -> PencilSpace<'a> {
    let masses = (0..regions).map(|q| pencil.region_mass(q));
    PencilSpace {
        matrices: masses.chain((0..regions).map(|q| pencil.region_stiffness(q))).collect(),
        symbolic,
    }
}

/// An M-orthonormal basis that holds `B`, the responses at all points and what they are made of.
pub(super) fn compressed_basis(
    full: &Responses<'_, PencilSpace<'_>>,
    points: &[Vec<f64>],
    energy: &Energy<'_>,
    tolerance: f64,
    listener: &dyn Listener,
) -> Result<Mat<f64>, ParametricError> {
    let mut blocks = vec![full.basis.clone()];
    // A few points at a time: their blocks are as long as the mesh is large.
    for (i, chunk) in points.chunks(2 * rayon::current_num_threads()).enumerate() {
        let responses = parallel::try_map(chunk.len(), &|at| full.at(&chunk[at]))?;
        for response in responses {
            blocks.push(response.load);
            blocks.extend(response.auxiliary);
        }
        listener.checkpoint(i * chunk.len(), points.len())?;
    }
    Ok(compress(&blocks, energy, 0.02 * tolerance)?)
}

/// The same problem in the coordinates of a compressed basis.
pub(super) fn compressed<'a>(
    full: &Responses<'a, PencilSpace<'_>>,
    vectors: &Mat<f64>,
) -> Result<Responses<'a, DenseSpace>, SeparatedError> {
    let project = |t: usize| {
        let product = vectors.transpose() * full.space.apply(t, vectors.as_ref());
        Mat::from_fn(product.nrows(), product.ncols(), |i, j| 0.5 * (product[(i, j)] + product[(j, i)]))
    };
    Ok(Responses {
        space: DenseSpace::new((0..full.space.n_operators()).map(project).collect())?,
        map: full.map,
        // UᵀMU = I, so coordinates of B and the image M₀B in U are one matrix.
        basis: vectors.transpose() * &full.weighted,
        weighted: vectors.transpose() * &full.weighted,
        scales: full.scales.clone(),
        lift: full.lift,
    })
}
