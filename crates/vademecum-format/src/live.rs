//! Live parameters of a parametric reduced-order model, in sections of any length.

use crate::error::FormatError;
use crate::kind::SectionKind;
use crate::parameter::{Parameter, ParameterRole};
use crate::read::File;

/// Numbers of a row of [`SectionKind::LiveParameters`].
pub const LIVE_COLUMNS: usize = 6;
/// Most live parameters of a file.
pub const MAX_LIVE: usize = 1024;
/// Most live regions of a file.
pub const MAX_LIVE_REGIONS: usize = 256;

/// Numbers of the lower triangle of a symmetric matrix of `r` rows.
const fn packed(r: usize) -> usize {
    r * (r + 1) / 2
}

/// A parameter of the table that cannot be one, or a table that does not fit its matrices.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// A row of the table.
    #[error("live parameter {index}: its role, region, range or value as built is none")]
    Parameter {
        /// The row.
        index: usize,
    },
    /// Sections that do not belong together.
    #[error("section {kind} has not the shape that the live parameters ask for")]
    Shape {
        /// Number of the kind.
        kind: u32,
    },
    /// A section that is missing, or cannot be read as it stands.
    #[error(transparent)]
    Format(#[from] FormatError),
}

/// Live parameters of a file, with the matrices that they scale.
#[derive(Clone, Copy, Debug)]
pub struct LiveParameters<'a> {
    rows: &'a [[[u8; 8]; LIVE_COLUMNS]],
    names: &'a str,
    /// Modes of the file.
    pub n_modes: usize,
    /// Live regions, without what is not live.
    pub n_regions: usize,
    /// Lower triangles of the stiffness: first of what is not live, then of each live region.
    pub stiffness: &'a [[u8; 8]],
    /// The same of the mass, if a density is live.
    pub mass: Option<&'a [[u8; 8]]>,
    /// Live region of each region of the mesh, counted from 1; 0 of those that are not live.
    pub regions: &'a [[u8; 4]],
    /// Terms of the scale of the residual flexibility, five numbers each; none of a file without it.
    pub residual: &'a [[[u8; 8]; 5]],
    /// Damping ratio that no loss factor makes, and loss factors of the live regions; none of a file without
    /// loss factors.
    pub loss: &'a [[u8; 8]],
    /// Group of dashpots of each row of section 79, counted from 1; 0 of those that are not live.
    pub dampers: &'a [[u8; 4]],
}

/// Lines of a text. (`str::lines` has a panic that no linker can rule out.)
struct Lines<'a>(&'a str);

impl<'a> Iterator for Lines<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        if self.0.is_empty() {
            return None;
        }
        let end = self.0.bytes().position(|byte| byte == b'\n').unwrap_or(self.0.len());
        let (line, rest) = self.0.split_at_checked(end)?;
        self.0 = rest.get(1..).unwrap_or_default();
        Some(line)
    }
}

/// The parameter of a row of the table; `None` for a role that there is not.
fn of_row<'a>(row: &[[u8; 8]; LIVE_COLUMNS], name: &'a str) -> Option<Parameter<'a>> {
    use ParameterRole as R;
    let [role, region, log, lower, upper, nominal] = row.map(f64::from_le_bytes);
    let region = region as u32;
    let (role, unit) = match role as u32 {
        0 => (R::Stiffness, ""),
        1 => (R::RegionStiffness { region }, ""),
        2 => (R::Density, ""),
        3 => (R::RegionDensity { region }, ""),
        4 => (R::Alpha, "1/s"),
        5 => (R::Beta, "s"),
        6 => (R::TimeStep, "s"),
        7 => (R::LossFactor { region }, ""),
        8 => (R::Damping { group: region }, ""),
        _ => return None,
    };
    Some(Parameter { name, unit, role, log: log != 0.0, lower, upper, nominal })
}

