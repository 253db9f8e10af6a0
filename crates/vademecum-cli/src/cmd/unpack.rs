//! `vademecum unpack`: a file as it is mapped, every section raw and aligned.

use std::path::PathBuf;

use vademecum_rewrite as rewrite;

use crate::arguments::{Limit, OutputArguments};
use crate::failure::Failure;
use crate::files::{open_pair, write_file};

/// Decompresses a file for use.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum unpack body.packed.vdm -o body.vdm")]
pub(crate) struct Unpack {
    /// The vademecum file.
    file: PathBuf,
    /// The raw file.
    #[arg(short, long)]
    output: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
    #[command(flatten)]
    limit: Limit,
}

impl Unpack {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let (outputs, bytes) = open_pair(&self.outputs, &self.file, &[], &self.output)?;
        let limit = self.limit.of(bytes.len());
        let raw = rewrite::unpack(&bytes, limit).map_err(|error| Failure::file(&self.file, error))?;
        write_file(&outputs, &self.output, &raw, bytes.len())?.print(self.json);
        Ok(())
    }
}
