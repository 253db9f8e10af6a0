//! Sparse Cholesky factorisation of `m M + k K`: symbolic once per pattern, numeric per matrix, a solve per
//! block of right-hand sides.
//!
//! The order and the structure are those of [`super::ordering`]; all threads make the numbers, in
//! [`super::multifrontal`], and solve with them, in [`super::substitution`]. The bits never depend on the
//! number of threads.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut};

use super::engine::{Engine, PencilRows, Search, SpreadFactor};
use super::factor_error::FactorError;
use super::multifrontal::factorise;
use super::ordering::structure;
use super::pencil::{Pencil, RemoteMatrices};
use super::rigid::RigidBody;
use super::single::{Iteration, SingleFactor, TOLERANCE};
use super::sparse::{AT_ONCE, Pattern, SymmetricMatrix, contiguous, contiguous_mut};
use super::spread::{EngineError, SpreadMatrix};
use super::substitution::{LARGE, gather, scatter, substitute, substitute_by_groups};
use super::supernodes::Supernodes;
use super::thin::padded;
use crate::linalg::{Random, column_groups};
use crate::parallel;

/// Right-hand sides solved together by one thread with a small factor: 16 columns cost less than 4 single
/// ones, and groups of 8 leave work for two threads.
const SOLVE_GROUP: usize = 8;

/// Precondition of reading the entries of a factor.
const READABLE: &str = "a factor in this process and in double precision";

/// Order and structure of the factor of every matrix on one pattern.
#[derive(Clone, Debug)]
pub struct Symbolic {
    n: usize,
    found: Arc<OnceLock<(Arc<Pattern>, Arc<Supernodes>)>>,
    /// Their source once a factor in this process needs them, where rows are on other ranks.
    away: Option<Arc<RemoteMatrices>>,
    /// The factor that was last kept.
    kept: Arc<Mutex<Option<Arc<Factor>>>>,
    /// The rigid motions of a body without supports.
    rigid: Option<Arc<RigidBody>>,
    /// The engine that factorises the stiffness; none where this process does.
    engine: Option<Arc<dyn Engine>>,
    /// The rigid motions of the body, held or not, where the engine iterates.
    motions: Option<Arc<Mat<f64>>>,
    /// True if the factors of the stiffness are in single precision.
    single: bool,
    /// The largest error that an iteration left, relative in the energy norm.
    worst: Arc<Mutex<f64>>,
}

impl Symbolic {
    /// Orders the dofs of a pencil and finds the structure of the factor. Where rows lie on ranks this waits
    /// until a factor in this process is asked for.
    ///
    /// # Errors
    /// [`FactorError::OutOfMemory`].
    pub fn analyze(pencil: &Pencil) -> Result<Symbolic, FactorError> {
        let away = pencil.away().cloned();
        let found = match away {
            Some(_) => OnceLock::new(),
            None => OnceLock::from(analysis(pencil)?),
        };
        Ok(Symbolic {
            n: pencil.n_dof(),
            found: Arc::new(found),
            away,
            kept: Arc::default(),
            rigid: pencil.rigid().cloned(),
            engine: None,
            motions: None,
            single: false,
            worst: Arc::default(),
        })
    }

    /// Pattern and structure.
    fn found(&self) -> &(Arc<Pattern>, Arc<Supernodes>) {
        self.found.get_or_init(|| {
            let away = self.away.as_ref().expect("it is found at once without ranks");
            analysis(away.here.get()).expect("memory for the structure of a factor")
        })
    }

    /// The free dof at each place of the order of elimination.
    fn order(&self) -> &[u32] {
        self.away.as_ref().map_or_else(|| self.supernodes().order(), |away| &away.order)
    }

    /// The same, with every factor of a stiffness made and kept by an engine. Single factors
    /// ([`Symbolic::factorize`]) stay in this process.
    /// One that iterates needs to know how the body moves as a whole, shape (n, 6).
    pub fn on(self, engine: Option<Arc<dyn Engine>>, motions: impl FnOnce() -> Mat<f64>) -> Symbolic {
        let iterates = engine.as_ref().is_some_and(|engine| engine.solver().is_some());
        let motions = iterates.then(|| Arc::new(motions()));
        Symbolic { engine, motions, kept: Arc::default(), ..self }
    }

