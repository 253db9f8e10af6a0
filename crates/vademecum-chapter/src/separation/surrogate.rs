//! Pencils to test on without meshes: a lattice of springs, and a clamped Euler–Bernoulli beam of several
//! regions, 2 dofs per node.
//!
//! Its frequencies spread as 1 : 6 : 18 : 34 : …, as those of a slender solid do, and its stiffness is
//! singularly ill conditioned, so it is not an easy case.

use faer::{Mat, MatRef, Side};
use vademecum_build::separated::{DenseSpace, Space, product, transposed_product};

pub(crate) struct Pencil {
    pub(crate) mass: Mat<f64>,
    /// One per region.
    pub(crate) stiffness: Vec<Mat<f64>>,
    /// Lowest eigenvalues of the nominal pencil.
    pub(crate) eigenvalues: Vec<f64>,
    /// Ritz vectors of a space of static responses, `(n, n_modes)`: near the eigenmodes but not invariant, as
    /// a basis that comes from snapshots.
    pub(crate) modes: Mat<f64>,
}

impl Pencil {
    /// `elements` beam elements on unit length with unit bending stiffness and mass, split into equal
    /// regions.
    pub(crate) fn beam(elements: usize, regions: usize, n_modes: usize) -> Pencil {
        let h = 1.0 / elements as f64;
        let bending = [[12.0, 6.0 * h, -12.0, 6.0 * h], [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h]];
        let inertia = [[156.0, 22.0 * h, 54.0, -13.0 * h], [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h]];
        let entry = |rows: &[[f64; 4]; 2], i: usize, j: usize| {
            // The lower half of an element is the upper one seen from the other end, rotations reversed.
            let sign = |k: usize| if k % 2 == 1 { -1.0 } else { 1.0 };
            if i < 2 { rows[i][j] } else { rows[i - 2][(j + 2) % 4] * sign(i) * sign(j) }
        };
        let assemble = |scale: f64, rows: &[[f64; 4]; 2], region: Option<usize>| {
            let mut entries = Vec::new();
            for e in 0..elements {
                let inside = region.is_none_or(|q| e * regions / elements == q);
                for i in 0..4 {
                    for j in 0..4 {
                        let (row, col) = ((2 * e + i).checked_sub(2), (2 * e + j).checked_sub(2));
                        if let (Some(row), Some(col)) = (row, col) {
                            let value = if inside { scale * entry(rows, i, j) } else { 0.0 };
                            entries.push((row, col, value));
                        }
                    }
                }
            }
            dense(2 * elements, &entries)
        };
        let mass = assemble(h / 420.0, &inertia, None);
        let stiffness: Vec<_> = (0..regions).map(|q| assemble(h.powi(-3), &bending, Some(q))).collect();
        Pencil::new(mass, stiffness, n_modes)
    }

    /// A scalar lattice of `nx × ny × nz` nodes, clamped at one end, cut in regions along z.
    pub(crate) fn lattice(nx: usize, ny: usize, nz: usize, regions: usize, n_modes: usize) -> Pencil {
        let at = |x: usize, y: usize, z: usize| x + nx * (y + ny * z);
        let assemble = |own: f64, shared: f64, ground: f64, region: Option<usize>| {
            let mut entries = Vec::new();
            for (x, y, z) in (0..nx * ny * nz).map(|k| (k % nx, k / nx % ny, k / (nx * ny))) {
                let inside = f64::from(region.is_none_or(|q| z * regions / nz == q));
                let i = at(x, y, z);
                if z == 0 {
                    entries.push((i, i, inside * ground));
                }
                for (x, y, z) in [(x + 1, y, z), (x, y + 1, z), (x, y, z + 1)] {
                    if x < nx && y < ny && z < nz {
                        let j = at(x, y, z);
                        entries.extend(
                            [(i, i, own), (j, j, own), (i, j, shared), (j, i, shared)]
                                .map(|(i, j, v)| (i, j, inside * v)),
                        );
                    }
                }
            }
            dense(nx * ny * nz, &entries)
        };
        let mass = assemble(2.0 / 6.0, 1.0 / 6.0, 2.0 / 6.0, None);
        let stiffness: Vec<_> = (0..regions).map(|q| assemble(1.0, -1.0, 1.0, Some(q))).collect();
        Pencil::new(mass, stiffness, n_modes)
    }

    fn new(mass: Mat<f64>, stiffness: Vec<Mat<f64>>, n_modes: usize) -> Pencil {
        let (eigenvalues, modes) = ritz(&mass, &stiffness, n_modes);
        Pencil { mass, stiffness, eigenvalues, modes }
    }

    /// `M X`.
    pub(crate) fn energy(&self) -> impl Fn(MatRef<'_, f64>) -> Mat<f64> + Sync + '_ {
        |x| product(self.mass.as_ref(), x)
    }
}

/// The `n × n` matrix whose entries are summed from `(row, column, value)`.
fn dense(n: usize, entries: &[(usize, usize, f64)]) -> Mat<f64> {
    let mut matrix = Mat::zeros(n, n);
    entries.iter().for_each(|(i, j, value)| matrix[(*i, *j)] += value);
    matrix
}

/// Lowest eigenvalues, and the Ritz vectors of `3 n_modes` responses to point loads, once through the
/// inertia.
fn ritz(mass: &Mat<f64>, stiffness: &[Mat<f64>], count: usize) -> (Vec<f64>, Mat<f64>) {
    let n = mass.nrows();
    let mut matrices = vec![mass.clone()];
    matrices.extend_from_slice(stiffness);
    let space = DenseSpace::new(matrices).unwrap();
    let mut weights = vec![1.0; 1 + stiffness.len()];
    weights[0] = 0.0;
    let width = 3 * count;
    let loads = Mat::from_fn(n, width, |i, j| f64::from(i == 2 * ((j + 1) * n / (2 * width) - 1)));
    let mut v = space.solve(&weights, loads.as_ref()).unwrap();
    let inverse = |v: &Mat<f64>| {
        rayleigh_ritz(&space, &space.solve(&weights, space.apply(0, v.as_ref()).as_ref()).unwrap())
    };
    v = inverse(&v).1;
    let basis = v.as_ref().subcols(0, count).to_owned();
    let mut values = Vec::new();
    for _ in 0..20 {
        (values, v) = inverse(&v);
    }
    values.truncate(count);
    (values, basis)
}

/// Ritz values and mass-orthonormal Ritz vectors of the span of `w`.
fn rayleigh_ritz(space: &DenseSpace, w: &Mat<f64>) -> (Vec<f64>, Mat<f64>) {
    // an orthonormal basis first: static responses are nearly parallel
    let w = w.thin_svd().unwrap().U().to_owned();
    let gram = transposed_product(w.as_ref(), space.apply(0, w.as_ref()).as_ref());
    let l = gram.llt(Side::Lower).unwrap();
    let mut t = w.transpose().to_owned();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(l.L(), t.as_mut(), faer::Par::Seq);
    let q = t.transpose().to_owned();
    let mut small = Mat::zeros(q.ncols(), q.ncols());
    for k in 1..space.n_operators() {
        small += transposed_product(q.as_ref(), space.apply(k, q.as_ref()).as_ref());
    }
    let evd = small.self_adjoint_eigen(Side::Lower).unwrap();
    let values = (0..w.ncols()).map(|i| evd.S().column_vector()[i]).collect();
    (values, product(q.as_ref(), evd.U()))
}
