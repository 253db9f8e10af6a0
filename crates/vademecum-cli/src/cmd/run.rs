//! `vademecum run`: a scenario through a file, to tables and fields.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use vademecum_build::field::{Cells, write_pvd, write_vtu};
use vademecum_eval::{Field, SceneOptions, StructureChoice};
use vademecum_format::{File, SectionKind};
use vademecum_study::scenario::{FieldChoice, Scenario};

use super::{make_folder, open, whole_file, write_text};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::player::{PlayOptions, Playable, Track, names, play};

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
    /// Only the first so many terms of the separated solution; `info --terms-for` tells how many a tolerance takes.
    #[arg(long)]
    terms: Option<usize>,
    /// Copy the file into memory instead of mapping it: safe where another program may shorten or overwrite it in place.
    #[arg(long)]
    copy: bool,
}

/// Structure of the step, as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum StructureArgument {
    /// The cheapest whose certificate keeps the tolerance.
    Auto,
    /// One 3 × 3 map per mode.
    Diagonal,
    /// One dense map.
    Block,
    /// The chapter's separated stage maps.
    Canonical,
}

impl StructureArgument {
    /// Options for playing a scenario through it.
    pub fn options(self) -> PlayOptions {
        let structure = match self {
            Self::Diagonal => StructureChoice::Diagonal,
            Self::Block => StructureChoice::Block,
            Self::Auto | Self::Canonical => StructureChoice::Auto,
        };
        PlayOptions {
            chapter: self == Self::Canonical,
            scene: SceneOptions { structure, ..SceneOptions::default() },
        }
    }
}

impl Run {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        use vademecum_build::progress::Listener;
        let scenario = Scenario::read(&self.scenario)?;
        let mapped = open(&self.file, self.copy)?;
        let mut memory = vec![];
        let file = whole_file(&self.file, &mapped, &mut memory)?;
        let mut options = self.structure.options();
        (options.scene.time_step, options.scene.terms) = (self.time_step, self.terms);
        let track = Track::bind(&self.file, &file, &scenario)?;
        for (i, (_, point, _)) in track.contacts.iter().enumerate() {
            let size = point.position.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
            if point.distance > 1e-6 * size {
                console.note(&format!("contact[{i}] acts {:.3e} away from the point given", point.distance));
            }
        }
        make_folder(&self.output)?;
        let mut probes = ProbeTable::new(names(&self.file, &file, SectionKind::ProbeNames)?);
        let mut fields = FieldSeries::new(&self.file, &file, scenario.output.fields)?;
        let time_step = options.scene.time_step.unwrap_or(file.metadata().time_step);
        let steps = scenario.steps(time_step);
        console.stage("step");
        let every = scenario.output.fields_every;
        play(&self.file, &file, &options, &track, steps, |step, body| {
            let time = step as f64 * time_step;
            if step % scenario.output.probes_every == 0 {
                probes.add(&self.file, time, body)?;
            }
            if every > 0 && step % every == 0 {
                fields.add(&self.file, &self.output, time, body)?;
            }
            console.advance(step, steps);
            Ok(())
        })?;
        console.clear();
        write_text(&self.output.join("probes.csv"), &probes.text)?;
        println!("{} steps of {time_step} s; {}", steps, self.output.join("probes.csv").display());
        if every > 0 {
            let path = self.output.join("fields.pvd");
            write_pvd(&path, &fields.entries).map_err(|error| Failure::new(Cause::Machine, error))?;
            println!("{} fields; {}", fields.entries.len(), path.display());
        }
        Ok(())
    }
}

/// Time, energy and every probe, one line an instant.
struct ProbeTable {
    count: usize,
    text: String,
}

impl ProbeTable {
    fn new(names: Vec<String>) -> Self {
        let mut text = String::from("time_s,energy_J");
        names.iter().for_each(|name| text.push_str(&format!(",{name}")));
        text.push('\n');
        Self { count: names.len(), text }
    }

    fn add(&mut self, path: &Path, time: f64, body: &dyn Playable<Number = f64>) -> Result<(), Failure> {
        let failed = |error| Failure::file(path, error);
        let energy = body.energy().map_err(failed)?;
        write!(self.text, "{time:.9e},{energy:.9e}").expect("writing to a string cannot fail");
        for probe in 0..self.count {
            let value = body.probe(probe).map_err(failed)?;
            write!(self.text, ",{value:.9e}").expect("writing to a string cannot fail");
        }
        self.text.push('\n');
        Ok(())
    }
}

/// A series of VTU files over the surface or all nodes of the file.
struct FieldSeries {
    choice: FieldChoice,
    nodes: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    entries: Vec<(f64, String)>,
}

impl FieldSeries {
    fn new(path: &Path, file: &File<'_>, choice: FieldChoice) -> Result<Self, Failure> {
        let metadata = file.metadata();
        let count = match choice {
            FieldChoice::Surface => metadata.n_surface_nodes,
            FieldChoice::Body => metadata.n_nodes,
        } as usize;
        let (mut nodes, triangles) = geometry(path, file)?;
        nodes.truncate(count);
        Ok(Self {
            choice,
            nodes,
            triangles,
            displacement: vec![0.0; 3 * count],
            velocity: vec![0.0; 3 * count],
            entries: vec![],
        })
    }

    fn add(
        &mut self,
        path: &Path,
        folder: &Path,
        time: f64,
        body: &dyn Playable<Number = f64>,
    ) -> Result<(), Failure> {
        let fill = |field, out: &mut [f64]| match self.choice {
            FieldChoice::Surface => body.surface_into(field, out),
            FieldChoice::Body => body.body_into(field, out),
        };
        fill(Field::Displacement, &mut self.displacement).map_err(|error| Failure::file(path, error))?;
        fill(Field::Velocity, &mut self.velocity).map_err(|error| Failure::file(path, error))?;
        let name = format!("field-{:06}.vtu", self.entries.len());
        let data = [("displacement", &self.displacement[..], 3), ("velocity", &self.velocity[..], 3)];
        let cells = Cells::Triangles(&self.triangles);
        write_vtu(&folder.join(&name), &self.nodes, cells, &data)
            .map_err(|error| Failure::new(Cause::Machine, error))?;
        self.entries.push((time, name));
        Ok(())
    }
}

/// Node coordinates and surface triangles.
pub type Geometry = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Node coordinates and surface triangles in file order.
pub fn geometry(path: &Path, file: &File<'_>) -> Result<Geometry, Failure> {
    let section = |kind: SectionKind| {
        let missing =
            || Failure::new(Cause::File, format!("{}: the file has no section {kind:?}", path.display()));
        file.section(kind).ok_or_else(missing)
    };
    let failed = |error| Failure::file(path, error);
    let numbers: Vec<f64> =
        section(SectionKind::NodeCoordinates)?.numbers().map_err(failed)?.iter().collect();
    let indices = section(SectionKind::Triangles)?.u32s().map_err(failed)?;
    let nodes = numbers.as_chunks().0.to_vec();
    let triangles = indices.as_chunks::<3>().0.iter().map(|t| t.map(u32::from_le_bytes)).collect();
    Ok((nodes, triangles))
}
