//! `strip`, `pack`, `unpack` and `verify --file-only`: what they keep, what they refuse, and that a file on
//! disk is the old one or the new one whatever happens.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::Instant;

use vademecum_eval::{Contact, Field, LoadError, Place, SceneOptions, StructureChoice};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{
    Codec, Element, File, FormatError, SectionInput, SectionKind, encode_into, encoded_len,
};
use vademecum_rewrite::{
    DECODED_LIMIT, Keep, RewriteError, check, drop_terms, pack, pack_within, strip, unpack,
};
use vademecum_tests::golden;
use vademecum_tests::program::{command, program, repository, vademecum};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, Random, bathe};

/// What stands where a result goes: a vademecum file by its first bytes.
const OLD: &[u8] = b"\x89VDM\r\n\x1a\nold";

/// The demo's problem on a coarser mesh: the same text, modes, patterns and probes, so the same probes-only
/// file but for numbers.
fn built() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        let text =
            std::fs::read_to_string(repository().join("fixtures/problems/cantilever.toml")).expect("text");
        let coarse = text.replace("divisions = [32, 3, 4]", "divisions = [8, 1, 2]");
        assert_ne!(coarse, text, "the demo's mesh is another");
        let (problem, file) = (folder.path().join("beam.toml"), folder.path().join("beam.vdm"));
        std::fs::write(&problem, coarse).expect("written");
        let arguments = [
            "build".as_ref(),
            problem.as_os_str(),
            "-o".as_ref(),
            file.as_os_str(),
            "--keep-missed".as_ref(),
        ];
        let ran = vademecum(&arguments);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        std::fs::read(file).expect("a file")
    })
}

/// A synthetic file of some hundred kilobytes.
fn large() -> Vec<u8> {
    let layout = Layout { rows: 40, load_rows: 10, columns: 40, n_interior: 100, r: 8 };
    let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    Body::closed(layout, 5).file(&bathe(), &step, Element::F64)
}

/// The file with its sections changed, and new ones after them.
fn edited<'a>(bytes: &'a [u8], edit: impl Fn(&mut SectionInput<'a>), more: &[SectionInput<'a>]) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let mut inputs: Vec<SectionInput<'a>> = file.sections().map(SectionInput::from).collect();
    inputs.iter_mut().for_each(edit);
    inputs.extend_from_slice(more);
    let mut out = vec![0; encoded_len(file.metadata(), &inputs).expect("a length")];
    encode_into(file.metadata(), &inputs, &mut out).expect("written");
    out
}

#[test]
fn unpacking_gives_back_the_very_bytes() {
    let mut files: Vec<Vec<u8>> = golden::all().into_iter().map(|f| f.1).collect();
    files.push(built().to_vec());
    for bytes in files {
        for level in [1, 19] {
            let packed = pack(&bytes, level).expect("packed");
            assert!(packed.len() <= bytes.len());
            assert!(unpack(&packed, DECODED_LIMIT).expect("unpacked") == bytes);
            // Each section by itself took the smaller codec.
            for section in File::parse(&packed).expect("a file").sections() {
                let smaller = (section.stored().len() as u64) < section.decoded_length();
                assert_eq!(section.codec() != Codec::Raw, smaller);
            }
            assert_eq!(check(&packed).expect("sound").numbers, check(&bytes).expect("sound").numbers);
        }
    }
    let large = large();
    let packed = pack(&large, 3).expect("packed");
    assert!(packed.len() < large.len());
    assert!(unpack(&packed, DECODED_LIMIT).expect("unpacked") == large);
    assert!(matches!(unpack(&packed, 1000), Err(RewriteError::TooLarge { limit: 1000, .. })));
    assert!(matches!(pack(&large, 0), Err(RewriteError::Level { level: 0 })));
}

