//! The same body in SI and in millimetres, tonnes and megapascals: the same answer.

use vademecum_build::input::Problem;
use vademecum_eval::{Field, StructureChoice};

use super::build::{build_kept, structures};
use super::drive::distance;
use super::{Form, Measured, Outcome};
use crate::long_march::taking;
use crate::stage::with_scene;

/// What the answers may be apart: rounding of the coordinates (ε of a node's position moves an eigenvalue by
/// some ε, 500 steps at 40 a period turn that into a phase), with three digits to spare.
const ALIKE: f64 = 1e-10;

/// Displacements over 500 steps of the push `pull` in both unit systems.
pub fn same_answer(problem: &Problem, form: Form) -> Outcome {
    let (si, mm) = match (build_kept(problem), build_kept(&in_millimetres(problem))) {
        (Ok(si), Ok(mm)) => (si, mm),
        (Err(refused), _) | (_, Err(refused)) => return refused,
    };
    let steps = form.pick(500, 5000);
    let compared = structures(&si.report).into_iter().map(|(structure, certified)| {
        let metres = field(&si.bytes, structure, steps, 1.0);
        // 1 MPa mm² = 1 N, and the unit of force is t mm/s² = N; displacements come in mm.
        let millimetres = field(&mm.bytes, structure, steps, 1e-3);
        Measured { error: distance(&millimetres, &metres), allowed: ALIKE, floor: 0.0, ..certified }
    });
    Outcome::Ran(compared.collect())
}

/// Lengths × 1e3, stresses × 1e-6, densities (t/mm³) × 1e-12; times stay.
fn in_millimetres(problem: &Problem) -> Problem {
    let mut problem = problem.clone();
    let block = problem.mesh.block.as_mut().expect("a block");
    block.lengths = block.lengths.map(|l| 1e3 * l);
    for material in &mut problem.materials {
        material.young = material.young.map(|young| 1e-6 * young);
        material.density *= 1e-12;
    }
    for pattern in &mut problem.load.patterns {
        pattern.traction = pattern.traction.map(|t| t.map(|t| 1e-6 * t));
    }
    problem
}

/// Displacements of the surface times `scale` after each step; the load is let go after 50.
fn field(bytes: &[u8], structure: StructureChoice, steps: usize, scale: f64) -> Vec<Vec<f64>> {
    with_scene::<f64, _>(bytes, &taking(structure), |scene, state, loads| {
        loads.add_pattern(scene, 0, 1.0).expect("the pattern");
        let mut out = vec![0.0; 3 * scene.metadata().n_surface_nodes as usize];
        let one = |n: usize| {
            if n == 50 {
                loads.clear();
            }
            scene.step(state, loads).expect("a step");
            scene.surface_into(state, Field::Displacement, &mut out).expect("the surface");
            out.iter().map(|u| scale * u).collect()
        };
        (0..steps).map(one).collect()
    })
}
