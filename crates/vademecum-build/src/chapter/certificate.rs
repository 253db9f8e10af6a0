//! What a canonical build measures about itself: unseen loads at its positions, full order beside it, and whether the
//! trajectories stayed on its axes.

use faer::Mat;
use vademecum_format::StructureCertificate;

use super::separation::StageError;
use super::{ChapterLoad, ChapterMap, Outside, StageMap};
use crate::basis::{Basis, Runs};
use crate::certificate::worst;
use crate::dynamics::{
    ErrorMeter, FullOrder, Interval, MarchError, TimedLoad, factors, march_full_order, stage_amplitudes,
};
use crate::linalg::{Random, project, unit};
use crate::prepared::Prepared;
use crate::progress::Listener;
use crate::response::reduced::ReducedMatrices;

/// Unseen trajectories marched side by side.
const TRAJECTORIES: usize = 3;
/// Factors read in the free run; it is as long as that allows, and 100 000 steps at most.
const FREE_RUN_WORK: usize = 1_000_000_000;

/// What was measured of a canonical map.
#[derive(Clone, Debug)]
pub struct ChapterCertificate {
    /// As of the other structures, over the steps that were on the axes. The map errors are those of the worst stage, root mean
    /// square and the larger of its state and load parts; the spectral radius is that of the step linearised at rest.
    pub structure: StructureCertificate,
    /// The step at which a trajectory left an axis, and which; errors are of the steps before it.
    pub left: Option<(usize, Outside)>,
    /// Error of each stage's map over random points.
    pub stages: Vec<StageError>,
    /// Terms of each stage.
    pub terms: Vec<usize>,
}

impl ChapterCertificate {
    /// The errors of the maps alone, nothing marched.
    pub fn of_maps(map: &ChapterMap) -> Self {
        let stages: Vec<StageError> = map.stages.iter().map(|stage| stage.error).collect();
        let largest = |part: fn(&StageError) -> f64| stages.iter().map(part).fold(0.0, f64::max);
        let structure = StructureCertificate {
            map_error_rms: largest(|e| e.total),
            map_error_max: largest(|e| e.state.max(e.load)),
            ..StructureCertificate::default()
        };
        let terms = map.stages.iter().map(StageMap::n_terms).collect();
        Self { structure, left: None, stages, terms }
    }
}

/// A load of the certificate: where it stands, and the same at full order.
struct Unseen {
    position: usize,
    components: [f64; 3],
    magnitude: f64,
    timed: TimedLoad,
}

/// The march of one map beside the full-order one.
struct March<'a> {
    map: &'a ChapterMap,
    states: Vec<Vec<f64>>,
    meter: ErrorMeter<'a>,
    left: Option<(usize, Outside)>,
}

/// Marches unseen loads full order beside maps over the same positions and measures each.
///
/// The loads have the largest magnitude, are held for 0.7 of the snapshots' hold and stand where no run of the snapshots was, if
/// there are such positions.
///
/// # Errors
/// If the full-order march fails or is cancelled.
pub fn certify_chapter(
    maps: &[&ChapterMap],
    prepared: &Prepared,
    full: &FullOrder<'_>,
    basis: &Basis,
    runs: &Runs,
    steps: usize,
    listener: &dyn Listener,
) -> Result<Vec<ChapterCertificate>, MarchError> {
    let pencil = prepared.body.model.pencil();
    let matrices = ReducedMatrices::new(pencil, basis.vectors.as_ref());
    let Some(first) = maps.first() else { return Ok(vec![]) };
    let unseen = draw(first, prepared, runs);
    let loads: Vec<TimedLoad> = unseen.iter().map(|u| u.timed.clone()).collect();
    let states: Vec<Vec<f64>> = unseen.iter().map(|load| initial(load, full, basis, &matrices)).collect();
    let march = |&map| March {
        map,
        states: states.clone(),
        meter: ErrorMeter::new(pencil.mass(), basis.vectors.as_ref(), unseen.len()),
        left: None,
    };
    let mut marches: Vec<March<'_>> = maps.iter().map(march).collect();
    march_full_order(full, &loads, loads.len(), steps, listener, |step, state| {
        for march in marches.iter_mut().filter(|march| step > 0 && march.left.is_none()) {
            march.step(step, &unseen, full);
            if march.left.is_none() {
                let states = &march.states;
                let coordinates = Mat::from_fn(basis.n_modes(), states.len(), |i, j| states[j][i]);
                march.meter.add(state.displacement.as_ref(), coordinates.as_ref());
            }
        }
    })?;
    Ok(marches.iter().map(|march| march.certificate(full, &matrices, steps)).collect())
}

