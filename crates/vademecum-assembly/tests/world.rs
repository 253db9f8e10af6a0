//! Bodies that touch in a world, against full-order solutions with the same contact law.
//!
//! The bodies and loads: a cube of 0.08 m of 8 × 8 × 8 cells on a block of 0.16 × 0.16 × 0.08 m, linear
//! tetrahedra, Young's modulus 1 MPa, whose meshes do not match; 81 nodes of the cube touch.

mod reference;

use std::path::PathBuf;

use reference::{FullBody, Pair};
use vademecum_assembly::{AssemblyFile, GivenPart, WorldSavedError, WorldSimulation};
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{
    Anchor, Body, BodyOptions, Field, JointKind, Member, Nodes, Place, Pose, RigidMotion, RigidShape,
    SceneOptions, SurfacePoint, Touching, World, WorldBuffers, WorldJoint, WorldOptions, WorldReport,
};
use vademecum_format::{File, SectionKind};

const CUBE: &str =
    "[mesh]\nblock = { lengths = [0.08, 0.08, 0.08], divisions = [8, 8, 8], order = \"linear\" }\n";
const BASE: &str =
    "[mesh]\nblock = { lengths = [0.16, 0.16, 0.08], divisions = [10, 10, 5], order = \"linear\" }\n";
const RUBBER: &str = "[[material]]\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n";
const STEEL: &str = "[[material]]\nyoung = 2e11\npoisson = 0.3\ndensity = 7800.0\n";
const HELD: &str = "[[support]]\non = { group = \"z_min\" }\n";

/// Distance of the patch: three edges of the cube.
const PATCH: f64 = 0.03;

/// A problem of `modes` modes; with residual flexibility between near contacts where `patch` says so.
fn problem(mesh: &str, rest: &str, modes: usize, patch: bool) -> String {
    let patch = if patch { format!("contact_patch = {PATCH}\n") } else { String::new() };
    format!(
        "{mesh}{rest}[basis]\nmodes = {modes}\n[tolerance]\nerror = 10.0\n[output]\n\
         precision = \"f64\"\n{patch}"
    )
}

fn built(text: &str) -> Vec<u8> {
    let problem = Problem::parse(text, "body.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}

fn options(time_step: f64) -> BodyOptions {
    let mut options = BodyOptions::default();
    options.scene.time_step = Some(time_step);
    options.scene.contacts = 256;
    options
}

/// Memory of a world without joints.
fn buffers(members: &[Member<'_, '_, f64>], options: &WorldOptions) -> WorldBuffers {
    WorldBuffers::new(&World::sizes(members, &[], options).expect("sizes"))
}

/// Results of the march of a cube over a base.
#[derive(Debug, Default)]
struct Dropped {
    restitution: f64,
    peak: f64,
    /// Largest rise of the energy in a step, and the sum of all rises, as shares of the energy at the start.
    rise: f64,
    rises: f64,
    given_away: f64,
    left: f64,
}

/// Drops the cube with 0.5 m/s from 1 mm above the base, turned by `tilt` about y.
fn dropped(cube: &[u8], base: &[u8], time_step: f64, tilt: f64) -> Dropped {
    let (cube, base) = (File::parse(cube).expect("a file"), File::parse(base).expect("a file"));
    let options = options(time_step);
    let mut memory = vec![0.0; Body::<f64>::len_for(&cube, &options).expect("a length")];
    let mut other = vec![0.0; Body::<f64>::len_for(&base, &options).expect("a length")];
    let mut cube = Body::<f64>::bind(&cube, &options, &mut memory).expect("a body");
    let mut base = Body::<f64>::bind(&base, &options, &mut other).expect("a body");
    let body = cube.rigid_body().expect("a free body");
    let mut motion = RigidMotion::thrown(&body, [0.0, 0.0, -0.5], [0.0; 3]);
    let half = 0.5 * f64::atan(tilt);
    motion.attitude = [half.cos(), 0.0, half.sin(), 0.0];
    let height = 0.04 * (1.0 + tilt) / (1.0f64 + tilt * tilt).sqrt();
    motion.position = [0.08, 0.08, 0.08 + height + 0.001];
    cube.set_motion(motion).expect("a motion");
    let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1) }];
    let options = WorldOptions::default();
    let mut members = [Member::Free(&mut cube), Member::Held(&mut base, Pose::IDENTITY)];
    let mut memory = buffers(&members, &options);
    let mut world = World::new(&members, &pairs, &[], &options, memory.lend()).expect("a world");
    let start = world.energy(&members).expect("an energy");
    let (mut found, mut before) = (Dropped::default(), start);
    for _ in 0..(0.05 / time_step) as usize {
        let report = world.step(&mut members).expect("a step");
        assert!(report.converged, "{report:?}");
        let force: f64 = world.touches().iter().map(|touch| touch.force()[2]).sum();
        found.peak = found.peak.max(force);
        found.given_away += report.energy_given_away / start;
        let energy = world.energy(&members).expect("an energy");
        let rise = (energy - before) / start;
        found.rise = found.rise.max(rise);
        found.rises += rise.max(0.0);
        before = energy;
    }
    found.left = before / start;
    if let Member::Free(cube) = &members[0] {
        found.restitution = cube.motion().expect("a motion").momentum[2] / body.mass / 0.5;
    }
    found
}

