//! Sparse Cholesky factorisation of `m M + k K`: symbolic once per pattern, numeric per matrix, a solve per
//! block of right-hand sides.
//!
//! The fill-reducing order is a nested dissection of the *node* graph by METIS, each node then standing for
//! its free dofs: a third of the graph, and 1.3–2.7 times faster factors than minimum degree on solids. faer
//! finds the structure and solves; all threads make the numbers, in [`super::multifrontal`]. Solves run on
//! one thread for each group of columns. The bits never depend on the number of threads.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::sparse::FaerError;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Conj, Mat, MatMut, Par, Side};
use rayon::prelude::*;

use super::engine::{Engine, EngineError, LocalRows, Rows, Search, Spread};
use super::model::Model;
use super::multifrontal::factorise;
use super::pencil::Pencil;
use super::rigid::Rigid;
use super::sparse::{Pattern, SymmetricMatrix, contiguous, contiguous_mut};
use super::supernodes::Supernodes;
use crate::linalg::column_groups;

/// Right-hand sides solved together by one thread: 16 columns cost less than 4 single ones, and groups of 8
/// leave work for two threads.
const SOLVE_GROUP: usize = 8;

/// Below this many nodes minimum degree orders as well as a dissection, and faster.
const METIS_NODES: usize = 200;

/// Why a factorisation failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FactorError {
    /// The matrix is not positive definite: a body that can move freely, or a bad combination of weights.
    #[error(
        "the matrix is not positive definite (pivot {pivot} of {n}): is the body held, are all weights positive?"
    )]
    NotPositiveDefinite {
        /// The pivot, in elimination order, at which it showed.
        pivot: usize,
        /// Size of the matrix.
        n: usize,
    },
    /// The factor has more entries than an index can count.
    #[error("the factor has more entries than a 32-bit index can count")]
    TooLarge,
    /// The memory for the factor was refused.
    #[error("not enough memory for the factor")]
    OutOfMemory,
    /// Ranks that factorise together had to stop.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

impl From<FaerError> for FactorError {
    fn from(error: FaerError) -> FactorError {
        match error {
            FaerError::IndexOverflow => FactorError::TooLarge,
            _ => FactorError::OutOfMemory,
        }
    }
}

/// Order and structure of the factor of every matrix on one pattern.
#[derive(Clone, Debug)]
pub struct Symbolic {
    pattern: Arc<Pattern>,
    cholesky: Arc<SymbolicCholesky<u32>>,
    /// The factor that was last kept.
    kept: Arc<Mutex<Option<Arc<Factor>>>>,
    /// The rigid motions of a body without supports.
    rigid: Option<Arc<Rigid>>,
    /// What factorises the stiffness where it is not this process alone.
    engine: Option<Arc<dyn Engine>>,
    /// The rigid motions of the body, held or not, where the engine iterates.
    motions: Option<Arc<Mat<f64>>>,
}

impl Symbolic {
    /// Orders the dofs of a pencil and finds the structure of the factor.
    ///
    /// # Errors
    /// [`FactorError::TooLarge`] or [`FactorError::OutOfMemory`].
    pub fn analyze(pencil: &Pencil) -> Result<Symbolic, FactorError> {
        let pattern = pencil.mass().pattern().clone();
        let order = pencil.dof_nodes().and_then(|nodes| dissection_order(&pattern, nodes));
        let cholesky = match order {
            Some((forward, inverse)) => {
                let permutation = PermRef::new_checked(&forward, &inverse, pattern.n());
                symbolic_cholesky(&pattern, SymmetricOrdering::Custom(permutation))?
            }
            None => symbolic_cholesky(&pattern, SymmetricOrdering::Amd)?,
        };
        let rigid = pencil.rigid().cloned();
        let cholesky = Arc::new(cholesky);
        Ok(Symbolic { pattern, cholesky, kept: Arc::default(), rigid, engine: None, motions: None })
    }

    /// The same, with every factor of a stiffness made and kept by an engine. Single factors
    /// ([`Symbolic::factorize`]) stay in this process.
    /// One that iterates needs to know how the body moves as a whole.
    pub fn on(self, engine: Option<Arc<dyn Engine>>, model: &Model) -> Symbolic {
        let iterates = engine.as_ref().is_some_and(|engine| engine.solver().is_some());
        let motions = iterates.then(|| Arc::new(model.rigid_motions()));
        Symbolic { engine, motions, kept: Arc::default(), ..self }
    }

    /// How an engine solves that has no factor.
    pub fn solver(&self) -> Option<String> {
        self.engine.as_ref().and_then(|engine| engine.solver())
    }

