//! `vademecum export craig-bampton`: a body reduced to its interfaces, for multibody and finite element
//! programs.

use std::path::PathBuf;

use vademecum_build::Matrix;
use vademecum_build::field::dense_market_into;
use vademecum_build::input::{InterfaceEntry, Problem};
use vademecum_build::limits::Memory;
use vademecum_build::progress::Listener;
use vademecum_build::store::{Kind, Outputs};
use vademecum_build::superelement::{Method, Request};
use vademecum_study::superelement::{Description, ReducedBody, columns_of};

use crate::arguments::{OutputArguments, size};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{outputs, write_bytes};
use crate::print::{json, print_json};

/// The script for Exudyn.
const EXUDYN: &str = include_str!("../../../assets/superelement/exudyn_body.py");

/// Writes a body reduced to its interfaces and some modes: mass, stiffness, damping and transformation of a
/// superelement.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum export craig-bampton rod.toml --interface x_min --interface x_max -o rod      patches of groups
  vademecum export craig-bampton rod.toml --interface x_min=rigid --interface x_max=average --modes 8 -o rod
  vademecum export craig-bampton rod.toml -o rod                                          the ports of the problem
  vademecum export craig-bampton rod.toml --interface x_min=rigid --format exudyn,dmig -o rod
  vademecum export craig-bampton rod.toml --method rubin --interface x_min=average -o rod
An interface is NAME, the name of a port of the problem or of a group of the mesh; NAME=KIND with a kind; or
NAME={ … } with the keys kind, on, at and axes in the language of the problem file:
  --interface 'pin={ kind = \"rigid\", on = { box = { min = [0, 0, 0], max = [0.1, 1, 1] } }, at = [0, 0, 0] }'
Kinds: patch and nodes have three displacements a node; rigid and average are frames of six motions that the
nodes follow (RBE2), or that follow their mean (RBE3). What the files hold: formats/superelement-1.md.
More: docs/how-to/craig-bampton.md")]
pub(crate) struct CraigBampton {
    /// The problem file (TOML).
    problem: PathBuf,
    /// An interface; may be given several times [default: the ports of the problem].
    #[arg(long, value_name = "INTERFACE", value_parser = interface)]
    interface: Vec<InterfaceEntry>,
    /// Method: `craig-bampton`, `rubin`, `macneal` or `herting`.
    #[arg(long, default_value = "craig-bampton", value_parser = method)]
    method: Method,
    /// Number of normal modes beside the coordinates of the interfaces.
    #[arg(long, default_value_t = 12)]
    modes: u16,
    /// What is written beside the description, separated by commas: `market` (Matrix Market), `npz` (NumPy),
    /// `dmig` (Nastran), `exudyn` (a script, and in the archive the matrices at full order).
    #[arg(long, value_delimiter = ',', default_value = "market,npz", value_parser = format)]
    format: Vec<Format>,
    /// Folder for the files; made if missing.
    #[arg(short, long)]
    output: PathBuf,
    /// Memory that may be used, such as 8G or 500M [default: what the machine, control groups and `ulimit -v`
    /// leave].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    memory: Option<u64>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// Files for other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Market,
    Npz,
    Dmig,
    Exudyn,
}

impl Format {
    const ALL: [(&'static str, Self); 4] =
        [("market", Self::Market), ("npz", Self::Npz), ("dmig", Self::Dmig), ("exudyn", Self::Exudyn)];

    /// Its files.
    fn files(self) -> &'static [(&'static str, Kind)] {
        const NPZ: (&str, Kind) = ("superelement.npz", Kind::Npz);
        match self {
            Self::Market => &MARKET,
            Self::Npz => &[NPZ],
            Self::Dmig => &[("superelement.pch", Kind::Text)],
            Self::Exudyn => &[NPZ, ("exudyn_body.py", Kind::Text)],
        }
    }
}

/// Files of `market`.
const MARKET: [(&str, Kind); 4] = [
    ("mass.mtx", Kind::Market),
    ("stiffness.mtx", Kind::Market),
    ("damping.mtx", Kind::Market),
    ("transformation.mtx", Kind::Market),
];

/// The description.
const DESCRIPTION: (&str, Kind) = ("superelement.json", Kind::Json);

fn interface(text: &str) -> Result<InterfaceEntry, String> {
    InterfaceEntry::parse(text).map_err(|error| error.to_string())
}

fn method(text: &str) -> Result<Method, String> {
    let found = Method::ALL.into_iter().find(|method| method.word() == text);
    found.ok_or_else(|| format!("`{text}` is not one of craig-bampton, rubin, macneal, herting"))
}

fn format(text: &str) -> Result<Format, String> {
    let found = Format::ALL.into_iter().find(|(word, _)| *word == text);
    found.map(|(_, format)| format).ok_or_else(|| format!("`{text}` is not one of market, npz, dmig, exudyn"))
}

