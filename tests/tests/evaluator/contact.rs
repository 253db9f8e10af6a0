//! Contacts as an operator: what `compliance` and `free_motion` say is what a step does, the residual
//! flexibility makes a held load end where statics says, and a rigid sphere that is solved for neither goes
//! into the body nor gives it energy.

use std::sync::OnceLock;

use vademecum_build::Matrix;
use vademecum_build::fem::Solve;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{
    Contact, Field, LoadError, Loads, Scalar, Scene, SceneOptions, State, StepError, StructureChoice,
    Surface, SurfacePoint,
};
use vademecum_format::{File, SectionKind};
use vademecum_tests::program::repository;
use vademecum_tests::shared::shared;
use vademecum_tests::stage::with_scene;

#[path = "../../../examples/press_a_sphere.rs"]
mod press_a_sphere;

use press_a_sphere::{Body, Sphere, Touch, beam, path, press};

const BATHE: &str = "scheme = { name = \"bathe\" }";

fn fixture(name: &str) -> String {
    std::fs::read_to_string(repository().join("fixtures/problems").join(name)).expect("the fixture")
}

fn problem(text: &str) -> Problem {
    Problem::parse(text, "p.toml", repository().join("fixtures/problems")).expect("a problem")
}

fn built(text: &str) -> Vec<u8> {
    build(&problem(text), &BuildOptions::default(), &Silent).expect("built").either().bytes
}

/// A short beam of four natural modes that are moved exactly, with its residual.
fn short_beam() -> String {
    let text = fixture("short-beam.toml").replace(BATHE, "scheme = { name = \"exact\" }");
    text.replace("modes = 4", "kind = \"modes\"\nmodes = 4")
}

fn exact() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| built(&short_beam()))
}

/// The same with Bathe's scheme.
fn bathe() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    let text = || short_beam().replace("scheme = { name = \"exact\" }", BATHE);
    BYTES.get_or_init(|| {
        built(&text().replace("[[output.probe]]", "[output]\nresidual = true\n[[output.probe]]"))
    })
}

fn of(structure: StructureChoice) -> SceneOptions {
    SceneOptions { structure, ..SceneOptions::default() }
}

