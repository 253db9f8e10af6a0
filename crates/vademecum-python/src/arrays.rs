//! Results in NumPy's arrays: written into the caller's array where one is given, and else into a new one.
//! Nothing is copied either way.

use numpy::{Element, IxDyn, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

const NOT_CONTIGUOUS: &str =
    "out: the array is not C-contiguous; pass one whose numbers lie side by side, row by row";

/// An array of this shape, filled by `write`.
pub fn filled<'py, T: Element>(
    py: Python<'py>,
    shape: &[usize],
    out: Option<&Bound<'py, PyAny>>,
    write: impl FnOnce(&mut [T]) -> PyResult<()>,
) -> PyResult<Bound<'py, PyAny>> {
    let array = match out {
        Some(out) => given::<T>(out, shape)?,
        None => PyArrayDyn::<T>::zeros(py, IxDyn(shape), false),
    };
    let mut lent = array.try_readwrite().map_err(|error| {
        PyValueError::new_err(format!("out: the array cannot be written to: {error}; pass a writable one"))
    })?;
    let slice = lent.as_slice_mut().map_err(|_| PyValueError::new_err(NOT_CONTIGUOUS))?;
    write(slice)?;
    drop(lent);
    Ok(array.into_any())
}

/// The caller's array, if it has the right type and shape.
fn given<'py, T: Element>(out: &Bound<'py, PyAny>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let array = out.cast::<PyArrayDyn<T>>().map_err(|_| {
        let wanted = T::get_dtype(out.py());
        let found =
            out.getattr("dtype").map_or_else(|_| out.get_type().to_string(), |dtype| dtype.to_string());
        PyTypeError::new_err(format!("out: expected a NumPy array of {wanted}, found {found}"))
    })?;
    if array.shape() != shape {
        return Err(PyValueError::new_err(format!(
            "out: expected the shape {}, found {}",
            text(shape),
            text(array.shape())
        )));
    }
    if !array.is_c_contiguous() {
        return Err(PyValueError::new_err(NOT_CONTIGUOUS));
    }
    Ok(array.clone())
}

/// A shape as Python writes it.
fn text(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    match &lengths[..] {
        [one] => format!("({one},)"),
        all => format!("({})", all.join(", ")),
    }
}

/// A vector as an array of this shape, which takes its memory over.
pub fn owned<'py, T: Element>(
    py: Python<'py>,
    numbers: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    Ok(numpy::PyArray1::from_vec(py, numbers).reshape(IxDyn(shape))?.into_any())
}
