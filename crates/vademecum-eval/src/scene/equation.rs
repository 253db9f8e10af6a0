//! The reduced equation of motion at a scene's parameters: `s_ρ M_r ζ̈ + … + s_K K_r ζ = BᵀF` with
//! `M_r = Σ_q ρ_q BᵀM_qB` (the identity while every `ρ_q` is 1) and `K_r = Σ_q κ_q BᵀK_qB`.
//!
//! Note: the region sums are formed anew whenever they are read. They are wanted once per placed
//! state or asked energy, and a step does not know them.

use crate::base::error::StepError;
use crate::base::scalar::Scalar;
use crate::kernels::coordinates::Coordinates;
use vademecum_format::scheme::StepParameters;

/// The reduced matrices of a file, as it stores them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Matrices<'m> {
    /// `BᵀKB`.
    pub stiffness: Stiffness<'m>,
    /// Number of regions.
    pub n_regions: usize,
    /// `BᵀK_qB` of each region, `(n_regions, r, r)`; `None` if absent or compressed.
    pub region_stiffness: Option<&'m [[u8; 8]]>,
    /// `BᵀM_qB` of each region, `(n_regions, r, r)`; `None` if absent or compressed.
    pub region_mass: Option<&'m [[u8; 8]]>,
}

/// Kinetic and elastic energy \[J\].
pub(crate) struct Energy {
    pub kinetic: f64,
    pub elastic: f64,
}

impl Energy {
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic
    }
}

