//! A body: mesh, supports and materials, with its matrices; or nodes and the matrices of another program.

use std::sync::Arc;

use faer::{Mat, MatRef};
use vademecum_format::base_field;

use super::assembly::{NodeGraph, assemble, couple};
use super::blocks::{Block, BlockGroups, ElementMatrices, assemble_blocks, assemble_split, held_columns};
use super::dampers::{Dampers, DampingBlock};
use super::dofs::DofMap;
use super::elimination::{Constraints, Elimination};
use super::engine::Engine;
use super::freedom::{Freedom, MOTIONS, Places, meets_rigid_motion};
use super::material::Material;
use super::model_error::ModelError;
use super::pencil::Pencil;
use super::prestress::Prestress;
use super::rigid::RigidBody;
use super::whole::AssemblyPlan;
use crate::linalg::vec3::sub;
use crate::mesh::Mesh;
use crate::store::{Inputs, StageInput};

/// A supported body at full order.
#[derive(Clone, Debug)]
pub struct Model {
    mesh: Arc<Mesh>,
    materials: Vec<Material>,
    dofs: Arc<DofMap>,
    pencil: Pencil,
    attached: Option<Arc<Attached>>,
}

/// Attachments of a body, the constraints between its dofs, and the state about which it moves.
#[derive(Clone, Debug)]
struct Attached {
    blocks: Vec<Block>,
    groups: Option<BlockGroups>,
    elimination: Elimination,
    prestress: Option<Prestress>,
}

/// Attachments of a body over its dofs: three for each node of the mesh, then those of reference points.
#[derive(Clone, Debug, Default)]
pub struct Attachments {
    /// Couplings, ties and equations.
    pub constraints: Constraints,
    /// Masses and springs.
    pub blocks: Vec<Block>,
    /// Their groups, where the pencil is to have the matrices of each region.
    pub groups: Option<BlockGroups>,
    /// Dashpots.
    pub dashpots: Vec<DampingBlock>,
    /// Places of the reference points, six dofs each.
    pub points: Vec<[f64; 3]>,
}

impl Attached {
    /// Matrices of single elements about the state.
    fn elements<'a>(
        &'a self,
        mesh: &'a Mesh,
        materials: &'a [Material],
        lumped: &'a [bool],
    ) -> ElementMatrices<'a> {
        let elements = ElementMatrices::new(mesh, materials, lumped);
        self.prestress.iter().fold(elements, |elements, state| elements.about(state))
    }
}

impl Attachments {
    /// True if nothing is attached.
    pub fn is_empty(&self) -> bool {
        let blocks = self.blocks.is_empty() && self.dashpots.is_empty();
        blocks && self.points.is_empty() && self.constraints.dofs().next().is_none()
    }
}

impl Model {
    /// Assembles consistent mass and stiffness. `materials` holds one entry per region of the mesh,
    /// `constrained` one flag per dof `3 · node + component`. Where none is held, the body is free: its
    /// pencil has the rigid motions.
    ///
    /// Elements in parallel, the same bits for any number of threads; allocates the matrices and, while it
    /// runs, as much again.
    ///
    /// # Errors
    /// [`ModelError`]: counts that do not fit, an unsound material, a folded element, a part of the body left
    /// free to move.
    pub fn assemble(mesh: Mesh, materials: &[Material], constrained: &[bool]) -> Result<Model, ModelError> {
        Model::assemble_on(None, mesh, materials, constrained)
    }

