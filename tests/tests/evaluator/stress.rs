//! Stress, strain and gauges: closed forms, the stress of sparse statics under a held load with its elements
//! worked out here, the motion at full order, live stiffness, what rewriting keeps, and the program.

use std::sync::OnceLock;

use vademecum_build::Matrix;
use vademecum_build::fem::Solve;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{Contact, Field, Loads, OutputError, Scene, SceneOptions, State, Surface, Tensor};
use vademecum_format::{Element, File, SectionKind as S};
use vademecum_rewrite::{Keep, check, pack_within, strip, unpack};
use vademecum_tests::page::block;
use vademecum_tests::program::{repository, vademecum};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::rewritten;

fn problem(text: &str) -> Problem {
    Problem::parse(text, "p.toml", repository()).expect("a problem")
}

fn built(text: &str) -> Vec<u8> {
    build(&problem(text), &BuildOptions::default(), &Silent).expect("built").either().bytes
}

/// A bar on rollers, pulled at its end: one stress everywhere, whatever the elements.
fn bar(order: &str, output: &str) -> String {
    format!(
        r#"
[mesh]
block = {{ lengths = [0.4, 0.1, 0.1], divisions = [4, 2, 2], order = "{order}" }}
[[material]]
young = 2e6
poisson = 0.3
density = 1000.0
[[support]]
on = {{ group = "x_min" }}
components = ["x"]
[[support]]
on = {{ group = "y_min" }}
components = ["y"]
[[support]]
on = {{ group = "z_min" }}
components = ["z"]
[load]
[[load.pattern]]
name = "pull"
on = {{ group = "x_max" }}
traction = [700.0, 0.0, 0.0]
[time]
step = 1e-2
[damping]
ratio = 0.5
[basis]
modes = 4
[tolerance]
error = 10.0
[output]
{output}
[[output.gauge]]
name = "along"
point = [0.2, 0.03, 0.1]
direction = [2.0, 0.0, 0.0]
length = 0.15
[[output.gauge]]
name = "across"
point = [0.2, 0.05, 0.1]
direction = [0.0, 1.0, 0.0]
length = 0.05
"#
    )
}

#[test]
fn a_pulled_bar_has_the_stress_and_the_strains_of_the_textbook() {
    for order in ["linear", "quadratic"] {
        let bytes = built(&bar(order, "stress = \"body\""));
        with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads| {
            loads.add_pattern(scene, 0, 2.0).expect("added");
            settle(scene, state, loads, 400);
            assert!(scene.n_stress_points() >= 45);
            for point in 0..scene.n_stress_points() {
                let Tensor(stress) = scene.stress(state, point).expect("a stress");
                for (k, stress) in stress.into_iter().enumerate() {
                    let exact = if k == 0 { 1400.0 } else { 0.0 };
                    assert!((stress - exact).abs() < 1e-6, "{order}, point {point}, {k}: {stress}");
                }
                let Tensor([xx, yy, zz, xy, ..]) = scene.strain(state, point).expect("a strain");
                assert!((xx - 7e-4).abs() < 1e-12 && xy.abs() < 1e-12);
                assert!((yy + 2.1e-4).abs() < 1e-12 && (zz + 2.1e-4).abs() < 1e-12);
            }
            let gauge = |index| scene.probe(state, index, Field::Displacement).expect("a gauge");
            assert!((gauge(0) - 7e-4).abs() < 1e-12, "{order}: {}", gauge(0));
            assert!((gauge(1) + 2.1e-4).abs() < 1e-12, "{order}: {}", gauge(1));
            let count = scene.n_stress_points();
            let beyond = OutputError::OutOfRange { index: count, count };
            assert_eq!(scene.stress(state, count), Err(beyond));
            let mut all = vec![0.0; 6 * count];
            scene.stress_into(state, &mut all).expect("stresses");
            assert_eq!(all[6], scene.stress(state, 1).expect("a stress").0[0]);
            let wrong = OutputError::Length { found: 6 * count - 1, needed: 6 * count };
            assert_eq!(scene.stress_into(state, &mut all[1..]), Err(wrong));
        });
        let units = File::parse(&bytes).expect("a file").section(S::ProbeUnits).expect("units").text();
        assert_eq!(units, Ok("1\n1"));
    }
}

