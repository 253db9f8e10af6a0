//! Calibration of six stiffnesses and `β` of a beam held at both ends, from three taps on the same beam at
//! full order, exact in time, with noise.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use vademecum_build::progress::Silent;
use vademecum_format::File;
use vademecum_study::calibrate::{CalibrateOptions, Calibration, Estimate, Noise, calibrate, measurements};
use vademecum_study::scenario::Scenario;

use crate::live_beam::LiveBeam;
use crate::normal::Normal;

const TRUTH: [f64; 6] = [0.8, 1.3, 0.9, 1.15, 0.7, 1.4];
const BETA: f64 = 5e-5;
/// Time step \[s\], a 24th of the first period.
const STEP: f64 = 2.5e-4;
/// Points and forces of the taps.
const TAPS: [([f64; 3], [f64; 3]); 3] = [
    ([0.8, 0.05, 0.12], [0.0, 3.0, -10.0]),
    ([0.6, 0.05, 0.12], [0.0, -6.0, -8.0]),
    ([0.3, 0.1, 0.08], [4.0, -9.0, 5.0]),
];

/// The beam, and what is measured of it.
pub struct Bench {
    beam: Vec<u8>,
    /// Free dofs of the beam.
    pub dofs: usize,
    scenarios: Vec<Scenario>,
    /// For each tap the rows of the nine sensors at full order, without noise.
    clean: Vec<Vec<[f64; 9]>>,
    names: Vec<String>,
}

impl Bench {
    /// The beam of a mesh this fine ([`LiveBeam::fine`]) with so many vectors.
    ///
    /// # Panics
    /// If it is not built or marched.
    #[must_use]
    pub fn new(fine: usize, modes: usize) -> Self {
        let beam = LiveBeam { regions: 6, height: 0.12, modes, both_ends: true, fine, step: STEP };
        let (mut scenarios, mut clean, mut dofs) = (vec![], vec![], 0);
        for (point, force) in TAPS {
            let text = format!(
                "duration = {}\n[[contact]]\npoint = {point:?}\nforce = {force:?}\nend = 0.001\n",
                400.0 * STEP
            );
            let scenario = Scenario::parse(&text, "tap.toml").expect("a scenario");
            let found = beam.full_order((&TRUTH, BETA), &scenario);
            dofs = found.1;
            clean.push(found.0);
            scenarios.push(scenario);
        }
        let component = |place| ["x", "y", "z"].map(|axis| format!("s{place}{axis} [m]"));
        let names = (0..3).flat_map(component).collect();
        Self { beam: beam.build(None), dofs, scenarios, clean, names }
    }

    /// Tables with noise, which is a share of the mean square over all columns or of each, and the fit to
    /// them.
    ///
    /// # Panics
    /// If nothing is fitted.
    #[must_use]
    pub fn fit(&self, folder: &Path, share: f64, over_all: bool, seed: u64) -> Calibration {
        let mut normal = Normal::new(seed);
        let mut paths: Vec<PathBuf> = vec![];
        for (tap, rows) in self.clean.iter().enumerate() {
            let count = rows.len() as f64;
            let own = |c: usize| (rows.iter().map(|row| row[c] * row[c]).sum::<f64>() / count).sqrt();
            let columns: Vec<f64> = (0..9).map(own).collect();
            let all = (columns.iter().map(|x| x * x).sum::<f64>() / 9.0).sqrt();
            let mut text = format!("time_s,{}\n", self.names.join(","));
            for (step, row) in rows.iter().enumerate() {
                let _ = write!(text, "{:.9e}", STEP * step as f64);
                for (value, own) in row.iter().zip(&columns) {
                    let sigma = share * if over_all { all } else { *own };
                    let _ = write!(text, ",{:.9e}", value + sigma * normal.draw());
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

/// Relative errors of the estimates, and how many intervals hold the truth.
///
/// # Panics
/// If a parameter is not one of the beam.
#[must_use]
pub fn errors(found: &Calibration) -> (Vec<f64>, usize) {
    let truth = |name: &str| match name.strip_prefix('k') {
        Some(number) => TRUTH[number.parse::<usize>().expect("a number") - 1],
        None => BETA,
    };
    let of = |own: &Estimate| (own.value / truth(&own.name) - 1.0).abs();
    let holds =
        |own: &&Estimate| own.interval.is_some_and(|[low, high]| (low..=high).contains(&truth(&own.name)));
    (found.estimates.iter().map(of).collect(), found.estimates.iter().filter(holds).count())
}
