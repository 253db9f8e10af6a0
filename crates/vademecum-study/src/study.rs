//! A body and its snapshots, and the pieces of all methods made from them, each timed where it is made.

use std::time::Instant;

use vademecum_build::basis::{
    Basis, BasisError, CachedRuns, Pod, SnapshotSchedule, basis_of_pod, modes_basis,
};
use vademecum_build::dynamics::{FullOrder, SchemeKind, announce, lowest_modes, mode_table, table_matrix};
use vademecum_build::export::{Draft, NodeOrder, Parts, encode, program};
use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::input::{BasisKind, ParameterEntry, ParameterKind, ParameterScale, Problem};
use vademecum_build::parametric::{SeparationOptions, separate_responses};
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::{ParameterSpace, Prepared, prepare};
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_build::response::{BlockTerms, StageResponse, stage_responses};
use vademecum_build::store::StageCache;
use vademecum_format::Certificate;
use vademecum_format::scheme::SchemeTable;

use crate::error::StudyError;
use crate::scenario::{ContactEntry, Scenario};

/// Contents of a file beside the diagonal structure.
#[derive(Default)]
pub struct Form<'a> {
    /// The block structure.
    pub block: Option<BlockTerms<'a>>,
    /// Live parameters of the block structure.
    pub parameters: Option<&'a ParameterSpace>,
    /// Sections of another structure, which stand in place of the diagonal one.
    pub others: Vec<Draft>,
    /// The modes move exactly instead of by the stages of the scheme.
    pub exact: bool,
}

/// A value and the seconds it took.
pub struct Timed<T> {
    /// The value.
    pub value: T,
    /// Wall time \[s\].
    pub seconds: f64,
}

impl<T> Timed<T> {
    /// Does the work and times it.
    pub fn new(work: impl FnOnce() -> T) -> Self {
        let start = Instant::now();
        let value = work();
        Self { value, seconds: start.elapsed().as_secs_f64() }
    }

    /// Does work that may fail and times it.
    pub fn of<E>(work: impl FnOnce() -> Result<T, E>) -> Result<Self, E> {
        let Timed { value, seconds } = Timed::new(work);
        Ok(Self { value: value?, seconds })
    }
}

/// A body with its snapshots decomposed: what all methods start from.
pub struct Study {
    problem: Problem,
    prepared: Prepared,
    runs: SnapshotSchedule,
    pod: Pod,
    first_period: f64,
    prepare_seconds: f64,
    snapshot_seconds: f64,
}

impl Study {
    /// Assembles the model and takes the snapshots of the problem's plan, for bases of up to `max_modes`
    /// modes.
    ///
    /// Live parameters of the problem are left out: everything is compared at the values of the problem file.
    ///
    /// # Errors
    /// [`StudyError`], by cause.
    pub fn new(problem: &Problem, max_modes: usize, listener: &dyn Listener) -> Result<Self, StudyError> {
        Self::of(problem, max_modes, false, listener)
    }

    /// The same; `long` allows more than four hours of full-order marching.
    ///
    /// # Errors
    /// As [`Study::new`].
    pub fn of(
        problem: &Problem,
        max_modes: usize,
        long: bool,
        listener: &dyn Listener,
    ) -> Result<Self, StudyError> {
        if !problem.damping.modal_ratios().is_empty() || problem.has_loss() {
            return Err(StudyError::NoModalMarch);
        }
        if problem.is_large() {
            return Err(StudyError::LargeDisplacements);
        }
        if problem.is_free() {
            return Err(StudyError::FreeByStages);
        }
        let mut problem = problem.clone();
        if !problem.parameters.is_empty() {
            listener.note(
                "live parameters are left out: everything is compared at the values of the problem file",
            );
            problem.parameters.clear();
        }
        (problem.basis.kind, problem.basis.modes, problem.basis.energy) =
            (Some(BasisKind::Ritz), Some(max_modes), None);
        if problem.scheme() == (SchemeKind::Exact {}) {
            // What is compared moves by stages, beside a step that is exact.
            problem.time.scheme = Some(SchemeKind::Bathe {});
        }
        let prepared = Timed::of(|| prepare(&problem, &mut Stopwatch::new(listener), listener))?;
        listener.stage("snapshots");
        let pod = Timed::of(|| decompose(&problem, &prepared.value, long, listener))?;
        let (runs, pod_value, first_period) = pod.value;
        Ok(Self {
            problem,
            prepared: prepared.value,
            runs,
            pod: pod_value,
            first_period,
            prepare_seconds: prepared.seconds,
            snapshot_seconds: pod.seconds,
        })
    }