    /// The same, with an engine each rank its own rows. The matrices are then not in this process unless
    /// something asks for their entries.
    ///
    /// # Errors
    /// As [`Model::assemble`]; [`ModelError::Engine`].
    pub(crate) fn assemble_on(
        engine: Option<&Arc<dyn Engine>>,
        mesh: Mesh,
        materials: &[Material],
        constrained: &[bool],
    ) -> Result<Model, ModelError> {
        check_counts(&mesh, materials, constrained)?;
        let free = !constrained.contains(&true);
        if free {
            check_one_part(&mesh)?;
        } else {
            check_supports(&mesh, constrained)?;
        }
        let (mesh, dofs) = (Arc::new(mesh), Arc::new(DofMap::new(constrained)));
        if dofs.n_free() == 0 || mesh.elements.is_empty() {
            return Err(ModelError::NothingFree);
        }
        let mut pencil = match engine {
            None => assemble(&mesh, materials, &dofs)?,
            Some(engine) => {
                let whole = Arc::new(AssemblyPlan::new(mesh.clone(), materials, dofs.clone())?);
                let rows = engine.assemble(&whole)?;
                Pencil::spread(rows, whole.away())
            }
        };
        if free {
            let rigid = RigidBody::new(&mesh.nodes, pencil.mass());
            pencil = pencil.with_rigid(rigid);
        }
        Ok(Model { mesh, materials: materials.to_vec(), dofs, pencil, attached: None })
    }

    /// The same with attachments, by elimination of the dependent dofs: `TᵀMT` and `TᵀKT`. All regions
    /// together, unless [`Attachments::groups`] are given: the pencil has one. Where neither supports nor
    /// attachments hold the body as a whole, it is free, and its pencil has the rigid motions. Parts of a
    /// held body that attachments alone hold are seen when the stiffness is factorised.
    ///
    /// # Errors
    /// As [`Model::assemble`]; [`ModelError::Contradiction`], [`ModelError::Coupled`],
    /// [`ModelError::PartlyHeld`], [`ModelError::Mechanism`], [`ModelError::DampedFlight`].
    pub fn assemble_attached(
        mesh: Mesh,
        materials: &[Material],
        constrained: &[bool],
        attachments: Attachments,
    ) -> Result<Model, ModelError> {
        check_counts(&mesh, materials, constrained)?;
        let Attachments { mut constraints, blocks, groups, dashpots, points } = attachments;
        let held = (0..).zip(constrained).filter(|(_, held)| **held);
        held.for_each(|(dof, _)| constraints.hold(dof, 0.0));
        let places = Places { nodes: &mesh.nodes, points: &points };
        let free = is_free(&mesh, places, &constraints, &blocks)?;
        let elimination = constraints.eliminate(constrained.len() + MOTIONS * points.len())?;
        let lumped = vec![false; mesh.regions.len()];
        let elements = ElementMatrices::new(&mesh, materials, &lumped);
        let pencil = assemble_split(&elements, &blocks, groups.as_ref(), &elimination)?;
        let dofs = Arc::new(DofMap::of_elimination(mesh.nodes.len(), &elimination));
        let mut pencil = pencil.with_dampers(Dampers::of(&dashpots, &dofs)?);
        if free {
            if dashpots.iter().any(|one| meets_rigid_motion(places, &one.dofs, &one.damping)) {
                return Err(ModelError::DampedFlight);
            }
            let rows = |about| elimination.free().iter().map(|&dof| places.row(dof, about)).collect();
            let solid = |free: usize| (elimination.free()[free] as usize) < places.of_mesh();
            let rigid = RigidBody::of_rows(pencil.mass(), rows, solid, points.clone());
            pencil = pencil.with_rigid(rigid);
        }
        let attached = Some(Arc::new(Attached { blocks, groups, elimination, prestress: None }));
        Ok(Model { mesh: Arc::new(mesh), materials: materials.to_vec(), dofs, pencil, attached })
    }

    /// The same body with a loss factor of each region.
    pub(crate) fn with_loss(self, loss: Vec<f64>) -> Model {
        Model { pencil: self.pencil.with_loss(loss), ..self }
    }

