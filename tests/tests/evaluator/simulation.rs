//! A body that owns its memory moves as one in lent memory does.

use std::error::Error;

use vademecum_eval::{
    Contact, Field, LoadError, LocateError, Place, Scalar, SceneOptions, Simulation, SimulationError, Status,
    Surface,
};
use vademecum_rewrite::pack;
use vademecum_tests::exact_beam::exact_beam;
use vademecum_tests::golden::named;
use vademecum_tests::stage::with_scene;

const FORCE: [f64; 3] = [3.0, -20.0, -40.0];

/// State and a point after some steps, in lent memory and in a simulation.
fn both<T: Scalar + PartialEq + Send + 'static>(bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    let options = SceneOptions::default();
    let mut body = Simulation::<T>::new(bytes.to_vec(), &options)?;
    let place = body.locate([0.8, 0.04, 0.1])?;
    body.push(&place, FORCE)?;
    assert_eq!(body.step(100)?, Status::Moving);
    // Moved to another place and to another thread: what it borrows stays where it is.
    let mut boxed = Box::new(body);
    boxed = std::thread::spawn(move || {
        boxed.step(100).expect("a step");
        boxed
    })
    .join()
    .expect("a thread");
    let body = *boxed;
    let (saved, point) = with_scene::<T, _>(bytes, &options, |scene, state, loads| {
        let contact = Contact::new(place.place, FORCE);
        loads.add_contact(scene, &contact).expect("a contact");
        for _ in 0..200 {
            scene.step(state, loads).expect("a step");
        }
        let mut saved = vec![T::ZERO; scene.state_numbers()];
        state.save_into(&mut saved).expect("length");
        (saved, scene.point(state, &place, Field::Displacement).expect("a point"))
    });
    assert_eq!(body.save(), saved);
    assert_eq!(body.point(&place, Field::Displacement)?, point);
    assert!(point[2] < 0.0);
    Ok(())
}

#[test]
fn a_simulation_has_the_bits_of_lent_memory() -> Result<(), Box<dyn Error>> {
    let bytes = exact_beam();
    both::<f32>(&bytes)?;
    both::<f64>(&bytes)
}

#[test]
fn names_and_loads_outlive_a_change_of_parameters() -> Result<(), Box<dyn Error>> {
    let mut body = Simulation::<f64>::new(named("parameters.vdm"), &SceneOptions::default())?;
    let soft = body.find_parameter("soft").ok_or("no parameter")?;
    assert_eq!(body.find_parameter("none"), None);
    let pull = 0;
    body.push_pattern(pull, 1.0)?;
    body.set_parameters(&[(soft, 0.75)])?;
    body.step(10)?;
    let after = body.energy()?;

    // The same with the parameter set first.
    let mut other = Simulation::<f64>::new(named("parameters.vdm"), &SceneOptions::default())?;
    other.set_parameters(&[(soft, 0.75)])?;
    let mut another = other.another()?;
    for body in [&mut other, &mut another] {
        body.push_pattern(pull, 1.0)?;
        body.step(10)?;
        assert_eq!(body.energy()?, after);
    }
    assert!(after != 0.0);
    // A value out of its range changes nothing.
    assert!(other.set_parameters(&[(soft, 1e9)]).is_err());
    assert_eq!(other.scene().options().regions.stiffness()[0], 0.75);
    other.step(1)?;
    other.clear();
    assert!(other.loads().is_empty());

    let beam = Simulation::<f32>::new(exact_beam(), &SceneOptions::default())?;
    assert_eq!((beam.find_pattern("gravity"), beam.find_pattern("gravit")), (Some(0), None));
    let named = Simulation::<f32>::new(named("fixed-f64.vdm"), &SceneOptions::default())?;
    let names: Vec<&str> = named.file().probe_names().collect();
    assert_eq!(names.len(), 3);
    for (index, name) in names.into_iter().enumerate() {
        assert_eq!(named.find_probe(name), Some(index));
    }
    assert_eq!(named.find_probe("none"), None);
    Ok(())
}

