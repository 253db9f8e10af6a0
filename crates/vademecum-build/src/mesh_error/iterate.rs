//! The answers of the raised space, as far as they are needed: conjugate gradients for a load, block
//! Rayleigh–Ritz iteration for modes (locally optimal, Knyazev 2001), with the factor of the mesh in the
//! preconditioner.

use faer::{Mat, MatRef};

use super::error::MeshErrorFailure;
use crate::fem::{Factor, RaisedSpace, RigidBody, Solve, contiguous_mut};
use crate::linalg::{dot, product, subtract_product, symmetric_eigen, transposed_product};
use crate::mesh::Order;
use crate::progress::{Cancelled, Listener};

/// Frequencies that are estimated.
pub const FREQUENCIES: usize = 6;
/// Most steps of an iteration.
const MAX_STEPS: usize = 20;
/// Eigenvalue of a Gram matrix of unit vectors below which they count as dependent.
const DEPENDENT: f64 = 1e-10;

/// Changes of values by one degree more.
pub(super) struct Change {
    /// `1/λ` of each mode, or the compliance.
    pub(super) values: Vec<f64>,
    /// Steps that were taken.
    pub(super) steps: usize,
}

/// Growth of a change, relative to it, below which an iteration ends.
fn settled(order: Order) -> f64 {
    match order {
        Order::Quadratic => 0.05,
        Order::Linear => 0.03,
    }
}

/// True if no change has grown by more than that. A change of less than rounding leaves is no change.
fn is_settled(order: Order, now: &[f64], before: &[f64], sizes: &[f64]) -> bool {
    let mut all = now.iter().zip(before).zip(sizes);
    all.all(|((now, before), size)| {
        (now - before).abs() < settled(order) * now.abs() || now.abs() < 1e-10 * size
    })
}

/// The compliance of a load on the mesh, and its change over the raised space.
pub(super) fn compliance_change(
    space: &RaisedSpace<'_>,
    factor: &Factor,
    load: &[f64],
    listener: &dyn Listener,
) -> Result<(f64, Change), MeshErrorFailure> {
    let n = space.n();
    let mut solve = Solve::new(factor.symbolic(), 1, false);
    let force = MatRef::from_column_major_slice(load, n, 1);
    let mut x = force.subrows(0, space.n_given()).to_owned();
    solve.solve_in_place(factor, x.as_mut());
    let mesh = dot(x.col_as_slice(0), &load[..space.n_given()]);
    let mut x = lifted(space, x.as_ref());
    let mut residual = force - space.stiffness(x.as_ref());
    let (mut direction, mut last) = (Mat::zeros(n, 1), 0.0);
    let (mut change, mut steps) = (0.0, 0);
    for step in 0..MAX_STEPS {
        if listener.cancelled() {
            return Err(Cancelled.into());
        }
        listener.advance(step, MAX_STEPS);
        let mut z = residual.clone();
        space.precondition(factor, &mut solve, z.as_mut());
        let size = dot(residual.col_as_slice(0), z.col_as_slice(0));
        let ratio = if step == 0 { 0.0 } else { size / last };
        for (d, z) in contiguous_mut(direction.as_mut(), 0).iter_mut().zip(z.col_as_slice(0)) {
            *d = z + ratio * *d;
        }
        let pushed = space.stiffness(direction.as_ref());
        let curvature = dot(direction.col_as_slice(0), pushed.col_as_slice(0));
        steps = step + 1;
        // Nothing left to reduce, or not a number.
        if curvature.is_nan() || curvature <= 0.0 {
            break;
        }
        let length = size / curvature;
        add(&mut x, &direction, length);
        add(&mut residual, &pushed, -length);
        last = size;
        let before = std::mem::replace(&mut change, dot(x.col_as_slice(0), load) - mesh);
        if is_settled(space.order(), &[change], &[before], &[mesh]) {
            break;
        }
    }
    Ok((mesh, Change { values: vec![change], steps }))
}

/// `to ← to + scale x`, one column.
fn add(to: &mut Mat<f64>, x: &Mat<f64>, scale: f64) {
    contiguous_mut(to.as_mut(), 0).iter_mut().zip(x.col_as_slice(0)).for_each(|(to, x)| *to += scale * x);
}

