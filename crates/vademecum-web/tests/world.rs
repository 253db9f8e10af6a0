//! The committed WebAssembly module of worlds gives the bits of the stage compiled for this machine.

use std::path::{Path, PathBuf};
use std::process::Command;

use vademecum_eval::{
    Anchor, JointKind, Lead, Member, Nodes, Place, RigidBody, Touching, WorldJoint, WorldOptions,
};
use vademecum_tests::soft_cube::soft_cube;
use vademecum_web::pull::{Grip, Pull};
use vademecum_web::refusal::Refusal;
use vademecum_web::stage::{Shown, Stage, Start};

const UNITS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn block(lengths: [f64; 3]) -> (&'static [[f64; 3]], &'static [[u32; 3]]) {
    let corner = |i: u32| std::array::from_fn(|k| if i >> k & 1 == 1 { lengths[k] } else { 0.0 });
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = squares.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let nodes: Vec<[f64; 3]> = (0..8).map(corner).collect();
    (nodes.leak(), halves.collect::<Vec<_>>().leak())
}

fn at(position: [f64; 3]) -> Start {
    Start { position, rotation: [1.0, 0.0, 0.0, 0.0], ..Start::default() }
}

/// The world of `world.mjs`.
fn staged(bytes: Vec<u8>) -> Stage {
    let mut stage = Stage::new();
    let file = stage.open(bytes.leak()).expect("a file");
    let first = Start { velocity: [0.3, 0.0, 0.0], ..at([0.0, 0.0, 0.001]) };
    let second = Start {
        position: [0.01, 0.005, 0.05],
        rotation: [0.6, 0.8, 0.0, 0.0],
        velocity: [0.0, 0.0, -0.5],
        spin: [1.0, 2.0, 3.0],
    };
    for start in [first, second] {
        stage.add_body(file, 1e-3, 128, &start).expect("a body");
    }
    let (nodes, triangles) = block([0.4, 0.4, 0.1]);
    let floor = stage.add_rigid(nodes, triangles, None, &at([-0.2, -0.2, -0.1])).expect("a floor");
    let stops: Vec<[f64; 4]> = vec![[0.0; 4], [0.2, 0.0, 0.0, 0.01], [0.3, 0.0, 0.0, 0.0]];
    let way = Lead { stops: stops.leak(), amplitude: [0.002, 0.0, 0.0], frequency: 20.0, ramp: 0.1 };
    stage.lead(floor, way).expect("a floor is led");
    assert!(matches!(stage.lead(0, way), Err(Refusal::BadPart)), "a free body is not");
    let (nodes, triangles) = block([0.02; 3]);
    let body = RigidBody { mass: 0.05, centre: [0.01; 3], moments: [4e-6; 3], axes: UNITS, first_pattern: 0 };
    stage.add_rigid(nodes, triangles, Some(body), &at([0.1, 0.0, 0.1])).expect("a block");
    let pairs = [
        (0, 1, 0.4, 0.5, Nodes::Both),
        (0, 2, 0.5, 0.0, Nodes::First),
        (1, 2, 0.3, 0.7, Nodes::First),
        (0, 3, 0.2, 1.0, Nodes::Second),
    ];
    for (a, b, friction, restitution, nodes) in pairs {
        stage.add_pair(Touching { members: [a, b], friction, restitution, nodes });
    }
    let pin = [Anchor::Frame(0), Anchor::point([-0.06, 0.02, -0.079])];
    stage.add_joint(WorldJoint::new(JointKind::Ball, [0, 3], pin));
    let hook = [Anchor::Frame(0), Anchor::point([0.2, 0.2, 0.35])];
    let cable = WorldJoint::new(JointKind::Cable { length: 0.25 }, [1, 2], hook);
    stage.add_joint(WorldJoint { compliance: 1e-3, breaks_at: 0.4, ..cable });
    let options =
        WorldOptions { gravity: [0.0, 0.0, -9.81], sweeps: 300, contacts: 128, ..WorldOptions::default() };
    stage.bind(&options, 1e-3).expect("a world");
    stage
}

