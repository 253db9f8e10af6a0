//! Binding a file to parameters and memory, and the step.
//!
//! Binding fuses the stages (see `vademecum_format::scheme`), so a step is one small matrix-vector product. The diagonal
//! structure keeps a 3×3 block per mode and takes any `Δt`, stiffness, density and damping exactly; the block structure
//! keeps the dense `3r × 3r` map and takes what its axes allow.

use crate::axes::{Factors, StagePlace};
use crate::error::{BindError, StepError};
use crate::kernel::{LANES, TILE, step_dense, step_diagonal};
use crate::loads::Loads;
use crate::scalar::Scalar;
use crate::state::State;
use vademecum_format::scheme::{
    MAX_STAGES, SchemeTable, StageCoefficients, StepParameters, fuse_into, fuse_work_len,
};
use vademecum_format::{File, Metadata, Numbers, SectionKind, StructureCertificate};

/// The two ways a step can be held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// One 3×3 block per mode: `9r` multiply-adds.
    Diagonal,
    /// One dense map: `9r²` multiply-adds.
    Block,
}

/// Which structure a scene shall take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StructureChoice {
    /// The cheapest whose certificate keeps the tolerance, or else the one with the smaller certified error.
    #[default]
    Auto,
    /// The diagonal one.
    Diagonal,
    /// The block one.
    Block,
}

/// What a scene is bound to; [`SceneOptions::default`] is the file as it was built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneOptions {
    /// Structure of the step.
    pub structure: StructureChoice,
    /// Trajectory error (relative, as in the certificate) that [`StructureChoice::Auto`] accepts. A structure within 1.1 times
    /// its projection floor + 1e-6 is accepted in any case: no structure on this basis does better.
    pub tolerance: f64,
    /// `Δt` \[s\]; the file's if `None`.
    pub time_step: Option<f64>,
    /// Scale of the stiffness.
    pub stiffness: f64,
    /// Scale of the density.
    pub density: f64,
    /// Rayleigh `α` \[1/s\]; the file's if `None`.
    pub alpha: Option<f64>,
    /// Rayleigh `β` \[s\]; the file's if `None`.
    pub beta: Option<f64>,
    /// An unloaded body is put at rest once the sum of its `3r` absolute state numbers \[m kg^½\] is at or below this. With 0 it
    /// rests when every number has fallen below [`Scalar::FLOOR`].
    pub rest_below: f64,
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self {
            structure: StructureChoice::Auto,
            tolerance: 0.0,
            time_step: None,
            stiffness: 1.0,
            density: 1.0,
            alpha: None,
            beta: None,
            rest_below: 0.0,
        }
    }
}

/// How much memory to lend, in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Of `T`, to the scene.
    pub scene: usize,
    /// Of `f64`, to [`Scene::bind`] while it runs.
    pub work: usize,
    /// Of `T`, to each [`State`].
    pub state: usize,
    /// Of `T`, to each [`Loads`].
    pub loads: usize,
}

/// What a step found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The body moves or is loaded.
    Moving,
    /// The body is unloaded and at rest: its state is zero and further steps cost nothing.
    AtRest,
}

/// The lengths a scene, its states and its loads agree on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    pub structure: Structure,
    pub r: usize,
    pub n_stages: usize,
    pub n_terms: usize,
}

impl Shape {
    /// Distance between ζ, Δt ζ̇ and Δt² ζ̈ in a state.
    pub const fn stride(&self) -> usize {
        match self.structure {
            Structure::Diagonal => self.r.next_multiple_of(LANES),
            Structure::Block => self.r,
        }
    }

    /// Length of one state, padded for the kernel.
    pub const fn padded(&self) -> usize {
        match self.structure {
            Structure::Diagonal => 3 * self.stride(),
            Structure::Block => (3 * self.r).next_multiple_of(TILE),
        }
    }

    /// A state: old and new.
    pub const fn state_len(&self) -> usize {
        2 * self.padded()
    }

    /// Length of the step map.
    const fn map_len(&self) -> usize {
        match self.structure {
            Structure::Diagonal => 9 * self.stride(),
            Structure::Block => self.padded() * 3 * self.r,
        }
    }

    /// Length of one stage's load map.
    pub const fn load_map_len(&self) -> usize {
        match self.structure {
            Structure::Diagonal => self.padded(),
            Structure::Block => self.padded() * self.r,
        }
    }

