//! Live parameters: which of them are free, and what they do to the model.
//!
//! A [`ParameterSpace`] is the box of the user's parameters; a [`Setting`] is one point of it, resolved to
//! what the model needs. Which axes a separated solution takes over the box is another question
//! (`parametric`).

use vademecum_format::scheme::{SchemeTable, StepParameters, TableError, theta};
use vademecum_format::{MAX_AXES, MAX_LIVE_REGIONS, MAX_REGIONS, ParameterRole};

use super::body::{material_entry, not_a_region};
use super::body_error::BodyError;
use crate::dynamics::Rayleigh;
use crate::fem::Pencil;
use crate::input::{ParameterEntry, ParameterKind, ParameterScale, Problem};
use crate::linalg::Random;
use crate::mesh::Mesh;
use crate::suggest::did_you_mean;

/// Corners of the box looked at; of more than six parameters, that many are drawn.
const MAX_CORNERS: usize = 64;

/// A parameter with its place in the model.
#[derive(Clone, Debug)]
pub struct LiveParameter {
    /// Its name.
    pub name: String,
    /// Its unit; empty for a factor.
    pub unit: &'static str,
    /// The scaled property.
    pub(crate) role: ParameterRole,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// Values spread evenly in the logarithm.
    pub log: bool,
    /// Value of the problem file.
    pub(crate) nominal: f64,
}

/// The live parameters of a problem.
#[derive(Clone, Debug)]
#[doc(alias("parameter domain", "parametric reduced-order model"))]
pub struct ParameterSpace {
    /// The parameters, in the order of the problem file.
    pub parameters: Vec<LiveParameter>,
    /// Material regions of the mesh, and of a body whose attachments a parameter leaves or scales: what is
    /// fixed of them, then one for each group of them that is live.
    pub(crate) n_regions: usize,
    n_mesh: usize,
    /// Loss factor of each region; none of a body without any.
    loss: Vec<f64>,
    fixed: StepParameters,
}

/// A point of the box, resolved to what the model needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Δt, α, β and the uniform factors.
    pub step: StepParameters,
    /// Stiffness factor of each region.
    pub stiffness: Vec<f64>,
    /// Density factor of each region.
    pub density: Vec<f64>,
    /// Loss factor of each region; none of a body without any.
    pub loss: Vec<f64>,
    /// Factor on the damping of each live group of attachments; none where no dashpots are live.
    pub damping: Vec<f64>,
}

/// Regions whose stiffness or density is live.
#[derive(Clone, Debug)]
pub(crate) struct LiveRegions {
    /// Number of each region among them, counted from 1; 0 of those that are not live. Those of the mesh come
    /// first, then those of attachments ([`ParameterSpace::n_regions`]).
    pub(crate) of_mesh: Vec<u32>,
    /// Regions of the mesh, without attachments.
    pub(crate) n_mesh: usize,
    /// As many as there are.
    pub(crate) count: usize,
    /// True if a density is live.
    pub(crate) density: bool,
    /// Loss factor of each region; none of a body without any.
    pub(crate) loss: Vec<f64>,
    /// Parameters that scale a single region.
    pub(crate) factors: usize,
}

impl LiveRegions {
    /// Factors of what is not live and of each live region, from those of the regions of the mesh.
    pub(crate) fn scales(&self, of_mesh: &[f64]) -> Vec<f64> {
        let mut scales = vec![1.0; 1 + self.count];
        for (&live, &scale) in self.of_mesh.iter().zip(of_mesh).filter(|(live, _)| **live > 0) {
            scales[live as usize] = scale;
        }
        scales
    }
}

