//! What `verify --file-only` finds in files whose checksums are right: sections that say what cannot be, or
//! contradict each other. And that it finds nothing in files that are sound.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use vademecum_format::{Element, File, Metadata, SectionInput, SectionKind};
use vademecum_rewrite::{Fault, Keep, RewriteError, check, default_limit, pack, pack_within, strip};
use vademecum_study::soundness::check_file;
use vademecum_study::{FileError, StudyError};
use vademecum_tests::golden;
use vademecum_tests::program::{fixtures, repository, vademecum};
use vademecum_tests::synthetic::rewritten;

/// What is built once: a problem's text and the file it gives, `--repair` and a missed tolerance allowed.
fn build(text: &str, folder: &Path) -> Vec<u8> {
    let (problem, file) = (folder.join("p.toml"), folder.join("f.vdm"));
    std::fs::write(&problem, text).expect("written");
    let path = |p: &PathBuf| p.display().to_string();
    let built = vademecum(&["build", &path(&problem), "-o", &path(&file), "--keep-missed", "--repair"]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    std::fs::read(file).expect("a file")
}

fn short_beam() -> String {
    std::fs::read_to_string(repository().join("fixtures/problems/short-beam.toml")).expect("the fixture")
}

/// The short beam with Ritz vectors: both structures.
fn built() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| build(&short_beam(), tempfile::tempdir().expect("a folder").path()))
}

/// A live stiffness of one of two regions, and a live time step.
fn live() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let material = "young = 2e9\npoisson = 0.3\ndensity = 1200.0";
        let regions = short_beam()
            .replace(
                "[[material]]",
                "[[mesh.region]]\nname = \"tip\"\non = { fraction = { axis = \"x\", side = \"max\", fraction = \
                 0.5 } }\n[[material]]\nregion = \"body\"",
            )
            .replace(material, &format!("{material}\n[[material]]\nregion = \"tip\"\n{material}"));
        let parameters = "[[parameter]]\nname = \"tip\"\nkind = \"stiffness\"\nregion = \"tip\"\nrange = [0.5, \
                          2.0]\nscale = \"log\"\n[[parameter]]\nname = \"dt\"\nkind = \"time-step\"\nrange = \
                          [0.5e-3, 2e-3]\nscale = \"log\"\n[tolerance]\nsteps = 50\nmap = 1e-4\n";
        build(&format!("representation = \"separated\"\n{regions}{parameters}"), tempfile::tempdir().expect("a folder").path())
    })
}

/// What the deep check says of bytes.
fn verdict(bytes: &[u8]) -> Result<(), StudyError> {
    check_file(bytes, default_limit(bytes.len())).map(|_| ())
}

/// Numbers of a section, changed, with the section's own element (and right checksums).
fn changed(bytes: &[u8], kind: SectionKind, edit: impl Fn(usize, f64) -> f64) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let section = file.section(kind).expect("present");
    let numbers = section.numbers().expect("raw");
    let edited = numbers.iter().enumerate().map(|(i, x)| edit(i, x));
    let stored: Vec<u8> = match section.element() {
        Element::F32 => edited.flat_map(|x| (x as f32).to_le_bytes()).collect(),
        _ => edited.flat_map(f64::to_le_bytes).collect(),
    };
    replaced(bytes, kind, &stored)
}

fn replaced(bytes: &[u8], kind: SectionKind, stored: &[u8]) -> Vec<u8> {
    let put = |section: &mut SectionInput<'_>| section.kind == kind;
    let stored = stored.to_vec();
    let bytes = bytes.to_vec();
    rewritten(
        &bytes,
        |_| (),
        |section| {
            if put(section) {
                section.stored = &stored;
            }
        },
        &[],
    )
}

