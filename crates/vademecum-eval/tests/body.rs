//! [`Body`] does what its parts do, bit for bit; what it saves comes back, and strangers are refused.

use vademecum_eval::format::File;
use vademecum_eval::{
    AnyBody, Body, BodyOptions, Field, LoadError, Loads, LoadsAfter, OutputError, ParameterError, Place,
    PlaceError, Precision, Quantity, Restored, SavedError, Scalar, Scene, SceneOptions, State, Surface,
};

const GOLDEN: [&str; 8] = [
    "fixed-f64.vdm",
    "parameters.vdm",
    "bent.vdm",
    "swinging.vdm",
    "free.vdm",
    "reactions.vdm",
    "base.vdm",
    "fixed-f32.vdm",
];

fn golden(name: &str) -> Vec<u8> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/golden").join(name);
    std::fs::read(path).unwrap_or_default()
}

/// Runs on every golden file that is there.
fn each(run: impl Fn(&str, &File<'_>)) {
    let mut seen = 0;
    for name in GOLDEN {
        let bytes = golden(name);
        if let Ok(file) = File::parse(&bytes) {
            run(name, &file);
            seen += 1;
        }
    }
    assert!(seen >= 6, "{seen} golden files");
}

fn options() -> BodyOptions {
    BodyOptions { keep_loads: true, flight: false, ..BodyOptions::default() }
}

/// Pushes as far as the file goes.
fn load<T: Scalar>(body: &mut Body<'_, T>) {
    if body.scene().metadata().n_patterns > 0 {
        body.push_pattern(0, 0.7).expect("a pattern");
    }
    if let Ok(at) = body.locate([0.1, 0.05, 0.0]) {
        body.push(&at, [1.0, -2.0, 0.5]).expect("a push");
    }
}

fn same_bits_as_the_parts<T: Scalar + std::fmt::Debug>(name: &str, file: &File<'_>) {
    let options = options();
    let mut memory = vec![f64::NAN; Body::<T>::len_for(file, &options).expect("a length")];
    let mut body = Body::<T>::bind(file, &options, &mut memory).expect("bound");
    let sizes = Scene::<T>::sizes(file, &options.scene).expect("sizes");
    let (mut a, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let (mut b, mut c) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let scene = Scene::bind(file, &options.scene, &mut a, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut b).expect("a state");
    let mut loads = Loads::new(&scene, &mut c).expect("loads");
    load(&mut body);
    if file.metadata().n_patterns > 0 {
        loads.add_pattern(&scene, 0, 0.7).expect("a pattern");
    }
    if let Some(at) = Surface::new(file).ok().and_then(|surface| surface.locate([0.1, 0.05, 0.0])) {
        let contact = vademecum_eval::Contact::new(at.place, [1.0, -2.0, 0.5]);
        loads.add_contact(&scene, &contact).expect("a push");
    }
    for _ in 0..50 {
        let [own, parts] = [body.step(), scene.step(&mut state, &loads)];
        assert_eq!(own, parts, "{name}");
    }
    assert_eq!(body.state().zeta(), state.zeta(), "{name}");
    assert_eq!(body.state().scaled_velocity(), state.scaled_velocity(), "{name}");
    let energy = scene.energy(&state).expect("energy");
    assert_eq!(body.energy(), Ok(energy), "{name}");
    // Apart, the two make the whole.
    let [kinetic, strain] = [scene.kinetic_energy(&state), scene.strain_energy(&state)].map(Result::unwrap);
    assert!((kinetic + strain - energy).abs() <= 1e-15 * energy.abs(), "{name}");
}

#[test]
fn a_body_steps_as_its_parts_do() {
    each(|name, file| {
        same_bits_as_the_parts::<f32>(name, file);
        same_bits_as_the_parts::<f64>(name, file);
    });
}

#[test]
fn short_memory_is_refused() {
    each(|name, file| {
        let needed = Body::<f32>::len_for(file, &options()).expect("a length");
        let mut memory = vec![0.0; needed - 1];
        assert!(Body::<f32>::bind(file, &options(), &mut memory).is_err(), "{name}");
    });
}

#[test]
fn kept_loads_come_back_and_need_room() {
    let bytes = golden("fixed-f64.vdm");
    let file = File::parse(&bytes).expect("a file");
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options()).expect("a length")];
    let mut body = Body::<f64>::bind(&file, &options(), &mut memory).expect("bound");
    load(&mut body);
    body.keep_loads().expect("room");
    body.clear();
    assert!(body.loads().is_empty());
    body.recall_loads().expect("room");
    assert!(!body.loads().is_empty());
    let without = BodyOptions { keep_loads: false, ..options() };
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &without).expect("a length")];
    let mut body = Body::<f64>::bind(&file, &without, &mut memory).expect("bound");
    assert_eq!(body.keep_loads(), Err(LoadError::NoRoom));
    assert_eq!(body.recall_loads(), Err(LoadError::NoRoom));
}