impl<'a> LiveParameters<'a> {
    /// Number of parameters.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.rows.len()
    }

    /// True without parameters, which no file has.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Parameter `index`. Its region is that of the matrices, counted from 0.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<Parameter<'a>> {
        of_row(self.rows.get(index)?, Lines(self.names).nth(index)?)
    }

    /// All parameters, in the order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = Parameter<'a>> + use<'a> {
        self.rows.iter().zip(Lines(self.names)).map_while(|(row, name)| of_row(row, name))
    }

    /// Number of the parameter of this name.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<usize> {
        Lines(self.names).take(self.len()).position(|own| own == name)
    }

    fn check(&self) -> Result<(), LiveError> {
        if self.rows.is_empty() || self.rows.len() > MAX_LIVE {
            return Err(LiveError::Shape { kind: SectionKind::LiveParameters.number() });
        }
        if self.iter().count() != self.len() {
            return Err(LiveError::Parameter { index: self.iter().count() });
        }
        for (index, parameter) in self.iter().enumerate() {
            let needed = match parameter.role {
                ParameterRole::RegionDensity { .. } => self.mass.is_some(),
                ParameterRole::LossFactor { .. } => !self.loss.is_empty(),
                ParameterRole::Damping { group } => {
                    self.dampers.iter().any(|own| u32::from_le_bytes(*own).checked_sub(1) == Some(group))
                }
                _ => true,
            };
            let sound = parameter.is_sound(self.n_regions as u32) && needed;
            let same = |other: &Parameter<'_>| other.role == parameter.role || other.name == parameter.name;
            if !sound || self.iter().take(index).any(|other| same(&other)) {
                return Err(LiveError::Parameter { index });
            }
        }
        Ok(())
    }
}

impl<'a> File<'a> {
    /// Live parameters in the order of their numbers, those of a parametric reduced-order model too; none of
    /// a table that cannot be read.
    pub fn parameters(&self) -> impl Iterator<Item = Parameter<'a>> + use<'a> {
        let metadata = *self.metadata();
        let own = (0..).map_while(move |index: usize| metadata.active_parameters().get(index).copied());
        own.chain(self.live_parameters().ok().flatten().into_iter().flat_map(|live| live.iter()))
    }

    /// Live parameters of a parametric reduced-order model; `None` of a file without them.
    ///
    /// # Errors
    /// [`LiveError`]: sections that are missing, compressed or do not fit each other.
    pub fn live_parameters(&self) -> Result<Option<LiveParameters<'a>>, LiveError> {
        use SectionKind as S;
        let Some(table) = self.section(S::LiveParameters) else { return Ok(None) };
        let needed = |kind: S| self.section(kind).ok_or(FormatError::Missing { kind: kind.number() });
        let r = self.metadata().n_modes as usize;
        let stiffness = needed(S::LiveStiffness)?;
        let mass = self.section(S::LiveMass);
        let regions = needed(S::LiveRegions)?.u32s()?;
        let rows = stiffness.shape()[0] as usize;
        let live = LiveParameters {
            rows: table.f64s()?.as_chunks().0,
            names: needed(S::LiveNames)?.text()?,
            n_modes: r,
            n_regions: rows.saturating_sub(1),
            stiffness: stiffness.f64s()?,
            mass: mass.map(|section| section.f64s()).transpose()?,
            regions,
            residual: match self.section(S::LiveResidual) {
                Some(section) => section.f64s()?.as_chunks().0,
                None => &[],
            },
            loss: match self.section(S::LiveLoss) {
                Some(section) => section.f64s()?,
                None => &[],
            },
            dampers: match self.section(S::LiveDampers) {
                Some(section) => section.u32s()?,
                None => &[],
            },
        };
        let fits = |shape: [u64; 3]| shape == [rows as u64, packed(r) as u64, 1];
        if !fits(stiffness.shape()) || rows == 0 || rows > MAX_LIVE_REGIONS + 1 {
            return Err(LiveError::Shape { kind: S::LiveStiffness.number() });
        }
        if mass.is_some_and(|section| !fits(section.shape())) {
            return Err(LiveError::Shape { kind: S::LiveMass.number() });
        }
        let lost = live.loss.iter().map(|number| f64::from_le_bytes(*number));
        if !live.loss.is_empty()
            && (live.loss.len() != rows || !lost.clone().all(|x| x >= 0.0 && x.is_finite()))
        {
            return Err(LiveError::Shape { kind: S::LiveLoss.number() });
        }
        if regions.iter().any(|&region| u32::from_le_bytes(region) as usize >= rows) {
            return Err(LiveError::Shape { kind: S::LiveRegions.number() });
        }
        live.check()?;
        Ok(Some(live))
    }
}
