//! Any bytes, opened and stepped: no panic, no read past the end, no more memory than is lent.
#![no_main]

mod seal;

use libfuzzer_sys::fuzz_target;
use vademecum_eval::{Contact, Field, Loads, Place, Scalar, Scene, SceneOptions, State, StructureChoice};
use vademecum_format::{File, FormatError};

/// Numbers lent at most: a file that asks for more is one a caller would turn down by its sizes.
const LENT: usize = 1 << 20;

fn step<T: Scalar>(file: &File<'_>, structure: StructureChoice) {
    let options = SceneOptions { structure, ..SceneOptions::default() };
    let Ok(sizes) = Scene::<T>::sizes(file, &options) else { return };
    if [sizes.scene, sizes.work, sizes.state, sizes.loads].iter().any(|&n| n > LENT) {
        return;
    }
    let (mut memory, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let Ok(scene) = Scene::bind(file, &options, &mut memory, &mut work) else { return };
    let (Ok(mut state), Ok(mut loads)) = (State::new(&scene, &mut state), Loads::new(&scene, &mut loads))
    else {
        return;
    };
    let contact = Contact::new(Place::triangle([0, 1, 2], [0.2, 0.3, 0.5]), [1.0, -1.0, 2.0]);
    let _ = loads.add_contact(&scene, &contact);
    let _ = loads.add_pattern(&scene, 0, 1.0);
    for _ in 0..4 {
        // An infinite step is refused and leaves the state; the outputs must hold up all the same.
        let _ = scene.step(&mut state, &loads);
    }
    let _ = scene.energy(&state);
    for index in [0, 1, usize::MAX] {
        let _ = scene.probe(&state, index, Field::Displacement);
        let _ = scene.node(&state, index, Field::Velocity);
    }
    let mut surface = vec![T::ZERO; 3 * (file.metadata().n_surface_nodes as usize).min(LENT)];
    let _ = scene.surface_into(&state, Field::Displacement, &mut surface);
}

fuzz_target!(|bytes: &[u8]| {
    let _ = File::parse(bytes);
    let sealed = seal::seal(bytes.to_vec());
    let Ok(file) = File::parse(&sealed) else { return };
    // The checksums are right; an index may still lead nowhere, and what reads it has to hold up.
    match file.verify_all() {
        Ok(()) | Err(FormatError::Index { .. }) => {}
        Err(other) => panic!("sealed: {other:?}"),
    }
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        step::<f64>(&file, structure);
        step::<f32>(&file, structure);
    }
});