impl ParameterSpace {
    /// Resolves the parameters of a problem on its mesh.
    ///
    /// A coefficient of damping or a time step that the problem leaves out takes the middle of its
    /// parameter's range.
    ///
    /// # Errors
    /// [`BodyError::Region`] for a region the mesh does not have, [`BodyError::Nominal`] for a range without
    /// the problem's own value.
    pub fn new(problem: &Problem, mesh: &Mesh, rayleigh: Rayleigh) -> Result<Self, BodyError> {
        let mut fixed = StepParameters {
            time_step: problem.time.step.unwrap_or(f64::NAN),
            alpha: rayleigh.alpha,
            beta: rayleigh.beta,
            density: 1.0,
            stiffness: 1.0,
        };
        let split = problem.splits_regions() && problem.has_attachments();
        let attached = if split { 1 + problem.live_attachments().len() } else { 0 };
        let loss = loss_factors(problem, mesh, attached);
        let mut parameters = vec![];
        for (i, entry) in problem.parameters.iter().enumerate() {
            let role = role(problem, i, entry, mesh)?;
            check_role(problem, i, role, &parameters)?;
            let parameter = live_parameter(problem, entry, role, (&fixed, &loss));
            if !(parameter.lower..=parameter.upper).contains(&parameter.nominal) {
                return Err(BodyError::Nominal {
                    path: problem.place(&format!("parameter[{i}].range")),
                    name: entry.name.clone(),
                    nominal: parameter.nominal,
                    range: entry.range,
                });
            }
            assign(&mut fixed, &parameter, parameter.nominal);
            parameters.push(parameter);
        }
        let n_mesh = mesh.regions.len();
        let space = Self { parameters, n_regions: n_mesh + attached, n_mesh, loss, fixed };
        let live = space.live_regions().count;
        if live > MAX_LIVE_REGIONS && problem.is_parametric() {
            let (path, most) = (problem.place("parameter"), MAX_LIVE_REGIONS);
            return Err(BodyError::TooManyLive { path, live, most });
        }
        // One axis for θ, and at most one for each live region factor.
        let regional = space.parameters.iter().filter(|p| region_of(p.role).is_some()).count();
        let separated = regional > 0 && !problem.is_parametric();
        if separated && (space.n_regions > MAX_REGIONS || regional >= MAX_AXES) {
            let path = problem.place("parameter");
            return Err(BodyError::TooManyRegions { path, regions: space.n_regions, regional });
        }
        Ok(space)
    }

    /// Δt \[s\]; none if neither the problem nor a parameter says it.
    pub(super) fn time_step(&self) -> Option<f64> {
        Some(self.fixed.time_step).filter(|step| !step.is_nan())
    }

    /// The same with another Δt \[s\].
    pub(super) fn at_time_step(mut self, time_step: f64) -> Self {
        self.fixed.time_step = time_step;
        self
    }

    /// Loss factor of each region; none of a body without any.
    pub(super) fn loss(&self) -> &[f64] {
        &self.loss
    }

    /// True if a parameter scales single regions or attachments, so that θ alone does not carry them all.
    pub(crate) fn has_region_parameters(&self) -> bool {
        self.parameters.iter().any(|p| region_of(p.role).is_some()) || self.has_live_dashpots()
    }

    /// True if a parameter scales dashpots.
    fn has_live_dashpots(&self) -> bool {
        self.parameters.iter().any(|p| matches!(p.role, ParameterRole::Damping { .. }))
    }

    /// Groups of attachments that parameters scale.
    fn n_groups(&self) -> usize {
        (self.n_regions - self.n_mesh).saturating_sub(1)
    }

    /// The live regions, in the order of the mesh.
    pub(crate) fn live_regions(&self) -> LiveRegions {
        let of = |p: &LiveParameter| region_of(p.role).map(|region| region as usize);
        // Regions with a loss factor have a matrix of their own, whose energy decides the damping.
        let is_live = |region: usize| {
            self.parameters.iter().any(|p| of(p) == Some(region))
                || self.loss.get(region).is_some_and(|loss| *loss > 0.0)
        };
        let mut count = 0;
        let number = |region: usize| {
            count += u32::from(is_live(region));
            if is_live(region) { count } else { 0 }
        };
        let of_mesh = (0..self.n_regions).map(number).collect();
        let density = |p: &LiveParameter| matches!(p.role, ParameterRole::RegionDensity { .. });
        LiveRegions {
            of_mesh,
            n_mesh: self.n_mesh,
            count: count as usize,
            density: self.parameters.iter().any(density),
            loss: self.loss.clone(),
            factors: self.parameters.iter().filter(|p| of(p).is_some()).count(),
        }
    }

