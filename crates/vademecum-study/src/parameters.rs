//! The live parameters of a file by name: what they are set to, and what that means at full order.

use serde::Serialize;
use vademecum_build::prepared::{ParameterSpace, Setting};
use vademecum_build::suggest::did_you_mean;
use vademecum_eval::{BindError, SceneOptions};
use vademecum_format::{Metadata, Parameter, ParameterRole};

use crate::error::StudyError;

/// A live parameter and its value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterValue {
    /// Its name in the file.
    pub name: String,
    /// Its value: a factor, or a number in the unit that `info` shows.
    pub value: f64,
}

/// Sets live parameters of a file by name.
///
/// # Errors
/// [`StudyError::NoParameter`], [`StudyError::OutsideRange`]; [`StudyError::TimeStepTwice`] if the options
/// have a time step already.
pub fn set(
    options: &mut SceneOptions,
    metadata: &Metadata<'_>,
    settings: &[ParameterValue],
) -> Result<(), StudyError> {
    let (given, known) = (options.time_step.is_some(), metadata.active_parameters());
    for (index, value) in resolve(known, settings)? {
        let parameter = &known[index];
        if given && parameter.role == ParameterRole::TimeStep {
            return Err(StudyError::TimeStepTwice { name: parameter.name.to_string() });
        }
        options.set(metadata, &[(index, value)]).map_err(BindError::from)?;
    }
    Ok(())
}

/// Numbers and values of parameters that are set by name, in their ranges.
///
/// # Errors
/// [`StudyError::NoParameter`], [`StudyError::OutsideRange`].
pub fn resolve(
    known: &[Parameter<'_>],
    settings: &[ParameterValue],
) -> Result<Vec<(usize, f64)>, StudyError> {
    let resolved = |ParameterValue { name, value }: &ParameterValue| {
        let index = known.iter().position(|p| p.name == name).ok_or_else(|| {
            let nearest = did_you_mean(name, known.iter().map(|p| p.name));
            StudyError::NoParameter { name: name.clone(), known: ranges(known) + &nearest }
        })?;
        let Parameter { lower, upper, .. } = known[index];
        if (lower..=upper).contains(value) {
            return Ok((index, *value));
        }
        Err(StudyError::OutsideRange { name: name.clone(), value: *value, lower, upper })
    };
    settings.iter().map(resolved).collect()
}

/// Names and ranges of live parameters.
fn ranges(known: &[Parameter<'_>]) -> String {
    let parameter = |p: &Parameter<'_>| {
        let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
        format!("`{}` from {} to {}{unit}", p.name, p.lower, p.upper)
    };
    let known: Vec<String> = known.iter().map(parameter).collect();
    if known.is_empty() { "none".into() } else { known.join(", ") }
}

/// Values of all live parameters of a file at these options.
pub fn values(options: &SceneOptions, metadata: &Metadata<'_>) -> Vec<ParameterValue> {
    use ParameterRole as R;
    let value = |p: &vademecum_format::Parameter<'_>| match p.role {
        R::Stiffness => options.stiffness,
        R::Density => options.density,
        R::RegionStiffness { region } => options.regions.stiffness()[region as usize],
        R::RegionDensity { region } => options.regions.density()[region as usize],
        R::Alpha => options.alpha.unwrap_or(metadata.alpha),
        R::Beta => options.beta.unwrap_or(metadata.beta),
        R::TimeStep => options.time_step.unwrap_or(metadata.time_step),
        _ => p.nominal,
    };
    let parameters = metadata.active_parameters().iter();
    parameters.map(|p| ParameterValue { name: p.name.to_string(), value: value(p) }).collect()
}

/// Setting of the model of a problem for these options of its file.
pub(crate) fn setting(options: &SceneOptions, metadata: &Metadata<'_>, space: &ParameterSpace) -> Setting {
    let mut setting = space.setting(&space.nominal());
    setting.step.time_step = options.time_step.unwrap_or(metadata.time_step);
    setting.step.alpha = options.alpha.unwrap_or(setting.step.alpha);
    setting.step.beta = options.beta.unwrap_or(setting.step.beta);
    if metadata.active_parameters().is_empty() {
        // Fixed: at the values of the problem, or at those that a parametric model was set to.
        setting.step.stiffness *= options.stiffness;
        setting.step.density *= options.density;
        return setting;
    }
    (setting.step.stiffness, setting.step.density) = (options.stiffness, options.density);
    setting.stiffness.iter_mut().zip(options.regions.stiffness()).for_each(|(scale, &asked)| *scale = asked);
    setting.density.iter_mut().zip(options.regions.density()).for_each(|(scale, &asked)| *scale = asked);
    setting
}
