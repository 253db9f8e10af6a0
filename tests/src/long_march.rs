//! Long marches of a file: whether energy stays bounded, and how far single precision strays from double.

use vademecum_eval::{Contact, Loads, Place, Scalar, Scene, SceneOptions, State, StructureChoice};
use vademecum_format::{File, SectionKind};

use crate::stage::with_scene;

/// Steps between two looks at a long march.
const LOOK: usize = 1000;

/// Options that take a structure and nothing else.
#[must_use]
pub fn taking(structure: StructureChoice) -> SceneOptions {
    SceneOptions { structure, ..SceneOptions::default() }
}

/// A push of (1, −2, 0.5) N in the middle of the middle loadable triangle.
///
/// # Panics
/// If the file has no loadable triangle.
#[must_use]
pub fn middle_contact(bytes: &[u8]) -> Contact {
    let file = File::parse(bytes).expect("a file");
    let triangles = file.section(SectionKind::Triangles).expect("triangles").u32s().expect("indices");
    let corners = triangles.as_chunks::<3>().0[file.metadata().n_load_triangles as usize / 2];
    Contact::new(Place::triangle(corners.map(u32::from_le_bytes), [1.0 / 3.0; 3]), [1.0, -2.0, 0.5])
}

/// Largest energy of `steps` free steps over the energy at release; the push is held for 100 steps before.
///
/// # Panics
/// If a step fails.
#[must_use]
pub fn energy_ratio<T: Scalar>(bytes: &[u8], structure: StructureChoice, steps: usize) -> f64 {
    let contact = middle_contact(bytes);
    with_scene::<T, f64>(bytes, &taking(structure), |scene, state, loads| {
        push(scene, state, loads, &contact, 100);
        loads.clear();
        // The old acceleration still holds the force, so the scheme lets it fade over the first free step;
        // from then on nothing acts.
        scene.step(state, loads).expect("a step");
        let released = scene.energy(state).expect("energy");
        let mut largest = 0.0_f64;
        for step in 0..steps {
            scene.step(state, loads).expect("a step");
            // Every step of the first look, when most moves; then one in a thousand.
            if step < LOOK || step % LOOK == 0 {
                largest = largest.max(scene.energy(state).expect("energy"));
            }
        }
        largest / released
    })
}

fn push<T: Scalar>(
    scene: &Scene<'_, T>,
    state: &mut State<'_, T>,
    loads: &mut Loads<'_, T>,
    contact: &Contact,
    steps: usize,
) {
    loads.add_contact(scene, contact).expect("a loadable triangle");
    let zero = vec![0.0; scene.n_modes()];
    scene.set(state, &zero, &zero, loads).expect("the initial acceleration");
    (0..steps).for_each(|_| {
        scene.step(state, loads).expect("a step");
    });
}

/// How far single precision is from double.
#[derive(Clone, Copy, Debug)]
pub struct Precision {
    /// ‖ζ₃₂ − ζ₆₄‖ ÷ ‖ζ₆₄‖ after the last step of a push held all the time.
    pub held: f64,
    /// The same norm over all looks together, of a march released after 100 steps: the ringing itself.
    pub released: f64,
}

/// Marches `steps` steps in both precisions.
///
/// # Panics
/// If a step fails.
#[must_use]
pub fn precision(bytes: &[u8], structure: StructureChoice, steps: usize) -> Precision {
    let held = [path::<f32>(bytes, structure, steps, steps), path::<f64>(bytes, structure, steps, steps)];
    let released = [path::<f32>(bytes, structure, steps, 100), path::<f64>(bytes, structure, steps, 100)];
    let last = held[1].len() - 1;
    Precision {
        held: distance(&held[0][last..], &held[1][last..]),
        released: distance(&released[0], &released[1]),
    }
}

/// ζ at every look and after the last step; the push is held for the first `hold` steps.
fn path<T: Scalar>(bytes: &[u8], structure: StructureChoice, steps: usize, hold: usize) -> Vec<Vec<f64>> {
    let contact = middle_contact(bytes);
    with_scene::<T, _>(bytes, &taking(structure), |scene, state, loads| {
        let read = |state: &State<'_, T>| state.zeta().iter().map(|z| z.to_f64()).collect::<Vec<f64>>();
        push(scene, state, loads, &contact, 0);
        let mut looks = vec![];
        for step in 1..=steps {
            scene.step(state, loads).expect("a step");
            if step == hold {
                loads.clear();
            }
            // All of the first look, then one in 97: no multiple of a period.
            if step < LOOK || step % 97 == 0 || step == steps {
                looks.push(read(state));
            }
        }
        looks
    })
}

fn distance(found: &[Vec<f64>], expected: &[Vec<f64>]) -> f64 {
    let square = |x: f64| x * x;
    let apart: f64 = found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| square(a - b)).sum();
    (apart / expected.iter().flatten().map(|&b| square(b)).sum::<f64>()).sqrt()
}
