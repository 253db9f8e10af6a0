//! Reactions of supports against an own full order that keeps the rows of the held dofs, and in equilibrium
//! with loads and inertia to rounding.

use faer::Mat;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::{File, SectionInput, SectionKind, encode_into, encoded_len};
use vademecum_eval::{Contact, OutputError, SceneOptions, Simulation, StructureChoice, Surface};
use vademecum_rewrite::{Fault, Keep, RewriteError, check, pack, strip, unpack};
use vademecum_study::live::at_values;
use vademecum_study::parameters::ParameterValue;
use vademecum_tests::held_rows::{Full, Scaled, add_at};
use vademecum_tests::page::block;
use vademecum_tests::program::{repository, vademecum};
use vademecum_tests::stage::with_scene;

/// A beam of linear tetrahedra, few enough dofs to keep all modes: clamped at one end, on a roller at the
/// other, and held sideways on an edge of which the roller holds one component already.
const ALL_MODES: &str = r#"
[mesh]
block = { lengths = [1.0, 0.1, 0.2], divisions = [5, 1, 1], order = "linear" }
[[material]]
young = 2e9
poisson = 0.3
density = 1200.0
[[support]]
name = "clamp"
on = { group = "x_min" }
[[support]]
on = { group = "x_max" }
components = ["z"]
[[support]]
name = "edge"
on = { all = [{ group = "x_max" }, { group = "y_min" }] }
components = ["y", "z"]
[[load.pattern]]
name = "gravity"
acceleration = [0.5, 1.0, -9.81]
[[load.pattern]]
name = "wind"
on = { group = "z_max" }
pressure = 300.0
[basis]
modes = 54
[output]
precision = "f64"
reactions = true
"#;

/// Quadratic tetrahedra under one support, and a basis that leaves most out.
fn few_modes(modes: usize) -> String {
    let divisions = "divisions = [4, 1, 1], order = \"quadratic\"";
    let supported = "[[support]]\non = { group = \"x_min\" }\n[[load.pattern]]\nname = \"gravity\"";
    let text = ALL_MODES.replace("divisions = [5, 1, 1], order = \"linear\"", divisions);
    let (first, rest) = text.split_once("[[support]]").expect("supports");
    let (_, rest) = rest.split_once("[[load.pattern]]\nname = \"gravity\"").expect("a pattern");
    format!("{first}{supported}{rest}").replace("modes = 54", &format!("modes = {modes}"))
}

fn problem(text: &str) -> Problem {
    Problem::parse(text, "p.toml", std::path::PathBuf::new()).expect("a problem")
}

fn built(text: &str) -> Vec<u8> {
    build(&problem(text), &BuildOptions::default(), &Silent).expect("a file").either().bytes
}

