//! Bodies that touch. `cargo bench -p vademecum-tests --bench world` prints the time of binding a world and
//! of its step, and at the end the step as a number of plain steps of the same bodies, measured in turns.

use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

use divan::Bencher;
use divan::counter::ItemsCount;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{
    Body, BodyOptions, Contact, Member, Nodes, Place, Pose, RigidMotion, RigidShape, Touching, World,
    WorldBuffers, WorldOptions,
};
use vademecum_format::File;

const RUBBER: &str = "[[material]]\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n[damping]\nratio = 0.05\n";
/// Sweeps of a step: the tolerance is 0, so each step does all of them.
const SWEEPS: usize = 20;
/// Rounds in which two loops take turns.
const ROUNDS: usize = 101;

fn main() {
    divan::main();
    ratios();
}

fn built(cells: &str, lengths: &str, rest: &str) -> Vec<u8> {
    let text = format!(
        "[mesh]\nblock = {{ lengths = {lengths}, divisions = {cells}, order = \"linear\" }}\n{RUBBER}{rest}"
    );
    let problem = Problem::parse(&text, "body.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}

/// A cube with 81 nodes on its lower face and the base under it, of 32 modes each; with 64 further modes for
/// contacts if `further`.
fn cube_and_base(further: bool) -> [Vec<u8>; 2] {
    let patch = if further { "contact_patch = 0.03\ncontact_modes = 64\n" } else { "" };
    let rest =
        format!("[basis]\nmodes = 32\n[tolerance]\nerror = 10.0\n[output]\nprecision = \"f64\"\n{patch}");
    let held = format!("[[support]]\non = {{ group = \"z_min\" }}\n{rest}");
    [built("[8, 8, 8]", "[0.08, 0.08, 0.08]", &rest), built("[10, 10, 5]", "[0.16, 0.16, 0.08]", &held)]
}

fn options() -> BodyOptions {
    let mut options = BodyOptions::default();
    options.scene.time_step = Some(1e-3);
    options.scene.contacts = 256;
    options
}

/// Memory of a body.
fn memory(file: &File<'_>) -> Vec<f64> {
    vec![0.0; Body::<f64>::len_for(file, &options()).expect("a length")]
}

fn world_options() -> WorldOptions {
    WorldOptions {
        gravity: [0.0, 0.0, -9.81],
        tolerance: Some(0.0),
        sweeps: SWEEPS,
        contacts: 512,
        ..WorldOptions::default()
    }
}

/// Runs `run` with a step of a cube that lies on a base with its 81 nodes, and with a step of the two alone.
fn lying<R>(files: &[Vec<u8>; 2], run: impl FnOnce(&mut dyn FnMut(Step)) -> R) -> R {
    let [cube, base] = [0, 1].map(|i| File::parse(&files[i]).expect("a file"));
    let (mut first, mut second) = (memory(&cube), memory(&base));
    let mut cube = Body::<f64>::bind(&cube, &options(), &mut first).expect("a body");
    let mut base = Body::<f64>::bind(&base, &options(), &mut second).expect("a body");
    let mut motion = *cube.motion().expect("a motion");
    motion.position = [0.08, 0.08, 0.12];
    cube.set_motion(motion).expect("a motion");
    let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1).with_friction(0.3) }];
    let mut members = [Member::Free(&mut cube), Member::Held(&mut base, Pose::IDENTITY)];
    let mut lent = WorldBuffers::new(&World::sizes(&members, &[], &world_options()).expect("sizes"));
    let mut world = World::new(&members, &pairs, &[], &world_options(), lent.lend()).expect("a world");
    for _ in 0..200 {
        let _ = world.step(&mut members).expect("a step");
    }
    assert_eq!(world.touches().len(), 81);
    run(&mut |step| match step {
        Step::Load | Step::Plain => members.iter_mut().for_each(|member| {
            if let Member::Free(body) | Member::Held(body, _) = member {
                plain(body, step);
            }
        }),
        Step::World => {
            let report = world.step(&mut members).expect("a step");
            assert!(report.contacts == 81 && report.sweeps == SWEEPS, "{report:?}");
        }
    })
}

/// Work of a case at each call.
#[derive(Clone, Copy)]
enum Step {
    /// Puts a force on each body, so that none is at rest; a step of the world takes it away.
    Load,
    /// The modes of each body alone, under that force.
    Plain,
    /// The world.
    World,
}

/// Loads the modes of a body, or steps them.
fn plain(body: &mut Body<'_, f64>, step: Step) {
    body.with(|parts| match step {
        Step::Load => {
            parts.loads.clear();
            let contact = Contact::new(Place::node(0), [1e-3, 2e-3, -3e-3]);
            parts.loads.add_contact(parts.scene, &contact).expect("a contact");
        }
        _ => {
            black_box(parts.scene.step(parts.state, parts.loads)).expect("a step");
        }
    });
}