#[test]
fn a_saved_state_comes_back_and_a_ray_meets_what_has_moved() -> Result<(), Box<dyn Error>> {
    let mut body = Simulation::<f32>::new(exact_beam(), &SceneOptions::default())?;
    let above = ([0.9, 0.04, 1.0], [0.0, 0.0, -1.0]);
    let at_rest = body.pick(above.0, above.1, 1.0).ok_or("nothing there")?;
    let place = body.locate(at_rest.position)?;
    body.push(&place, [0.0, 0.0, -4e3])?;
    body.step(20)?;
    let saved = body.save();
    let close = body.nearest(at_rest.position, 1.0).ok_or("nothing there")?;
    assert!(close.distance > 0.0 && at_rest.distance < 1.0);
    let pressed = body.pick(above.0, above.1, 1.0).ok_or("nothing there")?;
    let magnified = body.pick(above.0, above.1, 10.0).ok_or("nothing there")?;
    let sunk = |hit: f64| hit - at_rest.distance;
    let ratio = sunk(magnified.distance) / sunk(pressed.distance);
    // The ray meets another point of the bent body when it is magnified, so not ten times exactly.
    assert!(sunk(pressed.distance) > 0.0 && (5.0..20.0).contains(&ratio), "{ratio}");
    let (energy, place_now) = (body.energy()?, body.point(&place, Field::Displacement)?);
    body.step(7)?;
    assert!(body.energy()? != energy);
    body.restore(&saved)?;
    assert_eq!(body.energy()?, energy);
    assert_eq!(body.point(&place, Field::Displacement)?, place_now);
    let clipped = body.restore(&saved[1..]);
    assert!(clipped.is_err());
    body.with(|scene, state, loads| {
        loads.clear();
        scene.step(state, loads).map(drop)
    })?;
    assert!(body.loads().is_empty());
    let far = Contact::new(Place::triangle([u32::MAX; 3], [1.0, 0.0, 0.0]), FORCE);
    let refused = body.with(|scene, _, loads| loads.add_contact(scene, &far));
    assert!(matches!(refused, Err(LoadError::NotLoadable { .. })), "{refused:?}");
    Ok(())
}

#[test]
fn files_are_opened_packed_or_not_and_survive_what_happens_on_the_disk() -> Result<(), Box<dyn Error>> {
    let bytes = exact_beam();
    let packed = pack(&bytes, 3)?;
    assert!(packed.len() < bytes.len());
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("beam.vdm");
    let mut steps = vec![];
    for bytes in [&bytes, &packed] {
        std::fs::write(&path, bytes)?;
        let mut body = Simulation::<f32>::open(&path, &SceneOptions::default())?;
        // Another program cuts the file short.
        std::fs::OpenOptions::new().write(true).truncate(true).open(&path)?;
        let place = body.locate([0.8, 0.04, 0.1])?;
        body.push(&place, FORCE)?;
        body.step(50)?;
        steps.push(body.save());
    }
    assert_eq!(steps[0], steps[1]);
    let missing = Simulation::<f32>::open(folder.path().join("none"), &SceneOptions::default());
    assert!(matches!(missing.as_ref().err(), Some(SimulationError::Read(_))), "{missing:?}");
    assert!(missing.err().ok_or("no error")?.source().is_some());
    let cut = Simulation::<f32>::new(bytes[..bytes.len() / 2].to_vec(), &SceneOptions::default());
    assert!(matches!(cut.err(), Some(SimulationError::Format(_))));
    Ok(())
}

#[test]
fn a_finger_far_from_the_body_is_refused_with_its_distance() -> Result<(), Box<dyn Error>> {
    let body = Simulation::<f64>::new(exact_beam(), &SceneOptions::default())?;
    let surface = Surface::new(body.file())?;
    let (tip, reach) = (body.locate([1.0, 0.04, 0.1])?, surface.reach());
    assert!(tip.distance < 1e-12 && (1.0..1.1).contains(&reach), "{reach}");
    // A finger above the body may hover as high as the body is large.
    let above = |height: f64| body.locate([1.0, 0.04, 0.1 + height]);
    assert_eq!(above(0.999 * reach)?.place, tip.place);
    let Err(LocateError::Far { distance, reach: told }) = above(1.001 * reach) else { panic!("not refused") };
    assert!((distance - 1.001 * reach).abs() < 1e-12 && told == reach);
    assert_eq!(
        surface.locate([1.0, 0.04, 100.0]).ok_or("none")?.place,
        tip.place,
        "the surface only measures"
    );
    assert_eq!(body.locate([f64::NAN, 0.0, 0.0]), Err(LocateError::NotFinite));
    let words = body.locate([1000.0, 40.0, 100.0]).unwrap_err().to_string();
    assert!(
        words.contains("away from the loadable surface") && words.contains("unit of the file"),
        "{words}"
    );
    Ok(())
}
