//! The space that loads and `K⁻¹M` span, orthonormal in the mass, with the stiffness projected on it.
//!
//! It grows by as many columns as there are loads, although a large factor solves for 24 in hardly more time.
//! A start filled up with random vectors was tried at 105 840 dofs: it took 240 vectors where 93 do, as long
//! in all, and the error was estimated too small as long as the space was small.
//!
//! The six rigid motions of a free body are the first columns of every orthonormalisation, and no load acts
//! on them. What rounding leaves of them in a solve would otherwise be blown up where a nearly dependent
//! vector is normalised, and would get an eigenvalue that is zero but for rounding, of either sign.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatRef, Par, Side};

use crate::dynamics::orthonormal::{DEPENDENT, orthonormalise_here};
use crate::fem::{FEW_DASHPOTS, Factor, Pencil, RigidBody, Solve};
use crate::linalg::symmetric_eigen;
use crate::linalg::{Columns, NoConvergence};

/// Columns solved for together.
const GROUP: usize = 24;

/// Room that is set aside for each vector of the start. Pages that no vector comes to are never touched, and
/// vectors that are moved cost as much as new ones.
const ROOM: usize = 8;

/// Rigid motions of a body without supports.
const RIGID: usize = 6;

/// Name of the decomposition in errors.
const PROJECTED: &str = "the stiffness projected on the space of the loads";

/// A growing space.
pub(super) struct RitzSpace<'a> {
    pencil: &'a Pencil,
    factor: &'a Factor,
    solve: Solve,
    /// `Φ`, then `V`.
    columns: Columns,
    /// Number of rigid motions, the first columns.
    rigid: usize,
    /// Columns whose image under `K⁻¹M` is in the space.
    expanded: usize,
    /// The first columns, natural modes that were given.
    given: usize,
    /// `VᵀKV`, its upper triangle, of the first `projected` columns.
    stiffness: Mat<f64>,
    projected: usize,
}

/// The modes of the pencil projected on the first `m` columns of a space.
pub(super) struct ProjectedModes {
    /// `λ`, ascending.
    pub(crate) values: Vec<f64>,
    /// Coordinates over those columns, orthonormal; shape (m, m).
    pub(crate) vectors: Mat<f64>,
}

impl<'a> RitzSpace<'a> {
    /// The space of natural modes that are known and of the static answers to the forces.
    pub(crate) fn new<'f>(
        pencil: &'a Pencil,
        factor: &'a Factor,
        modes: MatRef<'_, f64>,
        forces: impl Iterator<Item = &'f [f64]>,
    ) -> RitzSpace<'a> {
        let n = pencil.n_dof();
        let forces: Vec<&[f64]> = forces.collect();
        let starts = forces.len() + pencil.dampers().count().min(2 * FEW_DASHPOTS);
        let room = ROOM * (modes.ncols() + starts);
        let mut space = RitzSpace {
            pencil,
            factor,
            solve: Solve::new(factor.symbolic(), GROUP, false),
            columns: Columns::with_room(n, RIGID + room.min(n)),
            rigid: 0,
            expanded: 0,
            given: 0,
            stiffness: Mat::zeros(0, 0),
            projected: 0,
        };
        if let Some(rigid) = pencil.rigid() {
            space.append(rigid.motions().to_owned());
            space.rigid = space.columns.as_ref().ncols();
        }
        // Each is its own image.
        for first in (0..modes.ncols()).step_by(GROUP) {
            space.append(modes.subcols(first, GROUP.min(modes.ncols() - first)).to_owned());
        }
        (space.expanded, space.given) = (space.used(), space.used());
        // The static answers decide the compliance under a force, so their rounding is refined away.
        let mut solve = Solve::new(factor.symbolic(), GROUP.min(forces.len().max(1)), true);
        for group in forces.chunks(GROUP) {
            let mut answers = Mat::from_fn(n, group.len(), |i, j| group[j][i]);
            if let Some(rigid) = pencil.rigid() {
                leave_out_rigid(rigid, &mut answers);
            }
            solve.solve_in_place(factor, answers.as_mut());
            space.append(answers);
        }
        let dashpots = space.dashpot_forces();
        for first in (0..dashpots.ncols()).step_by(GROUP) {
            let mut answers = dashpots.subcols(first, GROUP.min(dashpots.ncols() - first)).to_owned();
            space.solve.solve_in_place(factor, answers.as_mut());
            space.append(answers);
        }
        space
    }

    /// Forces by which dashpots leave the space: one for each of them where they are few, and else those that
    /// they exert on the first vectors and on the static answers.
    fn dashpot_forces(&self) -> Mat<f64> {
        let (n, dampers) = (self.pencil.n_dof(), self.pencil.dampers());
        if dampers.count() <= FEW_DASHPOTS {
            return dampers.forces(n, Mat::identity(dampers.count(), dampers.count()).as_ref());
        }
        let first = self.vectors().subcols(0, self.given.min(FEW_DASHPOTS));
        let answers = self.vectors().subcols(self.given, self.used() - self.given);
        let [first, answers] =
            [first, answers].map(|vectors| dampers.forces(n, dampers.along(vectors).as_ref()));
        let mut all = Mat::zeros(n, first.ncols() + answers.ncols());
        all.subcols_mut(0, first.ncols()).copy_from(&first);
        all.subcols_mut(first.ncols(), answers.ncols()).copy_from(&answers);
        all
    }

    /// Number of vectors.
    pub(crate) fn used(&self) -> usize {
        self.vectors().ncols()
    }

    /// Number of natural modes that were given; they come first.
    pub(crate) fn given(&self) -> usize {
        self.given
    }

    /// True if `K⁻¹M` leads nowhere else.
    pub(crate) fn is_closed(&self) -> bool {
        self.expanded == self.used() || self.used() + self.rigid == self.pencil.n_dof()
    }

    /// Takes the images of what was added last, as far as there is room for them in `count` vectors.
    pub(crate) fn grow(&mut self, count: usize) {
        let width = (self.used() - self.expanded).min(GROUP).min(count - self.used());
        let mut image = Mat::zeros(self.pencil.n_dof(), width);
        self.pencil.mass().mul_into(self.vectors().subcols(self.expanded, width), image.as_mut());
        self.solve.solve_in_place(self.factor, image.as_mut());
        self.expanded += width;
        self.append(image);
    }

    fn append(&mut self, block: Mat<f64>) {
        let joined = orthonormalise_here(self.pencil.mass(), self.columns.as_ref(), block);
        self.columns.append(joined.new.as_ref());
    }

    /// The vectors `V`, orthonormal in the mass and to the rigid motions; shape (n, used).
    pub(crate) fn vectors(&self) -> MatRef<'_, f64> {
        let all = self.columns.as_ref();
        all.subcols(self.rigid, all.ncols() - self.rigid)
    }

    /// Number of rigid motions before the vectors.
    pub(crate) fn rigid(&self) -> usize {
        self.rigid
    }

    /// Lends the rigid motions with the vectors behind them, and the projected stiffness, away.
    pub(crate) fn lend(&mut self) -> (Columns, Mat<f64>) {
        let none = (Columns::with_room(0, 0), Mat::new());
        (std::mem::replace(&mut self.columns, none.0), std::mem::replace(&mut self.stiffness, none.1))
    }

    /// Takes them back.
    pub(crate) fn take_back(&mut self, (columns, stiffness): (Columns, Mat<f64>)) {
        (self.columns, self.stiffness) = (columns, stiffness);
    }

    /// Projects the stiffness on the columns that are new.
    pub(crate) fn project(&mut self) {
        let (n, used) = (self.pencil.n_dof(), self.used());
        self.stiffness.resize_with(used, used, |_, _| 0.0);
        while self.projected < used {
            let first = self.projected;
            let width = GROUP.min(used - first);
            let mut forces = Mat::zeros(n, width);
            self.pencil.stiffness().mul_into(self.vectors().subcols(first, width), forces.as_mut());
            let all = self.columns.as_ref();
            let before = all.subcols(self.rigid, first + width).transpose();
            let target = self.stiffness.submatrix_mut(0, first, first + width, width);
            matmul(target, Accum::Replace, before, forces.as_ref(), 1.0, Par::Seq);
            self.projected += width;
        }
    }

    /// The modes of the pencil on the first `m` columns, all of which are projected.
    ///
    /// # Errors
    /// As [`ritz`].
    pub(crate) fn ritz(&self, m: usize) -> Result<ProjectedModes, NoConvergence> {
        ritz(self.stiffness.as_ref(), m)
    }
}

