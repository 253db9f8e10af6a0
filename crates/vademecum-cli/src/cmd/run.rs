//! `vademecum run`: a scenario through a file, to tables and fields.

mod list;
mod sets;
mod world;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use vademecum_assembly::AssemblyFile;
use vademecum_build::field::{Cells, PVD_HEAD, PVD_TAIL, pvd_line, vtu_into};
use vademecum_build::limits::memory_in_words;
use vademecum_build::progress::Listener;
use vademecum_build::store::{GrowingFile, Kind, Outputs};
use vademecum_format::SectionKind;
use vademecum_study::contents::Geometry;
use vademecum_study::parameters::{self, ParameterValue};
use vademecum_study::run::{Fields, Moment, ProbeRow};
use vademecum_study::scenario::{FieldChoice, OutputPlan, Scenario, Total};
use vademecum_study::sets::{SetRun, Sets};
use vademecum_study::stress::{LargestStress, StressPlace};
use vademecum_study::{FileError, StudyError, run};

use crate::arguments::{Limit, OutputArguments, StructureArgument, positive, setting};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{at_values, chart_kind, is_stepped, to_step, usable_file, write_chart};
use crate::given::{Given, outputs_of};
use crate::pictures::{Drawn, Panel, Series, Thinned, panels_chart};
use crate::print::print_json;
use list::{FILES, RunList, field_name};
use sets::SetsCommand;
use world::WorldCommand;

/// Steps a vademecum through a scenario and writes probes (CSV) and fields (VTU, opens in ParaView).
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum run body.vdm --scenario push.toml -o out/
  vademecum run body.vdm --scenario push.toml --plot out/probes.svg
  vademecum run assembly.toml -o drop.csv --every 10    bodies that touch: an assembly with `[world]`
  vademecum run body.vdm --scenario push.toml --set \"tip stiffness=1.5\" --set damping=1e-4
  vademecum run body.vdm --scenario push.toml --sets sets.csv    a body for each row of the table
Rows and fields are written while they are computed: what was there before Ctrl-C or a full disk is kept.
Keys of the scenario file: `vademecum help scenario`")]
pub(crate) struct Run {
    /// The vademecum file, or an assembly file (TOML): it is joined in memory, or marched if it has
    /// `[world]`.
    file: PathBuf,
    /// The scenario file (TOML). A world has none.
    #[arg(long)]
    scenario: Option<PathBuf>,
    /// Folder for the results, made if missing [default: out]; of a world the table (CSV) [default:
    /// world.csv].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Steps from one row of the table of a world to the next [default: 1].
    #[arg(long, value_name = "STEPS", value_parser = clap::value_parser!(u32).range(1..))]
    every: Option<u32>,
    /// Folder for the surfaces of a world at the times of the rows (VTU, opens in ParaView).
    #[arg(long, value_name = "FOLDER")]
    vtu: Option<PathBuf>,
    /// Draw the columns of probes.csv over time here (SVG, or PDF by its name); the energy if there are no
    /// others.
    #[arg(long)]
    plot: Option<PathBuf>,
    /// Structure of the step.
    #[arg(long, value_enum, default_value_t = StructureArgument::Auto)]
    structure: StructureArgument,
    /// Time step in s; the file's if absent. The diagonal structure takes any; the block structure takes
    /// those of the range it was built for, if the time step is one of its live parameters, and no other.
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    time_step: Option<f64>,
    /// Set a live parameter of the file, by its name; may be given several times. `info` shows names, ranges
    /// and units.
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    set: Vec<ParameterValue>,
    /// Modes that are stepped of a file with live regions [default: all; 32 with `--sets`].
    #[arg(long, value_name = "N")]
    modes: Option<usize>,
    /// Run one body for each row of this table (CSV): the first line has names of live parameters, the others
    /// values. The results are `bodies.csv` in the folder: of every column of probes.csv the smallest, the
    /// largest and the last value of each body.
    #[arg(long, value_name = "FILE", conflicts_with = "plot")]
    sets: Option<PathBuf>,
    /// March more than a billion steps.
    #[arg(long)]
    long: bool,
    /// Only the first so many terms of the separated solution; `info --terms-for` tells how many a tolerance
    /// takes.
    #[arg(long)]
    terms: Option<usize>,
    /// Map the file into memory instead of copying it, for files too large to copy. Nobody may shorten or
    /// overwrite it meanwhile: the program would crash or give wrong numbers.
    #[arg(long)]
    map: bool,
    /// The default.
    #[arg(long, hide = true, conflicts_with = "map")]
    copy: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
    #[command(flatten)]
    limit: Limit,
}

