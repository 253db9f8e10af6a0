//! `vademecum run`: a scenario through a file, to tables and fields.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use vademecum_build::field::{Cells, write_pvd, write_vtu};
use vademecum_format::SectionKind;
use vademecum_study::contents::Geometry;
use vademecum_study::run::{Fields, Moment, Probed};
use vademecum_study::scenario::{FieldChoice, Scenario};
use vademecum_study::{FileError, StudyError, run};

use crate::arguments::{Limit, StructureArgument};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{is_stepped, make_folder, open, usable_file, write_text};

/// Steps a vademecum through a scenario and writes probes (CSV) and fields (VTU, opens in ParaView).
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum run body.vdm --scenario push.toml -o out/
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
    /// Time step \[s\]; the file's if absent (diagonal structure only).
    #[arg(long)]
    time_step: Option<f64>,
    /// Only the first so many terms of the separated solution; `info --terms-for` tells how many a tolerance
    /// takes.
    #[arg(long)]
    terms: Option<usize>,
    /// Copy the file into memory instead of mapping it: safe where another program may shorten or overwrite
    /// it in place.
    #[arg(long)]
    copy: bool,
    #[command(flatten)]
    limit: Limit,
}

impl Run {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        let scenario = Scenario::read(&self.scenario)?;
        let mapped = open(&self.file, self.copy)?;
        let mut memory = vec![];
        let inside = scenario.output.fields_every > 0 && scenario.output.fields == FieldChoice::Body;
        let wanted = |kind| is_stepped(kind) && (inside || kind != SectionKind::InteriorBasis);
        let file = usable_file(&self.file, &mapped, wanted, self.limit, &mut memory)?;
        let mut options = self.structure.options();
        (options.scene.time_step, options.scene.terms) = (self.time_step, self.terms);
        let about = |error: StudyError| Failure::from(error).about(&self.file);
        let unread = |error: FileError| Failure::file(&self.file, error);
        let run = run::Run::bind(&file, options, &scenario, console).map_err(about)?;
        let mut probes = ProbeTable::new(&run.probes().map_err(unread)?);
        let mut fields =
            run.geometry().map_err(unread)?.map(|geometry| FieldSeries::new(&self.output, geometry));
        make_folder(&self.output)?;
        run.play(console, |moment: &Moment<'_>| {
            if let Some(probed) = &moment.probes {
                probes.add(moment.time, probed);
            }
            match (&moment.fields, &mut fields) {
                (Some(shown), Some(series)) => series.add(moment.time, shown),
                _ => Ok(()),
            }
        })
        .map_err(|failure: Failure| failure.about(&self.file))?;
        console.clear();
        let table = self.output.join("probes.csv");
        write_text(&table, &probes.text)?;
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