/// Rebounds of a soft cube against those at full order: flat, and tilted by a fiftieth.
#[test]
fn a_cube_rebounds_as_at_full_order() {
    let cube = built(&problem(CUBE, RUBBER, 32, true));
    let base = built(&problem(BASE, &format!("{RUBBER}{HELD}"), 32, true));
    let whole = [
        FullBody::new(&problem(CUBE, RUBBER, 8, false)),
        FullBody::new(&problem(BASE, &format!("{RUBBER}{HELD}"), 8, false)),
    ];
    for (tilt, bounds) in [(0.0, [0.06, 0.03]), (0.02, [0.06, 0.02])] {
        let expected = Pair::new(&whole).drop(tilt);
        println!("tilt {tilt}: full order {:.3}, peak {:.1} N", expected.restitution, expected.peak);
        for (time_step, bound) in [1e-3, 0.25e-3].into_iter().zip(bounds) {
            let found = dropped(&cube, &base, time_step, tilt);
            println!("  {:.2} ms: {found:?}", 1e3 * time_step);
            assert!((found.restitution - expected.restitution).abs() < bound, "{found:?}");
            assert!(found.rises < 1e-3, "{found:?}");
            assert!((found.left + found.given_away - 1.0).abs() < 2e-3, "{found:?}");
        }
    }
}

/// A cube held below whose upper face is pressed by 1 mm with a plate, and by 2 mm with a sphere of 0.1 m.
#[test]
fn a_pressed_patch_is_as_stiff_as_at_full_order() {
    let rest = format!("{RUBBER}{HELD}[damping]\nratio = 0.7\n");
    let whole = FullBody::new(&problem(CUBE, &format!("{RUBBER}{HELD}"), 8, false));
    for (name, depth, centre, force_bound, largest_bound) in
        [("plate", 1e-3, None, 0.03, 0.08), ("sphere", 2e-3, Some(0.1), 0.07, 0.12)]
    {
        let expected = whole.pressed(depth, centre);
        for (patch, modes) in [(false, 32), (true, 8), (true, 32)] {
            let found = pressed(&built(&problem(CUBE, &rest, modes, patch)), depth, centre);
            let off = [found[0] / expected[0] - 1.0, found[1] / expected[1] - 1.0];
            println!("{name}, {modes} modes, patch {patch}: {found:.3?} of {expected:.3?} N, {off:.3?}");
            if patch && modes == 32 {
                assert!(off[0].abs() < force_bound && off[1].abs() < largest_bound, "{name}: {off:?}");
            }
        }
    }
}

/// Total and largest nodal force on the upper face of a cube that is pressed.
fn pressed(file: &[u8], depth: f64, radius: Option<f64>) -> [f64; 2] {
    let file = File::parse(file).expect("a file");
    let options = options(5e-3);
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options).expect("a length")];
    let mut body = Body::<f64>::bind(&file, &options, &mut memory).expect("a body");
    let (nodes, triangles) = match radius {
        None => plate(),
        Some(radius) => cap(radius),
    };
    let at = |down: f64| Pose::at([0.04, 0.04, 0.08 - down]);
    let mut tool = RigidShape::led(&nodes, &triangles, at(-1e-4)).expect("a tool");
    let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1) }];
    let options = WorldOptions { reach: Some(4e-3), sweeps: 5000, ..WorldOptions::default() };
    let mut members = [Member::Held(&mut body, Pose::IDENTITY), Member::Rigid(&mut tool)];
    let mut memory = buffers(&members, &options);
    let mut world = World::new(&members, &pairs, &[], &options, memory.lend()).expect("a world");
    let mut report = WorldReport::default();
    for step in 0..200 {
        let down = depth * (f64::from(step) / 50.0).min(1.0);
        if let Member::Rigid(tool) = &mut members[1] {
            tool.lead(at(down)).expect("a pose");
        }
        report = world.step(&mut members).expect("a step");
    }
    assert!(report.converged, "{report:?}");
    let forces: Vec<f64> = world.touches().iter().map(|touch| -touch.force()[2]).collect();
    [forces.iter().sum(), forces.iter().copied().fold(0.0, f64::max)]
}