impl March<'_> {
    fn step(&mut self, step: usize, unseen: &[Unseen], full: &FullOrder<'_>) {
        for (load, y) in unseen.iter().zip(&mut self.states) {
            if let Err(outside) = self.map.step(y, load.at(full, step - 1).as_ref()) {
                self.left = Some((step, outside));
                return;
            }
        }
    }

    fn certificate(
        &self,
        full: &FullOrder<'_>,
        matrices: &ReducedMatrices,
        steps: usize,
    ) -> ChapterCertificate {
        let (map, left) = (self.map, self.left);
        let maps = ChapterCertificate::of_maps(map);
        let measured = worst(&self.meter.errors());
        let free = || free_run(map, full, matrices, &self.states[0]);
        let structure = StructureCertificate {
            trajectory_error: measured.error,
            projection_floor: measured.floor,
            spectral_radius: map.spectral_radius(),
            energy_ratio: if left.is_some() { f64::NAN } else { free() },
            steps: left.map_or(steps, |(step, _)| step - 1) as f64,
            ..maps.structure
        };
        ChapterCertificate { structure, left, ..maps }
    }
}

fn draw(map: &ChapterMap, prepared: &Prepared, runs: &Runs) -> Vec<Unseen> {
    let body = &prepared.body;
    let mut random = Random::new(0x5EED_0002);
    let when = Interval { start: 0.0, end: 0.7 * runs.hold, ramp: 0.0 };
    let seen = |position: &usize| runs.nodes.contains(&map.positions[*position]);
    let all: Vec<usize> = (0..map.positions.len()).collect();
    let fresh: Vec<usize> = all.iter().copied().filter(|p| !seen(p)).collect();
    let choice = if fresh.is_empty() { &all } else { &fresh };
    let [lower, upper] = map.load;
    let magnitude = if upper >= -lower { upper } else { lower };
    let load = |column| {
        let position = choice[random.below(choice.len())];
        let components = map.direction.unwrap_or_else(|| {
            let d: [f64; 3] = std::array::from_fn(|_| random.uniform() - 0.5);
            unit(d)
        });
        let mut force = vec![0.0; body.n_dof()];
        let node = map.positions[position];
        body.model.add_point_force(&[node], &[1.0], components.map(|d| magnitude * d), &mut force);
        Unseen { position, components, magnitude, timed: TimedLoad { column, force, when } }
    };
    (0..TRAJECTORIES).map(load).collect()
}

/// From rest the acceleration is what the force at time zero demands.
fn initial(load: &Unseen, full: &FullOrder<'_>, basis: &Basis, matrices: &ReducedMatrices) -> Vec<f64> {
    let r = basis.n_modes();
    let reduced = project(basis.vectors.as_ref(), &load.timed.force);
    let factor = load.timed.when.factor(0.0) * full.dt() * full.dt();
    let mut y = vec![0.0; 3 * r];
    y[2 * r..].iter_mut().zip(matrices.acceleration(reduced)).for_each(|(a, f)| *a = factor * f);
    y
}

impl Unseen {
    /// The load of a step; none once it is over.
    fn at(&self, full: &FullOrder<'_>, step: usize) -> Option<ChapterLoad> {
        let factors = factors(full.table(), full.dt(), step, &self.timed.when);
        let magnitudes = stage_amplitudes(full.table(), &factors).map(|p| p * self.magnitude);
        let acts = magnitudes.iter().any(|&p| p != 0.0);
        acts.then_some(ChapterLoad { position: self.position, magnitudes, components: self.components })
    }
}

/// Largest energy of a long unloaded run over the energy at its start; NaN if it leaves an axis.
fn free_run(map: &ChapterMap, full: &FullOrder<'_>, matrices: &ReducedMatrices, from: &[f64]) -> f64 {
    let cost: usize = map.stages.iter().flat_map(|s| &s.parts).map(|p| p.terms.ncols() * p.axes.len()).sum();
    let steps = (FREE_RUN_WORK / cost.max(1)).min(100_000);
    let mut y = from.to_vec();
    if map.step(&mut y, None).is_err() {
        return f64::NAN;
    }
    let start = matrices.energy(full.dt(), &y);
    let mut largest = start;
    for _ in 0..steps {
        if map.step(&mut y, None).is_err() {
            return f64::NAN;
        }
        largest = largest.max(matrices.energy(full.dt(), &y));
    }
    largest / start
}
