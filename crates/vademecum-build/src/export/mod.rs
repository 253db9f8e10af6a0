//! From the built parts to the bytes of a file.
//!
//! Rounding to the file's precision happens here and nowhere before.

mod curve;
mod draft;
mod factor;
mod live;
mod mesh_error;
mod order;
mod patch;
mod ports;
mod reaction;
mod residual;
mod strain;
mod stress;

pub use draft::Draft;
pub(crate) use factor::factor_sections;
pub use live::PointMeasured;
pub(crate) use live::{PointWitnessed, RegionForms, live_certificate, live_sections, live_witnesses};
pub(crate) use mesh_error::mesh_error_section;
pub use order::NodeOrder;
pub(crate) use patch::patch_sections;
pub(crate) use ports::port_sections;
pub(crate) use reaction::reaction_sections;
pub(crate) use residual::residual_sections;
pub(crate) use strain::{StrainMap, TrainingBox, strain_sections};
pub(crate) use stress::{stress_order, stress_sections};

use faer::{Mat, MatRef};
use vademecum_format::FormatError;
use vademecum_format::scheme::SchemeTable;
use vademecum_format::{Axis, Certificate, MAX_AXES, MAX_PARAMETERS, MAX_REGIONS, Metadata, Parameter};
use vademecum_format::{Element, SectionInput, SectionKind, encode_into, encoded_len};

use crate::basis::Basis;
use crate::dynamics::Rayleigh;
use crate::fem::DofMap;
use crate::input::{Fields, Problem};
use crate::linalg::{project, symmetric_part};
use crate::mesh::Embedded;
use crate::parametric::SeparationRecord;
use crate::prepared::{Body, ParameterSpace, Quadrangle};
use crate::response::BlockTerms;

/// Everything a file is made of.
pub struct Parts<'a> {
    /// The problem it came from.
    pub problem: &'a Problem,
    /// The body.
    pub body: &'a Body,
    /// Its nodes in the order of the file.
    pub order: &'a NodeOrder,
    /// The basis.
    pub basis: &'a Basis,
    /// Name of the scheme, with its parameters.
    pub scheme_name: &'a str,
    /// The scheme.
    pub scheme: &'a SchemeTable,
    /// Δt \[s\].
    pub time_step: f64,
    /// Rayleigh damping.
    pub rayleigh: Rayleigh,
    /// The block structure.
    pub block: Option<BlockTerms<'a>>,
    /// Whether the diagonal structure is offered, where the basis allows it.
    pub diagonal: bool,
    /// Sections of another structure.
    pub others: Vec<&'a Draft>,
    /// Live parameters; none without a box.
    pub parameters: Option<&'a ParameterSpace>,
    /// What the separation over the parameters did; none without them.
    pub separation: Option<&'a SeparationRecord>,
    /// What was measured.
    pub certificate: Certificate,
    /// Rows of section 16, shape (r, 6).
    pub mode_table: Mat<f64>,
    /// What wrote the file: [`program`].
    pub program: String,
}

/// The program with its version, and how it solved if that was not by a factor.
pub fn program(solver: Option<String>) -> String {
    let own = concat!("vademecum ", env!("CARGO_PKG_VERSION"));
    solver.map_or_else(|| own.to_owned(), |solver| format!("{own}, {solver}"))
}

