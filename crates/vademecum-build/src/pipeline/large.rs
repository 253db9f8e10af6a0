//! The road of large displacements: states, strain maps, a choice by held-out pushes, a certificate by
//! others.

use faer::Mat;

use super::exact::damping_section;
use super::file::{CertifiedFile, FileStep, encode_file};
use super::plan::{in_words, large_memory};
use super::{BuildContext, BuildError, Built};
use crate::basis::Basis;
use crate::certificate::{
    CertificateError, LargeReport, StructureMeasured, StructureReport, certify_push, push_motion,
};
use crate::dynamics::large::LargeError;
use crate::dynamics::lowest_modes;
use crate::export::{Draft, StrainMap, TrainingBox, strain_sections};
use crate::fem::GreenStrain;
use crate::input::Problem;
use crate::large::{
    LargeModel, LargeOptions, LearnError, PARTS, ProjectedRun, PushFamily, ReferenceModel, ReferenceRun,
    StrainLearner, asked_displacement,
};
use crate::linalg::symmetric_eigen;
use crate::parallel;
use crate::prepared::Body;
use crate::progress::Stopwatch;
use crate::report::{BuildPlan, CertificateReport};

/// The stage at whose end there is a basis, in the timings of a report.
pub const SHAPES: &str = "shapes of least energy";
/// Coordinates where the problem does not say.
const COORDINATES: usize = 32;
/// Sub-steps of a step.
const SUBSTEPS: usize = 4;
/// Sub-steps beside which those of a file are seen to be too few: their error in time is a 64th of its.
const MANY_SUBSTEPS: usize = 32;
/// Modes that tell how strong a push is.
const PUSH_MODES: usize = 8;
/// Pushes that choose.
const CHOOSING: usize = 6;
/// A map that is so many times as far off as the best one is not fitted.
const BEHIND: f64 = 2.0;
/// Pushes of the certificate where the problem does not say.
const CERTIFYING: usize = 2;
/// First periods of each push.
const PUSH_PERIODS: f64 = 5.0;
/// Seeds of the draws; no push of one draw is one of the other.
const SEEDS: [u64; 2] = [0xC400_5E01, 0xCE47_1F02];

/// One file of large displacements.
pub(super) fn build(
    context: &BuildContext<'_>,
    problem: &Problem,
    mut plan: BuildPlan,
    watch: &mut Stopwatch<'_>,
) -> Result<Built, BuildError> {
    let BuildContext { prepared, kept, first_period, .. } = *context;
    let (body, symbolic, listener) = (&prepared.body, &prepared.symbolic, kept.listener);
    let options = large_options(problem, body);
    let time_step = prepared.step.time_step;
    let strain = GreenStrain::new(&body.model)?;
    let pencil = body.model.pencil();
    let modes = lowest_modes(pencil, symbolic, PUSH_MODES.min(pencil.n_dof()))?;
    context.estimate_mesh_error(Some((&modes.eigenvalues, modes.vectors.as_ref())), watch)?;
    let drawn = PushFamily { body, modes: &modes, displacement: options.displacement, time_step };
    let full =
        ReferenceModel { strain: &strain, symbolic, damping: prepared.rayleigh(), time_step, parts: PARTS };
    let steps = (PUSH_PERIODS * first_period / time_step).ceil() as usize;
    let certifying = problem.large.as_ref().and_then(|large| large.pushes).unwrap_or(CERTIFYING);

    let push = &drawn.draw(&[true], SEEDS[0])[0];
    let kept_steps = [CHOOSING * steps, certifying * steps];
    let memory = large_memory(prepared, &options, strain.n_rows(), kept_steps);
    let instead = ": fewer `basis.modes`, fewer `large.states`, fewer `large.pushes`, a coarser mesh";
    context.options.memory().check(memory, instead, || "strains of states and of products".into())?;
    plan.memory_bytes = plan.memory_bytes.max(memory);
    plan.work = full.work(push, ((CHOOSING + 3 * certifying) * steps) as f64, listener)?;
    plan.work.check(context.options.long, || "pushes at full order".into())?;
    listener.note(&format!("estimate: {}, and shapes of least energy", in_words(&plan)));
    let learner = StrainLearner::new(body, symbolic, &options, kept)?;
    let priors = watch.stage(SHAPES, || learner.priors())?;
    let march = || full.references(&drawn, (CHOOSING, SEEDS[0]), steps, kept);
    let references = watch.stage("held-out pushes at full order", march)?;
    let held_out = Pushed { context, problem, references: &references };
    let priors = watch.stage("choice of the shapes", || held_out.measured(priors, true))?;
    let fitted = || -> Result<Vec<LargeModel>, LearnError> {
        let mut fitted = vec![];
        for prior in worth_fitting(&priors) {
            fitted.extend(learner.fitted(prior)?);
        }
        Ok(fitted)
    };
    let fitted = watch.stage("states and regressions", fitted)?;
    let mut maps = watch.stage("choice of the strain map", || held_out.measured(fitted, false))?;
    maps.splice(0..0, priors);
    let candidates = maps.iter().map(|(error, map)| (map.name.clone(), *error)).collect();
    let best = maps.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let map = best.expect("there are strain maps").1;

    let march = || {
        let rough = full.references(&drawn, (certifying, SEEDS[1]), steps, kept)?;
        let refined = parallel::map_of(rough, &|_, reference| reference.refined(&full, kept));
        refined.into_iter().collect()
    };
    let references: Result<Vec<_>, LargeError> =
        watch.stage("pushes of the certificate at full order", march);
    let references = references?;
    let seconds: f64 = references.iter().map(|reference| reference.seconds_per_step).sum();
    let full_order_seconds_per_step = seconds / references.len() as f64;
    let certify = |bytes: &[u8], push: &ReferenceRun| {
        certify_push(bytes, context.order, body, (push, &map.see(body, push)))
    };
    let pushed = Pushed { context, problem, references: &references };
    let runs = watch.stage("certificate", || pushed.runs(&map, certify))?;
    let (strain_map, rows) = (map.name.clone(), map.map.quadratic.nrows());
    let report =
        LargeReport { strain_map, rows, substeps: SUBSTEPS, candidates, full_order_seconds_per_step, runs };
    let (basis, sections) = (basis_of(&map), sections(context, &map, problem));
    let measured = report.measured(steps);
    let step = FileStep::measured(None, &measured, &StructureMeasured::default());
    let bytes = watch.stage("encode", || encode_file(context, problem, &basis, step, &sections))?;
    let certificate = CertificateReport {
        diagonal: Some(StructureReport::measured(&measured)),
        large: true,
        ..CertificateReport::within(&problem.tolerance)
    };
    let file = CertifiedFile { bytes, certificate, separation: None, large: Some(report) };
    Ok(file.reported(context, problem, (&basis, 0), plan, watch))
}

