//! Times of the build, from `build --json`: a file cannot hold them, or two builds would not
//! be the same bytes.

use std::path::Path;

use serde::Deserialize;
use vademecum_build::store::read_text;

use crate::failure::{Cause, Failure};

/// The part of a build's JSON that a report shows.
#[derive(Deserialize)]
pub(crate) struct BuildTimes {
    file_bytes: usize,
    /// In order.
    pub(crate) timings: Vec<Stage>,
}

/// A stage of the build.
#[derive(Deserialize)]
pub(crate) struct Stage {
    /// Name of the stage.
    pub(crate) stage: String,
    /// Wall time \[s\].
    pub(crate) seconds: f64,
    /// Largest memory of the program until its end \[bytes\].
    pub(crate) peak_memory_bytes: Option<u64>,
}

impl BuildTimes {
    /// Reads what `build --json` printed when it wrote a file of this length.
    pub(crate) fn read(path: &Path, file_bytes: usize) -> Result<Self, Failure> {
        let text = read_text(path).map_err(|error| Failure::io(path, error))?;
        let failed = |what: String| {
            Failure::new(Cause::Input, format!("{}: {what}", path.display()))
                .remedy("give what `vademecum build PROBLEM -o FILE --json` printed for this very file")
        };
        let times: Self = serde_json::from_str(&text).map_err(|error| failed(error.to_string()))?;
        if times.file_bytes != file_bytes {
            let found = times.file_bytes;
            return Err(failed(format!("it is about a file of {found} bytes, this one has {file_bytes}")));
        }
        Ok(times)
    }

    /// Seconds of all stages.
    pub(crate) fn total(&self) -> f64 {
        self.timings.iter().map(|stage| stage.seconds).sum()
    }
}
