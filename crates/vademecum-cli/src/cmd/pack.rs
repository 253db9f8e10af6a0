//! `vademecum pack`: a file as it is shipped, compressed.

use std::path::PathBuf;

use vademecum_rewrite as rewrite;

use crate::arguments::{Limit, OutputArguments, rounding};
use crate::failure::Failure;
use crate::files::{open_pair, write_file};

/// Compresses a file for shipping; without a tolerance, `unpack` gives back the very bytes.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum pack body.vdm -o body.packed.vdm
  vademecum pack body.vdm -o body.packed.vdm --tolerance 1e-4
With a tolerance, what is known at every node (basis, load rows, coordinates) is rounded to 16 or 32 bits as
far as fields stay within it.
Probes, load patterns and the step are kept to the bit. `vademecum info` shows what it cost.")]
pub(crate) struct Pack {
    /// The vademecum file.
    file: PathBuf,
    /// The compressed file.
    #[arg(short, long)]
    output: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
    /// Level of zstd: 1 is quick, 22 is small.
    #[arg(long, default_value_t = 19, value_parser = clap::value_parser!(i32).range(1..=22))]
    level: i32,
    /// Relative error of fields that rounding may bring, such as 1e-4 [default: no rounding].
    #[arg(long, value_parser = rounding)]
    tolerance: Option<f64>,
    #[command(flatten)]
    limit: Limit,
}

impl Pack {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let (outputs, bytes) = open_pair(&self.outputs, &self.file, &[], &self.output)?;
        let limit = self.limit.of(bytes.len());
        let packed = rewrite::pack_limited(&bytes, self.level, self.tolerance, limit);
        let packed = packed.map_err(|error| Failure::file(&self.file, error))?;
        write_file(&outputs, &self.output, &packed, bytes.len())?.print(self.json);
        Ok(())
    }
}
