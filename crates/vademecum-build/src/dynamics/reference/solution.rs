//! The reference solution: its space, its modes, and the motion in them.

use std::sync::{Arc, Mutex, PoisonError};

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::coupled::{CoupledModes, CoupledStep};
use super::motion::{Coupling, Motion};
use super::space::{ProjectedModes, RitzSpace, ritz};
use crate::dynamics::orthonormal::DEPENDENT;
use crate::dynamics::{History, Rayleigh, TimedLoad, fewest_rows};
use crate::fem::{FactorError, Pencil, Symbolic};
use crate::linalg::{Columns, NoConvergence, project};
use crate::progress::{Cancelled, Listener};

/// Instants taken at a time.
pub(super) const WINDOW: usize = 64;

/// Instants that the estimate of the error looks at, at most; of a longer motion it takes every second or
/// third, and so on.
const ESTIMATED: usize = 4096;

/// Size of the space at which its error is first estimated.
const FIRST: usize = 12;

/// Decay `σ` \[1/s\] of a mode, from its stiffness `λ` \[rad²/s²\] and its place among the modes in ascending
/// order, besides the damping by the dashpots and the loss factors of the pencil.
pub type Decay<'a> = &'a dyn Fn(f64, usize) -> f64;

/// When the space is good enough, and how large it may get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceOptions {
    /// Estimated relative error, mass norm over all dofs and instants, at which the space grows no more.
    pub tolerance: f64,
    /// Most vectors per independent force.
    pub vectors_per_force: usize,
    /// Most memory that the vectors take \[bytes\]; three vectors per force are made whatever it says.
    pub bytes: u64,
}

impl Default for ReferenceOptions {
    fn default() -> Self {
        Self { tolerance: 1e-6, vectors_per_force: 400, bytes: 2_000_000_000 }
    }
}

impl ReferenceOptions {
    /// Most vectors for `forces` independent forces on a body of `n` dofs.
    #[must_use]
    pub fn most_vectors(&self, forces: usize, n: usize) -> usize {
        let room = self.bytes / (8 * n.max(1) as u64);
        let room = usize::try_from(room).unwrap_or(usize::MAX);
        forces.saturating_mul(self.vectors_per_force).min(room).max(3 * forces).min(n)
    }
}

