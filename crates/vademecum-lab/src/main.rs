//! `vademecum-lab`: comparisons that the program `vademecum` does not ship.

/// Prints a line of results. Shadows the standard macro, which panics when the reader has gone.
macro_rules! println {
    ($($text:tt)*) => { vademecum_cli::front::show(format_args!($($text)*)) };
}

/// Prints a line on standard error. Shadows the standard macro, which panics when nobody reads it any more.
macro_rules! eprintln {
    ($($text:tt)*) => { vademecum_cli::front::tell(format_args!($($text)*)) };
}

mod command;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use vademecum_cli::run_command;

/// Compares methods of reduced solid dynamics by run time and error.
#[derive(Parser)]
#[command(name = "vademecum-lab", version, about)]
struct Arguments {
    /// Show results and errors only.
    #[arg(long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Bench(command::Bench),
}

fn main() -> ExitCode {
    let Arguments { quiet, command: Command::Bench(bench) } = Arguments::parse();
    ExitCode::from(run_command(quiet, |console| bench.run(console)))
}
