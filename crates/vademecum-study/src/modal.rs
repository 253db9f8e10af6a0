//! The reduced equation of motion of a file, `M_r ζ̈ + C_r ζ̇ + K_r ζ = Bᵀ F`, its modes and its response to
//! a harmonic force.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, c64};
use vademecum_build::linalg::{eigenvalues, solve_dense, symmetric_eigen};
use vademecum_eval::SceneOptions;
use vademecum_format::{File, SectionKind};

use crate::contents::numbers;
use crate::error::FileError;

/// The reduced equation of motion at some options.
pub(crate) struct ModalModel {
    pub(crate) mass: Mat<f64>,
    pub(crate) damping: Mat<f64>,
    pub(crate) stiffness: Mat<f64>,
    /// True if all three are diagonal.
    diagonal: bool,
    /// True if dashpots couple the modes.
    coupled: bool,
}

impl ModalModel {
    pub(crate) fn of(file: &File<'_>, options: &SceneOptions) -> Result<Self, FileError> {
        use SectionKind as S;
        let (metadata, r) = (file.metadata(), file.metadata().n_modes as usize);
        let (alpha, beta) = (options.alpha.unwrap_or(metadata.alpha), options.beta.unwrap_or(metadata.beta));
        let ritz_values = numbers(file, S::Eigenvalues)?;
        let moved = |scales: &[f64]| scales.iter().any(|&scale| scale != 1.0);
        let sum = |kind: SectionKind, scales: &[f64]| -> Result<Mat<f64>, FileError> {
            let parts = numbers(file, kind)?;
            if parts.is_empty() {
                return Err(FileError::Missing { kind });
            }
            let part = |q: usize, i: usize, j: usize| scales[q] * parts[(q * r + i) * r + j];
            Ok(Mat::from_fn(r, r, |i, j| (0..parts.len() / (r * r)).map(|q| part(q, i, j)).sum()))
        };
        let mut diagonal = true;
        let stiffness = if moved(options.regions.stiffness()) {
            diagonal = false;
            sum(S::RegionStiffness, options.regions.stiffness())?
        } else if ritz_values.len() == r {
            Mat::from_fn(r, r, |i, j| if i == j { ritz_values[i] } else { 0.0 })
        } else {
            diagonal = false;
            let whole = numbers(file, S::ReducedStiffness)?;
            if whole.len() != r * r {
                return Err(FileError::Missing { kind: S::ReducedStiffness });
            }
            Mat::from_fn(r, r, |i, j| whole[i * r + j])
        };
        let mass = if moved(options.regions.density()) {
            diagonal = false;
            sum(S::RegionMass, options.regions.density())?
        } else {
            Mat::identity(r, r)
        };
        let (stiffness, mass) = (options.stiffness * stiffness, options.density * mass);
        let mut damping = alpha * &mass + beta * &stiffness;
        // A damping ratio belongs to a mode, whatever its frequency is now.
        for (k, ratio) in numbers(file, S::DampingRatios)?.into_iter().enumerate() {
            damping[(k, k)] += 2.0 * ratio * (stiffness[(k, k)] * mass[(k, k)]).sqrt();
        }
        let rows = numbers(file, S::DampingRows)?;
        let coupled = !rows.is_empty();
        for d in rows.chunks_exact(r) {
            for (i, j) in (0..r).flat_map(|i| (0..r).map(move |j| (i, j))) {
                damping[(i, j)] += d[i] * d[j];
            }
        }
        Ok(Self { mass, damping, stiffness, diagonal: diagonal && !coupled, coupled })
    }

    /// Natural frequency `ω` \[rad/s\] and decay `σ` \[1/s\] of each mode; with live regions, of the modes
    /// of the reduced matrices, and of the damped modes where dashpots couple them.
    pub(crate) fn modes(&self) -> Vec<[f64; 2]> {
        if let Some(modes) = self.damped_modes() {
            return modes;
        }
        self.normal_modes().1
    }

