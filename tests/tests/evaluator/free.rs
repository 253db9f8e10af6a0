//! Free bodies, from the problem to the motion in space, against closed forms and against all modes of the
//! whole matrices.

use std::path::{Path, PathBuf};
use std::process::Command;

use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side};
use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{
    Contact, Field, FreeBody, Loads, RigidBody, RigidMotion, Scene, SceneOptions, Simulation, State, Surface,
};
use vademecum_format::{File, SectionKind};
use vademecum_rewrite::{Fault, Keep, RewriteError, check, pack, strip};
use vademecum_tests::golden;
use vademecum_tests::program::{Ran, program as executable, repository, vademecum};
use vademecum_tests::synthetic::rewritten;

/// A rod along x of a material that does not contract, so that the theory of rods is exact but for its
/// thickness.
const ROD: &str = r#"
[mesh]
block = { lengths = [1.0, 0.025, 0.02], divisions = [10, 1, 1] }
[[material]]
young = 1e7
poisson = 0.0
density = 1000.0
[load]
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
[damping]
ratio = 1.0
[time]
step = 1e-3
[basis]
modes = 12
[tolerance]
error = 1.0
[[parameter]]
name = "density"
kind = "density"
range = [0.5, 2.0]
[[parameter]]
name = "stiffness"
kind = "stiffness"
range = [0.5, 2.0]
"#;

pub(super) fn problem(text: &str) -> Problem {
    Problem::parse(text, "free.toml", PathBuf::new()).expect("a problem")
}

/// Runs the program with its notes.
fn aloud(arguments: &[&str]) -> Ran {
    Ran::new(&Command::new(executable()).args(arguments).output().expect("the program starts"))
}

pub(super) fn built(text: &str) -> Vec<u8> {
    build(&problem(text), &BuildOptions::default(), &Silent).expect("built").either().bytes
}

/// A free body in memory of its own.
pub(super) struct Flight {
    pub(super) simulation: Simulation<f64>,
    pub(super) free: FreeBody,
}

impl Flight {
    pub(super) fn new(
        bytes: &[u8],
        options: &SceneOptions,
        motion: impl FnOnce(&RigidBody) -> RigidMotion,
    ) -> Self {
        let simulation = Simulation::<f64>::new(bytes.to_vec(), options).expect("bound");
        let free = FreeBody::new(simulation.scene(), motion).expect("a free body");
        Self { simulation, free }
    }

    pub(super) fn step(&mut self, mut push: impl FnMut(&mut FreeBody, &Scene<'_, f64>, &mut Loads<'_, f64>)) {
        let free = &mut self.free;
        self.simulation.with(|scene, state, loads| {
            push(free, scene, loads);
            free.step(scene, state, loads).expect("a step");
        });
    }

    pub(super) fn point(&self, at: [f64; 3]) -> [f64; 3] {
        let point = self.simulation.locate(at).expect("a surface");
        self.free.point(self.simulation.scene(), self.simulation.state(), &point).expect("a point")
    }

    pub(super) fn displacement(&self, at: [f64; 3]) -> [f64; 3] {
        let point = self.simulation.locate(at).expect("a surface");
        self.simulation.point(&point, Field::Displacement).expect("a point")
    }
}

pub(super) fn nothing(_: &mut FreeBody, _: &Scene<'_, f64>, _: &mut Loads<'_, f64>) {}