#[test]
fn parameters_are_set_all_or_none() {
    let bytes = golden("parameters.vdm");
    let file = File::parse(&bytes).expect("a file");
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options()).expect("a length")];
    let mut body = Body::<f64>::bind(&file, &options(), &mut memory).expect("bound");
    let [soft, hard] = ["soft", "hard"].map(|n| SceneOptions::find(file.metadata(), n).expect("a name"));
    let before = *body.scene().options();
    let refused = [
        (vec![(soft, 0.75), (99, 1.0)], ParameterError::Unknown { index: 99 }),
        (vec![(soft, 0.75), (soft, 0.8)], ParameterError::Twice { parameter: soft }),
    ];
    for (settings, expected) in refused {
        assert_eq!(body.set_parameters(&settings), Err(expected.into()));
        assert_eq!(*body.scene().options(), before);
    }
    assert!(body.set_parameters(&[(soft, 0.75), (hard, 1e9)]).is_err());
    assert_eq!(*body.scene().options(), before);
    assert_eq!(body.set_parameters(&[(soft, 0.75)]), Ok(LoadsAfter::Empty));
    assert_eq!(body.scene().options().value(file.metadata(), soft), Some(0.75));
    load(&mut body);
    assert_eq!(body.set_parameters(&[(soft, 1.0)]), Ok(LoadsAfter::Stale));
    assert!(body.step().is_err());
    body.clear();
    body.step().expect("a step");
}

#[test]
fn wrong_places_are_refused_where_they_are_used() {
    let bytes = golden("fixed-f64.vdm");
    let file = File::parse(&bytes).expect("a file");
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options()).expect("a length")];
    let mut body = Body::<f64>::bind(&file, &options(), &mut memory).expect("bound");
    let point = Place::triangle([0, 1, 3], [0.2, 0.5, 0.3]);
    let wrong = [
        (point.with_radius(0.01), PlaceError::Area { radius: 0.01 }),
        (point.with_radius(-0.01), PlaceError::Radius { radius: -0.01 }),
        (Place::frame(0), PlaceError::NoFrames { index: 0 }),
        (Place::triangle([0, 1, 3], [0.2, 0.5, 0.2]), PlaceError::Sum { sum: 0.2 + 0.5 + 0.2 }),
    ];
    for (place, expected) in wrong {
        assert_eq!(body.push(&place, [1.0; 3]), Err(LoadError::Place(expected)));
        assert_eq!(body.point(&place, Field::Displacement), Err(OutputError::Place(expected)));
        assert_eq!(body.compliance(&[place], &mut [0.0; 9]), Err(LoadError::Place(expected)));
        assert!(body.loads().is_empty());
    }
    // Four nodes do what the same force on each of them does.
    let four = Place::new(&[0, 1, 3, 4], &[0.25; 4]).expect("a place");
    body.push(&four, [0.0, 0.0, -8.0]).expect("loadable");
    body.step().expect("a step");
    let moved = body.state().zeta().to_vec();
    body.clear();
    body.rest();
    for node in [0, 1, 3, 4] {
        body.push(&Place::node(node), [0.0, 0.0, -2.0]).expect("loadable");
    }
    body.step().expect("a step");
    for (a, b) in moved.iter().zip(body.state().zeta()) {
        assert!((a - b).abs() <= 1e-12 * a.abs());
    }
}