    /// The problem, for the most modes and without live parameters.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The plan of the snapshots.
    pub fn runs(&self) -> &SnapshotSchedule {
        &self.runs
    }

    /// The snapshots, decomposed.
    pub fn pod(&self) -> &Pod {
        &self.pod
    }

    /// The model.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// Its mass matrix, in whose norm errors are measured.
    pub fn mass(&self) -> &SymmetricMatrix {
        self.prepared.body.model.pencil().mass()
    }

    /// Time step \[s\].
    pub fn time_step(&self) -> f64 {
        self.prepared.step.time_step
    }

    /// First natural period \[s\].
    pub fn first_period(&self) -> f64 {
        self.first_period
    }

    /// Dimension of the snapshots: no POD basis has more modes.
    pub fn max_modes(&self) -> usize {
        self.pod.singular_values.len()
    }

    /// Seconds of reading, assembling and analysing: in every method's offline time.
    pub fn prepare_seconds(&self) -> f64 {
        self.prepare_seconds
    }

    /// Seconds of the snapshots and their decomposition: in the offline time of every method but natural
    /// modes.
    pub fn snapshot_seconds(&self) -> f64 {
        self.snapshot_seconds
    }

    /// A basis of a kind.
    ///
    /// # Errors
    /// [`StudyError`]: more modes than [`Study::max_modes`], or a stiffness that does not factorise.
    pub fn basis(&self, kind: BasisKind, modes: usize) -> Result<Timed<Basis>, StudyError> {
        Timed::of(|| {
            if kind == BasisKind::Modes {
                let found = lowest_modes(self.prepared.body.model.pencil(), &self.prepared.symbolic, modes)?;
                return Ok(modes_basis(found.vectors, found.eigenvalues));
            }
            if modes > self.max_modes() {
                let path = self.problem.place("basis.modes");
                return Err(BasisError::TooManyModes { path, asked: modes, found: self.max_modes() }.into());
            }
            let mut problem = self.problem.clone();
            problem.basis.kind = Some(kind);
            Ok(basis_of_pod(&problem, &self.prepared, &self.pod, modes)?)
        })
    }

    /// The full-order solves of the stages projected on a basis: the block structure is
    /// made of.
    ///
    /// # Errors
    /// [`StudyError`]: a stage that does not factorise.
    pub fn responses(&self, basis: &Basis) -> Result<Timed<Vec<StageResponse>>, StudyError> {
        Timed::of(|| Ok(stage_responses(&self.prepared, basis)?))
    }

    /// The bytes of a file with this basis: with responses the block structure, without them the diagonal
    /// structure alone. Its certificate is empty.
    ///
    /// # Errors
    /// [`StudyError`]: numbers a file cannot hold.
    pub fn file(
        &self,
        basis: &Basis,
        responses: Option<&[StageResponse]>,
    ) -> Result<Timed<Vec<u8>>, StudyError> {
        Timed::of(|| self.encode(basis, Form { block: responses.map(BlockTerms::fixed), ..Form::default() }))
    }

    /// The bytes of a file whose modes, natural ones, move exactly. Its certificate is empty.
    ///
    /// # Errors
    /// [`StudyError`]: numbers a file cannot hold.
    pub fn exact_file(&self, basis: &Basis) -> Result<Timed<Vec<u8>>, StudyError> {
        Timed::of(|| self.encode(basis, Form { exact: true, ..Form::default() }))
    }

    /// The bytes of a file with this basis in which one stiffness stays live, between half and twice the
    /// problem's: that of the first region, of the whole body where there is one. With them the number of
    /// terms.
    ///
    /// # Errors
    /// [`StudyError`]: a separation that fails, numbers a file cannot hold.
    pub fn separated_file(
        &self,
        basis: &Basis,
        tolerance: f64,
        listener: &dyn Listener,
    ) -> Result<Timed<(Vec<u8>, usize)>, StudyError> {
        const MAX_TERMS: usize = 100;
        Timed::of(|| {
            let Prepared { body, symbolic, scheme, .. } = &self.prepared;
            let mut problem = self.problem.clone();
            problem.parameters = vec![ParameterEntry {
                name: "stiffness".into(),
                kind: ParameterKind::Stiffness,
                region: body.model.mesh().regions[0].name.clone(),
                attachment: None,
                range: [0.5, 2.0],
                scale: ParameterScale::Log,
            }];
            let space = ParameterSpace::new(&problem, body.model.mesh(), self.prepared.rayleigh())?;
            let asked = SeparationOptions { tolerance, max_terms: MAX_TERMS };
            let pencil = body.model.pencil();
            let parametric = separate_responses(pencil, symbolic, basis, &space, scheme, &asked, listener)?;
            let form = Form { block: Some(parametric.terms()?), parameters: Some(&space), ..Form::default() };
            Ok((self.encode(basis, form)?, parametric.n_terms()))
        })
    }

