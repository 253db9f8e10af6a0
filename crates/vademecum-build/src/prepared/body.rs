//! From the problem to the body: the model with its supports, its loadable surface, its load patterns and its
//! probes.
//!
//! Names of the problem file meet the mesh here; what does not fit is an error that says what the mesh has.

use vademecum_format::{BASE_PATTERNS, base_field};

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use super::attachments::{attachments, first_dof};
use super::body_error::BodyError;
use super::gauge;
use super::heat;
use super::matrices::MatrixModel;
use super::places::{ends_between_nodes, facets, facets_within, located, select};
use super::ports::{Port, ports};
use super::quadrangle::Quadrangle;
use crate::fem::{COMPONENTS, Engine, Material, Model, StressPoint, stress_points};
use crate::input::{
    CENTRIFUGAL, Fields, GaugeEntry, MaterialEntry, PatternEntry, Problem, RaisedOrder, StressPlaces,
};
use crate::limits::MAGNITUDE;
use crate::mesh::select::numbered;
use crate::mesh::surface::Surface;
use crate::mesh::{self, Embedded, Mesh};
use crate::suggest::did_you_mean;

/// A named value that is linear in the displacements of some nodes.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Its name.
    pub name: String,
    /// Its unit: `m`, or `1` for a strain.
    pub unit: &'static str,
    /// Mesh nodes, and what a displacement there is multiplied by.
    pub nodes: Vec<(u32, [f64; 3])>,
}

/// A support: where it is, and which dofs it holds.
#[derive(Clone, Debug)]
pub struct Support {
    /// Its name.
    pub name: String,
    /// Mean of its nodes, about which its moment is taken.
    pub point: [f64; 3],
    /// The dofs it holds, ascending, without those that an earlier support holds.
    pub dofs: Vec<u32>,
    /// True if its limit lies between nodes: a finer mesh holds more.
    pub(crate) between_nodes: bool,
}

/// Components of the angular velocity whose product each centrifugal pattern is of.
const SPIN_PRODUCTS: [[usize; 2]; CENTRIFUGAL.len()] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];

/// A model with everything that can be done to it and read from it.
#[derive(Clone, Debug)]
pub struct Body {
    /// Mesh, materials, supports, matrices.
    pub model: Model,
    /// Linear triangles of the whole surface, outward, by mesh node.
    pub surface: Vec<[u32; 3]>,
    /// Linear triangles contacts may touch, by mesh node; a subset of `surface` in its order.
    pub loadable: Vec<[u32; 3]>,
    /// The quadrangular facets that `loadable` are the triangles of, in their order.
    pub(crate) quadrangles: Vec<Quadrangle>,
    /// Nodes forces may act on, ascending: those of `loadable`, or of a body without triangles the chosen
    /// ones.
    pub(crate) load_nodes: Vec<u32>,
    /// Load patterns: name and force over the free dofs, length n.
    pub patterns: Vec<(String, Vec<f64>)>,
    /// Of each pattern that is a temperature its place, and the thermal strain of each element.
    pub thermal: Vec<(usize, Vec<[[f64; 3]; 3]>)>,
    /// Part of each pattern on held dofs, over all dofs; empty for imported matrices.
    pub held_loads: Vec<Vec<(u32, f64)>>,
    /// Supports; none with imported matrices.
    pub supports: Vec<Support>,
    /// Centre of rotation of a moving base; its twelve motions are the last patterns.
    pub base: Option<[f64; 3]>,
    /// Probes, then gauges.
    pub probes: Vec<Probe>,
    /// Points of the stored stress.
    pub stress: Vec<StressPoint>,
    /// Ports, by which an assembly joins the body to others.
    pub ports: Vec<Port>,
    /// The surface that is drawn in place of that of the mesh.
    pub(crate) embedded: Option<Embedded>,
    /// Binds a file to its mesh.
    pub mesh_hash: [u8; 16],
}

impl Body {
    /// Number of free dofs n.
    pub fn n_dof(&self) -> usize {
        self.model.pencil().n_dof()
    }

