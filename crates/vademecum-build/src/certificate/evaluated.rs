//! The march of a certificate through the evaluator, on the encoded bytes.

use faer::{Mat, MatRef};
use vademecum_eval::{
    Body, BodyOptions, Contact, Field, LoadError, Loads, OutputError, Place, Scene, SceneOptions, State,
    StaticField, Structure,
};
use vademecum_format::exact::ForceFilter;
use vademecum_format::scheme::{MAX_STAGES, StepParameters};
use vademecum_format::{File, FormatError, SectionKind};

use super::error::CertificateError;
use super::growth::free_states;
use super::unseen::{UnseenLoad, UnseenLoads};
use super::verdict::StructureMeasured;
use crate::basis::Basis;
use crate::dynamics::{
    Decay, ErrorMeter, FullOrder, MotionPart, ReferenceDistance, ReferenceOptions, ReferenceSolution,
    TrajectoryError, march_full_order,
};
use crate::export::NodeOrder;
use crate::fem::{DofMap, Pencil, Symbolic, SymmetricMatrix};
use crate::linalg::{self, project};
use crate::progress::{Cancelled, Listener};

/// Multiply-adds spent on the free run of one structure; it is as long as that allows, and [`FREE_RUN_STEPS`]
/// at most.
const FREE_RUN_WORK: usize = 1_000_000_000;
/// See [`FREE_RUN_WORK`].
const FREE_RUN_STEPS: usize = 100_000;

/// Options of a body that is only stepped and read.
pub(super) fn body_options(scene: &SceneOptions) -> BodyOptions {
    BodyOptions { scene: *scene, places: 0, flight: false, ..BodyOptions::default() }
}

/// Memory of a body of these options.
pub(super) fn body_memory(file: &File<'_>, options: &BodyOptions) -> Result<Vec<f64>, CertificateError> {
    Ok(vec![0.0; Body::<f64>::len_for(file, options)?])
}

/// Memory lent to one march.
struct Memory {
    body: Vec<f64>,
    states: Vec<Vec<f64>>,
    loads: Vec<Vec<f64>>,
}

impl Memory {
    fn new(file: &File<'_>, options: &SceneOptions, trajectories: usize) -> Result<Self, CertificateError> {
        let sizes = Scene::<f64>::sizes(file, options)?;
        Ok(Self {
            body: body_memory(file, &body_options(options))?,
            states: vec![vec![0.0; sizes.state]; trajectories],
            loads: vec![vec![0.0; sizes.loads]; trajectories],
        })
    }
}

/// One trajectory: a load, and the state under it.
struct Trajectory<'m> {
    contact: Contact,
    load: &'m UnseenLoad,
    state: State<'m, f64>,
    loads: Loads<'m, f64>,
    /// Factors on the load that stand in `loads`.
    factors: [f64; 1 + MAX_STAGES],
}

/// All unseen loads marched through the scene of one body.
struct March<'m> {
    body: Body<'m, f64>,
    trajectories: Vec<Trajectory<'m>>,
    reciprocity: Reciprocity,
}

/// A file beside the full-order march: its bytes, the basis it holds, and what it is bound to.
#[derive(Clone, Copy)]
pub struct Candidate<'a> {
    /// The whole file.
    pub bytes: &'a [u8],
    /// Its basis, orthonormal in the mass of the march.
    pub basis: &'a Basis,
    /// Structure and parameters of the step.
    pub options: &'a SceneOptions,
}

/// What was measured of a candidate.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Error and floor of each unseen trajectory.
    pub errors: Vec<TrajectoryError>,
    /// Largest modulus of the eigenvalues of the step.
    pub spectral_radius: f64,
    /// Largest energy of a long free run over the energy at its start.
    pub(crate) energy_ratio: f64,
    /// Defect of reciprocity between the loads.
    pub(crate) reciprocity: f64,
    /// Largest energy of the motions that the loads left, over a million free steps, over that at their
    /// start.
    pub(crate) energy_growth: f64,
}

impl Measured {
    /// As a build judges it, after so many steps. Map errors are not measured here; they are NaN.
    fn structure(self, steps: usize) -> StructureMeasured {
        let mut measured = StructureMeasured::of_runs(self.errors, steps);
        measured.certificate.spectral_radius = self.spectral_radius;
        measured.certificate.energy_ratio = self.energy_ratio;
        measured.figures.reciprocity = self.reciprocity;
        measured.figures.energy_growth = self.energy_growth;
        measured
    }
}