    /// The same body about a static state under dead loads: `K + K_σ`, with the softening of rotations, which
    /// act on attached masses too. All regions together: the pencil has one.
    ///
    /// # Errors
    /// [`ModelError::TooLarge`], [`ModelError::Contradiction`].
    pub(crate) fn about(&self, prestress: Prestress) -> Result<Model, ModelError> {
        let (mut blocks, elimination) = match &self.attached {
            Some(attached) => (attached.blocks.clone(), attached.elimination.clone()),
            None => {
                let mut constraints = Constraints::default();
                let held = (0..self.dofs.n_dof()).filter(|&dof| self.dofs.is_held(dof));
                held.for_each(|dof| constraints.hold(dof as u32, 0.0));
                (vec![], constraints.eliminate(self.dofs.n_dof())?)
            }
        };
        for Block { mass, stiffness, .. } in &mut blocks {
            prestress.rotations.iter().for_each(|rotation| rotation.soften(mass, stiffness));
        }
        let attached = Attached { blocks, groups: None, elimination, prestress: Some(prestress) };
        let lumped = vec![false; self.mesh.regions.len()];
        let elements = attached.elements(&self.mesh, &self.materials, &lumped);
        let pencil = assemble_blocks(&elements, &attached.blocks, &attached.elimination)?;
        let pencil = pencil.with_dampers(self.pencil.dampers().clone());
        Ok(Model { pencil, attached: Some(Arc::new(attached)), ..self.clone() })
    }

    /// Adds the forces of an acceleration on attached masses to a load over the free dofs; `points` are the
    /// places of the reference points.
    pub(crate) fn add_attached_weight(
        &self,
        points: &[[f64; 3]],
        acceleration: impl Fn([f64; 3]) -> [f64; 3],
        load: &mut [f64],
    ) {
        for block in self.attached.iter().flat_map(|attached| &attached.blocks) {
            // Reference points have three displacements, then three rotations.
            let of_dof = |dof: u32| match dof.checked_sub(self.dofs.n_dof() as u32) {
                Some(place) if place % 6 >= 3 => 0.0,
                Some(place) => acceleration(points[place as usize / 6])[place as usize % 6],
                None => acceleration(self.mesh.nodes[dof as usize / 3])[dof as usize % 3],
            };
            for (row, &dof) in block.dofs.iter().enumerate() {
                let columns = block.dofs.iter().enumerate();
                let force = columns.map(|(column, &other)| block.mass[(row, column)] * of_dof(other)).sum();
                self.add_force(dof as usize, force, load);
            }
        }
    }

    /// Adds the centrifugal forces on attached masses to a load over the free dofs, `−M(ω × (ω × x))` and, of
    /// their moments of inertia `J`, `−ω × Jω`: the part of the product of two components of `ω`, with `x`
    /// from `origin`.
    pub(crate) fn add_attached_spin(
        &self,
        points: &[[f64; 3]],
        origin: [f64; 3],
        (motion, [i, j]): (usize, [usize; 2]),
        load: &mut [f64],
    ) {
        self.add_attached_weight(points, |x| base_field(motion, sub(x, origin)).map(|a| -a), load);
        for block in self.attached.iter().flat_map(|attached| &attached.blocks) {
            let turn = |dof: u32| {
                let place = (dof as usize).checked_sub(self.dofs.n_dof())?;
                (place % MOTIONS >= 3).then_some((place / MOTIONS, place % MOTIONS - 3))
            };
            let turns: Vec<(usize, usize, usize)> = (0..)
                .zip(&block.dofs)
                .filter_map(|(row, &dof)| turn(dof).map(|(p, c)| (row, p, c)))
                .collect();
            for &(row, point, a) in &turns {
                let about: Vec<_> = turns.iter().filter(|other| other.1 == point).collect();
                // Component a of J e_k.
                let of = |c: usize, k: usize| -> f64 {
                    let first = about.iter().find(|other| other.2 == c);
                    let second = about.iter().find(|other| other.2 == k);
                    first.zip(second).map_or(0.0, |(first, second)| block.mass[(first.0, second.0)])
                };
                // −(e_i × J e_k)_a
                let moment = |i: usize, k: usize| match (a + 3 - i) % 3 {
                    1 => of((i + 2) % 3, k),
                    2 => -of((i + 1) % 3, k),
                    _ => 0.0,
                };
                let sum = if i == j { moment(i, i) } else { moment(i, j) + moment(j, i) };
                self.add_force(block.dofs[row] as usize, sum, load);
            }
        }
    }

    /// True of a body of elements alone: nothing is attached to it, and it has no prestress.
    pub fn is_bare(&self) -> bool {
        self.attached.is_none()
    }

