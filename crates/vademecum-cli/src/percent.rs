//! Shares in words.

/// A share in percent, with two figures.
pub(crate) fn percent(share: f64) -> String {
    let text = format!("{:.1e}", 100.0 * share);
    match text.parse::<f64>() {
        Ok(percent) if percent == 0.0 || percent >= 1e-3 => format!("{percent} %"),
        _ => format!("{text} %"),
    }
}
