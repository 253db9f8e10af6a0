//! Frequency response: the response of a body to a harmonic force, in closed form from the modes of a file.
//!
//! In the reduced coordinates a force `F e^{iωt}` gives `ζ = (K_r + iω C_r − ω² M_r)⁻¹ Bᵀ F`, and the
//! displacement along an output is `b · ζ + R/(1 + iωβ)`: what the modes leave out of the static answer, as
//! in the mode acceleration method, behind its force by the damping `βK` of the truncated modes. Velocity
//! and acceleration are `iω` and `−ω²` times that.

mod channel;

use std::f64::consts::TAU;

use faer::c64;
use serde::Serialize;
use vademecum_build::dynamics::harmonic;
use vademecum_build::input::Problem;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_eval::{Body, Field, SceneOptions, SurfacePoint};
use vademecum_format::{File, SectionKind};

pub use channel::Channel;
pub(crate) use channel::{ResponsePoint, Side, at_probe, place, row};

use crate::contents::lines;
use crate::error::{FileError, StudyError};
use crate::live::prepared_at;
use crate::modal::ModalModel;
use crate::near::FAR;
use crate::parameters::{ParameterValue, setting};
use crate::player::{Playable, elastic, elastic_with_fields, with_body};
use crate::verify::file_nodes;

/// Request for a frequency response.
#[derive(Clone, Debug)]
pub struct ResponseRequest {
    /// Point of a force of amplitude 1 N, or load pattern of amplitude 1.
    pub input: Channel,
    /// Outputs.
    pub outputs: Vec<Channel>,
    /// Frequencies \[Hz\], above 0.
    pub frequencies: Vec<f64>,
    /// Displacement, velocity or acceleration.
    pub quantity: Quantity,
}

/// Quantity of the outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Receptance \[m/N\].
    Displacement,
    /// Mobility \[m/(N s)\].
    Velocity,
    /// Inertance \[m/(N s²)\].
    Acceleration,
}

impl Quantity {
    /// `(iω)ⁿ`.
    fn factor(self, frequency: f64) -> c64 {
        let omega = TAU * frequency;
        match self {
            Self::Displacement => c64::new(1.0, 0.0),
            Self::Velocity => c64::new(0.0, omega),
            Self::Acceleration => c64::new(-omega * omega, 0.0),
        }
    }
}

/// Frequencies that may be asked for \[Hz\]: their squares times any mass stay far from overflow.
pub const FREQUENCIES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// Number of frequencies of a range.
pub const POINTS: std::ops::RangeInclusive<u32> = 2..=1_000_000;

/// Frequencies from the first to the last \[Hz\], in equal steps or in equal ratios.
pub fn frequencies([first, last]: [f64; 2], count: usize, ratios: bool) -> Vec<f64> {
    let share = |i: usize| i as f64 / (count.max(2) - 1) as f64;
    let at = |i: usize| match (i, ratios) {
        (0, _) => first,
        (i, _) if i + 1 == count => last,
        (i, true) => first * (last / first).powf(share(i)),
        (i, false) => first + share(i) * (last - first),
    };
    (0..count).map(at).collect()
}

/// Amplitude and phase \[degrees\] of complex amplitudes.
pub fn polar(values: &[c64]) -> impl Iterator<Item = (f64, f64)> + '_ {
    values.iter().map(|x| (x.norm(), x.im.atan2(x.re).to_degrees()))
}

/// The answer of each output at each frequency.
#[derive(Clone, Debug)]
pub struct FrequencyResponse {
    /// Complex amplitudes, one list for each output.
    pub values: Vec<Vec<c64>>,
    /// The same by the modes alone.
    pub by_modes: Vec<Vec<c64>>,
    /// Highest natural frequency among the modes \[Hz\].
    pub highest_mode_hz: f64,
    /// Largest amplitude of each output between the first and the last frequency, refined between those
    /// asked for; none where a mode without damping lies there.
    pub peaks: Vec<Option<Peak>>,
    /// Outputs without the contribution of the truncated modes: points of the surface away from the force,
    /// in a file without the factor of its stiffness.
    pub by_modes_alone: Vec<usize>,
    /// True of a load pattern as the input; false of a force of 1 N.
    pub by_pattern: bool,
    /// Points that are not where they were asked for, and outputs that are held, in sentences.
    pub notes: Vec<String>,
}

