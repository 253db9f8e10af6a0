//! A vademecum of a model that another program has assembled: mass and stiffness come from Matrix Market
//! files.
//!
//! What you learn: which three files a problem needs instead of a mesh, that the model may be anything with a
//! symmetric positive definite mass and stiffness, and how a body without a surface is loaded: at its nodes.
//!
//! The "other program" is the function [`write_chain`]: masses in a row, each tied to the next by a spring,
//! the first to a wall. Its frequencies are known in closed form, so the example checks what comes out.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{Contact, Field, Loads, Place, Scene, SceneOptions, State};

const MASSES: usize = 200;
/// kg
const MASS: f64 = 0.01;
/// N/m
const SPRING: f64 = 4e5;

/// There is no `[[material]]` and no `[[support]]`: both are in the matrices. Only x moves, so only x is
/// pushed.
const PROBLEM: &str = "
title = \"a chain of masses and springs\"
[mesh.matrices]
mass = \"mass.mtx\"
stiffness = \"stiffness.mtx\"
dofs = \"dofs.csv\"
[damping]
alpha = 20.0
[load]
surface = { nodes = [200] }     # forces act on the last mass only; without this line, on any
[time]
scheme.name = \"bathe\"
step = 1e-3
[snapshots]
directions = [[1.0, 0.0, 0.0]]
[basis]
modes = 8
[[output.probe]]
name = \"end\"
point = [200.0, 0.0, 0.0]
direction = [1.0, 0.0, 0.0]
";

/// Writes what a problem needs: two matrices, and a table that says what each of their rows is.
fn write_chain(folder: &Path) -> std::io::Result<()> {
    // Of a symmetric matrix one triangle is enough. Rows count from 1 in these files, and from 0 in the
    // table.
    let head = "%%MatrixMarket matrix coordinate real symmetric\n";
    let mut mass = format!("{head}{MASSES} {MASSES} {MASSES}\n");
    let mut stiffness = format!("{head}{MASSES} {MASSES} {}\n", 2 * MASSES - 1);
    let mut dofs = String::from("row,node,component,x,y,z\n");
    for i in 1..=MASSES {
        // The last mass hangs on one spring, all others on two.
        let springs = if i == MASSES { 1.0 } else { 2.0 };
        let _ = writeln!(mass, "{i} {i} {MASS}");
        let _ = writeln!(stiffness, "{i} {i} {}", springs * SPRING);
        if i > 1 {
            let _ = writeln!(stiffness, "{i} {} {}", i - 1, -SPRING);
        }
        // The components y and z have no row: they are held.
        let _ = writeln!(dofs, "{},{i},x,{i},0,0", i - 1);
    }
    for (name, text) in [("mass.mtx", mass), ("stiffness.mtx", stiffness), ("dofs.csv", dofs)] {
        std::fs::write(folder.join(name), text)?;
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    write_chain(folder.path())?;
    // Paths in a problem start from its folder.
    let problem = Problem::parse(PROBLEM, "chain.toml", folder.path().to_path_buf())?;
    let bytes = build(&problem, &BuildOptions::default(), &Silent)?.kept()?.bytes;
    let file = File::parse(&bytes)?;

    // Frequencies of the reduced body, lowest first, against those of the chain: 2 √(k/m) sin((2j − 1) π /
    // 2(2n + 1)).
    let values = file.section(SectionKind::Eigenvalues).ok_or("no diagonal structure")?.numbers()?;
    let mut found: Vec<f64> = values.iter().map(|value| value.sqrt() / std::f64::consts::TAU).collect();
    found.sort_unstable_by(f64::total_cmp);
    for (j, found) in (1..=3).zip(found) {
        let angle = (2 * j - 1) as f64 * std::f64::consts::PI / (2 * (2 * MASSES + 1)) as f64;
        let exact = 2.0 * (SPRING / MASS).sqrt() * angle.sin() / std::f64::consts::TAU;
        println!("mode {j}: {found:.6} Hz, exact {exact:.6} Hz, relative error {:.0e}", found / exact - 1.0);
    }

    // From here on the body is like any other.
    let options = SceneOptions::default();
    let sizes = Scene::<f64>::sizes(&file, &options)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(&file, &options, &mut memory, &mut work)?;
    let mut state = State::new(&scene, &mut state_memory)?;
    let mut loads = Loads::new(&scene, &mut load_memory)?;

    // Without triangles there is no surface to search. Loadable nodes come first in a file, and here there is
    // one: node 0.
    let pull = Contact::new(Place::triangle([0; 3], [1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
    loads.add_contact(&scene, &pull)?;
    for _ in 0..2000 {
        scene.step(&mut state, &loads)?;
    }
    // Damping has taken the swing by now. What is left is the stretch of n springs one after the other: F n /
    // k. The low modes carry nearly all of it; a force at a single point also stretches the chain in ways
    // that only high modes show.
    let (end, exact) = (scene.probe(&state, 0, Field::Displacement)?, MASSES as f64 / SPRING);
    let share = 100.0 * end / exact;
    println!(
        "the pulled end comes to rest at {:.4} mm, exact {:.4} mm: {share:.1} %",
        1e3 * end,
        1e3 * exact
    );
    Ok(())
}
