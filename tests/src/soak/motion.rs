//! What holds of the motion, through the evaluator on the bytes that the program wrote: walks of live
//! parameters, reciprocity, superposition, energy.

use vademecum_build::certificate::BOUNDED;
use vademecum_eval::format::{File, Metadata};
use vademecum_eval::{
    BindError, Contact, Field, Loads, Scalar, Scene, SceneOptions, State, StructureChoice, Surface,
    SurfacePoint,
};

use super::dice::Dice;
use super::invariant::{Breach, Held, agree, breach, finite, no_growth};
use super::life::Done;
use super::place::{Built, Place};
use crate::stage::with_scene;

/// An error of the evaluator where there may be none.
fn unexpected<E: std::fmt::Display>(what: &'static str) -> impl Fn(E) -> Breach {
    move |error| Breach { invariant: "no error", found: format!("{what}: {error}") }
}

/// Live parameters moved at random inside their box, and outside of it, while the body is pushed.
///
/// # Errors
/// [`Breach`].
pub fn walk(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    if !built.problem.live {
        return Ok("no live parameter");
    }
    match dice.once_in(2) {
        true => walk_in::<f64>(&built, dice)?,
        false => walk_in::<f32>(&built, dice)?,
    }
    Ok("done")
}

fn walk_in<T: Scalar + PartialEq>(built: &Built, dice: &mut Dice) -> Held {
    let file = File::parse(&built.bytes).map_err(unexpected("the file"))?;
    let options = SceneOptions::default();
    let sizes = Scene::<T>::sizes(&file, &options).map_err(unexpected("its sizes"))?;
    let (mut memory, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).map_err(unexpected("bind"))?;
    let mut state = State::new(&scene, &mut state).map_err(unexpected("a state"))?;
    let mut loads = Loads::new(&scene, &mut loads).map_err(unexpected("loads"))?;
    let mut saved = [vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.state]];
    let parameters = file.metadata().active_parameters();
    for _ in 0..300 {
        if dice.once_in(5) {
            let index = dice.below(parameters.len());
            let (low, high) = (parameters[index].lower, parameters[index].upper);
            let outside = dice.once_in(4);
            let value = match (outside, dice.below(4)) {
                (true, 0) => f64::NAN,
                (true, 1) => low - (high - low) - 1e-3,
                (true, _) => high + dice.log(1e-6, 1e6) * (high - low),
                // The ends of the range are inside.
                (false, 0) => low,
                (false, 1) => high,
                (false, _) => dice.between(low, high),
            };
            let length = scene.state_numbers();
            let [before, after] = &mut saved;
            state.save_into(&mut before[..length]).map_err(unexpected("save"))?;
            let set = scene.set_parameters(&[(index, value)], &mut state, &mut work);
            state.save_into(&mut after[..length]).map_err(unexpected("save"))?;
            match set {
                Ok(()) if outside => {
                    return breach("the box", format!("{value} outside {low} … {high} is taken"));
                }
                Ok(()) | Err(BindError::NotDiagonal) => {}
                Err(_) if outside && before == after => {}
                Err(_) if outside => return breach("the box", "a refused value changed the state"),
                Err(error) => return breach("the box", format!("{value} in {low} … {high}: {error}")),
            }
            loads.clear();
        }
        if dice.once_in(3) {
            loads.clear();
            if let Some(contact) = contact(&file, dice, built) {
                loads.add_contact(&scene, &contact).map_err(unexpected("a contact"))?;
            }
        }
        scene.step(&mut state, &loads).map_err(unexpected("a step"))?;
        let zeta: Vec<f64> = state.zeta().iter().map(|z| z.to_f64()).collect();
        finite("reduced coordinates", &zeta)?;
    }
    let energy = scene.energy(&state).map_err(unexpected("energy"))?;
    finite("energy", &[energy])
}

/// A point of the loadable surface near a random point of the body.
fn point(file: &File<'_>, dice: &mut Dice, built: &Built) -> Option<SurfacePoint> {
    let unit = dice.vector().map(f64::abs);
    let surface = Surface::new(file).ok()?;
    surface.locate([0, 1, 2].map(|k| unit[k] * built.problem.lengths[k]))
}

fn contact(file: &File<'_>, dice: &mut Dice, built: &Built) -> Option<Contact> {
    let point = point(file, dice, built)?;
    Some(Contact::new(point.place, dice.vector()))
}

/// Steps of a march whose laws are checked.
const STEPS: usize = 60;

/// A force at a point, and what it moves.
type Push = (SurfacePoint, [f64; 3]);

