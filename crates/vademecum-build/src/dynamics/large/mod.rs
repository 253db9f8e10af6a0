//! Motion at large displacements: a St. Venant–Kirchhoff solid at full order, by Newton's method.
//!
//! The elastic force is the gradient of the energy `V(u) = ½ |z(u)|²` of [`GreenStrain`](crate::fem). Three
//! questions are answered with it: where a body rests under a load ([`rest`]), how it moves
//! ([`LargeMarch`], [`march_large`]), and how it relaxes where some of its coordinates are prescribed
//! ([`Relaxation`]).
//!
//! A load is a vector over the free dofs that depends on time alone, as in the linear march. Its direction
//! stays in space: a pressure that turns with the surface ("follower") cannot be expressed, and a pressure
//! pattern pushes along the normals of the body at rest.

mod balance;
mod error;
mod march;
mod newton;
mod relax;
mod rest;
mod scheme;
mod vectors;

pub use error::LargeError;
pub use march::{LargeMarch, LargeState, LargeWork, march_large, timed_force};
pub use newton::Newton;
pub use relax::{Relaxation, Relaxed};
pub use rest::{Rest, RestOptions, rest};
pub use scheme::{LargeDamping, LargeScheme};

#[cfg(test)]
mod elastica_tests;
#[cfg(test)]
mod march_tests;
#[cfg(test)]
mod test_beam;
