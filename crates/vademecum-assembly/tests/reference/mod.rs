//! Bodies at full order with lumped masses, explicit in time, under the same contact law: gaps of nodes over
//! triangles that are not below zero at the end of a step, and Coulomb's friction.

use std::path::PathBuf;

use faer::Mat;
use faer::linalg::solvers::Solve;
use vademecum_build::input::Problem;
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};

/// Vectors of all nodes.
type Field = [[f64; 3]];

/// Forces on nodes, of the time and the displacements.
type Pushes<'f> = &'f dyn Fn(f64, &Field) -> Vec<(usize, [f64; 3])>;

/// A body of linear tetrahedra.
pub struct FullBody {
    prepared: Prepared,
    /// Lumped mass of each node \[kg\].
    mass: Vec<f64>,
    /// Places of the nodes at rest \[m\].
    pub nodes: Vec<[f64; 3]>,
    free: Vec<Option<u32>>,
}

impl FullBody {
    pub fn new(text: &str) -> Self {
        let problem = Problem::parse(text, "whole.toml", PathBuf::new()).expect("a problem");
        let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model");
        let model = &prepared.body.model;
        let nodes = model.mesh().nodes.clone();
        let free: Vec<Option<u32>> = (0..3 * nodes.len()).map(|dof| model.dofs().free(dof)).collect();
        // Tetrahedra of one density: a quarter of each cell's mass at each of its nodes.
        let mut mass = vec![0.0; nodes.len()];
        let density = 1000.0;
        for cell in model.mesh().elements.chunks(4) {
            let at = |k: usize| nodes[cell[k] as usize];
            let edge = |k: usize| -> [f64; 3] { std::array::from_fn(|c| at(k)[c] - at(0)[c]) };
            let [a, b, c] = [edge(1), edge(2), edge(3)];
            let volume = (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                + a[2] * (b[0] * c[1] - b[1] * c[0]))
                / 6.0;
            cell.iter().for_each(|&node| mass[node as usize] += density * volume.abs() / 4.0);
        }
        Self { mass, nodes, free, prepared }
    }

    /// Number of the node at a place.
    pub fn on(&self, holds: impl Fn([f64; 3]) -> bool) -> Vec<usize> {
        (0..self.nodes.len()).filter(|&node| holds(self.nodes[node])).collect()
    }

    /// `−K u` at every node.
    fn forces(&self, u: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let stiffness = self.prepared.body.model.pencil().stiffness();
        let n = self.prepared.body.model.pencil().n_dof();
        let mut x = Mat::zeros(n, 1);
        for (dof, free) in self.free.iter().enumerate() {
            if let Some(free) = free {
                x[(*free as usize, 0)] = u[dof / 3][dof % 3];
            }
        }
        let mut y = Mat::zeros(n, 1);
        stiffness.mul_into(x.as_ref(), y.as_mut());
        let mut forces = vec![[0.0; 3]; self.nodes.len()];
        for (dof, free) in self.free.iter().enumerate() {
            if let Some(free) = free {
                forces[dof / 3][dof % 3] = -y[(*free as usize, 0)];
            }
        }
        forces
    }

    /// Rows of the first port over the nodes: node, component and weight.
    fn port_rows(&self) -> Vec<Vec<(usize, f64)>> {
        let dof_of_free = self.prepared.body.model.dofs().dof_of_free();
        let row = |row: &Vec<(u32, f64)>| {
            row.iter().map(|&(free, weight)| (dof_of_free[free as usize] as usize, weight)).collect()
        };
        self.prepared.body.ports.first().map_or(vec![], |port| port.rows.iter().map(row).collect())
    }

