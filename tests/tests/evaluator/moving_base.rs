//! A base that moves: relative to it the body answers to twelve inertia patterns as one whose supports are
//! really moved, with reactions that carry its mass.

use faer::Mat;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::{BASE_PATTERNS, File, base_field};
use vademecum_eval::{BaseMotion, Field, LoadError, SceneOptions};
use vademecum_rewrite::{Keep, check, strip};
use vademecum_tests::held_rows::Full;
use vademecum_tests::needed_minor;
use vademecum_tests::page::block;
use vademecum_tests::program::{repository, vademecum};
use vademecum_tests::stage::with_scene;

/// A beam with all of its modes.
const BEAM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.1, 0.2], divisions = [5, 1, 1], order = "linear" }
[[material]]
young = 2e9
poisson = 0.3
density = 1200.0
[[support]]
on = { group = "x_min" }
[base]
moves = true
point = [-0.3, 0.2, 0.1]
[load]
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
[time]
step = 1e-4
[basis]
modes = 60
[output]
precision = "f64"
reactions = true
[[output.probe]]
name = "tip"
point = [1.0, 0.1, 0.2]
direction = [0.3, -1.0, 0.7]
"#;

fn problem(text: &str) -> Problem {
    Problem::parse(text, "p.toml", std::path::PathBuf::new()).expect("a problem")
}

fn built(text: &str) -> Vec<u8> {
    build(&problem(text), &BuildOptions::default(), &Silent).expect("a file").either().bytes
}

#[test]
fn a_file_on_a_base_has_its_motions_as_last_patterns() {
    let bytes = built(BEAM);
    check(&bytes).expect("sound");
    let file = File::parse(&bytes).expect("a file");
    assert_eq!(needed_minor(&file), 5);
    let names: Vec<&str> = file.pattern_names().collect();
    assert_eq!(names[0], "gravity");
    assert_eq!(names[1..], BASE_PATTERNS);
    // It keeps its base without its surface.
    let probes = strip(&bytes, Keep::Probes).expect("stripped");
    check(&probes).expect("sound");
    with_scene::<f64, _>(&probes, &SceneOptions::default(), |scene, _, loads| {
        assert_eq!(scene.base_point(), Some([-0.3, 0.2, 0.1]));
        assert_eq!(loads.add_base(scene, &BaseMotion::default()), Ok(()));
        let mad = BaseMotion { angular_velocity: [1e200, 0.0, 0.0], ..BaseMotion::default() };
        assert_eq!(loads.add_base(scene, &mad), Err(LoadError::NotFinite));
        assert!(loads.is_empty());
    });
    let still = built(&BEAM.replace("moves = true", "moves = false"));
    with_scene::<f64, _>(&still, &SceneOptions::default(), |scene, _, loads| {
        assert_eq!(scene.base_point(), None);
        let shaken = BaseMotion { acceleration: [1.0; 3], ..BaseMotion::default() };
        assert!(matches!(loads.add_base(scene, &shaken), Err(LoadError::Missing { .. })));
    });
}

