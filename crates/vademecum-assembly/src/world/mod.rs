//! Worlds of an assembly file: parts that move, touch and turn, marched by [`vademecum_eval::World`].

mod block;
mod error;
mod joints;
mod march;
mod mass;
mod overlap;
mod parts;
mod rows;
mod scene;

pub use error::WorldRunError;
pub use march::{WorldPlan, WorldRow, WorldRunOptions, WorldRunReport, WorldSink, run_world};
pub use scene::{SceneJoint, SceneMember, WorldScene, world_scene};
