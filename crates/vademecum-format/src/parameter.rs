//! Live parameters of a file, each with its range.

use bincode::{BorrowDecode, Encode};

/// Something a scene can be set to, with its range.
#[derive(Clone, Copy, Debug, PartialEq, Encode, BorrowDecode)]
pub struct Parameter<'a> {
    /// Its name; not empty, and no two parameters share one.
    pub name: &'a str,
    /// Its unit; empty for a pure number.
    pub unit: &'a str,
    /// The quantity it changes; no two parameters share one.
    pub role: ParameterRole,
    /// Its range is best walked in the logarithm; `lower` is then positive.
    pub log: bool,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// The value the file was built around.
    pub nominal: f64,
}

impl Parameter<'_> {
    /// The filler of unused places.
    pub const UNUSED: Parameter<'static> = Parameter {
        name: "",
        unit: "",
        role: ParameterRole::Stiffness,
        log: false,
        lower: 0.0,
        upper: 0.0,
        nominal: 0.0,
    };

    pub(crate) fn is_sound(&self, n_regions: u32) -> bool {
        use ParameterRole as R;
        // NaN fails every comparison; infinite ends fail `is_finite`.
        let ordered = self.lower < self.upper && self.lower <= self.nominal && self.nominal <= self.upper;
        let finite = self.lower.is_finite() && self.upper.is_finite();
        let may_vanish =
            !self.log && matches!(self.role, R::Alpha | R::Beta | R::LossFactor { .. } | R::Damping { .. });
        let sign = self.lower > 0.0 || (may_vanish && self.lower == 0.0);
        let region = match self.role {
            R::RegionStiffness { region } | R::RegionDensity { region } | R::LossFactor { region } => {
                region < n_regions
            }
            _ => true,
        };
        ordered && finite && sign && region && !self.name.is_empty()
    }
}

/// Quantity changed by a parameter: a factor on the value of the build, or (`α`, `β`, `Δt`, `η_q`) the value
/// itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, BorrowDecode)]
#[non_exhaustive]
pub enum ParameterRole {
    /// Factor on the stiffness of the whole body.
    Stiffness,
    /// `κ_q`: factor on a region's stiffness.
    RegionStiffness {
        /// The region.
        region: u32,
    },
    /// Factor on the density of the whole body.
    Density,
    /// `ρ_q`: factor on a region's density.
    RegionDensity {
        /// The region.
        region: u32,
    },
    /// Rayleigh `α` \[1/s\].
    Alpha,
    /// Rayleigh `β` \[s\].
    Beta,
    /// `Δt` \[s\].
    TimeStep,
    /// `η_q`: loss factor of a region, of a parametric reduced-order model.
    LossFactor {
        /// The region.
        region: u32,
    },
    /// Factor on the damping of a group of dashpots, of a parametric reduced-order model.
    Damping {
        /// The group.
        group: u32,
    },
}
