//! Why a problem and its mesh make no body.

use super::gauge::GaugeError;
use super::matrices::MatricesError;
use crate::fem::{LoadError, ModelError};
use crate::mesh::MeshError;
use crate::mesh::select::SelectError;

/// Why a problem and its mesh make no body.
#[derive(Debug, thiserror::Error)]
pub enum BodyError {
    /// The mesh cannot be used.
    #[error("the mesh cannot be used")]
    Mesh(#[from] MeshError),
    /// A selection fits nothing.
    #[error("{path}: `{key}`")]
    Selection {
        /// The problem file.
        path: String,
        /// Path of the key.
        key: String,
        /// Names that the mesh has.
        source: Box<SelectError>,
    },
    /// More live regions than a file has.
    #[error(
        "{path}: {live} regions are live, or have a loss factor; a file has at most {most}: fewer regions, or loss \
         factors for fewer of them"
    )]
    TooManyLive {
        /// The problem file and line.
        path: String,
        /// Live regions.
        live: usize,
        /// As many as a file has.
        most: usize,
    },
    /// A region of the mesh has no material, or a material no region.
    #[error("{path}: `material`: {found}; the mesh has the regions {regions}")]
    Region {
        /// The problem file.
        path: String,
        /// The mismatch.
        found: String,
        /// Names of the mesh's regions.
        regions: String,
    },
    /// A region of the problem file holds no element.
    #[error("{path}: `mesh.region`: no element has all its corners in region `{name}`")]
    EmptyRegion {
        /// The problem file and line.
        path: String,
        /// The region.
        name: String,
    },
    /// A temperature reaches nothing that expands.
    #[error(
        "{path}: the temperature `{name}` changes no element with an `expansion`; expected nodes of `on` that are \
         all corners of such elements"
    )]
    NotHeated {
        /// The problem file and line.
        path: String,
        /// Name of the pattern.
        name: String,
    },
    /// A parameter's range leaves out the problem's own value.
    #[error(
        "{path}: `parameter`: the range {range:?} of `{name}` leaves out the problem's own value, {nominal}"
    )]
    Nominal {
        /// The problem file and line.
        path: String,
        /// The parameter.
        name: String,
        /// The problem's own value.
        nominal: f64,
        /// The range.
        range: [f64; 2],
    },
    /// Two parameters that change the same thing.
    #[error("{path}: `parameter`: `{name}` changes what `{other}` changes already; leave one of them out")]
    TwiceLive {
        /// The problem file and line.
        path: String,
        /// The parameter.
        name: String,
        /// The earlier one.
        other: String,
    },
    /// More live regions than a file has axes for.
    #[error(
        "{path}: `parameter`: {regional} parameters of single regions on a mesh of {regions} regions; a vademecum file has \
         room for 11 such parameters on 8 regions: join regions, or use `region = \"*\"`"
    )]
    TooManyRegions {
        /// The problem file and line.
        path: String,
        /// Regions of the mesh.
        regions: usize,
        /// Parameters of single regions.
        regional: usize,
    },
    /// Coordinates that double precision does not carry.
    #[error(
        "{path}: `mesh`: the body reaches from {low:?} to {high:?} (after `mesh.scale`); expected coordinates below 1e30 and \
         a size above 1e-30"
    )]
    Size {
        /// The problem file and line.
        path: String,
        /// Lower corner of the box around the body.
        low: [f64; 3],
        /// Upper corner.
        high: [f64; 3],
    },
    /// A selection holds no whole facet of the surface.
    #[error(
        "{path}: `{key}` selects nodes but no whole facet of the surface; select all corners of the facets meant"
    )]
    NoFacet {
        /// The problem file.
        path: String,
        /// Path of the key.
        key: String,
    },
    /// The problem has matrices and no mesh.
    #[error("{path}: `mesh` names matrices, and no mesh that could be read")]
    NoMesh {
        /// The problem file and line.
        path: String,
    },
    /// No node where forces may act can move.
    #[error("{path}: `load.surface` chooses no node with a free component")]
    NoFreeNode {
        /// The problem file.
        path: String,
    },
    /// The matrices of another program cannot be used.
    #[error("the matrices cannot be used")]
    Matrices(#[from] MatricesError),
    /// The matrices cannot be assembled.
    #[error("{path}: `support`: the model cannot be assembled")]
    Model {
        /// The problem file, and the line of its first support.
        path: String,
        /// Why not.
        source: ModelError,
    },
    /// A tie that ties nothing.
    #[error(
        "{path}: no node of `on` is within {distance:e} m of a facet of `to`; expected a larger `distance`, or surfaces \
         that touch"
    )]
    LooseTie {
        /// The problem file and line.
        path: String,
        /// Largest distance \[m\].
        distance: f64,
    },
    /// An attachment beside which the stiffness of the body is lost in rounding.
    #[error(
        "{path}: `{key}` is {ratio:.0e} times as stiff as the body (modulus times length: {body:.2e} N/m); expected at most \
         {most:.0e} times that: hold the point by `held`, or take a rigid coupling"
    )]
    TooStiff {
        /// The problem file and line.
        path: String,
        /// Path of the key.
        key: String,
        /// Stiffness over that of the body.
        ratio: f64,
        /// Stiffness of the body \[N/m\].
        body: f64,
        /// Largest ratio.
        most: f64,
    },
    /// Attachments on a matrix that ranks hold.
    #[error(
        "{path}: a body with couplings, ties, masses, springs or a prestress is not built by an engine of several \
         ranks"
    )]
    SpreadAttachments {
        /// The problem file and line.
        path: String,
    },
    /// A static load case that no body stands.
    #[error(
        "{path}: `prestress`: the body buckles under {factor:.3} of this load case (loads and the square of the speed \
         of rotation), so that it has no motion about it; expected a smaller load case, a stiffer body or more supports"
    )]
    Buckled {
        /// The problem file and line.
        path: String,
        /// Share of the load case.
        factor: f64,
    },
    /// A strain gauge off the surface.
    #[error("{path}: gauge `{name}`")]
    Gauge {
        /// The problem file and line.
        path: String,
        /// Its name.
        name: String,
        /// Why not.
        source: GaugeError,
    },
    /// A load pattern cannot be integrated.
    #[error("a load pattern cannot be integrated")]
    Load(#[from] LoadError),
}
