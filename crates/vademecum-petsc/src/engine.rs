//! The engine of the first rank.

use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};
use vademecum_build::fem::{
    AT_ONCE, AssemblyPlan, ElementError, Engine, EngineError, FactorError, ModelError, PencilRows, Resource,
    RigidBody, Search, SpreadFactor, SpreadMatrix, SymmetricMatrix,
};

use crate::calls::Calls;
use crate::deal::{Share, send_part};
use crate::job::{Options, TOLERANCE, end};
use crate::ranks::{Command, Ranks};
use crate::rows::{LocalMatrix, Relief, Session, SpreadRows, put, take};
use crate::serve::{Springs, make, serve_next};
use crate::work::{assemble, distribute};

/// Starts MPI and PETSc. The first rank does `work` with an engine of all ranks, and its result comes back;
/// the others serve it until it is done, and come back without one.
///
/// If a rank was lost during the work, the others may wait for ever. Then `tell` reports what
/// became of the work and gives an exit code, with which all ranks end: no launcher has to notice.
///
/// # Errors
/// [`EngineError`]: MPI or PETSc do not start.
pub fn run<T>(
    options: &Options,
    work: impl FnOnce(&Arc<dyn Engine>) -> T,
    tell: impl FnOnce(&T) -> u8,
) -> Result<Option<T>, EngineError> {
    let mut session = Session::new(Ranks { calls: Calls::start()? });
    if !session.ranks.is_first() {
        while serve_next(&mut session, options) {}
        let Session { ranks, matrices, factors, .. } = session;
        drop((factors, matrices));
        ranks.calls.finish()?;
        return Ok(None);
    }
    let size = session.ranks.calls.size;
    let session = Arc::new(Mutex::new(session));
    let shared = Shared { session: session.clone(), options: options.clone() };
    let engine: Arc<dyn Engine> = Arc::new(Petsc { shared, size, last: Mutex::default() });
    let done = work(&engine);
    drop(engine);
    let session = Arc::into_inner(session).expect("factors end with the work");
    let Session { ranks, lost, .. } = session.into_inner().unwrap_or_else(PoisonError::into_inner);
    if lost {
        ranks.calls.abort(tell(&done));
    }
    ranks.broadcast(Command::Stop)?;
    ranks.calls.finish()?;
    Ok(Some(done))
}

/// Data shared by all matrices and factors of a job.
#[derive(Clone)]
struct Shared {
    session: Arc<Mutex<Session>>,
    options: Options,
}

impl Shared {
    fn locked(&self) -> MutexGuard<'_, Session> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Works on all ranks.
struct Petsc {
    shared: Shared,
    size: usize,
    /// The order of the last matrix.
    last: Mutex<Arc<Vec<u32>>>,
}

impl fmt::Debug for Petsc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Petsc").field("options", &self.shared.options).finish_non_exhaustive()
    }
}

impl Engine for Petsc {
    fn solver(&self) -> Option<String> {
        let iterative = self.shared.options.iterative;
        iterative.then(|| format!("conjugate gradients to {TOLERANCE:e} of the energy norm"))
    }

    fn ranks(&self) -> usize {
        self.size
    }

    fn assemble(&self, body: &AssemblyPlan) -> Result<[Arc<dyn SpreadMatrix>; 2], ModelError> {
        let mut session = self.shared.locked();
        let ids = [session.number(), session.number()];
        let made = assemble_all(&mut session, ids, body, &self.shared.options);
        let diagonals = session.noted(made)??;
        let mut diagonals = diagonals.into_iter();
        Ok(ids.map(|id| self.spread(id, body.order(), diagonals.next().unwrap_or_default())))
    }

    fn deal(&self, matrix: &SymmetricMatrix, order: &[u32]) -> Result<Arc<dyn SpreadMatrix>, EngineError> {
        let mut session = self.shared.locked();
        let id = session.number();
        let local = deal(&session.ranks, id, matrix, order);
        let local = session.noted(local)?;
        session.matrices.insert(id, local);
        let diagonal = (0..matrix.n()).map(|row| matrix.diagonal(row)).collect();
        Ok(self.spread(id, order, diagonal))
    }

    fn factorize(
        &self,
        matrix: &dyn SpreadMatrix,
        order: &[u32],
        motions: Option<MatRef<'_, f64>>,
        rigid: Option<&Arc<RigidBody>>,
    ) -> Result<Arc<dyn SpreadFactor>, FactorError> {
        let options = &self.shared.options;
        let mut session = self.shared.locked();
        let id = session.number();
        let motions = motions.filter(|_| options.iterative);
        let springs = |places: &[u32]| rigid.map(|rigid| springs_at(places, matrix.diagonal(), rigid));
        let made = factorise_all(&mut session, [id, matrix.number()], order, motions, &springs, options);
        session.noted(made)??;
        let handle = RemoteHandle { shared: self.shared.clone(), id, order: self.order(order) };
        Ok(Arc::new(DistributedFactor { handle, rigid: rigid.cloned() }))
    }
}

