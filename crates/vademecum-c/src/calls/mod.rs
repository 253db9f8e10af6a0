//! The calls, by subject.

/// The same lines in the precision of a body.
macro_rules! either {
    ($any:expr, $body:ident => $lines:expr) => {
        match $any {
            vademecum_eval::AnyBody::Single($body) => $lines,
            #[cfg(feature = "double")]
            vademecum_eval::AnyBody::Double($body) => $lines,
        }
    };
}

/// A field of a body in single precision.
macro_rules! single {
    ($any:expr, $write:ident($field:expr, $out:expr)) => {
        match $any {
            AnyBody::Single(body) => wrote(body.$write($field, $out)),
            #[cfg(feature = "double")]
            AnyBody::Double(_) => Err(Refusal::Words(
                VdmStatus::VDM_ARGUMENT,
                "the body is in double precision: call the function that ends in f64",
            )),
        }
    };
}

/// A field of a body in double precision.
macro_rules! double {
    ($any:expr, $write:ident($field:expr, $out:expr)) => {
        match ($any, $field, $out) {
            #[cfg(feature = "double")]
            (AnyBody::Double(body), field, out) => wrote(body.$write(field, out)),
            (AnyBody::Single(_), ..) => Err(Refusal::Words(
                VdmStatus::VDM_ARGUMENT,
                "the body is in single precision: call the function that ends in f32",
            )),
        }
    };
}

mod about;
mod batch;
mod bind;
mod flight;
mod loads;
mod read;
mod states;
#[cfg(feature = "world")]
mod world;

pub use about::*;
pub use batch::*;
pub use bind::*;
pub use flight::*;
pub use loads::*;
pub use read::*;
pub use states::*;
#[cfg(feature = "world")]
pub use world::*;