    /// The same with all factors in this process, where their entries can be read.
    pub fn here(&self) -> Symbolic {
        let here = self.clone();
        if self.is_spread() { Symbolic { engine: None, kept: Arc::default(), ..here } } else { here }
    }

    /// Whether factors of the stiffness are made by an engine and lie outside this process.
    pub fn is_spread(&self) -> bool {
        self.engine.is_some()
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.pattern.n()
    }

    /// The pattern of the matrices.
    pub(super) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The structure of the factor.
    pub(super) fn cholesky(&self) -> &SymbolicCholesky<u32> {
        &self.cholesky
    }

    /// Memory of one factor \[bytes\].
    pub fn factor_bytes(&self) -> usize {
        self.cholesky.len_val().saturating_mul(size_of::<f64>())
    }

    /// Factorises a matrix, which is kept for refinement. All threads, whose number no bit depends on.
    ///
    /// # Errors
    /// [`FactorError::NotPositiveDefinite`].
    ///
    /// # Panics
    /// If the matrix is on another pattern.
    pub fn factorize(&self, matrix: SymmetricMatrix) -> Result<Factor, FactorError> {
        assert!(Arc::ptr_eq(&self.pattern, matrix.pattern()), "one pattern per symbolic analysis");
        match factorise(&Supernodes::new(&self.cholesky), &matrix) {
            // Of its own, or a factor would keep itself.
            Ok(values) => {
                let symbolic = Symbolic { kept: Arc::default(), ..self.clone() };
                Ok(Factor { symbolic, matrix, values, spread: None, rigid: None })
            }
            Err(pivot) => Err(FactorError::NotPositiveDefinite { pivot, n: self.n() }),
        }
    }

    /// The factor of a stiffness, which is kept until another one is: stages of a build that solve with one
    /// matrix factorise it once. Of a body without supports it solves by inertia relief.
    ///
    /// # Errors
    /// As [`Symbolic::factorize`].
    ///
    /// # Panics
    /// If the matrix is on another pattern.
    pub fn factor_of(&self, matrix: &SymmetricMatrix) -> Result<Arc<Factor>, FactorError> {
        let kept = self.kept().clone();
        if let Some(factor) = kept.filter(|factor| factor.matrix.values() == matrix.values()) {
            return Ok(factor);
        }
        self.forget();
        let factor = Arc::new(match &self.rigid {
            Some(rigid) => {
                let held = self.factorize_stiffness(rigid.held(matrix))?;
                Factor { matrix: matrix.clone(), rigid: Some(rigid.clone()), ..held }
            }
            None => self.factorize_stiffness(matrix.clone())?,
        });
        *self.kept() = Some(factor.clone());
        Ok(factor)
    }

    /// Factorises where the factors of a stiffness are.
    fn factorize_stiffness(&self, matrix: SymmetricMatrix) -> Result<Factor, FactorError> {
        let Some(engine) = &self.engine else { return self.factorize(matrix) };
        let spread = Some(engine.factorize(
            &matrix,
            &self.order(),
            self.motions.as_ref().map(|motions| motions.as_ref().as_ref()),
        )?);
        let symbolic = Symbolic { kept: Arc::default(), ..self.clone() };
        Ok(Factor { symbolic, matrix, values: vec![], spread, rigid: None })
    }

    /// The row of the matrix that stands at each place of the order of elimination.
    fn order(&self) -> Vec<u32> {
        match self.cholesky.perm() {
            Some(permutation) => permutation.arrays().0.to_vec(),
            None => (0..self.n() as u32).collect(),
        }
    }

    /// The same factor to be used up, kept no longer.
    ///
    /// # Errors
    /// As [`Symbolic::factorize`].
    ///
    /// # Panics
    /// If the matrix is on another pattern.
    pub fn take_factor_of(&self, matrix: &SymmetricMatrix) -> Result<Factor, FactorError> {
        let factor = self.factor_of(matrix)?;
        self.forget();
        Ok(Arc::unwrap_or_clone(factor))
    }

    /// Frees the factor that is kept.
    pub fn forget(&self) {
        *self.kept() = None;
    }

    fn kept(&self) -> MutexGuard<'_, Option<Arc<Factor>>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Factorises several matrices, one thread each.
    ///
    /// # Errors
    /// The error of the first matrix, in the given order, that has one.
    pub fn factorize_all(&self, matrices: Vec<SymmetricMatrix>) -> Result<Vec<Factor>, FactorError> {
        let factors: Vec<_> = matrices.into_par_iter().map(|matrix| self.factorize(matrix)).collect();
        factors.into_iter().collect()
    }
}