/// `BᵀKB` of the whole body.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stiffness<'m> {
    /// Its diagonal, the Ritz values, `(r)`.
    Diagonal(&'m [[u8; 8]]),
    /// All of it, `(r, r)`.
    Dense(&'m [[u8; 8]]),
}

/// The reduced equation of motion: matrices and what scales them.
#[derive(Clone, Copy)]
pub(crate) struct Equation<'e, 'm> {
    pub matrices: &'e Matrices<'m>,
    pub parameters: &'e StepParameters,
    /// `κ_q`.
    pub region_stiffness: &'e [f64],
    /// `ρ_q`.
    pub region_density: &'e [f64],
}

impl Equation<'_, '_> {
    /// Sets displacement and velocity and computes the acceleration under `force = BᵀF`; all of it or
    /// nothing.
    pub fn place<T: Scalar>(
        &self,
        y: &mut Coordinates<'_, T>,
        zeta: &[f64],
        zeta_dot: &[f64],
        force: &[T],
    ) -> Result<(), StepError> {
        let StepParameters { time_step: dt, alpha, beta, density, stiffness } = *self.parameters;
        y.next.fill(T::ZERO);
        if !y.has_acceleration() {
            return place_without_acceleration(y, zeta, zeta_dot, dt);
        }
        let [position, velocity, acceleration] = y.next_parts()?;
        if [zeta.len(), zeta_dot.len(), force.len()] != [position.len(); 3] {
            return Err(StepError::Mismatch);
        }
        for (k, (force, out)) in force.iter().zip(&mut *position).enumerate() {
            let rows = self.stiffness_row(k, zeta).zip(self.stiffness_row(k, zeta_dot));
            let (of_zeta, of_rate) = rows.ok_or(StepError::Mismatch)?;
            let elastic = stiffness * (of_zeta + beta * of_rate);
            *out = T::from_f64((force.to_f64() - elastic) / density);
        }
        self.divide_by_mass(position, velocity, acceleration)?;
        let placed = position.iter_mut().zip(velocity).zip(acceleration);
        for (((position, velocity), acceleration), (&zeta, &rate)) in placed.zip(zeta.iter().zip(zeta_dot)) {
            *position = T::from_f64(zeta);
            *velocity = T::from_f64(dt * rate);
            *acceleration = T::from_f64(dt * dt * (acceleration.to_f64() - alpha * rate));
        }
        accept_placed(y, dt)
    }

    /// Gives a body at rest the acceleration that `force = BᵀF` demands, as [`Equation::place`] does; all of
    /// it or nothing.
    pub fn start<T: Scalar>(&self, y: &mut Coordinates<'_, T>, force: &[T]) -> Result<(), StepError> {
        y.next.fill(T::ZERO);
        let [position, velocity, acceleration] = y.next_parts()?;
        self.acceleration_at_rest(force, [&mut *position, &mut *velocity, acceleration])?;
        position.fill(T::ZERO);
        velocity.fill(T::ZERO);
        if !y.next.iter().all(|value| value.in_range()) {
            return Err(StepError::NotFinite);
        }
        y.accept(self.parameters.time_step);
        Ok(())
    }

    /// `Δt² ζ̈` of a body at rest under `force = BᵀF`, in the last of three vectors as long as `force`; the
    /// first two are work. The bits are those of [`Equation::place`] at zero.
    pub fn acceleration_at_rest<T: Scalar>(
        &self,
        force: &[T],
        [residual, direction, acceleration]: [&mut [T]; 3],
    ) -> Result<(), StepError> {
        let StepParameters { time_step: dt, density, .. } = *self.parameters;
        if [residual.len(), direction.len(), acceleration.len()] != [force.len(); 3] {
            return Err(StepError::Mismatch);
        }
        let scaled = force.iter().map(|force| T::from_f64(force.to_f64() / density));
        residual.iter_mut().zip(scaled).for_each(|(out, force)| *out = force);
        self.divide_by_mass(residual, direction, acceleration)?;
        acceleration.iter_mut().for_each(|a| *a = T::from_f64(dt * dt * a.to_f64()));
        Ok(())
    }

    /// `a = M_r⁻¹ residual`; `direction` is work, and `residual` is lost.
    fn divide_by_mass<T: Scalar>(
        &self,
        residual: &mut [T],
        direction: &mut [T],
        a: &mut [T],
    ) -> Result<(), StepError> {
        if moved(self.region_density) {
            return self.solve_mass(residual, direction, a);
        }
        copy(residual, a);
        Ok(())
    }

    /// Kinetic and elastic energy \[J\]; `None` if a matrix is smaller than the state asks for.
    pub fn energy<T: Scalar>(&self, y: &Coordinates<'_, T>) -> Option<Energy> {
        let (zeta, rates, per_second) = (y.part(0), y.part(1), 1.0 / y.time_step);
        let kinetic = form(rates, |k| self.mass_row(k, rates))? * per_second * per_second;
        let elastic = form(zeta, |k| self.stiffness_row(k, zeta))?;
        Some(Energy {
            kinetic: 0.5 * self.parameters.density * kinetic,
            elastic: 0.5 * self.parameters.stiffness * elastic,
        })
    }

    /// Derivative of [`Equation::energy`] at `y` along `direction` \[J\]; both have the same `Δt`.
    pub fn energy_along<T: Scalar>(
        &self,
        y: &Coordinates<'_, T>,
        direction: &Coordinates<'_, T>,
    ) -> Option<Energy> {
        let (zeta, rates, per_second) = (y.part(0), y.part(1), 1.0 / y.time_step);
        let kinetic = form(direction.part(1), |k| self.mass_row(k, rates))? * per_second * per_second;
        let elastic = form(direction.part(0), |k| self.stiffness_row(k, zeta))?;
        Some(Energy {
            kinetic: self.parameters.density * kinetic,
            elastic: self.parameters.stiffness * elastic,
        })
    }

    /// Solves `M_r a = f` by conjugate gradients: `f` in `residual` on entry, three vectors in all. `M_r` is
    /// between the smallest and the largest region density times the identity, so the count of iterations
    /// goes with the root of their ratio.
    fn solve_mass<T: Scalar>(
        &self,
        residual: &mut [T],
        direction: &mut [T],
        a: &mut [T],
    ) -> Result<(), StepError> {
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
            let curvature = rows.map(|(k, p)| Some(p.to_f64() * self.mass_row(k, direction)?));
            let curvature = curvature.sum::<Option<f64>>().ok_or(StepError::Mismatch)?;
            let length = now / curvature;
            if curvature <= 0.0 || !length.is_finite() {
                return Err(StepError::BadMass);
            }
            for (k, ((a, residual), p)) in a.iter_mut().zip(&mut *residual).zip(&*direction).enumerate() {
                *a = T::from_f64(a.to_f64() + length * p.to_f64());
                let image = self.mass_row(k, direction).ok_or(StepError::Mismatch)?;
                *residual = T::from_f64(residual.to_f64() - length * image);
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
    fn stiffness_row<S: Scalar>(&self, k: usize, x: &[S]) -> Option<f64> {
        let scales = self.region_stiffness;
        match (self.matrices.stiffness, self.matrices.region_stiffness) {
            (Stiffness::Diagonal(lambda), _) => Some(number(lambda, k)? * x.get(k)?.to_f64()),
            (Stiffness::Dense(_), Some(regions)) if moved(scales) => self.region_row(regions, scales, k, x),
            (Stiffness::Dense(whole), _) => row(whole, k, x),
        }
    }

    /// Row `k` of `M_r x`, without `s_ρ`.
    fn mass_row<S: Scalar>(&self, k: usize, x: &[S]) -> Option<f64> {
        match self.matrices.region_mass {
            Some(regions) if moved(self.region_density) => {
                self.region_row(regions, self.region_density, k, x)
            }
            _ => Some(x.get(k)?.to_f64()),
        }
    }

    /// Row `k` of `Σ_q s_q A_q x`, the `A_q` one after the other.
    fn region_row<S: Scalar>(&self, regions: &[[u8; 8]], scales: &[f64], k: usize, x: &[S]) -> Option<f64> {
        self.over_regions(scales, |q| row(regions, q * x.len() + k, x))
    }

    /// `Σ_q s_q a_q` over the regions of the file.
    fn over_regions(&self, scales: &[f64], a: impl Fn(usize) -> Option<f64>) -> Option<f64> {
        let mut regions = scales.iter().take(self.matrices.n_regions).enumerate();
        regions.try_fold(0.0, |sum, (q, scale)| Some(sum + scale * a(q)?))
    }

    /// At least the largest eigenvalue of `K_r` of `r` modes, without `s_K`: the largest Ritz value, or the
    /// sum of the diagonal, which no eigenvalue of a positive matrix exceeds. `None` if a matrix is smaller
    /// than that.
    pub fn stiffness_bound(&self, r: usize) -> Option<f64> {
        let scales = self.region_stiffness;
        let on_diagonal = |matrix, k| number(matrix, k * r + k);
        match (self.matrices.stiffness, self.matrices.region_stiffness) {
            (Stiffness::Diagonal(lambda), _) => {
                (0..r).try_fold(0.0, |so_far, k| Some(larger(so_far, number(lambda, k)?)))
            }
            (Stiffness::Dense(_), Some(regions)) if moved(scales) => {
                let entry = |q: usize, k: usize| number(regions, (q * r + k) * r + k);
                (0..r).map(|k| self.over_regions(scales, |q| entry(q, k))).sum()
            }
            (Stiffness::Dense(whole), _) => (0..r).map(|k| on_diagonal(whole, k)).sum(),
        }
    }
}

/// Sets displacement and velocity where there is nothing else to set.
fn place_without_acceleration<T: Scalar>(
    y: &mut Coordinates<'_, T>,
    zeta: &[f64],
    zeta_dot: &[f64],
    time_step: f64,
) -> Result<(), StepError> {
    let [position, velocity] = y.next_parts()?;
    if [zeta.len(), zeta_dot.len()] != [position.len(); 2] {
        return Err(StepError::Mismatch);
    }
    position.iter_mut().zip(zeta).for_each(|(out, &value)| *out = T::from_f64(value));
    velocity.iter_mut().zip(zeta_dot).for_each(|(out, &rate)| *out = T::from_f64(time_step * rate));
    accept_placed(y, time_step)
}

/// Takes a state that was written beside the old one, if it is finite.
fn accept_placed<T: Scalar>(y: &mut Coordinates<'_, T>, time_step: f64) -> Result<(), StepError> {
    if !y.next.iter().all(|value| value.in_range()) {
        return Err(StepError::NotFinite);
    }
    y.accept(time_step);
    (y.at_rest, y.unstarted) = (false, false);
    if y.now.iter().all(|&value| value == T::ZERO) {
        y.come_to_rest();
    }
    Ok(())
}

/// The larger of two; the first if the second is not a number.
pub(crate) fn larger(so_far: f64, value: f64) -> f64 {
    if value > so_far { value } else { so_far }
}

/// `Σ_k x_k y_k`.
fn form<T: Scalar>(x: &[T], y: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    x.iter().enumerate().map(|(k, x)| Some(x.to_f64() * y(k)?)).sum()
}

/// Without the panic of `copy_from_slice`.
fn copy<T: Copy>(from: &[T], to: &mut [T]) {
    to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
}

fn moved(scales: &[f64]) -> bool {
    scales.iter().any(|&scale| scale != 1.0)
}

/// Row `k` of `A x`, `A` as wide as `x` is long.
fn row<S: Scalar>(a: &[[u8; 8]], k: usize, x: &[S]) -> Option<f64> {
    let row = a.get(k * x.len()..(k + 1) * x.len())?;
    Some(row.iter().zip(x).map(|(&a, x)| f64::from_le_bytes(a) * x.to_f64()).sum())
}

fn number(numbers: &[[u8; 8]], at: usize) -> Option<f64> {
    numbers.get(at).map(|&bytes| f64::from_le_bytes(bytes))
}
