//! The dense step of a block scene taken apart into independent modes, once per setting of its parameters.
//!
//! With live regions the stages of a step are functions of one pencil, `I + E_i = (M̃ + θ_i K̃)⁻¹ M̃`
//! (`docs/explanation/why-these-defaults.md`), so they share their eigenvectors: `E_i = X diag(e_i) X⁻¹` with
//! one real `X`. In `η = X⁻¹ζ` a step is `r` independent 3×3 blocks. A call of [`Modal::march`] goes to `η`,
//! takes any number of such steps under the same loads, and comes back; states, loads and outputs of the
//! scene stay as they are.
//!
//! The odd thing: `M̃` and `K̃` are not in the file, only `E`, so the symmetric form of the problem cannot be
//! had; `E` itself is diagonalised, as a general matrix. What the stages do not share is measured
//! ([`Modal::remainder`]) and left out.

use crate::base::error::{BindError, StepError};
use crate::base::lend::{Lender, Short, put};
use crate::base::options::{Status, Structure};
use crate::base::scalar::Scalar;
use crate::kernels::kernel::{LANES, TILE, add_dense, blocks, step_diagonal};
use crate::motion::eigen::diagonalise;
use crate::scene::bind::{Asked, lay_out_columns, place_in_modes, stage_responses};
use crate::scene::loads::Loads;
use crate::scene::scene::Scene;
use crate::scene::shape::Shape;
use crate::scene::state::State;
use vademecum_format::scheme::{MAX_STAGES, fuse_into, fuse_work_len};

/// What the sizes of both kernels, [`LANES`] and [`TILE`], divide.
const STRIDE: usize = 48;

/// The modes of a block scene at its parameters, in lent memory.
#[derive(Debug)]
pub struct Modal<'m, T> {
    shape: Shape,
    generation: u64,
    remainder: f64,
    /// `D` of every mode, as the diagonal kernel wants it.
    blocks: &'m mut [T],
    /// `X⁻¹`, in tiles.
    to: &'m mut [T],
    /// `X`, in tiles.
    from: &'m mut [T],
    /// Where a march starts, and where it is.
    start: &'m mut [T],
    now: &'m mut [T],
    next: &'m mut [T],
    /// What acts on it.
    load: &'m mut [T],
}

/// How much memory a [`Modal`] wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModalSizes {
    /// Numbers of `T`, to keep.
    pub memory: usize,
    /// Numbers of `f64`, while it is bound.
    pub work: usize,
}

impl<'m, T: Scalar> Modal<'m, T> {
    /// The memory to lend for a scene.
    #[must_use]
    pub const fn sizes(scene: &Scene<'_, T>) -> ModalSizes {
        let Shape { r, n_stages, n_terms, .. } = scene.shape;
        let stride = r.next_multiple_of(STRIDE);
        ModalSizes {
            memory: 9 * r.next_multiple_of(LANES) + 2 * r.next_multiple_of(TILE) * r + 12 * stride,
            work: (n_stages + 3) * r * r
                + n_stages * n_terms
                + crate::sections::axes::Axes::WORK * scene.shape.n_points,
        }
    }

    /// Diagonalises the step of a block scene as it is bound now. `tolerance` is the largest
    /// [`Modal::remainder`] accepted: about the map error of the file's certificate (1e-5) for files with
    /// live regions.
    ///
    /// Cost `O(r³)`, some 5 (r = 8) to 40 (r = 64) times that of binding the scene: from a thousand steps on
    /// it pays (`docs/measurements/step.md`). Allocates nothing.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Block: file, sizes, scene, state, loads, work);
    /// let lent = Modal::sizes(&scene);
    /// let (mut memory, mut work) = (vec![0.0; lent.memory], vec![0.0; lent.work]);
    /// let mut modal = Modal::bind(&scene, 1e-5, &mut memory, &mut work)?;
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// modal.march(&scene, &mut state, &loads, 50)?;
    /// let marched = scene.energy(&state)?;
    ///
    /// // The same fifty steps, one by one.
    /// state.rest();
    /// for _ in 0..50 {
    ///     scene.step(&mut state, &loads)?;
    /// }
    /// assert!((marched / scene.energy(&state)? - 1.0).abs() < 1e-9);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BindError::OtherStructure`] for a diagonal scene, which has its modes; [`BindError::LentMemory`];
    /// [`BindError::NotDiagonalisable`] if the remainder is larger than asked for; [`BindError::NotFinite`].
    pub fn bind(
        scene: &Scene<'_, T>,
        tolerance: f64,
        memory: &'m mut [T],
        work: &mut [f64],
    ) -> Result<Self, BindError> {
        let shape = scene.shape;
        if shape.structure() != Structure::Block {
            return Err(BindError::OtherStructure);
        }
        let sizes = Self::sizes(scene);
        let short = |found, needed| BindError::LentMemory { found, needed };
        let (lent, lent_work) = (memory.len(), work.len());
        let memory = memory.get_mut(..sizes.memory).ok_or(short(lent, sizes.memory))?;
        let work = work.get_mut(..sizes.work).ok_or(short(lent_work, sizes.work))?;
        let (square, mut work) = (shape.r * shape.r, Lender::new(work));
        let e = work.take(shape.n_stages * square)?;
        let (columns, rows, spare) = (work.take(square)?, work.take(square)?, work.take(square)?);
        let (weights, axes) = (work.take(shape.weights_len())?, work.rest());
        let asked = Asked::new(&scene.metadata, &scene.options);
        stage_responses(&scene.metadata, &scene.sections, &asked, shape, weights, e, axes)?;
        let remainder = share_eigenvectors(e, columns, rows, spare, shape.r)?;
        if remainder.is_nan() || remainder > tolerance {
            return Err(BindError::NotDiagonalisable { remainder, tolerance });
        }
        memory.fill(T::ZERO);
        let mut memory = Lender::new(memory);
        let tiles = shape.r.next_multiple_of(TILE) * shape.r;
        let vector = 3 * shape.r.next_multiple_of(STRIDE);
        let modal = Self {
            shape,
            generation: scene.generation,
            remainder,
            blocks: memory.take(9 * shape.r.next_multiple_of(LANES))?,
            to: memory.take(tiles)?,
            from: memory.take(tiles)?,
            start: memory.take(vector)?,
            now: memory.take(vector)?,
            next: memory.take(vector)?,
            load: memory.take(vector)?,
        };
        lay_out_columns(columns, shape.r, modal.from)?;
        transpose(rows, shape.r, spare);
        lay_out_columns(spare, shape.r, modal.to)?;
        fuse_each(scene, e, modal.blocks)?;
        Ok(modal)
    }

