//! Rigid bodies of a physics engine on a deformable body, coupled in both directions.
//!
//! What you learn: how the contact operator fits between two steppers. The engine keeps its bodies, their
//! shapes and the contacts among them. The deformable body keeps its modes. Between the two stand forces, one
//! for each place of contact, that are solved for in each step: how the places yield under them is known on
//! both sides ([`Scene::compliance`](vademecum_eval::Scene::compliance), and mass and inertia of the rigid
//! body), and at the end of the step no place has gone into the other body (Signorini), no force pulls, and
//! none drags by more than friction allows (Coulomb). Nothing is stiff, so nothing limits the step.
//!
//! The engine knows shapes, this loop knows **feelers**: spheres on a rigid body that touch the surface. A
//! ball is one feeler, a box with rounded corners has eight.

use std::error::Error;

use rapier3d_f64::prelude::*;
use vademecum_eval::format::SectionKind;
use vademecum_eval::{Contact, Field, Simulation, SurfacePoint};

pub mod picture;
pub mod scene;

/// A sphere that stands for a part of a rigid body.
#[derive(Clone, Copy, Debug)]
pub struct Feeler {
    /// The rigid body.
    pub of: RigidBodyHandle,
    /// Its centre in the frame of that body \[m\].
    pub centre: Vector,
    /// Its radius \[m\].
    pub radius: f64,
}

/// A place where a feeler touches, or soon may.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Which feeler.
    pub feeler: usize,
    /// The place on the deformable body.
    pub place: SurfacePoint,
    /// From the feeler into the deformable body.
    pub normal: Vector,
    /// Force of the feeler on the deformable body, held over the step \[N\].
    pub force: Vector,
    /// From the rigid body's centre of mass to the place of contact \[m\].
    arm: Vector,
    /// Gap at the end of the step if no force acts \[m\].
    gap: f64,
    /// How far the place slides along the feeler in the step, if no force acts \[m\].
    slide: Vector,
}

/// A deformable body in the world of a physics engine, which steps with it.
pub struct Coupled {
    /// The rigid bodies.
    pub world: PhysicsWorld,
    /// The deformable one.
    pub body: Simulation<f64>,
    /// What touches.
    pub feelers: Vec<Feeler>,
    /// Coulomb's μ.
    pub friction: f64,
    /// Contacts of the last step.
    pub touches: Vec<Touch>,
    /// Places at rest, of the loadable nodes.
    nodes: Vec<Vector>,
}

/// A feeler this near to the surface takes part in a step \[radii\], beside how far it moves in the step.
const NEAR: f64 = 0.5;
/// Sweeps over all contacts at most, and the change at which they end, relative to the smallest radius.
const SWEEPS: usize = 10_000;
const DONE: f64 = 1e-12;

impl Coupled {
    /// Puts a body into a world, which takes its time step.
    ///
    /// # Errors
    /// If the file has no loadable surface.
    pub fn new(mut world: PhysicsWorld, body: Simulation<f64>) -> Result<Self, Box<dyn Error>> {
        world.integration_parameters.dt = body.scene().parameters().time_step;
        // Forces then act over the whole step, as they do on the deformable body.
        world.integration_parameters.num_solver_iterations = 1;
        let file = body.file();
        let section = file.section(SectionKind::NodeCoordinates).ok_or("the file has no nodes")?;
        let numbers: Vec<f64> = section.numbers()?.iter().collect();
        let loadable = numbers.as_chunks::<3>().0.iter().take(file.metadata().n_load_nodes as usize);
        let nodes = loadable.map(|&[x, y, z]| Vector::new(x, y, z)).collect();
        Ok(Self { world, body, feelers: vec![], friction: 0.4, touches: vec![], nodes })
    }

