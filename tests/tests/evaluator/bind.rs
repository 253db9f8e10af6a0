//! Choosing a structure, evaluating axes, finding surface points, mapping a file.

use vademecum_eval::{BindError, Mapped, Scene, SceneOptions, Structure, StructureChoice, Surface};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{
    Axis, AxisKind, AxisRole, Element, File, MAX_REGIONS, Metadata, Parameter, ParameterRole, SectionKind,
    StructureCertificate,
};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, Random, bathe, encode, newmark};

const LAYOUT: Layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r: 4 };

fn step() -> StepParameters {
    StepParameters { time_step: 2e-3, alpha: 0.1, beta: 1e-6, density: 1.0, stiffness: 1.0 }
}

/// The file with other metadata and the given sections replaced or added.
fn edited(
    bytes: &[u8],
    edit: impl FnOnce(&mut Metadata<'_>),
    replaced: &[(SectionKind, Element, Vec<u8>)],
) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let mut metadata = *file.metadata();
    edit(&mut metadata);
    let kept = file.sections().filter(|s| replaced.iter().all(|r| r.0 != s.kind()));
    let mut contents: Vec<_> = kept.map(|s| (s.kind(), s.element(), s.stored().to_vec())).collect();
    contents.extend_from_slice(replaced);
    encode(&metadata, &contents)
}

#[test]
fn the_cheapest_structure_that_keeps_the_tolerance_is_taken() {
    let bytes = Body::closed(LAYOUT, 1).file(&bathe(), &step(), Element::F32);
    let certified = |trajectory_error, projection_floor| StructureCertificate {
        trajectory_error,
        projection_floor,
        ..StructureCertificate::default()
    };
    let cases = [
        // error of diagonal, of block, floor, tolerance
        (0.020, 0.010, 0.0095, 0.0, Structure::Block),
        (0.010, 0.0099, 0.0095, 0.0, Structure::Diagonal),
        (0.020, 0.010, 0.0095, 0.03, Structure::Diagonal),
        (0.030, 0.020, 0.001, 0.01, Structure::Block),
        (0.020, 0.030, 0.001, 0.01, Structure::Diagonal),
        (f64::NAN, 0.030, 0.001, 0.01, Structure::Block),
        (f64::NAN, f64::NAN, f64::NAN, 0.01, Structure::Diagonal),
    ];
    for (diagonal, block, floor, tolerance, expected) in cases {
        let edit = |m: &mut Metadata<'_>| {
            m.certificate.diagonal = certified(diagonal, floor);
            m.certificate.block = certified(block, floor);
        };
        let bytes = edited(&bytes, edit, &[]);
        let options = SceneOptions { tolerance, ..SceneOptions::default() };
        with_scene::<f32, ()>(&bytes, &options, |scene, _, _| assert_eq!(scene.structure(), expected));
    }
}

#[test]
fn an_unstable_structure_is_not_taken_for_its_small_error() {
    let bytes = Body::closed(LAYOUT, 1).file(&bathe(), &step(), Element::F32);
    let edit = |m: &mut Metadata<'_>| {
        let certified = |trajectory_error, spectral_radius| StructureCertificate {
            trajectory_error,
            projection_floor: 0.010,
            spectral_radius,
            ..StructureCertificate::default()
        };
        // The diagonal structure misses 1.1 × floor; the block structure keeps it and grows.
        m.certificate.diagonal = certified(0.020, 1.0);
        m.certificate.block = certified(0.010, 1.0 + 1e-7);
    };
    let bytes = edited(&bytes, edit, &[]);
    let taken = with_scene::<f32, _>(&bytes, &SceneOptions::default(), |scene, _, _| scene.structure());
    assert_eq!(taken, Structure::Diagonal);
}

