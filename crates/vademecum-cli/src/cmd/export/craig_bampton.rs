//! `vademecum export craig-bampton`: a body reduced to its interfaces, for multibody and finite element
//! programs.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use vademecum_build::Matrix;
use vademecum_build::field::{dense_market_into, matrix_market_into};
use vademecum_build::input::{InterfaceEntry, Problem};
use vademecum_build::limits::Memory;
use vademecum_build::progress::Listener;
use vademecum_build::store::{Kind, Outputs, open_regular};
use vademecum_build::superelement::{Method, Request};
use vademecum_study::StudyError;
use vademecum_study::superelement::{
    Description, ReducedBody, chrono, columns_of, file_at_ports, npz, punch,
};

use crate::arguments::{Limit, OutputArguments, size};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{open_or_map, outputs, usable_file, write_bytes};
use crate::looks::is_vademecum;
use crate::print::{json, print_json};

/// The header for Chrono.
const CHRONO: &str = include_str!("../../../assets/superelement/chrono_body.h");

/// The script for Exudyn.
const EXUDYN: &str = include_str!("../../../assets/superelement/exudyn_body.py");

/// Writes a body reduced to its interfaces and some modes: mass, stiffness, damping and transformation of a
/// superelement.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum export craig-bampton rod.toml --interface x_min --interface x_max -o rod  patches of groups
  vademecum export craig-bampton rod.toml --interface x_min=rigid --interface x_max=average --modes 8 -o rod
  vademecum export craig-bampton rod.toml -o rod                     the ports of the problem
  vademecum export craig-bampton rod.toml --interface x_min=rigid --format exudyn,dmig -o rod
  vademecum export craig-bampton rod.toml --method rubin --interface x_min=average -o rod
  vademecum export craig-bampton rod.vdm --interface tip -o rod      a vademecum file at its port `tip`
An interface is NAME, the name of a port of the problem or of a group of the mesh; NAME=KIND with a kind; or
NAME={ … } with the keys kind, on, at and axes in the language of the problem file:
  --interface 'pin={ kind = \"rigid\", on = { group = \"x_min\" }, at = [0, 0, 0.01] }'
Kinds: patch and nodes have three displacements a node; rigid and average are frames of six motions that the
nodes follow (RBE2), or that follow their mean (RBE3). A vademecum file has its ports as interfaces, and the
methods rubin and macneal. What the files hold: formats/superelement-1.md.
More: docs/how-to/craig-bampton.md")]
pub(crate) struct CraigBampton {
    /// The problem file (TOML), or a vademecum file with ports.
    problem: PathBuf,
    /// An interface; may be given several times [default: the ports].
    #[arg(long, value_name = "INTERFACE", value_parser = interface)]
    interface: Vec<InterfaceEntry>,
    /// Method: `craig-bampton`, `rubin`, `macneal` or `herting` [default: `craig-bampton`, and `rubin` of a
    /// vademecum file].
    #[arg(long, value_parser = method)]
    method: Option<Method>,
    /// Number of normal modes beside the coordinates of the interfaces [default: 12, and all of a vademecum
    /// file].
    #[arg(long)]
    modes: Option<u16>,
    /// Files beside the description, separated by commas: `market` (Matrix Market), `npz` (NumPy),
    /// `dmig` (Nastran), `exudyn` (a module, and in the archive the matrices at full order), `chrono` (a
    /// header, and the matrices at full order).
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
    #[command(flatten)]
    limit: Limit,
}

/// Modes of a problem without a number.
const MODES: u16 = 12;

/// Files for other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Market,
    Npz,
    Dmig,
    Exudyn,
    Chrono,
}

