//! The increment map a scene hands out is the one it steps with.

use vademecum_eval::{OutputError, Scalar, SceneOptions, StructureChoice};
use vademecum_format::File;
use vademecum_tests::program::fixtures;
use vademecum_tests::stage::with_scene;

/// Steps every unit state without loads and compares with the columns of `D`, bit by bit: a step of `e_j` is
/// the sum of one product with 1 and of zeros, added to `e_j`, and then set to zero below the floor.
fn check<T: Scalar>(name: &str, bytes: &[u8], structure: StructureChoice) {
    let options = SceneOptions { structure, ..SceneOptions::default() };
    with_scene::<T, _>(bytes, &options, |scene, state, loads| {
        let n = 3 * scene.n_modes();
        let mut map = vec![f64::NAN; n * n];
        scene.increment_into(&mut map).expect("a map");
        let mut stepped = vec![T::ZERO; n];
        for j in 0..n {
            let unit: Vec<T> = (0..n).map(|i| T::from_f64(f64::from(u8::from(i == j)))).collect();
            state.restore(&unit).expect("a state");
            scene.step(state, loads).expect("a step");
            state.save_into(&mut stepped).expect("a state");
            for i in 0..n {
                let expected = unit[i] + T::from_f64(map[j * n + i]);
                let expected = if expected.magnitude() < T::FLOOR { T::ZERO } else { expected };
                assert_eq!(stepped[i].to_f64(), expected.to_f64(), "{name} {structure:?} ({i}, {j})");
            }
        }
        assert!(map.iter().any(|&d| d != 0.0), "{name}: a map that moves nothing");
    });
}

#[test]
fn its_columns_are_the_steps_of_unit_states() {
    let mut checked = [0; 2];
    for (name, bytes) in fixtures("golden") {
        let metadata = *File::parse(&bytes).expect("a file").metadata();
        let present = [metadata.diagonal && !metadata.scheme.is_exact(), metadata.block];
        for (place, structure) in [StructureChoice::Diagonal, StructureChoice::Block].into_iter().enumerate()
        {
            if present[place] {
                check::<f32>(&name, &bytes, structure);
                check::<f64>(&name, &bytes, structure);
                checked[place] += 1;
            }
        }
    }
    assert!(checked[0] >= 6 && checked[1] >= 8, "{checked:?}");
}

#[test]
fn more_modes_than_a_vector_holds() {
    use vademecum_format::Element;
    use vademecum_format::scheme::StepParameters;
    use vademecum_tests::synthetic::{Body, Layout, newmark};
    // 21 modes: more than one group of the diagonal kernel, and three tiles of the dense one, neither filled.
    let layout = Layout { rows: 3, load_rows: 2, columns: 9, n_interior: 2, r: 21 };
    let step = StepParameters { time_step: 1e-3, alpha: 0.5, beta: 1e-6, density: 1.0, stiffness: 1.0 };
    let bytes = Body::closed(layout, 3).file(&newmark(0.25, 0.5), &step, Element::F64);
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        check::<f32>("21 modes", &bytes, structure);
        check::<f64>("21 modes", &bytes, structure);
    }
}

#[test]
fn another_length_is_refused() {
    let (_, bytes) = fixtures("golden").into_iter().find(|(name, _)| name == "fixed-f64.vdm").expect("there");
    with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, _, _| {
        let needed = 9 * scene.n_modes() * scene.n_modes();
        for found in [0, needed - 1, needed + 1] {
            let refused = scene.increment_into(&mut vec![0.0; found]);
            assert_eq!(refused, Err(OutputError::Length { found, needed }));
        }
    });
}
