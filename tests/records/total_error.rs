//! The record of `docs/benchmarks/total-error.md`: pushes at random places of real bodies through files beside
//! the motion that is exact in time.
//!
//! `cargo run --release -p vademecum-tests --example total_error [-- --pushes N --body NAME ...]`; without
//! arguments 200 pushes on each of the five bodies whose meshes are there.

use std::time::Instant;

use vademecum_tests::total_error::{markdown, measure, real_bodies};

fn main() {
    let (mut pushes, mut names) = (200, vec![]);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_else(|| panic!("{argument} wants a value"));
        match argument.as_str() {
            "--pushes" => pushes = value().parse().expect("a number of pushes"),
            "--body" => names.push(value()),
            _ => panic!("`{argument}` is not known: usage: total_error [--pushes N] [--body NAME ...]"),
        }
    }
    let bodies = real_bodies();
    for name in &names {
        let known: Vec<&str> = bodies.iter().map(|body| body.name).collect();
        assert!(known.contains(&name.as_str()), "no body `{name}`; there are {}", known.join(", "));
    }
    println!("A cell of three has median / 95 % / largest of all pushes.\n");
    for body in bodies.iter().filter(|body| names.is_empty() || names.iter().any(|name| name == body.name)) {
        let start = Instant::now();
        let (conditions, rows) = measure(body, &[0.0, 0.02], &[16, 32], pushes, |done| {
            if done % 5 == 0 || done == pushes {
                eprintln!("{}: {done} of {pushes} pushes, {} s", body.name, start.elapsed().as_secs());
            }
        });
        print!("{}", markdown(body, &conditions, &rows));
    }
}
