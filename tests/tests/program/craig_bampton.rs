//! `vademecum export craig-bampton` end to end: the files hold one superelement, digit for digit, and what
//! cannot be is refused.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;
use vademecum_build::Matrix;
use vademecum_build::field::read_npy;
use vademecum_build::linalg::symmetric_eigen;
use vademecum_tests::program::{Ran, repository, vademecum};

const ROD: &str = "tests/multibody/rod.toml";

fn export(folder: &Path, rest: &[&str]) -> Ran {
    let rod = repository().join(ROD);
    let [rod, output] = [&*rod, folder].map(|path| path.to_str().expect("UTF-8"));
    vademecum(&[&["export", "craig-bampton", rod, "-o", output], rest].concat())
}

fn exported(folder: &Path, rest: &[&str]) -> String {
    let ran = export(folder, rest);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    ran.stdout
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("a file")
}

/// A matrix of Matrix Market's dense form.
fn market(folder: &Path, name: &str) -> Matrix {
    let text = text(folder, name);
    let mut lines = text.lines();
    let symmetric = match lines.next() {
        Some("%%MatrixMarket matrix array real symmetric") => true,
        Some("%%MatrixMarket matrix array real general") => false,
        other => panic!("{name}: {other:?}"),
    };
    let sizes: Vec<usize> =
        lines.next().expect("sizes").split(' ').map(|word| word.parse().expect("a size")).collect();
    let mut matrix = Matrix::zeros(sizes[0], sizes[1]);
    let mut values = lines.map(|line| line.parse::<f64>().expect("a number"));
    for j in 0..sizes[1] {
        for i in if symmetric { j } else { 0 }..sizes[0] {
            matrix[(i, j)] = values.next().expect("a value");
            if symmetric {
                matrix[(j, i)] = matrix[(i, j)];
            }
        }
    }
    assert_eq!(values.next(), None);
    matrix
}

/// The entries of an archive that stores them as they are: name and bytes.
fn archive(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let bytes = std::fs::read(folder.join("superelement.npz")).expect("an archive");
    let number = |at: usize, width: usize| -> usize {
        bytes[at..at + width].iter().rev().fold(0, |sum, byte| 256 * sum + usize::from(*byte))
    };
    // The directory is at the end: its number of entries and its place.
    let end = bytes.windows(4).rposition(|window| window == b"PK\x05\x06").expect("an end");
    let (count, mut at) = (number(end + 10, 2), number(end + 16, 4));
    let mut entries = BTreeMap::new();
    for _ in 0..count {
        let (size, name, extra, comment) =
            (number(at + 24, 4), number(at + 28, 2), number(at + 30, 2), number(at + 32, 2));
        let local = number(at + 42, 4);
        let text = String::from_utf8(bytes[at + 46..at + 46 + name].to_vec()).expect("a name");
        let start = local + 30 + number(local + 26, 2) + number(local + 28, 2);
        entries.insert(text, bytes[start..start + size].to_vec());
        at += 46 + name + extra + comment;
    }
    entries
}

/// A matrix of the archive.
fn array(folder: &Path, name: &str) -> Matrix {
    let bytes = &archive(folder)[&format!("{name}.npy")];
    let path = folder.join("one.npy");
    std::fs::write(&path, bytes).expect("written");
    let read = read_npy(&path).expect("an array");
    Matrix::from_fn(read.rows, read.columns, |i, j| read.column(j)[i])
}

/// DMIG entries of Nastran as a matrix over the points of its rows, by the rules of fields of 16 characters.
fn dmig(text: &str, name: &str, rows: &[(u64, u64)]) -> Matrix {
    let place: BTreeMap<(u64, u64), usize> = rows.iter().copied().zip(0..).collect();
    let fields = |line: &str| -> Vec<String> {
        let padded = format!("{line:<72}");
        (0..4).map(|k| padded[8 + 16 * k..24 + 16 * k].trim().to_string()).collect()
    };
    let whole = |field: &str| field.parse::<u64>().expect("a whole number");
    let mut matrix = Matrix::zeros(rows.len(), rows.len());
    let mut column = None;
    for line in text.lines() {
        assert!(line.len() <= 72, "{line}");
        if line.starts_with("DMIG*") {
            let head = fields(line);
            column = (head[0] == name).then(|| place[&(whole(&head[1]), whole(&head[2]))]);
        } else if let (Some(column), true) = (column, line.starts_with('*')) {
            let entry = fields(line);
            let row = place[&(whole(&entry[0]), whole(&entry[1]))];
            let value: f64 = entry[2].replace('D', "E").parse().expect("a number");
            matrix[(row, column)] = value;
            matrix[(column, row)] = value;
        } else {
            column = None;
        }
    }
    matrix
}