#[test]
fn a_spinning_rod_grows_as_the_closed_form_says_at_live_density_and_stiffness() {
    let bytes = built(ROD);
    for (density, stiffness) in [(1.0, 1.0), (2.0, 0.5)] {
        let mut options = SceneOptions::default();
        let file = File::parse(&bytes).expect("a file");
        options.set(file.metadata(), &[(0, density)]).expect("in range");
        options.set(file.metadata(), &[(1, stiffness)]).expect("in range");
        let spin = 4.0;
        let mut flight =
            Flight::new(&bytes, &options, |body| RigidMotion::thrown(body, [0.0; 3], [0.0, 0.0, spin]));
        assert!((flight.free.body().mass - 0.5 * density).abs() < 1e-12);
        for _ in 0..4000 {
            flight.step(nothing);
        }
        // ρ ω² L³ / (24 E) at each end, from the centre: the thickness adds its square over that of the
        // length.
        let expected = 1000.0 * density * spin * spin / (24.0 * 1e7 * stiffness);
        for (end, sign) in [([1.0, 0.0125, 0.01], 1.0), ([0.0, 0.0125, 0.01], -1.0)] {
            let [grown, across, up] = flight.displacement(end);
            assert!((sign * grown / expected - 1.0).abs() < 2e-3, "{grown} {expected}");
            assert!(across.abs() < 1e-3 * expected && up.abs() < 1e-3 * expected);
            // In space the end is on its circle, half a length and what it grew from the centre.
            let place = flight.point(end);
            let radius = (0..3).map(|c| (place[c] - [0.5, 0.0125, 0.01][c]).powi(2)).sum::<f64>().sqrt();
            assert!((radius - 0.5 - expected).abs() < 2e-3 * expected);
        }
    }
}

#[test]
fn the_stress_in_a_spinning_rod_is_that_of_the_closed_form() {
    let bytes = built(&format!("{ROD}[output]\nstress = \"surface\"\n"));
    let spin = 4.0;
    let thrown = |body: &RigidBody| RigidMotion::thrown(body, [0.0; 3], [0.0, 0.0, spin]);
    let mut flight = Flight::new(&bytes, &SceneOptions::default(), thrown);
    for _ in 0..4000 {
        flight.step(nothing);
    }
    let (scene, state) = (flight.simulation.scene(), flight.simulation.state());
    let largest = (0..scene.n_stress_points())
        .map(|point| scene.stress(state, point).expect("a stress").0[0])
        .fold(f64::MIN, f64::max);
    // ρ ω² L² / 8 in the middle. Elements of a tenth of the length have a linear stress, which misses the
    // parabola by h²/6 over L²/4.
    let expected = 1000.0 * spin * spin / 8.0;
    assert!((largest / expected - 1.0).abs() < 7e-3, "{largest} {expected}");
}

pub(super) fn dense(a: &SymmetricMatrix) -> Mat<f64> {
    let mut image = Mat::zeros(a.n(), a.n());
    a.mul_into(Mat::<f64>::identity(a.n(), a.n()).as_ref(), image.as_mut());
    image
}

#[test]
fn a_pushed_brick_moves_as_all_modes_of_the_whole_matrices_say_the_rigid_ones_included() {
    let text = "[mesh]\nblock = { lengths = [0.3, 0.2, 0.1], divisions = [2, 1, 1], order = \"linear\" }\n\
                [[material]]\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n[time]\nstep = 1e-4\n\
                [basis]\nmodes = 30\n[tolerance]\nerror = 1.0\nsteps = 50\n";
    let problem = problem(text);
    let Prepared { body, .. } =
        prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a free body");
    let pencil = body.model.pencil();
    let n = pencil.n_dof();
    assert_eq!(n - 6, 30, "all elastic modes are in the file");
    let lower = dense(pencil.mass()).llt(Side::Lower).expect("positive");
    let mut reduced = dense(pencil.stiffness());
    solve_lower_triangular_in_place(lower.L(), reduced.as_mut(), Par::Seq);
    solve_lower_triangular_in_place(lower.L(), reduced.as_mut().transpose_mut(), Par::Seq);
    let modes = reduced.self_adjoint_eigen(Side::Lower).expect("modes");
    let mut vectors = modes.U().to_owned();
    solve_upper_triangular_in_place(lower.L().transpose(), vectors.as_mut(), Par::Seq);
    let squares: Vec<f64> = (0..n).map(|k| modes.S()[k]).collect();
    let still = 1e-9 * squares[n - 1];
    assert_eq!(squares.iter().filter(|&&square| square.abs() < still).count(), 6);

    // So light a push that turning stays linear.
    let (at, force) = ([0.3, 0.2, 0.1], [1e-4, 2e-4, -3e-4]);
    let nodes = &body.model.mesh().nodes;
    let find = |p: [f64; 3]| nodes.iter().position(|x| (0..3).all(|c| (x[c] - p[c]).abs() < 1e-12));
    let node = find(at).expect("a corner");
    let bytes = built(text);
    let mut flight = Flight::new(&bytes, &SceneOptions::default(), RigidMotion::at_rest);
    let steps = 400;
    let pushed = flight.simulation.locate(at).expect("a corner");
    for _ in 0..steps {
        flight.step(|free, scene, loads| free.push(scene, loads, &pushed, force).expect("a push"));
    }
    let time = steps as f64 * 1e-4;
    let answer = |square: f64| match square.abs() < still {
        true => 0.5 * time * time,
        false => (1.0 - (square.sqrt() * time).cos()) / square,
    };
    let mut largest = 0.0f64;
    let mut compared = 0;
    for (other, place) in nodes.iter().enumerate() {
        let moved = |c: usize| -> f64 {
            let share = |k: usize| (0..3).map(|f| vectors[(3 * node + f, k)] * force[f]).sum::<f64>();
            (0..n).map(|k| vectors[(3 * other + c, k)] * share(k) * answer(squares[k])).sum()
        };
        let found = flight.point(*place);
        for c in 0..3 {
            let (expected, found) = (moved(c), found[c] - place[c]);
            largest = largest.max((found - expected).abs());
            compared += usize::from(expected.abs() > 1e-9);
        }
    }
    // The push moves it by 1e-7 m to 1e-6 m and turns it by 1e-6, whose square is what is left.
    assert!(compared > 30 && largest < 1e-11, "{compared} {largest:e}");
    let body = flight.free.body();
    for c in 0..3 {
        let impulse = force[c] * time;
        assert!((flight.free.motion().momentum[c] - impulse).abs() < 1e-12 * impulse.abs());
    }
    assert!((body.mass - 6.0).abs() < 1e-12);
}

