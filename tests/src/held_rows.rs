//! A full order that keeps the rows of held displacements: what supports exert, worked out from the matrices.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use vademecum_build::export::NodeOrder;
use vademecum_build::fem::Model;
use vademecum_build::input::Problem;
use vademecum_build::prepared::{Body, read_mesh};
use vademecum_eval::{Contact, SceneOptions};

/// The full order with the rows of held dofs: columns are free dofs.
pub struct Full {
    /// The body.
    pub body: Body,
    /// Its nodes in the order of files.
    pub order: NodeOrder,
    /// Mass: rows are all dofs.
    pub mass: Mat<f64>,
    /// Stiffness: rows are all dofs.
    pub stiffness: Mat<f64>,
    /// All natural modes, mass-orthonormal, and their eigenvalues.
    pub modes: Mat<f64>,
    /// Of the modes \[1/s²\].
    pub eigenvalues: Vec<f64>,
}

impl Full {
    /// Of a small problem.
    ///
    /// # Panics
    /// If it cannot be made, or has no element far from its supports.
    #[must_use]
    pub fn of(problem: &Problem) -> Self {
        let mesh = read_mesh(problem).expect("a mesh");
        let body = Body::build(problem, mesh.clone(), None).expect("a body");
        let order = NodeOrder::new(&body);
        let dofs = body.model.dofs();
        let (all, n) = (dofs.n_dof(), dofs.n_free());
        // The same body held somewhere else has the rows that the supports of this one take away: at an
        // element none of whose neighbours is held here.
        let held = |node: u32| (0..3).any(|c| dofs.free(3 * node as usize + c).is_none());
        let per = mesh.order().nodes_per_element();
        let near = |node: u32| {
            let mut around = mesh.elements.chunks_exact(per).filter(|element| element.contains(&node));
            around.any(|element| element.iter().any(|&other| held(other)))
        };
        let mut elements = mesh.elements.chunks_exact(per);
        let elsewhere = elements.find(|element| !element.iter().any(|&node| near(node)));
        let elsewhere = elsewhere.expect("an element far from the supports").to_vec();
        let constrained: Vec<bool> = (0..all as u32).map(|dof| elsewhere.contains(&(dof / 3))).collect();
        let other = Model::assemble(mesh.clone(), body.model.materials(), &constrained).expect("held");
        let rows = |pick: fn(&Model) -> &vademecum_build::fem::SymmetricMatrix| {
            let mut dense = Mat::<f64>::zeros(all, n);
            for (model, own) in [(&body.model, true), (&other, false)] {
                let (matrix, map) = (pick(model), model.dofs());
                for column in 0..matrix.n() {
                    let dof = map.dof_of_free()[column] as usize;
                    let Some(free) = dofs.free(dof) else { continue };
                    let values = &matrix.values()[matrix.pattern().range(column)];
                    for (&row, &value) in matrix.pattern().rows_of(column).iter().zip(values) {
                        let row = map.dof_of_free()[row as usize] as usize;
                        if own || dofs.free(row).is_none() {
                            dense[(row, free as usize)] = value;
                        }
                    }
                }
            }
            dense
        };
        let mass = rows(|model| model.pencil().mass());
        let stiffness = rows(|model| model.pencil().stiffness());
        let square = |full: &Mat<f64>| Mat::from_fn(n, n, |i, j| full[(dofs.dof_of_free()[i] as usize, j)]);
        let lower = square(&mass).llt(Side::Lower).expect("a mass").L().to_owned();
        let inverse = lower.partial_piv_lu().solve(Mat::<f64>::identity(n, n));
        let symmetric = &inverse * square(&stiffness) * inverse.transpose();
        let found = symmetric.self_adjoint_eigen(Side::Lower).expect("modes");
        let modes = inverse.transpose() * found.U();
        let eigenvalues = (0..n).map(|k| found.S()[k]).collect();
        Self { body, order, mass, stiffness, modes, eigenvalues }
    }

    /// A contact of the file as a load on all dofs.
    #[must_use]
    pub fn contact(&self, contact: &Contact) -> Vec<f64> {
        let mut load = vec![0.0; self.body.model.dofs().n_dof()];
        for (node, weight) in contact.place.entries() {
            for (c, force) in contact.force.iter().enumerate() {
                load[3 * self.order.nodes[node as usize] as usize + c] += weight * force;
            }
        }
        load
    }

