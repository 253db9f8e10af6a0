//! A master that calls the entry points: the numbers are those of the evaluator, bit for bit, states come
//! back as they were, and everything else is refused by name.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use vademecum_eval::format::{File, ParameterRole, SectionKind};
use vademecum_eval::{
    Body, BodyOptions, Contact, Field, FreeBody, LiveMemory, Loads, Place, RigidMotion, Scene, SceneOptions,
    State, Surface, SurfacePoint,
};
use vademecum_fmu::fmi2::*;
use vademecum_fmu::fmi3::*;
use vademecum_fmu::points::{Point, StressPlace, table};
use vademecum_fmu::token::token;
use vademecum_fmu::variables::{Counts, Variable as V};

/// Resources of an FMU of a golden file, with two points.
struct Unit {
    _folder: tempfile::TempDir,
    resources: PathBuf,
    token: CString,
    bytes: Vec<u8>,
    points: [SurfacePoint; 2],
    counts: Counts,
}

fn golden(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/golden").join(name);
    std::fs::read(path).expect("a golden file")
}

/// A node whose stress the file knows.
fn stress_node(file: &File<'_>) -> Option<u32> {
    let section = file.section(SectionKind::StressPoints)?;
    section.u32s().ok()?.first().copied().map(u32::from_le_bytes)
}

impl Unit {
    fn new(name: &str) -> Self {
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
        let table = table(&rows, &stresses).expect("a table");
        let folder = tempfile::tempdir().expect("a folder");
        let resources = folder.path().join("re sources");
        std::fs::create_dir(&resources).expect("made");
        std::fs::write(resources.join("body.vdm"), &bytes).expect("written");
        std::fs::write(resources.join("points.bin"), &table).expect("written");
        let token = CString::new(token(&bytes, &table)).expect("a token");
        let counts = Counts::of(&file, 2, stresses.len() as u32);
        Self { _folder: folder, resources, token, bytes, points, counts }
    }

    fn uri(&self) -> CString {
        let path = self.resources.display().to_string().replace(' ', "%20");
        CString::new(format!("file://{path}")).expect("a URI")
    }

    fn reference(&self, variable: V) -> u32 {
        self.counts.all().position(|known| known == variable).expect("a variable") as u32
    }

    fn two(&self, log: &Log) -> Two {
        Two(self.two_with(log, &self.token, &self.uri(), 1))
    }

    fn two_with(&self, log: &Log, token: &CStr, uri: &CStr, kind: c_int) -> *mut c_void {
        let functions = log.functions();
        unsafe { fmi2Instantiate(c"beam".as_ptr(), kind, token.as_ptr(), uri.as_ptr(), &functions, 0, 1) }
    }

    fn three(&self, log: &Log) -> *mut c_void {
        let folder = CString::new(format!("{}/", self.resources.display())).expect("a path");
        let (name, token, folder) = (c"beam".as_ptr(), self.token.as_ptr(), folder.as_ptr());
        let (environment, hear) = (log.environment(), Some(hear3 as _));
        unsafe {
            fmi3InstantiateCoSimulation(name, token, folder, 0, 0, 0, 0, null(), 0, environment, hear, null())
        }
    }
}

/// What instances have told; it outlives them.
struct Log(Mutex<Vec<String>>);

/// A callback of C with the arguments that this library gives it.
type Heard = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char);

impl Log {
    fn new() -> Self {
        Self(Mutex::new(vec![]))
    }

    fn environment(&self) -> *mut c_void {
        (&raw const self.0).cast_mut().cast()
    }

    fn functions(&self) -> CallbackFunctions {
        // On every platform of the tests a variadic call passes its arguments like named ones.
        let logger = unsafe { std::mem::transmute::<Heard, vademecum_fmu::logger::Callback2>(hear2) };
        let environment = self.environment();
        let (allocate_memory, free_memory, step_finished) = (None, None, None);
        CallbackFunctions { logger: Some(logger), allocate_memory, free_memory, step_finished, environment }
    }

    /// The last sentence must hold these words.
    fn last(&self, words: &[&str]) {
        let all = self.0.lock().expect("a log");
        let last = all.last().expect("a sentence");
        assert!(words.iter().all(|word| last.contains(word)), "`{last}` has not all of {words:?}");
    }

    fn refused(&self, status: c_int, words: &[&str]) {
        assert_eq!(status, 3, "{words:?}");
        self.last(words);
    }

    fn not_made(&self, instance: *mut c_void, words: &[&str]) {
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

unsafe extern "C" fn hear3(environment: *mut c_void, _: c_int, _: *const c_char, message: *const c_char) {
    let log = unsafe { &*environment.cast::<Mutex<Vec<String>>>() };
    let text = unsafe { CStr::from_ptr(message) }.to_str().expect("UTF-8").to_string();
    log.lock().expect("a log").push(text);
}

/// An instance of FMI 2.
struct Two(*mut c_void);

impl Drop for Two {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.0) };
    }
}

impl Two {
    fn start(&self) {
        unsafe {
            assert_eq!(fmi2SetupExperiment(self.0, 0, 0.0, 0.0, 0, 0.0), 0);
            assert_eq!(fmi2EnterInitializationMode(self.0), 0);
            assert_eq!(fmi2ExitInitializationMode(self.0), 0);
        }
    }

    fn set(&self, reference: u32, value: f64) -> c_int {
        unsafe { fmi2SetReal(self.0, &reference, 1, &value) }
    }

    fn step(&self, point: f64, size: f64) -> c_int {
        unsafe { fmi2DoStep(self.0, point, size, 1) }
    }

    /// Bits of some variables.
    fn bits(&self, references: &[u32]) -> Vec<u64> {
        let mut values = vec![f64::NAN; references.len()];
        let found = unsafe { fmi2GetReal(self.0, references.as_ptr(), values.len(), values.as_mut_ptr()) };
        assert_eq!(found, 0);
        values.into_iter().map(f64::to_bits).collect()
    }

