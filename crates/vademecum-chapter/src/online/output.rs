//! Outputs of a state: probes, nodes, the surface, the body and the energy.

use super::scene::ChapterScene;
use super::state::ChapterState;
use vademecum_eval::{Field, OutputError, Place};
use vademecum_format::{Numbers, SectionKind};

/// Reduced coordinates or rates, and a scale.
type Factors<'s> = (&'s [f64], f64);

impl<'m> ChapterScene<'m> {
    /// Value of probe `index`. `O(r)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn probe(&self, state: &ChapterState, index: usize, field: Field) -> Result<f64, OutputError> {
        let (x, scale) = self.factors(state, field)?;
        let (r, count) = (self.shape.r, self.metadata.n_probes as usize);
        let rows = self.probes.ok_or(OutputError::Missing { kind: SectionKind::ProbeRows })?;
        let row = rows.row(index.saturating_mul(r), r).filter(|_| index < count);
        Ok(dot(row.ok_or(OutputError::OutOfRange { index, count })?, x) * scale)
    }

    /// Displacement or velocity of `node` (file order), three components. `O(r)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn node(&self, state: &ChapterState, node: usize, field: Field) -> Result<[f64; 3], OutputError> {
        let (x, scale) = self.factors(state, field)?;
        Ok(self.rows_of(node)?.map(|row| dot(row, x) * scale))
    }

    /// Displacement or velocity of a place, such as a point of the surface, three components. `O(r)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn point(
        &self,
        state: &ChapterState,
        at: &impl AsRef<Place>,
        field: Field,
    ) -> Result<[f64; 3], OutputError> {
        let place = at.as_ref();
        place.check()?;
        let mut value = [0.0; 3];
        for (node, weight) in place.entries() {
            let at_node = self.node(state, node as usize, field)?;
            value.iter_mut().zip(at_node).for_each(|(sum, x)| *sum += weight * x);
        }
        Ok(value)
    }

    /// The surface, `out` of shape `(n_surface_nodes, 3)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn surface_into(
        &self,
        state: &ChapterState,
        field: Field,
        out: &mut [f64],
    ) -> Result<(), OutputError> {
        self.field_into(self.metadata.n_surface_nodes as usize, self.factors(state, field)?, out)
    }

    /// The whole body, `out` of shape `(n_nodes, 3)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn body_into(&self, state: &ChapterState, field: Field, out: &mut [f64]) -> Result<(), OutputError> {
        self.field_into(self.metadata.n_nodes as usize, self.factors(state, field)?, out)
    }

    /// Kinetic plus elastic energy \[J\]. `O(r²)`.
    ///
    /// # Errors
    /// [`OutputError::Mismatch`].
    pub fn energy(&self, state: &ChapterState) -> Result<f64, OutputError> {
        let (rates, per_second) = self.factors(state, Field::Velocity)?;
        let kinetic = rates.iter().map(|x| x * x).sum::<f64>() * per_second * per_second;
        let zeta = state.zeta().iter().enumerate();
        let elastic: f64 = zeta.map(|(k, x)| x * self.stiffness_row(k, state.zeta())).sum();
        Ok(0.5 * kinetic + 0.5 * elastic)
    }

    /// The first nodes of the file.
    fn field_into(
        &self,
        n_nodes: usize,
        (x, scale): Factors<'_>,
        out: &mut [f64],
    ) -> Result<(), OutputError> {
        if out.len() != 3 * n_nodes {
            return Err(OutputError::Length { found: out.len(), needed: 3 * n_nodes });
        }
        for (node, out) in out.chunks_exact_mut(3).enumerate() {
            for (row, out) in self.rows_of(node)?.into_iter().zip(out) {
                *out = scale * dot_in_eights(row, x);
            }
        }
        Ok(())
    }

    /// The rows of the basis of a node.
    fn rows_of(&self, node: usize) -> Result<[Numbers<'m>; 3], OutputError> {
        let (r, n_nodes) = (self.shape.r, self.metadata.n_nodes as usize);
        let beyond = OutputError::OutOfRange { index: node, count: n_nodes };
        if node >= n_nodes {
            return Err(beyond);
        }
        let (rows, kind, place) = match node.checked_sub(self.metadata.n_surface_nodes as usize) {
            None => (self.surface, SectionKind::SurfaceBasis, node),
            Some(place) => (self.interior, SectionKind::InteriorBasis, place),
        };
        let rows = rows.ok_or(OutputError::Missing { kind })?;
        let row = |component| rows.row((3 * place + component) * r, r).ok_or(beyond);
        Ok([row(0)?, row(1)?, row(2)?])
    }

    /// Displacement or velocity of a state as coordinates and a scale.
    fn factors<'s>(&self, state: &'s ChapterState, field: Field) -> Result<Factors<'s>, OutputError> {
        if state.shape != self.shape {
            return Err(OutputError::Mismatch);
        }
        Ok(match field {
            Field::Displacement => (state.zeta(), 1.0),
            Field::Velocity => (state.scaled_velocity(), 1.0 / self.shape.time_step),
        })
    }
}

/// `Σ_k row_k x_k`.
fn dot(row: Numbers<'_>, x: &[f64]) -> f64 {
    row.iter().zip(x).map(|(b, x)| b * x).sum()
}

/// `Σ_k row_k x_k` in the order in which the evaluator sums whole fields: column `k` goes to partial sum
/// `k mod 8`, and the eight are added in pairs.
fn dot_in_eights(row: Numbers<'_>, x: &[f64]) -> f64 {
    match row {
        Numbers::F32(row) => in_eights(row.iter().map(|&bytes| f64::from(f32::from_le_bytes(bytes))), x),
        Numbers::F64(row) => in_eights(row.iter().map(|&bytes| f64::from_le_bytes(bytes)), x),
        Numbers::I16(_) => in_eights(row.iter(), x),
    }
}

fn in_eights(row: impl Iterator<Item = f64>, x: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    row.zip(x).enumerate().for_each(|(k, (b, x))| sums[k % 8] += b * x);
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
