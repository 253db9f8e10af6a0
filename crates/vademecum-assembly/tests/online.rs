//! Bodies joined at bind, by the evaluator: glued and broken while they move, free, with hinges and sliders,
//! their reactions, and files that are wrong.

use std::path::PathBuf;
use std::sync::LazyLock;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::File;
use vademecum_eval::{
    Assembly, AssemblyError, AssemblyOptions, AssemblySizes, End, Joint, JointEnergy, JointFault, Loads,
    Part, PartFault, PartState, Pose, RigidBody, RigidMotion, Scene, SceneOptions, State,
};

include!("../../vademecum-eval/doc/masses.rs");

/// Half of a beam or the whole of it, held at one end or free.
fn read(name: &str) -> Vec<u8> {
    let (length, divisions, modes) = if name.starts_with("whole") { (1.0, 20, 24) } else { (0.5, 10, 8) };
    let held = name.starts_with("held");
    let port = |port: &str, side: &str| {
        format!(
            "[[port]]\nname = \"{port}\"\non = {{ group = \"{side}\" }}\n\
             [[port]]\nname = \"{}\"\nkind = \"frame\"\non = {{ group = \"{side}\" }}\n",
            if port == "end" { "pin" } else { "eye" }
        )
    };
    let more = match (held, name.starts_with("whole")) {
        (true, _) => format!("[[support]]\non = {{ group = \"x_min\" }}\n{}", port("end", "x_max")),
        (false, true) => probe(1.0),
        (false, false) => format!("{}{}{}", port("end", "x_min"), port("far", "x_max"), probe(0.5)),
    };
    let text = format!(
        "[mesh]\nblock = {{ lengths = [{length}, 0.05, 0.05], divisions = [{divisions}, 2, 2] }}\n\
         [[material]]\nyoung = 2e9\npoisson = 0.3\ndensity = 1000.0\n[time]\nstep = 1e-4\n\
         [basis]\nmodes = {modes}\n[output]\nprecision = \"f64\"\n\
         [[load.pattern]]\nname = \"weight\"\nacceleration = [1.0, 2.0, -9.81]\n{more}"
    );
    let problem = Problem::parse(&text, "part.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}

fn probe(x: f64) -> String {
    format!("[[output.probe]]\nname = \"end\"\npoint = [{x}, 0.05, 0.05]\ndirection = [0.0, 0.6, 0.8]\n")
}

static HELD: LazyLock<Vec<u8>> = LazyLock::new(|| read("held8"));
static FREE: LazyLock<Vec<u8>> = LazyLock::new(|| read("free8"));

/// A body in its first place, and another where the first one ends.
fn halves<'a>(first: &'a [u8], second: &'a [u8]) -> [Part<'a>; 2] {
    let part = |name, bytes, x| {
        let file = File::parse(bytes).expect("a file");
        Part::new(name, file, Pose::new([x, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])).expect("a part")
    };
    [part("a", first, 0.0), part("b", second, 0.5)]
}

fn end(parts: &[Part<'_>], name: &str) -> End {
    End::find(parts, name).expect("a port")
}

/// Memory that an assembly borrows.
#[derive(Default)]
struct Lent {
    bytes: Vec<u8>,
    memory: Vec<f64>,
    work: Vec<f64>,
}

impl Lent {
    fn bind<'m>(
        &'m mut self,
        parts: &'m [Part<'m>],
        joints: &'m [Joint<'m>],
        options: &AssemblyOptions<'_>,
    ) -> Result<(Assembly<'m>, &'m mut [f64]), AssemblyError> {
        let AssemblySizes { bytes, memory, work, .. } = Assembly::sizes(parts, joints, options)?;
        // Whatever is in lent memory does not matter.
        *self = Self { bytes: vec![0xa5; bytes], memory: vec![f64::NAN; memory], work: vec![f64::NAN; work] };
        let assembly =
            Assembly::bind(parts, joints, options, &mut self.bytes, &mut self.memory, &mut self.work)?;
        Ok((assembly, &mut self.work))
    }
}