/// Largest amplitude of an output.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Peak {
    /// Amplitude, in the unit of the output.
    pub amplitude: f64,
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
}

/// Residual flexibility of each output to a unit load at the input \[m/N\], and the outputs for which the
/// file does not have it. Without stiffness-proportional damping the residual follows its load at once, so
/// it is read there where the structure of the step allows it.
fn static_rest(
    file: &File<'_>,
    options: &SceneOptions,
    input: &ResponsePoint,
    outputs: &[ResponsePoint],
) -> Result<(Vec<f64>, Vec<usize>), StudyError> {
    let at_once = SceneOptions { beta: Some(0.0), ..*options };
    let usable = with_body::<f64, _>(file, &elastic(&at_once), |_| Ok(())).is_ok();
    let options = if usable { at_once } else { *options };
    let shown = |residual: bool| -> Result<(Vec<f64>, bool), StudyError> {
        let options = elastic_with_fields(&SceneOptions { residual, ..options });
        with_body::<f64, _>(file, &options, |body| {
            add(body, input)?;
            body.step()?;
            let mut whole = vec![];
            if residual && body.has_static_field() && points(outputs).next().is_some() {
                whole.resize(3 * file.metadata().n_nodes as usize, 0.0);
                Playable::body_into(body, Field::Displacement, &mut whole)?;
            }
            let read = |output: &ResponsePoint| -> Result<f64, FileError> {
                match output {
                    ResponsePoint::Point(at, direction) if !whole.is_empty() => {
                        Ok(along(at, *direction, |node| std::array::from_fn(|c| whole[3 * node + c])))
                    }
                    output => read(body, output),
                }
            };
            Ok((outputs.iter().map(read).collect::<Result<_, _>>()?, !whole.is_empty()))
        })
    };
    let ((whole, solved), (modes, _)) = (shown(true)?, shown(false)?);
    let unknown = (0..outputs.len()).filter(|&i| !solved && lacks_residual(input, &outputs[i])).collect();
    // The two move alike, and differ by what is shown beside the modes.
    Ok((whole.iter().zip(modes).map(|(whole, modes)| whole - modes).collect(), unknown))
}

/// True of an output whose residual flexibility to this input a file without the factor of its stiffness does
/// not have: a point of the surface away from the force.
pub(crate) fn lacks_residual(input: &ResponsePoint, output: &ResponsePoint) -> bool {
    let (ResponsePoint::Point(at, _), ResponsePoint::Point(other, _)) = (input, output) else { return false };
    other.place.entries().any(|(node, weight)| weight != 0.0 && !has(at, node))
}

/// Outputs that are points, with their numbers.
fn points(outputs: &[ResponsePoint]) -> impl Iterator<Item = (usize, &SurfacePoint)> {
    outputs.iter().enumerate().filter_map(|(i, output)| match output {
        ResponsePoint::Point(at, _) => Some((i, at)),
        ResponsePoint::Named(_) => None,
    })
}

/// True if a node belongs to a place.
fn has(at: &SurfacePoint, node: u32) -> bool {
    at.place.entries().any(|(own, _)| own == node)
}

/// Displacement of a point along a direction, from that of the nodes.
pub(crate) fn along(at: &SurfacePoint, direction: [f64; 3], node: impl Fn(usize) -> [f64; 3]) -> f64 {
    let of_node =
        |index: u32| -> f64 { node(index as usize).iter().zip(direction).map(|(u, d)| u * d).sum() };
    at.place.entries().map(|(index, weight)| weight * of_node(index)).sum()
}

/// Adds a force of 1 N, or a load pattern once.
pub(crate) fn add(body: &mut Body<'_, f64>, input: &ResponsePoint) -> Result<(), FileError> {
    match input {
        ResponsePoint::Point(at, force) => body.push(at, *force)?,
        ResponsePoint::Named(index) => body.push_pattern(*index, 1.0)?,
    }
    Ok(())
}

fn read(body: &Body<'_, f64>, output: &ResponsePoint) -> Result<f64, FileError> {
    match output {
        ResponsePoint::Point(at, direction) => {
            let moved = body.point(at, Field::Displacement)?;
            Ok((0..3).map(|c| moved[c] * direction[c]).sum())
        }
        ResponsePoint::Named(index) => Ok(body.probe(*index, Field::Displacement)?),
    }
}

