//! The calls of the node, without the engine. `BODY` names a file of the tongue of `bodies/`.

use vademecum_godot::soft::{Drawn, Soft};

fn tongue() -> Soft {
    let path = std::env::var("BODY").expect("BODY names a file");
    Soft::new(std::fs::read(path).expect("read")).expect("a body")
}

const TIP: [f64; 3] = [0.03569, 0.0025, 0.0008];

#[test]
fn a_push_bends_the_tongue_and_it_rings() {
    let mut soft = tongue();
    soft.push(TIP, [0.0, 0.0, -0.1]).expect("pushed");
    // Frames of 60 Hz; steps are of 20 µs, so what a frame leaves over is made up for.
    for _ in 0..120 {
        soft.advance(1.0 / 60.0).expect("steps");
    }
    let [x, y, down] = soft.displacement(TIP).expect("at the tip");
    // F L³ / (3 E I), with its vibration damped away after two seconds.
    let beam = -0.1 * 0.03569_f64.powi(3) / (3.0 * 2.06e11 * 0.005 * 0.0008_f64.powi(3) / 12.0);
    assert!((down / beam - 1.0).abs() < 0.05, "{down} against {beam}");
    assert!(x.abs() + y.abs() < 0.1 * down.abs(), "{x} {y}");
    let probe = soft.probe("tip").expect("a probe");
    assert!((probe / down - 1.0).abs() < 1e-3, "{probe} against {down}");
    soft.clear();
    soft.advance(1e-3).expect("steps");
    assert!(soft.probe("tip").expect("a probe") > 0.0, "it swings back in half a period of 1.9 ms");
}

#[test]
fn the_mesh_follows() {
    let mut soft = tongue();
    let Drawn { places: rest, normals } = soft.surface(1.0).expect("a surface");
    assert!(soft.triangles().iter().flatten().all(|&node| (node as usize) < rest.len()));
    let top = rest.iter().position(|at| at[2] > 0.00079 && at[0] > 0.01 && at[0] < 0.03).expect("a node");
    assert!(normals[top][2] > 0.5, "outward: {:?}", normals[top]);
    soft.push(TIP, [0.0, 0.0, -0.1]).expect("pushed");
    soft.advance(0.1).expect("steps");
    let once = soft.surface(1.0).expect("a surface").places;
    let twice = soft.surface(2.0).expect("a surface").places;
    let moved =
        |places: &[[f32; 3]]| places.iter().zip(&rest).map(|(a, b)| a[2] - b[2]).fold(0.0_f32, f32::min);
    assert!(moved(&once) < 0.0 && (moved(&twice) / moved(&once) - 2.0).abs() < 1e-3);
}

#[test]
fn what_is_no_file_is_refused() {
    assert!(Soft::new(b"no vademecum".to_vec()).is_err());
    assert!(tongue().probe("toe").is_err());
}
