//! Everything the evaluator does, in both precisions, as a library for a machine without operating system:
//! opening, binding, setting parameters, loading, stepping, reading. `check` builds it and looks at the
//! symbols it is left with.
#![no_std]

use core::panic::PanicInfo;
use vademecum_eval::chapter::{ChapterLoads, ChapterScene, ChapterState};
use vademecum_eval::format::File;
use vademecum_eval::{
    Batch, Contact, Field, Loads, Scalar, Scene, SceneOptions, State, StructureChoice, Surface,
    SurfaceTree, Place,
};

unsafe extern "C" {
    /// Defined nowhere: left in the library exactly when a panic is reachable.
    fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never called; the library is not linked into a program.
    unsafe { a_panic_is_reachable() }
}

/// What a host would do in a loop; `None` on any refusal.
fn run<T: Scalar>(bytes: &[u8], memory: &mut [T], work: &mut [f64], block: bool) -> Option<f64> {
    let file = File::parse(bytes).ok()?;
    file.verify_all().ok()?;
    let structure = if block { StructureChoice::Block } else { StructureChoice::Auto };
    let options = SceneOptions { structure, ..SceneOptions::default() };
    let sizes = Scene::<T>::sizes(&file, &options).ok()?;
    let (scene, memory) = memory.split_at_mut_checked(sizes.scene)?;
    let (state, memory) = memory.split_at_mut_checked(sizes.state)?;
    let (loads, memory) = memory.split_at_mut_checked(sizes.loads)?;
    let mut scene = Scene::bind(&file, &options, scene, work).ok()?;
    let mut state = State::new(&scene, state).ok()?;
    let mut loads = Loads::new(&scene, loads).ok()?;
    let index = SceneOptions::find(file.metadata(), "stiffness")?;
    scene.set_parameters(&[(index, 1.1)], &mut state, work).ok()?;
    scene.rebind(&options, work).ok()?;
    state.carry(&scene).ok()?;
    let point = Surface::new(&file).ok()?.locate([0.0; 3])?;
    let surface = Surface::whole(&file).ok()?;
    let (mut order, mut boxes) = ([0; 64], [0.0; 256]);
    let mut tree = SurfaceTree::new(&surface, &mut order, &mut boxes).ok()?;
    tree.refit(memory, 2.0).ok()?;
    let point = tree.pick(point.position, [0.0, 0.0, -1.0]).or(tree.locate(point.position))?;
    let contact = Contact::new(point.place, [0.0, 0.0, -1.0]);
    loads.add_contact(&scene, &contact).ok()?;
    loads.add_pattern_staged(&scene, 0, &[0.0, 0.5, 1.0, 0.0]).ok()?;
    scene.set(&mut state, &[0.0], &[1.0], &loads).ok()?;
    scene.step(&mut state, &loads).ok()?;
    scene.increment_into(work.get_mut(..9 * scene.n_modes() * scene.n_modes())?).ok()?;
    let (lent, out) = memory.split_at_mut_checked(Batch::len_for(&scene, 20))?;
    let mut batch = Batch::new(&scene, 20, lent).ok()?;
    batch.load(&scene, 17, &loads).ok()?;
    batch.set(17, &state).ok()?;
    batch.step(&scene).ok()?;
    batch.carry(&scene).ok()?;
    batch.status(17).ok()?;
    batch.get(17, &mut state).ok()?;
    batch.clear();
    scene.body_into(&state, Field::Velocity, out).ok()?;
    let at_point = scene.point(&state, &point, Field::Displacement).ok()?;
    Some(scene.probe(&state, 0, Field::Displacement).ok()? + scene.energy(&state).ok()? + at_point[0])
}

/// The same for a file of the chapter's structure.
fn run_chapter<T: Scalar>(bytes: &[u8], memory: &mut [T]) -> Option<f64> {
    let file = File::parse(bytes).ok()?;
    let sizes = ChapterScene::<T>::sizes(&file).ok()?;
    let (scene, memory) = memory.split_at_mut_checked(sizes.scene)?;
    let (state, memory) = memory.split_at_mut_checked(sizes.state)?;
    let (loads, out) = memory.split_at_mut_checked(sizes.loads)?;
    let scene = ChapterScene::bind(&file, &SceneOptions::default(), scene).ok()?;
    let mut state = ChapterState::new(&scene, state).ok()?;
    let mut loads = ChapterLoads::new(&scene, loads).ok()?;
    let contact = Contact::new(Place::triangle([0; 3], [1.0, 0.0, 0.0]), [0.0, 0.0, -1.0]);
    loads.add_contact(&scene, &contact).ok()?;
    loads.add_contact_staged(&scene, &contact, &[0.0, 0.5, 1.0, 0.0]).ok()?;
    scene.set(&mut state, &[0.0], &[1.0], &loads).ok()?;
    scene.step(&mut state, &loads).ok()?;
    loads.clear();
    scene.body_into(&state, Field::Velocity, out).ok()?;
    Some(scene.probe(&state, 0, Field::Displacement).ok()? + scene.energy(&state).ok()?)
}

/// `run` for f32 with the slices of a C caller.
///
/// # Safety
/// The pointers and lengths describe memory that lives and is not shared during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn run_f32(
    bytes: *const u8,
    n_bytes: usize,
    memory: *mut f32,
    n: usize,
    work: *mut f64,
    n_work: usize,
    block: bool,
) -> f64 {
    // SAFETY: the caller's promise.
    let (bytes, memory, work) = unsafe {
        (
            core::slice::from_raw_parts(bytes, n_bytes),
            core::slice::from_raw_parts_mut(memory, n),
            core::slice::from_raw_parts_mut(work, n_work),
        )
    };
    run(bytes, memory, work, block).or_else(|| run_chapter(bytes, memory)).unwrap_or(f64::NAN)
}

/// `run` for f64 with the slices of a C caller.
///
/// # Safety
/// As [`run_f32`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn run_f64(
    bytes: *const u8,
    n_bytes: usize,
    memory: *mut f64,
    n: usize,
    work: *mut f64,
    n_work: usize,
    block: bool,
) -> f64 {
    // SAFETY: the caller's promise.
    let (bytes, memory, work) = unsafe {
        (
            core::slice::from_raw_parts(bytes, n_bytes),
            core::slice::from_raw_parts_mut(memory, n),
            core::slice::from_raw_parts_mut(work, n_work),
        )
    };
    run(bytes, memory, work, block).or_else(|| run_chapter(bytes, memory)).unwrap_or(f64::NAN)
}
