//! Upper bounds of a problem's numbers: everything that would be allocated, marched or squared is
//! bounded here, before anything is done with it.
//!
//! Bounds of size come from the file format or stand far above what a build ends with; how much a machine
//! holds is another question, asked when the model is known (`limits`, `pipeline`).

use vademecum_format::{MAX_LIVE, MAX_PARAMETERS};

use super::{ParameterKind, Problem, ProblemError};
use crate::limits::MAGNITUDE;

/// Longest title, unit system and name.
const MAX_NAME: usize = 1000;
/// Most cells of a block. With fewer than that, quadratic elements have more matrix entries than a 32-bit
/// index counts; linear ones come close to it.
const MAX_CELLS: usize = 50_000_000;
/// Longest over shortest edge of a block. Supports that span less than a millionth of a body do not hold it
/// in double precision.
const MAX_SLENDERNESS: f64 = 1e6;
/// Most directions of forces.
const MAX_DIRECTIONS: usize = 1000;
/// Largest loss factor of a live parameter: a mode that strains its region alone is critically damped then.
const MAX_LOSS: f64 = 2.0;

/// Upper over lower end of the range of a live parameter.
const MAX_RANGE_RATIO: f64 = 1e6;

const SCALE: &str = "a number between 1e-30 and 1e30 (or zero where zero makes sense), whose products double \
                     precision can hold";
const POSITIVE_SCALE: &str =
    "a positive number between 1e-30 and 1e30, whose products double precision can hold";

/// True if double precision carries a number through every product a build forms; zero counts.
fn carried(value: f64) -> bool {
    value == 0.0 || (MAGNITUDE.0..=MAGNITUDE.1).contains(&value.abs())
}

impl Problem {
    /// Texts as long as the vademecum file can hold them.
    pub(super) fn check_texts(&self) -> Result<(), ProblemError> {
        let short = |key: &str, text: &str| {
            let expected = "at most 1000 bytes";
            self.require_with(text.len() <= MAX_NAME, key, || format!("{} bytes long", text.len()), expected)
        };
        short("title", &self.title)?;
        short("units", &self.units)?;
        for (i, support) in self.supports.iter().enumerate() {
            short(&format!("support[{i}].name"), support.name.as_deref().unwrap_or(""))?;
        }
        for (i, parameter) in self.parameters.iter().enumerate() {
            short(&format!("parameter[{i}].name"), &parameter.name)?;
        }
        for (i, pattern) in self.load.patterns.iter().enumerate() {
            short(&format!("load.pattern[{i}].name"), &pattern.name)?;
        }
        for (i, probe) in self.output.probes.iter().enumerate() {
            short(&format!("output.probe[{i}].name"), &probe.name)?;
        }
        for (i, gauge) in self.output.gauges.iter().enumerate() {
            short(&format!("output.gauge[{i}].name"), &gauge.name)?;
        }
        for (i, point) in self.reference_points.iter().enumerate() {
            short(&format!("reference_point[{i}].name"), &point.name)?;
        }
        for (i, port) in self.ports.iter().enumerate() {
            short(&format!("port[{i}].name"), &port.name)?;
        }
        for (i, region) in self.mesh.regions.iter().enumerate() {
            short(&format!("mesh.region[{i}].name"), &region.name)?;
        }
        Ok(())
    }

    /// Counts and sizes.
    pub(super) fn check_sizes(&self) -> Result<(), ProblemError> {
        if let Some(block) = &self.mesh.block {
            let cells = block.divisions.iter().try_fold(1, |n: usize, &d| n.checked_mul(d));
            self.require(
                cells.is_some_and(|n| n <= MAX_CELLS),
                "mesh.block.divisions",
                block.divisions,
                "at most 50 000 000 cells in all: the matrices of more have more entries than a 32-bit index \
                 counts",
            )?;
        }
        let plan = &self.snapshots;
        self.require_with(
            plan.directions.len() <= MAX_DIRECTIONS,
            "snapshots.directions",
            || format!("{} vectors", plan.directions.len()),
            "at most 1000: every force is a sum of three directions",
        )?;
        self.require_with(
            self.parameters.len() <= if self.is_parametric() { MAX_LIVE } else { MAX_PARAMETERS },
            "parameter",
            || format!("a list of {}", self.parameters.len()),
            "at most 16 live parameters, or 1024 of a parametric reduced-order model of live regions",
        )
    }

