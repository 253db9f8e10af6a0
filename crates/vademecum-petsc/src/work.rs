//! Operations of every rank on its rows, at a command of the first one.

use std::ffi::CString;
use std::path::Path;
use std::sync::Arc;

use vademecum_build::fem::{AssemblyPart, EngineError, FactorError, ModelError, Pencil, Resource};
use vademecum_build::limits::{Memory, memory_in_words};

use crate::calls::{Factor, Iteration, Matrix};
use crate::deal::{Share, own_rows};
use crate::job::{Options, TOLERANCE};
use crate::ranks::Ranks;
use crate::rows::{LocalMatrix, Scratch, Solver};

/// Memory of conjugate gradients with multigrid as a multiple of that of the matrix: the whole processes of a
/// prototype held 2.7 times their matrix at 282 576 dofs and 5.4 times at 1 044 900.
const MULTIGRID: f64 = 5.5;

/// This rank's share of the memory of its machine that is free, or that the user allows \[bytes\].
fn free(ranks: &Ranks, options: &Options) -> f64 {
    Memory::asked_or_available(options.memory).limit() as f64 / ranks.calls.near as f64
}

/// Memory is short.
fn short_of_memory(call: &str, reason: String) -> EngineError {
    EngineError { call: call.into(), reason, short: Some(Resource::Memory) }
}

/// Assembles the rows of a part, if the memory is there.
pub fn assemble(ranks: &Ranks, part: &AssemblyPart, options: &Options) -> Result<Pencil, ModelError> {
    let (needed, free) = (part.bytes(), free(ranks, options));
    // All ranks look before one of them takes any.
    let mut without = [f64::from(u8::from(needed > free))];
    ranks.calls.sum(&mut without)?;
    if without[0] > 0.0 {
        let [needed, free] = [needed, free].map(|bytes| memory_in_words(bytes as u64));
        let reason = format!(
            "{:.0} of {} ranks have less memory than their rows take while they are assembled (rank {}: {needed}, and \
             {free} can be had): more machines",
            without[0], ranks.calls.size, ranks.calls.rank
        );
        return Err(short_of_memory("the assembly", reason).into());
    }
    part.assemble()
}

/// Mass and stiffness of all ranks, once each has assembled its part: this one's rows, and their diagonals.
pub fn distribute(
    total: usize,
    part: &AssemblyPart,
    pencil: Pencil,
    places: Vec<i64>,
) -> Result<[(LocalMatrix, Vec<f64>); 2], EngineError> {
    let of_columns = part.free_places();
    let rows = own_rows(part, &of_columns);
    let places = Arc::new(places);
    let one = |matrix| {
        let share = Share::of(matrix, &rows, |column| of_columns[column as usize]);
        let diagonal = rows.iter().map(|&row| matrix.diagonal(row as usize)).collect();
        Ok((LocalMatrix::new(total, &share, &places)?, diagonal))
    };
    Ok([one(pencil.mass())?, one(pencil.stiffness())?])
}

/// Room in addition to what MUMPS needs without pivoting that is tried, one after the other \[%\]; its
/// estimates count the first.
const ROOM: [i64; 3] = [30, 100, 400];

/// A solver and the folder of its factor on disk; or the error, on which all ranks agree.
pub type SolverResult = Result<(Solver, Option<Scratch>), FactorError>;

