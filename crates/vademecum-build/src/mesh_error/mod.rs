//! The discretisation error of a body: how far its natural frequencies and a static displacement are from
//! those of an infinitely fine mesh of the same shape.
//!
//! The degree of the displacements is raised by one on the same mesh, and the change of each value, `g`, is
//! scaled. With `λ = ω²` and the compliance `c` of a traction, both of which the mesh has from below in
//! `1/λ` and `c`,
//!
//! ```text
//! e = s g        1/λ* = 1/λ + e        c* = c + e
//! ```
//!
//! | mesh | `s` | bound in 95 % |
//! |---|---|---|
//! | quadratic | 1.45 | 1.9 |
//! | linear | 1.1 | 1.4 |
//! | quadratic, a support ends inside a smooth face | 1.8 | 2.2 |
//! | linear, likewise | 1.3 | 1.7 |
//! | quadratic, more than half of the rim does | 2.1 | 2.7 |
//! | linear, likewise | 1.55 | 2.1 |
//!
//! The factors were fitted on ten bodies with 1 078 values and kept on four others; each value was within
//! 0.65 to 1.33 of its true error. The last two were fitted on a rectangular patch in the middle of a face,
//! whose bound the others missed (`census`). No system of the raised space is factorised: loads are solved by
//! conjugate gradients, modes by block Rayleigh–Ritz iteration, both with the factor that exists
//! ([`RaisedSpace`](crate::fem)). They end when the change of no value grows by more than 5 % (quadratic) or
//! 3 % (linear), at 20 steps at most.
//!
//! A load at a point, and a support without area, have no limit under refinement: the answer depends on the
//! mesh by definition, and no estimate is given.

mod disc;
mod error;
mod iterate;
mod supports;

use faer::MatRef;
use serde::{Deserialize, Serialize};

pub use self::disc::DiscLoad;
use self::disc::{raised_load, softest_place};
pub use self::error::MeshErrorFailure;
pub use self::iterate::FREQUENCIES;
use self::iterate::{compliance_change, frequency_changes};
use self::supports::{Rim, SupportShape, support_shape};
use crate::dynamics::{Modes, lowest_modes};
use crate::fem::RaisedSpace;
use crate::linalg::vec3::{norm, sub};
use crate::mesh::Order;
use crate::prepared::Prepared;
use crate::progress::Listener;

/// Radius of a disc where nobody asks for one, in mean edges of the mesh.
const EDGES: f64 = 3.0;
/// Modes beside them in the start block: linear meshes sort modes wrongly.
const GUARD: usize = 2;

/// A value of the mesh beside the one without discretisation error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RefinedValue {
    /// The value on this mesh.
    pub mesh: f64,
    /// The estimate of the value on an infinitely fine mesh.
    pub refined: f64,
    /// Relative error of the value on this mesh, signed: positive is too high.
    pub error: f64,
    /// Magnitude that the error does not exceed in 95 % of the values measured.
    pub bound: f64,
}

impl RefinedValue {
    /// A value on this mesh beside the one without discretisation error.
    pub fn of_mesh(mesh: f64, refined: f64, bound: f64) -> Self {
        Self { mesh, refined, error: mesh / refined - 1.0, bound }
    }
}

/// The displacement under a traction of one newton, spread over a disc of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiscDisplacement {
    /// The disc and its normal.
    #[serde(flatten)]
    pub disc: DiscLoad,
    /// The mean displacement of the disc along its normal \[m\].
    #[serde(flatten)]
    pub value: RefinedValue,
}

/// The discretisation error of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiscretisationError {
    /// The lowest natural frequencies \[Hz\].
    pub frequencies: Vec<RefinedValue>,
    /// The displacement under a traction; absent of a body without supports or without a loadable face, where
    /// nobody asked, and of a disc too small to be integrated.
    pub displacement: Option<DiscDisplacement>,
    /// True where a support ends inside a smooth face, which the raised degree sees less of.
    pub smooth_rim: bool,
    /// Held nodes in no held face: what they do depends on the mesh by definition, and is not estimated.
    pub nodes_without_area: usize,
    /// True where a support ends between nodes: a finer mesh holds more there, which the estimate leaves out.
    pub support_between_nodes: bool,
    /// Steps of the iteration for the frequencies, and for the displacement.
    pub steps: [usize; 2],
}

/// The discretisation error of a body, or the reason why it is not known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum MeshEstimate {
    /// It was estimated.
    Known(DiscretisationError),
    /// It has none, or cannot be estimated.
    Unknown {
        /// The reason, for people.
        reason: String,
    },
}

/// Why there is no estimate.
#[derive(Clone, Copy, Debug, thiserror::Error)]
enum NoEstimate {
    /// There are no elements.
    #[error("the matrices of another program have no elements: their mesh is not known")]
    NoElements,
    /// There are other elements than tetrahedra of one order.
    #[error("the estimate is for tetrahedra: meshes with hexahedra, wedges or pyramids have none")]
    NoTetrahedra,
    /// Something is attached to the body.
    #[error("the estimate is for a body alone: one with couplings, ties, masses or springs has none")]
    Attachments,
    /// The body moves about a loaded state.
    #[error("the estimate is for a body without load: one with `[prestress]` has none")]
    Prestress,
    /// The matrices are not in this process.
    #[error("matrices on several ranks are not refined: ask `vademecum modes --mesh-error` in one process")]
    Ranks,
    /// No support has an area.
    #[error(
        "{nodes} held nodes and no held face: a support without area has no limit under refinement, so \
         frequencies and displacements depend on the mesh by definition; hold the faces of a patch"
    )]
    NoArea {
        /// Held corner nodes.
        nodes: usize,
    },
}