    /// The bytes of a file with this basis and this form of the step. Its certificate is empty.
    ///
    /// # Errors
    /// [`StudyError`]: numbers a file cannot hold.
    pub fn encode(
        &self,
        basis: &Basis,
        Form { block, parameters, others, exact }: Form<'_>,
    ) -> Result<Vec<u8>, StudyError> {
        let Prepared { body, scheme, .. } = &self.prepared;
        let (scheme, scheme_name) = match exact {
            true => (&SchemeTable::EXACT, SchemeKind::Exact {}.to_string()),
            false => (scheme, self.problem.scheme().to_string()),
        };
        let rayleigh = self.prepared.rayleigh();
        let table = mode_table(
            &basis.quotients(),
            &basis.energy,
            scheme,
            (&rayleigh, &self.prepared.ratios),
            self.time_step(),
        );
        let parts = Parts {
            program: program(self.prepared.symbolic.solver()),
            problem: &self.problem,
            body,
            order: &NodeOrder::new(body),
            basis,
            scheme_name: &scheme_name,
            scheme,
            time_step: self.time_step(),
            rayleigh,
            block,
            diagonal: others.is_empty(),
            others: others.iter().collect(),
            parameters,
            separation: None,
            certificate: Certificate::default(),
            mode_table: table_matrix(&table),
        };
        Ok(encode(&parts).map_err(BuildError::from)?)
    }

    /// The full-order solver with a scheme and a step \[s\], factorised.
    ///
    /// # Errors
    /// [`StudyError`]: a stage that does not factorise.
    pub fn full_order(
        &self,
        scheme: &SchemeTable,
        time_step: f64,
    ) -> Result<Timed<FullOrder<'_>>, StudyError> {
        let (pencil, rayleigh) = (self.prepared.body.model.pencil(), self.prepared.rayleigh());
        Timed::of(|| Ok(FullOrder::new(pencil, &self.prepared.symbolic, scheme, time_step, rayleigh)?))
    }

    /// Scenario of a body for which none is given: an oblique push on the middle one of the
    /// loadable triangles, 200 steps long, and 1 800 steps free.
    ///
    /// # Errors
    /// [`StudyError::NothingToPush`].
    pub fn push(&self) -> Result<Scenario, StudyError> {
        let body = &self.prepared.body;
        let middle = body.loadable.get(body.loadable.len() / 2).ok_or(StudyError::NothingToPush)?;
        let corners = middle.map(|node| body.model.mesh().nodes[node as usize]);
        let point = std::array::from_fn(|c| corners.iter().map(|p| p[c]).sum::<f64>() / 3.0);
        let (force, end) = ([0.3, -0.5, -0.8], 200.0 * self.time_step());
        let push = ContactEntry::push(point, force, end);
        let duration = 2000.0 * self.time_step();
        Ok(Scenario { duration, contacts: vec![push], ..Scenario::default() })
    }
}

/// The plan, its snapshots and the first natural period.
fn decompose(
    problem: &Problem,
    prepared: &Prepared,
    long: bool,
    listener: &dyn Listener,
) -> Result<(SnapshotSchedule, Pod, f64), StudyError> {
    let (body, dt) = (&prepared.body, prepared.step.time_step);
    let pencil = body.model.pencil();
    let first_period = 1.0 / lowest_modes(pencil, &prepared.symbolic, 1)?.frequencies_hz()[0];
    prepared.check_time_step(first_period, listener)?;
    let full = FullOrder::new(pencil, &prepared.symbolic, &prepared.scheme, dt, prepared.rayleigh())?;
    let runs = SnapshotSchedule::plan(&problem.snapshots, body, dt, first_period);
    let at_once = runs.side_by_side(body.n_dof()).min(runs.count());
    let steps = runs.steps as f64 * runs.count().div_ceil(at_once) as f64;
    announce("snapshots to compare on", &full, at_once, steps, long, listener)?;
    let kept = CachedRuns { kept: &StageCache::new(None, prepared, listener), inputs: &|inputs| inputs };
    let pod = vademecum_build::basis::decompose(problem, body, Some(&full), &runs, &kept)?;
    Ok((runs, pod.expect("a Ritz basis is made of snapshots"), first_period))
}
