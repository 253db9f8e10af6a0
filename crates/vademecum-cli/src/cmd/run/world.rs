//! `vademecum run` of a world: parts of an assembly file that move, touch and turn.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use vademecum_assembly::{
    AssemblyError, AssemblyFile, WorldPlan, WorldRow, WorldRunError, WorldRunOptions, WorldRunReport,
    WorldSink, run_world,
};
use vademecum_build::field::{Cells, PVD_HEAD, PVD_TAIL, pvd_line, vtu_into};
use vademecum_build::progress::Listener;
use vademecum_build::store::{GrowingFile, Kind, OutputError, Outputs};

use crate::console::Console;
use crate::failure::Failure;
use crate::files::check_output;
use crate::print::print_json;

/// Name of the collection of surfaces.
const COLLECTION: &str = "world.pvd";

/// Name of a file of surfaces.
fn surface_name(number: usize) -> String {
    format!("world-{number:06}.vtu")
}

/// A run of a world.
pub(super) struct WorldCommand<'a> {
    pub file: &'a AssemblyFile,
    pub path: &'a Path,
    pub outputs: &'a Outputs,
    pub table: &'a Path,
    pub surfaces: Option<&'a Path>,
    pub every: usize,
    pub json: bool,
}

/// JSON output.
#[derive(serde::Serialize)]
struct WorldOutput<'a> {
    #[serde(flatten)]
    report: &'a WorldRunReport,
    /// Names of the columns of the table, as in its first line.
    columns: &'a [String],
    rows: usize,
    table_file: String,
    /// None without `--vtu`.
    #[serde(skip_serializing_if = "Option::is_none")]
    surfaces_file: Option<String>,
}

impl WorldCommand<'_> {
    pub(super) fn run(&self, console: &Console) -> Result<(), Failure> {
        check_output(self.outputs, self.table, Kind::Csv)?;
        if let Some(folder) = self.surfaces {
            let first = surface_name(0);
            self.outputs.check_in(folder, &[(COLLECTION, Kind::Pvd), (&first, Kind::Vtu)])?;
        }
        let options = WorldRunOptions { every: self.every, surfaces: self.surfaces.is_some() };
        let mut table = WorldTable {
            outputs: self.outputs,
            path: self.table,
            folder: self.surfaces,
            plan: None,
            rows: None,
            collection: None,
            line: String::new(),
        };
        let marched = run_world(self.file, &options, console, &mut table);
        console.clear();
        // Whatever ended the run, what was computed is kept.
        let written = table.finish();
        let report = match marched {
            Ok(report) => report,
            Err(ended) => return Err(ended.failure(self.path).kept(table.kept())),
        };
        written?;
        self.warn(&report, console);
        let columns = table.plan.as_ref().map(|plan| plan.columns.as_slice()).unwrap_or_default();
        let output = WorldOutput {
            report: &report,
            columns,
            rows: table.rows.as_ref().map_or(0, GrowingFile::lines),
            table_file: self.table.display().to_string(),
            surfaces_file: self.surfaces.map(|folder| folder.join(COLLECTION).display().to_string()),
        };
        if self.json {
            print_json(&output);
        } else {
            output.print(&table.kept());
        }
        Ok(())
    }

    fn warn(&self, report: &WorldRunReport, console: &Console) {
        if report.steps_without_room > 0 {
            console.note(&format!(
                "in {} of {} steps there was no room for all contacts, and the deepest were kept: more `contacts` \
                 under `[world]`",
                report.steps_without_room, report.steps
            ));
        }
        if report.steps_not_converged > 0 {
            console.note(&format!(
                "{} of {} steps did not converge: more `sweeps` or a larger `tolerance` under `[world]`",
                report.steps_not_converged, report.steps
            ));
        }
    }
}

impl WorldOutput<'_> {
    fn print(&self, kept: &str) {
        let report = self.report;
        println!("{} steps of {} s; {kept}", report.steps, report.time_step);
        println!(
            "contacts at most {}; sweeps in the mean {:.1}; {} steps did not converge",
            report.contacts_at_most, report.mean_sweeps, report.steps_not_converged
        );
        if report.joints_broken > 0 {
            println!("joints that broke {}", report.joints_broken);
        }
        println!("deepest overlap {:.3e} m", report.deepest_overlap);
        println!(
            "energy given away {:.6e} J; rises of the energy {:.3e} J, {:.3e} J at most in a step",
            report.energy_given_away, report.energy_rises, report.largest_energy_rise
        );
    }
}

