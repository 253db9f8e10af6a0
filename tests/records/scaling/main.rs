//! How the cost of a build and of a step grows: tables and fitted exponents, as Markdown.
//!
//! ```text
//! cargo run --release -p vademecum-tests --example scaling -- online
//! cargo run --release -p vademecum-tests --example scaling -- offline [LARGEST_DOFS]
//! ```
//!
//! Records: `docs/measurements/scaling.md`.

mod fit;
mod offline;
mod online;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["online"] => online::run(),
        ["offline"] => offline::run(110_000),
        ["offline", largest] => offline::run(largest.parse().expect("a number of dofs")),
        _ => eprintln!("usage: scaling online | scaling offline [LARGEST_DOFS]"),
    }
}
