//! The ranks that serve the first one.

use std::sync::Arc;
use std::time::Duration;

use faer::Mat;
use vademecum_build::dynamics::{ModesError, search_on};
use vademecum_build::fem::{EngineError, ModelError, Resource};

use crate::deal::{Share, receive_part};
use crate::job::{Options, end};
use crate::ranks::{Command, Ranks};
use crate::rows::{LocalMatrix, LocalSolver, Relief, Session, SpreadRows};
use crate::work::{assemble, distribute, factorise, iterate};

/// Time that a failed rank waits for the first one to report the same error.
const GRACE: Duration = Duration::from_secs(2);

/// Executes the next command of the first rank; false after the last one. A failure ends the job.
pub fn serve_next(session: &mut Session, options: &Options) -> bool {
    match serve(session, options) {
        Ok(more) => more,
        Err(error) => {
            // Where all ranks failed alike, the first one tells it by itself.
            std::thread::sleep(GRACE);
            end(&session.ranks, &error)
        }
    }
}

/// Waits for a command and executes it.
fn serve(session: &mut Session, options: &Options) -> Result<bool, EngineError> {
    match session.ranks.receive_command()? {
        Command::Deal(id) => {
            let (total, places) = receive_places(&session.ranks)?;
            let share = Share::receive(&session.ranks, 0)?;
            session.matrices.insert(id, LocalMatrix::new(total, &share, &Arc::new(places))?);
        }
        Command::Assemble(mass, stiffness) => {
            let ranks = &session.ranks;
            let (total, places) = receive_places(ranks)?;
            let part = receive_part(ranks, 0)?;
            let assembled = assemble(ranks, &part, options);
            send_verdict(ranks, assembled.as_ref().err())?;
            let goes = ranks.receive::<u64>(1, 0)?[0] != 0;
            // The first rank tells why it does not.
            if let (true, Ok(pencil)) = (goes, assembled) {
                let laid = distribute(total, &part, pencil, places)?;
                for (id, (local, diagonal)) in [mass, stiffness].into_iter().zip(laid) {
                    session.ranks.send(&diagonal, 0)?;
                    session.matrices.insert(id, local);
                }
            }
        }
        Command::Scale(id, of, weight) => {
            let scaled = session.matrix(of)?.scaled(weight)?;
            session.matrices.insert(id, scaled);
        }
        Command::Factorise(id, of) => factorise_part(session, id, of, options)?,
        Command::Multiply(id, columns) => {
            let own = session.matrix(id)?.places.len();
            let x: Vec<f64> = session.ranks.receive(columns * own, 0)?;
            let product = session.matrix(id)?.matrix.multiply(&x, columns)?;
            session.ranks.send(&product, 0)?;
        }
        Command::Solve(id, columns) => {
            let own = session.factor(id)?.places.len();
            let forces = session.ranks.receive(columns * own, 0)?;
            let answers = session.factor(id)?.solver.solve(forces, columns)?;
            session.ranks.send(&answers, 0)?;
        }
        Command::Search(id, mass, search, free) => {
            let own = session.factor(id)?.places.len();
            let relief = free.then(|| receive_relief(&session.ranks, own)).transpose()?;
            let mut rows = SpreadRows { session, id, mass, relief, order: Arc::default(), _kept: None };
            // Whatever else ends a search, ends it on all ranks.
            if let Err(ModesError::Engine(error)) = search_on(&mut rows, &search, None) {
                return Err(error);
            }
        }
        Command::Release(id) => session.free(id),
        Command::Stop => return Ok(false),
    }
    Ok(true)
}

fn factorise_part(session: &mut Session, id: u64, of: u64, options: &Options) -> Result<(), EngineError> {
    let local = session.matrix(of)?;
    let (own, total) = (local.places.len(), local.total);
    let ranks = &session.ranks;
    let springs = receive_springs(ranks)?;
    let multigrid = match options.iterative {
        true => Some((ranks.receive::<u64>(1, 0)?[0] != 0, ranks.receive::<f64>(6 * own, 0)?)),
        false => None,
    };
    let first = ranks.rows_of(ranks.calls.rank, total).start;
    make(session, id, of, (first, springs), multigrid.as_ref(), options).map(drop)
}

/// Springs of this rank, by own row; absent where no rank has one.
pub type Springs = Option<Vec<(usize, f64)>>;

/// Makes a factor with all ranks, or sets up an iteration; the error that all agree on is the first rank's to
/// tell. `first` is the place of the first own row.
pub fn make(
    session: &mut Session,
    id: u64,
    of: u64,
    (first, springs): (usize, Springs),
    multigrid: Option<&(bool, Vec<f64>)>,
    options: &Options,
) -> Result<Result<(), vademecum_build::fem::FactorError>, EngineError> {
    let LocalMatrix { matrix, places, total } = session.matrix(of)?;
    let (places, total) = (places.clone(), *total);
    let on_rows = |springs: &Vec<(usize, f64)>| -> Vec<(i64, f64)> {
        springs.iter().map(|&(row, spring)| ((first + row) as i64, spring)).collect()
    };
    let matrix = matrix.with_springs(springs.as_ref().map(on_rows).as_deref())?;
    let made = match multigrid {
        Some(multigrid) => iterate(&session.ranks, matrix, multigrid, options)?,
        None => factorise(&session.ranks, matrix, total, options)?,
    };
    Ok(made.map(|(solver, _scratch)| {
        let springs = springs.unwrap_or_default();
        session.factors.insert(id, LocalSolver { solver, springs, places, total, _scratch });
    }))
}

/// Outcome of the assembly on this rank: success, or failure with element and volume form, or
/// shortage of memory with its message.
fn send_verdict(ranks: &Ranks, error: Option<&ModelError>) -> Result<(), EngineError> {
    match error {
        None => ranks.send(&[0.0; 3], 0),
        Some(ModelError::FoldedElement { element, source }) => {
            ranks.send(&[1.0, f64::from(*element), source.determinant], 0)
        }
        Some(other) => {
            let short =
                matches!(other, ModelError::Engine(EngineError { short: Some(Resource::Memory), .. }));
            ranks.send(&[2.0, f64::from(u8::from(short)), 0.0], 0)?;
            ranks.send_list(&other.to_string().bytes().map(u64::from).collect::<Vec<_>>(), 0)
        }
    }
}

/// Rows of all ranks, and the row of the whole matrix that each own row is.
fn receive_places(ranks: &Ranks) -> Result<(usize, Vec<i64>), EngineError> {
    Ok((ranks.receive::<u64>(1, 0)?[0] as usize, ranks.receive_list(0)?))
}

fn receive_springs(ranks: &Ranks) -> Result<Springs, EngineError> {
    if ranks.receive::<u64>(1, 0)?[0] == 0 {
        return Ok(None);
    }
    let rows: Vec<u64> = ranks.receive_list(0)?;
    let springs: Vec<f64> = ranks.receive(rows.len(), 0)?;
    Ok(Some(rows.into_iter().map(|row| row as usize).zip(springs).collect()))
}

fn receive_relief(ranks: &Ranks, own: usize) -> Result<Relief, EngineError> {
    let six = || -> Result<Mat<f64>, EngineError> {
        let numbers: Vec<f64> = ranks.receive(6 * own, 0)?;
        Ok(Mat::from_fn(own, 6, |i, k| numbers[i + own * k]))
    };
    Ok(Relief { motions: six()?, momenta: six()? })
}
