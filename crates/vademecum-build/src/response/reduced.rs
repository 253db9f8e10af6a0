//! The fused reduced step in its two structures, as the evaluator will march it, for certificates and
//! comparisons.

use faer::{Mat, MatRef};
use vademecum_format::scheme::SchemeTable;
use vademecum_format::scheme::{StepParameters, TableError, fuse_into, fuse_work_len, theta};

use super::stage::{StageResponse, galerkin_increment};
use crate::linalg::project;

/// `y ← y + D y + Σ_i L_i g_i p_i` on the state `y = (ζ, Δt ζ̇, Δt² ζ̈)` of length 3r.
pub trait FusedStep {
    /// Number of modes r.
    fn n_modes(&self) -> usize;
    /// `H_iᵀF` for each stage: what a force over the free dofs is to the step.
    fn load_response(&self, force: &[f64]) -> Vec<Vec<f64>>;
    /// Adds `Σ_i p_i L_i g_i` to `target`, length 3r.
    fn add_load(&self, responses: &[Vec<f64>], amplitudes: &[f64], target: &mut [f64]);
    /// One step; `work` has the length of `y`.
    fn step(&self, y: &mut [f64], load: &[f64], work: &mut [f64]);
    /// Largest modulus of the eigenvalues of `I + D`.
    fn spectral_radius(&self) -> f64;
}

/// The block structure: a dense map.
pub struct BlockStep<'a> {
    basis: MatRef<'a, f64>,
    responses: &'a [StageResponse],
    /// `D`, shape (3r, 3r).
    increment: Mat<f64>,
    /// `L_i`, shape (3r, r), one per stage.
    load_maps: Vec<Mat<f64>>,
}

impl<'a> BlockStep<'a> {
    /// Fuses the stages.
    ///
    /// # Errors
    /// If the table or a parameter is unusable.
    pub fn fuse(
        table: &SchemeTable,
        parameters: &StepParameters,
        basis: MatRef<'a, f64>,
        responses: &'a [StageResponse],
    ) -> Result<Self, TableError> {
        let r = basis.ncols();
        let states: Vec<Mat<f64>> = responses.iter().map(|s| s.state.clone()).collect();
        let (increment, loads) = fuse(table, parameters, r, &states)?;
        let map = |values: &[f64]| MatRef::from_column_major_slice(values, 3 * r, r).to_owned();
        let load_maps = loads.chunks_exact(3 * r * r).map(map).collect();
        Ok(Self { basis, responses, increment, load_maps })
    }
}

impl FusedStep for BlockStep<'_> {
    fn n_modes(&self) -> usize {
        self.basis.ncols()
    }

    fn load_response(&self, force: &[f64]) -> Vec<Vec<f64>> {
        let base = project(self.basis, force);
        let response = |stage: &StageResponse| {
            let increment = project(stage.increment.as_ref(), force);
            base.iter().zip(increment).map(|(b, i)| b + i).collect()
        };
        self.responses.iter().map(response).collect()
    }

    fn add_load(&self, responses: &[Vec<f64>], amplitudes: &[f64], target: &mut [f64]) {
        for ((map, g), &p) in self.load_maps.iter().zip(responses).zip(amplitudes) {
            for (j, &value) in g.iter().enumerate() {
                let column = map.col_as_slice(j);
                target.iter_mut().zip(column).for_each(|(t, m)| *t += p * value * m);
            }
        }
    }

    fn step(&self, y: &mut [f64], load: &[f64], work: &mut [f64]) {
        work.copy_from_slice(load);
        for (j, &value) in y.iter().enumerate() {
            let column = self.increment.col_as_slice(j);
            work.iter_mut().zip(column).for_each(|(w, d)| *w += d * value);
        }
        y.iter_mut().zip(work).for_each(|(y, w)| *y += *w);
    }

    fn spectral_radius(&self) -> f64 {
        radius_of_increment(&self.increment)
    }
}

/// The diagonal structure: one 3 × 3 map per mode.
pub struct DiagonalStep<'a> {
    basis: MatRef<'a, f64>,
    /// `1 + e_ik = 1/(1 + θ_i λ_k)`, one list per stage.
    weights: Vec<Vec<f64>>,
    /// `D` of each mode, column-major.
    increments: Vec<[f64; 9]>,
    /// `L_i` of each mode, one after the other.
    load_maps: Vec<Vec<[f64; 3]>>,
}

