//! A problem on its mesh, ready to be computed with: the value that every stage after it reads.

mod attachments;
mod body;
mod body_error;
mod design;
mod gauge;
mod heat;
mod inertia;
mod interfaces;
mod matrices;
mod means;
mod parameters;
mod places;
mod ports;
mod prestress;
mod proposed;
mod quadrangle;
mod size;
mod time_step;

pub use body::{Body, Probe, Support, read_mesh};
pub use body_error::BodyError;
pub(crate) use design::Design;
pub use interfaces::{Coordinate, Interface, InterfaceError, InterfaceRows, interfaces};
pub use matrices::MatricesError;
pub(crate) use matrices::MatrixModel;
pub use means::FactorPrecision;
pub(crate) use means::Means;
pub(crate) use parameters::LiveRegions;
pub use parameters::{LiveParameter, ParameterSpace, Setting};
pub use ports::Port;
pub use proposed::{STEPS_PER_PERIOD, proposed_time_step};
pub(crate) use quadrangle::Quadrangle;
pub use time_step::TimeStepError;

use faer::{Mat, MatRef};
use vademecum_format::scheme::{SchemeTable, StepParameters, TableError};

use crate::dynamics::schemes::bathe;
use crate::dynamics::{
    DampingError, FirstMode, FullOrder, FullOrderError, ModalRatios, ModesError, Rayleigh, SchemeError,
    SchemeKind,
};
use crate::fem::{FactorError, Pencil, Solve, Symbolic, SymmetricMatrix};
use crate::input::{BasisKind, Problem, ProblemError};
use crate::limits::TooMuchMemory;
use crate::linalg::Random;
use crate::mesh::{ElementKind, Hexahedra, Mesh, Order};
use crate::progress::{Listener, Stopwatch};
use crate::store::{Inputs, StageInput};