/// Supports that are really moved: in the fixed frame the body is driven by `−K_fs u_s − M_fs ü_s` alone.
#[test]
fn shaken_and_turned_the_body_moves_as_one_whose_supports_are_moved() {
    let bytes = built(BEAM);
    let full = Full::of(&problem(BEAM));
    let (mesh, dofs) = (full.body.model.mesh(), full.body.model.dofs());
    let point = [-0.3, 0.2, 0.1];
    let (all, n) = (dofs.n_dof(), dofs.n_free());
    let probe = &full.body.probes[0];
    let mut worst: f64 = 0.0;
    for motion in 0..6 {
        let rigid: Vec<f64> = (0..all)
            .map(|dof| {
                let at = mesh.nodes[dof / 3];
                base_field(motion, std::array::from_fn(|c| at[c] - point[c]))[dof % 3]
            })
            .collect();
        // Through the rows of held displacements: K_fs = K_sfᵀ.
        let driven = |matrix: &Mat<f64>| -> Vec<f64> {
            let held = (0..all).filter(|&dof| dofs.free(dof).is_none());
            let mut load = vec![0.0; all];
            for dof in held {
                for free in 0..n {
                    load[dofs.dof_of_free()[free] as usize] -= matrix[(dof, free)] * rigid[dof];
                }
            }
            full.on_modes(&load)
        };
        let (by_place, by_acceleration) = (driven(&full.stiffness), driven(&full.mass));
        // Base at ½ a t²: each mode has z̈ + λ z = c₀ + c₂ t², and starts at rest.
        let rate = 3.0;
        let absolute = |t: f64| -> Vec<f64> {
            let mode = |k: usize| {
                let lambda = full.eigenvalues[k];
                let (c0, c2) = (rate * by_acceleration[k], 0.5 * rate * by_place[k]);
                let rest = (c0 - 2.0 * c2 / lambda) / lambda;
                c2 * t * t / lambda + rest * (1.0 - (lambda.sqrt() * t).cos())
            };
            let z: Vec<f64> = (0..n).map(mode).collect();
            (0..n).map(|i| (0..n).map(|k| full.modes[(i, k)] * z[k]).sum()).collect()
        };
        let along = |field: &dyn Fn(usize) -> f64| -> f64 {
            {
                let of_node = |&(node, weights): &(u32, [f64; 3])| {
                    (0..3).map(move |c| weights[c] * field(3 * node as usize + c)).sum::<f64>()
                };
                probe.nodes.iter().map(of_node).sum()
            }
        };
        with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads| {
            let mut moves = BaseMotion::default();
            if motion < 3 {
                moves.acceleration[motion] = rate
            } else {
                moves.angular_acceleration[motion - 3] = rate
            }
            loads.add_base(scene, &moves).expect("a base");
            let dt = scene.parameters().time_step;
            let (mut most, mut size) = (0.0f64, 0.0f64);
            for step in 1..=200 {
                scene.step(state, loads).expect("a step");
                let t = f64::from(step) * dt;
                let u = absolute(t);
                let carried = 0.5 * rate * t * t;
                let relative =
                    along(&|dof| u[dofs.free(dof).expect("a free probe") as usize] - carried * rigid[dof]);
                let found = scene.probe(state, 0, Field::Displacement).expect("a probe");
                most = most.max((found - relative).abs());
                size = size.max(relative.abs());
            }
            assert!(size > 0.0 && most < 1e-8 * size, "motion {motion}: {most:e} of {size:e}");
            worst = worst.max(most / size);
        });
    }
    println!("supports moved: {worst:.1e}");
}

/// A bar that turns about its held end is drawn out as σ' = −ρ ω² x says.
#[test]
fn a_bar_that_turns_is_drawn_out_as_theory_says() {
    let text = BEAM
        .replace("poisson = 0.3", "poisson = 0.0")
        .replace("divisions = [5, 1, 1], order = \"linear\"", "divisions = [4, 1, 1], order = \"quadratic\"")
        .replace("point = [-0.3, 0.2, 0.1]", "point = [0.0, 0.05, 0.1]")
        .replace("modes = 60", "modes = 12")
        .replace("direction = [0.3, -1.0, 0.7]", "direction = [1.0, 0.0, 0.0]")
        .replace("[time]", "[damping]\nratio = 1.0\n[time]");
    let bytes = built(&text);
    let (young, density, length) = (2e9, 1200.0, 1.0);
    let spin = 40.0;
    with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads| {
        let turns = BaseMotion { angular_velocity: [0.0, spin, 0.0], ..BaseMotion::default() };
        loads.add_base(scene, &turns).expect("a base");
        (0..20_000).for_each(|_| {
            scene.step(state, loads).expect("a step");
        });
        let tip = scene.probe(state, 0, Field::Displacement).expect("a probe");
        // The section is drawn across, too, by half of its height, which a slender bar does not know.
        let expected = density * spin * spin * length * length * length / (3.0 * young);
        assert!((tip / expected - 1.0).abs() < 2e-3, "{tip:e}, {expected:e}");
        // What holds it: ρ A ω² L²/2, exactly.
        let held = scene.reaction(state, 0).expect("a reaction").total()[0];
        let expected = -0.5 * density * 0.1 * 0.2 * spin * spin * length * length;
        assert!((held / expected - 1.0).abs() < 1e-9, "{held}, {expected}");
        println!("turning bar: {:.1e}", (tip * 3.0 * young / (density * spin * spin) - 1.0).abs());
    });
}

