//! NaN and infinity as load, state, option and parameter: an error each, and nothing changed.

use vademecum_build::input::Problem;
use vademecum_eval::format::File;
use vademecum_eval::{Contact, Place, Scalar, Scene, SceneOptions, State, StepError, StructureChoice};

use super::build::{build_kept, structures};
use super::{Form, Measured, Outcome};
use crate::long_march::{middle_contact, taking};
use crate::stage::with_scene;

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

/// Every way in, both structures, both precisions.
pub fn not_finite(problem: &Problem, _: Form) -> Outcome {
    let built = match build_kept(problem) {
        Ok(built) => built,
        Err(refused) => return refused,
    };
    let structures = structures(&built.report);
    let mut faults = vec![];
    for &(structure, _) in &structures {
        faults.extend(attack::<f64>(&built.bytes, structure));
        faults.extend(attack::<f32>(&built.bytes, structure));
        faults.extend(bad_options(&built.bytes, structure));
    }
    match faults.first() {
        None => Outcome::Ran(structures.into_iter().map(|(_, m)| Measured::of(m.structure)).collect()),
        Some(first) => Outcome::Wrong(first.clone()),
    }
}

/// What a scene and its state let through.
fn attack<T: Scalar>(bytes: &[u8], structure: StructureChoice) -> Vec<String> {
    let contact = middle_contact(bytes);
    with_scene::<T, _>(bytes, &taking(structure), |scene, state, loads| {
        let r = scene.n_modes();
        loads.add_contact(scene, &contact).expect("a loadable triangle");
        for _ in 0..3 {
            scene.step(state, loads).expect("a step");
        }
        let mut faults = vec![];
        let mut expect = |what: &str, refused: bool| {
            if !refused {
                faults.push(format!("{structure:?}: {what} was taken"));
            }
        };
        let before = bits(state);
        for bad in BAD {
            loads.clear();
            let force = Contact { force: [0.0, bad, 0.0], ..contact };
            expect("a force", loads.add_contact(scene, &force).is_err());
            let weights = Contact { place: Place::triangle([0, 1, 2], [bad, 0.5, 0.5]), ..contact };
            expect("a weight", loads.add_contact(scene, &weights).is_err());
            expect("an amplitude", loads.add_pattern(scene, 0, bad).is_err());
            expect("an instant", loads.add_pattern_staged(scene, 0, &[bad; 4]).is_err());
            expect("a refused load", loads.is_empty());
            let mut saved = vec![T::ZERO; 3 * r];
            saved[r] = T::from_f64(bad);
            expect("a restored state", state.restore(&saved).is_err());
            let (mut zeta, zero) = (vec![0.0; r], vec![0.0; r]);
            zeta[0] = bad;
            expect("a displacement", scene.set(state, &zeta, &zero, loads).is_err());
            expect("a velocity", scene.set(state, &zero, &zeta, loads).is_err());
        }
        expect("a change of the state", bits(state) == before);
        // Finite, but so large that the new state is not.
        let large = vec![T::from_f64(if T::EPSILON > 1e-10 { f64::from(f32::MAX) } else { f64::MAX }); 3 * r];
        state.restore(&large).expect("finite numbers");
        let before = bits(state);
        expect("an overflow", scene.step(state, loads) == Err(StepError::NotFinite));
        expect("a change by an overflow", bits(state) == before);
        faults
    })
}

fn bits<T: Scalar>(state: &State<'_, T>) -> Vec<u64> {
    let parts = [state.zeta(), state.scaled_velocity(), state.scaled_acceleration()];
    parts.into_iter().flatten().map(|z| z.to_f64().to_bits()).collect()
}

/// What binding lets through.
fn bad_options(bytes: &[u8], structure: StructureChoice) -> Vec<String> {
    let file = File::parse(bytes).expect("a file");
    let base = taking(structure);
    let mut all = vec![];
    for bad in BAD {
        all.extend([
            ("a time step", SceneOptions { time_step: Some(bad), ..base }),
            ("a stiffness", SceneOptions { stiffness: bad, ..base }),
            ("a density", SceneOptions { density: bad, ..base }),
            ("alpha", SceneOptions { alpha: Some(bad), ..base }),
            ("beta", SceneOptions { beta: Some(bad), ..base }),
            (
                "a rest threshold",
                SceneOptions { rest_below: if bad > 0.0 { -1.0 } else { f64::NAN }, ..base },
            ),
        ]);
    }
    let sizes = Scene::<f64>::sizes(&file, &base).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let taken = |options: &SceneOptions, memory: &mut [f64], work: &mut [f64]| {
        Scene::<f64>::bind(&file, options, memory, work).is_ok()
    };
    let mut faults = vec![];
    for (what, options) in all {
        if taken(&options, &mut memory, &mut work) {
            faults.push(format!("{structure:?}: {what} that is no number was bound"));
        }
    }
    faults
}