/// Why a problem cannot be computed with.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// Problem and mesh do not fit.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// The key that a body without supports excludes.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The damping feeds energy into some mode.
    #[error("`damping`")]
    Damping(#[from] DampingError),
    /// The scheme's parameters are unusable.
    #[error("`time.scheme`")]
    Scheme(#[from] SchemeError),
    /// The scheme's table is unusable.
    #[error("`time.scheme`")]
    Table(#[from] TableError),
    /// A matrix of another program is not positive definite.
    #[error("`mesh.matrices.{key}`: the {key} matrix cannot be computed with")]
    NotDefinite {
        /// `mass` or `stiffness`.
        key: &'static str,
        /// The stage that detected it.
        source: FactorError,
    },
    /// More memory than there is.
    #[error(transparent)]
    Memory(#[from] TooMuchMemory),
    /// The pattern of the matrices cannot be analysed.
    #[error("a matrix of the model does not factorise")]
    Factor(#[from] FactorError),
    /// No first natural mode to propose a time step from.
    #[error("natural modes, to propose `time.step`")]
    Modes(#[from] ModesError),
}

/// A model ready to be marched: what `build`, `verify` and `modes` start from.
pub struct Prepared {
    /// The body.
    pub body: Body,
    /// Symbolic factorisation of its pattern.
    pub symbolic: Symbolic,
    /// The scheme that the full order is marched with: Bathe's where the file moves its modes exactly.
    pub scheme: SchemeTable,
    /// True if the file moves its modes exactly.
    pub exact: bool,
    /// Live parameters.
    pub space: ParameterSpace,
    /// The step at the values of the problem file.
    pub step: StepParameters,
    /// Damping ratios in addition to Rayleigh's, of a file that moves its modes exactly.
    pub ratios: ModalRatios,
    /// The first natural mode, once something has asked for it: the time step may be proposed from it.
    pub(crate) first_mode: Option<FirstMode>,
}

impl Prepared {
    /// True for live regions by a parametric reduced-order model; a body of one region has none.
    pub(crate) fn is_parametric(&self, problem: &Problem) -> bool {
        problem.is_parametric() && self.space.has_region_parameters()
    }

    /// Rayleigh damping at the values of the problem file.
    pub fn rayleigh(&self) -> Rayleigh {
        Rayleigh { alpha: self.step.alpha, beta: self.step.beta }
    }

    /// True if materials have loss factors, which are no damping matrix.
    pub fn has_loss(&self) -> bool {
        self.body.model.pencil().has_loss()
    }

    /// Damping ratios of natural modes, columns of `vectors`, normal in the mass, in addition to Rayleigh's
    /// and to dashpots: those of the problem, and `½ φᵀ(Σ η_q K_q)φ / ω²` by the loss factors of a pencil.
    pub fn modal_ratios(
        &self,
        pencil: &Pencil,
        eigenvalues: &[f64],
        vectors: MatRef<'_, f64>,
    ) -> ModalRatios {
        let Some(loss) = pencil.loss() else { return self.ratios.clone() };
        let mut image = Mat::zeros(vectors.nrows(), vectors.ncols());
        loss.mul_into(vectors, image.as_mut());
        let energy = |k: usize| vectors.col(k).transpose() * image.col(k);
        let ratio = |(k, value): (usize, &f64)| self.ratios.of(k) + 0.5 * energy(k) / value;
        ModalRatios(eigenvalues.iter().enumerate().map(ratio).collect())
    }

    /// The same with `φᵀCφ / (2 ω)` by dashpots.
    pub fn ratios_along(
        &self,
        pencil: &Pencil,
        eigenvalues: &[f64],
        vectors: MatRef<'_, f64>,
    ) -> ModalRatios {
        let (ratios, dampers) = (self.modal_ratios(pencil, eigenvalues, vectors), pencil.dampers());
        if dampers.is_empty() {
            return ratios;
        }
        let damping = dampers.project(vectors);
        let ratio = |(k, value): (usize, &f64)| ratios.of(k) + 0.5 * damping[(k, k)] / value.sqrt();
        ModalRatios(eigenvalues.iter().enumerate().map(ratio).collect())
    }

    /// Takes these values of the live parameters, one for each, for those of the problem file. Matrices stay
    /// those of the problem file; [`ParameterSpace::setting`] tells what they are scaled by.
    pub fn set_nominal(&mut self, values: &[f64]) {
        self.space.set_nominal(values);
        self.step = self.space.setting(values).step;
    }

    /// The scheme of the file.
    pub fn file_scheme(&self) -> &SchemeTable {
        if self.exact { &SchemeTable::EXACT } else { &self.scheme }
    }

    /// The full-order solver at the values of the problem file, its stages factorised.
    ///
    /// # Errors
    /// [`FullOrderError`]: a stage that does not factorise.
    pub fn full_order(&self) -> Result<FullOrder<'_>, FullOrderError> {
        let pencil = self.body.model.pencil();
        FullOrder::new(pencil, &self.symbolic, &self.scheme, self.step.time_step, self.rayleigh())
    }
}

/// Inputs of all stages: the model. Scheme, step and parameters are named by the stages that look at
/// them.
impl StageInput for Prepared {
    fn add_to(&self, inputs: Inputs) -> Inputs {
        inputs.with(&self.body.model)
    }
}

/// Reads the mesh and assembles the model of a problem, or reads the matrices it names instead.
///
/// # Errors
/// [`PrepareError`], by cause.
pub fn prepare(
    problem: &Problem,
    watch: &mut Stopwatch<'_>,
    listener: &dyn Listener,
) -> Result<Prepared, PrepareError> {
    prepare_within(problem, &Means::default(), watch, listener)
}

/// The same within so much memory, with factors of the stiffness made by an engine if there is one.
///
/// # Errors
/// As [`prepare`]; [`PrepareError::Memory`] before a mesh or matrices that need more are allocated.
pub(crate) fn prepare_within(
    problem: &Problem,
    means: &Means<'_>,
    watch: &mut Stopwatch<'_>,
    listener: &dyn Listener,
) -> Result<Prepared, PrepareError> {
    let memory = means.memory;
    let (scheme, exact) = match problem.scheme() {
        SchemeKind::Exact {} => (bathe(), true),
        kind => (kind.table()?, false),
    };
    let rayleigh = problem.damping.damping().rayleigh()?;
    let (body, space) = if let Some(source) = &problem.mesh.matrices {
        let read = || MatrixModel::read(problem, source);
        let matrices = watch.stage("read matrices", read).map_err(BodyError::from)?;
        matrices.mesh.notes.iter().for_each(|note| listener.note(note));
        let space = ParameterSpace::new(problem, &matrices.mesh, rayleigh)?;
        (Body::of_matrices(problem, matrices)?, space)
    } else {
        // What needs entries of the matrices has them assembled in this process.
        let engine = means.engine.filter(|_| exact && entries_stay_away(problem));
        let ranks = engine.map_or(1, |engine| engine.ranks());
        if let Some(block) = &problem.mesh.block {
            size::check_block(block, ranks, memory)?;
        }
        let mesh = watch.stage("read mesh", || read_mesh(problem))?;
        size::check_mesh(&mesh, ranks, memory)?;
        mesh.notes.iter().for_each(|note| listener.note(note));
        problem.check_free()?;
        note_locking(problem, &mesh, listener);
        let space = ParameterSpace::new(problem, &mesh, rayleigh)?;
        let mut body = watch.stage("assemble", || Body::build(problem, mesh, engine))?;
        if !space.loss().is_empty() {
            body.model = body.model.with_loss(space.loss().to_vec());
        }
        let loaded = |body| -> Result<Body, PrepareError> {
            match &problem.prestress {
                None => Ok(body),
                Some(entry) => prestress::prestressed(problem, entry, body, memory, listener),
            }
        };
        (loaded(body)?, space)
    };
    note_probes(problem, &body, listener);
    note_free(&body, listener);
    if let Some(left_out) = body.embedded.as_ref().map(|embedded| embedded.left_out).filter(|n| *n > 0) {
        listener.note(&format!(
            "{left_out} triangles of the embedded surface lie more than a tenth of the body's size off the mesh, and \
             are left out"
        ));
    }
    let symbolic = watch.stage("order and analyse", || Symbolic::analyze(body.model.pencil()))?;
    let symbolic = symbolic.on(means.engine.cloned(), || body.model.rigid_motions());
    // Matrices from elsewhere are factorised in double precision anyway, to see whether they are definite.
    let open = exact && problem.mesh.matrices.is_none();
    let symbolic = means.precise(symbolic, body.model.pencil(), open, listener);
    if let Some(solver) = symbolic.solver() {
        listener.note(&format!("every system is solved by {solver}: nothing is more exact than that"));
    }
    if problem.mesh.matrices.is_some() {
        watch.stage("factorise matrices", || check_definite(body.model.pencil(), &symbolic))?;
    }
    let (mut space, mut first_mode) = (space, None);
    if space.time_step().is_none() {
        let factor = symbolic.stiffness_bytes() as f64 + body.model.pencil().bytes() as f64;
        memory.check(factor, ": a coarser mesh", || format!("the matrices of {} free dofs", body.n_dof()))?;
        let find = || FirstMode::find(body.model.pencil(), &symbolic);
        let first = watch.stage("first natural mode", find)?;
        let period = first.period();
        let proposed = proposed_time_step(period);
        listener.note(&format!(
            "no `time.step` is given: {proposed:e} s is taken, {:.0} steps in the first natural period",
            period / proposed
        ));
        space = space.at_time_step(proposed);
        first_mode = Some(first);
    }
    let step = space.setting(&space.nominal()).step;
    let ratios = problem.damping.modal_ratios();
    Ok(Prepared { body, symbolic, scheme, exact, space, step, ratios, first_mode })
}

/// True if a file that is exact in time is built from products with the matrices and solves alone.
fn entries_stay_away(problem: &Problem) -> bool {
    let whole_factor = problem.output.static_fields == Some(true);
    problem.basis_kind() == BasisKind::Modes && !problem.is_large() && !whole_factor
}

/// A matrix whose inverse is so many times larger than one over its largest diagonal entry is singular to
/// rounding.
const SINGULAR: f64 = 1e14;

/// The mass and the stiffness of a held solid are positive definite as they are assembled; matrices from
/// elsewhere may be anything.
fn check_definite(pencil: &Pencil, symbolic: &Symbolic) -> Result<(), PrepareError> {
    let factorises = |matrix: &SymmetricMatrix| -> Result<(), FactorError> {
        let factor = symbolic.factorize(matrix.clone())?;
        // A pivot of zero, or of nothing but rounding, passes as a factor; its solutions are as large as that
        // is small.
        let (n, mut random) = (matrix.n(), Random::new(1));
        let mut x = Mat::from_fn(n, 1, |_, _| random.uniform() - 0.5);
        Solve::new(symbolic, 1, false).solve_in_place(&factor, x.as_mut());
        let largest = (0..n).map(|i| matrix.diagonal(i)).fold(0.0, f64::max);
        let sound = |i: usize| (x[(i, 0)] * largest).abs() < SINGULAR;
        match (0..n).find(|&i| !sound(i)) {
            None => Ok(()),
            Some(pivot) => Err(FactorError::NotPositiveDefinite { pivot, n }),
        }
    };
    // Lumped masses need no factor, which would fill as much as that of the stiffness.
    let mass = if pencil.mass().is_diagonal() { positive(pencil.mass()) } else { factorises(pencil.mass()) };
    mass.map_err(|source| PrepareError::NotDefinite { key: "mass", source })?;
    factorises(pencil.stiffness()).map_err(|source| PrepareError::NotDefinite { key: "stiffness", source })
}

/// True if every diagonal entry is above zero.
fn positive(matrix: &SymmetricMatrix) -> Result<(), FactorError> {
    match (0..matrix.n()).find(|&i| matrix.diagonal(i) <= 0.0) {
        None => Ok(()),
        Some(pivot) => Err(FactorError::NotPositiveDefinite { pivot, n: matrix.n() }),
    }
}

/// A probe this far from the point given, relative to the node's largest coordinate, is worth a note.
const FAR: f64 = 1e-6;

/// A probe looks at the node nearest to its point, however far off the body that is: says where it looks.
fn note_probes(problem: &Problem, body: &Body, listener: &dyn Listener) {
    for (entry, probe) in problem.output.probes.iter().zip(&body.probes) {
        let (nodes, place) = (&body.model.mesh().nodes, probe.nodes[0].0 as usize);
        let of_points = |place: usize| problem.reference_points[(place - nodes.len()) / 2].at;
        let at = nodes.get(place).copied().unwrap_or_else(|| of_points(place));
        let distance = at.iter().zip(entry.point).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let size = at.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        if distance > FAR * size {
            let [x, y, z] = at;
            listener.note(&format!(
                "probe `{}` looks at the nearest node, ({x:.6}, {y:.6}, {z:.6}), {distance:.3e} away from the point \
                 given",
                probe.name
            ));
        }
    }
}

/// A body that nothing holds is meant, or a support was forgotten.
fn note_free(body: &Body, listener: &dyn Listener) {
    if let Some(rigid) = body.model.pencil().rigid() {
        let [x, y, z] = rigid.centre;
        listener.note(&format!(
            "no `[[support]]`: the body is free; the file keeps its six rigid motions apart (mass {:.6e}, centre ({x:.6e}, \
             {y:.6e}, {z:.6e})) and its elastic modes",
            rigid.mass
        ));
    }
}

/// Fully integrated 8-node hexahedra and linear tetrahedra cannot bend, and near ν = ½ they cannot even keep
/// their volume: they are too stiff.
fn note_locking(problem: &Problem, mesh: &Mesh, listener: &dyn Listener) {
    const NEARLY_INCOMPRESSIBLE: f64 = 0.45;
    let named = |formulation| mesh.regions.iter().any(|region| region.hexahedra == Some(formulation));
    let bricks = mesh.kinds.distinct().contains(&ElementKind::Hex8);
    if bricks && problem.is_large() && (named(Hexahedra::Full) || named(Hexahedra::MeanDilatation)) {
        listener.note(
            "8-node hexahedra without incompatible modes are too stiff where the body bends, and no certificate shows \
             it: mesh with 20-node ones",
        );
    } else if bricks && named(Hexahedra::Full) {
        listener.note(
            "8-node hexahedra with full integration are too stiff where the body bends; `hexahedra = \"incompatible\"` \
             in `[[material]]` has none of it, and no other frequencies where the mesh is fine",
        );
    }
    let kinds = mesh.kinds.distinct();
    let is_hexahedron = |kind| matches!(kind, ElementKind::Hex8 | ElementKind::Hex20 | ElementKind::Hex27);
    if !kinds.iter().copied().any(is_hexahedron) && problem.materials.iter().any(|m| m.hexahedra.is_some()) {
        listener.note("`hexahedra` in `[[material]]` does nothing: the mesh has no hexahedra");
    }
    let stiff = [ElementKind::Tet4, ElementKind::Pyramid5, ElementKind::Wedge6];
    if mesh.tetrahedra().is_none() && kinds.iter().any(|kind| stiff.contains(kind)) {
        listener.note(
            "linear tetrahedra, pyramids and wedges are too stiff where the body bends, and no certificate shows \
             it: mesh with quadratic elements, or with hexahedra where it bends",
        );
    }
    let poisson = problem.materials.iter().filter_map(|m| m.poisson).fold(0.0, f64::max);
    if mesh.tetrahedra() != Some(Order::Linear) {
        return;
    }
    if poisson >= NEARLY_INCOMPRESSIBLE {
        listener.note(&format!(
            "Poisson's ratio {poisson} with linear tetrahedra: they lock and are many times too stiff; `order = \"quadratic\"` in `[mesh]` adds mid-side nodes"
        ));
    } else {
        listener.note(
            "linear tetrahedra are too stiff where the body bends, and no certificate shows it: with one of them through \
             the thickness frequencies are twice as high as they should be; `order = \"quadratic\"` in `[mesh]` adds mid-side nodes",
        );
    }
}