/// A factor of the rows of all ranks.
pub fn factorise(
    ranks: &Ranks,
    matrix: Matrix,
    total: usize,
    options: &Options,
) -> Result<SolverResult, EngineError> {
    let scratch =
        options.out_of_core.as_deref().map(|folder| scratch(folder, ranks.calls.rank)).transpose()?;
    let folder = scratch.as_ref().map(|(_, name)| name);
    let mut factor = Factor::analyse(matrix, folder, ROOM[0])?;
    if factor.info_of_all(1)? < 0 {
        return Ok(Err(mumps_error("the analysis of MUMPS", &factor)?.into()));
    }
    // Numbers 15 and 16 are for a factor in memory, 17 and 26 for one on disk; in MB.
    let (own, most) = if folder.is_some() { (17, 26) } else { (15, 16) };
    let [own, most] = [factor.info(own)? as f64, factor.info_of_all(most)? as f64];
    let free = free(ranks, options);
    for room in ROOM {
        let with_room = (100 + room) as f64 / (100 + ROOM[0]) as f64;
        let mut without = [f64::from(u8::from(own * with_room * 1e6 > free))];
        ranks.calls.sum(&mut without)?;
        if without[0] > 0.0 {
            let reason = format!(
                "MUMPS asks for {:.0} MB on the rank that takes most, and {:.0} of {} ranks have less (the first has \
                 {:.0} MB): more machines, or `--out-of-core DIR`",
                most * with_room,
                without[0],
                ranks.calls.size,
                free / 1e6,
            );
            return Ok(Err(short_of_memory("the factorisation of MUMPS", reason).into()));
        }
        factor.fill(room)?;
        // Too little room for what pivoting needs.
        if ![-8, -9].contains(&factor.info_of_all(1)?) {
            break;
        }
    }
    let negative = factor.info_of_all(12)?;
    match factor.info_of_all(1)? {
        -10 => Ok(Err(FactorError::NotPositiveDefinite { pivot: total, n: total })),
        -13 => Ok(Err(FactorError::OutOfMemory)),
        code if code < 0 => Ok(Err(mumps_error("the factorisation of MUMPS", &factor)?.into())),
        _ if negative > 0 => Ok(Err(FactorError::NotPositiveDefinite {
            pivot: total.saturating_sub(negative as usize),
            n: total,
        })),
        _ => Ok(Ok((Solver::Direct(factor), scratch.map(|(folder, _)| folder)))),
    }
}

/// Conjugate gradients on the rows of all ranks.
pub fn iterate(
    ranks: &Ranks,
    matrix: Matrix,
    (blocks, motions): &(bool, Vec<f64>),
    options: &Options,
) -> Result<SolverResult, EngineError> {
    // A value and an index of 32 bits for each entry.
    let needed = MULTIGRID * 12.0 * matrix.entries() as f64;
    let free = free(ranks, options);
    let mut without = [f64::from(u8::from(needed > free))];
    ranks.calls.sum(&mut without)?;
    if without[0] > 0.0 {
        let reason = format!(
            "multigrid takes about {:.0} MB on the first rank, and {:.0} of {} ranks have less: more machines",
            needed / 1e6,
            without[0],
            ranks.calls.size,
        );
        return Ok(Err(short_of_memory("GAMG", reason).into()));
    }
    Ok(Ok((Solver::Iterative(Iteration::new(matrix, motions, *blocks, TOLERANCE)?), None)))
}

/// Error of MUMPS in words.
fn mumps_error(call: &str, factor: &Factor) -> Result<EngineError, EngineError> {
    let [code, detail] = [factor.info_of_all(1)?, factor.info_of_all(2)?];
    let (words, short) = match code {
        -90 => {
            let words =
                "the disk refused a factor out of core: is there room in the folder of `--out-of-core`? ";
            (words, Some(Resource::Disk))
        }
        -9 | -8 => ("more room than five times the estimate is needed: ", Some(Resource::Memory)),
        -7 | -13 | -19 => ("", Some(Resource::Memory)),
        _ => ("", None),
    };
    let reason =
        format!("{words}INFOG(1) = {code}, INFOG(2) = {detail} (MUMPS users' guide, error diagnostics)");
    Ok(EngineError { call: call.into(), reason, short })
}

/// A new folder of this rank for a factor out of core, and its name for MUMPS.
fn scratch(folder: &Path, rank: usize) -> Result<(Scratch, CString), EngineError> {
    let own = folder.join(format!("vademecum-{}-{rank}", std::process::id()));
    let call = || format!("the folder {}", own.display());
    let refused = |reason: String| EngineError { call: call(), reason, short: Some(Resource::Disk) };
    std::fs::create_dir_all(&own).map_err(|error| refused(error.to_string()))?;
    let scratch = Scratch(own.clone());
    let name = own.to_str().and_then(|name| CString::new(name).ok());
    Ok((scratch, name.ok_or_else(|| refused("its name is no plain text".into()))?))
}