    /// Range of a region's stiffness (or density) factor, if it is live.
    pub(crate) fn region_range(&self, region: usize, density: bool) -> Option<(f64, f64)> {
        let fits = |role: ParameterRole| match role {
            ParameterRole::RegionStiffness { region: q } => !density && q as usize == region,
            ParameterRole::RegionDensity { region: q } => density && q as usize == region,
            _ => false,
        };
        self.parameters.iter().find(|p| fits(p.role)).map(|p| (p.lower, p.upper))
    }

    /// The values of the problem file.
    pub fn nominal(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.nominal).collect()
    }

    /// Takes these values for those of the problem file.
    pub(super) fn set_nominal(&mut self, values: &[f64]) {
        self.parameters.iter_mut().zip(values).for_each(|(own, &value)| own.nominal = value);
    }

    /// Inputs of the responses; names and nominal values are not among them.
    pub(crate) fn effect(&self) -> impl std::fmt::Debug {
        let lowest: Vec<f64> = self.parameters.iter().map(|p| p.lower).collect();
        let moves: Vec<_> = self.parameters.iter().map(|p| (p.role, p.lower, p.upper, p.log)).collect();
        (self.setting(&lowest), moves)
    }

    /// Model coefficients at these values, one per parameter.
    pub fn setting(&self, values: &[f64]) -> Setting {
        let mut setting = Setting {
            step: self.fixed,
            stiffness: vec![1.0; self.n_regions],
            density: vec![1.0; self.n_regions],
            loss: self.loss.clone(),
            damping: vec![1.0; if self.has_live_dashpots() { self.n_groups() } else { 0 }],
        };
        for (parameter, &value) in self.parameters.iter().zip(values) {
            match parameter.role {
                ParameterRole::RegionStiffness { region } => setting.stiffness[region as usize] = value,
                ParameterRole::RegionDensity { region } => setting.density[region as usize] = value,
                ParameterRole::LossFactor { region } => setting.loss[region as usize] = value,
                ParameterRole::Damping { group } => setting.damping[group as usize] = value,
                _ => assign(&mut setting.step, parameter, value),
            }
        }
        setting
    }

    /// Corners of the box (all of them up to six parameters, else the same number of random ones).
    pub(crate) fn corners(&self) -> Vec<Vec<f64>> {
        let p = self.parameters.len();
        let corner = |bits: u64| -> Vec<f64> {
            let end = |(k, parameter): (usize, &LiveParameter)| {
                if bits >> k & 1 == 1 { parameter.upper } else { parameter.lower }
            };
            self.parameters.iter().enumerate().map(end).collect()
        };
        if 1usize << p.min(32) <= MAX_CORNERS {
            return (0..1 << p).map(corner).collect();
        }
        let mut random = Random::new(64);
        (0..MAX_CORNERS).map(|_| corner(random.next_u64())).collect()
    }

    /// `count` random points of the box.
    pub fn random(&self, count: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut random = Random::new(seed);
        let mut value = |p: &LiveParameter| {
            let t = random.uniform();
            if p.log { p.lower * (p.upper / p.lower).powf(t) } else { p.lower + (p.upper - p.lower) * t }
        };
        (0..count).map(|_| self.parameters.iter().map(&mut value).collect()).collect()
    }

    /// Smallest and largest θ of all stages over the box: θ is monotone in every parameter, so the corners
    /// have them.
    ///
    /// # Errors
    /// If a parameter is unusable for the scheme.
    pub(crate) fn theta_range(&self, scheme: &SchemeTable) -> Result<(f64, f64), TableError> {
        let mut range = (f64::INFINITY, 0.0f64);
        for bits in 0..1u32 << 5 {
            let mut step = self.fixed;
            for parameter in &self.parameters {
                let bit = uniform_bit(parameter.role).map(|k| bits >> k & 1 == 1);
                if let Some(high) = bit {
                    assign(&mut step, parameter, if high { parameter.upper } else { parameter.lower });
                }
            }
            for stage in 0..scheme.active().len() {
                let value = theta(scheme, &step, stage)?;
                range = (range.0.min(value), range.1.max(value));
            }
        }
        Ok(range)
    }

    /// Parameters merged into θ and parameters with an axis of their own, in sentences for the build log.
    pub(crate) fn explain(&self, theta: (f64, f64)) -> Vec<String> {
        let name = |p: &LiveParameter| format!("`{}`", p.name);
        let (regional, uniform): (Vec<&LiveParameter>, Vec<&LiveParameter>) =
            self.parameters.iter().partition(|p| region_of(p.role).is_some());
        let mut lines = vec![];
        if !uniform.is_empty() {
            let names: Vec<String> = uniform.into_iter().map(name).collect();
            lines.push(format!(
                "{} and the stages of the scheme only move θ = k̃/m̃ and share one axis, θ = {:.3e} to {:.3e} s²",
                names.join(", "),
                theta.0,
                theta.1
            ));
        }
        if !regional.is_empty() {
            let names: Vec<String> = regional.into_iter().map(name).collect();
            lines.push(format!(
                "{} change the ratio between regions and keep axes of their own",
                names.join(", ")
            ));
        }
        lines
    }
}