/// Marches the unseen loads full order beside a file in several structures and certifies each.
///
/// As [`measure`], for candidates of one file.
///
/// # Errors
/// As [`measure`].
pub(crate) fn certify(
    candidates: &[Candidate<'_>],
    order: &NodeOrder,
    mass: &SymmetricMatrix,
    full: &FullOrder<'_>,
    unseen: &UnseenLoads,
    listener: &dyn Listener,
) -> Result<Vec<StructureMeasured>, CertificateError> {
    let measured = measure(candidates, order, mass, full, unseen, listener)?;
    Ok(measured.into_iter().map(|measured| measured.structure(unseen.steps)).collect())
}

/// Marches the unseen loads once full order, and through each candidate beside it.
///
/// `order` is the order of nodes of every file; `mass` is the mass matrix in which errors are measured and
/// bases are orthonormal.
///
/// # Errors
/// [`CertificateError`]: a full-order march that fails or is stopped, a file the evaluator refuses.
pub fn measure(
    candidates: &[Candidate<'_>],
    order: &NodeOrder,
    mass: &SymmetricMatrix,
    full: &FullOrder<'_>,
    unseen: &UnseenLoads,
    listener: &dyn Listener,
) -> Result<Vec<Measured>, CertificateError> {
    let columns = unseen.loads.len();
    let files = candidates.iter().map(|c| File::parse(c.bytes)).collect::<Result<Vec<_>, _>>()?;
    let memory =
        |(file, candidate): (&File<'_>, &Candidate<'_>)| Memory::new(file, candidate.options, columns);
    let mut memories = files.iter().zip(candidates).map(memory).collect::<Result<Vec<_>, _>>()?;
    let bound = files.iter().zip(candidates).zip(&mut memories);
    let bind = |((file, candidate), memory)| March::bind(file, candidate, memory, order, unseen);
    let mut marches = bound.map(bind).collect::<Result<Vec<_>, _>>()?;
    let bases = candidates.iter().map(|candidate| candidate.basis.vectors.as_ref());
    let mut meters: Vec<_> = bases.map(|basis| ErrorMeter::new(mass, basis, columns)).collect();
    let mut refused = None;
    march_full_order(full, &unseen.timed(), columns, unseen.steps, listener, |step, state| {
        for (march, meter) in marches.iter_mut().zip(&mut meters) {
            if step == 0 || refused.is_some() {
                continue;
            }
            match march.step(step - 1) {
                Ok(coordinates) => meter.add(state.displacement.as_ref(), coordinates.as_ref()),
                Err(error) => refused = Some(error),
            }
        }
    })?;
    match refused {
        Some(error) => Err(error),
        None => {
            let each = marches.iter_mut().zip(&meters);
            each.map(|(march, meter)| march.measured(meter.errors(), listener)).collect()
        }
    }
}

/// Steps the unseen loads through a file that moves its modes exactly, beside the motion that is exact in
/// time in a space that has converged for them: there is no march at full order. The loads end on whole
/// steps. Where the file has the factor of the stiffness, its fields are compared with the whole static
/// answer. The model comes with natural modes that are known of it, for [`ReferenceSolution::find_until`].
///
/// # Errors
/// [`CertificateError`]: a stiffness that does not factorise, a file the evaluator refuses, a stop.
pub(crate) fn certify_exact(
    candidate: &Candidate<'_>,
    nodes: (&NodeOrder, &DofMap),
    model: (&Pencil, &Symbolic, MatRef<'_, f64>),
    decay: Decay<'_>,
    unseen: &UnseenLoads,
    listener: &dyn Listener,
) -> Result<StructureMeasured, CertificateError> {
    let nothing = |_: &ReferenceSolution<'_>, _: &UnseenLoads| Ok(());
    Ok(certify_beside(candidate, nodes, model, decay, unseen, listener, nothing)?.0)
}

/// [`certify_exact`], and what `look` finds of the reference that it took and of the loads.
///
/// # Errors
/// As [`certify_exact`], and those of `look`.
pub(crate) fn certify_beside<T>(
    candidate: &Candidate<'_>,
    (order, dofs): (&NodeOrder, &DofMap),
    model: (&Pencil, &Symbolic, MatRef<'_, f64>),
    decay: Decay<'_>,
    unseen: &UnseenLoads,
    listener: &dyn Listener,
    look: impl FnOnce(&ReferenceSolution<'_>, &UnseenLoads) -> Result<T, CertificateError>,
) -> Result<(StructureMeasured, T), CertificateError> {
    let file = File::parse(candidate.bytes)?;
    let time_step = candidate.options.time_step.unwrap_or(file.metadata().time_step);
    let unseen = &unseen.on_steps(time_step);
    let columns = unseen.loads.len();
    let mut memory = Memory::new(&file, candidate.options, columns)?;
    let mut march = March::bind(&file, candidate, &mut memory, order, unseen)?;
    let r = candidate.basis.n_modes();
    let mut coordinates = vec![Mat::zeros(r, 1 + unseen.steps); columns];
    // How much of its load each shows at each instant.
    let mut acting = vec![Mat::zeros(1, 1 + unseen.steps); columns];
    let filter = ForceFilter::of(march.body.scene().parameters());
    for step in 0..unseen.steps {
        let now = march.step(step)?;
        for (j, trajectory) in march.trajectories.iter().enumerate() {
            coordinates[j].col_mut(step + 1).copy_from(now.col(j));
            // A step shows the load as it is at its very end, through the filter of the damping.
            let [start, end, ..] = trajectory.factors;
            acting[j][(0, step + 1)] = filter.keep * acting[j][(0, step)] + filter.drive(start, end);
        }
        listener.checkpoint(step + 1, unseen.steps)?;
    }
    let statics = march.static_fields(order, dofs)?;
    let (span, loads) = ((time_step, unseen.steps), unseen.timed());
    let columns = candidate.basis.vectors.as_ref();
    let errors = |truth: &ReferenceSolution<'_>| -> Vec<TrajectoryError> {
        let error = |(j, (coordinates, acting)): (usize, (&Mat<f64>, &Mat<f64>))| {
            let mut shown = vec![MotionPart { columns, amplitudes: coordinates.as_ref() }];
            if let Some(field) = statics.get(j) {
                shown.push(MotionPart { columns: field.as_ref(), amplitudes: acting.as_ref() });
            }
            let ReferenceDistance { error, floor } = truth.trajectory(j).distance(&shown);
            TrajectoryError { error, floor }
        };
        coordinates.iter().zip(&acting).enumerate().map(error).collect()
    };
    // What was last measured tells whether it is worth measuring again.
    let mut known = vec![ANY; unseen.loads.len()];
    let enough = |truth: &ReferenceSolution<'_>| {
        let small =
            |known: &[f64]| (0..known.len()).all(|j| truth.trajectory(j).estimate() <= SHARE * known[j]);
        if !small(&known) {
            return None;
        }
        let errors = errors(truth);
        known = errors.iter().map(|found| found.error).collect();
        small(&known).then_some(errors)
    };
    let (truth, found) =
        ReferenceSolution::find_until(model, decay, &loads, span, &REFERENCE, listener, enough)?;
    let errors = found.unwrap_or_else(|| errors(&truth));
    let measured = march.measured(errors, listener)?;
    Ok((measured.structure(unseen.steps), look(&truth, unseen)?))
}

/// The error of the reference as a share of the error that it measures: it adds its square, 3 %.
const SHARE: f64 = 0.25;

/// An error that no reduction worth measuring reaches.
const ANY: f64 = 0.5;

/// What the reference of a certificate has to reach where it measures less: a hundredth of an error that
/// would be worth a note, and no more vectors than a build has room for.
const REFERENCE: ReferenceOptions =
    ReferenceOptions { tolerance: 1e-5, vectors_per_force: 80, bytes: 500_000_000 };

impl<'m> March<'m> {
    fn bind(
        file: &File<'m>,
        candidate: &Candidate<'m>,
        memory: &'m mut Memory,
        order: &NodeOrder,
        unseen: &'m UnseenLoads,
    ) -> Result<Self, CertificateError> {
        let body = Body::bind(file, &body_options(candidate.options), &mut memory.body)?;
        let scene = body.scene();
        let lent = memory.states.iter_mut().zip(&mut memory.loads);
        let trajectories = unseen.loads.iter().zip(lent).map(|(load, (state, loads))| {
            let nodes: Vec<u32> = load.nodes.iter().map(|&node| order.file_node[node as usize]).collect();
            let contact =
                Contact::new(Place::new(&nodes, &load.weights).map_err(LoadError::from)?, load.force);
            let (state, loads) = (State::new(scene, state)?, Loads::new(scene, loads)?);
            let mut trajectory = Trajectory { contact, load, state, loads, factors: [0.0; 1 + MAX_STAGES] };
            trajectory.load_step(scene, 0)?;
            // From rest the acceleration is what the force at time zero demands.
            let zero = vec![0.0; scene.n_modes()];
            scene.set(&mut trajectory.state, &zero, &zero, &trajectory.loads)?;
            Ok(trajectory)
        });
        let trajectories = trajectories.collect::<Result<_, CertificateError>>()?;
        let forces = unseen.loads.iter().map(|load| &load.timed.force[..]);
        let reciprocity = Reciprocity::new(candidate.basis, forces);
        Ok(Self { body, trajectories, reciprocity })
    }

    fn measured(
        &mut self,
        errors: Vec<TrajectoryError>,
        listener: &dyn Listener,
    ) -> Result<Measured, CertificateError> {
        let increment = increment(self.body.scene())?;
        let energy_growth = self.energy_growth(increment.as_ref())?;
        Ok(Measured {
            errors,
            spectral_radius: radius(&self.body)?,
            energy_ratio: self.free_run_energy(listener)?,
            reciprocity: self.reciprocity.defect(),
            energy_growth,
        })
    }

    /// Largest energy that the motions left by the loads reach in a million free steps, over that at their
    /// start. Takes the loads away and leaves the states as they are.
    fn energy_growth(&mut self, increment: MatRef<'_, f64>) -> Result<f64, CertificateError> {
        let n = self.body.scene().state_numbers();
        let mut starts = Mat::zeros(n, self.trajectories.len());
        let mut energies = vec![];
        let mut left = vec![0.0; n];
        for (j, Trajectory { state, loads, .. }) in self.trajectories.iter_mut().enumerate() {
            state.save_into(&mut left)?;
            loads.clear();
            self.body.scene().step(state, loads)?;
            // The first free step removes what is left of the load's acceleration.
            energies.push(self.body.scene().energy(state)?);
            state.save_into(starts.col_as_slice_mut(j))?;
            state.restore(&left)?;
        }
        let states = free_states(increment, starts.as_ref());
        let mut largest: f64 = 1.0;
        let Trajectory { state, .. } = &mut self.trajectories[0];
        state.save_into(&mut left)?;
        for j in 0..states.ncols() {
            let column = states.col_as_slice(j);
            if column.iter().any(|x| !x.is_finite()) {
                largest = f64::INFINITY;
                break;
            }
            state.restore(column)?;
            largest = largest.max(self.body.scene().energy(state)? / energies[j % energies.len()]);
        }
        state.restore(&left)?;
        Ok(largest)
    }

    /// What the file's fields show of each load beside the modes, over the free dofs of `dofs`, for factor 1
    /// on the load; nothing where the file does not have the factor of the stiffness or fields inside the
    /// body. Takes the loads away and leaves the states as they are.
    fn static_fields(&mut self, order: &NodeOrder, dofs: &DofMap) -> Result<Vec<Mat<f64>>, CertificateError> {
        let [of_answer, of_rest] = self.body.scene().static_field_sizes();
        let (mut answer, mut rest) = (vec![0.0; of_answer], vec![0.0; of_rest]);
        let mut statics = StaticField::new(self.body.scene(), &mut answer, &mut rest)?;
        let mut shown = vec![0.0; 3 * order.nodes.len()];
        let mut left = vec![0.0; self.body.scene().state_numbers()];
        let zero = vec![0.0; self.body.scene().state_numbers()];
        let mut fields = vec![];
        for Trajectory { contact, state, loads, factors, .. } in &mut self.trajectories {
            if of_answer == 0 {
                break;
            }
            state.save_into(&mut left)?;
            loads.clear();
            loads.add_contact(self.body.scene(), contact)?;
            // In equilibrium with the load.
            state.restore_under(&zero, loads)?;
            self.body.scene().solve_static_field(state, &mut statics)?;
            let told = self.body.scene().body_with(state, Field::Displacement, &mut statics, &mut shown);
            loads.clear();
            *factors = [0.0; 1 + MAX_STAGES];
            state.restore(&left)?;
            match told {
                Ok(()) => {}
                Err(OutputError::Missing { .. }) => return Ok(vec![]),
                Err(error) => return Err(error.into()),
            }
            let value = |&dof: &u32| shown[3 * order.file_node[dof as usize / 3] as usize + dof as usize % 3];
            let field: Vec<f64> = dofs.dof_of_free().iter().map(value).collect();
            fields.push(MatRef::from_column_major_slice(&field, field.len(), 1).to_owned());
        }
        Ok(fields)
    }

    /// One step of every trajectory: their ζ, shape (r, trajectories).
    fn step(&mut self, step: usize) -> Result<Mat<f64>, CertificateError> {
        for trajectory in &mut self.trajectories {
            trajectory.load_step(self.body.scene(), step)?;
            self.body.scene().step(&mut trajectory.state, &trajectory.loads)?;
        }
        let coordinates = self.coordinates();
        self.reciprocity.add(coordinates.as_ref());
        Ok(coordinates)
    }

    /// ζ of every trajectory, shape (r, trajectories).
    fn coordinates(&self) -> Mat<f64> {
        Mat::from_fn(self.body.scene().n_modes(), self.trajectories.len(), |i, j| {
            self.trajectories[j].state.zeta()[i]
        })
    }

    /// Largest energy of a long unloaded run from the last state of the first trajectory, over the energy at
    /// its start.
    fn free_run_energy(&mut self, listener: &dyn Listener) -> Result<f64, CertificateError> {
        let r = self.body.scene().n_modes();
        let steps = (FREE_RUN_WORK / (9 * r * r)).min(FREE_RUN_STEPS);
        let Trajectory { state, loads, .. } = &mut self.trajectories[0];
        loads.clear();
        // The first unloaded step removes what is left of the load's acceleration.
        self.body.scene().step(state, loads)?;
        let start = self.body.scene().energy(state)?;
        let mut largest = start;
        for _ in 0..steps {
            self.body.scene().step(state, loads)?;
            largest = largest.max(self.body.scene().energy(state)?);
        }
        if listener.cancelled() { Err(Cancelled.into()) } else { Ok(largest / start) }
    }
}

impl Trajectory<'_> {
    /// Puts the load of step `step` into `loads` where it differs from that of the step before.
    fn load_step(&mut self, scene: &Scene<'_, f64>, step: usize) -> Result<(), CertificateError> {
        let time_step = scene.parameters().time_step;
        let (when, time) = (&self.load.timed.when, |c: f64| (step as f64 + c) * time_step);
        let mut factors = scene.instants().map(|c| when.factor(time(c)));
        if matches!(scene.structure(), Structure::Exact | Structure::Strain) {
            // What the load is within the step, up to the step's very end.
            (factors[0], factors[1]) = (when.just_after(time(0.0)), when.just_before(time(1.0)));
        }
        if factors != self.factors {
            self.factors = factors;
            self.loads.clear();
            if factors.iter().any(|&f| f != 0.0) {
                self.loads.add_contact_staged(scene, &self.contact, &factors)?;
            }
        }
        Ok(())
    }
}

/// How far the displacement along load `a` under load `b` is from the reverse. All loads act at the same
/// times.
struct Reciprocity {
    /// `BᵀF` of every load, shape (r, loads).
    rows: Mat<f64>,
    defect: f64,
    norm: f64,
}

impl Reciprocity {
    fn new<'f>(basis: &Basis, forces: impl Iterator<Item = &'f [f64]>) -> Self {
        let rows: Vec<f64> = forces.flat_map(|force| project(basis.vectors.as_ref(), force)).collect();
        let r = basis.n_modes();
        let rows = MatRef::from_column_major_slice(&rows, r, rows.len() / r).to_owned();
        Self { rows, defect: 0.0, norm: 0.0 }
    }

    /// Adds one instant of all trajectories, ζ of shape (r, loads).
    fn add(&mut self, coordinates: MatRef<'_, f64>) {
        let seen = self.rows.transpose() * coordinates;
        for a in 0..seen.nrows() {
            for b in 0..a {
                self.defect += (seen[(a, b)] - seen[(b, a)]).powi(2);
                self.norm += 0.5 * (seen[(a, b)].powi(2) + seen[(b, a)].powi(2));
            }
        }
    }

    /// NaN where no load moves the place of another.
    fn defect(&self) -> f64 {
        (self.defect / self.norm).sqrt()
    }
}

/// Spectral radius of the step of a file bound to `options`.
///
/// # Errors
/// [`CertificateError`]: a file the evaluator refuses, eigenvalues that do not converge.
pub fn spectral_radius(file: &File<'_>, options: &SceneOptions) -> Result<f64, CertificateError> {
    let options = body_options(options);
    let mut memory = body_memory(file, &options)?;
    radius(&Body::bind(file, &options, &mut memory)?)
}

/// Spectral radius of the step of a body.
fn radius(body: &Body<'_, f64>) -> Result<f64, CertificateError> {
    let scene = body.scene();
    let increment = increment(scene)?;
    match scene.structure() {
        Structure::Exact if scene.is_coupled() => radius_of_increment(energetic(body, increment)?.as_ref()),
        Structure::Exact => Ok(radius_of_modes(increment.as_ref())),
        _ => radius_of_increment(increment.as_ref()),
    }
}

/// The increment of coupled modes with displacements in units of their velocities: `D` between numbers of
/// which the squares are the energy keeps the digits of its eigenvalues.
fn energetic(body: &Body<'_, f64>, increment: Mat<f64>) -> Result<Mat<f64>, CertificateError> {
    let (scene, kind) = (body.scene(), SectionKind::Eigenvalues);
    let section = body.file().section(kind).ok_or(FormatError::Missing { kind: kind.number() })?;
    let StepParameters { time_step, stiffness, density, .. } = *scene.parameters();
    let unit = |value: f64| time_step * (value * stiffness / density).sqrt();
    let units: Vec<f64> = section.numbers()?.iter().map(unit).collect();
    let unit = |i: usize| units.get(i).copied().filter(|unit| *unit > 0.0).unwrap_or(1.0);
    let n = increment.nrows();
    Ok(Mat::from_fn(n, n, |i, j| increment[(i, j)] * unit(i) / unit(j)))
}

/// The same of modes with a 2×2 block each: displacements and velocities of a fast mode differ by so much
/// that the eigenvalues of the whole would lose digits.
fn radius_of_modes(increment: MatRef<'_, f64>) -> f64 {
    let r = increment.nrows() / 2;
    let of_mode = |k: usize| {
        let [a, b, c, d] = [(k, k), (k, r + k), (r + k, k), (r + k, r + k)].map(|place| increment[place]);
        let (half, determinant) = (0.5 * (a + d), a * d - b * c);
        let apart = half * half - determinant;
        if apart < 0.0 {
            return (1.0 + 2.0 * half + determinant).sqrt();
        }
        let root = apart.sqrt();
        (1.0 + half + root).abs().max((1.0 + half - root).abs())
    };
    (0..r).map(of_mode).fold(0.0, f64::max)
}

/// The increment map `D` of `y ← y + D y` as the scene holds it.
pub(super) fn increment(scene: &Scene<'_, f64>) -> Result<Mat<f64>, CertificateError> {
    let n = scene.state_numbers();
    let mut map = vec![0.0; n * n];
    scene.increment_into(&mut map)?;
    Ok(MatRef::from_column_major_slice(&map, n, n).to_owned())
}

/// Largest modulus of the eigenvalues of `I + D`, from those of `D`, so that those near 1 keep their digits.
///
/// # Errors
/// [`CertificateError::Eigenvalues`].
pub(crate) fn radius_of_increment(increment: MatRef<'_, f64>) -> Result<f64, CertificateError> {
    let eigenvalues = linalg::eigenvalues(increment).map_err(|_| CertificateError::Eigenvalues)?;
    Ok(eigenvalues.iter().map(|l| (1.0 + l.re).hypot(l.im)).fold(0.0, f64::max))
}