/// Results of more bytes are announced.
const MUCH: u64 = 100_000_000;

impl Run {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let given = Given::look(&self.file)?;
        if let Given::Assembly(file) = &given
            && file.world.is_some()
        {
            return self.run_world(file, &given, console);
        }
        let of_world = [("--every", self.every.is_some()), ("--vtu", self.vtu.is_some())];
        refuse_options(&of_world, "an assembly file with `[world]`")?;
        let Some(scenario_file) = &self.scenario else {
            let error = "`--scenario FILE` is missing; only an assembly file with `[world]` runs without";
            return Err(Failure::new(Cause::Usage, error));
        };
        let folder = self.output.clone().unwrap_or_else(|| "out".into());
        let mut scenario = Scenario::read(scenario_file)?;
        if self.sets.is_some() && (scenario.output.fields_every > 0 || scenario.output.stress_every > 0) {
            console.note("with `--sets`, no fields and no table of stresses are written");
            (scenario.output.fields_every, scenario.output.stress_every) = (0, 0);
        }
        let inputs = [Some(&*self.file), Some(scenario_file), self.sets.as_deref()];
        let outputs = outputs_of(&self.outputs, &given, &inputs);
        RunList::check(&outputs, &folder)?;
        // The folder of the results is made with them.
        let made = |path: &&PathBuf| path.parent() != Some(&folder) || folder.is_dir();
        let plot = self.plot.iter().filter(made).map(|path| (path.clone(), chart_kind(path)));
        outputs.check(&plot.collect::<Vec<_>>())?;
        let mapped = given.open(&self.file, self.map, console)?;
        let mut memory = vec![];
        let shown = &scenario.output;
        let inside =
            !shown.probes.is_empty() || (shown.fields_every > 0 && shown.fields == FieldChoice::Body);
        let wanted = |kind| is_stepped(kind) && (inside || kind != SectionKind::InteriorBasis);
        let file = usable_file(&self.file, &mapped, wanted, self.limit, &mut memory)?;
        let about = |error: StudyError| Failure::of_study(error, &self.file, scenario_file);
        let mut options = self.structure.options();
        (options.scene.time_step, options.scene.terms) = (self.time_step, self.terms);
        options.long = self.long;
        if let Some(path) = &self.sets {
            let run =
                SetRun { file: &file, given: &self.set, modes: self.modes, options, scenario: &scenario };
            let sets = Sets::read(path, &file, &self.set).map_err(about)?;
            let command =
                SetsCommand { run, sets: &sets, outputs: &outputs, folder: &folder, json: self.json };
            return command.run(console, &about);
        }
        let set_body = at_values(&file, &self.set, self.modes).map_err(about)?;
        let (file, settings) = to_step(file, &self.set, set_body.as_ref()).map_err(about)?;
        if self.terms.is_some() && file.metadata().active_parameters().is_empty() {
            console
                .note("`--terms` has no effect: without live parameters the file has no terms to leave out");
        }
        parameters::set(&mut options.scene, file.metadata(), settings).map_err(about)?;
        let unread = |error: FileError| Failure::file(&self.file, error);
        let run = run::Run::bind(&file, options, &scenario, console).map_err(about)?;
        let geometry = run.geometry().map_err(unread)?;
        let bytes = run.least_bytes(geometry.as_ref());
        outputs.check_space(&folder, bytes)?;
        if bytes > MUCH {
            let about = memory_in_words(bytes);
            console.note(&format!("{} steps, whose results take at least {about}", run.steps));
        }
        // What can be refused is refused before the first instant: only then are results begun, and older
        // ones removed.
        let (mut geometry, mut results) = (Some(geometry), None);
        let played = run.play(console, |moment: &Moment<'_>| {
            if let Some(geometry) = geometry.take() {
                outputs.make_folder(&folder)?;
                let mut begun = Results::begin(&outputs, &folder, &run, geometry, shown)?;
                begun.curves = self.plot.is_some().then(|| Curves::of(&run));
                results = Some(begun);
            }
            results.as_mut().map_or(Ok(()), |results| results.show(moment))
        });
        console.clear();
        let Some(mut results) = results else {
            return played.map_err(|failure: Failure| failure.about(&self.file));
        };
        // Whatever ended the run, what was computed is kept.
        let written = results.finish();
        let failed = |failure: Failure| failure.about(&self.file).kept(results.kept());
        played.and(written).map_err(failed)?;
        if let (Some(path), Some(curves)) = (&self.plot, results.curves.take()) {
            write_chart(&outputs, path, curves.draw(&run))?;
        }
        results.print(&run, self.plot.as_deref(), self.json);
        Ok(())
    }
}

