//! Reading a state: probes, nodes, the surface, the whole body, energy. Each costs what it reads and nothing
//! else.

use crate::coordinates::Coordinates;
use crate::error::OutputError;
use crate::lend::Lender;
use crate::reconstruct::reconstruct;
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::state::State;
use crate::surface::SurfacePoint;
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

/// What multiplies the basis: reduced coordinates of length `r`, and a scale.
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

    /// Value of probe `index`.
    pub fn probe<T: Scalar>(&self, index: usize, (x, scale): Factors<'_, T>) -> Result<f64, OutputError> {
        let rows = self.probes.ok_or(OutputError::Missing { kind: SectionKind::ProbeRows })?;
        let row = rows.row(index.saturating_mul(self.r), self.r).filter(|_| index < self.n_probes);
        let row = row.ok_or(OutputError::OutOfRange { index, count: self.n_probes })?;
        Ok(dot(row, x) * scale)
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

    /// Three components at a point of the surface.
    pub fn point<T: Scalar>(
        &self,
        point: &SurfacePoint,
        factors: Factors<'_, T>,
    ) -> Result<[f64; 3], OutputError> {
        let mut value = [0.0; 3];
        for (&node, weight) in point.nodes.iter().zip(point.weights) {
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

impl<T: Scalar> Scene<'_, T> {
    /// Value of probe `index`. `O(r)`.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// let [displacement, velocity] = [Field::Displacement, Field::Velocity].map(|field| scene.probe(&state, 0, field));
    /// assert!(displacement? != 0.0 && velocity? != 0.0); // one step after a load came on
    /// assert_eq!(scene.probe(&state, 3, Field::Velocity), Err(OutputError::OutOfRange { index: 3, count: 3 }));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn probe(&self, state: &State<'_, T>, index: usize, field: Field) -> Result<f64, OutputError> {
        self.sections.rows.probe(index, self.factors(state, field)?)
    }

    /// Displacement or velocity of `node` (file order), three components. `O(r)`.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// // The surface holds the first nodes of the file, three numbers each.
    /// let mut surface = vec![0.0; 3 * file.metadata().n_surface_nodes as usize];
    /// scene.surface_into(&state, Field::Displacement, &mut surface)?;
    /// let node = scene.node(&state, 5, Field::Displacement)?;
    /// for component in 0..3 {
    ///     assert!((node[component] - surface[3 * 5 + component]).abs() < 1e-15);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn node(&self, state: &State<'_, T>, node: usize, field: Field) -> Result<[f64; 3], OutputError> {
        self.sections.rows.node(node, self.factors(state, field)?)
    }

    /// Displacement or velocity of a point of the surface, three components. `O(r)`.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// // Half way between two nodes, the mean of both.
    /// let middle = SurfacePoint { nodes: [0, 1, 3], weights: [0.5, 0.5, 0.0], position: [0.0; 3], distance: 0.0 };
    /// let there = scene.point(&state, &middle, Field::Displacement)?;
    /// let [a, b] = [scene.node(&state, 0, Field::Displacement)?, scene.node(&state, 1, Field::Displacement)?];
    /// for component in 0..3 {
    ///     assert_eq!(there[component], 0.5 * a[component] + 0.5 * b[component]);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn point(
        &self,
        state: &State<'_, T>,
        point: &SurfacePoint,
        field: Field,
    ) -> Result<[f64; 3], OutputError> {
        self.sections.rows.point(point, self.factors(state, field)?)
    }

    /// The surface, `out` of shape `(n_surface_nodes, 3)`. Bound by reading the basis once.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// let mut moved = vec![0.0; 3 * file.metadata().n_surface_nodes as usize]; // a vertex array
    /// scene.surface_into(&state, Field::Displacement, &mut moved)?;
    /// assert!(moved.iter().any(|&x| x != 0.0));
    /// let wrong = scene.surface_into(&state, Field::Displacement, &mut moved[1..]);
    /// assert_eq!(wrong, Err(OutputError::Length { found: 26, needed: 27 }));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn surface_into(&self, state: &State<'_, T>, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        self.sections.rows.surface_into(self.factors(state, field)?, out)
    }

    /// The whole body, `out` of shape `(n_nodes, 3)`. Bound by reading the basis once.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn body_into(&self, state: &State<'_, T>, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        self.sections.rows.body_into(self.factors(state, field)?, out)
    }

    /// Kinetic plus elastic energy \[J\]: `½ s_ρ ζ̇ᵀ M_r ζ̇ + ½ s_K ζᵀ K_r ζ`, with the scales of the regions
    /// in `M_r = Σ ρ_q BᵀM_qB` and `K_r = Σ κ_q BᵀK_qB`. `O(r)`, or `O(r²)` times the regions that count.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// assert!(scene.energy(&state)? > 0.0);
    /// state.rest();
    /// assert_eq!(scene.energy(&state)?, 0.0);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError::Mismatch`].
    pub fn energy(&self, state: &State<'_, T>) -> Result<f64, OutputError> {
        self.check(state)?;
        self.equation().energy(&state.y).ok_or(OutputError::Mismatch)
    }

    fn factors<'s>(&self, state: &'s State<'_, T>, field: Field) -> Result<Factors<'s, T>, OutputError> {
        self.check(state)?;
        Ok(factors(&state.y, field))
    }

    fn check(&self, state: &State<'_, T>) -> Result<(), OutputError> {
        if state.shape == self.shape { Ok(()) } else { Err(OutputError::Mismatch) }
    }
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
