//! Bodies that touch in a world, against full-order solutions with the same contact law.
//!
//! The bodies and loads: a cube of 0.08 m of 8 × 8 × 8 cells on a block of 0.16 × 0.16 × 0.08 m, linear
//! tetrahedra, Young's modulus 1 MPa, whose meshes do not match; 81 nodes of the cube touch.

mod reference;

use std::path::PathBuf;

use reference::{FullBody, Pair};
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{
    Body, BodyOptions, JointState, Member, Near, Nodes, Pose, RigidMotion, RigidShape, Slot, Touch, Touching,
    World, WorldMemory, WorldOptions, WorldReport,
};
use vademecum_format::File;

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

/// Memory of a world.
#[derive(Default)]
struct Memory {
    slots: Vec<Slot>,
    touches: Vec<Touch>,
    joints: Vec<JointState>,
    near: Vec<Near>,
    numbers: Vec<f64>,
}

impl Memory {
    fn of(members: &[Member<'_, '_, f64>], options: &WorldOptions) -> Self {
        let sizes = World::sizes(members, &[], options).expect("sizes");
        Self {
            slots: vec![Slot::default(); sizes.slots],
            touches: vec![Touch::NONE; sizes.touches],
            joints: vec![JointState::default(); sizes.joints],
            near: vec![Near::default(); sizes.near],
            numbers: vec![f64::NAN; sizes.numbers],
        }
    }

    fn lend(&mut self) -> WorldMemory<'_> {
        WorldMemory {
            slots: &mut self.slots,
            touches: &mut self.touches,
            joints: &mut self.joints,
            near: &mut self.near,
            numbers: &mut self.numbers,
        }
    }
}

/// What a march of a cube over a base tells.
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
    let mut memory = Memory::of(&members, &options);
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
        println!("tilt {tilt}: full order {expected:?}");
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
    let mut memory = Memory::of(&members, &options);
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
        let mut memory = Memory::of(&members, &options);
        let mut world = World::new(&members, &pairs, &[], &options, memory.lend()).expect("a world");
        for _ in 0..20 {
            world.step(&mut members).expect("a step");
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
        let mut memory = Memory::of(&members, &options);
        let mut world = World::new(&members, &pairs, &[], &options, memory.lend()).expect("a world");
        let weight = 9.81 * body.mass;
        let steps = 1500;
        let mut worst = 0.0_f64;
        for step in 0..steps {
            world.step(&mut members).expect("a step");
            let force: f64 = world.touches().iter().map(|touch| touch.force()[2]).sum();
            if step > steps - 200 {
                worst = worst.max((force / weight - 1.0).abs());
            }
        }
        println!("  rests with {worst:.1e} of its weight");
        assert!(worst < 0.01, "{worst}");
    }
}