impl Petsc {
    fn spread(&self, id: u64, order: &[u32], diagonal: Vec<f64>) -> Arc<dyn SpreadMatrix> {
        let handle = RemoteHandle { shared: self.shared.clone(), id, order: self.order(order) };
        Arc::new(DistributedMatrix { handle, diagonal })
    }

    /// One copy of an order, which all matrices of a body have.
    fn order(&self, order: &[u32]) -> Arc<Vec<u32>> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.as_slice() != order {
            *last = Arc::new(order.to_vec());
        }
        last.clone()
    }
}

/// Has every rank make a multiple of a matrix; this rank's rows.
fn scale(session: &mut Session, id: u64, of: u64, weight: f64) -> Result<LocalMatrix, EngineError> {
    session.ranks.broadcast(Command::Scale(id, of, weight))?;
    session.matrix(of)?.scaled(weight)
}

/// The rows of a matrix that a rank has, as they are sent to it.
fn places_of(ranks: &Ranks, rank: usize, order: &[u32]) -> Vec<i64> {
    order[ranks.rows_of(rank, order.len())].iter().map(|&row| row.into()).collect()
}

/// Tells the other ranks their places among the rows of all.
fn send_places(ranks: &Ranks, rank: usize, order: &[u32]) -> Result<(), EngineError> {
    ranks.send(&[order.len() as u64], rank)?;
    ranks.send_list(&places_of(ranks, rank, order), rank)
}

/// Deals the rows of a matrix; this rank's.
fn deal(ranks: &Ranks, id: u64, matrix: &SymmetricMatrix, order: &[u32]) -> Result<LocalMatrix, EngineError> {
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(at, &row)| place[row as usize] = at as i64);
    let share = |rank| {
        let rows = &order[ranks.rows_of(rank, order.len())];
        Share::of(matrix, rows, |column| place[column as usize])
    };
    ranks.broadcast(Command::Deal(id))?;
    for rank in ranks.others() {
        send_places(ranks, rank, order)?;
        share(rank).send(ranks, rank)?;
    }
    LocalMatrix::new(order.len(), &share(0), &Arc::new(places_of(ranks, 0, order)))
}

/// Has every rank assemble its rows; the diagonals of mass and stiffness, or why there are none.
fn assemble_all(
    session: &mut Session,
    ids: [u64; 2],
    body: &AssemblyPlan,
    options: &Options,
) -> Result<Result<[Vec<f64>; 2], ModelError>, EngineError> {
    let (ranks, order) = (&session.ranks, body.order());
    let total = order.len();
    ranks.broadcast(Command::Assemble(ids[0], ids[1]))?;
    for rank in ranks.others() {
        send_places(ranks, rank, order)?;
        send_part(&body.part(ranks.rows_of(rank, total)), ranks, rank)?;
    }
    let part = body.part(ranks.rows_of(0, total));
    let own = assemble(ranks, &part, options);
    let mut failed: Vec<ModelError> = own.as_ref().err().cloned().into_iter().collect();
    for rank in ranks.others() {
        failed.extend(receive_verdict(ranks, rank)?);
    }
    // The element that one process would have named.
    let element = |error: &ModelError| match error {
        ModelError::FoldedElement { element, .. } => *element,
        _ => u32::MAX,
    };
    let first = failed.into_iter().min_by_key(element);
    ranks.others().try_for_each(|rank| ranks.send(&[u64::from(first.is_none())], rank))?;
    let pencil = match (first, own) {
        (None, Ok(pencil)) => pencil,
        (Some(error), _) | (None, Err(error)) => return Ok(Err(error)),
    };
    let laid = distribute(total, &part, pencil, places_of(ranks, 0, order))?;
    let mut diagonals = [vec![0.0; total], vec![0.0; total]];
    for ((id, diagonal), (local, own)) in ids.into_iter().zip(&mut diagonals).zip(laid) {
        let mut fill = |rank, own: Vec<f64>| {
            let rows = &order[session.ranks.rows_of(rank, total)];
            rows.iter().zip(own).for_each(|(&row, entry)| diagonal[row as usize] = entry);
        };
        fill(0, own);
        session.matrices.insert(id, local);
    }
    for rank in session.ranks.others() {
        let places = session.ranks.rows_of(rank, total);
        for diagonal in &mut diagonals {
            let own: Vec<f64> = session.ranks.receive(places.len(), rank)?;
            order[places.clone()].iter().zip(own).for_each(|(&row, entry)| diagonal[row as usize] = entry);
        }
    }
    Ok(Ok(diagonals))
}

