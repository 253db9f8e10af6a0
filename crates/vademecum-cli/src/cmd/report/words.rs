//! Numbers and names as the page and its files write them.

/// A frequency with three figures.
pub(crate) fn hertz(value: f64) -> String {
    let digits = if value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        3
    };
    format!("{value:.digits$} Hz")
}

/// Bytes with a unit.
pub(crate) fn size(bytes: f64) -> String {
    let (scale, unit) = if bytes >= 1e6 {
        (1e6, "MB")
    } else if bytes >= 1e3 {
        (1e3, "kB")
    } else {
        (1.0, "bytes")
    };
    let digits = usize::from(scale > 1.0);
    format!("{:.digits$} {unit}", bytes / scale)
}

/// Letters and digits of a name; the rest becomes `-`.
pub(crate) fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
}

/// A quantity with its unit in brackets.
pub(crate) fn with_unit(name: &str, unit: &str) -> String {
    if matches!(unit, "" | "1") { name.into() } else { format!("{name} [{unit}]") }
}
