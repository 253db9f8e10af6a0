//! The map a scene steps with, taken out again: for whoever wants to judge the numbers that are used, not
//! those they were made from.

use crate::base::error::OutputError;
use crate::base::lend::Short;
use crate::base::options::Structure;
use crate::base::scalar::Scalar;
use crate::scene::bind::{place_in_modes, place_in_tiles};
use crate::scene::scene::Scene;

impl<T: Scalar> Scene<'_, T> {
    /// Writes the increment map `D` of the step `y ← y + D y + ℓ` with `y = (ζ, Δt ζ̇, Δt² ζ̈)`, as the scene
    /// holds it in its precision; each number is converted to `f64`, which is exact.
    ///
    /// `out` has shape `(3r, 3r)`, column-major: number `(i, j)` is at `3r j + i`; `2r` in place of `3r` for
    /// the exact structure, `y = (ζ, Δt ζ̇)`. The diagonal structure has a 3×3 block per mode and the exact
    /// one a 2×2 block, so all numbers between different modes are 0, unless dashpots couple them. The step's
    /// own map is `I + D`; its spectral radius tells whether a free body stays bounded. `O(r²)`.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// let n = 3 * scene.n_modes();
    /// let mut map = vec![0.0; n * n];
    /// scene.increment_into(&mut map)?;
    /// // A step of the first unit state, less itself, is the first column.
    /// let mut unit = vec![0.0; n];
    /// unit[0] = 1.0;
    /// state.restore(&unit)?;
    /// scene.step(&mut state, &loads)?;
    /// for (mode, &zeta) in state.zeta().iter().enumerate() {
    ///     assert_eq!(zeta, unit[mode] + map[mode]);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError::NotWithStrain`] for the strain structure, whose step is not a map;
    /// [`OutputError::Length`] if `out` does not have `9r²` numbers, or `4r²` for the exact structure.
    pub fn increment_into(&self, out: &mut [f64]) -> Result<(), OutputError> {
        if self.shape.is_strain() {
            return Err(OutputError::NotWithStrain);
        }
        let n = self.shape.n_parts() * self.shape.r;
        let (found, needed) = (out.len(), n * n);
        if found != needed {
            return Err(OutputError::Length { found, needed });
        }
        for (j, column) in out.chunks_exact_mut(n.max(1)).enumerate() {
            for (i, out) in column.iter_mut().enumerate() {
                *out = self.increment(i, j)?;
            }
        }
        Ok(())
    }

    /// Number `(i, j)` of `D`.
    pub(crate) fn increment(&self, i: usize, j: usize) -> Result<f64, Short> {
        let r = self.shape.r.max(1);
        let at = match self.shape.structure() {
            Structure::Exact if self.shape.is_coupled() => place_in_tiles(i, j, 2 * r),
            Structure::Diagonal | Structure::Exact if i % r != j % r => return Ok(0.0),
            Structure::Diagonal => place_in_modes::<3>(i % r, i / r, j / r),
            Structure::Exact => place_in_modes::<2>(i % r, i / r, j / r),
            Structure::Block => place_in_tiles(i, j, 3 * r),
            Structure::Strain => return Ok(0.0),
        };
        let short = Short { found: self.map.len(), needed: at.saturating_add(1) };
        self.map.get(at).map(|d| d.to_f64()).ok_or(short)
    }
}
