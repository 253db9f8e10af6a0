//! A value that is made when someone asks for it, and only then.

use std::fmt;
use std::sync::OnceLock;

/// Initializer of a value.
type Initializer<T> = Box<dyn Fn() -> T + Send + Sync>;

/// A value, or how to make it.
pub(super) struct Lazy<T> {
    found: OnceLock<T>,
    make: Initializer<T>,
}

impl<T> Lazy<T> {
    /// A value that is not there yet.
    pub(crate) fn new(make: impl Fn() -> T + Send + Sync + 'static) -> Self {
        Self { found: OnceLock::new(), make: Box::new(make) }
    }

    /// The value, made by the first who asks.
    pub(crate) fn get(&self) -> &T {
        self.found.get_or_init(|| (self.make)())
    }

    /// True if anyone has asked.
    pub(crate) fn is_made(&self) -> bool {
        self.found.get().is_some()
    }
}

impl<T> fmt::Debug for Lazy<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Late").field("is_made", &self.is_made()).finish_non_exhaustive()
    }
}