#[test]
fn a_host_that_turns_the_body_itself_sees_the_same_elastic_motion() {
    let bytes = built(ROD);
    let file = File::parse(&bytes).expect("a file");
    let options = SceneOptions::default();
    let spin = [0.3, 4.0, 0.2];
    let mut flight = Flight::new(&bytes, &options, |body| RigidMotion::thrown(body, [0.0; 3], spin));
    let sizes = Scene::<f64>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state_memory).expect("a state");
    let mut loads = Loads::new(&scene, &mut load_memory).expect("loads");
    let touched = Surface::new(&file).expect("a surface").locate([0.9, 0.0, 0.02]).expect("a point");
    let mut largest = 0.0f64;
    for _ in 0..200 {
        // The engine's own motion: where the body is now, halfway, and at the end of the step.
        let body = *flight.free.body();
        let (before, middle) = (*flight.free.motion(), flight.free.middle(&scene));
        flight.step(|free, scene, loads| free.push(scene, loads, &touched, [0.0, 1.0, 2.0]).expect("a push"));
        let after = *flight.free.motion();
        let force = middle.to_body([0.0, 1.0, 2.0]);
        loads.clear();
        let contact = Contact::new(touched.place, force);
        loads.add_contact(&scene, &contact).expect("a contact");
        loads.add_spin(&scene, before.spin(&body), after.spin(&body)).expect("free");
        scene.step(&mut state, &loads).expect("a step");
        assert_eq!(state.zeta(), flight.simulation.state().zeta());
        largest = largest.max(state.zeta().iter().fold(0.0, |m, x| m.max(x.abs())));
    }
    assert!(largest > 1e-4, "it swings: {largest}");
}

#[test]
fn gravity_and_patterns_move_the_centre_as_they_should_and_spins_are_not_pushed_by_hand() {
    let bytes = built(ROD);
    let mut flight = Flight::new(&bytes, &SceneOptions::default(), |body| {
        RigidMotion::thrown(body, [1.0, 2.0, 3.0], [0.0; 3])
    });
    // The pattern `gravity` is an acceleration: its force is the mass times it, without a moment.
    for _ in 0..100 {
        flight.step(|free, scene, loads| {
            free.push_pattern(scene, loads, 0, 1.0).expect("gravity");
            assert!(free.push_pattern(scene, loads, 1, 1.0).is_err(), "a pattern of the angular velocity");
        });
    }
    let RigidMotion { position, angular_momentum, attitude, .. } = *flight.free.motion();
    let expected = [0.6, 0.2125, 0.01 + 0.3 - 0.5 * 9.81 * 0.01];
    for c in 0..3 {
        assert!((position[c] - expected[c]).abs() < 1e-12, "{position:?} {expected:?}");
        assert!(angular_momentum[c].abs() < 1e-12);
    }
    assert!((attitude[0] - 1.0).abs() < 1e-12);
    // The elastic motion does not see gravity.
    assert!(flight.displacement([1.0, 0.0125, 0.01]).iter().all(|u| u.abs() < 1e-12));
    // A live density keeps the velocity.
    flight.simulation.set_parameters(&[(0, 2.0)]).expect("in range");
    let before = flight.free.motion().position;
    flight.step(nothing);
    let moved = flight.free.motion().position[0] - before[0];
    assert!((moved - 1e-3).abs() < 1e-12 && (flight.free.body().mass - 1.0).abs() < 1e-12);
}

