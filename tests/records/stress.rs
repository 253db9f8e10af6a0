//! The record of `docs/measurements/stability.md`: every cell of the stress matrix at full size.
//!
//! `cargo run --release -p vademecum-tests --example stress [-- WORD]`; with a word only the cells whose
//! group or name has it, and `--reduced` runs them as continuous integration does.

use vademecum_tests::stress::{Form, cells, markdown, row};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let form = if words.iter().any(|w| w == "--reduced") { Form::Reduced } else { Form::Full };
    let wanted =
        |text: &str| words.iter().filter(|w| !w.starts_with("--")).all(|w| text.contains(w.as_str()));
    let mut ran = vec![];
    let mut missed = 0;
    for cell in cells().into_iter().filter(|cell| wanted(&format!("{}: {}", cell.group, cell.name))) {
        let start = std::time::Instant::now();
        let outcome = cell.run(form);
        let held = outcome.verdict().is(cell.expected);
        missed += usize::from(!held);
        eprint!(
            "{}{:.2} s {}",
            if held { "" } else { "MISSED " },
            start.elapsed().as_secs_f64(),
            row(&cell, &outcome)
        );
        ran.push((cell, outcome));
    }
    print!("{}", markdown(&ran));
    eprintln!("{} cells, {missed} not as expected", ran.len());
    std::process::exit(i32::from(missed > 0));
}