    /// Displacements of a node of a free body every `every` seconds, under gravity along z and `force` of the
    /// time on nodes that have moved by `u`. `held` rows of its first port keep the value zero.
    pub fn march(
        &self,
        (time, every): (f64, f64),
        gravity: f64,
        node: usize,
        held: &[usize],
        force: Pushes<'_>,
    ) -> Vec<[f64; 3]> {
        let (dt, n) = (2e-5, self.nodes.len());
        let (mut u, mut v) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
        let rows = self.port_rows();
        let rows: Vec<&Vec<(usize, f64)>> = held.iter().map(|&row| &rows[row]).collect();
        let weight = |a: &Vec<(usize, f64)>, b: &Vec<(usize, f64)>| -> f64 {
            let of = |dof: usize| b.iter().filter(|entry| entry.0 == dof).map(|entry| entry.1).sum::<f64>();
            a.iter().map(|&(dof, weight)| weight * of(dof) / self.mass[dof / 3]).sum()
        };
        let yields = Mat::from_fn(rows.len(), rows.len(), |i, j| weight(rows[i], rows[j]));
        let factor = (!rows.is_empty()).then(|| yields.llt(faer::Side::Lower).expect("rows that hold"));
        let (steps, each) = ((time / dt).round() as usize, (every / dt).round() as usize);
        let mut found = vec![];
        for step in 0..steps {
            let own = self.forces(&u);
            for node in 0..n {
                (0..3).for_each(|c| v[node][c] += dt * own[node][c] / self.mass[node]);
                v[node][2] += dt * gravity;
            }
            for (node, f) in force((step as f64 + 0.5) * dt, &u) {
                (0..3).for_each(|c| v[node][c] += dt * f[c] / self.mass[node]);
            }
            if let Some(factor) = &factor {
                // Displacements of the rows at the end of the step are zero.
                let value = |row: &Vec<(usize, f64)>| -> f64 {
                    row.iter().map(|&(dof, w)| w * (u[dof / 3][dof % 3] / dt + v[dof / 3][dof % 3])).sum()
                };
                let values = Mat::from_fn(rows.len(), 1, |i, _| value(rows[i]));
                let impulses = factor.solve(&values);
                for (i, row) in rows.iter().enumerate() {
                    row.iter().for_each(|&(dof, w)| {
                        v[dof / 3][dof % 3] -= w * impulses[(i, 0)] / self.mass[dof / 3]
                    });
                }
            }
            u.iter_mut().zip(&v).for_each(|(u, v)| (0..3).for_each(|c| u[c] += dt * v[c]));
            if (step + 1) % each == 0 {
                found.push(u[node]);
            }
        }
        found
    }

    fn is_held(&self, node: usize) -> bool {
        self.free[3 * node].is_none()
    }

    /// Total and largest nodal force of the upper face pressed to a depth by a plate, or by a sphere of a
    /// radius, without friction: the complementarity problem of the compliance at the face.
    pub fn pressed(&self, depth: f64, radius: Option<f64>) -> [f64; 2] {
        let top = self.on(|x| (x[2] - 0.08).abs() < 1e-9);
        let n = self.prepared.body.model.pencil().n_dof();
        let stiffness = self.prepared.body.model.pencil().stiffness();
        let mut whole = Mat::<f64>::zeros(n, n);
        let mut unit = Mat::zeros(n, n);
        (0..n).for_each(|k| unit[(k, k)] = 1.0);
        stiffness.mul_into(unit.as_ref(), whole.as_mut());
        let factor = whole.llt(faer::Side::Lower).expect("a positive matrix");
        let dof = |node: usize| self.free[3 * node + 2].expect("a free node") as usize;
        let mut loads = Mat::zeros(n, top.len());
        top.iter().enumerate().for_each(|(k, &node)| loads[(dof(node), k)] = 1.0);
        let answers = factor.solve(&loads);
        let compliance = Mat::from_fn(top.len(), top.len(), |i, j| answers[(dof(top[i]), j)]);
        // Height of the tool over each node.
        let gap: Vec<f64> = top
            .iter()
            .map(|&node| {
                let [x, y] = [0, 1].map(|c| self.nodes[node][c] - 0.04);
                let lift = radius.map_or(0.0, |r| r - (r * r - x * x - y * y).sqrt());
                lift - depth
            })
            .collect();
        let mut forces = vec![0.0_f64; top.len()];
        for _ in 0..20_000 {
            let mut change = 0.0_f64;
            for i in 0..top.len() {
                let sunk: f64 = (0..top.len()).map(|j| compliance[(i, j)] * forces[j]).sum();
                let next = (forces[i] - (gap[i] + sunk) / compliance[(i, i)]).max(0.0);
                change = change.max((next - forces[i]).abs());
                forces[i] = next;
            }
            if change < 1e-10 {
                break;
            }
        }
        [forces.iter().sum(), forces.iter().copied().fold(0.0, f64::max)]
    }
}