    /// True if the body moves about a loaded state.
    pub(crate) fn is_prestressed(&self) -> bool {
        self.attached.as_ref().is_some_and(|attached| attached.prestress.is_some())
    }

    /// Takes matrices that another program assembled. `mesh` has nodes and no elements, `constrained` one
    /// flag per dof (node by node, x y z), `pencil` one row per free dof, ascending. Whether the body is held
    /// shows when its stiffness is factorised.
    ///
    /// # Errors
    /// [`ModelError::SupportCount`], [`ModelError::NothingFree`], [`ModelError::PencilSize`].
    pub fn from_matrices(mesh: Mesh, constrained: &[bool], pencil: Pencil) -> Result<Model, ModelError> {
        check_support_count(&mesh, constrained)?;
        let dofs = Arc::new(DofMap::new(constrained));
        let (found, expected) = (pencil.n_dof(), dofs.n_free());
        if expected == 0 {
            return Err(ModelError::NothingFree);
        }
        if found != expected {
            return Err(ModelError::PencilSize { found, expected });
        }
        let nodes = dofs.dof_of_free().iter().map(|dof| dof / 3).collect();
        let mesh = Arc::new(mesh);
        Ok(Model { mesh, materials: vec![], dofs, pencil: pencil.with_dof_nodes(nodes), attached: None })
    }

    /// `K_fs t` and `M_fs t` over the free dofs, for displacements `t` of held dofs: shape (n_dof, columns),
    /// zero at free dofs. Zeros where the matrices came from another program.
    pub(crate) fn couple(&self, t: MatRef<'_, f64>) -> [Mat<f64>; 2] {
        self.couple_regions(t, &|_| true)
    }

    /// [`Self::couple`] of some regions of the pencil.
    pub(crate) fn couple_regions(
        &self,
        t: MatRef<'_, f64>,
        is_counted: &dyn Fn(usize) -> bool,
    ) -> [Mat<f64>; 2] {
        let found = match &self.attached {
            None => couple(&self.mesh, &self.materials, &self.dofs, t, is_counted).map_err(|_| ()),
            Some(attached) => {
                let lumped = vec![false; self.mesh.regions.len()];
                let elements = attached.elements(&self.mesh, &self.materials, &lumped);
                let others = (&attached.blocks[..], attached.groups.as_ref());
                held_columns(&elements, others, &attached.elimination, t, is_counted).map_err(|_| ())
            }
        };
        found.expect("the assembled mesh has no folded element")
    }

    /// The six rigid motions over the free dofs, shape (n_dof, 6): shifts along x, y, z, turns about axes
    /// through the middle of the nodes.
    pub fn rigid_motions(&self) -> Mat<f64> {
        let nodes = &self.mesh.nodes;
        let mean = |c: usize| nodes.iter().map(|node| node[c]).sum::<f64>() / nodes.len() as f64;
        let middle: [f64; 3] = std::array::from_fn(mean);
        let free = self.dofs.dof_of_free();
        Mat::from_fn(free.len(), 6, |row, k| {
            let (node, c) = (nodes[free[row] as usize / 3], free[row] as usize % 3);
            let about = |axis: usize| match (c + 3 - axis) % 3 {
                // The unit vector of the axis times the arm.
                1 => -(node[(axis + 2) % 3] - middle[(axis + 2) % 3]),
                2 => node[(axis + 1) % 3] - middle[(axis + 1) % 3],
                _ => 0.0,
            };
            if k < 3 { f64::from(u8::from(c == k)) } else { about(k - 3) }
        })
    }

    /// The mesh; nodes without elements where the matrices came from another program.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// One material per region; none where the matrices came from another program.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Which dofs are free.
    pub fn dofs(&self) -> &DofMap {
        &self.dofs
    }

    /// The matrices over the free dofs.
    pub fn pencil(&self) -> &Pencil {
        &self.pencil
    }
}