/// A square plate that looks down.
fn plate() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let h = 0.06;
    (vec![[-h, -h, 0.0], [h, -h, 0.0], [h, h, 0.0], [-h, h, 0.0]], vec![[0, 2, 1], [0, 3, 2]])
}

/// The lowest part of a sphere that touches the origin from above, in facets of 0.5 mm.
fn cap(radius: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (n, size) = (80_u32, 0.04_f64);
    let side = n + 1;
    let mut nodes = vec![];
    for j in 0..side {
        for i in 0..side {
            let [x, y] = [i, j].map(|k| size * (2.0 * f64::from(k) / f64::from(n) - 1.0));
            nodes.push([x, y, radius - (radius * radius - x * x - y * y).sqrt()]);
        }
    }
    let mut triangles = vec![];
    for j in 0..n {
        for i in 0..n {
            let [a, b, c, d] = [j * side + i, j * side + i + 1, (j + 1) * side + i, (j + 1) * side + i + 1];
            triangles.extend([[a, d, b], [a, c, d]]);
        }
    }
    (nodes, triangles)
}

/// A cube pressed on the base with 20 N and pushed to and fro until it slips, with friction 0.3: the face
/// that touches moves as at full order.
#[test]
fn a_face_slips_as_at_full_order() {
    let (beta, friction, every, time) = (6.4e-5, 0.3, 1e-3, 0.3);
    let force = |t: f64| -> [f64; 3] {
        let ramp = (t / 0.05).min(1.0);
        let press = ramp * ramp * (3.0 - 2.0 * ramp);
        let push = if t > 0.1 { 6.6 * (8.0 * std::f64::consts::PI * (t - 0.1)).sin() } else { 0.0 };
        [push, 0.0, -20.0 * press]
    };
    let damping = format!("[damping]\nbeta = {beta:e}\n");
    let whole = [
        FullBody::new(&problem(CUBE, RUBBER, 8, false)),
        FullBody::new(&problem(BASE, &format!("{RUBBER}{HELD}"), 8, false)),
    ];
    let expected = Pair::new(&whole).slide(time, every, friction, beta, &force);
    let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (modes, patch, time_step, bound) in [(32, true, 1e-3, 0.12), (32, true, 0.25e-3, 0.05)] {
        let cube = built(&problem(CUBE, &format!("{RUBBER}{damping}"), modes, patch));
        let base = built(&problem(BASE, &format!("{RUBBER}{HELD}{damping}"), modes, patch));
        let found = slid(&cube, &base, time_step, (time, every, friction), &force);
        assert_eq!(found.len(), expected.len());
        let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
        let square = |x: f64| x * x;
        let sum: f64 = found.iter().zip(&expected).map(|(a, b)| square(a - b)).sum();
        let off = (sum / expected.iter().map(|&x| square(x)).sum::<f64>()).sqrt();
        println!(
            "{modes} modes, patch {patch}, {time_step:e} s: the face is off by {off:.3} in the mean square over \
             time, at worst by {worst:.3} of {largest:.3e} m"
        );
        assert!(off < bound, "{off}");
    }
}

/// Mean displacement along x of the lowest face of the cube, every so many seconds.
fn slid(
    cube: &[u8],
    base: &[u8],
    time_step: f64,
    (time, every, friction): (f64, f64, f64),
    force: &dyn Fn(f64) -> [f64; 3],
) -> Vec<f64> {
    let (cube, base) = (File::parse(cube).expect("a file"), File::parse(base).expect("a file"));
    let options = options(time_step);
    let mut memory = vec![0.0; Body::<f64>::len_for(&cube, &options).expect("a length")];
    let mut other = vec![0.0; Body::<f64>::len_for(&base, &options).expect("a length")];
    let mut cube = Body::<f64>::bind(&cube, &options, &mut memory).expect("a body");
    let mut base = Body::<f64>::bind(&base, &options, &mut other).expect("a body");
    let at = |height: f64| -> Vec<SurfacePoint> {
        let coordinates = cube.file().section(SectionKind::NodeCoordinates).expect("coordinates");
        let numbers: Vec<f64> = coordinates.numbers().expect("numbers").iter().collect();
        let nodes = cube.file().metadata().n_load_nodes;
        let place = |node: u32| -> [f64; 3] { std::array::from_fn(|c| numbers[3 * node as usize + c]) };
        let on = (0..nodes).filter(|&node| (place(node)[2] - height).abs() < 1e-9);
        on.map(|node| SurfacePoint { place: Place::node(node), position: place(node), distance: 0.0 })
            .collect()
    };
    let (top, face) = (at(0.08), at(0.0));
    assert_eq!((top.len(), face.len()), (81, 81));
    let mut motion = *cube.motion().expect("a motion");
    motion.position = [0.08, 0.08, 0.12];
    cube.set_motion(motion).expect("a motion");
    let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1).with_friction(friction) }];
    let options = WorldOptions::default();
    let mut members = [Member::Free(&mut cube), Member::Held(&mut base, Pose::IDENTITY)];
    let mut memory = buffers(&members, &options);
    let mut world = World::new(&members, &pairs, &[], &options, memory.lend()).expect("a world");
    let (steps, each) = ((time / time_step).round() as usize, (every / time_step).round() as usize);
    let mut found = vec![];
    for step in 0..steps {
        let pushed = force((step as f64 + 0.5) * time_step).map(|f| f / top.len() as f64);
        if let Member::Free(cube) = &mut members[0] {
            cube.with(|parts| {
                let flight = parts.flight.as_mut().expect("a flight");
                for point in &top {
                    flight.push(parts.scene, parts.loads, point, pushed).expect("a push");
                }
            });
        }
        let report = world.step(&mut members).expect("a step");
        assert!(report.converged, "{report:?}");
        if (step + 1) % each == 0
            && let Member::Free(cube) = &members[0]
        {
            let moved = |point: &SurfacePoint| {
                cube.in_space(point, Field::Displacement).expect("a point")[0] - point.position[0] - 0.04
            };
            found.push(face.iter().map(moved).sum::<f64>() / face.len() as f64);
        }
    }
    found
}

