//! A body reduced to its interfaces, and the files by which other programs read it.

mod body;
mod chrono;
mod description;
mod error;
mod npz;
mod of_file;
mod punch;

pub use body::{ReducedBody, columns_of};
pub use chrono::chrono;
pub use description::{Description, InterfaceDescription};
pub use error::PortError;
pub use npz::npz;
pub use of_file::file_at_ports;
pub use punch::punch;
