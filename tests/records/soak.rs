//! The record of `docs/measurements/soak.md`: random use and misuse of the program against its invariants.
//!
//! ```text
//! cargo run --release -p vademecum-tests --bin soak -- [--minutes N | --seconds N] [--seed N]
//!     [--from N] [--iterations N] [--only WORD] [--program FILE]
//! ```
//!
//! One line a minute and the table go to standard output; a finding names its iteration, which
//! `--seed N --from N --iterations 1` repeats alone. The exit code is 1 if there is a finding.

use std::path::PathBuf;
use std::time::Duration;

use vademecum_tests::program::{program, repository};
use vademecum_tests::soak::{Settings, soak};

fn main() {
    let settings = settings(std::env::args().skip(1)).unwrap_or_else(|fault| {
        eprintln!("soak: {fault}; the head of tests/records/soak.rs has the options");
        std::process::exit(2)
    });
    // A panic of the evaluator is a finding and is told as one.
    std::panic::set_hook(Box::new(|_| {}));
    let tally = soak(&settings, &mut |line| println!("{line}\n"));
    println!("Seed {}, {:.0} s.\n\n{tally}", settings.seed, tally.seconds);
    std::process::exit(i32::from(!tally.findings.is_empty()));
}

fn settings(mut words: impl Iterator<Item = String>) -> Result<Settings, String> {
    let mut settings = Settings {
        program: PathBuf::new(),
        folder: repository().join("target/soak"),
        seed: 1,
        from: 0,
        iterations: u64::MAX,
        time: Duration::from_secs(60),
        limit: Duration::from_secs(60),
        only: String::new(),
    };
    while let Some(option) = words.next() {
        let value = words.next().ok_or(format!("{option} without a value"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("{option} {value} is no whole number"));
        match option.as_str() {
            "--minutes" => settings.time = Duration::from_secs(60 * number()?),
            "--seconds" => settings.time = Duration::from_secs(number()?),
            "--seed" => settings.seed = number()?,
            "--from" => settings.from = number()?,
            "--iterations" => settings.iterations = number()?,
            "--only" => settings.only = value,
            "--program" => settings.program = value.into(),
            _ => return Err(format!("no option {option}")),
        }
    }
    if settings.program.as_os_str().is_empty() {
        settings.program = program();
    }
    Ok(settings)
}