fn claiming(bytes: &[u8], edit: impl FnOnce(&mut Metadata<'_>)) -> Vec<u8> {
    rewritten(bytes, edit, |_| (), &[])
}

/// Asserts that a file is refused for this fault of this section, by the library and by the program.
fn refused(bytes: &[u8], kind: SectionKind, fault: Fault, parts: &[&str]) {
    let error = check(bytes).expect_err("not sound");
    let found =
        matches!(&error, RewriteError::Unsound { kind: k, fault: f, .. } if *k == kind && *f == fault);
    assert!(found, "{kind} {fault:?}: {error:?}");
    let text = error.to_string();
    assert!(text.contains(&kind.to_string()), "{text}");
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    File::parse(bytes).and_then(|file| file.verify_all()).expect("the checksums are right");
}

#[test]
fn sound_files_of_every_kind_are_called_sound() {
    let mut files: Vec<(String, Vec<u8>)> = fixtures("golden")
        .into_iter()
        .chain([("built".into(), built().to_vec()), ("live".into(), live().to_vec())])
        .collect();
    for (name, bytes) in files.clone() {
        for keep in [Keep::Probes, Keep::Surface] {
            files.extend(strip(&bytes, keep).ok().map(|stripped| (format!("{name} {keep:?}"), stripped)));
        }
        for tolerance in [1e-2, 1e-4, 1e-7] {
            let rounded = pack_within(&bytes, 3, tolerance).expect("packed");
            files.push((format!("{name} within {tolerance}"), rounded));
        }
    }
    let single = short_beam().replace("[[output.probe]]", "[output]\nprecision = \"f32\"\n[[output.probe]]");
    let surface =
        short_beam().replace("[[output.probe]]", "[output]\nfields = \"surface\"\n[[output.probe]]");
    let [pod, modes] = ["pod", "modes"]
        .map(|kind| short_beam().replace("modes = 4", &format!("modes = 4\nkind = \"{kind}\"")));
    let texts = [("single", single), ("surface", surface), ("pod", pod), ("modes", modes)];
    for (name, text) in texts {
        files.push((name.into(), build(&text, tempfile::tempdir().expect("a folder").path())));
    }
    for (name, bytes) in &files {
        verdict(bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
        verdict(&pack(bytes, 19).expect("packed")).unwrap_or_else(|error| panic!("{name}, packed: {error}"));
    }
    assert!(files.len() > 40, "{} files", files.len());
}

#[test]
fn an_embedded_surface_is_whole_and_its_weights_sum_to_one() {
    use SectionKind::{EmbeddedNodes, EmbeddedTriangles, EmbeddedWeights};
    let whole = golden::named("embedded.vdm");
    let heavier = changed(&whole, EmbeddedWeights, |i, x| if i == 5 { x + 1e-3 } else { x });
    refused(&heavier, EmbeddedWeights, Fault::Disagrees, &["vertex 1", "expected 1"]);
    for (kind, from) in [(EmbeddedNodes, 76), (EmbeddedTriangles, 78)] {
        // A node, or a vertex, that there is not.
        let raw = File::parse(&whole).expect("sound").section(kind).expect("there").stored().len();
        let damaged = replaced(&whole, kind, &vec![0xff; raw]);
        let found = verdict(&damaged).expect_err("out of range").to_string();
        assert!(found.contains(&from.to_string()), "{found}");
        let parsed = File::parse(&damaged).expect("opens");
        assert!(vademecum_eval::EmbeddedSurface::new(&parsed).is_err());
    }
}

#[test]
fn quadrangles_have_the_nodes_of_triangles_of_their_own() {
    use SectionKind::Quadrangles;
    const NONE: u32 = u32::MAX;
    const NINE: [u32; 11] = [0, 8, 0, 2, 8, 6, 1, 5, 7, 3, 4];
    const FOUR: [u32; 11] = [8, 2, 6, 7, 10, 9, NONE, NONE, NONE, NONE, NONE];
    let whole = golden::named("quadrangles.vdm");
    let with = |facets: [[u32; 11]; 2]| {
        let stored: Vec<u8> = facets.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        replaced(&whole, Quadrangles, &stored)
    };
    verdict(&with([NINE, FOUR])).expect("as it is");
    let edited = |facet: [u32; 11], edit: fn(&mut [u32; 11])| {
        let mut facet = facet;
        edit(&mut facet);
        facet
    };
    let wrong = |facets, parts: &[&str]| refused(&with(facets), Quadrangles, Fault::Disagrees, parts);
    wrong([FOUR, NINE], &["facet 1", "behind 10"]);
    wrong([NINE, edited(FOUR, |f| f[0] = 7)], &["facet 1", "behind 8"]);
    wrong([NINE, edited(FOUR, |f| f[1] = 0)], &["facet 1", "0 triangles"]);
    wrong([NINE, edited(FOUR, |f| f[1] = 3)], &["facet 1", "those of its triangles"]);
    wrong([NINE, edited(FOUR, |f| f[2] = 8)], &["facet 1", "those of its triangles"]);
    wrong([NINE, edited(FOUR, |f| f[2] = 7)], &["facet 1", "each once"]);
    wrong([NINE, edited(FOUR, |f| f[6] = 0)], &["facet 1", "four, eight or nine"]);
    wrong([NINE, edited(FOUR, |f| f[8] = 0)], &["facet 1", "four, eight or nine"]);
    // A triangle, or a node, that is not loadable: found when the section is asked for.
    for facet in [edited(FOUR, |f| f[0] = 12), edited(FOUR, |f| f[1] = 5), edited(FOUR, |f| f[5] = NONE)] {
        let damaged = with([NINE, facet]);
        let found = verdict(&damaged).expect_err("out of range").to_string();
        assert!(found.contains("80"), "{found}");
        let parsed = File::parse(&damaged).expect("opens");
        assert!(vademecum_eval::Surface::new(&parsed).is_err());
    }
}

#[test]
fn eigenvalues_must_not_be_negative_and_agree_with_the_stiffness() {
    use SectionKind::{Eigenvalues, ReducedStiffness};
    refused(&changed(built(), Eigenvalues, |_, x| -x), Eigenvalues, Fault::Negative, &["eigenvalue 0"]);
    let hundred = changed(built(), Eigenvalues, |_, x| 100.0 * x);
    refused(&hundred, Eigenvalues, Fault::Disagrees, &["(0, 0)", "ReducedStiffness"]);
    for place in 0..4 {
        let one = changed(built(), Eigenvalues, |i, x| if i == place { 1.001 * x } else { x });
        refused(&one, Eigenvalues, Fault::Disagrees, &[&format!("({place}, {place})")]);
    }
    // Both the same, and the step disagrees.
    let both = changed(&hundred, ReducedStiffness, |_, x| 100.0 * x);
    assert!(verdict(&both).is_err());
    let beyond = changed(built(), Eigenvalues, |_, _| 1e308);
    refused(&beyond, Eigenvalues, Fault::Magnitude, &["number 0"]);
}

#[test]
fn reduced_matrices_are_symmetric_and_not_negative() {
    use SectionKind::{ModeTable, ReducedStiffness, RegionMass, RegionStiffness};
    // Modes 0 and 1: entry (0, 1) alone; both, so large that a combination has negative energy; all.
    let r = 4;
    let file = File::parse(built()).expect("a file");
    let numbers = file.section(ReducedStiffness).expect("there").numbers().expect("raw");
    let size = 1.1 * (numbers.get(0).expect("one") * numbers.get(r + 1).expect("one")).sqrt();
    let one = changed(built(), ReducedStiffness, |i, x| if i == 1 { size } else { x });
    refused(&one, ReducedStiffness, Fault::NotSymmetric, &["(0, 1)", "(1, 0)"]);
    let two = changed(built(), ReducedStiffness, |i, x| if i == 1 || i == r { size } else { x });
    refused(&two, ReducedStiffness, Fault::Negative, &["0 to 1"]);
    refused(&changed(built(), ReducedStiffness, |_, x| -x), ReducedStiffness, Fault::Negative, &[]);
    let table = changed(built(), ModeTable, |i, x| if i == 7 { 1.01 * x } else { x });
    refused(&table, ModeTable, Fault::Disagrees, &["mode 1"]);
    let shares = changed(built(), ModeTable, |i, x| if i == 2 { -x } else { x });
    refused(&shares, ModeTable, Fault::Negative, &["energy share of mode 0"]);

    for kind in [RegionStiffness, RegionMass] {
        refused(&changed(live(), kind, |_, x| 2.0 * x), kind, Fault::Disagrees, &["sum"]);
        refused(&changed(live(), kind, |_, x| -x), kind, Fault::Negative, &["region 0"]);
        let one = changed(live(), kind, |i, x| if i == 1 { x + 1e3 } else { x });
        refused(&one, kind, Fault::NotSymmetric, &["region 0"]);
    }
}

#[test]
fn nodes_and_triangles_are_those_of_a_body() {
    use SectionKind::{NodeCoordinates, NodeIds, Triangles};
    let file = File::parse(built()).expect("a file");
    let n = file.metadata().n_nodes as usize;
    refused(&replaced(built(), NodeIds, &vec![0; 8 * n]), NodeIds, Fault::Twice, &["nodes 0 and 1", "id 0"]);
    let mut ids = file.section(NodeIds).expect("there").stored().to_vec();
    ids.copy_within(8..16, 8 * (n - 1));
    refused(&replaced(built(), NodeIds, &ids), NodeIds, Fault::Twice, &[&format!("nodes 1 and {}", n - 1)]);

    let triangles = file.section(Triangles).expect("there").stored().to_vec();
    let zeros = vec![0; triangles.len()];
    refused(&replaced(built(), Triangles, &zeros), Triangles, Fault::Twice, &["triangle 0"]);
    let first = triangles[..12].repeat(triangles.len() / 12);
    refused(&replaced(built(), Triangles, &first), Triangles, Fault::Twice, &["triangles 0 and 1"]);
    let mut turned = triangles;
    let (front, back) = (turned[0..4].to_vec(), turned[4..8].to_vec());
    turned[12..16].copy_from_slice(&back);
    turned[16..20].copy_from_slice(&front);
    turned.copy_within(8..12, 20);
    refused(&replaced(built(), Triangles, &turned), Triangles, Fault::Twice, &["triangles 0 and 1"]);

    let same = changed(built(), NodeCoordinates, |_, _| 0.5);
    refused(&same, NodeCoordinates, Fault::Twice, &["one place"]);
    let line = changed(built(), NodeCoordinates, |i, x| if i % 3 == 0 { x } else { 0.0 });
    refused(&line, NodeCoordinates, Fault::Twice, &["one line"]);
    let far = changed(built(), NodeCoordinates, |i, x| if i == 4 { 3e38 } else { x });
    refused(&far, NodeCoordinates, Fault::Magnitude, &["y of node 1"]);
}

#[test]
fn modes_are_independent_and_probes_move_like_nodes() {
    use SectionKind::{InteriorBasis, ProbeRows, SurfaceBasis};
    let r = 4;
    let both = |edit: &dyn Fn(usize, f64) -> f64| {
        let surface = changed(built(), SurfaceBasis, edit);
        changed(&surface, InteriorBasis, edit)
    };
    let zero = both(&|i, x| if i % r == 2 { 0.0 } else { x });
    refused(&zero, SurfaceBasis, Fault::Dependent, &["column 2"]);
    // Columns 1 and 3 the same; 3 twice column 1, which only the rank tells.
    let file = File::parse(built()).expect("a file");
    let column = |kind: SectionKind, factor: f64| {
        let numbers = file.section(kind).expect("there").numbers().expect("raw");
        let values: Vec<f64> = numbers.iter().collect();
        move |i: usize, x: f64| if i % r == 3 { factor * values[i - 2] } else { x }
    };
    for (factor, fault, part) in
        [(1.0, Fault::Twice, "columns 1 and 3"), (-2.0, Fault::Dependent, "column 3 is a combination")]
    {
        let surface = changed(built(), SurfaceBasis, column(SurfaceBasis, factor));
        let all = changed(&surface, InteriorBasis, column(InteriorBasis, factor));
        refused(&all, SurfaceBasis, fault, &[part]);
    }
    // Equal columns show on the surface alone too.
    let surface = strip(built(), Keep::Surface).expect("stripped");
    let equal = changed(&surface, SurfaceBasis, column(SurfaceBasis, 1.0));
    refused(&equal, SurfaceBasis, Fault::Twice, &["columns 1 and 3"]);

    let large = changed(built(), ProbeRows, |_, _| 1e308);
    refused(&large, ProbeRows, Fault::Magnitude, &["number 0"]);
    let further = changed(built(), ProbeRows, |_, x| 3e3 * x);
    refused(&further, ProbeRows, Fault::Disagrees, &["probe 0"]);
}

#[test]
fn quantised_numbers_are_those_of_a_writer() {
    let bytes = golden::named("quantised.vdm");
    let kind = SectionKind::SurfaceBasis;
    let stored = File::parse(&bytes).expect("a file").section(kind).expect("there").stored().to_vec();
    for scale in [-1.0f32, 0.0, 1e-40] {
        let mut wrong = stored.clone();
        wrong[4..8].copy_from_slice(&scale.to_le_bytes());
        refused(&replaced(&bytes, kind, &wrong), kind, Fault::Quantised, &["column 1"]);
    }
    let mut wrong = stored;
    let last = wrong.len() - 2;
    wrong[last..].copy_from_slice(&i16::MIN.to_le_bytes());
    refused(&replaced(&bytes, kind, &wrong), kind, Fault::Quantised, &["−32768"]);
}

#[test]
fn the_step_follows_from_the_stiffness() {
    use SectionKind::{BlockState, Factors};
    for factor in [10.0, 1.5, -1.0] {
        let state = changed(built(), BlockState, |_, x| factor * x);
        refused(&state, BlockState, Fault::Disagrees, &["stage 0", "(0, 0)"]);
    }
    let one = changed(built(), BlockState, |i, x| if i == 1 { x + 1e-3 } else { x });
    refused(&one, BlockState, Fault::NotSymmetric, &["(0, 1)"]);
    refused(&changed(live(), BlockState, |_, x| 1e100 * x), BlockState, Fault::Magnitude, &[]);
    refused(&changed(live(), Factors, |_, x| 1e100 * x), Factors, Fault::Magnitude, &[]);
}

/// Asserts that a file is refused for the spectral radius of its step.
fn unstable(bytes: &[u8], of: &str, at: &str) {
    check(bytes).expect("each section for itself may be so");
    let error = verdict(bytes).expect_err("not stable");
    let text = error.to_string();
    let found = matches!(error, StudyError::File(FileError::Unstable { structure, .. }) if structure == of);
    assert!(found && text.contains(at), "{text}");
}

#[test]
fn a_step_is_no_less_stable_than_its_certificate_says() {
    let file = File::parse(live()).expect("a file");
    assert!(file.metadata().certificate.block.spectral_radius < 1.0 + 1e-6);
    let times = |factor: f64| changed(live(), SectionKind::BlockState, move |_, x| factor * x);
    unstable(&times(10.0), "block", "");
    unstable(&times(-1.0), "block", "");
    // Sound at the values of the problem, not at a corner: a factor of the last axis, at its end.
    let points: usize = file.metadata().active_axes().iter().map(|axis| axis.n_points as usize).sum();
    let last = file.metadata().active_axes().last().expect("an axis").n_points as usize;
    let terms = file.metadata().n_terms as usize;
    let start = terms * (points - last);
    let end = changed(live(), SectionKind::Factors, |i, x| {
        if i >= start && (i - start) % last == last - 1 { -3.0 * x } else { x }
    });
    let error = verdict(&end).expect_err("not stable");
    assert!(matches!(error, StudyError::File(FileError::Unstable { .. })), "{error}");
    // What the certificate admits is no lie; what nobody measured may not double the state all the same.
    let admitted = claiming(&times(10.0), |m| m.certificate.block.spectral_radius = 1e6);
    verdict(&admitted).expect("it says so");
    let unmeasured = claiming(&times(10.0), |m| m.certificate.block.spectral_radius = f64::NAN);
    assert!(verdict(&unmeasured).is_err());
}

#[test]
fn a_certificate_does_not_contradict_itself() {
    let refused = |edit: &dyn Fn(&mut Metadata<'_>), parts: &[&str]| {
        let error = check(&claiming(built(), edit)).expect_err("not sound");
        assert!(matches!(error, RewriteError::Certificate { .. }), "{error}");
        parts.iter().for_each(|part| assert!(error.to_string().contains(part), "{error}"));
    };
    refused(&|m| m.certificate.block.projection_floor = 0.9, &["block", "above"]);
    refused(&|m| m.certificate.diagonal.trajectory_error = f64::NAN, &["diagonal", "together"]);
    refused(&|m| m.certificate.block.map_error_rms = 1.0, &["block", "mean"]);
    let kind = SectionKind::RadiusSamples;
    let width = File::parse(live()).expect("a file").metadata().n_parameters as usize + 1;
    let larger = changed(live(), kind, |i, x| if i % width == width - 1 { x + 0.1 } else { x });
    self::refused(&larger, kind, Fault::Disagrees, &["sample 0"]);
    let kind = SectionKind::SingularValues;
    self::refused(&changed(built(), kind, |_, x| -x), kind, Fault::Negative, &["singular value 0"]);
}

#[test]
fn the_program_says_what_is_wrong_with_coordinates() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let file = path("nan.vdm");
    let scenario = repository().join("fixtures/scenarios/short-push.toml").display().to_string();
    for value in [f64::NAN, 1e308] {
        let wrong = changed(built(), SectionKind::NodeCoordinates, |_, _| value);
        std::fs::write(&file, wrong).expect("written");
        vademecum(&["verify", &*file, "--file-only"]).fails(7, &["nan.vdm", "NodeCoordinates"]);
        let run = vademecum(&["run", &*file, "--scenario", &scenario, "-o", &path("out")]);
        run.fails(7, &["nan.vdm", "NodeCoordinates"]);
        assert!(!run.stderr.contains("no loadable surface"), "{}", run.stderr);
        let info = vademecum(&["info", &*file]);
        assert_eq!(info.code, Some(0), "{}", info.stderr);
        assert!(info.stderr.contains("NodeCoordinates"), "{}", info.stderr);
    }
}