/// A cube over a base.
pub struct Pair<'b> {
    bodies: &'b [FullBody; 2],
    /// Nodes of the cube that touch, in its lowest face.
    nodes: Vec<usize>,
    /// Triangles of the upper face of the base.
    top: Vec<[usize; 3]>,
    /// Step \[s\].
    step: f64,
}

/// Results of a drop.
#[derive(Debug)]
pub struct Rebound {
    pub restitution: f64,
    pub peak: f64,
}

/// A node over a triangle, and its force.
struct Contact {
    node: usize,
    on: [usize; 3],
    weights: [f64; 3],
    force: [f64; 3],
}

impl<'b> Pair<'b> {
    pub fn new(bodies: &'b [FullBody; 2]) -> Self {
        let nodes = bodies[0].on(|x| x[2].abs() < 1e-9);
        Self { bodies, nodes, top: bodies[1].top(), step: 2e-5 }
    }

    /// The drop of `dropped`; angles are small, so the tilt is a displacement of the nodes.
    pub fn drop(&self, tilt: f64) -> Rebound {
        let cube = &self.bodies[0];
        let angle = f64::atan(tilt);
        let (sin, cos) = angle.sin_cos();
        let height = 0.08 + 0.04 * (1.0 + tilt) / (1.0 + tilt * tilt).sqrt() + 0.001;
        // Turned about y, placed over the middle of the base.
        let turn = |x: [f64; 3]| [cos * x[0] + sin * x[2], x[1], cos * x[2] - sin * x[0]];
        let place = |x: [f64; 3]| {
            let moved = turn([x[0] - 0.04, x[1] - 0.04, x[2] - 0.04]);
            [moved[0] + 0.08, moved[1] + 0.08, moved[2] + height]
        };
        let start: Vec<[f64; 3]> = cube.nodes.iter().map(|&x| place(x)).collect();
        let back = |f: [f64; 3]| [cos * f[0] - sin * f[2], f[1], sin * f[0] + cos * f[2]];
        let rest = &self.bodies[1].nodes;
        let (mut u, mut w) = (vec![[0.0; 3]; start.len()], vec![[0.0; 3]; rest.len()]);
        let (mut v, mut s) = (vec![[0.0, 0.0, -0.5]; start.len()], vec![[0.0; 3]; rest.len()]);
        let mut peak = 0.0_f64;
        let dt = self.step;
        for _ in 0..(0.05 / dt) as usize {
            // Elastic forces of the cube in the directions it is turned to: the whole turns by what is left.
            let own: Vec<[f64; 3]> = self.elastic(&start, &u, &turn, &back);
            let other = self.bodies[1].forces(&w);
            for (node, f) in own.iter().enumerate() {
                (0..3).for_each(|c| v[node][c] += dt * f[c] / cube.mass[node]);
            }
            for (node, f) in other.iter().enumerate().filter(|&(node, _)| !self.bodies[1].is_held(node)) {
                (0..3).for_each(|c| s[node][c] += dt * f[c] / self.bodies[1].mass[node]);
            }
            let mut contacts = self.find(&start, &u, &v, &w, &s);
            self.solve(&mut contacts, (&start, &u, &mut v), (rest, &w, &mut s), 0.0);
            peak = peak.max(contacts.iter().map(|contact| contact.force[2]).sum());
            u.iter_mut().zip(&v).for_each(|(u, v)| (0..3).for_each(|c| u[c] += dt * v[c]));
            w.iter_mut().zip(&s).for_each(|(w, s)| (0..3).for_each(|c| w[c] += dt * s[c]));
        }
        let total: f64 = cube.mass.iter().sum();
        let momentum: f64 = v.iter().zip(&cube.mass).map(|(v, m)| v[2] * m).sum();
        Rebound { restitution: momentum / total / 0.5, peak }
    }