/// Probe values of 200 steps, 50 of them under the first load pattern.
fn probe_bits(bytes: &[u8], structure: StructureChoice) -> Vec<u64> {
    let options = SceneOptions { structure, ..SceneOptions::default() };
    with_scene::<f64, _>(bytes, &options, |scene, state, loads| {
        loads.add_pattern(scene, 0, 1.0).expect("a pattern");
        let mut bits = vec![];
        for n in 0..200 {
            if n == 50 {
                loads.clear();
            }
            scene.step(state, loads).expect("a step");
            for probe in 0..scene.metadata().n_probes as usize {
                let [x, v] = [Field::Displacement, Field::Velocity].map(|f| scene.probe(state, probe, f));
                bits.extend([x, v].map(|value| value.expect("a probe").to_bits()));
            }
            bits.push(scene.energy(state).expect("an energy").to_bits());
        }
        bits
    })
}

#[test]
fn a_stripped_file_steps_to_the_same_bits() {
    for keep in [Keep::Probes, Keep::Surface, Keep::All] {
        let stripped = strip(built(), keep).expect("stripped");
        for structure in [StructureChoice::Auto, StructureChoice::Exact] {
            let bits = probe_bits(&stripped, structure);
            assert!(bits.iter().any(|&bits| f64::from_bits(bits).abs() > 0.0));
            assert!(bits == probe_bits(built(), structure), "{keep:?} {structure:?}");
        }
        check(&stripped).expect("sound");
    }
    assert!(strip(built(), Keep::All).expect("all of it") == built());
    // A stripped file can be packed, a packed one stripped, and the order does not matter.
    let packed_first = strip(&pack(built(), 19).expect("packed"), Keep::Probes).expect("stripped");
    assert!(packed_first == pack(&strip(built(), Keep::Probes).expect("stripped"), 19).expect("packed"));
}

#[test]
fn a_probes_only_file_of_the_demo_fits_a_microcontroller() {
    let probes = strip(built(), Keep::Probes).expect("stripped");
    assert_eq!(File::parse(&probes).expect("a file").metadata().n_modes, 16);
    assert!(probes.len() <= 16 * 1024, "{} bytes", probes.len());
}

#[test]
fn what_was_dropped_is_refused_by_name() {
    let [probes, surface] = [Keep::Probes, Keep::Surface].map(|keep| strip(built(), keep).expect("stripped"));
    let contact = Contact::new(Place::triangle([0, 1, 2], [1.0, 0.0, 0.0]), [0.0, 0.0, 1.0]);
    with_scene::<f64, _>(&probes, &SceneOptions::default(), |scene, state, loads| {
        let refused = loads.add_contact(scene, &contact);
        assert!(
            matches!(refused, Err(LoadError::Missing { kind: SectionKind::SurfaceBasis })),
            "{refused:?}"
        );
        assert!(scene.node(state, 0, Field::Displacement).is_err());
    });
    with_scene::<f64, _>(&surface, &SceneOptions::default(), |scene, state, loads| {
        loads.add_contact(scene, &contact).expect("contacts stay");
        let mut all = vec![0.0; 3 * scene.metadata().n_nodes as usize];
        assert!(scene.body_into(state, Field::Displacement, &mut all).is_err());
        all.truncate(3 * scene.metadata().n_surface_nodes as usize);
        scene.surface_into(state, Field::Displacement, &mut all).expect("the surface stays");
    });
    assert!(matches!(strip(&probes, Keep::Probes), Err(RewriteError::NothingToStrip { .. })));
    let lost = strip(&probes, Keep::Surface);
    assert!(matches!(lost, Err(RewriteError::Absent { kind: SectionKind::SurfaceBasis, .. })));
    let parameters = &golden::named("parameters.vdm");
    let no_probes = strip(parameters, Keep::Probes);
    assert!(matches!(no_probes, Err(RewriteError::Absent { kind: SectionKind::ProbeRows, .. })));
}