/// Takes off forces what accelerates the whole body. A force of which rounding alone is left deforms nothing
/// and becomes zero, so that no vector is made of its rounding.
fn leave_out_rigid(rigid: &RigidBody, forces: &mut Mat<f64>) {
    let whole: Vec<f64> = (0..forces.ncols()).map(|j| forces.col(j).norm_l2()).collect();
    rigid.relieve(forces.as_mut());
    for (j, whole) in whole.into_iter().enumerate() {
        if forces.col(j).norm_l2() <= DEPENDENT * whole {
            forces.col_as_slice_mut(j).fill(0.0);
        }
    }
}

/// The modes of the pencil on the first `m` columns of a space, from the upper triangle of its projected
/// stiffness.
///
/// They are those of the inverse: the columns go from smooth to rough, so that the lowest `λ` are parts
/// in 1e8 and less of the highest and would drown in its rounding.
///
/// # Errors
/// [`NoConvergence`]: a stiffness that is not positive definite, or not of numbers.
pub(super) fn ritz(projected: MatRef<'_, f64>, m: usize) -> Result<ProjectedModes, NoConvergence> {
    let stiffness = Mat::from_fn(m, m, |i, j| projected[(i.min(j), i.max(j))]);
    let lower = stiffness.llt(Side::Lower).map_err(|_| NoConvergence { what: PROJECTED })?;
    let mut inverse = Mat::identity(m, m);
    solve_lower_triangular_in_place(lower.L(), inverse.as_mut(), Par::Seq);
    let mut compliance = Mat::zeros(m, m);
    let inverse = inverse.as_ref();
    matmul(compliance.as_mut(), Accum::Replace, inverse.transpose(), inverse, 1.0, Par::Seq);
    let (_, vectors) = symmetric_eigen(compliance.as_ref())?;
    // Rayleigh quotients are free of the rounding of the inverse.
    let mut forces = Mat::zeros(m, m);
    matmul(forces.as_mut(), Accum::Replace, stiffness.as_ref(), vectors.as_ref(), 1.0, Par::Seq);
    let quotients: Vec<f64> = (0..m).map(|k| vectors.col(k).transpose() * forces.col(k)).collect();
    let mut order: Vec<usize> = (0..m).rev().collect();
    order.sort_by(|&a, &b| quotients[a].total_cmp(&quotients[b]));
    Ok(ProjectedModes {
        values: order.iter().map(|&k| quotients[k]).collect(),
        vectors: Mat::from_fn(m, m, |i, k| vectors[(i, order[k])]),
    })
}