impl Run {
    /// Marches a world.
    fn run_world(&self, file: &AssemblyFile, given: &Given, console: &Console) -> Result<(), Failure> {
        let of_body = [
            ("--scenario", self.scenario.is_some()),
            ("--plot", self.plot.is_some()),
            ("--structure", self.structure != StructureArgument::Auto),
            ("--time-step", self.time_step.is_some()),
            ("--set", !self.set.is_empty()),
            ("--sets", self.sets.is_some()),
            ("--long", self.long),
            ("--terms", self.terms.is_some()),
            ("--map", self.map),
        ];
        refuse_options(&of_body, "one body; an assembly file with `[world]` has its own keys")?;
        let outputs = outputs_of(&self.outputs, given, &[Some(&self.file)]);
        let table = self.output.clone().unwrap_or_else(|| "world.csv".into());
        let command = WorldCommand {
            file,
            path: &self.file,
            outputs: &outputs,
            table: &table,
            surfaces: self.vtu.as_deref(),
            every: self.every.unwrap_or(1) as usize,
            json: self.json,
        };
        command.run(console)
    }
}

/// Refuses options that belong to something else.
fn refuse_options(options: &[(&str, bool)], of: &str) -> Result<(), Failure> {
    match options.iter().find(|(_, given)| *given) {
        Some((name, _)) => Err(Failure::new(Cause::Usage, format!("`{name}` belongs to the run of {of}"))),
        None => Ok(()),
    }
}

/// Tables, fields and curves of a run, and the largest stress seen.
struct Results<'a> {
    list: RunList<'a>,
    probes: ProbeTable,
    stresses: Option<StressTable<'a>>,
    fields: Option<FieldSeries<'a>>,
    curves: Option<Curves>,
    largest: Option<LargestStress>,
}

impl<'a> Results<'a> {
    fn begin(
        outputs: &'a Outputs,
        folder: &'a Path,
        run: &'a run::Run<'_>,
        geometry: Option<Geometry>,
        shown: &OutputPlan,
    ) -> Result<Self, Failure> {
        let (places, with_stress) = (run.stress_places(), shown.stress_every > 0);
        let written = [true, with_stress, shown.fields_every > 0];
        let files: Vec<&str> =
            FILES.iter().zip(written).filter(|(_, is)| *is).map(|(file, _)| file.0).collect();
        let fields = run.steps.checked_div(shown.fields_every).map_or(0, |fields| 1 + fields);
        let list = RunList::begin(outputs, folder, &files, fields)?;
        let stresses = with_stress
            .then(|| StressTable::begin(outputs, folder.join("stress.csv"), places))
            .transpose()?;
        let probes = ProbeTable::begin(outputs, folder.join("probes.csv"), run)?;
        let fields = geometry.map(|geometry| FieldSeries::begin(outputs, folder, geometry)).transpose()?;
        Ok(Self { list, probes, stresses, fields, curves: None, largest: None })
    }

