//! `vademecum report`: one page that shows a build to someone who did not make it, with its figures beside
//! it.

mod build_times;
mod content;
mod figures;
mod page;
mod separation_figures;
mod words;

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_build::store::write_atomic;
use vademecum_format::File;
use vademecum_study::contents::mode_table;
use vademecum_study::free_run::free_run;
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::Scenario;
use vademecum_study::separation::{enrichment_history, radius_samples, repairs};
use vademecum_study::timings::timings;
use vademecum_study::verify::{Verified, verify};
use vademecum_study::{FileError, StudyError};

use self::build_times::BuildTimes;
use self::content::Content;
use self::figures::Figures;
use crate::arguments::Limit;
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{make_folder, open, refuse_canonical, usable_file};
use crate::html::title;

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
    #[command(flatten)]
    limit: Limit,
}

impl Report {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        let mapped = open(&self.file, false)?;
        let mut memory = vec![];
        let file = usable_file(&self.file, &mapped, |_| true, self.limit, &mut memory)?;
        refuse_canonical(&self.file, &file, "the report")?;
        let stored = mapped.file().map_err(|error| Failure::file(&self.file, error))?;
        let bytes = mapped.bytes().len();
        let build = self.build.as_ref().map(|path| BuildTimes::read(path, bytes)).transpose()?;
        let about = |error: StudyError| Failure::from(error).about(&self.file);
        let unread = |error: FileError| Failure::file(&self.file, error);
        let modes = mode_table(&file).map_err(unread)?;
        console.stage("measure");
        let timings = timings(&self.file, &file).map_err(about)?;
        console.stage("free run");
        let quotients: Vec<f64> = modes.iter().map(|mode| mode.rayleigh_quotient).collect();
        let free = free_run(&file, &quotients).map_err(about)?;
        let verified = self.compare(&file, console)?;
        let content = Content {
            title: title(&self.file, &file),
            path: &self.file,
            bytes,
            file: &file,
            stored: &stored,
            modes,
            timings,
            free,
            verified,
            history: enrichment_history(&file).map_err(unread)?,
            radii: radius_samples(&file).map_err(unread)?,
            repairs: repairs(&file).map_err(unread)?,
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
        let verified = verify(file, &PlayOptions::default(), &problem, &prepared, &scenario, console);
        verified.map(Some).map_err(|error| Failure::from(error).about(&self.file))
    }
}
