//! Marches of a million (reduced) to a hundred million steps: the energy of a released body stays bounded in
//! both precisions.

use vademecum_build::input::Problem;

use super::build::{build_kept, structures};
use super::{Form, Measured, Outcome};
use crate::long_march::energy_ratio;

/// Energy over a long free march of each structure, double and single.
pub fn free(problem: &Problem, form: Form) -> Outcome {
    march(problem, form.pick(1_000_000, 10_000_000))
}

/// The same, ten times as long in the full form.
pub fn longest(problem: &Problem, form: Form) -> Outcome {
    march(problem, form.pick(1_000_000, 100_000_000))
}

/// The same with 64 modes, whose dense step costs a hundred times as much.
pub fn stiff(problem: &Problem, form: Form) -> Outcome {
    march(problem, form.pick(20_000, 1_000_000))
}

fn march(problem: &Problem, steps: usize) -> Outcome {
    let built = match build_kept(problem) {
        Ok(built) => built,
        Err(refused) => return refused,
    };
    let mut measured = vec![];
    for (structure, certified) in structures(&built.report) {
        let names = if certified.structure == "block" {
            ["block", "block f32"]
        } else {
            ["diagonal", "diagonal f32"]
        };
        let energy = energy_ratio::<f64>(&built.bytes, structure, steps);
        measured.push(Measured { structure: names[0], energy, ..certified });
        let energy = energy_ratio::<f32>(&built.bytes, structure, steps);
        measured.push(Measured { structure: names[1], energy, ..certified });
    }
    Outcome::Ran(measured)
}