/// A steel cube on a steel base at 1 ms, an impact of a fiftieth of a step: whatever the phase of the hit,
/// it rebounds with at most the restitution it is given, and it rests without a saw.
#[test]
fn an_impact_shorter_than_a_step_has_its_restitution_and_rests() {
    let cube =
        "[mesh]\nblock = { lengths = [0.08, 0.08, 0.08], divisions = [4, 4, 4], order = \"linear\" }\n";
    let base =
        "[mesh]\nblock = { lengths = [0.16, 0.16, 0.08], divisions = [6, 6, 3], order = \"linear\" }\n";
    let cube = built(&problem(cube, STEEL, 8, false));
    let base = built(&problem(base, &format!("{STEEL}{HELD}"), 8, false));
    let (cube, base) = (File::parse(&cube).expect("a file"), File::parse(&base).expect("a file"));
    let restitution = 0.7;
    for phase in 0..12 {
        let options = options(1e-3);
        let mut memory = vec![0.0; Body::<f64>::len_for(&cube, &options).expect("a length")];
        let mut other = vec![0.0; Body::<f64>::len_for(&base, &options).expect("a length")];
        let mut cube = Body::<f64>::bind(&cube, &options, &mut memory).expect("a body");
        let mut base = Body::<f64>::bind(&base, &options, &mut other).expect("a body");
        let body = cube.rigid_body().expect("a free body");
        let mut motion = RigidMotion::thrown(&body, [0.0, 0.0, -0.5], [0.0; 3]);
        motion.position = [0.08, 0.08, 0.12 + 0.5e-3 * (1.0 + f64::from(phase) / 12.0)];
        cube.set_motion(motion).expect("a motion");
        let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1).with_restitution(restitution) }];
        let options = WorldOptions { sweeps: 400, ..WorldOptions::default() };
        let mut members = [Member::Free(&mut cube), Member::Held(&mut base, Pose::IDENTITY)];
        let mut memory = buffers(&members, &options);
        let mut world = World::new(&members, &pairs, &[], &options, memory.lend()).expect("a world");
        for _ in 0..20 {
            let _ = world.step(&mut members).expect("a step");
        }
        let Member::Free(cube) = &members[0] else { unreachable!("the cube") };
        let rebound = cube.motion().expect("a motion").momentum[2] / body.mass / 0.5;
        println!("phase {phase}: {rebound:.3}");
        assert!((0.0..=restitution + 0.01).contains(&rebound), "{rebound}");

        if phase % 6 > 0 {
            continue;
        }
        // The same world with weight: it comes to rest, and its force is its weight.
        let options = WorldOptions { gravity: [0.0, 0.0, -9.81], ..options };
        let mut memory = buffers(&members, &options);
        let mut world = World::new(&members, &pairs, &[], &options, memory.lend()).expect("a world");
        let weight = 9.81 * body.mass;
        let steps = 1500;
        let mut worst = 0.0_f64;
        for step in 0..steps {
            let _ = world.step(&mut members).expect("a step");
            let force: f64 = world.touches().iter().map(|touch| touch.force()[2]).sum();
            if step > steps - 200 {
                worst = worst.max((force / weight - 1.0).abs());
            }
        }
        println!("  rests with {worst:.1e} of its weight");
        assert!(worst < 0.01, "{worst}");
    }
}