    const fn sizes(&self) -> Sizes {
        let (r, n) = (self.r, self.n_stages);
        let work = match self.structure {
            Structure::Diagonal => 0,
            Structure::Block => (n + 9 + 3 * n) * r * r + fuse_work_len(r),
        };
        Sizes {
            scene: self.map_len() + n * self.load_map_len() + n * self.n_terms,
            work,
            state: self.state_len(),
            loads: self.padded() + (2 + n) * r,
        }
    }
}

/// Sections a scene reads while it runs; `None` if absent or compressed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sections<'m> {
    pub surface: Option<Numbers<'m>>,
    pub interior: Option<Numbers<'m>>,
    pub block_load: Option<Numbers<'m>>,
    pub pattern_basis: Option<Numbers<'m>>,
    pub pattern_block: Option<Numbers<'m>>,
    pub probes: Option<Numbers<'m>>,
    /// `BᵀKB`: `(r)` for the diagonal structure, `(r, r)` for the block structure.
    pub stiffness: Numbers<'m>,
}

/// An opened file bound to parameters, ready to step. Immutable; states and loads are apart.
#[derive(Debug)]
pub struct Scene<'m, T> {
    pub(crate) shape: Shape,
    pub(crate) metadata: Metadata<'m>,
    pub(crate) parameters: StepParameters,
    pub(crate) sections: Sections<'m>,
    rest_below: T,
    map: &'m [T],
    load_maps: &'m [T],
    pub(crate) weights: &'m [T],
}

impl<'m, T: Scalar> Scene<'m, T> {
    /// The memory a scene of these options asks for.
    ///
    /// # Errors
    /// [`BindError::NoStructure`] and [`BindError::BadOption`].
    pub fn sizes(file: &File<'_>, options: &SceneOptions) -> Result<Sizes, BindError> {
        Ok(shape(file.metadata(), options)?.sizes())
    }

    /// Binds a file. `memory` and `work` hold at least what [`Scene::sizes`] says; what is in them does not matter.
    ///
    /// Cost: `O(r)` for the diagonal structure, `O(r³)` for the block structure. The basis is not touched.
    ///
    /// # Errors
    /// [`BindError`].
    pub fn bind(
        file: &File<'m>,
        options: &SceneOptions,
        memory: &'m mut [T],
        work: &mut [f64],
    ) -> Result<Self, BindError> {
        let metadata = *file.metadata();
        let shape = shape(&metadata, options)?;
        let sizes = shape.sizes();
        let parameters = step_parameters(&metadata, options);
        let short = |found, needed| BindError::LentMemory { found, needed };
        let (lent, lent_work) = (memory.len(), work.len());
        let memory = memory
            .get_mut(..sizes.scene)
            .ok_or(short(lent, sizes.scene))?;
        let work = work
            .get_mut(..sizes.work)
            .ok_or(short(lent_work, sizes.work))?;
        memory.fill(T::ZERO);
        let (map, rest) = memory
            .split_at_mut_checked(shape.map_len())
            .unwrap_or_default();
        let (load_maps, weights) = rest
            .split_at_mut_checked(shape.n_stages * shape.load_map_len())
            .unwrap_or_default();
        let sections = sections(file, shape.structure)?;
        match shape.structure {
            Structure::Diagonal => {
                fuse_modes(
                    &metadata.scheme,
                    &parameters,
                    &sections.stiffness,
                    shape,
                    map,
                    load_maps,
                )?;
            }
            Structure::Block => {
                fuse_block(
                    file,
                    &parameters,
                    shape,
                    Lent {
                        map,
                        load_maps,
                        weights,
                        work,
                    },
                )?;
            }
        }
        let mut bound = map.iter().chain(load_maps.iter()).chain(weights.iter());
        if bound.any(|value| !value.to_f64().is_finite()) {
            return Err(BindError::NotFinite);
        }
        let rest_below = T::from_f64(options.rest_below);
        Ok(Self {
            shape,
            metadata,
            parameters,
            sections,
            rest_below,
            map,
            load_maps,
            weights,
        })
    }

    /// The structure the scene took.
    #[must_use]
    pub const fn structure(&self) -> Structure {
        self.shape.structure
    }

    /// `r`: the number of modes.
    #[must_use]
    pub const fn n_modes(&self) -> usize {
        self.shape.r
    }

