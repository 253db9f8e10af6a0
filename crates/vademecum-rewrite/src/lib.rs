//! A finished file made into another: compressed for shipping (rounded, if that is allowed), raw for mapping,
//! or without what a target does not need.
//!
//! Each function takes the bytes of a whole file and gives the bytes of a whole new one; nothing is changed
//! in place. Metadata are taken over word for word (but for the number of terms and its certificate where
//! terms are dropped), so a section that is gone is *absent*, never of another shape, and what needs it says
//! so by name. Note: sections this program does not know cannot be carried along (their meaning may
//! be tied to what is dropped), so a file that has some is not rewritten at all.

mod check;
mod codec;
mod contact;
mod error;
mod keep;
mod numbers;
mod pack;
mod round;
mod strip;
mod terms;
mod unpack;
mod whole;

pub use check::{CheckReport, check, check_coordinates, check_limited, lines};
pub use codec::{DECODED_LIMIT, decode, default_limit};
pub use error::{Fault, RewriteError};
pub use keep::Keep;
pub use numbers::numbers;
pub use pack::{pack, pack_limited, pack_within, read_losses};
pub use round::Loss;
pub use strip::strip;
pub use terms::{TermReduction, drop_terms, drop_terms_limited, fewest_terms};
pub use unpack::{unpack, unpack_wanted};
