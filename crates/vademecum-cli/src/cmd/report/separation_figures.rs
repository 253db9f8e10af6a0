//! How the separated solution came about, and how stable the step is where the parameters may stand.

use vademecum_build::parametric::RadiusSample;
use vademecum_format::Parameter;

use super::Content;
use super::figures::{Figures, file_name};
use crate::failure::Failure;
use crate::pictures::{Chart, Series, dot_chart, line_chart};

/// Parameters the spectral radius is drawn against: those it follows most.
const DRAWN: usize = 3;

impl Figures {
    /// Error over terms.
    pub(super) fn enrichment(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        let history = &content.history;
        let (Some(first), Some(last)) = (history.first(), history.last()) else { return Ok(()) };
        let certified = content.file.metadata().certificate.block;
        let level = |error: f64| vec![(f64::from(first.terms), error), (f64::from(last.terms), error)];
        let lines = [
            Series {
                name: "while terms were added",
                points: history.iter().map(|e| (f64::from(e.terms), e.error)).collect(),
            },
            Series { name: "certified, mean", points: level(certified.map_error_rms) },
            Series { name: "certified, worst", points: level(certified.map_error_max) },
        ];
        let chart = Chart {
            title: "error of the separated solution as it grew",
            x: "terms",
            y: "relative error",
            log_y: true,
        };
        let caption = "The answer to every value of the parameters is a sum of terms, found one after the other, each followed by a new \
             fit of all. The line is the error that is left at points no term was fitted to: the root of the mean square or a tenth of the \
             worst, whichever is larger. A line that keeps falling was stopped by the tolerance; one that runs level had nothing more to \
             gain. The dashed lines are the error of the finished solution against full-order solves at other fresh points.";
        self.add("axes", "enrichment", caption.into(), |path| line_chart(path, &chart, &lines))
    }

    /// Distance of the spectral radius from 1 against the parameters it follows most.
    pub(super) fn radius(&mut self, content: &Content<'_>) -> Result<(), Failure> {
        let metadata = content.file.metadata();
        let parameters = metadata.active_parameters();
        let order = most_followed(parameters, &content.radii);
        for (drawn, k) in order.into_iter().take(DRAWN).enumerate() {
            let parameter = &parameters[k];
            let side = |name, sign: f64| {
                let margin = content.radii.iter().map(|s| (s.values[k], sign * (1.0 - s.spectral_radius)));
                Series { name, points: margin.filter(|p| p.1 > 0.0).collect() }
            };
            let lines: Vec<Series<'_>> = [side("stable: 1 − ρ", 1.0), side("not stable: ρ − 1", -1.0)]
                .into_iter()
                .filter(|series| !series.points.is_empty())
                .collect();
            if lines.is_empty() {
                continue;
            }
            let title = format!("spectral radius ρ of the step against {}", parameter.name);
            let x = with_unit(parameter.name, parameter.unit);
            let chart = Chart { title: &title, x: &x, y: "distance of ρ from 1", log_y: true };
            let again = format!("The same settings, placed by their {}.", parameter.name);
            let first = format!(
                "ρ is the factor by which one step can enlarge a motion that no load drives: below 1 every motion decays. Each dot is one \
                 of {} settings of all parameters (the corners of their box, the values of the problem file, and random ones), placed by \
                 its {}; the lower a dot, the less the scheme and the material damp the slowest decaying motion there. A dot in the second \
                 colour above 1e-12 would be an unstable setting.",
                content.radii.len(),
                parameter.name
            );
            let caption = if drawn == 0 { first } else { again };
            let name = format!("radius-{}", file_name(parameter.name));
            self.add("axes", &name, caption, |path| dot_chart(path, &chart, parameter.log, &lines))?;
        }
        Ok(())
    }
}

/// A quantity with its unit in brackets.
pub fn with_unit(name: &str, unit: &str) -> String {
    if matches!(unit, "" | "1") { name.into() } else { format!("{name} [{unit}]") }
}

/// Places of the parameters by how closely `ln |1 − ρ|` follows them: by the square of their correlation, largest first.
fn most_followed(parameters: &[Parameter<'_>], radii: &[RadiusSample]) -> Vec<usize> {
    let margin: Vec<f64> =
        radii.iter().map(|s| (1.0 - s.spectral_radius).abs().max(f64::MIN_POSITIVE).ln()).collect();
    let follows = |k: usize| {
        let place = |s: &RadiusSample| if parameters[k].log { s.values[k].ln() } else { s.values[k] };
        squared_correlation(&radii.iter().map(place).collect::<Vec<f64>>(), &margin)
    };
    let mut places: Vec<(usize, f64)> = (0..parameters.len()).map(|k| (k, follows(k))).collect();
    places.sort_by(|a, b| b.1.total_cmp(&a.1));
    places.into_iter().map(|place| place.0).collect()
}

/// `(Σ xy)² / (Σ x² Σ y²)` of two series about their means; 0 where one does not vary.
fn squared_correlation(x: &[f64], y: &[f64]) -> f64 {
    let centred = |v: &[f64]| {
        let mean = v.iter().sum::<f64>() / v.len() as f64;
        v.iter().map(|value| value - mean).collect::<Vec<f64>>()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (x, y) = (centred(x), centred(y));
    let size = dot(&x, &x) * dot(&y, &y);
    if size > 0.0 { dot(&x, &y).powi(2) / size } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vademecum_format::ParameterRole;

    #[test]
    fn a_parameter_the_radius_follows_comes_before_one_it_does_not() {
        let parameter = |name, log| Parameter {
            name,
            unit: "",
            role: ParameterRole::Beta,
            log,
            lower: 0.1,
            upper: 10.0,
            nominal: 1.0,
        };
        let parameters = [parameter("idle", false), parameter("damping", true)];
        let sample = |idle: f64, damping: f64| RadiusSample {
            values: vec![idle, damping],
            spectral_radius: 1.0 - 1e-3 * damping,
        };
        let radii = [sample(1.0, 0.1), sample(2.0, 10.0), sample(1.0, 10.0), sample(2.0, 0.1)];
        assert_eq!(most_followed(&parameters, &radii), [1, 0]);
        assert_eq!(squared_correlation(&[1.0, 2.0, 3.0], &[-2.0, -4.0, -6.0]), 1.0);
        assert_eq!(squared_correlation(&[1.0, 1.0], &[1.0, 2.0]), 0.0);
    }
}