/// A response that can be evaluated at any frequency.
struct BoundResponse {
    reduced: ModalModel,
    force: Vec<f64>,
    rows: Vec<Vec<f64>>,
    /// `R` of each output.
    rest: Vec<f64>,
    /// Outputs whose `R` the file does not have.
    unknown: Vec<usize>,
    by_pattern: bool,
    notes: Vec<String>,
    /// Time constant of the truncated modes \[s\].
    beta: f64,
    quantity: Quantity,
}

impl BoundResponse {
    fn new(file: &File<'_>, options: &SceneOptions, question: &ResponseRequest) -> Result<Self, StudyError> {
        let reduced = ModalModel::of(file, options)?;
        let input = place(file, &question.input, Side::Input)?;
        let outputs = question.outputs.iter().map(|output| place(file, output, Side::Output));
        let outputs: Vec<ResponsePoint> = outputs.collect::<Result<_, _>>()?;
        let force = row(file, &input, Side::Input)?;
        let rows = outputs.iter().map(|output| row(file, output, Side::Output));
        let rows: Vec<Vec<f64>> = rows.collect::<Result<_, _>>()?;
        let channels = [(&question.input, &input)].into_iter().chain(question.outputs.iter().zip(&outputs));
        let mut notes: Vec<String> = channels.filter_map(|(asked, found)| moved(asked, found)).collect();
        let held = question.outputs.iter().zip(&rows).filter(|(_, row)| row.iter().all(|x| *x == 0.0));
        notes.extend(held.map(|(output, _)| format!("`{output}` is held: no mode moves it")));
        let (rest, unknown) = static_rest(file, options, &input, &outputs)?;
        let beta = options.beta.unwrap_or(file.metadata().beta);
        let by_pattern = matches!(input, ResponsePoint::Named(_));
        let quantity = question.quantity;
        Ok(Self { reduced, force, rows, rest, unknown, by_pattern, notes, beta, quantity })
    }

    /// Answer of each output at a frequency \[Hz\], and the same by the modes alone.
    fn at(&self, frequency: f64) -> Vec<[c64; 2]> {
        let omega = TAU * frequency;
        let zeta = self.reduced.answer(&self.force, omega);
        let factor = self.quantity.factor(frequency);
        let behind = c64::new(1.0, omega * self.beta);
        let answer = |(row, &rest): (&Vec<f64>, &f64)| {
            let modes = row.iter().zip(&zeta).fold(c64::new(0.0, 0.0), |sum, (&b, &z)| sum + z * b);
            [factor * (modes + c64::new(rest, 0.0) / behind), factor * modes]
        };
        self.rows.iter().zip(&self.rest).map(answer).collect()
    }

    /// The largest amplitude of an output, from its amplitudes at ascending frequencies. Each local maximum
    /// of at least half of the largest is refined between its neighbours. Where a mode without damping lies
    /// between the first and the last frequency, there is no largest amplitude.
    fn peak(&self, output: usize, frequencies: &[f64], values: &[c64]) -> Option<Peak> {
        let amplitude = |frequency: f64| self.at(frequency)[output][0].norm();
        let known: Vec<f64> = polar(values).map(|(amplitude, _)| amplitude).collect();
        let largest = known.iter().copied().fold(0.0, f64::max);
        let last = known.len().checked_sub(1)?;
        let within = frequencies[0]..=frequencies[last];
        let infinite = |mode: &[f64; 2]| is_undamped(mode) && within.contains(&(mode[0] / TAU));
        if self.reduced.modes().iter().any(infinite) {
            return None;
        }
        let local = (0..=last).filter(|&i| {
            let (before, after) = (known[i.saturating_sub(1)], known[last.min(i + 1)]);
            known[i] >= 0.5 * largest && known[i] >= before && known[i] >= after
        });
        let refined = local.flat_map(|i| {
            let ends = [frequencies[i.saturating_sub(1)], frequencies[last.min(i + 1)]];
            let own = Peak { amplitude: known[i], frequency_hz: frequencies[i] };
            [own, highest_between(ends, amplitude)]
        });
        refined.max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
    }
}

