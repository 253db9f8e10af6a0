//! Live parameters of a file, and the scales and damping of the whole body: which of them an FMU offers, and
//! their values.

use vademecum_eval::format::{File, Parameter, ParameterRole, SectionKind};
use vademecum_eval::{ParameterError, SceneOptions};

use crate::refusal::Refusal;

/// True of a file with live regions that are set.
pub fn has_live(file: &File<'_>) -> bool {
    file.section(SectionKind::LiveParameters).is_some()
}

/// Number of live parameters.
pub fn parameters(file: &File<'_>) -> usize {
    file.parameters().fold(0, |count, _| count + 1)
}

/// Asks for a value of a parameter of a file with live regions, in its range.
pub fn ask(asked: &mut f64, file: &File<'_>, index: u32, value: f64) -> Result<(), ParameterError> {
    let parameter = index as usize;
    let unknown = ParameterError::Unknown { index: parameter };
    let Parameter { lower, upper, .. } = file.parameters().nth(parameter).ok_or(unknown)?;
    if !(lower..=upper).contains(&value) {
        return Err(ParameterError::OutsideRange { parameter, value, lower, upper });
    }
    *asked = value;
    Ok(())
}

/// Value of a parameter at these options, as built of a file with live regions; `None` for one that an FMU
/// does not offer. The time step is one: the internal step of an FMU is fixed.
#[must_use]
pub fn parameter(options: &SceneOptions, file: &File<'_>, index: u32) -> Option<f64> {
    let found = file.parameters().nth(index as usize)?;
    if found.role == ParameterRole::TimeStep {
        return None;
    }
    if has_live(file) { Some(found.nominal) } else { options.value(file.metadata(), index as usize) }
}

/// Numbers of [`Variable::Whole`].
pub const WHOLE: usize = 4;

/// Value of a scale or a damping of the whole body; `None` where a live parameter of the file has it, and of
/// `β` in a file that was built without.
#[must_use]
pub fn whole(options: &SceneOptions, file: &File<'_>, index: u32) -> Option<f64> {
    let metadata = file.metadata();
    let (role, value) = match index {
        0 => (ParameterRole::Stiffness, options.stiffness),
        1 => (ParameterRole::Density, options.density),
        2 => (ParameterRole::Alpha, options.alpha.unwrap_or(metadata.alpha)),
        // A scene that was bound without β has no room for what the residual flexibility needs of it.
        3 if metadata.beta != 0.0 => (ParameterRole::Beta, options.beta.unwrap_or(metadata.beta)),
        _ => return None,
    };
    let is_live = file.parameters().any(|parameter| parameter.role == role);
    (!is_live).then_some(value)
}

/// Sets what [`whole`] gives.
pub fn set_whole(options: &mut SceneOptions, file: &File<'_>, index: u32, value: f64) -> Result<(), Refusal> {
    whole(options, file, index).ok_or(Refusal::NoVariable)?;
    if !(value > 0.0 || index > 1 && value == 0.0) {
        return Err(Refusal::TooSmall { value });
    }
    match index {
        0 => options.stiffness = value,
        1 => options.density = value,
        2 => options.alpha = Some(value),
        _ => options.beta = Some(value),
    }
    Ok(())
}
