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
//! - follow plasticity or fracture: a file holds one elastic body, with supports or free ([`FreeBody`]).
//!   Bodies that touch each other are a `World` (feature `world`).
//!
//! # The flow
//!
//! ```text
//! bytes ──► File::parse ──► Body::bind ◄── one slice that the caller lends
//!                               │
//!           push, push_pattern ─┤ ◄── locate ◄── a finger
//!           set_parameters ─────┤ ◄── a slider
//!                               ▼
//!                           Body::step
//!                               │
//!                               ▼
//!             read: probe, node, point, surface, stress, reactions, energies
//! ```
//!
//! [`Body`] owns everything of one body: the file, its [`Scene`], one [`State`], its [`Loads`], the flight of
//! a body without supports, and the work of binding. **Bind**: the scene takes one of the structures of the
//! file (exact, diagonal, block, or strain for large displacements) and keeps the map of a step in lent
//! memory. **Step**: contacts and patterns add up in the loads, and a step advances the state by `Δt`.
//! **Read**: [`Quantity`] is the table of all outputs; each costs its own numbers and nothing else. The parts
//! are public: many states on one scene need no more than a [`State`] and [`Loads`] each.
//!
//! ```
//! use vademecum_eval::format::File;
//! use vademecum_eval::{Body, BodyOptions, Field};
//!
//! /// Displacement \[m\] of the surface point nearest to `finger` after `steps` steps under 20 N downwards.
//! fn push(bytes: &[u8], finger: [f64; 3], steps: usize) -> Result<[f64; 3], Box<dyn std::error::Error>> {
//!     let (file, options) = (File::parse(bytes)?, BodyOptions::default());
//!
//!     // Bind. The caller lends all memory; nothing is allocated from here on.
//!     let mut memory = vec![0.0; Body::<f32>::len_for(&file, &options)?];
//!     let mut body = Body::<f32>::bind(&file, &options, &mut memory)?;
//!
//!     // Touch. A load stays until `body.clear()`.
//!     let touched = body.locate(finger)?;
//!     body.push(&touched, [0.0, 0.0, -20.0])?;
//!
//!     // Step: this loop runs a thousand times a second.
//!     for _ in 0..steps {
//!         body.step()?;
//!     }
//!     Ok(body.point(&touched, Field::Displacement)?)
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
//! # Common uses
//!
//! - **A finger pushes a body.** Bytes of your own, or [`Mapped::copy`] or [`Mapped::map`] (feature `mmap`);
//!   `File::parse` and [`Body::bind`] once. Then, for each step: [`Body::locate`] where the finger has moved,
//!   [`Body::clear`] and [`Body::push`] where the force has changed, [`Body::step`], and [`Body::point`] for
//!   the finger or [`Body::surface_into`] for the picture.
//! - **A stiff tool presses a body.** A spring force is stable only if the spring is softer than the body
//!   within one step. [`Body::compliance`] (the Delassus operator of the contacts) and [`Body::free_motion`]
//!   give the forces with which tool and body just touch at the end of the step
//!   (`examples/press_a_sphere.rs`).
//! - **A slider changes the body.** [`SceneOptions::find`] gives the index of a live parameter by its name;
//!   [`Body::set_parameters`] sets any number of them, in 5 µs for 8 modes and 270 µs for 64, and carries the
//!   state over. Loads from before are stale: clear them and add them again. A value outside its range, an
//!   unknown or a doubled parameter is refused and changes nothing.
//! - **A body flies.** A body without supports has a floating frame of reference, and [`Body::step`] moves
//!   both: [`Body::throw`], [`Body::pull`], [`Body::in_space`]. A host that moves the frame itself binds
//!   without flight and uses [`Body::push_spin`].
//! - **Many bodies of one file.** [`Batch::len_for`] and [`Batch::new`]; [`Batch::load`] for each instance
//!   that is pushed, [`Batch::step`] for all of them, [`Batch::get`] for each that is read.
//! - **Bodies are joined.** [`Assembly`] (feature `assembly`) joins files at their ports while a program
//!   runs, to the bytes of one file: welds, bushings, springs, hinges, ball joints, sliders; glued while they
//!   move, and broken.
//! - **Gradients.** [`Body::adjoint`] goes back over a march with [`Cotangents`] of its outputs, and gives
//!   the gradient with respect to all loads and the start, without its states; a [`CheckpointedMarch`]
//!   (feature `parametric`) gives that with respect to parameters.
//! - **A state is kept.** [`Body::save_into`] and [`Body::restore`]: tagged bytes, every bit.
//!
//! # Features
//!
//! | feature | what it adds | needs |
//! |---|---|---|
//! | `alloc` | [`Simulation`]: a body that owns its memory, in five lines | a heap |
//! | `std` | `Simulation::open`: from a path; AVX2 for large displacements, found at run time | a system |
//! | `assembly` | [`Assembly`]: bodies joined at bind to one file | `full` |
//! | `full`, by default | all that a file may hold; without it exact steps only, for boards | nothing |
//! | `world` | [`World`]: bodies that touch, with friction | `full` |
//! | `parametric` | [`Parametric`]: live stiffness and density of regions | `full` |
//! | `mmap` | [`Mapped`]: a file mapped into memory | an operating system |
//! | `unpack` | [`format::unpack_into`]: files that were packed to be shipped | `std` |
//!
//! # Arithmetic
//!
//! The kernels multiply and add, and never use a fused multiply-add (`core` has none, and Rust does not
//! contract on its own). The goals in speed are met without it, and a scenario gives the same bits on every
//! machine with IEEE arithmetic and every build of it.
#![no_std]
// The pages link to what the features add; without them those links lead nowhere.
#![cfg_attr(
    not(all(
        feature = "alloc",
        feature = "assembly",
        feature = "mmap",
        feature = "parametric",
        feature = "unpack"
    )),
    allow(rustdoc::broken_intra_doc_links)
)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