    /// Bits of all variables that are offered: the time step is no parameter.
    fn all(&self, unit: &Unit) -> Vec<u64> {
        let file = File::parse(&unit.bytes).expect("a file");
        let fixed = |role| role == ParameterRole::TimeStep;
        let parameters: Vec<_> = file.parameters().collect();
        let offered = |variable: &V| match variable {
            V::Parameter(index) => !fixed(parameters[*index as usize].role),
            V::Whole(index) => vademecum_fmu::whole(&SceneOptions::default(), &file, *index).is_some(),
            _ => true,
        };
        let references: Vec<u32> = (0..)
            .zip(unit.counts.all())
            .filter(|(_, v)| offered(v))
            .map(|(reference, _)| reference)
            .collect();
        self.bits(&references)
    }

    fn internal_step(&self) -> f64 {
        f64::from_bits(self.bits(&[1])[0])
    }

    fn serialized(&self) -> Vec<u8> {
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
    fn take(&self, bytes: &[u8]) -> c_int {
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
fn force(step: u32, point: usize) -> [f64; 3] {
    let wave = |k: f64| (0.1 * k * f64::from(step) + point as f64).sin();
    [wave(1.0), 2.0 * wave(0.7), -3.0 * wave(0.3)]
}

#[test]
fn numbers_are_those_of_the_evaluator_bit_for_bit() {
    for name in ["fixed-f64.vdm", "exact-f64.vdm", "fixed-f32.vdm", "quadratic.vdm", "bent.vdm"] {
        let unit = Unit::new(name);
        let file = File::parse(&unit.bytes).expect("a file");
        let options = SceneOptions { contacts: 2, ..SceneOptions::default() };
        let sizes = Scene::<f64>::sizes(&file, &options).expect("sizes");
        let [mut a, mut b, mut c] = [sizes.scene, sizes.state, sizes.loads].map(|n| vec![0.0; n]);
        let mut work = vec![0.0; sizes.work];
        let scene = Scene::bind(&file, &options, &mut a, &mut work).expect("a scene");
        let mut state = State::new(&scene, &mut b).expect("a state");
        let mut loads = Loads::new(&scene, &mut c).expect("loads");

        let log = Log::new();
        let (two, three) = (unit.two(&log), unit.three(&log));
        assert!(!two.0.is_null() && !three.is_null(), "{name}");
        two.start();
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(three, 0, 0.0, 5.0, 0, 0.0), 0);
            assert_eq!(fmi3ExitInitializationMode(three), 0);
        }
        let patterns = unit.counts.patterns;
        let inputs = (0..6).map(|k| V::Force(k / 3, k % 3)).chain((0..patterns).map(V::Pattern));
        let inputs: Vec<u32> = inputs.map(|variable| unit.reference(variable)).collect();
        let probes = unit.counts.probes;
        let outputs = [V::Energy]
            .into_iter()
            .chain((0..6).map(|k| V::Displacement(k / 3, k % 3)))
            .chain((0..6).map(|k| V::Velocity(k / 3, k % 3)))
            .chain((0..probes).map(V::Probe))
            .chain((0..probes).map(V::ProbeVelocity));
        let outputs: Vec<u32> = outputs.map(|variable| unit.reference(variable)).collect();
        let step = scene.parameters().time_step;
        let (mut moved, mut point) = (0.0_f64, 0.0);
        for turn in 0..60 {
            let amplitude = if turn < 30 { 0.5 } else { 0.0 };
            let amplitudes = (0..patterns).map(|_| amplitude);
            let values: Vec<f64> = (0..2).flat_map(|p| force(turn, p)).chain(amplitudes).collect();
            let internal = if turn % 7 == 0 { 3 } else { 1 };
            let size = f64::from(internal) * step;
            loads.clear();
            for (p, at) in unit.points.iter().enumerate() {
                let contact = Contact::new(at.place, force(turn, p));
                loads.add_contact(&scene, &contact).expect("a contact");
            }
            if amplitude != 0.0 {
                (0..patterns as usize)
                    .for_each(|p| loads.add_pattern(&scene, p, amplitude).expect("a pattern"));
            }
            for _ in 0..internal {
                scene.step(&mut state, &loads).expect("a step");
            }
            let (n, mut last, mut flags) = (inputs.len(), 0.0, [9_u8; 3]);
            let [a, b, c] = &mut flags;
            unsafe {
                assert_eq!(fmi2SetReal(two.0, inputs.as_ptr(), n, values.as_ptr()), 0);
                assert_eq!(two.step(point, size), 0);
                assert_eq!(fmi3SetFloat64(three, inputs.as_ptr(), n, values.as_ptr(), n), 0);
                assert_eq!(fmi3DoStep(three, 5.0 + point, size, 1, a, b, c, &mut last), 0);
            }
            point += size;
            assert_eq!(flags, [0; 3]);
            assert!((last - 5.0 - point).abs() < 1e-9);
            let mut wanted = vec![scene.energy(&state).expect("an energy")];
            let fields = [Field::Displacement, Field::Velocity];
            for field in fields {
                for at in &unit.points {
                    wanted.extend(scene.point(&state, at, field).expect("a point"));
                }
            }
            for field in fields {
                let probe = |p| scene.probe(&state, p, field).expect("a probe");
                wanted.extend((0..probes as usize).map(probe));
            }
            let bits: Vec<u64> = wanted.iter().map(|x| x.to_bits()).collect();
            assert_eq!(two.bits(&outputs), bits, "{name}, turn {turn}, FMI 2");
            let (n, mut found) = (outputs.len(), vec![0.0; outputs.len()]);
            assert_eq!(unsafe { fmi3GetFloat64(three, outputs.as_ptr(), n, found.as_mut_ptr(), n) }, 0);
            let found: Vec<u64> = found.into_iter().map(f64::to_bits).collect();
            assert_eq!(found, bits, "{name}, turn {turn}, FMI 3");
            moved = wanted.iter().skip(1).fold(moved, |most, x| most.max(x.abs()));
        }
        assert!(moved > 0.0, "{name} never moved");
        unsafe { fmi3FreeInstance(three) };
    }
}

/// Numbers of variables that an instance shows.
fn shown(two: &Two, unit: &Unit, variables: impl IntoIterator<Item = V>) -> Vec<f64> {
    let references: Vec<u32> = variables.into_iter().map(|variable| unit.reference(variable)).collect();
    two.bits(&references).into_iter().map(f64::from_bits).collect()
}

#[test]
fn stress_and_reactions_are_those_of_the_evaluator() {
    let (mut supports, mut stresses) = (0, 0);
    for name in ["reactions.vdm", "stress.vdm"] {
        let unit = Unit::new(name);
        let log = Log::new();
        let two = unit.two(&log);
        two.start();
        let options = SceneOptions { contacts: 2, ..SceneOptions::default() };
        let file = File::parse(&unit.bytes).expect("a file");
        let sizes = Scene::<f64>::sizes(&file, &options).expect("sizes");
        let [mut a, mut b, mut c] = [sizes.scene, sizes.state, sizes.loads].map(|n| vec![0.0; n]);
        let mut work = vec![0.0; sizes.work];
        let scene = Scene::bind(&file, &options, &mut a, &mut work).expect("a scene");
        let mut state = State::new(&scene, &mut b).expect("a state");
        let mut loads = Loads::new(&scene, &mut c).expect("loads");
        let step = two.internal_step();
        for (component, force) in [(0, 3.0), (2, -20.0)] {
            assert_eq!(two.set(unit.reference(V::Force(1, component)), force), 0);
        }
        let contact = Contact::new(unit.points[1].place, [3.0, 0.0, -20.0]);
        loads.add_contact(&scene, &contact).expect("a push");
        for turn in 0..9 {
            assert_eq!(two.step(f64::from(turn) * step, step), 0);
            scene.step(&mut state, &loads).expect("a step");
            for support in 0..unit.counts.supports {
                let force = (0..3).map(|c| V::ReactionForce(support, c));
                let moment = (0..3).map(|c| V::ReactionMoment(support, c));
                let exerted = scene.reaction(&state, support as usize).expect("a reaction").total();
                assert_eq!(shown(&two, &unit, force.chain(moment)), exerted, "{name}, turn {turn}");
                supports += usize::from(exerted != [0.0; 6]);
            }
            for place in 0..unit.counts.stresses {
                let node = stress_node(&file).expect("a node");
                let of_node = (0..scene.n_stress_points())
                    .filter(|&point| scene.stress_point(point).expect("a point").node == node);
                let most = of_node.map(|point| scene.stress(&state, point).expect("a stress").von_mises());
                let most = most.fold(0.0, f64::max);
                assert_eq!(shown(&two, &unit, [V::VonMises(place)]), [most], "{name}, turn {turn}");
                stresses += usize::from(most > 0.0);
            }
        }
    }
    assert!(supports >= 9 && stresses == 9, "{supports} {stresses}");
}

#[test]
fn a_free_body_flies_as_in_the_evaluator() {
    let unit = Unit::new("free.vdm");
    assert_eq!(unit.counts.free, 1);
    let log = Log::new();
    let two = unit.two(&log);
    unsafe {
        assert_eq!(fmi2SetupExperiment(two.0, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!(fmi2EnterInitializationMode(two.0), 0);
    }
    // The start, one number after the other; an attitude that is not of length one.
    let start = [
        (V::BodyPosition(2), 2.0),
        (V::BodyAttitude(0), 1.0),
        (V::BodyVelocity(2), 3.0),
        (V::BodySpin(0), 5.0),
        (V::BodySpin(1), -1.0),
    ];
    for (variable, value) in start {
        assert_eq!(two.set(unit.reference(variable), value), 0);
    }
    for component in [0, 3] {
        let status = two.set(unit.reference(V::BodyAttitude(component)), 0.0);
        assert_eq!(status, if component == 0 { 0 } else { 3 }, "{component}");
    }
    log.last(&["body_attitude", "zero"]);
    assert_eq!(two.set(unit.reference(V::BodyAttitude(0)), 1.0), 0);
    assert_eq!(unsafe { fmi2ExitInitializationMode(two.0) }, 0);

    let file = File::parse(&unit.bytes).expect("a file");
    let options = SceneOptions { contacts: 2, ..SceneOptions::default() };
    let sizes = Scene::<f64>::sizes(&file, &options).expect("sizes");
    let [mut a, mut b, mut c] = [sizes.scene, sizes.state, sizes.loads].map(|n| vec![0.0; n]);
    let mut work = vec![0.0; sizes.work];
    let scene = Scene::bind(&file, &options, &mut a, &mut work).expect("a scene");
    let mut state = State::new(&scene, &mut b).expect("a state");
    let mut loads = Loads::new(&scene, &mut c).expect("loads");
    let mut free = FreeBody::new(&scene, RigidMotion::at_rest).expect("a free body");
    let body = *free.body();
    let placed = RigidMotion {
        position: [body.centre[0], body.centre[1], 2.0],
        attitude: [1.0, 1.0, 0.0, 0.0],
        ..RigidMotion::at_rest(&body)
    };
    let placed = placed.normalised().expect("a motion");
    let turning = body.angular_momentum_of(placed.to_body([5.0, -1.0, 0.0]));
    free.set_motion(RigidMotion {
        momentum: [0.0, 0.0, 3.0 * body.mass],
        angular_momentum: placed.to_space(turning),
        ..placed
    });

    let step = two.internal_step();
    let weight = -9.81 * body.mass;
    assert_eq!(two.set(unit.reference(V::BodyForce(2)), weight), 0);
    let patterns = unit.counts.patterns;
    assert!(patterns > 0 && patterns as usize == body.first_pattern, "a pattern that is no spin");
    assert_eq!(two.set(unit.reference(V::Pattern(0)), 0.5), 0);
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-11 * (1.0 + b.abs()));
    let mut time = 0.0;
    for turn in 0..40 {
        let force = force(turn, 1);
        for (component, value) in (0..).zip(force) {
            assert_eq!(two.set(unit.reference(V::Force(1, component)), value), 0);
        }
        let internal = if turn % 7 == 0 { 3 } else { 1 };
        for _ in 0..internal {
            free.push(&scene, &mut loads, &unit.points[1], force).expect("a push");
            free.push_pattern(&scene, &mut loads, 0, 0.5).expect("a pattern");
            free.pull([0.0, 0.0, weight]);
            free.step(&scene, &mut state, &mut loads).expect("a step");
        }
        assert_eq!(two.step(time, f64::from(internal) * step), 0);
        time += f64::from(internal) * step;
        let motion = free.motion();
        let [w, x, y, z] = motion.attitude;
        assert!(near(&shown(&two, &unit, (0..3).map(V::BodyPosition)), &motion.position), "turn {turn}");
        assert!(near(&shown(&two, &unit, (0..4).map(V::BodyAttitude)), &[x, y, z, w]), "turn {turn}");
        let velocity = motion.momentum.map(|share| share / body.mass);
        assert!(near(&shown(&two, &unit, (0..3).map(V::BodyVelocity)), &velocity), "turn {turn}");
        let spin = motion.to_space(motion.spin(&body));
        assert!(near(&shown(&two, &unit, (0..3).map(V::BodySpin)), &spin), "turn {turn}");
        for (p, at) in (0..).zip(&unit.points) {
            let place = free.point(&scene, &state, at).expect("a point");
            let moved: Vec<f64> = place.iter().zip(at.position).map(|(x, rest)| x - rest).collect();
            let found = shown(&two, &unit, (0..3).map(|c| V::Displacement(p, c)));
            assert!(near(&found, &moved), "turn {turn}: {found:?}, {moved:?}");
            let velocity = free.velocity(&scene, &state, at).expect("a velocity");
            assert!(near(&shown(&two, &unit, (0..3).map(|c| V::Velocity(p, c))), &velocity), "turn {turn}");
        }
    }
    assert!(scene.energy(&state).expect("an energy") > 0.0);
    log.refused(two.set(unit.reference(V::BodyPosition(0)), 1.0), &["body_position.x", "cannot be set"]);
}

#[test]
fn a_state_comes_back_with_its_outputs_and_goes_on_alike() {
    for name in [
        "exact-f64.vdm",
        "fixed-f64.vdm",
        "parameters.vdm",
        "parametric.vdm",
        "reactions.vdm",
        "stress.vdm",
        "free.vdm",
    ] {
        let unit = Unit::new(name);
        let log = Log::new();
        let (one, other) = (unit.two(&log), unit.two(&log));
        one.start();
        let step = one.internal_step();
        let (fx, fz) = (unit.reference(V::Force(1, 0)), unit.reference(V::Force(0, 2)));
        assert_eq!((one.set(fx, 3.0), one.set(fz, -20.0)), (0, 0));
        for turn in 0..5 {
            if turn == 3 && unit.counts.parameters > 0 {
                assert_eq!(one.set(unit.reference(V::Parameter(0)), 1.25), 0);
            }
            assert_eq!(one.step(f64::from(turn) * step, step), 0);
        }
        // An input that no step has seen yet is part of the state, too.
        assert_eq!(one.set(fx, 7.0), 0);
        let (saved, shown) = (one.serialized(), one.all(&unit));
        let go_on = |two: &Two| {
            for turn in 5..12 {
                assert_eq!(two.step(f64::from(turn) * step, step), 0);
            }
            two.all(&unit)
        };
        let after = go_on(&one);
        assert_ne!(after, shown, "{name}");
        for two in [&other, &one] {
            assert_eq!(two.take(&saved), 0, "{name}");
            assert_eq!(two.all(&unit), shown, "{name}: outputs");
            assert_eq!(two.serialized(), saved, "{name}: bytes");
            assert_eq!(go_on(two), after, "{name}: afterwards");
        }
        assert_eq!(unsafe { fmi2Reset(one.0) }, 0);
        one.start();
        let fresh = unit.two(&log);
        fresh.start();
        assert_eq!(one.all(&unit), fresh.all(&unit), "{name}: reset");
        assert_eq!(one.serialized(), fresh.serialized(), "{name}: reset");
    }
}

#[test]
fn a_damaged_state_is_refused_and_changes_nothing() {
    ["parameters.vdm", "parametric.vdm"].into_iter().for_each(refuse_damaged);
}

fn refuse_damaged(name: &str) {
    let unit = Unit::new(name);
    let log = Log::new();
    let one = unit.two(&log);
    one.start();
    let step = one.internal_step();
    assert_eq!(one.set(unit.reference(V::Force(0, 2)), -20.0), 0);
    assert_eq!(one.step(0.0, step), 0);
    let (saved, shown) = (one.serialized(), one.all(&unit));
    for length in 0..saved.len() {
        assert_eq!(one.take(&saved[..length]), 3);
    }
    log.last(&["fmi2DeSerializeFMUstate", "another length"]);
    assert_eq!(one.take(&[&saved[..], &[0]].concat()), 3);
    for place in 0..saved.len() {
        let mut damaged = saved.clone();
        damaged[place] ^= 0x40;
        assert_eq!(one.take(&damaged), 3, "byte {place}");
    }
    // With a checksum that fits, every number is still looked at.
    let sealed = |mut bytes: Vec<u8>| {
        let end = bytes.len() - 4;
        let checksum = crc32fast::hash(&bytes[..end]).to_le_bytes();
        bytes[end..].copy_from_slice(&checksum);
        bytes
    };
    const HEAD: usize = 8 + 38 + 2 + 16;
    let mut refused = 0;
    for place in (HEAD..saved.len() - 4).step_by(8) {
        for value in [f64::NAN, f64::INFINITY, f64::MAX, -1.0] {
            let mut hostile = saved.clone();
            hostile[place..place + 8].copy_from_slice(&value.to_le_bytes());
            if one.take(&sealed(hostile)) == 0 {
                assert_eq!(one.take(&saved), 0);
            } else {
                refused += 1;
            }
            assert_eq!(one.all(&unit), shown, "{value} at {place}");
            assert_eq!(one.serialized(), saved, "{value} at {place}");
        }
    }
    // Every number that is not finite, but that of the step, which is no parameter here.
    let numbers = (saved.len() - 4 - HEAD) / 8 - 1;
    assert!(refused >= 2 * numbers, "{refused} of {numbers} numbers");
    for (place, value) in [(46, 3), (46, 0), (47, 4)] {
        let mut hostile = saved.clone();
        hostile[place] = value;
        assert_eq!(one.take(&sealed(hostile)), 3, "byte {place}");
    }
    assert_eq!(one.all(&unit), shown);
    let foreign = Unit::new("fixed-f64.vdm");
    assert_eq!(foreign.two(&log).take(&saved), 3);
}

#[test]
fn parameters_are_set_within_their_ranges_all_or_none() {
    ["parameters.vdm", "parametric.vdm"].into_iter().for_each(set_all_or_none);
}

fn set_all_or_none(name: &str) {
    let unit = Unit::new(name);
    let file = File::parse(&unit.bytes).expect("a file");
    let log = Log::new();
    let one = unit.two(&log);
    one.start();
    let step = one.internal_step();
    let force = unit.reference(V::Force(0, 2));
    let mut offered = 0;
    for (index, parameter) in (0..).zip(file.parameters()) {
        let reference = unit.reference(V::Parameter(index));
        let value = 0.5 * (parameter.lower + parameter.upper);
        if parameter.role == ParameterRole::TimeStep {
            log.refused(one.set(reference, value), &["there is no such variable"]);
            continue;
        }
        offered += 1;
        assert_eq!(one.set(reference, value), 0, "{}", parameter.name);
        assert_eq!(one.bits(&[reference]), [value.to_bits()]);
        let before = one.all(&unit);
        let (references, values) = ([force, reference], [-1.0, 2.0 * parameter.upper + 1.0]);
        let status = unsafe { fmi2SetReal(one.0, references.as_ptr(), 2, values.as_ptr()) };
        let named = format!("parameter.{}", parameter.name);
        log.refused(status, &["fmi2SetReal", &named, "outside of its range"]);
        assert_eq!(one.all(&unit), before, "neither of both");
    }
    assert!(offered > 0);
    assert_eq!((one.set(force, -20.0), one.step(0.0, step)), (0, 0));
    log.refused(one.set(force, f64::NAN), &["force.root.z", "NaN"]);
    let shown = unit.reference(V::Displacement(1, 0));
    log.refused(one.set(shown, 1.0), &["displacement.far 100 %s.x", "cannot be set"]);
    // A force beyond all bounds is refused by the step, which leaves the body where it was.
    let before = one.all(&unit);
    assert_eq!((one.set(force, f64::MAX), one.step(step, 2.0 * step)), (0, 3));
    assert_eq!(one.set(force, -20.0), 0);
    assert_eq!(one.all(&unit), before);
    assert_eq!(one.step(step, step), 0);
}

#[test]
fn live_regions_are_set_as_in_the_evaluator() {
    let unit = Unit::new("parametric.vdm");
    let file = File::parse(&unit.bytes).expect("a file");
    let log = Log::new();
    let one = unit.two(&log);
    one.start();
    let step = one.internal_step();
    let options =
        BodyOptions { scene: vademecum_fmu::options(&file, 2), places: 0, ..BodyOptions::default() };
    let mut memory = vec![0.0; LiveMemory::len_for::<f64>(&file, &options).expect("a length")];
    let (mut live, mut body) = LiveMemory::bind::<f64>(&file, &options, &mut memory).expect("a body");
    let (pull, tip) = (unit.reference(V::Pattern(0)), unit.reference(V::Parameter(1)));
    let shown = [V::Probe(0), V::Energy].map(|variable| unit.reference(variable));
    let mut before = vec![];
    for turn in 0..10 {
        if turn % 5 == 0 {
            body.clear();
            if turn > 0 {
                assert_eq!(one.set(tip, 3.0), 0);
                let _ = unsafe { live.set(&[(1, 3.0)], &mut body) }.expect("in its range");
                assert_ne!(live.carried().work, 0.0);
            }
            assert_eq!(one.set(pull, 1.0), 0);
            body.push_pattern(0, 1.0).expect("a load");
        }
        assert_eq!(one.step(f64::from(turn) * step, step), 0);
        body.step().expect("a step");
        let probe = body.probe(0, Field::Displacement).expect("a probe");
        let expected = [probe, body.energy().expect("an energy")].map(f64::to_bits);
        assert_eq!(one.bits(&shown), expected, "step {turn}");
        assert_ne!(std::mem::replace(&mut before, expected.to_vec()), expected);
    }
    // Steps of another length go on from there.
    assert_eq!(one.step(10.0 * step, 0.5 * step), 0);
}

#[test]
fn exact_steps_have_any_length() {
    let unit = Unit::new("exact-f64.vdm");
    let log = Log::new();
    let (whole, cut) = (unit.two(&log), unit.two(&log));
    let force = unit.reference(V::Force(0, 2));
    for one in [&whole, &cut] {
        one.start();
        assert_eq!(one.set(force, -20.0), 0);
    }
    let step = whole.internal_step();
    let near = |a: &Two, b: &Two| {
        let shown = |one| shown(one, &unit, (0..3).map(|c| V::Displacement(0, c)).chain([V::Energy]));
        shown(a).iter().zip(shown(b)).all(|(a, b)| (a - b).abs() <= 1e-9 * b.abs())
    };
    let mut time = 0.0;
    for (turn, lengths) in [&[1.5, 1.5][..], &[0.3; 10], &[2.999, 0.001], &[1.0; 3]].into_iter().enumerate() {
        assert_eq!(whole.step(time, 3.0 * step), 0);
        let mut at = time;
        for length in lengths {
            assert_eq!(cut.step(at, length * step), 0, "turn {turn}");
            at += length * step;
        }
        time += 3.0 * step;
        assert!(near(&cut, &whole), "turn {turn}");
    }
    assert_eq!(cut.step(time, 0.4 * step), 0);
    // The length of the last step is part of a state, and a refused step leaves none.
    let (saved, before) = (cut.serialized(), cut.all(&unit));
    let forces: Vec<u32> = (0..6).map(|k| unit.reference(V::Force(k / 3, k % 3))).collect();
    for length in [1.7, 0.4] {
        let held: Vec<f64> = cut.bits(&forces).into_iter().map(f64::from_bits).collect();
        let put = |numbers: &[f64]| unsafe { fmi2SetReal(cut.0, forces.as_ptr(), 6, numbers.as_ptr()) };
        assert_eq!((put(&[f64::MAX; 6]), cut.step(time + 0.4 * step, length * step)), (0, 3));
        assert_eq!((put(&held), cut.all(&unit), cut.serialized()), (0, before.clone(), saved.clone()));
    }
    let other = unit.two(&log);
    assert_eq!((other.take(&saved), other.all(&unit), other.serialized()), (0, before, saved.clone()));
    for one in [&cut, &other] {
        assert_eq!(one.step(time + 0.4 * step, 2.6 * step), 0);
    }
    assert_eq!((whole.step(time, 3.0 * step), cut.all(&unit)), (0, other.all(&unit)));
    assert!(near(&cut, &whole));
    for none in [0.0, -step, 1e-9 * step, f64::NAN, f64::INFINITY] {
        log.refused(cut.step(time + 3.0 * step, none), &["the communication step", "no time"]);
    }
}

#[test]
fn the_whole_body_is_scaled_as_in_the_evaluator() {
    let unit = Unit::new("exact-f64.vdm");
    let file = File::parse(&unit.bytes).expect("a file");
    let log = Log::new();
    let one = unit.two(&log);
    one.start();
    let step = one.internal_step();
    // The file has a live stiffness, which is no second variable.
    log.refused(one.set(unit.reference(V::Whole(0)), 2.0), &["body_stiffness", "no such variable"]);
    let settings = [(1, 0.5), (2, 3.0), (3, 1e-5)];
    for (index, value) in settings {
        assert_eq!(one.set(unit.reference(V::Whole(index)), value), 0);
        assert_eq!(shown(&one, &unit, [V::Whole(index)]), [value]);
        log.refused(one.set(unit.reference(V::Whole(index)), -1.0), &["body_", "too small"]);
    }
    assert_eq!(one.set(unit.reference(V::Force(1, 2)), -20.0), 0);
    let [density, alpha, beta] = settings.map(|(_, value)| value);
    let scene = SceneOptions { density, alpha: Some(alpha), beta: Some(beta), ..SceneOptions::default() };
    let options = BodyOptions { scene, ..BodyOptions::default() };
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options).expect("a length")];
    let mut body = Body::<f64>::bind(&file, &options, &mut memory).expect("a body");
    body.push(&unit.points[1], [0.0, 0.0, -20.0]).expect("a push");
    for turn in 0..20 {
        assert_eq!(one.step(f64::from(turn) * step, step), 0);
        body.step().expect("a step");
    }
    assert_eq!(shown(&one, &unit, [V::Energy]), [body.energy().expect("an energy")]);
    let saved = one.serialized();
    let other = unit.two(&log);
    assert_eq!((other.take(&saved), other.all(&unit)), (0, one.all(&unit)));
    let live = Unit::new("parameters.vdm");
    assert_eq!(live.counts.exact, 0);
    assert!(live.counts.all().all(|variable| !matches!(variable, V::Whole(_))));
}