    /// `D ε_T` at points under each pattern that is a temperature; empty of others.
    pub(crate) fn thermal_stress(&self, points: &[StressPoint]) -> Vec<Vec<[f64; COMPONENTS]>> {
        heat::stress(&self.model, (self.patterns.len(), &self.thermal), points)
    }

    /// Largest displacement of the loadable surface at a displacement over the free dofs \[m\].
    pub fn largest_displacement(&self, displacement: &[f64]) -> f64 {
        let dofs = self.model.dofs();
        let moved = |dof: u32| dofs.value(dof as usize, |free| displacement[free]);
        let square = |&node: &u32| (0..3).map(|c| moved(3 * node + c).powi(2)).sum::<f64>();
        self.load_nodes.iter().map(square).fold(0.0, f64::max).sqrt()
    }

    /// Mass, centre, moments of inertia and first centrifugal pattern of a body without supports, then force
    /// and moment about the centre of each pattern, as section 59 of a file has them; nothing of a body that
    /// is held.
    pub(crate) fn rigid_numbers(&self) -> Vec<f64> {
        let Some(rigid) = self.model.pencil().rigid() else { return vec![] };
        let first = self.patterns.len() - CENTRIFUGAL.len();
        let own = [rigid.mass].into_iter().chain(rigid.centre).chain(rigid.inertia).chain([first as f64]);
        let nodes = &self.model.mesh().nodes;
        own.chain(self.patterns.iter().flat_map(|(_, force)| rigid.resultant(nodes, force))).collect()
    }

