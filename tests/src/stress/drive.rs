//! Loads that change every step, resonate, are huge or next to nothing: the file's march beside the
//! full-order one.

use std::f64::consts::TAU;

use vademecum_build::dynamics::INSTANTS;
use vademecum_build::dynamics::lowest_modes;
use vademecum_build::input::Problem;
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::format::File;
use vademecum_eval::{Loads, Scalar, Scene, State, StructureChoice};

use super::build::{build_kept, structures};
use super::reference::{Story, basis_of, errors};
use super::{Form, Measured, Outcome};
use crate::long_march::taking;

/// Whole sign change between any two steps.
pub fn switched(problem: &Problem, form: Form) -> Outcome {
    compare(problem, form.pick(500, 5000), |_| Load::Switched)
}

/// A sine of the first natural frequency: the amplitude grows linearly, and a phase error grows with it.
pub fn resonant(problem: &Problem, form: Form) -> Outcome {
    compare(problem, form.pick(500, 5000), |prepared| {
        let pencil = prepared.body.model.pencil();
        let first = lowest_modes(pencil, &prepared.symbolic, 1).expect("a mode");
        Load::Sine { steps_per_period: 1.0 / (first.frequencies_hz()[0] * prepared.step.time_step) }
    })
}

/// The pattern held from rest: a whole first period at T1/1e5 in the full form, a fifth of one in the
/// reduced.
pub fn held(problem: &Problem, form: Form) -> Outcome {
    compare(problem, form.pick(20_000, 100_000), |_| Load::Held)
}

/// A push of 1e12 times the pattern.
pub fn huge(problem: &Problem, form: Form) -> Outcome {
    compare(problem, form.pick(500, 5000), |_| Load::Push(1e12))
}

/// The same of 1e-12 times.
pub fn tiny(problem: &Problem, form: Form) -> Outcome {
    compare(problem, form.pick(500, 5000), |_| Load::Push(1e-12))
}

/// Pushes whose amplitude alternates between the smallest denormal and nothing: no step may fail, nothing may
/// move.
pub fn denormal(problem: &Problem, form: Form) -> Outcome {
    let built = match build_kept(problem) {
        Ok(built) => built,
        Err(refused) => return refused,
    };
    let (steps, load) = (form.pick(1000, 100_000), Load::Denormal);
    let mut measured = vec![];
    for (structure, certified) in structures(&built.report) {
        let double = march::<f64>(&built.bytes, structure, steps, &load);
        let single = march::<f32>(&built.bytes, structure, steps, &load);
        let largest = double.iter().chain(&single).flatten().fold(0.0_f64, |m, z| m.max(z.abs()));
        if largest > f64::MIN_POSITIVE {
            return Outcome::Wrong(format!("a denormal load moves the body by {largest:e}"));
        }
        measured.push(Measured::of(certified.structure));
    }
    Outcome::Ran(measured)
}

/// How the load pattern's amplitude runs.
enum Load {
    Switched,
    Sine {
        steps_per_period: f64,
    },
    /// For 50 steps.
    Push(f64),
    Held,
    Denormal,
}

impl Story for Load {
    fn amplitude(&self, n: usize, instants: [f64; INSTANTS]) -> [f64; INSTANTS] {
        let even = n.is_multiple_of(2);
        match *self {
            Load::Switched => [if even { 1.0 } else { -1.0 }; INSTANTS],
            Load::Sine { steps_per_period } => {
                instants.map(|c| (TAU * (n as f64 + c) / steps_per_period).sin())
            }
            Load::Push(size) => [if n < 50 { size } else { 0.0 }; INSTANTS],
            Load::Held => [1.0; INSTANTS],
            Load::Denormal => [if even { f64::from_bits(1) } else { 0.0 }; INSTANTS],
        }
    }
}

/// Builds, then marches the story full order and through each structure in both precisions.
pub fn compare<S: Story>(problem: &Problem, steps: usize, tell: impl Fn(&Prepared) -> S) -> Outcome {
    let built = match build_kept(problem) {
        Ok(built) => built,
        Err(refused) => return refused,
    };
    let prepared = prepare(problem, &mut Stopwatch::new(&Silent), &Silent).expect("prepared before");
    let story = tell(&prepared);
    let basis = basis_of(&built.bytes, &prepared.body);
    let structures = structures(&built.report);
    let both = |&(s, _): &_| {
        [march::<f64>(&built.bytes, s, steps, &story), march::<f32>(&built.bytes, s, steps, &story)]
    };
    let marched: Vec<[Vec<Vec<f64>>; 2]> = structures.iter().map(both).collect();
    let double: Vec<&Vec<Vec<f64>>> = marched.iter().map(|[double, _]| double).collect();
    let errors = errors(&prepared, &basis, &story, &double);
    let measured =
        structures.into_iter().zip(errors).zip(&marched).map(|(((_, certified), e), [double, single])| {
            let allowed = problem.tolerance.floor_ratio * e.floor + problem.tolerance.absolute;
            Measured {
                error: e.error,
                floor: e.floor,
                allowed,
                single: distance(single, double),
                ..certified
            }
        });
    Outcome::Ran(measured.collect())
}

/// ζ after each step; every live parameter is set before it.
fn march<T: Scalar>(
    bytes: &[u8],
    structure: StructureChoice,
    steps: usize,
    story: &dyn Story,
) -> Vec<Vec<f64>> {
    let file = File::parse(bytes).expect("a file");
    let options = taking(structure);
    let sizes = Scene::<T>::sizes(&file, &options).expect("options");
    let (mut memory, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("state memory");
    let mut loads = Loads::new(&scene, &mut loads).expect("load memory");
    // Both sides start without an acceleration: a state that is set has none but that of its numbers.
    state.restore(&vec![T::ZERO; 3 * scene.n_modes()]).expect("at rest");
    let one = |n: usize| {
        for (index, value) in story.parameters(n).into_iter().enumerate() {
            scene.set_parameters(&[(index, value)], &mut state, &mut work).expect("in range");
        }
        loads.clear();
        loads.add_pattern_staged(&scene, 0, &story.amplitude(n, scene.instants())).expect("a finite load");
        scene.step(&mut state, &loads).expect("a step");
        state.zeta().iter().map(|z| z.to_f64()).collect()
    };
    (0..steps).map(one).collect()
}

/// Relative distance of two marches over all steps.
pub fn distance(found: &[Vec<f64>], expected: &[Vec<f64>]) -> f64 {
    // Scaled first: squares of 1e-200 vanish.
    let size = expected.iter().flatten().fold(0.0_f64, |m, z| m.max(z.abs()));
    let square = |x: f64| (x / size) * (x / size);
    let apart: f64 = found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| square(a - b)).sum();
    (apart / expected.iter().flatten().map(|&b| square(b)).sum::<f64>()).sqrt()
}
