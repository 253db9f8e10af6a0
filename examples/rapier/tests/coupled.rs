//! Momentum, energy and gaps of the scene. `check` builds the plate and tells where it is.

use std::error::Error;
use std::path::PathBuf;

use rapier3d_f64::prelude::*;
use vademecum_rapier::scene::{BALLS, Scene, TOP, scene};

fn plate() -> PathBuf {
    std::env::var_os("PLATE").expect("PLATE is not set: run `check`, which builds the plate").into()
}

/// Momentum of all rigid bodies.
fn momentum(world: &PhysicsWorld) -> Vector {
    world.bodies.iter().map(|(_, rigid)| rigid.mass() * rigid.linvel()).sum()
}

#[test]
fn what_one_side_loses_the_other_gets_and_no_energy_appears() -> Result<(), Box<dyn Error>> {
    let Scene { mut coupled, balls, .. } = scene(&plate())?;
    let dt = coupled.world.integration_parameters.dt;
    let mass: f64 = coupled.world.bodies.iter().map(|(_, rigid)| rigid.mass()).sum();
    let start: f64 = coupled.energy()?.iter().sum();
    let (mut energy, mut hits, mut worst) = (start, 0, 0.0_f64);
    let (mut deepest, mut highest, mut given) = (0.0_f64, 0.0_f64, Vector::ZERO);
    for step in 0..2000 {
        let before = momentum(&coupled.world);
        coupled.step()?;
        // Momentum: of the rigid bodies, in each step.
        let force: Vector = coupled.touches.iter().map(|touch| touch.force).sum();
        given += dt * force;
        let expected = before + dt * (mass * coupled.world.gravity - force);
        worst = worst.max((momentum(&coupled.world) - expected).length());
        // Energy: of all bodies, never more than before, to the depth that is found below times the weights.
        let now: f64 = coupled.energy()?.iter().sum();
        assert!(now <= energy + 1e-6 * start, "step {step}: {now} J after {energy} J");
        energy = now;
        // Forces push, within the cone, and nothing has gone in.
        let ball = &coupled.world.bodies[balls[0]];
        let height = ball.translation().z - TOP - BALLS[0];
        if coupled.touches.iter().any(|touch| touch.feeler == 0 && touch.force != Vector::ZERO) {
            hits += 1;
        } else if hits > 0 {
            highest = highest.max(height);
        }
        for touch in coupled.touches.clone() {
            let push = touch.force.dot(touch.normal);
            let drag = (touch.force - push * touch.normal).length();
            assert!(push >= 0.0 && drag <= coupled.friction * push * (1.0 + 1e-9) + 1e-12);
            let feeler = coupled.feelers[touch.feeler];
            let centre = coupled.world.bodies[feeler.of].position() * feeler.centre;
            let nearest = coupled.body.nearest(centre.into(), 1.0).expect("a surface");
            deepest = deepest.max(1.0 - nearest.distance / feeler.radius);
        }
    }
    assert!(worst < 1e-12 * momentum_scale(mass), "momentum is off by {worst} kg m/s");
    assert!(hits > 100 && highest > 0.05, "the ball bounced {highest} m high");
    assert!(energy < 0.9 * start, "damping and impacts take energy");
    assert!(deepest < 1e-3, "a feeler went in by {deepest} of its radius");
    println!("momentum off by {worst:.1e} kg m/s at most, of {:.2} given", given.length());
    println!(
        "the ball bounced {:.0} mm high; a feeler went in by {deepest:.1e} of its radius",
        1e3 * highest
    );
    Ok(())
}

/// What the bodies have when they fall \[kg m/s\].
fn momentum_scale(mass: f64) -> f64 {
    mass * 2.0
}

#[test]
fn what_lies_still_is_held_by_its_weight() -> Result<(), Box<dyn Error>> {
    let Scene { mut coupled, balls, .. } = scene(&plate())?;
    let [ball, other] = balls;
    for of in [ball, other] {
        coupled.world.remove_body(of);
    }
    coupled.feelers.retain(|feeler| feeler.of != ball && feeler.of != other);
    let weight: f64 = coupled.world.bodies.iter().map(|(_, rigid)| 9.81 * rigid.mass()).sum();
    // The plate's slowest motion dies out within seconds; the mean of the last one is what holds the box.
    let (mut mean, mut steps) = (0.0, 0.0);
    for step in 0..6000 {
        coupled.step()?;
        if step >= 5000 {
            mean -= coupled.touches.iter().map(|touch| touch.force.z).sum::<f64>();
            steps += 1.0;
        }
    }
    assert!((mean / steps / weight - 1.0).abs() < 1e-3, "{} N hold {weight} N", mean / steps);
    let still = coupled.world.bodies.iter().map(|(_, rigid)| rigid.linvel().length()).fold(0.0, f64::max);
    assert!(still < 1e-3, "the box moves by {still} m/s");
    Ok(())
}
