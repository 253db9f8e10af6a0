//! The road of large displacements: states, strain maps, a choice by held-out pushes, a certificate by
//! others.

use std::time::Instant;

use faer::Mat;

use super::plan::in_words;
use super::vademecum::Certified;
use super::{BuildError, Built, Stages};
use crate::basis::Basis;
use crate::certificate::{LargeReport, StructureMeasured, certify_push};
use crate::dynamics::{lowest_modes, symmetric_eigen};
use crate::export::{Draft, StrainMap, TrainingBox, strain_sections};
use crate::fem::GreenStrain;
use crate::input::Problem;
use crate::large::{FullOrder, LargeOptions, Learnt, Push, Pushes, learn, longest_edge};
use crate::prepared::Body;
use crate::progress::Stopwatch;
use crate::report::BuildPlan;

/// Coordinates where the problem does not say.
const COORDINATES: usize = 32;
/// States to learn from, for each coordinate.
const STATES: usize = 8;
/// Sub-steps of a step.
const SUBSTEPS: usize = 4;
/// Largest displacement where the problem does not say, as a part of the longest edge around the body.
const DISPLACEMENT: f64 = 0.2;
/// Modes that tell how strong a push is.
const PUSH_MODES: usize = 8;
/// Pushes that choose, and first periods of each.
const CHOOSING: (usize, f64) = (2, 2.0);
/// Pushes of the certificate, and first periods of each.
const CERTIFYING: (usize, f64) = (2, 5.0);
/// Where the pushes are drawn; no push of one draw is one of the other.
const SEEDS: [u64; 2] = [0xC400_5E01, 0xCE47_1F02];

impl Stages<'_> {
    /// One file of large displacements.
    pub(super) fn large(
        &self,
        problem: &Problem,
        mut plan: BuildPlan,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Built, BuildError> {
        let Self { prepared, kept, first_period, order, .. } = *self;
        let (body, symbolic, listener) = (&prepared.body, &prepared.symbolic, kept.listener);
        let options = large_options(problem, body);
        let time_step = prepared.step.time_step;
        let strain = GreenStrain::new(&body.model)?;
        let pencil = body.model.pencil();
        let modes = lowest_modes(pencil, symbolic, PUSH_MODES.min(pencil.n_dof()))?;
        let drawn = Pushes { body, modes: &modes, displacement: options.displacement, time_step };
        let full = FullOrder { strain: &strain, symbolic, damping: prepared.rayleigh(), time_step };
        let steps = |periods: f64| (periods * first_period / time_step).ceil() as usize;
        let [(choosing, choosing_steps), (certifying, certifying_steps)] =
            [CHOOSING, CERTIFYING].map(|(count, periods)| (count, steps(periods)));

        let pushes = drawn.draw(choosing, SEEDS[0]);
        let count = (choosing * choosing_steps + certifying * certifying_steps) as f64;
        plan.work = full.work(&pushes[..1], count, listener)?;
        plan.work.check(self.options.long, || "pushes at full order".into())?;
        listener.note(&format!("ahead: {}; and shapes of least energy before them", in_words(&plan)));
        let maps = watch.stage("shapes of least energy", || learn(body, symbolic, &options, listener))?;
        let march = || full.march(&pushes, choosing_steps, listener);
        let references = watch.stage("held-out pushes at full order", march)?;
        let follow = |map: &Learnt| {
            let error = |(push, reference): (&Push, &Vec<Vec<f64>>)| {
                let found = map.follow(push, choosing_steps, time_step, SUBSTEPS, prepared.rayleigh());
                map.see(body, reference).error(&found).error
            };
            pushes.iter().zip(&references).map(error).fold(0.0, f64::max)
        };
        let errors: Vec<f64> = watch.stage("choice of the strain map", || maps.iter().map(follow).collect());
        let candidates: Vec<_> = maps.iter().map(|map| map.name.clone()).zip(errors).collect();
        for (name, error) in &candidates {
            listener.note(&format!("{name}: error {error:.2e} on the worst held-out push"));
        }
        let best = (0..maps.len()).min_by(|&a, &b| candidates[a].1.total_cmp(&candidates[b].1));
        let map = maps.into_iter().nth(best.unwrap_or(0)).expect("there are strain maps");

        let basis = basis_of(&map);
        let strain_rows = sections(&map, problem);
        let sized = Stages { strain: &strain_rows, ..*self };
        let pushes = drawn.draw(certifying, SEEDS[1]);
        let march = || full.march(&pushes, certifying_steps, listener);
        let start = Instant::now();
        let references = watch.stage("pushes of the certificate at full order", march)?;
        let steps = (certifying * certifying_steps) as f64;
        let full_order_seconds_per_step = start.elapsed().as_secs_f64() / steps;
        let bytes = sized.file(problem, &basis, &Certified::large(StructureMeasured::default()))?;
        let certify = || {
            let run = |(push, reference): (&Push, &Vec<Vec<f64>>)| {
                let seen = map.see(body, reference);
                Ok(certify_push(&bytes, order, body, push, (reference, &seen))?)
            };
            pushes.iter().zip(&references).map(run).collect::<Result<Vec<_>, BuildError>>()
        };
        let runs = watch.stage("certificate", certify)?;
        let (strain_map, rows) = (map.name.clone(), map.map.quadratic.nrows());
        let report = LargeReport {
            strain_map,
            rows,
            substeps: SUBSTEPS,
            candidates,
            full_order_seconds_per_step,
            runs,
        };
        let certified = Certified::large(report.measured(certifying_steps));
        let bytes = watch.stage("encode", || sized.file(problem, &basis, &certified))?;
        let mut told = sized.report(problem, &basis, &certified, 0, watch.timings(), bytes.len());
        told.large = Some(report);
        told.plan = plan;
        Ok(Built { bytes, report: told })
    }
}

/// The basis as files have it. Its signs are those of the strain map.
fn basis_of(map: &Learnt) -> Basis {
    let (r, values) = (map.eigenvalues.len(), &map.eigenvalues);
    Basis {
        vectors: map.vectors.clone(),
        stiffness: Mat::from_fn(r, r, |i, j| if i == j { values[i] } else { 0.0 }),
        eigenvalues: Some(values.clone()),
        energy: vec![],
        singular_values: vec![],
    }
}

/// The strain map, and where its training was.
fn sections(map: &Learnt, problem: &Problem) -> Vec<Draft> {
    let (r, states) = (map.eigenvalues.len(), map.states.as_ref());
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
        coupled: map.map.pairs.coupled,
        linear: linear.as_ref(),
        tail: &[],
        quadratic: map.map.quadratic.as_ref(),
        substeps: SUBSTEPS,
        training: Some(training),
    };
    strain_sections(&whole, problem.output.precision)
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
        displacement: large.displacement.unwrap_or_else(|| DISPLACEMENT * longest_edge(body.model.mesh())),
        coordinates,
        rows: large.rows.unwrap_or(coordinates),
        states: large.states.unwrap_or(STATES * coordinates),
    }
}