/// Why there is no reference solution.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The stiffness does not factorise.
    #[error("the stiffness matrix, for the reference that is exact in time")]
    Factor(#[from] FactorError),
    /// Numbers that double precision does not hold.
    #[error("the reference that is exact in time")]
    NoConvergence(#[from] NoConvergence),
    /// On request.
    #[error("the reference that is exact in time")]
    Cancelled(#[from] Cancelled),
}

/// Trajectories from rest, exact in time, in a space made for their loads.
#[doc(alias("truth", "load-dependent Ritz vectors"))]
pub struct ReferenceSolution<'a> {
    pub(super) pencil: &'a Pencil,
    /// `Φ` of a free body, then `V` of shape (n, m); orthonormal in the mass.
    columns: Columns,
    /// Columns of `Φ`.
    rigid: usize,
    /// `VᵀKV`, its upper triangle.
    stiffness: Mat<f64>,
    modes: ModalPencil,
    loads: ModalLoads,
    time_step: f64,
    steps: usize,
    /// Vectors that were known before, the first of the space.
    given: usize,
    /// True if nothing was left to add to the space.
    closed: bool,
    errors: Vec<f64>,
}

/// The pencil on a space, mode by mode.
struct ModalPencil {
    /// `λ` and `σ` of each mode, `λ` ascending.
    modes: Vec<[f64; 2]>,
    /// Modes over the vectors of the space, shape (m, m), orthonormal.
    vectors: Mat<f64>,
    /// Rows of dashpots along the modes, shape (any, m); they couple them.
    dashpots: Mat<f64>,
    /// The step of coupled modes that was made last.
    step: Mutex<Option<Arc<CoupledStep>>>,
}

/// Loads on the vectors of a space.
struct ModalLoads {
    /// `VᵀF`, shape (m, loads).
    shares: Mat<f64>,
    /// Time function of each load, and the trajectory on which it acts.
    when: Vec<(usize, History)>,
}

impl<'a> ReferenceSolution<'a> {
    /// Finds the space for the trajectories that `loads` drive over `steps` steps of `time_step` \[s\], on
    /// the pencil whose pattern `symbolic` analyses; each mode decays by `decay`.
    ///
    /// Costs one factor of `K`; for each vector of the space one solve and the orthogonalisation against all
    /// vectors before it (4 n products for each). Memory: the factor, and `n` numbers for each vector; twice
    /// that while vectors are moved, which begins with more than eight for each force. Deterministic.
    ///
    /// # Errors
    /// [`ReferenceError`]. A space that reaches its largest size before the tolerance is no error: see
    /// [`ReferenceTrajectory::estimate`].
    ///
    /// ```
    /// use faer::mat;
    /// use vademecum_build::dynamics::{Interval, TimedLoad, ReferenceOptions, ReferenceSolution};
    /// use vademecum_build::fem::{Pencil, Symbolic};
    /// use vademecum_build::progress::Silent;
    ///
    /// // A mass of 1 kg on a spring of 4 N/m, pushed by 8 N: u = 2 (1 − cos 2t).
    /// let pencil = Pencil::from_matrices(mat![[1.0]].as_ref(), mat![[4.0]].as_ref())?;
    /// let when = Interval { start: 0.0, end: f64::INFINITY, ramp: 0.0 }.into();
    /// let loads = [TimedLoad { column: 0, force: vec![8.0], when }];
    /// let symbolic = Symbolic::analyze(&pencil)?;
    /// let options = ReferenceOptions::default();
    /// let span = (0.1, 20);
    /// let found = ReferenceSolution::find(&pencil, &symbolic, &|_, _| 0.0, &loads, span, &options, &Silent)?;
    /// let u = found.trajectory(0).along(&[vec![(0, 1.0)]]);
    /// assert!((u[(0, 20)] - 2.0 * (1.0 - 4.0_f64.cos())).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn find(
        pencil: &'a Pencil,
        symbolic: &Symbolic,
        decay: Decay<'_>,
        loads: &[TimedLoad],
        span: (f64, usize),
        options: &ReferenceOptions,
        listener: &dyn Listener,
    ) -> Result<ReferenceSolution<'a>, ReferenceError> {
        let never = |_: &ReferenceSolution<'_>| None::<()>;
        let none = Mat::zeros(pencil.n_dof(), 0);
        let model = (pencil, symbolic, none.as_ref());
        Ok(Self::find_until(model, decay, loads, span, options, listener, never)?.0)
    }

    /// The same, but the space grows no more once `enough` has an answer, which comes along: what is measured
    /// against the reference may need less of it. It is asked at every size at which the error is estimated.
    ///
    /// The space begins with natural modes of the pencil, shape (n, count), where they are known: what is
    /// left of the loads then moves faster than they do, and takes half as many vectors. They have to be
    /// modes, not any Ritz vectors: what `K⁻¹M` makes of them is not looked at.
    ///
    /// # Errors
    /// As [`ReferenceSolution::find`].
    pub(crate) fn find_until<T>(
        (pencil, symbolic, modes): (&'a Pencil, &Symbolic, MatRef<'_, f64>),
        decay: Decay<'_>,
        loads: &[TimedLoad],
        (time_step, steps): (f64, usize),
        options: &ReferenceOptions,
        listener: &dyn Listener,
        mut enough: impl FnMut(&ReferenceSolution<'a>) -> Option<T>,
    ) -> Result<(ReferenceSolution<'a>, Option<T>), ReferenceError> {
        let factor = symbolic.factor_of(pencil.stiffness())?;
        let forces = loads.iter().map(|load| load.force.as_slice());
        let mut space = RitzSpace::new(pencil, &factor, modes, forces);
        let (given, rigid) = (space.given(), space.rigid());
        let n = pencil.n_dof() - rigid;
        let most = given + options.most_vectors(space.used() - given, n - given);
        let mut aim = (given + FIRST.max(3 * (space.used() - given))).min(most);
        loop {
            while space.used() < aim && !space.is_closed() {
                space.grow(aim);
                listener.checkpoint(space.used(), most)?;
            }
            space.project();
            let loads = ModalLoads::new(space.vectors(), loads);
            let dissipation = Dissipation::new(pencil, space.vectors());
            let modes = ModalPencil::new(space.ritz(space.used())?, decay, &dissipation)?;
            let closed = space.is_closed();
            let errors = if closed {
                // What is missing was taken for rounding.
                vec![DEPENDENT; loads.columns()]
            } else {
                let fewer = space.ritz(fewer(space.used(), given))?;
                let fewer = ModalPencil::new(fewer, decay, &dissipation)?;
                estimate(&modes, &fewer, &loads, time_step, steps, listener)?
            };
            let converged = errors.iter().all(|&error| error <= options.tolerance);
            let last = closed || converged || space.used() >= most;
            aim = (space.used() + (space.used() - given).div_ceil(4)).min(most);
            let (columns, stiffness) = space.lend();
            let truth = ReferenceSolution {
                pencil,
                columns,
                rigid,
                stiffness,
                given,
                closed,
                modes,
                loads,
                time_step,
                steps,
                errors,
            };
            let answer = enough(&truth);
            if last || answer.is_some() {
                return Ok((truth, answer));
            }
            space.take_back((truth.columns, truth.stiffness));
        }
    }

    /// The same loads in the same space under another damping, with its own estimate of the error. More
    /// damping needs no larger space; less might.
    ///
    /// # Errors
    /// [`ReferenceError`]: numbers that double precision does not hold; a stop.
    pub fn damped(
        self,
        decay: Decay<'_>,
        listener: &dyn Listener,
    ) -> Result<ReferenceSolution<'a>, ReferenceError> {
        let (vectors, projected) = (self.vectors(), self.stiffness.as_ref());
        let dissipation = Dissipation::new(self.pencil, self.space());
        let modes = ModalPencil::new(ritz(projected, vectors)?, decay, &dissipation)?;
        let mut errors = self.errors;
        if !self.closed {
            let fewer = ritz(projected, fewer(vectors, self.given))?;
            let fewer = ModalPencil::new(fewer, decay, &dissipation)?;
            errors = estimate(&modes, &fewer, &self.loads, self.time_step, self.steps, listener)?;
        }
        Ok(ReferenceSolution { modes, errors, ..self })
    }

    /// Number of vectors of the space.
    pub fn vectors(&self) -> usize {
        self.space().ncols()
    }

    /// `V`, shape (n, vectors), orthonormal in the mass, and to the rigid motions of a free body.
    pub fn space(&self) -> MatRef<'_, f64> {
        let all = self.columns.as_ref();
        all.subcols(self.rigid, all.ncols() - self.rigid)
    }

    /// `VᵀKV`.
    pub(crate) fn stiffness(&self) -> Mat<f64> {
        let m = self.vectors();
        Mat::from_fn(m, m, |i, j| self.stiffness[(i.min(j), i.max(j))])
    }

    /// `λ` of each mode in the space, ascending \[rad²/s²\].
    pub fn lambda(&self) -> Vec<f64> {
        self.modes.modes.iter().map(|mode| mode[0]).collect()
    }

    /// The trajectory that the loads of this column drive.
    pub fn trajectory(&self, column: usize) -> ReferenceTrajectory<'_> {
        ReferenceTrajectory { truth: self, column }
    }
}

