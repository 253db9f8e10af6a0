//! Options of a scene, from arguments of Python.

use numpy::{PyArrayDescr, PyArrayDescrMethods, dtype};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use vademecum_build::suggest::did_you_mean;
use vademecum_eval::{BodyOptions, Precision, SceneOptions, StructureChoice};
use vademecum_format::{File, Parameter, SectionKind};
use vademecum_study::parameters::{self, ParameterValue};

use crate::point::wrong;
use crate::refusal::{Refusal, of_study};

/// The precision of a NumPy type, or of anything that NumPy makes one of.
pub fn precision(given: &Bound<'_, PyAny>) -> PyResult<Precision> {
    let py = given.py();
    let descr = PyArrayDescr::new(py, given)?;
    if descr.is_equiv_to(&dtype::<f32>(py)) {
        Ok(Precision::Single)
    } else if descr.is_equiv_to(&dtype::<f64>(py)) {
        Ok(Precision::Double)
    } else {
        Err(PyTypeError::new_err(format!("dtype is {descr}; expected float32 or float64")))
    }
}

/// The structure of this name.
pub fn structure(name: &str) -> PyResult<StructureChoice> {
    Ok(match name {
        "auto" => StructureChoice::Auto,
        "diagonal" => StructureChoice::Diagonal,
        "block" => StructureChoice::Block,
        "exact" => StructureChoice::Exact,
        "strain" => StructureChoice::Strain,
        _ => {
            return Err(Refusal::usage(format!(
                "structure is `{name}`; expected `auto`, `diagonal`, `block`, `exact` or `strain`"
            ))
            .into());
        }
    })
}

/// Names of the options of a body, in the order of the documentation.
const OPTIONS: [&str; 16] = [
    "structure",
    "time_step",
    "tolerance",
    "terms",
    "rest_below",
    "residual",
    "contacts",
    "filtered_nodes",
    "substeps",
    "viscosity",
    "stiffness",
    "density",
    "alpha",
    "beta",
    "flight",
    "modes",
];

/// Options of a body, and the live parameters that they do not set.
pub struct Asked {
    pub scene: SceneOptions,
    /// Stepped modes of a parametric file.
    pub modes: Option<usize>,
    /// Parameters of a parametric file; those of others are in the options.
    pub live: Vec<ParameterValue>,
}

impl Asked {
    /// Options of the evaluator's body.
    pub fn body(&self, flight: bool) -> BodyOptions {
        BodyOptions { scene: self.scene, modes: self.modes, flight, ..BodyOptions::default() }
    }
}

/// Options by their names; all others are live parameters of the file.
pub fn asked(file: &File<'_>, given: Option<&Bound<'_, PyDict>>) -> PyResult<Asked> {
    let (mut options, mut modes) = (SceneOptions::default(), None);
    let mut live = vec![];
    let parameters: Vec<Parameter<'_>> = file.parameters().collect();
    let is_parametric = file.section(SectionKind::LiveParameters).is_some();
    for (name, value) in given.into_iter().flatten() {
        let name: String = name.extract()?;
        let parameter = parameters.iter().find(|parameter| keyword(parameter.name) == name);
        // The value of the option, of the type that it has.
        macro_rules! value {
            ($expected:literal) => {
                value.extract().map_err(|error| {
                    wrong(&value.as_borrowed(), &format!("{} for `{name}`", $expected), &PyErr::from(error))
                })?
            };
        }
        match name.as_str() {
            "structure" => {
                let text: String = value!("the name of a structure");
                options.structure = structure(&text)?;
            }
            "tolerance" => options.tolerance = value!("a number"),
            "time_step" => options.time_step = value!("a number"),
            "rest_below" => options.rest_below = value!("a number"),
            "terms" => options.terms = value!("a whole number from 1"),
            "residual" => options.residual = value!("True or False"),
            "contacts" => options.contacts = value!("a whole number from 0"),
            "filtered_nodes" => options.filtered_nodes = value!("a whole number from 0"),
            "substeps" => options.substeps = value!("a whole number from 1"),
            "modes" if is_parametric => modes = Some(value!("a whole number from 1")),
            "viscosity" => options.viscosity = value!("a number"),
            // Of the whole body, unless the file has a live parameter of that name.
            "stiffness" if parameter.is_none() => options.stiffness = value!("a number"),
            "density" if parameter.is_none() => options.density = value!("a number"),
            "alpha" if parameter.is_none() => options.alpha = value!("a number"),
            "beta" if parameter.is_none() => options.beta = value!("a number"),
            _ => {
                let meant = resolve(&parameters, name.clone());
                if !parameters.iter().any(|parameter| parameter.name == meant) {
                    refuse_slip(&name, value.extract::<f64>().is_ok())?;
                }
                live.push(ParameterValue { name: meant, value: value!("a number") });
                continue;
            }
        }
        // The time step is the same as a parameter and as an option.
        if let Some(both) = parameter.filter(|_| name != "time_step") {
            return Err(Refusal::usage(format!(
                "`{name}` is an option of bodies, and the live parameter `{both}` of this file too; set the \
                 parameter by `body.set_parameters({{\"{both}\": value}})` once the body is there",
                both = both.name
            ))
            .into());
        }
    }
    if !is_parametric {
        parameters::set(&mut options, file.metadata(), &std::mem::take(&mut live)).map_err(of_study)?;
    }
    Ok(Asked { scene: options, modes, live })
}

/// Refuses a keyword that is no live parameter if it is nearly an option, or has no number; any other is left
/// to the parameters, whose names its refusal lists.
fn refuse_slip(name: &str, is_number: bool) -> PyResult<()> {
    let nearest = did_you_mean(name, OPTIONS.iter().copied());
    if is_number && nearest.is_empty() {
        return Ok(());
    }
    Err(PyTypeError::new_err(format!("there is neither an option nor a live parameter `{name}`{nearest}")))
}

/// The parameter that a keyword means: the one of that name, or else the only one whose name becomes the
/// keyword if every sign that a keyword cannot have is written as `_`.
pub fn resolve(known: &[Parameter<'_>], name: String) -> String {
    if known.iter().any(|other| other.name == name) {
        return name;
    }
    let mut alike = known.iter().filter(|other| keyword(other.name) == name);
    match (alike.next(), alike.next()) {
        (Some(only), None) => only.name.to_string(),
        _ => name,
    }
}

/// A name with `_` for every sign that a keyword cannot have.
pub fn keyword(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}

/// Pairs of names and values of a mapping and of keywords.
pub fn pairs<V: for<'a> FromPyObject<'a, 'a, Error = PyErr>>(
    values: Option<&Bound<'_, PyDict>>,
    keywords: Option<&Bound<'_, PyDict>>,
) -> PyResult<Vec<(String, V)>> {
    let all = values.into_iter().flatten().chain(keywords.into_iter().flatten());
    all.map(|(name, value)| Ok((name.extract()?, value.extract()?))).collect()
}