    /// What the file says about itself.
    #[must_use]
    pub const fn metadata(&self) -> &Metadata<'m> {
        &self.metadata
    }

    /// The parameters the scene is bound to.
    #[must_use]
    pub const fn parameters(&self) -> &StepParameters {
        &self.parameters
    }

    /// Instants at which a step needs a changing load, as fractions of it: 0, then one per stage; the rest is 0.
    #[must_use]
    pub fn instants(&self) -> [f64; 1 + MAX_STAGES] {
        self.metadata.scheme.instants()
    }

    /// Advances `state` by `Δt` under `loads`.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn step(
        &self,
        state: &mut State<'_, T>,
        loads: &Loads<'_, T>,
    ) -> Result<Status, StepError> {
        if state.shape != self.shape || loads.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        if state.at_rest && !loads.active {
            return Ok(Status::AtRest);
        }
        let (old, new, load) = (&*state.now, &mut *state.next, &*loads.increment);
        let magnitude = match self.shape.structure {
            Structure::Diagonal => {
                step_diagonal(self.map.as_chunks().0.as_chunks().0, old, load, new)
            }
            Structure::Block => {
                step_dense(self.map.as_chunks().0, 3 * self.shape.r, old, load, new)
            }
        };
        if !magnitude.to_f64().is_finite() {
            return Err(StepError::NotFinite);
        }
        core::mem::swap(&mut state.now, &mut state.next);
        state.at_rest = false;
        if !loads.active && (magnitude <= self.rest_below || magnitude == T::ZERO) {
            state.rest();
            return Ok(Status::AtRest);
        }
        Ok(Status::Moving)
    }

    /// Sets displacement and velocity in reduced coordinates and computes the acceleration that goes with them under `loads`
    /// (their force at the start of a step): `ζ̈ = (BᵀF − s_K BᵀKB ζ)/s_ρ − (α + β s_K/s_ρ BᵀKB) ζ̇`.
    ///
    /// `zeta` \[m kg^½\] and `zeta_dot` \[m kg^½/s\] have length `r`.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn set(
        &self,
        state: &mut State<'_, T>,
        zeta: &[f64],
        zeta_dot: &[f64],
        loads: &Loads<'_, T>,
    ) -> Result<(), StepError> {
        let r = self.shape.r;
        if state.shape != self.shape
            || loads.shape != self.shape
            || zeta.len() != r
            || zeta_dot.len() != r
        {
            return Err(StepError::Mismatch);
        }
        let StepParameters {
            time_step: dt,
            alpha,
            beta,
            density,
            stiffness,
        } = self.parameters;
        let spare = &mut *state.next;
        spare.fill(T::ZERO);
        let stride = self.shape.stride();
        for (k, ((&zeta_k, &rate_k), force)) in zeta
            .iter()
            .zip(zeta_dot)
            .zip(loads.force.iter())
            .enumerate()
        {
            let elastic =
                stiffness * (self.stiffness_row(k, zeta) + beta * self.stiffness_row(k, zeta_dot));
            let acceleration = (force.to_f64() - elastic) / density - alpha * rate_k;
            for (place, value) in [zeta_k, dt * rate_k, dt * dt * acceleration]
                .into_iter()
                .enumerate()
            {
                let value = T::from_f64(value);
                if !value.to_f64().is_finite() {
                    return Err(StepError::NotFinite);
                }
                spare
                    .iter_mut()
                    .skip(place * stride + k)
                    .take(1)
                    .for_each(|out| *out = value);
            }
        }
        core::mem::swap(&mut state.now, &mut state.next);
        state.at_rest = state.now.iter().all(|&value| value == T::ZERO);
        Ok(())
    }

    /// `Σ_j (BᵀKB)_kj x_j`.
    pub(crate) fn stiffness_row(&self, k: usize, x: &[f64]) -> f64 {
        let r = self.shape.r;
        match self.shape.structure {
            Structure::Diagonal => {
                self.sections.stiffness.get(k).unwrap_or_default()
                    * x.get(k).copied().unwrap_or_default()
            }
            Structure::Block => {
                let row = self.sections.stiffness.row(k * r, r);
                row.map_or(0.0, |row| row.iter().zip(x).map(|(k, x)| k * x).sum())
            }
        }
    }

    /// The load map of a stage.
    pub(crate) fn load_map(&self, stage: usize) -> &[T] {
        let length = self.shape.load_map_len();
        self.load_maps
            .get(stage * length..(stage + 1) * length)
            .unwrap_or_default()
    }
}

fn shape(metadata: &Metadata<'_>, options: &SceneOptions) -> Result<Shape, BindError> {
    for value in [options.tolerance, options.rest_below] {
        if value.is_nan() || value < 0.0 {
            return Err(BindError::BadOption { value });
        }
    }
    let structure = choose(metadata, options).ok_or(BindError::NoStructure)?;
    let n_terms = if structure == Structure::Block {
        metadata.n_terms as usize
    } else {
        0
    };
    let n_stages = metadata.scheme.active().len();
    Ok(Shape {
        structure,
        r: metadata.n_modes as usize,
        n_stages,
        n_terms,
    })
}