/// The bytes of the file.
///
/// # Errors
/// [`FormatError`] for numbers a file cannot hold (a count past the format's limits, a value that is not
/// finite).
pub fn encode(parts: &Parts<'_>) -> Result<Vec<u8>, FormatError> {
    let order = parts.order;
    let own = sections(parts, order);
    let mut drafts: Vec<&Draft> = own.iter().chain(parts.others.iter().copied()).collect();
    drafts.sort_by_key(|draft| draft.kind.number());
    let tables = parts.block.as_ref().map_or(&[][..], |block| &block.axes);
    let mut axes = [Axis::UNUSED; MAX_AXES];
    axes.iter_mut().zip(tables).for_each(|(axis, table)| *axis = table.axis);
    let (parameters, n_parameters) = file_parameters(parts.parameters);
    let metadata = Metadata {
        program: &parts.program,
        problem: &parts.problem.text,
        units: &parts.problem.units,
        mesh_hash: parts.body.mesh_hash,
        n_nodes: order.nodes.len() as u32,
        n_surface_nodes: order.n_surface as u32,
        n_load_nodes: order.n_load as u32,
        n_triangles: order.triangles.len() as u32,
        n_load_triangles: order.n_load_triangles as u32,
        n_modes: parts.basis.n_modes() as u32,
        n_patterns: parts.body.patterns.len() as u32,
        n_probes: parts.body.probes.len() as u32,
        scheme_name: parts.scheme_name,
        scheme: *parts.scheme,
        time_step: parts.time_step,
        alpha: parts.rayleigh.alpha,
        beta: parts.rayleigh.beta,
        axes,
        n_axes: tables.len() as u32,
        n_terms: parts.block.as_ref().map_or(0, |block| block.states.len() as u32),
        n_regions: parts.body.model.mesh().regions.len().min(MAX_REGIONS) as u32,
        n_parameters,
        parameters,
        diagonal: parts.diagonal && parts.basis.eigenvalues.is_some(),
        block: parts.block.is_some(),
        certificate: parts.certificate,
    };
    let inputs: Vec<SectionInput<'_>> = drafts.iter().map(|draft| draft.input()).collect();
    let mut bytes = vec![0; encoded_len(&metadata, &inputs)?];
    encode_into(&metadata, &inputs, &mut bytes)?;
    Ok(bytes)
}

