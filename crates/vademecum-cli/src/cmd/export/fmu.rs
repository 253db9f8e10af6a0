//! `vademecum export fmu`: a vademecum file as a co-simulation unit.

use std::path::{Path, PathBuf};

use vademecum_build::store::{Kind, read_regular};
use vademecum_study::fmu::{
    ArrayRows, FmiVersion, FmuError, Library, NamedPoint, PlacedPoint, PlacedStress, Request, SurfaceNodes,
    export,
};

use crate::arguments::{Limit, OutputArguments};
use crate::assets::fmu_library;
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{check_output, is_stepped, refuse_chapter, usable_file, write_bytes};
use crate::given::{Given, outputs_of};
use crate::print::print_json;

/// Writes a co-simulation unit (FMU) with the file, for simulation programs that know FMI 2.0 or 3.0.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum export fmu body.vdm -o body.fmu                    points where the probes are
  vademecum export fmu body.vdm --point tip=1,0.04,0.1 --point middle=0.5,0.04,0.1 -o body.fmu
  vademecum export fmu body.vdm --stress root=0,0.04,0.1 -o body.fmu
  vademecum export fmu body.vdm --fmi 3 -o body.fmu
  vademecum export fmu body.vdm --fmi 3 --surface -o body.fmu       arrays over the loadable surface
  vademecum export fmu body.vdm --fmi 3 --surface 40 -o body.fmu    over 40 nodes, spread over it
  vademecum export fmu body.vdm --library x86_64-windows=vademecum_fmu.dll -o body.fmu
Inputs: force.POINT.x, .y, .z and pattern.NAME. Outputs: displacement.POINT.x, velocity.POINT.x, probe.NAME,
probe_velocity.NAME, energy, von_mises.NAME, and reaction_force.SUPPORT.x and reaction_moment.SUPPORT.x of a
file with reactions. Of a free body also body_force.x, body_position.x, body_attitude.w, body_velocity.x and
body_angular_velocity.x. With --surface the arrays surface_force, surface_displacement, surface_velocity and
surface_position, with surface_nodes rows. Tunable: parameter.NAME. Communication steps are multiples of
internal_step.
More: docs/how-to/fmu.md")]
pub(crate) struct Fmu {
    /// The vademecum file, or an assembly file (TOML), which is joined in memory.
    file: PathBuf,
    /// The FMU.
    #[arg(short, long)]
    output: PathBuf,
    /// Version of FMI: 2 or 3.
    #[arg(long, default_value = "2", value_parser = version)]
    fmi: FmiVersion,
    /// A named point of the loadable surface, where forces act and motion is shown; may be given several
    /// times [default: where the file's probes are].
    #[arg(long, value_name = "NAME=X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    point: Vec<NamedPoint>,
    /// A named place whose equivalent stress is reported, at the nearest node that the file knows the stress
    /// of (`[output] stress`); may be given several times.
    #[arg(long, value_name = "NAME=X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    stress: Vec<NamedPoint>,
    /// Arrays over the nodes of the loadable surface, of FMI 3: nodal forces in, displacements and velocities
    /// out, one row for each node. All nodes, or COUNT of them, spread over the surface; the master may use
    /// fewer.
    #[arg(long, value_name = "COUNT", num_args = 0..=1)]
    surface: Option<Option<usize>>,
    /// Arrays of a fixed number of rows, for masters without structural parameters.
    #[arg(long, requires = "surface")]
    fixed_rows: bool,
    /// The library for another platform, such as aarch64-linux, x86_64-windows or aarch64-darwin: what `cargo
    /// build --release -p vademecum-fmu` makes there. May be given several times. The one for x86_64-linux is
    /// inside the program.
    #[arg(long, value_name = "PLATFORM=FILE", value_parser = library)]
    library: Vec<LibraryArgument>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
    #[command(flatten)]
    limit: Limit,
}

/// A library that is asked for.
#[derive(Clone, Debug)]
struct LibraryArgument {
    platform: String,
    path: PathBuf,
}

fn version(text: &str) -> Result<FmiVersion, String> {
    match text {
        "2" | "2.0" => Ok(FmiVersion::Two),
        "3" | "3.0" => Ok(FmiVersion::Three),
        other => Err(format!("`{other}` is not one of 2, 3")),
    }
}

/// A name may hold the sign itself.
fn point(text: &str) -> Result<NamedPoint, String> {
    const EXPECTED: &str = "expected NAME=X,Y,Z with three numbers, such as tip=1,0.04,0.1";
    let (name, place) = text.rsplit_once('=').ok_or(EXPECTED)?;
    let numbers: Vec<f64> = place.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    let count = place.split(',').count();
    match numbers.as_slice() {
        &[x, y, z] if count == 3 && [x, y, z].iter().all(|number| number.is_finite()) => {
            Ok(NamedPoint { name: name.trim().to_string(), at: [x, y, z] })
        }
        _ => Err(EXPECTED.into()),
    }
}

