//! The scene of the example: a box that lies on a plate, and two balls that fall on it.

use std::error::Error;
use std::path::Path;

use rapier3d_f64::prelude::*;
use vademecum_eval::{SceneOptions, Simulation};

use crate::{Coupled, Feeler};

/// Radii of the balls \[m\].
pub const BALLS: [f64; 2] = [0.05, 0.03];
/// Half of the box, and the radius of its corners \[m\].
pub const BOX: [f64; 4] = [0.06, 0.05, 0.03, 0.01];
/// Top of the plate at rest \[m\].
pub const TOP: f64 = 0.01;

/// A scene, and the handles of its bodies.
pub struct Scene {
    /// The world.
    pub coupled: Coupled,
    /// The balls, as [`BALLS`].
    pub balls: [RigidBodyHandle; 2],
    /// The box.
    pub box_: RigidBodyHandle,
}

/// Builds the scene on the plate of a vademecum file (`plate.toml`).
///
/// # Errors
/// If the file cannot be opened.
pub fn scene(plate: &Path) -> Result<Scene, Box<dyn Error>> {
    let body = Simulation::open(plate, &SceneOptions { contacts: 32, ..SceneOptions::default() })?;
    let world = PhysicsWorld { gravity: -9.81 * Vector::Z, ..PhysicsWorld::default() };
    let mut coupled = Coupled::new(world, body)?;
    let at = |x: f64, y: f64, above: f64| {
        RigidBodyBuilder::dynamic().translation(Vector::new(x, y, TOP + above)).can_sleep(false)
    };
    let mut ball = |radius: f64, x: f64, y: f64, above: f64, mass: f64| {
        let collider = ColliderBuilder::ball(radius).mass(mass);
        let (of, _) = coupled.world.insert(at(x, y, above), collider);
        coupled.feelers.push(Feeler { of, centre: Vector::ZERO, radius });
        of
    };
    let balls = [ball(BALLS[0], 0.36, 0.22, 0.30, 1.0), ball(BALLS[1], 0.20, 0.30, 0.15, 0.2)];
    let [x, y, z, radius] = BOX;
    let collider = ColliderBuilder::round_cuboid(x - radius, y - radius, z - radius, radius).mass(0.4);
    let (box_, _) = coupled.world.insert(at(0.15, 0.14, z + 1e-4), collider);
    for corner in 0..8 {
        let sign = |bit: i32| if corner & bit == 0 { -1.0 } else { 1.0 };
        let centre = Vector::new(sign(1) * (x - radius), sign(2) * (y - radius), sign(4) * (z - radius));
        coupled.feelers.push(Feeler { of: box_, centre, radius });
    }
    Ok(Scene { coupled, balls, box_ })
}
