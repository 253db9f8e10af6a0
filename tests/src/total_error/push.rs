//! Pushes at random places, and how they follow time.

use std::sync::Arc;

use vademecum_build::dynamics::{Course, History, Interval, LoadTable, TimedLoad};
use vademecum_build::linalg::Random;
use vademecum_build::prepared::Body;

/// Steps of a run: five first periods at 40 steps each.
pub const STEPS: usize = 200;

/// A force of 1 N at a point of the loadable surface.
#[derive(Clone, Copy, Debug)]
pub struct Push {
    /// Corners of the triangle, by mesh node.
    pub nodes: [u32; 3],
    /// Shares of the corners.
    pub weights: [f64; 3],
    /// Force \[N\].
    pub force: [f64; 3],
}

impl Push {
    /// So many pushes, places uniform over the area and directions over the sphere; the same for the same
    /// body. A push that only held components would feel is drawn again.
    #[must_use]
    pub fn draw(body: &Body, count: usize) -> Vec<Push> {
        let at = |node: u32| body.model.mesh().nodes[node as usize];
        let mut area = 0.0;
        let areas: Vec<f64> = body
            .loadable
            .iter()
            .map(|&[a, b, c]| {
                let [e, f] = [b, c].map(|to| std::array::from_fn(|k| at(to)[k] - at(a)[k]));
                area += length(cross(e, f));
                area
            })
            .collect();
        let mut random = Random::new(0x707A_1E44);
        let mut draw = || {
            let place = random.uniform() * area;
            let triangle = areas.partition_point(|&end| end <= place).min(areas.len() - 1);
            let (a, b) = (random.uniform(), random.uniform());
            let (height, turn) = (2.0 * random.uniform() - 1.0, std::f64::consts::TAU * random.uniform());
            let flat = (1.0 - height * height).sqrt();
            Push {
                nodes: body.loadable[triangle],
                weights: [1.0 - a.max(b), a.min(b), (a - b).abs()],
                force: [flat * turn.cos(), flat * turn.sin(), height],
            }
        };
        let mut pushes = vec![];
        while pushes.len() < count {
            let push = draw();
            if push.over_dofs(body).iter().any(|&f| f != 0.0) {
                pushes.push(push);
            }
        }
        pushes
    }

    /// The force over the free dofs \[N\].
    #[must_use]
    pub fn over_dofs(&self, body: &Body) -> Vec<f64> {
        let mut force = vec![0.0; body.n_dof()];
        body.model.add_point_force(&self.nodes, &self.weights, self.force, &mut force);
        force
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// How a push follows time: linear between rows of (step, factor), 0 before the first and from the last on.
#[derive(Clone, Copy, Debug)]
pub struct Loading {
    /// Its name in the table.
    pub name: &'static str,
    /// The rows.
    rows: &'static [(usize, f64)],
}

/// The four ways in which a push acts. A ramp takes a tenth of the first period.
pub const HISTORIES: [Loading; 4] = [
    Loading { name: "jump, released", rows: &[(0, 1.0), (40, 1.0)] },
    Loading { name: "ramps, released", rows: &[(0, 0.0), (4, 1.0), (36, 1.0), (40, 0.0)] },
    Loading { name: "jump, held", rows: &[(0, 1.0), (STEPS + 1, 1.0)] },
    Loading { name: "ramp, held", rows: &[(0, 0.0), (4, 1.0), (STEPS + 1, 1.0)] },
];

impl Loading {
    /// As the builder and the reference take it.
    ///
    /// # Panics
    /// If the rows are none of a table.
    #[must_use]
    pub fn history(&self, time_step: f64) -> History {
        let times = self.rows.iter().map(|row| row.0 as f64 * time_step).collect();
        let values = self.rows.iter().map(|row| row.1).collect();
        let table = LoadTable::new(times, values).expect("a table");
        let during = Interval { start: 0.0, end: f64::MAX, ramp: 0.0 };
        History { during, share: None, course: Course::Table(Arc::new(table), 0) }
    }

    /// A force that follows it, on trajectory `column`.
    #[must_use]
    pub fn timed(&self, column: usize, force: &[f64], time_step: f64) -> TimedLoad {
        TimedLoad { column, force: force.to_vec(), when: self.history(time_step) }
    }

    /// The bound at each instant as a multiple of `‖RF‖`: the sum of the jumps so far, and of the ramps, each
    /// of which counts no more than `2/ωτ` for each unit that it rises in the time `τ`. `angle` is `ωΔt` of
    /// the lowest mode that may be missing.
    #[must_use]
    pub fn variation(&self, angle: f64) -> Vec<f64> {
        let (first, last) = (self.rows[0], self.rows[self.rows.len() - 1]);
        let jump = |(step, size): (usize, f64), instant: usize| if instant > step { size.abs() } else { 0.0 };
        let ramp = |rows: &[(usize, f64)], instant: usize| {
            let [(from, before), (to, after)] = [rows[0], rows[1]];
            let (steps, rise) = ((to - from) as f64, (after - before).abs());
            let done = (instant.clamp(from, to) - from) as f64 / steps;
            rise * done.min(2.0 / (angle * steps))
        };
        (0..=STEPS)
            .map(|n| {
                jump(first, n) + jump(last, n) + self.rows.windows(2).map(|rows| ramp(rows, n)).sum::<f64>()
            })
            .collect()
    }
}
