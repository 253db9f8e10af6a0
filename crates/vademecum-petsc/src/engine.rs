//! The engine of the first rank, and what the other ranks do when it asks them.

use std::ffi::CString;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};
use vademecum_build::dynamics::{ModesError, search_on};
use vademecum_build::fem::{
    AT_ONCE, Engine, EngineError, FactorError, Rigid, Rows, Search, Spread, SymmetricMatrix,
};
use vademecum_build::limits::Memory;

use crate::calls::{Calls, Factor, Iteration, Matrix};
use crate::deal::{Order, Share};
use crate::ranks::{Ranks, Word};
use crate::rows::{Held, Relief, Scratch, Session, Solver, SpreadRows, put, take};

/// The exit code of a job that a rank ended: that of numerics.
const ENDED: u8 = 5;
/// How long a rank that failed waits for the first one to tell the same.
const GRACE: Duration = Duration::from_secs(2);

/// What the user may choose.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Where factors lie on disk; absent: in memory. Every rank makes a folder of its own in it.
    pub out_of_core: Option<PathBuf>,
    /// Conjugate gradients with algebraic multigrid, and no factor, to [`TOLERANCE`].
    pub iterative: bool,
}

/// What conjugate gradients leave of the error, in the energy norm, as a share of the answer.
pub const TOLERANCE: f64 = 1e-10;

/// Memory of conjugate gradients with multigrid as a multiple of that of the matrix: the whole processes of a
/// prototype held 2.7 times their matrix at 282 576 dofs and 5.4 times at 1 044 900.
const MULTIGRID: f64 = 5.5;

/// Starts MPI and PETSc. The first rank does `work` with an engine of all ranks, and its result comes back;
/// the others serve it until it is done, and come back without one.
///
/// Where a rank was lost during the work, the others may wait for what will not come: the process then has
/// to end, by which `mpirun` ends them.
///
/// # Errors
/// [`EngineError`]: MPI or PETSc do not start.
pub fn run<T>(options: &Options, work: impl FnOnce(&Arc<dyn Engine>) -> T) -> Result<Option<T>, EngineError> {
    let mut session = Session::new(Ranks { calls: Calls::start()? });
    if !session.ranks.is_first() {
        while heard(&mut session, options) {}
        session.ranks.calls.finish()?;
        return Ok(None);
    }
    let session = Arc::new(Mutex::new(session));
    let engine: Arc<dyn Engine> = Arc::new(Petsc { session: session.clone(), options: options.clone() });
    let done = work(&engine);
    drop(engine);
    let session = Arc::into_inner(session).expect("factors end with the work");
    let Session { ranks, lost, .. } = session.into_inner().unwrap_or_else(PoisonError::into_inner);
    if !lost {
        ranks.say(Word::Stop)?;
        ranks.calls.finish()?;
    }
    Ok(Some(done))
}

/// Does what the first rank says next; whether there may be more. A failure ends the job.
fn heard(session: &mut Session, options: &Options) -> bool {
    match serve(session, options) {
        Ok(more) => more,
        Err(error) => {
            // Where all ranks failed alike, the first one tells it by itself.
            std::thread::sleep(GRACE);
            end(&session.ranks, &error)
        }
    }
}

/// Names an error and ends the job.
fn end(ranks: &Ranks, error: &EngineError) -> ! {
    eprintln!("error: rank {} of {}: {error}", ranks.calls.rank, ranks.calls.size);
    ranks.calls.abort(ENDED)
}