/// A block file with two axes, stage and `θ`, whose one term is a function of `θ` only; the parameter is
/// `Δt`.
fn with_theta_axis(kind: AxisKind, log: bool, points: &[f64], factor: impl Fn(f64) -> f64) -> Vec<u8> {
    let bytes = Body::closed(LAYOUT, 2).file(&newmark(0.25, 0.5), &step(), Element::F32);
    let f64s = |numbers: Vec<f64>| -> Vec<u8> { numbers.iter().flat_map(|x| x.to_le_bytes()).collect() };
    let mut all = vec![0.0];
    all.extend_from_slice(points);
    let mut factors = vec![1.0];
    factors.extend(points.iter().map(|&x| factor(x)));
    let (lower, upper) = (points[0], points[points.len() - 1]);
    let role = AxisRole::Monomial { theta: 1.0, stiffness: [0.0; MAX_REGIONS], density: [0.0; MAX_REGIONS] };
    let axis =
        Axis { name: "theta", unit: "s²", role, kind, log, lower, upper, n_points: points.len() as u32 };
    let parameter = Parameter {
        name: "step",
        unit: "s",
        role: ParameterRole::TimeStep,
        log: false,
        lower: 1e-4,
        upper: 1e-2,
        nominal: 2e-3,
    };
    let edit = |m: &mut Metadata<'_>| {
        (m.axes[1], m.n_axes) = (axis, 2);
        (m.parameters[0], m.n_parameters) = (parameter, 1);
    };
    let replaced = [
        (SectionKind::AxisPoints, Element::F64, f64s(all)),
        (SectionKind::Factors, Element::F64, f64s(factors)),
    ];
    edited(&bytes, edit, &replaced)
}

/// What the first increment of the first mode must be when `E = g E_0`, by hand: Newmark, one stage, from ζ_1
/// = 1 at rest (`ζ̈ = 0` set by restoring): `x = E_11 Δt²/k̃`, no velocity and acceleration enter.
fn first_increment(bytes: &[u8], dt: f64) -> f64 {
    let options = SceneOptions {
        structure: StructureChoice::Block,
        time_step: Some(dt),
        beta: Some(0.0),
        alpha: Some(0.0),
        ..SceneOptions::default()
    };
    let bytes = edited(bytes, |m| (m.alpha, m.beta) = (0.0, 0.0), &[]);
    with_scene::<f64, f64>(&bytes, &options, |scene, state, loads| {
        let mut start = [0.0; 12];
        start[0] = 1.0;
        state.restore(&start).expect("state");
        scene.step(state, loads).expect("step");
        state.zeta()[0] - 1.0
    })
}

#[test]
fn factors_are_evaluated_between_their_points() {
    let body = Body::closed(LAYOUT, 2);
    let theta = vademecum_format::scheme::theta(&newmark(0.25, 0.5), &step(), 0).expect("theta");
    let e = body.increment(theta)[0];
    // The trapezoidal rule without damping: θ = Δt²/4.
    let chebyshev: Vec<f64> =
        (0..9).map(|j| 1e-6 * (2.5 - 1.5 * (std::f64::consts::PI * f64::from(j) / 8.0).cos())).collect();
    let cubic = |x: f64| 0.3 + 0.1e6 * x + 0.02e18 * x * x * x;
    let hats = [1e-6, 2.25e-6, 4e-6];
    let step_of = |theta: f64| 2.0 * theta.sqrt();
    let cases: [(AxisKind, bool, &[f64], f64, f64); 6] = [
        // A cubic is its own interpolant, between the points, on one, and at the ends.
        (AxisKind::Chebyshev, false, &chebyshev, 1.7e-6, cubic(1.7e-6)),
        (AxisKind::Chebyshev, false, &chebyshev, chebyshev[3], cubic(chebyshev[3])),
        (AxisKind::Chebyshev, false, &chebyshev, chebyshev[8], cubic(chebyshev[8])),
        (AxisKind::Hat, false, &hats, 3.125e-6, 0.5 * (cubic(2.25e-6) + cubic(4e-6))),
        (AxisKind::Hat, true, &hats, 3e-6, 0.5 * (cubic(2.25e-6) + cubic(4e-6))),
        (AxisKind::Hat, false, &hats, 4e-6, cubic(4e-6)),
    ];
    for (kind, log, points, theta, g) in cases {
        let bytes = with_theta_axis(kind, log, points, cubic);
        let found = first_increment(&bytes, step_of(theta));
        // A few roundings of numbers of this size, and of the 1 that was subtracted; the weights of nine
        // points sum to 2 at most and change by their slope, of the order of 9² times the rounding of θ.
        assert!((found - g * e).abs() < 1e-13, "{kind:?} {log}: {found} {}", g * e);
    }
}

