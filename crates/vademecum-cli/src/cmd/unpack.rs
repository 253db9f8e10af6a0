//! `vademecum unpack`: a file as it is mapped, every section raw and aligned.

use std::path::PathBuf;

use vademecum_rewrite as rewrite;

use crate::arguments::Limit;
use crate::failure::Failure;
use crate::files::{read_file, write_file};

/// Decompresses a file for use.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum unpack body.packed.vdm -o body.vdm")]
pub struct Unpack {
    /// The vademecum file.
    file: PathBuf,
    /// The raw file; may be the file itself.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    limit: Limit,
}

impl Unpack {
    pub fn run(&self) -> Result<(), Failure> {
        let bytes = read_file(&self.file)?;
        let limit = self.limit.of(bytes.len());
        let raw = rewrite::unpack(&bytes, limit).map_err(|error| Failure::file(&self.file, error))?;
        write_file(&self.output, &raw, bytes.len())
    }
}