#[test]
fn long_flights_keep_the_momenta_while_the_body_rings_in_both_precisions() {
    fn fly<T: vademecum_eval::Scalar + 'static>(bytes: &[u8]) {
        let mut simulation = Simulation::<T>::new(bytes.to_vec(), &SceneOptions::default()).expect("bound");
        let thrown = |body: &RigidBody| RigidMotion::thrown(body, [0.1, 0.2, 0.3], [0.5, 6.0, 3.0]);
        let mut free = FreeBody::new(simulation.scene(), thrown).expect("a free body");
        let start = *free.motion();
        let energy = start.energy(free.body());
        let mut worst = 0.0f64;
        for _ in 0..100_000 {
            simulation.with(|scene, state, loads| free.step(scene, state, loads).expect("a step"));
            worst = worst.max((free.motion().energy(free.body()) / energy - 1.0).abs());
        }
        assert_eq!(free.motion().momentum, start.momentum);
        assert_eq!(free.motion().angular_momentum, start.angular_momentum);
        let length: f64 = free.motion().attitude.iter().map(|x| x * x).sum();
        assert!((length - 1.0).abs() < 1e-15 * 4.0 && worst < 1e-4, "{length} {worst:e}");
        let elastic = simulation.energy().expect("energy");
        assert!(elastic > 0.0 && elastic < 1e-2 * energy, "{elastic} {energy}");
    }
    let bytes = built(ROD);
    fly::<f64>(&bytes);
    fly::<f32>(&bytes);
}

#[test]
fn a_file_of_a_body_that_is_held_has_no_rigid_motion() {
    let bytes = golden::named("exact-f64.vdm");
    let mut simulation = Simulation::<f64>::new(bytes, &SceneOptions::default()).expect("bound");
    assert!(simulation.scene().rigid_body().is_none());
    assert!(FreeBody::new(simulation.scene(), RigidMotion::at_rest).is_none());
    let spun = simulation.with(|scene, _, loads| loads.add_spin(scene, [1.0; 3], [1.0; 3]));
    assert_eq!(spun, Err(vademecum_eval::LoadError::Missing { kind: SectionKind::RigidBody }));
}

#[test]
fn packed_and_stripped_files_stay_free() {
    let bytes = golden::named("free.vdm");
    let body = RigidBody::of(&File::parse(&bytes).expect("a file")).expect("free");
    let packed = pack(&bytes, 3).expect("packed");
    for small in [strip(&bytes, Keep::Probes).expect("stripped"), packed] {
        let simulation = Simulation::<f64>::new(small, &SceneOptions::default()).expect("bound");
        assert_eq!(simulation.scene().rigid_body(), Some(body));
    }
}

#[test]
fn the_deep_check_finds_what_no_body_has() {
    let bytes = golden::named("free.vdm");
    check(&bytes).expect("sound");
    let changed = |place: usize, value: f64| {
        let file = File::parse(&bytes).expect("a file");
        let mut stored = file.section(SectionKind::RigidBody).expect("free").stored().to_vec();
        stored[8 * place..8 * place + 8].copy_from_slice(&value.to_le_bytes());
        let put = stored.clone();
        rewritten(
            &bytes,
            |_| (),
            |section| {
                if section.kind == SectionKind::RigidBody {
                    // Lives as long as the test.
                    section.stored = Box::leak(put.clone().into_boxed_slice());
                }
            },
            &[],
        )
    };
    let first = File::parse(&bytes).expect("a file").metadata().n_patterns as usize - 6;
    for (place, value, expected) in [
        (0, -2.0, Fault::Negative),
        (0, 0.0, Fault::Negative),
        (4, 2.0, Fault::Negative),
        (5, 1.0, Fault::Negative),
        (10, 0.5, Fault::Disagrees),
        (10, first as f64 + 1.0, Fault::Disagrees),
        (11 + 6 * first, 0.125, Fault::Disagrees),
        (11 + 6 * first + 5, 0.25, Fault::Disagrees),
    ] {
        match check(&changed(place, value)) {
            Err(RewriteError::Unsound { kind: SectionKind::RigidBody, fault, .. }) if fault == expected => {}
            other => panic!("{place} {value}: {other:?}"),
        }
    }
}

