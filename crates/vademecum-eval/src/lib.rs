//! The online half: opens a vademecum file, binds a scene to it and steps it, without heap and without `std`.
//!
//! # Should I use this crate?
//!
//! Yes, if you have a vademecum file and want to know how its body moves under forces that you learn while it
//! moves: a haptic device, a game, a controller, a plot. A step takes from tens of nanoseconds to
//! microseconds (`docs/measurements/step.md`), so it fits into any loop, and the crate runs where there is no
//! operating system.
//!
//! No, if you want to
//!
//! - make such a file: that is the program `vademecum build`, or the crate `vademecum-build`;
//! - read a file without stepping it, or write one of your own: [`vademecum_format`], which this crate
//!   re-exports as [`mod@format`];
//! - find out where bodies collide, or follow large deformation or plasticity: a file holds one linear
//!   elastic body, with supports or free ([`FreeBody`]), whose displacements in its own frame are small.
//!
//! # The flow
//!
//! ```text
//! bytes ──► File::parse ──► Scene::bind ◄── memory that the caller lends
//!                               │
//!               ┌───────────────┴───────────────┐
//!          State::new                      Loads::new
//!               │                               │ ◄── add_contact ◄── Surface::locate ◄── a finger
//!               │                               │ ◄── add_pattern ◄── gravity, pressure
//!               └────────► Scene::step ◄────────┘
//!                               │ ▲
//!                               │ └──────────────── Scene::set_parameters ◄── a slider
//!                               ▼
//!             probe, node, point, surface_into, body_into, energy
//! ```
//!
//! **Bind**: [`Scene::bind`] chooses one of the structures of the file (diagonal or block), fuses the stages
//! of the time scheme into one increment map `y ← y + D y + ℓ` and keeps it in memory that the caller
//! lends. **Step**: contacts and patterns add up in [`Loads`], and [`Scene::step`] advances a [`State`] by
//! one time step. **Read**: each output costs what it reads and nothing else.
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
//!     loads.add_contact(&scene, &Contact::new(touched.place, force))?;
//!
//!     // Step: this loop is what runs a thousand times a second. The first step of a new state starts with the
//!     // acceleration that its loads demand.
//!     for _ in 0..steps {
//!         scene.step(&mut state, &loads)?;
//!     }
//!     Ok(scene.point(&state, &touched, Field::Displacement)?)
//! }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #     let bytes = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/fixed-f64.vdm"));
//! #     let [.., down] = push(bytes, [0.1, 0.05, 0.0], 10)?;
//! #     assert!(down < 0.0);
//! #     Ok(())
//! # }
//! ```
//!
//! Where there is a heap, [`Simulation`] (feature `alloc`) owns all of that memory and does the same in five
//! lines.
//!
//! # The longest ways through
//!
//! - **A finger pushes a body.** [`Mapped::copy`] or [`Mapped::map`] (feature `mmap`) or your own bytes,
//!   `File::parse`, [`Scene::sizes`], [`Scene::bind`], [`State::new`] and [`Loads::new`] once. Then, for each
//!   step: [`Surface::locate`] where the finger has moved, [`Loads::clear`] and [`Loads::add_contact`] where
//!   the force has changed, [`Scene::step`], and [`Scene::point`] for the finger or [`Scene::surface_into`]
//!   for the picture.
//! - **A stiff tool presses a body.** A force that a spring gives is stable only if the spring is softer than
//!   the body within one step. Ask [`Scene::compliance`] and [`Scene::free_motion`] instead, solve for the
//!   forces with which tool and body just touch at the end of the step, and give them to
//!   [`Loads::add_contact`] (`examples/press_a_sphere.rs`).
//! - **A slider changes the body.** [`SceneOptions::find`] tells the index of a live parameter by its name;
//!   [`Scene::set_parameters`] sets it, in 5 µs for 8 modes and 270 µs for 64, and carries the state over. The
//!   loads from before are stale: clear them and add them again. For several parameters at once, or several
//!   states: [`SceneOptions::set`], [`Scene::rebind`] and [`State::carry`]. A value outside of its range is
//!   refused and changes nothing.
//! - **A body flies.** [`FreeBody::new`] beside the scene of a body without supports; then, for each step,
//!   [`FreeBody::push`] and [`FreeBody::pull`], [`FreeBody::step`], and [`FreeBody::point`]. A host that
//!   moves bodies itself asks [`Loads::add_spin`] instead.
//! - **Many bodies of one file.** [`Batch::len_for`] and [`Batch::new`]; [`Batch::load`] for each instance
//!   that is pushed, [`Batch::step`] for all of them, [`Batch::get`] for each that is looked at, and then
//!   every output of the scene.
//!
//! Beside these: [`State::save_into`] and [`State::restore`] keep every bit, [`Scene::set`] places a body,
//! [`Modal::march`] takes many steps under unchanged loads at a time, [`Scene::cost`] tells what each move
//! reads, [`Scene::increment_into`] hands out `D`.
//!
//! # Features
//!
//! | feature | what it adds | needs |
//! |---|---|---|
//! | `alloc` | [`Simulation`]: a body that owns its memory, in five lines | a heap |
//! | `std` | `Simulation::open`: from a path; AVX2 for large displacements, found at run time | an operating system |
//! | `full`, on by default | everything a file may hold; without it exact steps only, for microcontrollers | nothing |
//! | `mmap` | [`Mapped`]: a file mapped into memory | an operating system |
//! | `unpack` | [`format::unpack_into`]: files that were packed to be shipped | `std` |
//! | `chapter` | [`chapter`]: files of the method as its chapter prints it, a baseline to compare with | nothing |
//!
//! # The odd thing
//!
//! The kernels multiply and add, and never use a fused multiply-add (`core` has none, and Rust does not
//! contract on its own). The goals in speed are met without it, and a scenario gives the same bits on every
//! machine with IEEE arithmetic and every build of it.
#![no_std]
// The pages link to what the features add; without them those links lead nowhere.
#![cfg_attr(
    not(all(feature = "alloc", feature = "chapter", feature = "mmap", feature = "unpack")),
    allow(rustdoc::broken_intra_doc_links)
)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

