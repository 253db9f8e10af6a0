//! The committed WebAssembly evaluator gives the bits of the one compiled for this machine: neither fuses
//! multiplications, so there is nothing to tolerate.

use std::path::{Path, PathBuf};
use std::process::Command;

use vademecum_eval::format::scheme::StepParameters;
use vademecum_eval::format::{Element, File};
use vademecum_eval::{
    AnyBody, Field, Place, Precision, Quantity, Scalar, SceneOptions, Simulation, StructureChoice,
};
use vademecum_tests::synthetic::{Body, Layout, bathe};
use vademecum_web::refusal::Refusal;
use vademecum_web::tool::{Sphere, Tool, body_options};

const LAYOUT: Layout = Layout { rows: 4, load_rows: 3, columns: 3, n_interior: 3, r: 11 };

const PLACE: Place = Place::triangle([1, 4, 3], [0.25, 0.5, 0.25]);
const FORCE: [f64; 3] = [1.0, -2.0, 0.7];

/// The march of `march.mjs`, in one precision.
struct Native<'f, 'n> {
    file: &'f File<'f>,
    precision: Precision,
    numbers: &'n mut Vec<f64>,
}

impl Native<'_, '_> {
    fn with_body(&mut self, options: SceneOptions, act: impl FnOnce(&mut Self, &mut AnyBody<'_>)) {
        let options = body_options(options);
        let mut memory = vec![0.0; AnyBody::len_for(self.file, &options, self.precision).unwrap()];
        let mut body = AnyBody::bind(self.file, &options, self.precision, &mut memory).unwrap();
        act(self, &mut body);
    }

    fn read(&mut self, body: &AnyBody<'_>, quantity: Quantity, index: usize, field: Field) {
        let mut out = vec![0.0; body.length(quantity)];
        body.read(quantity, index, field, &mut out).unwrap();
        self.numbers.extend(out);
    }

    fn record(&mut self, body: &AnyBody<'_>, watch: Option<[f64; 3]>) {
        for probe in 0..3 {
            self.read(body, Quantity::Probe, probe, Field::Displacement);
        }
        let u = body.point(&PLACE, Field::Displacement).unwrap();
        self.numbers.push(watch.map_or(0.0, |d| u.iter().zip(d).map(|(u, d)| u * d).sum()));
        for quantity in Quantity::totals() {
            self.read(body, quantity, 0, Field::Displacement);
        }
    }

    fn march(&mut self, structure: StructureChoice) {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        self.with_body(options, |native, body| {
            let watch = Some([0.6, 0.0, 0.8]);
            body.push(&PLACE, FORCE).unwrap();
            body.push_pattern(0, -0.3).unwrap();
            for _ in 0..100 {
                body.step().unwrap();
                native.record(body, watch);
            }
            let mut saved = vec![0; body.saved_len()];
            let length = body.save_into(&mut saved).unwrap();
            native.numbers.extend(saved[..length].iter().map(|&byte| f64::from(byte)));
            body.clear();
            for step in 0..5003 {
                body.step().unwrap();
                if step >= 5000 {
                    native.record(body, watch);
                }
            }
            for field in [Field::Displacement, Field::Velocity] {
                native.read(body, Quantity::Surface, 0, field);
            }
            let (mut zeta, mut rates) = (vec![0.0; body.n_modes()], vec![0.0; body.n_modes()]);
            body.coordinates_into(&mut zeta, &mut rates).unwrap();
            native.numbers.extend(zeta.into_iter().chain(rates));
            body.restore(&saved[..length]).unwrap();
            for quantity in Quantity::totals() {
                native.read(body, quantity, 0, Field::Displacement);
            }
            native.read(body, Quantity::Whole, 0, Field::Velocity);
            native.read(body, Quantity::Node, 7, Field::Displacement);
        });
    }

    /// Other parameters than the file's.
    fn march_elsewhere(&mut self) {
        let options = SceneOptions {
            structure: StructureChoice::Diagonal,
            time_step: Some(0.003),
            stiffness: 2.5,
            density: 0.7,
            alpha: Some(0.9),
            beta: Some(1e-5),
            ..SceneOptions::default()
        };
        self.with_body(options, |native, body| {
            body.push(&PLACE, FORCE).unwrap();
            for _ in 0..100 {
                body.step().unwrap();
                native.record(body, None);
            }
            native.numbers.extend(body.locate([0.3, 0.2, 0.9]).unwrap().position);
        });
    }

    /// A sphere that is pressed in and dragged for 40 steps; at how many places it pushed in all.
    fn press(&mut self) -> usize {
        let options =
            SceneOptions { structure: StructureChoice::Exact, alpha: Some(0.0), ..SceneOptions::default() };
        let mut pushed = 0;
        self.with_body(options, |native, body| {
            body.push_pattern(0, -0.3).unwrap();
            let [x, y, z] = body.locate([0.3, 0.2, 0.9]).unwrap().position;
            let (centre, target) = ([x, y, z + 0.21], [x + 0.1, y, z + 0.15]);
            let most = f64::INFINITY;
            let sphere = Sphere { radius: 0.2, friction: 0.3, centre, target, speed: 2.0, most };
            let mut tool = Tool::new(sphere, body).unwrap();
            for _ in 0..40 {
                tool.step(body).unwrap();
                native.numbers.extend(tool.sphere.centre);
                native.numbers.push(tool.deepest());
                for touch in tool.touches().iter().filter(|touch| touch.force != [0.0; 3]) {
                    native.numbers.extend(touch.place);
                    native.numbers.extend(touch.force);
                    pushed += 1;
                }
                native.read(body, Quantity::Energy, 0, Field::Displacement);
            }
            for _ in 0..3 {
                body.step().unwrap();
                native.record(body, None);
            }
        });
        pushed
    }
}

/// The module to test: the committed one, or that in the folder `VADEMECUM_WASM` (a fresh build).
fn module() -> PathBuf {
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vademecum-cli/assets");
    std::env::var_os("VADEMECUM_WASM").map_or(committed, PathBuf::from).join("evaluator.wasm")
}

#[test]
fn the_web_module_gives_the_native_bits() {
    if !has_node() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for element in [Element::F32, Element::F64] {
        let parameters =
            StepParameters { time_step: 5e-3, alpha: 0.3, beta: 2e-5, density: 1.0, stiffness: 1.0 };
        let bytes = Body::open(LAYOUT, 7).file(&bathe(), &parameters, element);
        let found = run("march.mjs", &bytes, folder.path());
        let file = File::parse(&bytes).unwrap();
        let mut numbers = vec![];
        let mut native = Native { file: &file, precision: Precision::Single, numbers: &mut numbers };
        for precision in [Precision::Single, Precision::Double] {
            native.precision = precision;
            for structure in [StructureChoice::Diagonal, StructureChoice::Block, StructureChoice::Exact] {
                native.march(structure);
            }
        }
        native.march_elsewhere();
        let mut pushed = 0;
        for precision in [Precision::Single, Precision::Double] {
            native.precision = precision;
            pushed += native.press();
        }
        assert!(pushed > 40, "the sphere touches the body: {pushed}");
        same(&found, &numbers, &format!("{element:?}"));
    }
}

#[test]
fn live_regions_set_in_the_web_module_give_the_native_bits() {
    if !has_node() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let bytes = vademecum_tests::golden::named("parametric.vdm");
    let found = run("live.mjs", &bytes, folder.path());
    let mut numbers = vec![];
    live::<f32>(&bytes, &mut numbers);
    live::<f64>(&bytes, &mut numbers);
    same(&found, &numbers, "live regions");
}

/// The numbers of `live.mjs` in one precision.
fn live<T: Scalar + 'static>(bytes: &[u8], numbers: &mut Vec<f64>) {
    let file = File::parse(bytes).unwrap();
    let metadata = file.metadata();
    let scene = SceneOptions {
        time_step: Some(metadata.time_step),
        alpha: Some(metadata.alpha),
        beta: Some(metadata.beta),
        ..SceneOptions::default()
    };
    let mut one = Simulation::<T>::with_options(bytes.to_vec(), &body_options(scene)).unwrap();
    one.push_pattern(0, 1.0).unwrap();
    let record = |one: &mut Simulation<T>, numbers: &mut Vec<f64>| {
        for _ in 0..5 {
            one.step(1).unwrap();
            for probe in 0..metadata.n_probes as usize {
                numbers.push(one.probe(probe, Field::Displacement).unwrap());
            }
            // Nothing is watched.
            numbers.push(0.0);
            for quantity in Quantity::totals() {
                let mut total = [0.0];
                one.body().read(quantity, 0, Field::Displacement, &mut total).unwrap();
                numbers.push(total[0]);
            }
        }
    };
    record(&mut one, numbers);
    one.set_parameters(&[(1, 3.0), (3, 1e-5)]).unwrap();
    record(&mut one, numbers);
    numbers.extend((0..4).map(|index| one.parameter(index).unwrap()));
    record(&mut one, numbers);
    let mut surface = vec![T::ZERO; 3 * metadata.n_surface_nodes as usize];
    one.surface_into(Field::Displacement, &mut surface).unwrap();
    numbers.extend(surface.into_iter().map(Scalar::to_f64));
}

