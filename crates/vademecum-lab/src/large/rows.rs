//! The rows of a comparison: those through the file, and those that are marched over all elements.

use faer::MatRef;
use vademecum_build::Matrix;
use vademecum_build::certificate::CONVERGED_SUBSTEPS;
use vademecum_build::dynamics::large::LargeMarch;
use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::progress::Listener;
use vademecum_eval::{Scalar, SceneOptions, StructureChoice};
use vademecum_format::File;
use vademecum_study::parts::{LargeMotion, percentiles, stop_if_asked};
use vademecum_study::player::{Track, elastic, with_body};

use super::table::{LargeErrors, LargeMethod, LargeRow};
use crate::measure::{Samples, held_steps, noise};
use crate::method::{Precision, play_file};
use crate::trajectory::{Projection, Reference, distance};
use vademecum_study::StudyError;

/// Bursts of a file in one round.
const BURSTS: usize = 100;

/// A file, and the scenario through it.
pub(super) struct Through<'a> {
    pub bytes: &'a [u8],
    pub track: &'a Track,
    pub steps: usize,
    /// From the coordinates of the file to those on a basis that is orthonormal in the mass.
    pub turn: MatRef<'a, f64>,
    pub listener: &'a dyn Listener,
}

/// The motion of a file under one method, and the times of its steps.
pub(super) struct PlayedRow {
    method: LargeMethod,
    substeps: usize,
    /// On the orthonormal basis, shape (r, instants).
    coordinates: Matrix,
    samples: Samples,
}

/// All motions of a file.
pub(super) struct PlayedRows {
    methods: Vec<PlayedRow>,
    /// With so many sub-steps that more would make no difference.
    converged: Matrix,
}

impl Through<'_> {
    /// The linear model, and the file in both precisions with each number of sub-steps: played, then timed in
    /// rounds by turns.
    pub fn all(&self, substeps: &[usize], rounds: usize) -> Result<PlayedRows, StudyError> {
        self.listener.stage("step the file");
        let play = |method: LargeMethod, substeps: usize| -> Result<PlayedRow, StudyError> {
            let coordinates = self.play(method, substeps)?;
            Ok(PlayedRow { method, substeps, coordinates, samples: Samples::default() })
        };
        let mut methods = vec![play(LargeMethod::Linear, 1)?];
        for &substeps in substeps {
            for precision in [Precision::Double, Precision::Single] {
                methods.push(play(LargeMethod::File(precision), substeps)?);
            }
        }
        let converged = self.play(LargeMethod::File(Precision::Double), CONVERGED_SUBSTEPS)?;
        self.listener.stage("time the steps of the file");
        for _ in 0..rounds {
            for PlayedRow { method, substeps, samples, .. } in &mut methods {
                let single = *method == LargeMethod::File(Precision::Single);
                let time = if single { Self::time::<f32> } else { Self::time::<f64> };
                samples.step_ns.push(time(self, &options(*method, *substeps))?);
                stop_if_asked(self.listener)?;
            }
        }
        Ok(PlayedRows { methods, converged })
    }

    fn play(&self, method: LargeMethod, substeps: usize) -> Result<Matrix, StudyError> {
        let single = method == LargeMethod::File(Precision::Single);
        let play = if single { play_file::<f32> } else { play_file::<f64> };
        let options = options(method, substeps);
        Ok(self.turn * play(self.bytes, &options, self.track, self.steps, self.listener)?)
    }

    fn time<T: Scalar>(&self, options: &SceneOptions) -> Result<Vec<f64>, StudyError> {
        let file = File::parse(self.bytes)?;
        with_body::<T, _>(&file, &elastic(options), |body| held_steps(body, self.track, BURSTS))
    }
}

fn options(method: LargeMethod, substeps: usize) -> SceneOptions {
    match method {
        LargeMethod::Linear => SceneOptions { structure: StructureChoice::Exact, ..SceneOptions::default() },
        _ => SceneOptions { substeps: Some(substeps), ..SceneOptions::default() },
    }
}