/// A link of 0.2 × 0.02 × 0.02 m with `modes` modes.
fn link(young: f64, modes: usize) -> Vec<u8> {
    let mesh = "[mesh]\nblock = { lengths = [0.2, 0.02, 0.02], divisions = [6, 1, 1] }\n";
    let material = format!("[[material]]\nyoung = {young:e}\npoisson = 0.3\ndensity = 1000.0\n");
    built(&problem(mesh, &material, modes, false))
}

/// Loadable node at a place.
fn node_at(file: &File<'_>, at: [f64; 3]) -> u32 {
    let numbers: Vec<f64> = file
        .section(SectionKind::NodeCoordinates)
        .expect("nodes")
        .numbers()
        .expect("numbers")
        .iter()
        .collect();
    let near = |node: &u32| (0..3).all(|c| (numbers[3 * *node as usize + c] - at[c]).abs() < 1e-9);
    (0..file.metadata().n_load_nodes).find(near).expect("a node")
}

/// A chain of links, horizontal and at rest, that falls under gravity from a hinge on the ground: each hinge
/// two ball joints. The tip every `every` seconds, and the largest gain of energy \[J\].
fn chain(file: &[u8], links: usize, time_step: f64, time: f64, every: f64) -> (Vec<[f64; 3]>, f64) {
    let file = File::parse(file).expect("a file");
    let options = options(time_step);
    let length = Body::<f64>::len_for(&file, &options).expect("a length");
    let mut memory = vec![vec![0.0; length]; links];
    let mut bodies: Vec<_> =
        memory.iter_mut().map(|memory| Body::<f64>::bind(&file, &options, memory).expect("a body")).collect();
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
    for i in 0..links {
        for y in [0.0, h] {
            let before = match i {
                0 => (links, Anchor::point([0.0, y, h / 2.0])),
                _ => (i - 1, anchor(0.2, y)),
            };
            joints.push(WorldJoint::new(JointKind::Ball, [i, before.0], [anchor(0.0, y), before.1]));
        }
    }
    let options =
        WorldOptions { gravity: [0.0, 0.0, -9.81], tolerance: Some(1e-12), ..WorldOptions::default() };
    let tip = Place::new(&[0.0, h].map(|y| node_at(&file, [0.2, y, h / 2.0])), &[0.5; 2]).expect("a place");
    let mut members: Vec<_> = bodies.iter_mut().map(Member::Free).collect();
    members.push(Member::Rigid(&mut ground));
    let mut memory = WorldBuffers::new(&World::sizes(&members, &joints, &options).expect("sizes"));
    let mut world = World::new(&members, &[], &joints, &options, memory.lend()).expect("a world");
    let energy = |world: &World<'_, f64>, members: &[Member<'_, '_, f64>]| {
        let height = |member: &Member<'_, '_, f64>| match member {
            Member::Free(link) => 9.81 * body.mass * link.motion().expect("a motion").position[2],
            _ => 0.0,
        };
        world.energy(members).expect("an energy") + members.iter().map(height).sum::<f64>()
    };
    let start = energy(&world, &members);
    let (mut tips, mut gain) = (vec![], 0.0_f64);
    let each = (every / time_step).round() as usize;
    for step in 0..(time / time_step).round() as usize {
        let report = world.step(&mut members).expect("a step");
        assert!(report.converged, "{report:?}");
        if (step + 1) % each == 0 {
            gain = gain.max(energy(&world, &members) - start);
            let Member::Free(last) = &members[links - 1] else { unreachable!("a link") };
            tips.push(last.in_space(&tip, Field::Displacement).expect("a point"));
        }
    }
    (tips, gain)
}

/// Three hinged links that turn far, with four modes at 1 ms, against all of them finely stepped.
#[test]
fn a_chain_swings_as_its_refinement() {
    let (found, gain) = chain(&link(1e8, 4), 3, 1e-3, 1.0, 1e-2);
    let (expected, _) = chain(&link(1e8, 60), 3, 1e-3 / 16.0, 1.0, 1e-2);
    let off = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    let off = found.iter().zip(&expected).map(|(a, b)| off(a, b)).fold(0.0, f64::max);
    println!("tip off by {:.3} mm of 600, gain of energy {gain:.1e} J", 1e3 * off);
    assert!(off < 0.25e-3, "{off}");
    assert!(gain < 1e-4, "{gain}");
}

/// A chain of ten steel links, ten seconds of it: its energy swings with the step, and does not grow.
#[test]
fn a_steel_chain_keeps_its_energy() {
    let (_, gain) = chain(&link(2e11, 4), 10, 1e-3, 10.0, 1e-2);
    println!("gain of energy {gain:.1e} J of 7.85");
    assert!(gain < 0.01 * 7.85, "{gain}");
}

