//! `vademecum pack`: a file as it is shipped, compressed.

use std::path::PathBuf;

use vademecum_build::rewrite;

use super::{read_file, rewrite_failed, write_file};
use crate::failure::Failure;

/// Compresses a file for shipping; `unpack` gives back the very bytes.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum pack body.vdm -o body.packed.vdm --level 19
A compressed file cannot be stepped: unpack it where it is used.")]
pub struct Pack {
    /// The vademecum file.
    file: PathBuf,
    /// The compressed file; may be the file itself.
    #[arg(short, long)]
    output: PathBuf,
    /// Level of zstd: 1 is quick, 22 is small.
    #[arg(long, default_value_t = 19, value_parser = clap::value_parser!(i32).range(1..=22))]
    level: i32,
}

impl Pack {
    pub fn run(&self) -> Result<(), Failure> {
        let bytes = read_file(&self.file)?;
        let packed = rewrite::pack(&bytes, self.level).map_err(|error| rewrite_failed(&self.file, error))?;
        write_file(&self.output, &packed, bytes.len())
    }
}