/// A push and what comes after it: reactions of all supports after each step, by the evaluator and at full
/// order.
fn marched(
    text: &str,
    bytes: &[u8],
    model: Scaled,
    options: &SceneOptions,
    (point, force): ([f64; 3], [f64; 3]),
    steps: [usize; 2],
) -> Vec<[Vec<[f64; 6]>; 2]> {
    let full = Full::of(&problem(text));
    let file = File::parse(bytes).expect("a file");
    let place = Surface::new(&file).expect("a surface").locate(point).expect("a triangle");
    let contact = Contact::new(place.place, force);
    let mut load = full.contact(&contact);
    // Both patterns act, too, the second pulling.
    let n_patterns = full.body.patterns.len();
    for (p, amplitude) in [(0, 1.0), (1, -0.5)] {
        let dofs = full.body.model.dofs();
        for (free, f) in full.body.patterns[p].1.iter().enumerate() {
            load[dofs.dof_of_free()[free] as usize] += amplitude * f;
        }
        full.body.held_loads[p].iter().for_each(|&(dof, f)| load[dof as usize] += amplitude * f);
    }
    assert_eq!(n_patterns, 2);
    let of_modes = full.on_modes(&load);
    let nothing = vec![0.0; load.len()];
    with_scene::<f64, _>(bytes, options, |scene, state, loads| {
        loads.add_contact(scene, &contact).expect("a contact");
        loads.add_pattern(scene, 0, 1.0).expect("a pattern");
        loads.add_pattern(scene, 1, -0.5).expect("a pattern");
        let dt = scene.parameters().time_step;
        let count = full.body.supports.len();
        assert_eq!(scene.n_supports(), count);
        let mut found = vec![];
        let mut released = vec![];
        for step in 1..=steps[0] + steps[1] {
            let pushed = step <= steps[0];
            if step == steps[0] + 1 {
                loads.clear();
            }
            scene.step(state, loads).expect("a step");
            let start = steps[0].min(step) as f64 * dt;
            let mut motion: Vec<[f64; 3]> = full
                .eigenvalues
                .iter()
                .zip(&of_modes)
                .map(|(&lambda, &f)| model.after(lambda, f, [0.0; 3], start))
                .collect();
            if pushed {
                released.clone_from(&motion);
            } else {
                let t = (step - steps[0]) as f64 * dt;
                let from = full.eigenvalues.iter().zip(&released);
                motion = from.map(|(&lambda, &from)| model.after(lambda, 0.0, from, t)).collect();
            }
            let acting = if pushed { &load } else { &nothing };
            let evaluated = (0..count).map(|s| scene.reaction(state, s).expect("a reaction").total());
            let exact = (0..count).map(|s| full.reaction(s, &model, &motion, acting));
            found.push([evaluated.collect(), exact.collect()]);
        }
        found
    })
}

/// Largest difference of two histories over the largest value of the same kind (force or moment).
fn apart(found: &[[Vec<[f64; 6]>; 2]]) -> f64 {
    let mut worst: f64 = 0.0;
    for kind in [0..3, 3..6] {
        let (mut most, mut size) = (0.0f64, 0.0f64);
        for [evaluated, exact] in found {
            for (a, b) in evaluated.iter().zip(exact) {
                for c in kind.clone() {
                    most = most.max((a[c] - b[c]).abs());
                    size = size.max(b[c].abs());
                }
            }
        }
        assert!(size > 0.0);
        worst = worst.max(most / size);
    }
    worst
}

/// Root of the mean square of the difference over that of the full order, forces and moments apart.
fn rms(found: &[[Vec<[f64; 6]>; 2]]) -> f64 {
    let sum = |kind: std::ops::Range<usize>| {
        let (mut off, mut whole) = (0.0, 0.0);
        for (a, b) in found.iter().flat_map(|[a, b]| a.iter().zip(b)) {
            off += kind.clone().map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
            whole += kind.clone().map(|c| b[c].powi(2)).sum::<f64>();
        }
        f64::sqrt(off / whole)
    };
    sum(0..3).max(sum(3..6))
}

const PUSH: ([f64; 3], [f64; 3]) = ([0.63, 0.05, 0.2], [3.0, -20.0, -70.0]);

#[test]
fn with_all_modes_reactions_are_those_of_the_full_order() {
    let alive = Scaled { stiffness: 1.7, density: 0.6, alpha: 12.0, beta: 3e-5, ratio: 0.0 };
    let damped = ALL_MODES.replace("[basis]", "[damping]\nratio = 0.03\n[basis]");
    let ratio = Scaled { ratio: 0.03, ..Scaled::AS_BUILT };
    for (text, model) in [(ALL_MODES, Scaled::AS_BUILT), (ALL_MODES, alive), (&damped, ratio)] {
        let bytes = built(text);
        check(&bytes).expect("sound");
        assert_eq!(File::parse(&bytes).expect("a file").metadata().n_modes, 54);
        let found = marched(text, &bytes, model, &model.options(), PUSH, [40, 40]);
        let off = apart(&found);
        println!("all modes: {off:.1e}");
        assert!(off < 1e-9, "{off:e}");
        // A scene without the residual flexibility gives them, too.
        let bare = SceneOptions { residual: false, ..model.options() };
        let off = apart(&marched(text, &bytes, model, &bare, PUSH, [5, 5]));
        assert!(off < 1e-9, "{off:e}");
    }
}