/// Why a rank could not assemble its rows.
fn receive_verdict(ranks: &Ranks, rank: usize) -> Result<Option<ModelError>, EngineError> {
    let said: Vec<f64> = ranks.receive(3, rank)?;
    Ok(match said[0] {
        0.0 => None,
        1.0 => {
            let source = ElementError { determinant: said[2] };
            Some(ModelError::FoldedElement { element: said[1] as u32, source })
        }
        _ => {
            let bytes: Vec<u64> = ranks.receive_list(rank)?;
            let words: Vec<u8> = bytes.into_iter().map(|byte| byte as u8).collect();
            let reason = String::from_utf8_lossy(&words).into_owned();
            let short = (said[1] != 0.0).then_some(Resource::Memory);
            Some(EngineError { call: format!("rank {rank}"), reason, short }.into())
        }
    })
}

/// Makes a factor with the other ranks, or sets up conjugate gradients where there are rigid motions.
fn factorise_all(
    session: &mut Session,
    [id, of]: [u64; 2],
    order: &[u32],
    motions: Option<MatRef<'_, f64>>,
    springs: &dyn Fn(&[u32]) -> Springs,
    options: &Options,
) -> Result<Result<(), FactorError>, EngineError> {
    let ranks = &session.ranks;
    let places = |rank| &order[ranks.rows_of(rank, order.len())];
    let blocks = motions.is_some_and(|motions| in_blocks(motions, order));
    ranks.broadcast(Command::Factorise(id, of))?;
    for rank in ranks.others() {
        let springs = springs(places(rank));
        ranks.send(&[u64::from(springs.is_some())], rank)?;
        if let Some(springs) = springs {
            let (rows, springs): (Vec<u64>, Vec<f64>) =
                springs.into_iter().map(|(row, spring)| (row as u64, spring)).unzip();
            ranks.send_list(&rows, rank)?;
            ranks.send(&springs, rank)?;
        }
        if let Some(motions) = motions {
            ranks.send(&[u64::from(blocks)], rank)?;
            ranks.send(&take(motions, places(rank)), rank)?;
        }
    }
    let own = springs(places(0));
    let multigrid = motions.map(|motions| (blocks, take(motions, places(0))));
    make(session, id, of, (0, own), multigrid.as_ref(), options)
}

/// The springs that hold a body without supports, of those at some rows: each is as stiff as its dof is.
fn springs_at(places: &[u32], diagonal: &[f64], rigid: &RigidBody) -> Vec<(usize, f64)> {
    let own = |pin: usize| {
        let row = places.iter().position(|&place| place as usize == pin)?;
        Some((row, diagonal[pin]))
    };
    rigid.pins().into_iter().filter_map(own).collect()
}

/// True if the three dofs of each node stand together in an order: there the rigid motions begin with rows of
/// the unit matrix.
fn in_blocks(motions: MatRef<'_, f64>, order: &[u32]) -> bool {
    let is_unit = |(at, &row): (usize, &u32)| {
        (0..3).all(|c| motions[(row as usize, c)] == f64::from(u8::from(c == at % 3)))
    };
    order.len().is_multiple_of(3) && order.iter().enumerate().all(is_unit)
}

/// Number of a matrix or factor on all ranks, freed on drop.
struct RemoteHandle {
    shared: Shared,
    id: u64,
    /// The row of the matrix at each place.
    order: Arc<Vec<u32>>,
}

impl Drop for RemoteHandle {
    fn drop(&mut self) {
        let mut session = self.shared.locked();
        if !session.lost {
            let said = session.ranks.broadcast(Command::Release(self.id));
            let _ = session.noted(said);
            session.free(self.id);
        } else {
            // To free it takes all ranks.
            std::mem::forget(session.matrices.remove(&self.id));
            std::mem::forget(session.factors.remove(&self.id));
        }
    }
}

impl RemoteHandle {
    /// The rows of the matrix that a rank has.
    fn places(&self, ranks: &Ranks, rank: usize) -> &[u32] {
        &self.order[ranks.rows_of(rank, self.order.len())]
    }

    /// Has all ranks do something with their rows of some columns, each by `word`, and puts what comes back
    /// where the result belongs.
    fn through(
        &self,
        session: &mut Session,
        command: Command,
        x: MatRef<'_, f64>,
        mut y: MatMut<'_, f64>,
        own: impl FnOnce(&mut Session, Vec<f64>) -> Result<Vec<f64>, EngineError>,
    ) -> Result<(), EngineError> {
        let ranks = &session.ranks;
        ranks.broadcast(command)?;
        for rank in ranks.others() {
            ranks.send(&take(x, self.places(ranks, rank)), rank)?;
        }
        let mine = take(x, self.places(ranks, 0));
        let done = own(session, mine)?;
        let ranks = &session.ranks;
        put(y.rb_mut(), self.places(ranks, 0), &done);
        for rank in ranks.others() {
            let places = self.places(ranks, rank);
            let done: Vec<f64> = ranks.receive(places.len() * x.ncols(), rank)?;
            put(y.rb_mut(), places, &done);
        }
        Ok(())
    }
}

