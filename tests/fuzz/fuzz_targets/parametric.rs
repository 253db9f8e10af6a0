//! Any bytes as a file of live regions, set to values and stepped: no panic, no read past the end, and no
//! frequency that is not finite.
#![no_main]

mod seal;

use libfuzzer_sys::fuzz_target;
use vademecum_eval::{Field, Loads, Parametric, Scene, SceneOptions, State};
use vademecum_format::File;

/// Numbers and bytes lent at most: a file that asks for more is one a caller would turn down by its sizes.
const LENT: usize = 1 << 20;
/// Stepped modes.
const MODES: usize = 3;

fuzz_target!(|bytes: &[u8]| {
    let sealed = seal::seal(bytes.to_vec());
    let Ok(file) = File::parse(&sealed) else { return };
    let Ok(model) = Parametric::new(&file) else { return };
    let modes = MODES.min(model.n_basis());
    let Ok(sizes) = model.sizes(modes) else { return };
    if [sizes.memory, sizes.work, sizes.write_work, sizes.bytes].iter().any(|&n| n > LENT) {
        return;
    }
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work.max(sizes.write_work)]);
    // Nominal values, and one end of each range after the other.
    let mut nominal = vec![0.0; model.n_parameters()];
    model.nominal_into(&mut nominal);
    let ends = model.parameters().enumerate().take(4).map(|(k, own)| {
        let mut values = nominal.clone();
        values[k] = if k % 2 == 0 { own.upper } else { own.lower };
        values
    });
    for values in [nominal.clone()].into_iter().chain(ends) {
        let Ok(tuned) = model.solve(&values, modes, &mut memory, &mut work) else { continue };
        assert!((0..modes).all(|k| tuned.frequency(k).is_finite()), "{values:?}");
        let mut lent = vec![0; sizes.bytes];
        if let Ok(body) = tuned.write(&model, &mut lent, &mut work) {
            let _ = body.verify_all();
            step(&body);
        }
    }
});

/// A few steps under a pattern.
fn step(file: &File<'_>) {
    let options = SceneOptions::default();
    let Ok(sizes) = Scene::<f64>::sizes(file, &options) else { return };
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let Ok(scene) = Scene::bind(file, &options, &mut memory, &mut work) else { return };
    let (Ok(mut state), Ok(mut loads)) = (State::new(&scene, &mut state), Loads::new(&scene, &mut loads))
    else {
        return;
    };
    let _ = loads.add_pattern(&scene, 0, 1.0);
    for _ in 0..4 {
        let _ = scene.step(&mut state, &loads);
    }
    let _ = scene.energy(&state);
    let _ = scene.probe(&state, 0, Field::Displacement);
}
