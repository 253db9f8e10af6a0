//! What decoding a packed file costs: what a command needs and no more, within a limit, and an error where
//! the machine has no memory. And that every command which reads a file takes packed ones.

use std::path::{Path, PathBuf};

use vademecum_format::{Codec, Element, SectionInput, SectionKind};
use vademecum_rewrite::{RewriteError, check, default_limit, pack, pack_within, unpack};
use vademecum_tests::golden;
use vademecum_tests::program::{Ran, repository, vademecum};
use vademecum_tests::synthetic::rewritten;

const GIB: u64 = 1 << 30;

/// A zstd frame of zeros, written by hand: runs of 128 KiB, four bytes each.
fn zeros(length: u64) -> Vec<u8> {
    const RUN: u64 = 1 << 17;
    // A length of eight bytes and a window of a mebibyte.
    let mut frame = vec![0x28, 0xB5, 0x2F, 0xFD, 0xC0, 0x50];
    frame.extend(length.to_le_bytes());
    let runs = length.div_ceil(RUN);
    for run in 1..=runs {
        let own = RUN.min(length - (run - 1) * RUN);
        let block = u32::from(run == runs) | 1 << 1 | (own as u32) << 3;
        frame.extend(&block.to_le_bytes()[..3]);
        frame.push(0);
    }
    frame
}

/// A golden file with singular values in a frame more.
fn with_frame(declared: u64, frame: &[u8]) -> Vec<u8> {
    let bomb = SectionInput {
        kind: SectionKind::SingularValues,
        element: Element::F64,
        codec: Codec::Zstd,
        required: false,
        shape: [declared / 8, 1, 1],
        decoded_length: declared,
        stored: frame,
    };
    rewritten(&golden::named("fixed-f64.vdm"), |_| (), |_| (), &[bomb])
}

/// The program where it can have no more than so many mebibytes of addresses.
#[cfg(target_os = "linux")]
fn within(mebibytes: u64, arguments: &[&str]) -> Ran {
    let limited = format!("ulimit -v {}; exec \"$0\" --quiet \"$@\"", 1024 * mebibytes);
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &limited]).arg(vademecum_tests::program::program()).args(arguments);
    Ran::new(&shell.output().expect("a shell"))
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

#[cfg(target_os = "linux")]
#[test]
fn a_bomb_costs_nothing_where_it_is_not_needed_and_is_refused_where_it_is() {
    const ROOM: u64 = 400;
    let folder = tempfile::tempdir().expect("a folder");
    let [file, scenario, out] = ["bomb.vdm", "s.toml", "out"].map(|name| path(folder.path(), name));
    let bomb = with_frame(GIB, &zeros(GIB));
    assert!(bomb.len() < 64 * 1024, "{} bytes", bomb.len());
    std::fs::write(&file, bomb).expect("written");
    std::fs::write(&scenario, "duration = 0.01\n[[pattern]]\nname = \"pull\"\n").expect("written");
    for arguments in [
        &["info", &file][..],
        &["run", &file, "--scenario", &scenario, "-o", &out],
        &["strip", &file, "--keep", "probes", "-o", &path(folder.path(), "probes.vdm")],
        &["view", &file, "--export", &path(folder.path(), "page.html")],
    ] {
        let ran = within(ROOM, arguments);
        assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.stderr);
    }
    let target = path(folder.path(), "target.vdm");
    for arguments in [
        &["verify", &file, "--file-only"][..],
        &["report", &file, "-o", &path(folder.path(), "report.html")],
        &["pack", &file, "-o", &target],
        &["pack", &file, "-o", &target, "--tolerance", "1e-4"],
        &["unpack", &file, "-o", &target],
    ] {
        within(ROOM, arguments).fails(7, &["bomb.vdm", "SingularValues", "--limit"]);
        // Allowed, and the machine has not the memory: an error, and no abort.
        let allowed = [arguments, &["--limit", "4G"]].concat();
        within(ROOM, &allowed).fails(1, &["memory"]);
    }
    assert!(!Path::new(&target).exists());
    // Room for the numbers, not for what the compressor may make of them.
    within(1536, &["pack", &file, "-o", &target, "--limit", "4G"]).fails(1, &["memory"]);
    // The commands that do not need it take the flag all the same.
    let tight = within(ROOM, &["info", &file, "--limit", "1K"]);
    assert_eq!(tight.code, Some(0), "nothing it needs is packed: {}", tight.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn a_frame_that_lies_costs_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let [file, target] = ["lie.vdm", "target.vdm"].map(|name| path(folder.path(), name));
    let mut says_so = zeros(1 << 20);
    says_so[6..14].copy_from_slice(&GIB.to_le_bytes());
    for frame in [zeros(1 << 20), says_so] {
        std::fs::write(&file, with_frame(GIB, &frame)).expect("written");
        for arguments in [&["verify", &file, "--file-only"][..], &["unpack", &file, "-o", &target]] {
            let allowed = [arguments, &["--limit", "4G"]].concat();
            within(400, &allowed).fails(7, &["lie.vdm", "SingularValues"]);
        }
    }
}