/// A matrix on all ranks, seen from the first.
struct DistributedMatrix {
    handle: RemoteHandle,
    diagonal: Vec<f64>,
}

impl fmt::Debug for DistributedMatrix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DistributedMatrix").field("id", &self.handle.id).finish_non_exhaustive()
    }
}

impl SpreadMatrix for DistributedMatrix {
    fn number(&self) -> u64 {
        self.handle.id
    }

    fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    fn mul_into(&self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) {
        let (id, mut session) = (self.handle.id, self.handle.shared.locked());
        for first in (0..x.ncols()).step_by(AT_ONCE) {
            let columns = AT_ONCE.min(x.ncols() - first);
            let own = |session: &mut Session, x: Vec<f64>| session.matrix(id)?.matrix.multiply(&x, columns);
            let (x, y) = (x.subcols(first, columns), y.rb_mut().subcols_mut(first, columns));
            let done = self.handle.through(&mut session, Command::Multiply(id, columns), x, y, own);
            if let Err(error) = done {
                end(&session.ranks, &error);
            }
        }
    }

    fn scaled(&self, weight: f64) -> Arc<dyn SpreadMatrix> {
        let RemoteHandle { shared, id: of, order } = &self.handle;
        let mut session = shared.locked();
        let id = session.number();
        match scale(&mut session, id, *of, weight) {
            Ok(local) => session.matrices.insert(id, local),
            Err(error) => end(&session.ranks, &error),
        };
        let handle = RemoteHandle { shared: shared.clone(), id, order: order.clone() };
        let diagonal = self.diagonal.iter().map(|entry| weight * entry).collect();
        Arc::new(DistributedMatrix { handle, diagonal })
    }
}

/// A factor on all ranks, seen from the first.
struct DistributedFactor {
    handle: RemoteHandle,
    rigid: Option<Arc<RigidBody>>,
}

impl fmt::Debug for DistributedFactor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("DistributedFactor").field("id", &self.handle.id).finish_non_exhaustive()
    }
}

impl DistributedFactor {
    /// Has all other ranks begin a search; what this one needs for it.
    fn begin_all(
        &self,
        session: &Session,
        mass: u64,
        search: &Search,
    ) -> Result<Option<Relief>, EngineError> {
        let (ranks, rigid) = (&session.ranks, self.rigid.as_deref());
        ranks.broadcast(Command::Search(self.handle.id, mass, *search, rigid.is_some()))?;
        let Some(rigid) = rigid else { return Ok(None) };
        for rank in ranks.others() {
            let places = self.handle.places(ranks, rank);
            ranks.send(&take(rigid.motions(), places), rank)?;
            ranks.send(&take(rigid.momenta(), places), rank)?;
        }
        let places = self.handle.places(ranks, 0);
        let own = |of: MatRef<'_, f64>| Mat::from_fn(places.len(), 6, |i, k| of[(places[i] as usize, k)]);
        Ok(Some(Relief { motions: own(rigid.motions()), momenta: own(rigid.momenta()) }))
    }
}

impl SpreadFactor for DistributedFactor {
    fn solve_in_place(&self, mut rhs: MatMut<'_, f64>) {
        let (id, mut session) = (self.handle.id, self.handle.shared.locked());
        for first in (0..rhs.ncols()).step_by(AT_ONCE) {
            let columns = AT_ONCE.min(rhs.ncols() - first);
            let own = |session: &mut Session, forces| session.factor(id)?.solver.solve(forces, columns);
            let forces = rhs.rb().subcols(first, columns).to_owned();
            let answers = rhs.rb_mut().subcols_mut(first, columns);
            let command = Command::Solve(id, columns);
            let done = self.handle.through(&mut session, command, forces.as_ref(), answers, own);
            if let Err(error) = done {
                end(&session.ranks, &error);
            }
        }
    }

    fn begin<'a>(
        &'a self,
        mass: Arc<dyn SpreadMatrix>,
        search: &Search,
    ) -> Result<Box<dyn PencilRows + 'a>, EngineError> {
        let RemoteHandle { shared, id, order } = &self.handle;
        let mut session = shared.locked();
        let begun = self.begin_all(&session, mass.number(), search);
        let relief = session.noted(begun)?;
        let (id, order, number) = (*id, order.clone(), mass.number());
        Ok(Box::new(SpreadRows { session, id, mass: number, relief, order, _kept: Some(mass) }))
    }
}