    /// The same, with every factor of a stiffness in single precision.
    pub(crate) fn in_single_precision(self) -> Symbolic {
        Symbolic { single: true, kept: Arc::default(), ..self }
    }

    /// True if every system so far was solved to the tolerance.
    ///
    /// # Errors
    /// [`FactorError::NotConverged`].
    pub(crate) fn check_solves(&self) -> Result<(), FactorError> {
        let error = *self.worst.lock().unwrap_or_else(PoisonError::into_inner);
        if error <= TOLERANCE { Ok(()) } else { Err(FactorError::NotConverged { error }) }
    }

    /// Description of the solver, unless it is a factor in double precision alone.
    pub fn solver(&self) -> Option<String> {
        if self.single {
            let preconditioner = "a factor in single precision";
            return Some(format!(
                "conjugate gradients with {preconditioner} to {TOLERANCE:e} of the energy norm"
            ));
        }
        self.engine.as_ref().and_then(|engine| engine.solver())
    }

    /// The same with all factors in this process and in double precision, where their entries can be read.
    pub fn here(&self) -> Symbolic {
        let here = self.clone();
        if self.has_entries() {
            here
        } else {
            Symbolic { engine: None, single: false, kept: Arc::default(), ..here }
        }
    }

    /// True if the entries of a factor of the stiffness can be read.
    pub(crate) fn has_entries(&self) -> bool {
        !self.is_spread() && !self.single
    }

    /// Memory of the factor of the stiffness in this process \[bytes\].
    pub(crate) fn stiffness_bytes(&self) -> usize {
        match (self.is_spread(), self.single) {
            (true, _) => 0,
            (false, true) => {
                SingleFactor::bytes(self.supernodes()).saturating_add(Iteration::bytes(self.n(), AT_ONCE))
            }
            (false, false) => self.factor_bytes(),
        }
    }

    /// True if factors of the stiffness are made by an engine and lie outside this process.
    pub(crate) fn is_spread(&self) -> bool {
        self.engine.is_some()
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.n
    }

    /// The pattern of the matrices.
    pub(super) fn pattern(&self) -> &Pattern {
        &self.found().0
    }

    /// The structure of the factor.
    pub(super) fn supernodes(&self) -> &Arc<Supernodes> {
        &self.found().1
    }

    /// Memory of one factor in this process \[bytes\]; a close estimate where rows lie on ranks.
    pub(crate) fn factor_bytes(&self) -> usize {
        let entries = match (&self.away, self.found.get()) {
            (Some(away), None) => away.factor_entries,
            _ => self.supernodes().len(),
        };
        entries.saturating_mul(size_of::<f64>())
    }

