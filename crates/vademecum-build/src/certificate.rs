//! What a build measures about itself before it writes anything.
//!
//! Unseen loads, at positions and in directions no snapshot used, are marched full order and through each structure of
//! the step; the error is put beside the floor of the basis. Then the fused step runs free for long and its energy is
//! watched, and its spectral radius is computed.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef};
use vademecum_format::StructureCertificate;

use crate::body::Body;
use crate::dynamics::FullOrder;
use crate::fem::{Pencil, SymmetricMatrix};
use crate::march::{
    ErrorMeter, MarchError, TimedLoad, TrajectoryError, factors, march_full_order, stage_amplitudes,
};
use crate::pod::Basis;
use crate::progress::Listener;
use crate::reduced::FusedStep;
use crate::scenario::Interval;
use crate::snapshots::Runs;

/// Unseen trajectories marched side by side.
const TRAJECTORIES: usize = 3;
/// Multiply-adds spent on the free run of one structure; it is as long as that allows, and 100 000 steps at most.
const FREE_RUN_WORK: usize = 1_000_000_000;

/// Loads the snapshots have not seen.
pub struct UnseenLoads {
    /// The loads, one per trajectory.
    pub loads: Vec<TimedLoad>,
    /// Steps of the march.
    pub steps: usize,
}

impl UnseenLoads {
    /// Draws positions and directions; the same for the same body. A load is held for 0.7 of the snapshots' hold, so
    /// that its spectrum is another one.
    pub fn draw(body: &Body, runs: &Runs, steps: usize) -> Self {
        let mut random = Random::new(0x5EED_0001);
        let when = Interval { start: 0.0, end: 0.7 * runs.hold, ramp: 0.0 };
        let load = |column| {
            let triangle = body.loadable[random.below(body.loadable.len())];
            let (a, b) = (random.unit(), random.unit());
            let weights = [1.0 - a.max(b), a.min(b), (a - b).abs()];
            let direction: [f64; 3] = std::array::from_fn(|_| random.unit() - 0.5);
            let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
            let mut force = vec![0.0; body.n_dof()];
            body.model.add_point_force(&triangle, &weights, direction.map(|d| d / length), &mut force);
            TimedLoad { column, force, when }
        };
        Self { loads: (0..TRAJECTORIES).map(load).collect(), steps }
    }
}

/// A small generator (xorshift64*), so that a build draws the same loads for ever.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// `BᵀMB` and `BᵀKB` of a pencil: energy, and the acceleration a force demands.
pub struct ReducedMatrices {
    mass: Mat<f64>,
    stiffness: Mat<f64>,
}

impl ReducedMatrices {
    /// Projects a pencil.
    pub fn new(pencil: &Pencil, basis: MatRef<'_, f64>) -> Self {
        let project = |matrix: &SymmetricMatrix| {
            let mut image = Mat::zeros(basis.nrows(), basis.ncols());
            matrix.mul_into(basis, image.as_mut());
            basis.transpose() * image
        };
        Self { mass: project(pencil.mass()), stiffness: project(pencil.stiffness()) }
    }

    /// `½ ζ̇ᵀ BᵀMB ζ̇ + ½ ζᵀ BᵀKB ζ` \[J\] of a state (ζ, Δt ζ̇, Δt² ζ̈).
    pub(crate) fn energy(&self, time_step: f64, y: &[f64]) -> f64 {
        let r = self.mass.nrows();
        let form = |matrix: &Mat<f64>, x: &[f64]| -> f64 {
            (0..r).map(|i| x[i] * (0..r).map(|j| matrix[(i, j)] * x[j]).sum::<f64>()).sum()
        };
        0.5 * (form(&self.mass, &y[r..2 * r]) / (time_step * time_step) + form(&self.stiffness, &y[..r]))
    }

    /// `(BᵀMB)⁻¹ BᵀF`.
    pub(crate) fn acceleration(&self, force: Vec<f64>) -> Vec<f64> {
        let mut rhs = Mat::from_fn(force.len(), 1, |i, _| force[i]);
        let factor = self.mass.llt(faer::Side::Lower).expect("a projected mass matrix is positive definite");
        factor.solve_in_place(rhs.as_mut());
        rhs.col_as_slice(0).to_vec()
    }
}

