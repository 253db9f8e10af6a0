//! Errors of a separated stage at random points, against exact answers in coordinates of their span.

use super::inputs::{Inputs, Part, Span};
use super::stage::StageError;
use faer::Mat;
use vademecum_build::linalg::Random;
use vademecum_build::separated::Separated;
use vademecum_build::separated::product;

/// Random points and the exact answers there, in coordinates of the span.
pub(super) struct Fresh {
    points: Vec<Vec<f64>>,
    /// `(n_sources, n_points)`.
    weights: Mat<f64>,
    pub(super) sources: Mat<f64>,
}

impl Fresh {
    pub(super) fn new(inputs: &Inputs, span: &Span, seed: u64) -> Fresh {
        let mut random = Random::new(seed ^ 0x5eed_f00d);
        let mut point = || inputs.axes.iter().map(|a| a.at_fraction(random.uniform())).collect();
        Fresh::at((0..200).map(|_| point()).collect(), inputs, span)
    }

    pub(super) fn at(points: Vec<Vec<f64>>, inputs: &Inputs, span: &Span) -> Fresh {
        let weights: Vec<Vec<f64>> = points.iter().map(|p| inputs.weights(p)).collect();
        let weights = Mat::from_fn(inputs.functions.len(), points.len(), |s, p| weights[p][s]);
        Fresh { points, weights, sources: span.sources.clone() }
    }

    /// The same points seen by one part: its coordinates, its sources.
    pub(super) fn of_part(&self, part: &Part) -> Fresh {
        let points = self.points.iter().map(|p| p[part.axes.clone()].to_vec()).collect();
        let sources = self.sources.as_ref().subcols(part.sources.start, part.sources.len()).to_owned();
        let weights = self.weights.as_ref().subrows(part.sources.start, part.sources.len()).to_owned();
        Fresh { points, weights, sources }
    }

    /// Error over size, each a root mean square in the energy norm.
    pub(super) fn error(&self, u: &Separated, span: &Span) -> f64 {
        let exact = product(self.sources.as_ref(), self.weights.as_ref());
        let (mut gap, mut size) = (0.0, 0.0);
        for (p, point) in self.points.iter().enumerate() {
            let exact = exact.as_ref().subcols(p, 1).to_owned();
            let Ok(found) = u.evaluate(point) else {
                return f64::NAN;
            };
            gap += span.size(&(&exact - &found));
            size += span.size(&exact);
        }
        (gap / size).sqrt()
    }

    /// State and load, together and apart.
    pub(super) fn stage_error(&self, inputs: &Inputs, span: &Span, u: &Separated) -> StageError {
        let with_zero = |axes: std::ops::Range<usize>| {
            let holds_zero =
                axes.clone().all(|a| inputs.axes[a].range().0 <= 0.0 && inputs.axes[a].range().1 >= 0.0);
            let mut points = self.points.clone();
            points.iter_mut().for_each(|p| p[axes.clone()].fill(0.0));
            if holds_zero { Fresh::at(points, inputs, span).error(u, span) } else { f64::NAN }
        };
        StageError {
            total: self.error(u, span),
            state: with_zero(inputs.n_state..inputs.n_state + 1),
            load: with_zero(0..inputs.n_state),
        }
    }
}