#[test]
fn steps_are_multiples_at_the_right_time_and_calls_come_in_order() {
    let unit = Unit::new("fixed-f64.vdm");
    let log = Log::new();
    let one = unit.two(&log);
    let i = one.0;
    unsafe {
        let mut value = 0.0;
        log.refused(one.step(0.0, 1e-3), &["fmi2DoStep is not allowed now", "not initialized"]);
        log.refused(fmi2GetReal(i, &0, 1, &mut value), &["fmi2GetReal is not allowed now"]);
        log.refused(fmi2EnterInitializationMode(i), &["fmi2SetupExperiment"]);
        log.refused(fmi2ExitInitializationMode(i), &["fmi2ExitInitializationMode is not allowed now"]);
        log.refused(fmi2Terminate(i), &["fmi2Terminate is not allowed now"]);
        log.refused(fmi2SetupExperiment(i, 0, 0.0, f64::NAN, 0, 0.0), &["NaN"]);
        log.refused(fmi2SetupExperiment(i, 0, 0.0, 2.0, 1, 1.0), &["from 2.0 s to 1.0 s"]);
        assert_eq!(fmi2SetupExperiment(i, 0, 0.0, 0.0, 1, 4.0), 0);
        assert_eq!(fmi2EnterInitializationMode(i), 0);
        log.refused(fmi2SetupExperiment(i, 0, 0.0, 0.0, 0, 0.0), &["in its initialization"]);
        log.refused(one.step(0.0, 1e-3), &["fmi2DoStep is not allowed now"]);
        assert_eq!(fmi2ExitInitializationMode(i), 0);
    }
    let step = one.internal_step();
    for bad in [0.0, -step, 0.5 * step, 1.5 * step, step * (1.0 + 1e-6), f64::NAN, f64::INFINITY] {
        log.refused(one.step(0.0, bad), &["fmi2DoStep: the communication step", "no multiple", "internal"]);
    }
    log.refused(one.step(0.0, 1.5 * step), &[&format!("{:?}", 1.5 * step), &format!("{step:?}")]);
    log.refused(one.step(0.0, 1e12 * step), &["more than 1000000000 times"]);
    log.refused(one.step(0.5 * step, step), &["the communication point is", "the instance is at 0.0 s"]);
    log.refused(one.step(f64::NAN, step), &["NaN"]);
    // A master that adds up its steps, with all of their roundings.
    let mut time = 0.0;
    for _ in 0..1000 {
        let next = time + step;
        assert_eq!(one.step(time, next - time), 0);
        time = next;
    }
    assert_eq!(one.step(time, 7.0 * step), 0);
    log.refused(one.step(time + 7.0 * step, 1e6 * step), &["beyond the stop time, 4.0 s"]);
    unsafe {
        let (mut state, mut value) = (null_mut(), 0.0);
        log.refused(fmi2GetReal(i, &9999, 1, &mut value), &["value reference 9999"]);
        log.refused(fmi2GetReal(i, null(), 1, &mut value), &["null pointer"]);
        log.refused(fmi2GetReal(i, &0, 1, null_mut()), &["null pointer"]);
        log.refused(fmi2SetReal(i, &0, 1, &1.0), &["time", "cannot be set"]);
        log.refused(fmi2GetInteger(i, &0, 1, null_mut()), &["fmi2GetInteger", "Real"]);
        log.refused(fmi2SetString(i, &0, 1, null()), &["fmi2SetString", "Real"]);
        assert_eq!(fmi2GetBoolean(i, null(), 0, null_mut()), 0);
        let status = fmi2GetDirectionalDerivative(i, &0, 1, &0, 1, &0.0, &mut value);
        log.refused(status, &["fmi2GetDirectionalDerivative", "providesDirectionalDerivative"]);
        log.refused(fmi2SetRealInputDerivatives(i, &0, 1, &1, &0.0), &["canInterpolateInputs"]);
        log.refused(fmi2CancelStep(i), &["fmi2CancelStep"]);
        log.refused(fmi2GetStatus(i, 0, null_mut()), &["fmi2GetStatus"]);
        assert_eq!(fmi2GetRealStatus(i, 2, &mut value), 0);
        assert!((value - 1007.0 * step).abs() < 1e-9);
        log.refused(fmi2SetFMUstate(i, null_mut()), &["fmi2SetFMUstate", "null"]);
        log.refused(fmi2GetFMUstate(i, null_mut()), &["fmi2GetFMUstate", "null"]);
        assert_eq!(fmi2FreeFMUstate(i, &mut state), 0, "null is free already");
        let mut small = [0; 8];
        assert_eq!(fmi2GetFMUstate(i, &mut state), 0);
        log.refused(fmi2SerializeFMUstate(i, state, small.as_mut_ptr(), 8), &["no room"]);
        assert_eq!(fmi2GetFMUstate(i, &mut state), 0, "written over");
        assert_eq!(fmi2FreeFMUstate(i, &mut state), 0);
        log.refused(fmi2SetDebugLogging(i, 1, 1, &c"logNothing".as_ptr()), &["logStatusError and logEvents"]);
        assert_eq!(fmi2SetDebugLogging(i, 1, 1, &c"logEvents".as_ptr()), 0);
        assert_eq!(fmi2Terminate(i), 0);
        log.refused(one.step(1.0, step), &["fmi2DoStep is not allowed now: the instance has terminated"]);
        assert_eq!(fmi2GetReal(i, &0, 1, &mut value), 0, "what was reached may still be read");
        assert_eq!(fmi2Reset(i), 0);
        // Null everywhere.
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 1.0, 0), 3);
        assert_eq!(fmi3DoStep(null_mut(), 0.0, 1.0, 0, null_mut(), null_mut(), null_mut(), null_mut()), 3);
        fmi2FreeInstance(null_mut());
        fmi3FreeInstance(null_mut());
    }
}