    /// Factorises a matrix, which is kept for refinement. All threads, whose number no bit depends on.
    ///
    /// # Errors
    /// [`FactorError::NotPositiveDefinite`].
    ///
    /// # Panics
    /// If the matrix is on another pattern.
    pub fn factorize(&self, matrix: SymmetricMatrix) -> Result<Factor, FactorError> {
        assert!(std::ptr::eq(self.pattern(), &**matrix.pattern()), "one pattern per symbolic analysis");
        match factorise(self.supernodes(), &matrix, None) {
            // Of its own, or a factor would keep itself.
            Ok(values) => Ok(self.factor(matrix, Numbers::Double(values))),
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
        if let Some(factor) = kept.filter(|factor| factor.matrix.is_same(matrix)) {
            return Ok(factor);
        }
        self.forget();
        let numbers = self.numbers_of(matrix)?;
        let factor = Factor { rigid: self.rigid.clone(), ..self.factor(matrix.clone(), numbers) };
        let factor = Arc::new(factor);
        if self.single {
            // As good as any other right-hand side to show whether they can be solved for.
            let mut random = Random::new(1);
            let mut x = Mat::from_fn(self.n(), 1, |_, _| random.uniform() - 0.5);
            Solve::new(self, 1, false).solve_in_place(&factor, x.as_mut());
            self.check_solves()?;
        }
        *self.kept() = Some(factor.clone());
        Ok(factor)
    }

    /// Factorises a stiffness where the factors of stiffnesses are.
    fn numbers_of(&self, matrix: &SymmetricMatrix) -> Result<Numbers, FactorError> {
        if let Some(engine) = &self.engine {
            let motions = self.motions.as_ref().map(|motions| motions.as_ref().as_ref());
            let rows = on_ranks(matrix, engine, self.order())?;
            let spread = engine.factorize(&*rows, self.order(), motions, self.rigid.as_ref())?;
            return Ok(Numbers::Distributed(spread));
        }
        let held = self.rigid.as_ref().map_or_else(|| matrix.clone(), |rigid| rigid.held(matrix));
        if self.single {
            let single = SingleFactor::new(self.supernodes(), &held);
            return Ok(Numbers::Single(single.ok_or(FactorError::NotConverged { error: 1.0 })?));
        }
        Ok(self.factorize(held)?.numbers)
    }

    fn factor(&self, matrix: SymmetricMatrix, numbers: Numbers) -> Factor {
        // Of its own, or a factor would keep itself.
        let symbolic = Symbolic { kept: Arc::default(), ..self.clone() };
        Factor { symbolic, matrix, numbers, rigid: None }
    }

    /// The same factor to be used up, kept no longer.
    ///
    /// # Errors
    /// As [`Symbolic::factorize`].
    ///
    /// # Panics
    /// If the matrix is on another pattern.
    pub(crate) fn take_factor_of(&self, matrix: &SymmetricMatrix) -> Result<Factor, FactorError> {
        let factor = self.factor_of(matrix)?;
        self.forget();
        Ok(Arc::unwrap_or_clone(factor))
    }

    /// Frees the factor that is kept.
    pub fn forget(&self) {
        let kept = self.kept().take();
        // Ranks may have to be asked, which others may be doing while they wait for what is kept.
        drop(kept);
    }

    fn kept(&self) -> MutexGuard<'_, Option<Arc<Factor>>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Factorises several matrices, one thread each.
    ///
    /// # Errors
    /// The error of the first matrix, in the given order, that has one.
    pub(crate) fn factorize_all(&self, matrices: Vec<SymmetricMatrix>) -> Result<Vec<Factor>, FactorError> {
        let factors = parallel::map_of(matrices, &|_, matrix| self.factorize(matrix));
        factors.into_iter().collect()
    }
}

/// Pattern, order and structure of a factor.
fn analysis(pencil: &Pencil) -> Result<(Arc<Pattern>, Arc<Supernodes>), FactorError> {
    let supernodes = structure(pencil).map_err(|_| FactorError::OutOfMemory)?;
    Ok((pencil.mass().pattern().clone(), Arc::new(supernodes)))
}

/// The rows of a matrix on the ranks, dealt out if they are here.
fn on_ranks(
    matrix: &SymmetricMatrix,
    engine: &Arc<dyn Engine>,
    order: &[u32],
) -> Result<Arc<dyn SpreadMatrix>, EngineError> {
    matrix.spread().map_or_else(|| engine.deal(matrix, order), |rows| Ok(rows.clone()))
}

/// Storage of the numbers of a factor.
#[derive(Clone, Debug)]
enum Numbers {
    /// Here, group by group.
    Double(Vec<f64>),
    Single(SingleFactor),
    /// On other ranks too.
    Distributed(Arc<dyn SpreadFactor>),
}

/// A factorised matrix.
#[derive(Clone, Debug)]
pub struct Factor {
    symbolic: Symbolic,
    matrix: SymmetricMatrix,
    numbers: Numbers,
    /// Present for the stiffness of a body without supports: the values are those of `Kₛ`, and what is solved
    /// with is `K⁺` of it.
    rigid: Option<Arc<RigidBody>>,
}

impl Factor {
    /// The matrix that was factorised.
    pub fn matrix(&self) -> &SymmetricMatrix {
        &self.matrix
    }

    /// The rigid motions, where the matrix is the stiffness of a body without supports.
    pub(super) fn rigid(&self) -> Option<&Arc<RigidBody>> {
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

    /// The rows of a search for modes of the pencil whose stiffness this is the factor of, where they are
    /// spread over ranks; `None` where they are all here.
    ///
    /// # Errors
    /// [`EngineError`].
    pub(super) fn spread_rows<'a>(
        &'a self,
        pencil: &Pencil,
        search: &Search,
    ) -> Result<Option<Box<dyn PencilRows + 'a>>, EngineError> {
        let Numbers::Distributed(spread) = &self.numbers else { return Ok(None) };
        let engine = self.symbolic.engine.as_ref().expect("what is spread has an engine");
        spread.begin(on_ranks(pencil.mass(), engine, self.symbolic.order())?, search).map(Some)
    }

