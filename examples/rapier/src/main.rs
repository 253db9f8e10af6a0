//! Two balls and a box on a rubber plate; prints what happens and draws it.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use rapier3d_f64::prelude::RigidBodyHandle;
use vademecum_rapier::picture::Picture;
use vademecum_rapier::scene::{Scene, scene};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let plate = arguments.next().ok_or("usage: vademecum-rapier PLATE.vdm [PICTURE.svg]")?;
    let Scene { mut coupled, balls, box_ } = scene(Path::new(&plate))?;
    let mut picture = Picture::new(&coupled)?;
    let mut spent = vec![];
    let start: f64 = coupled.energy()?.iter().sum();

    println!("  ms   heights of balls and box/mm   pushes/N    energy/J");
    for step in 0..=2000 {
        if step % 100 == 0 {
            let height = |of: RigidBodyHandle| 1e3 * coupled.world.bodies[of].translation().z;
            let heights = [balls[0], balls[1], box_].map(height);
            let push: f64 = coupled.touches.iter().map(|touch| touch.force.dot(touch.normal)).sum();
            let energy: f64 = coupled.energy()?.iter().sum();
            let [a, b, c] = heights;
            println!("{step:4}   {a:8.2} {b:8.2} {c:8.2}   {push:8.2}   {:9.5}", energy - start);
        }
        if step % 80 == 0 && step < 480 {
            picture.add(&format!("{step} ms"), &coupled, &balls, box_)?;
        }
        let before = Instant::now();
        coupled.step()?;
        spent.push(before.elapsed());
    }
    spent.sort_unstable();
    println!(
        "a step of both takes {:?} in the median, {:?} at most",
        spent[spent.len() / 2],
        spent[spent.len() - 1]
    );
    if let Some(path) = arguments.next() {
        std::fs::write(&path, picture.svg())?;
        println!("wrote {}", Path::new(&path).display());
    }
    Ok(())
}
