//! The rows of one rank in a search for modes.

use std::collections::BTreeMap;
use std::ops::DerefMut;
use std::sync::Arc;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};
use vademecum_build::fem::{EngineError, MassProduct, PencilRows, SpreadMatrix};

use crate::calls::{Factor, Iteration, Matrix};
use crate::deal::Share;
use crate::ranks::Ranks;

/// A solver with its matrix.
pub enum Solver {
    /// A factor by MUMPS.
    Direct(Factor),
    /// Conjugate gradients.
    Iterative(Iteration),
}

impl Solver {
    /// The matrix.
    pub fn matrix(&mut self) -> &mut Matrix {
        match self {
            Self::Direct(factor) => factor.matrix(),
            Self::Iterative(iteration) => iteration.matrix(),
        }
    }

    /// `A⁻¹` of forces, own rows column after column.
    pub fn solve(&mut self, forces: Vec<f64>, columns: usize) -> Result<Vec<f64>, EngineError> {
        match self {
            Self::Direct(factor) => factor.solve(forces, columns),
            Self::Iterative(iteration) => iteration.solve(&forces, columns),
        }
    }
}

/// A matrix, this rank's rows of it.
pub struct LocalMatrix {
    /// The rows.
    pub matrix: Matrix,
    /// The row of the whole matrix that each own row is.
    pub places: Arc<Vec<i64>>,
    /// Rows of all ranks.
    pub total: usize,
}

impl LocalMatrix {
    /// Makes a matrix of the rows of all ranks.
    pub fn new(total: usize, share: &Share, places: &Arc<Vec<i64>>) -> Result<Self, EngineError> {
        let matrix = Matrix::new(total, &share.starts, &share.columns, &share.values)?;
        Ok(Self { matrix, places: places.clone(), total })
    }

    /// The matrix times a number.
    pub fn scaled(&self, weight: f64) -> Result<Self, EngineError> {
        Ok(Self { matrix: self.matrix.scaled(weight)?, places: self.places.clone(), ..*self })
    }
}

/// A stiffness to solve with, this rank's rows of it.
pub struct LocalSolver {
    /// The solver with its matrix.
    pub solver: Solver,
    /// Own rows with a spring that holds a body without supports, and its stiffness.
    pub springs: Vec<(usize, f64)>,
    /// The row of the whole matrix that each own row is.
    pub places: Arc<Vec<i64>>,
    /// Rows of all ranks.
    pub total: usize,
    /// The folder of a factor out of core, which goes with it.
    pub _scratch: Option<Scratch>,
}

/// A folder of this rank that is removed with its content.
pub struct Scratch(pub std::path::PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed is left behind: the file is what counts.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Rigid motions of a body without supports, and their momenta.
pub struct Relief {
    /// `Φ`, own rows.
    pub motions: Mat<f64>,
    /// `MΦ`, own rows.
    pub momenta: Mat<f64>,
}

/// The ranks, and the matrices and factors that lie on them.
pub struct Session {
    pub ranks: Ranks,
    /// This rank's part of each matrix, by its number.
    pub matrices: BTreeMap<u64, LocalMatrix>,
    /// This rank's part of each factor, by its number.
    pub factors: BTreeMap<u64, LocalSolver>,
    /// The number of the next matrix or factor.
    next: u64,
    /// True if a call failed: then the others may wait for what will not come.
    pub lost: bool,
}

impl Session {
    pub fn new(ranks: Ranks) -> Self {
        Self { ranks, matrices: BTreeMap::new(), factors: BTreeMap::new(), next: 0, lost: false }
    }

    /// A new number.
    pub fn number(&mut self) -> u64 {
        self.next += 1;
        self.next
    }

    /// A matrix.
    pub fn matrix(&mut self, id: u64) -> Result<&mut LocalMatrix, EngineError> {
        self.matrices.get_mut(&id).ok_or_else(unknown)
    }

    /// A factor.
    pub fn factor(&mut self, id: u64) -> Result<&mut LocalSolver, EngineError> {
        self.factors.get_mut(&id).ok_or_else(unknown)
    }

    /// Frees what has a number.
    pub fn free(&mut self, id: u64) {
        self.matrices.remove(&id);
        self.factors.remove(&id);
    }

    /// Remembers that a call failed.
    pub fn noted<T>(&mut self, result: Result<T, EngineError>) -> Result<T, EngineError> {
        self.lost |= result.is_err();
        result
    }
}

fn unknown() -> EngineError {
    EngineError {
        call: "MPI_Recv".into(),
        reason: "the number of a matrix or factor that this rank does not hold".into(),
        short: None,
    }
}

/// Rows of the mass and of a factorised stiffness on one rank. `S` is how the session is reached: through a
/// lock on the first rank, which has several threads, and directly on the others.
pub struct SpreadRows<S> {
    pub session: S,
    /// The number of the factor.
    pub id: u64,
    /// The number of the mass.
    pub mass: u64,
    pub relief: Option<Relief>,
    /// The row of the whole matrix at each place, on the first rank.
    pub order: Arc<Vec<u32>>,
    /// The mass as the first rank knows it, to be freed after the session is.
    pub _kept: Option<Arc<dyn SpreadMatrix>>,
}

/// `y ← A x`.
fn multiply(matrix: &mut Matrix, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError> {
    let product = matrix.multiply(&packed(x), x.ncols())?;
    unpack(&product, y);
    Ok(())
}

/// Columns that stand one after the other.
fn unpack(columns: &[f64], mut to: MatMut<'_, f64>) {
    let rows = to.nrows();
    (0..to.ncols()).for_each(|c| column_mut(to.rb_mut(), c).copy_from_slice(&columns[c * rows..][..rows]));
}

fn column<'a>(x: MatRef<'a, f64>, c: usize) -> &'a [f64] {
    x.col(c).try_as_col_major().expect("columns are contiguous").as_slice()
}