/// Waits for a word and does it.
fn serve(session: &mut Session, options: &Options) -> Result<bool, EngineError> {
    match session.ranks.hear()? {
        Word::Factorise(id) => {
            let total = session.ranks.receive::<u64>(1, 0)?[0] as usize;
            let share = Share::receive(&session.ranks, 0)?;
            // The first rank tells why there is none.
            let held = if options.iterative {
                let blocks = session.ranks.receive::<u64>(1, 0)?[0] != 0;
                let motions = session.ranks.receive(6 * share.places.len(), 0)?;
                iterate(&session.ranks, share, total, &motions, blocks)?
            } else {
                factorise(&session.ranks, share, total, options)?
            };
            if let Ok(held) = held {
                session.held.insert(id, held);
            }
        }
        Word::Solve(id, columns) => {
            let held = session.held.get_mut(&id).ok_or_else(unknown)?;
            let forces = session.ranks.receive(columns * held.places.len(), 0)?;
            let answers = held.solver.solve(forces, columns)?;
            session.ranks.send(&answers, 0)?;
        }
        Word::Search(id, search, free) => {
            let held = session.held.get(&id).ok_or_else(unknown)?;
            let values: Vec<f64> = session.ranks.receive_list(0)?;
            let relief = free.then(|| receive_relief(&session.ranks, held.places.len())).transpose()?;
            // All ranks make a matrix together, so everything that is sent has to be here before.
            let mass = Matrix::new(held.total, &held.starts, &held.columns, &values)?;
            let mut rows = SpreadRows { session, id, mass, relief, order: Arc::default() };
            // Whatever else ends a search, ends it on all ranks.
            if let Err(ModesError::Engine(error)) = search_on(&mut rows, &search, None) {
                return Err(error);
            }
        }
        Word::Release(id) => drop(session.held.remove(&id)),
        Word::Stop => return Ok(false),
    }
    Ok(true)
}

fn unknown() -> EngineError {
    EngineError {
        call: "MPI_Recv".into(),
        reason: "the number of a factor that this rank does not hold".into(),
    }
}

/// Room beside MUMPS's estimate of its memory that is tried, one after the other \[%\].
const ROOM: [i64; 3] = [30, 100, 400];

/// A factor of the rows of all ranks, or why there is none, which all ranks agree on.
fn factorise(
    ranks: &Ranks,
    share: Share,
    total: usize,
    options: &Options,
) -> Result<Result<Held, FactorError>, EngineError> {
    let Share { starts, columns, values, places } = share;
    let matrix = Matrix::new(total, &starts, &columns, &values)?;
    drop(values);
    let scratch =
        options.out_of_core.as_deref().map(|folder| scratch(folder, ranks.calls.rank)).transpose()?;
    let folder = scratch.as_ref().map(|(_, name)| name);
    let mut factor = Factor::analyse(matrix, folder)?;
    let refused =
        |call: &str, reason: String| Ok(Err(FactorError::Engine(EngineError { call: call.into(), reason })));
    match factor.says_of_all(1)? {
        code if code < 0 => return refused("the analysis of MUMPS", mumps_words(&factor)?),
        _ => {}
    }
    // Numbers 15 and 16 are for a factor in memory, 17 and 26 for one on disk; in MB.
    let (own, most) = if folder.is_some() { (17, 26) } else { (15, 16) };
    let free = Memory::asked_or_available(None).limit() as f64 / ranks.calls.near as f64;
    let mut without = [f64::from(u8::from(factor.says(own)? as f64 * 1e6 > free))];
    ranks.calls.sum(&mut without)?;
    if without[0] > 0.0 {
        let needed = factor.says_of_all(most)?;
        let reason = format!(
            "MUMPS asks for {needed} MB on the rank that takes most, and {without:.0} of {} ranks have less (the \
             first has {:.0} MB): more machines, or `--out-of-core DIR`",
            ranks.calls.size,
            free / 1e6,
            without = without[0]
        );
        return refused("the factorisation of MUMPS", reason);
    }
    for room in ROOM {
        factor.fill(room)?;
        // Too little room for what pivoting needs.
        if ![-8, -9].contains(&factor.says_of_all(1)?) {
            break;
        }
    }
    let negative = factor.says_of_all(12)?;
    match factor.says_of_all(1)? {
        -10 => Ok(Err(FactorError::NotPositiveDefinite { pivot: total, n: total })),
        -13 => Ok(Err(FactorError::OutOfMemory)),
        code if code < 0 => refused("the factorisation of MUMPS", mumps_words(&factor)?),
        _ if negative > 0 => Ok(Err(FactorError::NotPositiveDefinite {
            pivot: total.saturating_sub(negative as usize),
            n: total,
        })),
        _ => Ok(Ok(Held {
            solver: Solver::Direct(factor),
            starts,
            columns,
            places,
            total,
            _scratch: scratch.map(|(folder, _)| folder),
        })),
    }
}