/// A factorised matrix.
#[derive(Clone, Debug)]
pub struct Factor {
    symbolic: Symbolic,
    matrix: SymmetricMatrix,
    /// Empty where the factor lies on other ranks too.
    values: Vec<f64>,
    spread: Option<Arc<dyn Spread>>,
    /// Present for the stiffness of a body without supports: the values are those of `Kₛ`, and what is solved
    /// with is `K⁺` of it.
    rigid: Option<Arc<Rigid>>,
}

impl Factor {
    /// The matrix that was factorised.
    pub fn matrix(&self) -> &SymmetricMatrix {
        &self.matrix
    }

    /// The rigid motions, where the matrix is the stiffness of a body without supports.
    pub(super) fn rigid(&self) -> Option<&Arc<Rigid>> {
        self.rigid.as_ref()
    }

    /// The factor of `Kₛ` by itself.
    pub(super) fn without_rigid(&self) -> Factor {
        Factor { rigid: None, ..self.clone() }
    }

    /// The structure the factor was computed on.
    pub fn symbolic(&self) -> &Symbolic {
        &self.symbolic
    }

    /// The rows of a search for modes of the pencil whose stiffness this is the factor of.
    ///
    /// # Errors
    /// [`EngineError`].
    pub(crate) fn rows<'a>(
        &'a self,
        pencil: &'a Pencil,
        search: &Search,
    ) -> Result<Box<dyn Rows + 'a>, EngineError> {
        match &self.spread {
            Some(spread) => spread.begin(pencil.mass(), self.rigid.as_deref(), search),
            None => Ok(Box::new(LocalRows::new(pencil, self))),
        }
    }

    /// `L` of `P A Pᵀ = L Lᵀ`, group by group of columns with the same rows below them.
    ///
    /// # Panics
    /// If the factor is not in this process alone (see [`Symbolic::here`]).
    pub fn columns(&self) -> FactorColumns {
        assert!(self.spread.is_none(), "a factor in this process");
        let cholesky = &self.symbolic.cholesky;
        let mut columns = FactorColumns {
            order: self.symbolic.order(),
            groups: vec![],
            rows: vec![],
            values: Vec::with_capacity(self.values.len()),
        };
        match cholesky.raw() {
            SymbolicCholeskyRaw::Simplicial(structure) => {
                for (first, last) in structure.col_ptr().iter().zip(&structure.col_ptr()[1..]) {
                    // The diagonal is the first of each column.
                    let column = *first as usize..*last as usize;
                    columns.rows.extend(&structure.row_idx()[column.clone()][1..]);
                    columns.groups.push([1, column.len() as u32 - 1]);
                    columns.values.extend(&self.values[column]);
                }
            }
            SymbolicCholeskyRaw::Supernodal(structure) => {
                let factor = SupernodalLltRef::new(structure, &self.values);
                for s in 0..structure.n_supernodes() {
                    let group = factor.supernode(s);
                    let (values, rows) = (group.val(), group.pattern());
                    columns.rows.extend(rows);
                    columns.groups.push([values.ncols() as u32, rows.len() as u32]);
                    for j in 0..values.ncols() {
                        let below = |i: usize| if i < j { 0.0 } else { values[(i, j)] };
                        columns.values.extend((0..values.nrows()).map(below));
                    }
                }
            }
        }
        columns
    }

    /// The structure and the values of `L`; whatever is above a diagonal means nothing.
    pub(super) fn into_values(self) -> (Symbolic, Vec<f64>) {
        (self.symbolic, self.values)
    }

    /// Solves for the few columns of one group.
    fn solve_group(&self, x: MatMut<'_, f64>, memory: &mut MemBuffer) {
        let factor = LltRef::new(&self.symbolic.cholesky, &self.values);
        factor.solve_in_place_with_conj(Conj::No, x, Par::Seq, MemStack::new(memory));
    }
}

/// A factor `L` as a file keeps it.
#[derive(Clone, Debug)]
pub struct FactorColumns {
    /// The row of the matrix that each column stands for, in the order of elimination.
    pub order: Vec<u32>,
    /// Columns of each group, and rows below it.
    pub groups: Vec<[u32; 2]>,
    /// Rows below each group, ascending, one group after the other.
    pub rows: Vec<u32>,
    /// Group by group, each column by column from the first row of the group on; zeros above the diagonal.
    pub values: Vec<f64>,
}