/// Refuses in CI to go on without node.
fn has_node() -> bool {
    if Command::new("node").arg("--version").output().is_ok_and(|output| output.status.success()) {
        return true;
    }
    assert!(std::env::var_os("CI").is_none(), "node is needed to run the web module");
    eprintln!("skipped: no node on this machine to run the web module");
    false
}

/// Bits of the numbers that a script writes of a file.
fn run(script: &str, bytes: &[u8], folder: &Path) -> Vec<u64> {
    let (input, output) = (folder.join("body.vdm"), folder.join("numbers"));
    std::fs::write(&input, bytes).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(script);
    let run = Command::new("node").arg(script).arg(module()).args([&input, &output]).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let found = std::fs::read(&output).unwrap();
    found.as_chunks().0.iter().map(|&bytes| u64::from_le_bytes(bytes)).collect()
}

fn same(found: &[u64], numbers: &[f64], what: &str) {
    let expected: Vec<u64> = numbers.iter().map(|x| x.to_bits()).collect();
    assert!(numbers.iter().any(|x| x.abs() > 1e-6) && numbers.iter().all(|x| x.is_finite()));
    assert_eq!(found.len(), expected.len());
    let apart = found.iter().zip(&expected).position(|(a, b)| a != b);
    assert_eq!(apart, None, "{what}: the first number that differs, of {}", expected.len());
}

/// The page shows the sentence of a refusal.
#[test]
fn a_file_with_only_the_chapters_structure_is_refused_in_words() {
    let (_, bytes) = vademecum_tests::golden::all()
        .into_iter()
        .find(|(name, _)| *name == "canonical.vdm")
        .expect("a golden file");
    let file = File::parse(&bytes).expect("a sound file");
    let options = body_options(SceneOptions::default());
    let refusal = AnyBody::len_for(&file, &options, Precision::Single);
    let said = Refusal::from(refusal.expect_err("no structure a page can step")).to_string();
    assert!(said.contains("only the chapter's structure") && said.contains("vademecum run"), "{said}");
}