#[test]
fn the_limit_goes_with_the_length_and_can_be_raised() {
    let length = 256 << 20;
    let bytes = with_frame(length, &zeros(length));
    assert!(default_limit(bytes.len()) < length);
    let refused = check(&bytes).expect_err("too large");
    let kind = SectionKind::SingularValues;
    assert!(matches!(refused, RewriteError::TooLarge { kind: found, .. } if found == kind), "{refused}");
    assert!(matches!(unpack(&bytes, length), Err(RewriteError::TooLarge { .. })), "beside the others");
    assert_eq!(unpack(&bytes, length + (1 << 20)).expect("unpacked").len() as u64 / length, 1);
    // Whatever a build writes and `pack` makes of it stays far below.
    for (_, bytes) in golden::all() {
        let packed = pack_within(&bytes, 19, 1e-2).expect("packed");
        assert!(unpack(&packed, default_limit(packed.len()) / 64).is_ok());
    }
    let path = repository().join("fixtures/golden/fixed-f64.vdm").display().to_string();
    vademecum(&["info", &*path, "--limit", "much"]).fails(2, &["--limit", "512M"]);
}

/// The short beam, and packed: without loss, and rounded.
fn packed(folder: &Path) -> [PathBuf; 3] {
    let [file, exact, rounded] = ["b.vdm", "p.vdm", "r.vdm"].map(|name| folder.join(name));
    let problem = repository().join("fixtures/problems/short-beam.toml");
    let built = vademecum(&["build".as_ref(), problem.as_os_str(), "-o".as_ref(), file.as_os_str()]);
    assert_eq!(built.code, Some(0), "{}", built.stderr);
    let bytes = std::fs::read(&file).expect("a file");
    std::fs::write(&exact, pack(&bytes, 19).expect("packed")).expect("written");
    std::fs::write(&rounded, pack_within(&bytes, 19, 1e-4).expect("packed")).expect("written");
    [file, exact, rounded]
}

#[test]
fn every_command_takes_packed_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = packed(folder.path());
    let [page, exact, rounded] = ["1.html", "2.html", "3.html"].map(|name| folder.path().join(name));
    for (file, page) in files.iter().zip([&page, &exact, &rounded]) {
        let [file, page] = [file, page].map(|path| path.display().to_string());
        let report = vademecum(&["report", &*file, "-o", &page]);
        assert_eq!(report.code, Some(0), "{}", report.stderr);
        let text = std::fs::read_to_string(&page).expect("a page");
        assert!(text.contains("a short beam of quadratic tetrahedra") && text.contains("svg"));
        let view = vademecum(&["view", &*file, "--export", &page]);
        assert_eq!(view.code, Some(0), "{}", view.stderr);
    }
    // The pages hold the numbers themselves: rounded ones are shorter than those a codec gives back.
    let length = |path: &PathBuf| std::fs::metadata(path).expect("a page").len();
    assert!(length(&rounded) < length(&exact));
}

/// The server's answer for the file itself.
fn fetched(file: &Path) -> Vec<u8> {
    use std::io::{BufRead, BufReader, Read, Write};
    let arguments = ["view".as_ref(), file.as_os_str(), "--no-open".as_ref()];
    let mut server = vademecum_tests::program::command(&arguments);
    let mut server = server.stdout(std::process::Stdio::piped()).spawn().expect("the program starts");
    let mut line = String::new();
    BufReader::new(server.stdout.take().expect("a pipe")).read_line(&mut line).expect("an address");
    let address = line.trim_start_matches("http://").split('/').next().expect("an address").to_string();
    let mut stream = std::net::TcpStream::connect(&address).expect("a connection");
    write!(stream, "GET /body.vdm HTTP/1.1\r\nHost: {address}\r\n\r\n").expect("asked");
    let mut answer = vec![];
    stream.read_to_end(&mut answer).expect("an answer");
    server.kill().expect("it runs");
    server.wait().expect("it ends");
    let end = answer.windows(4).position(|w| w == b"\r\n\r\n").expect("a head");
    answer.split_off(end + 4)
}

