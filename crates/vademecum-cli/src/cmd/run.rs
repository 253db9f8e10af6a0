//! `vademecum run`: a scenario through a file, to tables and fields.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use vademecum_build::field::{Cells, write_pvd, write_vtu};
use vademecum_study::contents::Geometry;
use vademecum_study::parameters::{self, ParameterValue};
use vademecum_study::run::{Fields, Moment, Probed};
use vademecum_study::scenario::Scenario;
use vademecum_study::{FileError, StudyError, run};

use crate::arguments::{StructureArgument, setting};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{make_folder, open_or_map, whole_file, write_text};

/// Steps a vademecum through a scenario and writes probes (CSV) and fields (VTU, opens in ParaView).
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum run body.vdm --scenario push.toml -o out/
  vademecum run body.vdm --scenario push.toml --set \"tip stiffness=1.5\" --set damping=1e-4
Keys of the scenario file: formats/scenario-1.md")]
pub struct Run {
    /// The vademecum file.
    file: PathBuf,
    /// The scenario file (TOML).
    #[arg(long)]
    scenario: PathBuf,
    /// Folder for the results; made if missing.
    #[arg(short, long, default_value = "out")]
    output: PathBuf,
    /// Structure of the step.
    #[arg(long, value_enum, default_value_t = StructureArgument::Auto)]
    structure: StructureArgument,
    /// Time step \[s\]; the file's if absent. The diagonal structure takes any; the block structure takes
    /// those of the range it was built for, if the time step is one of its live parameters, and no other.
    #[arg(long)]
    time_step: Option<f64>,
    /// Set a live parameter of the file, by its name; may be given several times. `info` shows names, ranges
    /// and units.
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    set: Vec<ParameterValue>,
    /// March more than a billion steps.
    #[arg(long)]
    long: bool,
    /// Only the first so many terms of the separated solution; `info --terms-for` tells how many a tolerance
    /// takes.
    #[arg(long)]
    terms: Option<usize>,
    /// Map the file into memory instead of copying it, for files too large to copy. Nobody may shorten or
    /// overwrite it meanwhile: that would end the program or give wrong numbers.
    #[arg(long)]
    map: bool,
    /// What happens without `--map`.
    #[arg(long, hide = true, conflicts_with = "map")]
    copy: bool,
}

impl Run {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        let scenario = Scenario::read(&self.scenario)?;
        let mapped = open_or_map(&self.file, self.map)?;
        let mut memory = vec![];
        let file = whole_file(&self.file, &mapped, &mut memory)?;
        let mut options = self.structure.options();
        (options.scene.time_step, options.scene.terms) = (self.time_step, self.terms);
        options.long = self.long;
        let about = |error: StudyError| Failure::of_study(error, &self.file, &self.scenario);
        parameters::set(&mut options.scene, file.metadata(), &self.set).map_err(about)?;
        let unread = |error: FileError| Failure::file(&self.file, error);
        let run = run::Run::bind(&file, options, &scenario, console).map_err(about)?;
        let mut probes = ProbeTable::new(&run.probes().map_err(unread)?);
        let mut fields =
            run.geometry().map_err(unread)?.map(|geometry| FieldSeries::new(&self.output, geometry));
        make_folder(&self.output)?;
        let played = run.play(console, |moment: &Moment<'_>| {
            if let Some(probed) = &moment.probes {
                probes.add(moment.time, probed);
            }
            match (&moment.fields, &mut fields) {
                (Some(shown), Some(series)) => series.add(moment.time, shown),
                _ => Ok(()),
            }
        });
        console.clear();
        let table = self.output.join("probes.csv");
        write_text(&table, &probes.text)?;
        played.map_err(|failure: Failure| failure.about(&self.file))?;
        println!("{} steps of {} s; {}", run.steps, run.time_step, table.display());
        fields.map_or(Ok(()), |fields| fields.finish())
    }
}

/// Time, energy and every probe, one line an instant.
struct ProbeTable {
    text: String,
}

impl ProbeTable {
    fn new(names: &[String]) -> Self {
        let mut text = String::from("time_s,energy_J");
        names.iter().for_each(|name| text.push_str(&format!(",{name}")));
        text.push('\n');
        Self { text }
    }

    fn add(&mut self, time: f64, probed: &Probed<'_>) {
        write!(self.text, "{time:.9e},{:.9e}", probed.energy).expect("writing to a string cannot fail");
        for value in probed.values {
            write!(self.text, ",{value:.9e}").expect("writing to a string cannot fail");
        }
        self.text.push('\n');
    }
}

/// A series of VTU files over the surface or all nodes of the file.
struct FieldSeries<'a> {
    folder: &'a Path,
    geometry: Geometry,
    entries: Vec<(f64, String)>,
}

impl<'a> FieldSeries<'a> {
    fn new(folder: &'a Path, geometry: Geometry) -> Self {
        Self { folder, geometry, entries: vec![] }
    }

    fn add(&mut self, time: f64, fields: &Fields<'_>) -> Result<(), Failure> {
        let name = format!("field-{:06}.vtu", self.entries.len());
        let data = [("displacement", fields.displacement, 3), ("velocity", fields.velocity, 3)];
        let cells = Cells::Triangles(&self.geometry.triangles);
        write_vtu(&self.folder.join(&name), &self.geometry.nodes, cells, &data)
            .map_err(|error| Failure::new(Cause::Machine, error))?;
        self.entries.push((time, name));
        Ok(())
    }

    /// Writes the collection that ParaView opens.
    fn finish(&self) -> Result<(), Failure> {
        let path = self.folder.join("fields.pvd");
        write_pvd(&path, &self.entries).map_err(|error| Failure::new(Cause::Machine, error))?;
        println!("{} fields; {}", self.entries.len(), path.display());
        Ok(())
    }
}