    /// Nodes and shares of a force at a point of a loadable triangle, as the evaluator has them: of a facet
    /// that is a triangle its corners and the barycentric `weights`, of a quadrangle its shape functions.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn place(&self, triangle: usize, weights: [f64; 3]) -> (Vec<u32>, Vec<f64>) {
        let corners = self.loadable[triangle];
        let after = self.quadrangles.partition_point(|quadrangle| quadrangle.first <= triangle);
        match self.quadrangles[..after].last().filter(|facet| facet.triangles().contains(&triangle)) {
            Some(facet) => (facet.nodes.clone(), facet.shares(corners, weights)),
            None => (corners.to_vec(), weights.to_vec()),
        }
    }

    /// A probe as weights on free dofs.
    pub fn probe_row(&self, probe: &Probe) -> Vec<(u32, f64)> {
        let of_node = |&(node, weights): &(u32, [f64; 3])| {
            let dofs = self.model.dofs();
            (0..3).flat_map(move |c| {
                dofs.terms(3 * node as usize + c).map(move |(free, share)| (free, share * weights[c]))
            })
        };
        probe.nodes.iter().flat_map(of_node).collect()
    }

    /// Builds the body a problem describes; with an engine each rank assembles its rows of the matrices.
    ///
    /// # Errors
    /// [`BodyError`], by cause.
    pub fn build(
        problem: &Problem,
        mut mesh: Mesh,
        engine: Option<&Arc<dyn Engine>>,
    ) -> Result<Self, BodyError> {
        let mesh_hash = mesh::hash(&mesh);
        let surface = Surface::of(&mesh);
        let (constrained, supports) = supports(problem, &mesh, &surface)?;
        let materials = region_materials(problem, &mesh)?;
        let hexahedra = mesh.tetrahedra().is_none();
        for region in &mut mesh.regions {
            // It does nothing to a mesh of tetrahedra alone.
            let named =
                material_entry(problem, region).filter(|_| hexahedra).and_then(|entry| entry.hexahedra);
            region.hexahedra = named.or(region.hexahedra);
        }
        let (loadable, quadrangles) = loadable_facets(problem, &mesh, &surface, &constrained)?;
        let mut probes = probes(problem, &mesh);
        probes.extend(gauges(problem, &mesh, &surface)?);
        let embed =
            |file: &PathBuf| Embedded::read(&problem.resolve(file), problem.mesh.scale, &mesh, &surface);
        let embedded = problem.output.embedded.as_ref().map(embed).transpose()?;
        let stress = stress_places(problem, &mesh, &surface, embedded.as_ref())?;
        let unusable = |source| BodyError::Model { path: problem.place("support"), source };
        if engine.is_some() && (problem.has_attachments() || problem.prestress.is_some()) {
            return Err(BodyError::SpreadAttachments { path: problem.place("mesh") });
        }
        let model = if problem.has_attachments() {
            let attached = attachments(problem, &mesh, &surface, &materials)?;
            Model::assemble_attached(mesh, &materials, &constrained, attached).map_err(unusable)?
        } else {
            Model::assemble_on(engine, mesh, &materials, &constrained).map_err(unusable)?
        };
        let of_region = |region| material_entry(problem, region).map(MaterialEntry::thermal_strain);
        let regions = model.mesh().regions.iter();
        let expansions: Vec<_> = regions.map(|region| of_region(region).unwrap_or_default()).collect();
        let (mut patterns, mut held_loads, mut thermal) = (vec![], vec![], vec![]);
        for (i, entry) in problem.load.patterns.iter().enumerate() {
            let force = match heat::strain(problem, i, entry, (model.mesh(), &expansions))? {
                Some(strain) => {
                    let force = model.thermal_load(&strain);
                    thermal.push((i, strain));
                    force
                }
                None => pattern_force(problem, i, entry, &model, &surface)?,
            };
            let mut free = model.free_part(&force);
            if let Some(acceleration) = entry.acceleration {
                model.add_attached_weight(&problem.reference_places(), |_| acceleration, &mut free);
            }
            if let Some(point) = entry.reference.as_deref().and_then(|name| problem.reference_point(name)) {
                let loads = [entry.force, entry.moment].map(Option::unwrap_or_default);
                let loads = (first_dof(model.mesh(), point)..).zip(loads.into_iter().flatten());
                loads.for_each(|(dof, load)| model.add_force(dof as usize, load, &mut free));
            }
            patterns.push((entry.name.clone(), free));
            held_loads.push(held_part(&model, &force));
        }
        let spin = BASE_PATTERNS.len() - CENTRIFUGAL.len();
        let own = model.pencil().rigid().map(|rigid| rigid.centre).into_iter();
        let own = own.flat_map(|centre| (spin..).zip(CENTRIFUGAL).map(move |with| (centre, with)));
        let base = problem.base.moves.then_some(problem.base.point);
        let of_base = base.into_iter().flat_map(|at| (0..).zip(BASE_PATTERNS).map(move |with| (at, with)));
        for (origin, (motion, name)) in own.chain(of_base) {
            let from = |x: [f64; 3]| std::array::from_fn(|c| x[c] - origin[c]);
            let force = model.inertia_load(|x| base_field(motion, from(x)).map(|a| -a));
            let mut free = model.free_part(&force);
            if let Some(place) = motion.checked_sub(spin) {
                let product = SPIN_PRODUCTS[place];
                model.add_attached_spin(&problem.reference_places(), origin, (motion, product), &mut free);
            }
            patterns.push((name.into(), free));
            held_loads.push(held_part(&model, &force));
        }
        let ports = ports(problem, model.mesh(), &surface, model.dofs())?;
        Ok(Self {
            load_nodes: nodes_of(&loadable),
            ports,
            model,
            surface: surface.triangles,
            loadable,
            quadrangles,
            patterns,
            thermal,
            held_loads,
            supports,
            base,
            probes,
            stress,
            embedded,
            mesh_hash,
        })
    }

    /// Builds the body of a problem whose matrices another program has assembled.
    ///
    /// # Errors
    /// [`BodyError`], by cause.
    pub(crate) fn of_matrices(problem: &Problem, matrices: MatrixModel) -> Result<Self, BodyError> {
        let MatrixModel { mesh, constrained, pencil, triangles: surface } = matrices;
        let mesh_hash = mesh::hash(&mesh);
        let chosen = match &problem.load.surface {
            Some(selection) => select(problem, selection, &mesh, || LOAD_SURFACE.into())?,
            None => (0..mesh.nodes.len() as u32).collect(),
        };
        let inside = |t: &&[u32; 3]| t.iter().all(|node| chosen.binary_search(node).is_ok());
        let loadable = if surface.is_empty() {
            vec![]
        } else {
            movable(problem, surface.iter().filter(inside), &constrained)?
        };
        let load_nodes = if surface.is_empty() {
            chosen.into_iter().filter(|node| !held(&constrained, node)).collect()
        } else {
            nodes_of(&loadable)
        };
        if load_nodes.is_empty() {
            return Err(BodyError::NoFreeNode { path: problem.place(LOAD_SURFACE) });
        }
        let mut probes = probes(problem, &mesh);
        probes.extend(gauges(problem, &mesh, &Surface::of_triangles(surface.clone()))?);
        let unusable = |source| BodyError::Model { path: problem.place("mesh.matrices"), source };
        let model = Model::from_matrices(mesh, &constrained, pencil).map_err(unusable)?;
        let force = |entry: &PatternEntry| {
            let acceleration =
                entry.acceleration.expect("a checked pattern beside matrices is an acceleration");
            (entry.name.clone(), model.free_part(&model.body_load(acceleration)))
        };
        let patterns = problem.load.patterns.iter().map(force).collect();
        let (held_loads, supports, base) = (vec![], vec![], None);
        Ok(Self {
            model,
            surface,
            loadable,
            quadrangles: vec![],
            load_nodes,
            patterns,
            thermal: vec![],
            held_loads,
            supports,
            base,
            probes,
            stress: vec![],
            ports: vec![],
            embedded: None,
            mesh_hash,
        })
    }
}