/// Marches the unseen loads full order beside each structure and measures all of them.
///
/// # Errors
/// If the full-order march fails or is cancelled.
pub fn certify(
    body: &Body,
    full: &FullOrder<'_>,
    basis: &Basis,
    matrices: &ReducedMatrices,
    structures: &[&dyn FusedStep],
    unseen: &UnseenLoads,
    listener: &dyn Listener,
) -> Result<Vec<StructureCertificate>, MarchError> {
    let mass = body.model.pencil().mass();
    let columns = unseen.loads.len();
    let meter = || ErrorMeter::new(mass, basis.vectors.as_ref(), columns);
    let mut marches: Vec<(ReducedMarch<'_>, ErrorMeter<'_>)> =
        structures.iter().map(|s| (ReducedMarch::new(*s, full, basis, matrices, unseen), meter())).collect();
    march_full_order(full, &unseen.loads, columns, unseen.steps, listener, |step, state| {
        for (reduced, meter) in &mut marches {
            if step > 0 {
                reduced.step(step - 1);
                meter.add(state.displacement.as_ref(), reduced.coordinates().as_ref());
            }
        }
    })?;
    let certificate = |(reduced, meter): &(ReducedMarch<'_>, ErrorMeter<'_>)| {
        let worst = worst(&meter.errors());
        StructureCertificate {
            trajectory_error: worst.error,
            projection_floor: worst.floor,
            spectral_radius: reduced.structure.spectral_radius(),
            energy_ratio: reduced.free_run_energy(),
            map_error_rms: f64::NAN,
            map_error_max: f64::NAN,
            steps: unseen.steps as f64,
        }
    };
    Ok(marches.iter().map(certificate).collect())
}

/// The trajectory farthest above its floor.
pub(crate) fn worst(errors: &[TrajectoryError]) -> TrajectoryError {
    let excess = |e: &TrajectoryError| e.error / e.floor.max(f64::MIN_POSITIVE);
    errors.iter().copied().max_by(|a, b| excess(a).total_cmp(&excess(b))).expect("there are trajectories")
}

/// The reduced march of the unseen loads.
struct ReducedMarch<'a> {
    structure: &'a dyn FusedStep,
    full: &'a FullOrder<'a>,
    matrices: &'a ReducedMatrices,
    unseen: &'a UnseenLoads,
    responses: Vec<Vec<Vec<f64>>>,
    states: Vec<Vec<f64>>,
    load: Vec<f64>,
    work: Vec<f64>,
}

impl<'a> ReducedMarch<'a> {
    fn new(
        structure: &'a dyn FusedStep,
        full: &'a FullOrder<'a>,
        basis: &'a Basis,
        matrices: &'a ReducedMatrices,
        unseen: &'a UnseenLoads,
    ) -> Self {
        let r = structure.n_modes();
        // From rest the acceleration is what the force at time zero demands.
        let state = |load: &TimedLoad| {
            let force =
                matrices.acceleration(crate::export::reduced_load(basis.vectors.as_ref(), &load.force));
            let factor = load.when.factor(0.0) * full.dt() * full.dt();
            let mut y = vec![0.0; 3 * r];
            y[2 * r..].iter_mut().zip(force).for_each(|(a, f)| *a = factor * f);
            y
        };
        Self {
            structure,
            full,
            matrices,
            unseen,
            responses: unseen.loads.iter().map(|load| structure.load_response(&load.force)).collect(),
            states: unseen.loads.iter().map(state).collect(),
            load: vec![0.0; 3 * r],
            work: vec![0.0; 3 * r],
        }
    }

    fn step(&mut self, step: usize) {
        for (j, load) in self.unseen.loads.iter().enumerate() {
            let factors = factors(self.full.table(), self.full.dt(), step, &load.when);
            let amplitudes = stage_amplitudes(self.full.table(), &factors);
            self.load.fill(0.0);
            if amplitudes.iter().any(|&p| p != 0.0) {
                self.structure.add_load(&self.responses[j], &amplitudes, &mut self.load);
            }
            self.structure.step(&mut self.states[j], &self.load, &mut self.work);
        }
    }

    fn coordinates(&self) -> Mat<f64> {
        Mat::from_fn(self.structure.n_modes(), self.states.len(), |i, j| self.states[j][i])
    }

    /// Largest energy of a long unloaded run from the last states, over the energy at its start.
    fn free_run_energy(&self) -> f64 {
        let r = self.structure.n_modes();
        let steps = (FREE_RUN_WORK / (9 * r * r)).min(100_000);
        let zero = vec![0.0; 3 * r];
        let mut work = zero.clone();
        let mut y = self.states[0].clone();
        // The first unloaded step removes what is left of the load's acceleration.
        self.structure.step(&mut y, &zero, &mut work);
        let start = self.matrices.energy(self.full.dt(), &y);
        let mut largest = start;
        for _ in 0..steps {
            self.structure.step(&mut y, &zero, &mut work);
            largest = largest.max(self.matrices.energy(self.full.dt(), &y));
        }
        largest / start
    }
}
