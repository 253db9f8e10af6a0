//! `vademecum report`: one page that shows a build to someone who did not make it, with its figures beside
//! it.

mod build_times;
mod content;
mod figures;
mod page;
mod separation_figures;
mod words;

use std::path::{Path, PathBuf};

use vademecum_build::input::Problem;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_build::store::{Kind, goes_through};
use vademecum_eval::SceneOptions;
use vademecum_format::File;
use vademecum_study::contents::{figures, mode_table};
use vademecum_study::free_run::free_run;
use vademecum_study::player::{PlayOptions, elastic, structure_name, with_body};
use vademecum_study::scenario::Scenario;
use vademecum_study::separation::{enrichment_history, radius_samples, repairs};
use vademecum_study::timings::timings;
use vademecum_study::verify::{AnyVerification, verify};
use vademecum_study::{FileError, StudyError};

use self::build_times::BuildTimes;
use self::content::Content;
use self::figures::Figures;
use crate::arguments::{Limit, OutputArguments};
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{check_output, outputs, refuse_chapter, usable_file, write_bytes};
use crate::given::Given;
use crate::html::title;
use crate::print::print_json;

/// Writes a page about a file: body, basis, modes, certificate, energy, parameters, make-up, timings.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum report body.vdm -o report.html
  vademecum report body.vdm --problem body.toml --scenario push.toml    with the full-order march beside it
  vademecum build body.toml -o body.vdm --json > build.json && vademecum report body.vdm --build build.json
The figures are written as SVG files too, into the folder `report-figures` beside `report.html`.")]
pub(crate) struct Report {
    /// The vademecum file, or an assembly file (TOML), which is joined in memory.
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
    /// Output of `build --json` for this file: adds the times of the build.
    #[arg(long)]
    build: Option<PathBuf>,
    /// Measure the times of the online work on this machine and show them. Without it the page is the same
    /// every time.
    #[arg(long)]
    timings: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
    #[command(flatten)]
    limit: Limit,
}

/// Report of the written page.
#[derive(serde::Serialize)]
struct ReportOutput {
    page: String,
    bytes: usize,
    figures: usize,
    /// None where the figures are in the page alone.
    figures_folder: Option<String>,
}

/// Figures of every report.
const FIGURES: [(&str, Kind); 4] = [
    ("mesh.svg", Kind::Svg),
    ("shape-1.svg", Kind::Svg),
    ("free-run.svg", Kind::Svg),
    ("file.svg", Kind::Svg),
];

/// Writes the page of a file, as `vademecum report` does, with the figures beside it; `compared` is the
/// problem and the scenario of a comparison with the full order.
///
/// # Errors
/// [`Failure`].
pub fn report(
    file: &Path,
    output: &Path,
    compared: Option<[PathBuf; 2]>,
    listener: &dyn Listener,
) -> Result<(), Failure> {
    let [problem, scenario] = compared.map_or([None, None], |both| both.map(Some));
    let report = Report {
        file: file.into(),
        output: output.into(),
        problem,
        scenario,
        build: None,
        timings: false,
        json: false,
        outputs: OutputArguments { force: false },
        limit: Limit::default(),
    };
    report.write(listener).map(drop)
}

