//! Run time against error: what `vademecum bench` compares, made from the same pieces as a build.
//!
//! One model, one set of snapshots and one POD serve every basis, and one full-order march serves every error, so that two
//! rows differ by the basis and the structure of the step and by nothing else. Each piece is timed where it is made; a
//! method's offline time is the sum of the pieces it needs, as if it had been built alone. Stepping files is the
//! evaluator's work and is timed by the program; here is only the plain reduced solver, [`DenseGalerkin`].

mod galerkin;
mod trajectory;

pub use galerkin::{DenseGalerkin, GalerkinState, Load, ReducedForces};
pub use trajectory::{Trajectory, distance, reduced_errors};

use std::time::Instant;

use vademecum_format::Certificate;
use vademecum_format::scheme::SchemeTable;

use crate::dynamics::{FullOrder, lowest_modes};
use crate::export::{BlockTerms, Parts, encode};
use crate::march::TimedLoad;
use crate::pipeline::{
    BuildError, Prepared, basis_of_pod, make_pod, mode_table, prepare, stage_responses, table_matrix,
};
use crate::pod::{Basis, Pod, modes_basis};
use crate::problem::{BasisKind, Problem};
use crate::progress::{Listener, Stopwatch};
use crate::snapshots::Runs;

/// A value and the seconds it took.
pub struct Timed<T> {
    /// The value.
    pub value: T,
    /// Wall time \[s\].
    pub seconds: f64,
}

impl<T> Timed<T> {
    /// Does the work and times it.
    fn of<E>(work: impl FnOnce() -> Result<T, E>) -> Result<Self, E> {
        let start = Instant::now();
        let value = work()?;
        Ok(Self { value, seconds: start.elapsed().as_secs_f64() })
    }
}

/// A body with its snapshots decomposed: what all methods start from.
pub struct Study {
    problem: Problem,
    prepared: Prepared,
    pod: Pod,
    first_period: f64,
    prepare_seconds: f64,
    snapshot_seconds: f64,
}

impl Study {
    /// Assembles the model and takes the snapshots of the problem's plan, for bases of up to `max_modes` modes.
    ///
    /// Live parameters of the problem are left out: everything is compared at the values of the problem file.
    ///
    /// # Errors
    /// [`BuildError`], by cause.
    pub fn new(problem: &Problem, max_modes: usize, listener: &dyn Listener) -> Result<Self, BuildError> {
        let mut problem = problem.clone();
        if !problem.parameters.is_empty() {
            listener.note(
                "live parameters are left out: everything is compared at the values of the problem file",
            );
            problem.parameters.clear();
        }
        (problem.basis.kind, problem.basis.modes, problem.basis.energy) =
            (BasisKind::Ritz, Some(max_modes), None);
        let prepared = Timed::of(|| prepare(&problem, &mut Stopwatch::new(listener), listener))?;
        listener.stage("snapshots");
        let pod = Timed::of(|| decompose(&problem, &prepared.value, listener))?;
        let (pod_value, first_period) = pod.value;
        Ok(Self {
            problem,
            prepared: prepared.value,
            pod: pod_value,
            first_period,
            prepare_seconds: prepared.seconds,
            snapshot_seconds: pod.seconds,
        })
    }

    /// The model.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// Time step \[s\].
    pub fn time_step(&self) -> f64 {
        self.problem.time.step
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

    /// Seconds of the snapshots and their decomposition: in the offline time of every method but natural modes.
    pub fn snapshot_seconds(&self) -> f64 {
        self.snapshot_seconds
    }

    /// A basis of a kind.
    ///
    /// # Errors
    /// [`BuildError`]: more modes than [`Study::max_modes`], or a stiffness that does not factorise.
    pub fn basis(&self, kind: BasisKind, modes: usize) -> Result<Timed<Basis>, BuildError> {
        Timed::of(|| {
            if kind == BasisKind::Modes {
                let found = lowest_modes(self.prepared.body.model.pencil(), &self.prepared.symbolic, modes)?;
                return Ok(modes_basis(found.vectors, found.eigenvalues));
            }
            if modes > self.max_modes() {
                let path = self.problem.place("basis.modes");
                return Err(BuildError::TooManyModes { path, asked: modes, found: self.max_modes() });
            }
            let mut problem = self.problem.clone();
            problem.basis.kind = kind;
            Ok(basis_of_pod(&problem, &self.prepared, &self.pod, modes)?)
        })
    }

    /// The bytes of a file with this basis: with `block` the block structure and its full-order solves, without it the
    /// diagonal structure alone. Its certificate is empty.
    ///
    /// # Errors
    /// [`BuildError`]: a stage that does not factorise, numbers a file cannot hold.
    pub fn file(&self, basis: &Basis, block: bool) -> Result<Timed<Vec<u8>>, BuildError> {
        Timed::of(|| {
            let Prepared { body, scheme, .. } = &self.prepared;
            let responses = if block { Some(stage_responses(&self.prepared, basis)?) } else { None };
            let rayleigh = self.prepared.rayleigh();
            let table = mode_table(basis, scheme, &rayleigh, self.time_step());
            let parts = Parts {
                problem: &self.problem,
                body,
                basis,
                scheme_name: &self.problem.time.scheme.to_string(),
                scheme,
                rayleigh,
                block: responses.as_deref().map(BlockTerms::fixed),
                parameters: None,
                separation: None,
                certificate: Certificate::default(),
                mode_table: table_matrix(&table),
            };
            Ok(encode(&parts)?)
        })
    }

    /// The plain reduced solver in a basis.
    ///
    /// # Errors
    /// None of its own; timed like the other pieces.
    pub fn galerkin(&self, basis: &Basis) -> Result<Timed<DenseGalerkin>, BuildError> {
        let rayleigh = self.prepared.rayleigh();
        Timed::of(|| Ok(DenseGalerkin::new(basis, &self.prepared.scheme, self.time_step(), rayleigh)))
    }

    /// Marches loads full order from rest with a scheme and `split` steps in each of the problem's `steps` steps, and keeps
    /// the displacement after each of the latter. Its seconds are those of the factorisation.
    ///
    /// # Errors
    /// [`BuildError`]: a stage that does not factorise, a march that is stopped.
    pub fn march(
        &self,
        scheme: &SchemeTable,
        split: usize,
        loads: &[TimedLoad],
        steps: usize,
        listener: &dyn Listener,
    ) -> Result<Timed<Trajectory>, BuildError> {
        let (pencil, dt) = (self.prepared.body.model.pencil(), self.time_step() / split as f64);
        let full = Timed::of(|| {
            FullOrder::new(pencil, &self.prepared.symbolic, scheme, dt, self.prepared.rayleigh())
        })?;
        let value = Trajectory::march(&full.value, split, loads, steps, listener)?;
        Ok(Timed { value, seconds: full.seconds })
    }
}

/// Snapshots of the plan and the first natural period.
fn decompose(
    problem: &Problem,
    prepared: &Prepared,
    listener: &dyn Listener,
) -> Result<(Pod, f64), BuildError> {
    let (body, dt) = (&prepared.body, problem.time.step);
    let pencil = body.model.pencil();
    let first_period = 1.0 / lowest_modes(pencil, &prepared.symbolic, 1)?.frequencies_hz()[0];
    let full = FullOrder::new(pencil, &prepared.symbolic, &prepared.scheme, dt, prepared.rayleigh())?;
    let runs = Runs::plan(&problem.snapshots, body, dt, first_period);
    let pod = make_pod(problem, body, &full, &runs, listener)?;
    Ok((pod.expect("a Ritz basis is made of snapshots"), first_period))
}