    /// Adds an instant.
    fn show(&mut self, moment: &Moment<'_>) -> Result<(), Failure> {
        self.probes.show(moment)?;
        if let Some(curves) = &mut self.curves {
            curves.add(moment);
        }
        if let Some(stresses) = &mut self.stresses {
            stresses.show(moment)?;
        }
        let found = moment.probes.and_then(|probed| probed.largest_stress);
        let known = self.largest;
        self.largest =
            found.filter(|found| known.is_none_or(|known| found.von_mises > known.von_mises)).or(known);
        match (&moment.fields, &mut self.fields) {
            (Some(shown), Some(series)) => series.add(moment.time, shown),
            _ => Ok(()),
        }
    }

    fn finish(&mut self) -> Result<(), Failure> {
        let written = self.probes.finish().and(self.stresses.as_mut().map_or(Ok(()), StressTable::finish));
        let written = written.and(self.fields.as_mut().map_or(Ok(()), FieldSeries::finish));
        written.and(self.list.finish(self.fields.as_ref().map_or(0, |series| series.count)))
    }

    /// The rows and fields written so far.
    fn kept(&self) -> String {
        let stresses = self.stresses.as_ref().map(StressTable::kept);
        let fields = self.fields.as_ref().map(FieldSeries::kept);
        [Some(self.probes.kept()), stresses, fields].into_iter().flatten().collect::<Vec<_>>().join("; ")
    }

    fn print(&self, run: &run::Run<'_>, plot: Option<&Path>, json: bool) {
        if json {
            let probes: Vec<String> = run.probes().iter().cloned().chain(run.flight_columns()).collect();
            return print_json(&RunOutput {
                steps: run.steps,
                time_step: run.time_step,
                probes: &probes,
                columns: columns(run),
                supports: run.supports(),
                quantities: run.quantities(),
                plot_file: plot.map(|path| path.display().to_string()),
                rows: self.probes.rows.lines(),
                probes_file: self.probes.path.display().to_string(),
                fields: self.fields.as_ref().map_or(0, |series| series.collection.lines()),
                fields_file: self.fields.as_ref().map(|series| series.path.display().to_string()),
                stress_file: self.stresses.as_ref().map(|stresses| stresses.path.display().to_string()),
                largest_stress: self.largest,
            });
        }
        println!("{} steps of {} s; {}", run.steps, run.time_step, self.kept());
        if let Some(path) = plot {
            println!("wrote {}", path.display());
        }
        if let Some(LargestStress { von_mises, place, time }) = self.largest {
            println!("largest von Mises stress {von_mises:.4e} Pa at node {} after {time:.4e} s", place.id);
        }
    }
}

/// Report of a run.
#[derive(serde::Serialize)]
struct RunOutput<'a> {
    steps: usize,
    time_step: f64,
    probes: &'a [String],
    /// Names of all columns of the table, as in its first line.
    columns: Vec<String>,
    /// Supports whose reactions are columns of the table.
    supports: &'a [String],
    /// Scalars of the whole body that are columns of the table, too.
    #[serde(skip_serializing_if = "<[Total]>::is_empty")]
    quantities: &'a [Total],
    /// None without a picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    plot_file: Option<String>,
    rows: usize,
    probes_file: String,
    fields: usize,
    /// None without fields.
    fields_file: Option<String>,
    /// None without a table of stresses.
    stress_file: Option<String>,
    /// None of a file without stress.
    largest_stress: Option<LargestStress>,
}

/// Names of the columns of the table of probes, with their units.
fn columns(run: &run::Run<'_>) -> Vec<String> {
    let named = run.columns().into_iter().map(|(name, unit)| match unit {
        "" => name,
        unit => format!("{name} [{unit}]"),
    });
    ["time_s", "energy_J"].map(String::from).into_iter().chain(named).collect()
}

