//! A gripper of two soft fingers lifts a soft cube by friction: three bodies of two files that touch, in one
//! world at 1 kHz.
//!
//! The fingers are held bodies whose placement the program moves; the cube lies on a rigid floor. What the
//! fingers press and what they lift is printed.

use std::error::Error;
use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::File;
use vademecum_eval::{
    Body, BodyOptions, Member, Pose, RigidMotion, RigidShape, Touching, World, WorldBuffers, WorldOptions,
};

/// A block of silicone, held at a side or not at all, that remembers how near contacts answer together.
fn block(lengths: [f64; 3], held: Option<&str>) -> Result<Vec<u8>, Box<dyn Error>> {
    let support = held.map_or(String::new(), |side| format!("[[support]]\non = {{ group = \"{side}\" }}\n"));
    let text = format!(
        "[mesh]\nblock = {{ lengths = {lengths:?}, divisions = [4, 4, 4], order = \"linear\" }}\n\
         [[material]]\nyoung = 5e5\npoisson = 0.4\ndensity = 1100.0\n{support}[damping]\nratio = 0.1\n\
         [time]\nstep = 1e-3\n[basis]\nmodes = 16\n[tolerance]\nerror = 10.0\n[output]\ncontact_patch = 0.02\n"
    );
    let problem = Problem::parse(&text, "block.toml", PathBuf::new())?;
    Ok(build(&problem, &BuildOptions::default(), &Silent)?.either().bytes)
}

fn main() -> Result<(), Box<dyn Error>> {
    let side = 0.04;
    let (cube, finger) = (block([side; 3], None)?, block([0.02, 0.03, 0.03], Some("x_min"))?);
    let (cube, finger) = (File::parse(&cube)?, File::parse(&finger)?);
    let mut options = BodyOptions::default();
    options.scene.contacts = 128;
    let flying = Body::<f64>::len_for(&cube, &options)?;
    let held = Body::<f64>::len_for(&finger, &options)?;
    let (mut first, mut second, mut third) = (vec![0.0; flying], vec![0.0; held], vec![0.0; held]);
    let mut cube = Body::<f64>::bind(&cube, &options, &mut first)?;
    let mut left = Body::<f64>::bind(&finger, &options, &mut second)?;
    let mut right = Body::<f64>::bind(&finger, &options, &mut third)?;

    // The cube on the floor, its middle over the origin.
    let body = cube.rigid_body().ok_or("the cube is free")?;
    let lying = RigidMotion { position: [0.0, 0.0, side / 2.0], ..RigidMotion::at_rest(&body) };
    cube.set_motion(lying).ok_or("the cube is free")?;
    let (nodes, triangles) = ([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]]);
    let mut floor = RigidShape::led(&nodes, &triangles, Pose::IDENTITY).ok_or("a floor")?;

    // Cube 0, fingers 1 and 2, floor 3.
    let pairs = [
        Touching::new(0, 1).with_friction(0.8),
        Touching::new(0, 2).with_friction(0.8),
        Touching::new(0, 3).with_friction(0.5),
    ];
    let options = WorldOptions { gravity: [0.0, 0.0, -9.81], ..WorldOptions::default() };
    // Fingers stand `gap` away from the cube and `height` over the floor; the right one is turned about z.
    let poses = |gap: f64, height: f64| {
        let reach = side / 2.0 + gap + 0.02;
        let left = Pose::at([-reach, -0.015, height]);
        let right = Pose::new([reach, 0.015, height], [0.0, 0.0, 0.0, 1.0]);
        (left, right)
    };
    let (at_left, at_right) = poses(1e-3, 5e-3);
    let mut members = [
        Member::Free(&mut cube),
        Member::Held(&mut left, at_left),
        Member::Held(&mut right, at_right),
        Member::Rigid(&mut floor),
    ];
    let mut buffers = WorldBuffers::new(&World::sizes(&members, &[], &options)?);
    let mut world = World::new(&members, &pairs, &[], &options, buffers.lend())?;

    println!("   time   height of the cube   pressed by a finger   contacts");
    for step in 0..1500 {
        let time = 1e-3 * f64::from(step);
        // Close for 0.3 s, then lift for a second.
        let (closed, lifted) = ((time / 0.3).min(1.0), ((time - 0.4) / 1.0).clamp(0.0, 1.0));
        let (at_left, at_right) = poses(1e-3 - 4e-3 * closed, 5e-3 + 0.1 * lifted);
        if let [_, Member::Held(_, left), Member::Held(_, right), _] = &mut members {
            (*left, *right) = (at_left, at_right);
        }
        let report = world.step(&mut members)?;
        if step % 150 == 149
            && let Member::Free(cube) = &members[0]
        {
            let pressed: f64 = world
                .touches()
                .iter()
                .filter(|touch| touch.members().contains(&1))
                .map(|touch| touch.force()[0].abs())
                .sum();
            let height = cube.motion().ok_or("the cube is free")?.position[2] - side / 2.0;
            println!("{time:5.2} s {:17.1} mm {pressed:19.2} N {:10}", 1e3 * height, report.pressed);
        }
    }
    let Member::Free(cube) = &members[0] else { return Err("the cube is the first member".into()) };
    let height = cube.motion().ok_or("the cube is free")?.position[2] - side / 2.0;
    if height < 0.09 {
        return Err(format!("the cube was lifted by {:.1} mm only", 1e3 * height).into());
    }
    Ok(())
}