    /// What of the stages is left beside the diagonals and is left out: the largest
    /// `|(X⁻¹E_iX)_kl| / √(e_ik e_il)` with columns of `X` of unit length.
    #[must_use]
    pub const fn remainder(&self) -> f64 {
        self.remainder
    }

    /// Advances `state` by `n_steps` steps of `Δt`, all under `loads` as they are now; the first of a
    /// new state starts as that of [`Scene::step`]. Costs
    /// `6r² + 9r n_steps` multiply-adds, and `3r²` more under load; `n_steps` calls of [`Scene::step`] cost
    /// `9r² n_steps`. So a call of one step is no gain, one of ten is. An unloaded body comes to rest as
    /// there, at the end of a call.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged. [`StepError::StaleModes`] if the scene's parameters have
    /// changed since this was bound.
    pub fn march(
        &mut self,
        scene: &Scene<'_, T>,
        state: &mut State<'_, T>,
        loads: &Loads<'_, T>,
        n_steps: usize,
    ) -> Result<Status, StepError> {
        if state.shape != self.shape || loads.shape != self.shape || scene.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        if self.generation != scene.generation {
            return Err(StepError::StaleModes);
        }
        scene.check_carried(state)?;
        if state.y.at_rest && !loads.active {
            state.y.unstarted &= n_steps == 0;
            return Ok(Status::AtRest);
        }
        scene.check_fresh(loads)?;
        if !state.y.unstarted {
            return self.advance(scene, state, loads, n_steps);
        }
        if n_steps == 0 {
            return Ok(Status::Moving);
        }
        scene.equation().start(&mut state.y, loads.force)?;
        let status = self.advance(scene, state, loads, n_steps);
        if status.is_err() {
            state.y.rest();
        }
        status
    }

    /// The steps of a march, from the state as it is.
    fn advance(
        &mut self,
        scene: &Scene<'_, T>,
        state: &mut State<'_, T>,
        loads: &Loads<'_, T>,
        n_steps: usize,
    ) -> Result<Status, StepError> {
        let (r, stride) = (self.shape.r, self.shape.r.next_multiple_of(STRIDE));
        transform(self.to, r, (state.y.now, r), (self.start, stride))?;
        self.load.fill(T::ZERO);
        if loads.active {
            transform(self.to, r, (loads.increment, r), (self.load, stride))?;
        }
        self.now.iter_mut().zip(&*self.start).for_each(|(now, &start)| *now = start);
        let mut moving = true;
        for _ in 0..n_steps {
            let magnitude = step_diagonal(blocks(self.blocks), self.now, self.load, self.next)?;
            if !magnitude.to_f64().is_finite() {
                return Err(StepError::NotFinite);
            }
            core::mem::swap(&mut self.now, &mut self.next);
            moving = magnitude != T::ZERO;
        }
        // What the steps added goes back, not the sum: the rounding of X X⁻¹ stays out of the state.
        self.now.iter_mut().zip(&*self.start).for_each(|(now, &start)| *now = *now - start);
        transform(self.from, r, (self.now, stride), (self.next, stride))?;
        let mut magnitude = T::ZERO;
        for (third, added) in self.next.chunks_exact(stride.max(1)).enumerate() {
            let old = state.y.now.iter().skip(third * r);
            for ((next, &old), &added) in state.y.next.iter_mut().skip(third * r).zip(old).zip(added).take(r)
            {
                *next = if moving { old + added } else { T::ZERO };
                magnitude += next.magnitude();
            }
        }
        state.y.settle(magnitude, loads.active, scene.rest_below)
    }
}