/// The maximum of an amplitude between two frequencies, where it has one, by sections of golden ratio.
fn highest_between([mut low, mut high]: [f64; 2], amplitude: impl Fn(f64) -> f64) -> Peak {
    const SHARE: f64 = 0.618_033_988_749_894_9;
    // Around its maximum an amplitude is flat to the half of its digits.
    let least = 1e-9 * high;
    let inner = |low: f64, high: f64| [high - SHARE * (high - low), low + SHARE * (high - low)];
    let mut at = inner(low, high);
    let mut found = at.map(&amplitude);
    while high - low > least {
        if found[0] >= found[1] {
            high = at[1];
            at = [inner(low, high)[0], at[0]];
            found = [amplitude(at[0]), found[0]];
        } else {
            low = at[0];
            at = [at[1], inner(low, high)[1]];
            found = [found[1], amplitude(at[1])];
        }
    }
    let i = usize::from(found[1] > found[0]);
    Peak { amplitude: found[i], frequency_hz: at[i] }
}

/// A note about a point that lies off the loadable surface.
pub(crate) fn moved(asked: &Channel, found: &ResponsePoint) -> Option<String> {
    let (Channel::Point(..), ResponsePoint::Point(at, _)) = (asked, found) else { return None };
    let size = at.position.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let [x, y, z] = at.position;
    (at.distance > FAR * size).then(|| {
        format!(
            "`{asked}` is taken at the nearest point of the loadable surface, ({x:.6}, {y:.6}, {z:.6}), {:.3e} away \
             from the point given",
            at.distance
        )
    })
}

/// True of a mode `[ω, σ]` whose answer at its own frequency is infinite, or lost in rounding.
fn is_undamped(&[omega, sigma]: &[f64; 2]) -> bool {
    sigma <= 1e-12 * omega
}

/// The same frequencies with the damped natural frequencies of the file and its half-power points that lie
/// between the first and the last; ascending. A peak is 2ζ times as wide as its frequency is high, and equal
/// steps miss it.
///
/// # Errors
/// [`StudyError::File`]: a file without its reduced matrices.
pub fn with_poles(
    file: &File<'_>,
    options: &SceneOptions,
    mut frequencies: Vec<f64>,
) -> Result<Vec<f64>, StudyError> {
    let (Some(&first), Some(&last)) = (frequencies.first(), frequencies.last()) else {
        return Ok(frequencies);
    };
    let modes = ModalModel::of(file, options)?.modes().into_iter().filter(|mode| !is_undamped(mode));
    let poles = modes.flat_map(|[omega, sigma]| {
        // An overdamped mode has no peak.
        let damped = (omega * omega - sigma * sigma).max(0.0).sqrt();
        [damped - sigma, damped, damped + sigma].map(|omega| omega / TAU)
    });
    frequencies.extend(poles.filter(|&frequency| frequency > first && frequency < last));
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    Ok(frequencies)
}

/// The frequency response of a file.
///
/// # Errors
/// [`StudyError::NoChannel`]; [`StudyError::FarPoint`]: further from the loadable surface than the body is
/// large; [`StudyError::File`]: a file without what a channel needs.
pub fn frequency_response(
    file: &File<'_>,
    options: &SceneOptions,
    question: &ResponseRequest,
) -> Result<FrequencyResponse, StudyError> {
    let bound = BoundResponse::new(file, options, question)?;
    let count = bound.rows.len();
    let (mut values, mut by_modes) = (vec![vec![]; count], vec![vec![]; count]);
    for &frequency in &question.frequencies {
        for (i, [whole, modes]) in bound.at(frequency).into_iter().enumerate() {
            values[i].push(whole);
            by_modes[i].push(modes);
        }
    }
    let peaks = values.iter().enumerate();
    let peaks = peaks.map(|(i, values)| bound.peak(i, &question.frequencies, values)).collect();
    // Rayleigh quotients; with live regions the modes turn a little.
    let BoundResponse { reduced, force, unknown, by_pattern, notes, .. } = bound;
    let highest = (0..force.len()).map(|k| reduced.stiffness[(k, k)] / reduced.mass[(k, k)]);
    let highest_mode_hz = highest.fold(0.0, f64::max).sqrt() / TAU;
    let by_modes_alone = unknown;
    Ok(FrequencyResponse { values, by_modes, highest_mode_hz, peaks, by_modes_alone, by_pattern, notes })
}

/// Distance of a response from direct full-order solves, over all outputs and frequencies; each
/// difference is relative to the root of the mean square of its output over the frequencies.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ResponseError {
    /// Frequencies compared.
    pub frequencies: usize,
    /// Root of the mean square, the worst output.
    pub rms: f64,
    /// The largest difference of all.
    pub worst: f64,
    /// `rms` of the modes alone.
    pub rms_by_modes: f64,
    /// `worst` of the modes alone.
    pub worst_by_modes: f64,
}