#[test]
fn a_section_of_a_later_version_is_not_lost() {
    let bytes = &golden::named("fixed-f64.vdm");
    let values = [0; 8];
    let mut later = edited(bytes, |_| {}, &[section(SectionKind::SingularValues, 8, Codec::Raw, &values)]);
    // The last entry of the directory becomes kind 4000 (optional), and the checksums follow.
    let n = u32::from_le_bytes(later[12..16].try_into().expect("four")) as usize;
    later[64 * n..64 * n + 4].copy_from_slice(&4000u32.to_le_bytes());
    let directory = crc32fast::hash(&later[64..64 * (n + 1)]);
    later[44..48].copy_from_slice(&directory.to_le_bytes());
    let header = crc32fast::hash(&later[..60]);
    later[60..64].copy_from_slice(&header.to_le_bytes());
    assert_eq!(check(&later).expect("sound").unknown_sections, 1);
    assert!(matches!(pack(&later, 3), Err(RewriteError::Unknown { count: 1 })));
    assert!(matches!(strip(&later, Keep::Probes), Err(RewriteError::Unknown { count: 1 })));
}

fn section(kind: SectionKind, decoded_length: u64, codec: Codec, stored: &[u8]) -> SectionInput<'_> {
    let shape = [decoded_length / 8, 1, 1];
    SectionInput { kind, element: Element::F64, codec, required: false, shape, decoded_length, stored }
}

#[test]
fn hostile_frames_are_refused_without_their_memory() {
    let bytes = &golden::named("probes.vdm");
    // A mebibyte of zeros in a frame of some dozen bytes.
    let zeros = vec![0; 1 << 20];
    let plain = section(SectionKind::SingularValues, 1 << 20, Codec::Raw, &zeros);
    let packed = pack(&edited(bytes, |_| {}, &[plain]), 19).expect("packed");
    let frame =
        File::parse(&packed).expect("a file").section(SectionKind::SingularValues).expect("there").stored();
    assert!(frame.len() < 1000);
    let refusal = |declared: u64, stored: &[u8]| {
        let hostile = section(SectionKind::SingularValues, declared, Codec::Zstd, stored);
        unpack(&edited(bytes, |_| {}, &[hostile]), DECODED_LIMIT).map(|_| ())
    };
    refusal(1 << 20, frame).expect("as it was packed");
    assert!(matches!(refusal(8, frame), Err(RewriteError::Frame { declared: 8, .. })));
    assert!(matches!(refusal(1 << 31, frame), Err(RewriteError::Frame { .. })));
    assert!(matches!(refusal(1 << 40, frame), Err(RewriteError::TooLarge { .. })));
    assert!(matches!(refusal(u64::MAX - 7, frame), Err(RewriteError::TooLarge { .. })));
    assert!(matches!(refusal(1 << 20, &[frame, frame].concat()), Err(RewriteError::Frame { .. })));
    assert!(matches!(refusal(1 << 20, &[frame, b"x"].concat()), Err(RewriteError::Frame { .. })));
    assert!(matches!(refusal(1 << 20, &frame[..frame.len() - 1]), Err(RewriteError::Frame { .. })));
    assert!(matches!(refusal(1 << 20, b""), Err(RewriteError::Frame { .. })));
    let mut random = Random::new(4);
    for _ in 0..2000 {
        let mut damaged = frame.to_vec();
        let place = ((random.number() + 1.0) * 0.5 * damaged.len() as f64) as usize;
        damaged[place] ^= 1 << ((random.number() + 1.0) * 4.0) as u32;
        let _ = refusal(1 << 20, &damaged);
    }
    // Where no more than a gibibyte of addresses can be had, a declaration of two costs nothing either.
    if cfg!(target_os = "linux") {
        let folder = tempfile::tempdir().expect("a folder");
        let (source, target) = (folder.path().join("hostile.vdm"), folder.path().join("raw.vdm"));
        let hostile = section(SectionKind::SingularValues, 1 << 31, Codec::Zstd, frame);
        std::fs::write(&source, edited(bytes, |_| {}, &[hostile])).expect("written");
        let bounded = Command::new("sh")
            .args(["-c", "ulimit -v 1048576; exec \"$0\" --quiet unpack \"$1\" -o \"$2\""])
            .args([program(), source, target])
            .output()
            .expect("a shell");
        assert_eq!(bounded.status.code(), Some(7), "{}", String::from_utf8_lossy(&bounded.stderr));
    }
}