#[test]
fn a_contact_on_the_support_goes_into_it() {
    let bytes = built(ALL_MODES);
    // On the edge of the clamp, so that held nodes carry a part.
    let push = ([0.001, 0.05, 0.2], [3.0, -20.0, -70.0]);
    let found = marched(ALL_MODES, &bytes, Scaled::AS_BUILT, &SceneOptions::default(), push, [10, 0]);
    assert!(apart(&found) < 1e-9, "{:e}", apart(&found));
}

#[test]
fn few_modes_carry_reactions_of_pushes_they_were_not_made_for() {
    let alive = Scaled { alpha: 20.0, beta: 2e-5, ..Scaled::AS_BUILT };
    for (model, bound) in [(Scaled::AS_BUILT, 0.08), (alive, 0.02)] {
        for modes in [6, 24] {
            let text = few_modes(modes);
            let bytes = built(&text);
            let found = marched(&text, &bytes, model, &model.options(), PUSH, [60, 120]);
            let off = rms(&found);
            println!("{modes} modes, alpha {}: {off:.1e}", model.alpha);
            assert!(off < bound, "{modes} modes: {off:e}");
        }
    }
}

#[test]
fn without_motion_reactions_are_the_static_ones_whatever_the_modes() {
    let text = few_modes(2);
    let bytes = built(&text);
    let full = Full::of(&problem(&text));
    // All of the weight hangs on the clamp, that of its own nodes with it.
    let weight = 1200.0 * 0.1 * 0.2;
    with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads| {
        loads.add_pattern(scene, 0, 1.0).expect("a pattern");
        scene.step(state, loads).expect("a step");
        let reaction = scene.reaction(state, 0).expect("a reaction");
        let at = scene.support_point(0).expect("a point");
        assert_eq!(at, full.body.supports[0].point);
        for (found, acceleration) in reaction.at_rest.iter().zip([0.5, 1.0, -9.81]) {
            assert!((found + weight * acceleration).abs() < 1e-9 * weight, "{found}");
        }
        // Half of the length away from the clamp: M = −r × W.
        for (found, expected) in reaction.at_rest[3..].iter().zip([0.0, -0.5 * 9.81 * weight, -0.5 * weight])
        {
            assert!((found - expected).abs() < 1e-9 * weight, "{found} {expected}");
        }
    });
}

/// Three supports, a quadratic mesh, few modes.
fn three_supports() -> String {
    let text = ALL_MODES.replace("divisions = [5, 1, 1], order = \"linear\"", "divisions = [6, 1, 1]");
    text.replace("modes = 54", "modes = 7").replace("[basis]", "[damping]\nratio = 0.01\n[basis]")
}

