//! The parametric model in coordinates of the box, and its files.

use vademecum_format::{File, ParameterRole};

use super::error::CalibrateError;
use crate::error::StudyError;
use crate::live::at_values;
use crate::live_errors::LiveErrors;
use crate::parameters::ParameterValue;

/// A parameter that is fitted.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub name: String,
    pub unit: &'static str,
    pub log: bool,
    pub lower: f64,
    pub upper: f64,
    /// Value at the start.
    pub start: f64,
}

impl Axis {
    /// Value at a coordinate from 0 to 1.
    pub fn value(&self, u: f64) -> f64 {
        let Self { lower, upper, .. } = *self;
        let value = if self.log { lower * (upper / lower).powf(u) } else { lower + u * (upper - lower) };
        value.clamp(lower, upper)
    }

    /// Coordinate of a value.
    pub fn coordinate(&self, value: f64) -> f64 {
        let Self { lower, upper, .. } = *self;
        if self.log { (value / lower).ln() / (upper / lower).ln() } else { (value - lower) / (upper - lower) }
    }
}

/// The model, what is fitted, and what is fixed.
pub(super) struct Model<'a> {
    file: &'a File<'a>,
    pub axes: Vec<Axis>,
    fixed: Vec<ParameterValue>,
}

impl<'a> Model<'a> {
    /// The model of a file: `fit` names the parameters that are fitted, or all but the time step if it is
    /// empty; `settings` fix the others, and are where those that are fitted start.
    pub fn new(
        file: &'a File<'a>,
        fit: &[String],
        settings: &[ParameterValue],
    ) -> Result<Self, CalibrateError> {
        let study = |error: vademecum_eval::ParametricError| CalibrateError::Study(StudyError::from(error));
        let live = file.live_parameters().map_err(|error| study(error.into()))?;
        let live = live.ok_or(CalibrateError::NotParametric)?;
        // Names and ranges of settings are checked as `run` checks them.
        at_values(file, settings, Some(1))?;
        let known: Vec<_> = live.iter().collect();
        let steps = |name: &str| known.iter().any(|p| p.name == name && p.role == ParameterRole::TimeStep);
        for (place, name) in fit.iter().enumerate() {
            let list =
                known.iter().filter(|p| p.role != ParameterRole::TimeStep).map(|p| format!("`{}`", p.name));
            let list = list.collect::<Vec<_>>().join(", ");
            let reason = if fit[..place].contains(name) {
                format!("`--fit \"{name}\"` is given twice")
            } else if steps(name) {
                format!("`{name}` is the time step, which is no property of the body; can be fitted: {list}")
            } else if !known.iter().any(|p| p.name == name) {
                format!("the file has no live parameter `{name}`; can be fitted: {list}")
            } else {
                continue;
            };
            return Err(CalibrateError::Parameters { reason });
        }
        let given = |name: &str| settings.iter().rev().find(|s| s.name == name).map(|s| s.value);
        let (mut axes, mut fixed) = (vec![], vec![]);
        for p in &known {
            let start = given(p.name).unwrap_or(p.nominal);
            let asked = fit.is_empty() || fit.iter().any(|name| name == p.name);
            let moves = p.role != ParameterRole::TimeStep && p.upper > p.lower;
            if asked && moves {
                let log = p.lower > 0.0 && (p.log || p.upper > 4.0 * p.lower);
                let unit = match p.role {
                    ParameterRole::Alpha => "1/s",
                    ParameterRole::Beta => "s",
                    _ => "",
                };
                axes.push(Axis { name: p.name.into(), unit, log, lower: p.lower, upper: p.upper, start });
            } else {
                fixed.push(ParameterValue { name: p.name.into(), value: start });
            }
        }
        if axes.is_empty() {
            let reason =
                "the file has no live parameter but the time step, and nothing can be fitted".to_string();
            return Err(CalibrateError::Parameters { reason });
        }
        Ok(Self { file, axes, fixed })
    }

    /// Values of all parameters at coordinates.
    pub fn values(&self, u: &[f64]) -> Vec<ParameterValue> {
        let fitted = self
            .axes
            .iter()
            .zip(u)
            .map(|(axis, &u)| ParameterValue { name: axis.name.clone(), value: axis.value(u) });
        self.fixed.iter().cloned().chain(fitted).collect()
    }

    /// Bytes of the ordinary file at coordinates.
    pub fn bytes(&self, u: &[f64]) -> Result<Vec<u8>, StudyError> {
        let body = at_values(self.file, &self.values(u), None)?;
        Ok(body.map(|body| body.bytes).unwrap_or_default())
    }

    /// Relative error of trajectories of the model: the median over the points of the certificate that
    /// trained nothing, 0 of a file without.
    pub fn error(&self) -> Result<f64, StudyError> {
        Ok(LiveErrors::of(self.file)?.quantiles().map_or(0.0, |[median, ..]| median))
    }
}
