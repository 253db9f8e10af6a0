//! What the program leaves on the disk and takes from other programs: fields for ParaView, imported
//! snapshots, nothing after Ctrl-C.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use vademecum_build::Matrix;
use vademecum_build::basis::SnapshotSchedule;
use vademecum_build::dynamics::Interval;
use vademecum_build::dynamics::{FullOrder, lowest_modes};
use vademecum_build::dynamics::{TimedLoad, march_full_order};
use vademecum_build::field::{self, Cells, write_npy, write_vtu};
use vademecum_build::input::Problem;
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_format::{File, SectionKind};
use vademecum_tests::program::{command, repository, vademecum};

fn short_beam() -> PathBuf {
    repository().join("fixtures/problems/short-beam.toml")
}

/// Builds a problem into `file`.
fn build(problem: &Path, file: &Path) {
    let built = vademecum(&["build".as_ref(), problem.as_os_str(), "-o".as_ref(), file.as_os_str()]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
}

/// A Python with meshio. Outside CI a machine without Python or without a registry skips; in CI that is a
/// failure.
fn python_with_meshio() -> Option<String> {
    let script = repository().join("tests/scripts/meshio-python");
    let output = Command::new("sh").arg(script).output().expect("a shell");
    if output.status.success() {
        return Some(String::from_utf8(output.stdout).expect("a path").trim().to_string());
    }
    let why = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(std::env::var_os("CI").is_none(), "no Python with meshio: {why}");
    eprintln!("skipped: no Python with meshio: {why}");
    None
}

/// The columns of a CSV table, without its header.
fn rows(table: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(table).expect("a table");
    let number = |cell: &str| cell.parse().expect("a number");
    text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect()
}

#[test]
fn meshio_reads_the_fields_of_a_run() {
    let Some(python) = python_with_meshio() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let (file, output) = (folder.path().join("beam.vdm"), folder.path().join("out"));
    build(&short_beam(), &file);
    for (fields, points) in [("surface", 106), ("body", 117)] {
        let scenario = folder.path().join("scenario.toml");
        let push = std::fs::read_to_string(repository().join("fixtures/scenarios/short-push.toml"))
            .expect("the fixture");
        std::fs::write(&scenario, push + &format!("fields = \"{fields}\"\n")).expect("written");
        let arguments = [
            "run".as_ref(),
            file.as_os_str(),
            "--scenario".as_ref(),
            scenario.as_os_str(),
            "-o".as_ref(),
            output.as_os_str(),
        ];
        let ran = vademecum(&arguments);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let probe = ["1.0", "0.1", "0.1"];
        let script = repository().join("tests/scripts/read-fields.py");
        let read = Command::new(&python)
            .arg(script)
            .arg(output.join("fields.pvd"))
            .args(probe)
            .output()
            .expect("Python");
        assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
        let entries: Vec<Value> = serde_json::from_slice(&read.stdout).expect("JSON");
        compare(&entries, &rows(&output.join("probes.csv")), points);
    }
}

/// Each field against the table's row of its step: the probe `tip` is the z displacement of the node at that
/// point.
fn compare(entries: &[Value], table: &[Vec<f64>], points: usize) {
    assert_eq!(entries.len(), 11);
    let mut moved = 0.0_f64;
    for (i, entry) in entries.iter().enumerate() {
        let row = &table[20 * i];
        assert!((entry["time"].as_f64().expect("a time") - row[0]).abs() < 1e-9);
        assert_eq!(entry["points"], points);
        assert_eq!(entry["cells"], serde_json::json!({ "triangle": 208 }));
        assert!(entry["distance"].as_f64().expect("a distance") < 1e-12);
        let z = entry["displacement"][2].as_f64().expect("a displacement");
        // The table has ten digits.
        assert!((z - row[2]).abs() <= 1e-9 * z.abs(), "{z} in the field, {} in the table", row[2]);
        let velocity = entry["velocity"].as_array().expect("a velocity");
        assert_eq!(velocity.len(), 3);
        moved = moved.max(z.abs());
    }
    assert!(moved > 1e-5, "the push moves the tip");
}

/// The snapshots of the plan over all dofs, as another program would hand them over: shape (3 nodes,
/// snapshots).
fn full_order_snapshots(problem: &Problem) -> (Prepared, Matrix) {
    let mut watch = Stopwatch::new(&Silent);
    let prepared = prepare(problem, &mut watch, &Silent).expect("a model");
    let (body, dt) = (&prepared.body, prepared.step.time_step);
    let pencil = body.model.pencil();
    let period = 1.0 / lowest_modes(pencil, &prepared.symbolic, 1).expect("a mode").frequencies_hz()[0];
    let runs = SnapshotSchedule::plan(&problem.snapshots, body, dt, period);
    let full = FullOrder::new(pencil, &prepared.symbolic, &prepared.scheme, dt, prepared.rayleigh())
        .expect("a march");
    let pushes = runs.nodes.iter().flat_map(|&node| runs.directions.iter().map(move |&d| (node, d)));
    let load = |(column, (node, direction))| {
        let mut force = vec![0.0; body.n_dof()];
        body.model.add_point_force(&[node], &[1.0], direction, &mut force);
        TimedLoad { column, force, when: Interval { start: 0.0, end: runs.hold, ramp: 0.0 }.into() }
    };
    let loads: Vec<TimedLoad> = pushes.enumerate().map(load).collect();
    let mut snapshots = Matrix::zeros(body.model.dofs().n_dof(), loads.len() * (runs.steps / runs.stride));
    let mut next = 0;
    march_full_order(&full, &loads, loads.len(), runs.steps, &Silent, |step, state| {
        if step > 0 && step % runs.stride == 0 {
            for j in 0..loads.len() {
                let free = state.displacement.col_as_slice(j);
                body.model.dofs().expand_into(free, snapshots.col_as_slice_mut(next));
                next += 1;
            }
        }
    })
    .expect("marched");
    drop(full);
    (prepared, snapshots)
}

/// The sections a basis makes, and what follows from it.
fn basis_sections(file: &Path) -> Vec<Vec<u8>> {
    let bytes = std::fs::read(file).expect("a file");
    let parsed = File::parse(&bytes).expect("a file");
    let kinds = [
        SectionKind::SurfaceBasis,
        SectionKind::InteriorBasis,
        SectionKind::Eigenvalues,
        SectionKind::SingularValues,
        SectionKind::BlockState,
    ];
    kinds.map(|kind| parsed.section(kind).expect("present").stored().to_vec()).to_vec()
}

#[test]
fn imported_snapshots_give_the_basis_of_computed_ones() {
    let problem = Problem::read(&short_beam()).expect("the fixture");
    let (prepared, snapshots) = full_order_snapshots(&problem);
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = prepared.body.model.mesh();
    let matrix = field::DenseMatrix {
        rows: snapshots.nrows(),
        columns: snapshots.ncols(),
        data: (0..snapshots.ncols()).flat_map(|j| snapshots.col_as_slice(j).to_vec()).collect(),
    };
    write_npy(&folder.path().join("snapshots.npy"), &matrix).expect("written");
    let mut series = vec![];
    for j in 0..matrix.columns {
        series.push(format!("\"snapshot-{j:04}.vtu\""));
        let cells = Cells::Elements(&mesh.kinds, &mesh.elements);
        let data = [("u", matrix.column(j), 3)];
        write_vtu(&folder.path().join(format!("snapshot-{j:04}.vtu")), &mesh.nodes, cells, &data)
            .expect("written");
    }
    let computed = folder.path().join("computed.vdm");
    build(&short_beam(), &computed);
    let text = std::fs::read_to_string(short_beam()).expect("the fixture");
    let sources =
        ["npy = \"snapshots.npy\"".to_string(), format!("field = \"u\"\nvtu = [{}]", series.join(", "))];
    for (i, source) in sources.iter().enumerate() {
        let (path, file) =
            (folder.path().join("imported.toml"), folder.path().join(format!("imported-{i}.vdm")));
        std::fs::write(&path, text.replace("[snapshots]", &format!("[snapshots]\n{source}")))
            .expect("written");
        build(&path, &file);
        // The same numbers in the same order: not near, the same bits.
        assert!(basis_sections(&file) == basis_sections(&computed), "{}", &source[..10]);
    }
}

#[test]
fn snapshots_of_another_mesh_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let matrix = field::DenseMatrix { rows: 12, columns: 1, data: vec![1.0; 12] };
    write_npy(&folder.path().join("snapshots.npy"), &matrix).expect("written");
    let text = std::fs::read_to_string(short_beam()).expect("the fixture");
    let path = folder.path().join("imported.toml");
    std::fs::write(&path, text.replace("[snapshots]", "[snapshots]\nnpy = \"snapshots.npy\""))
        .expect("written");
    let output = folder.path().join("none.vdm");
    let refused = vademecum(&["build".as_ref(), path.as_os_str(), "-o".as_ref(), output.as_os_str()]);
    refused.fails(3, &["snapshots.npy", "12 rows", "351"]);
}

