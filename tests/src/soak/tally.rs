//! What was done and what was found, as lines and as a table.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

use super::invariant::Breach;

/// A breach, and all it takes to see it again.
#[derive(Clone, Debug)]
pub struct Finding {
    /// Seed of the soak.
    pub seed: u64,
    /// The iteration.
    pub iteration: u64,
    /// Its kind.
    pub kind: &'static str,
    /// What does not hold.
    pub breach: Breach,
    /// Every command of the iteration, the last one broke it.
    pub commands: Vec<String>,
    /// The files as they were left.
    pub folder: PathBuf,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seed, iteration, kind, breach, commands, folder } = self;
        writeln!(
            f,
            "FINDING seed {seed}, iteration {iteration}, {kind}: {}: {}",
            breach.invariant, breach.found
        )?;
        writeln!(f, "  last command: {}", commands.last().map_or("none", String::as_str))?;
        write!(f, "  files and all commands: {}", folder.display())
    }
}

/// Counts of one kind.
#[derive(Clone, Debug, Default)]
struct Row {
    iterations: usize,
    commands: usize,
    seconds: f64,
    findings: usize,
    /// How the iterations that held ended.
    words: BTreeMap<&'static str, usize>,
}

/// Counts of a soak.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    rows: Vec<(&'static str, Row)>,
    /// Every finding.
    pub findings: Vec<Finding>,
    /// How long it ran.
    pub seconds: f64,
}

impl Tally {
    /// Of nothing yet.
    pub(super) fn new(kinds: impl Iterator<Item = &'static str>) -> Self {
        Self { rows: kinds.map(|kind| (kind, Row::default())).collect(), ..Self::default() }
    }

    pub(super) fn add(&mut self, kind: usize, time: Duration, commands: usize, word: Option<&'static str>) {
        let row = &mut self.rows[kind].1;
        row.iterations += 1;
        row.commands += commands;
        row.seconds += time.as_secs_f64();
        if let Some(word) = word {
            *row.words.entry(word).or_default() += 1;
        }
    }

    pub(super) fn find(&mut self, kind: usize, finding: Finding) {
        self.rows[kind].1.findings += 1;
        self.findings.push(finding);
    }

    /// Iterations of all kinds.
    #[must_use]
    pub fn iterations(&self) -> usize {
        self.rows.iter().map(|(_, row)| row.iterations).sum()
    }

    /// Runs of the program in all kinds.
    #[must_use]
    pub fn commands(&self) -> usize {
        self.rows.iter().map(|(_, row)| row.commands).sum()
    }

    /// Iterations of all kinds that ended with this word.
    #[must_use]
    pub fn ended(&self, word: &str) -> usize {
        self.rows.iter().filter_map(|(_, row)| row.words.get(word)).sum()
    }

    /// One line on where the soak is.
    #[must_use]
    pub fn line(&self, since: Duration) -> String {
        let counts = self.rows.iter().map(|(kind, row)| format!("{kind} {}", row.iterations));
        format!(
            "{} min: {} iterations, {} findings ({})",
            since.as_secs() / 60,
            self.iterations(),
            self.findings.len(),
            counts.collect::<Vec<_>>().join(", ")
        )
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| kind | iterations | runs of the program | s | how they ended | findings |")?;
        writeln!(f, "|---|---|---|---|---|---|")?;
        for (kind, row) in &self.rows {
            let words: Vec<String> =
                row.words.iter().map(|(word, count)| format!("{count} {word}")).collect();
            let Row { iterations, commands, seconds, findings, .. } = row;
            writeln!(
                f,
                "| {kind} | {iterations} | {commands} | {seconds:.0} | {} | {findings} |",
                words.join(", ")
            )?;
        }
        let (iterations, commands, findings) = (self.iterations(), self.commands(), self.findings.len());
        writeln!(f, "| **all** | {iterations} | {commands} | {:.0} | | {findings} |", self.seconds)?;
        let mut kinds: BTreeMap<(&str, &str), (usize, u64)> = BTreeMap::new();
        for finding in &self.findings {
            let entry =
                kinds.entry((finding.kind, finding.breach.invariant)).or_insert((0, finding.iteration));
            entry.0 += 1;
        }
        if !kinds.is_empty() {
            writeln!(f, "\n| findings in | invariant | how many | first iteration |\n|---|---|---|---|")?;
        }
        for ((kind, invariant), (count, first)) in kinds {
            writeln!(f, "| {kind} | {invariant} | {count} | {first} |")?;
        }
        Ok(())
    }
}
