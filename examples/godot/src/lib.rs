//! `VademecumBody`, a node of Godot 4 that draws a deformable body, steps it in every physics frame, and can
//! be pushed. [`soft`] does the work and knows nothing of the engine; `node` is the node (feature `engine`).

#[cfg(feature = "engine")]
mod node;
pub mod soft;