/// A bar under a temperature, between rollers at both ends if it is clamped.
fn heated(order: &str, clamped: bool, constants: &str) -> String {
    let pull = "on = { group = \"x_max\" }\ntraction = [700.0, 0.0, 0.0]";
    let end = "[[support]]\non = { group = \"x_max\" }\ncomponents = [\"x\"]\n[load]";
    bar(order, "stress = \"body\"")
        .replace(pull, "temperature = 20.0")
        .replace("poisson = 0.3", constants)
        .replace("step = 1e-2", "step = 4e-4")
        .replace("[load]", if clamped { end } else { "[load]" })
}

#[test]
fn a_heated_bar_has_no_stress_where_it_is_free_and_minus_e_alpha_where_it_is_clamped() {
    for order in ["linear", "quadratic"] {
        for clamped in [false, true] {
            let bytes = built(&heated(order, clamped, "poisson = 0.3\nexpansion = 1.5e-5"));
            check(&bytes).expect("a sound file");
            with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads| {
                loads.add_pattern(scene, 0, 2.0).expect("added");
                settle(scene, state, loads, 4000);
                let free = 1.5e-5 * 40.0;
                for point in 0..scene.n_stress_points() {
                    let Tensor(stress) = scene.stress(state, point).expect("a stress");
                    for (k, stress) in stress.into_iter().enumerate() {
                        let exact = if k == 0 && clamped { -2e6 * free } else { 0.0 };
                        assert!((stress - exact).abs() < 1e-6, "{order}, point {point}, {k}: {stress}");
                    }
                }
                let gauge = |index| scene.probe(state, index, Field::Displacement).expect("a gauge");
                let [along, across] = if clamped { [0.0, 1.3 * free] } else { [free, free] };
                assert!((gauge(0) - along).abs() < 1e-12, "{order}: {}", gauge(0));
                assert!((gauge(1) - across).abs() < 1e-12, "{order}: {}", gauge(1));
            });
        }
    }
    // One coefficient for each axis of the material.
    let axes = "poisson = 0.3\nexpansion = [1e-5, 2e-5, 3e-5]";
    let bytes = built(&heated("quadratic", false, axes));
    with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads| {
        loads.add_pattern(scene, 0, 1.0).expect("added");
        settle(scene, state, loads, 4000);
        let gauge = |index| scene.probe(state, index, Field::Displacement).expect("a gauge");
        assert!((gauge(0) - 2e-4).abs() < 1e-12 && (gauge(1) - 4e-4).abs() < 1e-12);
        let Tensor(stress) = scene.stress(state, 5).expect("a stress");
        assert!(stress.iter().all(|stress| stress.abs() < 1e-6), "{stress:?}");
    });
}

#[test]
fn a_pulled_bar_of_wood_has_the_strains_of_its_axes() {
    let wood = "orthotropic = { young = [5e6, 2e6, 1e6], poisson = [0.35, 0.3, 0.25], shear = [1e6, 8e5, 6e5] }\n\
                axes = [[0.0, 2.0, 0.0], [1.0, 0.0, 0.0]]";
    for order in ["linear", "quadratic"] {
        let text = bar(order, "stress = \"body\"").replace("young = 2e6\npoisson = 0.3", wood);
        let bytes = built(&text);
        let file = File::parse(&bytes).expect("a file");
        assert!(file.section(S::ElasticConstants).is_none() && file.section(S::Compliance).is_some());
        check(&bytes).expect("a sound file");
        with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads| {
            loads.add_pattern(scene, 0, 2.0).expect("added");
            settle(scene, state, loads, 400);
            for point in 0..scene.n_stress_points() {
                let Tensor(stress) = scene.stress(state, point).expect("a stress");
                let off = |k: usize| (stress[k] - if k == 0 { 1400.0 } else { 0.0 }).abs();
                assert!((0..6).all(|k| off(k) < 1e-6), "{order}, point {point}: {stress:?}");
                // The second axis of the material lies along x, the first one along y.
                let expected = [1400.0 / 2e6, -0.35 * 1400.0 / 5e6, -0.25 * 1400.0 / 2e6, 0.0, 0.0, 0.0];
                let Tensor(strain) = scene.strain(state, point).expect("a strain");
                let off = strain.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-12, "{order}, point {point}: {strain:?}");
            }
            let gauge = |index| scene.probe(state, index, Field::Displacement).expect("a gauge");
            assert!((gauge(0) - 7e-4).abs() < 1e-12 && (gauge(1) + 9.8e-5).abs() < 1e-12);
        });
    }
}

