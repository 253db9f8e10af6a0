//! Pages of `docs/`, whose examples the tests run.

/// The text of the first block of a page whose fence begins like this.
///
/// # Panics
/// If there is none.
#[must_use]
pub fn block<'a>(page: &'a str, start: &str) -> &'a str {
    let (_, rest) = page.split_once(&format!("```{start}")).expect("a block");
    rest.split("```").next().expect("closed")
}