/// Why a march ended early.
enum Ended {
    World(WorldRunError),
    Written(Failure),
}

impl Ended {
    fn failure(self, path: &Path) -> Failure {
        match self {
            Self::Written(failure) => failure,
            // It names file and line.
            Self::World(error @ WorldRunError::Assembly(AssemblyError::File(_))) => error.into(),
            Self::World(error) => Failure::from(error).within(path),
        }
    }
}

impl From<WorldRunError> for Ended {
    fn from(error: WorldRunError) -> Self {
        Self::World(error)
    }
}

impl From<Failure> for Ended {
    fn from(failure: Failure) -> Self {
        Self::Written(failure)
    }
}

impl From<OutputError> for Ended {
    fn from(error: OutputError) -> Self {
        Self::Written(error.into())
    }
}

/// The table of a world, and its surfaces.
struct WorldTable<'a> {
    outputs: &'a Outputs,
    path: &'a Path,
    folder: Option<&'a Path>,
    plan: Option<WorldPlan>,
    rows: Option<GrowingFile>,
    /// Path, file and number of surfaces.
    collection: Option<(PathBuf, GrowingFile, usize)>,
    line: String,
}

impl WorldTable<'_> {
    fn finish(&mut self) -> Result<(), Failure> {
        if let Some(rows) = &mut self.rows {
            rows.finish().map_err(|error| Failure::io(self.path, error))?;
        }
        if let Some((path, collection, _)) = &mut self.collection {
            collection.finish().map_err(|error| Failure::io(path, error))?;
        }
        Ok(())
    }

    /// The rows and surfaces written so far; empty before the first.
    fn kept(&self) -> String {
        let rows = self.rows.as_ref().map(|rows| format!("{} rows in {}", rows.lines(), self.path.display()));
        let surfaces = self
            .collection
            .as_ref()
            .map(|(path, collection, _)| format!("{} surfaces in {}", collection.lines(), path.display()));
        [rows, surfaces].into_iter().flatten().collect::<Vec<_>>().join("; ")
    }

    fn add_surfaces(&mut self, row: &WorldRow<'_>) -> Result<(), Failure> {
        let (Some(folder), Some(plan), Some((path, collection, count))) =
            (self.folder, &self.plan, &mut self.collection)
        else {
            return Ok(());
        };
        let name = surface_name(*count);
        let data = [("part", plan.part_of_node.as_slice(), 1)];
        self.outputs.write(&folder.join(&name), Kind::Vtu, |out| {
            vtu_into(out, row.nodes, Cells::Triangles(&plan.triangles), &data)
        })?;
        *count += 1;
        let listed = collection.add(&pvd_line(row.time, &name)).and_then(|()| collection.flush());
        listed.map_err(|error| Failure::io(path, error))
    }
}

impl WorldSink for WorldTable<'_> {
    type Error = Ended;

    fn begin(&mut self, plan: &WorldPlan) -> Result<(), Ended> {
        let head = plan.columns.join(",") + "\n";
        self.rows = Some(self.outputs.grow(self.path, Kind::Csv, &head, "")?);
        if let Some(folder) = self.folder {
            self.outputs.make_folder(folder)?;
            let path = folder.join(COLLECTION);
            let collection = self.outputs.grow(&path, Kind::Pvd, PVD_HEAD, PVD_TAIL)?;
            self.collection = Some((path, collection, 0));
        }
        self.plan = Some(plan.clone());
        Ok(())
    }

    fn show(&mut self, row: &WorldRow<'_>) -> Result<(), Ended> {
        self.line.clear();
        for (i, value) in row.values.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            let written = if i == 0 {
                write!(self.line, "{value:.9e}")
            } else if value.fract() == 0.0 && value.abs() < 1e9 {
                // Such as counts.
                write!(self.line, "{comma}{value}")
            } else {
                write!(self.line, "{comma}{value:e}")
            };
            written.expect("writing to a string cannot fail");
        }
        self.line.push('\n');
        if let Some(rows) = &mut self.rows {
            rows.add(&self.line).map_err(|error| Failure::io(self.path, error))?;
        }
        Ok(self.add_surfaces(row)?)
    }
}