// From the lowest room to the highest: a room uses those above its own line, and the scene that all of them
// extend.
mod base;

mod kernels;

mod sections;

// Documentation shows the blocks of a type in this order: a reader wants binding and stepping first.
mod scene;

mod motion;

mod show;

mod flight;

#[cfg(feature = "assembly")]
mod assembly;

#[cfg(feature = "parametric")]
mod parametric;

mod body;

#[cfg(feature = "full")]
mod adjoint;

#[cfg(feature = "world")]
mod world;

#[cfg(feature = "full")]
pub use adjoint::{
    batch::BatchAdjoint,
    cotangents::Cotangents,
    error::AdjointError,
    march::{Adjoint, AdjointSizes},
    surface::gradient_on_triangle,
};
#[cfg(feature = "parametric")]
pub use adjoint::{modal::MarchRows, parameters::CheckpointedMarch};
#[cfg(feature = "assembly")]
pub use assembly::assembly::{Assembly, AssemblyNumbers, AssemblyOptions, AssemblySizes};
#[cfg(feature = "assembly")]
pub use assembly::carry::{JointEnergy, JointForce};
#[cfg(feature = "assembly")]
pub use assembly::error::{AssemblyError, JointFault, PartFault};
#[cfg(feature = "assembly")]
pub use assembly::joint::{End, Joint};
#[cfg(feature = "assembly")]
pub use assembly::part::Part;
#[cfg(feature = "assembly")]
pub use assembly::states::PartState;
pub use base::error::{BindError, LoadError, LocateError, OutputError, ParameterError, StepError};
pub use base::options::{
    MAX_CONTACTS, RegionScales, SceneOptions, Sizes, Status, Structure, StructureChoice,
};
#[cfg(any(feature = "assembly", feature = "world"))]
pub use base::pose::Pose;
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
pub use motion::strain::{EnergyAccount, Training};
#[cfg(feature = "parametric")]
pub use parametric::{
    batch::ParametricBatch,
    error::ParametricError,
    memory::{Carried, LiveMemory},
    model::{Parametric, STEPPED_MODES},
    solve::ParametricSizes,
    tangents::{TangentSizes, Tangents},
    tracked::Tracked,
    tracker::{Sensor, Tracker, TrackerOptions},
    tuned::Tuned,
};
pub use scene::cost::Cost;
pub use scene::loads::Loads;
pub use scene::scene::Scene;
pub use scene::state::State;
pub use sections::contact::Contact;
pub use sections::embedded::EmbeddedSurface;
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
#[cfg(all(feature = "world", feature = "alloc"))]
pub use world::room::WorldBuffers;
#[cfg(feature = "world")]
pub use world::{
    bind::WorldSizing,
    error::WorldError,
    joint::{Anchor, JointKind, JointState, WorldJoint},
    lead::Lead,
    member::{Member, RigidShape},
    options::{WorldOptions, WorldReport},
    patch::Near,
    room::{WorldMemory, WorldSizes},
    slot::{Nodes, Slot, Touching},
    touch::Touch,
    world::World,
};
