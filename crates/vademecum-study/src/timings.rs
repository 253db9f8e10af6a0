//! Times of the online work on this machine: opening, binding, stepping, reading the surface.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use vademecum_eval::{Body, Field, Mapped, Scalar, SceneOptions};
use vademecum_format::File;

use crate::error::{FileError, StudyError};
use crate::free_run::{loadable, push};
use crate::player::{elastic, structure_name, with_body};
use crate::statistics::percentiles;

/// Wall times on this machine \[s\].
pub struct Timings {
    /// Reading and opening the file.
    pub open: f64,
    /// Binding a scene in double precision.
    pub bind: f64,
    /// One step in single and in double precision: median, 99th percentile and largest of bursts of 32.
    pub step: [[f64; 3]; 2],
    /// Displacement of the whole surface in single precision.
    pub surface: f64,
    /// Name of the structure that was stepped.
    pub structure: &'static str,
}

/// Steps of a burst, so that the clock is a small part of it, and bursts measured.
const BURST: u32 = 32;
const BURSTS: usize = 2000;
/// Shortest time of a measurement \[s\]; shorter ones are repeated more often.
const LONG_ENOUGH: f64 = 0.05;

/// Seconds of one call of `work`, the mean over at least [`LONG_ENOUGH`].
fn seconds(mut work: impl FnMut() -> Result<(), StudyError>) -> Result<f64, StudyError> {
    work()?;
    let mut count = 1;
    loop {
        let start = Instant::now();
        for _ in 0..count {
            work()?;
        }
        let elapsed = start.elapsed().as_secs_f64();
        if elapsed >= LONG_ENOUGH {
            return Ok(elapsed / f64::from(count));
        }
        count *= 2;
    }
}

/// Times opening the file at `path`, and binding, stepping and reading the surface of `file`, which is the
/// same one.
///
/// # Errors
/// [`StudyError::File`]: a file that cannot be opened, or that the evaluator refuses.
pub fn timings(path: &Path, file: &File<'_>) -> Result<Timings, StudyError> {
    let open = seconds(|| {
        let mapped = Mapped::copy(path).map_err(FileError::from)?;
        black_box(mapped.file()?.metadata().n_modes);
        Ok(())
    })?;
    let options = elastic(&SceneOptions::default());
    let bind = seconds(|| with_body::<f64, ()>(file, &options, |_| Ok(())))?;
    let (single, surface, _) = with_body::<f32, _>(file, &options, |body| steps(file, body))?;
    let (double, _, structure) = with_body::<f64, _>(file, &options, |body| steps(file, body))?;
    Ok(Timings { open, bind, step: [single, double], surface, structure })
}

/// Seconds of a step under a held contact and of a surface read, and the structure stepped.
fn steps<T: Scalar>(
    file: &File<'_>,
    body: &mut Body<'_, T>,
) -> Result<([f64; 3], f64, &'static str), StudyError> {
    if loadable(file) {
        push(file, body)?;
    } else {
        // Without a load a body at rest would not be stepped at all.
        let r = body.scene().n_modes();
        body.set(&vec![1e-3; r], &vec![0.0; r])?;
    }
    let mut bursts = Vec::with_capacity(BURSTS);
    for _ in 0..=BURSTS {
        let start = Instant::now();
        for _ in 0..BURST {
            body.step()?;
        }
        bursts.push(start.elapsed().as_secs_f64() / f64::from(BURST));
    }
    // The first one warms up.
    let step = percentiles(bursts.split_off(1));
    let mut field = vec![T::ZERO; 3 * file.metadata().n_surface_nodes as usize];
    let surface = seconds(|| {
        let read = body.surface_into(Field::Displacement, &mut field);
        black_box(&mut field);
        Ok(read?)
    })?;
    Ok((step, surface, structure_name(body.structure())))
}

/// The processor, where the system tells, and what the program was compiled for.
pub fn machine() -> String {
    let (system, processor) = (std::env::consts::OS, std::env::consts::ARCH);
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    model.map_or(format!("{processor} {system}"), |(_, name)| {
        format!("{} ({processor} {system})", name.trim())
    })
}
