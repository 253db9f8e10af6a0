//! How large the numbers of a problem file may be: everything that would be allocated, marched or squared is
//! bounded here, before anything is done with it.
//!
//! Bounds of size come from the file format or stand far above what a build ends with; how much a machine
//! holds is another question, asked when the model is known (`limits`, `pipeline`).

use vademecum_format::{MAX_MODES, MAX_PARAMETERS, MAX_TERMS};

use super::{ParameterKind, Problem, ProblemError};
use crate::limits::MAGNITUDE;

/// Longest title, unit system and name.
const MOST_NAME: usize = 1000;
/// Most cells of a block. With fewer than that, quadratic elements have more matrix entries than a 32-bit
/// index counts; linear ones come close to it.
const MOST_CELLS: usize = 50_000_000;
/// Longest over shortest edge of a block. Supports that span less than a millionth of a body do not hold it
/// in double precision.
const MOST_SLENDER: f64 = 1e6;
/// Most positions of forces.
const MOST_POSITIONS: usize = 10_000;
/// Most directions of forces, and most POD vectors per mode.
const MOST_DIRECTIONS: usize = 1000;
/// Upper over lower end of the range of a live parameter.
const WIDEST_RANGE: f64 = 1e6;

const SCALE: &str = "a number between 1e-30 and 1e30 (or zero where zero makes sense), whose products double \
                     precision can hold";
const POSITIVE_SCALE: &str =
    "a positive number between 1e-30 and 1e30, whose products double precision can hold";

/// Whether double precision carries a number through every product a build forms; zero counts.
fn carried(value: f64) -> bool {
    value == 0.0 || (MAGNITUDE.0..=MAGNITUDE.1).contains(&value.abs())
}

