//! Rows of outputs and of loads over the modes of a scene.

use crate::base::error::{LoadError, OutputError};
use crate::base::scalar::Scalar;
use crate::scene::scene::Scene;
use vademecum_format::{Numbers, SectionKind};

impl<T: Scalar> Scene<'_, T> {
    /// Row of a probe over the modes, `r` numbers: its value is that of the row along `ζ`.
    ///
    /// # Errors
    /// [`OutputError`]; [`OutputError::Length`] for another count of numbers.
    pub fn probe_row_into(&self, probe: usize, out: &mut [f64]) -> Result<(), OutputError> {
        out.fill(0.0);
        self.row_into(self.sections.rows.probe_row(probe)?, 1.0, out)
    }

    /// Row of a direction at a node over the modes, `r` numbers: the displacement along it, and the load of a
    /// force of this direction and size.
    ///
    /// # Errors
    /// As [`Scene::probe_row_into`].
    pub fn node_row_into(
        &self,
        node: usize,
        direction: [f64; 3],
        out: &mut [f64],
    ) -> Result<(), OutputError> {
        out.fill(0.0);
        for (component, scale) in direction.into_iter().enumerate() {
            self.row_into(self.sections.rows.node_row(node, component)?, scale, out)?;
        }
        Ok(())
    }

    /// Row of a load pattern over the modes, `r` numbers: the load of amplitude 1.
    ///
    /// # Errors
    /// [`LoadError::NoPattern`], [`LoadError::Missing`]; [`LoadError::Mismatch`] for another count of
    /// numbers.
    pub fn pattern_row_into(&self, pattern: usize, out: &mut [f64]) -> Result<(), LoadError> {
        let (count, r) = (self.metadata.n_patterns as usize, self.shape.r);
        if pattern >= count {
            return Err(LoadError::NoPattern { index: pattern, count });
        }
        let kind = SectionKind::PatternBasis;
        let row = self.sections.pattern_basis.and_then(|basis| basis.row(pattern * r, r));
        out.fill(0.0);
        self.row_into(row.ok_or(LoadError::Missing { kind })?, 1.0, out).map_err(|_| LoadError::Mismatch)
    }

    fn row_into(&self, row: Numbers<'_>, scale: f64, out: &mut [f64]) -> Result<(), OutputError> {
        let (found, needed) = (out.len(), self.shape.r);
        if found != needed {
            return Err(OutputError::Length { found, needed });
        }
        out.iter_mut().zip(row.iter()).for_each(|(out, x)| *out += scale * x);
        Ok(())
    }
}
