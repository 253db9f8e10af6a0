//! Worlds of an assembly file: parts that move, touch and turn, marched by [`vademecum_eval::World`].

mod block;
mod bonds;
mod error;
mod joints;
mod march;
mod mass;
mod overlap;
mod parts;
mod rows;
mod saved;
mod scene;
mod simulation;

pub use error::WorldRunError;
pub use march::{WorldPlan, WorldRow, WorldRunOptions, WorldRunReport, WorldSink, run_world};
pub use parts::{GivenPart, PartBytes, PartSurface};
pub use saved::WorldSavedError;
pub use scene::{SceneJoint, SceneMember, WorldScene, world_scene};
pub use simulation::{PartPoint, WorldSimulation};
