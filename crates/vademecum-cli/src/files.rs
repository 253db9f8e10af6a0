//! Files that commands read and write.

use std::error::Error;
use std::path::Path;

use vademecum_build::field::{Cells, vtu_into};
use vademecum_build::input::Problem;
use vademecum_build::mesh::Mesh;
use vademecum_build::store::{Kind, Outputs, open_regular, read_regular};
use vademecum_eval::{Mapped, OpenError, ParametricError};
use vademecum_format::{Codec, File, FormatError, Section, SectionKind};
use vademecum_study::StudyError;
use vademecum_study::live::{self, BodyAtValues};
use vademecum_study::parameters::ParameterValue;

use crate::arguments::{Limit, OutputArguments};
use crate::console;
use crate::failure::{Cause, DAMAGED, Failure, UNREAD};
use crate::looks::{Looks, is_vademecum, look_at};
use crate::pictures::{DrawResult, Drawn};
use crate::print::print_json;

/// Outputs of a command that reads `inputs` and the files named by `problem`. Everything that the program
/// writes goes through this.
pub fn outputs(arguments: &OutputArguments, inputs: &[Option<&Path>], problem: Option<&Problem>) -> Outputs {
    let given = inputs.iter().flatten().map(|path| path.to_path_buf());
    Outputs::new(given.chain(problem.map(Problem::files).unwrap_or_default()), arguments.force)
}

/// Refuses, before any work begins, what a command could not write. If it writes where standard output goes,
/// what it has to say goes to standard error.
pub(crate) fn check_output(outputs: &Outputs, path: &Path, kind: Kind) -> Result<(), Failure> {
    outputs.check(&[(path.to_path_buf(), kind)])?;
    console::make_way_for(path);
    Ok(())
}

/// The bytes of the vademecum file that a command makes another one of, once that may be written, and the
/// outputs to write it with. `others` are read too.
pub(crate) fn open_pair(
    arguments: &OutputArguments,
    file: &Path,
    others: &[Option<&Path>],
    output: &Path,
) -> Result<(Outputs, Vec<u8>), Failure> {
    let outputs = outputs(arguments, &[&[Some(file)], others].concat(), None);
    check_output(&outputs, output, Kind::Vademecum)?;
    Ok((outputs, read_file(file)?))
}

/// Writes bytes whole or not at all.
pub fn write_bytes(outputs: &Outputs, path: &Path, kind: Kind, bytes: &[u8]) -> Result<(), Failure> {
    Ok(outputs.write(path, kind, |out| out.write_all(bytes))?)
}

/// Writes a text that belongs to the program: a file that holds it already stays, and no other of its name is
/// replaced.
pub(crate) fn write_own(outputs: &Outputs, path: &Path, text: &str) -> Result<(), Failure> {
    if holds(path, text) { Ok(()) } else { write_bytes(outputs, path, Kind::Own, text.as_bytes()) }
}

/// Refuses what [`write_own`] could not write.
pub(crate) fn check_own(outputs: &Outputs, path: &Path, text: &str) -> Result<(), Failure> {
    if holds(path, text) { Ok(()) } else { Ok(outputs.check(&[(path.to_path_buf(), Kind::Own)])?) }
}

fn holds(path: &Path, text: &str) -> bool {
    let is_file =
        std::fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() == text.len() as u64);
    is_file && std::fs::read(path).is_ok_and(|found| found == text.as_bytes())
}

/// Writes a picture.
pub fn write_picture(outputs: &Outputs, path: &Path, drawn: DrawResult) -> Result<String, Failure> {
    let svg = drawn
        .map_err(|error| Failure::new(Cause::Numerics, format!("{}: not drawn: {error}", path.display())))?;
    write_bytes(outputs, path, Kind::Svg, svg.as_bytes())?;
    Ok(svg)
}

/// Kind of a chart, by the end of its name: PDF or, of any other name, SVG.
pub(crate) fn chart_kind(path: &Path) -> Kind {
    let is_pdf = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("pdf"));
    if is_pdf { Kind::Pdf } else { Kind::Svg }
}

/// Writes a chart as its name says.
pub(crate) fn write_chart(outputs: &Outputs, path: &Path, drawn: Drawn) -> Result<(), Failure> {
    let failed = |error| Failure::new(Cause::Numerics, format!("{}: not drawn: {error}", path.display()));
    let picture = drawn.map_err(failed)?;
    match chart_kind(path) {
        Kind::Pdf => write_bytes(outputs, path, Kind::Pdf, &picture.pdf()),
        kind => write_bytes(outputs, path, kind, picture.svg().as_bytes()),
    }
}

