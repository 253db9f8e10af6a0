//! Loads that no snapshot has seen.

use crate::basis::SnapshotSchedule;
use crate::dynamics::{Interval, TimedLoad};
use crate::linalg::{LoadDraw, unit};
use crate::prepared::Body;
use crate::store::{Inputs, StageInput};

/// Unseen trajectories marched side by side.
pub(crate) const TRAJECTORIES: usize = 3;
/// Where the draw starts.
const SEED: u64 = 0x5EED_0001;

/// A unit force at a point of the loadable surface, as the evaluator and as the full-order solver take it.
#[derive(Clone, Debug)]
pub struct UnseenLoad {
    /// Mesh nodes that share the force.
    pub nodes: Vec<u32>,
    /// Their shares.
    pub weights: Vec<f64>,
    /// Force \[N\].
    pub force: [f64; 3],
    /// The same over the free dofs, and when it acts.
    pub(crate) timed: TimedLoad,
}

/// A push of a test run, as the report of a build has it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct TestLoad {
    /// Its point \[m\].
    pub point: [f64; 3],
    /// Force \[N\].
    pub force: [f64; 3],
    /// End of the push, which starts at zero \[s\].
    pub end: f64,
}

/// Loads the snapshots have not seen.
pub struct UnseenLoads {
    /// The loads, one per trajectory.
    pub loads: Vec<UnseenLoad>,
    /// Steps of the march.
    pub steps: usize,
    /// Whether the problem left the steps open, so that a march elsewhere in a box may take more.
    pub open: bool,
}

impl UnseenLoads {
    /// Draws positions and directions; the same for the same body. A load is held for 0.7 of the snapshots'
    /// hold, so that its spectrum is another one.
    pub fn draw(body: &Body, runs: &SnapshotSchedule, steps: usize) -> Self {
        let mut random = LoadDraw::new(SEED);
        let when = Interval { start: 0.0, end: 0.7 * runs.hold, ramp: 0.0 };
        let load = |column| {
            let places = if body.loadable.is_empty() { body.load_nodes.len() } else { body.loadable.len() };
            let place = random.below(places);
            let (a, b) = (random.uniform(), random.uniform());
            let weights = [1.0 - a.max(b), a.min(b), (a - b).abs()];
            // A body without triangles is loaded at nodes.
            let (nodes, weights) = match body.load_nodes.get(place) {
                Some(&node) if body.loadable.is_empty() => (vec![node; 3], weights.to_vec()),
                _ => body.place(place, weights),
            };
            let force = unit(std::array::from_fn(|_| random.uniform() - 0.5));
            let mut full = vec![0.0; body.n_dof()];
            body.model.add_point_force(&nodes, &weights, force, &mut full);
            UnseenLoad { nodes, weights, force, timed: TimedLoad { column, force: full, when: when.into() } }
        };
        Self { loads: (0..TRAJECTORIES).map(load).collect(), steps, open: false }
    }

    /// The same loads, marched for a first period of so many steps at least if the problem left the steps
    /// open.
    pub(crate) fn over(&self, period: f64) -> Self {
        let steps = if self.open { self.steps.max(period.ceil() as usize) } else { self.steps };
        Self { loads: self.loads.clone(), steps, open: self.open }
    }

    /// The same loads, ending on whole steps of `time_step`.
    pub(super) fn on_steps(&self, time_step: f64) -> Self {
        let mut loads = self.loads.clone();
        for load in &mut loads {
            let when = &mut load.timed.when.during;
            when.end = (when.end / time_step).round().max(1.0) * time_step;
        }
        Self { loads, ..*self }
    }

    /// Points on a mesh with these nodes, forces and times.
    pub(crate) fn places(&self, nodes: &[[f64; 3]]) -> Vec<TestLoad> {
        let place = |load: &UnseenLoad| {
            let shares = || load.nodes.iter().zip(&load.weights);
            let coordinate =
                |axis: usize| shares().map(|(&node, weight)| weight * nodes[node as usize][axis]).sum();
            let end = load.timed.when.during.end;
            TestLoad { point: std::array::from_fn(coordinate), force: load.force, end }
        };
        self.loads.iter().map(place).collect()
    }

    /// As the full-order solver takes them.
    pub(crate) fn timed(&self) -> Vec<TimedLoad> {
        self.loads.iter().map(|load| load.timed.clone()).collect()
    }
}

/// The loads of a certificate and how long they are marched.
impl StageInput for UnseenLoads {
    fn add_to(&self, inputs: Inputs) -> Inputs {
        let steps = inputs.value(&self.steps);
        self.loads.iter().fold(steps, |inputs, load| {
            inputs.value(&(load.timed.column, &load.timed.when)).numbers(&load.timed.force)
        })
    }
}