fn undamped() -> SceneOptions {
    SceneOptions { alpha: Some(0.0), beta: Some(0.0), ..SceneOptions::default() }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn contact(point: &SurfacePoint, force: [f64; 3]) -> Contact {
    Contact::new(point.place, force)
}

/// Places inside of triangles along the upper side of the short beam; no two share a triangle.
fn four(bytes: &[u8]) -> [SurfacePoint; 4] {
    let file = File::parse(bytes).expect("a file");
    let surface = Surface::new(&file).expect("a surface");
    [0.2, 0.45, 0.7, 0.95].map(|x| surface.locate([x, 0.03, 0.1]).expect("a place"))
}

const FORCES: [[f64; 3]; 4] = [[1.0, 2.0, -30.0], [-5.0, 1.0, 8.0], [3.0, -4.0, -20.0], [0.0, 6.0, 11.0]];

/// What the operator says and what a step does differ by at most `tolerance` of the largest displacement.
fn says_what_a_step_does<T: Scalar>(bytes: &[u8], structure: StructureChoice, tolerance: f64) {
    let points = four(bytes);
    with_scene::<T, _>(bytes, &of(structure), |scene, state, loads| {
        // A body on the way, under a load that stays.
        loads.add_pattern(scene, 0, 1.0).expect("a pattern");
        loads.add_contact(scene, &contact(&points[2], [40.0, 0.0, 0.0])).expect("a contact");
        for _ in 0..7 {
            scene.step(state, loads).expect("a step");
        }
        loads.clear();
        loads.add_pattern(scene, 0, -0.5).expect("a pattern");
        let contacts = points.map(|point| contact(&point, [f64::MAX; 3]));
        let (mut w, mut free) = (vec![f64::NAN; 144], [[f64::NAN; 3]; 4]);
        let mut work = vec![T::ZERO; scene.compliance_work(4)];
        scene.compliance(&contacts, &mut w, &mut work).expect("an operator");
        scene.free_motion(state, loads, &contacts, &mut free, &mut work).expect("a motion");

        // Symmetric to the bit, and positive definite.
        assert!((0..144).all(|k| w[k].to_bits() == w[k % 12 * 12 + k / 12].to_bits()));
        let matrix = Matrix::from_fn(12, 12, |i, j| w[12 * i + j]);
        let least = matrix.self_adjoint_eigenvalues(faer::Side::Lower).expect("converged")[0];
        assert!(least > 0.0, "{least}");

        let shown = |with: bool, state: &mut State<'_, T>, loads: &mut Loads<'_, T>| {
            let mut saved = vec![T::ZERO; scene.state_numbers()];
            state.save_into(&mut saved).expect("saved");
            if with {
                for (point, force) in points.iter().zip(FORCES) {
                    loads.add_contact(scene, &contact(point, force)).expect("a contact");
                }
            }
            scene.step(state, loads).expect("a step");
            let shown = points.map(|p| scene.point(state, &p, Field::Displacement).expect("a point"));
            state.restore(&saved).expect("restored");
            shown
        };
        let without = shown(false, state, loads);
        let with = shown(true, state, loads);
        let largest = with.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (c, (without, with)) in without.iter().zip(&with).enumerate() {
            for i in 0..3 {
                assert!((without[i] - free[c][i]).abs() <= tolerance * largest);
                let yields = (0..12).map(|k| w[12 * (3 * c + i) + k] * FORCES.as_flattened()[k]).sum::<f64>();
                let off = (free[c][i] + yields - with[i]).abs();
                assert!(off <= tolerance * largest, "contact {c}, {i}: {off:e} of {largest:e}");
            }
        }
        // The forces matter.
        assert!((with[0][2] - without[0][2]).abs() > 1e-3 * largest);
    });
}

#[test]
fn the_operator_says_what_a_step_does() {
    says_what_a_step_does::<f64>(exact(), StructureChoice::Exact, 1e-13);
    says_what_a_step_does::<f32>(exact(), StructureChoice::Exact, 2e-6);
    says_what_a_step_does::<f64>(bathe(), StructureChoice::Diagonal, 1e-13);
    says_what_a_step_does::<f32>(bathe(), StructureChoice::Diagonal, 2e-6);
}

#[test]
fn the_block_structure_has_no_operator() {
    let points = four(bathe());
    with_scene::<f64, _>(bathe(), &of(StructureChoice::Block), |scene, state, loads| {
        let contacts = [contact(&points[0], [0.0; 3])];
        let (mut w, mut work) = ([0.0; 9], vec![0.0; scene.compliance_work(1)]);
        assert_eq!(scene.compliance(&contacts, &mut w, &mut work), Err(LoadError::Mismatch));
        let free = scene.free_motion(state, loads, &contacts, &mut [[0.0; 3]], &mut work);
        assert_eq!(free, Err(StepError::Mismatch));
    });
}

/// `K⁻¹F` for a force at a place, of the short beam: three components at each mesh node.
fn static_answer(force: impl FnOnce(&Prepared) -> Vec<f64>) -> (Prepared, Vec<f64>) {
    let prepared = prepare(&problem(&short_beam()), &mut Stopwatch::new(&Silent), &Silent).expect("a model");
    let load = force(&prepared);
    let model = &prepared.body.model;
    let factor = prepared.symbolic.factorize(model.pencil().combine(0.0, 1.0)).expect("definite");
    let mut answer = Matrix::from_fn(load.len(), 1, |i, _| load[i]);
    Solve::new(&prepared.symbolic, 1, true).solve_in_place(&factor, answer.as_mut());
    let mut full = vec![0.0; model.dofs().n_dof()];
    let free: Vec<f64> = (0..load.len()).map(|i| answer[(i, 0)]).collect();
    model.dofs().expand_into(&free, &mut full);
    (prepared, full)
}

/// Mesh nodes of a place.
fn mesh_nodes(prepared: &Prepared, bytes: &[u8], point: &SurfacePoint) -> [u32; 3] {
    let file = File::parse(bytes).expect("a file");
    let section = file.section(SectionKind::NodeCoordinates).expect("coordinates");
    let places: Vec<f64> = section.numbers().expect("raw").iter().collect();
    point.place.corners().expect("a triangle").0.map(|node| {
        let place = &places[3 * node as usize..][..3];
        let near = |x: &[f64; 3]| x.iter().zip(place).all(|(a, b)| (a - b).abs() < 1e-9);
        prepared.body.model.mesh().nodes.iter().position(near).expect("a mesh node") as u32
    })
}

fn at(full: &[f64], nodes: [u32; 3], point: &SurfacePoint) -> [f64; 3] {
    [0, 1, 2]
        .map(|i| nodes.iter().zip(point.place.weights()).map(|(&n, w)| w * full[3 * n as usize + i]).sum())
}

/// What a scene shows at a place and at the probe after two seconds near critical damping.
fn settled(
    options: &SceneOptions,
    load: impl FnOnce(&Scene<'_, f64>, &mut Loads<'_, f64>),
) -> ([f64; 3], f64) {
    let options = SceneOptions { alpha: Some(200.0), ..*options };
    let point = four(exact())[1];
    with_scene::<f64, _>(exact(), &options, |scene, state, loads| {
        load(scene, loads);
        for _ in 0..2000 {
            scene.step(state, loads).expect("a step");
        }
        let probe = scene.probe(state, 0, Field::Displacement).expect("a probe");
        (scene.point(state, &point, Field::Displacement).expect("a point"), probe)
    })
}

fn off(found: [f64; 3], expected: [f64; 3]) -> f64 {
    let by = minus(found, expected);
    (dot(by, by) / dot(expected, expected)).sqrt()
}

#[test]
fn four_modes_and_the_residual_end_where_statics_says() {
    let point = four(exact())[1];
    let force = [3.0, 10.0, -20.0];
    let load = |scene: &Scene<'_, f64>, loads: &mut Loads<'_, f64>| {
        loads.add_contact(scene, &contact(&point, force)).expect("a contact");
    };
    let (prepared, full) = static_answer(|prepared| {
        let mut load = vec![0.0; prepared.body.n_dof()];
        let nodes = mesh_nodes(prepared, exact(), &point);
        prepared.body.model.add_point_force(&nodes, point.place.weights(), force, &mut load);
        load
    });
    let expected = at(&full, mesh_nodes(&prepared, exact(), &point), &point);
    let tip = full[3 * prepared.body.probes[0].nodes[0].0 as usize + 2];

    let (found, probe) = settled(&SceneOptions::default(), load);
    let bare = SceneOptions { residual: false, ..SceneOptions::default() };
    let (modes, modes_probe) = settled(&bare, load);
    println!("under the force {:.1e}, without residual {:.1e}", off(found, expected), off(modes, expected));
    println!("probe {:.1e}, without {:.1e}", (probe / tip - 1.0).abs(), (modes_probe / tip - 1.0).abs());
    assert!(off(found, expected) < 1e-9 && (probe / tip - 1.0).abs() < 1e-9);
    assert!(off(modes, expected) > 1e-3 && (modes_probe / tip - 1.0).abs() > 1e-3);

    // A body twice as stiff yields half as much.
    let (stiff, stiff_probe) = settled(&SceneOptions { stiffness: 2.0, ..SceneOptions::default() }, load);
    assert!(off(stiff, expected.map(|x| 0.5 * x)) < 1e-9 && (2.0 * stiff_probe / tip - 1.0).abs() < 1e-9);
}

#[test]
fn a_pattern_ends_where_statics_says() {
    let load = |scene: &Scene<'_, f64>, loads: &mut Loads<'_, f64>| {
        loads.add_pattern(scene, 0, 0.5).expect("a pattern");
    };
    let (prepared, full) =
        static_answer(|prepared| prepared.body.patterns[0].1.iter().map(|f| 0.5 * f).collect());
    let point = four(exact())[1];
    let expected = at(&full, mesh_nodes(&prepared, exact(), &point), &point);
    let tip = full[3 * prepared.body.probes[0].nodes[0].0 as usize + 2];
    let (found, probe) = settled(&SceneOptions::default(), load);
    assert!(off(found, expected) < 1e-9 && (probe / tip - 1.0).abs() < 1e-9);
    let bare = SceneOptions { residual: false, ..SceneOptions::default() };
    let (modes, _) = settled(&bare, load);
    assert!(off(modes, expected) > 1e-6);
}

/// Presses a sphere on a body without damping and checks every step; at how many places at once it pushed.
fn checked(bytes: &[u8], steps: usize, still_from: usize, path: impl Fn(usize) -> Sphere) -> usize {
    let file = File::parse(bytes).expect("a file");
    let body = Body::new(&file).expect("a surface");
    let with = SceneOptions { time_step: Some(1e-3), ..undamped() };
    let bare = SceneOptions { residual: false, ..with };
    let mut words: Vec<&str> = vec![];
    let (mut deepest, mut balance, mut most, mut highest) = (f64::NEG_INFINITY, 0.0_f64, 0, 0.0_f64);
    with_scene::<f64, _>(bytes, &with, |scene, state, loads| {
        // The same forces on the modes alone.
        with_scene::<f64, _>(bytes, &bare, |modes, mode_state, mode_loads| {
            let mut energy = 0.0;
            for step in 1..=steps {
                let sphere = path(step);
                let touches = press(&body, &sphere, scene, state, loads).expect("a step");
                let pushing: Vec<&Touch> = touches.iter().filter(|touch| touch.push() > 0.0).collect();
                mode_loads.clear();
                let point = |state: &State<'_, f64>, touch: &Touch| {
                    modes.point(state, &touch.point, Field::Displacement).expect("a point")
                };
                let mut work = 0.0;
                for touch in &pushing {
                    mode_loads.add_contact(modes, &contact(&touch.point, touch.force)).expect("a contact");
                    work -= dot(touch.force, point(mode_state, touch));
                }
                modes.step(mode_state, mode_loads).expect("a step");

                let mut kept = 0.0;
                for touch in &touches {
                    let depth = touch.depth(&sphere, scene, state).expect("a depth") / sphere.radius;
                    deepest = deepest.max(depth);
                    assert!(depth <= 1e-6, "step {step}: {depth:e}");
                    let end = scene.point(state, &touch.point, Field::Displacement).expect("a point");
                    if touch.push() > 0.0 {
                        // It pushes what touches it: the place lies in the sphere's tangent plane.
                        let [x, y, z] = [0, 1, 2].map(|i| touch.point.position[i] + end[i]);
                        let away = minus([x, y, z], sphere.centre);
                        let gap = dot(touch.normal, away) / sphere.radius - 1.0;
                        assert!(gap.abs() <= 1e-9, "step {step} pushes over a gap of {gap:e}");
                        work += dot(touch.force, point(mode_state, touch));
                        kept += 0.5 * dot(touch.force, minus(end, point(mode_state, touch)));
                    }
                    // The cone, and friction against the slide.
                    assert!(touch.friction() <= (1.0 + 1e-12) * sphere.friction * touch.push());
                    let slide = minus(minus(end, touch.start), sphere.moves);
                    let along = minus(touch.force, touch.normal.map(|n| n * touch.push()));
                    let rubs = dot(along, slide);
                    assert!(rubs <= 1e-12 * sphere.radius * touch.push(), "step {step}: {rubs:e}");
                    if words.last() != Some(&touch.word(&sphere)) && touch.point == touches[0].point {
                        words.push(touch.word(&sphere));
                    }
                }
                most = most.max(pushing.len());

                // Exact steps under held forces: what the modes gain is the work on them, and what the
                // residual stores is half of force times its share.
                let after = modes.energy(mode_state).expect("an energy");
                highest = highest.max(after);
                balance = balance.max((after - energy - work).abs() / highest.max(f64::MIN_POSITIVE));
                let whole = scene.energy(state).expect("an energy");
                assert!((whole - after - kept).abs() <= 1e-12 * highest && kept >= 0.0, "step {step}");
                assert!(balance <= 1e-10, "step {step}: {balance:e}");
                // A sphere that has lifted off gives nothing.
                if step > still_from {
                    assert!(pushing.is_empty());
                    assert!(after <= (1.0 + 1e-12) * energy, "step {step}: {after} after {energy}");
                }
                energy = after;
            }
        });
    });
    println!("deepest {deepest:.1e} of the radius, balance {balance:.1e}, {most} at once, {words:?}");
    assert!(["sticks", "slips", "open"].iter().all(|word| words.contains(word)), "{words:?}");
    most
}

