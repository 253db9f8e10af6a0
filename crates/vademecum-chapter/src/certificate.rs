//! Certificate of the chapter's structure: unseen loads at its positions, full order beside
//! the scene of the bytes that ship, and whether the trajectories stayed on its axes.

use faer::{Mat, MatRef};
use vademecum_eval::{Contact, Place, SceneOptions};
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{ChapterRole, File, StructureCertificate};

use crate::error::ChapterError;
use crate::map::{ChapterMap, StageMap};
use crate::online::{ChapterLoads, ChapterScene, ChapterState, ChapterStepError};
use crate::separation::StageError;
use vademecum_build::basis::{Basis, SnapshotSchedule};
use vademecum_build::certificate::StructureMeasured;
use vademecum_build::dynamics::{ErrorMeter, FullOrder, Interval, TimedLoad, march_full_order};
use vademecum_build::export::NodeOrder;
use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::linalg::{self, LoadDraw, unit};
use vademecum_build::prepared::Body;
use vademecum_build::progress::Listener;

/// Unseen trajectories marched side by side.
const TRAJECTORIES: usize = 3;
/// Factors read in the free run; it is as long as that allows, and 100 000 steps at most.
const FREE_RUN_WORK: usize = 1_000_000_000;
/// Seed of the draw of loads.
const SEED: u64 = 0x5EED_0002;

/// Measurements of a canonical map.
#[derive(Clone, Debug)]
pub struct ChapterCertificate {
    /// As of the other structures, over the steps that were on the axes. The map errors are those of the
    /// worst stage, root mean square and the larger of its state and load parts; the spectral radius is that
    /// of the step linearised at rest.
    pub structure: StructureMeasured,
    /// The step at which a trajectory left an axis, and which; errors are of the steps before it.
    pub left: Option<(usize, ChapterStepError)>,
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
        let certificate = StructureCertificate {
            map_error_rms: largest(|e| e.total),
            map_error_max: largest(|e| e.state.max(e.load)),
            ..StructureCertificate::default()
        };
        let structure = StructureMeasured { certificate, ..StructureMeasured::default() };
        let terms = map.stages.iter().map(StageMap::n_terms).collect();
        Self { structure, left: None, stages, terms }
    }
}

/// A load of the certificate: as the evaluator takes it, and at full order.
struct Unseen {
    contact: Contact,
    timed: TimedLoad,
}

/// Loads the snapshots have not seen, at positions of a map, and how long they are marched.
pub struct ChapterUnseen {
    loads: Vec<Unseen>,
    steps: usize,
}

/// One trajectory: its state, the loads on it, and the factors that stand in them.
type Trajectory = (ChapterState, ChapterLoads, [f64; 1 + MAX_STAGES]);

/// The march of one file beside the full-order one.
struct March<'m> {
    scene: ChapterScene<'m>,
    trajectories: Vec<Trajectory>,
    meter: ErrorMeter<'m>,
    left: Option<(usize, ChapterStepError)>,
}

/// Marches unseen loads full order beside files of maps over the same positions and measures each. `mass` is
/// the mass matrix of the problem file, in which `basis` is orthonormal.
///
/// # Errors
/// [`ChapterError`]: a full-order march that fails or is cancelled, a file the evaluator refuses.
pub fn certify_chapter(
    files: &[(&ChapterMap, &[u8])],
    unseen: &ChapterUnseen,
    mass: &SymmetricMatrix,
    full: &FullOrder<'_>,
    basis: &Basis,
    listener: &dyn Listener,
) -> Result<Vec<ChapterCertificate>, ChapterError> {
    let ChapterUnseen { loads: unseen, steps } = unseen;
    let timed: Vec<TimedLoad> = unseen.iter().map(|u| u.timed.clone()).collect();
    let opened = files.iter().map(|(_, bytes)| File::parse(bytes)).collect::<Result<Vec<_>, _>>()?;
    let bind = |file| {
        let meter = ErrorMeter::new(mass, basis.vectors.as_ref(), unseen.len());
        March::bind(file, unseen, meter)
    };
    let mut marches = opened.iter().map(bind).collect::<Result<Vec<_>, _>>()?;
    let mut refused = None;
    march_full_order(full, &timed, timed.len(), *steps, listener, |step, state| {
        for march in marches.iter_mut().filter(|march| step > 0 && march.left.is_none()) {
            if let Err(error) = march.step(step, unseen) {
                refused.get_or_insert(error);
            } else if march.left.is_none() {
                march.meter.add(state.displacement.as_ref(), march.coordinates().as_ref());
            }
        }
    })?;
    if let Some(error) = refused {
        return Err(error);
    }
    marches.iter_mut().zip(files).map(|(march, (map, _))| march.certificate(map, *steps)).collect()
}

