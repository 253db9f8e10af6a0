//! How much energy a free motion can gain, whatever its start.
//!
//! A step whose eigenvalues lie in the unit circle may let the energy swing all the same, where its
//! eigenvectors are not orthogonal in the energy. With `W` a factor of the energy, `E(y) = ‖W y‖²`, and `y_0`
//! a start with the acceleration that its displacement demands, the largest `E(Aⁿ y_0) ÷ E(y_0)` is the
//! square of the largest singular value of `W Aⁿ P W⁻¹`; `P` fills in the acceleration. `A^(2ᵏ)` takes k
//! products.
//!
//! The odd thing: the powers are held as `Aⁿ − I`, whose squares are `2D + D²`, so that eigenvalues near 1
//! keep their digits.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};
use vademecum_eval::{Loads, Scene, State};

use super::error::CertificateError;
use super::evaluated::increment;

/// Products of the map: steps up to 2 to this power.
const DOUBLINGS: usize = 20;

/// Largest energy of any free motion at 1, 2, 4, …, 2²⁰ steps over the energy at its start; NaN where the
/// energy is not positive definite, infinite where a power overflows. The state and the loads are left
/// changed.
///
/// # Errors
/// [`CertificateError`]: a scene that refuses, singular values that do not converge.
pub(super) fn energy_growth(
    scene: &Scene<'_, f64>,
    state: &mut State<'_, f64>,
    loads: &mut Loads<'_, f64>,
) -> Result<f64, CertificateError> {
    let r = scene.n_modes();
    loads.clear();
    let starts = starts(scene, state, loads)?;
    let energy = energy_matrix(scene, state)?;
    let Ok(factor) = energy.llt(Side::Lower) else { return Ok(f64::NAN) };
    let mut power = increment(scene)?;
    let mut largest: f64 = 0.0;
    for doubling in 0..=DOUBLINGS {
        if doubling > 0 {
            power = &power * &power + faer::Scale(2.0) * &power;
        }
        // Displacement and velocity after so many steps, of every start.
        let moved = &starts + &power * &starts;
        // `(Lᵀ moved L⁻ᵀ)ᵀ`, which has the same singular values.
        let mut image = (factor.L().transpose() * moved.subrows(0, 2 * r)).transpose().to_owned();
        solve_lower_triangular_in_place(factor.L(), image.as_mut(), Par::Seq);
        if !image.is_all_finite() {
            return Ok(f64::INFINITY);
        }
        let singular = image.singular_values().map_err(|_| CertificateError::Eigenvalues)?;
        largest = singular.iter().fold(largest, |m, s| m.max(s * s));
    }
    Ok(largest)
}

/// Free starts `(ζ, Δt ζ̇, Δt² ζ̈)`, shape (3r, 2r): one unit of each displacement, then of each velocity
/// times Δt, with the acceleration that equilibrium demands.
fn starts(
    scene: &Scene<'_, f64>,
    state: &mut State<'_, f64>,
    loads: &Loads<'_, f64>,
) -> Result<Mat<f64>, CertificateError> {
    let (r, time_step) = (scene.n_modes(), scene.parameters().time_step);
    let mut starts = Mat::zeros(3 * r, 2 * r);
    for j in 0..2 * r {
        let (mut zeta, mut zeta_dot) = (vec![0.0; r], vec![0.0; r]);
        if j < r {
            zeta[j] = 1.0
        } else {
            zeta_dot[j - r] = 1.0 / time_step
        }
        scene.set(state, &zeta, &zeta_dot, loads)?;
        state.save_into(starts.col_as_slice_mut(j))?;
    }
    Ok(starts)
}

/// The energy as a quadratic form in `(ζ, Δt ζ̇)`, shape (2r, 2r), by polarisation.
fn energy_matrix(scene: &Scene<'_, f64>, state: &mut State<'_, f64>) -> Result<Mat<f64>, CertificateError> {
    let r = scene.n_modes();
    let mut of = |entries: &[usize]| -> Result<f64, CertificateError> {
        let mut y = vec![0.0; 3 * r];
        entries.iter().for_each(|&j| y[j] += 1.0);
        state.restore(&y)?;
        Ok(scene.energy(state)?)
    };
    let alone = (0..2 * r).map(|j| of(&[j])).collect::<Result<Vec<_>, _>>()?;
    let mut energy = Mat::zeros(2 * r, 2 * r);
    for i in 0..2 * r {
        energy[(i, i)] = alone[i];
        // Displacement and velocity do not couple.
        for j in if i < r { 0 } else { r }..i {
            energy[(i, j)] = 0.5 * (of(&[i, j])? - alone[i] - alone[j]);
            energy[(j, i)] = energy[(i, j)];
        }
    }
    Ok(energy)
}
