//! Figures of the enrichment history and of stability over the parameter domain.

use vademecum_study::separation::most_followed;

use super::content::Content;
use super::figures::Figures;
use super::words::{file_name, with_unit};
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
        let caption = "The answer to every value of the parameters is a sum of terms, found one after the \
            other, each followed by a new fit of all. The line is the error that is left at points no term \
            was fitted to: the root of the mean square or a tenth of the worst, whichever is larger. A line \
            that keeps falling was stopped by the tolerance; one that runs level had nothing more to gain. \
            The dashed lines are the error of the finished solution against full-order solves at other fresh \
            points.";
        self.add("axes", "enrichment", caption.into(), line_chart(&chart, lines.into()))
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
                "ρ is the factor by which one step can enlarge a motion that no load drives: below 1 every \
                 motion decays. Each dot is one of {} settings of all parameters (the corners of their box, \
                 the values of the problem file, and random ones), placed by its {}; the lower a dot, the \
                 less the scheme and the material damp the slowest decaying motion there. A dot in the \
                 second colour above 1e-12 would be an unstable setting.",
                content.radii.len(),
                parameter.name
            );
            let caption = if drawn == 0 { first } else { again };
            let name = format!("radius-{}", file_name(parameter.name));
            self.add("axes", &name, caption, dot_chart(&chart, parameter.log, &lines))?;
        }
        Ok(())
    }
}
