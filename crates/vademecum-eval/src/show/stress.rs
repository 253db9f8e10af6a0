//! Stress and strain at the points for which the file has them.
//!
//! ```text
//! σ = s_K κ_q S ζ + T F + Σ_p a_p T_p        S: section 48, T: 49, T_p: 50
//! ```
//!
//! The first part is that of the modes. The second, what the modes leave out under forces at nodes and under
//! load patterns (filtered ones under stiffness-proportional damping), makes it the mode acceleration method
//! (Craig and Kurdila 2006, chapter 11); it does not depend on a stiffness of the whole body, since the
//! displacement it belongs to shrinks as the stiffness grows.

use crate::base::error::OutputError;
use crate::base::principal::principal;
use crate::base::scalar::Scalar;
use crate::base::vec3::dot;
use crate::scene::scene::Scene;
use crate::scene::state::State;
use crate::sections::rows::{Field, factors};
use crate::sections::stress_rows::StressPoint;
use vademecum_format::{MAX_REGIONS, SectionKind};

/// A symmetric tensor: stress \[Pa\] or strain, components xx, yy, zz, xy, yz, zx. Shear strains are those of
/// the tensor, half of what engineers call γ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tensor(pub [f64; 6]);

impl Tensor {
    /// Von Mises' equivalent stress, `√(3/2 s:s)` with `s` the deviator.
    ///
    /// ```
    /// use vademecum_eval::Tensor;
    ///
    /// let pull = Tensor([3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    /// let shear = Tensor([0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    /// assert_eq!(pull.von_mises(), 3.0);
    /// assert_eq!(shear.von_mises(), libm::sqrt(3.0));
    /// ```
    #[must_use]
    pub fn von_mises(&self) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        let [a, b, c] = [xx - yy, yy - zz, zz - xx];
        libm::sqrt(0.5 * (a * a + b * b + c * c) + 3.0 * (xy * xy + yz * yz + zx * zx))
    }

    /// Derivative of [`Tensor::von_mises`] along `direction`; 0 where the equivalent stress is 0, which has
    /// none.
    ///
    /// ```
    /// use vademecum_eval::Tensor;
    ///
    /// let pull = Tensor([3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    /// let more = Tensor([2.0, 0.0, 0.0, 9.0, 0.0, 0.0]);
    /// assert_eq!(pull.von_mises_along(&more), 2.0);
    /// ```
    #[must_use]
    pub fn von_mises_along(&self, direction: &Self) -> f64 {
        let differences = |Tensor([xx, yy, zz, ..]): &Self| [xx - yy, yy - zz, zz - xx];
        let shears = |Tensor([.., xy, yz, zx]): &Self| [*xy, *yz, *zx];
        let value = self.von_mises();
        if value == 0.0 {
            return 0.0;
        }
        let normal = dot(differences(self), differences(direction));
        (0.5 * normal + 3.0 * dot(shears(self), shears(direction))) / value
    }

    /// Principal values, largest first, by Jacobi's rotations.
    ///
    /// ```
    /// use vademecum_eval::Tensor;
    ///
    /// let shear = Tensor([1.0, 1.0, 0.0, 3.0, 0.0, 0.0]);
    /// let [first, second, third] = shear.principal();
    /// assert!((first - 4.0).abs() < 1e-15 && second.abs() < 1e-15 && (third + 2.0).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn principal(&self) -> [f64; 3] {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        let ([a, b, c], _) = principal([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]);
        let (most, least) = (a.max(b).max(c), a.min(b).min(c));
        let middle = a.min(b).max(a.max(b).min(c));
        [most, middle, least]
    }

    /// The principal value of the largest size, with its sign: tension above zero, pressure below.
    #[must_use]
    pub fn signed_maximum(&self) -> f64 {
        let [most, _, least] = self.principal();
        if most >= -least { most } else { least }
    }
}

/// The strain of a stress, from the upper triangle of the compliance, whose shear strains are those of
/// engineers.
fn by_compliance(triangle: &[[u8; 8]; 21], stress: &[f64; 6]) -> [f64; 6] {
    let (mut strain, mut place) = ([0.0; 6], triangle.iter());
    for row in 0..6 {
        for column in row..6 {
            let value = place.next().map_or(0.0, |&bytes| f64::from_le_bytes(bytes));
            strain[row] += value * stress[column];
            if column != row {
                strain[column] += value * stress[row];
            }
        }
    }
    strain.iter_mut().skip(3).for_each(|shear| *shear *= 0.5);
    strain
}

impl<T: Scalar> Scene<'_, T> {
    /// Number of points whose stress the file has.
    #[must_use]
    pub const fn n_stress_points(&self) -> usize {
        self.sections.stress.points.len()
    }

    /// One of them.
    #[must_use]
    pub fn stress_point(&self, index: usize) -> Option<StressPoint> {
        self.sections.stress.point(index)
    }

    /// Stress \[Pa\] at point `index`: that of the modes, and what they leave out under the loads of the last
    /// step, where the file has it. `O(r)`, and 18 multiplications for each node of a contact.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn stress(&self, state: &State<'_, T>, index: usize) -> Result<Tensor, OutputError> {
        self.check(state)?;
        if self.shape.is_strain() {
            return Err(OutputError::NotWithStrain);
        }
        let rows = &self.sections.stress;
        let mut stress = rows.moving(index, factors(&state.y, Field::Displacement))?;
        let region = rows.point(index).map_or(MAX_REGIONS, |point| point.region as usize);
        let scale = self.parameters.stiffness * self.options.regions.stiffness().get(region).unwrap_or(&1.0);
        stress.iter_mut().for_each(|stress| *stress *= scale);
        if !state.shown().is_empty() {
            rows.add_static(index, state.shown(), &mut stress);
        }
        Ok(Tensor(stress))
    }

    /// Strain at point `index`: the stress there by the law of its material,
    /// `ε = ((1 + ν) σ − ν tr σ I) / E` or the compliance of a region that is not isotropic.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn strain(&self, state: &State<'_, T>, index: usize) -> Result<Tensor, OutputError> {
        let Tensor(mut strain) = self.stress(state, index)?;
        let rows = &self.sections.stress;
        let region = rows.point(index).map_or(MAX_REGIONS, |point| point.region as usize);
        let scale = self.parameters.stiffness * self.options.regions.stiffness().get(region).unwrap_or(&1.0);
        if let Some(compliance) = rows.compliance.get(region) {
            return Ok(Tensor(by_compliance(compliance, &strain).map(|strain| strain / scale)));
        }
        let missing = OutputError::Missing { kind: SectionKind::ElasticConstants };
        let [young, poisson] = rows.constants.get(region).ok_or(missing)?.map(f64::from_le_bytes);
        let [xx, yy, zz, ..] = strain;
        let trace = poisson * (xx + yy + zz);
        strain.iter_mut().for_each(|strain| *strain *= 1.0 + poisson);
        strain.iter_mut().take(3).for_each(|strain| *strain -= trace);
        Ok(Tensor(strain.map(|strain| strain / (young * scale))))
    }

    /// Stress \[Pa\] at all points, `out` of shape `(n_stress_points, 6)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn stress_into(&self, state: &State<'_, T>, out: &mut [T]) -> Result<(), OutputError> {
        let needed = 6 * self.n_stress_points();
        if out.len() != needed {
            return Err(OutputError::Length { found: out.len(), needed });
        }
        for (index, out) in out.as_chunks_mut::<6>().0.iter_mut().enumerate() {
            *out = self.stress(state, index)?.0.map(T::from_f64);
        }
        Ok(())
    }
}
