//! What a file names, and its live parameters.

use core::ffi::c_char;

use vademecum_eval::format::{ParameterRole, SectionKind};
use vademecum_eval::{BindError, Scalar, SceneOptions};

use crate::body::{Body, Moved, moved};
use crate::message::copy;
use crate::types::{VdmNamed, VdmParameter, VdmStatus};

impl Body {
    pub fn set_parameter(&mut self, parameter: u32, value: f64, work: &mut [f64]) -> VdmStatus {
        let index = parameter as usize;
        let done = moved!(self.march, m => m.scene.set_parameters(&[(index, value)], &mut m.state, work));
        self.follow();
        self.answer(done, VdmStatus::VDM_BIND)
    }

    /// Sets all live parameters at once.
    pub fn set_parameters(&mut self, values: &[f64], work: &mut [f64]) -> VdmStatus {
        let done = moved!(self.march, m => m.set_parameters(values, work));
        self.follow();
        match done {
            Ok(Some(())) => VdmStatus::VDM_OK,
            Ok(None) => self.message.note(VdmStatus::VDM_ARGUMENT, &"not as many values as live parameters"),
            Err(error) => self.message.note(VdmStatus::VDM_BIND, &error),
        }
    }

    pub fn parameter(&mut self, index: u32, out: &mut VdmParameter) -> VdmStatus {
        let options = moved!(self.march, m => *m.scene.options());
        let metadata = self.file.metadata();
        let known = metadata.active_parameters().get(index as usize);
        let valued = known.and_then(|known| {
            let region = |scales: &[f64], region: u32| scales.get(region as usize).copied();
            let value = match known.role {
                ParameterRole::Stiffness => Some(options.stiffness),
                ParameterRole::RegionStiffness { region: q } => region(options.regions.stiffness(), q),
                ParameterRole::Density => Some(options.density),
                ParameterRole::RegionDensity { region: q } => region(options.regions.density(), q),
                ParameterRole::Alpha => Some(options.alpha.unwrap_or(metadata.alpha)),
                ParameterRole::Beta => Some(options.beta.unwrap_or(metadata.beta)),
                ParameterRole::TimeStep => Some(options.time_step.unwrap_or(metadata.time_step)),
                _ => None,
            };
            value.map(|value| (known, value))
        });
        let Some((known, value)) = valued else {
            return self.message.note(VdmStatus::VDM_ARGUMENT, &"the file has no such live parameter");
        };
        let logarithmic = u32::from(known.log);
        let (lower, upper, nominal) = (known.lower, known.upper, known.nominal);
        *out = VdmParameter { lower, upper, nominal, value, logarithmic };
        VdmStatus::VDM_OK
    }

    /// Names of a kind, in order.
    fn names(&self, kind: i32) -> Option<Names<'_>> {
        let section = |kind| {
            let text = self.file.section(kind).and_then(|section| section.text().ok()).unwrap_or("");
            Names::Lines(text.lines())
        };
        match kind {
            k if k == VdmNamed::VDM_PROBES as i32 => Some(section(SectionKind::ProbeNames)),
            k if k == VdmNamed::VDM_PATTERNS as i32 => Some(section(SectionKind::PatternNames)),
            k if k == VdmNamed::VDM_SUPPORTS as i32 => Some(section(SectionKind::SupportNames)),
            k if k == VdmNamed::VDM_PARAMETERS as i32 => {
                Some(Names::Parameters(self.file.metadata().active_parameters().iter()))
            }
            _ => None,
        }
    }

    pub fn name(&mut self, kind: i32, index: u32, out: &mut [c_char]) -> VdmStatus {
        let found = self.names(kind).and_then(|mut names| names.nth(index as usize));
        match found {
            Some(name) => {
                copy(name.as_bytes(), out);
                VdmStatus::VDM_OK
            }
            None => self.message.note(VdmStatus::VDM_ARGUMENT, &"the file has no such name"),
        }
    }

    pub fn find(&mut self, kind: i32, name: &str) -> i32 {
        let place = self.names(kind).and_then(|mut names| names.position(|found| found == name));
        place.and_then(|place| i32::try_from(place).ok()).unwrap_or(-1)
    }
}

/// Names as the file has them.
enum Names<'a> {
    Lines(core::str::Lines<'a>),
    Parameters(core::slice::Iter<'a, vademecum_eval::format::Parameter<'a>>),
}

impl<'a> Iterator for Names<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        match self {
            Self::Lines(lines) => lines.next(),
            Self::Parameters(parameters) => parameters.next().map(|parameter| parameter.name),
        }
    }
}

impl<T: Scalar> Moved<T> {
    /// `None` for another number of values.
    fn set_parameters(&mut self, values: &[f64], work: &mut [f64]) -> Result<Option<()>, BindError> {
        if values.len() != self.scene.metadata().active_parameters().len() {
            return Ok(None);
        }
        let mut options: SceneOptions = *self.scene.options();
        let before = options;
        for (index, &value) in values.iter().enumerate() {
            options.set(self.scene.metadata(), &[(index, value)])?;
        }
        self.scene.rebind(&options, work)?;
        if self.state.carry(&self.scene).is_err() {
            // A state that leaves the precision: everything is put back.
            self.scene.rebind(&before, work)?;
            return Err(BindError::NotFinite);
        }
        Ok(Some(()))
    }
}