#[test]
fn the_viewers_server_hands_out_packed_files_raw() {
    let folder = tempfile::tempdir().expect("a folder");
    let [file, exact, _] = packed(folder.path());
    let (raw, of_packed) = (fetched(&file), fetched(&exact));
    assert!(raw == std::fs::read(&file).expect("a file"));
    let [raw, of_packed] = [&raw, &of_packed].map(|b| vademecum_format::File::parse(b).expect("a file"));
    for section in raw.sections() {
        match of_packed.section(section.kind()) {
            Some(own) => assert!(own.codec() == Codec::Raw && own.stored() == section.stored()),
            None => {
                use SectionKind as S;
                assert!(matches!(section.kind(), S::SingularValues | S::ModeTable | S::MeshError));
            }
        }
    }
}

#[test]
fn a_file_that_is_no_vademecum_is_called_what_it_looks_like() {
    let folder = tempfile::tempdir().expect("a folder");
    let fixture = |name: &str| repository().join("fixtures").join(name).display().to_string();
    let (problem, mesh, push) =
        (fixture("problems/cube.toml"), fixture("meshes/cube.msh"), fixture("scenarios/push.toml"));
    let made = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path().join(name), bytes).expect("written");
        path(folder.path(), name)
    };
    let page = made("page.html", b"<!DOCTYPE html><title>x</title>");
    let cases = [
        (problem.clone(), "problem file (TOML)"),
        (mesh, "a mesh"),
        (push.clone(), "scenario file (TOML)"),
        (page, "page"),
        (made("empty.vdm", b""), "empty"),
        (made("surface.step", b"ISO-10303-21;\n"), "CAD"),
        (made("noise.bin", &[7, 200, 1, 255, 3, 9, 0, 77, 4]), "first eight bytes"),
        (made("short.bin", &[7]), "text"),
    ];
    let out = path(folder.path(), "out");
    for (file, what) in &cases {
        for arguments in [
            &["info", file][..],
            &["run", file, "--scenario", &push, "-o", &out],
            &["verify", file, "--file-only"],
            &["verify", file, "--problem", &problem, "--scenario", &push],
            &["report", file, "-o", &out],
            &["view", file, "--export", &out],
            &["pack", file, "-o", &out],
            &["unpack", file, "-o", &out],
            &["strip", file, "-o", &out, "--keep", "probes"],
        ] {
            let ran = vademecum(arguments);
            ran.fails(7, &[file.as_str(), "not a vademecum file", what]);
            assert!(!ran.stderr.contains("damaged"), "{arguments:?}: {}", ran.stderr);
        }
    }
    // What was one is still called damaged.
    let mut bytes = golden::named("fixed-f64.vdm");
    bytes[4] = b'\n';
    let damaged = made("damaged.vdm", &bytes);
    vademecum(&["info", &*damaged]).fails(7, &["damaged.vdm", "was damaged"]);
    let cut = made("cut.vdm", &bytes[..3]);
    vademecum(&["info", &*cut]).fails(7, &["cut.vdm"]);
}

#[test]
fn a_missing_file_gives_the_systems_reason_and_no_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let [none, out] = ["none.vdm", "out"].map(|name| path(folder.path(), name));
    let push = repository().join("fixtures/scenarios/push.toml").display().to_string();
    for arguments in [
        &["info", &none][..],
        &["run", &none, "--scenario", &push, "-o", &out],
        &["verify", &none, "--file-only"],
        &["report", &none, "-o", &out],
        &["view", &none, "--export", &out],
        &["pack", &none, "-o", &out],
        &["unpack", &none, "-o", &out],
        &["strip", &none, "-o", &out, "--keep", "probes"],
    ] {
        let ran = vademecum(arguments);
        ran.fails(7, &["none.vdm", "No such file or directory"]);
        // No guess at what the file might be.
        let guesses = ["damaged", "looks like", "unpack", "build it"];
        assert!(!guesses.iter().any(|guess| ran.stderr.contains(guess)), "{arguments:?}: {}", ran.stderr);
    }
    let here = folder.path().display().to_string();
    vademecum(&["info", &*here]).fails(7, &["folder"]);
}