fn choose(metadata: &Metadata<'_>, options: &SceneOptions) -> Option<Structure> {
    let diagonal = metadata.diagonal.then_some(Structure::Diagonal);
    let block = metadata.block.then_some(Structure::Block);
    match options.structure {
        StructureChoice::Diagonal => diagonal,
        StructureChoice::Block => block,
        StructureChoice::Auto if diagonal.is_some() && block.is_some() => {
            let [a, b] = [&metadata.certificate.diagonal, &metadata.certificate.block];
            let error = |c: &StructureCertificate| {
                if c.trajectory_error.is_nan() {
                    f64::MAX
                } else {
                    c.trajectory_error
                }
            };
            let keeps =
                |c| error(c) <= options.tolerance || error(c) <= 1.1 * c.projection_floor + 1e-6;
            if keeps(a) || (!keeps(b) && error(a) <= error(b)) {
                diagonal
            } else {
                block
            }
        }
        StructureChoice::Auto => diagonal.or(block),
    }
}

fn step_parameters(metadata: &Metadata<'_>, options: &SceneOptions) -> StepParameters {
    StepParameters {
        time_step: options.time_step.unwrap_or(metadata.time_step),
        alpha: options.alpha.unwrap_or(metadata.alpha),
        beta: options.beta.unwrap_or(metadata.beta),
        density: options.density,
        stiffness: options.stiffness,
    }
}

fn sections<'m>(file: &File<'m>, structure: Structure) -> Result<Sections<'m>, BindError> {
    use SectionKind as S;
    let optional = |kind| {
        file.section(kind)
            .and_then(|section| section.numbers().ok())
    };
    let kind = if structure == Structure::Diagonal {
        S::Eigenvalues
    } else {
        S::ReducedStiffness
    };
    Ok(Sections {
        surface: optional(S::SurfaceBasis),
        interior: optional(S::InteriorBasis),
        block_load: optional(S::BlockLoad),
        pattern_basis: optional(S::PatternBasis),
        pattern_block: optional(S::PatternBlock),
        probes: optional(S::ProbeRows),
        stiffness: Numbers::F64(needed(file, kind)?),
    })
}

/// Numbers of a section the file cannot be without.
fn needed<'m>(file: &File<'m>, kind: SectionKind) -> Result<&'m [[u8; 8]], BindError> {
    let missing = vademecum_format::FormatError::Missing {
        kind: kind.number(),
    };
    Ok(file.section(kind).ok_or(missing)?.f64s()?)
}

/// The 3×3 block and the load vectors of each mode: `E = −θλ/(1 + θλ)`, and `H = B/(1 + θλ)` goes into the load map.
fn fuse_modes<T: Scalar>(
    scheme: &SchemeTable,
    parameters: &StepParameters,
    lambdas: &Numbers<'_>,
    shape: Shape,
    map: &mut [T],
    load_maps: &mut [T],
) -> Result<(), BindError> {
    let mut theta = [0.0; MAX_STAGES];
    for (stage, theta) in theta.iter_mut().take(shape.n_stages).enumerate() {
        *theta = StageCoefficients::new(scheme, parameters, stage)?.theta;
    }
    let (mut d, mut loads, mut work) = ([0.0; 9], [0.0; 3 * MAX_STAGES], [0.0; fuse_work_len(1)]);
    for (k, lambda) in lambdas.iter().enumerate() {
        let e = theta.map(|theta| -theta * lambda / (1.0 + theta * lambda));
        let e = e.get(..shape.n_stages).unwrap_or_default();
        let loads = loads.get_mut(..3 * shape.n_stages).unwrap_or_default();
        fuse_into(scheme, parameters, 1, e, &mut d, loads, &mut work)?;
        for (place, &value) in d.iter().enumerate() {
            // Column-major 3×3 to row-major, one row of LANES modes per coefficient.
            let row_major = 3 * (place % 3) + place / 3;
            let at = (k / LANES * 9 + row_major) * LANES + k % LANES;
            map.iter_mut()
                .skip(at)
                .take(1)
                .for_each(|out| *out = T::from_f64(value));
        }
        for (place, &value) in loads.iter().enumerate() {
            let (stage, row) = (place / 3, place % 3);
            let h = value * (1.0 + e.get(stage).copied().unwrap_or_default());
            let at = stage * shape.load_map_len() + row * shape.stride() + k;
            load_maps
                .iter_mut()
                .skip(at)
                .take(1)
                .for_each(|out| *out = T::from_f64(h));
        }
    }
    Ok(())
}

