//! Decks of finite element programs: one model in memory, and its linear answers at full order.
//!
//! ```text
//! .inp ──► abaqus ──┐
//! .bdf ──► nastran ─┼──► Deck ──► FullOrder ──► static steps, natural modes
//! .cdb ──► ansys ───┘
//! ```
//!
//! A reader turns cards into a [`Deck`]: mesh, materials, supports, links, attachments, loads and steps. It
//! lists every card that it does not take, with the line and the consequence for the result. [`FullOrder`]
//! eliminates the links (`u = T û`) and assembles `TᵀKT` and `TᵀMT`.

mod abaqus;
mod ansys;
mod deck;
mod error;
mod full_order;
mod heat;
mod left_out;
mod links;
mod nastran;
mod problem;
mod read;
mod tables;
mod units;

pub use deck::{
    Attachment, Damping, Deck, Dynamic, Extent, Harmonic, Link, Load, NodeNumber, Point, Spring, Step,
    StepKind, Support, Temperatures,
};
pub use error::{CardFault, DeckError};
pub use full_order::{FullOrder, Modes, StaticAnswer};
pub use left_out::LeftOut;
pub use problem::{FrequencyResponse, ProblemParts};
pub use read::{ReadOptions, is_deck, read};
pub use units::{System, Units};
pub use vademecum_build::mesh::inp::Dialect;
