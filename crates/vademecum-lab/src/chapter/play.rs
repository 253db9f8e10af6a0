//! Marches of the chapter's maps, superposed.

use vademecum_build::Matrix;
use vademecum_build::progress::Listener;
use vademecum_format::File;
use vademecum_study::StudyError;
use vademecum_study::parts::{left_ranges, stop_if_asked, with_marches};
use vademecum_study::player::{ChapterBody, Playable, Track};

use crate::march::{ChapterMarch, March};

/// The sum of the marches of all tracks from rest.
pub(crate) fn play(
    bytes: &[u8],
    tracks: &[Track],
    march: &March<'_>,
    listener: &dyn Listener,
) -> Result<ChapterMarch, StudyError> {
    let file = File::parse(bytes)?;
    with_marches(&file, Some(march.time_step), tracks.len(), |scene, marches| {
        let instants = scene.instants();
        let factors = |track: &Track, step: usize| track.factors(&instants, march.time_step, step);
        let mut sum = Matrix::zeros(scene.n_modes(), march.steps + 1);
        for (track, (state, loads)) in tracks.iter().zip(&mut *marches) {
            let mut body = ChapterBody { scene, state, loads };
            track.apply(&factors(track, 0), &mut body)?;
            body.start()?;
        }
        for step in 0..march.steps {
            for (track, (state, loads)) in tracks.iter().zip(&mut *marches) {
                track.apply(
                    &factors(track, step),
                    &mut ChapterBody { scene, state: &mut *state, loads: &mut *loads },
                )?;
                if let Err(error) = scene.step(state, loads) {
                    let left = left_ranges(error)?;
                    return Ok(Err(format!("left its ranges at step {}: {left}", step + 1)));
                }
                let column = sum.col_as_slice_mut(step + 1);
                column.iter_mut().zip(state.zeta()).for_each(|(sum, z)| *sum += z);
            }
            stop_if_asked(listener)?;
        }
        Ok(Ok(sum))
    })
}
