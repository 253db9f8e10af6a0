//! The residual flexibility and its bound in files: there by default and shown by `info`, checked, kept by
//! `strip` where it is of use, and of no weight to a program that does not read it.

use std::path::Path;
use std::sync::OnceLock;

use vademecum_eval::{Contact, Field, Place, SceneOptions, StructureChoice};
use vademecum_format::{Element, File, FormatError, SectionKind as S};
use vademecum_rewrite::{Fault, Keep, RewriteError, check, pack, strip, unpack};
use vademecum_tests::needed_minor;
use vademecum_tests::program::{Ran, repository, vademecum};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::rewritten;

/// All kinds of the residual.
const ALL: [S; 8] = [
    S::ContactResidual,
    S::ResidualPairs,
    S::PairResidual,
    S::ProbeResidual,
    S::PatternResidual,
    S::PatternProbeResidual,
    S::StaticBound,
    S::BoundMap,
];

fn short_beam() -> String {
    std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml")).expect("the fixture")
}

/// Builds a problem in a folder of its own and hands over its file.
fn built(text: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = run_build(text, folder.path());
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    std::fs::read(folder.path().join("f.vdm")).expect("a file")
}

fn run_build(text: &str, folder: &Path) -> Ran {
    let [problem, file] = ["p.toml", "f.vdm"].map(|name| folder.join(name).display().to_string());
    std::fs::write(&problem, text).expect("written");
    vademecum(&["build", &problem, "-o", &file, "--keep-missed"])
}

/// The short beam with its residual.
fn with() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| built(&with_output("residual = true")))
}

/// The short beam without a residual.
fn without() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| built(&with_output("residual = false")))
}

/// The short beam with a line in its `[output]`.
fn with_output(line: &str) -> String {
    let text = short_beam().replace("[[output.probe]]", &format!("[output]\n{line}\n[[output.probe]]"));
    assert!(text.contains(line));
    text
}

fn present(bytes: &[u8]) -> Vec<S> {
    let file = File::parse(bytes).expect("a file");
    ALL.into_iter().filter(|&kind| file.section(kind).is_some()).collect()
}

fn info(bytes: &[u8], arguments: &[&str]) -> Ran {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("f.vdm");
    std::fs::write(&file, bytes).expect("written");
    vademecum(&[&["info", &file.display().to_string()], arguments].concat())
}

#[test]
fn a_build_keeps_the_residual_unless_it_is_told_not_to() {
    assert_eq!(present(with()), ALL);
    assert_eq!(present(without()), []);
    assert_eq!([with(), without()].map(|bytes| needed_minor(&File::parse(bytes).expect("a file"))), [3, 2]);
    check(with()).expect("sound");
    check(without()).expect("sound");
    let single = built(&with_output("residual = true\nprecision = \"f32\""));
    check(&single).expect("sound");
    let file = File::parse(&single).expect("a file");
    assert_eq!(file.section(S::ContactResidual).expect("present").element(), Element::F32);
    // POD vectors have no diagonal structure.
    assert_eq!(present(&built(&short_beam().replace("modes = 4", "modes = 4\nkind = \"pod\""))), []);
}

#[test]
fn a_file_steps_to_the_same_bits_with_and_without() {
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        let bits = |bytes: &[u8]| -> Vec<u64> {
            // Modes alone: outputs add the residual otherwise.
            let options = SceneOptions { structure, residual: false, ..SceneOptions::default() };
            with_scene::<f64, _>(bytes, &options, |scene, state, loads| {
                let contact = Contact::new(Place::triangle([3, 7, 11], [0.5, 0.25, 0.25]), [1.0, -3.0, 2.0]);
                loads.add_contact(scene, &contact).expect("a contact");
                loads.add_pattern(scene, 0, 1.0).expect("a pattern");
                let mut bits = vec![];
                for _ in 0..100 {
                    scene.step(state, loads).expect("a step");
                    bits.push(scene.probe(state, 0, Field::Displacement).expect("a probe").to_bits());
                }
                bits
            })
        };
        let stepped = bits(with());
        assert!(f64::from_bits(stepped[99]).abs() > 0.0);
        assert!(stepped == bits(without()), "{structure:?}");
    }
}

#[test]
fn info_tells_the_bound() {
    let ran = info(with(), &["--json"]).json();
    let bound = &ran["certificate"]["bound"];
    let number = |key: &str| bound[key].as_f64().expect("a number");
    assert!(0.0 < number("median") && number("median") <= number("p95"));
    assert!(number("p95") <= number("worst") && number("worst") < 1.0);
    assert_eq!(bound["kind"], "estimate");
    let said = info(with(), &[]).stdout;
    assert!(
        said.lines().any(|line| line.starts_with("error estimate for any point load: median ")),
        "{said}"
    );
    assert!(info(without(), &["--json"]).json()["certificate"]["bound"].is_null());
    let warned = info(without(), &[]).stdout;
    assert!(warned.contains("warning: contacts have no residual flexibility and no error bound"), "{warned}");
    // Packed sections are read too.
    let packed = pack(with(), 3).expect("packed");
    assert_eq!(&info(&packed, &["--json"]).json()["certificate"]["bound"], bound);
}