impl<'a> DiagonalStep<'a> {
    /// Fuses the stages mode by mode.
    ///
    /// # Errors
    /// If the table or a parameter is unusable.
    pub fn fuse(
        table: &SchemeTable,
        parameters: &StepParameters,
        basis: MatRef<'a, f64>,
        eigenvalues: &[f64],
    ) -> Result<Self, TableError> {
        let n_stages = table.active().len();
        let thetas = (0..n_stages).map(|i| theta(table, parameters, i)).collect::<Result<Vec<f64>, _>>()?;
        let mut step = Self { basis, weights: vec![vec![]; n_stages], increments: vec![], load_maps: vec![] };
        let mut work = vec![0.0; fuse_work_len(1)];
        for &eigenvalue in eigenvalues {
            let e: Vec<f64> = thetas.iter().map(|&t| galerkin_increment(t, eigenvalue)).collect();
            step.weights.iter_mut().zip(&e).for_each(|(w, e)| w.push(1.0 + e));
            let mut increment = [0.0; 9];
            let mut loads = vec![0.0; 3 * n_stages];
            fuse_into(table, parameters, 1, &e, &mut increment, &mut loads, &mut work)?;
            step.increments.push(increment);
            step.load_maps.push(loads.as_chunks().0.to_vec());
        }
        Ok(step)
    }
}

impl FusedStep for DiagonalStep<'_> {
    fn n_modes(&self) -> usize {
        self.basis.ncols()
    }

    fn load_response(&self, force: &[f64]) -> Vec<Vec<f64>> {
        let base = project(self.basis, force);
        self.weights.iter().map(|weights| base.iter().zip(weights).map(|(b, w)| b * w).collect()).collect()
    }

    fn add_load(&self, responses: &[Vec<f64>], amplitudes: &[f64], target: &mut [f64]) {
        let r = self.n_modes();
        for (k, maps) in self.load_maps.iter().enumerate() {
            for ((map, g), &p) in maps.iter().zip(responses).zip(amplitudes) {
                (0..3).for_each(|row| target[row * r + k] += p * g[k] * map[row]);
            }
        }
    }

    fn step(&self, y: &mut [f64], load: &[f64], _: &mut [f64]) {
        let r = self.n_modes();
        for (k, d) in self.increments.iter().enumerate() {
            let old = [y[k], y[r + k], y[2 * r + k]];
            for row in 0..3 {
                let moved: f64 = (0..3).map(|column| d[3 * column + row] * old[column]).sum();
                y[row * r + k] = old[row] + (moved + load[row * r + k]);
            }
        }
    }

    fn spectral_radius(&self) -> f64 {
        let radius = |d: &[f64; 9]| {
            let matrix = MatRef::from_column_major_slice(d, 3, 3);
            let eigenvalues = matrix.eigenvalues().expect("a finite matrix has eigenvalues");
            eigenvalues.iter().map(|l| (1.0 + l.re).hypot(l.im)).fold(0.0, f64::max)
        };
        self.increments.iter().map(radius).fold(0.0, f64::max)
    }
}

/// Spectral radius of the fused step of the given `E_i = C_i − I`, shape (r, r), one per stage.
///
/// # Errors
/// If the table or a parameter is unusable.
pub fn fused_radius(
    table: &SchemeTable,
    parameters: &StepParameters,
    states: &[Mat<f64>],
) -> Result<f64, TableError> {
    let r = states.first().map_or(0, Mat::nrows);
    Ok(radius_of_increment(&fuse(table, parameters, r, states)?.0))
}

/// `(D, L)`: the increment map, shape (3r, 3r), and the load maps one after the other, from row-major states.
fn fuse(
    table: &SchemeTable,
    parameters: &StepParameters,
    r: usize,
    states: &[Mat<f64>],
) -> Result<(Mat<f64>, Vec<f64>), TableError> {
    let packed: Vec<f64> = states.iter().flat_map(|s| (0..r * r).map(|k| s[(k / r, k % r)])).collect();
    let mut increment = vec![0.0; 9 * r * r];
    let mut loads = vec![0.0; states.len() * 3 * r * r];
    let mut work = vec![0.0; fuse_work_len(r)];
    fuse_into(table, parameters, r, &packed, &mut increment, &mut loads, &mut work)?;
    Ok((MatRef::from_column_major_slice(&increment, 3 * r, 3 * r).to_owned(), loads))
}

/// From the eigenvalues of `D`, so that those of `I + D` near 1 keep their digits.
fn radius_of_increment(increment: &Mat<f64>) -> f64 {
    let eigenvalues = increment.eigenvalues().expect("a finite matrix has eigenvalues");
    eigenvalues.iter().map(|l| (1.0 + l.re).hypot(l.im)).fold(0.0, f64::max)
}

/// Largest modulus of the eigenvalues of a step map `T`, shape (n, n), column-major.
pub fn spectral_radius(n: usize, map: &[f64]) -> f64 {
    let eigenvalues =
        MatRef::from_column_major_slice(map, n, n).eigenvalues().expect("a finite matrix has eigenvalues");
    eigenvalues.iter().map(|l| l.re.hypot(l.im)).fold(0.0, f64::max)
}
