//! Memory for a scene on the heap: what a caller with `std` would write.

use vademecum_chapter::{ChapterLoads, ChapterScene, ChapterState};
use vademecum_eval::format::File;
use vademecum_eval::{Loads, Scalar, Scene, SceneOptions, State};

/// Binds a scene of `bytes` and hands it over with a state at rest and no loads.
///
/// # Panics
/// If the file or the options are refused.
pub fn with_scene<T: Scalar, R>(
    bytes: &[u8],
    options: &SceneOptions,
    use_it: impl FnOnce(&Scene<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>) -> R,
) -> R {
    with_work(bytes, options, |scene, state, loads, _| use_it(scene, state, loads))
}

/// The same of a scene that may be bound again, with the work memory for it.
///
/// # Panics
/// If the file or the options are refused.
pub fn with_work<T: Scalar, R>(
    bytes: &[u8],
    options: &SceneOptions,
    use_it: impl FnOnce(&mut Scene<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>, &mut [f64]) -> R,
) -> R {
    let file = File::parse(bytes).expect("a file");
    let sizes = Scene::<T>::sizes(&file, options).expect("options");
    let (mut memory, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let mut scene = Scene::bind(&file, options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("state memory");
    let mut loads = Loads::new(&scene, &mut loads).expect("load memory");
    use_it(&mut scene, &mut state, &mut loads, &mut work)
}

/// Binds a scene of the chapter's structure of `bytes` and hands it over with a state at rest and no loads.
///
/// # Panics
/// If the file or the options are refused.
pub fn with_chapter<R>(
    bytes: &[u8],
    use_it: impl FnOnce(&ChapterScene<'_>, &mut ChapterState, &mut ChapterLoads) -> R,
) -> R {
    let file = File::parse(bytes).expect("a file");
    let scene = ChapterScene::bind(&file, &SceneOptions::default()).expect("bound");
    use_it(&scene, &mut ChapterState::new(&scene), &mut ChapterLoads::new(&scene))
}