/// Memory for solves of up to a fixed number of right-hand sides, lent to one solve at a time.
pub struct Solve {
    groups: Vec<MemBuffer>,
    /// Right-hand side and residual, present when refinement is asked for.
    refine: Option<[Mat<f64>; 2]>,
}

impl Solve {
    /// Memory for `columns` right-hand sides of factors of one structure; `refine` asks for one step of
    /// iterative refinement in each solve (a product and a second solve; for slender bodies, whose `K` is
    /// ill-conditioned).
    pub fn new(symbolic: &Symbolic, columns: usize, refine: bool) -> Solve {
        let request = symbolic.cholesky.solve_in_place_scratch::<f64>(SOLVE_GROUP.min(columns), Par::Seq);
        // An engine has memory of its own, but a factor of this process may be solved with all the same.
        let groups = columns.div_ceil(SOLVE_GROUP);
        let n = symbolic.n();
        Solve {
            groups: (0..groups).map(|_| MemBuffer::new(request)).collect(),
            refine: refine.then(|| [Mat::zeros(n, columns), Mat::zeros(n, columns)]),
        }
    }

    /// Overwrites `rhs`, shape `(n, c)`, by `A⁻¹ rhs`; groups of columns in parallel, no allocation. For the
    /// stiffness of a body without supports it is `K⁺ rhs` (see [`Rigid`]), which allocates six numbers a
    /// column.
    ///
    /// # Panics
    /// If `rhs` has more columns than this memory was made for.
    pub fn solve_in_place(&mut self, factor: &Factor, mut rhs: MatMut<'_, f64>) {
        let columns = rhs.ncols();
        if let Some(rigid) = &factor.rigid {
            rigid.relieve(rhs.rb_mut());
        }
        let Some([kept, residual]) = self.refine.as_mut() else {
            return solve_centred(&mut self.groups, factor, rhs);
        };
        let mut kept = kept.as_mut().subcols_mut(0, columns);
        let mut residual = residual.as_mut().subcols_mut(0, columns);
        kept.copy_from(rhs.rb());
        solve_centred(&mut self.groups, factor, rhs.rb_mut());
        factor.matrix.mul_into(rhs.rb(), residual.rb_mut());
        for c in 0..columns {
            let target = contiguous(kept.rb(), c);
            for (r, &b) in contiguous_mut(residual.rb_mut(), c).iter_mut().zip(target) {
                *r = b - *r;
            }
        }
        if let Some(rigid) = &factor.rigid {
            rigid.relieve(residual.rb_mut());
        }
        solve_centred(&mut self.groups, factor, residual.rb_mut());
        for c in 0..columns {
            let correction = contiguous(residual.rb(), c);
            for (x, &d) in contiguous_mut(rhs.rb_mut(), c).iter_mut().zip(correction) {
                *x += d;
            }
        }
    }
}

/// Solves for forces that move no body as a whole, and takes such a motion off the answer.
fn solve_centred(memories: &mut [MemBuffer], factor: &Factor, mut rhs: MatMut<'_, f64>) {
    match &factor.spread {
        Some(spread) => spread.solve_in_place(rhs.rb_mut()),
        None => solve_groups(memories, factor, rhs.rb_mut()),
    }
    if let Some(rigid) = &factor.rigid {
        rigid.centre(rhs);
    }
}

/// Solves group by group, each with its own memory.
fn solve_groups(memories: &mut [MemBuffer], factor: &Factor, rhs: MatMut<'_, f64>) {
    assert!(rhs.ncols() <= memories.len() * SOLVE_GROUP, "more columns than the memory was made for");
    if rhs.ncols() <= SOLVE_GROUP {
        if rhs.ncols() > 0 {
            factor.solve_group(rhs, &mut memories[0]);
        }
        return;
    }
    column_groups(rhs, SOLVE_GROUP)
        .into_par_iter()
        .zip(memories.par_iter_mut())
        .for_each(|(group, memory)| factor.solve_group(group, memory));
}

/// Structure of the factor under one order.
fn symbolic_cholesky(
    pattern: &Pattern,
    order: SymmetricOrdering<'_, u32>,
) -> Result<SymbolicCholesky<u32>, FactorError> {
    // Default parameters: faer chooses the supernodal form wherever it pays; forcing the simplicial one is 20
    // × slower.
    let params = CholeskySymbolicParams::default();
    Ok(factorize_symbolic_cholesky(pattern.as_faer(), Side::Lower, order, params)?)
}