impl From<NoEstimate> for MeshEstimate {
    fn from(reason: NoEstimate) -> Self {
        Self::Unknown { reason: reason.to_string() }
    }
}

/// The load whose displacement is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscRequest {
    /// None: frequencies alone.
    None,
    /// A disc of this radius \[m\], else of three mean edges, at the loadable node of largest compliance.
    Radius(Option<f64>),
}

/// Factors from the change to the error, and to its bound.
fn factors(order: Order, rim: Rim) -> [f64; 2] {
    match (order, rim) {
        (Order::Quadratic, Rim::Sharp) => [1.45, 1.9],
        (Order::Quadratic, Rim::PartlySmooth) => [1.8, 2.2],
        (Order::Quadratic, Rim::Smooth) => [2.1, 2.7],
        (Order::Linear, Rim::Sharp) => [1.1, 1.4],
        (Order::Linear, Rim::PartlySmooth) => [1.3, 1.7],
        (Order::Linear, Rim::Smooth) => [1.55, 2.1],
    }
}

/// Estimates the discretisation error of a body at the values of its problem file.
///
/// `known` are its lowest modes, ascending, if there are any at hand; more are computed where they are
/// fewer than eight. Work: some products with the raised space and as many solves with the factor that
/// exists; memory for three blocks of 24 vectors of the raised space.
///
/// # Errors
/// [`MeshErrorFailure`]: numerics that fail, or a listener that wants to stop.
pub fn estimate(
    prepared: &Prepared,
    known: Option<(&[f64], MatRef<'_, f64>)>,
    disc: DiscRequest,
    listener: &dyn Listener,
) -> Result<MeshEstimate, MeshErrorFailure> {
    let (model, symbolic) = (&prepared.body.model, &prepared.symbolic);
    let pencil = model.pencil();
    if model.mesh().elements.is_empty() {
        return Ok(NoEstimate::NoElements.into());
    }
    if model.mesh().tetrahedra().is_none() {
        return Ok(NoEstimate::NoTetrahedra.into());
    }
    if model.is_prestressed() {
        return Ok(NoEstimate::Prestress.into());
    }
    if !model.is_bare() {
        return Ok(NoEstimate::Attachments.into());
    }
    if symbolic.is_spread() {
        return Ok(NoEstimate::Ranks.into());
    }
    let free = pencil.rigid().is_some();
    let SupportShape { held_nodes, without_area, has_area, rim } = support_shape(model);
    if !free && !has_area {
        return Ok(NoEstimate::NoArea { nodes: held_nodes }.into());
    }
    let count = (FREQUENCIES + GUARD).min(pencil.n_elastic());
    let computed: Modes;
    let (eigenvalues, vectors) = match known {
        Some((values, vectors)) if values.len() >= count => (values, vectors),
        _ => {
            computed = lowest_modes(pencil, symbolic, count)?;
            (computed.eigenvalues.as_slice(), computed.vectors.as_ref())
        }
    };
    let (eigenvalues, vectors) = (&eigenvalues[..count], vectors.subcols(0, count));
    let factor = symbolic.factor_of(pencil.stiffness())?;
    let space = RaisedSpace::new(model);
    let (low, high) = model.mesh().bounding_box();
    let (edge, most) = (space.mean_edge(), 0.5 * norm(sub(high, low)));
    let bad_disc = |radius: f64| MeshErrorFailure::Disc { radius, most, edge };
    if let DiscRequest::Radius(Some(radius)) = disc
        && radius > most
    {
        return Err(bad_disc(radius));
    }
    let [scale, bound_scale] = factors(model.mesh().order(), rim);
    let change = frequency_changes(
        &space,
        &factor,
        pencil.rigid().map(AsRef::as_ref),
        (eigenvalues, vectors),
        listener,
    )?;
    let frequencies = eigenvalues.iter().zip(&change.values).take(FREQUENCIES).map(|(&lambda, &g)| {
        let too_high = |s: f64| (1.0 + s * g * lambda).sqrt() - 1.0;
        let mesh = lambda.sqrt() / std::f64::consts::TAU;
        RefinedValue::of_mesh(mesh, mesh / (1.0 + too_high(scale)), too_high(bound_scale))
    });
    let frequencies = frequencies.collect();
    let mut steps = [change.steps, 0];
    let mut displacement = None;
    if let (DiscRequest::Radius(asked), false) = (disc, free) {
        let radius = asked.unwrap_or(EDGES * edge);
        let place = softest_place(&prepared.body, eigenvalues, vectors, radius);
        let loaded = place
            .and_then(|(disc, facets)| Some((disc, raised_load(&space, &prepared.body, &disc, &facets)?)));
        if let (None, Some(radius)) = (&loaded, asked) {
            return Err(bad_disc(radius));
        }
        if let Some((disc, load)) = loaded {
            let (mesh, change) = compliance_change(&space, &factor, &load, listener)?;
            let g = change.values[0];
            let share = |s: f64| s * g / (mesh + s * g);
            let value = RefinedValue::of_mesh(mesh, mesh + scale * g, share(bound_scale));
            displacement = Some(DiscDisplacement { disc, value });
            steps[1] = change.steps;
        }
    }
    Ok(MeshEstimate::Known(DiscretisationError {
        frequencies,
        displacement,
        smooth_rim: rim != Rim::Sharp,
        nodes_without_area: without_area,
        support_between_nodes: prepared.body.supports.iter().any(|support| support.between_nodes),
        steps,
    }))
}

#[cfg(test)]
mod census_tests;
#[cfg(test)]
mod tests;
