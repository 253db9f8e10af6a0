//! The reduced equation of motion at a scene's parameters: `s_ρ M_r ζ̈ + … + s_K K_r ζ = BᵀF` with `M_r = Σ_q ρ_q BᵀM_qB` (the
//! identity while every `ρ_q` is 1) and `K_r = Σ_q κ_q BᵀK_qB`.
//!
//! The odd thing: the region sums are formed anew whenever they are read. They are wanted once per placed state or asked energy,
//! and a step does not know them.

use crate::error::StepError;
use crate::loads::Loads;
use crate::options::Structure;
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::state::State;
use vademecum_format::scheme::StepParameters;
use vademecum_format::{MAX_REGIONS, Numbers};

impl<T: Scalar> Scene<'_, T> {
    /// Sets displacement and velocity in reduced coordinates and computes the acceleration that goes with them under `loads`
    /// (their force at the start of a step): `ζ̈ = M_r⁻¹ (BᵀF − s_K K_r (ζ + β ζ̇))/s_ρ − α ζ̇`.
    ///
    /// `zeta` \[m kg^½\] and `zeta_dot` \[m kg^½/s\] have length `r`. With region densities, `M_r ζ̈ = …` is solved by conjugate
    /// gradients to rounding; otherwise `M_r` is the identity.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn set(
        &self,
        state: &mut State<'_, T>,
        zeta: &[f64],
        zeta_dot: &[f64],
        loads: &Loads<'_, T>,
    ) -> Result<(), StepError> {
        let r = self.shape.r;
        if state.shape != self.shape || loads.shape != self.shape || zeta.len() != r || zeta_dot.len() != r {
            return Err(StepError::Mismatch);
        }
        self.check_fresh(loads)?;
        let StepParameters { time_step: dt, alpha, beta, density, stiffness } = self.parameters;
        state.next.fill(T::ZERO);
        let [position, velocity, acceleration] = thirds(state.next, self.shape.stride(), r);
        for (k, (force, out)) in loads.force.iter().zip(&mut *position).enumerate() {
            let elastic = stiffness * (self.stiffness_row(k, zeta) + beta * self.stiffness_row(k, zeta_dot));
            *out = T::from_f64((force.to_f64() - elastic) / density);
        }
        if self.has_region_mass() {
            self.solve_mass(position, velocity, acceleration)?;
        } else {
            copy(position, acceleration);
        }
        let placed = position.iter_mut().zip(velocity).zip(acceleration);
        for (((position, velocity), acceleration), (&zeta, &rate)) in placed.zip(zeta.iter().zip(zeta_dot)) {
            *position = T::from_f64(zeta);
            *velocity = T::from_f64(dt * rate);
            *acceleration = T::from_f64(dt * dt * (acceleration.to_f64() - alpha * rate));
        }
        if state.next.iter().any(|value| !value.to_f64().is_finite()) {
            return Err(StepError::NotFinite);
        }
        state.accept(dt);
        state.at_rest = state.now.iter().all(|&value| value == T::ZERO);
        Ok(())
    }

    /// Solves `M_r a = f` by conjugate gradients: `f` in `residual` on entry, three vectors in all. `M_r` is between the smallest and
    /// the largest region density times the identity, so the count of iterations goes with the root of their ratio.
    fn solve_mass(&self, residual: &mut [T], direction: &mut [T], a: &mut [T]) -> Result<(), StepError> {
        let square = |x: &[T]| x.iter().map(|x| x.to_f64() * x.to_f64()).sum::<f64>();
        a.fill(T::ZERO);
        copy(residual, direction);
        let mut now = square(residual);
        if !now.is_finite() {
            return Err(StepError::NotFinite);
        }
        let enough = T::EPSILON * T::EPSILON * now;
        // In exact arithmetic r iterations are all; rounding takes a few times that.
        for _ in 0..10 * a.len() + 50 {
            if now <= enough {
                return Ok(());
            }
            let rows = direction.iter().enumerate();
            let curvature: f64 = rows.map(|(k, p)| p.to_f64() * self.mass_row(k, direction)).sum();
            let length = now / curvature;
            if curvature <= 0.0 || !length.is_finite() {
                return Err(StepError::BadMass);
            }
            for (k, ((a, residual), p)) in a.iter_mut().zip(&mut *residual).zip(&*direction).enumerate() {
                *a = T::from_f64(a.to_f64() + length * p.to_f64());
                *residual = T::from_f64(residual.to_f64() - length * self.mass_row(k, direction));
            }
            let next = square(residual);
            let share = next / now;
            now = next;
            for (p, residual) in direction.iter_mut().zip(&*residual) {
                *p = T::from_f64(residual.to_f64() + share * p.to_f64());
            }
        }
        Err(StepError::BadMass)
    }

    /// Row `k` of `K_r x`, without `s_K`.
    pub(crate) fn stiffness_row<S: Scalar>(&self, k: usize, x: &[S]) -> f64 {
        let (r, scales) = (self.shape.r, &self.options.region_stiffness);
        match (self.shape.structure, self.sections.region_stiffness) {
            (Structure::Diagonal, _) => {
                let value = x.get(k).map(|x| x.to_f64()).unwrap_or_default();
                self.sections.stiffness.get(k).unwrap_or_default() * value
            }
            (_, Some(regions)) if moved(scales) => region_row(regions, scales, k, r, x),
            _ => row(self.sections.stiffness, k * r, x),
        }
    }

    /// Row `k` of `M_r x`, without `s_ρ`.
    pub(crate) fn mass_row<S: Scalar>(&self, k: usize, x: &[S]) -> f64 {
        let scales = &self.options.region_density;
        match self.sections.region_mass {
            Some(regions) if moved(scales) => region_row(regions, scales, k, self.shape.r, x),
            _ => x.get(k).map(|x| x.to_f64()).unwrap_or_default(),
        }
    }

    /// Number `(k, k)` of `K_r`, without `s_K`, of the block structure.
    pub(crate) fn stiffness_entry(&self, k: usize) -> f64 {
        let (r, scales) = (self.shape.r, &self.options.region_stiffness);
        let at = |numbers: Numbers<'_>, q: usize| numbers.get((q * r + k) * r + k).unwrap_or_default();
        match self.sections.region_stiffness {
            Some(regions) if moved(scales) => {
                scales.iter().enumerate().map(|(q, scale)| scale * at(regions, q)).sum()
            }
            _ => at(self.sections.stiffness, 0),
        }
    }

    fn has_region_mass(&self) -> bool {
        moved(&self.options.region_density)
    }
}