/// Memory lent to [`fuse_block`].
struct Lent<'l, T> {
    map: &'l mut [T],
    load_maps: &'l mut [T],
    weights: &'l mut [T],
    work: &'l mut [f64],
}

/// The dense map: `E_i = Σ_t g_t E_t` at each stage's parameters, fused, rounded and laid out in tiles.
fn fuse_block<T: Scalar>(
    file: &File<'_>,
    parameters: &StepParameters,
    shape: Shape,
    lent: Lent<'_, T>,
) -> Result<(), BindError> {
    let metadata = file.metadata();
    let square = shape.r * shape.r;
    let factors = Factors {
        points: needed(file, SectionKind::AxisPoints)?,
        factors: needed(file, SectionKind::Factors)?,
    };
    let terms = needed(file, SectionKind::BlockState)?;
    let (e, rest) = lent
        .work
        .split_at_mut_checked(shape.n_stages * square)
        .unwrap_or_default();
    let (d, rest) = rest.split_at_mut_checked(9 * square).unwrap_or_default();
    let (loads, work) = rest
        .split_at_mut_checked(3 * shape.n_stages * square)
        .unwrap_or_default();
    e.fill(0.0);
    // `next` in the loop, not `zip`: zipped chunks divide by their sizes, and the compiler cannot see that they are not zero.
    let mut weights = lent.weights.chunks_exact_mut(shape.n_terms.max(1));
    for (stage, e) in e.chunks_exact_mut(square.max(1)).enumerate() {
        let weights = weights.next().unwrap_or_default();
        let theta = allowed_theta(metadata, parameters, stage)?;
        let place = StagePlace {
            stage,
            theta,
            parameters: *parameters,
        };
        for (t, (term, out)) in terms.chunks_exact(square.max(1)).zip(weights).enumerate() {
            let weight = factors.weight(metadata, t, &place)?;
            *out = T::from_f64(weight);
            e.iter_mut()
                .zip(term)
                .for_each(|(e, &bytes)| *e += weight * f64::from_le_bytes(bytes));
        }
    }
    fuse_into(&metadata.scheme, parameters, shape.r, e, d, loads, work)?;
    lay_out(d, 3 * shape.r, lent.map);
    let mut load_maps = lent.load_maps.chunks_exact_mut(shape.load_map_len().max(1));
    for columns in loads.chunks_exact(square.saturating_mul(3).max(1)) {
        let out = load_maps.next().unwrap_or_default();
        lay_out(columns, 3 * shape.r, out);
    }
    Ok(())
}

/// `θ` of a stage, if the block structure was built for it: parameters without an axis must be the file's, up to rounding
/// (a few operations: 1e-12).
fn allowed_theta(
    metadata: &Metadata<'_>,
    asked: &StepParameters,
    stage: usize,
) -> Result<f64, BindError> {
    use vademecum_format::AxisRole as R;
    let requested = StageCoefficients::new(&metadata.scheme, asked, stage)?.theta;
    let has = |role: R| metadata.active_axes().iter().any(|axis| axis.role == role);
    let pick = |role, asked, built| if has(role) { asked } else { built };
    let reference = StepParameters {
        time_step: pick(R::TimeStep, asked.time_step, metadata.time_step),
        alpha: pick(R::Alpha, asked.alpha, metadata.alpha),
        beta: pick(R::Beta, asked.beta, metadata.beta),
        density: 1.0,
        stiffness: 1.0,
    };
    let built = StageCoefficients::new(&metadata.scheme, &reference, stage)?.theta;
    if has(R::Theta) || (requested - built).abs() <= 1e-12 * built {
        return Ok(requested);
    }
    Err(BindError::Fixed {
        stage,
        requested,
        built,
    })
}

/// Column-major `(rows, any)` to tiles of [`TILE`] rows, each tile column by column; the padding stays zero.
fn lay_out<T: Scalar>(columns: &[f64], rows: usize, tiles: &mut [T]) {
    let n_columns = columns.len() / rows.max(1);
    for (c, column) in columns.chunks_exact(rows.max(1)).enumerate() {
        for (tile, part) in column.chunks(TILE).enumerate() {
            let at = (tile * n_columns + c) * TILE;
            let place = tiles.iter_mut().skip(at).zip(part);
            place.for_each(|(out, &value)| *out = T::from_f64(value));
        }
    }
}