    /// One step of both.
    ///
    /// # Errors
    /// If a step is refused, or if the forces cannot be found.
    pub fn step(&mut self) -> Result<(), Box<dyn Error>> {
        self.body.clear();
        self.touches = self.candidates()?;
        let w = self.operator()?;
        self.solve(&w)?;
        for (_, rigid) in self.world.bodies.iter_mut() {
            rigid.reset_forces(false);
            rigid.reset_torques(false);
        }
        for touch in self.touches.iter().filter(|touch| touch.force != Vector::ZERO) {
            self.body.push(&touch.place, touch.force.into())?;
            let rigid = &mut self.world.bodies[self.feelers[touch.feeler].of];
            let at = rigid.center_of_mass() + touch.arm;
            rigid.add_force_at_point(-touch.force, at, true);
        }
        self.body.step(1)?;
        self.world.step();
        Ok(())
    }

    /// Kinetic and potential energy of the rigid bodies, and energy of the deformable one \[J\].
    ///
    /// # Errors
    /// If the file does not tell energies.
    pub fn energy(&self) -> Result<[f64; 3], Box<dyn Error>> {
        let (mut moving, mut high) = (0.0, 0.0);
        for (_, rigid) in self.world.bodies.iter().filter(|(_, rigid)| rigid.is_dynamic()) {
            moving += rigid.kinetic_energy();
            high -= rigid.mass() * self.world.gravity.dot(rigid.center_of_mass());
        }
        Ok([moving, high, self.body.energy()?])
    }

    /// Where a feeler is, and how far it moves in a step without contact.
    fn of_feeler(&self, feeler: &Feeler) -> (Vector, Vector) {
        let centre = self.world.bodies[feeler.of].position() * feeler.centre;
        (centre, self.moves(feeler, centre))
    }

    /// How far the point of a feeler's body that is at `at` moves in a step without contact.
    fn moves(&self, feeler: &Feeler, at: Vector) -> Vector {
        let dt = self.world.integration_parameters.dt;
        dt * (self.world.bodies[feeler.of].velocity_at_point(at) + dt * self.world.gravity)
    }

    /// The places that may touch in the coming step.
    fn candidates(&mut self) -> Result<Vec<Touch>, Box<dyn Error>> {
        let mut found = vec![];
        for (i, feeler) in self.feelers.iter().enumerate() {
            let (centre, moves) = self.of_feeler(feeler);
            let Some(place) = self.body.nearest(centre.into(), 1.0) else { continue };
            let loadable = place.place.nodes().iter().all(|&node| (node as usize) < self.nodes.len());
            if loadable && place.distance < (1.0 + NEAR) * feeler.radius + moves.length() {
                found.push((i, centre, moves, place));
            }
        }
        let contacts: Vec<Contact> = found.iter().map(|(.., place)| contact(place)).collect();
        let mut free = vec![[0.0; 3]; contacts.len()];
        self.body.with(|scene, state, loads| {
            let mut work = vec![0.0; scene.compliance_work(contacts.len())];
            scene.free_motion(state, loads, &contacts, &mut free, &mut work)
        })?;
        let mut touches = vec![];
        for ((i, centre, moves, place), free) in found.into_iter().zip(free) {
            let (feeler, free) = (&self.feelers[i], Vector::from(free));
            let rest: Vector = place.place.entries().map(|(n, w)| w as Real * self.nodes[n as usize]).sum();
            let start = Vector::from(self.body.point(&place, Field::Displacement)?);
            let away = rest + free - (centre + moves);
            let normal = away / away.length();
            let at = centre + feeler.radius * normal;
            touches.push(Touch {
                feeler: i,
                place,
                normal,
                force: Vector::ZERO,
                arm: at - self.world.bodies[feeler.of].center_of_mass(),
                gap: away.length() - feeler.radius,
                slide: free - start - self.moves(feeler, at),
            });
        }
        Ok(touches)
    }

