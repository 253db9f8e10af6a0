//! The invariants as functions of results: what a run gave goes in, the breach comes out.
//!
//! They know nothing of how the results came about, so a test can hand each of them a broken one and see it
//! fail (`tests/tests/program/soak.rs`).

use std::path::Path;

use super::launch::Ended;

/// An invariant that does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breach {
    /// The invariant, in a word.
    pub invariant: &'static str,
    /// What was found.
    pub found: String,
}

/// Whether an invariant holds.
pub type Held = Result<(), Breach>;

/// A breach.
///
/// # Errors
/// Always.
pub fn breach<T>(invariant: &'static str, found: impl Into<String>) -> Result<T, Breach> {
    Err(Breach { invariant, found: found.into() })
}

/// The exit codes of `vademecum --help`; 130 only where a run was interrupted.
pub const CODES: [i32; 7] = [0, 1, 3, 4, 5, 6, 7];

/// A run ended by itself or by the signal it was sent, in time, with one of the codes of `allowed`, and said
/// nothing that only its programmer understands.
///
/// # Errors
/// [`Breach`].
pub fn ended_well(ended: &Ended, allowed: &[i32]) -> Held {
    plain_words(&ended.stderr)?;
    plain_words(&ended.stdout)?;
    if ended.over_time {
        return breach("ends in time", format!("it still ran after {:.1} s", ended.seconds));
    }
    match (ended.signal, ended.code) {
        (Some(signal), _) if ended.sent.map(|sent| sent.number()) == Some(signal) => Ok(()),
        (Some(signal), _) => breach("documented exit", format!("it died of signal {signal}")),
        (_, Some(code)) if allowed.contains(&code) => Ok(()),
        (_, Some(130)) if ended.sent.is_some() => Ok(()),
        (_, code) => breach("documented exit", format!("code {code:?}, where {allowed:?} may be")),
    }
}

/// An allocation larger than all the memory there was should have been refused; many that add up to more are
/// nobody's fault.
///
/// # Errors
/// [`Breach`].
pub fn ended_well_in(ended: &Ended, allowed: &[i32], limit_bytes: u64) -> Held {
    let words = "memory allocation of ";
    let asked = ended.stderr.split_once(words).and_then(|(_, rest)| rest.split(' ').next()?.parse().ok());
    match asked {
        Some(bytes) if bytes <= limit_bytes => Ok(()),
        Some::<u64>(bytes) => breach("memory", format!("{bytes} bytes asked for at once of {limit_bytes}")),
        None => ended_well(ended, allowed),
    }
}

/// No panic, no backtrace, no place in the sources, no value as Rust's `Debug` writes it.
///
/// # Errors
/// [`Breach`].
pub fn plain_words(text: &str) -> Held {
    const WORDS: [&str; 9] = [
        "panicked",
        "RUST_BACKTRACE",
        ".rs:",
        "Some(",
        "Err(",
        "unwrap()",
        "overflow at",
        "Error {",
        "stack backtrace",
    ];
    if let Some(word) = WORDS.iter().find(|word| text.contains(**word)) {
        return breach("plain words", format!("`{word}` in: {text}"));
    }
    // `Name { field: …`, where a name has both capitals and small letters.
    let pieces: Vec<&str> = text.split(" { ").collect();
    let debug = pieces.windows(2).find(|pair| {
        let name = pair[0].rsplit(|c: char| !c.is_alphanumeric()).next().unwrap_or("");
        let field = pair[1].split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or("");
        name.starts_with(|c: char| c.is_ascii_uppercase())
            && name.contains(|c: char| c.is_ascii_lowercase())
            && pair[1][field.len()..].starts_with(": ")
    });
    debug.map_or(Ok(()), |_| breach("plain words", format!("a value of Rust in: {text}")))
}

/// A refusal with this code that names the file.
///
/// # Errors
/// [`Breach`].
pub fn refused_by_name(ended: &Ended, codes: &[i32], name: &str) -> Held {
    ended_well(ended, codes)?;
    if ended.stderr.contains(name) {
        return Ok(());
    }
    breach("refused by name", format!("`{name}` is not named in: {}", ended.stderr))
}

