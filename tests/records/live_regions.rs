//! Separated and parametric steps of one body cut into more and more live regions: the table of
//! `docs/measurements/parameters.md`.
//!
//! ```text
//! cargo run --release -p vademecum-tests --example live_regions -- [--regions 1,2,3,4,6,8,16] [--minutes 30]
//!     [--points 8] [-o FOLDER]
//! ```
//!
//! A build that takes longer than `--minutes` is stopped, and its row says so. Errors are those of
//! [`LivePoint`] at as many random points and corners as `--points` says, the same for both, all modes of a
//! parametric basis stepped. FOLDER takes the matrices of the body with the most regions, and its points, for
//! `docs/measurements/peers/live`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::input::{Problem, ProblemError};
use vademecum_build::pipeline::{BuildError, BuildOptions, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Listener, Silent, Stopwatch, is_cancelled};
use vademecum_eval::{Parametric, Scene, SceneOptions, State, StructureChoice};
use vademecum_format::File;
use vademecum_study::timings::timings;
use vademecum_tests::live_point::LivePoint;
use vademecum_tests::synthetic::Random;

/// Changes of the parameters that are timed; the median counts.
const CHANGES: usize = 51;

/// A listener that stops the work at a time.
struct Until(Instant);

impl Listener for Until {
    fn stage(&self, _: &str) {}
    fn advance(&self, _: usize, _: usize) {}
    fn note(&self, _: &str) {}
    fn cancelled(&self) -> bool {
        Instant::now() > self.0
    }
}

