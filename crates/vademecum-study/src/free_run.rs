//! Energy of an unforced motion.

use vademecum_eval::{Body, Place, Scalar, SceneOptions};
use vademecum_format::{File, SectionKind};

use crate::contents::numbers;
use crate::error::{FileError, StudyError};
use crate::player::{elastic, with_body};

/// Energy over an unloaded run, as a share of that at its start.
pub struct FreeRun {
    /// After a push: (time \[s\], share); none for a file without loads.
    pub pushed: Option<Vec<(f64, f64)>>,
    /// Only the lowest mode is bent at first.
    pub lowest: Vec<(f64, f64)>,
    /// Periods of the lowest mode.
    pub periods: f64,
}

/// Most steps of a free run, and most points kept of it.
const STEPS: usize = 200_000;
const POINTS: usize = 1000;

/// Releases a body that was pushed, and one bent in its lowest mode with the energy ½. `lambdas` are the
/// Rayleigh quotients of the modes \[rad²/s²\].
///
/// # Errors
/// [`StudyError::File`]: a file that the evaluator refuses.
pub fn free_run(file: &File<'_>, lambdas: &[f64]) -> Result<FreeRun, StudyError> {
    let lowest = lambdas.iter().copied().filter(|&lambda| lambda > 0.0).fold(f64::INFINITY, f64::min);
    let (period, time_step) = (std::f64::consts::TAU / lowest.sqrt(), file.metadata().time_step);
    let steps = ((50.0 * period / time_step).ceil() as usize).clamp(100, STEPS);
    let bend = |&lambda: &f64| if lambda == lowest { lambda.sqrt().recip() } else { 0.0 };
    let zeta: Vec<f64> = lambdas.iter().map(bend).collect();
    let held = ((0.5 * period / time_step).ceil() as usize).clamp(1, STEPS);
    let options = elastic(&SceneOptions::default());
    let pushed = if loadable(file) {
        Some(with_body::<f64, _>(file, &options, |body| {
            push(file, body)?;
            for _ in 0..held {
                body.step()?;
            }
            body.clear();
            release(body, steps)
        })?)
    } else {
        None
    };
    let lowest = with_body::<f64, _>(file, &options, |body| {
        let at_rest = vec![0.0; zeta.len()];
        body.set(&zeta, &at_rest)?;
        release(body, steps)
    })?;
    Ok(FreeRun { pushed, lowest, periods: steps as f64 * time_step / period })
}

/// True if anything can act on the body.
pub(crate) fn loadable(file: &File<'_>) -> bool {
    file.metadata().n_load_nodes > 0 || file.metadata().n_patterns > 0
}

/// A contact at the loadable node that the modes move most, or the first load pattern of a file without
/// contacts.
pub(crate) fn push<T: Scalar>(file: &File<'_>, body: &mut Body<'_, T>) -> Result<(), FileError> {
    match file.metadata().n_load_nodes as usize {
        0 => body.push_pattern(0, 1e-3)?,
        n_load_nodes => {
            let basis = numbers(file, SectionKind::SurfaceBasis)?;
            let size = |row: &[f64]| row.iter().map(|x| x * x).sum::<f64>();
            let rows =
                basis.chunks_exact(3 * body.scene().n_modes()).map(size).take(n_load_nodes).enumerate();
            let node = rows.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |row| row.0 as u32);
            body.push(&Place::triangle([node; 3], [1.0, 0.0, 0.0]), [1e-3; 3])?;
        }
    }
    Ok(())
}

/// Steps a body that nothing drives; its energy as a share of that at the start.
fn release(body: &mut Body<'_, f64>, steps: usize) -> Result<Vec<(f64, f64)>, StudyError> {
    let first = body.energy()?;
    let mut points = vec![(0.0, 1.0)];
    for step in 1..=steps {
        body.step()?;
        if step % steps.div_ceil(POINTS) == 0 {
            points.push((step as f64 * body.time_step(), body.energy()? / first));
        }
    }
    Ok(points)
}