fn look(stage: &mut Stage, numbers: &mut Vec<f64>) {
    let (report, broken) = stage.report().expect("a report");
    let count = |count: usize| count as f64;
    numbers.push(stage.time().expect("a time"));
    numbers.extend([report.contacts, report.pressed, report.left_out, report.sweeps].map(count));
    numbers.extend([f64::from(u8::from(report.converged)), report.worst_gap, report.energy_given_away]);
    numbers.push(count(broken));
    numbers.extend(stage.energies().expect("energies"));
    for member in 0..stage.members().len() {
        let (position, rotation) = stage.pose(member).expect("a pose");
        numbers.extend(position.into_iter().chain(rotation));
    }
    for touch in stage.touches().expect("contacts").iter().filter(|touch| touch.pressure() > 0.0) {
        numbers.extend(touch.members().map(count));
        numbers.extend(touch.position().into_iter().chain(touch.force()).chain([touch.pressure()]));
    }
    for (force, broken) in stage.joints().expect("joints") {
        numbers.extend(force.into_iter().chain([f64::from(u8::from(broken))]));
    }
    for (_, pull) in stage.pulls() {
        let held = pull.at(&stage.members()[pull.member]).expect("a place");
        numbers.extend(held.into_iter().chain(pull.target).chain(pull.force));
    }
    let strikes = stage.strikes().expect("a world");
    for strike in strikes.heard() {
        numbers.extend([count(strike.member)].into_iter().chain(strike.impulse));
        numbers.extend(strike.place.nodes().iter().map(|&node| f64::from(node)));
        numbers.extend(strike.place.weights());
    }
    strikes.taken();
}

fn march(stage: &mut Stage, rounds: usize, numbers: &mut Vec<f64>) {
    for _ in 0..rounds {
        (0..10).for_each(|_| stage.step().expect("a step"));
        look(stage, numbers);
    }
}

/// The march of `world.mjs`.
fn native(bytes: Vec<u8>) -> Vec<f64> {
    let mut numbers = vec![];
    let mut stage = staged(bytes);
    look(&mut stage, &mut numbers);
    march(&mut stage, 20, &mut numbers);
    let grip = Grip::Place(Place::new(&[0, 1, 2], &[0.2, 0.3, 0.5]).expect("a place"));
    let hold = |member, grip, target, stiffness, damping| Pull {
        member,
        grip,
        target,
        stiffness,
        damping,
        force: [0.0; 3],
    };
    stage.pull(1, hold(0, grip, [0.0, 0.0, 0.1], 40.0, 0.5)).expect("a hand");
    stage.pull(2, hold(3, Grip::Point([0.02, 0.01, 0.0]), [0.1; 3], 20.0, 0.2)).expect("a hand");
    assert!(stage.pull(3, hold(9, grip, [0.0; 3], 1.0, 0.0)).is_err(), "there is no such member");
    march(&mut stage, 10, &mut numbers);
    stage.move_pull(1, [0.05, 0.0, 0.12]).expect("a hand");
    march(&mut stage, 10, &mut numbers);
    stage.release(1);
    stage.break_joint(0).expect("a joint");
    stage.throw(1, [0.0, 0.0, 1.0], [5.0, 0.0, 0.0]).expect("a free body");
    stage.set_gravity([0.0, 0.0, -3.0]).expect("numbers");
    march(&mut stage, 5, &mut numbers);
    let saved = stage.save().expect("a state");
    let from = numbers.len();
    march(&mut stage, 5, &mut numbers);
    let middle = numbers.len();
    stage.restore(&saved).expect("its state");
    assert!(stage.restore(&saved[1..]).is_err() && stage.restore(&saved).is_ok());
    march(&mut stage, 5, &mut numbers);
    let bits = |part: &[f64]| part.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert!(bits(&numbers[from..middle]) == bits(&numbers[middle..]), "it goes on bit by bit");
    for shown in [Shown::Displacement, Shown::Velocity] {
        let (mut nodes, mut fields, mut work) = (vec![], vec![], vec![]);
        for member in 0..stage.members().len() {
            let mut own = vec![[0.0; 3]; stage.n_nodes(member)];
            let mut field = own.clone();
            stage.surface_into(member, shown, &mut work, &mut own, &mut field).expect("a surface");
            nodes.extend(own.into_flattened());
            fields.extend(field.into_flattened());
        }
        numbers.extend(nodes.into_iter().chain(fields).map(f64::from));
    }
    stage.reset().expect("a start");
    stage.release(2);
    stage.set_gravity([0.0, 0.0, -9.81]).expect("numbers");
    look(&mut stage, &mut numbers);
    march(&mut stage, 5, &mut numbers);
    numbers
}

