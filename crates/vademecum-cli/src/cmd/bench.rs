//! The former `vademecum bench`.

use crate::failure::{Cause, Failure};

/// Names the program that compares methods.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub(crate) struct Bench {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

impl Bench {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let command = ["cargo run --release -p vademecum-lab -- bench".into(), self.arguments.join(" ")];
        let command = command.join(" ");
        let text = "`bench` has moved to the laboratory, a program of the repository";
        Err(Failure::new(Cause::Usage, format!("{text}: `{}`", command.trim_end())))
    }
}
