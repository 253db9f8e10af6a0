//! `K⁻¹` and what a basis takes of it.
//!
//! `R F = K⁻¹F − B Λ⁻¹ BᵀF` is often a thousandth of `K⁻¹F`, so rounding of the solve shows. What it adds
//! along `B` is taken away by a second projection, `y − B Λ⁻¹ (KB)ᵀ y`. The solve is not refined: what it
//! leaves outside of `B` is far below what a contact feels, and refining would solve twice.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::prelude::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::basis::ResidualBasis;
use crate::fem::{Factor, FactorError, Pencil, Solve, Symbolic};
use crate::linalg::column_groups;
use crate::parallel;
use crate::prepared::{Body, Probe};

/// Columns that one thread works on at a time: three groups of the solver, and eight nodes.
pub(super) const GROUP: usize = 24;

/// `K⁻¹` and a basis with `BᵀKB = Λ`.
pub(super) struct ResidualOperator<'a> {
    body: &'a Body,
    pencil: &'a Pencil,
    symbolic: &'a Symbolic,
    /// Absent while it is used up.
    factor: Option<Arc<Factor>>,
    vectors: MatRef<'a, f64>,
    /// `K B`.
    images: Mat<f64>,
    /// `1/λ`.
    compliances: Vec<f64>,
}

/// Memory for as many columns as are worked on at once.
pub(super) struct ResidualWorkspace {
    /// Forces, then answers; shape (n, columns).
    pub(crate) columns: Mat<f64>,
    /// `M` times the answers.
    pub(crate) images: Mat<f64>,
    solve: Solve,
}

impl<'a> ResidualOperator<'a> {
    pub(crate) fn new(reduced: &ResidualBasis<'a>) -> Result<Self, FactorError> {
        let ResidualBasis { body, pencil, symbolic, vectors, eigenvalues, .. } = *reduced;
        let stiffness = pencil.stiffness();
        let factor = symbolic.factor_of(stiffness)?;
        let mut images = Mat::zeros(vectors.nrows(), vectors.ncols());
        columns_of(vectors, images.as_mut(), |group, image| stiffness.mul_into(group, image));
        let compliances = eigenvalues.iter().map(|lambda| 1.0 / lambda).collect();
        Ok(Self { body, pencil, symbolic, factor: Some(factor), vectors, images, compliances })
    }

    /// The factor of `K`.
    pub(crate) fn factor(&self) -> &Factor {
        self.factor.as_ref().expect("a factor that is not used up")
    }

    /// The factor of `K`, to use it up: without it nothing is solved for.
    pub(crate) fn take_factor(&mut self) -> Result<Factor, FactorError> {
        self.factor = None;
        self.symbolic.take_factor_of(self.pencil().stiffness())
    }

    /// Makes the same factor again.
    pub(crate) fn restore_factor(&mut self) -> Result<(), FactorError> {
        self.factor = Some(self.symbolic.factor_of(self.pencil().stiffness())?);
        Ok(())
    }