/// Pushes at full order, beside which strain maps are measured.
struct Pushed<'a> {
    context: &'a BuildContext<'a>,
    problem: &'a Problem,
    references: &'a [ReferenceRun],
}

impl Pushed<'_> {
    /// Measurements of each push through the bytes of a strain map.
    fn runs<T: Send>(
        &self,
        map: &LargeModel,
        measure: impl Fn(&[u8], &ReferenceRun) -> Result<T, CertificateError> + Sync,
    ) -> Result<Vec<T>, BuildError> {
        let Self { context, problem, references } = *self;
        let (basis, sections) = (basis_of(map), sections(context, map, problem));
        let bytes = encode_file(context, problem, &basis, FileStep::unmeasured(None), &sections)?;
        parallel::try_map(references.len(), &|at| Ok(measure(&bytes, &references[at])?))
    }

    /// The motions of a strain map under pushes, in its own sub-steps or in others.
    fn motions(&self, map: &LargeModel, substeps: Option<usize>) -> Result<Vec<Mat<f64>>, BuildError> {
        self.runs(map, |bytes, push| push_motion(bytes, self.context.order, push, substeps))
    }

    /// Strain maps with the geometric mean of their errors on held-out pushes: a push that no map follows
    /// does not choose alone. With `fit` the inertia of their natural modes is chosen first; a regression
    /// keeps that of the map it began with.
    fn measured(&self, maps: Vec<LargeModel>, fit: bool) -> Result<Vec<(f64, LargeModel)>, BuildError> {
        let body = &self.context.prepared.body;
        let measure = |mut map: LargeModel| {
            let see = |at: usize| map.see(body, &self.references[at]);
            let seen: Vec<ProjectedRun> = parallel::map(self.references.len(), &see);
            let motions = match fit {
                true => self.fit_inertia(&mut map, &seen)?,
                false => self.motions(&map, None)?,
            };
            let errors: Vec<f64> =
                seen.iter().zip(&motions).map(|(seen, motion)| seen.error(motion).error).collect();
            let each: Vec<_> = errors.iter().map(|error| format!("{error:.1e}")).collect();
            self.context.kept.listener.note(&format!(
                "{}: errors of held-out pushes {}",
                map.name,
                each.join(", ")
            ));
            Ok((geometric_mean(&errors), map))
        };
        maps.into_iter().map(measure).collect()
    }

    /// Lets those natural modes swing with their own frequencies that bring the motions under held-out pushes
    /// nearer to those in far more sub-steps, and returns the motions.
    ///
    /// A mode that mostly follows others does not, as the first longitudinal one of a beam that bends: there
    /// the true inertia counts. The faster modes are asked first. What the strain map misses is left out of
    /// this, because errors of time and of the map may cancel, on these pushes and on no others.
    fn fit_inertia(&self, map: &mut LargeModel, seen: &[ProjectedRun]) -> Result<Vec<Mat<f64>>, BuildError> {
        let fine = self.motions(map, Some(MANY_SUBSTEPS))?;
        let off = |motions: &[Mat<f64>]| {
            let each = seen.iter().zip(motions).zip(&fine);
            geometric_mean(&each.map(|((seen, motion), fine)| seen.apart(motion, fine)).collect::<Vec<_>>())
        };
        let mut best = self.motions(map, None)?;
        for k in (0..map.basis.natural.len()).rev() {
            let own = std::mem::take(&mut map.basis.natural[k]);
            if own == 0.0 {
                continue;
            }
            let without = self.motions(map, None)?;
            if off(&without) < off(&best) {
                best = without;
            } else {
                map.basis.natural[k] = own;
            }
        }
        Ok(best)
    }
}

