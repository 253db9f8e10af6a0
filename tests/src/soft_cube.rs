//! A soft cube with a port, for worlds.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;

/// A cube of 40 mm with a frame `pin` on one side, and eight modes.
const CUBE: &str = "[mesh]\nblock = { lengths = [0.04, 0.04, 0.04], divisions = [2, 2, 2], order = \"linear\" }\n\
                    [[material]]\nyoung = 2e5\npoisson = 0.4\ndensity = 1000.0\n[[port]]\nname = \"pin\"\n\
                    kind = \"frame\"\non = { group = \"x_max\" }\naxes = [[1, 0, 0], [0, 0, 1]]\n[damping]\nratio = 0.05\n\
                    [time]\nstep = 1e-3\n[basis]\nmodes = 8\n[tolerance]\nerror = 10.0\n";

/// Bytes of the file of a soft cube that nothing holds.
pub fn soft_cube() -> Vec<u8> {
    let problem = Problem::parse(CUBE, "cube.toml", PathBuf::new()).expect("a problem");
    build(&problem, &BuildOptions::default(), &Silent).expect("a build").either().bytes
}