    /// `B`, shape (n, r).
    pub(crate) fn vectors(&self) -> MatRef<'a, f64> {
        self.vectors
    }

    /// `K B`, shape (n, r).
    pub(crate) fn images(&self) -> MatRef<'_, f64> {
        self.images.as_ref()
    }

    /// `1/λ`.
    pub(crate) fn compliances(&self) -> &[f64] {
        &self.compliances
    }

    pub(crate) fn pencil(&self) -> &Pencil {
        self.pencil
    }

    /// Columns worked on at once: one group a thread, and one in all where an engine solves.
    pub(crate) fn at_once(symbolic: &Symbolic) -> usize {
        if symbolic.is_spread() { GROUP } else { GROUP * rayon::current_num_threads().max(1) }
    }

    /// Columns of this complement worked on at once.
    pub(crate) fn columns_at_once(&self) -> usize {
        Self::at_once(self.symbolic)
    }

    /// Memory for `columns` columns.
    pub(crate) fn workspace(&self, columns: usize) -> ResidualWorkspace {
        let n = self.pencil().n_dof();
        let [own, images] = [Mat::zeros(n, columns), Mat::zeros(n, columns)];
        ResidualWorkspace {
            columns: own,
            images,
            solve: Solve::new(self.factor().symbolic(), columns, false),
        }
    }

    /// Free dofs that a component of a node follows, and weights; none where it is held.
    pub(crate) fn terms(&self, node: u32, component: usize) -> impl Iterator<Item = (usize, f64)> {
        let terms = self.body.model.dofs().terms(3 * node as usize + component);
        terms.map(|(free, weight)| (free as usize, weight))
    }

    /// A component of a node, from the values of the free dofs.
    pub(crate) fn value(&self, node: u32, component: usize, free: impl Fn(usize) -> f64) -> f64 {
        self.body.model.dofs().value(3 * node as usize + component, free)
    }

    /// Unit forces at these nodes, three columns each.
    pub(crate) fn fill_units(&self, memory: &mut ResidualWorkspace, nodes: &[u32]) {
        memory.columns.fill(0.0);
        for (place, &node) in nodes.iter().enumerate() {
            for c in 0..3 {
                for (free, weight) in self.terms(node, c) {
                    memory.columns[(free, 3 * place + c)] = weight;
                }
            }
        }
    }

    /// Overwrites the first `used` columns, forces `F`, by `R F`.
    pub(crate) fn apply(&self, memory: &mut ResidualWorkspace, used: usize) {
        let r = self.compliances.len();
        let groups = used.div_ceil(GROUP);
        let mut shares = vec![Mat::zeros(r, GROUP); groups];
        let mut columns = memory.columns.as_mut().subcols_mut(0, used);
        let own = column_groups(columns.rb_mut(), GROUP);
        parallel::for_each_of(own.into_iter().zip(&mut shares), &|_, (forces, shares)| {
            self.shares_into(self.vectors, forces.as_ref(), shares);
        });
        memory.solve.solve_in_place(self.factor(), columns.rb_mut());
        let own = column_groups(columns, GROUP);
        parallel::for_each_of(own.into_iter().zip(&mut shares), &|_, (mut answers, shares)| {
            self.take_away(answers.rb_mut(), shares);
            self.shares_into(self.images.as_ref(), answers.as_ref(), shares);
            self.take_away(answers, shares);
        });
    }

    /// `M` times the first `used` columns.
    pub(crate) fn weigh(&self, memory: &mut ResidualWorkspace, used: usize) {
        let ResidualWorkspace { columns, images, .. } = memory;
        let images = images.as_mut().subcols_mut(0, used);
        self.pencil().mass().mul_into(columns.as_ref().subcols(0, used), images);
    }

    /// `Λ⁻¹ VᵀX`, shape (r, columns).
    fn shares_into(&self, vectors: MatRef<'_, f64>, columns: MatRef<'_, f64>, shares: &mut Mat<f64>) {
        if self.compliances.is_empty() {
            return;
        }
        let mut shares = shares.as_mut().subcols_mut(0, columns.ncols());
        matmul(shares.rb_mut(), Accum::Replace, vectors.transpose(), columns, 1.0, Par::Seq);
        for column in shares.col_iter_mut() {
            column.iter_mut().zip(&self.compliances).for_each(|(share, compliance)| *share *= compliance);
        }
    }

    /// `X ← X − B C`.
    fn take_away(&self, columns: MatMut<'_, f64>, shares: &Mat<f64>) {
        if !self.compliances.is_empty() {
            let shares = shares.as_ref().subcols(0, columns.ncols());
            matmul(columns, Accum::Add, self.vectors, shares, -1.0, Par::Seq);
        }
    }

    /// `Λ⁻¹Bᵀ` of unit forces at a node, shape (r, 3): what the modes answer.
    pub(crate) fn modal(&self, node: u32) -> Mat<f64> {
        let row =
            |k: usize, c: usize| self.value(node, c, |free| self.compliances[k] * self.vectors[(free, k)]);
        Mat::from_fn(self.compliances.len(), 3, row)
    }

    /// `Bᵀ` times three weighed columns, shape (r, 3).
    pub(crate) fn project(&self, weighed: MatRef<'_, f64>) -> Mat<f64> {
        let mut product = Mat::zeros(self.compliances.len(), weighed.ncols());
        if !self.compliances.is_empty() {
            let product = product.as_mut();
            matmul(product, Accum::Replace, self.vectors.transpose(), weighed, 1.0, Par::Seq);
        }
        product
    }

    /// The displacement of a node in one column.
    pub(crate) fn row(&self, column: MatRef<'_, f64>, node: u32) -> [f64; 3] {
        std::array::from_fn(|c| self.value(node, c, |free| column[(free, 0)]))
    }

    /// The displacements of a node in three columns, row by row.
    pub(crate) fn rows(&self, columns: MatRef<'_, f64>, node: u32) -> [f64; 9] {
        std::array::from_fn(|at| self.value(node, at / 3, |free| columns[(free, at % 3)]))
    }

    /// Adds the unit force along what a probe looks at.
    pub(crate) fn add_probe(&self, probe: &Probe, load: &mut [f64]) {
        self.body.probe_row(probe).into_iter().for_each(|(free, weight)| load[free as usize] += weight);
    }

    /// Values of all probes in one column.
    pub(crate) fn probe_values(&self, column: MatRef<'_, f64>) -> Vec<f64> {
        let value = |probe: &Probe| {
            let row = self.body.probe_row(probe).into_iter();
            row.map(|(free, weight)| weight * column[(free as usize, 0)]).sum()
        };
        self.body.probes.iter().map(value).collect()
    }
}

/// Shows the columns of two matrices in groups: whole matrices may be wide, and a group keeps what a product
/// needs in addition small.
pub(super) fn columns_of(
    from: MatRef<'_, f64>,
    to: MatMut<'_, f64>,
    work: impl Fn(MatRef<'_, f64>, MatMut<'_, f64>),
) {
    for (to, from) in column_groups(to, GROUP).into_iter().zip(groups(from)) {
        work(from, to);
    }
}

/// The columns of a matrix in groups.
fn groups(vectors: MatRef<'_, f64>) -> impl Iterator<Item = MatRef<'_, f64>> {
    let last = vectors.ncols();
    let group = move |first: usize| vectors.subcols(first, GROUP.min(last - first));
    // No columns are one group of none, as `column_groups` has it.
    (0..last.max(1)).step_by(GROUP).map(group)
}
