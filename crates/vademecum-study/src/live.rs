//! Files of a parametric reduced-order model at values of their live parameters.

use vademecum_build::prepared::Prepared;
use vademecum_eval::{Parametric, ParametricError};
use vademecum_format::File;

use crate::error::StudyError;
use crate::parameters::{ParameterValue, resolve};

/// The body of a parametric model at values of its parameters.
#[derive(Clone, Debug)]
pub struct BodyAtValues {
    /// Bytes of an ordinary file.
    pub bytes: Vec<u8>,
    /// Every parameter with its value.
    pub values: Vec<ParameterValue>,
}

/// The body of a parametric model at these values, those as built where there is none; `None` of a file
/// without such a model. `modes` are stepped, 32 unless asked otherwise.
///
/// # Errors
/// [`StudyError::NoParameter`], [`StudyError::OutsideRange`], [`StudyError::Model`].
pub fn at_values(
    file: &File<'_>,
    settings: &[ParameterValue],
    modes: Option<usize>,
) -> Result<Option<BodyAtValues>, StudyError> {
    if file.live_parameters().map_err(ParametricError::from)?.is_none() {
        return Ok(None);
    }
    let model = Parametric::new(file)?;
    let mut values = vec![0.0; model.n_parameters()];
    model.nominal_into(&mut values);
    let known: Vec<_> = model.parameters().collect();
    for setting in resolve(&known, settings)? {
        model.set(&mut values, &[setting]).map_err(ParametricError::from)?;
    }
    let modes = modes.unwrap_or(model.usual_modes());
    let bytes = model.body_at(&values, modes)?;
    let named = known.iter().zip(&values);
    let values = named.map(|(p, &value)| ParameterValue { name: p.name.to_string(), value }).collect();
    Ok(Some(BodyAtValues { bytes, values }))
}

/// The model of a problem at these values of its live parameters, as if they were those of the problem.
///
/// # Errors
/// [`StudyError::NoParameter`]: a parameter that the problem does not have.
pub fn prepared_at(prepared: &mut Prepared, values: &[ParameterValue]) -> Result<(), StudyError> {
    let known = || {
        let names = prepared.space.parameters.iter().map(|p| format!("`{}`", p.name));
        names.collect::<Vec<_>>().join(", ")
    };
    let mut own = prepared.space.nominal();
    for ParameterValue { name, value } in values {
        let place = prepared.space.parameters.iter().position(|p| p.name == *name);
        let missing = || StudyError::NoParameter { name: name.clone(), known: known() };
        own[place.ok_or_else(missing)?] = *value;
    }
    prepared.set_nominal(&own);
    Ok(())
}