#[test]
fn strip_keeps_what_is_of_use_and_pack_loses_nothing() {
    let probes = strip(with(), Keep::Probes).expect("stripped");
    assert_eq!(present(&probes), [S::PatternProbeResidual, S::StaticBound]);
    let surface = strip(with(), Keep::Surface).expect("stripped");
    assert_eq!(present(&surface), ALL);
    for bytes in [&probes, &surface, with()] {
        check(bytes).expect("sound");
        let packed = pack(bytes, 19).expect("packed");
        check(&packed).expect("sound");
        assert!(packed.len() < bytes.len());
        let file = File::parse(bytes).expect("a file");
        let whole = unpack(&packed, 1 << 30).expect("unpacked");
        let again = File::parse(&whole).expect("a file");
        for kind in present(bytes) {
            let [one, other] =
                [file, again].map(|file| file.section(kind).expect("present").stored().to_vec());
            assert!(one == other, "{kind}");
        }
    }
}

/// The file with numbers of a section changed.
fn changed(kind: S, edit: impl Fn(&mut [f64])) -> Vec<u8> {
    let section = File::parse(with()).expect("a file").section(kind).expect("present");
    let mut numbers: Vec<f64> = section.numbers().expect("raw").iter().collect();
    edit(&mut numbers);
    replaced(kind, &numbers.into_iter().flat_map(f64::to_le_bytes).collect::<Vec<u8>>())
}

fn replaced(kind: S, stored: &[u8]) -> Vec<u8> {
    let bytes = with().to_vec();
    let stored = stored.to_vec();
    let put = |section: &mut vademecum_format::SectionInput<'_>| section.kind == kind;
    let file = File::parse(&bytes).expect("a file");
    let mut inputs: Vec<vademecum_format::SectionInput<'_>> =
        file.sections().map(vademecum_format::SectionInput::from).collect();
    for section in inputs.iter_mut().filter_map(|section| put(section).then_some(section)) {
        section.stored = &stored;
    }
    let mut out = vec![0; vademecum_format::encoded_len(file.metadata(), &inputs).expect("a length")];
    vademecum_format::encode_into(file.metadata(), &inputs, &mut out).expect("written");
    out
}

fn fault(bytes: &[u8], kind: S) -> Fault {
    match check(bytes) {
        Err(RewriteError::Unsound { kind: found, fault, .. }) if found == kind => fault,
        other => panic!("{kind}: {other:?}"),
    }
}

#[test]
fn numbers_that_no_residual_has_are_found() {
    // Blocks that take energy out of nothing, where the body moves most: an entry off the diagonal that is
    // larger than those on it, and a negative diagonal.
    let swung = |x: &mut [f64], width: usize| {
        let most = (0..x.len() / width).max_by(|a, b| x[a * width].total_cmp(&x[b * width])).expect("nodes");
        let row = &mut x[most * width..][..width];
        row[1] = 2.0 * (row[0] + row[3]);
    };
    assert_eq!(fault(&changed(S::ContactResidual, |x| swung(x, 6)), S::ContactResidual), Fault::Negative);
    assert_eq!(fault(&changed(S::BoundMap, |x| swung(x, 7)), S::BoundMap), Fault::Negative);
    let turned = |x: &mut [f64]| x.iter_mut().for_each(|x| *x = -*x);
    assert_eq!(fault(&changed(S::ContactResidual, turned), S::ContactResidual), Fault::Negative);
    let last = |x: &mut [f64]| x[6] = -0.5;
    assert_eq!(fault(&changed(S::BoundMap, last), S::BoundMap), Fault::Negative);
    // Worst, median, 95th percentile out of order, and no kind of bound.
    assert_eq!(fault(&changed(S::StaticBound, |x| x.swap(1, 2)), S::StaticBound), Fault::Disagrees);
    assert_eq!(fault(&changed(S::StaticBound, |x| x[0] = 0.5), S::StaticBound), Fault::Disagrees);
    assert_eq!(fault(&changed(S::StaticBound, |x| x[1] *= 1.01), S::StaticBound), Fault::Disagrees);
    assert!(matches!(
        check(&changed(S::ProbeResidual, |x| x[5] = f64::NAN)),
        Err(RewriteError::NotFinite { kind: S::ProbeResidual, place: 5, .. })
    ));
}