#[cfg(unix)]
#[test]
fn verify_measures_a_rounded_file_by_the_fields_it_shows() {
    const TOLERANCE: f64 = 1e-3;
    let folder = tempfile::tempdir().expect("a folder");
    let [file, packed] = ["b.vdm", "p.vdm"].map(|name| folder.path().join(name));
    build(&short_beam(), &file);
    let path = |p: &Path| p.display().to_string();
    let ran =
        vademecum(&["pack", &*path(&file), "-o", &path(&packed), "--tolerance", &TOLERANCE.to_string()]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let scenario = path(&repository().join("fixtures/scenarios/short-push.toml"));
    let verified = |file: &Path| -> [f64; 2] {
        let problem = path(&short_beam());
        let arguments = ["verify", &*path(file), "--problem", &problem, "--scenario", &scenario, "--json"];
        let report = vademecum(&arguments).json();
        ["trajectory_error", "projection_floor"].map(|key| report[key].as_f64().expect("a number"))
    };
    let ([built, _], [rounded, floor]) = (verified(&file), verified(&packed));
    // Fields are off by the tolerance at most, once for the basis and once for the load rows.
    assert!(rounded <= built + 2.0 * TOLERANCE, "{rounded}, as built {built}");
    assert!(floor <= rounded && rounded > built, "{floor}, {rounded}, as built {built}");
}

#[test]
fn ctrl_c_in_a_build_leaves_nothing_behind() {
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;
    // Long enough to be caught in the snapshots whatever the machine: forty times the demo's plan.
    let text =
        std::fs::read_to_string(repository().join("fixtures/problems/cantilever.toml")).expect("the fixture");
    let folder = tempfile::tempdir().expect("a folder");
    let problem = folder.path().join("long.toml");
    let marched = text.replace("modes = 16", "modes = 16\nkind = \"ritz\"");
    assert_ne!(marched, text);
    std::fs::write(&problem, marched + "\n[snapshots]\npositions = 480\n").expect("written");
    let mut command = Command::new(command::<&str>(&[]).get_program());
    command.arg("build").arg(&problem).arg("-o").arg(folder.path().join("long.vdm"));
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.contains("snapshots")), "the build reaches the snapshots");
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(killed.success());
    let said: Vec<String> = lines.collect();
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{said:?}");
    assert!(said.iter().any(|line| line.contains("stopped on request")), "{said:?}");
    let left: Vec<_> = std::fs::read_dir(folder.path())
        .expect("a folder")
        .map(|e| e.expect("an entry").file_name())
        .collect();
    assert_eq!(left, ["long.toml"]);
}