#[test]
fn reactions_loads_and_inertia_are_in_equilibrium() {
    let mut worst: f64 = 0.0;
    for (text, alpha) in [(ALL_MODES.to_string(), 0.0), (few_modes(6), 30.0), (three_supports(), 10.0)] {
        let bytes = built(&text);
        let full = Full::of(&problem(&text));
        let file = File::parse(&bytes).expect("a file");
        let numbers = |kind| -> Vec<f64> {
            let section = file.section(kind).expect("present");
            section.numbers().expect("raw").iter().collect()
        };
        let r = file.metadata().n_modes as usize;
        let (mesh, dofs) = (full.body.model.mesh(), full.body.model.dofs());
        // Momentum of each mode: force-like parts along the axes, then moments about the origin.
        let mut rows = numbers(SectionKind::SurfaceBasis);
        if file.section(SectionKind::InteriorBasis).is_some() {
            rows.extend(numbers(SectionKind::InteriorBasis));
        }
        let basis = Mat::from_fn(dofs.n_free(), r, |free, k| {
            let dof = dofs.dof_of_free()[free] as usize;
            rows[(3 * full.order.file_node[dof / 3] as usize + dof % 3) * r + k]
        });
        let heavy = &full.mass * &basis;
        let resultant = |load: &dyn Fn(usize) -> f64| {
            let mut sum = [0.0; 6];
            (0..dofs.n_dof()).for_each(|d| add_at(&mut sum, mesh.nodes[d / 3], [0.0; 3], d % 3, load(d)));
            sum
        };
        let momenta: Vec<[f64; 6]> = (0..r).map(|k| resultant(&|dof| heavy[(dof, k)])).collect();
        let ratios = if text.contains("ratio = 0.01") { 0.01 } else { 0.0 };
        let eigenvalues = numbers(SectionKind::Eigenvalues);
        let options = SceneOptions { alpha: Some(alpha), beta: Some(1e-5), ..SceneOptions::default() };
        let surface = Surface::new(&file).expect("a surface");
        with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
            let dt = scene.parameters().time_step;
            let mut random = vademecum_build::linalg::Random::new(7);
            for push in 0..12 {
                let mut place = || random.uniform();
                let point = [place(), 0.1 * place(), 0.2 * place()];
                let force = [0; 3].map(|_| 100.0 * (random.uniform() - 0.5));
                let at = surface.locate(point).expect("a triangle");
                let contact = Contact::new(at.place, force);
                loads.clear();
                loads.add_contact(scene, &contact).expect("a contact");
                let amplitude = random.uniform() - 0.5;
                loads.add_pattern(scene, push % 2, amplitude).expect("a pattern");
                for _ in 0..7 {
                    scene.step(state, loads).expect("a step");
                }
                let mut load = full.contact(&contact);
                let (pattern, held) = (&full.body.patterns[push % 2].1, &full.body.held_loads[push % 2]);
                let free = dofs.dof_of_free().iter().zip(pattern).map(|(&dof, &f)| (dof, f));
                free.chain(held.iter().copied()).for_each(|(dof, f)| load[dof as usize] += amplitude * f);
                // BᵀF, by the rows of the file.
                let force = |k: usize| -> f64 {
                    (0..dofs.n_free()).map(|i| basis[(i, k)] * load[dofs.dof_of_free()[i] as usize]).sum()
                };
                let mut sum = resultant(&|dof| load[dof]);
                let mut size = sum.map(f64::abs);
                for k in 0..r {
                    let (z, v, lambda) = (state.zeta()[k], state.scaled_velocity()[k] / dt, eigenvalues[k]);
                    let decay = alpha + 1e-5 * lambda + 2.0 * ratios * lambda.sqrt();
                    let change = force(k) - decay * v - lambda * z + alpha * v;
                    (0..6).for_each(|c| sum[c] -= momenta[k][c] * change);
                    (0..6).for_each(|c| size[c] = size[c].max((momenta[k][c] * change).abs()));
                }
                for s in 0..scene.n_supports() {
                    let [x, y, z] = scene.support_point(s).expect("a point");
                    let [fx, fy, fz, mx, my, mz] = scene.reaction(state, s).expect("a reaction").total();
                    let about = [mx + y * fz - z * fy, my + z * fx - x * fz, mz + x * fy - y * fx];
                    let all = [fx, fy, fz, about[0], about[1], about[2]];
                    (0..6).for_each(|c| sum[c] += all[c]);
                    (0..6).for_each(|c| size[c] = size[c].max(all[c].abs()));
                }
                for kind in [0..3, 3..6] {
                    let largest = size[kind.clone()].iter().fold(0.0, |m: f64, x| m.max(*x));
                    let left = sum[kind].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                    assert!(largest > 0.0 && left < 1e-9 * largest, "{left:e} of {largest:e}");
                    worst = worst.max(left / largest);
                }
            }
        });
    }
    println!("equilibrium: {worst:.1e}");
}

