//! Calibration: six stiffnesses and `β` of a beam from three taps at full order with noise.

use vademecum_tests::calibration::{Bench, errors};

#[test]
fn six_stiffnesses_and_damping_come_back_from_three_taps_at_full_order() {
    let (bench, folder) = (Bench::new(2, 96), tempfile::tempdir().expect("a folder"));
    for seed in 1..5 {
        let found = bench.fit(folder.path(), 0.02, true, seed);
        let (errors, _) = errors(&found);
        println!("noise 2 % over all, {seed}: {errors:.4?}, chi-squared/N {:.3}", found.chi_squared);
        assert!(found.converged && found.undetermined.is_empty(), "{:?}", found.undetermined);
        assert_eq!(found.estimates.len(), 7);
        assert!(errors.iter().all(|error| *error <= 0.01), "{errors:?}");
        assert!(found.chi_squared < 1.1, "{}", found.chi_squared);
    }
    let (mut held, mut all, mut worst) = (0, 0, 0.0_f64);
    for seed in 11..19 {
        let found = bench.fit(folder.path(), 0.02, false, seed);
        let (errors, holds) = errors(&found);
        println!(
            "noise 2 % of each, {seed}: {errors:.4?}, {holds} held, chi-squared/N {:.3}",
            found.chi_squared
        );
        (held, all) = (held + holds, all + errors.len());
        worst = errors.into_iter().fold(worst, f64::max);
    }
    assert!(worst <= 0.02, "{worst}");
    assert!(held as f64 >= 0.9 * all as f64, "{held} of {all}");
}