fn pressed_beam() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| beam().expect("the example's beam"))
}

#[test]
fn a_sphere_on_the_beam_neither_goes_in_nor_gives_energy() {
    checked(pressed_beam(), 600, 500, path);
}

#[test]
fn a_sphere_on_the_liver_neither_goes_in_nor_gives_energy() {
    if shared("meshes/gmsh1/liver.msh").is_none() {
        return;
    }
    let text = fixture("liver.toml").replace("vtu/liverFine.vtu", "gmsh1/liver.msh");
    let bytes = built(&text.replace("scheme = { name = \"bathe\" }", "scheme = { name = \"exact\" }"));
    let file = File::parse(&bytes).expect("a file");
    let section = file.section(SectionKind::NodeCoordinates).expect("coordinates");
    let numbers: Vec<f64> = section.numbers().expect("raw").iter().collect();
    let nodes = &numbers.as_chunks::<3>().0[..file.metadata().n_load_nodes as usize];
    let top = *nodes.iter().max_by(|a, b| a[2].total_cmp(&b[2])).expect("a node");
    let extent =
        nodes.iter().map(|x| x[0]).fold(0.0, f64::max) - nodes.iter().map(|x| x[0]).fold(0.0, f64::min);
    let radius = 0.1 * extent;
    let path = drag(radius, top, [0.0, 0.5 * radius], [0.05 * radius, 0.1 * radius, 1.5 * radius]);
    checked(&bytes, 600, 500, path);
}

