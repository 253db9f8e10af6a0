//! Cause and remedy of errors.

use super::*;
use vademecum_build::fem::{EngineError, FactorError, ModelError, Resource};
use vademecum_build::mesh_error::MeshErrorFailure;
use vademecum_build::progress::Cancelled;

/// The exit code is that of who can act, and the remedy is theirs, in whichever stage it was met.
#[test]
fn what_ran_short_is_told_with_a_remedy_for_it() {
    let of_ranks = |short| EngineError { call: "MUMPS".into(), reason: "no room".into(), short };
    let factor = |error: FactorError| {
        [
            BuildError::Factor(error.clone()),
            BasisError::Modes(ModesError::Factor(error.clone())).into(),
            PrepareError::Modes(ModesError::Factor(error)).into(),
        ]
    };
    let model = |source: ModelError| {
        let error = BodyError::Model { path: "problem.toml".into(), source };
        BuildError::from(PrepareError::from(error))
    };
    let told = |error: BuildError| {
        let failure = Failure::from(error);
        (failure.cause, failure.remedy)
    };
    for (short, words) in [(Resource::Memory, "more machines"), (Resource::Disk, "disk with room")] {
        let error = of_ranks(Some(short));
        let mut all = factor(error.clone().into()).map(told).to_vec();
        all.extend([told(model(error.clone().into())), told(ModesError::from(error).into())]);
        assert!(
            all.iter().all(|(cause, remedy)| *cause == Cause::Machine && remedy.contains(words)),
            "{all:?}"
        );
    }
    let refused = factor(FactorError::OutOfMemory).map(told);
    assert_eq!(refused, [(Cause::Machine, MEMORY); 3]);
    assert_eq!(told(model(ModelError::OutOfMemory)), (Cause::Machine, MEMORY));
    // What a library cannot do is no fault of supports and materials.
    assert_eq!(told(model(of_ranks(None).into())), (Cause::Numerics, ""));
    let indefinite = FactorError::NotPositiveDefinite { pivot: 1, n: 2 };
    assert_eq!(factor(indefinite).map(|error| told(error).0), [Cause::Numerics; 3]);
    let (cause, remedy) = told(model(ModelError::NothingFree));
    assert!(cause == Cause::Numerics && remedy.contains("[[support]]"), "{remedy}");
}

#[test]
fn a_search_that_is_stopped_is_no_failure_of_it() {
    let error = BuildError::from(BasisError::Modes(Cancelled.into()));
    assert_eq!(Failure::from(error).cause, Cause::Stopped);
    let error = || MeshErrorFailure::from(Cancelled);
    assert_eq!(Failure::from(BuildError::from(error())).cause, Cause::Stopped);
    assert_eq!(Failure::from(StudyError::from(error())).cause, Cause::Stopped);
}