#[test]
fn three_refuses_by_name_what_it_does_not_do() {
    let unit = Unit::new("fixed-f64.vdm");
    let log = Log::new();
    let i = unit.three(&log);
    assert!(!i.is_null());
    unsafe {
        let mut value = 0.0;
        log.refused(fmi3EnterEventMode(i), &["fmi3EnterEventMode", "hasEventMode"]);
        log.refused(fmi3SetTime(i, 0.0), &["fmi3SetTime", "co-simulation"]);
        log.refused(fmi3EnterConfigurationMode(i), &["fmi3EnterConfigurationMode"]);
        log.refused(fmi3GetInt32(i, &0, 1, null_mut(), 1), &["fmi3GetInt32", "Float64"]);
        log.refused(fmi3GetClock(i, &0, 1, null_mut()), &["fmi3GetClock", "no clocks"]);
        log.refused(fmi3GetOutputDerivatives(i, &0, 1, &1, null_mut(), 1), &["fmi3GetOutputDerivatives"]);
        log.refused(fmi3Terminate(i), &["fmi3Terminate is not allowed now"]);
        assert_eq!(fmi3EnterInitializationMode(i, 0, 0.0, 0.0, 0, 0.0), 0);
        log.refused(fmi3GetFloat64(i, &0, 1, &mut value, 2), &["2 values for 1 value references"]);
        assert_eq!(fmi3ExitInitializationMode(i), 0);
        let (mut a, mut b, mut c, mut last) = (9, 9, 9, 9.0);
        let status = fmi3DoStep(i, 0.0, 1e-3, 0, null_mut(), &mut b, &mut c, &mut last);
        log.refused(status, &["fmi3DoStep", "null"]);
        let status = fmi3DoStep(i, 0.0, 1.23e-5, 0, &mut a, &mut b, &mut c, &mut last);
        log.refused(status, &["fmi3DoStep", "0.0000123 s", "no multiple"]);
        assert_eq!((a, b, c, last), (0, 0, 0, 0.0));
        fmi3FreeInstance(i);
        let (token, environment) = (unit.token.as_ptr(), log.environment());
        let folder = c"/".as_ptr();
        let none = fmi3InstantiateModelExchange(c"x".as_ptr(), token, folder, 0, 0, environment, Some(hear3));
        log.not_made(none, &["fmi3InstantiateModelExchange", "co-simulation"]);
    }
}