    /// Magnitudes of physical numbers.
    pub(super) fn check_scales(&self) -> Result<(), ProblemError> {
        let one = |key: &str, value: f64| self.require(carried(value), key, value, SCALE);
        let all = |key: &str, values: &[f64]| match values.iter().find(|&&value| !carried(value)) {
            Some(&value) => one(key, value),
            None => Ok(()),
        };
        if let Some(block) = &self.mesh.block {
            let [shortest, longest] = [f64::min, f64::max].map(|pick: fn(f64, f64) -> f64| {
                let [a, b, c] = block.lengths.map(|length| length * self.mesh.scale);
                pick(a, pick(b, c))
            });
            let within = carried(shortest) && carried(longest);
            self.require(within, "mesh.block.lengths", block.lengths, POSITIVE_SCALE)?;
            self.require(
                longest <= MAX_SLENDERNESS * shortest,
                "mesh.block.lengths",
                block.lengths,
                "the longest edge at most 1e6 times the shortest: double precision cannot tell how a slenderer \
                 body is held (above about 1000 its first frequency is lost in rounding)",
            )?;
        }
        one("damping.alpha", self.damping.alpha.unwrap_or(0.0))?;
        one("damping.beta", self.damping.beta.unwrap_or(0.0))?;
        for pair in self.damping.ratios.iter().flatten() {
            all("damping.ratios", pair)?;
        }
        for (i, p) in self.load.patterns.iter().enumerate() {
            let key = format!("load.pattern[{i}]");
            let vectors = [&p.acceleration, &p.traction, &p.force, &p.moment].into_iter().flatten();
            let nodal = p.forces.iter().flatten().flat_map(|force| force.force());
            let values = vectors.flatten().chain(&p.pressure).chain(&p.temperature).copied().chain(nodal);
            all(&key, &values.collect::<Vec<f64>>())?;
        }
        let plan = &self.snapshots;
        plan.directions.iter().try_for_each(|d| all("snapshots.directions", d))?;
        all("base.point", &self.base.point)?;
        for (i, point) in self.reference_points.iter().enumerate() {
            all(&format!("reference_point[{i}].at"), &point.at)?;
        }
        for (i, port) in self.ports.iter().enumerate() {
            all(&format!("port[{i}].at"), &port.at.unwrap_or_default())?;
        }
        for (i, probe) in self.output.probes.iter().enumerate() {
            all(&format!("output.probe[{i}].point"), &probe.point)?;
            all(&format!("output.probe[{i}].direction"), &probe.direction)?;
        }
        for (i, gauge) in self.output.gauges.iter().enumerate() {
            all(&format!("output.gauge[{i}].point"), &gauge.point)?;
            all(&format!("output.gauge[{i}].direction"), &gauge.direction)?;
        }
        if let Some(c) = &self.canonical {
            all("canonical.load", &c.load)?;
            all("canonical.direction", &c.direction.unwrap_or_default())?;
        }
        self.check_parameter_ranges()
    }

    /// Ranges of live parameters that a separated solution can span.
    fn check_parameter_ranges(&self) -> Result<(), ProblemError> {
        for (i, p) in self.parameters.iter().enumerate() {
            let key = format!("parameter[{i}].range");
            let [lower, upper] = p.range;
            self.require(carried(lower) && carried(upper), &key, p.range, SCALE)?;
            let most = if p.kind == ParameterKind::LossFactor { MAX_LOSS } else { f64::INFINITY };
            self.require(upper <= most, &key, p.range, "a loss factor of at most 2")?;
            self.require(
                (p.kind.may_vanish() && lower == 0.0) || upper <= MAX_RANGE_RATIO * lower,
                &key,
                p.range,
                "an upper end at most 1e6 times the lower: what the solution does over more cannot be told from \
                 rounding",
            )?;
        }
        Ok(())
    }
}
