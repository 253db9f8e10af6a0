//! The committed WebAssembly evaluator gives the bits of the one compiled for this machine: neither fuses
//! multiplications, so there is nothing to tolerate.

use std::path::{Path, PathBuf};
use std::process::Command;

use vademecum_eval::format::scheme::StepParameters;
use vademecum_eval::format::{Element, File};
use vademecum_eval::{
    Contact, Field, Loads, Place, Scalar, Scene, SceneOptions, State, StructureChoice, Surface, SurfacePoint,
};
use vademecum_tests::synthetic::{Body, Layout, bathe};
use vademecum_web::session::{Player, Session, lengths};
use vademecum_web::tool::Sphere;

const LAYOUT: Layout = Layout { rows: 4, load_rows: 3, columns: 3, n_interior: 3, r: 11 };

const POINT: SurfacePoint =
    SurfacePoint { place: Place::triangle([1, 4, 3], [0.25, 0.5, 0.25]), position: [0.0; 3], distance: 0.0 };

/// The march of `march.mjs`, for one precision.
struct Native<'f, 'n> {
    file: &'f File<'f>,
    numbers: &'n mut Vec<f64>,
}

impl Native<'_, '_> {
    fn record<T: Scalar>(&mut self, scene: &Scene<'_, T>, state: &State<'_, T>, watch: Option<[f64; 3]>) {
        for probe in 0..3 {
            self.numbers.push(scene.probe(state, probe, Field::Displacement).unwrap());
        }
        let u = scene.point(state, &POINT, Field::Displacement).unwrap();
        self.numbers.push(watch.map_or(0.0, |d| u.iter().zip(d).map(|(u, d)| u * d).sum()));
        let energies = [scene.energy(state), scene.kinetic_energy(state), scene.strain_energy(state)];
        self.numbers.extend(energies.map(|energy| energy.unwrap()));
    }

    fn march<T: Scalar>(&mut self, structure: StructureChoice) {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        let sizes = Scene::<T>::sizes(self.file, &options).unwrap();
        let mut memory = vec![T::ZERO; sizes.scene + sizes.state + sizes.loads];
        let (scene, rest) = memory.split_at_mut(sizes.scene);
        let (state, loads) = rest.split_at_mut(sizes.state);
        let scene = Scene::bind(self.file, &options, scene, &mut vec![0.0; sizes.work]).unwrap();
        let mut state = State::new(&scene, state).unwrap();
        let mut loads = Loads::new(&scene, loads).unwrap();
        let watch = Some([0.6, 0.0, 0.8]);
        loads.add_contact(&scene, &contact()).unwrap();
        loads.add_pattern(&scene, 0, -0.3).unwrap();
        for _ in 0..100 {
            scene.step(&mut state, &loads).unwrap();
            self.record(&scene, &state, watch);
        }
        loads.clear();
        for step in 0..5003 {
            scene.step(&mut state, &loads).unwrap();
            if step >= 5000 {
                self.record(&scene, &state, watch);
            }
        }
        for field in [Field::Displacement, Field::Velocity] {
            let mut surface = vec![T::ZERO; 3 * LAYOUT.n_surface()];
            scene.surface_into(&state, field, &mut surface).unwrap();
            self.numbers.extend(surface.iter().map(|x| x.to_f64()));
        }
        self.numbers.extend(state.zeta().iter().map(|x| x.to_f64()));
        let rate = 1.0 / scene.parameters().time_step;
        self.numbers.extend(state.scaled_velocity().iter().map(|x| x.to_f64() * rate));
        self.numbers.push(scene.energy(&state).unwrap());
    }

    /// Other parameters than the file's, double precision, diagonal.
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
        let sizes = Scene::<f64>::sizes(self.file, &options).unwrap();
        let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
        let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
        let scene = Scene::bind(self.file, &options, &mut memory, &mut work).unwrap();
        let mut state = State::new(&scene, &mut state).unwrap();
        let mut loads = Loads::new(&scene, &mut loads).unwrap();
        loads.add_contact(&scene, &contact()).unwrap();
        for _ in 0..100 {
            scene.step(&mut state, &loads).unwrap();
            self.record(&scene, &state, None);
        }
        let point = Surface::new(self.file).unwrap().locate([0.3, 0.2, 0.9]).unwrap();
        self.numbers.extend(point.position);
    }
}