impl Problem {
    /// Texts as long as the vademecum file can hold them.
    pub(super) fn check_texts(&self) -> Result<(), ProblemError> {
        let short = |key: &str, text: &str| {
            let expected = "at most 1000 bytes";
            self.require_said(text.len() <= MOST_NAME, key, || format!("{} bytes long", text.len()), expected)
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
                cells.is_some_and(|n| n <= MOST_CELLS),
                "mesh.block.divisions",
                block.divisions,
                "at most 50 000 000 cells in all: the matrices of more have more entries than a 32-bit index \
                 counts",
            )?;
        }
        let plan = &self.snapshots;
        self.require(
            plan.positions <= MOST_POSITIONS,
            "snapshots.positions",
            plan.positions,
            "at most 10 000: a basis needs some tens of load positions, and each is marched in every direction",
        )?;
        self.require_said(
            plan.directions.len() <= MOST_DIRECTIONS,
            "snapshots.directions",
            || format!("{} vectors", plan.directions.len()),
            "at most 1000: every force is a sum of three directions",
        )?;
        let basis = &self.basis;
        if let Some(modes) = basis.modes {
            self.require(
                modes <= MAX_MODES as usize,
                "basis.modes",
                modes,
                "at most 4096, the most a vademecum file holds",
            )?;
        }
        self.require(
            basis.oversampling <= MOST_DIRECTIONS,
            "basis.oversampling",
            basis.oversampling,
            "at most 1000: beyond some tens of POD vectors per mode the rest is rounding",
        )?;
        self.require(
            self.tolerance.max_terms <= MAX_TERMS as usize,
            "tolerance.max_terms",
            self.tolerance.max_terms,
            "at most 65 536, the most a vademecum file holds",
        )?;
        self.require_said(
            self.parameters.len() <= MAX_PARAMETERS,
            "parameter",
            || format!("a list of {}", self.parameters.len()),
            "at most 16 live parameters, the most a vademecum file holds",
        )?;
        if let Some(c) = &self.canonical {
            let terms = c.max_terms.is_none_or(|terms| terms <= MAX_TERMS as usize);
            let expected = "at most 65 536, the most a vademecum file holds";
            self.require(terms, "canonical.max_terms", c.max_terms.unwrap_or(0), expected)?;
            let positions = c.positions.is_none_or(|positions| positions <= MOST_POSITIONS);
            self.require(positions, "canonical.positions", c.positions.unwrap_or(0), "at most 10 000")?;
            self.require(c.margin <= 1e6, "canonical.margin", c.margin, "at most 1e6 times the range")?;
        }
        Ok(())
    }

    /// Magnitudes of physical numbers.
    pub(super) fn check_scales(&self) -> Result<(), ProblemError> {
        let one = |key: &str, value: f64| self.require(carried(value), key, value, SCALE);
        let positive =
            |key: &str, value: f64| self.require(carried(value) && value > 0.0, key, value, POSITIVE_SCALE);
        let all = |key: &str, values: &[f64]| match values.iter().find(|&&value| !carried(value)) {
            Some(&value) => one(key, value),
            None => Ok(()),
        };
        positive("mesh.scale", self.mesh.scale)?;
        if let Some(block) = &self.mesh.block {
            let [shortest, longest] = [f64::min, f64::max].map(|pick: fn(f64, f64) -> f64| {
                let [a, b, c] = block.lengths.map(|length| length * self.mesh.scale);
                pick(a, pick(b, c))
            });
            let within = block.lengths.iter().all(|&l| carried(l)) && carried(shortest) && carried(longest);
            self.require(within, "mesh.block.lengths", block.lengths, POSITIVE_SCALE)?;
            self.require(
                longest <= MOST_SLENDER * shortest,
                "mesh.block.lengths",
                block.lengths,
                "the longest edge at most 1e6 times the shortest: double precision cannot tell how a slenderer \
                 body is held (above about 1000 its first frequency is lost in rounding)",
            )?;
        }
        for (i, m) in self.materials.iter().enumerate() {
            positive(&format!("material[{i}].young"), m.young)?;
            positive(&format!("material[{i}].density"), m.density)?;
        }
        one("damping.alpha", self.damping.alpha.unwrap_or(0.0))?;
        one("damping.beta", self.damping.beta.unwrap_or(0.0))?;
        for pair in self.damping.ratios.iter().flatten() {
            all("damping.ratios", pair)?;
        }
        for (i, p) in self.load.patterns.iter().enumerate() {
            let key = format!("load.pattern[{i}]");
            let values = p.acceleration.iter().chain(&p.traction).flatten().chain(&p.pressure);
            all(&key, &values.copied().collect::<Vec<f64>>())?;
        }
        self.time.step.map_or(Ok(()), |step| positive("time.step", step))?;
        let plan = &self.snapshots;
        plan.directions.iter().try_for_each(|d| all("snapshots.directions", d))?;
        plan.hold.map_or(Ok(()), |hold| positive("snapshots.hold", hold))?;
        plan.duration.map_or(Ok(()), |duration| positive("snapshots.duration", duration))?;
        all("base.point", &self.base.point)?;
        for (i, probe) in self.output.probes.iter().enumerate() {
            all(&format!("output.probe[{i}].point"), &probe.point)?;
            all(&format!("output.probe[{i}].direction"), &probe.direction)?;
        }
        for (i, gauge) in self.output.gauges.iter().enumerate() {
            all(&format!("output.gauge[{i}].point"), &gauge.point)?;
            all(&format!("output.gauge[{i}].direction"), &gauge.direction)?;
            positive(&format!("output.gauge[{i}].length"), gauge.length)?;
        }
        if let Some(c) = &self.canonical {
            all("canonical.load", &c.load)?;
            all("canonical.direction", &c.direction.unwrap_or_default())?;
        }
        self.check_ranges()
    }

    /// Ranges of live parameters that a separated solution can span.
    fn check_ranges(&self) -> Result<(), ProblemError> {
        for (i, p) in self.parameters.iter().enumerate() {
            let key = format!("parameter[{i}].range");
            let [lower, upper] = p.range;
            self.require(carried(lower) && carried(upper), &key, p.range, SCALE)?;
            let damping = matches!(p.kind, ParameterKind::Alpha | ParameterKind::Beta);
            self.require(
                (damping && lower == 0.0) || upper <= WIDEST_RANGE * lower,
                &key,
                p.range,
                "an upper end at most 1e6 times the lower: what the solution does over more cannot be told from \
                 rounding",
            )?;
        }
        Ok(())
    }
}
