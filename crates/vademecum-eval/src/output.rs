//! Reading a state: probes, nodes, the surface, the whole body, energy. Each costs what it reads and nothing else.

use crate::error::OutputError;
use crate::quantised::reconstruct_quantised;
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

fn dot<T: Scalar>(row: Numbers<'_>, x: &[T]) -> f64 {
    row.iter().zip(x).map(|(row, x)| row * x.to_f64()).sum()
}

/// `out_d = scale Σ_k B_dk x_k` for all rows of `B`.
fn reconstruct<T: Scalar>(rows: Numbers<'_>, x: &[T], scale: T, out: &mut [T]) {
    match rows {
        Numbers::F32(rows) => {
            reconstruct_with(rows, x, scale, out, |bytes| T::from_f32(f32::from_le_bytes(bytes)))
        }
        Numbers::F64(rows) => {
            reconstruct_with(rows, x, scale, out, |bytes| T::from_f64(f64::from_le_bytes(bytes)))
        }
        Numbers::I16(rows) => reconstruct_quantised(rows, x, scale, out),
    }
}

/// Columns of a row handled at once.
const WIDTH: usize = 8;
/// Rows of [`WIDTH`] columns handled at once: their sums are then finished side by side.
const ROWS: usize = 4;

#[inline(always)]
fn reconstruct_with<T: Scalar, const N: usize>(
    rows: &[[u8; N]],
    x: &[T],
    scale: T,
    out: &mut [T],
    read: impl Fn([u8; N]) -> T,
) {
    let (wide, narrow) = x.as_chunks::<WIDTH>();
    if let ([x], []) = (wide, narrow) {
        return reconstruct_eight(rows, x, scale, out, read);
    }
    for (row, out) in rows.chunks_exact(x.len().max(1)).zip(out) {
        let (row_wide, row_narrow) = row.as_chunks::<WIDTH>();
        let mut sums = [T::ZERO; WIDTH];
        for (row, x) in row_wide.iter().zip(wide) {
            for k in 0..WIDTH {
                sums[k] += read(row[k]) * x[k];
            }
        }
        for ((bytes, &x), sum) in row_narrow.iter().zip(narrow).zip(&mut sums) {
            *sum += read(*bytes) * x;
        }
        let [a, b, c, d, e, f, g, h] = sums;
        *out = scale * (((a + e) + (c + g)) + ((b + f) + (d + h)));
    }
}

/// The same bits for 8 modes, where finishing the sum of each row alone would cost more than reading it.
#[inline(always)]
fn reconstruct_eight<T: Scalar, const N: usize>(
    rows: &[[u8; N]],
    x: &[T; WIDTH],
    scale: T,
    out: &mut [T],
    read: impl Fn([u8; N]) -> T,
) {
    let (blocks, rest) = rows.as_chunks::<WIDTH>().0.as_chunks::<ROWS>();
    let (out, out_rest) = out.as_chunks_mut::<ROWS>();
    let half = |row: &[[u8; N]; WIDTH]| {
        let row = row.map(&read);
        let mut sums = [T::ZERO; WIDTH / 2];
        for k in 0..WIDTH / 2 {
            sums[k] = row[k] * x[k] + row[k + 4] * x[k + 4];
        }
        sums
    };
    for (rows, out) in blocks.iter().zip(out) {
        // Keeps the compiler from taking several blocks at once, which with AVX2 and AVX-512 it does byte by byte, six times slower.
        let rows = core::hint::black_box(rows);
        let sums = [half(&rows[0]), half(&rows[1]), half(&rows[2]), half(&rows[3])];
        for row in 0..ROWS {
            out[row] = scale * ((sums[row][0] + sums[row][2]) + (sums[row][1] + sums[row][3]));
        }
    }
    for (row, out) in rest.iter().zip(out_rest) {
        let sums = half(row);
        *out = scale * ((sums[0] + sums[2]) + (sums[1] + sums[3]));
    }
}