/// A sphere that comes down on a place from a height, presses to a depth, is dragged in x and y, and lifted.
fn drag(
    radius: f64,
    place: [f64; 3],
    over: [f64; 2],
    [height, depth, lift]: [f64; 3],
) -> impl Fn(usize) -> Sphere {
    move |step| {
        let at = |step: usize| {
            let share = |from: usize, steps: f64| (step.saturating_sub(from) as f64 / steps).min(1.0);
            let [x, y] = over.map(|way| way * share(100, 300.0));
            let above = height - (height + depth) * share(0, 100.0) + lift * share(400, 100.0);
            [place[0] + x, place[1] + y, place[2] + radius + above]
        };
        let centre = at(step);
        Sphere { radius, friction: 0.3, centre, moves: minus(centre, at(step - 1)) }
    }
}

#[test]
fn a_sphere_that_touches_at_several_places_does_neither() {
    let path = drag(20.0, [0.6, 0.04, 0.1], [0.2, 0.0], [1e-3, 2e-3, 20e-3]);
    let most = checked(pressed_beam(), 600, 500, path);
    assert!(most >= 3, "{most}");
}

#[test]
fn a_spring_as_stiff_as_that_does_not_stay_bounded() {
    let file = File::parse(pressed_beam()).expect("a file");
    let surface = Surface::new(&file).expect("a surface");
    with_scene::<f64, _>(pressed_beam(), &undamped(), |scene, state, loads| {
        let mut grown = 0.0_f64;
        for step in 1..=400 {
            let sphere = path(step);
            let touched = surface.locate(sphere.centre).expect("a place");
            let (mut w, mut work) = ([0.0; 9], vec![0.0; scene.compliance_work(1)]);
            scene.compliance(&[contact(&touched, [0.0; 3])], &mut w, &mut work).expect("an operator");
            let moved = scene.point(state, &touched, Field::Displacement).expect("a point");
            let depth = (touched.position[2] + moved[2] - (sphere.centre[2] - sphere.radius)).max(0.0);
            loads.clear();
            let force = [0.0, 0.0, -1e3 / w[8] * depth];
            loads.add_contact(scene, &contact(&touched, force)).expect("a contact");
            if scene.step(state, loads) == Err(StepError::NotFinite) {
                grown = f64::INFINITY;
                break;
            }
            grown = grown.max(scene.energy(state).expect("an energy"));
        }
        println!("a spring of 1000 / W: energy up to {grown:.1e} J");
        // The operator's sphere leaves less than 10 J in the same beam.
        assert!(grown > 1e6, "{grown}");
    });
}

#[test]
fn the_example_runs() {
    press_a_sphere::main().expect("a beam under a sphere");
}