#[test]
fn what_does_not_belong_together_is_not_made() {
    let unit = Unit::new("fixed-f64.vdm");
    let log = Log::new();
    let (token, uri) = (unit.token.clone(), unit.uri());
    let foreign = c"{8c4e810f-3df3-4a00-8276-176fa3c9f000}";
    log.not_made(unit.two_with(&log, foreign, &uri, 1), &["GUID", "export"]);
    log.not_made(unit.two_with(&log, &token, c"http://example.org/resources", 1), &["file:///"]);
    log.not_made(unit.two_with(&log, &token, c"file:///nowhere", 1), &["body.vdm", "cannot be opened"]);
    log.not_made(unit.two_with(&log, &token, &uri, 0), &["fmi2Instantiate", "co-simulation"]);
    let functions = log.functions();
    let make = |name: *const c_char, token: *const c_char, uri: *const c_char, functions| unsafe {
        fmi2Instantiate(name, 1, token, uri, functions, 0, 1)
    };
    let (name, id, place) = (c"beam".as_ptr(), token.as_ptr(), uri.as_ptr());
    log.not_made(make(null(), id, place, &functions), &["needs a name"]);
    log.not_made(make(name, null(), place, &functions), &["GUID"]);
    log.not_made(make(name, id, null(), &functions), &["location"]);
    assert!(make(name, id, place, null()).is_null());
    // Without a log it works all the same.
    let silent = Two(make(name, id, place, &CallbackFunctions { logger: None, ..functions }));
    assert!(!silent.0.is_null());
    silent.start();
    assert_eq!(silent.step(7.0, 1.0), 3);
    // Bytes in the resources that are no longer those of the token.
    for place in [0, unit.bytes.len() / 2, unit.bytes.len() - 1] {
        let mut damaged = unit.bytes.clone();
        damaged[place] ^= 1;
        std::fs::write(unit.resources.join("body.vdm"), damaged).expect("written");
        log.not_made(unit.two_with(&log, &token, &uri, 1), &["GUID"]);
    }
    // A file that is none, under its own token.
    let table = std::fs::read(unit.resources.join("points.bin")).expect("a table");
    for (file, table, words) in [
        (b"no vademecum".to_vec(), table.clone(), ["body.vdm", "refused"]),
        (unit.bytes.clone(), b"VDMFMU01 and no more".to_vec(), ["points.bin", "no table"]),
    ] {
        std::fs::write(unit.resources.join("body.vdm"), &file).expect("written");
        std::fs::write(unit.resources.join("points.bin"), &table).expect("written");
        let token = CString::new(vademecum_fmu::token::token(&file, &table)).expect("a token");
        log.not_made(unit.two_with(&log, &token, &uri, 1), &words);
    }
}

