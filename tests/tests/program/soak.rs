//! The soak in little, and every invariant of it made to fail: by a broken result, or by a program that
//! breaks it.

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use vademecum_tests::soak::invariant::{
    CODES, Held, agree, bounded_memory, ended_well, ended_well_in, finite, no_growth, nothing_left,
    old_or_new, plain_words, refused_by_name, same_bytes, whole_table,
};
use vademecum_tests::soak::launch::{Ended, Launch, Signal};
use vademecum_tests::soak::{KINDS, Settings, soak};

fn fails(held: Held, invariant: &str) {
    assert_eq!(held.expect_err(invariant).invariant, invariant);
}

fn ended(code: i32, stderr: &str) -> Ended {
    Ended { code: Some(code), stderr: stderr.into(), ..Ended::default() }
}

#[test]
fn a_broken_end_of_a_run_is_seen() {
    assert_eq!(ended_well(&ended(3, "error: p.toml: `time.step` is 0"), &CODES), Ok(()));
    for code in [2, 101, 130, 134, 139] {
        fails(ended_well(&ended(code, ""), &CODES), "documented exit");
    }
    fails(ended_well(&ended(0, "thread 'main' panicked at src"), &CODES), "plain words");
    fails(ended_well(&Ended { over_time: true, ..ended(0, "") }, &CODES), "ends in time");
    let killed = Ended { signal: Some(9), sent: Some(Signal::Kill), ..Ended::default() };
    assert_eq!(ended_well(&killed, &[0]), Ok(()));
    for signal in [6, 7, 11, 15] {
        fails(ended_well(&Ended { signal: Some(signal), ..killed.clone() }, &[0]), "documented exit");
    }
    let stopped = Ended { sent: Some(Signal::Interrupt), ..ended(130, "") };
    assert_eq!(ended_well(&stopped, &[0]), Ok(()));
    fails(refused_by_name(&ended(7, "error: broken"), &[7], "a.vdm"), "refused by name");
    fails(refused_by_name(&ended(0, "a.vdm"), &[7], "a.vdm"), "documented exit");
    let out_of_memory =
        Ended { signal: Some(6), stderr: "memory allocation of 900 bytes failed".into(), ..Ended::default() };
    assert_eq!(ended_well_in(&out_of_memory, &[0], 1000), Ok(()));
    fails(ended_well_in(&out_of_memory, &[0], 800), "memory");
    fails(ended_well_in(&ended(101, ""), &[0], 800), "documented exit");
}

#[test]
fn words_of_rust_are_seen_and_words_of_people_are_not() {
    for text in [
        "contact[0] is ContactEntry { point: [0.0] }",
        "found Some(3)",
        "called `Result::unwrap()` on an `Err`",
        "at crates/vademecum-cli/src/main.rs:3",
    ] {
        fails(plain_words(text), "plain words");
    }
    for text in [
        "3 | block = { lengths = [1, 1, 1] }",
        "an error (some 3 nodes); see formats/problem-1.md",
        "E { x = 1 }",
    ] {
        assert_eq!(plain_words(text), Ok(()));
    }
}

#[test]
fn broken_files_and_tables_are_seen() {
    assert_eq!(old_or_new(None, None, b"new"), Ok(()));
    assert_eq!(old_or_new(Some(b"new"), Some(b"old"), b"new"), Ok(()));
    fails(old_or_new(Some(b"ne"), Some(b"old"), b"new"), "old or new");
    fails(old_or_new(None, Some(b"old"), b"new"), "old or new");
    fails(same_bytes("two files", b"abc", b"abd"), "same bytes");
    fails(same_bytes("two files", b"abc", b"ab"), "same bytes");
    let good = "time_s,energy_J\n0,1\n1e-3,2\n";
    assert_eq!(whole_table(good, Some(2)), Ok(()));
    for (text, rows) in
        [("", None), ("t,e\n0,1\n1e-3", None), ("t,e\n0\n", None), (good, Some(3)), ("t\nx\n", None)]
    {
        fails(whole_table(text, rows), "whole rows");
    }
    fails(whole_table("t,e\n0,inf\n", None), "finite results");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("a.work")).expect("a folder");
    assert_eq!(nothing_left(folder.path()), Ok(()));
    std::fs::write(folder.path().join("a.work/.vademecum-x.part"), "").expect("written");
    fails(nothing_left(folder.path()), "nothing left");
}

#[test]
fn broken_motions_are_seen() {
    assert_eq!(no_growth(&[2.0, 1.9, 2.0], 1.0), Ok(()));
    fails(no_growth(&[2.0, 2.1, 1.0], 1.0), "no growth");
    fails(no_growth(&[2.0, f64::NAN], 1.0), "finite results");
    fails(finite("numbers", &[0.0, f64::INFINITY]), "finite results");
    assert_eq!(agree("reciprocity", &[1.0], &[1.0 + 1e-15], 1.0, 1e-14), Ok(()));
    fails(agree("reciprocity", &[1.0], &[1.0 + 1e-13], 1.0, 1e-14), "reciprocity");
    fails(agree("superposition", &[1.0, 2.0], &[1.0], 1.0, 1e-14), "superposition");
    assert_eq!(bounded_memory(7000, 7100), Ok(()));
    fails(bounded_memory(7000, 30_000), "bounded memory");
}

