//! Contacts near each other in files: pairs and blocks as they are checked, kept and shown, and a flexibility
//! between contacts that gives no energy away.

use std::path::Path;

use vademecum_format::{File, SectionInput, SectionKind as S, encode_into, encoded_len};
use vademecum_rewrite::{Fault, Keep, RewriteError, check, default_limit, pack, strip, unpack};
use vademecum_study::soundness::{Soundness, check_file};
use vademecum_study::{FileError, StudyError};
use vademecum_tests::golden;
use vademecum_tests::program::{Ran, vademecum};

const ALL: [S; 4] = [S::ContactModes, S::PatchPairs, S::PatchResidual, S::ContactPatch];

/// A slab on its lower face that is touched from above.
fn slab(divisions: &str, output: &str) -> String {
    format!(
        "[mesh]\nblock = {{ lengths = [0.4, 0.3, 0.05], divisions = {divisions}, order = \"linear\" }}\n\
         [[material]]\nyoung = 2e6\npoisson = 0.3\ndensity = 1000.0\n[[support]]\non = {{ group = \"z_min\" }}\n\
         [load]\nsurface = {{ group = \"z_max\" }}\n[time]\nstep = 1e-4\n[basis]\nmodes = 6\n[output]\n{output}\n"
    )
}

fn run_build(text: &str, folder: &Path) -> Ran {
    let [problem, file] = ["p.toml", "f.vdm"].map(|name| folder.join(name).display().to_string());
    std::fs::write(&problem, text).expect("written");
    vademecum(&["build", &problem, "-o", &file, "--keep-missed"])
}

fn built(text: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = run_build(text, folder.path());
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    std::fs::read(folder.path().join("f.vdm")).expect("a file")
}

/// The file with a section whose bytes are edited.
fn edited(bytes: &[u8], kind: S, edit: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let mut stored = file.section(kind).expect("present").raw().expect("raw").to_vec();
    edit(&mut stored);
    let mut inputs: Vec<SectionInput<'_>> = file.sections().map(SectionInput::from).collect();
    for section in inputs.iter_mut().filter(|section| section.kind == kind) {
        section.stored = &stored;
    }
    encoded(&file, &inputs)
}

/// The number at a place of a section of doubles, changed.
fn number(bytes: &[u8], kind: S, place: usize, edit: impl Fn(f64) -> f64) -> Vec<u8> {
    edited(bytes, kind, |stored| {
        let own: &mut [u8; 8] = (&mut stored[8 * place..8 * place + 8]).try_into().expect("eight bytes");
        *own = edit(f64::from_le_bytes(*own)).to_le_bytes();
    })
}

/// The file without a section.
fn without(bytes: &[u8], kind: S) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let inputs: Vec<SectionInput<'_>> =
        file.sections().filter(|section| section.kind() != kind).map(SectionInput::from).collect();
    encoded(&file, &inputs)
}

/// The file without the last rows of some sections.
fn shorter(bytes: &[u8], kinds: &[S]) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let mut inputs: Vec<SectionInput<'_>> = file.sections().map(SectionInput::from).collect();
    for section in inputs.iter_mut().filter(|section| kinds.contains(&section.kind)) {
        let row = section.stored.len() / section.shape[0] as usize;
        section.stored = &section.stored[..section.stored.len() - row];
        section.shape[0] -= 1;
        section.decoded_length = section.stored.len() as u64;
    }
    encoded(&file, &inputs)
}

fn encoded(file: &File<'_>, inputs: &[SectionInput<'_>]) -> Vec<u8> {
    let mut out = vec![0; encoded_len(file.metadata(), inputs).expect("a length")];
    encode_into(file.metadata(), inputs, &mut out).expect("written");
    out
}

fn fault(bytes: &[u8], kind: S) -> Fault {
    match check(bytes) {
        Err(RewriteError::Unsound { kind: found, fault, .. }) if found == kind => fault,
        other => panic!("{kind}: {other:?}"),
    }
}

fn verdict(bytes: &[u8]) -> Result<Soundness, StudyError> {
    check_file(bytes, default_limit(bytes.len()))
}

/// True if contacts take a negative value together, and nothing else is wrong.
fn gives_away(bytes: &[u8]) -> bool {
    check(bytes).expect("sections that are sound by themselves");
    let refused = verdict(bytes);
    let Err(StudyError::File(FileError::Rewrite(RewriteError::Unsound { kind, fault, .. }))) = refused else {
        return false;
    };
    kind == S::PatchResidual && fault == Fault::Negative
}

#[test]
fn sections_that_contradict_each_other_are_found() {
    let whole = golden::named("patch.vdm");
    assert!(edited(&whole, S::PatchPairs, |_| ()) == whole);
    let swapped = |stored: &mut Vec<u8>| stored[..16].rotate_left(8);
    assert_eq!(fault(&edited(&whole, S::PatchPairs, swapped), S::PatchPairs), Fault::Twice);
    // (0, 1) becomes (1, 0), or (0, 0) once more.
    let turned = |stored: &mut Vec<u8>| stored[8..16].rotate_left(4);
    assert_eq!(fault(&edited(&whole, S::PatchPairs, turned), S::PatchPairs), Fault::Twice);
    let again = |stored: &mut Vec<u8>| stored[12] = 0;
    assert_eq!(fault(&edited(&whole, S::PatchPairs, again), S::PatchPairs), Fault::Twice);
    let past = edited(&whole, S::PatchPairs, |stored| stored[12] = 200);
    assert!(matches!(check(&past), Err(RewriteError::Format(_))));
    // The last pair is that of the last node with itself.
    assert_eq!(fault(&shorter(&whole, &[S::PatchPairs, S::PatchResidual]), S::PatchPairs), Fault::Disagrees);
    assert_eq!(fault(&shorter(&whole, &[S::PatchResidual]), S::PatchPairs), Fault::Disagrees);
    for distance in [0.0, -1.0] {
        assert_eq!(
            fault(&number(&whole, S::ContactPatch, 0, |_| distance), S::ContactPatch),
            Fault::Negative
        );
    }
    let bent = number(&whole, S::PatchResidual, 1, |x| x + 1e-6);
    assert_eq!(fault(&bent, S::PatchResidual), Fault::NotSymmetric);
    let turned = number(&whole, S::PatchResidual, 0, |x| -x);
    assert_eq!(fault(&turned, S::PatchResidual), Fault::Negative);
    let lost = number(&whole, S::ContactModes, 0, |_| f64::NAN);
    assert!(matches!(check(&lost), Err(RewriteError::NotFinite { kind: S::ContactModes, place: 0, .. })));
    for kind in [S::PatchPairs, S::PatchResidual, S::ContactPatch] {
        let there = if kind == S::ContactPatch { S::PatchPairs } else { S::ContactPatch };
        assert_eq!(fault(&without(&whole, kind), there), Fault::Disagrees);
    }
    check(&without(&whole, S::ContactModes)).expect("a patch without further modes");
}

