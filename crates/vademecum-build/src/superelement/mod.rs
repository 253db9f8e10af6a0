//! A body reduced to its interfaces, for multibody and finite element programs: component mode synthesis.
//!
//! The free dofs `u` are written by the coordinates `q` of the interfaces and the dofs `x` that are left,
//! `u = S (q, x)`: a node of a patch is its own coordinate, nodes of a rigid frame follow its six motions,
//! and of the nodes of an averaging frame six dofs are replaced by the mean motions. Over `v = (q, x)` the
//! interface is a set of rows, and the methods differ in the columns that stand for `x`:
//!
//! ```text
//! Craig–Bampton     x = −K_xx⁻¹ K_xq q + Φ η       Φ: modes with q = 0
//! Herting           x = −K_xx⁻¹ K_xq q + D η       D: free modes less their static part
//! Rubin, MacNeal    v = R Eᵀ f + Φ η               Φ: free modes; f is solved for
//! ```
//!
//! (Hurty 1965; Craig and Bampton 1968; Herting 1985; Rubin 1975; MacNeal 1971)
//!
//! with `R` the flexibility that the modes `Φ` leave out and `E` the rows of `q`. In all of them `q` stays a
//! set of coordinates, so that other programs join the body to theirs by adding rows and columns.

mod coordinates;
mod damping;
mod error;
mod fixed;
mod free;
mod partition;
mod reduced;
#[cfg(test)]
mod tests;

pub use error::SuperelementError;
pub use free::{AtInterface, ByForces};

use faer::Mat;

use crate::fem::{Model, Pencil};
use crate::input::Problem;
use crate::limits::Memory;
use crate::linalg::transposed_product;
use crate::prepared::{Interface, InterfaceRows, Prepared};
use crate::progress::Listener;

use partition::Partition;
use reduced::Reduced;

/// Method of the reduction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Constraint modes and fixed-interface normal modes.
    CraigBampton,
    /// Free-interface normal modes and residual attachment modes, with their mass.
    Rubin,
    /// The same without the mass of the residual attachment modes.
    Macneal,
    /// Constraint modes and free-interface normal modes less their static part.
    Herting,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::CraigBampton, Self::Rubin, Self::Macneal, Self::Herting];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::CraigBampton => "craig-bampton",
            Self::Rubin => "rubin",
            Self::Macneal => "macneal",
            Self::Herting => "herting",
        }
    }
}

/// A body reduced to its interfaces and some modes.
#[derive(Clone, Debug)]
#[doc(alias("substructure", "component mode synthesis"))]
pub struct Superelement {
    /// The method.
    pub method: Method,
    /// The interfaces; their coordinates are the first ones of the superelement, in order.
    pub interfaces: Vec<Interface>,
    /// Number m of coordinates of the interfaces.
    pub coordinates: usize,
    /// Frequencies \[Hz\] of the normal modes, ascending: with fixed interfaces for Craig–Bampton, of the
    /// body as it is for the others.
    pub frequencies_hz: Vec<f64>,
    /// Mass, shape (r, r), symmetric.
    pub mass: Mat<f64>,
    /// Stiffness, shape (r, r), symmetric.
    pub stiffness: Mat<f64>,
    /// Damping, shape (r, r), symmetric; zeros without any.
    pub damping: Mat<f64>,
    /// `T`, shape (3 · nodes, r): displacement of each node of the mesh under each coordinate.
    pub transformation: Mat<f64>,
    /// The coordinates under three shifts along the axes of space and three turns about the origin of space,
    /// shape (r, 6); none of a body that is held.
    pub rigid_motions: Option<Mat<f64>>,
    /// The full order over the coordinates of the interfaces and the dofs that are left; none of a file.
    pub full_order: Option<FullOrder>,
}

/// A body over the coordinates of its interfaces and the dofs that are left.
#[derive(Clone, Debug)]
pub struct FullOrder {
    /// Mass and stiffness.
    pub pencil: Pencil,
    /// Free dof of the body at each place behind those of the interfaces, ascending.
    pub inside: Vec<u32>,
}

