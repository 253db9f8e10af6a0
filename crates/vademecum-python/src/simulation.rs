//! A simulation in either precision, and outputs of it as arrays.

use numpy::Element;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat};
use vademecum_eval::{Field, Quantity, Scalar, Simulation};
use vademecum_study::parameters::{self, ParameterValue};

use crate::arrays::{filled, owned};
use crate::options::resolve;
use crate::refusal::{of_bind, of_output, of_study, unknown_quantity};

/// A precision of the evaluator and of NumPy.
pub trait Number: Scalar + Element + 'static {}

impl Number for f32 {}
impl Number for f64 {}

/// A simulation whose precision is known at run time.
pub enum AnySimulation {
    Single(Simulation<f32>),
    Double(Simulation<f64>),
}

/// The same lines in the precision of a value with the variants `Single` and `Double`.
macro_rules! either {
    ($any:expr, $of:ident, $one:ident => $lines:expr) => {
        match $any {
            $of::Single($one) => $lines,
            $of::Double($one) => $lines,
        }
    };
}
pub(crate) use either;

/// Python, and the caller's array if there is one.
pub type Out<'a, 'py> = (Python<'py>, Option<&'a Bound<'py, PyAny>>);

/// The nodes of the surface, shape (nodes, 3).
pub fn surface<'py, T: Number>(
    one: &Simulation<T>,
    field: Field,
    (py, out): Out<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [one.file().metadata().n_surface_nodes as usize, 3];
    filled::<T>(py, &shape, out, |slice| one.surface_into(field, slice).map_err(of_output))
}

/// All nodes, shape (nodes, 3).
pub fn whole<'py, T: Number>(
    one: &Simulation<T>,
    field: Field,
    (py, out): Out<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [one.file().metadata().n_nodes as usize, 3];
    filled::<T>(py, &shape, out, |slice| one.body_into(field, slice).map_err(of_output))
}

/// A quantity as a number or an array.
pub fn shown(py: Python<'_>, quantity: Quantity, numbers: Vec<f64>) -> PyResult<Bound<'_, PyAny>> {
    let length = numbers.len();
    match (quantity, &numbers[..]) {
        (Quantity::Surface | Quantity::Whole, _) => owned(py, numbers, &[length / 3, 3]),
        (_, &[one]) => Ok(PyFloat::new(py, one).into_any()),
        _ => owned(py, numbers, &[length]),
    }
}

/// A quantity by its name.
pub fn quantity(name: &str) -> PyResult<Quantity> {
    Quantity::find(name).ok_or_else(|| unknown_quantity(name))
}

/// Quantities that a body has, by name, as `vademecum.Quantity`.
pub fn quantities<'py, T: Number>(py: Python<'py>, one: &Simulation<T>) -> PyResult<Bound<'py, PyDict>> {
    let (all, class) = (PyDict::new(py), py.import("vademecum._data")?.getattr("Quantity")?);
    for quantity in Quantity::ALL {
        let (name, count, length) =
            (quantity.name(), one.body().count(quantity), one.body().length(quantity));
        let [unit, rate] = [Field::Displacement, Field::Velocity].map(|field| quantity.unit(field));
        if count > 0 {
            all.set_item(name, class.call1((name, quantity.text(), count, length, unit, rate))?)?;
        }
    }
    Ok(all)
}

/// Values of live parameters by name.
pub fn values<'py, T: Number>(py: Python<'py>, one: &Simulation<T>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (index, parameter) in one.parameters().enumerate() {
        dict.set_item(parameter.name, one.parameter(index))?;
    }
    Ok(dict)
}

/// Sets live parameters by name: all of them, or none if one is refused.
pub fn change<T: Number>(one: &mut Simulation<T>, given: Vec<(String, f64)>) -> PyResult<()> {
    let settings = {
        let known: Vec<_> = one.parameters().collect();
        let meant = |(name, value)| ParameterValue { name: resolve(&known, name), value };
        let given: Vec<_> = given.into_iter().map(meant).collect();
        parameters::resolve(&known, &given).map_err(of_study)?
    };
    one.set_parameters(&settings).map_err(of_bind)
}