/// Displacements along the directions of `seen` under the sum of `pushes`, from rest: `seen.len()` a step.
fn march(bytes: &[u8], options: &SceneOptions, pushes: &[Push], seen: &[Push]) -> Result<Vec<f64>, Breach> {
    with_scene::<f64, _>(bytes, options, |scene, state, loads| {
        for (point, force) in pushes {
            let contact = Contact::new(point.place, *force);
            loads.add_contact(scene, &contact).map_err(unexpected("a contact"))?;
        }
        let mut all = vec![];
        for _ in 0..STEPS {
            scene.step(state, loads).map_err(unexpected("a step"))?;
            for (point, along) in seen {
                let moved = scene.point(state, point, Field::Displacement).map_err(unexpected("a point"))?;
                all.push((0..3).map(|k| moved[k] * along[k]).sum());
            }
        }
        Ok(all)
    })
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most: f64, number| most.max(number.abs()))
}

/// Reciprocity of the diagonal structure, superposition of every structure, and no energy from nothing.
///
/// # Errors
/// [`Breach`].
pub fn laws(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    if built.problem.canonical {
        return Ok("refused");
    }
    let file = File::parse(&built.bytes).map_err(unexpected("the file"))?;
    let (Some(a), Some(b)) = (point(&file, dice, &built), point(&file, dice, &built)) else {
        return Ok("nothing to push");
    };
    let (a, b) = ((a, dice.vector()), (b, dice.vector()));
    let metadata = file.metadata();
    // Roundings of a step carry through the rest at most in proportion to the steps, twice over: one sum over
    // the modes a step.
    let rounding = 8.0 * f64::EPSILON * f64::from(metadata.n_modes) * (STEPS * STEPS) as f64;
    let choices = [(metadata.diagonal, of_modes(metadata)), (metadata.block, StructureChoice::Block)];
    for (_, structure) in choices.into_iter().filter(|(there, _)| *there) {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        let [one, other, both] =
            [&[a][..], &[b][..], &[a, b][..]].map(|pushes| march(&built.bytes, &options, pushes, &[a, b]));
        let (one, other, both) = (one?, other?, both?);
        let size = largest(&one).max(largest(&other));
        let sum: Vec<f64> = one.iter().zip(&other).map(|(x, y)| x + y).collect();
        agree("superposition", &sum, &both, size, rounding)?;
        // Forces are read from one row of the basis, displacements from the other: the same numbers in double
        // precision alone.
        if structure == of_modes(metadata) && built.problem.double {
            let at_b: Vec<f64> = one.iter().skip(1).step_by(2).copied().collect();
            let at_a: Vec<f64> = other.iter().step_by(2).copied().collect();
            agree("reciprocity", &at_b, &at_a, size, rounding)?;
        }
    }
    if built.kept {
        energy(&built, &a, dice)?;
    }
    Ok("done")
}

/// Free steps after which the acceleration under a force that is gone has faded.
const FADING: usize = 20;

/// The structure that moves each mode by itself.
fn of_modes(metadata: &Metadata<'_>) -> StructureChoice {
    if metadata.scheme.is_exact() { StructureChoice::Exact } else { StructureChoice::Diagonal }
}

/// Pushed, let go: the energy of the structure whose certificate keeps the tolerance.
fn energy(built: &Built, push: &Push, dice: &mut Dice) -> Held {
    let held = dice.whole(1, 40);
    let file = File::parse(&built.bytes).map_err(unexpected("the file"))?;
    let dissipative = built.problem.dissipative && built.problem.double;
    let structure = if dissipative { of_modes(file.metadata()) } else { StructureChoice::Auto };
    let diagonal = dissipative && file.metadata().diagonal;
    // Every mode by itself loses energy in these schemes, or keeps it but for rounding.
    let bound = if diagonal { 1.0 + 1e-9 } else { BOUNDED };
    let structure = if diagonal { structure } else { StructureChoice::Auto };
    let options = SceneOptions { structure, ..SceneOptions::default() };
    let energies =
        with_scene::<f64, Result<Vec<f64>, Breach>>(&built.bytes, &options, |scene, state, loads| {
            let contact = Contact::new(push.0.place, push.1);
            loads.add_contact(scene, &contact).map_err(unexpected("a contact"))?;
            let mut step = |loads: &Loads<'_, f64>| {
                scene.step(state, loads).map_err(unexpected("a step"))?;
                scene.energy(state).map_err(unexpected("energy"))
            };
            for _ in 0..held {
                step(loads)?;
            }
            loads.clear();
            // The old acceleration still holds the force. One free step lets it fade where a scheme begins
            // each step anew; generalized-α carries a part of it on, which shrinks by at least a half in each
            // step.
            for _ in 0..FADING {
                step(loads)?;
            }
            (0..1000).map(|_| step(loads)).collect()
        })?;
    no_growth(&energies, bound)
}
