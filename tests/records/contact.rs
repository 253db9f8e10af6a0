//! The records of energy of `docs/measurements/contact.md`: worlds over a million steps.
//!
//! ```text
//! cargo run --release -p vademecum-tests --example contact [-- STEPS]
//! ```
//!
//! A step of a body that has come to rest, whose contacts have the nodes and triangles of the step before,
//! counts as one of fixed pairs, every other one with contact as a step of searched pairs.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{
    Anchor, Body, BodyOptions, JointKind, Member, Nodes, Place, Pose, RigidMotion, RigidShape, Touching,
    World, WorldBuffers, WorldJoint, WorldOptions,
};
use vademecum_format::{File, SectionKind};

const GRAVITY: f64 = 9.81;
/// Largest change of a displacement in the last sweep \[m\].
const TOLERANCE: f64 = 1e-13;

fn main() {
    let steps = std::env::args().nth(1).map_or(1_000_000, |word| word.parse().expect("a number of steps"));
    println!(
        "| world | steps | without contact | of fixed pairs | largest rise of one, J | bound, J | of searched pairs | with a rise | \
         all rises ÷ energy | given by contacts ÷ energy | energy left | largest overlap, mm |"
    );
    println!("|{}", "---|".repeat(12));
    println!("{}", lands(steps));
    for (friction, time_step) in [(0.0, 1e-3), (0.3, 1e-3), (0.0, 0.25e-3)] {
        println!("{}", boxed(steps, friction, time_step));
    }
    println!(
        "\n| chain of three links | steps | energy scale, J | energy at the end ÷ scale | lowest | highest |"
    );
    println!("|{}", "---|".repeat(6));
    println!("{}", chain(2e11, steps));
}