#[test]
fn the_module_of_worlds_gives_the_native_bits() {
    let bytes = soft_cube();
    let numbers = native(bytes.clone());
    assert!(numbers.iter().all(|x| x.is_finite()) && numbers.len() > 3000, "{}", numbers.len());
    let node = Command::new("node").arg("--version").output();
    if !node.is_ok_and(|output| output.status.success()) {
        assert!(std::env::var_os("CI").is_none(), "node is needed to run the web module");
        eprintln!("skipped: no node on this machine to run the web module");
        return;
    }
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vademecum-cli/assets");
    let module = std::env::var_os("VADEMECUM_WASM").map_or(committed, PathBuf::from).join("world.wasm");
    let folder = tempfile::tempdir().expect("a folder");
    let (input, output) = (folder.path().join("cube.vdm"), folder.path().join("numbers"));
    std::fs::write(&input, bytes).expect("written");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/world.mjs");
    let run = Command::new("node").arg(script).arg(module).args([&input, &output]).output().expect("node");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let found = std::fs::read(&output).expect("numbers");
    let found: Vec<u64> = found.as_chunks().0.iter().map(|&bytes| u64::from_le_bytes(bytes)).collect();
    let expected: Vec<u64> = numbers.iter().map(|x| x.to_bits()).collect();
    let apart = found.iter().zip(&expected).position(|(a, b)| a != b);
    assert_eq!(apart, None, "the first number that differs, of {}", expected.len());
    assert_eq!(found.len(), expected.len());
}

/// A hand pulls a free body to where it is, and a body that is thrown has its velocity.
#[test]
fn a_hand_brings_a_body_to_it_and_a_throw_has_its_velocity() {
    let mut stage = Stage::new();
    let file = stage.open(soft_cube().leak()).expect("a file");
    stage.add_body(file, 1e-3, 8, &at([0.0; 3])).expect("a body");
    stage.bind(&WorldOptions::default(), 1e-3).expect("a world");
    let mass = stage.mass(0);
    assert!((mass - 1000.0 * 0.04_f64.powi(3)).abs() < 1e-9, "{mass}");
    let omega = 2.0 * std::f64::consts::PI * 3.0;
    let grip = Grip::Place(Place::node(0));
    let hold = Pull {
        member: 0,
        grip,
        target: [0.1, -0.2, 0.3],
        stiffness: mass * omega * omega,
        damping: 1.4 * mass * omega,
        force: [0.0; 3],
    };
    stage.pull(7, hold).expect("a hand");
    (0..3000).for_each(|_| stage.step().expect("a step"));
    let held = stage.pulls()[0].1.at(&stage.members()[0]).expect("a place");
    let off = (0..3).map(|k| (held[k] - hold.target[k]).abs()).fold(0.0, f64::max);
    // It still turns about the corner, and the spring bears the centrifugal force.
    assert!(off < 5e-3, "{held:?}");
    stage.release(7);
    stage.throw(0, [0.5, 0.0, 0.0], [0.0; 3]).expect("a free body");
    let centre = |stage: &Stage| match &stage.members()[0] {
        Member::Free(body) => body.motion().expect("a motion").position,
        _ => unreachable!("a free body"),
    };
    let before = centre(&stage);
    (0..100).for_each(|_| stage.step().expect("a step"));
    assert!((centre(&stage)[0] - before[0] - 0.05).abs() < 1e-12);
}
