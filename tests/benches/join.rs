//! Bodies joined at bind. `cargo bench -p vademecum-tests --bench join` prints the time of binding two bodies
//! of so many modes each, whose 27 rows of a port are welded; the second body is free.

use std::path::PathBuf;

use divan::Bencher;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{Assembly, AssemblyOptions, End, Joint, Part, Pose};
use vademecum_format::File;

fn main() {
    divan::main();
}

/// A block with `modes` modes, held at one end, or free.
fn block(modes: usize, held: bool) -> Vec<u8> {
    let (side, support) = match held {
        true => ("x_max", "[[support]]\non = { group = \"x_min\" }\n"),
        false => ("x_min", ""),
    };
    let text = format!(
        "[mesh]\nblock = {{ lengths = [0.5, 0.05, 0.05], divisions = [10, 2, 2], order = \"linear\" }}\n\
         [[material]]\nyoung = 2e9\npoisson = 0.3\ndensity = 1000.0\n[time]\nstep = 1e-4\n\
         [basis]\nmodes = {modes}\n[output]\nprecision = \"f64\"\n{support}\
         [[port]]\nname = \"end\"\non = {{ group = \"{side}\" }}\n"
    );
    let problem = Problem::parse(&text, "block.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}

/// Binding two bodies with as many coordinates together.
#[divan::bench(args = [32, 64, 128])]
fn bind(bencher: Bencher<'_, '_>, coordinates: usize) {
    let modes = coordinates / 2;
    let (first, second) = (block(modes, true), block(modes - 6, false));
    let [first, second] = [&first, &second].map(|bytes| File::parse(bytes).expect("a file"));
    let place = Pose::new([0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
    let parts = [
        Part::new("a", first, Pose::IDENTITY).expect("a part"),
        Part::new("b", second, place).expect("a part"),
    ];
    let [a, b] = ["a.end", "b.end"].map(|name| End::find(&parts, name).expect("a port"));
    let joints = [Joint::weld(b, a)];
    let options = AssemblyOptions::default();
    let sizes = Assembly::sizes(&parts, &joints, &options).expect("sizes");
    assert_eq!(sizes.coordinates, coordinates);
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let mut bytes = vec![0; sizes.bytes];
    bencher.bench_local(|| {
        let bound = Assembly::bind(&parts, &joints, &options, &mut bytes, &mut memory, &mut work);
        bound.expect("joined").bytes().len()
    });
}