fn main() {
    let mut regions: Vec<usize> = vec![1, 2, 3, 4, 6, 8, 16];
    let (mut minutes, mut points, mut folder) = (30.0, 8, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let value = arguments.next().expect("a value");
        match argument.as_str() {
            "--regions" => regions = value.split(',').map(|n| n.parse().expect("a number")).collect(),
            "--minutes" => minutes = value.parse().expect("minutes"),
            "--points" => points = value.parse().expect("a number"),
            _ => folder = Some(PathBuf::from(value)),
        }
    }
    println!(
        "| regions | step | vectors or terms | build \\[s\\] | file \\[MB\\] | set \\[µs\\] | a step \\[ns\\] | worst error, random points | corners |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let most = regions.iter().copied().max().unwrap_or(0);
    for count in regions {
        let mut drawn = None;
        for representation in ["parametric", "separated"] {
            let limit = Until(Instant::now() + Duration::from_secs_f64(60.0 * minutes));
            let row = row(count, representation, &limit, points, &mut drawn);
            println!("| {count} | {representation} | {row} |");
        }
        if let (Some(folder), true, Some(drawn)) = (&folder, count == most, drawn) {
            write(folder, count, &drawn);
        }
    }
}

/// First natural frequency of the block as built \[Hz\], whose fortieth of a period is the step.
const FIRST_HZ: f64 = 1.006;

/// A block of 3 360 dofs cut across into equal regions, whose stiffness is live over [1/3, 3], and Δt over a
/// factor 4; one live region is half of it.
fn problem(count: usize, representation: &str) -> Result<Problem, ProblemError> {
    let mut text = format!(
        "representation = \"{representation}\"\n[mesh]\n\
         block = {{ lengths = [1.0, 0.3, 0.2], divisions = [16, 3, 2], order = \"quadratic\" }}\n"
    );
    let cut = count.max(2);
    for region in 1..cut {
        let share = 1.0 - region as f64 / cut as f64;
        let _ = writeln!(
            text,
            "[[mesh.region]]\nname = \"r{region}\"\n\
             on = {{ fraction = {{ axis = \"x\", side = \"max\", fraction = {share:.12} }} }}"
        );
    }
    text += "[[material]]\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n[damping]\nbeta = 1e-3\n\
             [[support]]\non = { group = \"x_min\" }\n[load]\nsurface = { group = \"z_max\" }\n[time]\n";
    let step = 0.025 / FIRST_HZ;
    let _ = writeln!(text, "step = {step:e}");
    if representation == "separated" {
        text += "[basis]\nmodes = 16\n[tolerance]\nmap = 1e-5\nmax_terms = 1000\n";
    }
    for region in 0..count {
        let name = if region == 0 { "body".into() } else { format!("r{region}") };
        let _ = writeln!(
            text,
            "[[parameter]]\nname = \"k{region}\"\nkind = \"stiffness\"\nregion = \"{name}\"\n\
             range = [0.3333333333, 3.0]\nscale = \"log\""
        );
    }
    let _ = writeln!(
        text,
        "[[parameter]]\nname = \"step\"\nkind = \"time-step\"\nrange = [{:e}, {:e}]\nscale = \"log\"",
        0.5 * step,
        2.0 * step
    );
    Problem::parse(&text, "block.toml", PathBuf::new())
}

/// The row of a build, or why there is none. The points are drawn for the first file.
fn row(
    count: usize,
    representation: &str,
    limit: &Until,
    points: usize,
    drawn: &mut Option<Vec<LivePoint>>,
) -> String {
    let problem = match problem(count, representation) {
        Ok(problem) => problem,
        Err(error) => return format!("refused: {error} | | | | | | |"),
    };
    let start = Instant::now();
    let built = match build(&problem, &BuildOptions::default(), limit) {
        Ok(built) => built.either(),
        Err(error) => return refused(&error, start.elapsed()),
    };
    let seconds = start.elapsed().as_secs_f64();
    let file = File::parse(&built.bytes).expect("a file");
    let parametric = Parametric::new(&file).ok();
    let size = match (&parametric, file.metadata().n_terms) {
        (Some(model), _) => model.n_basis(),
        (None, terms) => terms as usize,
    };
    let drawn = drawn.get_or_insert_with(|| {
        let mut dice = Random::new(1);
        (0..2 * points).map(|k| LivePoint::draw(&problem, &file, k >= points, &mut dice)).collect()
    });
    let modes = parametric.as_ref().map_or(0, Parametric::n_basis);
    let errors: Vec<f64> = drawn.iter().map(|point| point.errors(&problem, &file, modes)[0]).collect();
    let [random, corners] =
        [&errors[..points], &errors[points..]].map(|own| own.iter().copied().fold(0.0, f64::max));
    let [set, step] =
        [seconds_to_set(&file, parametric.as_ref()), seconds_of_step(&file, parametric.as_ref())];
    format!(
        "{size} | {seconds:.1} | {:.2} | {:.0} | {:.0} | {random:.1e} | {corners:.1e}",
        1e-6 * built.bytes.len() as f64,
        1e6 * set,
        1e9 * step
    )
}

fn refused(error: &BuildError, after: Duration) -> String {
    let why = if is_cancelled(error) { "stopped".to_string() } else { error.to_string() };
    format!("{why} after {:.0} s | | | | | |", after.as_secs_f64())
}

/// Median seconds of setting all parameters, 32 modes of a parametric model.
fn seconds_to_set(file: &File<'_>, model: Option<&Parametric<'_>>) -> f64 {
    let known: Vec<_> = file.parameters().collect();
    let values = |change: usize| {
        known.iter().enumerate().map(move |(k, p)| {
            let share = ((change + k) % 10) as f64 / 10.0;
            p.lower * (p.upper / p.lower).powf(share)
        })
    };
    let mut change: Box<dyn FnMut(usize)> = match model {
        Some(model) => {
            let modes = model.usual_modes();
            let sizes = model.sizes(modes).expect("sizes");
            let (mut memory, mut work) =
                (vec![0.0; sizes.memory], vec![0.0; sizes.work.max(sizes.write_work)]);
            let mut bytes = vec![0; sizes.bytes];
            Box::new(move |change| {
                let values: Vec<f64> = values(change).collect();
                let tuned = model.solve(&values, modes, &mut memory, &mut work).expect("modes");
                tuned.write(model, &mut bytes, &mut work).expect("a file");
            })
        }
        None => {
            let options = SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() };
            let sizes = Scene::<f32>::sizes(file, &options).expect("sizes");
            let memory = vec![0.0f32; sizes.scene].leak();
            let (mut work, lent) = (vec![0.0f64; sizes.work], vec![0.0f32; sizes.state].leak());
            let mut scene = Scene::bind(file, &options, memory, &mut work).expect("a scene");
            let mut state = State::new(&scene, lent).expect("a state");
            Box::new(move |change| {
                let values: Vec<(usize, f64)> = values(change).enumerate().collect();
                scene.set_parameters(&values, &mut state, &mut work).expect("set");
            })
        }
    };
    let mut times: Vec<f64> = (0..CHANGES)
        .map(|k| {
            let start = Instant::now();
            change(k);
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[CHANGES / 2]
}

/// Median seconds of a step in single precision.
fn seconds_of_step(file: &File<'_>, model: Option<&Parametric<'_>>) -> f64 {
    let Some(model) = model else { return step_of(file.bytes()) };
    let mut values = vec![0.0; model.n_parameters()];
    model.nominal_into(&mut values);
    step_of(&model.body_at(&values, model.usual_modes()).expect("a body"))
}

fn step_of(bytes: &[u8]) -> f64 {
    let path = std::env::temp_dir().join(format!("live-regions-{}.vdm", std::process::id()));
    std::fs::write(&path, bytes).expect("a file");
    let found = timings(&path, &File::parse(bytes).expect("a file")).expect("times");
    let _ = std::fs::remove_file(&path);
    found.step[0][0]
}

/// Matrices of the regions and of the mass as triplets, the dofs and the points.
fn write(folder: &Path, count: usize, points: &[LivePoint]) {
    std::fs::create_dir_all(folder).expect("a folder");
    let problem = problem(count, "parametric").expect("a problem");
    let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("prepared");
    let model = &prepared.body.model;
    let save = |name: &str, matrix: &SymmetricMatrix| {
        let pattern = matrix.pattern();
        let columns = 0..pattern.n();
        let triplets = columns.flat_map(|j| {
            let values = &matrix.values()[pattern.range(j)];
            pattern
                .rows_of(j)
                .iter()
                .zip(values)
                .flat_map(move |(&i, &value)| [f64::from(i), j as f64, value])
        });
        let bytes: Vec<u8> = triplets.flat_map(f64::to_le_bytes).collect();
        std::fs::write(folder.join(name), bytes).expect("a matrix");
    };
    save("mass.bin", model.pencil().mass());
    for region in 0..count {
        // A region alone, to rounding: the others have no share of a difference.
        let at = |factor: f64| {
            let mut setting = prepared.space.setting(&prepared.space.nominal());
            setting.stiffness[region] = factor;
            setting.pencil(model.pencil())
        };
        let terms = [(0.5, at(3.0)), (-0.5, at(1.0))];
        let own = SymmetricMatrix::combine(&[
            (terms[0].0, terms[0].1.stiffness()),
            (terms[1].0, terms[1].1.stiffness()),
        ]);
        save(&format!("stiffness-{region}.bin"), &own);
    }
    let mut dofs = String::new();
    for &dof in model.dofs().dof_of_free() {
        let [x, y, z] = model.mesh().nodes[dof as usize / 3];
        let _ = writeln!(dofs, "{x} {y} {z} {}", dof % 3);
    }
    std::fs::write(folder.join("dofs.txt"), dofs).expect("the dofs");
    let mut rows = String::new();
    for LivePoint { values, time_step, place, direction } in points {
        let values = values.iter().map(|value| value.value);
        let row = values.chain([*time_step]).chain(*place).chain(*direction).map(|x| x.to_string());
        let _ = writeln!(rows, "{}", row.collect::<Vec<_>>().join(" "));
    }
    std::fs::write(folder.join("points.txt"), rows).expect("the points");
}
