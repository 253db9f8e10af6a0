//! The six rigid motions of a body without supports, and what they do to its stiffness.
//!
//! `K` does not answer a force that moves the whole body. What is left of a force `F` once the inertia of the
//! body at its rigid acceleration stands against it is `P F`, with `P = I − MΦΦᵀ` and `Φ` the six rigid
//! motions, orthonormal in the mass. The answer to that which moves no mass as a whole is (inertia relief)
//!
//! ```text
//! K⁺ = Pᵀ Kₛ⁻¹ P        Kₛ = K + Σ_i s_i e_i e_iᵀ
//! ```
//!
//! `Kₛ` holds the body by springs at six dofs that fix it and nothing more. No force of `P F` goes into them
//! (six forces that are in equilibrium at such dofs are zero), so the answer depends neither on their place
//! nor on their stiffness, and the pattern of `K` stays what it is.
//!
//! With attachments the same holds of the eliminated `TᵀMT` and `TᵀKT`: constraints that a rigid motion
//! fulfils leave it a motion of the free dofs, among them displacements and rotations of reference points.

use faer::{Mat, MatMut, MatRef, Side};

use super::coupling::rigid_row;
use super::sparse::SymmetricMatrix;
use crate::linalg::vec3::{cross, sub};
use crate::linalg::{subtract_product, transposed_product};

/// Mass, place and moments of inertia of a body without supports, and its rigid motions.
#[derive(Clone, Debug)]
#[doc(alias("inertia relief", "floating frame of reference"))]
pub struct RigidBody {
    /// Mass \[kg\].
    pub mass: f64,
    /// Its centre \[m\].
    pub centre: [f64; 3],
    /// Moments of inertia about the centre \[kg m²\]: xx, xy, xz, yy, yz, zz.
    pub inertia: [f64; 6],
    /// `Φ`, shape (n, 6).
    motions: Mat<f64>,
    /// `MΦ`, shape (n, 6).
    momenta: Mat<f64>,
    /// Dofs of the six springs.
    pins: [usize; 6],
    /// Shifts along the axes of space and turns about the centre, shape (n, 6), where dofs depend on others
    /// or belong to reference points.
    turns: Option<Mat<f64>>,
    /// Places of the reference points.
    points: Vec<[f64; 3]>,
}

impl RigidBody {
    /// The rigid motions of a body all of whose dofs are free: `3 · node + component` is the row of a
    /// component of a node.
    ///
    /// # Panics
    /// If there are not three rows per node, or the nodes lie on a line.
    pub(crate) fn new(nodes: &[[f64; 3]], mass: &SymmetricMatrix) -> RigidBody {
        let n = 3 * nodes.len();
        assert_eq!(mass.n(), n, "every dof of a free body is free");
        let push = field(nodes, |_| [1.0, 0.0, 0.0]);
        let weights = times(mass, push.as_ref());
        let weight = |k: usize| weights[(3 * k, 0)];
        let total: f64 = (0..nodes.len()).map(weight).sum();
        let centre: [f64; 3] =
            std::array::from_fn(|c| (0..nodes.len()).map(|k| weight(k) * nodes[k][c]).sum::<f64>() / total);
        let turn = |axis: [f64; 3]| field(nodes, |x| cross(axis, std::array::from_fn(|c| x[c] - centre[c])));
        let turns: Vec<Mat<f64>> = UNITS.map(turn).into();
        let inner = |i: usize, j: usize| mass.inner(turns[i].col_as_slice(0), turns[j].col_as_slice(0));
        let inertia = [inner(0, 0), inner(0, 1), inner(0, 2), inner(1, 1), inner(1, 2), inner(2, 2)];
        // About the principal axes the motions of a slender body are far from each other.
        let mut motions = Mat::zeros(n, 6);
        for (c, axis) in UNITS.into_iter().enumerate() {
            motions.col_mut(c).copy_from(field(nodes, |_| axis).col(0));
        }
        for (c, axis) in principal_axes(&inertia).into_iter().enumerate() {
            motions.col_mut(3 + c).copy_from(turn(axis).col(0));
        }
        for _ in 0..2 {
            orthonormalise(mass, &mut motions);
        }
        let momenta = times(mass, motions.as_ref());
        let pins = pins(motions.as_ref(), |_| 1.0);
        let (turns, points) = (None, vec![]);
        RigidBody { mass: total, centre, inertia, motions, momenta, pins, turns, points }
    }

