//! The record of `docs/measurements/total-error.md`: pushes at random places of real bodies through files
//! beside the motion that is exact in time.
//!
//! ```text
//! cargo run --release -p vademecum-tests --example total_error
//!     [-- --pushes N --body NAME --modes N --kept FOLDER]
//! ```
//!
//! Without arguments it makes 200 pushes on each of the five bodies whose meshes are there, with 16 and with
//! 32 modes. The tables of a body are printed when it is done; with `--kept` they are also written to
//! `FOLDER/NAME.md` after every push, so that a run that is ended early leaves what the same number of pushes
//! would have given.

use std::path::PathBuf;
use std::time::Instant;

use vademecum_tests::total_error::{markdown, measure, real_bodies};

fn main() {
    let (mut pushes, mut names, mut sizes, mut kept) = (200, vec![], vec![], None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_else(|| panic!("{argument} wants a value"));
        match argument.as_str() {
            "--pushes" => pushes = value().parse().expect("a number of pushes"),
            "--body" => names.push(value()),
            "--modes" => sizes.push(value().parse().expect("a number of modes")),
            "--kept" => kept = Some(PathBuf::from(value())),
            _ => panic!(
                "`{argument}` is not known: usage: total_error [--pushes N] [--body NAME ...] \
                 [--modes N ...] [--kept FOLDER]"
            ),
        }
    }
    if sizes.is_empty() {
        sizes = vec![16, 32];
    }
    let bodies = real_bodies();
    for name in &names {
        let known: Vec<&str> = bodies.iter().map(|body| body.name).collect();
        assert!(known.contains(&name.as_str()), "no body `{name}`; there are {}", known.join(", "));
    }
    println!("A cell of three has median / 95 % / largest of all pushes.\n");
    for body in bodies.iter().filter(|body| names.is_empty() || names.iter().any(|name| name == body.name)) {
        let start = Instant::now();
        let (conditions, rows) = measure(body, &[0.0, 0.02], &sizes, pushes, |conditions, rows| {
            let done = conditions.pushes;
            if done % 5 == 0 || done == pushes {
                eprintln!("{}: {done} of {pushes} pushes, {} s", body.name, start.elapsed().as_secs());
            }
            if let Some(folder) = &kept {
                let place = folder.join(format!("{}.md", body.name));
                std::fs::write(place, markdown(body, conditions, rows)).expect("a folder to write to");
            }
        });
        print!("{}", markdown(body, &conditions, &rows));
    }
}