#[test]
fn every_structure_of_a_file_gives_reactions() {
    let text = few_modes(6).replace("[basis]", "[time]\nscheme = { name = \"bathe\" }\nstep = 2e-4\n[basis]");
    let bytes = built(&text);
    let mut last = vec![];
    for structure in [StructureChoice::Exact, StructureChoice::Diagonal, StructureChoice::Block] {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        last.push(with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
            for step in 0..200 {
                // A load that rises slowly excites what all three step alike.
                let amplitude = [f64::from(step), f64::from(step + 1), f64::from(step + 1), 0.0];
                let amplitudes = match structure {
                    StructureChoice::Exact => amplitude,
                    _ => scene.instants().map(|c| f64::from(step) + c),
                };
                loads.clear();
                loads.add_pattern_staged(scene, 0, &amplitudes.map(|a| a / 200.0)).expect("a pattern");
                scene.step(state, loads).expect("a step");
            }
            scene.reaction(state, 0).expect("a reaction").total()
        }));
    }
    let [exact, ..] = last[..] else { panic!("three structures") };
    for other in &last[1..] {
        for kind in [0..3, 3..6] {
            let size = kind.clone().map(|c| exact[c].abs()).fold(0.0, f64::max);
            let off = kind.map(|c| (other[c] - exact[c]).abs()).fold(0.0, f64::max);
            assert!(size > 0.0 && off < 2e-2 * size, "{off:e} of {size:e}");
        }
    }
}

#[test]
fn what_a_scene_cannot_tell_it_refuses() {
    let bytes = built(&few_modes(2));
    let asked = |bytes: &[u8], options: &SceneOptions, index: usize| {
        with_scene::<f64, _>(bytes, options, |scene, state, _| scene.reaction(state, index).err())
    };
    let usual = SceneOptions::default();
    assert_eq!(asked(&bytes, &usual, 0), None);
    assert_eq!(asked(&bytes, &usual, 1), Some(OutputError::OutOfRange { index: 1, count: 1 }));
    let forgetful = SceneOptions { contacts: 0, ..usual };
    assert_eq!(asked(&bytes, &forgetful, 0), Some(OutputError::ForcesForgotten));
    let without = built(&few_modes(2).replace("reactions = true", ""));
    let missing = OutputError::Missing { kind: SectionKind::ReactionBasis };
    assert_eq!(asked(&without, &usual, 0), Some(missing));
    assert!(without.len() < bytes.len());
    assert_eq!(File::parse(&without).expect("a file").support_names().count(), 0);
}

const ALL: [SectionKind; 5] = [
    SectionKind::SupportNames,
    SectionKind::SupportPoints,
    SectionKind::ReactionBasis,
    SectionKind::ReactionLoads,
    SectionKind::PatternReaction,
];