/// Report of the export.
#[derive(serde::Serialize)]
struct CraigBamptonOutput {
    folder: String,
    method: &'static str,
    size: usize,
    interface_size: usize,
    dofs: usize,
    frequencies_hz: Vec<f64>,
    interfaces: Vec<InterfaceOutput>,
    files: Vec<&'static str>,
}

/// An interface in the report.
#[derive(serde::Serialize)]
struct InterfaceOutput {
    name: String,
    kind: &'static str,
    count: usize,
    origin: [f64; 3],
}

impl CraigBampton {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let problem = Problem::read(&self.problem)?;
        let outputs = outputs(&self.outputs, &[Some(&self.problem)], Some(&problem));
        let files = self.files();
        outputs.check_in(&self.output, &files)?;
        let request = Request {
            method: self.method,
            modes: self.modes.into(),
            memory: Memory::asked_or_available(self.memory),
        };
        let body = ReducedBody::new(&problem, &self.interface, request, console)?;
        if self.format.contains(&Format::Exudyn) && !body.is_bare_and_free() {
            let text = "--format exudyn: the body has supports or attachments; expected a free body of elements alone, which \
                        moves in a floating frame: remove them, joints of Exudyn take their place";
            return Err(Failure::new(Cause::Usage, text));
        }
        console.stage("write");
        outputs.make_folder(&self.output)?;
        let description = body.description();
        self.write(&outputs, &body, &description)?;
        console.clear();
        self.print(&body, description, files.iter().map(|(name, _)| *name).collect());
        Ok(())
    }

    /// Files that are written.
    fn files(&self) -> Vec<(&'static str, Kind)> {
        let mut files = vec![DESCRIPTION];
        for file in self.format.iter().flat_map(|format| format.files()) {
            if !files.iter().any(|(name, _)| *name == file.0) {
                files.push(*file);
            }
        }
        files
    }

    fn write(&self, outputs: &Outputs, body: &ReducedBody, description: &Description) -> Result<(), Failure> {
        let at = |name: &str| self.output.join(name);
        let bytes = |name: &str, kind, bytes: &[u8]| write_bytes(outputs, &at(name), kind, bytes);
        let has = |format| self.format.contains(&format);
        if has(Format::Market) {
            let found = &body.superelement;
            let matrices = [&found.mass, &found.stiffness, &found.damping, &found.transformation];
            for ((name, kind), matrix) in MARKET.into_iter().zip(matrices) {
                let (symmetric, columns) = (is_square(matrix), columns_of(matrix));
                outputs.write(&at(name), kind, |out| dense_market_into(out, &columns, symmetric))?;
            }
        }
        if has(Format::Npz) || has(Format::Exudyn) {
            bytes("superelement.npz", Kind::Npz, &body.npz(has(Format::Exudyn))?)?;
        }
        if has(Format::Dmig) {
            bytes("superelement.pch", Kind::Text, body.punch().as_bytes())?;
        }
        if has(Format::Exudyn) {
            bytes("exudyn_body.py", Kind::Text, EXUDYN.as_bytes())?;
        }
        bytes(DESCRIPTION.0, DESCRIPTION.1, json(description).as_bytes())
    }

    fn print(&self, body: &ReducedBody, description: Description, files: Vec<&'static str>) {
        let found = &body.superelement;
        let interfaces = description.interfaces.iter().map(|one| InterfaceOutput {
            name: one.name.clone(),
            kind: one.kind,
            count: one.count,
            origin: one.origin,
        });
        let exported = CraigBamptonOutput {
            folder: self.output.display().to_string(),
            method: found.method.word(),
            size: description.size,
            interface_size: description.interface_size,
            dofs: description.dofs,
            interfaces: interfaces.collect(),
            frequencies_hz: description.frequencies_hz,
            files,
        };
        if self.json {
            return print_json(&exported);
        }
        let CraigBamptonOutput { folder, method, size, interface_size, dofs, .. } = &exported;
        println!(
            "{folder}: {dofs} dofs reduced to {size} by {method}: {interface_size} of interfaces, {} of modes",
            size - interface_size
        );
        for InterfaceOutput { name, kind, count, origin: [x, y, z] } in &exported.interfaces {
            println!("interface {name}: {kind}, {count} coordinates, at ({x:.6}, {y:.6}, {z:.6})");
        }
        let modes = match found.method {
            Method::CraigBampton => "modes with fixed interfaces",
            Method::Rubin | Method::Macneal | Method::Herting => "modes with free interfaces",
        };
        let frequencies: Vec<String> = exported.frequencies_hz.iter().map(|f| format!("{f:.6}")).collect();
        if !frequencies.is_empty() {
            println!("{modes}: {} Hz", frequencies.join(", "));
        }
        println!("wrote {}", exported.files.join(", "));
    }
}

/// True of the matrices over the coordinates, which are symmetric.
fn is_square(matrix: &Matrix) -> bool {
    matrix.nrows() == matrix.ncols()
}