/// One trajectory of a reference solution.
#[derive(Clone, Copy)]
pub struct ReferenceTrajectory<'t> {
    pub(super) truth: &'t ReferenceSolution<'t>,
    column: usize,
}

impl<'t> ReferenceTrajectory<'t> {
    /// Number of instants, the start included.
    pub(crate) fn instants(&self) -> usize {
        self.truth.steps + 1
    }

    /// Estimate of its own error, relative L2 over all dofs and instants, mass norm: how far it is from the
    /// answer in the first two thirds of what was added to the space. Where nothing was left to add to the
    /// space it is the part that counts as rounding there, 1e-11.
    pub fn estimate(&self) -> f64 {
        self.truth.errors.get(self.column).copied().unwrap_or(0.0)
    }

    /// Coordinates over the space, some instants at a time from the start on.
    pub fn windows(&self) -> Windows<'t> {
        let truth = self.truth;
        Windows::new(&truth.modes, &truth.loads, self.column, truth.time_step, self.instants())
    }

    /// Coordinates over the space at all instants, shape (vectors, instants): much memory for a long motion,
    /// which [`ReferenceTrajectory::windows`] does without.
    pub fn coordinates(&self) -> Mat<f64> {
        let mut all = Mat::zeros(self.truth.vectors(), self.instants());
        for (first, window) in self.windows() {
            all.subcols_mut(first, window.ncols()).copy_from(window);
        }
        all
    }

    /// Displacement along rows of (dof, weight) at all instants; shape (rows, instants).
    pub fn along(&self, rows: &[Vec<(u32, f64)>]) -> Mat<f64> {
        let mut all = Mat::zeros(rows.len(), self.instants());
        for (first, window) in self.along_windows(rows) {
            all.subcols_mut(first, window.ncols()).copy_from(window);
        }
        all
    }

    /// The same some instants at a time, each window with its first instant.
    pub fn along_windows(&self, rows: &[Vec<(u32, f64)>]) -> impl Iterator<Item = (usize, Mat<f64>)> + 't {
        let space = self.truth.space();
        let weight = |row: usize, k: usize| {
            rows[row].iter().map(|&(dof, weight)| weight * space[(dof as usize, k)]).sum::<f64>()
        };
        let rows = Mat::from_fn(rows.len(), space.ncols(), weight);
        self.windows().map(move |(first, window)| {
            let mut along = Mat::zeros(rows.nrows(), window.ncols());
            matmul(along.as_mut(), Accum::Replace, rows.as_ref(), window.as_ref(), 1.0, Par::Seq);
            (first, along)
        })
    }

    /// Kinetic plus elastic energy at each instant \[J\].
    pub fn energy(&self) -> Vec<f64> {
        let mut windows = self.windows();
        (0..self.instants()).map(|_| windows.motion.next_energy()).collect()
    }

    /// `√Σ ‖u(t_n)‖²` in the mass, over all instants.
    pub fn norm(&self) -> f64 {
        self.windows().map(|(_, window)| window.squared_norm_l2()).sum::<f64>().sqrt()
    }
}

