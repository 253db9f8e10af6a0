//! Resources of an FMU of a golden file, a master's log, and an instance of FMI 2.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr::null_mut;
use std::sync::Mutex;

use vademecum_eval::format::{File, ParameterRole, SectionKind};
use vademecum_eval::{Loads, Place, Scene, SceneOptions, State, Surface, SurfacePoint};
use vademecum_fmu::fmi2::*;
use vademecum_fmu::fmi3::*;
use vademecum_fmu::points::{Point, StressPlace, table};
use vademecum_fmu::token::token;
use vademecum_fmu::variables::{Counts, Variable as V};
use vademecum_fmu::watch::IntermediateUpdate;

/// Resources of an FMU of a golden file, with two points.
pub struct Unit {
    _folder: tempfile::TempDir,
    pub resources: PathBuf,
    pub token: CString,
    pub bytes: Vec<u8>,
    pub points: [SurfacePoint; 2],
    pub counts: Counts,
}

pub fn golden(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/golden").join(name);
    std::fs::read(path).expect("a golden file")
}

/// A node whose stress the file knows.
pub fn stress_node(file: &File<'_>) -> Option<u32> {
    let section = file.section(SectionKind::StressPoints)?;
    section.u32s().ok()?.first().copied().map(u32::from_le_bytes)
}

impl Unit {
    pub fn new(name: &str) -> Self {
        Self::with_surface(name, &[])
    }

    /// With arrays over these nodes.
    pub fn with_surface(name: &str, surface: &[u32]) -> Self {
        let bytes = golden(name);
        let file = File::parse(&bytes).expect("a file");
        // A file without geometry is touched at two of its nodes.
        let at_node = |node: u32| SurfacePoint {
            place: Place::triangle([node; 3], [1.0, 0.0, 0.0]),
            position: [0.0; 3],
            distance: 0.0,
        };
        let points = match Surface::new(&file) {
            Ok(surface) => [[0.0; 3], [0.3, 0.2, 0.1]].map(|at| surface.locate(at).expect("a place")),
            Err(_) => [at_node(0), at_node(5)],
        };
        let row = |(name, point): (&'static str, &SurfacePoint)| Point { name, place: point.place };
        let rows: Vec<Point<'_>> = ["root", "far 100 %s"].into_iter().zip(&points).map(row).collect();
        let stress_node = stress_node(&file);
        let stresses: Vec<StressPlace<'_>> =
            stress_node.iter().map(|&node| StressPlace { name: "hot spot", node }).collect();
        let table = table(&rows, surface, &stresses).expect("a table");
        let folder = tempfile::tempdir().expect("a folder");
        let resources = folder.path().join("re sources");
        std::fs::create_dir(&resources).expect("made");
        std::fs::write(resources.join("body.vdm"), &bytes).expect("written");
        std::fs::write(resources.join("points.bin"), &table).expect("written");
        let token = CString::new(token(&bytes, &table)).expect("a token");
        let counts = Counts::of(&file, 2, stresses.len() as u32, surface.len() as u32);
        Self { _folder: folder, resources, token, bytes, points, counts }
    }

    pub fn uri(&self) -> CString {
        let path = self.resources.display().to_string().replace(' ', "%20");
        CString::new(format!("file://{path}")).expect("a URI")
    }

    pub fn reference(&self, variable: V) -> u32 {
        self.counts.all().position(|known| known == variable).expect("a variable") as u32
    }

    pub fn two(&self, log: &Log) -> Two {
        Two(self.two_with(log, &self.token, &self.uri(), 1))
    }

    pub fn two_with(&self, log: &Log, token: &CStr, uri: &CStr, kind: c_int) -> *mut c_void {
        let functions = log.functions();
        unsafe { fmi2Instantiate(c"beam".as_ptr(), kind, token.as_ptr(), uri.as_ptr(), &functions, 0, 1) }
    }

    pub fn three(&self, log: &Log) -> *mut c_void {
        self.three_with(log, None, false, &[])
    }

    /// With a watch over steps.
    pub fn three_with(
        &self,
        log: &Log,
        update: Option<IntermediateUpdate>,
        early_return: bool,
        watched: &[u32],
    ) -> *mut c_void {
        let folder = CString::new(format!("{}/", self.resources.display())).expect("a path");
        let (name, token, folder) = (c"beam".as_ptr(), self.token.as_ptr(), folder.as_ptr());
        let (environment, hear) = (log.environment(), Some(hear3 as _));
        unsafe {
            let (early, at, n) = (u8::from(early_return), watched.as_ptr(), watched.len());
            fmi3InstantiateCoSimulation(name, token, folder, 0, 0, 0, early, at, n, environment, hear, update)
        }
    }
}

/// Messages of instances; it outlives them.
pub struct Log(pub Mutex<Vec<String>>);

/// A callback of C with the arguments that this library gives it.
pub type Heard = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char);