/// Reads or makes the mesh a problem names, raises its order, scales it and cuts out the regions the problem
/// adds.
///
/// # Errors
/// [`BodyError`] if it cannot be read, is no usable solid, or a region is empty, or if the problem names
/// matrices instead.
pub fn read_mesh(problem: &Problem) -> Result<Mesh, BodyError> {
    let source = &problem.mesh;
    let mut mesh = if let Some(file) = &source.file {
        let mut raw = mesh::parse_with_cells(&problem.resolve(file), source.cells)?;
        raw.drop_small_parts(source.smallest_part);
        // Attachments join parts.
        if problem.has_attachments() { mesh::repaired_apart(&raw)? } else { mesh::repaired(raw, 0.0)? }
    } else if let Some(tables) = &source.tables {
        let [coordinates, connectivity] =
            [&tables.coordinates, &tables.connectivity].map(|path| problem.resolve(path));
        mesh::read_tables_without(&coordinates, &connectivity, source.smallest_part)?
    } else {
        let none = || BodyError::NoMesh { path: problem.place("mesh") };
        let block = source.block.as_ref().ok_or_else(none)?;
        mesh::block(block.lengths, block.divisions, block.order.into())
    };
    if source.order == Some(RaisedOrder::Quadratic) {
        mesh = mesh.raised();
    }
    mesh.nodes.iter_mut().flatten().for_each(|x| *x *= source.scale);
    check_size(problem, &mesh)?;
    for (i, region) in source.regions.iter().enumerate() {
        let nodes = select(problem, &region.on, &mesh, || format!("mesh.region[{i}].on"))?;
        if !cut_region(&mut mesh, &region.name, &nodes) {
            let path = problem.place(&format!("mesh.region[{i}]"));
            return Err(BodyError::EmptyRegion { path, name: region.name.clone() });
        }
    }
    Ok(mesh)
}

/// True if products of coordinates stay within double precision.
fn check_size(problem: &Problem, mesh: &Mesh) -> Result<(), BodyError> {
    let (low, high) = mesh.bounding_box();
    let largest = low.iter().chain(&high).fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    if size >= MAGNITUDE.0 && largest <= MAGNITUDE.1 {
        return Ok(());
    }
    Err(BodyError::Size { path: problem.place("mesh"), low, high })
}