    /// Mean displacement along x of the lowest face of a cube that lies on the base, every `every` seconds:
    /// it is pressed and pushed on its upper face by `force` of the time, damped by `beta` times the
    /// stiffness.
    pub fn slide(
        &self,
        time: f64,
        every: f64,
        friction: f64,
        beta: f64,
        force: &dyn Fn(f64) -> [f64; 3],
    ) -> Vec<f64> {
        let cube = &self.bodies[0];
        let start: Vec<[f64; 3]> =
            cube.nodes.iter().map(|x| [x[0] + 0.04, x[1] + 0.04, x[2] + 0.08]).collect();
        let top = cube.on(|x| (x[2] - 0.08).abs() < 1e-9);
        let rest = &self.bodies[1].nodes;
        let (mut u, mut w) = (vec![[0.0; 3]; start.len()], vec![[0.0; 3]; rest.len()]);
        let (mut v, mut s) = (u.clone(), w.clone());
        let damped = |u: &[[f64; 3]], v: &[[f64; 3]]| -> Vec<[f64; 3]> {
            u.iter().zip(v).map(|(u, v)| std::array::from_fn(|c| u[c] + beta * v[c])).collect()
        };
        let dt = self.step;
        let (steps, each) = ((time / dt).round() as usize, (every / dt).round() as usize);
        let mut found = vec![];
        for step in 0..steps {
            let own = cube.forces(&damped(&u, &v));
            let other = self.bodies[1].forces(&damped(&w, &s));
            for (node, f) in own.iter().enumerate() {
                (0..3).for_each(|c| v[node][c] += dt * f[c] / cube.mass[node]);
            }
            let pushed = force((step as f64 + 0.5) * dt).map(|f| f / top.len() as f64);
            for &node in &top {
                (0..3).for_each(|c| v[node][c] += dt * pushed[c] / cube.mass[node]);
            }
            for (node, f) in other.iter().enumerate().filter(|&(node, _)| !self.bodies[1].is_held(node)) {
                (0..3).for_each(|c| s[node][c] += dt * f[c] / self.bodies[1].mass[node]);
            }
            let mut contacts = self.find(&start, &u, &v, &w, &s);
            self.solve(&mut contacts, (&start, &u, &mut v), (rest, &w, &mut s), friction);
            u.iter_mut().zip(&v).for_each(|(u, v)| (0..3).for_each(|c| u[c] += dt * v[c]));
            w.iter_mut().zip(&s).for_each(|(w, s)| (0..3).for_each(|c| w[c] += dt * s[c]));
            if (step + 1) % each == 0 {
                found.push(self.nodes.iter().map(|&node| u[node][0]).sum::<f64>() / self.nodes.len() as f64);
            }
        }
        found
    }

    /// Elastic forces of a cube that turns: of the displacements against the rigid motion nearest to it,
    /// which is found by the means of the positions and of their turns about y.
    fn elastic(
        &self,
        start: &[[f64; 3]],
        u: &[[f64; 3]],
        turn: &dyn Fn([f64; 3]) -> [f64; 3],
        back: &dyn Fn([f64; 3]) -> [f64; 3],
    ) -> Vec<[f64; 3]> {
        let cube = &self.bodies[0];
        let total: f64 = cube.mass.iter().sum();
        let mean = |f: &dyn Fn(usize) -> [f64; 3]| -> [f64; 3] {
            let mut sum = [0.0; 3];
            for node in 0..start.len() {
                (0..3).for_each(|c| sum[c] += cube.mass[node] * f(node)[c] / total);
            }
            sum
        };
        let centre = mean(&|node| start[node]);
        let shift = mean(&|node| u[node]);
        // The rotation about y that fits best, beyond the tilt it started with.
        let (mut along, mut across) = (0.0, 0.0);
        for node in 0..start.len() {
            let m = cube.mass[node];
            let a: [f64; 3] = std::array::from_fn(|c| start[node][c] - centre[c]);
            let b: [f64; 3] = std::array::from_fn(|c| a[c] + u[node][c] - shift[c]);
            along += m * (a[0] * b[0] + a[2] * b[2]);
            across += m * (a[2] * b[0] - a[0] * b[2]);
        }
        let (sin, cos) = across.atan2(along).sin_cos();
        let more = |x: [f64; 3]| [cos * x[0] + sin * x[2], x[1], cos * x[2] - sin * x[0]];
        let less = |x: [f64; 3]| [cos * x[0] - sin * x[2], x[1], sin * x[0] + cos * x[2]];
        let displacements: Vec<[f64; 3]> = (0..start.len())
            .map(|node| {
                let a: [f64; 3] = std::array::from_fn(|c| start[node][c] - centre[c]);
                let turned = more(a);
                back(less(std::array::from_fn(|c| a[c] + u[node][c] - shift[c] - turned[c])))
            })
            .collect();
        cube.forces(&displacements).into_iter().map(|f| more(turn(f))).collect()
    }