impl Log {
    pub fn new() -> Self {
        Self(Mutex::new(vec![]))
    }

    pub fn environment(&self) -> *mut c_void {
        (&raw const self.0).cast_mut().cast()
    }

    pub fn functions(&self) -> CallbackFunctions {
        // On every platform of the tests a variadic call passes its arguments like named ones.
        let logger = unsafe { std::mem::transmute::<Heard, vademecum_fmu::logger::Callback2>(hear2) };
        let environment = self.environment();
        let (allocate_memory, free_memory, step_finished) = (None, None, None);
        CallbackFunctions { logger: Some(logger), allocate_memory, free_memory, step_finished, environment }
    }

    /// The last sentence must hold these words.
    pub fn last(&self, words: &[&str]) {
        let all = self.0.lock().expect("a log");
        let last = all.last().expect("a sentence");
        assert!(words.iter().all(|word| last.contains(word)), "`{last}` has not all of {words:?}");
    }

    pub fn refused(&self, status: c_int, words: &[&str]) {
        assert_eq!(status, 3, "{words:?}");
        self.last(words);
    }

    pub fn not_made(&self, instance: *mut c_void, words: &[&str]) {
        assert!(instance.is_null(), "{words:?}");
        self.last(words);
    }
}

unsafe extern "C" fn hear2(
    environment: *mut c_void,
    instance: *const c_char,
    _status: c_int,
    category: *const c_char,
    format: *const c_char,
) {
    let text = |text| unsafe { CStr::from_ptr(text) }.to_str().expect("UTF-8");
    // No argument follows, so nothing but doubled percent signs may stand in the format.
    let message = text(format).replace("%%", "\0");
    assert!(!message.contains('%'), "{message}");
    assert!(["beam", ""].contains(&text(instance)));
    assert!(["logStatusError", "logEvents"].contains(&text(category)));
    let log = unsafe { &*environment.cast::<Mutex<Vec<String>>>() };
    log.lock().expect("a log").push(message.replace('\0', "%"));
}

pub unsafe extern "C" fn hear3(environment: *mut c_void, _: c_int, _: *const c_char, message: *const c_char) {
    let log = unsafe { &*environment.cast::<Mutex<Vec<String>>>() };
    let text = unsafe { CStr::from_ptr(message) }.to_str().expect("UTF-8").to_string();
    log.lock().expect("a log").push(text);
}

/// An instance of FMI 2.
pub struct Two(pub *mut c_void);

impl Drop for Two {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.0) };
    }
}

impl Two {
    pub fn start(&self) {
        unsafe {
            assert_eq!(fmi2SetupExperiment(self.0, 0, 0.0, 0.0, 0, 0.0), 0);
            assert_eq!(fmi2EnterInitializationMode(self.0), 0);
            assert_eq!(fmi2ExitInitializationMode(self.0), 0);
        }
    }

    pub fn set(&self, reference: u32, value: f64) -> c_int {
        unsafe { fmi2SetReal(self.0, &reference, 1, &value) }
    }

    pub fn step(&self, point: f64, size: f64) -> c_int {
        unsafe { fmi2DoStep(self.0, point, size, 1) }
    }