/// The live parameters as the file keeps them, and their number.
fn file_parameters(space: Option<&ParameterSpace>) -> ([Parameter<'_>; MAX_PARAMETERS], u32) {
    let mut parameters = [Parameter::UNUSED; MAX_PARAMETERS];
    let live = space.map_or(&[][..], |s| &s.parameters);
    for (place, p) in parameters.iter_mut().zip(live) {
        *place = Parameter {
            name: &p.name,
            unit: p.unit,
            role: p.role,
            log: p.log,
            lower: p.lower,
            upper: p.upper,
            nominal: p.nominal,
        };
    }
    (parameters, live.len() as u32)
}

fn sections(parts: &Parts<'_>, order: &NodeOrder) -> Vec<Draft> {
    let mut drafts = geometry_sections(parts, order);
    drafts.extend(basis_sections(parts, order));
    drafts.extend(load_and_probe_sections(parts));
    if let Some(block) = &parts.block {
        drafts.extend(block_sections(parts, block, order));
    }
    if parts.parameters.is_some_and(ParameterSpace::has_region_parameters) {
        drafts.extend(region_sections(parts));
    }
    if let Some(separation) = parts.separation {
        drafts.extend(separation_sections(separation));
    }
    drafts
}

fn geometry_sections(parts: &Parts<'_>, order: &NodeOrder) -> Vec<Draft> {
    let mesh = parts.body.model.mesh();
    let ids = order.nodes.iter().flat_map(|&n| mesh.node_ids[n as usize].to_le_bytes()).collect();
    let coordinates = order.nodes.iter().flat_map(|&n| mesh.nodes[n as usize]);
    let triangles = order.triangles.iter().flatten().flat_map(|n| n.to_le_bytes()).collect();
    let n = order.nodes.len();
    let mut drafts = vec![
        Draft { kind: SectionKind::NodeIds, element: Element::U64, shape: [n as u64, 1, 1], bytes: ids },
        Draft::reals(SectionKind::NodeCoordinates, parts.problem.output.precision, [n, 3, 1], coordinates),
        Draft {
            kind: SectionKind::Triangles,
            element: Element::U32,
            shape: [order.triangles.len() as u64, 3, 1],
            bytes: triangles,
        },
    ];
    drafts.extend(quadrangle_section(order));
    if let Some(Embedded { nodes, weights, triangles, .. }) = &parts.body.embedded {
        let followed = nodes.iter().flatten().map(|&node| order.file_node[node as usize]);
        let weights = weights.as_flattened().iter().copied();
        let corners = triangles.as_flattened().iter().copied();
        let precision = parts.problem.output.precision;
        drafts.extend([
            Draft::u32s(SectionKind::EmbeddedNodes, [nodes.len(), 4, 1], followed),
            Draft::reals(SectionKind::EmbeddedWeights, precision, [nodes.len(), 4, 1], weights),
            Draft::u32s(SectionKind::EmbeddedTriangles, [triangles.len(), 3, 1], corners),
        ]);
    }
    drafts
}

/// The quadrangular facets that may be loaded; nothing of a surface of triangles.
fn quadrangle_section(order: &NodeOrder) -> Option<Draft> {
    let facets = &order.quadrangles;
    let most = facets.iter().map(|facet| facet.nodes.len()).max()?;
    let row = |facet: &Quadrangle| {
        let triangles = facet.triangles();
        let nodes = facet.nodes.iter().copied().chain(std::iter::repeat(u32::MAX)).take(most);
        [triangles.start as u32, triangles.len() as u32].into_iter().chain(nodes).collect::<Vec<u32>>()
    };
    let rows = facets.iter().flat_map(row);
    Some(Draft::u32s(SectionKind::Quadrangles, [facets.len(), 2 + most, 1], rows))
}

fn basis_sections(parts: &Parts<'_>, order: &NodeOrder) -> Vec<Draft> {
    let (basis, dofs) = (parts.basis, parts.body.model.dofs());
    let (r, precision) = (basis.n_modes(), parts.problem.output.precision);
    let (surface, interior) = order.nodes.split_at(order.n_surface);
    let stiffness = (0..r * r).map(|k| basis.stiffness[(k / r, k % r)]);
    let mut drafts = vec![
        Draft::f64s(SectionKind::ReducedStiffness, [r, r, 1], stiffness),
        Draft::reals(
            SectionKind::SurfaceBasis,
            precision,
            [surface.len(), 3, r],
            node_rows(dofs, basis.vectors.as_ref(), surface),
        ),
        Draft::f64s(SectionKind::ModeTable, [r, 6, 1], (0..6 * r).map(|k| parts.mode_table[(k / 6, k % 6)])),
    ];
    if let Some(values) = &basis.eigenvalues {
        drafts.push(Draft::f64s(SectionKind::Eigenvalues, [r, 1, 1], values.iter().copied()));
    }
    if !basis.singular_values.is_empty() {
        let values = basis.singular_values.iter().copied();
        drafts.push(Draft::f64s(SectionKind::SingularValues, [basis.singular_values.len(), 1, 1], values));
    }
    if parts.problem.output.fields == Fields::Body && !interior.is_empty() {
        let rows = node_rows(dofs, basis.vectors.as_ref(), interior);
        drafts.push(Draft::reals(SectionKind::InteriorBasis, precision, [interior.len(), 3, r], rows));
    }
    drafts
}

fn load_and_probe_sections(parts: &Parts<'_>) -> Vec<Draft> {
    let (body, basis) = (parts.body, parts.basis);
    let r = basis.n_modes();
    let mut drafts = vec![];
    if !body.patterns.is_empty() {
        let rows = body.patterns.iter().flat_map(|(_, force)| project(basis.vectors.as_ref(), force));
        drafts.push(Draft::f64s(SectionKind::PatternBasis, [body.patterns.len(), r, 1], rows));
        drafts.push(Draft::names(SectionKind::PatternNames, body.patterns.iter().map(|p| p.0.as_str())));
    }
    let rigid = body.rigid_numbers();
    if !rigid.is_empty() {
        drafts.push(Draft::f64s(SectionKind::RigidBody, [rigid.len(), 1, 1], rigid));
    }
    if let Some(point) = body.base {
        drafts.push(Draft::f64s(SectionKind::BaseFrame, [3, 1, 1], point));
    }
    if !body.probes.is_empty() {
        let row = |probe: &crate::prepared::Probe| -> Vec<f64> {
            let row = body.probe_row(probe);
            let value =
                |k| row.iter().map(|&(free, weight)| weight * basis.vectors[(free as usize, k)]).sum();
            (0..r).map(value).collect()
        };
        let rows = body.probes.iter().flat_map(row);
        drafts.push(Draft::f64s(SectionKind::ProbeRows, [body.probes.len(), r, 1], rows));
        drafts.push(Draft::names(SectionKind::ProbeNames, body.probes.iter().map(|p| p.name.as_str())));
        if body.probes.iter().any(|probe| probe.unit != "m") {
            drafts.push(Draft::names(SectionKind::ProbeUnits, body.probes.iter().map(|probe| probe.unit)));
        }
    }
    drafts
}

fn block_sections(parts: &Parts<'_>, block: &BlockTerms<'_>, order: &NodeOrder) -> Vec<Draft> {
    let (r, terms, dofs) = (parts.basis.n_modes(), block.states.len(), parts.body.model.dofs());
    let state = block.states.iter().flat_map(|s| (0..r * r).map(|k| s[(k / r, k % r)]));
    let load_nodes = &order.nodes[..order.n_load];
    let load = load_nodes.iter().flat_map(|node| {
        block.loads.iter().flat_map(move |l| node_rows(dofs, l.as_ref(), std::slice::from_ref(node)))
    });
    let precision = parts.problem.output.precision;
    let points: Vec<f64> = block.axes.iter().flat_map(|table| table.points.iter().copied()).collect();
    let factors = block.axes.iter().flat_map(|table| {
        let points = table.points.len();
        (0..terms * points).map(move |k| table.factors[(k / points, k % points)])
    });
    let mut drafts = vec![
        Draft::f64s(SectionKind::BlockState, [terms, r, r], state),
        Draft::reals(SectionKind::BlockLoad, precision, [load_nodes.len(), terms, 3 * r], load),
        Draft::f64s(SectionKind::Factors, [terms * points.len(), 1, 1], factors),
        Draft::f64s(SectionKind::AxisPoints, [points.len(), 1, 1], points),
    ];
    let patterns = &parts.body.patterns;
    if !patterns.is_empty() {
        let rows = patterns
            .iter()
            .flat_map(|(_, force)| block.loads.iter().flat_map(move |l| project(l.as_ref(), force)));
        drafts.push(Draft::f64s(SectionKind::PatternBlock, [patterns.len(), terms, r], rows));
    }
    drafts
}

/// `BᵀK_qB` and `BᵀM_qB` of each region: energy and initial acceleration when regions are scaled.
fn region_sections(parts: &Parts<'_>) -> Vec<Draft> {
    let (pencil, basis) = (parts.body.model.pencil(), parts.basis.vectors.as_ref());
    let (r, regions) = (basis.ncols(), pencil.n_regions());
    let projected = |matrix: &crate::fem::SymmetricMatrix| {
        let mut image = Mat::zeros(basis.nrows(), r);
        matrix.mul_into(basis, image.as_mut());
        let product = symmetric_part((basis.transpose() * image).as_ref());
        (0..r * r).map(move |k| product[(k / r, k % r)])
    };
    vec![
        Draft::f64s(
            SectionKind::RegionStiffness,
            [regions, r, r],
            (0..regions).flat_map(|q| projected(pencil.region_stiffness(q))),
        ),
        Draft::f64s(
            SectionKind::RegionMass,
            [regions, r, r],
            (0..regions).flat_map(|q| projected(pencil.region_mass(q))),
        ),
    ]
}

/// Rows of a matrix over the free dofs at the three dofs of each node, zero where held: shape (nodes, 3, r).
fn node_rows<'a>(
    dofs: &'a DofMap,
    matrix: MatRef<'a, f64>,
    nodes: &'a [u32],
) -> impl Iterator<Item = f64> + 'a {
    nodes.iter().flat_map(move |&node| {
        (0..3).flat_map(move |component| {
            let dof = 3 * node as usize + component;
            (0..matrix.ncols()).map(move |k| dofs.value(dof, |row| matrix[(row, k)]))
        })
    })
}

/// Sections for people: how the error fell with the terms, how stable the step is over the box, and what was
/// repaired.
fn separation_sections(report: &SeparationRecord) -> Vec<Draft> {
    let history = report.history_terms.iter().zip(&report.history);
    let radii = report.radius_samples.iter().map(|s| s.values.iter().copied().chain([s.spectral_radius]));
    let columns = report.radius_samples.first().map_or(0, |s| s.values.len() + 1);
    let mut drafts = vec![
        Draft::f64s(
            SectionKind::EnrichmentHistory,
            [report.history.len(), 2, 1],
            history.flat_map(|(&terms, &error)| [terms as f64, error]),
        ),
        Draft::f64s(SectionKind::RadiusSamples, [report.radius_samples.len(), columns, 1], radii.flatten()),
    ];
    if !report.repairs.is_empty() {
        drafts.push(Draft::names(SectionKind::Repairs, report.repairs.iter().map(String::as_str)));
    }
    drafts
}
