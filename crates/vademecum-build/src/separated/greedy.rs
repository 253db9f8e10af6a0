//! What all greedy loops share: how far they go, why they end, and what they report.

use super::solution::Separated;

/// How a greedy enrichment is run.
#[derive(Clone, Debug, PartialEq)]
pub struct EnrichmentOptions {
    /// Stop when the measured error is at most this (relative).
    pub tolerance: f64,
    /// Stop at this many terms.
    pub max_terms: usize,
    /// Most sweeps over all directions while one term is sought.
    pub max_sweeps: usize,
    /// Sweeps in which all factors are re-fitted after each new term; 0 is the plain greedy method.
    pub update_sweeps: usize,
    /// Stop when this many terms in a row did not lower the best error by a twentieth.
    pub patience: usize,
    /// Seed of the random starts and sample points.
    pub seed: u64,
}

impl Default for EnrichmentOptions {
    fn default() -> Self {
        EnrichmentOptions {
            tolerance: 1e-6,
            max_terms: 100,
            max_sweeps: 25,
            update_sweeps: 3,
            patience: 10,
            seed: 1,
        }
    }
}

/// Why an enrichment ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum StopReason {
    /// The tolerance is met.
    Tolerance,
    /// The largest number of terms is reached.
    MaxTerms,
    /// Further terms do not lower the error.
    Stagnation,
}

impl std::fmt::Display for StopReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Tolerance => "the tolerance",
            Self::MaxTerms => "the largest number of terms",
            Self::Stagnation => "stagnation: further terms did not lower the error",
        })
    }
}

/// What an enrichment did. The solution returned beside it is the best one seen, not the last, in the order
/// and scaling of [`Separated::normalised`].
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct EnrichmentReport {
    /// Measured error after each enrichment.
    pub(crate) history: Vec<f64>,
    /// Terms after each enrichment.
    pub terms: Vec<usize>,
    /// Error of the solution returned.
    pub error: f64,
    /// Why it ended.
    pub stop: StopReason,
}

/// Keeps the best solution and decides when to stop; shared by all greedy loops.
pub(crate) struct Progress {
    best: Separated,
    error: f64,
    history: Vec<f64>,
    terms: Vec<usize>,
    /// Error to beat by a twentieth, and the enrichment at which it was reached.
    milestone: (f64, usize),
}

impl Progress {
    pub(crate) fn new(start: Separated, error: f64) -> Progress {
        Progress { best: start, error, history: Vec::new(), terms: Vec::new(), milestone: (f64::INFINITY, 0) }
    }

    /// Records a candidate; says whether, and why, to stop.
    pub(crate) fn record(
        &mut self,
        now: &Separated,
        error: f64,
        options: &EnrichmentOptions,
    ) -> Option<StopReason> {
        self.history.push(error);
        self.terms.push(now.n_terms());
        if error < self.error {
            self.error = error;
            self.best = now.clone();
        }
        if error < 0.95 * self.milestone.0 {
            self.milestone = (error, self.history.len());
        }
        if self.error <= options.tolerance {
            Some(StopReason::Tolerance)
        } else if now.n_terms() >= options.max_terms {
            Some(StopReason::MaxTerms)
        } else if self.history.len() >= self.milestone.1 + options.patience {
            Some(StopReason::Stagnation)
        } else {
            None
        }
    }

    pub(crate) fn finish(self, stop: StopReason) -> (Separated, EnrichmentReport) {
        let Self { best, error, history, terms, .. } = self;
        (best.normalised(), EnrichmentReport { history, terms, error, stop })
    }
}