    /// How the end of the step moves, place of contact against feeler, under forces at all of them: the
    /// compliance of the deformable body, and `Δt² (1/m + r × I⁻¹ r ×)` of the rigid ones.
    fn operator(&mut self) -> Result<Vec<f64>, Box<dyn Error>> {
        let contacts: Vec<Contact> = self.touches.iter().map(|touch| contact(&touch.place)).collect();
        let n = contacts.len();
        let mut w = vec![0.0; 9 * n * n];
        self.body.with(|scene, _, _| {
            let mut work = vec![0.0; scene.compliance_work(n)];
            scene.compliance(&contacts, &mut w, &mut work)
        })?;
        let dt = self.world.integration_parameters.dt;
        for (c, touch) in self.touches.iter().enumerate() {
            for (d, other) in self.touches.iter().enumerate() {
                if self.feelers[touch.feeler].of != self.feelers[other.feeler].of {
                    continue;
                }
                let mass = self.world.bodies[self.feelers[touch.feeler].of].mass_properties();
                for (j, unit) in [Vector::X, Vector::Y, Vector::Z].into_iter().enumerate() {
                    let turns = mass.effective_world_inv_inertia * other.arm.cross(unit);
                    let moves = mass.effective_inv_mass * unit + turns.cross(touch.arm);
                    for (i, x) in moves.to_array().into_iter().enumerate() {
                        w[(3 * c + i) * 3 * n + 3 * d + j] += dt * dt * x;
                    }
                }
            }
        }
        Ok(w)
    }

    /// Forces with `gap ≥ 0`, `f_n ≥ 0`, one of them zero, and `|f_t| ≤ μ f_n` against the slide: projected
    /// Gauss-Seidel, contact by contact.
    fn solve(&mut self, w: &[f64]) -> Result<(), &'static str> {
        let n = self.touches.len();
        let row = |c: usize, i: usize| &w[(3 * c + i) * 3 * n..][..3 * n];
        let smallest = self.feelers.iter().map(|feeler| feeler.radius).fold(f64::INFINITY, f64::min);
        for _ in 0..SWEEPS {
            let mut changed = 0.0_f64;
            for c in 0..n {
                let Touch { normal, gap, slide, force: before, .. } = self.touches[c];
                let own = |v: Vector| product(|i| &row(c, i)[3 * c..][..3], [v].into_iter());
                let yields = normal.dot(own(normal));
                let trace: f64 = (0..3).map(|i| row(c, i)[3 * c + i]).sum();
                let moved =
                    |touches: &[Touch]| product(|i| row(c, i), touches.iter().map(|touch| touch.force));

                // The force along the normal that closes the gap, if it pushes.
                let push = before.dot(normal);
                let pushed = (push - (gap + normal.dot(moved(&self.touches))) / yields).max(0.0);
                self.touches[c].force = before + (pushed - push) * normal;

                // Friction that stops the slide, or as much of it as the cone allows.
                let slides = along(slide + moved(&self.touches), normal);
                let wanted = along(self.touches[c].force, normal) - slides / (trace - yields);
                let share = (self.friction * pushed / wanted.length()).min(1.0);
                let drag = if wanted == Vector::ZERO { wanted } else { share * wanted };
                self.touches[c].force = pushed * normal + drag;
                changed = changed.max((self.touches[c].force - before).length() * yields);
            }
            if changed <= DONE * smallest {
                return Ok(());
            }
        }
        Err("the forces of the contacts were not found in 10 000 sweeps")
    }
}

/// A place, without a force.
fn contact(place: &SurfacePoint) -> Contact {
    Contact::new(place.place, [0.0; 3])
}

/// Three rows times a vector that comes in threes.
fn product<'w>(row: impl Fn(usize) -> &'w [f64], forces: impl Iterator<Item = Vector> + Clone) -> Vector {
    let line = |i: usize| -> f64 {
        let blocks = row(i).as_chunks::<3>().0.iter().zip(forces.clone());
        blocks.map(|(&block, force)| Vector::from(block).dot(force)).sum()
    };
    Vector::new(line(0), line(1), line(2))
}

/// What is left of `a` without its part along `normal`.
fn along(a: Vector, normal: Vector) -> Vector {
    a - a.dot(normal) * normal
}