/// Moves the elements all of whose corners are among `nodes` to a new region; false if there are none.
fn cut_region(mesh: &mut Mesh, name: &str, nodes: &[u32]) -> bool {
    let mut chosen = vec![false; mesh.nodes.len()];
    nodes.iter().for_each(|&node| chosen[node as usize] = true);
    let tag = 1 + mesh.regions.iter().map(|r| r.tag).max().unwrap_or(0);
    let new = mesh.regions.len() as u32;
    mesh.regions.push(mesh::Region::new(tag, name));
    let elements = mesh.kinds.each(&mesh.elements);
    for ((kind, element), region) in elements.zip(&mut mesh.element_region) {
        if element[..kind.corners()].iter().all(|&node| chosen[node as usize]) {
            *region = new;
        }
    }
    drop_empty_regions(mesh);
    mesh.regions.iter().any(|r| r.tag == tag)
}

fn drop_empty_regions(mesh: &mut Mesh) {
    let used = |q: &usize| mesh.element_region.iter().any(|&r| r as usize == *q);
    let kept: Vec<usize> = (0..mesh.regions.len()).filter(used).collect();
    let place =
        |q: u32| kept.iter().position(|&k| k == q as usize).expect("an element's region is kept") as u32;
    let renumbered: Vec<u32> = mesh.element_region.iter().map(|&q| place(q)).collect();
    mesh.element_region = renumbered;
    mesh.regions = kept.iter().map(|&q| mesh.regions[q].clone()).collect();
}

/// Which of the `3 × nodes` dofs are held, and by which support: a dof belongs to the first that names it.
fn supports(
    problem: &Problem,
    mesh: &Mesh,
    surface: &Surface,
) -> Result<(Vec<bool>, Vec<Support>), BodyError> {
    let mut constrained = vec![false; 3 * mesh.nodes.len()];
    let mut supports = vec![];
    for (i, support) in problem.supports.iter().enumerate() {
        let nodes = select(problem, &support.on, mesh, || format!("support[{i}].on"))?;
        let mut dofs = vec![];
        for &node in &nodes {
            for &component in &support.components {
                let dof = 3 * node + component as u32;
                if !std::mem::replace(&mut constrained[dof as usize], true) {
                    dofs.push(dof);
                }
            }
        }
        dofs.sort_unstable();
        let count = nodes.len().max(1) as f64;
        let mean = |c: usize| nodes.iter().map(|&node| mesh.nodes[node as usize][c] / count).sum();
        supports.push(Support {
            name: support.name(i),
            point: std::array::from_fn(mean),
            dofs,
            between_nodes: ends_between_nodes(&support.on, mesh, surface, &nodes),
        });
    }
    Ok((constrained, supports))
}

/// Part of a load over all dofs that acts on held ones.
fn held_part(model: &Model, load: &[f64]) -> Vec<(u32, f64)> {
    let held = |&(dof, force): &(u32, f64)| force != 0.0 && model.dofs().is_held(dof as usize);
    (0..).zip(load.iter().copied()).filter(held).collect()
}

/// The sentence about a region that the mesh does not have: none of its name was declared, or it has lost
/// its elements.
pub(super) fn not_a_region(problem: &Problem, name: &str) -> String {
    match problem.mesh.regions.iter().position(|region| region.name == name) {
        Some(i) => format!(
            "`{name}` is `mesh.region[{i}]`, but later regions take all its elements: declare it after them, or leave it out"
        ),
        None => format!("`{name}` is no region"),
    }
}

/// True if a material names a region by its name or tag.
fn names_region(entry: &MaterialEntry, region: &mesh::Region) -> bool {
    entry.region == region.name || entry.region == region.tag.to_string()
}

/// The material of a region: the one that names it, else the one for `"*"`.
pub(super) fn material_entry<'p>(problem: &'p Problem, region: &mesh::Region) -> Option<&'p MaterialEntry> {
    let named = problem.materials.iter().find(|entry| names_region(entry, region));
    named.or_else(|| problem.materials.iter().find(|entry| entry.region == "*"))
}

