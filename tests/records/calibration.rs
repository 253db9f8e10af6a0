//! Calibration of six stiffnesses and `β` from three taps and nine sensors with 2 % of noise: errors,
//! intervals and times over random noise, for bases of several sizes. Minutes.
//!
//!     cargo run --release -p vademecum-tests --example calibration

use std::time::Instant;

use vademecum_tests::calibration::{Bench, errors};

const FITS: u64 = 20;

fn main() {
    println!(
        "| mesh | vectors | noise | errors of the seven: median, worst | worst of each | intervals that hold | χ²/N | time of a fit |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (fine, modes) in [(3, 48), (3, 96), (3, 128)] {
        let (bench, folder) = (Bench::new(fine, modes), tempfile::tempdir().expect("a folder"));
        for (over_all, words) in [(true, "2 % over all"), (false, "2 % of each channel")] {
            let (mut all, mut of_each) = (vec![], [0.0_f64; 7]);
            let (mut held, mut chi, mut seconds) = (0, 0.0, 0.0);
            let mut model = 0.0;
            for seed in 1..=FITS {
                let start = Instant::now();
                let found = bench.fit(folder.path(), 0.02, over_all, seed);
                seconds += start.elapsed().as_secs_f64() / FITS as f64;
                let (errors, holds) = errors(&found);
                of_each.iter_mut().zip(&errors).for_each(|(worst, error)| *worst = worst.max(*error));
                all.extend(errors);
                held += holds;
                chi += found.chi_squared / FITS as f64;
                model = found.model_error;
            }
            all.sort_by(f64::total_cmp);
            let percent = |x: f64| format!("{:.2}", 100.0 * x);
            let each = of_each.map(percent).join(", ");
            println!(
                "| {} dofs | {modes} (model error {model:.1e}) | {words} | {} %, {} % | {each} % | {held} of {} | {chi:.3} | {seconds:.1} s |",
                bench.dofs,
                percent(all[all.len() / 2]),
                percent(all[all.len() - 1]),
                all.len()
            );
        }
    }
}