impl Format {
    const ALL: [(&'static str, Self); 5] = [
        ("market", Self::Market),
        ("npz", Self::Npz),
        ("dmig", Self::Dmig),
        ("exudyn", Self::Exudyn),
        ("chrono", Self::Chrono),
    ];

    /// Its files.
    fn files(self) -> &'static [(&'static str, Kind)] {
        const NPZ: (&str, Kind) = ("superelement.npz", Kind::Npz);
        match self {
            Self::Market => &MARKET,
            Self::Npz => &[NPZ],
            Self::Dmig => &[("superelement.pch", Kind::Text)],
            Self::Exudyn => &[NPZ, ("exudyn_body.py", Kind::Text)],
            Self::Chrono => &CHRONO_FILES,
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

/// Files of `chrono`.
const CHRONO_FILES: [(&str, Kind); 4] = [
    ("chrono_mass.mtx", Kind::Market),
    ("chrono_stiffness.mtx", Kind::Market),
    ("chrono_boundary.csv", Kind::Csv),
    ("chrono_body.h", Kind::Text),
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
    found
        .map(|(_, format)| format)
        .ok_or_else(|| format!("`{text}` is not one of market, npz, dmig, exudyn, chrono"))
}

/// Report of the export.
#[derive(serde::Serialize)]
struct CraigBamptonOutput {
    folder: String,
    method: &'static str,
    size: usize,
    interface_size: usize,
    dofs: Option<usize>,
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
        let files = self.files();
        let (outputs, body) = match is_file(&self.problem) {
            true => self.of_file(&files)?,
            false => self.of_problem(&files, console)?,
        };
        if self.format.contains(&Format::Exudyn) && !body.is_bare_and_free() {
            let text = "--format exudyn: the body has supports or attachments, or it is a vademecum file; expected the \
                        problem file of a free body of elements alone, which moves in a floating frame";
            return Err(Failure::new(Cause::Usage, text));
        }
        let for_chrono = self.format.contains(&Format::Chrono).then(|| chrono(&body)).transpose();
        let for_chrono = for_chrono.map_err(StudyError::from)?;
        console.stage("write");
        outputs.make_folder(&self.output)?;
        let description = Description::new(&body);
        self.write(&outputs, &body, &description)?;
        if let Some((table, full)) = for_chrono {
            let at = |name: &str| self.output.join(name);
            let [mass, stiffness] = [full.pencil.mass(), full.pencil.stiffness()];
            for ((name, kind), matrix) in CHRONO_FILES.into_iter().zip([mass, stiffness]) {
                outputs.write(&at(name), kind, |out| matrix_market_into(out, matrix))?;
            }
            write_bytes(&outputs, &at("chrono_boundary.csv"), Kind::Csv, table.as_bytes())?;
            write_bytes(&outputs, &at("chrono_body.h"), Kind::Text, CHRONO.as_bytes())?;
        }
        console.clear();
        self.print(&body, description, files.iter().map(|(name, _)| *name).collect());
        Ok(())
    }

    /// The outputs, and the body of a problem at its interfaces.
    fn of_problem(
        &self,
        files: &[(&str, Kind)],
        console: &Console,
    ) -> Result<(Outputs, ReducedBody), Failure> {
        let problem = Problem::read(&self.problem)?;
        let outputs = outputs(&self.outputs, &[Some(&self.problem)], Some(&problem));
        outputs.check_in(&self.output, files)?;
        let request = Request {
            method: self.method.unwrap_or(Method::CraigBampton),
            modes: self.modes.unwrap_or(MODES).into(),
            memory: Memory::asked_or_available(self.memory),
        };
        let body = ReducedBody::new(&problem, &self.interface, request, console)?;
        Ok((outputs, body))
    }

    /// The outputs, and the body of a vademecum file at its ports.
    fn of_file(&self, files: &[(&str, Kind)]) -> Result<(Outputs, ReducedBody), Failure> {
        let outputs = outputs(&self.outputs, &[Some(&self.problem)], None);
        outputs.check_in(&self.output, files)?;
        let mapped = open_or_map(&self.problem, false)?;
        let mut memory = vec![];
        let file = usable_file(&self.problem, &mapped, |_| true, self.limit, &mut memory)?;
        let method = self.method.unwrap_or(Method::Rubin);
        let body = file_at_ports(file, &self.interface, method, self.modes.map(usize::from));
        Ok((outputs, body.map_err(|error| Failure::from(error).about(&self.problem))?))
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
            bytes("superelement.npz", Kind::Npz, &npz(body, has(Format::Exudyn))?)?;
        }
        if has(Format::Dmig) {
            bytes("superelement.pch", Kind::Text, punch(body).as_bytes())?;
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
        let from = dofs.map_or_else(String::new, |dofs| format!("{dofs} dofs reduced to "));
        println!(
            "{folder}: {from}{size} coordinates by {method}: {interface_size} of interfaces, {} of modes",
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

/// True of a vademecum file, sound or not.
fn is_file(path: &Path) -> bool {
    let mut head = [0; 8];
    open_regular(path).and_then(|mut file| file.read_exact(&mut head)).is_ok() && is_vademecum(&head)
}

/// True of the matrices over the coordinates, which are symmetric.
fn is_square(matrix: &Matrix) -> bool {
    matrix.nrows() == matrix.ncols()
}