#[test]
fn pairs_are_the_edges_of_the_loadable_triangles() {
    let section = File::parse(with()).expect("a file").section(S::ResidualPairs).expect("present");
    let pairs: Vec<u32> = section.u32s().expect("raw").iter().map(|&x| u32::from_le_bytes(x)).collect();
    let edited = |edit: &dyn Fn(&mut Vec<u32>)| {
        let mut pairs = pairs.clone();
        edit(&mut pairs);
        replaced(S::ResidualPairs, &pairs.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
    };
    assert!(edited(&|_| ()) == with());
    assert_eq!(fault(&edited(&|p| p.swap(0, 1)), S::ResidualPairs), Fault::Twice);
    assert_eq!(fault(&edited(&|p| p[..4].rotate_left(2)), S::ResidualPairs), Fault::Twice);
    let n = File::parse(with()).expect("a file").metadata().n_load_nodes;
    let past = edited(&|p| p[1] = n);
    let refused = check(&past);
    assert!(matches!(refused, Err(RewriteError::Format(FormatError::Index { kind: 35, place: 1, .. }))));
    // Ascending, and none of the triangles'.
    let other = edited(&|p| {
        let all: Vec<[u32; 2]> = p.as_chunks().0.to_vec();
        let fits = |&i: &usize| {
            let next = [all[i][0], all[i][1] + 1];
            next[1] < n && all.get(i + 1).is_some_and(|after| next < *after)
        };
        let place = (0..all.len()).find(fits).expect("a gap");
        p[2 * place + 1] += 1;
    });
    assert_eq!(fault(&other, S::ResidualPairs), Fault::Disagrees);
    // Blocks that belong to nobody.
    let orphan = rewritten(
        with(),
        |_| (),
        |section| {
            if section.kind == S::ResidualPairs {
                (section.shape, section.decoded_length, section.stored) = ([0, 2, 1], 0, &[]);
            }
        },
        &[],
    );
    assert_eq!(fault(&orphan, S::ResidualPairs), Fault::Disagrees);
}

#[test]
fn an_error_chooses_the_number_of_natural_modes() {
    let asked = |basis: &str| with_output("residual = true").replace("modes = 4", basis);
    let bytes = built(&asked("kind = \"modes\"\nerror = 0.1"));
    let contents = info(&bytes, &["--json"]).json();
    let bound = &contents["certificate"]["bound"];
    let worst = bound["worst"].as_f64().expect("a number");
    assert!(worst <= 0.1, "{worst}");
    // One mode less misses it.
    let fewer = contents["modes"].as_u64().expect("a count") - 1;
    let fewer = built(&asked(&format!("kind = \"modes\"\nmodes = {fewer}")));
    let fewer = info(&fewer, &["--json"]).json();
    assert!(fewer["certificate"]["bound"]["worst"].as_f64().expect("a number") > 0.1);
    // The step of this file is not exact in time.
    assert_eq!(bound["kind"], "estimate");
}

#[test]
fn an_error_that_cannot_be_asked_for_or_reached_is_named() {
    let refused = |basis: &str, parts: &[&str]| {
        let folder = tempfile::tempdir().expect("a folder");
        run_build(&short_beam().replace("modes = 4", basis), folder.path()).fails(3, parts);
    };
    refused("error = 1e-2", &["`basis.error`", "`kind = \"modes\"`"]);
    refused("kind = \"modes\"\nmodes = 4\nerror = 1e-2", &["`basis`", "`error` beside `modes`"]);
    refused("kind = \"modes\"\nerror = 1e-9", &["`basis.error`", "1e-5"]);
    refused("kind = \"modes\"\nerror = nan", &["`basis.error`", "1e-5"]);
    refused("kind = \"modes\"\nerror = 1.0", &["`basis.error`", "below 1"]);
    // 540 dofs: more than the modes that are tried.
    let longer = short_beam().replace("divisions = [6, 1, 1]", "divisions = [10, 1, 1]");
    let folder = tempfile::tempdir().expect("a folder");
    let text = longer.replace("modes = 4", "kind = \"modes\"\nerror = 1e-5");
    run_build(&text, folder.path()).fails(3, &["`basis.error`", "512 natural modes", "reach"]);
}

#[test]
fn a_body_without_triangles_has_no_pairs() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let [problem, scenario] = ["problems/short-beam.toml", "scenarios/short-push.toml"]
        .map(|name| repository().join("fixtures").join(name).display().to_string());
    let to = path("");
    let exported =
        vademecum(&["export", "matrices", &problem, "--scenario", &scenario, "--modes", "4", "-o", &to]);
    assert_eq!(exported.code, Some(0), "{}", exported.stderr);
    let text = "[mesh.matrices]\nmass = \"mass.mtx\"\nstiffness = \"stiffness.mtx\"\ndofs = \"dofs.csv\"\nnodes \
                = \"nodes.csv\"\n[load]\n[time]\nstep = 1e-3\n[snapshots]\npositions = 2\nduration = \
                0.1\n[basis]\nmodes = 4\n";
    let ran = run_build(text, folder.path());
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let bytes = std::fs::read(path("f.vdm")).expect("a file");
    assert_eq!(present(&bytes), [S::ContactResidual, S::StaticBound, S::BoundMap]);
    check(&bytes).expect("sound");
    // The nodes of the surface have the residual that they have with a mesh.
    let numbers = |bytes: &[u8], kind| -> Vec<f64> {
        let section = File::parse(bytes).expect("a file").section(kind).expect("present");
        section.numbers().expect("raw").iter().collect()
    };
    assert!(numbers(&bytes, S::ContactResidual).len() > numbers(with(), S::ContactResidual).len());
}
