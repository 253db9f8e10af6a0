//! The online half: opens a vademecum file, binds a scene to it and steps it, without heap and without `std`.
//!
//! Three moves. **Bind**: [`Scene::bind`] chooses a structure of the step (diagonal or block), fuses the stages of the time
//! scheme into one increment map `y ← y + D y + ℓ` and keeps it in memory the caller lends. **Step**: contacts and patterns
//! add up in [`Loads`], [`Scene::step`] advances a [`State`] by one step. **Read**: probes, nodes, the surface, the whole
//! body, energy, each for what it costs and nothing else.
//!
//! ```text
//! let file = File::parse(bytes)?;
//! let sizes = Scene::<f32>::sizes(&file, &options)?;       // how much memory to lend
//! let scene = Scene::bind(&file, &options, memory, work)?;
//! let mut state = State::new(&scene, state_memory)?;
//! let mut loads = Loads::new(&scene, load_memory)?;
//! loads.add_contact(&scene, &contact)?;
//! let status = scene.step(&mut state, &loads)?;
//! ```
//!
//! The odd thing: the kernels multiply and add, and never use a fused multiply-add (`core` has none, and Rust does not
//! contract on its own). The goals in speed are met without it, and a scenario gives the same bits on every machine with
//! IEEE arithmetic and every build of it.
#![no_std]

#[cfg(feature = "mmap")]
extern crate std;

mod axes;
mod bind;
mod error;
mod kernel;
mod loads;
#[cfg(feature = "mmap")]
mod mmap;
mod options;
mod output;
mod scalar;
mod scene;
mod shape;
mod state;
mod surface;

pub use error::{BindError, LoadError, OutputError, StepError};
pub use loads::{Contact, Loads};
#[cfg(feature = "mmap")]
pub use mmap::{Mapped, OpenError};
pub use options::{SceneOptions, Sizes, Status, Structure, StructureChoice};
pub use output::Field;
pub use scalar::Scalar;
pub use scene::Scene;
pub use state::State;
pub use surface::{Surface, SurfacePoint};
pub use vademecum_format as format;
