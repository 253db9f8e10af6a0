//! Reduced matrices: symmetric, not negative, and in agreement wherever two sections say the same.

use vademecum_format::{File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};
use super::symmetric::{HALF, Sizes, negative_pivot, unsymmetric};

/// Sections 4, 5, 16, 19 and 20, as far as the file has them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    let r = file.metadata().n_modes as usize;
    let stiffness = reals_of(file, S::ReducedStiffness)?;
    let eigenvalues = reals_of(file, S::Eigenvalues)?;
    let table = reals_of(file, S::ModeTable)?;
    if let Some(values) = &eigenvalues {
        not_negative(S::Eigenvalues, "eigenvalue", values)?;
    }
    if let Some(stiffness) = &stiffness {
        let sizes = Sizes::of(stiffness, r);
        definite(S::ReducedStiffness, "", stiffness, r, &sizes)?;
        if let Some(values) = &eigenvalues {
            diagonal(stiffness, values, &sizes)?;
        }
        if let Some(parts) = reals_of(file, S::RegionStiffness)? {
            regions(S::RegionStiffness, "section ReducedStiffness", &parts, stiffness, r)?;
        }
    }
    if let Some(parts) = reals_of(file, S::RegionMass)? {
        let identity: Vec<f64> = (0..r * r).map(|i| f64::from(u8::from(i / r == i % r))).collect();
        regions(S::RegionMass, "the identity", &parts, &identity, r)?;
    }
    let quotients: Option<Vec<f64>> = match (&stiffness, &eigenvalues) {
        (Some(stiffness), _) => Some((0..r).map(|k| stiffness[k * r + k]).collect()),
        (None, values) => values.clone(),
    };
    table.map_or(Ok(()), |table| mode_table(&table, quotients.as_deref()))
}

/// No number is less than what rounding makes of zero.
pub(super) fn not_negative(kind: SectionKind, what: &str, values: &[f64]) -> Result<(), RewriteError> {
    let largest = values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    match values.iter().position(|&x| x < -super::symmetric::ROUNDING * largest) {
        None => Ok(()),
        Some(k) => {
            let reason = format!("{what} {k} is {:e}; it must not be negative", values[k]);
            Err(unsound(kind, Fault::Negative, reason))
        }
    }
}

/// Symmetric and positive semidefinite, within the tolerances of `sizes`; `of` says of which region.
fn definite(
    kind: SectionKind,
    of: &str,
    matrix: &[f64],
    r: usize,
    sizes: &Sizes,
) -> Result<(), RewriteError> {
    if let Some([k, l]) = unsymmetric(matrix, r, |k, l| sizes.tolerance(k, l)) {
        let (one, other) = (matrix[k * r + l], matrix[l * r + k]);
        let reason = format!("{of}entry ({k}, {l}) is {one:e} and ({l}, {k}) is {other:e}; it is symmetric");
        return Err(unsound(kind, Fault::NotSymmetric, reason));
    }
    let mut copy = matrix.to_vec();
    match negative_pivot(&mut copy, r, |k| sizes.tolerance(k, k)) {
        None => Ok(()),
        Some(k) => {
            let reason = format!(
                "{of}the matrix is negative for a combination of modes 0 to {k} (entry ({k}, {k}) is {:e}); \
                 energies are not",
                matrix[k * r + k]
            );
            Err(unsound(kind, Fault::Negative, reason))
        }
    }
}

/// `BᵀKB = diag λ`.
fn diagonal(stiffness: &[f64], values: &[f64], sizes: &Sizes) -> Result<(), RewriteError> {
    let r = values.len();
    let expected = |k: usize, l: usize| if k == l { values[k] } else { 0.0 };
    let off = |k: usize, l: usize| (stiffness[k * r + l] - expected(k, l)).abs();
    let mut places = (0..r).flat_map(|k| (0..r).map(move |l| (k, l)));
    match places.find(|&(k, l)| off(k, l) > sizes.tolerance(k, l)) {
        None => Ok(()),
        Some((k, l)) => {
            let reason = format!(
                "they ask for {:e} at ({k}, {l}) of section ReducedStiffness, which has {:e} there",
                expected(k, l),
                stiffness[k * r + l]
            );
            Err(unsound(SectionKind::Eigenvalues, Fault::Disagrees, reason))
        }
    }
}

/// The parts of all regions: each symmetric and not negative, their sum what `sum` says. Two sums over all
/// elements, in two orders, agree to half the digits of the largest entry.
fn regions(kind: SectionKind, name: &str, parts: &[f64], sum: &[f64], r: usize) -> Result<(), RewriteError> {
    let sizes = Sizes::of(sum, r);
    let mut total = vec![0.0; r * r];
    for (region, part) in parts.chunks_exact(r * r).enumerate() {
        definite(kind, &format!("region {region}: "), part, r, &sizes)?;
        total.iter_mut().zip(part).for_each(|(total, x)| *total += x);
    }
    match total.iter().zip(sum).position(|(a, b)| (a - b).abs() > HALF * sizes.largest) {
        None => Ok(()),
        Some(i) => {
            let reason = format!(
                "the regions sum to {:e} at ({}, {}), where {name} has {:e}",
                total[i],
                i / r,
                i % r,
                sum[i]
            );
            Err(unsound(kind, Fault::Disagrees, reason))
        }
    }
}

/// Frequency, Rayleigh quotient, energy share, damping ratios, elongation: `(2πf)² = λ_k`, shares within
/// 0 … 1, no physical damping below 0.
fn mode_table(table: &[f64], quotients: Option<&[f64]>) -> Result<(), RewriteError> {
    let kind = SectionKind::ModeTable;
    let largest = table.iter().skip(1).step_by(6).fold(0.0, |m: f64, x| m.max(x.abs()));
    for (k, &[frequency, quotient, share, physical, _, _]) in table.as_chunks().0.iter().enumerate() {
        for (what, value) in [("frequency", frequency), ("energy share", share), ("damping ratio", physical)]
        {
            if value < 0.0 || (what == "energy share" && value > 1.0 + HALF) {
                let reason = format!("{what} of mode {k} is {value:e}");
                return Err(unsound(kind, Fault::Negative, reason));
            }
        }
        let allowed = |size: f64| 4.0 * HALF * size.abs() + super::symmetric::ROUNDING * largest;
        let square = (std::f64::consts::TAU * frequency).powi(2);
        if (square - quotient).abs() > allowed(quotient) {
            let reason = format!("mode {k} has {frequency:e} Hz and the Rayleigh quotient {quotient:e} 1/s²");
            return Err(unsound(kind, Fault::Disagrees, reason));
        }
        let Some(&own) = quotients.and_then(|values| values.get(k)) else { continue };
        if (own - quotient).abs() > allowed(own) {
            let reason =
                format!("the Rayleigh quotient of mode {k} is {quotient:e}, that of the matrix {own:e}");
            return Err(unsound(kind, Fault::Disagrees, reason));
        }
    }
    Ok(())
}