#[test]
fn a_value_off_its_axis_is_refused() {
    let refuse = |bytes: &[u8], dt: f64| {
        let file = File::parse(bytes).expect("a file");
        let options = SceneOptions {
            structure: StructureChoice::Block,
            time_step: Some(dt),
            ..SceneOptions::default()
        };
        let sizes = Scene::<f32>::sizes(&file, &options).expect("sizes");
        let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
        Scene::bind(&file, &options, &mut memory, &mut work).map(|_| ()).expect_err("refused")
    };
    let hats = with_theta_axis(AxisKind::Hat, false, &[1e-6, 4e-6], |_| 1.0);
    for dt in [5e-3, 0.9e-3] {
        // With its Rayleigh damping the file's θ is not Δt²/4, and still off the axis.
        let refused = refuse(&hats, dt);
        assert!(matches!(refused, BindError::OutsideAxis { axis: 1, .. }), "{refused:?}");
    }
    // The same axis without a parameter that moves it: the file stands where it was built.
    let fixed = edited(&hats, |m| (m.n_parameters, m.parameters[0]) = (0, m.parameters[1]), &[]);
    assert!(matches!(refuse(&fixed, 3e-3), BindError::Fixed { stage: 0, .. }));
    let short = SceneOptions::default();
    let file = File::parse(&hats).expect("a file");
    let refused = Scene::<f32>::bind(&file, &short, &mut [], &mut []).map(|_| ()).expect_err("refused");
    assert!(matches!(refused, BindError::LentMemory { found: 0, .. }));
    let bad = SceneOptions { tolerance: f64::NAN, ..short };
    assert!(matches!(Scene::<f32>::sizes(&file, &bad), Err(BindError::BadOption { .. })));
    let bad = SceneOptions { structure: StructureChoice::Diagonal, density: -1.0, ..short };
    let sizes = Scene::<f32>::sizes(&file, &bad).expect("sizes");
    let refused =
        Scene::<f32>::bind(&file, &bad, &mut vec![0.0; sizes.scene], &mut vec![0.0; sizes.work]).map(|_| ());
    assert!(matches!(refused, Err(BindError::Scheme(_))), "{refused:?}");
}

#[test]
fn the_nearest_surface_point_is_found() {
    let bytes = Body::closed(LAYOUT, 3).file(&bathe(), &step(), Element::F64);
    let file = File::parse(&bytes).expect("a file");
    let surface = Surface::new(&file).expect("surface");
    let mut random = Random::new(5);
    for _ in 0..200 {
        let point = [0, 1, 2].map(|_| 3.0 * random.number());
        let found = surface.locate(point).expect("found");
        // The loadable surface is the flat rectangle [0, 2] × [0, 1]: clamping is the answer.
        let nearest = [point[0].clamp(0.0, 2.0), point[1].clamp(0.0, 1.0), 0.0];
        let distance = (0..3).map(|i| (point[i] - nearest[i]).powi(2)).sum::<f64>().sqrt();
        assert!((found.distance - distance).abs() < 1e-12, "{point:?}");
        (0..3).for_each(|i| assert!((found.position[i] - nearest[i]).abs() < 1e-12, "{point:?}"));
        assert!((found.place.weights().iter().sum::<f64>() - 1.0).abs() < 1e-15);
        assert!(
            found.place.weights().iter().all(|&w| w >= 0.0) && found.place.nodes().iter().all(|&n| n < 6)
        );
    }
    assert_eq!(surface.locate([f64::NAN, 0.0, 0.0]), None);
}

#[test]
fn a_copied_file_stays_whatever_becomes_of_it() {
    let bytes = Body::closed(LAYOUT, 4).file(&bathe(), &step(), Element::F32);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("body.vdm");
    std::fs::write(&path, &bytes).expect("written");
    let copied = Mapped::copy(&path).expect("copied");
    std::fs::write(&path, b"").expect("cut");
    assert_eq!(copied.bytes(), bytes);
    copied.file().expect("a file").verify_all().expect("whole");
    let missing = Mapped::copy(folder.path().join("none.vdm")).expect_err("missing");
    assert!(std::error::Error::source(&missing).is_some());
}
