//! A block scene taken apart into modes: the march of the dense step, what it refuses, what it leaves
//! unchanged.

use vademecum_eval::{
    BindError, Contact, Loads, Modal, Place, Scalar, Scene, SceneOptions, State, Status, StepError,
    StructureChoice,
};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, File};
use vademecum_tests::galerkin::galerkin_file;
use vademecum_tests::regions::{TwoRegions, chebyshev};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, bathe};

const R: usize = 10;
const STEP: StepParameters =
    StepParameters { time_step: 2e-3, alpha: 0.2, beta: 1e-5, density: 1.0, stiffness: 1.0 };

/// `E` is rounded to ε of its largest entry (1), its smallest eigenvalue is about 2e-4, and `X` and `X⁻¹`
/// enlarge that some dozen times.
const ROUNDING: f64 = 1e-10;

fn block() -> SceneOptions {
    SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() }
}

fn contact() -> Contact {
    Contact::new(Place::triangle([1, 4, 3], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.7])
}

/// Memory for a modal, on the heap.
fn lend<T: Scalar>(scene: &Scene<'_, T>) -> (Vec<T>, Vec<f64>) {
    let sizes = Modal::sizes(scene);
    (vec![T::from_f64(f64::NAN); sizes.memory], vec![f64::NAN; sizes.work])
}

/// Largest distance of `ζ` to the dense march, over its largest size: 200 calls, the first ten under load.
fn distance<T: Scalar>(steps_a_call: usize) -> f64 {
    with_scene::<T, f64>(&galerkin_file(R, &STEP), &block(), |scene, state, loads| {
        let (mut memory, mut work) = lend(scene);
        let mut modal = Modal::bind(scene, ROUNDING, &mut memory, &mut work).expect("diagonalised");
        let mut other = vec![T::ZERO; 6 * R.next_multiple_of(24)];
        let mut dense = State::new(scene, &mut other).expect("memory");
        loads.add_contact(scene, &contact()).expect("contact");
        let (mut worst, mut largest) = (0.0f64, 0.0f64);
        for n in 0..200 {
            if n == 10 {
                loads.clear();
            }
            modal.march(scene, state, loads, steps_a_call).expect("steps");
            (0..steps_a_call).for_each(|_| assert_eq!(scene.step(&mut dense, loads), Ok(Status::Moving)));
            for (a, b) in state.zeta().iter().zip(dense.zeta()) {
                worst = worst.max((a.to_f64() - b.to_f64()).abs());
                largest = largest.max(b.to_f64().abs());
            }
        }
        worst / largest
    })
}

#[test]
fn a_modal_march_is_the_dense_march() {
    for steps in [1, 7] {
        // E is known to a few ε; a fault of the step grows with the square of the steps at most: (7 ·
        // 200)²/2.
        let error = distance::<f64>(steps);
        assert!(error < 10.0 * f64::EPSILON * 1e6, "{steps} steps a call: {error:e}");
        // The project's bound for f32 against f64 over as long a march.
        let error = distance::<f32>(steps);
        assert!(error < 2e-3, "{steps} steps a call, f32: {error:e}");
    }
}

#[test]
fn stages_that_share_no_modes_are_refused() {
    // Solved at full order and projected on an open basis: no pencil stands behind these.
    let open = Body::open(Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r: R }, 1);
    with_scene::<f64, ()>(&open.file(&bathe(), &STEP, Element::F64), &block(), |scene, _, _| {
        let (mut memory, mut work) = lend(scene);
        let refused = Modal::bind(scene, 1e-5, &mut memory, &mut work).map(|modal| modal.remainder());
        assert!(matches!(refused, Err(BindError::NotDiagonalisable { remainder, .. }) if remainder > 1e-5));
        let asked = Modal::bind(scene, 1.0, &mut memory, &mut work).expect("asked for");
        assert!(asked.remainder() > 1e-5);
        for (n, n_work) in [(0, work.len()), (memory.len(), 0)] {
            let short = Modal::bind(scene, 1.0, &mut memory[..n], &mut work[..n_work]).map(|_| ());
            assert!(matches!(short, Err(BindError::LentMemory { .. })));
        }
    });
    let diagonal = SceneOptions { structure: StructureChoice::Diagonal, ..SceneOptions::default() };
    with_scene::<f64, ()>(&open.file(&bathe(), &STEP, Element::F64), &diagonal, |scene, _, _| {
        let (mut memory, mut work) = lend(scene);
        assert_eq!(
            Modal::bind(scene, 1.0, &mut memory, &mut work).map(|_| ()),
            Err(BindError::OtherStructure)
        );
    });
}

#[test]
fn a_refused_march_changes_nothing_and_a_quiet_body_rests() {
    with_scene::<f32, ()>(
        &galerkin_file(R, &StepParameters { alpha: 300.0, ..STEP }),
        &block(),
        |scene, state, loads| {
            let (mut memory, mut work) = lend(scene);
            let mut modal = Modal::bind(scene, ROUNDING, &mut memory, &mut work).expect("diagonalised");
            assert_eq!(modal.march(scene, state, loads, 1_000_000), Ok(Status::AtRest), "at once");
            let huge = [3e38; 3 * R];
            state.restore(&huge).expect("finite");
            assert_eq!(modal.march(scene, state, loads, 5), Err(StepError::NotFinite));
            let mut after = [0.0; 3 * R];
            state.save_into(&mut after).expect("length");
            assert_eq!(after, huge);
            state.restore(&[1e-20; 3 * R]).expect("finite");
            let rests = (0..10_000).any(|_| modal.march(scene, state, loads, 100) == Ok(Status::AtRest));
            assert!(rests && state.zeta().iter().all(|&z| z == 0.0));
            loads.add_contact(scene, &contact()).expect("contact");
            assert_eq!(modal.march(scene, state, loads, 3), Ok(Status::Moving), "woken by the load");
        },
    );
}

#[test]
fn new_parameters_want_new_modes() {
    let bytes = TwoRegions::new(1).separated(
        &bathe(),
        &STEP,
        &chebyshev(5, 1e-8, 1e-5, true),
        &chebyshev(4, 0.5, 2.0, true),
        &[],
    );
    let file = File::parse(&bytes).expect("a file");
    let sizes = Scene::<f64>::sizes(&file, &block()).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let mut scene = Scene::bind(&file, &block(), &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("memory");
    let loads = Loads::new(&scene, &mut loads).expect("memory");
    let (mut memory, mut modal_work) = lend(&scene);
    let mut modal = Modal::bind(&scene, 1.0, &mut memory, &mut modal_work).expect("diagonalised");
    modal.march(&scene, &mut state, &loads, 1).expect("at rest");
    scene.set_parameters(&[(0, 1.5)], &mut state, &mut work).expect("set");
    assert_eq!(modal.march(&scene, &mut state, &loads, 1), Err(StepError::StaleModes));
}