/// Time, energy and every probe, one line an instant; on the disk soon after they are computed.
struct ProbeTable {
    path: PathBuf,
    rows: GrowingFile,
    line: String,
}

impl ProbeTable {
    fn begin(outputs: &Outputs, path: PathBuf, run: &run::Run<'_>) -> Result<Self, Failure> {
        let head = columns(run).join(",") + "\n";
        let rows = outputs.grow(&path, Kind::Csv, &head, "")?;
        Ok(Self { path, rows, line: String::new() })
    }

    /// Adds the row of an instant that has one.
    fn show(&mut self, moment: &Moment<'_>) -> Result<(), Failure> {
        let added = match &moment.probes {
            Some(probed) => {
                self.line.clear();
                write_row(&mut self.line, moment.time, probed).expect("writing to a string cannot fail");
                self.rows.add(&self.line)
            }
            None => self.rows.tick(),
        };
        added.map_err(|error| Failure::io(&self.path, error))
    }

    fn finish(&mut self) -> Result<(), Failure> {
        self.rows.finish().map_err(|error| Failure::io(&self.path, error))
    }

    fn kept(&self) -> String {
        format!("{} rows in {}", self.rows.lines(), self.path.display())
    }
}

/// The stress of every point, one line a point and instant.
struct StressTable<'a> {
    path: PathBuf,
    places: &'a [StressPlace],
    rows: GrowingFile,
    line: String,
}

impl<'a> StressTable<'a> {
    fn begin(outputs: &Outputs, path: PathBuf, places: &'a [StressPlace]) -> Result<Self, Failure> {
        let head = "time_s,node,region,xx_Pa,yy_Pa,zz_Pa,xy_Pa,yz_Pa,zx_Pa,von_mises_Pa\n";
        let rows = outputs.grow(&path, Kind::Csv, head, "")?;
        Ok(Self { path, places, rows, line: String::new() })
    }

    /// Adds the rows of an instant that has some.
    fn show(&mut self, moment: &Moment<'_>) -> Result<(), Failure> {
        for (place, stress) in self.places.iter().zip(moment.stress.into_iter().flatten()) {
            self.line.clear();
            let line = &mut self.line;
            let mut write = || {
                write!(line, "{:.9e},{},{}", moment.time, place.id, place.region)?;
                stress.0.iter().try_for_each(|value| write!(line, ",{value:.9e}"))?;
                writeln!(line, ",{:.9e}", stress.von_mises())
            };
            write().expect("writing to a string cannot fail");
            self.rows.add(&self.line).map_err(|error| Failure::io(&self.path, error))?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), Failure> {
        self.rows.finish().map_err(|error| Failure::io(&self.path, error))
    }

    fn kept(&self) -> String {
        format!("{} stresses in {}", self.rows.lines(), self.path.display())
    }
}

fn write_row(line: &mut String, time: f64, probed: &ProbeRow<'_>) -> std::fmt::Result {
    write!(line, "{time:.9e},{:.9e}", probed.energy)?;
    let reactions = probed.reactions.as_flattened();
    probed.values.iter().chain(reactions).try_for_each(|value| write!(line, ",{value:.9e}"))?;
    // Far from the origin a place in space needs all of its digits.
    probed.flight.iter().try_for_each(|value| write!(line, ",{value:e}"))?;
    let rest = probed.quantities.iter().chain(probed.contacts.as_flattened());
    rest.into_iter().try_for_each(|value| write!(line, ",{value:.9e}"))?;
    line.write_char('\n')
}

/// The columns of the table of probes over time, thinned out to what a picture shows.
struct Curves {
    names: Vec<(String, &'static str)>,
    lines: Vec<Thinned>,
    energy: Thinned,
}

impl Curves {
    /// Columns of a picture that a point falls into: half a pixel each.
    const COLUMNS: f64 = 1240.0;