    /// Bits of some variables.
    pub fn bits(&self, references: &[u32]) -> Vec<u64> {
        let mut values = vec![f64::NAN; references.len()];
        let found = unsafe { fmi2GetReal(self.0, references.as_ptr(), values.len(), values.as_mut_ptr()) };
        assert_eq!(found, 0);
        values.into_iter().map(f64::to_bits).collect()
    }

    /// Bits of all variables that are offered: the time step is no parameter.
    pub fn all(&self, unit: &Unit) -> Vec<u64> {
        let file = File::parse(&unit.bytes).expect("a file");
        let fixed = |role| role == ParameterRole::TimeStep;
        let parameters: Vec<_> = file.parameters().collect();
        let offered = |variable: &V| match variable {
            V::Parameter(index) => !fixed(parameters[*index as usize].role),
            V::Whole(index) => vademecum_fmu::whole(&SceneOptions::default(), &file, *index).is_some(),
            V::SurfaceNodes => false,
            _ => true,
        };
        let references: Vec<u32> = (0..)
            .zip(unit.counts.all())
            .filter(|(_, v)| offered(v))
            .map(|(reference, _)| reference)
            .collect();
        self.bits(&references)
    }

    pub fn internal_step(&self) -> f64 {
        f64::from_bits(self.bits(&[1])[0])
    }

    pub fn serialized(&self) -> Vec<u8> {
        unsafe {
            let (mut state, mut size) = (null_mut(), 0);
            assert_eq!(fmi2GetFMUstate(self.0, &mut state), 0);
            assert_eq!(fmi2SerializedFMUstateSize(self.0, state, &mut size), 0);
            let mut bytes = vec![0; size];
            assert_eq!(fmi2SerializeFMUstate(self.0, state, bytes.as_mut_ptr(), size), 0);
            assert_eq!(fmi2FreeFMUstate(self.0, &mut state), 0);
            assert!(state.is_null());
            bytes
        }
    }

    /// Takes a serialized state back, if it is one.
    pub fn take(&self, bytes: &[u8]) -> c_int {
        unsafe {
            let mut state = null_mut();
            let made = fmi2DeSerializeFMUstate(self.0, bytes.as_ptr(), bytes.len(), &mut state);
            if made != 0 {
                assert!(state.is_null());
                return made;
            }
            let taken = fmi2SetFMUstate(self.0, state);
            assert_eq!(fmi2FreeFMUstate(self.0, &mut state), 0);
            taken
        }
    }
}

/// A force that changes from step to step.
pub fn force(step: u32, point: usize) -> [f64; 3] {
    let wave = |k: f64| (0.1 * k * f64::from(step) + point as f64).sin();
    [wave(1.0), 2.0 * wave(0.7), -3.0 * wave(0.3)]
}

/// Numbers of variables that an instance shows.
pub fn shown(two: &Two, unit: &Unit, variables: impl IntoIterator<Item = V>) -> Vec<f64> {
    let references: Vec<u32> = variables.into_iter().map(|variable| unit.reference(variable)).collect();
    two.bits(&references).into_iter().map(f64::from_bits).collect()
}

/// Memory of a scene in double precision, its state and its loads.
pub struct SceneMemory([Vec<f64>; 3], Vec<f64>);

impl SceneMemory {
    /// As much as a file needs.
    pub fn new(file: &File<'_>, options: &SceneOptions) -> Self {
        let sizes = Scene::<f64>::sizes(file, options).expect("sizes");
        let own = [sizes.scene, sizes.state, sizes.loads].map(|n| vec![0.0; n]);
        Self(own, vec![0.0; sizes.work])
    }

    /// A scene at rest without loads.
    pub fn bind<'m>(
        &'m mut self,
        file: &File<'m>,
        options: &SceneOptions,
    ) -> (Scene<'m, f64>, State<'m, f64>, Loads<'m, f64>) {
        let Self([a, b, c], work) = self;
        let scene = Scene::bind(file, options, a, work).expect("a scene");
        let state = State::new(&scene, b).expect("a state");
        let loads = Loads::new(&scene, c).expect("loads");
        (scene, state, loads)
    }
}