#[test]
fn verify_alone_finds_damage_anywhere() {
    let bytes = &golden::named("fixed-f64.vdm");
    for place in (0..bytes.len()).step_by(7) {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        assert!(check(&damaged).is_err(), "byte {place}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("damaged.vdm");
    for place in [3, 70, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[place] ^= 1;
        std::fs::write(&path, &damaged).expect("written");
        vademecum(&["verify".as_ref(), path.as_os_str(), "--file-only".as_ref()]).fails(7, &["damaged.vdm"]);
    }
    vademecum(&["verify".as_ref(), path.as_os_str()]).fails(2, &["--problem", "--scenario"]);
}

#[test]
fn verify_alone_names_what_checksums_cannot_see() {
    let bytes = &golden::named("fixed-f64.vdm");
    let replaced = |kind: SectionKind, stored: &[u8]| {
        let damaged = edited(
            bytes,
            |section| {
                if section.kind == kind {
                    // The bytes live as long as the test: the closure may not borrow for less.
                    section.stored = Box::leak(stored.to_vec().into_boxed_slice());
                    if kind == SectionKind::ProbeNames {
                        section.shape[0] = stored.len() as u64;
                        section.decoded_length = stored.len() as u64;
                    }
                }
            },
            &[],
        );
        check(&damaged).expect_err("not sound")
    };
    let eigenvalues: Vec<u8> = [1.0, f64::NAN, 3.0].iter().flat_map(|x: &f64| x.to_le_bytes()).collect();
    let error = replaced(SectionKind::Eigenvalues, &eigenvalues);
    assert!(
        matches!(error, RewriteError::NotFinite { kind: SectionKind::Eigenvalues, place: 1, .. }),
        "{error}"
    );
    for names in ["x\ny", "x\ny\n", "x\ny\nx"] {
        let error = replaced(SectionKind::ProbeNames, names.as_bytes());
        assert!(matches!(error, RewriteError::Names { kind: SectionKind::ProbeNames, .. }), "{error}");
    }
    let points: Vec<u8> = [1.0f64, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    assert!(matches!(replaced(SectionKind::AxisPoints, &points), RewriteError::Points { axis: 0 }));
    let file = File::parse(bytes).expect("a file");
    let mut triangles = file.section(SectionKind::Triangles).expect("there").stored().to_vec();
    triangles[0] = 200;
    assert!(matches!(
        replaced(SectionKind::Triangles, &triangles),
        RewriteError::Format(FormatError::Index { found: 200, place: 0, .. })
    ));
}

/// The golden file of 27 terms, each alone at a point of the grid, as a sum of terms everywhere on the axes
/// whose weights fall by half: as separated solutions are.
fn decaying() -> Vec<u8> {
    let bytes = golden::named("parameters.vdm");
    let file = File::parse(&bytes).expect("a file");
    let terms = file.metadata().n_terms as usize;
    let scaled = |kind: SectionKind, width: usize| -> Vec<u8> {
        let numbers = file.section(kind).expect("there").numbers().expect("numbers");
        let of_term = |i: usize| (i / width % terms) as i32;
        numbers.iter().enumerate().flat_map(|(i, x)| (x * 0.5f64.powi(of_term(i))).to_le_bytes()).collect()
    };
    let factors = file.section(SectionKind::Factors).expect("there").numbers().expect("numbers");
    let smooth = |i: usize| 0.5 + 0.0625 * (i * 7 % 5) as f64;
    let smooth: Vec<u8> = (0..factors.len()).flat_map(|i| smooth(i).to_le_bytes()).collect();
    let r = file.metadata().n_modes as usize;
    let widths =
        [(SectionKind::BlockState, r * r), (SectionKind::BlockLoad, 3 * r), (SectionKind::PatternBlock, r)];
    let mut replaced = widths.map(|(kind, width)| (kind, scaled(kind, width))).to_vec();
    replaced.push((SectionKind::Factors, smooth));
    vademecum_tests::synthetic::rewritten(
        &bytes,
        |_| (),
        |section| {
            if let Some((_, stored)) = replaced.iter().find(|(kind, _)| *kind == section.kind) {
                assert_eq!(section.element, Element::F64);
                section.stored = stored;
            }
        },
        &[],
    )
}

#[test]
fn terms_are_dropped_within_a_tolerance_and_the_certificate_says_so() {
    let bytes = &decaying();
    let before = *File::parse(bytes).expect("a file").metadata();
    let mut left = usize::MAX;
    for tolerance in [1e-4, 1e-2] {
        let (fewer, dropped) = drop_terms(bytes, tolerance).expect("some can go");
        assert!(dropped.left < left && dropped.left < dropped.before, "{dropped:?}");
        left = dropped.left;
        assert!(0.0 < dropped.error_rms && dropped.error_rms <= dropped.error_max, "{dropped:?}");
        assert!(dropped.error_max <= tolerance, "{dropped:?}");
        let file = File::parse(&fewer).expect("a file");
        assert_eq!(file.metadata().n_terms as usize, dropped.left);
        let block = &file.metadata().certificate.block;
        assert!(block.spectral_radius.is_nan() && block.trajectory_error.is_nan());
        let noted = block.map_error_max - before.certificate.block.map_error_max;
        assert!(
            before.certificate.block.map_error_max.is_nan() || (noted - dropped.error_max).abs() <= 1e-12
        );
        check(&fewer).expect("sound");
        // The step's displacement under a held contact differs by no more than the maps do, a few hundred
        // steps on.
        let [a, b] = [bytes, &fewer].map(|bytes| contact_field(bytes, 100));
        let first = SceneOptions { terms: Some(left), ..block_options() };
        assert_eq!(contact_field_with(bytes, &first, 100), b, "a scene of the first terms of the whole file");
        let off = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let size = a.iter().map(|a| a * a).sum::<f64>().sqrt();
        assert!(0.0 < off && off < 100.0 * tolerance * size, "{off} of {size} at {tolerance}");
        // Rounded load rows lose the same columns.
        let packed = unpack(&pack_within(bytes, 3, 1e-5).expect("packed"), DECODED_LIMIT).expect("unpacked");
        let quantised = File::parse(&packed).expect("a file").section(SectionKind::BlockLoad).expect("there");
        assert_eq!(quantised.element(), Element::I16);
        let (packed, _) = drop_terms(&packed, tolerance).expect("some can go");
        let [a, b] = [&fewer, &packed].map(|bytes| {
            let file = File::parse(bytes).expect("a file");
            let section = file.section(SectionKind::BlockLoad).expect("there");
            section.numbers().expect("numbers").iter().collect::<Vec<f64>>()
        });
        let largest = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        assert_eq!(a.len(), b.len());
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1e-3 * largest));
    }
    assert!(matches!(drop_terms(bytes, 1e-12), Err(RewriteError::NoTerms { terms: 27 })));
    assert!(matches!(drop_terms(bytes, 0.5), Err(RewriteError::Tolerance { .. })));
}

/// The surface after some steps under a held contact, block structure.
fn contact_field(bytes: &[u8], steps: usize) -> Vec<f64> {
    contact_field_with(bytes, &block_options(), steps)
}

fn block_options() -> SceneOptions {
    SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() }
}