/// Two materials, linear elements, few modes: point forces move it where the modes cannot follow.
fn cube(output: &str) -> String {
    format!(
        r#"
[mesh]
block = {{ lengths = [0.1, 0.1, 0.1], divisions = [3, 3, 3], order = "linear" }}
[[mesh.region]]
name = "stiff"
on = {{ box = {{ min = [0.06, -1.0, -1.0], max = [1.0, 1.0, 1.0] }} }}
[[material]]
young = 2e6
poisson = 0.3
density = 1000.0
[[material]]
region = "stiff"
young = 9e6
poisson = 0.2
density = 1500.0
[[support]]
on = {{ group = "x_min" }}
[load]
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
[time]
step = 1e-3
[damping]
alpha = 5.0
beta = 2e-4
[[parameter]]
name = "stiffness"
kind = "stiffness"
range = [0.5, 2.0]
[basis]
modes = 4
[tolerance]
error = 10.0
[output]
{output}
"#
    )
}

fn cube_bytes() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| built(&cube("stress = \"body\"")))
}

const FORCE: [f64; 3] = [3.0, 10.0, -20.0];

/// Stress under the force and half of gravity by sparse statics: `K⁻¹F`, then each linear element's gradient
/// from the inverse of its edges, and the mean of each region's elements at a node.
fn by_statics(bytes: &[u8]) -> Vec<[f64; 6]> {
    let prepared: Prepared =
        prepare(&problem(&cube("")), &mut Stopwatch::new(&Silent), &Silent).expect("a model");
    let (model, file) = (&prepared.body.model, File::parse(bytes).expect("a file"));
    let ids = file.section(S::NodeIds).expect("ids").u64s().expect("raw");
    let node = |id: &[u8; 8]| {
        let id = u64::from_le_bytes(*id);
        model.mesh().node_ids.iter().position(|&other| other == id).expect("a mesh node")
    };
    let nodes: Vec<usize> = ids.iter().map(node).collect();
    let touched = Surface::new(&file).expect("a surface").locate([0.08, 0.03, 0.1]).expect("a place");
    let mut force: Vec<f64> = prepared.body.patterns[0].1.iter().map(|f| 0.5 * f).collect();
    let places = touched.place.corners().expect("a triangle").0.map(|n| nodes[n as usize] as u32);
    model.add_point_force(&places, touched.place.weights(), FORCE, &mut force);
    let factor = prepared.symbolic.factorize(model.pencil().combine(0.0, 1.0)).expect("definite");
    let mut answer = Matrix::from_fn(force.len(), 1, |i, _| force[i]);
    Solve::new(&prepared.symbolic, 1, true).solve_in_place(&factor, answer.as_mut());
    let free: Vec<f64> = (0..force.len()).map(|i| answer[(i, 0)]).collect();
    let mut u = vec![0.0; model.dofs().n_dof()];
    model.dofs().expand_into(&free, &mut u);

    let mesh = model.mesh();
    let constants = [(2e6, 0.3), (9e6, 0.2)];
    let element_stress = |e: usize| {
        let corners: [usize; 4] = std::array::from_fn(|k| mesh.element(e)[k] as usize);
        let edge = |k: usize, of: &dyn Fn(usize, usize) -> f64| -> [f64; 3] {
            std::array::from_fn(|c| of(corners[k + 1], c) - of(corners[0], c))
        };
        let x: [[f64; 3]; 3] = std::array::from_fn(|k| edge(k, &|n, c| mesh.nodes[n][c]));
        let moved: [[f64; 3]; 3] = std::array::from_fn(|k| edge(k, &|n, c| u[3 * n + c]));
        // x ∇uᵀ = moved, by Cramer's rule.
        let det = |m: [[f64; 3]; 3]| {
            m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
                - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
                + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
        };
        let gradient = |i: usize, j: usize| {
            let mut with = x;
            (0..3).for_each(|k| with[k][j] = moved[k][i]);
            det(with) / det(x)
        };
        let (young, poisson) = constants[mesh.element_region[e] as usize];
        let mu = young / (2.0 * (1.0 + poisson));
        let lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
        let trace = gradient(0, 0) + gradient(1, 1) + gradient(2, 2);
        [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]
            .map(|(i, j)| mu * (gradient(i, j) + gradient(j, i)) + if i == j { lambda * trace } else { 0.0 })
    };
    let stresses: Vec<[f64; 6]> = (0..mesh.element_count()).map(element_stress).collect();
    let points = file.section(S::StressPoints).expect("points").u32s().expect("raw");
    let at = |pair: &[[u8; 4]; 2]| {
        let [node, region] = pair.map(u32::from_le_bytes);
        let own = |e: &usize| {
            mesh.element_region[*e] == region && mesh.element(*e).contains(&(nodes[node as usize] as u32))
        };
        let around: Vec<usize> = (0..mesh.element_count()).filter(own).collect();
        assert!(!around.is_empty());
        std::array::from_fn(|k| around.iter().map(|&e| stresses[e][k]).sum::<f64>() / around.len() as f64)
    };
    points.as_chunks::<2>().0.iter().map(at).collect()
}