/// Request.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// The method.
    pub method: Method,
    /// Normal modes, beside rigid motions.
    pub modes: usize,
    /// Memory that may be used.
    pub memory: Memory,
}

/// Reduces a body to its interfaces and some normal modes.
///
/// # Errors
/// [`SuperelementError`].
pub fn reduce(
    problem: &Problem,
    prepared: &Prepared,
    interfaces: Vec<Interface>,
    request: Request,
    listener: &dyn Listener,
) -> Result<Superelement, SuperelementError> {
    let Request { method, modes, memory } = request;
    let model = &prepared.body.model;
    let points = problem.reference_places();
    check_memory(model, &interfaces, modes, memory)?;
    listener.stage("coordinates of the interfaces");
    let partition = Partition::new(model, &points, &interfaces)?;
    let reduced = match method {
        Method::CraigBampton => fixed::craig_bampton(&partition, modes, listener)?,
        Method::Herting => fixed::herting(&partition, modes, listener)?,
        Method::Rubin => free::rubin(&partition, modes, true, listener)?,
        Method::Macneal => free::rubin(&partition, modes, false, listener)?,
    };
    let free = partition.coordinates.expand(reduced.columns.as_ref());
    let damping = damping::damping(prepared, &reduced, free.as_ref())?;
    let mut transformation = Mat::zeros(model.dofs().n_dof(), free.ncols());
    for k in 0..free.ncols() {
        model.dofs().expand_into(free.col_as_slice(k), transformation.col_as_slice_mut(k));
    }
    let rigid_motions = partition.is_free().then(|| rigid_motions(&partition, &reduced));
    let coordinates = partition.coordinates.interface;
    let inside = partition.coordinates.inside;
    let full_order = Some(FullOrder { pencil: partition.pencil, inside });
    Ok(Superelement {
        method,
        coordinates,
        interfaces,
        frequencies_hz: reduced.frequencies_hz,
        mass: reduced.mass,
        stiffness: reduced.stiffness,
        damping,
        transformation,
        rigid_motions,
        full_order,
    })
}

/// Refuses what does not fit the memory: `T` at nodes, over the free dofs and over `v`, solves, and blocks of
/// dofs under a mean.
fn check_memory(
    model: &Model,
    interfaces: &[Interface],
    modes: usize,
    memory: Memory,
) -> Result<(), SuperelementError> {
    let coordinates: usize = interfaces.iter().map(|interface| interface.coordinates.len()).sum();
    let columns = (coordinates + modes + 6) as f64;
    // Dofs under a mean are all coupled: entries of two matrices as they are collected and as they are kept.
    let coupled = interfaces.iter().map(|interface| match &interface.rows {
        InterfaceRows::Means(rows) => rows.iter().map(Vec::len).max().unwrap_or(0) as f64,
        InterfaceRows::Followers(_) => 0.0,
    });
    let means: f64 = coupled.map(|dofs| 64.0 * dofs * dofs).sum();
    let needed = 8.0 * 5.0 * columns * model.dofs().n_dof() as f64 + means;
    let what = || format!("{coordinates} coordinates of interfaces and {modes} modes");
    let instead = ": rigid frames, frames instead of patches, or fewer modes";
    Ok(memory.check(needed, instead, what)?)
}

/// The coordinates under rigid motions: those of the interfaces as they move; rigid motions that are
/// coordinates by their share; nothing of the other modes.
fn rigid_motions(partition: &Partition, reduced: &Reduced) -> Mat<f64> {
    let rows = partition.rigid_rows([0.0; 3]);
    let (m, r) = (partition.coordinates.interface, reduced.columns.ncols());
    let own = Mat::from_fn(rows.len(), 6, |i, k| rows[i][k]);
    let natural = partition.pencil.rigid().filter(|_| reduced.natural.is_some());
    let shares = natural.map(|rigid| transposed_product(rigid.momenta(), own.as_ref()));
    Mat::from_fn(r, 6, |i, k| match &shares {
        _ if i < m => own[(i, k)],
        Some(shares) if i < m + 6 => shares[(i - m, k)],
        _ => 0.0,
    })
}