#[test]
fn strip_keeps_what_is_of_use_and_the_check_finds_what_is_no_reaction() {
    let bytes = built(ALL_MODES);
    let present = |bytes: &[u8]| {
        let file = File::parse(bytes).expect("a file");
        ALL.into_iter().filter(|&kind| file.section(kind).is_some()).collect::<Vec<_>>()
    };
    assert_eq!(present(&bytes), ALL);
    let names: Vec<_> = File::parse(&bytes).expect("a file").support_names().map(String::from).collect();
    assert_eq!(names, ["clamp", "support2", "edge"]);
    let with_probe = ALL_MODES.replace(
        "reactions = true",
        "reactions = true\n[[output.probe]]\nname = \"tip\"\npoint = [1, 0, 0]\ndirection = [1, 0, 0]",
    );
    let probes = strip(&built(&with_probe), Keep::Probes).expect("stripped");
    check(&probes).expect("sound");
    let kept: Vec<_> = ALL.into_iter().filter(|&kind| kind != SectionKind::ReactionLoads).collect();
    assert_eq!(present(&probes), kept);
    let packed = pack(&bytes, 19).expect("packed");
    check(&packed).expect("sound");
    assert!(unpack(&packed, 1 << 30).expect("unpacked") == bytes);

    let changed = |kind: SectionKind, edit: &dyn Fn(&mut Vec<u8>, &mut [u64; 3])| -> Vec<u8> {
        let file = File::parse(&bytes).expect("a file");
        let section = file.section(kind).expect("present");
        let (mut stored, mut shape) = (section.stored().to_vec(), section.shape());
        edit(&mut stored, &mut shape);
        let mut inputs: Vec<SectionInput<'_>> = file.sections().map(SectionInput::from).collect();
        for input in inputs.iter_mut().filter(|input| input.kind == kind) {
            (input.shape, input.stored, input.decoded_length) = (shape, &stored, stored.len() as u64);
        }
        let mut out = vec![0; encoded_len(file.metadata(), &inputs).expect("a length")];
        encode_into(file.metadata(), &inputs, &mut out).expect("written");
        out
    };
    assert!(changed(SectionKind::ReactionLoads, &|_, _| ()) == bytes);
    let fault = |bytes: &[u8]| match check(bytes) {
        Err(RewriteError::Unsound { kind, fault, .. }) => (kind, fault),
        other => panic!("{other:?}"),
    };
    let turned = changed(SectionKind::ReactionLoads, &|stored, _| {
        stored[7] ^= 0x80;
    });
    assert_eq!(fault(&turned), (SectionKind::ReactionLoads, Fault::Disagrees));
    let fewer = changed(SectionKind::SupportPoints, &|stored, shape| {
        stored.truncate(48);
        shape[0] = 2;
    });
    assert_eq!(fault(&fewer), (SectionKind::SupportPoints, Fault::Disagrees));
    let unnamed = changed(SectionKind::SupportNames, &|stored, shape| {
        stored.truncate(5);
        shape[0] = 5;
    });
    assert!(matches!(check(&unnamed), Err(RewriteError::Names { kind: SectionKind::SupportNames, .. })));
}

#[test]
fn the_page_does_what_it_says() {
    let page = std::fs::read_to_string(repository().join("docs/how-to/reactions.md")).expect("the page");
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("shelf.toml"), block(&page, "toml\n# shelf.toml")).expect("written");
    std::fs::write(path("push.toml"), block(&page, "toml\n# push.toml")).expect("written");
    let ran = vademecum(&["build", &path("shelf.toml"), "-o", &path("shelf.vdm")]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let info = vademecum(&["info", &path("shelf.vdm"), "--json"]).json();
    assert_eq!(info["supports"][1]["name"], "right");
    let ran = vademecum(&[
        "run",
        &path("shelf.vdm"),
        "--scenario",
        &path("push.toml"),
        "-o",
        &path("out"),
        "--json",
    ]);
    assert_eq!(ran.json()["supports"], serde_json::json!(["left", "right"]));
    let table = std::fs::read_to_string(folder.path().join("out/probes.csv")).expect("a table");
    let head: Vec<&str> = table.lines().next().expect("names").split(',').collect();
    assert_eq!(head[2..5], ["reaction.left.fx [N]", "reaction.left.fy [N]", "reaction.left.fz [N]"]);
    assert_eq!(head.len(), 2 + 12);
    let last: Vec<f64> =
        table.lines().last().expect("rows").split(',').map(|x| x.parse().expect("a number")).collect();
    // The damped shelf has come to rest under its load, as the page says.
    let column = |name: &str| last[head.iter().position(|known| *known == name).expect("a column")];
    let [left, right] = ["left", "right"].map(|name| column(&format!("reaction.{name}.fz [N]")));
    assert!((left + right - 30.0).abs() < 1e-3, "{left} {right}");
    let said = block(&page, "text\nfz at rest");
    for (name, value) in [("left", left), ("right", right)] {
        let line = said.lines().find(|line| line.starts_with(name)).expect("a line");
        let number: f64 = line.split_whitespace().nth(1).expect("a number").parse().expect("a number");
        assert!((number - value).abs() < 0.006, "{name}: {number} on the page, {value} found");
    }
}

