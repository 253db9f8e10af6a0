//! The published two-dof problem (Bathe & Baig): M = diag(2, 1), K = [6 −2; −2 4], R = (0, 10) from rest, Δt = 0.28, through a
//! file with a full basis, in both structures and by hand-made numbers only: λ = 2 and 5, modes (1, 1)/√3 and (1, −2)/√6.

use vademecum_eval::{Field, SceneOptions, StructureChoice};
use vademecum_format::scheme::{SchemeTable, StepParameters, theta};
use vademecum_format::{Axis, Certificate, Element, MAX_AXES, MAX_PARAMETERS, Metadata, Parameter, SectionKind};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{bathe, encode, newmark, stage_axis};

/// One node whose x and y are the two dofs.
fn file(scheme: &SchemeTable, dt: f64) -> Vec<u8> {
    let (a, b) = (1.0 / 3f64.sqrt(), 1.0 / 6f64.sqrt());
    let lambda = [2.0, 5.0];
    let step = StepParameters {
        time_step: dt,
        alpha: 0.0,
        beta: 0.0,
        density: 1.0,
        stiffness: 1.0,
    };
    let n = scheme.active().len();
    let thetas: Vec<f64> = (0..n)
        .map(|i| theta(scheme, &step, i).expect("theta"))
        .collect();
    let load = [10.0 * a, -20.0 * b];
    let h = |theta: f64, k: usize| -theta * lambda[k] / (1.0 + theta * lambda[k]);
    let state: Vec<f64> = thetas
        .iter()
        .flat_map(|&t| [h(t, 0), 0.0, 0.0, h(t, 1)])
        .collect();
    let pattern: Vec<f64> = thetas
        .iter()
        .flat_map(|&t| [h(t, 0) * load[0], h(t, 1) * load[1]])
        .collect();
    let identity: Vec<f64> = (0..n * n)
        .map(|i| f64::from(u8::from(i / n == i % n)))
        .collect();
    let points: Vec<f64> = (0..n).map(|i| i as f64).collect();
    let basis = [a, b, a, -2.0 * b, 0.0, 0.0];
    let f64s = |kind, numbers: &[f64]| {
        (
            kind,
            Element::F64,
            numbers
                .iter()
                .flat_map(|x| x.to_le_bytes())
                .collect::<Vec<u8>>(),
        )
    };
    use SectionKind as S;
    let contents = [
        f64s(S::ReducedStiffness, &[2.0, 0.0, 0.0, 5.0]),
        f64s(S::Eigenvalues, &lambda),
        f64s(S::SurfaceBasis, &basis),
        f64s(S::BlockState, &state),
        f64s(S::PatternBasis, &load),
        f64s(S::PatternBlock, &pattern),
        f64s(S::AxisPoints, &points),
        f64s(S::Factors, &identity),
    ];
    let mut axes = [Axis::UNUSED; MAX_AXES];
    axes[0] = stage_axis(n)[0];
    let metadata = Metadata {
        program: "two dofs",
        problem: "",
        units: "",
        mesh_hash: [0; 16],
        n_nodes: 1,
        n_surface_nodes: 1,
        n_load_nodes: 1,
        n_triangles: 0,
        n_load_triangles: 0,
        n_modes: 2,
        n_patterns: 1,
        n_probes: 0,
        scheme_name: "by hand",
        scheme: *scheme,
        time_step: dt,
        alpha: 0.0,
        beta: 0.0,
        n_regions: 1,
        n_parameters: 0,
        parameters: [Parameter::UNUSED; MAX_PARAMETERS],
        axes,
        n_axes: 1,
        n_terms: n as u32,
        diagonal: true,
        block: true,
        certificate: Certificate::default(),
    };
    encode(&metadata, &contents)
}

/// Displacements after each of the steps.
fn march(bytes: &[u8], options: &SceneOptions, steps: usize) -> Vec<[f64; 2]> {
    with_scene::<f64, _>(bytes, options, |scene, state, loads| {
        loads.add_pattern(scene, 0, 1.0).expect("load");
        scene
            .set(state, &[0.0; 2], &[0.0; 2], loads)
            .expect("initial acceleration");
        let mut displacements = vec![];
        for _ in 0..steps {
            scene.step(state, loads).expect("step");
            let [x, y, _] = scene.node(state, 0, Field::Displacement).expect("node");
            displacements.push([x, y]);
        }
        displacements
    })
}

/// Printed digits: half a unit of the last one.
fn printed(found: [f64; 2], expected: [f64; 2], digits: i32) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!(
            (found - expected).abs() <= 0.5001 * 10f64.powi(-digits),
            "{found} {expected}"
        );
    }
}

#[test]
fn bathe_gives_the_published_displacements() {
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        let options = SceneOptions {
            structure,
            ..SceneOptions::default()
        };
        let u = march(&file(&bathe(), 0.28), &options, 12);
        printed(u[0], [0.004576, 0.373228], 6);
        printed(u[5], [1.618358, 5.312445], 6);
        printed(u[11], [1.279425, 2.397547], 6);
    }
}

#[test]
fn a_step_of_a_hundred_times_the_size_goes_to_the_static_answer() {
    let built = SceneOptions::default();
    let changed = SceneOptions {
        structure: StructureChoice::Diagonal,
        time_step: Some(28.0),
        ..SceneOptions::default()
    };
    for u in [
        march(&file(&bathe(), 28.0), &built, 200),
        march(&file(&bathe(), 0.28), &changed, 200),
    ] {
        printed(u[0], [1.041138, 3.064947], 6);
        printed(u[199], [1.0, 3.0], 6);
    }
}

#[test]
fn the_trapezoidal_rule_gives_its_published_displacements() {
    for structure in [StructureChoice::Diagonal, StructureChoice::Block] {
        let options = SceneOptions {
            structure,
            ..SceneOptions::default()
        };
        let u = march(&file(&newmark(0.25, 0.5), 0.28), &options, 12);
        printed(u[11], [1.40, 2.31], 2);
    }
}