#[test]
fn instances_know_nothing_of_each_other() {
    let unit = Unit::new("fixed-f64.vdm");
    let log = Log::new();
    let step = {
        let one = unit.two(&log);
        log.last(&["vademecum", "3 modes", "internal step"]);
        one.start();
        one.internal_step()
    };
    let turn = |one: &Two, k: u32, turn: u32| {
        assert_eq!(one.set(unit.reference(V::Force(0, 2)), f64::from(k + turn)), 0);
        assert_eq!(one.step(f64::from(turn) * step, step), 0);
    };
    let alone = |k: u32| {
        let log = Log::new();
        let one = unit.two(&log);
        one.start();
        (0..50).for_each(|t| turn(&one, k, t));
        one.all(&unit)
    };
    let wanted: Vec<Vec<u64>> = (0..4).map(alone).collect();
    assert_ne!(wanted[0], wanted[1]);
    // In threads, and side by side in one thread.
    let found: Vec<Vec<u64>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|k| scope.spawn(move || alone(k))).collect();
        threads.into_iter().map(|thread| thread.join().expect("a thread")).collect()
    });
    assert_eq!(found, wanted);
    let all: Vec<Two> = (0..4).map(|_| unit.two(&log)).collect();
    all.iter().for_each(Two::start);
    for t in 0..50 {
        (0..).zip(&all).for_each(|(k, one)| turn(one, k, t));
    }
    let found: Vec<Vec<u64>> = all.iter().map(|one| one.all(&unit)).collect();
    assert_eq!(found, wanted);
}