/// Runs the program on a problem in a folder of its own.
fn program(folder: &Path, name: &str, text: &str, arguments: &[&str]) -> Ran {
    std::fs::write(folder.join(name), text).expect("written");
    let mut all = vec![arguments[0].to_string(), folder.join(name).display().to_string()];
    all.extend(arguments[1..].iter().map(|argument| (*argument).to_string()));
    vademecum(&all)
}

#[test]
fn the_program_builds_throws_and_tells_of_a_free_body() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let file = path("rod.vdm");
    std::fs::write(folder.path().join("rod.toml"), ROD).expect("written");
    let mut told = std::process::Command::new(vademecum_tests::program::program());
    let ran = Ran::new(&told.args(["build", &path("rod.toml"), "-o", &file]).output().expect("it starts"));
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stderr.contains("no `[[support]]`: the body is free"), "{}", ran.stderr);
    let modes = program(folder.path(), "rod.toml", ROD, &["modes", "--count", "4"]);
    assert!(modes.stdout.contains("6 rigid motions of no frequency"), "{}", modes.stdout);
    let told = vademecum(&["info", &file, "--json"]).json();
    assert!((told["free_body"]["mass"].as_f64().expect("a mass") - 0.5).abs() < 1e-12);
    assert!(vademecum(&["info", &file]).stdout.contains("free body: mass 5.0"));
    assert_eq!(vademecum(&["verify", &file, "--file-only"]).code, Some(0));

    let scenario = "duration = 0.5\n[free]\nvelocity = [1.0, 0.0, 2.0]\nspin = [0.0, 0.0, 6.0]\ngravity = [0.0, 0.0, \
                    -10.0]\n[output]\nprobes_every = 500\nfields_every = 500\n[[output.probe]]\nname = \"end\"\n\
                    point = [1.0, 0.0125, 0.01]\ndirection = [1.0, 0.0, 0.0]\n";
    std::fs::write(folder.path().join("throw.toml"), scenario).expect("written");
    let out = path("out");
    let ran = vademecum(&["run", &file, "--scenario", &path("throw.toml"), "-o", &out]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let table = std::fs::read_to_string(folder.path().join("out/probes.csv")).expect("a table");
    let head = "time_s,energy_J,end [m],rigid energy_J,centre x [m],centre y [m],centre z [m],q_w [1],q_x [1],q_y [1],q_z [1],end \
                in space x [m],end in space y [m],end in space z [m]";
    assert_eq!(table.lines().next(), Some(head));
    let last: Vec<f64> =
        table.lines().last().expect("rows").split(',').map(|x| x.parse().expect("a number")).collect();
    let expected = [1.0, 0.0125, 0.01 + 1.0 - 1.25];
    for c in 0..3 {
        assert!((last[4 + c] - expected[c]).abs() < 1e-8, "{last:?}");
    }
    // Three radians about z; the end is half a length from the centre.
    assert!((last[7] - 1.5f64.cos()).abs() < 1e-8 && (last[10] - 1.5f64.sin()).abs() < 1e-8, "{last:?}");
    let radius = 0.5 + last[2];
    assert!((last[11] - expected[0] - radius * 3.0f64.cos()).abs() < 1e-5, "{last:?}");
    assert!((last[12] - expected[1] - radius * 3.0f64.sin()).abs() < 1e-5, "{last:?}");
    // The field shows the body there: its displacement is that of space.
    assert!(folder.path().join("out/field-000001.vtu").is_file());

    let modes = program(folder.path(), "rod.toml", ROD, &["modes", "--json"]).json();
    assert_eq!(modes["rigid_motions"].as_u64(), Some(6));
}