/// The beam of all modes in two regions whose stiffness and one of whose densities are live.
fn of_regions() -> String {
    let region = "[[mesh.region]]\nname = \"tip\"\non = { fraction = { axis = \"x\", side = \"max\", fraction = 0.4 \
                  } }\n[[material]]";
    let live = |name: &str, kind: &str, region: &str| {
        format!(
            "[[parameter]]\nname = \"{name}\"\nkind = \"{kind}\"\nregion = \"{region}\"\nrange = [0.25, 4.0]\n"
        )
    };
    let parameters =
        [("root", "stiffness", "body"), ("tip", "stiffness", "tip"), ("heavy", "density", "tip")];
    let parameters = parameters.map(|(name, kind, region)| live(name, kind, region)).concat();
    // The force of gravity is that of the density as built.
    let pressure = "on = { group = \"y_max\" }\npressure = 200.0";
    let text = ALL_MODES.replace("acceleration = [0.5, 1.0, -9.81]", pressure);
    text.replacen("[[material]]", region, 1) + &parameters
}

#[test]
fn reactions_follow_live_regions() {
    let text = of_regions();
    let bytes = built(&text);
    check(&bytes).expect("sound");
    let file = File::parse(&bytes).expect("a file");
    let r = file.metadata().n_modes;
    for [root, tip, heavy] in [[1.0, 1.0, 1.0], [0.3, 3.5, 1.0], [3.0, 0.4, 2.5]] {
        let values = [("root", root), ("tip", tip), ("heavy", heavy)];
        let values = values.map(|(name, value)| ParameterValue { name: name.into(), value });
        let set = at_values(&file, &values, Some(r as usize)).expect("set").expect("a model");
        let material = |region: &str, young: f64, density: f64| {
            format!(
                "[[material]]\nregion = \"{region}\"\nyoung = {young}\npoisson = 0.3\ndensity = {density}\n"
            )
        };
        let (before, _) = text.split_once("[[material]]").expect("a material");
        let (_, after) = text.split_once("density = 1200.0\n").expect("a density");
        let (after, _) = after.split_once("[[parameter]]").expect("parameters");
        let fixed = format!(
            "{before}{}{}{after}",
            material("body", 2e9 * root, 1200.0),
            material("tip", 2e9 * tip, 1200.0 * heavy)
        );
        let found = marched(&fixed, &set.bytes, Scaled::AS_BUILT, &SceneOptions::default(), PUSH, [40, 40]);
        let off = apart(&found);
        println!("{r} vectors at {root}, {tip}, {heavy}: {off:.1e}");
        assert!(off < 1e-9, "{off:e} at {root}, {tip}, {heavy}");
    }
}

/// Reactions of all supports after each of 40 steps under a push, then without it.
fn pushed(bytes: &[u8], supports: usize) -> Vec<[f64; 6]> {
    let mut body = Simulation::<f64>::new(bytes.to_vec(), &SceneOptions::default()).expect("bound");
    let place = body.locate(PUSH.0).expect("a place");
    body.push(&place, PUSH.1).expect("pushed");
    let mut found = vec![];
    for step in 0..40 {
        if step == 20 {
            body.clear();
        }
        body.step(1).expect("a step");
        found.extend((0..supports).map(|support| body.reaction(support).expect("a reaction").total()));
    }
    found
}

