//! Damaged matrices and tables of another program are refused or read, but never panic, hang or eat memory.

use std::path::Path;

use proptest::prelude::*;
use vademecum_build::input::Problem;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};

/// Two masses on springs, and a triangle of three nodes, one of them held.
const FILES: [(&str, &str); 5] = [
    ("m.mtx", "%%MatrixMarket matrix coordinate integer symmetric\n% masses\n2 2 2\n1 1 1\n2 2 1\n"),
    ("k.mtx", "%%MatrixMarket matrix coordinate real general\n2 2 4\n1 1 2\n1 2 -1e0\n2 1 -1.0\n2 2 2\n"),
    ("d.csv", "row,node,component,x,y,z\n0,1,x,0,0,0\n1,2,x,1,0,0\n"),
    ("n.csv", "node,x,y,z\n1,0,0,0\n2,1,0,0\n3,0,1,0\n"),
    ("t.csv", "a,b,c\n1,2,3\n"),
];

const PROBLEM: &str = "[mesh.matrices]\nmass = \"m.mtx\"\nstiffness = \"k.mtx\"\ndofs = \"d.csv\"\n\
                       nodes = \"n.csv\"\ntriangles = \"t.csv\"\n\
                       [load]\n[[load.pattern]]\nname = \"g\"\nacceleration = [1, 2, 3]\n\
                       [time]\nscheme.name = \"bathe\"\nstep = 1e-3\n";

fn write_all(folder: &Path) {
    for (name, text) in FILES {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

fn problem(folder: &Path) -> Problem {
    Problem::parse(PROBLEM, "problem.toml", folder.to_path_buf()).unwrap()
}

#[test]
fn the_undamaged_files_are_two_masses() {
    let folder = tempfile::tempdir().unwrap();
    write_all(folder.path());
    let prepared = prepare(&problem(folder.path()), &mut Stopwatch::new(&Silent), &Silent).unwrap();
    let body = &prepared.body;
    assert_eq!((body.n_dof(), body.surface.as_slice()), (2, &[[0, 1, 2]][..]));
    assert_eq!(body.model.pencil().stiffness().values(), [2.0, -1.0, -1.0, 2.0]);
}

/// Bytes that make the most of a text format: digits, signs, separators, line ends.
fn byte() -> impl Strategy<Value = u8> {
    prop_oneof![
        4 => prop::sample::select(b"0123456789-+.eE, \n%#".to_vec()),
        1 => any::<u8>(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_text_never_panics(
        which in 0..FILES.len(),
        flips in prop::collection::vec((any::<usize>(), byte()), 0..6),
        keep in any::<usize>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let problem = problem(folder.path());
        let (name, text) = FILES[which];
        for keep in [keep % (text.len() + 1), text.len()] {
            write_all(folder.path());
            let mut bytes = text.as_bytes().to_vec();
            flips.iter().for_each(|&(place, value)| bytes[place % text.len()] = value);
            bytes.truncate(keep);
            std::fs::write(folder.path().join(name), bytes).unwrap();
            // Either answer will do; arriving at one is the test, and a model must be whole.
            if let Ok(prepared) = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent) {
                prop_assert_eq!(prepared.body.patterns[0].1.len(), prepared.body.n_dof());
            }
        }
    }
}

#[test]
fn counts_that_no_file_can_hold_are_refused_before_anything_is_allocated() {
    let folder = tempfile::tempdir().unwrap();
    for count in ["4000000000", "18446744073709551615", "99999999999999999999"] {
        write_all(folder.path());
        let text =
            format!("%%MatrixMarket matrix coordinate real symmetric\n{count} {count} {count}\n1 1 1\n");
        std::fs::write(folder.path().join("m.mtx"), text).unwrap();
        let error = prepare(&problem(folder.path()), &mut Stopwatch::new(&Silent), &Silent).err().unwrap();
        let cause = std::error::Error::source(&error).unwrap().to_string();
        assert!(cause.contains("m.mtx, line 2, in the header: found"), "{cause}");
    }
}