/// Points and components of the rows of the punch file, from the description.
fn rows(described: &Value) -> Vec<(u64, u64)> {
    let coordinates = described["coordinates"].as_array().expect("a list");
    let motions = ["x", "y", "z", "rx", "ry", "rz"];
    let interfaces = described["interfaces"].as_array().expect("a list");
    let mut next = described["nodes"].as_u64().expect("a number");
    let frames: Vec<u64> = interfaces
        .iter()
        .map(|one| {
            next += u64::from(one["kind"] != "patch" && one["kind"] != "nodes");
            next
        })
        .collect();
    let row = |coordinate: &Value| {
        let motion = motions.iter().position(|word| coordinate["motion"] == *word).expect("a motion");
        let frame = frames[coordinate["interface"].as_u64().expect("a place") as usize];
        (coordinate["node"].as_u64().unwrap_or(frame), motion as u64 + 1)
    };
    let size = described["size"].as_u64().expect("a number") as usize;
    let scalars = (next + 1..).map(|point| (point, 0));
    coordinates.iter().map(row).chain(scalars.take(size - coordinates.len())).collect()
}

fn off(a: &Matrix, b: &Matrix) -> f64 {
    (a - b).norm_max() / b.norm_max()
}

#[test]
fn all_files_hold_the_same_superelement() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let sides = ["--interface", "x_min=rigid", "--interface", "x_max", "--modes", "5"];
    exported(at, &[&sides[..], &["--format", "market,npz,dmig"]].concat());
    let described: Value = serde_json::from_str(&text(at, "superelement.json")).expect("JSON");
    let size = described["size"].as_u64().expect("a number") as usize;
    // Six motions, nine nodes, five modes.
    assert_eq!((size, &described["interface_size"]), (6 + 27 + 5, &Value::from(33)));
    assert_eq!(described["interfaces"][0]["nodes"].as_array().map(Vec::len), Some(9));
    let punch = text(at, "superelement.pch");
    let rows = rows(&described);
    for (file, name, entry) in [
        ("mass.mtx", "mass", "MAAX"),
        ("stiffness.mtx", "stiffness", "KAAX"),
        ("damping.mtx", "damping", "BAAX"),
    ] {
        let matrix = market(at, file);
        assert_eq!(matrix, array(at, name), "{file}");
        if matrix.norm_max() > 0.0 {
            // Ten digits.
            let error = off(&dmig(&punch, entry, &rows), &matrix);
            assert!(error < 1e-9, "{entry}: {error:e}");
        }
    }
    let transformation = market(at, "transformation.mtx");
    assert_eq!(transformation, array(at, "transformation"));
    assert_eq!(transformation.nrows(), 3 * described["nodes"].as_u64().expect("a number") as usize);
    let motions = array(at, "rigid_motions");
    let work = market(at, "stiffness.mtx") * &motions;
    assert!(work.norm_max() < 1e-9 * market(at, "stiffness.mtx").norm_max());
    // Every grid point of the punch file is there once, and the frame has its place.
    let grids = punch.lines().filter(|line| line.starts_with("GRID*")).count();
    assert_eq!(grids, 10);
    // The same command gives the same bytes.
    let again = tempfile::tempdir().expect("a folder");
    exported(again.path(), &[&sides[..], &["--format", "npz"]].concat());
    let bytes = |folder: &Path| std::fs::read(folder.join("superelement.npz")).expect("an archive");
    let (first, second) = (bytes(at), bytes(again.path()));
    assert_eq!(first, second);
}

#[test]
fn frequencies_of_the_reduced_rod_are_those_of_the_rod() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let rod = repository().join(ROD);
    let ran = vademecum(&["modes", rod.to_str().expect("UTF-8"), "--count", "4", "--json"]);
    let modes: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    let full: Vec<f64> = modes["frequencies_hz"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|f| f.as_f64().expect("a number"))
        .collect();
    // Craig–Bampton from above; the two others have the modes themselves.
    for (method, most) in [("craig-bampton", 1e-3), ("rubin", 1e-8), ("herting", 1e-8)] {
        let sides = ["--interface", "x_min=average", "--interface", "x_max=average", "--modes", "24"];
        exported(at, &[&sides[..], &["--method", method]].concat());
        let (mass, stiffness) = (market(at, "mass.mtx"), market(at, "stiffness.mtx"));
        let (values, axes) = symmetric_eigen(mass.as_ref()).expect("converged");
        let unit = Matrix::from_fn(values.len(), values.len(), |i, k| axes[(i, k)] / values[k].sqrt());
        let reduced = unit.transpose() * stiffness * &unit;
        let values = symmetric_eigen(reduced.as_ref()).expect("converged").0;
        for (mode, full) in full.iter().enumerate() {
            let found = values[6 + mode].sqrt() / std::f64::consts::TAU;
            let off = found / full - 1.0;
            assert!((-1e-8..most).contains(&off), "{method}, mode {mode}: {found} Hz for {full} Hz");
        }
    }
}