/// The dof order that dissects the node graph, as (old of new, new of old); `None` where it would not pay.
fn dissection_order(pattern: &Pattern, dof_nodes: &[u32]) -> Option<(Vec<u32>, Vec<u32>)> {
    let first_dofs = first_dofs(dof_nodes);
    if first_dofs.len() - 1 < METIS_NODES {
        return None;
    }
    let (starts, neighbours) = node_graph(pattern, dof_nodes, &first_dofs);
    let node_order = nested_dissection(starts, neighbours)?;
    let mut forward = Vec::with_capacity(pattern.n());
    for node in node_order {
        forward.extend(first_dofs[node as usize]..first_dofs[node as usize + 1]);
    }
    let mut inverse = vec![0; forward.len()];
    for (new, &old) in forward.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    Some((forward, inverse))
}

/// First dof of each node that has one, and the number of dofs at the end.
fn first_dofs(dof_nodes: &[u32]) -> Vec<u32> {
    let mut first: Vec<u32> = (0..dof_nodes.len())
        .filter(|&d| d == 0 || dof_nodes[d] != dof_nodes[d - 1])
        .map(|d| d as u32)
        .collect();
    first.push(dof_nodes.len() as u32);
    first
}

/// Adjacency of nodes without loops: two nodes are neighbours where any of their dofs share a place.
fn node_graph(pattern: &Pattern, dof_nodes: &[u32], first_dofs: &[u32]) -> (Vec<i32>, Vec<i32>) {
    // Nodes as METIS counts them: those that have a dof, without gaps.
    let mut node_of_dof = vec![0; pattern.n()];
    for dof in 1..pattern.n() {
        node_of_dof[dof] = node_of_dof[dof - 1] + i32::from(dof_nodes[dof] != dof_nodes[dof - 1]);
    }
    let mut starts = vec![0];
    let mut neighbours = Vec::new();
    let mut row = Vec::new();
    for (node, dofs) in first_dofs.windows(2).enumerate() {
        row.clear();
        // Blocks of a mesh are dense, but matrices of another program may leave out their zeros.
        for dof in dofs[0]..dofs[1] {
            row.extend(pattern.rows_of(dof as usize).iter().map(|&other| node_of_dof[other as usize]));
        }
        row.sort_unstable();
        row.dedup();
        neighbours.extend(row.iter().filter(|&&other| other != node as i32));
        starts.push(neighbours.len() as i32);
    }
    (starts, neighbours)
}

/// METIS draws from one process-wide random sequence; two analyses at once would disturb each other's.
static METIS_LOCK: Mutex<()> = Mutex::new(());

/// Elimination order of the nodes (old number of each new one); `None` if METIS refuses.
fn nested_dissection(mut starts: Vec<i32>, mut neighbours: Vec<i32>) -> Option<Vec<i32>> {
    let mut n = i32::try_from(starts.len() - 1).ok()?;
    i32::try_from(neighbours.len()).ok()?;
    if neighbours.is_empty() {
        return None;
    }
    let mut order = vec![0; n as usize];
    let mut inverse = vec![0; n as usize];
    let _guard = METIS_LOCK.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    // SAFETY: METIS_NodeND reads `starts` (n + 1 ascending offsets, the last equal to the length of
    // `neighbours`) and `neighbours` (indices in 0..n, symmetric, no loops), takes null for "no weights" and
    // "default options", and writes n numbers to each of `order` and `inverse`. All outlive the call, none
    // alias, and no pointer is kept.
    #[allow(unsafe_code)]
    let status = unsafe {
        metis_sys::METIS_NodeND(
            &mut n,
            starts.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            std::ptr::null_mut(),
            std::ptr::null_mut(),
            order.as_mut_ptr(),
            inverse.as_mut_ptr(),
        )
    };
    (status == metis_sys::rstatus_et_METIS_OK).then_some(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_neighbours_where_any_of_their_dofs_meet() {
        // Nodes 4 (x, y), 5 (x) and 9 (y): 4x meets 5x, 4y meets 9y.
        let dof_nodes = [4, 4, 5, 9];
        let couplings = [(0, 2), (2, 0), (1, 3), (3, 1)].map(|(i, j)| (i, j, 1.0));
        let pencil = Pencil::from_triplets(4, &[], &couplings).unwrap();
        let first = first_dofs(&dof_nodes);
        assert_eq!(first, [0, 2, 3, 4]);
        let (starts, neighbours) = node_graph(pencil.mass().pattern(), &dof_nodes, &first);
        assert_eq!((starts, neighbours), (vec![0, 2, 3, 4], vec![1, 2, 0, 0]));
    }
}