fn contact_field_with(bytes: &[u8], options: &SceneOptions, steps: usize) -> Vec<f64> {
    with_scene::<f64, _>(bytes, options, |scene, state, loads| {
        let contact = Contact::new(Place::triangle([0, 1, 3], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.5]);
        loads.add_contact(scene, &contact).expect("a contact");
        (0..steps).for_each(|_| {
            scene.step(state, loads).expect("a step");
        });
        let mut field = vec![0.0; 3 * scene.metadata().n_surface_nodes as usize];
        scene.surface_into(state, Field::Displacement, &mut field).expect("the surface");
        field
    })
}

#[test]
fn a_file_is_not_stripped_of_what_its_target_needs() {
    let folder = tempfile::tempdir().expect("a folder");
    let [file, scenario, out] = ["beam.vdm", "target.toml", "out.vdm"].map(|name| folder.path().join(name));
    std::fs::write(&file, built()).expect("written");
    let strip = |keep: &str, text: &str| {
        std::fs::write(&scenario, format!("duration = 0.1\n{text}")).expect("written");
        std::fs::write(&out, OLD).expect("written");
        let arguments =
            ["strip".as_ref(), file.as_os_str(), "--keep".as_ref(), keep.as_ref(), "--for".as_ref()];
        let rest = [scenario.as_os_str(), "-o".as_ref(), out.as_os_str()];
        let ran = vademecum(&[&arguments[..], &rest[..]].concat());
        (ran, std::fs::read(&out).expect("a file"))
    };
    let contact = "[[contact]]\npoint = [1.0, 0.0, 0.1]\nforce = [0, 0, 1]\n";
    let pattern = "[[pattern]]\nname = \"gravity\"\n";
    let fields = "[output]\nfields_every = 1\nfields = \"body\"\n";
    for (keep, text) in [("probes", pattern), ("surface", contact), ("all", fields)] {
        let (ran, new) = strip(keep, text);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert!(new.len() > 1000);
    }
    let refused = [
        ("probes", contact, "NodeCoordinates"),
        ("surface", fields, "InteriorBasis"),
        ("all", "[[pattern]]\nname = \"wind\"\n", "wind"),
    ];
    for (keep, text, named) in refused {
        let (ran, new) = strip(keep, text);
        ran.fails(7, &[named]);
        assert_eq!(new, OLD);
    }
}