/// Compares the response of a file with complex solves of the problem it was built from, at these values of
/// the live parameters of a parametric model.
///
/// # Errors
/// As [`frequency_response`]; [`StudyError::ModalDamping`]: a problem with damping ratios, which are no
/// matrix; a full order that does not factorise.
pub fn compare_response(
    file: &File<'_>,
    options: &SceneOptions,
    question: &ResponseRequest,
    (problem, values): (&Problem, &[ParameterValue]),
    listener: &dyn Listener,
) -> Result<ResponseError, StudyError> {
    let found = frequency_response(file, options, question)?;
    let mut prepared = prepare(problem, &mut Stopwatch::new(listener), listener)?;
    prepared_at(&mut prepared, values)?;
    if !prepared.ratios.is_empty() || prepared.has_loss() {
        return Err(StudyError::ModalDamping);
    }
    let (body, metadata) = (&prepared.body, file.metadata());
    let setting = setting(options, metadata, &prepared.space);
    let pencil = setting.pencil(body.model.pencil());
    let nodes = file_nodes(file, body)?;
    let dofs = body.model.dofs();
    let weights = |channel: &Channel, side: Side| -> Result<Vec<(u32, f64)>, StudyError> {
        let mut row = vec![];
        match (place(file, channel, side)?, side) {
            (ResponsePoint::Point(at, direction), _) => {
                for (node, weight) in at.place.entries() {
                    for (c, along) in direction.iter().enumerate() {
                        let terms = dofs.terms(3 * nodes[node as usize] as usize + c);
                        row.extend(terms.map(|(free, share)| (free, share * weight * along)));
                    }
                }
            }
            (ResponsePoint::Named(index), Side::Output) => {
                let name = &lines(file, SectionKind::ProbeNames)?[index];
                let probe = body.probes.iter().find(|probe| probe.name == *name);
                let probe = probe.ok_or_else(|| StudyError::ForeignProbe { name: name.clone() })?;
                row.extend(body.probe_row(probe));
            }
            (ResponsePoint::Named(index), Side::Input) => {
                let name = &lines(file, SectionKind::PatternNames)?[index];
                let pattern = body.patterns.iter().find(|(pattern, _)| pattern == name);
                let (_, force) = pattern.ok_or_else(|| StudyError::ForeignPattern { name: name.clone() })?;
                row.extend(force.iter().enumerate().map(|(dof, &f)| (dof as u32, f)));
            }
        }
        Ok(row)
    };
    let mut force = vec![0.0; body.n_dof()];
    for (dof, weight) in weights(&question.input, Side::Input)? {
        force[dof as usize] += weight;
    }
    let outputs = question.outputs.iter().map(|output| weights(output, Side::Output));
    let rows: Vec<_> = outputs.collect::<Result<_, _>>()?;
    listener.stage("complex solves of the full order");
    let frequencies = &question.frequencies;
    let exact = harmonic(&pencil, setting.rayleigh(), &force, &rows, frequencies, listener)?;
    let mut error = ResponseError {
        frequencies: frequencies.len(),
        rms: 0.0,
        worst: 0.0,
        rms_by_modes: 0.0,
        worst_by_modes: 0.0,
    };
    let count = frequencies.len() as f64;
    for i in 0..rows.len() {
        let reference: Vec<c64> =
            exact.iter().zip(frequencies).map(|(row, &f)| question.quantity.factor(f) * row[i]).collect();
        let size = (reference.iter().map(c64::norm_sqr).sum::<f64>() / count).sqrt();
        let apart = |values: &[c64]| -> (f64, f64) {
            let squares = values.iter().zip(&reference).map(|(a, b)| (a - b).norm_sqr());
            let (sum, most) = squares.fold((0.0, 0.0), |(sum, most), x| (sum + x, f64::max(most, x)));
            ((sum / count).sqrt() / size, f64::sqrt(most) / size)
        };
        let ((rms, worst), (modes, worst_modes)) = (apart(&found.values[i]), apart(&found.by_modes[i]));
        error.rms = error.rms.max(rms);
        error.worst = error.worst.max(worst);
        error.rms_by_modes = error.rms_by_modes.max(modes);
        error.worst_by_modes = error.worst_by_modes.max(worst_modes);
    }
    Ok(error)
}
