//! Signals of a request, found in a file.

use vademecum_build::suggest::did_you_mean;
use vademecum_eval::{Body, Field};
use vademecum_format::{BASE_PATTERNS, File, SectionKind};

use super::error::StateSpaceError;
use super::model::{Signal, StateSpaceRequest};
use super::signal::{OutputSignal, PARTS};
use crate::contents::{is_si, lines, numbers};
use crate::error::FileError;
use crate::frf::{Channel, Quantity, ResponsePoint, Side, along, moved, place};
use crate::near::FAR;
use crate::stress::stress_places;

/// An output that is read of a body.
pub(super) enum PlacedOutput {
    Motion(Quantity, ResponsePoint),
    /// Point of the file, and the component.
    Stress(usize, usize),
    /// Support, and the part of its reaction.
    Reaction(usize, usize),
}

impl PlacedOutput {
    /// True of what answers a force by the residual flexibility, behind it under stiffness-proportional
    /// damping. Reactions and accelerations follow their force at once.
    pub(super) fn is_filtered(&self) -> bool {
        matches!(self, Self::Motion(Quantity::Displacement, _) | Self::Stress(..))
    }

    /// The value of a body; that of an acceleration is its displacement. `whole` is the displacement of all
    /// nodes where it was solved for.
    pub(super) fn read(&self, body: &Body<'_, f64>, whole: &[f64]) -> Result<f64, FileError> {
        Ok(match self {
            Self::Motion(Quantity::Displacement, ResponsePoint::Point(at, direction))
                if !whole.is_empty() =>
            {
                along(at, *direction, |node| std::array::from_fn(|c| whole[3 * node + c]))
            }
            Self::Motion(quantity, at) => {
                let velocity = *quantity == Quantity::Velocity;
                let field = if velocity { Field::Velocity } else { Field::Displacement };
                match at {
                    ResponsePoint::Point(at, direction) => {
                        let moved = body.point(at, field)?;
                        moved.iter().zip(direction).map(|(u, d)| u * d).sum()
                    }
                    ResponsePoint::Named(probe) => body.probe(*probe, field)?,
                }
            }
            Self::Stress(point, component) => body.scene().stress(body.state(), *point)?.0[*component],
            Self::Reaction(support, part) => body.scene().reaction(body.state(), *support)?.total()[*part],
        })
    }
}

/// Signals of a request.
pub(super) struct PlacedSignals {
    pub(super) inputs: Vec<(Signal, ResponsePoint)>,
    pub(super) outputs: Vec<(Signal, PlacedOutput)>,
    /// Places that are not where they were asked for, in sentences.
    pub(super) notes: Vec<String>,
}

impl PlacedSignals {
    pub(super) fn new(file: &File<'_>, request: &StateSpaceRequest) -> Result<Self, StateSpaceError> {
        let (mut placed, si) = (Self { inputs: vec![], outputs: vec![], notes: vec![] }, is_si(file));
        let known = |unit: &str| if si || unit == "1" { unit.to_string() } else { String::new() };
        let (patterns, supports) =
            (lines(file, SectionKind::PatternNames)?, lines(file, SectionKind::SupportNames)?);
        let mut inputs = request.inputs.clone();
        if inputs.is_empty() {
            inputs.extend(patterns.iter().map(|name| Channel::Named(name.clone())));
        }
        for channel in inputs {
            let at = place(file, &channel, Side::Input)?;
            placed.notes.extend(moved(&channel, &at));
            let unit = match &at {
                ResponsePoint::Point(..) => "N",
                ResponsePoint::Named(pattern) => unit_of_pattern(file, &patterns[*pattern]),
            };
            placed.inputs.push((Signal { name: channel.to_string(), unit: known(unit) }, at));
        }
        let mut outputs = request.outputs.clone();
        if outputs.is_empty() {
            let probes = lines(file, SectionKind::ProbeNames)?.into_iter();
            outputs.extend(
                probes.map(|name| OutputSignal::Motion(Quantity::Displacement, Channel::Named(name))),
            );
            outputs.extend(supports.iter().cloned().map(OutputSignal::Reaction));
        }
        let gauges = lines(file, SectionKind::ProbeUnits)?;
        for signal in outputs {
            let name = signal.to_string();
            match &signal {
                OutputSignal::Motion(quantity, channel) => {
                    let at = place(file, channel, Side::Output)?;
                    placed.notes.extend(moved(channel, &at));
                    let gauge = match &at {
                        ResponsePoint::Named(probe) => gauges.get(*probe).is_some_and(|unit| unit == "1"),
                        ResponsePoint::Point(..) => false,
                    };
                    let unit = unit_of_motion(*quantity, gauge);
                    placed
                        .outputs
                        .push((Signal { name, unit: known(unit) }, PlacedOutput::Motion(*quantity, at)));
                }
                OutputSignal::Stress(at, component) => {
                    let point = placed.stress_point(file, *at, &name)?;
                    let signal = Signal { name, unit: known("Pa") };
                    placed.outputs.push((signal, PlacedOutput::Stress(point, *component)));
                }
                OutputSignal::Reaction(asked) => {
                    let (support, parts) = parts_of(&supports, asked)?;
                    for part in parts {
                        let name = format!("reaction.{}.{}", supports[support], PARTS[part]);
                        let unit = if part < 3 { "N" } else { "N m" };
                        let signal = Signal { name, unit: known(unit) };
                        placed.outputs.push((signal, PlacedOutput::Reaction(support, part)));
                    }
                }
            }
        }
        placed.check()?;
        Ok(placed)
    }