/// A heavy mass on a spring carries the beam. Its motion and that of the beam are one system, whose modes are
/// found from the matrices; a loop that knows the beam by its reactions alone must follow them.
#[test]
fn a_mass_on_a_spring_feels_the_body_it_carries() {
    let bytes = built(BEAM);
    let full = Full::of(&problem(BEAM));
    let (all, n) = (full.body.model.dofs().n_dof(), full.body.model.dofs().n_free());
    let along = |dof: usize| if dof % 3 == 2 { 1.0 } else { 0.0 };
    let inertia = full.body.model.inertia_load(|_| [0.0, 0.0, 1.0]);
    let body_mass: f64 = (0..all).map(|dof| along(dof) * inertia[dof]).sum();
    assert!((body_mass - 24.0).abs() < 1e-9);
    let shares = full.on_modes(&inertia);
    let (mass, spring) = (60.0, 60.0 * 90.0f64.powi(2));
    // Unknowns: the base, then the modes relative to it; mass matrix [[m, g], [gᵀ, 1]].
    let size = n + 1;
    let heavy = Mat::from_fn(size, size, |i, j| match (i, j) {
        (0, 0) => mass + body_mass,
        (0, k) | (k, 0) => shares[k - 1],
        _ if i == j => 1.0,
        _ => 0.0,
    });
    let stiff = |i: usize| if i == 0 { spring } else { full.eigenvalues[i - 1] };
    let start = 1e-3;
    // The exact motion of the base from the modes of the joint system.
    let lower = heavy.llt(faer::Side::Lower).expect("a mass").L().to_owned();
    let inverse = {
        use faer::linalg::solvers::Solve;
        lower.partial_piv_lu().solve(Mat::<f64>::identity(size, size))
    };
    let diagonal = Mat::from_fn(size, size, |i, j| if i == j { stiff(i) } else { 0.0 });
    let symmetric = &inverse * diagonal * inverse.transpose();
    let joint = symmetric.self_adjoint_eigen(faer::Side::Lower).expect("modes");
    let modes = inverse.transpose() * joint.U();
    let weights: Vec<f64> = {
        let moved = heavy.col(0).to_owned();
        (0..size).map(|k| start * (0..size).map(|i| modes[(i, k)] * moved[i]).sum::<f64>()).collect()
    };
    let exact = |t: f64| -> f64 {
        (0..size).map(|k| modes[(0, k)] * weights[k] * (joint.S()[k].max(0.0).sqrt() * t).cos()).sum()
    };
    with_scene::<f64, _>(&bytes, &SceneOptions::default(), |scene, state, loads| {
        let dt = scene.parameters().time_step;
        // The reaction answers to an acceleration of the base at once: with what no mode carries.
        let bare = body_mass - shares.iter().map(|g| g * g).sum::<f64>();
        let (mut place, mut speed, mut acceleration) = (start, 0.0, -spring * start / (mass + bare));
        let (mut most, mut largest) = (0.0f64, 0.0f64);
        let (steps, mut before) = (6000, acceleration);
        for step in 1..=steps {
            loads.clear();
            // What the base will do in the middle of the step.
            let held = 1.5 * acceleration - 0.5 * before;
            let shaken = BaseMotion { acceleration: [0.0, 0.0, held], ..BaseMotion::default() };
            loads.add_base(scene, &shaken).expect("a base");
            scene.step(state, loads).expect("a step");
            place += dt * speed + 0.5 * dt * dt * acceleration;
            // m Ẍ = −k X − r, and r grows with Ẍ by `bare`.
            let reaction = scene.reaction(state, 0).expect("a reaction").total()[2];
            let next = (-spring * place - reaction + bare * held) / (mass + bare);
            speed += 0.5 * dt * (acceleration + next);
            (before, acceleration) = (acceleration, next);
            let truth = exact(f64::from(step) * dt);
            most = most.max((place - truth).abs());
            largest = largest.max(truth.abs());
        }
        println!("mass on a spring, {} s: {:.1e}", f64::from(steps) * dt, most / largest);
        assert!(most < 2e-3 * largest, "{most:e} of {largest:e}");
        // Not a mass that carries nothing: the two are coupled.
        let alone = (0..steps).map(|s| start * ((spring / mass).sqrt() * f64::from(s) * dt).cos());
        let apart = alone.enumerate().map(|(s, x)| (x - exact(s as f64 * dt)).abs()).fold(0.0, f64::max);
        assert!(apart > 0.5 * largest);
    });
}