fn built(mesh: &str, young: f64, rest: &str, modes: usize) -> Vec<u8> {
    let text = format!(
        "[mesh]\nblock = {mesh}\n[[material]]\nyoung = {young:e}\npoisson = 0.3\ndensity = 1000.0\n{rest}\
         [basis]\nmodes = {modes}\n[tolerance]\nerror = 10.0\n[output]\nprecision = \"f64\"\n"
    );
    let problem = Problem::parse(&text, "body.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}

fn options(time_step: f64) -> BodyOptions {
    let mut options = BodyOptions::default();
    options.scene.time_step = Some(time_step);
    options.scene.contacts = 256;
    options
}

fn memory(file: &File<'_>) -> Vec<f64> {
    vec![0.0; Body::<f64>::len_for(file, &options(1e-3)).expect("a length")]
}

/// Rises of the energy over a march.
#[derive(Default)]
struct Rises {
    /// Steps without a force of contact.
    alone: usize,
    fixed: usize,
    largest: f64,
    /// Largest force × tolerance of a step of fixed pairs: what the solution leaves open.
    open: f64,
    searched: usize,
    risen: usize,
    all: f64,
    /// Work of the contacts in steps in which they add energy.
    given: f64,
    overlap: f64,
}

/// Marches a world of undamped bodies, which come to rest after `settled` steps; the rises of its energy as a
/// row of the table.
fn march(
    name: &str,
    (members, pairs, options): (&mut [Member<'_, '_, f64>], &[Touching], &WorldOptions),
    [steps, settled]: [usize; 2],
    scale: f64,
    height: &dyn Fn(&[Member<'_, '_, f64>]) -> f64,
) -> String {
    let mut lent = WorldBuffers::new(&World::sizes(members, &[], options).expect("sizes"));
    let mut world = World::new(members, pairs, &[], options, lent.lend()).expect("a world");
    let total = |world: &World<'_, f64>, members: &[Member<'_, '_, f64>]| {
        world.energy(members).expect("an energy") + height(members)
    };
    let start = total(&world, members);
    let (mut found, mut before, mut old) = (Rises::default(), start, vec![]);
    for step in 0..steps {
        let report = world.step(members).expect("a step");
        assert!(report.converged, "{report:?}");
        let energy = total(&world, members);
        let rise = energy - before;
        let now: Vec<_> =
            world.touches().iter().map(|t| (t.members(), t.places().map(|p| p.nodes().to_vec()))).collect();
        let force: f64 = world.touches().iter().map(|touch| touch.pressure()).sum();
        if report.pressed == 0 {
            // Without contact the energy of a body that turns swings with its modes in the floating frame.
            found.alone += 1;
        } else if step >= settled && now == old {
            found.fixed += 1;
            found.largest = found.largest.max(rise);
            found.open = found.open.max(force * TOLERANCE);
        } else {
            found.searched += 1;
            found.risen += usize::from(rise > 1e-12 * scale);
            found.all += rise.max(0.0);
            found.given += (-report.energy_given_away).max(0.0);
        }
        found.overlap = found.overlap.max(report.worst_gap);
        (before, old) = (energy, now);
    }
    let Rises { alone, fixed, largest, open, searched, risen, all, given, overlap } = found;
    format!(
        "| {name} | {steps} | {alone} | {fixed} | {largest:.1e} | {open:.1e} | {searched} | {risen} | {:.1e} | {:.1e} | {:.4} | {:.4} |",
        all / scale,
        given / scale,
        1.0 + (before - start) / scale,
        1e3 * overlap
    )
}

/// An undamped cube of eight modes that lands on a base with nine nodes, slides and rests, with friction 0.3.
/// The scale is the kinetic energy and the height above the base at the start.
fn lands(steps: usize) -> String {
    let cube = "{ lengths = [0.08, 0.08, 0.08], divisions = [2, 2, 2], order = \"linear\" }";
    let base = "{ lengths = [0.16, 0.16, 0.08], divisions = [10, 10, 5], order = \"linear\" }";
    let held = "[[support]]\non = { group = \"z_min\" }\n";
    let files = [built(cube, 1e6, "", 8), built(base, 1e6, held, 8)];
    let [cube, base] = [0, 1].map(|i| File::parse(&files[i]).expect("a file"));
    let (mut first, mut second) = (memory(&cube), memory(&base));
    let mut cube = Body::<f64>::bind(&cube, &options(1e-3), &mut first).expect("a body");
    let mut base = Body::<f64>::bind(&base, &options(1e-3), &mut second).expect("a body");
    let body = cube.rigid_body().expect("a free body");
    let mut motion = RigidMotion::thrown(&body, [0.05, 0.0, 0.0], [0.0; 3]);
    motion.position = [0.08, 0.08, 0.121];
    cube.set_motion(motion).expect("a motion");
    let scale = body.mass * (GRAVITY * 1e-3 + 0.5 * 0.05 * 0.05);
    let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1).with_friction(0.3) }];
    let options = WorldOptions {
        gravity: [0.0, 0.0, -GRAVITY],
        tolerance: Some(TOLERANCE),
        sweeps: 5000,
        ..WorldOptions::default()
    };
    let height = |members: &[Member<'_, '_, f64>]| height_of(&members[0], body.mass);
    let mut members = [Member::Free(&mut cube), Member::Held(&mut base, Pose::IDENTITY)];
    march("a cube lands, slides and rests", (&mut members, &pairs, &options), [steps, 2000], scale, &height)
}

/// Energy of the weight.
fn height_of(member: &Member<'_, '_, f64>, mass: f64) -> f64 {
    match member {
        Member::Free(body) => GRAVITY * mass * body.motion().expect("a motion").position[2],
        _ => 0.0,
    }
}

/// An undamped cube that flies about in a closed rigid box, turning, without weight: its contacts are new
/// ones again and again. The scale is the kinetic energy at the start.
fn boxed(steps: usize, friction: f64, time_step: f64) -> String {
    let cube = "{ lengths = [0.08, 0.08, 0.08], divisions = [2, 2, 2], order = \"linear\" }";
    let bytes = built(cube, 1e6, "", 16);
    let file = File::parse(&bytes).expect("a file");
    let mut lent = memory(&file);
    let mut cube = Body::<f64>::bind(&file, &options(time_step), &mut lent).expect("a body");
    let body = cube.rigid_body().expect("a free body");
    let mut motion = RigidMotion::thrown(&body, [0.3, 0.2, -0.25], [1.0, -2.0, 1.5]);
    motion.position = [0.0; 3];
    cube.set_motion(motion).expect("a motion");
    let scale = motion.energy(&body);
    let (nodes, triangles) = walls(0.1);
    let mut walls = RigidShape::led(&nodes, &triangles, Pose::IDENTITY).expect("walls");
    let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1).with_friction(friction) }];
    let options = WorldOptions { tolerance: Some(TOLERANCE), sweeps: 5000, ..WorldOptions::default() };
    let mut members = [Member::Free(&mut cube), Member::Rigid(&mut walls)];
    let name = format!("a cube in a box, {} ms, friction {friction}", 1e3 * time_step);
    march(&name, (&mut members, &pairs, &options), [steps, steps], scale, &|_| 0.0)
}