fn check_counts(mesh: &Mesh, materials: &[Material], constrained: &[bool]) -> Result<(), ModelError> {
    if materials.len() != mesh.regions.len() {
        return Err(ModelError::MaterialCount { found: materials.len(), expected: mesh.regions.len() });
    }
    check_support_count(mesh, constrained)?;
    for (material, region) in materials.iter().zip(&mesh.regions) {
        if !material.is_sound() {
            return Err(ModelError::UnsoundMaterial {
                region: region.name.clone(),
                material: Box::new(*material),
            });
        }
    }
    Ok(())
}

fn check_support_count(mesh: &Mesh, constrained: &[bool]) -> Result<(), ModelError> {
    let (found, expected) = (constrained.len(), 3 * mesh.nodes.len());
    if found == expected { Ok(()) } else { Err(ModelError::SupportCount { found, expected }) }
}

/// True of a body that neither supports nor attachments hold.
///
/// # Errors
/// [`ModelError::PartlyHeld`], [`ModelError::Mechanism`].
fn is_free(
    mesh: &Mesh,
    places: Places<'_>,
    constraints: &Constraints,
    blocks: &[Block],
) -> Result<bool, ModelError> {
    let parts = connected_parts(mesh);
    let mut part = vec![0; mesh.nodes.len()];
    for (number, nodes) in (0..).zip(&parts) {
        nodes.iter().for_each(|&node| part[node as usize] = number);
    }
    let found = Freedom::new(places, (part, parts.len()), constraints, blocks)?;
    match (found.rigid, found.all) {
        (0, _) => Ok(false),
        (MOTIONS, Some(all)) if all > MOTIONS => Err(ModelError::Mechanism { more: all - MOTIONS }),
        (MOTIONS, _) => Ok(true),
        (n_modes, _) => Err(ModelError::PartlyHeld {
            holder: found.holder.unwrap_or_default(),
            n_modes,
            named: found.named.join(", "),
        }),
    }
}

/// A body without supports is one part.
fn check_one_part(mesh: &Mesh) -> Result<(), ModelError> {
    let parts = connected_parts(mesh);
    let Some(second) = parts.get(1) else { return Ok(()) };
    let node = mesh.node_ids.get(second[0] as usize).copied().unwrap_or(u64::from(second[0]));
    Err(ModelError::FreeParts { parts: parts.len(), node, n_nodes: second.len() })
}

/// Every connected part must be held against its six rigid-body modes.
fn check_supports(mesh: &Mesh, constrained: &[bool]) -> Result<(), ModelError> {
    for part in connected_parts(mesh) {
        let (centre, size) = extent(mesh, part.iter().copied());
        let n_modes = 6 - held_modes(mesh, &part, constrained, centre, size);
        if n_modes == 0 {
            continue;
        }
        let (node, n_nodes) = (mesh.node_ids.get(part[0] as usize).copied(), part.len());
        let node = node.unwrap_or(u64::from(part[0]));
        // Seen from nearby the same supports may hold it.
        let held = part.iter().copied().filter(|&n| (0..3).any(|c| constrained[3 * n as usize + c]));
        let (near, span) = extent(mesh, held);
        if held_modes(mesh, &part, constrained, near, span) == 6 {
            return Err(ModelError::SupportTooSmall { node, n_nodes, size, span });
        }
        return Err(ModelError::Unsupported { node, n_nodes, n_modes });
    }
    Ok(())
}

/// Centre and largest edge of the box around nodes; of no nodes the origin, and no edge.
fn extent(mesh: &Mesh, nodes: impl Iterator<Item = u32> + Clone) -> ([f64; 3], f64) {
    let corner = |pick: fn(f64, f64) -> f64| -> [f64; 3] {
        std::array::from_fn(|i| nodes.clone().map(|n| mesh.nodes[n as usize][i]).reduce(pick).unwrap_or(0.0))
    };
    let (low, high) = (corner(f64::min), corner(f64::max));
    let size = (0..3).map(|i| high[i] - low[i]).fold(f64::MIN_POSITIVE, f64::max);
    (std::array::from_fn(|i| 0.5 * (low[i] + high[i])), size)
}

