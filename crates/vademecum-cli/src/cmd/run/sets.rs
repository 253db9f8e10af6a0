//! `vademecum run --sets`: one scenario through many bodies of a file.

use std::fmt::Write as _;
use std::path::Path;

use vademecum_build::parallel;
use vademecum_build::progress::Listener;
use vademecum_build::store::{Kind, Outputs};
use vademecum_study::StudyError;
use vademecum_study::sets::{SetRun, Sets, Summary};

use super::list::{BODIES, RunList};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::print::print_json;

/// Bodies whose results are in memory at once.
const ROUND: usize = 64;

/// Most refused rows that a message names; JSON has all.
const NAMED: usize = 10;

/// A run of many bodies.
pub(super) struct SetsCommand<'a> {
    pub run: SetRun<'a>,
    pub sets: &'a Sets,
    pub outputs: &'a Outputs,
    pub folder: &'a Path,
    pub json: bool,
}

/// JSON output.
#[derive(serde::Serialize)]
struct SetsOutput {
    bodies: usize,
    rows: usize,
    bodies_file: String,
    /// Names of the columns of the table, as in its first line.
    columns: Vec<String>,
    /// Rows that were refused: where, and why.
    refused: Vec<String>,
}

impl SetsCommand<'_> {
    /// Steps all bodies, and writes a row for each as soon as those before it are there.
    pub(super) fn run(
        &self,
        console: &Console,
        about: &dyn Fn(StudyError) -> Failure,
    ) -> Result<(), Failure> {
        let columns = columns(self.sets, &self.run.columns(console).map_err(about)?);
        let path = self.folder.join(BODIES);
        self.outputs.make_folder(self.folder)?;
        let mut list = RunList::begin(self.outputs, self.folder, &[BODIES], 0)?;
        let mut table = self.outputs.grow(&path, Kind::Csv, &(columns.join(",") + "\n"), "")?;
        let (run, sets) = (self.run, self.sets);
        let (count, mut refused, mut ended) = (sets.len(), vec![], Ok(()));
        console.stage("step the bodies");
        for begin in (0..count).step_by(ROUND) {
            let round = ROUND.min(count - begin);
            let found = parallel::map(round, &|place| run.body(sets, begin + place, console));
            for (row, found) in (begin..).zip(found) {
                let written = match found {
                    Ok(summary) => table.add(&line(row, self.sets, &summary)),
                    Err(error) => match self.sets.fault(row, &error) {
                        Some(fault) => {
                            refused.push(fault);
                            Ok(())
                        }
                        None => {
                            ended = ended.and(Err(about(error)));
                            break;
                        }
                    },
                };
                ended = ended.and(written.map_err(|error| Failure::io(&path, error)));
            }
            let flushed = table.flush().map_err(|error| Failure::io(&path, error));
            let on = console.checkpoint(begin + round, count).map_err(|end| about(end.into()));
            ended = ended.and(flushed).and(on);
            if ended.is_err() {
                break;
            }
        }
        console.clear();
        let finished = table.finish().map_err(|error| Failure::io(&path, error));
        let kept = format!("{} bodies in {}", table.lines(), path.display());
        ended.and(finished).and(list.finish(0)).map_err(|failure| failure.kept(kept.clone()))?;
        let output = SetsOutput {
            bodies: count,
            rows: table.lines(),
            bodies_file: path.display().to_string(),
            columns,
            refused,
        };
        if self.json {
            print_json(&output);
        } else {
            println!("{kept}");
        }
        if output.refused.is_empty() {
            return Ok(());
        }
        let some = output.refused.iter().take(NAMED).cloned().collect::<Vec<_>>().join("; ");
        let error = format!("{} of {count} rows were refused, the others ran: {some}", output.refused.len());
        Err(Failure::new(Cause::Usage, error).kept(kept))
    }
}

/// Names of the columns: number of the body, parameters, and three of each column of a run.
fn columns(sets: &Sets, of_run: &[(String, &'static str)]) -> Vec<String> {
    let summaries = of_run.iter().flat_map(|(name, unit)| {
        ["min", "max", "last"].map(|part| match *unit {
            "" => format!("{name}.{part}"),
            unit => format!("{name}.{part} [{unit}]"),
        })
    });
    ["body".to_string()].into_iter().chain(sets.names().map(String::from)).chain(summaries).collect()
}

/// The row of a body, counted from 1.
fn line(row: usize, sets: &Sets, summaries: &[Summary]) -> String {
    let mut line = (row + 1).to_string();
    let mut push = |text: std::fmt::Arguments<'_>| line.write_fmt(text).expect("a string takes all");
    sets.values(row).iter().for_each(|value| push(format_args!(",{value}")));
    for Summary { least, largest, last } in summaries {
        push(format_args!(",{least:.9e},{largest:.9e},{last:.9e}"));
    }
    line + "\n"
}