#[test]
fn the_frequency_response_is_that_of_the_elastic_motion_at_full_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("rod.vdm").display().to_string();
    let text = ROD.replace("ratio = 1.0", "alpha = 2.0\nbeta = 1e-6");
    let text = text.split("[[parameter]]").next().expect("a problem");
    assert_eq!(program(folder.path(), "rod.toml", text, &["build", "-o", &file]).code, Some(0));
    let problem = folder.path().join("rod.toml").display().to_string();
    let ends = ["--in", "1.0,0.0125,0.02,z", "--out", "0.0,0.0125,0.02,z", "--out", "1.0,0.0125,0.02,z"];
    // Up to a third of the highest mode of the file: what the constant residual misses is of the order of
    // the square of that, for a file of so few modes.
    let modes = vademecum(&["modes", &problem, "--json"]).json();
    let highest = modes["frequencies_hz"][11].as_f64().expect("twelve modes");
    let span = format!("0.5,{}", highest / 3.0);
    let range = ["--range", &span, "--problem", &problem, "--compare", "20", "--json"];
    let ran = vademecum(&[&["frf", file.as_str()][..], &ends[..], &range[..]].concat()).json();
    let worst = ran["compared"]["worst"].as_f64().expect("a comparison");
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn what_a_free_body_cannot_have_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("none.vdm").display().to_string();
    let plain: String = ROD.split("[[parameter]]").next().expect("a problem").into();
    let build = |text: &str| program(folder.path(), "p.toml", text, &["build", "-o", &file]);
    let bathe = plain
        .replace("step = 1e-3", "step = 1e-3\nscheme = { name = \"bathe\" }")
        .replace("ratio = 1.0", "alpha = 1.0");
    build(&bathe).fails(3, &["p.toml", "`support` is none beside the time scheme bathe", "flies freely"]);
    build(&plain.replace("modes = 12", "kind = \"ritz\"\nmodes = 4").replace("ratio = 1.0", "alpha = 1.0"))
        .fails(3, &["p.toml", "`support` is none beside a basis of"]);
    build(&format!("{plain}[output]\nstatic_fields = true\n"))
        .fails(3, &["p.toml", "`output.static_fields`", "a body that is held"]);
    build(&plain.replace("\"gravity\"", "\"centrifugal xy\""))
        .fails(3, &["`load.pattern[0].name`", "another name"]);
    let region = "[[parameter]]\nname = \"a\"\nkind = \"stiffness\"\nregion = \"body\"\nrange = [0.5, 2.0]\n";
    let separated = "representation = \"separated\"\n".to_string() + &plain;
    build(&(separated.replace("ratio = 1.0", "alpha = 1.0") + region))
        .fails(3, &["`support` is none beside a live parameter of a region"]);
    let hinge = "[[support]]\non = { box = { min = [-1, -1, -1], max = [0.01, 0.01, 1] } }\n";
    build(&(plain.clone() + hinge)).fails(5, &["can still move in 1 of the 6 rigid ways"]);

    let scenario = folder.path().join("throw.toml");
    std::fs::write(&scenario, "duration = 1.0\n[free]\n").expect("written");
    let held = folder.path().join("held.vdm");
    std::fs::write(&held, golden::named("exact-f64.vdm")).expect("written");
    let run =
        ["run", &held.display().to_string(), "--scenario", &scenario.display().to_string(), "-o", &file];
    vademecum(&run).fails(7, &["`[free]`", "a body with supports"]);
}

#[test]
fn the_free_plate_of_nafems() {
    let problem = repository().join("fixtures/problems/free-plate.toml").display().to_string();
    let told = vademecum(&["modes", &problem, "--count", "6", "--json"]).json();
    assert_eq!(told["rigid_motions"], 6);
    let found = told["frequencies_hz"].as_array().expect("frequencies").iter();
    let found: Vec<f64> = found.map(|hertz| hertz.as_f64().expect("a frequency")).collect();
    // FV12 of the benchmarks, closed form of a thin plate; the fourth and the fifth are of one frequency.
    for (found, expected) in found.iter().zip([1.622, 2.360, 2.922, 4.233, 4.233, 7.416]) {
        assert!((found / expected - 1.0).abs() < 0.01, "{found} Hz, {expected} Hz");
    }
    assert_eq!(found.len(), 6);
}

