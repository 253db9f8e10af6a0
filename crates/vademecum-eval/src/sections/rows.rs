//! The rows of the basis that outputs read, and what is read of them.

use crate::base::error::OutputError;
use crate::base::lend::Lender;
use crate::base::scalar::Scalar;
use crate::kernels::coordinates::Coordinates;
use crate::sections::place::Place;
use crate::sections::reconstruct::reconstruct;
use vademecum_format::{File, Numbers, SectionKind};

/// Which field an output is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Displacement \[m\].
    Displacement,
    /// Velocity \[m/s\].
    Velocity,
}

/// The rows of the basis that outputs read; `None` where they are absent or compressed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'m> {
    pub surface: Option<Numbers<'m>>,
    pub interior: Option<Numbers<'m>>,
    pub probes: Option<Numbers<'m>>,
    r: usize,
    n_nodes: usize,
    n_surface_nodes: usize,
    n_probes: usize,
}

/// Multiplier of the basis: reduced coordinates of length `r`, and a scale.
pub(crate) type Factors<'s, T> = (&'s [T], f64);

impl<'m> Rows<'m> {
    /// Looks them up.
    pub fn of(file: &File<'m>) -> Self {
        let optional = |kind| file.section(kind).and_then(|section| section.numbers().ok());
        let m = file.metadata();
        let [r, n_nodes, n_surface_nodes, n_probes] =
            [m.n_modes, m.n_nodes, m.n_surface_nodes, m.n_probes].map(|n| n as usize);
        Self {
            surface: optional(SectionKind::SurfaceBasis),
            interior: optional(SectionKind::InteriorBasis),
            probes: optional(SectionKind::ProbeRows),
            r,
            n_nodes,
            n_surface_nodes,
            n_probes,
        }
    }

    /// Row of probe `index`.
    pub fn probe_row(&self, index: usize) -> Result<Numbers<'m>, OutputError> {
        let rows = self.probes.ok_or(OutputError::Missing { kind: SectionKind::ProbeRows })?;
        let row = rows.row(index.saturating_mul(self.r), self.r).filter(|_| index < self.n_probes);
        row.ok_or(OutputError::OutOfRange { index, count: self.n_probes })
    }

    /// Value of probe `index`.
    pub fn probe<T: Scalar>(&self, index: usize, (x, scale): Factors<'_, T>) -> Result<f64, OutputError> {
        Ok(dot(self.probe_row(index)?, x) * scale)
    }

    /// Row of a component at `node`.
    #[cfg(feature = "full")]
    pub fn node_row(&self, node: usize, component: usize) -> Result<Numbers<'m>, OutputError> {
        let beyond = OutputError::OutOfRange { index: node, count: self.n_nodes };
        let (rows, place) = match node.checked_sub(self.n_surface_nodes) {
            None => (self.surface()?, node),
            Some(place) => (self.interior()?, place),
        };
        let at = place.saturating_mul(3).saturating_add(component).saturating_mul(self.r);
        rows.row(at, self.r).filter(|_| node < self.n_nodes).ok_or(beyond)
    }

    /// Three components at `node`.
    pub fn node<T: Scalar>(&self, node: usize, (x, scale): Factors<'_, T>) -> Result<[f64; 3], OutputError> {
        let beyond = OutputError::OutOfRange { index: node, count: self.n_nodes };
        if node >= self.n_nodes {
            return Err(beyond);
        }
        let (rows, place) = match node.checked_sub(self.n_surface_nodes) {
            None => (self.surface()?, node),
            Some(place) => (self.interior()?, place),
        };
        let mut value = [0.0; 3];
        for (component, value) in value.iter_mut().enumerate() {
            let row = rows.row((3 * place + component) * self.r, self.r).ok_or(beyond)?;
            *value = dot(row, x) * scale;
        }
        Ok(value)
    }

    /// Three components at a place.
    pub fn point<T: Scalar>(&self, place: &Place, factors: Factors<'_, T>) -> Result<[f64; 3], OutputError> {
        place.check()?;
        let mut value = [0.0; 3];
        for (node, weight) in place.entries() {
            let at_node = self.node(node as usize, factors)?;
            value.iter_mut().zip(at_node).for_each(|(sum, x)| *sum += weight * x);
        }
        Ok(value)
    }

    /// The surface, `out` of shape `(n_surface_nodes, 3)`.
    pub fn surface_into<T: Scalar>(
        &self,
        (x, scale): Factors<'_, T>,
        out: &mut [T],
    ) -> Result<(), OutputError> {
        expect_len(out, 3 * self.n_surface_nodes)?;
        Ok(reconstruct(self.surface()?, x, T::from_f64(scale), out)?)
    }

    /// The whole body, `out` of shape `(n_nodes, 3)`.
    pub fn body_into<T: Scalar>(&self, factors: Factors<'_, T>, out: &mut [T]) -> Result<(), OutputError> {
        expect_len(out, 3 * self.n_nodes)?;
        let mut out = Lender::new(out);
        let (surface, interior) = (out.take(3 * self.n_surface_nodes)?, out.rest());
        if !interior.is_empty() {
            reconstruct(self.interior()?, factors.0, T::from_f64(factors.1), interior)?;
        }
        self.surface_into(factors, surface)
    }

    fn surface(&self) -> Result<Numbers<'m>, OutputError> {
        self.surface.ok_or(OutputError::Missing { kind: SectionKind::SurfaceBasis })
    }

    fn interior(&self) -> Result<Numbers<'m>, OutputError> {
        self.interior.ok_or(OutputError::Missing { kind: SectionKind::InteriorBasis })
    }
}

fn expect_len<T>(out: &[T], needed: usize) -> Result<(), OutputError> {
    if out.len() == needed { Ok(()) } else { Err(OutputError::Length { found: out.len(), needed }) }
}

/// Displacement or velocity of a state as coordinates and a scale.
pub(crate) fn factors<'s, T: Scalar>(y: &'s Coordinates<'_, T>, field: Field) -> Factors<'s, T> {
    match field {
        Field::Displacement => (y.part(0), 1.0),
        Field::Velocity => (y.part(1), 1.0 / y.time_step),
    }
}

/// `Σ_k row_k x_k`; the kind of the numbers is looked at once a row.
pub(crate) fn dot<T: Scalar>(row: Numbers<'_>, x: &[T]) -> f64 {
    let x = x.iter().map(|x| x.to_f64());
    match row {
        Numbers::F32(row) => row.iter().zip(x).map(|(&row, x)| f64::from(f32::from_le_bytes(row)) * x).sum(),
        Numbers::F64(row) => row.iter().zip(x).map(|(&row, x)| f64::from_le_bytes(row) * x).sum(),
        Numbers::I16(_) => row.iter().zip(x).map(|(row, x)| row * x).sum(),
    }
}