    fn of(run: &run::Run<'_>) -> Self {
        let column = || Thinned::new(run.steps as f64 * run.time_step / Self::COLUMNS);
        let names = run.columns();
        Self { lines: names.iter().map(|_| column()).collect(), names, energy: column() }
    }

    fn add(&mut self, moment: &Moment<'_>) {
        let Some(probed) = &moment.probes else { return };
        let parts = [
            probed.values,
            probed.reactions.as_flattened(),
            probed.flight,
            probed.quantities,
            probed.contacts.as_flattened(),
        ];
        let values = parts.into_iter().flatten();
        self.lines.iter_mut().zip(values).for_each(|(line, &value)| line.push((moment.time, value)));
        self.energy.push((moment.time, probed.energy));
    }

    /// An area for each unit.
    fn draw(self, run: &run::Run<'_>) -> Drawn {
        let mut panels: Vec<Panel<'_>> = vec![];
        for ((name, unit), line) in self.names.iter().zip(self.lines) {
            let y = match *unit {
                "" => name.clone(),
                "1" => "dimensionless".into(),
                unit => format!("{} [{unit}]", quantity(unit)),
            };
            let series = Series { name, points: line.finish() };
            match panels.iter_mut().find(|panel| panel.y == y) {
                Some(panel) => panel.series.push(series),
                None => panels.push(Panel { y, log_y: false, range: None, series: vec![series] }),
            }
        }
        if panels.is_empty() {
            let series = vec![Series { name: "energy", points: self.energy.finish() }];
            panels.push(Panel { y: "energy [J]".into(), log_y: false, range: None, series });
        }
        let one = match &panels[..] {
            [panel] if panel.series.len() == 1 => panel.series[0].name.to_string(),
            _ => "probes".into(),
        };
        panels_chart(&one, ("time [s]", false), panels, run.acting())
    }
}

/// Quantity that has a unit.
fn quantity(unit: &str) -> &'static str {
    match unit {
        "m" => "displacement",
        "m/s" => "velocity",
        "m/s²" => "acceleration",
        "Pa" => "stress",
        "N" => "force",
        "N m" => "moment",
        _ => "value",
    }
}

/// A series of VTU files over the surface or all nodes of the file, and the collection that ParaView opens,
/// which lists each file once it is written.
struct FieldSeries<'a> {
    outputs: &'a Outputs,
    folder: &'a Path,
    geometry: Geometry,
    path: PathBuf,
    collection: GrowingFile,
    count: usize,
}

impl<'a> FieldSeries<'a> {
    fn begin(outputs: &'a Outputs, folder: &'a Path, geometry: Geometry) -> Result<Self, Failure> {
        let path = folder.join("fields.pvd");
        let collection = outputs.grow(&path, Kind::Pvd, PVD_HEAD, PVD_TAIL)?;
        Ok(Self { outputs, folder, geometry, path, collection, count: 0 })
    }

    fn add(&mut self, time: f64, fields: &Fields<'_>) -> Result<(), Failure> {
        let name = field_name(self.count);
        let [stress, von_mises] = fields.stress;
        let moving = [("displacement", fields.displacement, 3), ("velocity", fields.velocity, 3)];
        let stress = [("stress", stress, 6), ("von_mises", von_mises, 1)];
        let known = stress.into_iter().filter(|(_, values, _)| !values.is_empty());
        let data: Vec<_> = moving.into_iter().chain(known).collect();
        let Geometry { nodes, triangles } = &self.geometry;
        self.outputs.write(&self.folder.join(&name), Kind::Vtu, |out| {
            vtu_into(out, nodes, Cells::Triangles(triangles), &data)
        })?;
        self.count += 1;
        let listed = self.collection.add(&pvd_line(time, &name)).and_then(|()| self.collection.flush());
        listed.map_err(|error| Failure::io(&self.path, error))
    }

    fn finish(&mut self) -> Result<(), Failure> {
        self.collection.finish().map_err(|error| Failure::io(&self.path, error))
    }

    fn kept(&self) -> String {
        format!("{} fields in {}", self.collection.lines(), self.path.display())
    }
}