/// The stresses that a file shows after two seconds under loads that stay.
fn shown(bytes: &[u8], options: &SceneOptions) -> Vec<[f64; 6]> {
    let touched = {
        let file = File::parse(bytes).expect("a file");
        Surface::new(&file).expect("a surface").locate([0.08, 0.03, 0.1]).expect("a place")
    };
    with_scene::<f64, _>(bytes, options, |scene, state, loads| {
        let contact = Contact::new(touched.place, FORCE);
        loads.add_contact(scene, &contact).expect("added");
        loads.add_pattern(scene, 0, 0.5).expect("added");
        settle(scene, state, loads, 4000);
        let stress = |point| scene.stress(state, point).expect("a stress").0;
        (0..scene.n_stress_points()).map(stress).collect()
    })
}

/// A strain under gravity at a stiffness of the whole body.
fn settled_strain(stiffness: f64) -> f64 {
    let options = SceneOptions { stiffness, ..SceneOptions::default() };
    with_scene::<f64, _>(cube_bytes(), &options, |scene, state, loads| {
        loads.add_pattern(scene, 0, 1.0).expect("added");
        settle(scene, state, loads, 4000);
        scene.strain(state, 7).expect("a strain").0[0]
    })
}

/// Steps under loads that stay.
fn settle(scene: &Scene<'_, f64>, state: &mut State<'_, f64>, loads: &Loads<'_, f64>, steps: usize) {
    for _ in 0..steps {
        scene.step(state, loads).expect("a step");
    }
}