    /// `L` of `P A Pᵀ = L Lᵀ`, group by group of columns with the same rows below them.
    ///
    /// # Panics
    /// If the factor is not in this process alone, or not in double precision (see [`Symbolic::here`]).
    pub fn columns(&self) -> FactorColumns {
        let values = self.values();
        let supernodes = self.symbolic.supernodes();
        let mut columns = FactorColumns {
            order: supernodes.order().to_vec(),
            groups: vec![],
            rows: vec![],
            values: Vec::with_capacity(values.len()),
        };
        for group in &supernodes.groups {
            columns.rows.extend(supernodes.rows(group));
            columns.groups.push([group.columns as u32, group.below() as u32]);
            for (j, column) in values[group.values.clone()].chunks_exact(group.height()).enumerate() {
                columns.values.extend(column.iter().enumerate().map(|(i, &l)| if i < j { 0.0 } else { l }));
            }
        }
        columns
    }

    /// The values of `L` in double precision.
    fn values(&self) -> &[f64] {
        match &self.numbers {
            Numbers::Double(values) => values,
            _ => panic!("{READABLE}"),
        }
    }

    /// The structure and the values of `L`; whatever is above a diagonal means nothing.
    pub(super) fn into_values(self) -> (Symbolic, Vec<f64>) {
        match self.numbers {
            Numbers::Double(values) => (self.symbolic, values),
            _ => panic!("{READABLE}"),
        }
    }
}

/// A factor `L` as a file keeps it.
#[derive(Clone, Debug)]
pub struct FactorColumns {
    /// The row of the matrix of each column, in the order of elimination.
    pub order: Vec<u32>,
    /// Columns of each group, and rows below it.
    pub(crate) groups: Vec<[u32; 2]>,
    /// Rows below each group, ascending, one group after the other.
    pub rows: Vec<u32>,
    /// Group by group, each column by column from the first row of the group on; zeros above the diagonal.
    pub values: Vec<f64>,
}

/// Memory for solves of up to a fixed number of right-hand sides, lent to one solve at a time.
pub struct Solve {
    columns: usize,
    /// Made by the first solve, for the kind of its factor.
    memory: Option<SolveMemory>,
    /// Right-hand side and residual, present when refinement is asked for.
    refine: Option<[Mat<f64>; 2]>,
}

/// Memory of a solve.
enum SolveMemory {
    /// For each group of columns: these in the order of elimination, and what the tallest group of the factor
    /// takes.
    Small(Vec<[Vec<f64>; 2]>),
    /// As many columns as are solved for together, in the order of elimination.
    Large(Vec<f64>),
    Iteration(Iteration),
}

impl SolveMemory {
    fn new(factor: &Factor, columns: usize) -> Option<SolveMemory> {
        let n = factor.symbolic.n();
        match &factor.numbers {
            Numbers::Distributed(_) => None,
            Numbers::Single(_) => Some(SolveMemory::Iteration(Iteration::new(n, columns.min(AT_ONCE)))),
            Numbers::Double(values) if values.len() > LARGE => {
                Some(SolveMemory::Large(vec![0.0; n * padded(columns.min(AT_ONCE))]))
            }
            Numbers::Double(_) => {
                let (width, tallest) = (SOLVE_GROUP.min(columns), factor.symbolic.supernodes().tallest());
                let group = |_| [n, tallest].map(|rows| vec![0.0; rows * width]);
                Some(SolveMemory::Small((0..columns.div_ceil(SOLVE_GROUP)).map(group).collect()))
            }
        }
    }
}

impl Solve {
    /// Memory for `columns` right-hand sides of factors of one structure; `refine` asks for one step of
    /// iterative refinement in each solve (a product and a second solve; for slender bodies, whose `K` is
    /// ill-conditioned).
    pub fn new(symbolic: &Symbolic, columns: usize, refine: bool) -> Solve {
        let n = symbolic.n();
        let refine = refine && !symbolic.single;
        let refine = refine.then(|| [Mat::zeros(n, columns), Mat::zeros(n, columns)]);
        Solve { columns, memory: None, refine }
    }

