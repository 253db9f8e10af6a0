//! Steps of the strain structure: `cargo bench -p vademecum-tests --bench strain`. Times are those of
//! [`STEPS`] steps.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use vademecum_eval::{Scalar, SceneOptions};
use vademecum_format::scheme::StepParameters;
use vademecum_tests::stage::with_scene;
use vademecum_tests::strained::Strained;

const STEPS: usize = 1000;

/// `n, n₁, r, m` of the maps.
const SIZES: [[usize; 4]; 6] = [
    [16, 0, 16, 48],
    [24, 0, 64, 112],
    [24, 24, 64, 136],
    [32, 0, 64, 128],
    [48, 0, 48, 96],
    [64, 0, 64, 128],
];

fn main() {
    divan::main();
}

/// A moving body under a held load, so that it never comes to rest.
#[divan::bench(types = [f32, f64], args = SIZES)]
fn step<T: Scalar>(bencher: Bencher<'_, '_>, sizes: [usize; 4]) {
    let parameters = StepParameters { time_step: 5e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let bytes = Strained::random(sizes, 1).file(&parameters);
    with_scene::<T, ()>(&bytes, &SceneOptions::default(), |scene, state, loads| {
        loads.add_pattern(scene, 0, 50.0).expect("a pattern");
        bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
            for _ in 0..STEPS {
                scene.step(black_box(state), loads).expect("step");
            }
        });
    });
}
