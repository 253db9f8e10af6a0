//! Checks of measured figures: certificates, and the tables for people.

use vademecum_format::{File, SectionKind, StructureCertificate};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};
use super::matrices::not_negative;

/// Tolerance for rounding between two equal measured numbers.
const ROUNDED: f64 = 1.0 + 1e-6;

/// The certificates, and sections 15, 21, 22, 29 and 30.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    let metadata = file.metadata();
    let own = &metadata.certificate;
    for (structure, numbers) in [("diagonal", &own.diagonal), ("block", &own.block)] {
        certificate(numbers, metadata.scheme.is_exact())
            .map_err(|reason| RewriteError::Certificate { structure, reason })?;
    }
    if let Some(numbers) = reals_of(file, S::CanonicalCertificate)? {
        chapter(&numbers)?;
    }
    for (kind, what) in [
        (S::SingularValues, "singular value"),
        (S::EnrichmentHistory, "number"),
        (S::Losses, "number"),
        (S::DampingRatios, "damping ratio"),
    ] {
        if let Some(values) = reals_of(file, kind)? {
            not_negative(kind, what, &values)?;
        }
    }
    let samples = reals_of(file, S::RadiusSamples)?;
    samples.map_or(Ok(()), |samples| radii(&samples, 1 + metadata.n_parameters as usize, &own.block))
}

/// No trajectory on a basis is nearer than its projection, unless fields show a static answer beside the
/// modes, as files for `exact` steps may; a mean is at most the largest.
fn certificate(c: &StructureCertificate, exact: bool) -> Result<(), String> {
    let (error, floor) = (c.trajectory_error, c.projection_floor);
    if error.is_nan() != floor.is_nan() {
        return Err(format!(
            "trajectory error {error:e} and projection floor {floor:e} are measured together"
        ));
    }
    if !exact && floor > ROUNDED * error + 1e-12 {
        return Err(format!("the projection floor {floor:e} is above the trajectory error {error:e}"));
    }
    if c.map_error_rms > ROUNDED * c.map_error_max + 1e-12 {
        let (mean, largest) = (c.map_error_rms, c.map_error_max);
        return Err(format!("the mean error of the maps {mean:e} is above the largest {largest:e}"));
    }
    Ok(())
}

/// Certificate of the chapter's structure: as above, and nothing that was measured is negative or infinite.
fn chapter(numbers: &[f64]) -> Result<(), RewriteError> {
    let kind = SectionKind::CanonicalCertificate;
    if let Some(place) = numbers.iter().position(|x| *x < 0.0 || x.is_infinite()) {
        let reason =
            format!("number {place} is {:e}; what was measured is finite and not negative", numbers[place]);
        return Err(unsound(kind, Fault::Negative, reason));
    }
    let Some(&first) = numbers.first_chunk::<7>() else { return Ok(()) };
    certificate(&StructureCertificate::from_numbers(first), false)
        .map_err(|reason| unsound(kind, Fault::Disagrees, reason))
}

/// No sample of the spectral radius is above the one the certificate calls the largest.
fn radii(samples: &[f64], width: usize, claimed: &StructureCertificate) -> Result<(), RewriteError> {
    let kind = SectionKind::RadiusSamples;
    for (place, row) in samples.chunks_exact(width).enumerate() {
        let radius = row[width - 1];
        if radius < 0.0 {
            let reason = format!("the spectral radius of sample {place} is {radius:e}");
            return Err(unsound(kind, Fault::Negative, reason));
        }
        if radius > ROUNDED * claimed.spectral_radius {
            let reason = format!(
                "the spectral radius of sample {place} is {radius:e}, the certificate calls {:e} the largest",
                claimed.spectral_radius
            );
            return Err(unsound(kind, Fault::Disagrees, reason));
        }
    }
    Ok(())
}