/// Coordinates of a trajectory over its space, with the first instant of each window.
pub struct Windows<'t> {
    motion: Motion<'t>,
    vectors: MatRef<'t, f64>,
    next: usize,
    instants: usize,
}

impl<'t> Windows<'t> {
    fn new(
        modes: &'t ModalPencil,
        loads: &ModalLoads,
        column: usize,
        time_step: f64,
        instants: usize,
    ) -> Self {
        let (shares, when) = loads.of(column, modes);
        let motion = Motion::new(&modes.modes, modes.coupling(time_step), shares, when, time_step);
        Self { motion, vectors: modes.vectors.as_ref(), next: 0, instants }
    }
}

impl Iterator for Windows<'_> {
    type Item = (usize, Mat<f64>);

    fn next(&mut self) -> Option<(usize, Mat<f64>)> {
        let (first, count) = (self.next, WINDOW.min(self.instants - self.next));
        if count == 0 {
            return None;
        }
        let modal = self.motion.next(count);
        let mut window = Mat::zeros(self.vectors.nrows(), count);
        matmul(window.as_mut(), Accum::Replace, self.vectors, modal.as_ref(), 1.0, Par::Seq);
        self.next += count;
        Some((first, window))
    }
}

/// Dissipation of the pencil along the vectors of the space, or more.
struct Dissipation {
    /// Rows of dashpots.
    dashpots: Mat<f64>,
    /// `Σ η_q K_q` of loss factors.
    loss: Option<Mat<f64>>,
}

impl Dissipation {
    fn new(pencil: &Pencil, space: MatRef<'_, f64>) -> Self {
        let loss = pencil.loss().map(|matrix| {
            let mut image = Mat::zeros(space.nrows(), space.ncols());
            matrix.mul_into(space, image.as_mut());
            space.transpose() * image
        });
        Self { dashpots: pencil.dampers().along(space), loss }
    }
}

impl ModalPencil {
    /// # Errors
    /// [`NoConvergence`]: numbers that double precision does not hold.
    fn new(
        ritz: ProjectedModes,
        decay: Decay<'_>,
        dissipation: &Dissipation,
    ) -> Result<ModalPencil, NoConvergence> {
        let m = ritz.vectors.nrows();
        let dashpots = fewest_rows(dissipation.dashpots.subcols(0, m) * &ritz.vectors)?;
        let loss = dissipation.loss.as_ref().map(|loss| loss.submatrix(0, 0, m, m) * &ritz.vectors);
        // ζω of the ratio ½ xᵀGx/λ of modes that are normal in the mass.
        let lost = |k: usize, lambda: f64| {
            loss.as_ref().map_or(0.0, |loss| {
                let energy = ritz.vectors.col(k).transpose() * loss.col(k);
                if lambda > 0.0 { 0.5 * energy / lambda.sqrt() } else { 0.0 }
            })
        };
        let values = ritz.values.iter().enumerate();
        let modes = values.map(|(k, &lambda)| [lambda, decay(lambda, k) + lost(k, lambda)]).collect();
        Ok(ModalPencil { modes, vectors: ritz.vectors, dashpots, step: Mutex::new(None) })
    }