// From the lowest room to the highest: a room uses those above its own line, and the scene that all of them extend.
mod base;

mod kernels;

mod sections;

// Documentation shows the blocks of a type in this order: a reader wants binding and stepping first.
mod scene;

mod motion;

mod show;

mod flight;

mod body;

#[cfg(feature = "chapter")]
pub mod chapter;

pub use base::error::{BindError, LoadError, OutputError, ParameterError, StepError};
pub use base::options::{RegionScales, SceneOptions, Sizes, Status, Structure, StructureChoice};
pub use base::scalar::Scalar;
pub use body::any::{AnyBody, Precision};
pub use body::batch::{Batch, BatchStatus};
pub use body::body::{Body, BodyOptions, BodyParts, LoadsAfter};
pub use body::quantity::{At, Quantity};
pub use body::saved::{Restored, SavedError};
#[cfg(feature = "alloc")]
pub use body::simulation::{Simulation, SimulationError};
pub use body::tree::{SurfaceTree, TreeSizes};
pub use flight::free::FreeBody;
pub use flight::rigid::{RigidBody, RigidMotion};
pub use motion::modal::{Modal, ModalSizes};
pub use motion::strain::{EnergyAccount, Training};
pub use scene::cost::Cost;
pub use scene::loads::Loads;
pub use scene::scene::Scene;
pub use scene::state::State;
pub use sections::contact::Contact;
#[cfg(feature = "mmap")]
pub use sections::mmap::{Mapped, OpenError};
pub use sections::place::{MAX_PLACE_NODES, Place, PlaceError};
pub use sections::rows::Field;
pub use sections::stress_rows::StressPoint;
pub use sections::surface::{Surface, SurfacePoint, nearest_in_triangle};
pub use show::reaction::Reaction;
pub use show::static_field::StaticField;
pub use show::stress::Tensor;
pub use vademecum_format as format;
pub use vademecum_format::BaseMotion;
