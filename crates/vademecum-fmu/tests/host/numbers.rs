//! Numbers of the evaluator, bit for bit.

use vademecum_eval::format::File;
use vademecum_eval::{Contact, Field, FreeBody, RigidMotion, SceneOptions};
use vademecum_fmu::fmi2::*;
use vademecum_fmu::fmi3::*;
use vademecum_fmu::variables::Variable as V;

use crate::unit::*;

#[test]
fn numbers_are_those_of_the_evaluator_bit_for_bit() {
    for name in ["fixed-f64.vdm", "exact-f64.vdm", "fixed-f32.vdm", "quadratic.vdm", "bent.vdm"] {
        let unit = Unit::new(name);
        let file = File::parse(&unit.bytes).expect("a file");
        let options = SceneOptions { contacts: 2, ..SceneOptions::default() };
        let mut memory = SceneMemory::new(&file, &options);
        let (scene, mut state, mut loads) = memory.bind(&file, &options);

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
        let mut memory = SceneMemory::new(&file, &options);
        let (scene, mut state, mut loads) = memory.bind(&file, &options);
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
    let mut memory = SceneMemory::new(&file, &options);
    let (scene, mut state, mut loads) = memory.bind(&file, &options);
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