/// Conjugate gradients on the rows of all ranks, or why there are none, which all ranks agree on.
fn iterate(
    ranks: &Ranks,
    share: Share,
    total: usize,
    motions: &[f64],
    blocks: bool,
) -> Result<Result<Held, FactorError>, EngineError> {
    let Share { starts, columns, values, places } = share;
    // A value and an index of 32 bits for each entry.
    let needed = MULTIGRID * 12.0 * values.len() as f64;
    let free = Memory::asked_or_available(None).limit() as f64 / ranks.calls.near as f64;
    let mut without = [f64::from(u8::from(needed > free))];
    ranks.calls.sum(&mut without)?;
    if without[0] > 0.0 {
        let reason = format!(
            "multigrid takes about {:.0} MB on the first rank, and {:.0} of {} ranks have less: more machines",
            needed / 1e6,
            without[0],
            ranks.calls.size,
        );
        return Ok(Err(FactorError::Engine(EngineError { call: "GAMG".into(), reason })));
    }
    let matrix = Matrix::new(total, &starts, &columns, &values)?;
    drop(values);
    let solver = Solver::Iterative(Iteration::new(matrix, motions, blocks, TOLERANCE)?);
    Ok(Ok(Held { solver, starts, columns, places, total, _scratch: None }))
}

/// Whether the three dofs of each node stand together in an order: there the rigid motions begin with rows of
/// the unit matrix.
fn in_blocks(motions: MatRef<'_, f64>, order: &[u32]) -> bool {
    let is_unit = |(at, &row): (usize, &u32)| {
        (0..3).all(|c| motions[(row as usize, c)] == f64::from(u8::from(c == at % 3)))
    };
    order.len().is_multiple_of(3) && order.iter().enumerate().all(is_unit)
}

/// What MUMPS says of an error.
fn mumps_words(factor: &Factor) -> Result<String, EngineError> {
    let [code, detail] = [factor.says_of_all(1)?, factor.says_of_all(2)?];
    let words = match code {
        -90 => "the disk refused a factor out of core: is there room in the folder of `--out-of-core`? ",
        -9 | -8 => "more room than five times the estimate is needed: ",
        _ => "",
    };
    Ok(format!("{words}INFOG(1) = {code}, INFOG(2) = {detail} (MUMPS users' guide, error diagnostics)"))
}

/// A new folder of this rank for a factor out of core, and its name for MUMPS.
fn scratch(folder: &Path, rank: usize) -> Result<(Scratch, CString), EngineError> {
    let own = folder.join(format!("vademecum-{}-{rank}", std::process::id()));
    let refused = |reason: String| EngineError { call: format!("the folder {}", own.display()), reason };
    std::fs::create_dir_all(&own).map_err(|error| refused(error.to_string()))?;
    let scratch = Scratch(own.clone());
    let name = own.to_str().and_then(|name| CString::new(name).ok());
    Ok((scratch, name.ok_or_else(|| refused("its name is no plain text".into()))?))
}

fn receive_relief(ranks: &Ranks, own: usize) -> Result<Relief, EngineError> {
    let six = || -> Result<Mat<f64>, EngineError> {
        let numbers: Vec<f64> = ranks.receive(6 * own, 0)?;
        Ok(Mat::from_fn(own, 6, |i, k| numbers[i + own * k]))
    };
    let (motions, momenta) = (six()?, six()?);
    let rows: Vec<u64> = ranks.receive_list(0)?;
    let springs: Vec<f64> = ranks.receive(rows.len(), 0)?;
    Ok(Relief { motions, momenta, springs: rows.into_iter().map(|row| row as usize).zip(springs).collect() })
}