    /// Shapes of the modes of the reduced matrices without damping that couples them, over the coordinates
    /// and of modal mass 1, with their natural frequency \[rad/s\] and decay \[1/s\].
    pub(crate) fn normal_modes(&self) -> (Mat<f64>, Vec<[f64; 2]>) {
        let r = self.mass.nrows();
        let turned = if self.diagonal { None } else { self.turned() };
        let mut modes = turned.unwrap_or(Mat::identity(r, r));
        let mut rates = vec![];
        for k in 0..modes.ncols() {
            let along = |matrix: &Mat<f64>| modes.col(k).transpose() * matrix * modes.col(k);
            let mass = along(&self.mass);
            rates.push([(along(&self.stiffness) / mass).max(0.0).sqrt(), 0.5 * along(&self.damping) / mass]);
            (0..r).for_each(|i| modes[(i, k)] /= mass.sqrt());
        }
        (modes, rates)
    }

    /// Modulus and decay of the damped modes, from the eigenvalues of the equation of motion between `ω ζ`
    /// and `ζ̇`, of which the squares are the energy. `None` where every mode is damped by itself.
    fn damped_modes(&self) -> Option<Vec<[f64; 2]>> {
        let r = self.mass.nrows();
        let omega = |k: usize| (self.stiffness[(k, k)] / self.mass[(k, k)]).max(0.0).sqrt();
        let entry = |i: usize, j: usize| match (i < r, j < r) {
            (true, false) if i == j - r => omega(i),
            (false, true) if i - r == j => -omega(j),
            (false, false) => -self.damping[(i - r, j - r)] / self.mass[(i - r, i - r)],
            _ => 0.0,
        };
        let values = self.coupled.then(|| eigenvalues(Mat::from_fn(2 * r, 2 * r, entry).as_ref()).ok())??;
        // One of each pair; an overdamped mode has two that are real.
        let upper = values.into_iter().filter(|value| value.im >= 0.0);
        Some(upper.map(|value| [value.norm(), -value.re]).collect())
    }

    /// Modes of the reduced matrices over their coordinates: those of `L⁻¹KL⁻ᵀ` with `M = LLᵀ`. `None` of
    /// matrices that have none.
    fn turned(&self) -> Option<Mat<f64>> {
        let factor = self.mass.llt(faer::Side::Lower).ok()?;
        let mut inverse = Mat::<f64>::identity(self.mass.nrows(), self.mass.nrows());
        solve_lower_triangular_in_place(factor.L(), inverse.as_mut(), Par::Seq);
        let reduced = &inverse * &self.stiffness * inverse.transpose();
        let (_, vectors) = symmetric_eigen(reduced.as_ref()).ok()?;
        Some(inverse.transpose() * vectors)
    }

    /// `ζ` under `force` at `omega` \[rad/s\].
    pub(crate) fn answer(&self, force: &[f64], omega: f64) -> Vec<c64> {
        let entry = |i: usize, j: usize| {
            let real = self.stiffness[(i, j)] - omega * omega * self.mass[(i, j)];
            c64::new(real, omega * self.damping[(i, j)])
        };
        let r = force.len();
        if self.diagonal {
            return (0..r).map(|k| c64::new(force[k], 0.0) / entry(k, k)).collect();
        }
        // Real part above imaginary part.
        let matrix = Mat::from_fn(2 * r, 2 * r, |i, j| match (i < r, j < r) {
            (true, true) | (false, false) => entry(i % r, j % r).re,
            (false, true) => entry(i - r, j).im,
            (true, false) => -entry(i, j - r).im,
        });
        let right = Mat::from_fn(2 * r, 1, |i, _| if i < r { force[i] } else { 0.0 });
        let answer = solve_dense(matrix.as_ref(), right.as_ref());
        (0..r).map(|k| c64::new(answer[(k, 0)], answer[(r + k, 0)])).collect()
    }
}