/// A block that lies on another under weight and friction: no step of many gains energy beyond the tolerance,
/// and a world goes on bit by bit from what was saved.
#[test]
fn a_resting_block_gains_no_energy_and_is_saved() {
    let cube =
        "[mesh]\nblock = { lengths = [0.08, 0.08, 0.08], divisions = [2, 2, 2], order = \"linear\" }\n";
    let (cube, base) = (
        built(&problem(cube, RUBBER, 8, false)),
        built(&problem(BASE, &format!("{RUBBER}{HELD}"), 8, false)),
    );
    let (cube, base) = (File::parse(&cube).expect("a file"), File::parse(&base).expect("a file"));
    let options = options(1e-3);
    let mut memory = vec![0.0; Body::<f64>::len_for(&cube, &options).expect("a length")];
    let mut other = vec![0.0; Body::<f64>::len_for(&base, &options).expect("a length")];
    let mut cube = Body::<f64>::bind(&cube, &options, &mut memory).expect("a body");
    let mut base = Body::<f64>::bind(&base, &options, &mut other).expect("a body");
    let body = cube.rigid_body().expect("a free body");
    let mut motion = RigidMotion::thrown(&body, [0.05, 0.0, 0.0], [0.0; 3]);
    motion.position = [0.08, 0.08, 0.121];
    cube.set_motion(motion).expect("a motion");
    let pairs = [Touching { nodes: Nodes::First, ..Touching::new(0, 1).with_friction(0.3) }];
    let options = WorldOptions {
        gravity: [0.0, 0.0, -9.81],
        tolerance: Some(1e-13),
        sweeps: 2000,
        ..WorldOptions::default()
    };
    let mut members = [Member::Free(&mut cube), Member::Held(&mut base, Pose::IDENTITY)];
    let mut memory = buffers(&members, &options);
    let mut world = World::new(&members, &pairs, &[], &options, memory.lend()).expect("a world");
    let total = |world: &World<'_, f64>, members: &[Member<'_, '_, f64>]| {
        let Member::Free(cube) = &members[0] else { unreachable!("the cube") };
        let height = cube.motion().expect("a motion").position[2];
        world.energy(members).expect("an energy") + 9.81 * body.mass * height
    };
    let mut before = total(&world, &members);
    let scale = 9.81 * body.mass * 0.001;
    let (mut rise, mut rises) = (0.0_f64, 0.0_f64);
    for step in 0..100_000 {
        let _ = world.step(&mut members).expect("a step");
        let energy = total(&world, &members);
        // After it has come to rest, pairs stay.
        if step > 2_000 {
            rise = rise.max(energy - before);
        }
        rises += (energy - before).max(0.0);
        before = energy;
    }
    println!("largest rise at rest {rise:.1e} J, all rises {rises:.1e} J, of {scale:.1e} J");
    assert!(rise < 1e-8 * scale, "{rise}");
    assert!(rises < 1e-3 * scale, "{rises}");

    let mut saved = vec![0.0; world.saved_len()];
    world.save_into(&mut saved).expect("saved");
    let states = |members: &[Member<'_, '_, f64>]| -> Vec<Vec<u8>> {
        members
            .iter()
            .map(|member| {
                let (Member::Free(body) | Member::Held(body, _)) = member else { unreachable!("a body") };
                let mut bytes = vec![0; body.saved_len()];
                let used = body.save_into(&mut bytes).expect("saved");
                bytes.truncate(used);
                bytes
            })
            .collect()
    };
    let start = states(&members);
    let mut ends = vec![];
    for _ in 0..2 {
        world.restore(&saved).expect("restored");
        for (member, bytes) in members.iter_mut().zip(&start) {
            let (Member::Free(body) | Member::Held(body, _)) = member else { unreachable!("a body") };
            body.restore(bytes).expect("restored");
        }
        for _ in 0..50 {
            let _ = world.step(&mut members).expect("a step");
        }
        let mut after = vec![0.0; world.saved_len()];
        world.save_into(&mut after).expect("saved");
        ends.push((states(&members), after.iter().map(|x| x.to_bits()).collect::<Vec<_>>()));
    }
    assert!(ends[0] == ends[1]);
    saved[0] = 1e9;
    assert!(world.restore(&saved).is_err());
}