fn column_mut<'a>(x: MatMut<'a, f64>, c: usize) -> &'a mut [f64] {
    x.col_mut(c).try_as_col_major_mut().expect("columns are contiguous").as_slice_mut()
}

/// Columns one after the other.
pub fn packed(x: MatRef<'_, f64>) -> Vec<f64> {
    (0..x.ncols()).flat_map(|c| column(x, c).iter().copied()).collect()
}

/// `x ← x − A (BᵀX)`, the product summed over the ranks.
fn take_off(ranks: &Ranks, mut x: MatMut<'_, f64>, a: &Mat<f64>, b: &Mat<f64>) -> Result<(), EngineError> {
    let product = b.transpose() * x.rb();
    let mut shares = packed(product.as_ref());
    ranks.calls.sum(&mut shares)?;
    for c in 0..x.ncols() {
        let column = column_mut(x.rb_mut(), c);
        for (k, share) in shares[c * a.ncols()..][..a.ncols()].iter().enumerate() {
            column.iter_mut().zip(a.col_as_slice(k)).for_each(|(x, a)| *x -= share * a);
        }
    }
    Ok(())
}

impl<S: DerefMut<Target = Session>> SpreadRows<S> {
    fn factor(&self) -> &LocalSolver {
        self.session.factors.get(&self.id).expect("a factor that is not released")
    }

    fn solver(&mut self) -> &mut Solver {
        &mut self.session.factors.get_mut(&self.id).expect("a factor that is not released").solver
    }

    /// Takes off forces what accelerates a body without supports as a whole.
    fn relieve(&self, forces: MatMut<'_, f64>) -> Result<(), EngineError> {
        let Some(relief) = &self.relief else { return Ok(()) };
        take_off(&self.session.ranks, forces, &relief.momenta, &relief.motions)
    }

    /// Solves for forces that are relieved, and takes off what moves mass as a whole.
    fn solve_relieved(&mut self, mut x: MatMut<'_, f64>) -> Result<(), EngineError> {
        let answers = self.solver().solve(packed(x.rb()), x.ncols())?;
        unpack(&answers, x.rb_mut());
        let Some(relief) = &self.relief else { return Ok(()) };
        take_off(&self.session.ranks, x, &relief.motions, &relief.momenta)
    }

    /// `y ← K x`, each row summed closely. Every rank needs all rows of a column for that.
    fn multiply_closely(&mut self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) -> Result<(), EngineError> {
        let ranks = &self.session.ranks;
        let places = ranks.rows_of(ranks.calls.rank, self.factor().total);
        for c in 0..x.ncols() {
            let mut whole = vec![0.0; self.factor().total];
            whole[places.clone()].copy_from_slice(column(x, c));
            self.session.ranks.calls.sum(&mut whole)?;
            let springs = self.factor().springs.clone();
            self.solver().matrix().multiply_closely(&whole, &springs, column_mut(y.rb_mut(), c))?;
        }
        Ok(())
    }

