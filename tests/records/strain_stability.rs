//! The long marches of the strain structure: random strain maps, loads times 1, 4, 16 and 256, steps times 1,
//! 4 and 10, in both precisions.
//! `cargo run --release -p vademecum-tests --example strain_stability -- [STEPS]` (10⁶ steps by default, some
//! hours; prints a row as soon as it is known). A row is one map, load and step: the largest change of the
//! energy after the load has gone, over the energy then, without damping, and whether the bound of the energy
//! held while the load acted.

use vademecum_eval::{Scalar, SceneOptions};
use vademecum_format::scheme::StepParameters;
use vademecum_tests::stage::with_scene;
use vademecum_tests::strained::Strained;
use vademecum_tests::synthetic::Random;

/// Steps under load.
const LOADED: usize = 200;

/// Drift of the energy of a free body, and how near the energy came to its bound.
fn march<T: Scalar>(bytes: &[u8], viscosity: f64, times: f64, steps: usize) -> (f64, f64) {
    let options = SceneOptions { viscosity, ..SceneOptions::default() };
    with_scene::<T, _>(bytes, &options, |scene, state, loads| {
        let mut random = Random::new(5);
        let (mut root, mut share) = (0.0f64, 0.0f64);
        let unit = {
            let file = vademecum_format::File::parse(bytes).expect("a file");
            let pattern = file.section(vademecum_format::SectionKind::PatternBasis).expect("a pattern");
            pattern.numbers().expect("raw").iter().map(|x| x * x).sum::<f64>().sqrt()
        };
        for _ in 0..LOADED {
            let amplitude = 100.0 * times * random.number();
            loads.clear();
            loads.add_pattern(scene, 0, amplitude).expect("a pattern");
            scene.step(state, loads).expect("a step");
            let next = scene.energy(state).expect("an energy").sqrt();
            let allowed = scene.parameters().time_step * amplitude.abs() * unit / 2f64.sqrt();
            share = share.max((next - root) / allowed);
            root = next;
        }
        loads.clear();
        let (start, mut off) = (scene.energy(state).expect("an energy"), 0.0f64);
        for step in 0..steps {
            scene.step(state, loads).expect("a step");
            if step % 1000 == 999 {
                off = off.max((scene.energy(state).expect("an energy") - start) / start);
                if viscosity == 0.0 {
                    off = off.max((scene.energy(state).expect("an energy") / start - 1.0).abs());
                }
            }
        }
        (off, share)
    })
}

fn main() {
    let steps = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(1_000_000);
    println!("n, n1, r, m | load | step | f64 drift | f64 share of bound | f32 drift | f32 growth, c = 1/18");
    for sizes in [[8, 0, 8, 24], [16, 0, 16, 48], [24, 0, 24, 72], [32, 0, 32, 96], [16, 8, 32, 64]] {
        for longer in [1.0, 4.0, 10.0] {
            for times in [1.0, 4.0, 16.0, 256.0] {
                let time_step = 5e-3 * longer;
                let by = StepParameters { time_step, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
                let bytes = Strained::random(sizes, 1).file(&by);
                let (double, share) = march::<f64>(&bytes, 0.0, times, steps);
                let (single, _) = march::<f32>(&bytes, 0.0, times, steps);
                let (damped, _) = march::<f32>(&bytes, 1.0 / 18.0, times, steps);
                println!(
                    "{sizes:?} | x{times} | x{longer} | {double:.1e} | {share:.3} | {single:.1e} | {damped:.1e}"
                );
            }
        }
    }
}
