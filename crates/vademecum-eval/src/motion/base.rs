//! A base that moves: its inertia is twelve load patterns, the last of the file.

use crate::base::error::LoadError;
use crate::base::scalar::Scalar;
use crate::scene::loads::{Loads, check_range};
use crate::scene::scene::Scene;
use vademecum_format::{BASE_PATTERNS, BaseMotion, SectionKind};

impl<T: Scalar> Scene<'_, T> {
    /// The point \[m\] about which the base turns and whose acceleration is given; `None` if the file was
    /// built without `[base] moves`.
    #[must_use]
    pub fn base_point(&self) -> Option<[f64; 3]> {
        let mut point = [0.0; 3];
        point.iter_mut().zip(self.sections.base?).for_each(|(out, &x)| *out = f64::from_le_bytes(x));
        Some(point)
    }
}

impl<T: Scalar> Loads<'_, T> {
    /// Adds the inertia of a base that moves so over the step, in the axes of the base. Displacements are
    /// then those relative to the base. It follows a live density.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use vademecum_eval::{BaseMotion, Field, SceneOptions, Simulation};
    /// # let bytes: &'static [u8] =
    /// #     include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/base.vdm"));
    /// let mut body = Simulation::<f64>::new(bytes, &SceneOptions::default())?;
    /// let shaken = BaseMotion { acceleration: [0.0, 0.0, 2.0], ..BaseMotion::default() };
    /// body.push_base(shaken)?; // Loads::add_base
    /// body.step(1)?;
    /// assert!(body.probe(0, Field::Displacement)? != 0.0);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`LoadError::Missing`]: a file without a moving base; as [`Loads::add_pattern`]. The loads are then
    /// unchanged.
    pub fn add_base(&mut self, scene: &Scene<'_, T>, motion: &BaseMotion) -> Result<(), LoadError> {
        let first = (scene.metadata().n_patterns as usize).checked_sub(BASE_PATTERNS.len());
        let first = first.filter(|_| scene.base_point().is_some());
        let first = first.ok_or(LoadError::Missing { kind: SectionKind::BaseFrame })?;
        let amplitudes = motion.amplitudes().map(|amplitude| scene.parameters().density * amplitude);
        check_range::<T>(amplitudes.iter())?;
        for (index, amplitude) in amplitudes.into_iter().enumerate() {
            if amplitude != 0.0 {
                self.add_pattern(scene, first + index, amplitude)?;
            }
        }
        Ok(())
    }
}