/// One material per region: the one that names it (by name or tag), else the one for `"*"`.
fn region_materials(problem: &Problem, mesh: &Mesh) -> Result<Vec<Material>, BodyError> {
    let names = || mesh.regions.iter().map(|r| format!("`{}`", r.name)).collect::<Vec<_>>().join(", ");
    let error = |key: &str, found, nearest: &str| BodyError::Region {
        path: problem.place(key),
        found,
        regions: names() + nearest,
    };
    for (i, entry) in problem.materials.iter().enumerate().filter(|(_, entry)| entry.region != "*") {
        if !mesh.regions.iter().any(|region| names_region(entry, region)) {
            let nearest = did_you_mean(&entry.region, mesh.regions.iter().map(|r| r.name.as_str()));
            let (key, found) = (format!("material[{i}].region"), not_a_region(problem, &entry.region));
            return Err(error(&key, found, &nearest));
        }
    }
    let material = |region: &mesh::Region| {
        let entry = material_entry(problem, region)
            .ok_or_else(|| error("material", format!("no material for region `{}`", region.name), ""))?;
        let elasticity = entry.elasticity().expect("checked constants of a solid");
        Ok(Material { elasticity, density: entry.density })
    };
    mesh.regions.iter().map(material).collect()
}

/// Triangles of the selected surface that can move, and the quadrangles that these are parts of: a quadrangle
/// is loaded as a whole, so its triangles stay together.
fn loadable_facets(
    problem: &Problem,
    mesh: &Mesh,
    surface: &Surface,
    constrained: &[bool],
) -> Result<(Vec<[u32; 3]>, Vec<Quadrangle>), BodyError> {
    let selected = match &problem.load.surface {
        Some(selection) => {
            let nodes = select(problem, selection, mesh, || LOAD_SURFACE.into())?;
            facets_within(surface, mesh.nodes.len(), &nodes)
        }
        None => (0..surface.facet_count()).collect(),
    };
    let mut chosen = vec![false; surface.facet_count()];
    selected.into_iter().for_each(|facet| chosen[facet] = true);
    let (mut loadable, mut quadrangles): (Vec<[u32; 3]>, Vec<Quadrangle>) = (vec![], vec![]);
    for (triangle, &facet) in surface.triangles.iter().zip(&surface.triangle_facet) {
        let facet = facet as usize;
        let kind = surface.facet_kind(facet);
        let nodes = if kind.corners() == 3 { &triangle[..] } else { surface.facet(facet) };
        if !chosen[facet] || nodes.iter().all(|node| held(constrained, node)) {
            continue;
        }
        let known = quadrangles.last().map_or(0, |last| last.triangles().end);
        if kind.corners() > 3 && known <= loadable.len() {
            quadrangles.push(Quadrangle { kind, first: loadable.len(), nodes: nodes.to_vec() });
        }
        loadable.push(*triangle);
    }
    Ok((some_movable(problem, chosen.contains(&true), loadable)?, quadrangles))
}

/// The key that chooses where forces may act.
const LOAD_SURFACE: &str = "load.surface";

/// True if no component of a node is free.
fn held(constrained: &[bool], node: &u32) -> bool {
    (0..3).all(|c| constrained[3 * *node as usize + c])
}

/// Those of the chosen triangles that are not held entirely.
fn movable<'a>(
    problem: &Problem,
    triangles: impl Iterator<Item = &'a [u32; 3]>,
    constrained: &[bool],
) -> Result<Vec<[u32; 3]>, BodyError> {
    let held = |node: &u32| held(constrained, node);
    let mut triangles = triangles.peekable();
    let some = triangles.peek().is_some();
    some_movable(problem, some, triangles.filter(|t| !t.iter().all(held)).copied().collect())
}

/// The loadable triangles, if there are any; `some` tells whether any were chosen.
fn some_movable(problem: &Problem, some: bool, loadable: Vec<[u32; 3]>) -> Result<Vec<[u32; 3]>, BodyError> {
    if loadable.is_empty() && some {
        return Err(BodyError::NoFreeNode { path: problem.place(LOAD_SURFACE) });
    }
    if loadable.is_empty() {
        return Err(BodyError::NoFacet { path: problem.place(LOAD_SURFACE), key: LOAD_SURFACE.into() });
    }
    Ok(loadable)
}