    /// The rigid motions of a body with attachments, over free dofs from which all others follow: `rows`
    /// gives them under three shifts along the axes of space and three turns about a point. Springs are at
    /// `solid` dofs if these fix the body.
    pub(crate) fn of_rows(
        mass: &SymmetricMatrix,
        rows: impl Fn([f64; 3]) -> Vec<[f64; 6]>,
        solid: impl Fn(usize) -> bool,
        points: Vec<[f64; 3]>,
    ) -> RigidBody {
        let n = mass.n();
        let about = |point: [f64; 3]| {
            let rows = rows(point);
            Mat::from_fn(n, 6, |i, k| rows[i][k])
        };
        let gram = |columns: &Mat<f64>| columns.transpose() * times(mass, columns.as_ref());
        // A shift along e_i and a turn about e_j share m e_i · (e_j × (c − o)). From the second point on, the
        // arms are those of the body.
        let (mut total, mut centre) = (0.0, [0.0; 3]);
        for _ in 0..2 {
            let shares = gram(&about(centre));
            total = (0..3).map(|c| shares[(c, c)]).sum::<f64>() / 3.0;
            let arm = |c: usize| {
                let (next, last) = ((c + 1) % 3, (c + 2) % 3);
                0.5 * (shares[(next, 3 + last)] - shares[(last, 3 + next)]) / total
            };
            centre = std::array::from_fn(|c| centre[c] + arm(c));
        }
        let turns = about(centre);
        let shares = gram(&turns);
        let inner = |i: usize, j: usize| shares[(3 + i, 3 + j)];
        let inertia = [inner(0, 0), inner(0, 1), inner(0, 2), inner(1, 1), inner(1, 2), inner(2, 2)];
        let axes = principal_axes(&inertia);
        let along = |i: usize, axis: [f64; 3]| (0..3).map(|c| axis[c] * turns[(i, 3 + c)]).sum::<f64>();
        let mut motions =
            Mat::from_fn(n, 6, |i, k| if k < 3 { turns[(i, k)] } else { along(i, axes[k - 3]) });
        for _ in 0..2 {
            orthonormalise(mass, &mut motions);
        }
        let momenta = times(mass, motions.as_ref());
        // Rotations have another unit, and reference points may be on a soft spring.
        let pins = pins(motions.as_ref(), |i| if solid(i) { 1.0 } else { LAST });
        RigidBody { mass: total, centre, inertia, motions, momenta, pins, turns: Some(turns), points }
    }

    /// The same with springs at other dofs.
    #[cfg(test)]
    pub(crate) fn with_pins(self, pins: [usize; 6]) -> RigidBody {
        RigidBody { pins, ..self }
    }

