//! Names of parts, and beginnings of them.

/// Most parts of a world.
pub(crate) const MAX_PARTS: usize = 10_000;

/// The sign behind the beginning of names.
pub(crate) const ANY: char = '*';

/// True if a name is meant: itself, or one with the beginning before `*`.
pub(crate) fn means(pattern: &str, name: &str) -> bool {
    pattern.strip_suffix(ANY).map_or(pattern == name, |beginning| name.starts_with(beginning))
}