/// What is left out: the tension of a beam that turns makes it stiffer. A slender cantilever that turns about
/// its held end, of Hermite elements with that tension, bends out of the plane of turning; its first
/// frequency over that at rest.
fn stiffened(share: f64) -> f64 {
    use faer::linalg::solvers::Solve;
    const COUNT: usize = 12;
    let size = 2 * COUNT;
    let h = 1.0 / COUNT as f64;
    let [mut bending, mut tension, mut mass] = [(); 3].map(|()| Mat::<f64>::zeros(size, size));
    // Four points of Gauss on [0, 1].
    let (a, b) = (0.339_981_043_584_856_3, 0.861_136_311_594_052_6);
    let (wa, wb) = (0.652_145_154_862_546_1, 0.347_854_845_137_453_9);
    for element in 0..COUNT {
        for (point, weight) in [(-b, wb), (-a, wa), (a, wa), (b, wb)] {
            let (s, w) = (0.5 * (point + 1.0), 0.5 * weight * h);
            let x = (element as f64 + s) * h;
            let n = [
                1.0 - 3.0 * s * s + 2.0 * s.powi(3),
                h * (s - 2.0 * s * s + s.powi(3)),
                3.0 * s * s - 2.0 * s.powi(3),
                h * (s.powi(3) - s * s),
            ];
            let slope = [
                (6.0 * s * s - 6.0 * s) / h,
                1.0 - 4.0 * s + 3.0 * s * s,
                (6.0 * s - 6.0 * s * s) / h,
                3.0 * s * s - 2.0 * s,
            ];
            let curve = [
                (12.0 * s - 6.0) / h / h,
                (6.0 * s - 4.0) / h,
                (6.0 - 12.0 * s) / h / h,
                (6.0 * s - 2.0) / h,
            ];
            for i in 0..4 {
                for j in 0..4 {
                    // The first two dofs of the first element are held.
                    let (Some(row), Some(column)) =
                        ((2 * element + i).checked_sub(2), (2 * element + j).checked_sub(2))
                    else {
                        continue;
                    };
                    bending[(row, column)] += w * curve[i] * curve[j];
                    tension[(row, column)] += w * 0.5 * (1.0 - x * x) * slope[i] * slope[j];
                    mass[(row, column)] += w * n[i] * n[j];
                }
            }
        }
    }
    let lower = mass.llt(faer::Side::Lower).expect("a mass").L().to_owned();
    let inverse = lower.partial_piv_lu().solve(Mat::<f64>::identity(size, size));
    let first = |stiffness: &Mat<f64>| {
        let symmetric = &inverse * stiffness * inverse.transpose();
        symmetric.self_adjoint_eigenvalues(faer::Side::Lower).expect("modes")[0]
    };
    let still = first(&bending);
    assert!((still.sqrt() / 3.516_015 - 1.0).abs() < 1e-6, "{}", still.sqrt());
    (first(&(bending + share * share * still * tension)) / still).sqrt()
}