#[test]
fn a_load_on_a_body_that_flies_acts_by_its_integral_over_the_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let bar = FREE_BAR.replace("step = 1e-4", "step = 1e-3");
    std::fs::write(path("free.toml"), bar).expect("written");
    assert_eq!(vademecum(&["build", &path("free.toml"), "-o", &path("free.vdm")]).code, Some(0));
    // Mass 0.12 kg: the velocity of the centre, from its place at the last two of 40 steps.
    let momentum = |start: f64, end: f64| {
        let text = format!(
            "duration = 0.04\n[free]\nvelocity = [0.0, 0.0, 0.0]\n[[contact]]\npoint = [0.2, 0.01, 0.03]\n\
             force = [0.0, 0.0, 1.0]\nstart = {start}\nend = {end}\n[output]\nprobes_every = 1\n"
        );
        std::fs::write(path("tap.toml"), text).expect("written");
        let out = path("out");
        let ran = aloud(&["run", &path("free.vdm"), "--scenario", &path("tap.toml"), "-o", &out, "--force"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert!(!ran.stderr.contains("moves nothing"), "{}", ran.stderr);
        let table = std::fs::read_to_string(folder.path().join("out/probes.csv")).expect("a table");
        let head: Vec<&str> = table.lines().next().expect("a head").split(',').collect();
        let column =
            head.iter().position(|name| *name == "centre z [m]").unwrap_or_else(|| panic!("{head:?}"));
        let z: Vec<f64> = table
            .lines()
            .skip(1)
            .map(|row| row.split(',').nth(column).expect("a column").parse().expect("a number"))
            .collect();
        0.12 * (z[z.len() - 1] - z[z.len() - 2]) / 1e-3
    };
    // One, two and ten steps; a tap inside of a step; one that begins in a step and ends in another.
    for [start, end] in [[0.0, 0.001], [0.0, 0.002], [0.0, 0.01], [0.0102, 0.0104], [0.0031, 0.0047]] {
        let found = momentum(start, end);
        // Ten digits of the table, of which a step takes three.
        assert!((found / (end - start) - 1.0).abs() < 1e-4, "{start} to {end}: {found}");
    }
}

#[test]
fn the_attitude_under_loads_of_a_scenario_converges_with_order_two() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("free.toml"), FREE_BAR).expect("written");
    assert_eq!(vademecum(&["build", &path("free.toml"), "-o", &path("free.vdm")]).code, Some(0));
    let scenario = "duration = 0.02\n[free]\n[[contact]]\npoint = [0.2, 0.01, 0.03]\n\
                    force = [0.0, 3.0, 4.0]\n[[contact]]\npoint = [0.2, 0.02, 0.0]\n\
                    force = [3.0, 0.0, -2.0]\nstart = 0.004\nend = 0.016\n";
    std::fs::write(path("push.toml"), scenario).expect("written");
    let attitude = |step: &str| -> Vec<f64> {
        let out = path(step);
        let run =
            ["run", &path("free.vdm"), "--scenario", &path("push.toml"), "--time-step", step, "-o", &out];
        let ran = vademecum(&run);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let table = std::fs::read_to_string(Path::new(&out).join("probes.csv")).expect("a table");
        let columns = table.lines().next().expect("a head").split(',').map(|name| name.starts_with("q_"));
        let row = table.lines().last().expect("a row").split(',');
        row.zip(columns).filter(|(_, is)| *is).map(|(value, _)| value.parse().expect("a number")).collect()
    };
    let exact = attitude("1e-6");
    let error = |step: &str| -> f64 {
        attitude(step).iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let order = (error("4e-4") / error("2e-4")).log2();
    assert!((order - 2.0).abs() < 0.01, "{order}");
}

/// A short bar without supports.
const FREE_BAR: &str = r#"
[mesh]
block = { lengths = [0.2, 0.02, 0.03], divisions = [8, 1, 2] }
[[material]]
young = 2e8
poisson = 0.3
density = 1000.0
[damping]
ratio = 0.02
[time]
step = 1e-4
[basis]
modes = 16
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
"#;