/// The built file and a packed one on disk, and the old content of where results go.
fn on_disk(folder: &Path, bytes: &[u8]) -> (PathBuf, PathBuf) {
    let (source, target) = (folder.join("packed.vdm"), folder.join("target.vdm"));
    std::fs::write(&source, pack(bytes, 3).expect("packed")).expect("written");
    std::fs::write(&target, OLD).expect("written");
    (source, target)
}

#[test]
fn killed_at_any_moment_the_file_is_the_old_one_or_the_new_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let new = large();
    let (source, target) = on_disk(folder.path(), &new);
    let unpacking = || {
        let mut unpacking =
            command(&["unpack".as_ref(), source.as_os_str(), "-o".as_ref(), target.as_os_str()]);
        unpacking.stdout(Stdio::null()).stderr(Stdio::null());
        unpacking
    };
    let start = Instant::now();
    assert!(unpacking().status().expect("the program").success());
    let whole = start.elapsed();
    let mut random = Random::new(1);
    let mut killed = 0;
    for _ in 0..50 {
        std::fs::write(&target, OLD).expect("written");
        let mut running = unpacking().spawn().expect("the program starts");
        std::thread::sleep(whole.mul_f64((random.number() + 1.0) * 0.5));
        let _ = running.kill();
        killed += usize::from(!running.wait().expect("it ends").success());
        let found = std::fs::read(&target).expect("there is a file");
        assert!(found == OLD || found == new, "{} bytes are neither file", found.len());
    }
    assert!(killed > 0, "every run ended before it was killed");
    assert!(unpacking().status().expect("the program").success());
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2, "parts are left behind");
}

#[test]
fn where_nothing_can_be_written_the_old_file_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let (source, target) = on_disk(folder.path(), &large());
    let missing = folder.path().join("none/out.vdm");
    let to = |out: &Path| vademecum(&["unpack".as_ref(), source.as_os_str(), "-o".as_ref(), out.as_os_str()]);
    to(&missing).fails(1, &["out.vdm", "folder"]);
    // Not even root can make files in /proc; permission bits do not hold root back.
    #[cfg(target_os = "linux")]
    to(Path::new("/proc/out.vdm")).fails(1, &["/proc/out.vdm", "folder"]);
    // A limit on the length of files stands for a full disk: the write fails half way.
    if cfg!(unix) {
        let full = Command::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$0\" --quiet unpack \"$1\" -o \"$2\""])
            .args([program(), source, target.clone()])
            .output()
            .expect("a shell");
        assert_eq!(full.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&full.stderr).contains("target.vdm"));
    }
    assert_eq!(std::fs::read(&target).expect("the old file"), OLD);
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2, "a temporary file is left");
}
