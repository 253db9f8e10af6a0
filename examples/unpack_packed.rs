//! Opening a compressed file in memory that the program lends.
//!
//! What you learn: how small a file ships, that a program decodes only what it wants, and that it can say
//! beforehand how much memory that takes.

use std::error::Error;
use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::{File, SectionKind, unpack_into, unpacked_len};
use vademecum_eval::{Contact, Field, Loads, Scene, SceneOptions, State, Surface};

fn main() -> Result<(), Box<dyn Error>> {
    let problem = Problem::parse(include_str!("beam.toml"), "beam.toml", PathBuf::new())?;
    let raw = build(&problem, &BuildOptions::default(), &Silent)?.kept()?.bytes;

    // `vademecum pack` does the same. Without loss a file shrinks a little; fields rounded to 1e-4 shrink a
    // lot.
    let exact = vademecum_rewrite::pack(&raw, 19)?;
    let rounded = vademecum_rewrite::pack_within(&raw, 19, 1e-4)?;
    println!(
        "{} bytes as built; packed {}; rounded to 1e-4 and packed {}",
        raw.len(),
        exact.len(),
        rounded.len()
    );

    // This program touches and draws the surface. It wants no displacements inside the body, and nothing that
    // is for people.
    let wanted = |kind: SectionKind| {
        !matches!(kind, SectionKind::InteriorBasis | SectionKind::SingularValues | SectionKind::ModeTable)
    };
    let open = |packed: &[u8]| -> Result<(usize, f64), Box<dyn Error>> {
        // A packed file opens like any other: header, directory and metadata are never compressed. Its
        // sections are.
        let file = File::parse(packed)?;
        let mut memory = vec![0; unpacked_len(&file, wanted)?];
        // Now the sections lie in `memory`, as in a file that was never packed. `packed` may be dropped.
        let file = unpack_into(&file, wanted, &mut memory)?;
        assert!(file.section(SectionKind::InteriorBasis).is_none());
        Ok((file.bytes().len(), push(&file)?))
    };
    let whole = push(&File::parse(&raw)?)?;
    let (memory, from_exact) = open(&exact)?;
    // The same bits went in, so the same bits come out.
    assert_eq!(from_exact, whole);
    let (less, from_rounded) = open(&rounded)?;
    let error = ((from_rounded - whole) / whole).abs();
    assert!(error < 1e-3, "a contact is read from rounded rows: its effect is off by about 1e-4");
    println!("unpacked {memory} and {less} bytes; the tip moves {:.4} mm", 1e3 * whole);
    println!("after rounding it moves {:.4} mm", 1e3 * from_rounded);
    Ok(())
}

/// Pushes the tip for 20 ms with 20 N; where the probe is then, m.
fn push(file: &File<'_>) -> Result<f64, Box<dyn Error>> {
    let options = SceneOptions::default();
    let sizes = Scene::<f64>::sizes(file, &options)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(file, &options, &mut memory, &mut work)?;
    let mut state = State::new(&scene, &mut state_memory)?;
    let mut loads = Loads::new(&scene, &mut load_memory)?;
    let touched = Surface::new(file)?.locate([1.0, 0.05, 0.1]).ok_or("no loadable surface")?;
    let force = [0.0, 0.0, -20.0];
    loads.add_contact(&scene, &Contact::new(touched.place, force))?;
    for _ in 0..20 {
        scene.step(&mut state, &loads)?;
    }
    Ok(scene.probe(&state, 0, Field::Displacement)?)
}
