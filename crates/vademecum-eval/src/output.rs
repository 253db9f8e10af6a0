//! Reading a state: probes, nodes, the surface, the whole body, energy. Each costs what it reads and nothing else.

use crate::error::OutputError;
use crate::reconstruct::reconstruct;
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::state::State;
use crate::surface::SurfacePoint;
use vademecum_format::{Numbers, SectionKind};

/// Which field an output is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Displacement \[m\].
    Displacement,
    /// Velocity \[m/s\].
    Velocity,
}

impl<T: Scalar> Scene<'_, T> {
    /// Value of probe `index`. `O(r)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn probe(&self, state: &State<'_, T>, index: usize, field: Field) -> Result<f64, OutputError> {
        let count = self.metadata.n_probes as usize;
        let rows = self.sections.probes.ok_or(OutputError::Missing { kind: SectionKind::ProbeRows })?;
        let row = rows.row(index.saturating_mul(self.shape.r), self.shape.r);
        let row = row.filter(|_| index < count).ok_or(OutputError::OutOfRange { index, count })?;
        let (coordinates, scale) = self.coordinates(state, field)?;
        Ok(dot(row, coordinates) * scale)
    }

    /// Displacement or velocity of `node` (file order), three components. `O(r)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn node(&self, state: &State<'_, T>, node: usize, field: Field) -> Result<[f64; 3], OutputError> {
        let (count, n_surface) = (self.metadata.n_nodes as usize, self.metadata.n_surface_nodes as usize);
        if node >= count {
            return Err(OutputError::OutOfRange { index: node, count });
        }
        let (rows, place) = match node.checked_sub(n_surface) {
            None => (self.rows(SectionKind::SurfaceBasis)?, node),
            Some(place) => (self.rows(SectionKind::InteriorBasis)?, place),
        };
        let (coordinates, scale) = self.coordinates(state, field)?;
        let r = self.shape.r;
        Ok([0, 1, 2].map(|component| {
            let row = rows.row((3 * place + component) * r, r);
            row.map_or(0.0, |row| dot(row, coordinates) * scale)
        }))
    }

    /// Displacement or velocity of a point of the surface, three components. `O(r)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn point(
        &self,
        state: &State<'_, T>,
        point: &SurfacePoint,
        field: Field,
    ) -> Result<[f64; 3], OutputError> {
        let mut value = [0.0; 3];
        for (&node, weight) in point.nodes.iter().zip(point.weights) {
            let at_node = self.node(state, node as usize, field)?;
            value.iter_mut().zip(at_node).for_each(|(sum, x)| *sum += weight * x);
        }
        Ok(value)
    }

    /// The surface, `out` of shape `(n_surface_nodes, 3)`. Bound by reading the basis once.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn surface_into(&self, state: &State<'_, T>, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        let needed = 3 * self.metadata.n_surface_nodes as usize;
        if out.len() != needed {
            return Err(OutputError::Length { found: out.len(), needed });
        }
        let rows = self.rows(SectionKind::SurfaceBasis)?;
        let (coordinates, scale) = self.coordinates(state, field)?;
        reconstruct(rows, coordinates, T::from_f64(scale), out);
        Ok(())
    }

    /// The whole body, `out` of shape `(n_nodes, 3)`. Bound by reading the basis once.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn body_into(&self, state: &State<'_, T>, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        let needed = 3 * self.metadata.n_nodes as usize;
        let length = OutputError::Length { found: out.len(), needed };
        if out.len() != needed {
            return Err(length);
        }
        let n_surface = 3 * self.metadata.n_surface_nodes as usize;
        let (surface, interior) = out.split_at_mut_checked(n_surface).ok_or(length)?;
        if !interior.is_empty() {
            let rows = self.rows(SectionKind::InteriorBasis)?;
            let (coordinates, scale) = self.coordinates(state, field)?;
            reconstruct(rows, coordinates, T::from_f64(scale), interior);
        }
        self.surface_into(state, field, surface)
    }

    /// Kinetic plus elastic energy \[J\]: `½ s_ρ ζ̇ᵀ M_r ζ̇ + ½ s_K ζᵀ K_r ζ`, with the scales of the regions in
    /// `M_r = Σ ρ_q BᵀM_qB` and `K_r = Σ κ_q BᵀK_qB`. `O(r)`, or `O(r²)` times the regions that count.
    ///
    /// # Errors
    /// [`OutputError::Mismatch`].
    pub fn energy(&self, state: &State<'_, T>) -> Result<f64, OutputError> {
        let (rates, scale) = self.coordinates(state, Field::Velocity)?;
        let kinetic = form(rates, |k| self.mass_row(k, rates)) * scale * scale;
        let zeta = state.zeta();
        let elastic = form(zeta, |k| self.stiffness_row(k, zeta));
        Ok(0.5 * self.parameters.density * kinetic + 0.5 * self.parameters.stiffness * elastic)
    }

    fn rows(&self, kind: SectionKind) -> Result<Numbers<'_>, OutputError> {
        let rows =
            if kind == SectionKind::SurfaceBasis { self.sections.surface } else { self.sections.interior };
        rows.ok_or(OutputError::Missing { kind })
    }

    /// What multiplies the basis: reduced coordinates and a scale.
    fn coordinates<'s>(&self, state: &'s State<'_, T>, field: Field) -> Result<(&'s [T], f64), OutputError> {
        if state.shape != self.shape {
            return Err(OutputError::Mismatch);
        }
        Ok(match field {
            Field::Displacement => (state.zeta(), 1.0),
            Field::Velocity => (state.scaled_velocity(), 1.0 / state.time_step),
        })
    }
}

/// `Σ_k x_k y_k`.
fn form<T: Scalar>(x: &[T], y: impl Fn(usize) -> f64) -> f64 {
    x.iter().enumerate().map(|(k, x)| x.to_f64() * y(k)).sum()
}

/// `Σ_k row_k x_k`; the kind of the numbers is looked at once a row.
fn dot<T: Scalar>(row: Numbers<'_>, x: &[T]) -> f64 {
    let x = x.iter().map(|x| x.to_f64());
    match row {
        Numbers::F32(row) => row.iter().zip(x).map(|(&row, x)| f64::from(f32::from_le_bytes(row)) * x).sum(),
        Numbers::F64(row) => row.iter().zip(x).map(|(&row, x)| f64::from_le_bytes(row) * x).sum(),
        Numbers::I16(_) => row.iter().zip(x).map(|(row, x)| row * x).sum(),
    }
}