    /// The coupling of the modes, with a step of `time_step`; `None` without dashpots.
    fn coupling(&self, time_step: f64) -> Option<Coupling<'_>> {
        if self.dashpots.nrows() == 0 {
            return None;
        }
        let modes = CoupledModes { modes: &self.modes, rows: self.dashpots.as_ref() };
        let mut known = self.step.lock().unwrap_or_else(PoisonError::into_inner);
        let whole = match known.take().filter(|step| step.length() == time_step) {
            Some(step) => step,
            None => Arc::new(modes.step(time_step)),
        };
        *known = Some(Arc::clone(&whole));
        Some(Coupling { modes, whole })
    }
}

impl ModalLoads {
    fn new(space: MatRef<'_, f64>, loads: &[TimedLoad]) -> ModalLoads {
        let mut shares = Mat::zeros(space.ncols(), loads.len());
        for (j, load) in loads.iter().enumerate() {
            shares.col_as_slice_mut(j).copy_from_slice(&project(space, &load.force));
        }
        ModalLoads { shares, when: loads.iter().map(|load| (load.column, load.when.clone())).collect() }
    }

    /// Number of trajectories.
    fn columns(&self) -> usize {
        self.when.iter().map(|(column, _)| column + 1).max().unwrap_or(0)
    }

    /// Shares of the modes in the loads of one trajectory, and how these follow time.
    fn of(&self, column: usize, modes: &ModalPencil) -> (Mat<f64>, Vec<History>) {
        let mine: Vec<usize> = (0..self.when.len()).filter(|&j| self.when[j].0 == column).collect();
        let m = modes.vectors.nrows();
        let shares = Mat::from_fn(m, mine.len(), |i, j| self.shares[(i, mine[j])]);
        (modes.vectors.transpose() * shares, mine.iter().map(|&j| self.when[j].1.clone()).collect())
    }
}

/// Vectors of a space of so many with which its error is estimated: those that were given, and two thirds of
/// the others.
fn fewer(vectors: usize, given: usize) -> usize {
    let found = vectors - given;
    given + (2 * found).div_ceil(3).min(found - 1)
}

/// Distance of the answers in `fewer` vectors from those in all, relative, for each trajectory.
fn estimate(
    modes: &ModalPencil,
    fewer: &ModalPencil,
    loads: &ModalLoads,
    time_step: f64,
    steps: usize,
    listener: &dyn Listener,
) -> Result<Vec<f64>, Cancelled> {
    let stride = steps.div_ceil(ESTIMATED).max(1);
    let (time_step, instants) = (stride as f64 * time_step, steps / stride + 1);
    let distance = |column: usize| -> Result<f64, Cancelled> {
        let all = Windows::new(modes, loads, column, time_step, instants);
        let part = Windows::new(fewer, loads, column, time_step, instants);
        let (mut apart, mut norm) = (0.0, 0.0);
        for ((_, all), (_, part)) in all.zip(part) {
            let (shared, rest) = all.split_at_row(part.nrows());
            apart += (shared - part).squared_norm_l2() + rest.squared_norm_l2();
            norm += all.squared_norm_l2();
            if listener.cancelled() {
                return Err(Cancelled);
            }
        }
        // A body that does not move is where it is; what is no number stays none.
        Ok(if norm == 0.0 { 0.0 } else { (apart / norm).sqrt() })
    };
    (0..loads.columns()).map(distance).collect()
}

impl Rayleigh {
    /// Decay `½(α + βλ)` \[1/s\] of a mode of stiffness `lambda` \[rad²/s²\].
    #[must_use]
    pub fn decay(&self, lambda: f64) -> f64 {
        0.5 * (self.alpha + self.beta * lambda)
    }
}