/// The rod with ports, and how it is built.
const PORTS: &str = "[basis]\nmodes = 8\n[load]\nsurface = { group = \"z_max\" }\n\
    [[port]]\nname = \"tip\"\non = { group = \"x_max\" }\n\
    [[port]]\nname = \"pin\"\nkind = \"frame\"\non = { group = \"x_min\" }\n";

#[test]
fn a_file_at_its_ports_is_the_superelement_of_its_problem() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_string();
    std::fs::write(at("rod.toml"), text(&repository(), ROD) + PORTS).expect("written");
    let built = vademecum(&["build", &at("rod.toml"), "-o", &at("rod.vdm"), "--keep-missed"]);
    assert!(matches!(built.code, Some(0 | 6)), "{}", built.stderr);
    let export = |of: &str, to: &str, rest: &[&str]| {
        let ran = vademecum(&[&["export", "craig-bampton", &at(of), "-o", &at(to)], rest].concat());
        assert_eq!(ran.code, Some(0), "{rest:?}: {}", ran.stderr);
        let folder = Path::new(&at(to)).to_path_buf();
        (market(&folder, "mass.mtx"), market(&folder, "stiffness.mtx"), array(&folder, "rigid_motions"))
    };
    for (method, modes) in [("rubin", "8"), ("macneal", "8"), ("rubin", "5")] {
        let rest = ["--method", method, "--modes", modes];
        let of_problem = export("rod.toml", "problem", &rest);
        let (mass, stiffness, motions) = export("rod.vdm", "file", &rest);
        // Coordinates of the ports; rigid motions and modes may have other signs.
        let m = 27 + 6;
        let part = |matrix: &Matrix| matrix.as_ref().submatrix(0, 0, m, m).to_owned();
        for (name, found, expected) in
            [("mass", &mass, &of_problem.0), ("stiffness", &stiffness, &of_problem.1)]
        {
            assert_eq!(found.nrows(), m + 6 + modes.parse::<usize>().expect("a number"));
            if expected.as_ref().submatrix(0, 0, m, m).norm_max() > 0.0 {
                // Modes of both are off by a residual of 5e-9.
                let error = off(&part(found), &part(expected));
                assert!(error < 1e-6, "{method}, {modes} modes, {name}: {error:e}");
            }
        }
        let work = &stiffness * &motions;
        assert!(work.norm_max() < 1e-9 * stiffness.norm_max() * motions.norm_max(), "{method}");
        // The rod weighs 0.6 · 0.03 · 0.02 · 2 700 kg; MacNeal's matrix has it in its modes.
        let inertia = motions.transpose() * &mass * &motions;
        assert!((inertia[(0, 0)] / 0.972 - 1.0).abs() < 1e-6, "{method}: {}", inertia[(0, 0)]);
        let shapes = array(&folder.path().join("file"), "transformation");
        let moved = &shapes * &motions;
        // A shift along x moves every node of the surface by it.
        let nodes = shapes.nrows() / 3;
        assert!(nodes > 100 && (0..nodes).all(|node| (moved[(3 * node, 0)] - 1.0).abs() < 1e-6), "{method}");
    }
    let refused = |rest: &[&str], words: &str| {
        let ran =
            vademecum(&[&["export", "craig-bampton", &at("rod.vdm"), "-o", &at("none")], rest].concat());
        assert_eq!(ran.code, Some(2), "{rest:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(words), "{rest:?}: {}", ran.stderr);
        assert!(!Path::new(&at("none")).exists());
    };
    refused(&["--method", "craig-bampton"], "no modes with fixed interfaces; expected rubin or macneal");
    refused(&["--method", "herting"], "no modes with fixed interfaces");
    refused(&["--interface", "hub"], "there are `tip`, `pin`");
    refused(&["--interface", "tip=rigid"], "a file has no interfaces but its ports");
    refused(&["--modes", "9"], "the file has 8 modes");
    refused(&["--format", "exudyn"], "expected the problem file");
    let bare = repository().join("fixtures/golden/free.vdm");
    let ran = vademecum(&["export", "craig-bampton", bare.to_str().expect("UTF-8"), "-o", &at("none")]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert!(ran.stderr.contains("the file has no ports"), "{}", ran.stderr);
}

#[test]
fn matrices_for_chrono_are_the_body_over_its_boundary_and_its_inside() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    exported(
        at,
        &["--interface", "x_min=rigid", "--interface", "x_max", "--modes", "3", "--format", "chrono,npz"],
    );
    let table = text(at, "chrono_boundary.csv");
    let kinds: Vec<&str> =
        table.lines().skip(1).map(|line| line.split(',').next().expect("a kind")).collect();
    assert_eq!((kinds[0], kinds.len()), ("frame", 10));
    assert!(kinds[1..].iter().all(|kind| *kind == "node"));
    let read = |name: &str| -> Vec<(usize, usize, f64)> {
        let text = text(at, name);
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("%%MatrixMarket matrix coordinate real symmetric"));
        lines.next().expect("sizes");
        let entry = |line: &str| {
            let words: Vec<&str> = line.split(' ').collect();
            let index = |k: usize| words[k].parse::<usize>().expect("an index") - 1;
            (index(0), index(1), words[2].parse().expect("a number"))
        };
        lines.map(entry).collect()
    };
    let (mass, stiffness) = (read("chrono_mass.mtx"), read("chrono_stiffness.mtx"));
    // A shift along x: of the frame, of the nine nodes of the patch, and of the nodes inside.
    let n = 1 + mass.iter().map(|entry| entry.0).max().expect("entries");
    let m = 6 + 27;
    let shift = |row: usize| match row {
        0..6 => f64::from(u8::from(row == 0)),
        _ => f64::from(u8::from((row - 6).is_multiple_of(3))),
    };
    assert_eq!((n - m) % 3, 0);
    let times = |entries: &[(usize, usize, f64)]| {
        let mut image = vec![0.0; n];
        for &(row, column, value) in entries {
            image[row] += value * shift(column);
            if row != column {
                image[column] += value * shift(row);
            }
        }
        image
    };
    let weight: f64 = times(&mass).iter().enumerate().map(|(row, x)| x * shift(row)).sum();
    assert!((weight / 0.972 - 1.0).abs() < 1e-10, "{weight}");
    let largest = stiffness.iter().map(|entry| entry.2.abs()).fold(0.0, f64::max);
    assert!(times(&stiffness).iter().all(|x| x.abs() < 1e-9 * largest));
    for (interface, words) in [
        ("x_min=average", "`x_min` of kind average"),
        (
            "a={ kind = \"rigid\", on = { group = \"x_min\" }, axes = [[0, 1, 0], [0, 0, 1]] }",
            "`a` with axes of its own",
        ),
    ] {
        let ran = export(&at.join("none"), &["--interface", interface, "--format", "chrono"]);
        assert_eq!(ran.code, Some(2), "{}", ran.stderr);
        assert!(ran.stderr.contains(words), "{}", ran.stderr);
    }
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path().join("out");
    for (rest, code, words) in [
        (vec![], 2, "no interface"),
        (vec!["--interface", "left"], 2, "there are `body`, `x_max`, `x_min`"),
        (vec!["--interface", "x_min=soft"], 2, "expected patch, nodes, rigid or average"),
        (vec!["--interface", "x_min", "--interface", "z_max"], 2, "in common"),
        (vec!["--interface", "x_min", "--method", "guyan"], 2, "is not one of craig-bampton, rubin"),
        (
            vec!["--interface", "x_min", "--format", "abaqus"],
            2,
            "is not one of market, npz, dmig, exudyn, chrono",
        ),
        (vec!["--interface", "a={ kind = \"nodes\", on = { nodes = [1] } }"], 2, "leave 3 of the 6"),
        (vec!["--interface", "x_min", "--modes", "60000"], 2, "60000 modes asked for"),
        (vec!["--interface", "x_min", "--memory", "1K"], 1, "of memory"),
    ] {
        let ran = export(&at, &rest);
        assert_eq!(ran.code, Some(code), "{rest:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(words), "{rest:?}: {}", ran.stderr);
        assert!(!at.exists(), "{rest:?}");
    }
    // A body with supports has no floating frame.
    let held = folder.path().join("held.toml");
    let support = "[[support]]\non = { group = \"x_min\" }\n";
    std::fs::write(&held, text(&repository(), ROD) + support).expect("written");
    let [held, out] = [&*held, &*at].map(|path| path.to_str().expect("UTF-8"));
    let rest = ["--interface", "x_max=average", "--format", "exudyn", "-o", out];
    let ran = vademecum(&[&["export", "craig-bampton", held], &rest[..]].concat());
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert!(ran.stderr.contains("expected the problem file of a free body"), "{}", ran.stderr);
    assert!(!at.exists());
}