#[test]
fn what_is_left_out_of_turning_is_as_small_as_the_page_says() {
    for (share, rise) in [(0.1, 0.006), (0.3, 0.052)] {
        let found = stiffened(share) - 1.0;
        println!("turning at {share} of the first frequency: {found:.4}");
        assert!((found / rise - 1.0).abs() < 0.05, "{found}");
        let southwell = (1.0 + 1.19 * share * share).sqrt() - 1.0;
        assert!((found / southwell - 1.0).abs() < 0.02, "{found} {southwell}");
    }
}

#[test]
fn the_page_does_what_it_says() {
    let page = std::fs::read_to_string(repository().join("docs/how-to/moving-base.md")).expect("the page");
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    for name in ["tower", "quake"] {
        let text = block(&page, &format!("toml\n# {name}.toml"));
        std::fs::write(path(&format!("{name}.toml")), text.replace("12.0", "3.0")).expect("written");
    }
    let ran = vademecum(&["build", &path("tower.toml"), "-o", &path("tower.vdm")]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    // A ramp to a steady acceleration: in the end the tower stands bent, and the foot holds its mass.
    std::fs::write(path("quake.csv"), "time,ax,ay,az\n0,0,0,0\n0.4,0.1,0,0\n9,0.1,0,0\n").expect("written");
    let scenario = path("quake.toml");
    let out = path("out");
    let ran = vademecum(&["run", &path("tower.vdm"), "--scenario", &scenario, "-o", &out]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let table = std::fs::read_to_string(folder.path().join("out/probes.csv")).expect("a table");
    let head: Vec<&str> = table.lines().next().expect("names").split(',').collect();
    let last: Vec<f64> =
        table.lines().last().expect("rows").split(',').map(|x| x.parse().expect("a number")).collect();
    let column = |name: &str| last[head.iter().position(|known| *known == name).expect("a column")];
    let carried = 1600.0 * 0.981;
    assert!(
        (column("reaction.foot.fx [N]") / carried - 1.0).abs() < 1e-2,
        "{}",
        column("reaction.foot.fx [N]")
    );
    // q L⁴/8 E I under 392 N/m, bent backwards.
    let bent = -392.4 * 256.0 / (8.0 * 2e9 * 0.4 * 0.125 / 12.0);
    assert!((column("top [m]") / bent - 1.0).abs() < 2e-2, "{} {bent}", column("top [m]"));
    // Verified against the full order, whose patterns are the same.
    let checked = vademecum(&[
        "verify",
        &path("tower.vdm"),
        "--problem",
        &path("tower.toml"),
        "--scenario",
        &scenario,
        "--json",
    ]);
    let total = checked.json()["total_error"].as_f64().expect("a number");
    assert!(total < 5e-3, "{total}");
    let swung = vademecum(&[
        "frf",
        &path("tower.vdm"),
        "--in",
        "base.ax",
        "--out",
        "top",
        "--range",
        "0.5,60",
        "--json",
    ]);
    assert_eq!(swung.code, Some(0), "{}", swung.stderr);
    // A file without a base says so.
    let still =
        std::fs::read_to_string(path("tower.toml")).expect("text").replace("moves = true", "moves = false");
    std::fs::write(path("still.toml"), still).expect("written");
    assert_eq!(vademecum(&["build", &path("still.toml"), "-o", &path("still.vdm")]).code, Some(0));
    let refused = vademecum(&["run", &path("still.vdm"), "--scenario", &scenario, "-o", &out]);
    assert_ne!(refused.code, Some(0));
    assert!(refused.stderr.contains("base.ax"), "{}", refused.stderr);
}