    /// Nodes of the cube over triangles of the base, as they will be at the end of the step.
    fn find(
        &self,
        start: &[[f64; 3]],
        u: &[[f64; 3]],
        v: &[[f64; 3]],
        w: &[[f64; 3]],
        s: &[[f64; 3]],
    ) -> Vec<Contact> {
        let dt = self.step;
        let rest = &self.bodies[1].nodes;
        let mut contacts = vec![];
        for &node in &self.nodes {
            let at: [f64; 3] = std::array::from_fn(|c| start[node][c] + u[node][c] + dt * v[node][c]);
            for &on in &self.top {
                let [a, b, c] =
                    on.map(|k| -> [f64; 3] { std::array::from_fn(|i| rest[k][i] + w[k][i] + dt * s[k][i]) });
                // Weights of the point below, in the plane.
                let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                let second = ((at[0] - a[0]) * (c[1] - a[1]) - (at[1] - a[1]) * (c[0] - a[0])) / area;
                let third = ((b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0])) / area;
                let weights = [1.0 - second - third, second, third];
                if weights.iter().all(|&weight| weight > -1e-9) {
                    let below: f64 = (0..3).map(|k| weights[k] * [a, b, c][k][2]).sum();
                    if at[2] - below < 1e-3 {
                        contacts.push(Contact { node, on, weights, force: [0.0; 3] });
                    }
                    break;
                }
            }
        }
        contacts
    }

    /// Forces of the contacts, added to the velocities. Normals are those of the plane at rest.
    fn solve(
        &self,
        contacts: &mut [Contact],
        (start, u, v): (&Field, &Field, &mut Field),
        (rest, w, s): (&Field, &Field, &mut Field),
        friction: f64,
    ) {
        let dt = self.step;
        let masses = [&self.bodies[0].mass, &self.bodies[1].mass];
        for _ in 0..200 {
            let mut change = 0.0_f64;
            for contact in &mut *contacts {
                let speed = |c: usize| -> f64 {
                    v[contact.node][c] - (0..3).map(|k| contact.weights[k] * s[contact.on[k]][c]).sum::<f64>()
                };
                let slips = [speed(0), speed(1), speed(2)];
                let below: f64 =
                    (0..3).map(|k| contact.weights[k] * (rest[contact.on[k]][2] + w[contact.on[k]][2])).sum();
                let gap = start[contact.node][2] + u[contact.node][2] - below + dt * slips[2];
                let yields = 1.0 / masses[0][contact.node]
                    + (0..3).map(|k| contact.weights[k].powi(2) / masses[1][contact.on[k]]).sum::<f64>();
                let mut next = contact.force;
                next[2] = (contact.force[2] - gap / (dt * dt * yields)).max(0.0);
                (0..2).for_each(|c| next[c] -= slips[c] / (dt * yields));
                let size = next[0].hypot(next[1]);
                let scale = if size > friction * next[2] { friction * next[2] / size } else { 1.0 };
                (0..2).for_each(|c| next[c] *= if size > 0.0 { scale } else { 0.0 });
                for c in 0..3 {
                    let more = dt * (next[c] - contact.force[c]);
                    change = change.max(more.abs() * yields);
                    v[contact.node][c] += more / masses[0][contact.node];
                    for k in 0..3 {
                        s[contact.on[k]][c] -= contact.weights[k] * more / masses[1][contact.on[k]];
                    }
                }
                contact.force = next;
            }
            if change < 1e-9 {
                break;
            }
        }
    }
}

impl FullBody {
    /// Triangles of the face at the top: those of cells with three nodes there.
    fn top(&self) -> Vec<[usize; 3]> {
        let cells = self.prepared.body.model.mesh().elements.chunks(4);
        let up = |node: &usize| (self.nodes[*node][2] - 0.08).abs() < 1e-9;
        let faces = cells.filter_map(|cell| {
            let nodes: Vec<usize> = cell.iter().map(|&node| node as usize).filter(up).collect();
            <[usize; 3]>::try_from(nodes).ok()
        });
        faces.collect()
    }
}