    /// `Φ`, shape (n, 6).
    pub fn motions(&self) -> MatRef<'_, f64> {
        self.motions.as_ref()
    }

    /// `MΦ`, shape (n, 6).
    pub fn momenta(&self) -> MatRef<'_, f64> {
        self.momenta.as_ref()
    }

    /// The dofs of the six springs of `Kₛ`; each is as stiff as its dof is.
    pub fn pins(&self) -> [usize; 6] {
        self.pins
    }

    /// `Kₛ`: the stiffness with six springs, each as stiff as its dof is.
    pub(crate) fn held(&self, stiffness: &SymmetricMatrix) -> SymmetricMatrix {
        stiffness.with_springs(&self.pins.map(|dof| (dof, stiffness.diagonal(dof))))
    }

    /// `F ← P F`: takes off the forces `F`, shape (n, c), what accelerates the whole body.
    pub(crate) fn relieve(&self, forces: MatMut<'_, f64>) {
        let shares = transposed_product(self.motions(), forces.as_ref());
        subtract_product(forces, self.momenta(), shares.as_ref());
    }

    /// `u ← Pᵀ u`: takes off the displacements `u`, shape (n, c), what moves mass as a whole.
    pub(crate) fn centre(&self, displacements: MatMut<'_, f64>) {
        let shares = transposed_product(self.momenta(), displacements.as_ref());
        subtract_product(displacements, self.motions(), shares.as_ref());
    }

    /// A component of a node, or of a reference point, which has two places behind those of the nodes, under
    /// three shifts and three turns about the centre.
    pub(crate) fn row(&self, nodes: &[[f64; 3]], place: usize, component: usize) -> [f64; 6] {
        let at = nodes.get(place).copied().unwrap_or_else(|| self.points[(place - nodes.len()) / 2]);
        rigid_row(sub(at, self.centre), component)
    }

    /// Force \[N\] and moment about the centre \[N m\] of forces over the dofs.
    pub(crate) fn resultant(&self, nodes: &[[f64; 3]], force: &[f64]) -> [f64; 6] {
        if let Some(turns) = &self.turns {
            return std::array::from_fn(|k| {
                turns.col_as_slice(k).iter().zip(force).map(|(a, f)| a * f).sum()
            });
        }
        let mut sum = [0.0; 6];
        for (x, f) in nodes.iter().zip(force.as_chunks::<3>().0) {
            let moment = cross(std::array::from_fn(|c| x[c] - self.centre[c]), *f);
            for c in 0..3 {
                sum[c] += f[c];
                sum[3 + c] += moment[c];
            }
        }
        sum
    }
}

/// Weight of a dof that is a place for a spring only where no others fix the body.
const LAST: f64 = 1e-6;

const UNITS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A vector at each node as one column over the dofs.
fn field(nodes: &[[f64; 3]], at: impl Fn(&[f64; 3]) -> [f64; 3]) -> Mat<f64> {
    let values: Vec<f64> = nodes.iter().flat_map(at).collect();
    Mat::from_fn(values.len(), 1, |i, _| values[i])
}

fn times(mass: &SymmetricMatrix, columns: MatRef<'_, f64>) -> Mat<f64> {
    let mut image = Mat::zeros(columns.nrows(), columns.ncols());
    mass.mul_into(columns, image.as_mut());
    image
}

/// The principal axes of moments of inertia; the axes of the coordinates if there is no finding them.
fn principal_axes(&[xx, xy, xz, yy, yz, zz]: &[f64; 6]) -> [[f64; 3]; 3] {
    let full = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let matrix = Mat::from_fn(3, 3, |i, j| full[i][j]);
    match matrix.self_adjoint_eigen(Side::Lower) {
        Ok(found) => std::array::from_fn(|k| std::array::from_fn(|c| found.U()[(c, k)])),
        Err(_) => UNITS,
    }
}

/// One pass of Gram and Schmidt in the mass.
fn orthonormalise(mass: &SymmetricMatrix, columns: &mut Mat<f64>) {
    for k in 0..columns.ncols() {
        for j in 0..k {
            let share = mass.inner(columns.col_as_slice(j), columns.col_as_slice(k));
            for i in 0..columns.nrows() {
                columns[(i, k)] -= share * columns[(i, j)];
            }
        }
        let length = mass.inner(columns.col_as_slice(k), columns.col_as_slice(k)).sqrt();
        columns.col_as_slice_mut(k).iter_mut().for_each(|x| *x /= length);
    }
}

/// Six dofs that fix a body: each is the one that moves most, times its weight, in what the ones before it
/// leave free.
fn pins(motions: MatRef<'_, f64>, weight: impl Fn(usize) -> f64) -> [usize; 6] {
    let row = |i: usize| -> [f64; 6] { std::array::from_fn(|k| weight(i) * motions[(i, k)]) };
    let mut rows: Vec<[f64; 6]> = (0..motions.nrows()).map(row).collect();
    let square = |row: &[f64; 6]| row.iter().map(|x| x * x).sum::<f64>();
    [(); 6].map(|()| {
        let largest = rows.iter().map(square).enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let (pin, length) = largest.expect("a body has dofs");
        let along = rows[pin].map(|x| x / length.sqrt());
        for row in &mut rows {
            let share: f64 = row.iter().zip(&along).map(|(a, b)| a * b).sum();
            row.iter_mut().zip(&along).for_each(|(x, a)| *x -= share * a);
        }
        pin
    })
}
