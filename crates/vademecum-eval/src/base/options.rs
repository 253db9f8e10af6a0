//! Options of a scene, and the memory it wants.

use crate::base::error::ParameterError;
use crate::base::scalar::Scalar;
use vademecum_format::{MAX_REGIONS, Metadata, ParameterRole};

/// Most contacts and places that a scene or a body makes room for.
pub const MAX_CONTACTS: usize = 1 << 20;

/// The ways a step can be held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// One 3×3 block per mode: `9r` multiply-adds.
    Diagonal,
    /// One dense map: `9r²` multiply-adds.
    Block,
    /// One 2×2 block per mode, which moves it exactly under loads that are linear over the step: `4r`
    /// multiply-adds ([`vademecum_format::exact`]).
    Exact,
    /// Large displacements: a strain that is quadratic in the coordinates, and one small solve a sub-step.
    Strain,
}

/// Which structure a scene shall take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StructureChoice {
    /// The strain one if the file has it, else the exact one if the file was built for it. Otherwise the
    /// cheapest whose certificate keeps the tolerance, or else the one with the smaller certified error. The
    /// block one if a region's scale is not 1; a scene that will be set to such scales later asks for the
    /// block one from the start.
    #[default]
    Auto,
    /// The diagonal one.
    Diagonal,
    /// The block one.
    Block,
    /// The exact one, which every file with the diagonal structure can take.
    Exact,
    /// The strain one.
    Strain,
}

/// Options of a scene; [`SceneOptions::default`] is the file as it was built. Step and scales are from the
/// inverse of [`Scalar::LARGEST`](crate::Scalar::LARGEST) up to it, damping from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneOptions {
    /// Structure of the step.
    pub structure: StructureChoice,
    /// Trajectory error (relative, as in the certificate) that [`StructureChoice::Auto`] accepts. A structure
    /// within [`allowed_error`](vademecum_format::policy::allowed_error) of its projection floor is accepted
    /// in any case: no structure on this basis does better.
    pub tolerance: f64,
    /// `Δt` \[s\]; the file's if `None`.
    pub time_step: Option<f64>,
    /// Scale of the stiffness.
    pub stiffness: f64,
    /// Scale of the density.
    pub density: f64,
    /// Scales of the regions, beside those of the whole body.
    pub regions: RegionScales,
    /// Rayleigh `α` \[1/s\]; the file's if `None`.
    pub alpha: Option<f64>,
    /// Rayleigh `β` \[s\]; the file's if `None`.
    pub beta: Option<f64>,
    /// An unloaded body is put at rest once the sum of its `3r` absolute state numbers \[m kg^½\] is at or
    /// below this, or at or below [`Scalar::REST`](crate::Scalar::REST).
    /// [`Scene::energy_at_rest`](crate::Scene::energy_at_rest) tells the energy that goes with it.
    pub rest_below: f64,
    /// Of the separated solution of the block structure only the first so many terms; all if `None`. The
    /// build puts the strongest first; what leaving terms out costs in accuracy is reported by
    /// `vademecum info --terms-for`, and no certificate of the file speaks of it. Binding, parameters,
    /// contacts and patterns then neither read nor add up the other terms.
    pub terms: Option<usize>,
    /// Residual flexibility in outputs, where the file has it.
    #[doc(alias = "static residual", alias = "residual attachment modes", alias = "mode acceleration")]
    pub residual: bool,
    /// With a residual or with reactions: for so many contacts with nodes of their own there is room, up to
    /// [`MAX_CONTACTS`], each with as many nodes as the largest facet of the file
    /// ([`File::contact_nodes`](vademecum_format::File::contact_nodes)). Contacts on the same nodes share it.
    pub contacts: usize,
    /// With a residual and stiffness-proportional damping: for the filtered forces of so many nodes there is
    /// room; of all loadable nodes if `None`. A node counts until its filtered force is below 1e-12 of the
    /// largest, which is 28 β after its last contact. Four numbers a node.
    pub filtered_nodes: Option<usize>,
    /// Sub-steps of a step of the strain structure, 1 to 1024; those the file was built with if `None`. The
    /// other structures have none.
    pub substeps: Option<usize>,
    /// `c`: numerical viscosity of strain rows, which takes from a small motion of frequency `ω` the energy
    /// that `c (ω k/2)⁴` damping ratios a sub-step of `k` would. 0 keeps the energy exactly. Only of the
    /// strain structure.
    pub viscosity: f64,
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self {
            structure: StructureChoice::Auto,
            tolerance: 0.0,
            time_step: None,
            stiffness: 1.0,
            density: 1.0,
            regions: RegionScales::default(),
            alpha: None,
            beta: None,
            rest_below: 0.0,
            terms: None,
            residual: true,
            contacts: 16,
            filtered_nodes: None,
            substeps: None,
            viscosity: 1.0 / 18.0,
        }
    }
}

