//! Files whose indices are out of range, all checksums right: every command refuses them, and none stumbles.

use std::path::Path;

use vademecum_format::{Codec, File, FormatError, SectionKind};
use vademecum_study::contents::Geometry;
use vademecum_tests::program::{fixtures, vademecum};
use vademecum_tests::synthetic::rewritten;

/// The file with one index of a section replaced.
fn changed(bytes: &[u8], kind: SectionKind, place: usize, value: u32) -> Vec<u8> {
    let section = File::parse(bytes).expect("a file").section(kind).expect("the section");
    let mut stored = section.stored().to_vec();
    stored[4 * place..4 * place + 4].copy_from_slice(&value.to_le_bytes());
    rewritten(
        bytes,
        |_| {},
        |section| {
            if section.kind == kind {
                section.stored = &stored
            }
        },
        &[],
    )
}

/// Every golden file with sections of indices, and these kinds.
fn indexed() -> Vec<(String, Vec<u8>, Vec<SectionKind>)> {
    let held = |bytes: &[u8]| -> Vec<SectionKind> {
        let file = File::parse(bytes).expect("a golden file");
        let raw = |&kind: &SectionKind| {
            file.section(kind).is_some_and(|section| section.codec() == Codec::Raw && section.shape()[0] > 0)
        };
        SectionKind::INDICES.into_iter().filter(raw).collect()
    };
    let all = fixtures("golden").into_iter().map(|(name, bytes)| (held(&bytes), name, bytes));
    all.filter(|(kinds, ..)| !kinds.is_empty()).map(|(kinds, name, bytes)| (name, bytes, kinds)).collect()
}

#[test]
fn an_index_out_of_range_is_found_in_every_section_at_every_place() {
    let files = indexed();
    let mut seen: Vec<SectionKind> = files.iter().flat_map(|(.., kinds)| kinds.clone()).collect();
    seen.dedup();
    assert!(seen.contains(&SectionKind::Triangles) && seen.contains(&SectionKind::StressPoints), "{seen:?}");
    for (name, bytes, kinds) in files {
        for kind in kinds {
            let known = File::parse(&bytes).expect(&name).indices(kind).expect("sound").expect("there");
            let count = known.len();
            for place in [0, 1, count / 2, count - 1] {
                // A facet of four nodes stands in a row of eleven numbers: there is no node in the last ones.
                let other = |value: &u32| known[place] != value.to_le_bytes();
                for value in [u32::MAX, 1 << 30].into_iter().filter(other) {
                    let bytes = changed(&bytes, kind, place, value);
                    let file = File::parse(&bytes).expect("only numbers have changed");
                    let refused = file.verify_all();
                    let expected = (kind.number(), place as u64, value);
                    match refused {
                        Err(FormatError::Index { kind, place, found, .. }) => {
                            assert_eq!((kind, place, found), expected, "{name}");
                        }
                        other => panic!("{name}, {kind} {place}: {other:?}"),
                    }
                    // Who reads the surface without asking first is refused too.
                    if kind == SectionKind::Triangles {
                        assert!(Geometry::of(&file).is_err(), "{name}");
                    }
                    if matches!(kind, SectionKind::Triangles | SectionKind::Quadrangles) {
                        assert!(vademecum_eval::Surface::whole(&file).is_err(), "{name}");
                    }
                }
            }
        }
    }
}

#[test]
fn every_command_refuses_a_file_with_an_index_out_of_range() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("s.toml"), "duration = 0.001\n").expect("written");
    let (file, scenario) = (path("a.vdm"), path("s.toml"));
    for (name, bytes, kinds) in indexed() {
        for kind in kinds {
            std::fs::write(&file, changed(&bytes, kind, 0, u32::MAX)).expect("written");
            for arguments in [
                &["info", &file][..],
                &["report", &file, "-o", &path("r.html")],
                &["run", &file, "--scenario", &scenario, "-o", &path("out")],
                &["view", &file, "--export", &path("v.html")],
                &[
                    "frf",
                    &file,
                    "--in",
                    "0,0,0,z",
                    "--out",
                    "0,0,0,z",
                    "--range",
                    "1,100",
                    "-o",
                    &path("f.csv"),
                ],
                &["strip", &file, "--keep", "surface", "-o", &path("b.vdm")],
                &["pack", &file, "-o", &path("c.vdm")],
                &["export", "fmu", &file, "-o", &path("d.fmu")],
                &["verify", &file, "--file-only"],
            ] {
                let ran = vademecum(arguments);
                ran.fails(7, &["a.vdm", &format!("section {}", kind.number()), "4294967295"]);
                assert!(!ran.stderr.contains("panicked"), "{name} {arguments:?}: {}", ran.stderr);
            }
        }
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).expect("the folder").flatten().collect();
    assert_eq!(left.len(), 2, "{left:?}");
    assert!(Path::new(&file).exists());
}