/// The beam on an elastic ground, which reaches the nodes that supports hold, with a motor on a mount.
fn with_attachments(text: &str, [ground, mount, motor]: [f64; 3]) -> String {
    let scaled =
        |numbers: &[f64], scale: f64| format!("{:?}", numbers.iter().map(|x| scale * x).collect::<Vec<_>>());
    let middle = "{ all = [{ group = \"z_max\" }, { fraction = { axis = \"x\", side = \"max\", fraction = 0.65 } }, \
                  { fraction = { axis = \"x\", side = \"min\", fraction = 0.65 } }] }";
    let attached = format!(
        "[[foundation]]\nname = \"ground\"\non = {{ group = \"z_min\" }}\nnormal = {}\ntangential = {}\n\
         [[reference_point]]\nname = \"motor\"\nat = [0.5, 0.05, 0.3]\n\
         [[reference_point]]\nname = \"seat\"\nat = [0.5, 0.05, 0.2]\n\
         [[coupling]]\nreference = \"seat\"\non = {middle}\nkind = \"rigid\"\n\
         [[point_mass]]\nname = \"motor\"\nreference = \"motor\"\nmass = {}\ninertia = {}\n\
         [[spring]]\nname = \"mount\"\nfrom = \"motor\"\nto = \"seat\"\nstiffness = {}\n",
        3e7 * ground,
        1e7 * ground,
        4.0 * motor,
        scaled(&[0.02, 0.03, 0.01, 0.0, 0.0, 0.0], motor),
        scaled(&[2e5, 3e5, 5e5, 900.0, 700.0, 500.0], mount)
    );
    text.replacen("[[load.pattern]]", &(attached + "[time]\nstep = 1e-3\n[[load.pattern]]"), 1)
}

#[test]
fn reactions_follow_live_regions_and_attachments() {
    let live = |name: &str, kind: &str| {
        format!(
            "[[parameter]]\nname = \"live {name}\"\nkind = \"{kind}\"\nattachment = \"{name}\"\nrange = [0.25, 4.0]\n"
        )
    };
    let parameters = [("ground", "stiffness"), ("mount", "stiffness"), ("motor", "mass")];
    let parameters = parameters.map(|(name, kind)| live(name, kind)).concat();
    let one_support = |text: &str| {
        let (first, rest) = text.split_once("[[support]]\non").expect("supports");
        let (_, rest) = rest.split_once("[[load.pattern]]").expect("a pattern");
        format!("{first}[[load.pattern]]{rest}")
    };
    for alone in [false, true] {
        let regions = if alone { one_support(&of_regions()) } else { of_regions() };
        let (all_modes, supports) = if alone { (60, 1) } else { (54, 3) };
        let regions = regions.replace("modes = 54", &format!("modes = {all_modes}"));
        let bytes = built(&(with_attachments(&regions, [1.0; 3]) + &parameters));
        let file = File::parse(&bytes).expect("a file");
        let r = file.metadata().n_modes as usize;
        for [root, tip, heavy, ground, mount, motor] in
            [[1.0; 6], [0.3, 3.5, 1.0, 2.0, 0.4, 0.5], [3.0, 0.4, 2.5, 0.25, 4.0, 3.0]]
        {
            let values = [
                ("root", root),
                ("tip", tip),
                ("heavy", heavy),
                ("live ground", ground),
                ("live mount", mount),
                ("live motor", motor),
            ];
            let values = values.map(|(name, value)| ParameterValue { name: name.into(), value });
            let set = at_values(&file, &values, Some(r)).expect("set").expect("a model");
            let text = with_attachments(&regions, [ground, mount, motor]);
            let material = |region: &str, young: f64, density: f64| {
                format!(
                    "[[material]]\nregion = \"{region}\"\nyoung = {young}\npoisson = 0.3\ndensity = {density}\n"
                )
            };
            let (before, rest) = text.split_once("[[material]]").expect("a material");
            let (_, after) = rest.split_once("density = 1200.0\n").expect("a density");
            let (after, _) = after.split_once("[[parameter]]").expect("parameters");
            let materials =
                material("body", 2e9 * root, 1200.0) + &material("tip", 2e9 * tip, 1200.0 * heavy);
            let expected = pushed(&built(&format!("{before}{materials}{after}")), supports);
            let found = pushed(&set.bytes, supports);
            let largest = expected.as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let apart = found.as_flattened().iter().zip(expected.as_flattened());
            let apart = apart.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            println!("{r} vectors, one support: {alone}: {:.1e}", apart / largest);
            assert!(apart < 1e-8 * largest, "{:e} at {values:?}", apart / largest);
        }
    }
}
