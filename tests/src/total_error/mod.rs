//! How far files are from the truth under pushes at random places of real bodies, and whether the bound that
//! they keep is one: what `docs/measurements/total-error.md` records.
//!
//! A push is a force of 1 N at a point of the loadable surface. It acts in four ways ([`HISTORIES`]); one
//! reference that is exact in time serves all of them, because its space depends on the force alone.

mod bodies;
mod files;
mod measure;
mod push;
mod table;

pub use bodies::{RealBody, real_bodies};
pub use measure::{Conditions, Row, Sample, measure};
pub use push::{HISTORIES, Loading, Push, STEPS};
pub use table::{markdown, quantiles};