/// Nodes of triangles, ascending and unique.
fn nodes_of(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut nodes = triangles.as_flattened().to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

fn pattern_force(
    problem: &Problem,
    index: usize,
    entry: &PatternEntry,
    model: &Model,
    surface: &Surface,
) -> Result<Vec<f64>, BodyError> {
    if let Some(acceleration) = entry.acceleration {
        return Ok(model.body_load(acceleration));
    }
    if entry.reference.is_some() {
        return Ok(vec![0.0; model.dofs().n_dof()]);
    }
    if let Some(forces) = &entry.forces {
        let key = || format!("load.pattern[{index}].forces");
        let ids: Vec<u64> = forces.iter().map(|force| force.0).collect();
        let nodes = numbered(&ids, model.mesh()).map_err(|source| located(problem, &key, source))?;
        let mut load = vec![0.0; model.dofs().n_dof()];
        for (node, force) in nodes.into_iter().zip(forces) {
            let sums = &mut load[3 * node as usize..][..3];
            sums.iter_mut().zip(force.force()).for_each(|(sum, f)| *sum += f);
        }
        return Ok(load);
    }
    let key = || format!("load.pattern[{index}].on");
    let selection = entry.on.as_ref().expect("a checked pattern without acceleration has a place");
    let facets = facets(problem, selection, model.mesh(), surface, key)?;
    Ok(match (entry.traction, entry.pressure) {
        (Some(traction), _) => model.traction_load(&facets, traction),
        (None, pressure) => model.pressure_load(&facets, pressure.unwrap_or(0.0)),
    })
}

fn probes(problem: &Problem, mesh: &Mesh) -> Vec<Probe> {
    let probe = |entry: &crate::input::ProbeEntry| {
        let length = entry.direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        Probe {
            name: entry.name.clone(),
            unit: "m",
            nodes: vec![(nearest_place(problem, mesh, entry.point), entry.direction.map(|c| c / length))],
        }
    };
    problem.output.probes.iter().map(probe).collect()
}

/// Strain gauges as probes.
fn gauges(problem: &Problem, mesh: &Mesh, surface: &Surface) -> Result<Vec<Probe>, BodyError> {
    let placed = |(i, entry): (usize, &GaugeEntry)| {
        let path = || problem.place(&format!("output.gauge[{i}]"));
        let nodes = gauge::nodes(mesh, surface, entry).map_err(|source| BodyError::Gauge {
            path: path(),
            name: entry.name.clone(),
            source,
        })?;
        Ok(Probe { name: entry.name.clone(), unit: "1", nodes })
    };
    problem.output.gauges.iter().enumerate().map(placed).collect()
}

/// Points of the stored stress, in the order of the nodes.
fn stress_places(
    problem: &Problem,
    mesh: &Mesh,
    surface: &Surface,
    embedded: Option<&Embedded>,
) -> Result<Vec<StressPoint>, BodyError> {
    let nodes = match &problem.output.stress {
        None => return Ok(vec![]),
        Some(StressPlaces::Every(Fields::Body)) => (0..mesh.nodes.len() as u32).collect(),
        Some(StressPlaces::Every(Fields::Surface)) => {
            // Vertices of an embedded surface follow nodes below the surface too.
            let followed = embedded.iter().flat_map(|embedded| embedded.nodes.as_flattened());
            let all: BTreeSet<u32> = surface.nodes.iter().chain(followed).copied().collect();
            all.into_iter().collect()
        }
        Some(StressPlaces::Chosen(selection)) => select(problem, selection, mesh, || "output.stress".into())?,
    };
    Ok(stress_points(mesh, &nodes))
}

/// The mesh node or reference point nearest to a point, the first of equals; a reference point stands for
/// its displacements, behind those of the nodes.
fn nearest_place(problem: &Problem, mesh: &Mesh, point: [f64; 3]) -> u32 {
    let distance = |node: &[f64; 3]| (0..3).map(|c| (node[c] - point[c]).powi(2)).sum::<f64>();
    let nodes = (0..).zip(&mesh.nodes);
    let points = problem.reference_points.iter().enumerate();
    let points = points.map(|(i, point)| (first_dof(mesh, i) / 3, &point.at));
    nodes.chain(points).min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).map_or(0, |place| place.0)
}