fn library(text: &str) -> Result<LibraryArgument, String> {
    let (platform, path) = text.split_once('=').ok_or("expected PLATFORM=FILE")?;
    Ok(LibraryArgument { platform: platform.trim().to_string(), path: path.into() })
}

/// Report of the export.
#[derive(serde::Serialize)]
struct FmuOutput {
    file: String,
    bytes: usize,
    fmi: &'static str,
    internal_step: f64,
    points: Vec<PlacedPoint>,
    stresses: Vec<PlacedStress>,
    surface_nodes: usize,
    inputs: Vec<String>,
    outputs: Vec<String>,
    parameters: Vec<String>,
}

impl Fmu {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let given = Given::look(&self.file)?;
        let read: Vec<Option<&Path>> = std::iter::once(&self.file)
            .chain(self.library.iter().map(|library| &library.path))
            .map(|path| Some(path.as_path()))
            .collect();
        let outputs = outputs_of(&self.outputs, &given, &read);
        check_output(&outputs, &self.output, Kind::Fmu)?;
        let libraries = self.libraries()?;
        let mapped = given.open(&self.file, false, console)?;
        console.clear();
        let mut memory = vec![];
        let file = usable_file(&self.file, &mapped, is_stepped, self.limit, &mut memory)?;
        refuse_chapter(&self.file, &file, "an FMU")?;
        let name = self.output.file_stem().and_then(|stem| stem.to_str()).unwrap_or("vademecum");
        let (points, stresses) = (&self.point, &self.stress);
        let surface = match self.surface {
            None => SurfaceNodes::None,
            Some(None) => SurfaceNodes::All,
            Some(Some(count)) => SurfaceNodes::Spread(count),
        };
        let rows = if self.fixed_rows { ArrayRows::Fixed } else { ArrayRows::Structural };
        let (version, libraries) = (self.fmi, &libraries);
        let request = Request { version, name, points, stresses, surface, rows, libraries };
        let fmu = export(file.bytes(), &request).map_err(|error| self.failure(error))?;
        write_bytes(&outputs, &self.output, Kind::Fmu, &fmu.archive)?;
        let exported = FmuOutput {
            file: self.output.display().to_string(),
            bytes: fmu.archive.len(),
            fmi: match self.fmi {
                FmiVersion::Two => "2.0",
                FmiVersion::Three => "3.0",
            },
            internal_step: fmu.internal_step,
            points: fmu.points,
            stresses: fmu.stresses,
            surface_nodes: fmu.surface_nodes,
            inputs: fmu.inputs,
            outputs: fmu.outputs,
            parameters: fmu.parameters,
        };
        if self.json {
            print_json(&exported);
        } else {
            exported.print();
        }
        Ok(())
    }

    /// The library inside the program, unless another one is given for its platform, and those given.
    fn libraries(&self) -> Result<Vec<Library>, Failure> {
        const OWN: &str = "x86_64-linux";
        let mut libraries = vec![];
        if !self.library.iter().any(|asked| asked.platform == OWN) {
            libraries.push(Library { platform: OWN.into(), bytes: fmu_library() });
        }
        for LibraryArgument { platform, path } in &self.library {
            let bytes = read_regular(path).map_err(|error| Failure::io(path, error))?;
            let library = Library::new(platform, bytes);
            let failed = |error| Failure::new(Cause::Usage, format!("--library {}: {error}", path.display()));
            libraries.push(library.map_err(failed)?);
        }
        libraries.sort_by(|a, b| a.platform.cmp(&b.platform));
        if let Some(pair) = libraries.windows(2).find(|pair| pair[0].platform == pair[1].platform) {
            let text = format!("--library: {} is given twice", pair[0].platform);
            return Err(Failure::new(Cause::Usage, text));
        }
        Ok(libraries)
    }

    fn failure(&self, error: FmuError) -> Failure {
        match error {
            FmuError::File(error) => Failure::file(&self.file, error),
            error => Failure::new(Cause::Usage, error),
        }
    }
}

impl FmuOutput {
    fn print(&self) {
        let Self { file, bytes, fmi, internal_step, points, stresses, inputs, outputs, parameters, .. } =
            self;
        println!("{file}: FMI {fmi}, {bytes} bytes, internal step {internal_step} s");
        for PlacedPoint { name, position: [x, y, z], distance, .. } in points {
            println!("point {name}: ({x}, {y}, {z}), {distance:.1e} from the place given");
        }
        for PlacedStress { name, position: [x, y, z], distance, .. } in stresses {
            println!("stress {name}: ({x}, {y}, {z}), {distance:.1e} from the place given");
        }
        if self.surface_nodes > 0 {
            println!("arrays: {} nodes of the loadable surface", self.surface_nodes);
        }
        for (what, names) in [("inputs", inputs), ("outputs", outputs), ("tunable", parameters)] {
            println!("{what}: {}", if names.is_empty() { "none".into() } else { names.join(", ") });
        }
        if inputs.is_empty() {
            println!(
                "nothing can act on the body: name a point with --point, or build the file with a load pattern"
            );
        }
    }
}