impl<'m> March<'m> {
    fn bind(file: &File<'m>, unseen: &[Unseen], meter: ErrorMeter<'m>) -> Result<Self, ChapterError> {
        let scene = ChapterScene::bind(file, &SceneOptions::default())?;
        let zero = vec![0.0; scene.n_modes()];
        let trajectories = unseen.iter().map(|load| {
            let mut trajectory =
                (ChapterState::new(&scene), ChapterLoads::new(&scene), [0.0; 1 + MAX_STAGES]);
            load_step(&scene, load, 0, &mut trajectory)?;
            // From rest the acceleration is what the force at time zero demands.
            scene.set(&mut trajectory.0, &zero, &zero, &trajectory.1)?;
            Ok(trajectory)
        });
        let trajectories = trajectories.collect::<Result<_, ChapterError>>()?;
        Ok(Self { scene, trajectories, meter, left: None })
    }

    /// Step number `step`, counted from 1, of every trajectory, unless one leaves its axes.
    fn step(&mut self, step: usize, unseen: &[Unseen]) -> Result<(), ChapterError> {
        for (load, trajectory) in unseen.iter().zip(&mut self.trajectories) {
            load_step(&self.scene, load, step - 1, trajectory)?;
            match self.scene.step(&mut trajectory.0, &trajectory.1) {
                Ok(_) => {}
                Err(outside @ ChapterStepError::OutsideAxis { .. }) => {
                    self.left = Some((step, outside));
                    return Ok(());
                }
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// ζ of every trajectory, shape (r, trajectories).
    fn coordinates(&self) -> Mat<f64> {
        Mat::from_fn(self.scene.n_modes(), self.trajectories.len(), |i, j| self.trajectories[j].0.zeta()[i])
    }

    fn certificate(&mut self, map: &ChapterMap, steps: usize) -> Result<ChapterCertificate, ChapterError> {
        let left = self.left;
        let maps = ChapterCertificate::of_maps(map);
        let energy_ratio = if left.is_some() { f64::NAN } else { self.free_run(map)? };
        let steps = left.map_or(steps, |(step, _)| step - 1);
        let mut structure = StructureMeasured::of_runs(self.meter.errors(), steps);
        let certificate = &mut structure.certificate;
        certificate.spectral_radius = self.spectral_radius(map)?;
        certificate.energy_ratio = energy_ratio;
        certificate.map_error_rms = maps.structure.certificate.map_error_rms;
        certificate.map_error_max = maps.structure.certificate.map_error_max;
        Ok(ChapterCertificate { structure, left, ..maps })
    }

    /// Largest energy of a long unloaded run over the energy at its start; NaN if it leaves an axis.
    fn free_run(&mut self, map: &ChapterMap) -> Result<f64, ChapterError> {
        let parts = map.stages.iter().flat_map(|s| &s.parts);
        let cost: usize = parts.map(|p| p.terms.ncols() * p.axes.len()).sum();
        let steps = (FREE_RUN_WORK / cost.max(1)).min(100_000);
        let (state, loads, _) = &mut self.trajectories[0];
        loads.clear();
        if self.scene.step(state, loads).is_err() {
            return Ok(f64::NAN);
        }
        let start = self.scene.energy(state)?;
        let mut largest = start;
        for _ in 0..steps {
            if self.scene.step(state, loads).is_err() {
                return Ok(f64::NAN);
            }
            largest = largest.max(self.scene.energy(state)?);
        }
        Ok(largest / start)
    }

    /// Largest modulus of the eigenvalues of the unloaded step linearised at rest, by differences over half
    /// of each range (less where a stage would leave its own); NaN if some coordinate cannot be moved.
    fn spectral_radius(&mut self, map: &ChapterMap) -> Result<f64, ChapterError> {
        let n = 3 * map.n_modes;
        let mut columns = vec![0.0; n * n];
        for (j, column) in columns.chunks_exact_mut(n).enumerate() {
            let Some(slope) = self.slope(map, j)? else { return Ok(f64::NAN) };
            column.copy_from_slice(&slope);
        }
        let matrix = MatRef::from_column_major_slice(&columns, n, n);
        let eigenvalues = linalg::eigenvalues(matrix).map_err(|_| ChapterError::Eigenvalues)?;
        Ok(eigenvalues.iter().map(|l| l.re.hypot(l.im)).fold(0.0, f64::max))
    }

    /// Column `j` of the linearised step.
    fn slope(&mut self, map: &ChapterMap, j: usize) -> Result<Option<Vec<f64>>, ChapterError> {
        let (family, mode) = (j / map.n_modes, j % map.n_modes);
        let axes = map.stages.iter().flat_map(|s| &s.parts).flat_map(|part| &part.axes);
        let own = axes.filter(|axis| axis.role == ChapterRole::State { family, mode });
        let reach = own.map(|axis| axis.upper.min(-axis.lower) / axis.factor).fold(f64::INFINITY, f64::min);
        let mut length = if reach.is_finite() { 0.5 * reach } else { 1.0 };
        for _ in 0..60 {
            if let (Some(up), Some(down)) = (self.moved(j, length)?, self.moved(j, -length)?) {
                return Ok(Some(up.iter().zip(down).map(|(u, d)| (u - d) / (2.0 * length)).collect()));
            }
            length *= 0.5;
        }
        Ok(None)
    }

    /// The state after one unloaded step from `by` in entry `j`; none if that leaves an axis.
    fn moved(&mut self, j: usize, by: f64) -> Result<Option<Vec<f64>>, ChapterError> {
        let (state, loads, _) = &mut self.trajectories[0];
        loads.clear();
        let mut y = vec![0.0; 3 * self.scene.n_modes()];
        y[j] = by;
        state.restore(&y)?;
        if self.scene.step(state, loads).is_err() {
            return Ok(None);
        }
        state.save_into(&mut y)?;
        Ok(Some(y))
    }
}

/// Puts the load of a step into a trajectory's loads where it differs from that of the step before.
fn load_step(
    scene: &ChapterScene<'_>,
    load: &Unseen,
    step: usize,
    (_, loads, known): &mut Trajectory,
) -> Result<(), ChapterError> {
    let time_step = scene.parameters().time_step;
    let factors = scene.instants().map(|c| load.timed.when.factor((step as f64 + c) * time_step));
    if factors != *known {
        *known = factors;
        loads.clear();
        if factors.iter().any(|&f| f != 0.0) {
            loads.add_contact_staged(scene, &load.contact, &factors)?;
        }
    }
    Ok(())
}

impl ChapterUnseen {
    /// Draws loads of the largest magnitude, held for 0.7 of the snapshots' hold, where no run of the
    /// snapshots was if there are such positions; the same for the same map. `order` is the order of nodes of
    /// the files.
    pub fn draw(
        map: &ChapterMap,
        body: &Body,
        order: &NodeOrder,
        runs: &SnapshotSchedule,
        steps: usize,
    ) -> Self {
        let mut random = LoadDraw::new(SEED);
        let when = Interval { start: 0.0, end: 0.7 * runs.hold, ramp: 0.0 };
        let seen = |position: &u32| runs.nodes.contains(position);
        let fresh: Vec<u32> = map.positions.iter().copied().filter(|p| !seen(p)).collect();
        let choice = if fresh.is_empty() { &map.positions } else { &fresh };
        let [lower, upper] = map.load;
        let magnitude = if upper >= -lower { upper } else { lower };
        let load = |column| {
            let node = choice[random.below(choice.len())];
            let drawn = || unit(std::array::from_fn(|_| random.uniform() - 0.5));
            let force = map.direction.unwrap_or_else(drawn).map(|d| magnitude * d);
            let mut full = vec![0.0; body.n_dof()];
            body.model.add_point_force(&[node], &[1.0], force, &mut full);
            let nodes = [order.file_node[node as usize]; 3];
            let contact = Contact::new(Place::triangle(nodes, [1.0, 0.0, 0.0]), force);
            Unseen { contact, timed: TimedLoad { column, force: full, when: when.into() } }
        };
        Self { loads: (0..TRAJECTORIES).map(load).collect(), steps }
    }
}
