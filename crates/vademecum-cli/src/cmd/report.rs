//! `vademecum report`: one page that shows a build to someone who did not make it, with its figures beside it.

mod build_times;
mod figures;
mod measure;
mod page;
mod separation_figures;

use std::path::{Path, PathBuf};

use vademecum_build::input::Problem;
use vademecum_build::parametric::RadiusSample;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_build::store::write_atomic;
use vademecum_eval::Mapped;
use vademecum_format::{File, SectionKind};
use vademecum_study::scenario::Scenario;

use self::build_times::BuildTimes;
use self::figures::Figures;
use self::measure::{FreeRun, Timings};
use super::verify::{Verified, verify};
use super::view::title;
use super::{make_folder, refuse_canonical};
use crate::console::Console;
use crate::failure::Failure;
use crate::player::PlayOptions;
use crate::separation::{Enrichment, enrichment_history, radius_samples, repairs};

/// Writes a page about a file: body, basis, modes, certificate, energy, parameters, make-up, timings.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum report body.vdm -o report.html
  vademecum report body.vdm --problem body.toml --scenario push.toml    with the full-order march beside it
  vademecum build body.toml -o body.vdm --json > build.json && vademecum report body.vdm --build build.json
The figures are written as SVG files too, into the folder `report-figures` beside `report.html`.")]
pub struct Report {
    /// The vademecum file.
    file: PathBuf,
    /// The page.
    #[arg(short, long, default_value = "report.html")]
    output: PathBuf,
    /// The problem it was built from; with `--scenario`, the full-order model is marched and compared.
    #[arg(long, requires = "scenario")]
    problem: Option<PathBuf>,
    /// The scenario to compare on.
    #[arg(long, requires = "problem")]
    scenario: Option<PathBuf>,
    /// What `build --json` printed for this file: shows what the build took.
    #[arg(long)]
    build: Option<PathBuf>,
}

/// Everything the page shows.
struct Content<'a> {
    title: String,
    path: &'a Path,
    bytes: usize,
    file: &'a File<'a>,
    modes: Vec<[f64; 6]>,
    timings: Timings,
    free: FreeRun,
    verified: Option<Verified>,
    history: Vec<Enrichment>,
    radii: Vec<RadiusSample>,
    repairs: Vec<String>,
    build: Option<BuildTimes>,
}

impl Report {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        let mapped = Mapped::open(&self.file).map_err(|error| Failure::file(&self.file, error))?;
        let file = mapped.file().map_err(|error| Failure::file(&self.file, error))?;
        refuse_canonical(&self.file, &file, "the report")?;
        let modes = mode_table(&self.file, &file)?;
        let bytes = mapped.bytes().len();
        let build = self.build.as_ref().map(|path| BuildTimes::read(path, bytes)).transpose()?;
        console.stage("measure");
        let timings = measure::timings(&self.file, &file)?;
        console.stage("free run");
        let lambdas: Vec<f64> = modes.iter().map(|mode| mode[1]).collect();
        let free = measure::free_run(&self.file, &file, &lambdas)?;
        let verified = self.compare(&file, console)?;
        let title = title(&self.file, &file);
        let content = Content {
            title,
            path: &self.file,
            bytes,
            file: &file,
            modes,
            timings,
            free,
            verified,
            history: enrichment_history(&self.file, &file)?,
            radii: radius_samples(&self.file, &file)?,
            repairs: repairs(&self.file, &file)?,
            build,
        };

        console.stage("draw");
        let folder = self.output.with_file_name(format!(
            "{}-figures",
            self.output.file_stem().unwrap_or_default().to_string_lossy()
        ));
        make_folder(&folder)?;
        let figures = Figures::draw(&folder, &content)?;
        let page = page::page(&content, &figures);
        write_atomic(&self.output, page.as_bytes()).map_err(|error| Failure::io(&self.output, error))?;
        console.clear();
        println!(
            "{}: {} bytes; {} figures in {}",
            self.output.display(),
            page.len(),
            figures.len(),
            folder.display()
        );
        Ok(())
    }

    /// The full-order march beside the file's, if a problem and a scenario are given.
    fn compare(&self, file: &File<'_>, console: &Console) -> Result<Option<Verified>, Failure> {
        let (Some(problem), Some(scenario)) = (&self.problem, &self.scenario) else { return Ok(None) };
        let (problem, scenario) = (Problem::read(problem)?, Scenario::read(scenario)?);
        let prepared = prepare(&problem, &mut Stopwatch::new(console), console)?;
        verify(&self.file, file, &PlayOptions::default(), &problem, &prepared, &scenario, console).map(Some)
    }
}

/// Rows of the mode table: frequency \[Hz\], Rayleigh quotient \[rad²/s²\], energy share, physical damping, numerical damping,
/// period elongation.
fn mode_table(path: &Path, file: &File<'_>) -> Result<Vec<[f64; 6]>, Failure> {
    let values = numbers(path, file, SectionKind::ModeTable)?;
    Ok(values.as_chunks().0.to_vec())
}

/// Numbers of a section; none if the file does not have it.
fn numbers(path: &Path, file: &File<'_>, kind: SectionKind) -> Result<Vec<f64>, Failure> {
    let Some(section) = file.section(kind) else { return Ok(vec![]) };
    Ok(section.numbers().map_err(|error| Failure::file(path, error))?.iter().collect())
}