impl Setting {
    /// The same without the factors of the whole body, which turn no mode.
    pub(crate) fn regional(mut self) -> Self {
        (self.step.stiffness, self.step.density) = (1.0, 1.0);
        self
    }

    /// The pencil at this setting, uniform factors included.
    pub fn pencil(&self, nominal: &Pencil) -> Pencil {
        let scaled =
            |uniform: f64, regions: &[f64]| regions.iter().map(|r| uniform * r).collect::<Vec<f64>>();
        let pencil = nominal
            .scaled(&scaled(self.step.density, &self.density), &scaled(self.step.stiffness, &self.stiffness));
        let pencil = if self.loss.is_empty() { pencil } else { pencil.with_loss(self.loss.clone()) };
        if self.damping.is_empty() {
            return pencil;
        }
        let dampers = pencil.dampers().scaled(&self.damping);
        pencil.with_dampers(dampers)
    }

    /// Rayleigh damping at this setting.
    pub fn rayleigh(&self) -> Rayleigh {
        Rayleigh { alpha: self.step.alpha, beta: self.step.beta }
    }
}

/// Loss factor of each region of the mesh, and zeros of attachments; none of a body without any.
fn loss_factors(problem: &Problem, mesh: &Mesh, attached: usize) -> Vec<f64> {
    if !problem.has_loss() {
        return vec![];
    }
    let of = |region| material_entry(problem, region).and_then(|entry| entry.loss_factor).unwrap_or(0.0);
    mesh.regions.iter().map(of).chain(std::iter::repeat_n(0.0, attached)).collect()
}