/// Without the panic of `copy_from_slice`.
fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
}

fn moved(scales: &[f64; MAX_REGIONS]) -> bool {
    scales.iter().any(|&scale| scale != 1.0)
}

/// Row `k` of `Σ_q s_q A_q x`, the `A_q` one after the other.
fn region_row<S: Scalar>(
    regions: Numbers<'_>,
    scales: &[f64; MAX_REGIONS],
    k: usize,
    r: usize,
    x: &[S],
) -> f64 {
    scales.iter().enumerate().map(|(q, scale)| scale * row(regions, (q * r + k) * r, x)).sum()
}

/// The numbers from `start` times `x`; nothing past their end, where a file has fewer regions than scales.
fn row<S: Scalar>(numbers: Numbers<'_>, start: usize, x: &[S]) -> f64 {
    let row = numbers.row(start, x.len());
    row.map_or(0.0, |row| row.iter().zip(x).map(|(a, x)| a * x.to_f64()).sum())
}

/// The first `r` numbers of each third of a state.
fn thirds<T>(all: &mut [T], stride: usize, r: usize) -> [&mut [T]; 3] {
    let (first, rest) = all.split_at_mut_checked(stride).unwrap_or_default();
    let (second, third) = rest.split_at_mut_checked(stride).unwrap_or_default();
    [first, second, third].map(|part| part.get_mut(..r).unwrap_or_default())
}
