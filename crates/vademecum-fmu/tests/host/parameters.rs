//! Live parameters, scales of the whole body, and steps of any length.

use vademecum_eval::format::{File, ParameterRole};
use vademecum_eval::{Body, BodyOptions, Field, LiveMemory, SceneOptions};
use vademecum_fmu::fmi2::*;
use vademecum_fmu::variables::Variable as V;

use crate::unit::*;

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
        BodyOptions { scene: vademecum_fmu::options(&file, 2, 0), places: 0, ..BodyOptions::default() };
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