    /// A load on all dofs, on the modes.
    #[must_use]
    pub fn on_modes(&self, load: &[f64]) -> Vec<f64> {
        let free = self.body.model.free_part(load);
        let n = free.len();
        (0..n).map(|k| (0..n).map(|i| self.modes[(i, k)] * free[i]).sum()).collect()
    }

    /// What support `s` exerts when modes have these displacements, velocities and accelerations.
    #[must_use]
    pub fn reaction(&self, s: usize, model: &Scaled, motion: &[[f64; 3]], load: &[f64]) -> [f64; 6] {
        let n = self.eigenvalues.len();
        let elastic = |k: usize| {
            let [z, v, _] = motion[k];
            let internal = 2.0 * model.ratio / (model.lambda(self.eigenvalues[k])).sqrt();
            model.stiffness * (z + (model.beta + internal) * v)
        };
        let heavy = |k: usize| model.density * (motion[k][2] + model.alpha * motion[k][1]);
        let field = |of_mode: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..n).map(|i| (0..n).map(|k| self.modes[(i, k)] * of_mode(k)).sum()).collect()
        };
        let (strained, moved) = (field(&elastic), field(&heavy));
        let support = &self.body.supports[s];
        let mut sum = [0.0; 6];
        for &dof in &support.dofs {
            let row =
                |matrix: &Mat<f64>, x: &[f64]| (0..n).map(|j| matrix[(dof as usize, j)] * x[j]).sum::<f64>();
            let force = row(&self.stiffness, &strained) + row(&self.mass, &moved) - load[dof as usize];
            add_at(
                &mut sum,
                self.body.model.mesh().nodes[dof as usize / 3],
                support.point,
                dof as usize % 3,
                force,
            );
        }
        sum
    }
}

/// Adds a force along an axis at `x` to a force and a moment about `point`.
pub fn add_at(sum: &mut [f64; 6], x: [f64; 3], point: [f64; 3], axis: usize, force: f64) {
    let arm: [f64; 3] = std::array::from_fn(|c| x[c] - point[c]);
    sum[axis] += force;
    let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
    // r × f e_axis: component a has r_b f, component b has −r_a f.
    sum[3 + a] += arm[b] * force;
    sum[3 + b] -= arm[a] * force;
}

/// Live parameters of a march.
#[derive(Clone, Copy)]
pub struct Scaled {
    /// Scale of the stiffness.
    pub stiffness: f64,
    /// Scale of the density.
    pub density: f64,
    /// Rayleigh's.
    pub alpha: f64,
    /// Rayleigh's.
    pub beta: f64,
    /// Damping ratio of every mode.
    pub ratio: f64,
}

impl Scaled {
    /// Without damping.
    pub const AS_BUILT: Self = Self { stiffness: 1.0, density: 1.0, alpha: 0.0, beta: 0.0, ratio: 0.0 };

    #[must_use]
    /// Of a mode.
    pub fn lambda(&self, eigenvalue: f64) -> f64 {
        self.stiffness * eigenvalue / self.density
    }

    #[must_use]
    /// For a scene.
    pub fn options(&self) -> SceneOptions {
        SceneOptions {
            stiffness: self.stiffness,
            density: self.density,
            alpha: Some(self.alpha),
            beta: Some(self.beta),
            ..SceneOptions::default()
        }
    }

    /// A mode after `t` seconds under a constant load, in closed form.
    #[must_use]
    pub fn after(&self, eigenvalue: f64, force: f64, [z, v, _]: [f64; 3], t: f64) -> [f64; 3] {
        let (lambda, f) = (self.lambda(eigenvalue), force / self.density);
        let s = 0.5 * (self.alpha + self.beta * lambda) + self.ratio * lambda.sqrt();
        let (rest, d) = (f / lambda, lambda - s * s);
        let w = d.abs().sqrt();
        // In parts that do not leave the range of a double.
        let (cosine, sine) = if d > 0.0 {
            ((-s * t).exp() * (w * t).cos(), (-s * t).exp() * (w * t).sin() / w)
        } else {
            let [slow, fast] = [((w - s) * t).exp(), ((-w - s) * t).exp()];
            (0.5 * (slow + fast), 0.5 * (slow - fast) / w)
        };
        let off = z - rest;
        let moved = rest + off * cosine + (v + s * off) * sine;
        let speed = v * cosine - (lambda * off + s * v) * sine;
        [moved, speed, f - 2.0 * s * speed - lambda * moved]
    }
}