/// A cube on a held block, and a rigid die above, with all that the world borrows.
#[test]
fn a_world_that_owns_its_parts_is_saved_led_and_restored() {
    let cube =
        "[mesh]\nblock = { lengths = [0.08, 0.08, 0.08], divisions = [2, 2, 2], order = \"linear\" }\n";
    let (cube, base) = (
        built(&problem(cube, RUBBER, 8, false)),
        built(&problem(BASE, &format!("{RUBBER}{HELD}"), 8, false)),
    );
    let text = "format = 1\n[world]\ntime = 1.0\nstep = 1e-3\ngravity = [0.0, 0.0, -9.81]\n\
                [[part]]\nname = \"cube\"\nfile = \"given\"\nposition = [0.04, 0.04, 0.081]\n\
                [[part]]\nname = \"base\"\nfile = \"given\"\nrotation = [0.6, 0.0, 0.0, 0.8]\nposition = [0.1792, 0.0256, 0.0]\n\
                [[part]]\nname = \"die\"\nrigid = { box = { lengths = [0.02, 0.02, 0.02] }, density = 500.0 }\n\
                position = [0.0, 0.05, 0.09]\nspin = [1.0, 2.0, 3.0]\n\
                [[contact]]\nbetween = [\"cube\", \"base\"]\nfriction = 0.3\n\
                [[contact]]\nbetween = [\"die\", \"base\"]\n[[output]]\npart = \"cube\"\n";
    let file = AssemblyFile::parse(text, "world.toml", PathBuf::new()).expect("a world");
    let given = |bytes: &Vec<u8>| GivenPart::File(Box::new(bytes.clone()), SceneOptions::default());
    let parts = || vec![given(&cube), given(&base), GivenPart::Named];
    let mut world = WorldSimulation::new(file.clone(), parts()).expect("a world");
    let march = |world: &mut WorldSimulation, steps: usize| {
        for _ in 0..steps {
            let report = world.step().expect("a step");
            assert!(report.converged && report.left_out == 0, "{report:?}");
        }
    };
    let touches = |world: &WorldSimulation| {
        world.with_touches(|touches| touches.iter().any(|touch| touch.pressure() > 0.0))
    };
    while !touches(&world) {
        march(&mut world, 1);
        assert!(world.time() < 0.1, "the cube falls by 1 mm");
    }
    let saved = world.save();
    let all = |world: &mut WorldSimulation| {
        let shown = world.outputs().expect("outputs")[0];
        let die = world.motion(2).expect("a rigid body that moves");
        let energy = world.energy().expect("an energy");
        (shown.map(f64::to_bits), die, energy.map(f64::to_bits), world.time().to_bits())
    };
    let mut ends = vec![];
    for _ in 0..2 {
        world.restore(&saved).expect("restored");
        assert!(world.save() == saved);
        march(&mut world, 60);
        ends.push(all(&mut world));
    }
    assert!(ends[0] == ends[1]);

    // A host leads the base; what is refused changes nothing.
    let pose = Pose::new([0.0, 0.0, 1e-4], [0.8, 0.0, 0.0, 0.6]);
    assert!(world.lead(1, pose).is_some() && world.pose(1) == Some(pose));
    assert!(world.lead(0, pose).is_none() && world.lead(2, pose).is_none() && world.motion(1).is_none());
    let now = world.save();
    for (wrong, expected) in
        [(&saved[1..], WorldSavedError::Untagged), (&saved[..saved.len() - 8], WorldSavedError::Other)]
    {
        assert_eq!(world.restore(wrong), Err(expected));
        assert!(world.save() == now);
    }
    world.restore(&saved).expect("restored");
    assert!(world.pose(1) != Some(pose), "the base stands where it was saved");
    let mut other = WorldSimulation::new(file, parts()).expect("a world");
    other.restore(&now).expect("the state of a world of the same parts");
    assert!(other.save() == now);
}

/// The joint of a body.
type JointOf<'f> = &'f dyn Fn(&File<'_>) -> WorldJoint;

/// Places and forces of a time.
type ForcesOf<'f> = &'f dyn Fn(f64) -> Vec<([f64; 3], [f64; 3])>;

/// Displacements of a node of a free cube under one joint to the ground, every so many seconds.
fn held_by(
    file: &[u8],
    time_step: f64,
    (time, every): (f64, f64),
    gravity: f64,
    (joint, point): (JointOf<'_>, [f64; 3]),
    force: ForcesOf<'_>,
) -> Vec<[f64; 3]> {
    let file = File::parse(file).expect("a file");
    let options = options(time_step);
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options).expect("a length")];
    let mut body = Body::<f64>::bind(&file, &options, &mut memory).expect("a body");
    let mut ground = RigidShape::led(&[], &[], Pose::IDENTITY).expect("a ground");
    let joints = [joint(&file)];
    let options = WorldOptions { gravity: [0.0, 0.0, gravity], ..WorldOptions::default() };
    let at =
        |at: [f64; 3]| SurfacePoint { place: Place::node(node_at(&file, at)), position: at, distance: 0.0 };
    let watched = at(point);
    let mut members = [Member::Free(&mut body), Member::Rigid(&mut ground)];
    let mut memory = WorldBuffers::new(&World::sizes(&members, &joints, &options).expect("sizes"));
    let mut world = World::new(&members, &[], &joints, &options, memory.lend()).expect("a world");
    let (steps, each) = ((time / time_step).round() as usize, (every / time_step).round() as usize);
    let mut found = vec![];
    for step in 0..steps {
        if let Member::Free(body) = &mut members[0] {
            body.with(|parts| {
                let flight = parts.flight.as_mut().expect("a flight");
                for (place, force) in force((step as f64 + 0.5) * time_step) {
                    flight.push(parts.scene, parts.loads, &at(place), force).expect("a push");
                }
            });
        }
        let report = world.step(&mut members).expect("a step");
        assert!(report.converged, "{report:?}");
        if (step + 1) % each == 0
            && let Member::Free(body) = &members[0]
        {
            let now = body.in_space(&watched, Field::Displacement).expect("a point");
            found.push(std::array::from_fn(|c| now[c] - point[c]));
        }
    }
    found
}

