//! Build history of a separated solution: sections 21, 22 and 31.

use serde::Serialize;
use vademecum_build::parametric::RadiusSample;
use vademecum_format::{File, Parameter, SectionKind};

use crate::contents::{lines, numbers};
use crate::error::FileError;

/// Result of an enrichment step.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Enrichment {
    /// Terms after it.
    pub terms: u32,
    /// Relative error they leave at fresh points.
    pub error: f64,
}

/// The enrichments of the separated solution, in order; none if the file does not keep them.
///
/// # Errors
/// As [`numbers`].
pub fn enrichment_history(file: &File<'_>) -> Result<Vec<Enrichment>, FileError> {
    let values = numbers(file, SectionKind::EnrichmentHistory)?;
    Ok(values.as_chunks().0.iter().map(|&[terms, error]| Enrichment { terms: terms as u32, error }).collect())
}

/// The spectral radius at points of the parameters' box; none if the file does not keep it.
///
/// # Errors
/// As [`numbers`].
pub fn radius_samples(file: &File<'_>) -> Result<Vec<RadiusSample>, FileError> {
    let n_parameters = file.metadata().active_parameters().len();
    let sample = |row: &[f64]| {
        let (values, radius) = row.split_at(n_parameters);
        RadiusSample { values: values.to_vec(), spectral_radius: radius[0] }
    };
    let rows = numbers(file, SectionKind::RadiusSamples)?;
    Ok(rows.chunks_exact(n_parameters + 1).map(sample).collect())
}

/// Repairs of an unstable step by the build, one a line; empty without repairs.
///
/// # Errors
/// As [`lines`].
pub fn repairs(file: &File<'_>) -> Result<Vec<String>, FileError> {
    lines(file, SectionKind::Repairs)
}

/// Places of the parameters by how closely `ln |1 − ρ|` follows them: by the square of their correlation,
/// largest first.
pub fn most_followed(parameters: &[Parameter<'_>], radii: &[RadiusSample]) -> Vec<usize> {
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