/// `out = tiles · x` for each third of `x`; both with the distance of their thirds.
fn transform<T: Scalar>(
    tiles: &[T],
    r: usize,
    (x, from): (&[T], usize),
    (out, to): (&mut [T], usize),
) -> Result<(), Short> {
    out.fill(T::ZERO);
    let mut x = Lender::new(x);
    for out in out.chunks_exact_mut(to.max(1)) {
        add_dense(tiles.as_chunks().0, Lender::new(x.take(from)?).take(r)?, out);
    }
    Ok(())
}

/// Diagonalises the first stage's `E`, brings the others into its eigenvectors, and returns what is left
/// beside their diagonals. `e` `(n_stages, r, r)` becomes `X⁻¹E_iX`, `columns` `X` column by column, `rows`
/// `X⁻¹` row by row.
fn share_eigenvectors(
    e: &mut [f64],
    columns: &mut [f64],
    rows: &mut [f64],
    spare: &mut [f64],
    r: usize,
) -> Result<f64, Short> {
    let mut all = Lender::new(&mut *e);
    let (first, others) = (all.take(r * r)?, all.rest());
    diagonalise(first, columns, rows, r)?;
    let mut inverse = Lender::new(&mut *rows);
    for column in columns.chunks_exact_mut(r.max(1)) {
        let length = libm::sqrt(column.iter().map(|x| x * x).sum());
        column.iter_mut().for_each(|x| *x /= length);
        inverse.take(r)?.iter_mut().for_each(|x| *x *= length);
    }
    for e in others.chunks_exact_mut(r.saturating_mul(r).max(1)) {
        // spare = E X, column by column; then X⁻¹ (E X).
        for (column, out) in columns.chunks_exact(r.max(1)).zip(spare.chunks_exact_mut(r.max(1))) {
            product(e, column, out);
        }
        for (l, column) in spare.chunks_exact(r.max(1)).enumerate() {
            for (row, out) in rows.chunks_exact(r.max(1)).zip(e.iter_mut().skip(l).step_by(r.max(1))) {
                *out = row.iter().zip(column).map(|(a, b)| a * b).sum();
            }
        }
    }
    let mut largest = 0.0f64;
    for e in e.chunks_exact(r.saturating_mul(r).max(1)) {
        let short = Short { found: e.len(), needed: r.saturating_mul(r) };
        let diagonal = |k: usize| e.get(k * r + k).ok_or(short);
        for (k, row) in e.chunks_exact(r.max(1)).enumerate() {
            for (l, value) in row.iter().enumerate().filter(|&(l, _)| l != k) {
                let share = value.abs() / libm::sqrt((diagonal(k)? * diagonal(l)?).abs());
                largest = if share <= largest { largest } else { share };
            }
        }
    }
    Ok(largest)
}

fn transpose(a: &[f64], r: usize, out: &mut [f64]) {
    for (column, out) in out.chunks_exact_mut(r.max(1)).enumerate() {
        out.iter_mut().zip(a.iter().skip(column).step_by(r.max(1))).for_each(|(out, &a)| *out = a);
    }
}

/// `out = A x`, `A` row by row.
fn product(a: &[f64], x: &[f64], out: &mut [f64]) {
    for (row, out) in a.chunks_exact(x.len().max(1)).zip(out) {
        *out = row.iter().zip(x).map(|(a, x)| a * x).sum();
    }
}

/// The 3×3 block of each mode from `e_i` on the diagonals of `e`.
fn fuse_each<T: Scalar>(scene: &Scene<'_, T>, e: &[f64], blocks: &mut [T]) -> Result<(), BindError> {
    let (r, n_stages) = (scene.shape.r, scene.shape.n_stages);
    let (mut d, mut loads) = ([0.0; 9], [0.0; 3 * MAX_STAGES]);
    let mut small = [0.0; fuse_work_len(1)];
    for k in 0..r {
        let mut of_mode = [0.0; MAX_STAGES];
        let mut stages = Lender::new(e);
        for out in of_mode.iter_mut().take(n_stages) {
            let short = Short { found: r * r, needed: k * (r + 1) + 1 };
            *out = *stages.take(r * r)?.get(k * (r + 1)).ok_or(short)?;
        }
        let of_mode = Lender::new(&of_mode[..]).take(n_stages)?;
        let loads = Lender::new(&mut loads[..]).take(3 * n_stages)?;
        fuse_into(&scene.metadata.scheme, &scene.parameters, 1, of_mode, &mut d, loads, &mut small)?;
        for (entry, &value) in d.iter().enumerate() {
            if !T::from_f64(value).to_f64().is_finite() {
                return Err(BindError::NotFinite);
            }
            put(blocks, place_in_modes::<3>(k, entry % 3, entry / 3), T::from_f64(value))?;
        }
    }
    Ok(())
}