/// A program made of a few lines of the shell.
fn script(folder: &Path, lines: &str) -> PathBuf {
    let path = folder.join("program");
    std::fs::write(&path, format!("#!/bin/sh\n{lines}\n")).expect("written");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("executable");
    path
}

#[test]
fn runs_are_bounded_killed_and_watched() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |lines: &str, change: &dyn Fn(&mut Launch)| {
        let mut launch = Launch::new(&["build"], Duration::from_secs(20));
        change(&mut launch);
        launch.run(&script(folder.path(), lines), folder.path())
    };
    let soon = Duration::from_millis(300);
    fails(ended_well(&run("exec sleep 60", &|launch| launch.limit = soon), &CODES), "ends in time");
    fails(ended_well(&run("kill -SEGV $$", &|_| {}), &CODES), "documented exit");
    let killed = run("exec sleep 60", &|launch| launch.kill = Some((soon, Signal::Terminate)));
    assert_eq!((killed.signal, ended_well(&killed, &CODES)), (Some(15), Ok(())));
    let said = run("echo out; echo err >&2; exit 5", &|_| {});
    assert_eq!((said.stdout.trim(), said.stderr.trim(), said.code), ("out", "err", Some(5)));
    if cfg!(target_os = "linux") {
        assert!(run("exec sleep 0.2", &|_| {}).peak_kib > 0);
    }
    assert_eq!(run("ulimit -v", &|launch| launch.memory_kib = Some(1 << 20)).stdout.trim(), "1048576");
}

fn settings(folder: &Path, program: PathBuf) -> Settings {
    Settings {
        program,
        folder: folder.join("findings"),
        seed: 1,
        from: 0,
        iterations: 1,
        time: Duration::from_secs(300),
        limit: Duration::from_secs(60),
        only: String::new(),
    }
}

#[test]
fn a_program_that_breaks_an_invariant_is_a_finding_with_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let cases = [
        ("exit 101", "documented exit"),
        ("echo \"thread 'main' panicked at\" >&2; exit 3", "plain words"),
        ("exit 0", "old or new"),
        ("echo half > a.vdm; exit 5", "old or new"),
        ("case $1 in build) echo x > a.vdm;; *) exit 7;; esac", "documented exit"),
        ("echo x > a.vdm; echo x > .vademecum-1.part", "nothing left"),
    ];
    for (lines, invariant) in cases {
        let mut told = vec![];
        let settings =
            Settings { only: "build".into(), ..settings(folder.path(), script(folder.path(), lines)) };
        let tally = soak(&settings, &mut |line| told.push(line.to_string()));
        let finding = tally.findings.first().expect(invariant);
        assert_eq!(finding.breach.invariant, invariant, "{lines}");
        assert!(told[0].contains("seed 1, iteration 0") && told[0].contains("vademecum"), "{told:?}");
        for name in ["p.toml", "commands.txt"] {
            assert!(finding.folder.join(name).exists(), "{name}");
        }
        assert!(tally.to_string().contains(invariant));
    }
}

#[test]
fn the_same_seed_makes_the_same_choices() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = script(folder.path(), "exit 101");
    let commands = || {
        let settings = Settings { iterations: 30, ..settings(folder.path(), program.clone()) };
        let tally = soak(&settings, &mut |_| {});
        let read = |finding: &vademecum_tests::soak::Finding| {
            std::fs::read_to_string(finding.folder.join("p.toml")).expect("a problem")
        };
        tally.findings.iter().map(|f| (f.kind, f.commands.clone(), read(f))).collect::<Vec<_>>()
    };
    let first = commands();
    assert!(first.len() > 20, "nearly every kind runs the program");
    assert_eq!(first, commands());
}

/// One iteration of each kind by the real program, from its start to its end; whether the invariants hold is
/// asked for a minute by the gate.
#[test]
fn every_kind_runs_the_program_and_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    for (kind, ..) in KINDS {
        let program = vademecum_tests::program::program();
        let settings = Settings { only: kind.into(), seed: 5, ..settings(folder.path(), program) };
        let tally = soak(&settings, &mut |line| eprintln!("{line}"));
        assert_eq!(tally.iterations(), 1, "{kind}");
        assert!(tally.commands() > 0, "{kind}");
        // What the soak itself gets wrong is a panic in this process.
        assert!(tally.findings.iter().all(|finding| finding.breach.invariant != "no panic"), "{kind}");
    }
}