#[test]
fn a_saved_state_comes_back_bit_for_bit() {
    each(|name, file| {
        for flight in [false, true] {
            let options = BodyOptions { flight, ..options() };
            let mut memory = vec![0.0; Body::<f32>::len_for(file, &options).expect("a length")];
            let mut body = Body::<f32>::bind(file, &options, &mut memory).expect("bound");
            let _ = body.throw([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]);
            load(&mut body);
            for _ in 0..5 {
                body.step().expect("a step");
            }
            let mut saved = vec![0; body.saved_len()];
            let written = body.save_into(&mut saved).expect("room");
            let saved = &saved[..written];
            let look = |body: &Body<'_, f32>| {
                let flight = body.motion().copied();
                let probe = (0..body.count(Quantity::Probe)).map(|k| body.probe(k, Field::Displacement));
                (body.state().zeta().to_vec(), body.energy(), flight, probe.collect::<Vec<_>>())
            };
            let before = look(&body);
            let onwards = |body: &mut Body<'_, f32>| {
                body.clear();
                load(body);
                body.step().expect("a step");
                look(body)
            };
            let after = onwards(&mut body);
            body.rest();
            assert_eq!(body.restore(saved), Ok(Restored::AsSaved), "{name}");
            assert_eq!(look(&body), before, "{name}");
            assert_eq!(onwards(&mut body), after, "{name}");

            // Cut, longer, untagged, with a number that is none, or of an unknown kind.
            for length in 0..written {
                assert!(body.restore(&saved[..length]).is_err(), "{name} {length}");
            }
            let longer = [saved, &[0; 8]].concat();
            assert!(matches!(body.restore(&longer), Err(SavedError::Length { .. })), "{name}");
            let changed = |at: usize, byte: u8| {
                let mut changed = saved.to_vec();
                changed[at] = byte;
                changed
            };
            assert_eq!(body.restore(&changed(0, b'X')), Err(SavedError::Untagged), "{name}");
            assert_eq!(body.restore(&changed(3, 2)), Err(SavedError::Untagged), "{name}");
            assert_eq!(body.restore(&changed(4, !saved[4])), Err(SavedError::OtherFile), "{name}");
            assert_eq!(body.restore(&changed(12, saved[12] ^ 1)), Err(SavedError::OtherStructure), "{name}");
            assert_eq!(body.restore(&changed(14, 128)), Err(SavedError::OtherContents), "{name}");
            assert_eq!(body.restore(&changed(15, 1)), Err(SavedError::OtherContents), "{name}");
            let at = 16 + 8 * (5 + 2 * file.metadata().n_regions as usize);
            let mut nan = saved.to_vec();
            nan[at..at + 8].copy_from_slice(&f64::NAN.to_le_bytes());
            assert_eq!(body.restore(&nan), Err(SavedError::NotFinite), "{name}");
            assert_eq!(look(&body), after, "{name}: a refusal changes nothing");
            assert!(matches!(body.save_into(&mut [0; 15]), Err(SavedError::Length { .. })));
        }
    });
}

