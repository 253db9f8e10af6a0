//! Names as the page and its files write them.

/// Letters and digits of a name; the rest becomes `-`.
pub(crate) fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
}

/// A quantity with its unit in brackets.
pub(crate) fn with_unit(name: &str, unit: &str) -> String {
    if matches!(unit, "" | "1") { name.into() } else { format!("{name} [{unit}]") }
}