    /// Overwrites `rhs`, shape `(n, c)`, by `A⁻¹ rhs`; all threads. For the stiffness of a body without
    /// supports it is `K⁺ rhs` (see [`RigidBody`]).
    ///
    /// # Panics
    /// If `rhs` has more columns than this memory was made for.
    pub fn solve_in_place(&mut self, factor: &Factor, mut rhs: MatMut<'_, f64>) {
        let columns = rhs.ncols();
        if columns == 0 {
            return;
        }
        if let Some(rigid) = &factor.rigid {
            rigid.relieve(rhs.rb_mut());
        }
        let Some([mut kept, mut residual]) = self.refine.take() else {
            return self.solve_centred(factor, rhs);
        };
        {
            let mut kept = kept.as_mut().subcols_mut(0, columns);
            let mut residual = residual.as_mut().subcols_mut(0, columns);
            kept.copy_from(rhs.rb());
            self.solve_centred(factor, rhs.rb_mut());
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
            self.solve_centred(factor, residual.rb_mut());
            for c in 0..columns {
                let correction = contiguous(residual.rb(), c);
                for (x, &d) in contiguous_mut(rhs.rb_mut(), c).iter_mut().zip(correction) {
                    *x += d;
                }
            }
        }
        self.refine = Some([kept, residual]);
    }

    /// Solves for forces that move no body as a whole, and takes such a motion off the answer.
    fn solve_centred(&mut self, factor: &Factor, mut rhs: MatMut<'_, f64>) {
        assert!(rhs.ncols() <= self.columns, "more columns than the memory was made for");
        let supernodes = || factor.symbolic.supernodes();
        if self.memory.is_none() {
            self.memory = SolveMemory::new(factor, self.columns);
        }
        match (&factor.numbers, &mut self.memory) {
            (Numbers::Distributed(spread), _) => spread.solve_in_place(rhs.rb_mut()),
            (Numbers::Double(values), Some(SolveMemory::Small(groups))) => {
                solve_groups(supernodes(), values, rhs.rb_mut(), groups);
            }
            (Numbers::Double(values), Some(SolveMemory::Large(x))) => {
                let supernodes = supernodes();
                for mut rhs in column_groups(rhs.rb_mut(), AT_ONCE) {
                    let (columns, k) = (rhs.ncols(), padded(rhs.ncols()));
                    let x = &mut x[..supernodes.n() * k];
                    gather(supernodes, k, x, |row, c| if c < columns { rhs[(row, c)] } else { 0.0 });
                    substitute_by_groups(supernodes, values, x, k);
                    scatter(supernodes, x, k, rhs.rb_mut(), |x, _, _| x);
                }
            }
            (Numbers::Single(single), Some(SolveMemory::Iteration(memory))) => {
                for rhs in column_groups(rhs.rb_mut(), AT_ONCE) {
                    let error = single.solve(supernodes(), &factor.matrix, rhs, memory);
                    let mut worst = factor.symbolic.worst.lock().unwrap_or_else(PoisonError::into_inner);
                    *worst = worst.max(error);
                }
            }
            _ => unreachable!("one memory is for factors of one kind"),
        }
        if let Some(rigid) = &factor.rigid {
            rigid.centre(rhs);
        }
    }
}

/// Solves with a small factor; threads share groups of columns.
fn solve_groups(supernodes: &Supernodes, values: &[f64], rhs: MatMut<'_, f64>, groups: &mut [[Vec<f64>; 2]]) {
    let groups = column_groups(rhs, SOLVE_GROUP).into_iter().zip(groups);
    parallel::for_each_of(groups, &|_, (mut rhs, [x, spare])| {
        let k = rhs.ncols();
        let x = &mut x[..supernodes.n() * k];
        gather(supernodes, k, x, |row, column| rhs[(row, column)]);
        substitute(supernodes, values, x, k, spare);
        scatter(supernodes, x, k, rhs.rb_mut(), |x, _, _| x);
    });
}