#[test]
fn a_state_of_other_parameters_is_carried_and_said_to_be() {
    let bytes = golden("parameters.vdm");
    let file = File::parse(&bytes).expect("a file");
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options()).expect("a length")];
    let mut body = Body::<f64>::bind(&file, &options(), &mut memory).expect("bound");
    load(&mut body);
    body.march(5).expect("steps");
    let mut saved = vec![0; body.saved_len()];
    let written = body.save_into(&mut saved).expect("room");
    let r = body.scene().n_modes();
    let coordinates = |body: &Body<'_, f64>| {
        let (mut zeta, mut rate) = (vec![0.0; r], vec![0.0; r]);
        body.coordinates_into(&mut zeta, &mut rate).expect("as long");
        (zeta, rate)
    };
    let before = coordinates(&body);
    body.clear();
    let step = SceneOptions::find(file.metadata(), "step").expect("a name");
    let value = 1.1 * body.time_step();
    assert_eq!(body.set_parameters(&[(step, value)]), Ok(LoadsAfter::Empty));
    body.rest();
    assert_eq!(body.restore(&saved[..written]), Ok(Restored::Carried));
    let after = coordinates(&body);
    assert_eq!(after.0, before.0);
    for (a, b) in after.1.iter().zip(before.1) {
        assert!((a - b).abs() <= 1e-14 * b.abs(), "{a} {b}");
    }
    body.step().expect("the state belongs to the step");

    // In the other precision it is rounded, and another file is a stranger.
    let mut memory = vec![0.0; Body::<f32>::len_for(&file, &options()).expect("a length")];
    let mut single = Body::<f32>::bind(&file, &options(), &mut memory).expect("bound");
    assert_eq!(single.restore(&saved[..written]), Ok(Restored::Carried));
    let bytes = golden("reactions.vdm");
    let file = File::parse(&bytes).expect("a file");
    let mut memory = vec![0.0; Body::<f64>::len_for(&file, &options()).expect("a length")];
    let mut other = Body::<f64>::bind(&file, &options(), &mut memory).expect("bound");
    assert_eq!(other.restore(&saved[..written]), Err(SavedError::OtherFile));
}

#[test]
fn every_quantity_is_read_by_the_table_in_both_precisions() {
    each(|name, file| {
        for precision in [Precision::Single, Precision::Double] {
            let options = BodyOptions::default();
            let mut memory = vec![0.0; AnyBody::len_for(file, &options, precision).expect("a length")];
            let mut body = AnyBody::bind(file, &options, precision, &mut memory).expect("bound");
            body.push_pattern(0, 1.0).ok();
            body.step().expect("a step");
            for quantity in Quantity::ALL {
                let mut out = vec![f64::NAN; body.length(quantity)];
                let fields: &[Field] = if quantity.has_velocity() {
                    &[Field::Displacement, Field::Velocity]
                } else {
                    assert_eq!(
                        body.read(quantity, 0, Field::Velocity, &mut out),
                        Err(OutputError::NoVelocity)
                    );
                    &[Field::Displacement]
                };
                let count = body.count(quantity);
                for &field in fields {
                    if quantity == Quantity::Point {
                        if count > 0 {
                            let done = body.read(quantity, &Place::node(0), field, &mut out);
                            done.unwrap_or_else(|error| panic!("{name}: {error}"));
                        }
                        assert_eq!(body.read(quantity, 0, field, &mut out), Err(OutputError::NotAPlace));
                        continue;
                    }
                    for index in 0..count {
                        let done = body.read(quantity, index, field, &mut out);
                        match done {
                            Ok(()) => assert!(out.iter().all(|x| x.is_finite()), "{name} {quantity:?}"),
                            // A file may be stripped of the rows of its nodes.
                            Err(OutputError::Missing { .. }) if quantity == Quantity::Node => {}
                            Err(error) => panic!("{name} {quantity:?} {index}: {error}"),
                        }
                    }
                    assert!(body.read(quantity, count, field, &mut out).is_err(), "{name} {quantity:?}");
                    out.push(0.0);
                    let wrong = body.read(quantity, 0, field, &mut out);
                    assert!(matches!(wrong, Err(OutputError::Length { .. })), "{name} {quantity:?}");
                    out.pop();
                }
            }
        }
    });
}

#[test]
fn a_single_field_widens_without_losing_a_number() {
    let bytes = golden("fixed-f64.vdm");
    let file = File::parse(&bytes).expect("a file");
    let mut memory = vec![0.0; Body::<f32>::len_for(&file, &options()).expect("a length")];
    let mut body = Body::<f32>::bind(&file, &options(), &mut memory).expect("bound");
    load(&mut body);
    body.step().expect("a step");
    let length = body.length(Quantity::Surface);
    let (mut own, mut read) = (vec![0.0; length], vec![0.0; length]);
    body.surface_into(Field::Displacement, &mut own).expect("a surface");
    body.read(Quantity::Surface, 0, Field::Displacement, &mut read).expect("a surface");
    assert_eq!(own.iter().map(|&x| f64::from(x)).collect::<Vec<_>>(), read);
    assert!(read.iter().any(|&x| x != 0.0));
}