/// Nodes of each part connected through elements.
fn connected_parts(mesh: &Mesh) -> Vec<Vec<u32>> {
    let graph = NodeGraph::of(mesh);
    let mut seen = vec![false; mesh.nodes.len()];
    let mut parts = Vec::new();
    for start in 0..mesh.nodes.len() {
        if std::mem::replace(&mut seen[start], true) {
            continue;
        }
        let mut part = vec![start as u32];
        let mut next = 0;
        while next < part.len() {
            for &other in graph.row(part[next] as usize) {
                if !std::mem::replace(&mut seen[other as usize], true) {
                    part.push(other);
                }
            }
            next += 1;
        }
        parts.push(part);
    }
    parts
}

/// Rank of the six rigid-body modes on the held dofs of a part, turning about `centre` by lengths in `size`.
fn held_modes(mesh: &Mesh, part: &[u32], constrained: &[bool], centre: [f64; 3], size: f64) -> usize {
    let mut gram = [[0.0; 6]; 6];
    for &node in part {
        let p = mesh.nodes[node as usize];
        let x: [f64; 3] = std::array::from_fn(|i| (p[i] - centre[i]) / size);
        // Rows of (translations | rotations): u = t + ω × x.
        let rows = [
            [1.0, 0.0, 0.0, 0.0, x[2], -x[1]],
            [0.0, 1.0, 0.0, -x[2], 0.0, x[0]],
            [0.0, 0.0, 1.0, x[1], -x[0], 0.0],
        ];
        for c in (0..3).filter(|&c| constrained[3 * node as usize + c]) {
            for i in 0..6 {
                for j in 0..6 {
                    gram[i][j] += rows[c][i] * rows[c][j];
                }
            }
        }
    }
    rank(gram)
}

/// Rank of a Gram matrix by elimination with diagonal pivots. A pivot below 1e-12 of the largest counts as
/// zero: it belongs to supports that span less than a millionth of the body, below what coordinates resolve.
fn rank(mut gram: [[f64; 6]; 6]) -> usize {
    let largest = (0..6).map(|i| gram[i][i]).fold(0.0, f64::max);
    let mut used = [false; 6];
    for found in 0..6 {
        let free = (0..6).filter(|&i| !used[i]);
        let Some(pivot) = free.max_by(|&i, &j| gram[i][i].total_cmp(&gram[j][j])) else {
            return found;
        };
        if gram[pivot][pivot] <= 1e-12 * largest {
            return found;
        }
        used[pivot] = true;
        for i in (0..6).filter(|&i| !used[i]) {
            let factor = gram[i][pivot] / gram[pivot][pivot];
            for j in 0..6 {
                gram[i][j] -= factor * gram[pivot][j];
            }
        }
    }
    6
}

/// The matrices of all regions on their pattern, and the dofs they stand for. Mesh, materials and supports
/// act on the dynamics through these alone.
impl StageInput for Model {
    fn add_to(&self, inputs: Inputs) -> Inputs {
        let shape = inputs.indices(self.dofs().dof_of_free()).value(&self.dofs().n_dof());
        if let Some(away) = self.pencil().away() {
            // Matrices on ranks are known by what they are assembled of.
            let mesh = self.mesh();
            let shape = shape.numbers(mesh.nodes.as_flattened()).indices(&mesh.elements);
            let shape = shape.indices(&mesh.element_region).indices(&away.order);
            let kinds: Vec<u32> = mesh.each().map(|(kind, _)| kind.vtk().into()).collect();
            let hexahedra: Vec<_> = mesh.regions.iter().map(|region| region.hexahedra).collect();
            return shape.indices(&kinds).value(&(hexahedra, self.materials()));
        }
        // Of a body without attachments the numbers of its free dofs say it all.
        let shape = if self.is_bare() { shape } else { self.dofs().add_dependent(shape) };
        let shape = self.pencil().dampers().add_to(shape);
        let (pencil, pattern) = (self.pencil(), self.pencil().mass().pattern());
        let shape = (0..pattern.n()).fold(shape, |inputs, j| inputs.indices(pattern.rows_of(j)));
        (0..pencil.n_regions()).fold(shape, |inputs, q| {
            inputs.numbers(pencil.region_mass(q).values()).numbers(pencil.region_stiffness(q).values())
        })
    }
}
