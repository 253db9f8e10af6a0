//! The adjoint of a march of a body.

use numpy::{PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use vademecum_eval::{AdjointError, Cotangents, Field, Simulation, SurfacePoint};

use crate::simulation::Number;

/// Cotangents of displacements and of velocities of the probes after each step.
pub fn of_probes(given: &Bound<'_, PyAny>, probes: usize) -> PyResult<Vec<[Vec<f64>; 2]>> {
    let words = |shape: &[usize]| {
        PyValueError::new_err(format!(
            "cotangents: expected the shape (steps, {probes}) or (steps, 2, {probes}), found {shape:?}"
        ))
    };
    if let Ok(both) = given.extract::<PyReadonlyArray3<'_, f64>>() {
        let &[_, fields, width] = both.shape() else { return Err(words(both.shape())) };
        if fields != 2 || width != probes {
            return Err(words(both.shape()));
        }
        let both = both.as_array();
        return Ok(both.outer_iter().map(|step| [0, 1].map(|field| step.row(field).to_vec())).collect());
    }
    let one = given.extract::<PyReadonlyArray2<'_, f64>>().map_err(|_| {
        PyTypeError::new_err("cotangents: expected an array of float64 with a row for each step")
    })?;
    if one.shape()[1] != probes {
        return Err(words(one.shape()));
    }
    Ok(one.as_array().outer_iter().map(|step| [step.to_vec(), vec![]]).collect())
}

/// Gradients of a march of a body: forces at places, amplitudes of patterns, the start.
pub struct BodyGradient {
    pub forces: Vec<f64>,
    pub patterns: Vec<f64>,
    pub zeta: Vec<f64>,
    pub velocity: Vec<f64>,
}

/// Goes back over a march with the cotangents of the probes.
pub fn of_body<T: Number>(
    one: &Simulation<T>,
    cotangents: &[[Vec<f64>; 2]],
    (places, patterns): (&[SurfacePoint], &[usize]),
) -> Result<BodyGradient, AdjointError> {
    let (body, scene) = (one.body(), one.scene());
    let sizes = body.adjoint_sizes()?;
    let (mut memory, mut lent) = (vec![T::ZERO; sizes.adjoint], vec![T::ZERO; sizes.cotangents]);
    let mut adjoint = body.adjoint(&mut memory)?;
    let mut of_outputs = Cotangents::new(scene, &mut lent)?;
    let (steps, r) = (cotangents.len(), scene.n_modes());
    let mut found = BodyGradient {
        forces: vec![0.0; 6 * steps * places.len()],
        patterns: vec![0.0; 2 * steps * patterns.len()],
        zeta: vec![0.0; r],
        velocity: vec![0.0; r],
    };
    for (step, fields) in cotangents.iter().enumerate().rev() {
        of_outputs.clear();
        for (own, field) in fields.iter().zip([Field::Displacement, Field::Velocity]) {
            for (probe, &own) in own.iter().enumerate().filter(|own| *own.1 != 0.0) {
                of_outputs.add_probe(scene, probe, field, own)?;
            }
        }
        adjoint.back(scene, &of_outputs)?;
        for (k, place) in places.iter().enumerate() {
            let at = 6 * (step * places.len() + k);
            let own = adjoint.force(scene, place)?;
            found.forces[at..at + 6].copy_from_slice(own.as_flattened());
        }
        for (k, &pattern) in patterns.iter().enumerate() {
            let at = 2 * (step * patterns.len() + k);
            found.patterns[at..at + 2].copy_from_slice(&adjoint.pattern(scene, pattern)?);
        }
    }
    adjoint.initial_into(scene, &mut found.zeta, &mut found.velocity)?;
    Ok(found)
}