/// Largest difference of any component, as a share of the largest of the second.
fn apart(a: &[[f64; 6]], b: &[[f64; 6]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = b.as_flattened().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let off = a.as_flattened().iter().zip(b.as_flattened()).fold(0.0, |m: f64, (x, y)| m.max((x - y).abs()));
    off / largest
}

#[test]
fn four_modes_and_the_residual_end_at_the_stress_of_sparse_statics() {
    let exact = by_statics(cube_bytes());
    let options = SceneOptions::default();
    let with = apart(&shown(cube_bytes(), &options), &exact);
    let without = apart(&shown(cube_bytes(), &SceneOptions { residual: false, ..options }), &exact);
    println!("stress under a contact and gravity: {with:.1e} with the residual, {without:.1e} without");
    assert!(with < 1e-9, "{with:e}");
    assert!(without > 0.3, "{without:e}: the modes alone would do");
}

#[test]
fn the_stress_under_a_force_does_not_depend_on_the_stiffness_of_the_whole_body() {
    let exact = by_statics(cube_bytes());
    let options = SceneOptions { stiffness: 1.7, ..SceneOptions::default() };
    assert!(apart(&shown(cube_bytes(), &options), &exact) < 1e-9);
    let strains = [1.0, 1.7].map(settled_strain);
    assert!((strains[0] / strains[1] / 1.7 - 1.0).abs() < 1e-9, "{strains:?}");
}

#[test]
fn a_file_keeps_the_stress_under_contacts_where_it_is_small_or_asked_for() {
    let kinds = |bytes: &[u8]| {
        let file = File::parse(bytes).expect("a file");
        [S::StressBasis, S::StressResidual, S::PatternStress].map(|kind| file.section(kind).is_some())
    };
    assert_eq!(kinds(cube_bytes()), [true; 3]);
    assert_eq!(kinds(&built(&cube("stress = \"surface\"\nstress_residual = false"))), [true, false, true]);
    assert_eq!(kinds(&built(&cube("stress = \"surface\"\nresidual = false"))), [true, false, false]);
    assert_eq!(kinds(&built(&cube(""))), [false; 3]);
    let chosen = built(&cube("stress = { plane = { axis = \"x\", at = 0.0 } }"));
    let points = File::parse(&chosen).expect("a file").section(S::StressPoints).expect("points").shape();
    assert_eq!(points, [16, 2, 1]);
}

#[test]
fn rewriting_keeps_the_stress_or_takes_it_all_away() {
    let exact = shown(cube_bytes(), &SceneOptions::default());
    assert!(check(cube_bytes()).is_ok());
    let packed = pack_within(cube_bytes(), 3, 1e-4).expect("packed");
    let bytes = unpack(&packed, 1 << 30).expect("unpacked");
    let rounded = apart(&shown(&bytes, &SceneOptions::default()), &exact);
    assert!(rounded > 0.0 && rounded < 1e-3, "{rounded:e}");
    let probes = strip(&built(&bar("linear", "stress = \"body\"")), Keep::Probes).expect("stripped");
    let file = File::parse(&probes).expect("a file");
    assert!(file.section(S::StressPoints).is_none() && file.section(S::ProbeUnits).is_some());
    assert!(check(&probes).is_ok());
}

#[test]
fn what_contradicts_itself_is_refused() {
    let drop_of = |gone: S| {
        rewritten(
            cube_bytes(),
            |_| (),
            |section| {
                if section.kind == gone {
                    section.kind = S::Losses;
                    section.element = Element::F64;
                    section.shape = [0, 4, 1];
                    section.decoded_length = 0;
                    section.stored = &[];
                }
            },
            &[],
        )
    };
    for (gone, refused) in [
        (S::StressPoints, true),
        (S::StressBasis, true),
        (S::ElasticConstants, true),
        (S::StressResidual, false),
        (S::PatternStress, false),
    ] {
        assert_eq!(check(&drop_of(gone)).is_err(), refused, "{gone}");
    }
}

#[test]
fn the_program_shows_stress_and_compares_it_with_the_full_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let text = bar("quadratic", "stress = \"surface\"").replace("ratio = 0.5", "ratio = 0.02");
    std::fs::write(at("p.toml"), &text).expect("written");
    let scenario = "duration = 0.2\n[[contact]]\npoint = [0.3, 0.05, 0.1]\nforce = [0.0, 2.0, -5.0]\nramp = 0.05\n\
                    [output]\nstress_every = 10\nfields_every = 20\n\
                    [[output.stress]]\nname = \"top\"\npoint = [0.2, 0.05, 0.1]\n\
                    [[output.stress]]\nname = \"xx\"\npoint = [0.2, 0.05, 0.1]\nquantity = \"xx\"\n";
    std::fs::write(at("s.toml"), scenario).expect("written");
    assert_eq!(vademecum(&["build", &at("p.toml"), "-o", &at("b.vdm")]).code, Some(0));
    let run = ["run", &at("b.vdm"), "--scenario", &at("s.toml"), "-o", &at("out"), "--json"];
    let told = vademecum(&run).json();
    let largest = told["largest_stress"]["von_mises"].as_f64().expect("a stress");
    let table = std::fs::read_to_string(at("out/stress.csv")).expect("a table");
    let equivalent = |line: &str| line.rsplit(',').next().and_then(|x| x.parse::<f64>().ok());
    let most = table.lines().filter_map(equivalent).fold(0.0, f64::max);
    assert!(largest > 100.0 && most <= largest * (1.0 + 1e-9) && most > 0.5 * largest, "{most} {largest}");
    let probes = std::fs::read_to_string(at("out/probes.csv")).expect("a table");
    assert!(probes.starts_with("time_s,energy_J,along [1],across [1],top [Pa],xx [Pa]\n"), "{probes:.80}");
    let field = std::fs::read(at("out/field-000001.vtu")).expect("a field");
    let head = String::from_utf8_lossy(&field[..2000]).into_owned();
    assert!(head.contains("Name=\"stress\" NumberOfComponents=\"6\"") && head.contains("Name=\"von_mises\""));
    let verify = ["verify", &at("b.vdm"), "--problem", &at("p.toml"), "--scenario", &at("s.toml"), "--json"];
    let error = vademecum(&verify).json()["stress_error"].as_f64().expect("an error");
    println!("stress against the full order, 4 modes: {error:.1e}");
    assert!(error > 0.0 && error < 0.02, "{error:e}");
    // A file without stress is asked for it.
    let without = text.replace("stress = \"surface\"", "");
    std::fs::write(at("q.toml"), without).expect("written");
    assert_eq!(vademecum(&["build", &at("q.toml"), "-o", &at("q.vdm")]).code, Some(0));
    let run = ["run", &at("q.vdm"), "--scenario", &at("s.toml"), "-o", &at("no")];
    vademecum(&run).fails(3, &["output.stress", "the file has no stress"]);
}

