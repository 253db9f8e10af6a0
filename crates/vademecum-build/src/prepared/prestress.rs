//! The static state of a prestress, and the body about it.

use faer::Mat;

use super::body::Body;
use super::body_error::BodyError;
use crate::fem::{FactorError, Prestress, Rotation, Solve, Symbolic, buckling_factor};
use crate::input::{PrestressEntry, Problem};
use crate::limits::{Memory, TooMuchMemory};
use crate::linalg::unit;
use crate::progress::Listener;

/// The body of a problem about the static state of its prestress.
///
/// # Errors
/// A body that is not held, that buckles, or that does not fit into memory.
pub(super) fn prestressed<E: From<BodyError> + From<FactorError> + From<TooMuchMemory>>(
    problem: &Problem,
    entry: &PrestressEntry,
    body: Body,
    memory: Memory,
    listener: &dyn Listener,
) -> Result<Body, E> {
    let (model, pencil) = (&body.model, body.model.pencil());
    let symbolic = Symbolic::analyze(pencil)?;
    // Both stiffnesses and one factor at a time.
    let needed = symbolic.factor_bytes() as f64 + 2.0 * pencil.bytes() as f64;
    memory.check(needed, ": a coarser mesh", || format!("the prestress of {} free dofs", body.n_dof()))?;
    let rotations: Vec<Rotation> = rotation(entry).into_iter().collect();
    let load = static_load(problem, entry, &rotations, &body);
    let mut displacement = Mat::from_fn(body.n_dof(), 1, |i, _| load[i]);
    let factor = symbolic.factorize(pencil.stiffness().clone())?;
    Solve::new(&symbolic, 1, true).solve_in_place(&factor, displacement.as_mut());
    drop(factor);
    let free = displacement.col_as_slice(0);
    let largest = body.largest_displacement(free);
    let mut whole = vec![0.0; model.dofs().n_dof()];
    model.dofs().expand_into(free, &mut whole);
    let state =
        Prestress { displacement: whole, free: free_strain(entry, &body), rotations, displaced: false };
    let path = || problem.place("prestress");
    let loaded = model.about(state).map_err(|source| BodyError::Model { path: path(), source })?;
    let symbolic = Symbolic::analyze(loaded.pencil())?;
    match symbolic.factorize(loaded.pencil().stiffness().clone()) {
        Ok(_) => {}
        Err(FactorError::NotPositiveDefinite { .. }) => {
            let factor = buckling_factor(&symbolic, pencil.stiffness(), loaded.pencil().stiffness())?;
            return Err(BodyError::Buckled { path: path(), factor }.into());
        }
        Err(other) => return Err(other.into()),
    }
    listener.note(&format!(
        "`[prestress]`: its static state moves the surface by at most {largest:.6e} m; displacements, stress and \
         energy are those of the motion about it"
    ));
    Ok(Body { model: loaded, ..body })
}

/// The strain of each element that makes no stress under the load case; none where nothing is heated.
fn free_strain(entry: &PrestressEntry, body: &Body) -> Vec<[[f64; 3]; 3]> {
    let mut sum = vec![];
    for (pattern, strain) in &body.thermal {
        let Some(amplitude) = entry.loads.get(&body.patterns[*pattern].0) else { continue };
        sum.resize(strain.len(), [[0.0; 3]; 3]);
        for (sum, own) in sum.iter_mut().zip(strain) {
            (0..3).for_each(|c| (0..3).for_each(|i| sum[c][i] += amplitude * own[c][i]));
        }
    }
    sum
}

fn rotation(entry: &PrestressEntry) -> Option<Rotation> {
    let axis = unit(entry.axis?);
    let point = entry.point.unwrap_or_default();
    Some(Rotation { elements: None, speed_squared: entry.speed?.powi(2), point, axis })
}

/// The load case over the free dofs.
fn static_load(problem: &Problem, entry: &PrestressEntry, rotations: &[Rotation], body: &Body) -> Vec<f64> {
    let model = &body.model;
    let mut load = vec![0.0; body.n_dof()];
    let add = |load: &mut [f64], factor: f64, force: &[f64]| {
        load.iter_mut().zip(force).for_each(|(sum, f)| *sum += factor * f);
    };
    for (name, force) in &body.patterns {
        entry.loads.get(name).iter().for_each(|amplitude| add(&mut load, **amplitude, force));
    }
    let field = |at: [f64; 3]| {
        let constant = entry.acceleration.unwrap_or_default();
        rotations.iter().fold(constant, |sum, rotation| {
            let own = rotation.acceleration(at);
            std::array::from_fn(|c| sum[c] + own[c])
        })
    };
    add(&mut load, 1.0, &model.free_part(&model.inertia_load(field)));
    model.add_attached_weight(&problem.reference_places(), field, &mut load);
    load
}
