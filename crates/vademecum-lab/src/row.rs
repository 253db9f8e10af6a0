//! A row of a comparison.

use serde::Serialize;
use vademecum_study::parts::{median, percentiles};

use super::errors::Errors;
use super::measure::Samples;
use super::method::{Group, Identity, Method};

/// One method with one number of modes at one Δt.
#[derive(Serialize)]
pub struct Row {
    /// Method.
    pub name: Identity,
    /// Number of modes; absent at full order.
    pub modes: Option<usize>,
    /// Terms of the separated solution, or of a stage of the chapter's maps.
    pub terms: Option<usize>,
    /// Δt \[s\].
    pub time_step: f64,
    /// Wall time of everything it needs before the first step \[s\].
    pub offline_seconds: f64,
    /// Bytes of its file as it is shipped; absent without a file.
    pub file_bytes: Option<usize>,
    /// Time to bind its file \[µs\].
    pub bind_us: Option<f64>,
    /// Median time of a step \[ns\].
    pub step_ns_p50: f64,
    /// 99th percentile \[ns\].
    pub step_ns_p99: f64,
    /// Slowest step \[ns\].
    pub step_ns_max: f64,
    /// Spread of the medians of the rounds, relative to the lowest.
    pub step_spread: f64,
    /// Time of a full-order step over that of the row.
    pub times_full_order: f64,
    /// Time to fill the displacement of the body \[ms\].
    pub reconstruct_ms: Option<f64>,
    /// Errors.
    #[serde(flatten)]
    pub errors: Errors,
    /// Marches from rest whose sum is the answer; a step is one of each.
    pub marches: usize,
    /// Reason of a missing answer.
    pub note: Option<String>,
    /// Steps of its own in one of the problem's.
    #[serde(skip)]
    pub steps_per_step: f64,
}

/// Common data of the rows of one Δt.
pub(super) struct At<'a> {
    /// Δt \[s\].
    pub time_step: f64,
    /// Steps in one of the problem's.
    pub steps_per_step: f64,
    /// Of the full-order solver with the problem's scheme and Δt.
    pub full_order: &'a Samples,
}

impl Row {
    /// A full-order march.
    pub(super) fn new(
        at: &At<'_>,
        name: Identity,
        samples: &Samples,
        errors: Errors,
        offline_seconds: f64,
    ) -> Self {
        let [step_ns_p50, step_ns_p99, step_ns_max] = percentiles(samples.step_ns.concat());
        Self {
            name,
            modes: None,
            terms: None,
            time_step: at.time_step,
            offline_seconds,
            file_bytes: None,
            bind_us: None,
            step_ns_p50,
            step_ns_p99,
            step_ns_max,
            step_spread: samples.spread(),
            times_full_order: samples.times_faster_than(at.full_order),
            reconstruct_ms: None,
            errors,
            marches: 1,
            note: None,
            steps_per_step: at.steps_per_step,
        }
    }

    /// A reduced method; `note` says why it has no answer.
    pub(super) fn reduced(
        at: &At<'_>,
        group: &Group,
        method: &Method,
        samples: &Samples,
        errors: Errors,
        note: Option<String>,
    ) -> Self {
        Self {
            marches: method.n_marches(),
            note,
            modes: Some(group.basis.n_modes()),
            terms: method.terms,
            file_bytes: method.file_bytes(),
            bind_us: (!samples.bind_us.is_empty()).then(|| median(samples.bind_us.clone())),
            reconstruct_ms: Some(median(samples.reconstruct_ms.clone())),
            ..Self::new(at, group.identity(method), samples, errors, method.offline_seconds)
        }
    }
}