/// A sphere that is pressed in and dragged for 40 steps; at how many places it pushed in all.
fn press<T: Scalar>(file: &File<'_>, numbers: &mut Vec<f64>) -> usize {
    let options =
        SceneOptions { structure: StructureChoice::Exact, alpha: Some(0.0), ..SceneOptions::default() };
    let (body, field) = lengths::<T>(file, &options).unwrap();
    let (mut memory, mut field) = (vec![0.0; body], vec![T::ZERO; field]);
    let mut session = Session::bind(file, &options, &mut memory, &mut field).unwrap();
    session.add_pattern(0, -0.3).unwrap();
    let [x, y, z] = Surface::new(file).unwrap().locate([0.3, 0.2, 0.9]).unwrap().position;
    let (centre, target) = ([x, y, z + 0.21], [x + 0.1, y, z + 0.15]);
    session
        .hold(Some(Sphere { radius: 0.2, friction: 0.3, centre, target, speed: 2.0, most: f64::INFINITY }))
        .unwrap();
    let mut pushed = 0;
    for _ in 0..40 {
        session.march(1, &mut []).unwrap();
        let tool = session.tool().unwrap();
        numbers.extend(tool.sphere.centre);
        numbers.push(tool.deepest());
        for touch in tool.touches().iter().filter(|touch| touch.force != [0.0; 3]) {
            numbers.extend(touch.place);
            numbers.extend(touch.force);
            pushed += 1;
        }
        numbers.push(session.energy().unwrap());
    }
    session.hold(None).unwrap();
    let mut rows = vec![0.0; 3 * session.record_len()];
    session.march(3, &mut rows).unwrap();
    numbers.extend(rows);
    pushed
}

fn contact() -> Contact {
    Contact::new(POINT.place, [1.0, -2.0, 0.7])
}

/// The module to test: the committed one, or the one named by `VADEMECUM_WASM` (a fresh build).
fn module() -> PathBuf {
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vademecum-cli/assets/evaluator.wasm");
    std::env::var_os("VADEMECUM_WASM").map_or(committed, PathBuf::from)
}

#[test]
fn the_web_module_gives_the_native_bits() {
    let node = Command::new("node").arg("--version").output();
    if !node.is_ok_and(|output| output.status.success()) {
        assert!(std::env::var_os("CI").is_none(), "node is needed to run the web module");
        eprintln!("skipped: no node on this machine to run the web module");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for element in [Element::F32, Element::F64] {
        let parameters =
            StepParameters { time_step: 5e-3, alpha: 0.3, beta: 2e-5, density: 1.0, stiffness: 1.0 };
        let bytes = Body::open(LAYOUT, 7).file(&bathe(), &parameters, element);
        let (input, output) = (folder.path().join("body.vdm"), folder.path().join("numbers"));
        std::fs::write(&input, &bytes).unwrap();
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/march.mjs");
        let run = Command::new("node").arg(script).arg(module()).args([&input, &output]).output().unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));

        let file = File::parse(&bytes).unwrap();
        let mut numbers = vec![];
        let mut native = Native { file: &file, numbers: &mut numbers };
        for structure in [StructureChoice::Diagonal, StructureChoice::Block, StructureChoice::Exact] {
            native.march::<f32>(structure);
        }
        for structure in [StructureChoice::Diagonal, StructureChoice::Block, StructureChoice::Exact] {
            native.march::<f64>(structure);
        }
        native.march_elsewhere();
        let pushed = press::<f32>(&file, &mut numbers) + press::<f64>(&file, &mut numbers);
        assert!(pushed > 40, "the sphere touches the body: {pushed}");
        let found = std::fs::read(&output).unwrap();
        let found: Vec<u64> = found.as_chunks().0.iter().map(|&bytes| u64::from_le_bytes(bytes)).collect();
        let expected: Vec<u64> = numbers.iter().map(|x| x.to_bits()).collect();
        assert!(numbers.iter().any(|x| x.abs() > 1e-6) && numbers.iter().all(|x| x.is_finite()));
        assert_eq!(found.len(), expected.len());
        let apart = found.iter().zip(&expected).position(|(a, b)| a != b);
        assert_eq!(apart, None, "{element:?}: the first number that differs, of {}", expected.len());
    }
}

/// The page shows the sentence that a refused session says.
#[test]
fn a_file_with_only_the_chapters_structure_is_refused_in_words() {
    let (_, bytes) = vademecum_tests::golden::all()
        .into_iter()
        .find(|(name, _)| *name == "canonical.vdm")
        .expect("a golden file");
    let file = File::parse(&bytes).expect("a sound file");
    let refusal = lengths::<f32>(&file, &SceneOptions::default());
    let said = refusal.expect_err("no structure a page can step").to_string();
    assert!(said.contains("only the chapter's structure") && said.contains("vademecum run"), "{said}");
}
