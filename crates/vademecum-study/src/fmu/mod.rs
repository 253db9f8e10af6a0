//! A vademecum file as an FMU: one archive with a model description, the library of the crate
//! `vademecum-fmu`, the file and a table of named points.
//!
//! The list of variables is that of [`vademecum_fmu::variables`], which the library itself goes by. Points
//! are located on the loadable surface here, once, so that an instance searches nothing.

mod archive;
mod description;
mod error;
mod points;
mod surface;
mod terminals;
mod variable;
mod version;
mod xml;

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_eval::{BodyOptions, LiveMemory, Precision, RigidBody, SceneOptions};
use vademecum_fmu::points::{Point, StressPlace, table};
use vademecum_fmu::token::token;
use vademecum_fmu::variables::{Counts, Variable, is_exact, is_linear};
use vademecum_format::{File, SectionKind};

use crate::contents::lines;
use description::Description;
use variable::{VariableDescription, VariableNames};

use archive::Files;
pub use archive::{Library, LibraryError};
pub use error::FmuError;
pub use points::{NamedPoint, PlacedPoint, PlacedStress};
pub use surface::{ArrayRows, SurfaceNodes};
pub use version::FmiVersion;

/// Contents of an FMU beside the file.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// Version of the interface.
    pub version: FmiVersion,
    /// Name of the model; what of it is no letter or digit becomes `_` in the name of the library.
    pub name: &'a str,
    /// Named points; without any, the places of the file's probes that lie on the loadable surface.
    pub points: &'a [NamedPoint],
    /// Named places whose equivalent stress is reported: the nearest nodes that the file knows the stress of.
    pub stresses: &'a [NamedPoint],
    /// Nodes of the arrays, of FMI 3.
    pub surface: SurfaceNodes,
    /// Their first dimension.
    pub rows: ArrayRows,
    /// One library for each platform.
    pub libraries: &'a [Library],
}

/// An FMU.
#[derive(Clone, Debug)]
pub struct Fmu {
    /// The bytes of the archive.
    pub archive: Vec<u8>,
    /// Its named points.
    pub points: Vec<PlacedPoint>,
    /// The places of its stresses.
    pub stresses: Vec<PlacedStress>,
    /// Nodes of its arrays.
    pub surface_nodes: usize,
    /// Names of its inputs.
    pub inputs: Vec<String>,
    /// Names of its outputs.
    pub outputs: Vec<String>,
    /// Names of its tunable parameters.
    pub parameters: Vec<String>,
    /// Internal step \[s\].
    pub internal_step: f64,
}

/// Makes an FMU of a file whose sections are raw.
///
/// # Errors
/// [`FmuError`].
pub fn export(bytes: &[u8], request: &Request<'_>) -> Result<Fmu, FmuError> {
    let file = File::parse(bytes)?;
    let points = points::place(&file, request.points)?;
    // What the instance will do with it, so that a file that cannot be stepped is refused here.
    let surface = surface::place_surface(&file, request.surface, request.version)?;
    let options = vademecum_fmu::options(&file, points.len(), surface.len());
    let of_body = BodyOptions { scene: options, places: 0, ..BodyOptions::default() };
    let mut memory = vec![0.0; LiveMemory::any_len(&file, &of_body, Precision::Double)?];
    let (_, body) = LiveMemory::bind_any(&file, &of_body, Precision::Double, &mut memory)?;
    let internal_step = body.time_step();

    let rows: Vec<Point<'_>> = points.iter().map(PlacedPoint::row).collect();
    let stresses = points::place_stresses(&file, request.stresses)?;
    let stress_rows: Vec<StressPlace<'_>> = stresses.iter().map(PlacedStress::row).collect();
    let found = rows.len().max(stress_rows.len());
    let table = table(&rows, &surface, &stress_rows).ok_or(FmuError::TooManyPoints { found })?;
    let variables = variables(&file, &points, &stresses, (surface.len(), request.rows), &options)?;
    let token = token(bytes, &table);
    let identifier = archive::identifier(request.name);
    let description = Description {
        version: request.version,
        name: request.name,
        identifier: &identifier,
        token: std::str::from_utf8(&token).unwrap_or_default(),
        metadata: file.metadata(),
        internal_step,
        any_step: is_exact(&file),
        linear: is_linear(&file),
        bends_far: file.section(SectionKind::StrainLimits).is_some(),
        title: title(&file),
        variables: &variables,
    };
    let names: Vec<String> = points.iter().map(|point| point.name.clone()).collect();
    let terminals = match request.version {
        FmiVersion::Two => None,
        FmiVersion::Three => terminals::terminals(&variables, &names),
    };
    let files = Files { description, terminals, vademecum: bytes, points: &table };
    let archive = archive::write(&files, request.libraries)?;
    let names = |wanted: fn(Variable) -> bool| {
        let of_kind = variables.iter().filter(|described| wanted(described.variable));
        of_kind.map(|described| described.name.clone()).collect()
    };
    use Variable as V;
    Ok(Fmu {
        archive,
        inputs: names(|variable| variable.is_input()),
        outputs: names(Variable::is_output),
        parameters: names(|variable| matches!(variable, V::Parameter(_) | V::Whole(_))),
        points,
        stresses,
        surface_nodes: surface.len(),
        internal_step,
    })
}

/// Title of the problem that the file keeps; empty if it has none, or this program no longer reads it.
fn title(file: &File<'_>) -> String {
    let problem = Problem::parse(file.metadata().problem, "the problem in the file", PathBuf::new());
    problem.map(|problem| problem.title).unwrap_or_default()
}

/// All variables, named and described, in the order of their references.
fn variables(
    file: &File<'_>,
    points: &[PlacedPoint],
    stresses: &[PlacedStress],
    (surface, rows): (usize, ArrayRows),
    options: &SceneOptions,
) -> Result<Vec<VariableDescription>, FmuError> {
    let counts = Counts::of(file, points.len() as u32, stresses.len() as u32, surface as u32);
    let any_step = counts.exact != 0;
    let named = VariableNames {
        points: points.iter().map(|point| point.name.clone()).collect(),
        stresses: stresses.iter().map(|place| place.name.clone()).collect(),
        patterns: lines(file, SectionKind::PatternNames)?,
        probes: lines(file, SectionKind::ProbeNames)?,
        supports: lines(file, SectionKind::SupportNames)?,
        probe_units: lines(file, SectionKind::ProbeUnits)?,
        file,
        body: RigidBody::of(file),
        any_step,
        surface: counts.surface,
        surface_reference: match rows {
            ArrayRows::Structural => counts.reference(Variable::SurfaceNodes),
            ArrayRows::Fixed => None,
        },
    };
    let named = |(reference, variable)| variable::describe(reference, variable, &named, options);
    let all: Vec<VariableDescription> = (0..).zip(counts.all()).filter_map(named).collect();
    let mut names: Vec<&str> = all.iter().map(|described| described.name.as_str()).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(FmuError::NameTwice { name: pair[0].to_string() }),
        None => Ok(all),
    }
}