impl PlayedRows {
    /// The smallest error of the file.
    pub fn least_error(&self, seen: &Projection) -> f64 {
        self.methods.iter().map(|played| seen.error(&played.coordinates)).fold(f64::INFINITY, f64::min)
    }

    /// The median over all methods of how far the medians of their rounds lie apart, relative to the lowest.
    pub fn noise(&self) -> f64 {
        noise(self.methods.iter().map(|played| &played.samples))
    }

    /// A row of each; `seen` is the reference on the basis, and `norm` its size.
    pub fn rows(
        &self,
        seen: &Projection,
        norm: f64,
        (offline_seconds, file_bytes): (f64, usize),
    ) -> Vec<LargeRow> {
        let row = |played: &PlayedRow| LargeRow {
            modes: Some(played.coordinates.nrows()),
            file_bytes: Some(file_bytes),
            ..LargeRow::new(
                (played.method, played.substeps),
                offline_seconds,
                played.samples.step_ns.concat(),
                self.errors(played, seen, norm),
            )
        };
        self.methods.iter().map(row).collect()
    }

    fn errors(&self, played: &PlayedRow, seen: &Projection, norm: f64) -> LargeErrors {
        let of_basis = LargeErrors {
            error_total: seen.error(&played.coordinates),
            error_basis: Some(seen.floor()),
            ..LargeErrors::default()
        };
        let LargeMethod::File(precision) = played.method else { return of_basis };
        let apart = |a: &Matrix, b: &Matrix| (a - b).norm_l2() / norm;
        let is_double = |other: &&PlayedRow| {
            other.method == LargeMethod::File(Precision::Double) && other.substeps == played.substeps
        };
        let double = self.methods.iter().find(is_double).map_or(&played.coordinates, |p| &p.coordinates);
        let rounding = apart(&played.coordinates, double);
        LargeErrors {
            error_closure: Some(seen.beside_floor(&self.converged)),
            error_time: Some(apart(double, &self.converged)),
            error_rounding: (precision == Precision::Single).then_some(rounding),
            ..of_basis
        }
    }
}

/// Context of the marches over all elements.
pub(super) struct FullOrderRows<'a> {
    pub motion: &'a LargeMotion<'a>,
    pub mass: &'a SymmetricMatrix,
    pub truth: &'a Reference,
    pub steps: usize,
    pub listener: &'a dyn Listener,
}

impl FullOrderRows<'_> {
    /// The row of a march with `parts` steps in a step of the file, without the parts of its error. Each step
    /// of the scenario is timed by itself.
    pub fn row(
        &self,
        method: LargeMethod,
        march: &LargeMarch<'_>,
        parts: usize,
        offline_seconds: f64,
    ) -> Result<LargeRow, StudyError> {
        self.listener.stage(&format!("march {method}, {parts} in a step"));
        let mut moved = Matrix::zeros(self.mass.n(), 1 + self.steps);
        let seconds = self.motion.follow(march, parts, self.steps, self.listener, |step, displacement| {
            moved.col_as_slice_mut(step).copy_from_slice(displacement);
        })?;
        let apart = distance(self.mass, moved.as_ref(), self.truth.displacement.as_ref());
        let errors = LargeErrors { error_total: apart / self.truth.norm, ..LargeErrors::default() };
        let step_ns = seconds.into_iter().map(|seconds| 1e9 * seconds).collect();
        Ok(LargeRow::new((method, parts), offline_seconds, step_ns, errors))
    }
}

impl LargeRow {
    /// A row without a basis or a file, not yet compared with the full order.
    fn new(
        (name, substeps): (LargeMethod, usize),
        offline_seconds: f64,
        step_ns: Vec<f64>,
        errors: LargeErrors,
    ) -> Self {
        let [step_ns_p50, step_ns_p99, _] = percentiles(step_ns);
        let times_full_order = f64::NAN;
        let (modes, file_bytes) = (None, None);
        Self {
            name,
            modes,
            substeps,
            offline_seconds,
            file_bytes,
            step_ns_p50,
            step_ns_p99,
            times_full_order,
            errors,
        }
    }
}