/// A file for as long as the command runs: copied, so that nothing that becomes of it on the disk matters.
pub(crate) fn open(path: &Path) -> Result<Mapped, Failure> {
    refuse_irregular(path)?;
    recognised(path, Mapped::copy(path))
}

/// The file copied into memory, or mapped if the user asks for it.
///
/// # Errors
/// [`Failure`]: a file that cannot be read, or is no vademecum file.
pub fn open_or_map(path: &Path, map: bool) -> Result<Mapped, Failure> {
    if !map {
        return open(path);
    }
    refuse_irregular(path)?;
    // SAFETY: `--map` says what the user promises with it: nobody shortens or overwrites the file.
    #[allow(unsafe_code)]
    let mapped = unsafe { Mapped::map(path) };
    recognised(path, mapped)
}

/// Refuses other than regular files before they are read: reading a FIFO would block.
fn refuse_irregular(path: &Path) -> Result<(), Failure> {
    open_regular(path).map(drop).map_err(|error| unreadable(path, Some(&error)))
}

/// The opened file, if it is a vademecum file.
fn recognised(path: &Path, opened: Result<Mapped, OpenError>) -> Result<Mapped, Failure> {
    let mapped = opened.map_err(|error| unreadable(path, error.source()))?;
    recognise(path, mapped.bytes())?;
    Ok(mapped)
}

/// The file of a map with every section raw for which `wanted` holds, every section compared with its
/// checksum, and every index with what it counts: a program reads most of it anyway, and a damaged basis
/// would pass for physics. What is packed is decoded into `memory`, with the wanted sections only.
pub(crate) fn usable_file<'a>(
    path: &Path,
    mapped: &'a impl AsRef<[u8]>,
    wanted: impl Fn(SectionKind) -> bool,
    limit: Limit,
    memory: &'a mut Vec<u8>,
) -> Result<File<'a>, Failure> {
    usable_bytes(path, mapped.as_ref(), wanted, limit, memory)
}

/// A file of bytes that lie in memory already, decoded where it is packed.
///
/// # Errors
/// [`Failure`]: bytes that are no vademecum file, a damaged one, or one that unpacks to more than `limit`.
pub fn usable_bytes<'a>(
    path: &Path,
    bytes: &'a [u8],
    wanted: impl Fn(SectionKind) -> bool,
    limit: Limit,
    memory: &'a mut Vec<u8>,
) -> Result<File<'a>, Failure> {
    let failed = |error: FormatError| Failure::file(path, error).remedy(DAMAGED);
    let file = File::parse(bytes).map_err(failed)?;
    file.verify_all().map_err(failed)?;
    let packed = |section: &Section<'_>| section.codec() != Codec::Raw && wanted(section.kind());
    if file.sections().any(|section| packed(&section)) {
        let unpacked = vademecum_rewrite::unpack_wanted(&file, &wanted, limit.of(bytes.len()));
        *memory = unpacked.map_err(|error| Failure::file(path, error))?;
        let file = File::parse(memory).map_err(failed)?;
        file.verify_indices().map_err(failed)?;
        return Ok(file);
    }
    Ok(file)
}

/// Modes of a parametric model that are stepped unless asked otherwise, where dashpots couple them: a step
/// then takes all of them together.
const COUPLED_MODES: usize = 128;

/// The body of a parametric model at values of its parameters, with all its modes, or [`COUPLED_MODES`],
/// unless others are asked for; `None` of any other file.
///
/// # Errors
/// [`StudyError`]: a parameter that there is not, a value outside of its range, more modes than there are.
pub(crate) fn at_values(
    file: &File<'_>,
    settings: &[ParameterValue],
    modes: Option<usize>,
) -> Result<Option<BodyAtValues>, StudyError> {
    let all = file.metadata().n_modes as usize;
    let coupled = file.section(SectionKind::DampingRows).is_some();
    let usual = if coupled { all.min(COUPLED_MODES) } else { all };
    let body = live::at_values(file, settings, Some(modes.unwrap_or(usual)))?;
    if body.is_none() && modes.is_some() {
        return Err(ParametricError::NotParametric.into());
    }
    Ok(body)
}

/// The file that is stepped, and what is still to be set of it: of a parametric model the body at its values,
/// and nothing.
///
/// # Errors
/// [`StudyError::Format`]: none but of bytes that are no file.
pub(crate) fn to_step<'a>(
    file: File<'a>,
    settings: &'a [ParameterValue],
    body: Option<&'a BodyAtValues>,
) -> Result<(File<'a>, &'a [ParameterValue]), StudyError> {
    match body {
        None => Ok((file, settings)),
        Some(body) => Ok((File::parse(&body.bytes)?, &[])),
    }
}