#[test]
fn contacts_that_give_energy_away_are_found() {
    let whole = golden::named("patch.vdm");
    let found = verdict(&whole).expect("sound").patch.expect("a patch");
    assert_eq!((found.contacts, found.groups, found.distance), (6, 1, 8.0));
    assert!(verdict(&golden::named("exact-f64.vdm")).expect("sound").patch.is_none());
    // The second pair is of two nodes: more between them than at each.
    assert!(gives_away(&number(&whole, S::PatchResidual, 9, |x| x + 1.0)));
}

#[test]
fn blocks_are_found_by_pairs_of_nodes() {
    let whole = golden::named("patch.vdm");
    let patch = File::parse(&whole).expect("a file").contact_patch().expect("raw").expect("a patch");
    assert_eq!((patch.n_modes, patch.pairs.len()), (2, 21));
    let (there, back) = (patch.between(1, 4).expect("a pair"), patch.between(4, 1).expect("a pair"));
    assert!(there != back && (0..9).all(|at| there[at] == back[3 * (at % 3) + at / 3]));
    assert_eq!(patch.between(1, 6), None);
}

#[test]
fn a_built_patch_is_sound_shown_packed_and_stripped() {
    let bytes = built(&slab("[8, 6, 2]", "contact_patch = 0.11\ncontact_modes = 9\nprecision = \"f32\""));
    let file = File::parse(&bytes).expect("a file");
    assert_eq!(file.minor(), 13);
    let patch = file.contact_patch().expect("raw").expect("a patch");
    assert_eq!((patch.distance, patch.n_modes), (0.11, 9));
    let found = verdict(&bytes).expect("sound").patch.expect("a patch");
    assert_eq!((found.contacts, found.groups), (63, 1));

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("f.vdm").display().to_string();
    std::fs::write(&path, &bytes).expect("written");
    let info = vademecum(&["info", &path, "--json"]).json();
    let expected = serde_json::json!({ "distance": 0.11, "modes": 9, "pairs": patch.pairs.len() });
    assert_eq!(info["contact_patch"], expected);
    assert_eq!(vademecum(&["verify", &path, "--file-only", "--json"]).json()["patch"]["contacts"], 63);

    let packed = pack(&bytes, 3).expect("packed");
    assert_eq!(unpack(&packed, u64::MAX).expect("unpacked"), bytes);
    assert!(verdict(&packed).expect("sound").patch.is_some());
    let kinds = |bytes: &[u8]| ALL.map(|kind| File::parse(bytes).expect("a file").section(kind).is_some());
    assert_eq!(kinds(&bytes), [true; 4]);
    let surface = strip(&bytes, Keep::Surface).expect("stripped");
    assert_eq!(kinds(&surface), [true; 4]);
    assert_eq!(
        kinds(&built(&slab("[8, 6, 2]", "contact_patch = 0.11\ncontact_modes = 0"))),
        [false, true, true, true]
    );
}

#[test]
fn more_than_a_thousand_contacts_are_tried_in_groups() {
    let bytes = built(&slab("[40, 30, 1]", "contact_patch = 0.025\ncontact_modes = 4"));
    let found = verdict(&bytes).expect("sound").patch.expect("a patch");
    assert_eq!((found.contacts, found.groups), (1271, 2));
    // A fault between two nodes of the second group alone.
    let file = File::parse(&bytes).expect("a file");
    let pairs = file.contact_patch().expect("raw").expect("a patch").pairs;
    let late = |pair: &[[u8; 4]; 2]| {
        let [a, b] = pair.map(u32::from_le_bytes);
        a > 1000 && b > a
    };
    let of_both: Vec<usize> = (0..pairs.len()).filter(|&place| late(&pairs[place])).collect();
    assert!(!of_both.is_empty());
    let largest = file.section(S::PatchResidual).expect("present").numbers().expect("raw");
    let largest = largest.iter().fold(0.0, f64::max);
    let shared = edited(&bytes, S::PatchResidual, |stored| {
        for &place in &of_both {
            stored[72 * place..72 * place + 8].copy_from_slice(&(9.0 * largest).to_le_bytes());
        }
    });
    assert!(gives_away(&shared));
}

#[test]
fn a_patch_that_is_too_large_for_a_file_is_refused_with_the_largest_that_is_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = run_build(&slab("[53, 48, 1]", "contact_patch = 1.0"), folder.path());
    ran.fails(3, &["p.toml:", "`output.contact_patch` is 1", "256 MB", "at most", "load.surface"]);
    assert!(!folder.path().join("f.vdm").exists());
}
