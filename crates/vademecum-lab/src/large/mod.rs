//! The comparison for bodies of large displacements.
//!
//! A file is built once, and everything is measured against one motion at full order, marched by Bathe's
//! method with a fine step. On the coordinates of the file three ways to step are compared: the strain map of
//! the file, the linear model, and the strain of all elements with Newton's method, which is what a reduced
//! model without a strain map does. The full order with longer steps stands beside them.

mod comparison;
mod push;
mod rows;
mod table;

pub use comparison::{LargeBenchOptions, compare_large_methods};
pub use table::{LARGE_COLUMNS, LargeBenchTable, LargeErrors, LargeMethod, LargeRow};