impl SceneOptions {
    /// The file's parameter of this name.
    #[must_use]
    pub fn find(metadata: &Metadata<'_>, name: &str) -> Option<usize> {
        metadata.active_parameters().iter().position(|parameter| parameter.name == name)
    }

    /// Sets parameters of the file, each by its number counted from 0, to values in their ranges (ends
    /// included).
    ///
    /// # Errors
    /// [`ParameterError`]; the options are then unchanged.
    pub fn set(&mut self, metadata: &Metadata<'_>, settings: &[(usize, f64)]) -> Result<(), ParameterError> {
        let mut options = *self;
        for (place, &(parameter, value)) in settings.iter().enumerate() {
            if settings.iter().take(place).any(|&(earlier, _)| earlier == parameter) {
                return Err(ParameterError::Twice { parameter });
            }
            options.set_one(metadata, parameter, value)?;
        }
        *self = options;
        Ok(())
    }

    fn set_one(
        &mut self,
        metadata: &Metadata<'_>,
        parameter: usize,
        value: f64,
    ) -> Result<(), ParameterError> {
        use ParameterRole as R;
        let unknown = ParameterError::Unknown { index: parameter };
        let known = metadata.active_parameters().get(parameter).ok_or(unknown)?;
        let (lower, upper) = (known.lower, known.upper);
        if !(lower..=upper).contains(&value) {
            return Err(ParameterError::OutsideRange { parameter, value, lower, upper });
        }
        match known.role {
            R::Stiffness => self.stiffness = value,
            R::RegionStiffness { region: q } => self.regions.set_stiffness(q, value).ok_or(unknown)?,
            R::Density => self.density = value,
            R::RegionDensity { region: q } => self.regions.set_density(q, value).ok_or(unknown)?,
            R::Alpha => self.alpha = Some(value),
            R::Beta => self.beta = Some(value),
            R::TimeStep => self.time_step = Some(value),
            _ => return Err(unknown),
        }
        Ok(())
    }

    /// The value of a parameter of the file under these options; `None` for one that is not there or that
    /// this evaluator does not know.
    #[must_use]
    pub fn value(&self, metadata: &Metadata<'_>, parameter: usize) -> Option<f64> {
        use ParameterRole as R;
        match metadata.active_parameters().get(parameter)?.role {
            R::Stiffness => Some(self.stiffness),
            R::RegionStiffness { region } => self.regions.stiffness().get(region as usize).copied(),
            R::Density => Some(self.density),
            R::RegionDensity { region } => self.regions.density().get(region as usize).copied(),
            R::Alpha => Some(self.alpha.unwrap_or(metadata.alpha)),
            R::Beta => Some(self.beta.unwrap_or(metadata.beta)),
            R::TimeStep => Some(self.time_step.unwrap_or(metadata.time_step)),
            _ => None,
        }
    }

    /// The threshold below which a body rests, rounded.
    pub(crate) fn rest_threshold<T: Scalar>(&self) -> T {
        let asked = T::from_f64(self.rest_below);
        if asked < T::REST { T::REST } else { asked }
    }

    /// `true` if the scale of a region is not 1.
    pub(crate) fn moves_a_region(&self) -> bool {
        self.regions.stiffness.iter().chain(&self.regions.density).any(|&scale| scale != 1.0)
    }
}

/// Scales of the stiffness and the density of each region; all 1 by default, and 1 past the file's regions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionScales {
    stiffness: [f64; MAX_REGIONS],
    density: [f64; MAX_REGIONS],
}

impl Default for RegionScales {
    fn default() -> Self {
        Self::ONE
    }
}

impl RegionScales {
    /// No region differs from the file.
    pub const ONE: Self = Self { stiffness: [1.0; MAX_REGIONS], density: [1.0; MAX_REGIONS] };

    /// `κ_q`: scale of each region's stiffness.
    #[must_use]
    pub const fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// `ρ_q`: scale of each region's density.
    #[must_use]
    pub const fn density(&self) -> &[f64] {
        &self.density
    }

    /// Sets the scale of a region's stiffness; `None` for a region that no file has.
    pub fn set_stiffness(&mut self, region: u32, scale: f64) -> Option<()> {
        *self.stiffness.get_mut(region as usize)? = scale;
        Some(())
    }

    /// Sets the scale of a region's density; `None` for a region that no file has.
    pub fn set_density(&mut self, region: u32, scale: f64) -> Option<()> {
        *self.density.get_mut(region as usize)? = scale;
        Some(())
    }
}

/// Memory to lend, in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Of `T`, to the scene.
    pub scene: usize,
    /// Of `f64`, to [`Scene::bind`](crate::Scene::bind) and
    /// [`Scene::set_parameters`](crate::Scene::set_parameters) while they run.
    pub work: usize,
    /// Of `T`, to each [`State`](crate::State).
    pub state: usize,
    /// Of `T`, to each [`Loads`](crate::Loads).
    pub loads: usize,
}

/// Result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The body moves or is loaded.
    Moving,
    /// The body is unloaded and at rest: its state is zero and further steps cost nothing.
    AtRest,
}