#[test]
fn a_thrown_body_has_a_note_on_a_spin_beyond_the_model_and_all_digits_far_away() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("free.toml"), FREE_BAR).expect("written");
    assert_eq!(vademecum(&["build", &path("free.toml"), "-o", &path("free.vdm")]).code, Some(0));
    let thrown = |free: &str| {
        let text = format!("duration = 1e-3\n[free]\n{free}[output]\nprobes_every = 1\n");
        std::fs::write(path("throw.toml"), text).expect("written");
        let out = path("out");
        let ran =
            aloud(&["run", &path("free.vdm"), "--scenario", &path("throw.toml"), "-o", &out, "--force"]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        (ran.stderr, std::fs::read_to_string(folder.path().join("out/probes.csv")).expect("a table"))
    };
    // The first frequency of the bar is near 1440 rad/s.
    let (notes, _) = thrown("spin = [0.0, 800.0, 300.0]\n");
    assert!(notes.contains("`free.spin` of 854.4004 rad/s is 0."), "{notes}");
    assert!(notes.contains("leaves out the Coriolis force"), "{notes}");
    // The rigid motion has more digits than the ten of displacements; every column has its unit.
    let (notes, table) = thrown("velocity = [1234.56789012345, 0.0, 0.0]\nspin = [0.0, 50.0, 0.0]\n");
    assert!(!notes.contains("free.spin"), "{notes}");
    let mut rows = table.lines();
    let head: Vec<&str> = rows.next().expect("a head").split(',').collect();
    for column in ["rigid energy_J", "centre x [m]", "q_w [1]"] {
        assert!(head.contains(&column), "{head:?}");
    }
    let x = head.iter().position(|name| *name == "centre x [m]").expect("a column");
    let x = rows.map(|row| row.split(',').nth(x).expect("a column").parse::<f64>().expect("a number"));
    for (n, x) in x.enumerate() {
        let expected = 0.1 + 1234.56789012345 * 1e-4 * n as f64;
        assert!((x / expected - 1.0).abs() < 1e-13, "{x} m, {expected} m after {n} steps");
    }
}

#[test]
fn verify_of_a_free_body_measures_its_elastic_motion() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("free.toml"), FREE_BAR).expect("written");
    assert_eq!(vademecum(&["build", &path("free.toml"), "-o", &path("free.vdm")]).code, Some(0));
    let verify = |loads: &str| {
        std::fs::write(path("c.toml"), format!("duration = 0.02\n{loads}")).expect("written");
        let (problem, scenario) = (path("free.toml"), path("c.toml"));
        let line = ["verify", &path("free.vdm"), "--problem", &problem, "--scenario", &scenario, "--json"];
        vademecum(&line)
    };
    let contact = "[[contact]]\npoint = [0.2, 0.01, 0.03]\nforce = [0.0, 0.0, 1.0]\n";
    let weight = "[[pattern]]\nname = \"gravity\"\n";
    let spin = "[[pattern]]\nname = \"centrifugal xx\"\namplitude = 100.0\n";
    for loads in [contact.to_string(), spin.into(), format!("{contact}{weight}"), format!("{contact}{spin}")]
    {
        let ran = verify(&loads);
        assert_eq!(ran.code, Some(0), "{loads}: {}", ran.stderr);
        let figures = ran.json();
        let of = |key: &str| figures[key].as_f64().unwrap_or_else(|| panic!("{loads}: {key} in {figures}"));
        // The file moves its modes exactly, so it misses what its basis cannot show: under the spin the bar
        // stretches, of which sixteen modes show two thirds. The reference is known better than that.
        assert!(of("basis_error") < 0.4, "{loads}: {figures}");
        assert!((of("total_error") / of("basis_error") - 1.0).abs() < 1e-3, "{loads}: {figures}");
        assert!(of("truth_error") > 0.0 && of("truth_error") < 0.1 * of("total_error"), "{loads}: {figures}");
    }
    // A weight alone deforms nothing: there is no error to measure.
    let ran = verify(weight);
    assert_eq!(ran.code, Some(5), "{}", ran.stderr);
    assert!(ran.stderr.contains("was not measured"), "{}", ran.stderr);
}