#[test]
fn the_page_does_what_it_says() {
    let page = std::fs::read_to_string(repository().join("docs/how-to/stress.md")).expect("the page");
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(at("beam.toml"), block(&page, "toml\n# beam.toml")).expect("written");
    std::fs::write(at("push.toml"), block(&page, "toml\n# push.toml")).expect("written");
    let ran = vademecum(&["build", &at("beam.toml"), "-o", &at("beam.vdm")]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let run = ["run", &at("beam.vdm"), "--scenario", &at("push.toml"), "-o", &at("out"), "--json"];
    assert_eq!(vademecum(&run).json()["probes"], serde_json::json!(["top", "bending"]));
    let table = std::fs::read_to_string(at("out/probes.csv")).expect("a table");
    let last: Vec<f64> =
        table.lines().last().expect("rows").split(',').map(|x| x.parse().expect("a number")).collect();
    let said: Vec<f64> =
        block(&page, "text\ntop").split_whitespace().filter_map(|x| x.parse().ok()).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!((last[2] / said[0] - 1.0).abs() < 1e-4 && (last[3] / said[1] - 1.0).abs() < 1e-3, "{last:?}");
    // By hand: F (l − x) h / 2EI, with I = b h³ / 12.
    let inertia = 0.04 * 0.05_f64.powi(3) / 12.0;
    let strain = 10.0 * 0.25 * 0.025 / (2.1e9 * inertia);
    assert!((last[2] / strain - 1.0).abs() < 1e-6, "{} {strain}", last[2]);
    assert!((last[3] / (2.1e9 * strain) - 1.0).abs() < 0.01, "{}", last[3]);
}