    /// Hands every rank its rows of a block that the first one has whole.
    fn scattered(&self, whole: Option<&Mat<f64>>, mut own: MatMut<'_, f64>) -> Result<(), EngineError> {
        let (ranks, columns) = (&self.session.ranks, own.ncols());
        let part = match whole {
            Some(whole) => {
                let part = |rank| take(whole.as_ref(), &self.order[ranks.rows_of(rank, whole.nrows())]);
                ranks.others().try_for_each(|rank| ranks.send(&part(rank), rank))?;
                part(0)
            }
            None => ranks.receive(own.nrows() * columns, 0)?,
        };
        unpack(&part, own.rb_mut());
        Ok(())
    }

    /// All rows of a block on the first rank.
    fn gathered(&self, x: Mat<f64>) -> Result<Mat<f64>, EngineError> {
        if !self.session.ranks.is_first() {
            self.session.ranks.send(&packed(x.as_ref()), 0)?;
            return Ok(Mat::zeros(0, x.ncols()));
        }
        let mut whole = Mat::zeros(self.factor().total, x.ncols());
        for rank in 0..self.session.ranks.calls.size {
            let places = self.session.ranks.rows_of(rank, self.factor().total);
            let own = match rank {
                0 => packed(x.as_ref()),
                _ => self.session.ranks.receive(places.len() * x.ncols(), rank)?,
            };
            put(whole.as_mut(), &self.order[places], &own);
        }
        Ok(whole)
    }
}

impl<S: DerefMut<Target = Session>> MassProduct for SpreadRows<S> {
    fn mul_mass(&mut self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError> {
        let mass = self.mass;
        let done = self.session.matrix(mass).and_then(|mass| multiply(&mut mass.matrix, x, y));
        self.session.noted(done)
    }

    fn sum(&mut self, numbers: &mut [f64]) -> Result<(), EngineError> {
        let done = self.session.ranks.calls.sum(numbers);
        self.session.noted(done)
    }
}

impl<S: DerefMut<Target = Session>> PencilRows for SpreadRows<S> {
    fn own(&self) -> usize {
        self.factor().places.len()
    }

    fn total(&self) -> usize {
        self.factor().total
    }

    fn part_into(&self, whole: &[f64], own: &mut [f64]) {
        own.iter_mut()
            .zip(self.factor().places.iter())
            .for_each(|(own, &place)| *own = whole[place as usize]);
    }

    fn mul_stiffness(&mut self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) -> Result<(), EngineError> {
        let done = multiply(self.solver().matrix(), x, y.rb_mut());
        self.session.noted(done)?;
        for &(row, spring) in &self.factor().springs {
            (0..x.ncols()).for_each(|c| y[(row, c)] -= spring * x[(row, c)]);
        }
        Ok(())
    }

    fn mul_stiffness_closely(&mut self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) -> Result<(), EngineError> {
        let done = self.multiply_closely(x, y);
        self.session.noted(done)
    }

    fn solve(&mut self, mut x: MatMut<'_, f64>) -> Result<(), EngineError> {
        let done = self.relieve(x.rb_mut()).and_then(|()| self.solve_relieved(x));
        self.session.noted(done)
    }

    fn agree(&mut self, numbers: &mut [f64]) -> Result<(), EngineError> {
        let done = self.session.ranks.calls.agree(numbers);
        self.session.noted(done)
    }

    fn gather(&mut self, x: Mat<f64>) -> Result<Mat<f64>, EngineError> {
        let done = self.gathered(x);
        self.session.noted(done)
    }

    fn scatter(&mut self, whole: Option<&Mat<f64>>, own: MatMut<'_, f64>) -> Result<(), EngineError> {
        let done = self.scattered(whole, own);
        self.session.noted(done)
    }
}

/// Puts columns of own rows where they stand in whole columns.
pub fn put(mut whole: MatMut<'_, f64>, places: &[u32], own: &[f64]) {
    for c in 0..whole.ncols() {
        let column = column_mut(whole.rb_mut(), c);
        let part = &own[c * places.len()..][..places.len()];
        places.iter().zip(part).for_each(|(&place, &value)| column[place as usize] = value);
    }
}

/// Columns of the rows at some places of whole columns, one after the other.
pub fn take(whole: MatRef<'_, f64>, places: &[u32]) -> Vec<f64> {
    let part = |c| {
        let column = column(whole, c);
        places.iter().map(move |&place| column[place as usize])
    };
    (0..whole.ncols()).flat_map(part).collect()
}