impl Report {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let written = self.write(console)?;
        console.clear();
        if self.json {
            print_json(&written);
        } else {
            let at = written.figures_folder.as_ref().map_or("inside".into(), |folder| format!("in {folder}"));
            println!("{}: {} bytes; {} figures {at}", written.page, written.bytes, written.figures);
        }
        Ok(())
    }

    /// Writes the page and its figures.
    fn write(&self, console: &dyn Listener) -> Result<ReportOutput, Failure> {
        let compared = self.compared()?;
        let inputs = [Some(&self.file), self.problem.as_ref(), self.scenario.as_ref(), self.build.as_ref()];
        let inputs = inputs.map(|path| path.map(PathBuf::as_path));
        let given = Given::look(&self.file)?;
        let parts = given.parts();
        let inputs: Vec<_> =
            inputs.into_iter().chain(parts.iter().map(|part| Some(part.as_path()))).collect();
        let outputs = outputs(&self.outputs, &inputs, compared.as_ref().map(|(problem, _)| problem));
        check_output(&outputs, &self.output, Kind::Html)?;
        let folder = self.output.with_file_name(format!(
            "{}-figures",
            self.output.file_stem().unwrap_or_default().to_string_lossy()
        ));
        if !goes_through(&self.output) {
            outputs.check_in(&folder, &FIGURES)?;
        }
        let mapped = given.open(&self.file, false, console)?;
        let mut memory = vec![];
        let file = usable_file(&self.file, &mapped, |_| true, self.limit, &mut memory)?;
        refuse_chapter(&self.file, &file, "the report")?;
        let stored = mapped.file().map_err(|error| Failure::file(&self.file, error))?;
        let bytes = mapped.bytes().len();
        let build = self.build.as_ref().map(|path| BuildTimes::read(path, bytes)).transpose()?;
        let about = |error: StudyError| Failure::from(error).about(&self.file);
        let unread = |error: FileError| Failure::file(&self.file, error);
        let modes = mode_table(&file).map_err(unread)?;
        let structure = with_body::<f64, _>(&file, &elastic(&SceneOptions::default()), |body| {
            Ok(structure_name(body.structure()))
        });
        let structure = structure.map_err(about)?;
        let timings = if self.timings {
            console.stage("measure");
            Some(timings(&self.file, &file).map_err(about)?)
        } else {
            None
        };
        console.stage("free run");
        let quotients: Vec<f64> = modes.iter().map(|mode| mode.rayleigh_quotient).collect();
        let free = free_run(&file, &quotients).map_err(about)?;
        let verified = self.compare(compared, &file, console)?;
        let content = Content {
            title: title(&self.file, &file),
            command: self.command(),
            path: &self.file,
            bytes,
            file: &file,
            stored: &stored,
            modes,
            structure,
            timings,
            free,
            verified,
            history: enrichment_history(&file).map_err(unread)?,
            radii: radius_samples(&file).map_err(unread)?,
            figures: figures(&file).map_err(unread)?,
            repairs: repairs(&file).map_err(unread)?,
            build,
        };

        console.stage("draw");
        let figures = Figures::draw(&content)?;
        let page = page::page(&content, &figures);
        let beside = !goes_through(&self.output);
        if beside {
            outputs.make_folder(&folder)?;
            figures.write(&outputs, &folder)?;
        }
        write_bytes(&outputs, &self.output, Kind::Html, page.as_bytes())?;
        Ok(ReportOutput {
            page: self.output.display().to_string(),
            bytes: page.len(),
            figures: figures.len(),
            figures_folder: beside.then(|| folder.display().to_string()),
        })
    }

    /// The command that writes this page.
    fn command(&self) -> String {
        let given = [("--problem", &self.problem), ("--scenario", &self.scenario), ("--build", &self.build)];
        let given = given
            .into_iter()
            .filter_map(|(name, path)| Some(format!(" {name} {}", path.as_ref()?.display())));
        let given: String = given.collect();
        format!("vademecum report {}{given} -o {}", self.file.display(), self.output.display())
    }

    /// The problem and the scenario to compare on, if they are given.
    fn compared(&self) -> Result<Option<(Problem, Scenario)>, Failure> {
        let (Some(problem), Some(scenario)) = (&self.problem, &self.scenario) else { return Ok(None) };
        Ok(Some((Problem::read(problem)?, Scenario::read(scenario)?)))
    }

    /// The full-order march beside the file's.
    fn compare(
        &self,
        compared: Option<(Problem, Scenario)>,
        file: &File<'_>,
        console: &dyn Listener,
    ) -> Result<Option<AnyVerification>, Failure> {
        let Some((problem, scenario)) = compared else { return Ok(None) };
        let prepared = prepare(&problem, &mut Stopwatch::new(console), console)?;
        let verified = verify(file, &PlayOptions::default(), &problem, &prepared, &scenario, console);
        verified.map(Some).map_err(|error| Failure::from(error).about(&self.file))
    }
}