/// A hundred cubes of 16 modes, 75 of which lie on a floor with their four lowest nodes and 25 of which fall
/// above them for a long time; each may touch the floor and its neighbours.
fn hundred<R>(run: impl FnOnce(&mut dyn FnMut(Step)) -> R) -> R {
    let rest = "[basis]\nmodes = 16\n[tolerance]\nerror = 10.0\n[output]\nprecision = \"f64\"\n";
    let bytes = built("[1, 1, 1]", "[0.08, 0.08, 0.08]", rest);
    let file = File::parse(&bytes).expect("a file");
    let mut lent: Vec<_> = (0..100).map(|_| memory(&file)).collect();
    let mut bodies: Vec<_> =
        lent.iter_mut().map(|memory| Body::<f64>::bind(&file, &options(), memory).expect("a body")).collect();
    for (i, body) in bodies.iter_mut().enumerate() {
        let mut motion: RigidMotion = *body.motion().expect("a motion");
        let height = if i < 75 { 0.04 } else { 1e9 };
        motion.position = [0.1 * (i % 10) as f64, 0.1 * (i / 10) as f64, height];
        body.set_motion(motion).expect("a motion");
    }
    let corners = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [2.0, 2.0, 0.0], [-1.0, 2.0, 0.0]];
    let mut floor = RigidShape::led(&corners, &[[0, 1, 2], [0, 2, 3]], Pose::IDENTITY).expect("a floor");
    let mut pairs: Vec<_> = (0..100)
        .map(|i| Touching { nodes: Nodes::First, ..Touching::new(i, 100).with_friction(0.3) })
        .collect();
    pairs.extend((0..100).filter(|i| i % 10 < 9).map(|i| Touching::new(i, i + 1)));
    pairs.extend((0..90).map(|i| Touching::new(i, i + 10)));
    let mut members: Vec<_> = bodies.iter_mut().map(Member::Free).collect();
    members.push(Member::Rigid(&mut floor));
    let mut lent = WorldBuffers::new(&World::sizes(&members, &[], &world_options()).expect("sizes"));
    let mut world = World::new(&members, &pairs, &[], &world_options(), lent.lend()).expect("a world");
    for _ in 0..200 {
        let _ = world.step(&mut members).expect("a step");
    }
    assert_eq!(world.touches().len(), 300);
    run(&mut |step| match step {
        Step::Load | Step::Plain => members.iter_mut().for_each(|member| {
            if let Member::Free(body) = member {
                plain(body, step);
            }
        }),
        Step::World => {
            let report = world.step(&mut members).expect("a step");
            assert!(report.contacts == 300, "{report:?}");
        }
    })
}

/// A step of 81 contacts of two bodies with 32 modes each.
#[divan::bench]
fn contacts_81(bencher: Bencher<'_, '_>) {
    lying(&cube_and_base(false), |step| {
        bencher.counter(ItemsCount::new(81_usize)).bench_local(|| step(Step::World))
    });
}

/// The same with 64 further modes for contacts, and blocks between near contacts.
#[divan::bench]
fn contacts_81_further_64(bencher: Bencher<'_, '_>) {
    lying(&cube_and_base(true), |step| {
        bencher.counter(ItemsCount::new(81_usize)).bench_local(|| step(Step::World))
    });
}

/// A step of a hundred free bodies with 300 contacts.
#[divan::bench]
fn bodies_100(bencher: Bencher<'_, '_>) {
    hundred(|step| bencher.counter(ItemsCount::new(300_usize)).bench_local(|| step(Step::World)));
}

/// Binding a world of two bodies: the second arguments are those of the step above.
#[divan::bench(args = [false, true])]
fn bind(bencher: Bencher<'_, '_>, further: bool) {
    let files = cube_and_base(further);
    let [cube, base] = [0, 1].map(|i| File::parse(&files[i]).expect("a file"));
    let (mut first, mut second) = (memory(&cube), memory(&base));
    let mut cube = Body::<f64>::bind(&cube, &options(), &mut first).expect("a body");
    let mut base = Body::<f64>::bind(&base, &options(), &mut second).expect("a body");
    let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1) }];
    let members = [Member::Free(&mut cube), Member::Held(&mut base, Pose::IDENTITY)];
    let mut lent = WorldBuffers::new(&World::sizes(&members, &[], &world_options()).expect("sizes"));
    bencher.bench_local(|| {
        black_box(World::new(&members, &pairs, &[], &world_options(), lent.lend()).expect("a world"));
    });
}

/// Nanoseconds of a step of the world and of the plain steps, in turns: the fastest and the median of the
/// rounds. Each round is about a millisecond, so that on a busy machine some run undisturbed.
fn in_turns(step: &mut dyn FnMut(Step)) -> [[f64; 2]; 2] {
    let mut times = [vec![], vec![]];
    for _ in 0..ROUNDS {
        for (times, (kind, repeats)) in times.iter_mut().zip([(Step::World, 1), (Step::Plain, 1000)]) {
            if matches!(kind, Step::Plain) {
                step(Step::Load);
            }
            let clock = Instant::now();
            (0..repeats).for_each(|_| step(kind));
            times.push(1e9 * clock.elapsed().as_secs_f64() / f64::from(repeats));
        }
        // The modes come back to where contacts hold them.
        (0..20).for_each(|_| step(Step::World));
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        [times[0], times[ROUNDS / 2]]
    })
}

/// Prints steps of worlds beside plain steps of the same modes.
fn ratios() {
    println!(
        "\n| world | step, µs: fastest (median) | plain steps of all its bodies, ns | ratio of the fastest \
         (medians) |\n|---|---|---|---|"
    );
    let print = |name: &str, [world, plain]: [[f64; 2]; 2]| {
        println!(
            "| {name} | {:.0} ({:.0}) | {:.1} ({:.1}) | {:.0} ({:.0}) |",
            1e-3 * world[0],
            1e-3 * world[1],
            plain[0],
            plain[1],
            world[0] / plain[0],
            world[1] / plain[1]
        );
    };
    for (name, further) in [("81 contacts, 32 + 32 modes", false), ("the same, 64 + 64 further modes", true)]
    {
        print(name, lying(&cube_and_base(further), |step| in_turns(step)));
    }
    print("100 free bodies of 16 modes, 300 contacts", hundred(|step| in_turns(step)));
}
