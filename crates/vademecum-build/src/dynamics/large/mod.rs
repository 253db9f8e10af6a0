//! Motion at large displacements: a St. Venant–Kirchhoff solid at full order, by Newton's method.
//!
//! The elastic force is the gradient of the energy `V(u) = ½ |z(u)|²` of [`GreenStrain`](crate::fem). Three
//! questions are answered with it: where a body rests under a load ([`rest()`]), how it moves
//! ([`LargeMarch`], [`march_large`]; on a basis with [`LargeMarch::within`]), and how it relaxes where some
//! of its coordinates are prescribed (`Relaxation`).
//!
//! A load is a vector over the free dofs that depends on time alone, as in the linear march. Its direction
//! stays in space: a pressure that turns with the surface ("follower") cannot be expressed, and a pressure
//! pattern pushes along the normals of the body at rest.
//!
//! A beam of rubber under 20 times its weight:
//!
//! ```
//! use vademecum_build::dynamics::large::{LargeDamping, LargeMarch, LargeScheme, Newton, RestOptions};
//! use vademecum_build::dynamics::large::{march_large, rest};
//! use vademecum_build::fem::{GreenStrain, Material, Model, Symbolic};
//! use vademecum_build::mesh::{Order, block};
//! use vademecum_build::progress::Silent;
//!
//! let mesh = block([1.0, 0.1, 0.1], [8, 1, 1], Order::Quadratic);
//! let held: Vec<bool> = mesh.nodes.iter().flat_map(|x| [x[0] == 0.0; 3]).collect();
//! let rubber = Material::isotropic(1e7, 0.3, 1000.0);
//! let model = Model::assemble(mesh, &[rubber], &held)?;
//! let (strain, symbolic) = (GreenStrain::new(&model)?, Symbolic::analyze(model.pencil())?);
//! let weight = model.free_part(&model.body_load([0.0, 0.0, -9.81]));
//! let still = vec![0.0; strain.n_dof()];
//!
//! let mut load = |s: f64, f: &mut [f64]| f.iter_mut().zip(&weight).for_each(|(f, w)| *f = 20.0 * s * w);
//! let hanging = rest(&strain, &symbolic, &still, &mut load, &RestOptions::default())?;
//! let lowest = hanging.displacement.iter().fold(0.0_f64, |low, u| low.min(*u));
//! assert!((-0.95..-0.85).contains(&lowest), "the tip hangs down: {lowest}");
//!
//! // Let go of the load, it swings back; damping takes energy.
//! let damping = LargeDamping { strain_rate: 1e-3, ..LargeDamping::default() };
//! let march = LargeMarch::new(&strain, &symbolic, LargeScheme::bathe(), 0.01, damping, Newton::default())?;
//! let mut energies = vec![];
//! march_large(&march, [&hanging.displacement, &still], &mut |_, _| {}, 20, &Silent, |state| {
//!     energies.push(march.energy(state));
//! })?;
//! assert!(energies.windows(2).all(|pair| pair[1] < pair[0]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod balance;
mod error;
mod march;
mod newton;
mod relax;
mod rest;
mod scheme;
mod space;
mod vectors;

pub use error::LargeError;
pub use march::{LargeMarch, LargeState, LargeWork, march_large};
pub use newton::Newton;
pub(crate) use relax::{InitialGuess, Relaxation};
pub use rest::{RestOptions, StaticSolution, rest};
pub use scheme::{LargeDamping, LargeScheme};

#[cfg(test)]
mod elastica_tests;
#[cfg(test)]
mod march_tests;
#[cfg(test)]
mod test_beam;