/// Factorises on all ranks.
struct Petsc {
    session: Arc<Mutex<Session>>,
    options: Options,
}

impl fmt::Debug for Petsc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Petsc").field("options", &self.options).finish_non_exhaustive()
    }
}

fn locked(session: &Mutex<Session>) -> MutexGuard<'_, Session> {
    session.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Engine for Petsc {
    fn solver(&self) -> Option<String> {
        self.options.iterative.then(|| format!("conjugate gradients to {TOLERANCE:e} of the energy norm"))
    }

    fn factorize(
        &self,
        matrix: &SymmetricMatrix,
        order: &[u32],
        motions: Option<MatRef<'_, f64>>,
    ) -> Result<Arc<dyn Spread>, FactorError> {
        let order = Order::new(order);
        let mut session = locked(&self.session);
        let id = session.next;
        session.next += 1;
        let motions = motions.filter(|_| self.options.iterative);
        let made = deal(&session.ranks, id, matrix, &order, motions, &self.options);
        let held = session.noting(made)??;
        session.held.insert(id, held);
        drop(session);
        let diagonal = (0..matrix.n()).map(|row| matrix.diagonal(row)).collect();
        Ok(Arc::new(SpreadFactor {
            session: self.session.clone(),
            id,
            row: Arc::new(order.row.clone()),
            order,
            diagonal,
        }))
    }
}

/// Deals the rows of a matrix and factorises it with the others, or sets up conjugate gradients where there
/// are rigid motions.
fn deal(
    ranks: &Ranks,
    id: u64,
    matrix: &SymmetricMatrix,
    order: &Order,
    motions: Option<MatRef<'_, f64>>,
    options: &Options,
) -> Result<Result<Held, FactorError>, EngineError> {
    let total = matrix.n();
    let blocks = motions.is_some_and(|motions| in_blocks(motions, &order.row));
    let part = |motions, rank| take(motions, &order.row[ranks.rows_of(rank, total)]);
    ranks.say(Word::Factorise(id))?;
    for rank in ranks.others() {
        ranks.send(&[total as u64], rank)?;
        order.share(matrix, ranks.rows_of(rank, total)).send(ranks, rank)?;
        if let Some(motions) = motions {
            ranks.send(&[u64::from(blocks)], rank)?;
            ranks.send(&part(motions, rank), rank)?;
        }
    }
    let own = order.share(matrix, ranks.rows_of(0, total));
    match motions {
        Some(motions) => iterate(ranks, own, total, &part(motions, 0), blocks),
        None => factorise(ranks, own, total, options),
    }
}

/// A factor on all ranks, seen from the first.
struct SpreadFactor {
    session: Arc<Mutex<Session>>,
    id: u64,
    order: Order,
    /// The row of the matrix at each place.
    row: Arc<Vec<u32>>,
    /// Of the matrix.
    diagonal: Vec<f64>,
}

impl fmt::Debug for SpreadFactor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SpreadFactor").field("id", &self.id).finish_non_exhaustive()
    }
}

impl Drop for SpreadFactor {
    fn drop(&mut self) {
        let mut session = locked(&self.session);
        if !session.lost {
            let said = session.ranks.say(Word::Release(self.id));
            let _ = session.noting(said);
            session.held.remove(&self.id);
        } else if let Some(held) = session.held.remove(&self.id) {
            // To free it takes all ranks.
            std::mem::forget(held);
        }
    }
}

impl SpreadFactor {
    /// The rows of the matrix that a rank has.
    fn places(&self, ranks: &Ranks, rank: usize) -> &[u32] {
        &self.row[ranks.rows_of(rank, self.row.len())]
    }

