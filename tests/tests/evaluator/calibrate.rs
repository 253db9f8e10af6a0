//! Calibration: six stiffnesses and `β` of a beam held at both ends from three taps on another beam of fixed values, which steps
//! 150 of its own natural modes.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use vademecum_build::progress::Silent;
use vademecum_format::File;
use vademecum_study::calibrate::{CalibrateOptions, Calibration, Noise, calibrate, measurements};
use vademecum_study::player::PlayOptions;
use vademecum_study::run::Run;
use vademecum_study::scenario::Scenario;
use vademecum_tests::live_beam::LiveBeam;

const TRUTH: [f64; 6] = [0.8, 1.3, 0.9, 1.15, 0.7, 1.4];
const BETA: f64 = 1.7e-4;
/// Points and forces of the taps.
const TAPS: [([f64; 3], [f64; 3]); 3] = [
    ([0.8, 0.05, 0.12], [0.0, 3.0, -10.0]),
    ([0.6, 0.05, 0.12], [0.0, -6.0, -8.0]),
    ([0.3, 0.1, 0.08], [4.0, -9.0, 5.0]),
];

/// Normal numbers from a linear congruence (Box and Muller).
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        let (a, b) = (self.uniform(), self.uniform());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}

struct Bench {
    beam: Vec<u8>,
    scenarios: Vec<Scenario>,
    /// For each tap the rows of the nine sensors, without noise.
    clean: Vec<Vec<[f64; 9]>>,
    names: Vec<String>,
}

fn bench() -> Bench {
    let beam = LiveBeam { regions: 6, height: 0.12, modes: 96, both_ends: true }.build(None);
    let real = LiveBeam { regions: 6, height: 0.12, modes: 150, both_ends: true }.build(Some((&TRUTH, BETA)));
    let file = File::parse(&real).expect("a file");
    let (mut scenarios, mut clean, mut names) = (vec![], vec![], vec![]);
    for (point, force) in TAPS {
        let text =
            format!("duration = 0.4\n[[contact]]\npoint = {point:?}\nforce = {force:?}\nend = 0.002\n");
        let scenario = Scenario::parse(&text, "tap.toml").expect("a scenario");
        let run = Run::bind(&file, PlayOptions::default(), &scenario, &Silent).expect("bound");
        names = run.columns().into_iter().take(9).map(|(name, unit)| format!("{name} [{unit}]")).collect();
        let mut rows = vec![];
        run.play::<vademecum_study::StudyError>(&Silent, |moment| {
            let values = moment.probes.expect("every step").values;
            rows.push(values.try_into().expect("nine probes"));
            Ok(())
        })
        .expect("played");
        clean.push(rows);
        scenarios.push(scenario);
    }
    Bench { beam, scenarios, clean, names }
}

impl Bench {
    /// Tables with noise, and the fit to them.
    fn fit(&self, folder: &Path, share: f64, over_all: bool, seed: u64) -> Calibration {
        let mut normal = Normal(seed);
        let mut paths: Vec<PathBuf> = vec![];
        for (tap, rows) in self.clean.iter().enumerate() {
            let count = rows.len() as f64;
            let own = |c: usize| (rows.iter().map(|row| row[c] * row[c]).sum::<f64>() / count).sqrt();
            let columns: Vec<f64> = (0..9).map(own).collect();
            let all = (columns.iter().map(|x| x * x).sum::<f64>() / 9.0).sqrt();
            let mut text = format!("time_s,{}\n", self.names.join(","));
            for (step, row) in rows.iter().enumerate() {
                let _ = write!(text, "{:.9e}", 1e-3 * step as f64);
                for (value, own) in row.iter().zip(&columns) {
                    let sigma = share * if over_all { all } else { *own };
                    let _ = write!(text, ",{:.9e}", value + sigma * normal.next());
                }
                text.push('\n');
            }
            let path = folder.join(format!("tap{tap}.csv"));
            std::fs::write(&path, text).expect("written");
            paths.push(path);
        }
        let file = File::parse(&self.beam).expect("a file");
        let tables = measurements(&paths, &self.scenarios, &[]).expect("tables");
        let noise = Noise { share: Some(share), over_all, model: None };
        let options = CalibrateOptions { fit: vec![], settings: vec![], noise, time_step: None };
        calibrate(&file, &tables, &options, &Silent).expect("calibrated")
    }
}

/// Relative errors, and how many intervals hold the truth.
fn errors(found: &Calibration) -> (Vec<f64>, usize) {
    let truth = |name: &str| match name.strip_prefix('k') {
        Some(number) => TRUTH[number.parse::<usize>().expect("a number") - 1],
        None => BETA,
    };
    let of = |own: &vademecum_study::calibrate::Estimate| (own.value / truth(&own.name) - 1.0).abs();
    let holds = |own: &&vademecum_study::calibrate::Estimate| {
        own.interval.is_some_and(|[low, high]| (low..=high).contains(&truth(&own.name)))
    };
    (found.estimates.iter().map(of).collect(), found.estimates.iter().filter(holds).count())
}

#[test]
fn calibrate_six_stiffnesses_and_damping_from_three_taps() {
    let (bench, folder) = (bench(), tempfile::tempdir().expect("a folder"));
    let percent =
        |errors: &[f64]| errors.iter().map(|e| format!("{:.3}", 100.0 * e)).collect::<Vec<_>>().join(" ");
    for seed in 1..5 {
        let start = Instant::now();
        let found = bench.fit(folder.path(), 0.02, true, seed);
        let (errors, _) = errors(&found);
        let stated: Vec<f64> =
            found.estimates.iter().map(|own| own.relative_deviation.expect("inside")).collect();
        println!(
            "noise 2 % over all, {seed}: errors in % {} (stated deviations {}); chi-squared/N {:.3}, {} iterations, \
             {:.1} s, model error {:.1e}",
            percent(&errors),
            percent(&stated),
            found.chi_squared,
            found.iterations,
            start.elapsed().as_secs_f64(),
            found.model_error
        );
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
            "noise 2 % of each, {seed}: errors in % {}, {holds} of 7 held, chi-squared/N {:.3}",
            percent(&errors),
            found.chi_squared
        );
        (held, all) = (held + holds, all + errors.len());
        worst = errors.into_iter().fold(worst, f64::max);
    }
    println!(
        "noise 2 % of each channel: worst error {:.3} %, {held} of {all} intervals hold the truth",
        100.0 * worst
    );
    assert!(worst <= 0.02, "{worst}");
    assert!(held as f64 >= 0.9 * all as f64, "{held} of {all}");
}
