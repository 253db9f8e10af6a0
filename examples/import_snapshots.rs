//! A basis from the snapshots of another program.
//!
//! What you learn: in which shape and order snapshots are handed over, and how good a basis of them is: the
//! build measures it at loads that no snapshot has seen, and says so.
//!
//! The "other program" is beam theory: the bending shapes of a cantilever, evaluated at the nodes of the
//! solid's mesh. A real one would write the displacements it has computed; `numpy.save` writes the same
//! files.

use std::error::Error;
use std::path::PathBuf;

use vademecum_build::field::{DenseMatrix, write_npy};
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::read_mesh;
use vademecum_build::progress::Silent;
use vademecum_build::report::BuildReport;

/// Roots of `cos β cosh β = −1`: the bending shapes of a beam of length 1 that is clamped at 0 and free at 1.
const ROOTS: [f64; 3] = [1.875_104_068_711_961, 4.694_091_132_974_175, 7.854_757_438_237_613];

/// Deflection and slope at `x` of the shape of a root.
fn shape(root: f64, x: f64) -> [f64; 2] {
    let share = (root.cosh() + root.cos()) / (root.sinh() + root.sin());
    let (b, c) = (root * x, root * x);
    let deflection = b.cosh() - b.cos() - share * (b.sinh() - b.sin());
    let slope = root * (c.sinh() + c.sin() - share * (c.cosh() - c.cos()));
    [deflection, slope]
}

/// Displacements of all nodes, x y z of each, when the beam bends up (`axis` 2) or sideways (`axis` 1).
fn snapshot(nodes: &[[f64; 3]], root: f64, axis: usize) -> Vec<f64> {
    let displacement = |node: &[f64; 3]| {
        let [deflection, slope] = shape(root, node[0]);
        let mut u = [0.0; 3];
        // Cross-sections stay flat and turn: what lies off the middle line moves along the beam.
        u[0] = -(node[axis] - 0.05) * slope;
        u[axis] = deflection;
        u
    };
    nodes.iter().flat_map(displacement).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let text = include_str!("beam.toml");
    let own = Problem::parse(text, "beam.toml", PathBuf::new())?;

    // One column per snapshot, one row per component of each node, in the order of the mesh file.
    let nodes = read_mesh(&own)?.nodes;
    let columns = ROOTS.iter().flat_map(|&root| [1, 2].map(|axis| snapshot(&nodes, root, axis)));
    let data: Vec<f64> = columns.flatten().collect();
    let (rows, columns) = (3 * nodes.len(), 2 * ROOTS.len());
    write_npy(&folder.path().join("snapshots.npy"), &DenseMatrix { rows, columns, data })?;

    // One line in the problem file replaces all full-order runs for the basis.
    let text = text.replace("[snapshots]", "[snapshots]\nnpy = \"snapshots.npy\"");
    let imported = Problem::parse(&text, "beam.toml", folder.path().to_path_buf())?;
    println!("basis of              modes  first frequency  error at unseen loads");
    for (name, problem) in [("its own 12 runs", own), ("beam theory", imported)] {
        let report = build(&problem, &BuildOptions::default(), &Silent)?.kept()?.report;
        println!("{}", line(name, &report));
    }
    Ok(())
}

/// The error is that of the best structure; it cannot be below the floor, which is what the basis allows.
fn line(name: &str, report: &BuildReport) -> String {
    let certificate = &report.certificate;
    let errors = certificate.diagonal.iter().chain(&certificate.block).map(|s| s.trajectory_error);
    let first = report.mode_table.iter().map(|mode| mode.frequency_hz).fold(f64::INFINITY, f64::min);
    let error = errors.fold(f64::INFINITY, f64::min);
    format!("{name:<20}  {:>5}  {first:>12.3} Hz  {error:>21.1e}", report.modes)
}