    fn solve(&self, session: &mut Session, mut rhs: MatMut<'_, f64>) -> Result<(), EngineError> {
        let Session { ranks, held, .. } = session;
        let columns = rhs.ncols();
        ranks.say(Word::Solve(self.id, columns))?;
        for rank in ranks.others() {
            ranks.send(&take(rhs.rb(), self.places(ranks, rank)), rank)?;
        }
        let forces = take(rhs.rb(), self.places(ranks, 0));
        let own = held.get_mut(&self.id).ok_or_else(unknown)?.solver.solve(forces, columns)?;
        put(rhs.rb_mut(), self.places(ranks, 0), &own);
        for rank in ranks.others() {
            let places = self.places(ranks, rank);
            let answers: Vec<f64> = ranks.receive(places.len() * columns, rank)?;
            put(rhs.rb_mut(), places, &answers);
        }
        Ok(())
    }

    /// The mass on this rank, once all others have theirs and know what to search for.
    fn spread_mass(
        &self,
        session: &Session,
        mass: &SymmetricMatrix,
        rigid: Option<&Rigid>,
        search: &Search,
    ) -> Result<(Matrix, Option<Relief>), EngineError> {
        let ranks = &session.ranks;
        let total = mass.n();
        ranks.say(Word::Search(self.id, *search, rigid.is_some()))?;
        for rank in ranks.others() {
            ranks.send_list(&self.order.share(mass, ranks.rows_of(rank, total)).values, rank)?;
            if let Some(rigid) = rigid {
                let places = self.places(ranks, rank);
                ranks.send(&take(rigid.motions(), places), rank)?;
                ranks.send(&take(rigid.momenta(), places), rank)?;
                let (rows, springs): (Vec<u64>, Vec<f64>) =
                    self.springs(rigid, places).map(|(row, spring)| (row as u64, spring)).unzip();
                ranks.send_list(&rows, rank)?;
                ranks.send(&springs, rank)?;
            }
        }
        let held = session.held.get(&self.id).ok_or_else(unknown)?;
        let values = self.order.share(mass, ranks.rows_of(0, total)).values;
        let mass = Matrix::new(total, &held.starts, &held.columns, &values)?;
        let relief = rigid.map(|rigid| {
            let places = self.places(ranks, 0);
            let own = |of: MatRef<'_, f64>| Mat::from_fn(places.len(), 6, |i, k| of[(places[i] as usize, k)]);
            let springs = self.springs(rigid, places).collect();
            Relief { motions: own(rigid.motions()), momenta: own(rigid.momenta()), springs }
        });
        Ok((mass, relief))
    }

    /// The springs that hold a body without supports, of those at some rows: the own row, and the stiffness,
    /// which is that of the dof and so half of what stands in the matrix.
    fn springs<'b>(&'b self, rigid: &'b Rigid, places: &'b [u32]) -> impl Iterator<Item = (usize, f64)> + 'b {
        let own = move |pin: usize| {
            let row = places.iter().position(|&place| place as usize == pin)?;
            Some((row, 0.5 * self.diagonal[pin]))
        };
        rigid.pins().into_iter().filter_map(own)
    }
}

impl Spread for SpreadFactor {
    fn solve_in_place(&self, mut rhs: MatMut<'_, f64>) {
        let mut session = locked(&self.session);
        for first in (0..rhs.ncols()).step_by(AT_ONCE) {
            let columns = AT_ONCE.min(rhs.ncols() - first);
            if let Err(error) = self.solve(&mut session, rhs.rb_mut().subcols_mut(first, columns)) {
                end(&session.ranks, &error);
            }
        }
    }

    fn begin<'a>(
        &'a self,
        mass: &SymmetricMatrix,
        rigid: Option<&Rigid>,
        search: &Search,
    ) -> Result<Box<dyn Rows + 'a>, EngineError> {
        let mut session = locked(&self.session);
        let spread = self.spread_mass(&session, mass, rigid, search);
        let (mass, relief) = session.noting(spread)?;
        Ok(Box::new(SpreadRows { session, id: self.id, mass, relief, order: self.row.clone() }))
    }
}