/// Largest distance of two histories, of the largest of the second.
fn worst_off(found: &[[f64; 3]], expected: &[[f64; 3]]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let size = |a: &[f64; 3]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = expected.iter().map(size).fold(0.0, f64::max);
    let off = found.iter().zip(expected).map(|(a, b)| size(&std::array::from_fn(|c| a[c] - b[c])));
    off.fold(0.0, f64::max) / largest
}

/// A cube that falls into a cable, and swings up and down on it.
#[test]
fn a_cable_catches_as_at_full_order() {
    let (stiffness, slack, times) = (2000.0, 0.005, (0.25, 1e-3));
    let top = [0.04, 0.04, 0.08];
    let whole = FullBody::new(&problem(CUBE, RUBBER, 8, false));
    let node = whole.on(|x| (0..3).all(|c| (x[c] - top[c]).abs() < 1e-9))[0];
    // Towards the anchor 0.1 m above, wherever the node has moved to.
    let expected = whole.march(times, -9.81, node, &[], &|_, u| {
        let away = [-u[node][0], -u[node][1], 0.1 - u[node][2]];
        let length = away.iter().map(|x| x * x).sum::<f64>().sqrt();
        let force = stiffness * (length - 0.1 - slack).max(0.0);
        vec![(node, away.map(|x| force * x / length))]
    });
    let joint = |file: &File<'_>| WorldJoint {
        compliance: 1.0 / stiffness,
        ..WorldJoint::new(
            JointKind::Cable { length: 0.1 + slack },
            [0, 1],
            [Anchor::Place(Place::node(node_at(file, top))), Anchor::point([0.04, 0.04, 0.18])],
        )
    };
    // Up and down. Sideways the cube sways by what the mesh is not symmetric, 0.3 mm of 13, which depends on
    // how the mass is shared among the nodes.
    let vertical = |all: &[[f64; 3]]| -> Vec<[f64; 3]> { all.iter().map(|u| [0.0, 0.0, u[2]]).collect() };
    for (time_step, bound) in [(1e-3, 0.04), (0.25e-3, 0.02)] {
        let file = built(&problem(CUBE, RUBBER, 32, false));
        let found = held_by(&file, time_step, times, -9.81, (&joint, top), &|_| vec![]);
        let off = worst_off(&vertical(&found), &vertical(&expected));
        println!("cable, {time_step:e} s: off by {off:.4}");
        assert!(off < bound, "{off}");
    }
}

/// A cube on a slider along z, pushed at a corner along and across.
#[test]
fn a_slider_slides_as_at_full_order() {
    let times = (0.1, 1e-3);
    let corner = [0.08, 0.08, 0.08];
    let force = |t: f64| -> [f64; 3] {
        let wave = (2.0 * std::f64::consts::PI * 40.0 * t).sin();
        [2.0 * wave, -1.5 * wave, 4.0 * (1.0 - (2.0 * std::f64::consts::PI * 20.0 * t).cos())]
    };
    let port = format!("{RUBBER}[[port]]\nname = \"eye\"\nkind = \"frame\"\non = {{ group = \"z_min\" }}\n");
    let whole = FullBody::new(&problem(CUBE, &port, 8, false));
    let node = whole.on(|x| (0..3).all(|c| (x[c] - corner[c]).abs() < 1e-9))[0];
    let expected = whole.march(times, 0.0, node, &[0, 1, 3, 4, 5], &|t, _| vec![(node, force(t))]);
    let joint = |_: &File<'_>| {
        WorldJoint::new(JointKind::Slider, [1, 0], [Anchor::point([0.04, 0.04, 0.0]), Anchor::Frame(0)])
    };
    for (time_step, bound) in [(1e-3, 0.05), (0.25e-3, 0.02)] {
        let file = built(&problem(CUBE, &port, 32, false));
        let found = held_by(&file, time_step, times, 0.0, (&joint, corner), &|t| vec![(corner, force(t))]);
        let off = worst_off(&found, &expected);
        println!("slider, {time_step:e} s: off by {off:.4}");
        assert!(off < bound, "{off}");
    }
}