fn role(
    problem: &Problem,
    index: usize,
    entry: &ParameterEntry,
    mesh: &Mesh,
) -> Result<ParameterRole, BodyError> {
    if let Some(name) = &entry.attachment {
        let place = problem.live_attachments().iter().position(|live| live == name);
        let region = (mesh.regions.len() + 1 + place.expect("a name of the list")) as u32;
        return Ok(match entry.kind {
            ParameterKind::Damping => ParameterRole::Damping { group: place.unwrap_or(0) as u32 },
            ParameterKind::Stiffness => ParameterRole::RegionStiffness { region },
            _ => ParameterRole::RegionDensity { region },
        });
    }
    let uniform = match entry.kind {
        ParameterKind::Stiffness => ParameterRole::Stiffness,
        // A loss factor is always that of a region, which is looked up below.
        ParameterKind::LossFactor => ParameterRole::LossFactor { region: 0 },
        ParameterKind::Damping => ParameterRole::Damping { group: 0 },
        ParameterKind::Density | ParameterKind::Mass => ParameterRole::Density,
        ParameterKind::Alpha => ParameterRole::Alpha,
        ParameterKind::Beta => ParameterRole::Beta,
        ParameterKind::TimeStep => ParameterRole::TimeStep,
    };
    if entry.region == "*" {
        return Ok(uniform);
    }
    let fits = |r: &crate::mesh::Region| entry.region == r.name || entry.region == r.tag.to_string();
    let Some(region) = mesh.regions.iter().position(fits) else {
        let names: Vec<String> = mesh.regions.iter().map(|r| format!("`{}`", r.name)).collect();
        return Err(BodyError::Region {
            path: problem.place(&format!("parameter[{index}].region")),
            found: not_a_region(problem, &entry.region),
            regions: names.join(", ")
                + &did_you_mean(&entry.region, mesh.regions.iter().map(|r| r.name.as_str())),
        });
    };
    // With one region there is no ratio between regions: its scale is the uniform one.
    let region = region as u32;
    Ok(match uniform {
        ParameterRole::LossFactor { .. } => ParameterRole::LossFactor { region },
        _ if mesh.regions.len() == 1 && !problem.has_attachments() => uniform,
        ParameterRole::Density => ParameterRole::RegionDensity { region },
        _ => ParameterRole::RegionStiffness { region },
    })
}

/// One region may be named by its name and by its tag: what a parameter changes is compared, not its key.
fn check_role(
    problem: &Problem,
    index: usize,
    role: ParameterRole,
    earlier: &[LiveParameter],
) -> Result<(), BodyError> {
    let Some(other) = earlier.iter().find(|p| p.role == role) else { return Ok(()) };
    let (path, other) = (problem.place(&format!("parameter[{index}]")), other.name.clone());
    Err(BodyError::TwiceLive { path, name: problem.parameters[index].name.clone(), other })
}

fn live_parameter(
    problem: &Problem,
    entry: &ParameterEntry,
    role: ParameterRole,
    (fixed, loss): (&StepParameters, &[f64]),
) -> LiveParameter {
    let [lower, upper] = entry.range;
    let log = entry.scale == ParameterScale::Log;
    let middle = if log { (lower * upper).sqrt() } else { 0.5 * (lower + upper) };
    let undamped = problem.damping.ratios.is_none();
    let (unit, nominal) = match role {
        ParameterRole::TimeStep if problem.time.step.is_none() => ("s", middle),
        ParameterRole::TimeStep => ("s", fixed.time_step),
        ParameterRole::Alpha if undamped && problem.damping.alpha.is_none() => ("1/s", middle),
        ParameterRole::Alpha => ("1/s", fixed.alpha),
        ParameterRole::Beta if undamped && problem.damping.beta.is_none() => ("s", middle),
        ParameterRole::Beta => ("s", fixed.beta),
        ParameterRole::LossFactor { region } => ("", loss[region as usize]),
        _ => ("", 1.0),
    };
    LiveParameter { name: entry.name.clone(), unit, role, lower, upper, log, nominal }
}

/// Puts a uniform parameter's value where the step takes it.
fn assign(step: &mut StepParameters, parameter: &LiveParameter, value: f64) {
    match parameter.role {
        ParameterRole::Stiffness => step.stiffness = value,
        ParameterRole::Density => step.density = value,
        ParameterRole::Alpha => step.alpha = value,
        ParameterRole::Beta => step.beta = value,
        ParameterRole::TimeStep => step.time_step = value,
        _ => {}
    }
}

pub(super) fn region_of(role: ParameterRole) -> Option<u32> {
    match role {
        ParameterRole::RegionStiffness { region }
        | ParameterRole::RegionDensity { region }
        | ParameterRole::LossFactor { region } => Some(region),
        _ => None,
    }
}

fn uniform_bit(role: ParameterRole) -> Option<u32> {
    match role {
        ParameterRole::Stiffness => Some(0),
        ParameterRole::Density => Some(1),
        ParameterRole::Alpha => Some(2),
        ParameterRole::Beta => Some(3),
        ParameterRole::TimeStep => Some(4),
        _ => None,
    }
}