fn geometric_mean(errors: &[f64]) -> f64 {
    (errors.iter().map(|error| error.ln()).sum::<f64>() / errors.len() as f64).exp()
}

/// For each number of modes the better of the maps before any regression, where it is not far behind the best
/// of all.
fn worth_fitting(priors: &[(f64, LargeModel)]) -> Vec<&LargeModel> {
    let mut sorted: Vec<_> = priors.iter().collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut kept: Vec<&LargeModel> = vec![];
    for (error, map) in &sorted {
        if *error <= BEHIND * sorted[0].0 && kept.iter().all(|other| other.modes != map.modes) {
            kept.push(map);
        }
    }
    kept
}

/// The basis as files have it. Its signs are those of the strain map.
fn basis_of(map: &LargeModel) -> Basis {
    let (r, values) = (map.basis.eigenvalues.len(), &map.basis.eigenvalues);
    Basis {
        vectors: map.basis.vectors.clone(),
        stiffness: Mat::from_fn(r, r, |i, j| if i == j { values[i] } else { 0.0 }),
        eigenvalues: Some(values.clone()),
        energy: vec![],
        singular_values: vec![],
    }
}

/// The strain map, where its training was, and the damping of the modes.
fn sections(context: &BuildContext<'_>, map: &LargeModel, problem: &Problem) -> Vec<Draft> {
    let (r, states) = (map.basis.eigenvalues.len(), map.states.as_ref());
    let linear = Mat::from_fn(r, r, |i, j| if i == j { map.map.frequencies[i] } else { 0.0 });
    let count = states.ncols() as f64;
    let mean = Mat::from_fn(r, r, |i, j| {
        (0..states.ncols()).map(|s| states[(i, s)] * states[(j, s)]).sum::<f64>() / count
    });
    let distance = inverse_root(&mean);
    let far = |s: usize| (&distance * states.col(s)).norm_l2();
    let largest_distance = (0..states.ncols()).map(far).fold(0.0, f64::max);
    // A body let go has as much again as it is held with, at most.
    let largest_energy = 2.0 * map.energies.iter().copied().fold(0.0, f64::max);
    let training = TrainingBox { distance: distance.as_ref(), largest_distance, largest_energy };
    let whole = StrainMap {
        interacting: map.map.pairs.interacting,
        linear: linear.as_ref(),
        quadratic: map.map.quadratic.as_ref(),
        modes: &map.basis.natural,
        substeps: SUBSTEPS,
        training: Some(training),
    };
    let mut sections = strain_sections(&whole, problem.output.precision);
    sections.extend(damping_section(&context.prepared.ratios, r));
    sections
}

/// `W` with `WᵀW` the inverse of a covariance; directions it hardly has count as if they had a millionth of
/// the largest.
fn inverse_root(covariance: &Mat<f64>) -> Mat<f64> {
    const LEAST: f64 = 1e-12;
    let n = covariance.nrows();
    let (values, vectors) = symmetric_eigen(covariance.as_ref()).expect("a covariance is finite");
    let largest = values.last().copied().unwrap_or(1.0);
    Mat::from_fn(n, n, |i, j| vectors[(j, i)] / values[i].max(LEAST * largest).sqrt())
}

fn large_options(problem: &Problem, body: &Body) -> LargeOptions {
    let large = problem.large.clone().unwrap_or_default();
    let coordinates = problem.basis.modes.unwrap_or(COORDINATES).min(body.n_dof());
    LargeOptions {
        displacement: asked_displacement(problem, body.model.mesh()),
        coordinates,
        rows: large.rows.unwrap_or(coordinates),
        states: large.states.unwrap_or(LargeOptions::states_of(coordinates)),
    }
}
