//! A long build that was stopped goes on where it was: its finished stages are kept and found again by what they were
//! computed from.
//!
//! Each stage has an address, a hash of everything it reads: numbers of the model, the basis before it, the keys of the problem
//! file that it looks at. A result is used again only under the very same address, so a changed input rebuilds the stages that
//! depend on it and no others, and a build gives the same bytes with and without what is kept. The odd thing: addresses go by
//! content and not by history, so a change that leaves a basis as it was leaves all that follows from it too.
//!
//! Cheap stages (mesh, matrices, factorisations, stage responses) are not kept.

mod inputs;
pub mod matrix;
mod store;

pub use store::Store;

use serde::Serialize;
use serde::de::DeserializeOwned;
use vademecum_format::StructureCertificate;

use crate::parametric::{ParameterSpace, SeparationOptions, Setting};
use crate::pipeline::Prepared;
use crate::pod::Basis;
use crate::problem::{BasisKind, Problem};
use crate::progress::Listener;
use crate::snapshots::Runs;
pub(crate) use inputs::Inputs;
use store::Found;

/// The finished stages of one build.
pub struct Kept<'a> {
    store: Option<(&'a Store, Inputs)>,
    prepared: &'a Prepared,
    /// Hears what was used again and what was not.
    pub listener: &'a dyn Listener,
}

impl<'a> Kept<'a> {
    /// Of the build of a model; without a store every stage is computed.
    pub fn new(store: Option<&'a Store>, prepared: &'a Prepared, listener: &'a dyn Listener) -> Self {
        let store = store.map(|store| (store, Inputs::none().model(&prepared.body.model)));
        Self { store, prepared, listener }
    }

    /// The result of a stage: the kept one for the same model and `inputs`, or that of `work`, which is then kept.
    ///
    /// # Errors
    /// Of `work`. A store that cannot be written costs a note, not the build.
    pub(crate) fn stage<T: Serialize + DeserializeOwned, E>(
        &self,
        name: &str,
        inputs: impl FnOnce(Inputs) -> Inputs,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let Some((store, model)) = &self.store else { return work() };
        let address = inputs(model.clone().value(&name)).address();
        match store.read(name, address) {
            Found::Whole(result) => {
                self.listener.note(&format!("{name}: reused"));
                return Ok(result);
            }
            Found::Damaged(path) => {
                self.listener.note(&format!("{name}: {} is damaged, computed again", path.display()));
            }
            Found::Other => self.listener.note(&format!("{name}: rebuilt, what it depends on has changed")),
            Found::Nothing => {}
        }
        let result = work()?;
        if let Err(error) = store.write(name, address, &result) {
            self.listener.note(&format!("{name}: not kept in {}: {error}", store.folder().display()));
        }
        Ok(result)
    }

    /// Snapshots and basis, and the number of snapshots.
    pub(crate) fn basis<E>(
        &self,
        problem: &Problem,
        runs: &Runs,
        work: impl FnOnce() -> Result<(Basis, usize), E>,
    ) -> Result<(Basis, usize), E> {
        let Prepared { scheme, step, body, .. } = self.prepared;
        let plan = &problem.snapshots;
        let imported = plan.npy.iter().chain(plan.vtu.iter().flatten());
        let inputs = |inputs: Inputs| match problem.basis.kind {
            BasisKind::Modes => inputs.value(&problem.basis),
            _ if plan.npy.is_some() || plan.vtu.is_some() => {
                let known = inputs.value(&(&problem.basis, &plan.field, body.mesh_hash));
                imported.fold(known, |inputs, path| inputs.file(&problem.resolve(path)))
            }
            _ => inputs.value(&(&problem.basis, scheme, step, runs)),
        };
        self.stage("basis", inputs, work)
    }

    /// Snapshots and Ritz vectors of one parameter sample, and the number of snapshots.
    pub(crate) fn sample<E>(
        &self,
        index: usize,
        setting: &Setting,
        runs: &Runs,
        wanted: (usize, usize),
        work: impl FnOnce() -> Result<(Basis, usize), E>,
    ) -> Result<(Basis, usize), E> {
        let inputs = |inputs: Inputs| inputs.value(&(&self.prepared.scheme, setting, runs, wanted));
        self.stage(&format!("sample-{}", index + 1), inputs, work)
    }

    /// The separated solution over the parameters.
    pub(crate) fn separation<T: Serialize + DeserializeOwned, E>(
        &self,
        basis: &Basis,
        asked: &SeparationOptions,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let Prepared { scheme, space, .. } = self.prepared;
        let inputs = |inputs: Inputs| inputs.value(&(scheme, moved(space), asked)).basis(basis);
        self.stage("separation", inputs, work)
    }

    /// A march of the certificate, one row of numbers per structure.
    pub(crate) fn certificate<E>(
        &self,
        name: &str,
        inputs: impl FnOnce(Inputs) -> Inputs,
        work: impl FnOnce() -> Result<Vec<StructureCertificate>, E>,
    ) -> Result<Vec<StructureCertificate>, E> {
        let rows = self.stage(name, inputs, || {
            Ok(work()?.iter().map(StructureCertificate::numbers).collect::<Vec<_>>())
        })?;
        Ok(rows.into_iter().map(StructureCertificate::from_numbers).collect())
    }
}

/// What the parameters can do to the responses: names and nominal values do nothing.
fn moved(space: &ParameterSpace) -> impl std::fmt::Debug {
    let lowest: Vec<f64> = space.parameters.iter().map(|p| p.lower).collect();
    let moves: Vec<_> = space.parameters.iter().map(|p| (p.role, p.lower, p.upper, p.log)).collect();
    (space.setting(&lowest), moves)
}
