//! The online half: opens a vademecum file, binds a scene to it and steps it, without heap and without `std`.
//!
//! Three moves. **Bind**: [`Scene::bind`] chooses a structure of the step (diagonal or block), fuses the stages of the time
//! scheme into one increment map `y ← y + D y + ℓ` and keeps it in memory the caller lends. **Step**: contacts and patterns
//! add up in [`Loads`], [`Scene::step`] advances a [`State`] by one step. **Read**: probes, nodes, the surface, the whole
//! body, energy, each for what it costs and nothing else.
//!
//! ```
//! use vademecum_eval::format::File;
//! use vademecum_eval::{Contact, Field, Loads, Scene, SceneOptions, State, Surface};
//!
//! /// Pushes down with 20 N at the surface point nearest to `finger`; how that point has moved after `steps` steps, in m.
//! fn push(bytes: &[u8], finger: [f64; 3], steps: usize) -> Result<[f64; 3], Box<dyn std::error::Error>> {
//!     let file = File::parse(bytes)?;
//!     let options = SceneOptions::default();
//!
//!     // Bind. The caller lends all memory; nothing is allocated from here on.
//!     let sizes = Scene::<f32>::sizes(&file, &options)?;
//!     let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
//!     let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
//!     let scene = Scene::bind(&file, &options, &mut memory, &mut work)?;
//!     let mut state = State::new(&scene, &mut state_memory)?;
//!     let mut loads = Loads::new(&scene, &mut load_memory)?;
//!
//!     // Touch. A load stays until `loads.clear()`.
//!     let touched = Surface::new(&file)?.locate(finger).ok_or("no loadable surface")?;
//!     let force = [0.0, 0.0, -20.0];
//!     loads.add_contact(&scene, &Contact { nodes: touched.nodes, weights: touched.weights, force })?;
//!
//!     // Step: this loop is what runs a thousand times a second.
//!     for _ in 0..steps {
//!         scene.step(&mut state, &loads)?;
//!     }
//!     Ok(scene.point(&state, &touched, Field::Displacement)?)
//! }
//! ```
//!
//! **Live parameters**: [`Scene::set_parameter`] sets a scene to another value of one of the file's parameters where it is,
//! in microseconds, and carries the state over; a value out of its range is refused and changes nothing.
//!
//! The odd thing: the kernels multiply and add, and never use a fused multiply-add (`core` has none, and Rust does not
//! contract on its own). The goals in speed are met without it, and a scenario gives the same bits on every machine with
//! IEEE arithmetic and every build of it.
#![no_std]

#[cfg(feature = "mmap")]
extern crate std;

mod axes;
mod batch;
mod bind;
#[cfg(feature = "chapter")]
pub mod chapter;
mod coordinates;
mod cost;
mod eigen;
mod error;
mod kernel;
mod lend;
mod loads;
#[cfg(feature = "mmap")]
mod mmap;
mod modal;
mod motion;
mod options;
mod output;
mod quantised;
mod rebind;
mod reconstruct;
mod rest;
mod scalar;
mod scene;
mod shape;
mod state;
mod surface;

pub use batch::{Batch, BatchStatus};
pub use cost::Cost;
pub use error::{BindError, LoadError, OutputError, ParameterError, StepError};
pub use loads::{Contact, Loads};
#[cfg(feature = "mmap")]
pub use mmap::{Mapped, OpenError};
pub use modal::{Modal, ModalSizes};
pub use options::{SceneOptions, Sizes, Status, Structure, StructureChoice};
pub use output::Field;
pub use scalar::Scalar;
pub use scene::Scene;
pub use state::State;
pub use surface::{Surface, SurfacePoint};
pub use vademecum_format as format;