/// True of sections that stepping and showing the motion read; the others are for people.
pub fn is_stepped(kind: SectionKind) -> bool {
    use SectionKind as S;
    let for_people = [
        S::SingularValues,
        S::ModeTable,
        S::EnrichmentHistory,
        S::RadiusSamples,
        S::Losses,
        S::Repairs,
        S::MeshError,
    ];
    !for_people.contains(&kind)
}

/// A vademecum file that cannot be read, for the system's reason.
fn unreadable(path: &Path, reason: Option<&(dyn Error + 'static)>) -> Failure {
    let text = reason.map_or_else(|| "it cannot be read".to_string(), ToString::to_string);
    let failure = Failure::new(Cause::File, text).about(path);
    let system = reason.and_then(|reason| reason.downcast_ref::<std::io::Error>());
    let absent = system.is_some_and(|error| error.kind() == std::io::ErrorKind::NotFound);
    if absent { failure.remedy(UNREAD) } else { failure }
}

/// Refuses a file that is no vademecum at all, with a guess what it is instead.
fn recognise(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if is_vademecum(bytes) {
        return Ok(());
    }
    let looks = look_at(path, bytes);
    let text = format!("this is not a vademecum file: {}", looks.words());
    Err(Failure::new(Cause::File, text).about(path).remedy(instead(looks)))
}

/// Remedy for a file that is no vademecum.
fn instead(looks: Looks) -> &'static str {
    match looks {
        Looks::Problem => "`vademecum build PROBLEM -o FILE` makes a vademecum file of it",
        Looks::Scenario => "give the vademecum file first, and the scenario with `--scenario`",
        Looks::Assembly => {
            "`vademecum assemble ASSEMBLY -o FILE` makes a vademecum file of it; `run`, `frf`, `view`, `report` and \
             `export fmu` take it as it is"
        }
        Looks::Mesh => {
            "`vademecum init MESH` writes a problem file for the mesh, and `vademecum build` a vademecum file of that"
        }
        Looks::Solid => "mesh its volume first; `vademecum init MESH` goes on from there",
        _ => "give a file that `vademecum build` has written",
    }
}

/// Refuses a file of the chapter's representation where contacts anywhere or free states are needed.
pub(crate) fn refuse_chapter(path: &Path, file: &File<'_>, what: &str) -> Result<(), Failure> {
    if file.section(SectionKind::CanonicalParts).is_none() {
        return Ok(());
    }
    let text = format!("{what} does not know the chapter's representation, whose axes end");
    let remedy = "use `run`, `verify` or `info`, or build it without `representation`";
    Err(Failure::new(Cause::File, text).about(path).remedy(remedy))
}

/// All bytes of a vademecum file, copied.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = read_regular(path).map_err(|error| unreadable(path, Some(&error)))?;
    recognise(path, &bytes)?;
    Ok(bytes)
}

/// A file that was made of another one.
#[derive(serde::Serialize)]
pub(crate) struct RewriteOutput {
    /// Its path.
    pub(crate) file: String,
    /// Its length.
    pub(crate) bytes: usize,
    /// Length of the one it was made of.
    pub(crate) bytes_before: usize,
}

impl RewriteOutput {
    /// As JSON or as a line of text.
    pub(crate) fn print(&self, json: bool) {
        if json {
            return print_json(self);
        }
        println!("{}: {} bytes, {} before", self.file, self.bytes, self.bytes_before);
    }
}

/// Writes a vademecum file whole or not at all, and tells how large it has become.
pub(crate) fn write_file(
    outputs: &Outputs,
    path: &Path,
    bytes: &[u8],
    before: usize,
) -> Result<RewriteOutput, Failure> {
    write_bytes(outputs, path, Kind::Vademecum, bytes)?;
    Ok(RewriteOutput { file: path.display().to_string(), bytes: bytes.len(), bytes_before: before })
}

/// Writes displacement fields of the nodes of a mesh, one name for each.
pub(crate) fn write_fields(
    outputs: &Outputs,
    path: &Path,
    mesh: &Mesh,
    names: &[String],
    fields: &[Vec<f64>],
) -> Result<(), Failure> {
    let fields = names.iter().zip(fields);
    let data: Vec<(&str, &[f64], usize)> =
        fields.map(|(name, field)| (name.as_str(), field.as_slice(), 3)).collect();
    let cells = Cells::Elements(&mesh.kinds, &mesh.elements);
    Ok(outputs.write(path, Kind::Vtu, |out| vtu_into(out, &mesh.nodes, cells, &data))?)
}
