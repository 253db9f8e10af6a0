//! Tables of a cost against a size, with the exponent of the power law through them.

/// One column of a table: what is measured, one number per size.
pub struct Column {
    /// Heading, with unit.
    pub name: String,
    /// Values; NaN where nothing was measured.
    pub values: Vec<f64>,
}

/// Least-squares exponent `p` of `value ≈ c sizeᵖ` in logarithms, over the points with positive values; NaN
/// below two.
pub fn exponent(sizes: &[f64], values: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> =
        sizes.iter().zip(values).filter(|(_, v)| **v > 0.0).map(|(s, v)| (s.ln(), v.ln())).collect();
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let covariance: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    covariance / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// Prints a Markdown table: a row per size, then the exponents over all sizes and over the two largest.
pub fn print(title: &str, size: &str, sizes: &[f64], columns: &[Column]) {
    println!("\n### {title}\n");
    let line = |first: String, cells: Vec<String>| println!("| {first} | {} |", cells.join(" | "));
    line(size.into(), columns.iter().map(|c| c.name.clone()).collect());
    line("---".into(), columns.iter().map(|_| "---".into()).collect());
    for (i, s) in sizes.iter().enumerate() {
        line(format!("{s}"), columns.iter().map(|c| figures(c.values[i])).collect());
    }
    let last = sizes.len().saturating_sub(2);
    for (name, from) in [("exponent, all", 0), ("exponent, last two", last)] {
        let fitted = columns.iter().map(|c| figures(exponent(&sizes[from..], &c.values[from..])));
        line(name.into(), fitted.collect());
    }
}

fn figures(value: f64) -> String {
    if value.is_nan() {
        return String::new();
    }
    let decimals = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}