/// A cube of half the length `h` that is open inside: its triangles look inwards.
fn walls(h: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let nodes = (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { -h } else { h })).collect();
    let mut triangles = vec![];
    for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        // Counterclockwise from outside, turned round.
        triangles.extend([[a, c, b], [a, d, c]]);
    }
    (nodes, triangles)
}

/// Loadable node at a place.
fn node_at(file: &File<'_>, at: [f64; 3]) -> u32 {
    let section = file.section(SectionKind::NodeCoordinates).expect("nodes");
    let numbers: Vec<f64> = section.numbers().expect("numbers").iter().collect();
    let near = |node: &u32| (0..3).all(|c| (numbers[3 * *node as usize + c] - at[c]).abs() < 1e-9);
    (0..file.metadata().n_load_nodes).find(near).expect("a node")
}

/// Three undamped links of four modes that fall from the horizontal, each hinge two ball joints. The scale is
/// the height of the chain's centre from the horizontal to the vertical, in energy.
fn chain(young: f64, steps: usize) -> String {
    const LINKS: usize = 3;
    let bytes = built("{ lengths = [0.2, 0.02, 0.02], divisions = [6, 1, 1] }", young, "", 4);
    let file = File::parse(&bytes).expect("a file");
    let mut lent: Vec<_> = (0..LINKS).map(|_| memory(&file)).collect();
    let mut bodies: Vec<_> = lent
        .iter_mut()
        .map(|memory| Body::<f64>::bind(&file, &options(1e-3), memory).expect("a body"))
        .collect();
    let body = bodies[0].rigid_body().expect("a free body");
    for (i, link) in bodies.iter_mut().enumerate() {
        let mut motion = RigidMotion::at_rest(&body);
        motion.position[0] += 0.2 * i as f64;
        link.set_motion(motion).expect("a motion");
    }
    let mut ground = RigidShape::led(&[], &[], Pose::IDENTITY).expect("a ground");
    let h = 0.02;
    let anchor = |x: f64, y: f64| {
        let nodes = [0.0, h / 2.0, h].map(|z| node_at(&file, [x, y, z]));
        Anchor::Place(Place::new(&nodes, &[1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0]).expect("a place"))
    };
    let mut joints = vec![];
    for i in 0..LINKS {
        for y in [0.0, h] {
            let before = match i {
                0 => (LINKS, Anchor::point([0.0, y, h / 2.0])),
                _ => (i - 1, anchor(0.2, y)),
            };
            joints.push(WorldJoint::new(JointKind::Ball, [i, before.0], [anchor(0.0, y), before.1]));
        }
    }
    let options =
        WorldOptions { gravity: [0.0, 0.0, -GRAVITY], tolerance: Some(1e-12), ..WorldOptions::default() };
    let mut members: Vec<_> = bodies.iter_mut().map(Member::Free).collect();
    members.push(Member::Rigid(&mut ground));
    let mut lent = WorldBuffers::new(&World::sizes(&members, &joints, &options).expect("sizes"));
    let mut world = World::new(&members, &[], &joints, &options, lent.lend()).expect("a world");
    let energy = |world: &World<'_, f64>, members: &[Member<'_, '_, f64>]| {
        let height: f64 = members.iter().map(|member| height_of(member, body.mass)).sum();
        world.energy(members).expect("an energy") + height
    };
    let scale = LINKS as f64 * body.mass * GRAVITY * 0.1 * LINKS as f64;
    let start = energy(&world, &members);
    let (mut now, mut low, mut high) = (1.0, 1.0_f64, 1.0_f64);
    for _ in 0..steps {
        let report = world.step(&mut members).expect("a step");
        assert!(report.converged, "{report:?}");
        now = 1.0 + (energy(&world, &members) - start) / scale;
        (low, high) = (low.min(now), high.max(now));
    }
    format!("| steel, 200 GPa | {steps} | {scale:.3} | {now:.5} | {low:.5} | {high:.5} |")
}
