//! Errors of universal files.

use std::path::PathBuf;

/// Reasons why a universal file cannot be used or written.
#[derive(Debug, thiserror::Error)]
pub enum UffError {
    /// It cannot be read.
    #[error("{}", .file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// A line is not what its dataset has there.
    #[error("{}:{line}: found `{found}`; expected {expected}", .file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Its start.
        found: String,
        /// Expected contents.
        expected: &'static str,
    },
    /// A dataset is missing.
    #[error("{}: it has no {what}; expected dataset {dataset}", .file.display())]
    Missing {
        /// The file.
        file: PathBuf,
        /// Contents of the dataset.
        what: &'static str,
        /// Its number.
        dataset: &'static str,
    },
    /// A node has axes of its own.
    #[error(
        "{}: node {node} has displacements in the coordinate system {system}; expected the global one, 0 or 1",
        .file.display()
    )]
    LocalAxes {
        /// The file.
        file: PathBuf,
        /// Its label.
        node: u64,
        /// The coordinate system.
        system: i64,
    },
    /// Measured nodes are nowhere near the mesh.
    #[error(
        "{}: node {node} is {distance:.3e} away from the nearest node of the mesh, which is {size:.3e} large; \
         expected the axes and the unit of the mesh (dataset 164 has the unit of the file)",
        .file.display()
    )]
    FarNode {
        /// The file.
        file: PathBuf,
        /// Its label.
        node: u64,
        /// Distance \[m\].
        distance: f64,
        /// Largest extent of the mesh \[m\].
        size: f64,
    },
    /// A channel without a node and an axis.
    #[error(
        "`{channel}` is along {direction}; dataset 58 has directions along x, y and z: name a point with one of \
         x, -x, y, -y, z, -z"
    )]
    Direction {
        /// The channel.
        channel: String,
        /// Its direction.
        direction: String,
    },
    /// A label that ten columns do not hold.
    #[error("node {node} has more than ten digits, which the columns of a universal file do not hold")]
    Label {
        /// The label.
        node: u64,
    },
}
