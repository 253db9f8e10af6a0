//! The dense step of a block scene taken apart into independent modes, once per setting of its parameters.
//!
//! With live regions the stages of a step are functions of one pencil, `I + E_i = (M̃ + θ_i K̃)⁻¹ M̃` (`docs/decisions/lifting.md`), so
//! they share their eigenvectors: `E_i = X diag(e_i) X⁻¹` with one real `X`. In `η = X⁻¹ζ` a step is `r` independent 3×3 blocks. A call of
//! [`Modal::march`] goes to `η`, takes any number of such steps under the same loads, and comes back; states, loads and outputs of the
//! scene stay as they are.
//!
//! The odd thing: `M̃` and `K̃` are not in the file, only `E`, so the symmetric form of the problem cannot be had; `E` itself is
//! diagonalised, as a general matrix. What the stages do not share is measured ([`Modal::remainder`]) and left out.

use crate::bind::{Asked, lay_out_columns, stage_responses};
use crate::eigen::diagonalise;
use crate::error::{BindError, StepError};
use crate::kernel::{LANES, TILE, add_dense, step_diagonal};
use crate::loads::Loads;
use crate::options::{Status, Structure};
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::shape::Shape;
use crate::state::State;
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
    /// Four vectors like a state: the start, now, next, the load.
    vectors: &'m mut [T],
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
                + crate::axes::Axes::WORK * scene.shape.n_points,
        }
    }

    /// Diagonalises the step of a block scene as it is bound now. `tolerance` is the largest [`Modal::remainder`] accepted: about the map
    /// error of the file's certificate (1e-5) for files with live regions.
    ///
    /// Cost `O(r³)`, some 5 (r = 8) to 40 (r = 64) times that of binding the scene: from a thousand steps on it pays
    /// (`docs/benchmarks/step.md`). Allocates nothing.
    ///
    /// # Errors
    /// [`BindError::OtherStructure`] for a diagonal scene, which has its modes; [`BindError::LentMemory`]; [`BindError::NotDiagonalisable`]
    /// if the remainder is larger than asked for; [`BindError::NotFinite`].
    pub fn bind(
        scene: &Scene<'_, T>,
        tolerance: f64,
        memory: &'m mut [T],
        work: &mut [f64],
    ) -> Result<Self, BindError> {
        let shape = scene.shape;
        if shape.structure != Structure::Block {
            return Err(BindError::OtherStructure);
        }
        let sizes = Self::sizes(scene);
        let short = |found, needed| BindError::LentMemory { found, needed };
        let (lent, lent_work) = (memory.len(), work.len());
        let memory = memory.get_mut(..sizes.memory).ok_or(short(lent, sizes.memory))?;
        let work = work.get_mut(..sizes.work).ok_or(short(lent_work, sizes.work))?;
        let square = shape.r * shape.r;
        let (e, rest) = work.split_at_mut_checked(shape.n_stages * square).unwrap_or_default();
        let (columns, rest) = rest.split_at_mut_checked(square).unwrap_or_default();
        let (rows, rest) = rest.split_at_mut_checked(square).unwrap_or_default();
        let (spare, rest) = rest.split_at_mut_checked(square).unwrap_or_default();
        let (weights, axes) = rest.split_at_mut_checked(shape.n_stages * shape.n_terms).unwrap_or_default();
        let asked = Asked::new(&scene.metadata, &scene.options);
        stage_responses(&scene.metadata, &scene.sections, &asked, shape, weights, e, axes)?;
        let remainder = share_eigenvectors(e, columns, rows, spare, shape.r);
        if remainder.is_nan() || remainder > tolerance {
            return Err(BindError::NotDiagonalisable { remainder, tolerance });
        }
        memory.fill(T::ZERO);
        let tiles = shape.r.next_multiple_of(TILE) * shape.r;
        let (blocks, rest) =
            memory.split_at_mut_checked(9 * shape.r.next_multiple_of(LANES)).unwrap_or_default();
        let (to, rest) = rest.split_at_mut_checked(tiles).unwrap_or_default();
        let (from, vectors) = rest.split_at_mut_checked(tiles).unwrap_or_default();
        lay_out_columns(columns, shape.r, from);
        transpose(rows, shape.r, spare);
        lay_out_columns(spare, shape.r, to);
        fuse_each(scene, e, blocks)?;
        Ok(Self { shape, generation: scene.generation, remainder, blocks, to, from, vectors })
    }

    /// What of the stages is left beside the diagonals and is left out: the largest `|(X⁻¹E_iX)_kl| / √(e_ik e_il)` with columns of `X` of
    /// unit length.
    #[must_use]
    pub const fn remainder(&self) -> f64 {
        self.remainder
    }

    /// Advances `state` by `n_steps` steps of `Δt`, all under `loads` as they are now. Costs `6r² + 9r n_steps` multiply-adds, and `3r²` more under
    /// load; `n_steps` calls of [`Scene::step`] cost `9r² n_steps`. So a call of one step is no gain, one of ten is. An unloaded body comes to rest as there, at the end of a call.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged. [`StepError::StaleModes`] if the scene's parameters have changed since this was
    /// bound.
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
            return Ok(Status::AtRest);
        }
        scene.check_fresh(loads)?;
        let (r, stride) = (self.shape.r, self.shape.r.next_multiple_of(STRIDE));
        let mut vectors = self.vectors.chunks_exact_mut(stride.saturating_mul(3).max(1));
        let mut vector = || vectors.next().unwrap_or_default();
        let (start, mut now, mut new, load) = (vector(), vector(), vector(), vector());
        transform(self.to, r, (state.y.now, r), (start, stride));
        load.fill(T::ZERO);
        if loads.active {
            transform(self.to, r, (loads.increment, r), (load, stride));
        }
        now.iter_mut().zip(&*start).for_each(|(now, &start)| *now = start);
        let mut moving = true;
        for _ in 0..n_steps {
            let magnitude = step_diagonal(self.blocks.as_chunks().0.as_chunks().0, now, load, new);
            if !magnitude.to_f64().is_finite() {
                return Err(StepError::NotFinite);
            }
            core::mem::swap(&mut now, &mut new);
            moving = magnitude != T::ZERO;
        }
        // What the steps added goes back, not the sum: the rounding of X X⁻¹ stays out of the state.
        now.iter_mut().zip(&*start).for_each(|(now, &start)| *now = *now - start);
        transform(self.from, r, (now, stride), (new, stride));
        let mut magnitude = T::ZERO;
        for (third, added) in new.chunks_exact(stride.max(1)).enumerate() {
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
fn transform<T: Scalar>(tiles: &[T], r: usize, (x, from): (&[T], usize), (out, to): (&mut [T], usize)) {
    out.fill(T::ZERO);
    for (third, out) in out.chunks_exact_mut(to.max(1)).enumerate() {
        add_dense(tiles.as_chunks().0, x.get(third * from..third * from + r).unwrap_or_default(), out);
    }
}

/// Diagonalises the first stage's `E`, brings the others into its eigenvectors, and returns what is left beside their diagonals. `e`
/// `(n_stages, r, r)` becomes `X⁻¹E_iX`, `columns` `X` column by column, `rows` `X⁻¹` row by row.
fn share_eigenvectors(
    e: &mut [f64],
    columns: &mut [f64],
    rows: &mut [f64],
    spare: &mut [f64],
    r: usize,
) -> f64 {
    let Some((first, others)) = e.split_at_mut_checked(r * r) else { return f64::INFINITY };
    diagonalise(first, columns, rows, r);
    let mut inverse = rows.chunks_exact_mut(r.max(1));
    for column in columns.chunks_exact_mut(r.max(1)) {
        let length = libm::sqrt(column.iter().map(|x| x * x).sum());
        column.iter_mut().for_each(|x| *x /= length);
        inverse.next().unwrap_or_default().iter_mut().for_each(|x| *x *= length);
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
        let diagonal = |k: usize| e.get(k * r + k).copied().unwrap_or_default();
        for (k, row) in e.chunks_exact(r.max(1)).enumerate() {
            for (l, value) in row.iter().enumerate().filter(|&(l, _)| l != k) {
                let share = value.abs() / libm::sqrt((diagonal(k) * diagonal(l)).abs());
                largest = if share <= largest { largest } else { share };
            }
        }
    }
    largest
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
        for (stage, out) in of_mode.iter_mut().take(n_stages).enumerate() {
            *out = e.get(stage * r * r + k * r + k).copied().unwrap_or_default();
        }
        let of_mode = of_mode.get(..n_stages).unwrap_or_default();
        let loads = loads.get_mut(..3 * n_stages).unwrap_or_default();
        fuse_into(&scene.metadata.scheme, &scene.parameters, 1, of_mode, &mut d, loads, &mut small)?;
        for (entry, &value) in d.iter().enumerate() {
            if !T::from_f64(value).to_f64().is_finite() {
                return Err(BindError::NotFinite);
            }
            let row_major = 3 * (entry % 3) + entry / 3;
            if let Some(out) = blocks.get_mut((k / LANES * 9 + row_major) * LANES + k % LANES) {
                *out = T::from_f64(value);
            }
        }
    }
    Ok(())
}