fn eigenvalues(parts: &[Part<'_>], joints: &[Joint<'_>]) -> Result<Vec<f64>, AssemblyError> {
    let mut lent = Lent::default();
    let (assembly, _) = lent.bind(parts, joints, &AssemblyOptions::default())?;
    Ok(assembly.report().eigenvalues.to_vec())
}

/// Numbers between −1 and 1.
fn numbers(count: usize, mut seed: u64) -> Vec<f64> {
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

fn section(file: &File<'_>, kind: SectionKind) -> Vec<f64> {
    file.section(kind).expect("a section").numbers().expect("numbers").iter().collect()
}

/// Squares of the angular frequencies of a part, zeros of rigid motions first.
fn own_eigenvalues(part: &Part<'_>) -> Vec<f64> {
    let own = section(part.file(), SectionKind::Eigenvalues);
    std::iter::repeat_n(0.0, part.n_rigid()).chain(own).collect()
}

/// Elastic and kinetic energy of parts apart.
fn energy_apart(parts: &[Part<'_>], q: &[f64], rates: &[f64]) -> f64 {
    let values = parts.iter().flat_map(own_eigenvalues);
    let elastic: f64 = q.iter().zip(values).map(|(q, value)| value * q * q).sum();
    0.5 * (elastic + rates.iter().map(|v| v * v).sum::<f64>())
}

/// Coordinates with about the same energy in each of the modes, and rates.
fn moving(parts: &[Part<'_>], seed: u64) -> [Vec<f64>; 2] {
    let values: Vec<f64> = parts.iter().flat_map(own_eigenvalues).collect();
    let scaled = |(x, value): (f64, &f64)| if *value == 0.0 { 1e-3 * x } else { x / value.sqrt() };
    let q = numbers(values.len(), seed).into_iter().zip(&values).map(scaled).collect();
    [q, numbers(values.len(), seed + 1)]
}

/// States of parts, whose coordinates come one after the other.
fn states<'s>(parts: &[Part<'_>], [q, rates]: [&'s [f64]; 2]) -> Vec<PartState<'s>> {
    let mut first = 0;
    let of = |part: &Part<'_>| {
        let own = first..first + part.n_coordinates();
        first = own.end;
        PartState { displacement: &q[own.clone()], velocity: &rates[own], port_motion: &[] }
    };
    parts.iter().map(of).collect()
}

/// The parts of a state of the joined body, their energy apart, and that of the joints.
fn apart(
    assembly: &Assembly<'_>,
    [eta, rates]: [&[f64]; 2],
    work: &mut [f64],
) -> ([Vec<f64>; 2], f64, JointEnergy) {
    let r = assembly.n_coordinates();
    let (mut q, mut speeds, mut forces) = (vec![0.0; r], vec![0.0; r], vec![0.0; assembly.report().rows]);
    assembly.part_states(eta, rates, &mut q, &mut speeds, work).expect("parts");
    assembly.forces_into(&q, &[], &mut forces).expect("forces");
    let joints = assembly.joint_energy(&forces, &speeds);
    let energy = energy_apart(assembly.parts(), &q, &speeds);
    ([q, speeds], energy, joints)
}

/// Steps the joined body under the pattern of its glue; gives its state.
fn stepped(file: &File<'_>, glue: Option<usize>, [eta, rates]: [&[f64]; 2], steps: usize) -> [Vec<f64>; 2] {
    let options = SceneOptions::default();
    let sizes = Scene::<f64>::sizes(file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut of_state, mut of_loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(file, &options, &mut memory, &mut work).expect("a scene");
    let mut state = State::new(&scene, &mut of_state).expect("a state");
    let mut loads = Loads::new(&scene, &mut of_loads).expect("loads");
    glue.into_iter().for_each(|pattern| loads.add_pattern(&scene, pattern, 1.0).expect("a load"));
    scene.set(&mut state, eta, rates, &loads).expect("set");
    for _ in 0..steps {
        scene.step(&mut state, &loads).expect("a step");
    }
    let step = file.metadata().time_step;
    [state.zeta().to_vec(), state.scaled_velocity().iter().map(|v| v / step).collect()]
}

fn furthest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn glue_keeps_the_energy_a_thousand_steps_do_and_break_loses_that_of_the_joint() {
    let parts = halves(&HELD, &FREE);
    let joints = [Joint::weld(end(&parts, "b.end"), end(&parts, "a.end")).as_it_stands()];
    for inertia in [true, false] {
        let [q, rates] = moving(&parts, 1);
        let standing = states(&parts, [&q, &rates]);
        let options = AssemblyOptions { inertia, time_step: Some(1e-4), ..AssemblyOptions::default() };
        let mut lent = Lent::default();
        let (assembly, work) = lent.bind(&parts, &joints, &options.as_it_stands(&standing)).expect("joined");
        assert_eq!(assembly.report().rubin, inertia);
        let r = assembly.n_coordinates();
        let (mut eta, mut of_eta) = (vec![0.0; r], vec![0.0; r]);
        assembly.join(&standing, &mut eta, &mut of_eta, work).expect("joined");

        // Glued: no displacement, rate or energy jumps, and no force is there yet.
        let before = energy_apart(&parts, &q, &rates);
        let ([found, speeds], energy, joint) = apart(&assembly, [&eta, &of_eta], work);
        assert!(furthest(&found, &q) < 1e-15 && furthest(&speeds, &rates) < 1e-13);
        let after = energy + joint.stored;
        println!("glue, Rubin {inertia}: energy {:.1e}", after / before - 1.0);
        assert!((after / before - 1.0).abs() < 1e-13, "{after} beside {before}");
        assert!(joint.stored < 1e-24 * before, "{:e}", joint.stored);
        // Rates that were taken over as they are would have gained this.
        assert!(inertia == (joint.moving > 1e-3 * before), "{:e}", joint.moving / before);

        let [eta, of_eta] = stepped(assembly.file(), assembly.glue_pattern(), [&eta, &of_eta], 1000);
        let ([q, speeds], energy, joint) = apart(&assembly, [&eta, &of_eta], work);
        let later = energy + joint.stored;
        println!(
            "  after 1000 steps: {:.1e}; in the joint {:.1e}",
            later / before - 1.0,
            joint.stored / before
        );
        assert!((later / before - 1.0).abs() < 1e-12, "{later} beside {before}");
        assert!(joint.stored > 1e-3 * before);

        // Broken: ½ fᵀS f, here from the gap S f of the joint that the states of the parts have, is lost.
        let mut anew = Lent::default();
        let broken = states(&parts, [&q, &speeds]);
        let options = options.as_it_stands(&broken);
        let (other, _) = anew.bind(&parts, &joints, &options).expect("joined");
        let gap: Vec<f64> = other.offsets(0).expect("offsets").to_vec();
        let own = assembly.offsets(0).expect("offsets");
        let mut forces = vec![0.0; gap.len()];
        assembly.forces_into(&q, &[], &mut forces).expect("forces");
        let lost: f64 = gap.iter().zip(own).zip(&forces).map(|((g, own), f)| -0.5 * (g - own) * f).sum();
        let gone = before - energy_apart(&parts, &q, &speeds);
        println!("  broken: {:.1e} beside {:.1e}", gone / before, lost / before);
        assert!((gone - lost).abs() < 1e-12 * before, "{gone:e} beside {lost:e}");
    }
}

#[test]
fn a_joint_made_as_it_stands_leaves_the_forces_of_those_before_it() {
    let parts = halves(&HELD, &FREE);
    let [pin, eye] = ["b.end", "a.end"].map(|name| end(&parts, name));
    // In motion, welded; then the far end is held as it is.
    let [q, rates] = moving(&parts, 5);
    let before = [Joint::weld(pin, eye)];
    let mut lent = Lent::default();
    let options = AssemblyOptions::default();
    let (assembly, _) = lent.bind(&parts, &before, &options).expect("joined");
    let mut forces = vec![0.0; assembly.report().rows];
    assembly.forces_into(&q, &[], &mut forces).expect("forces");
    let both = [before[0], Joint::weld(end(&parts, "b.eye"), None).as_it_stands()];
    let states = states(&parts, [&q, &rates]);
    let mut more = Lent::default();
    let (held, _) = more.bind(&parts, &both, &options.as_it_stands(&states)).expect("joined");
    let mut found = vec![0.0; held.report().rows];
    held.forces_into(&q, &[], &mut found).expect("forces");
    let size = forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    let (old, new) = found.split_at(forces.len());
    assert!(furthest(old, &forces) < 1e-10 * size, "{:e}", furthest(old, &forces) / size);
    assert!(new.len() == 6 && new.iter().all(|f| f.abs() < 1e-10 * size), "{new:?}");
    // With its offsets it is the same joint in another assembly.
    let given = [before[0], Joint::weld(end(&parts, "b.eye"), None).at(held.offsets(1).expect("offsets"))];
    let mut again = Lent::default();
    let (same, _) = again.bind(&parts, &given, &options).expect("joined");
    assert_eq!(same.bytes(), held.bytes());
    // One that stands may not come before one that does not.
    let turned = [both[1], both[0]];
    let refused = Assembly::sizes(&parts, &turned, &options).expect_err("an order");
    assert_eq!(refused, AssemblyError::Joint { joint: 1, fault: JointFault::Order });
}

#[test]
fn reactions_hold_the_weight_of_what_hangs_on_them() {
    let parts = halves(&HELD, &FREE);
    let joints = [Joint::weld(end(&parts, "b.end"), end(&parts, "a.end"))];
    let mut lent = Lent::default();
    let (assembly, work) = lent.bind(&parts, &joints, &AssemblyOptions::default()).expect("joined");
    let file = assembly.file();
    let pattern = file.pattern_names().position(|name| name == "b.weight").expect("a pattern");
    let values = section(file, SectionKind::Eigenvalues);
    let rows = section(file, SectionKind::PatternBasis);
    let eta: Vec<f64> =
        values.iter().enumerate().map(|(k, value)| rows[pattern * values.len() + k] / value).collect();
    let r = values.len();
    let (mut q, mut rates) = (vec![0.0; r], vec![0.0; r]);
    assembly.part_states(&eta, &vec![0.0; r], &mut q, &mut rates, work).expect("parts");
    let mut motion = vec![0.0; parts[1].n_port_rows()];
    parts[1].move_ports(&[], &[(0, 1.0)], &mut motion).expect("motion");
    let mut forces = vec![0.0; assembly.report().rows];
    assembly.forces_into(&q, &[&[], &motion], &mut forces).expect("forces");
    let mut nodal = vec![0.0; 75];
    let found = assembly.nodal_reaction_into(0, &forces, &mut nodal).expect("a reaction");
    assert_eq!(found, assembly.reaction(0, &forces).expect("a reaction"));
    // 1.25 kg at an acceleration of (1, 2, −9.81) m/s², 0.25 m behind the joint.
    let weight = [1.25, 2.5, -12.2625];
    let expected = weight.map(|x: f64| -x);
    assert!(furthest(&found.force, &expected) < 1e-9, "{found:?}");
    let moment = [0.0, 0.25 * weight[2], -0.25 * weight[1]];
    assert!(furthest(&found.moment, &moment) < 1e-9, "{found:?}");
    let sum = |c: usize| nodal.iter().skip(c).step_by(3).sum::<f64>();
    assert!(furthest(&[sum(0), sum(1), sum(2)], &found.force) < 1e-9);
}

#[test]
fn parts_that_nothing_holds_are_one_free_body() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let file = File::parse(&FREE).expect("a file");
    // Turned about z by a right angle, one behind the other along y.
    let part =
        |name, y| Part::new(name, file, Pose::new([0.1, y, 0.3], [half, 0.0, 0.0, half])).expect("a part");
    let parts = [part("a", 0.2), part("b", 0.7)];
    let joints = [Joint::weld(end(&parts, "b.end"), end(&parts, "a.far"))];
    let mut lent = Lent::default();
    let (assembly, work) = lent.bind(&parts, &joints, &AssemblyOptions::default()).expect("joined");
    vademecum_rewrite::check(assembly.bytes()).expect("a sound file");
    let whole = read("whole_free");
    let whole = File::parse(&whole).expect("a file");
    let joined = assembly.file();
    let [found, expected] = [joined, &whole].map(|file| section(file, SectionKind::Eigenvalues));
    assert_eq!((assembly.n_rigid(), found.len()), (6, assembly.n_coordinates() - 6));
    let worst = (0..6).map(|k| ((found[k] / expected[k]).sqrt() - 1.0).abs()).fold(0.0, f64::max);
    println!("free beam: {worst:.1e}");
    assert!(worst < 1e-4, "{worst:e}");

    // Mass, moments, and the place of the centre.
    let [rigid, of_whole] = [joined, &whole].map(|file| RigidBody::of(file).expect("a free body"));
    assert!((rigid.mass / of_whole.mass - 1.0).abs() < 1e-12);
    assert!(furthest(&rigid.centre, &[0.075, 0.7, 0.325]) < 1e-12, "{rigid:?}");
    let sorted = |mut moments: [f64; 3]| {
        moments.sort_by(f64::total_cmp);
        moments
    };
    assert!(furthest(&sorted(rigid.moments), &sorted(of_whole.moments)) < 1e-12);

    // Static answers of the probe at the end to the angular velocity. Axes of the whole are y, −x, z here.
    let answer = |file: &File<'_>, pattern: usize, probe: usize| -> f64 {
        let numbers = |kind| section(file, kind);
        let (values, rest) = (numbers(SectionKind::Eigenvalues), numbers(SectionKind::PatternProbeResidual));
        let (loads, rows) = (numbers(SectionKind::PatternBasis), numbers(SectionKind::ProbeRows));
        let (r, probes) = (values.len(), file.metadata().n_probes as usize);
        let modal = (0..r).map(|k| loads[pattern * r + k] * rows[probe * r + k] / values[k]);
        modal.sum::<f64>() + rest[pattern * probes + probe]
    };
    let first = |file: &File<'_>| RigidBody::of(file).expect("a free body").first_pattern;
    for (of_whole, here, sign) in
        [(0, 1, 1.0), (1, 0, 1.0), (2, 2, 1.0), (3, 3, -1.0), (4, 5, -1.0), (5, 4, 1.0)]
    {
        let expected = answer(&whole, first(&whole) + of_whole, 0);
        let found = sign * answer(joined, first(joined) + here, 1);
        // Of a shear of 2e-9 m for each unit, a part in 1e9.
        assert!((found - expected).abs() < 2e-18, "{of_whole}: {found:e} beside {expected:e}");
    }
    // The rigid motions of the joined body are those that a part of its file would have.
    let alone = Part::new("whole", *joined, Pose::IDENTITY).expect("a part");
    let (v, spin) = ([0.3, -0.2, 0.5], [1.0, 2.0, -0.7]);
    let r = assembly.n_coordinates();
    let mut rates = vec![0.0; r];
    rates[..6].copy_from_slice(&alone.rigid_coordinates(v, spin));
    let ([_, speeds], energy, joint) = apart(&assembly, [&vec![0.0; r], &rates], work);
    let of_parts = speeds.split_at(parts[0].n_coordinates());
    for (part, speeds) in parts.iter().zip([of_parts.0, of_parts.1]) {
        let centre = part.pose().place(part.rigid().expect("a free part").centre);
        let arm: [f64; 3] = std::array::from_fn(|c| centre[c] - rigid.centre[c]);
        let at_centre: [f64; 3] = std::array::from_fn(|c| {
            let [i, j] = [(c + 1) % 3, (c + 2) % 3];
            v[c] + spin[i] * arm[j] - spin[j] * arm[i]
        });
        let [moved, turned] = part.rigid_motion(speeds).map(|x| part.pose().turn(x));
        assert!(furthest(&moved, &at_centre) < 1e-12 && furthest(&turned, &spin) < 1e-12);
        assert!(speeds[6..].iter().all(|x| x.abs() < 1e-12));
    }
    let expected = RigidMotion::thrown(&rigid, v, spin).energy(&rigid);
    assert!((energy / expected - 1.0).abs() < 1e-12, "{energy} beside {expected}");
    assert!(joint.moving < 1e-12 && joint.stored < 1e-12, "{joint:?}");
}

#[test]
fn a_hinge_and_a_slider_leave_their_motion_and_hold_the_others() {
    let parts = halves(&HELD, &FREE);
    let [pin, eye] = ["b.pin", "a.pin"].map(|name| end(&parts, name));
    let moves = |joint| match eigenvalues(&parts, &[joint]) {
        Err(AssemblyError::Moves { motions, parts }) => (motions, parts),
        other => panic!("{other:?}"),
    };
    assert_eq!(moves(Joint::hinge(pin, eye)), (1, 2));
    assert_eq!(moves(Joint::ball(pin, eye)), (3, 2));
    assert_eq!(moves(Joint::slider(pin, eye)), (1, 2));
    // The motion that is left, on a spring from soft to stiff, goes to a weld from below.
    let welded = eigenvalues(&parts, &[Joint::weld(pin, eye)]).expect("joined");
    for (joint, motion) in [(Joint::hinge(pin, eye), 5), (Joint::slider(pin, eye), 2)] {
        let off = |stiffness: f64| {
            let mut along = [0.0; 6];
            along[motion] = stiffness;
            let found = eigenvalues(&parts, &[joint, Joint::bushing(pin, eye, &along)]).expect("joined");
            1.0 - found[0] / welded[0]
        };
        let [soft, middle, stiff, stiffer] = [1.0, 1e4, 1e10, 1e11].map(off);
        assert!(1.0 > soft && soft > middle && middle > stiff && stiff > 0.0, "{soft} {middle} {stiff}");
        // Of stiff springs, what they yield goes with the inverse of their stiffness.
        assert!((stiff / stiffer - 10.0).abs() < 0.1 && stiffer < 1e-6, "{stiff:e} {stiffer:e}");
        // A reaction has nothing along the motion that is left.
        let mut along = [0.0; 6];
        along[motion] = 1e3;
        let joints = [joint, Joint::bushing(pin, eye, &along)];
        let mut lent = Lent::default();
        let (assembly, _) = lent.bind(&parts, &joints, &AssemblyOptions::default()).expect("joined");
        let [q, _] = moving(&parts, 9);
        let mut forces = vec![0.0; assembly.report().rows];
        assembly.forces_into(&q, &[], &mut forces).expect("forces");
        let (held, sprung) =
            (assembly.reaction(0, &forces).expect("one"), assembly.reaction(1, &forces).expect("one"));
        let axis = parts[1].pose().turn([0.0, 0.0, 1.0]);
        let along = |v: [f64; 3]| v.iter().zip(axis).map(|(a, b)| a * b).sum::<f64>().abs();
        let of = |force: &vademecum_eval::JointForce| {
            if motion < 3 { along(force.force) } else { along(force.moment) }
        };
        assert!(of(&held) < 1e-12 * of(&sprung) && of(&sprung) > 0.0, "{held:?} {sprung:?}");
    }
    let twice = [Joint::weld(pin, eye), Joint::hinge(pin, eye)];
    let refused = eigenvalues(&parts, &twice).expect_err("twice");
    assert_eq!(refused, AssemblyError::Joint { joint: 1, fault: JointFault::Redundant });
}

#[test]
fn memory_that_is_too_short_is_refused_with_what_is_needed() {
    let parts = halves(&HELD, &FREE);
    let joints = [Joint::weld(end(&parts, "b.end"), end(&parts, "a.end"))];
    let options = AssemblyOptions::default();
    let sizes = Assembly::sizes(&parts, &joints, &options).expect("sizes");
    let bind = |short: [usize; 3]| {
        let (mut bytes, mut memory) = (vec![0; sizes.bytes - short[0]], vec![0.0; sizes.memory - short[1]]);
        let mut work = vec![0.0; sizes.work - short[2]];
        let bound = Assembly::bind(&parts, &joints, &options, &mut bytes, &mut memory, &mut work);
        bound.map(|assembly| assembly.bytes().len())
    };
    let length = bind([0; 3]).expect("joined");
    assert_eq!(bind([sizes.bytes - length, 0, 0]), Ok(length));
    for short in [[sizes.bytes - length + 1, 0, 0], [sizes.bytes, 0, 0], [0, 1, 0], [0, sizes.memory, 0]] {
        assert!(matches!(bind(short), Err(AssemblyError::LentMemory { .. })), "{short:?}");
    }
    assert!(matches!(bind([0, 0, sizes.work]), Err(AssemblyError::LentMemory { .. })));
}

#[test]
fn wrong_numbers_in_a_file_are_refused_or_joined_and_never_a_panic() {
    use SectionKind as S;
    let kinds = [
        S::PortNames,
        S::PortTable,
        S::PortFrames,
        S::PortNodes,
        S::PortFacets,
        S::PortRows,
        S::PortCompliance,
        S::PortInertia,
        S::PortResidual,
        S::PortProbes,
        S::PortPatterns,
        S::ProbeMotions,
        S::RigidBody,
        S::Eigenvalues,
        S::NodeCoordinates,
        S::Triangles,
        S::ResidualPairs,
        S::PatternNames,
    ];
    let (mut refused, mut joined) = (0, 0);
    for (number, kind) in kinds.into_iter().enumerate() {
        let raw = {
            let file = File::parse(&FREE).expect("a file");
            let own = file.section(kind).unwrap_or_else(|| panic!("{kind}")).raw().expect("raw");
            let start = own.as_ptr() as usize - FREE.as_ptr() as usize;
            start..start + own.len()
        };
        for (round, noise) in numbers(3, 77 + number as u64).into_iter().enumerate() {
            // Checksums of sections are not looked at when a file is opened.
            let mut wrong = FREE.clone();
            let own = &mut wrong[raw.clone()];
            let at = ((0.5 + 0.5 * noise) * own.len() as f64) as usize / 8 * 8;
            let last = own.len().min(at + if round == 0 { 8 } else { 64 });
            own[at..last].fill(if round == 1 { 0x7f } else { 0xff });
            let held = File::parse(&HELD).expect("a file");
            let file = File::parse(&wrong).expect("sections are not read");
            let first = Part::new("a", held, Pose::IDENTITY).expect("a part");
            let pose = Pose::new([0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
            let Ok(second) = Part::new("b", file, pose) else {
                refused += 1;
                continue;
            };
            let parts = [first, second];
            for port in ["b.end", "b.pin"] {
                let Some(own) = End::find(&parts, port) else {
                    refused += 1;
                    continue;
                };
                let other = end(&parts, if port == "b.end" { "a.end" } else { "a.pin" });
                let joints = [Joint::weld(own, other)];
                let mut lent = Lent::default();
                match lent.bind(&parts, &joints, &AssemblyOptions::default()) {
                    Ok(_) => joined += 1,
                    Err(_) => refused += 1,
                }
            }
        }
    }
    println!("{refused} refused, {joined} joined");
    assert!(refused > 20 && joined > 10, "{refused} {joined}");
}

#[test]
fn parts_and_joints_that_do_not_fit_are_refused_by_number() {
    let parts = halves(&HELD, &FREE);
    let [patch, pin, eye] = ["b.end", "b.pin", "a.pin"].map(|name| end(&parts, name));
    let fault = |joint: Joint<'_>| match Assembly::sizes(&parts, &[joint], &AssemblyOptions::default()) {
        Err(AssemblyError::Joint { joint: 0, fault }) => fault,
        other => panic!("{other:?}"),
    };
    assert_eq!(fault(Joint::weld(patch, eye)), JointFault::Mixed);
    assert_eq!(fault(Joint::hinge(patch, None)), JointFault::OfPatches);
    assert_eq!(fault(Joint::weld(End { part: 2, port: 0 }, None)), JointFault::NoPort { part: 2, port: 0 });
    assert_eq!(fault(Joint::bushing(pin, eye, &[1.0])), JointFault::Stiffness { found: 1, expected: 6 });
    assert_eq!(fault(Joint::bushing(pin, eye, &[0.0; 6])), JointFault::Stiffness { found: 6, expected: 6 });
    assert_eq!(fault(Joint::weld(pin, eye).at(&[0.0])), JointFault::Offsets { found: 1, expected: 6 });
    assert_eq!(fault(Joint::spring(pin, pin, &[1.0])), JointFault::OnePlace);
    let far = |distance| {
        eigenvalues(&parts, &[Joint::weld(end(&parts, "b.far"), end(&parts, "a.end")).within(distance)])
    };
    match far(0.1).expect_err("apart") {
        AssemblyError::Joint { joint: 0, fault: JointFault::Apart { frames: false, distance, most } } => {
            assert!((distance - 0.5).abs() < 1e-12 && most == 0.1, "{distance} {most}");
        }
        other => panic!("{other:?}"),
    }
    assert!(far(0.6).is_ok());
    let turned = Pose::new([0.0; 3], [1.0, 1.0, 0.0, 0.0]);
    let unsound = [Part::new("a", *parts[0].file(), turned).expect("a part")];
    let refused = Assembly::sizes(&unsound, &[], &AssemblyOptions::default()).expect_err("a rotation");
    assert_eq!(refused, AssemblyError::Part { part: 0, fault: PartFault::Pose });
    let lonely = eigenvalues(&parts[1..], &[]).expect("one free body").len();
    assert_eq!(lonely, parts[1].n_coordinates() - 6);
}

#[test]
fn damping_that_couples_modes_is_that_of_the_parts_along_the_modes() {
    // Two masses of 1 kg with 2 N/m between them; K = [[3, −2], [−2, 5]].
    let stiffness = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    for (dampings, coupled) in
        [([0.3, 0.0], true), ([0.1, 0.1], false), ([2e-4, 1e-4], false), ([0.3, 0.2999], false)]
    {
        let [first, second] = [damped_mass(1.0, dampings[0]), damped_mass(3.0, dampings[1])];
        let part = |name, bytes| {
            Part::new(name, File::parse(bytes).expect("a file"), Pose::IDENTITY).expect("a part")
        };
        let parts = [part("a", &first), part("b", &second)];
        let joints = [Joint::bushing(end(&parts, "a.end"), end(&parts, "b.end"), &stiffness)];
        let mut lent = Lent::default();
        let (assembly, _) = lent.bind(&parts, &joints, &AssemblyOptions::default()).expect("joined");
        let (file, report) = (assembly.file(), assembly.report());
        let values = section(file, SectionKind::Eigenvalues);
        assert!(furthest(&values, &[4.0 - 5f64.sqrt(), 4.0 + 5f64.sqrt()]) < 1e-14);
        // Modes are (cos φ, sin φ) and (−sin φ, cos φ), with tan φ = (3 − λ)/2.
        let phi = ((3.0 - values[0]) / 2.0).atan();
        let [c, s] = [phi.cos(), phi.sin()];
        let [a, b] = dampings;
        let expected = [c * c * a + s * s * b, c * s * (b - a), s * s * a + c * c * b];
        assert_eq!(report.damping_coupled, coupled, "{dampings:?}: {:e}", report.damping_coupling);
        if a == b {
            assert_eq!((file.metadata().alpha, report.damping_coupling), (a, 0.0));
        } else if coupled {
            let rows = section(file, SectionKind::DampingRows);
            let entry = |i: usize, j: usize| rows.chunks(2).map(|row| row[i] * row[j]).sum::<f64>();
            let found = [entry(0, 0), entry(0, 1).abs(), entry(1, 1)];
            let expected = expected.map(f64::abs);
            assert!(furthest(&found, &expected) < 1e-15, "{found:?} beside {expected:?}");
        } else {
            let ratios = section(file, SectionKind::DampingRatios);
            let expected = [expected[0] / (2.0 * values[0].sqrt()), expected[2] / (2.0 * values[1].sqrt())];
            assert!(furthest(&ratios, &expected) < 1e-15 && report.damping_coupling > 0.0);
        }
    }
}