    /// Refuses a request without inputs or outputs, and one with a name twice.
    fn check(&self) -> Result<(), StateSpaceError> {
        if self.inputs.is_empty() {
            return Err(StateSpaceError::NoInputs);
        }
        if self.outputs.is_empty() {
            return Err(StateSpaceError::NoOutputs);
        }
        let twice = |mut names: Vec<&str>| {
            names.sort_unstable();
            names.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0].to_string())
        };
        let inputs = self.inputs.iter().map(|(signal, _)| &*signal.name).collect();
        let outputs = self.outputs.iter().map(|(signal, _)| &*signal.name).collect();
        for (side, names) in [("input", inputs), ("output", outputs)] {
            if let Some(name) = twice(names) {
                return Err(StateSpaceError::Twice { side, name });
            }
        }
        Ok(())
    }

    /// The point of the file at the node nearest to a place.
    fn stress_point(&mut self, file: &File<'_>, at: [f64; 3], name: &str) -> Result<usize, StateSpaceError> {
        let places = stress_places(file)?;
        let coordinates = numbers(file, SectionKind::NodeCoordinates)?;
        let nodes = coordinates.as_chunks::<3>().0;
        let square = |node: usize| -> f64 {
            let node = nodes.get(node).copied().unwrap_or([f64::INFINITY; 3]);
            (0..3).map(|c| (at[c] - node[c]).powi(2)).sum()
        };
        let all = places.iter().enumerate();
        let nearest = all.min_by(|a, b| square(a.1.node).total_cmp(&square(b.1.node)));
        let (point, nearest) = nearest.ok_or(StateSpaceError::NoStress)?;
        let [x, y, z] = nodes.get(nearest.node).copied().ok_or(StateSpaceError::NoStress)?;
        if places.iter().filter(|place| place.node == nearest.node).count() > 1 {
            return Err(StateSpaceError::BetweenRegions { x, y, z });
        }
        let (distance, size) =
            (square(nearest.node).sqrt(), [x, y, z].iter().fold(0.0, |m: f64, x| m.max(x.abs())));
        if distance > FAR * size {
            self.notes.push(format!(
                "`{name}` is that of the nearest node with a stress, ({x:.6}, {y:.6}, {z:.6}), {distance:.3e} away \
                 from the point given"
            ));
        }
        Ok(point)
    }
}

/// Unit of the amplitude of a pattern: those of a base are accelerations and products of angular velocities.
fn unit_of_pattern(file: &File<'_>, name: &str) -> &'static str {
    let of_base = file.section(SectionKind::BaseFrame).is_some();
    match BASE_PATTERNS.iter().position(|known| of_base && *known == name) {
        Some(0..3) => "m/s²",
        Some(3..6) => "rad/s²",
        Some(_) => "rad²/s²",
        None => "1",
    }
}

fn unit_of_motion(quantity: Quantity, gauge: bool) -> &'static str {
    match (quantity, gauge) {
        (Quantity::Displacement, false) => "m",
        (Quantity::Velocity, false) => "m/s",
        (Quantity::Acceleration, false) => "m/s²",
        (Quantity::Displacement, true) => "1",
        (Quantity::Velocity, true) => "1/s",
        (Quantity::Acceleration, true) => "1/s²",
    }
}

/// Number of a support, and the parts of its reaction that are asked for: `SUPPORT` or `SUPPORT.PART`.
fn parts_of(supports: &[String], asked: &str) -> Result<(usize, std::ops::Range<usize>), StateSpaceError> {
    let find = |name: &str| supports.iter().position(|known| known == name);
    if let Some(support) = find(asked) {
        return Ok((support, 0..PARTS.len()));
    }
    let (name, part) = asked.rsplit_once('.').unwrap_or((asked, ""));
    let part = PARTS.iter().position(|known| *known == part);
    if let Some((support, part)) = find(name).zip(part) {
        return Ok((support, part..part + 1));
    }
    let known: Vec<String> = supports.iter().map(|name| format!("`{name}`")).collect();
    let known = if known.is_empty() { "none".into() } else { known.join(", ") };
    let known = known + &did_you_mean(asked, supports.iter().map(String::as_str));
    Err(StateSpaceError::NoSupport { name: asked.into(), known })
}
