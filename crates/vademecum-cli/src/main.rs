//! `vademecum`: the program is the library of this crate, and this is its name.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(vademecum_cli::program(std::env::args_os()))
}