/// What lies at an output path is what lay there before, or the new file whole.
///
/// # Errors
/// [`Breach`].
pub fn old_or_new(found: Option<&[u8]>, old: Option<&[u8]>, new: &[u8]) -> Held {
    if found == old || found == Some(new) {
        return Ok(());
    }
    let length = |bytes: Option<&[u8]>| bytes.map_or("nothing".into(), |b| format!("{} bytes", b.len()));
    let (found, old) = (length(found), length(old));
    breach("old or new", format!("{found}, neither the old {old} nor the new {} bytes", new.len()))
}

/// The same bytes twice.
///
/// # Errors
/// [`Breach`].
pub fn same_bytes(what: &'static str, one: &[u8], other: &[u8]) -> Held {
    if one == other {
        return Ok(());
    }
    let first = one.iter().zip(other).position(|(a, b)| a != b);
    breach(
        "same bytes",
        format!("{what}: {} and {} bytes, first difference at {first:?}", one.len(), other.len()),
    )
}

/// No temporary file of a killed program is left in a folder or below it.
///
/// # Errors
/// [`Breach`].
pub fn nothing_left(folder: &Path) -> Held {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            nothing_left(&path)?;
        } else if path.extension().is_some_and(|ending| ending == "part") {
            return breach("nothing left", format!("{} is there", path.display()));
        }
    }
    Ok(())
}

/// A table of numbers has whole rows, all as long as the first, and every number in it is finite.
///
/// # Errors
/// [`Breach`].
pub fn whole_table(text: &str, rows: Option<usize>) -> Held {
    let mut lines = text.lines();
    let columns = lines.next().unwrap_or("").split(',').count();
    if !text.ends_with('\n') {
        return breach("whole rows", "the last row has no end");
    }
    for (line, number) in text.lines().zip(1..).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers: Option<Vec<f64>> = cells.iter().map(|cell| cell.parse().ok()).collect();
        match numbers {
            Some(numbers) if numbers.len() == columns => {
                if numbers.iter().any(|number| !number.is_finite()) {
                    return breach("finite results", format!("row {number}: {line}"));
                }
            }
            _ => return breach("whole rows", format!("row {number} is `{line}`, of {columns} columns")),
        }
    }
    match rows {
        Some(rows) if lines.clone().count() != rows => {
            breach("whole rows", format!("{} rows, where {rows} belong", lines.count()))
        }
        _ => Ok(()),
    }
}

/// All numbers are finite.
///
/// # Errors
/// [`Breach`].
pub fn finite(what: &'static str, numbers: &[f64]) -> Held {
    match numbers.iter().position(|number| !number.is_finite()) {
        Some(at) => breach("finite results", format!("{what}: number {at} is {}", numbers[at])),
        None => Ok(()),
    }
}

/// The energy of a body on which nothing acts stays below `bound` times what it was at first.
///
/// # Errors
/// [`Breach`].
pub fn no_growth(energies: &[f64], bound: f64) -> Held {
    finite("energy", energies)?;
    let Some(&first) = energies.first() else { return Ok(()) };
    let largest = energies.iter().copied().fold(0.0, f64::max);
    if largest <= bound * first {
        return Ok(());
    }
    breach(
        "no growth",
        format!("{largest:e} J after {first:e} J, {} times; at most {bound}", largest / first),
    )
}

/// Two series agree to `tolerance` of `size`.
///
/// # Errors
/// [`Breach`].
pub fn agree(law: &'static str, one: &[f64], other: &[f64], size: f64, tolerance: f64) -> Held {
    finite(law, one)?;
    finite(law, other)?;
    let apart = one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    if one.len() == other.len() && apart <= tolerance * size {
        return Ok(());
    }
    breach(law, format!("{apart:e} apart, of {size:e}: {:e}, at most {tolerance:e}", apart / size))
}

/// Memory of a long run is that of a short one, but for the noise of the allocator.
///
/// # Errors
/// [`Breach`].
pub fn bounded_memory(short_kib: u64, long_kib: u64) -> Held {
    const NOISE_KIB: u64 = 8 << 10;
    if long_kib <= short_kib + NOISE_KIB {
        return Ok(());
    }
    breach("bounded memory", format!("{long_kib} KiB in a long run, {short_kib} KiB in a short one"))
}