/// The changes of `1/λ` of the lowest modes.
pub(super) fn frequency_changes(
    space: &RaisedSpace<'_>,
    factor: &Factor,
    rigid: Option<&RigidBody>,
    (eigenvalues, vectors): (&[f64], MatRef<'_, f64>),
    listener: &dyn Listener,
) -> Result<Change, MeshErrorFailure> {
    let count = eigenvalues.len();
    let wanted = count.min(FREQUENCIES);
    let mut solve = Solve::new(factor.symbolic(), count, false);
    // Rigid motions are in the space of the mesh; their momenta have parts beside it.
    let rigid = rigid.map(|body| {
        let motions = lifted(space, body.motions());
        let [_, momenta] = space.products(motions.as_ref());
        (motions, momenta)
    });
    let mut block = Block::of(space, lifted(space, vectors));
    let mut values = eigenvalues.to_vec();
    let mut last: Option<Block> = None;
    let (mut changes, mut steps) = (vec![0.0; wanted], 0);
    let sizes: Vec<f64> = eigenvalues.iter().map(|lambda| 1.0 / lambda).collect();
    for step in 0..MAX_STEPS {
        if listener.cancelled() {
            return Err(Cancelled.into());
        }
        listener.advance(step, MAX_STEPS);
        let mut search = block.residual(&values);
        space.precondition(factor, &mut solve, search.as_mut());
        if let Some((motions, momenta)) = &rigid {
            let shares = transposed_product(momenta.as_ref(), search.as_ref());
            subtract_product(search.as_mut(), motions.as_ref(), shares.as_ref());
        }
        let search = Block::of(space, search);
        let mut parts = vec![&block, &search];
        parts.extend(last.as_ref());
        let (found, combination) = rayleigh_ritz(&parts, count)?;
        let (next, direction) = combined(&parts, &combination);
        (values, block, last) = (found, next, Some(direction));
        steps = step + 1;
        let now: Vec<f64> = (0..wanted).map(|k| 1.0 / values[k] - sizes[k]).collect();
        let before = std::mem::replace(&mut changes, now);
        if is_settled(space.order(), &changes, &before, &sizes) {
            break;
        }
    }
    Ok(Change { values: changes, steps })
}

/// Vectors with their products.
struct Block {
    x: Mat<f64>,
    stiffness: Mat<f64>,
    mass: Mat<f64>,
}

impl Block {
    fn of(space: &RaisedSpace<'_>, x: Mat<f64>) -> Self {
        let [stiffness, mass] = space.products(x.as_ref());
        Self { x, stiffness, mass }
    }

    /// `K X − M X Λ`.
    fn residual(&self, values: &[f64]) -> Mat<f64> {
        Mat::from_fn(self.x.nrows(), self.x.ncols(), |i, j| {
            self.stiffness[(i, j)] - values[j] * self.mass[(i, j)]
        })
    }
}

/// The lowest Ritz values of the space of some blocks, and what their vectors are made of.
fn rayleigh_ritz(parts: &[&Block], count: usize) -> Result<(Vec<f64>, Mat<f64>), MeshErrorFailure> {
    let total: usize = parts.iter().map(|part| part.x.ncols()).sum();
    let gram = |of: fn(&Block) -> &Mat<f64>| {
        let mut gram = Mat::zeros(total, total);
        let mut row = 0;
        for a in parts {
            let mut column = 0;
            for b in parts {
                let product = transposed_product(a.x.as_ref(), of(b).as_ref());
                gram.as_mut().submatrix_mut(row, column, a.x.ncols(), b.x.ncols()).copy_from(&product);
                column += b.x.ncols();
            }
            row += a.x.ncols();
        }
        gram
    };
    let (stiffness, mass) = (gram(|b| &b.stiffness), gram(|b| &b.mass));
    let scale: Vec<f64> =
        (0..total).map(|i| if mass[(i, i)] > 0.0 { mass[(i, i)].sqrt().recip() } else { 0.0 }).collect();
    let scaled =
        |a: &Mat<f64>| Mat::from_fn(total, total, |i, j| 0.5 * scale[i] * scale[j] * (a[(i, j)] + a[(j, i)]));
    let (sizes, axes) = symmetric_eigen(scaled(&mass).as_ref())?;
    let kept: Vec<usize> = (0..total).filter(|&k| sizes[k] > DEPENDENT).collect();
    let white = Mat::from_fn(total, kept.len(), |i, k| axes[(i, kept[k])] / sizes[kept[k]].sqrt());
    let reduced = white.transpose() * scaled(&stiffness) * &white;
    let (values, vectors) = symmetric_eigen(reduced.as_ref())?;
    let lowest = white * vectors.subcols(0, count);
    let combination = Mat::from_fn(total, count, |i, k| scale[i] * lowest[(i, k)]);
    Ok((values[..count].to_vec(), combination))
}

/// The combinations of all blocks, and the same without the first: how the first changes.
fn combined(parts: &[&Block], combination: &Mat<f64>) -> (Block, Block) {
    let count = combination.ncols();
    let sum = |of: fn(&Block) -> &Mat<f64>| {
        let first = parts[0].x.ncols();
        let mut change = Mat::zeros(parts[0].x.nrows(), count);
        let mut row = first;
        for part in &parts[1..] {
            change += product(of(part).as_ref(), combination.subrows(row, part.x.ncols()));
            row += part.x.ncols();
        }
        let whole = product(of(parts[0]).as_ref(), combination.subrows(0, first)) + &change;
        (whole, change)
    };
    let [(x, dx), (stiffness, d_stiffness), (mass, d_mass)] =
        [sum(|b| &b.x), sum(|b| &b.stiffness), sum(|b| &b.mass)];
    (Block { x, stiffness, mass }, Block { x: dx, stiffness: d_stiffness, mass: d_mass })
}

/// `(x, 0)`: columns over the unknowns of the mesh in the raised space.
fn lifted(space: &RaisedSpace<'_>, x: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(space.n(), x.ncols(), |i, j| if i < x.nrows() { x[(i, j)] } else { 0.0 })
}
