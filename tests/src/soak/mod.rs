//! The soak: random problems, scenarios, rewrites, kills and damage through the real program for as long as
//! it is let, against invariants that hold whatever chance chooses.
//!
//! An iteration draws its kind and all its choices from the seed and its own number, in a folder of its own,
//! so it can be repeated alone (`--from N --iterations 1`); only the instant at which a signal arrives is the
//! machine's. The rules themselves are in [`invariant`] and know only results. The record is
//! `docs/measurements/soak.md`.

pub mod dice;
pub mod harm;
pub mod invariant;
pub mod launch;
pub mod life;
pub mod motion;
pub mod place;
mod tally;
pub mod texts;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use dice::Dice;
use invariant::Breach;
use life::Done;
use place::Place;
pub use tally::{Finding, Tally};

/// What one iteration does.
type Kind = fn(&Place<'_>, &mut Dice) -> Done;

/// Every kind: its name, how often it is drawn, what it does.
pub const KINDS: [(&str, usize, Kind); 12] = [
    ("build and run", 6, life::built),
    ("rewrites", 4, life::rewritten),
    ("own matrices", 1, life::own_matrices),
    ("long runs", 1, life::long_run),
    ("kills", 4, harm::killed),
    ("damage", 4, harm::damaged),
    ("full disks", 2, harm::full_disk),
    ("little memory", 2, harm::little_memory),
    ("mutated texts", 6, harm::mutated),
    ("odd inputs", 1, harm::odd_inputs),
    ("laws of motion", 5, motion::laws),
    // Two files in three have no live parameter.
    ("walks of parameters", 6, motion::walk),
];

/// How long, of what, where.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The program.
    pub program: PathBuf,
    /// Where findings are kept.
    pub folder: PathBuf,
    /// What all choices come from.
    pub seed: u64,
    /// The first iteration.
    pub from: u64,
    /// At most so many iterations.
    pub iterations: u64,
    /// No iteration begins after this time.
    pub time: Duration,
    /// A run of the program that takes longer is a finding.
    pub limit: Duration,
    /// Only kinds whose name has this word.
    pub only: String,
}

/// Runs iterations until time or number is up; `line` hears a line a minute and every finding.
///
/// # Panics
/// If no kind has the word asked for, or the folder cannot be made.
#[must_use]
pub fn soak(settings: &Settings, line: &mut dyn FnMut(&str)) -> Tally {
    let kinds: Vec<(&str, usize, Kind)> =
        KINDS.into_iter().filter(|(name, ..)| name.contains(&settings.only)).collect();
    assert!(!kinds.is_empty(), "no kind has the word `{}`", settings.only);
    let weights: usize = kinds.iter().map(|(_, weight, _)| weight).sum();
    let mut tally = Tally::new(kinds.iter().map(|(name, ..)| *name));
    let (start, mut minute) = (Instant::now(), 1);
    for iteration in settings.from..settings.from.saturating_add(settings.iterations) {
        if start.elapsed() >= settings.time {
            break;
        }
        let mut dice = Dice::new(settings.seed, iteration);
        let mut drawn = dice.below(weights);
        let kind = kinds.iter().position(|(_, weight, _)| {
            let here = drawn < *weight;
            drawn = drawn.saturating_sub(*weight);
            here
        });
        let kind = kind.expect("weights add up");
        if let Some(finding) = iterate(settings, iteration, kinds[kind], &mut dice, &mut tally, kind) {
            line(&finding.to_string());
            tally.find(kind, finding);
        }
        if start.elapsed() >= Duration::from_secs(60 * minute) {
            line(&tally.line(start.elapsed()));
            minute = start.elapsed().as_secs() / 60 + 1;
        }
    }
    tally.seconds = start.elapsed().as_secs_f64();
    tally
}

fn iterate(
    settings: &Settings,
    iteration: u64,
    (name, _, kind): (&'static str, usize, Kind),
    dice: &mut Dice,
    tally: &mut Tally,
    index: usize,
) -> Option<Finding> {
    let folder = settings.folder.join(format!("{}-{iteration}", settings.seed));
    // Left by a soak of the same seed.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for findings");
    let place = Place::new(&settings.program, &folder, settings.limit);
    let start = Instant::now();
    let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| kind(&place, dice)))
        .unwrap_or_else(|panic| Err(panicked(&*panic)));
    let commands = place.commands();
    tally.add(index, start.elapsed(), commands.len(), done.as_ref().ok().copied());
    match done {
        Ok(_) => {
            let _ = std::fs::remove_dir_all(&folder);
            None
        }
        Err(breach) => {
            let _ = std::fs::write(folder.join("commands.txt"), commands.join("\n") + "\n");
            Some(Finding { seed: settings.seed, iteration, kind: name, breach, commands, folder })
        }
    }
}

/// A panic in this process: of the evaluator, or of the soak itself.
fn panicked(panic: &(dyn std::any::Any + Send)) -> Breach {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    Breach { invariant: "no panic", found: text.unwrap_or("a panic without words").into() }
}
