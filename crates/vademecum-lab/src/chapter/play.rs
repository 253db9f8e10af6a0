//! Marches of the chapter's maps, superposed.

use vademecum_build::Matrix;
use vademecum_build::progress::Listener;
use vademecum_chapter::ChapterScene;
use vademecum_eval::SceneOptions;
use vademecum_format::File;
use vademecum_study::StudyError;
use vademecum_study::parts::{left_ranges, stop_if_asked};
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
    let scene =
        ChapterScene::bind(&file, &SceneOptions { time_step: Some(march.time_step), ..Default::default() })?;
    let mut bodies: Vec<_> = tracks.iter().map(|_| ChapterBody::new(&scene)).collect();
    let instants = scene.instants();
    let factors = |track: &Track, step: usize| track.factors(&instants, march.time_step, step);
    let mut sum = Matrix::zeros(scene.n_modes(), march.steps + 1);
    for (track, body) in tracks.iter().zip(&mut bodies) {
        track.apply(&factors(track, 0), body)?;
        body.start()?;
    }
    for step in 0..march.steps {
        for (track, body) in tracks.iter().zip(&mut bodies) {
            track.apply(&factors(track, step), body)?;
            if let Err(error) = scene.step(&mut body.state, &body.loads) {
                let left = left_ranges(error)?;
                return Ok(Err(format!("left its ranges at step {}: {left}", step + 1)));
            }
            let column = sum.col_as_slice_mut(step + 1);
            column.iter_mut().zip(body.zeta()).for_each(|(sum, z)| *sum += z);
        }
        stop_if_asked(listener)?;
    }
    Ok(Ok(sum))
}
