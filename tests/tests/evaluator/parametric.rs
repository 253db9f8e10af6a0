//! Live regions of a parametric reduced-order model: modes, files and states at values of the parameters,
//! against dense matrices, and a built body against the full model at corners of its box.

use faer::linalg::solvers::DenseSolveCore as _;
use faer::{Mat, Side};
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{
    BodyOptions, Field, ParameterError, Parametric, ParametricError, SceneOptions, Simulation,
};
use vademecum_format::{File, SectionKind as S};
use vademecum_study::live::{at_values, prepared_at};
use vademecum_study::modes::natural_modes;
use vademecum_study::parameters::ParameterValue;
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::Scenario;
use vademecum_study::verify::{Figures, verify};
use vademecum_tests::golden;

/// A beam of two regions on eight divisions; both stiffnesses and the step are live.
const BEAM: &str = r#"
representation = "parametric"
[mesh]
block = { lengths = [1.0, 0.1, 0.12], divisions = [8, 1, 1], order = "quadratic" }
[[mesh.region]]
name = "tip"
on = { fraction = { axis = "x", side = "max", fraction = 0.5 } }
[[material]]
young = 2.1e9
poisson = 0.3
density = 1200.0
[damping]
ratio = 0.02
[[support]]
on = { group = "x_min" }
[load]
surface = { group = "z_max" }
[time]
step = 1e-3
[basis]
modes = 40
[tolerance]
steps = 200
[[parameter]]
name = "root"
kind = "stiffness"
region = "body"
range = [0.25, 4.0]
scale = "log"
[[parameter]]
name = "tip"
kind = "stiffness"
region = "tip"
range = [0.25, 4.0]
scale = "log"
[[parameter]]
name = "step"
kind = "time-step"
range = [0.5e-3, 2e-3]
"#;

fn problem(text: &str) -> Problem {
    Problem::parse(text, "beam.toml", std::path::PathBuf::new()).expect("a problem")
}

fn numbers(file: &File<'_>, kind: S) -> Vec<f64> {
    file.section(kind).expect("a section").numbers().expect("raw").iter().collect()
}

/// Sum of the packed matrices of a section at these scales.
fn dense(file: &File<'_>, kind: S, scales: &[f64]) -> Mat<f64> {
    let r = file.metadata().n_modes as usize;
    let packed = numbers(file, kind);
    Mat::from_fn(r, r, |i, j| {
        let (i, j) = (i.max(j), i.min(j));
        let place = i * (i + 1) / 2 + j;
        scales.iter().enumerate().map(|(q, scale)| scale * packed[q * r * (r + 1) / 2 + place]).sum()
    })
}

/// The file at these values with so many modes.
fn set(file: &File<'_>, values: &[f64], modes: usize) -> Result<Vec<u8>, ParametricError> {
    let model = Parametric::new(file)?;
    let sizes = model.sizes(modes)?;
    let (mut memory, mut work) = (vec![f64::NAN; sizes.memory], vec![f64::NAN; sizes.work]);
    let tuned = model.solve(values, modes, &mut memory, &mut work)?;
    let (mut bytes, mut work) = (vec![0xff; sizes.bytes], vec![f64::NAN; sizes.write_work]);
    let length = tuned.write(&model, &mut bytes, &mut work)?.bytes().len();
    assert_eq!(length, sizes.bytes);
    Ok(bytes)
}

#[test]
fn at_the_values_as_built_the_file_is_what_it_was() {
    let bytes = golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let mut values = vec![0.0; model.n_parameters()];
    model.nominal_into(&mut values);
    let found = set(&file, &values, 3).expect("set");
    let found = File::parse(&found).expect("a file");
    assert!(found.live_parameters().expect("none").is_none());
    for kind in [S::Eigenvalues, S::SurfaceBasis, S::ProbeRows, S::ContactResidual, S::PairResidual] {
        let (own, theirs) = (numbers(&found, kind), numbers(&file, kind));
        let largest = theirs.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert_eq!(own.len(), theirs.len());
        // A mode has no sign.
        let sized = |x: f64| if kind == S::PairResidual { x } else { x.abs() };
        for (a, b) in own.iter().zip(&theirs) {
            assert!((sized(*a) - sized(*b)).abs() < 1e-12 * largest, "{kind}: {a} beside {b}");
        }
    }
    let [own, theirs] = [&found, &file].map(|file| file.metadata().time_step);
    assert_eq!(own, theirs);
}

#[test]
fn modes_and_static_answers_are_those_of_the_reduced_matrices() {
    let bytes = golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let values = [0.5, 3.0, 1.25, 5e-5];
    let stiffness = dense(&file, S::LiveStiffness, &[1.0, 0.5, 3.0]);
    let mass = dense(&file, S::LiveMass, &[1.0, 1.0, 1.25]);
    let lower = mass.llt(Side::Lower).expect("definite");
    let mut half = stiffness.clone();
    lower.L().solve_lower_triangular_in_place(half.as_mut());
    let mut whole = half.transpose().to_owned();
    lower.L().solve_lower_triangular_in_place(whole.as_mut());
    let expected = whole.self_adjoint_eigenvalues(Side::Lower).expect("eigenvalues");

    let found = set(&file, &values, 2).expect("set");
    let found = File::parse(&found).expect("a file");
    assert_eq!(found.metadata().n_modes, 2);
    assert_eq!(found.metadata().beta, 5e-5);
    let lambda = numbers(&found, S::Eigenvalues);
    for (found, expected) in lambda.iter().zip(&expected) {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} beside {expected}");
    }
    // Modes and what stands beside them are the whole answer of the basis, and the rest scaled.
    let nodes = file.metadata().n_load_nodes as usize;
    let (rows, shown) = (numbers(&file, S::SurfaceBasis), numbers(&found, S::SurfaceBasis));
    let (built, residual) = (numbers(&file, S::ContactResidual), numbers(&found, S::ContactResidual));
    let inverse = stiffness.llt(Side::Lower).expect("definite").inverse();
    for node in 0..nodes {
        let own = if node % 2 == 0 { 0.5 } else { 3.0 };
        let mean = 0.5 * (0.5 + 3.0);
        let scale = 0.75 / own + 0.25 / (0.5 * own + 0.5 * mean);
        for (place, (i, j)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
            let row = |c: usize| Mat::from_fn(3, 1, |k, _| rows[3 * (3 * node + c) + k]);
            let whole = (row(i).transpose() * &inverse * row(j))[(0, 0)] + scale * built[6 * node + place];
            let modal = |k: usize| shown[2 * (3 * node + i) + k] * shown[2 * (3 * node + j) + k] / lambda[k];
            let found = modal(0) + modal(1) + residual[6 * node + place];
            assert!((found - whole).abs() < 1e-11 * built[0], "{node}: {found} beside {whole}");
        }
    }
}

#[test]
fn settings_are_checked_and_change_nothing_when_they_are_refused() {
    use ParameterError as P;
    use ParametricError as E;
    let bytes = golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let names: Vec<&str> = model.parameters().map(|p| p.name).collect();
    assert_eq!(names, ["stiffness of the root", "stiffness of the tip", "density of the tip", "beta"]);
    assert_eq!(model.find("beta"), Some(3));
    let mut values = [1.0, 1.0, 1.0, 1e-6];
    let before = values;
    assert_eq!(model.set(&mut values, &[(0, 1.5), (4, 1.0)]), Err(P::Unknown { index: 4 }));
    assert_eq!(model.set(&mut values, &[(0, 1.5), (0, 1.0)]), Err(P::Twice { parameter: 0 }));
    let range = |value| P::OutsideRange { parameter: 1, value, lower: 0.25, upper: 4.0 };
    assert_eq!(model.set(&mut values, &[(0, 1.5), (1, 4.5)]), Err(range(4.5)));
    assert!(model.set(&mut values, &[(1, f64::NAN)]).is_err());
    assert_eq!(values, before);
    model.set(&mut values, &[(0, 1.5), (3, 2e-5)]).expect("set");
    assert_eq!(values, [1.5, 1.0, 1.0, 2e-5]);
    assert_eq!(set(&file, &[1.0, 9.0, 1.0, 0.0], 2).err(), Some(range(9.0).into()));
    assert_eq!(model.sizes(4).err(), Some(E::Modes { found: 4, most: 3 }));
    assert_eq!(model.sizes(0).err(), Some(E::Modes { found: 0, most: 3 }));
    let sizes = model.sizes(2).expect("sizes");
    let mut memory = vec![0.0; sizes.memory];
    let wrong = model.solve(&values[..3], 2, &mut memory, &mut vec![0.0; sizes.work]);
    assert_eq!(wrong.err(), Some(E::Values { found: 3, needed: 4 }));
    let short = model.solve(&values, 2, &mut [], &mut vec![0.0; sizes.work]);
    let needed = sizes.memory;
    assert_eq!(short.err(), Some(E::LentMemory { what: "numbers of memory", found: 0, needed }));
    let other = golden::named("patch.vdm");
    let other = File::parse(&other).expect("a file");
    assert_eq!(Parametric::new(&other).err(), Some(E::NotParametric));
}

#[test]
fn a_state_carried_to_other_values_gains_no_kinetic_energy() {
    let bytes = golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let sizes = model.sizes(2).expect("sizes");
    let mut memory = [vec![0.0; sizes.memory], vec![0.0; sizes.memory], vec![0.0; sizes.memory]];
    let mut work = vec![0.0; sizes.work.max(sizes.write_work)];
    let [first, second, third] = &mut memory;
    let soft = model.solve(&[0.5, 0.25, 1.0, 0.0], 2, first, &mut work).expect("solved");
    let stiff = model.solve(&[2.0, 4.0, 1.0, 0.0], 2, second, &mut work).expect("solved");
    let rates = [0.75, -0.5];
    let (mut carried, mut back) = ([0.0; 2], [0.0; 2]);
    stiff.carry(&soft, &rates, &mut carried, &mut work).expect("carried");
    let energy = |q: &[f64; 2]| 0.5 * (q[0] * q[0] + q[1] * q[1]);
    assert!(energy(&carried) <= energy(&rates) * (1.0 + 1e-14), "{carried:?}");
    assert!(energy(&carried) > 0.5 * energy(&rates));
    // To the same values and back nothing is lost.
    let same = model.solve(&[0.5, 0.25, 1.0, 0.0], 2, third, &mut work).expect("solved");
    same.carry(&soft, &rates, &mut back, &mut work).expect("carried");
    assert!(back.iter().zip(rates).all(|(a, b)| (a - b).abs() < 1e-13), "{back:?}");
}

#[test]
fn a_simulation_sets_parameters_while_it_moves_and_keeps_its_loads() {
    let bytes = golden::named("parametric.vdm");
    let options = BodyOptions { modes: Some(2), flight: false, ..BodyOptions::default() };
    let mut body = Simulation::<f64>::with_options(bytes.clone(), &options).expect("bound");
    assert_eq!(body.scene().n_modes(), 2);
    let names: Vec<_> = body.parameters().map(|parameter| parameter.name.to_string()).collect();
    assert_eq!(names.len(), 4);
    let (root, tip) =
        (body.find_parameter(&names[0]).expect("root"), body.find_parameter(&names[1]).expect("tip"));
    let place = body.body().file().section(S::NodeCoordinates).expect("nodes").numbers().expect("raw");
    let point: Vec<f64> = place.iter().take(3).collect();
    let finger = body.locate([point[0], point[1], point[2]]).expect("a place");
    body.push(&finger, [0.0, 3.0, -20.0]).expect("pushed");
    body.step(3).expect("stepped");

    // Refused: nothing changes.
    let before = body.point(&finger, Field::Velocity).expect("shown");
    assert!(body.set_parameters(&[(root, 0.5), (tip, 90.0)]).is_err());
    assert_eq!(body.parameter(root), Some(1.0));
    assert_eq!(body.point(&finger, Field::Velocity).expect("shown"), before);

    body.set_parameters(&[(root, 0.5), (tip, 3.0)]).expect("set");
    assert_eq!((body.parameter(root), body.parameter(tip)), (Some(0.5), Some(3.0)));
    let mut values = vec![0.0; 4];
    let file = File::parse(&bytes).expect("a file");
    Parametric::new(&file).expect("a model").nominal_into(&mut values);
    (values[root], values[tip]) = (0.5, 3.0);
    let expected = set(&file, &values, 2).expect("set");
    let expected = numbers(&File::parse(&expected).expect("a file"), S::Eigenvalues);
    assert_eq!(numbers(body.file(), S::Eigenvalues), expected);
    // The loads go on: from rest the same body of a file at these values moves alike.
    body.rest();
    body.step(5).expect("stepped");
    let own = set(&file, &values, 2).expect("set");
    let mut other = Simulation::<f64>::new(own, &SceneOptions::default()).expect("bound");
    other.push(&finger, [0.0, 3.0, -20.0]).expect("pushed");
    other.step(5).expect("stepped");
    let [own, other] = [&body, &other].map(|body| body.point(&finger, Field::Displacement).expect("shown"));
    assert_eq!(own, other);
    // Another of it starts at the same values, and many changes need no more memory.
    let another = body.another().expect("another");
    assert_eq!((another.parameter(root), another.parameter(tip)), (Some(0.5), Some(3.0)));
    for turn in 0..20 {
        body.set_parameters(&[(root, 0.5 + 0.1 * f64::from(turn % 7))]).expect("set");
        body.step(1).expect("stepped");
    }
    assert!(body.energy().expect("energy").is_finite());
}

#[test]
fn motion_goes_over_to_other_values_and_its_energies_are_told() {
    let bytes = golden::named("parametric.vdm");
    // Energies of the third mode at the new values, of a motion that has none of it before.
    let mut third = [0.0; 2];
    for modes in [3, 2] {
        let options = BodyOptions { modes: Some(modes), flight: false, ..BodyOptions::default() };
        let mut body = Simulation::<f64>::with_options(bytes.clone(), &options).expect("bound");
        body.with_body(|body| body.set(&[1e-3, -2e-3, 0.0][..modes], &[0.3, 0.2, 0.0][..modes]))
            .expect("set");
        let shown = |body: &Simulation<f64>| {
            [Field::Displacement, Field::Velocity].map(|field| body.body().node(0, field).expect("shown"))
        };
        let energy = |body: &Simulation<f64>| {
            let (mut zeta, mut rate) = (vec![0.0; modes], vec![0.0; modes]);
            body.body().coordinates_into(&mut zeta, &mut rate).expect("read");
            let lambda = numbers(body.file(), S::Eigenvalues);
            let elastic: Vec<f64> = zeta.iter().zip(lambda).map(|(x, lambda)| 0.5 * lambda * x * x).collect();
            [rate.iter().map(|x| 0.5 * x * x).collect(), elastic]
        };
        let sum = |energies: [Vec<f64>; 2]| energies.map(|energy| energy.iter().sum::<f64>());
        let (before, [kinetic, elastic]) = (shown(&body), sum(energy(&body)));
        body.set_parameters(&[(0, 0.5), (1, 3.0)]).expect("set");
        let (after, [new_kinetic, new_elastic]) = (shown(&body), sum(energy(&body)));
        let carried = body.carried().expect("a parametric file");
        let close = |a: f64, b: f64, size: f64| assert!((a - b).abs() < 1e-11 * size, "{a} beside {b}");
        close(kinetic - carried.lost_kinetic, new_kinetic, kinetic);
        close(elastic + carried.work - carried.lost_elastic, new_elastic, elastic + new_elastic);
        assert!(carried.work.abs() > 1e-3 * elastic);
        if modes == 3 {
            // All modes of the basis: nothing is lost, and nothing moves at once.
            close(carried.lost_kinetic, 0.0, kinetic);
            for (before, after) in before.as_flattened().iter().zip(after.as_flattened()) {
                assert!((before - after).abs() < 1e-11 * before.abs().max(1e-3), "{before} {after}");
            }
            third = energy(&body).map(|energy| energy[2]);
        } else {
            close(carried.lost_kinetic, third[0], kinetic);
            close(carried.lost_elastic, third[1], elastic);
            assert!(third[1] > 1e-9 * elastic, "{third:?} of {kinetic:e} and {elastic:e}");
        }
    }
}

/// Largest errors of a file at values of its parameters, beside the full model there, under a push: of the
/// first frequencies, of the whole field, and under the contact.
fn errors_at(file: &File<'_>, problem: &Problem, scenario: &Scenario, asked: &[ParameterValue]) -> [f64; 3] {
    let body = at_values(file, asked, None).expect("set").expect("a model");
    let at = File::parse(&body.bytes).expect("a file");
    let lambda = numbers(&at, S::Eigenvalues);
    let (exact, _) = natural_modes(problem, Some(4), None, asked, &Silent).expect("modes");
    let hertz = lambda.iter().map(|value| value.sqrt() / std::f64::consts::TAU);
    let of_frequency = hertz.zip(&exact.frequencies_hz).map(|(found, exact)| (found / exact - 1.0).abs());
    let mut prepared = prepare(problem, &mut Stopwatch::new(&Silent), &Silent).expect("prepared");
    prepared_at(&mut prepared, &body.values).expect("values of the problem");
    let found =
        verify(&at, &PlayOptions::default(), problem, &prepared, scenario, &Silent).expect("verified");
    let Figures::Linear(figures) = found.figures else { panic!("a linear body") };
    let contact = figures.truth.contact_error.expect("a contact");
    [of_frequency.fold(0.0, f64::max), figures.truth.total_error, contact]
}

fn value(name: &str, value: f64) -> ParameterValue {
    ParameterValue { name: name.into(), value }
}

const PUSH: &str =
    "duration = 0.2\n[[contact]]\npoint = [0.9, 0.03, 0.12]\nforce = [0.0, 4.0, -9.0]\nend = 0.08\n";

#[test]
fn a_built_beam_follows_the_full_model_to_corners_that_trained_nothing() {
    let problem = problem(BEAM);
    let built = build(&problem, &BuildOptions::default(), &Silent).expect("built").kept().expect("kept");
    let file = File::parse(&built.bytes).expect("a file");
    assert_eq!(file.metadata().active_parameters().len(), 0);
    let points = numbers(&file, S::LiveCertificate);
    assert!(points.chunks_exact(5).all(|point| point[3] == 0.0 && point[4] < 5e-3), "{points:?}");
    let scenario = Scenario::parse(PUSH, "push.toml").expect("a scenario");
    for [root, tip] in [[0.25, 4.0], [4.0, 0.3], [0.7, 1.9]] {
        let asked = [value("root", root), value("tip", tip), value("step", 1e-3)];
        let [frequency, error, contact] = errors_at(&file, &problem, &scenario, &asked);
        assert!(frequency < 1e-3, "{frequency:e} at {root}, {tip}");
        assert!(error < 2e-3, "{error:e} at {root}, {tip}");
        assert!(contact < 1e-2, "{contact:e} under the contact at {root}, {tip}");
    }
}

/// The beam with a mass on springs at its end and an elastic bed under its tip; `live` is the table of
/// parameters, and the numbers are factors of the root's modulus, of the springs, of the bed, of the mass and
/// of a dashpot.
fn attached([root, mount, bed, motor, damper]: [f64; 5], live: &str) -> String {
    let (head, rest) = BEAM.split_once("[[material]]").expect("a material");
    let rest = rest.split_once("[[parameter]]").expect("parameters").0;
    let rest = rest.replacen("young", "region = \"tip\"\nyoung", 1);
    let root = format!(
        "[[material]]\nregion = \"body\"\nyoung = {:e}\npoisson = 0.3\ndensity = 1200.0\n",
        root * 2.1e9
    );
    let attachments = format!(
        "[[reference_point]]\nname = \"hub\"\nat = [1.0, 0.05, 0.06]\n\
         [[coupling]]\nreference = \"hub\"\non = {{ group = \"x_max\" }}\nkind = \"rigid\"\n\
         [[spring]]\nname = \"mount\"\nfrom = \"hub\"\nstiffness = [0, {0:e}, {0:e}, {1}, 0, 0]\n\
         [[spring]]\nname = \"mount\"\nfrom = \"hub\"\nstiffness = [{0:e}, 0, 0, 0, 0, 0]\n\
         [[spring]]\nfrom = \"hub\"\nstiffness = [1e4, 0, 2e4, 0, 0, 0]\n\
         [[point_mass]]\nname = \"motor\"\nreference = \"hub\"\nmass = {2}\ninertia = [{3}, {3}, {3}, 0, 0, 0]\n\
         [[foundation]]\nname = \"bed\"\non = {{ group = \"z_min\" }}\nnormal = {4:e}\n\
         [[dashpot]]\nname = \"damper\"\nfrom = \"hub\"\ndamping = [0, 0, {5}, 0, 0, 0]\n\
         [[dashpot]]\nfrom = \"hub\"\ndamping = [5, 8, 0, 0, 0, 0]\n",
        mount * 5e4,
        mount * 300.0,
        motor * 3.0,
        motor * 0.02,
        bed * 2e6,
        damper * 60.0
    );
    format!("{head}{root}[[material]]{rest}{attachments}{live}")
}

#[test]
fn springs_foundations_and_masses_beside_live_regions_are_those_of_the_full_model_and_live_themselves() {
    let names = ["root", "mount", "bed", "motor", "damper"];
    let ranges = [[0.25, 4.0], [0.1, 10.0], [0.2, 5.0], [0.5, 2.0], [0.1, 10.0]];
    let live = |k: usize| {
        let target =
            if k == 0 { "region = \"body\"".into() } else { format!("attachment = \"{}\"", names[k]) };
        let kind = ["stiffness", "stiffness", "stiffness", "mass", "damping"][k];
        format!(
            "[[parameter]]\nname = \"{}\"\nkind = \"{kind}\"\n{target}\nrange = {:?}\nscale = \"log\"\n",
            names[k], ranges[k]
        )
    };
    let problem = problem(&attached([1.0; 5], &(0..5).map(live).collect::<String>()));
    let built = build(&problem, &BuildOptions::default(), &Silent).expect("built").kept().expect("kept");
    let file = File::parse(&built.bytes).expect("a file");
    let scenario = Scenario::parse(PUSH, "push.toml").expect("a scenario");
    for factors in [[0.25, 10.0, 0.2, 2.0, 10.0], [4.0, 0.1, 5.0, 0.5, 0.1], [0.6, 3.0, 1.4, 1.7, 4.0]] {
        let asked: Vec<_> = names.iter().zip(factors).map(|(name, factor)| value(name, factor)).collect();
        let [frequency, error, contact] = errors_at(&file, &problem, &scenario, &asked);
        assert!(
            frequency < 2e-3 && error < 5e-3 && contact < 2e-2,
            "{frequency:e} {error:e} {contact:e} at {factors:?}"
        );
        // The same body, built at these values without any live parameter.
        let fixed = self::problem(&attached(factors, ""));
        let [(found, _), (expected, _)] = [(&problem, &asked[..]), (&fixed, &[])]
            .map(|(problem, asked)| natural_modes(problem, Some(6), None, asked, &Silent).expect("modes"));
        for (found, expected) in found.frequencies_hz.iter().zip(&expected.frequencies_hz) {
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} beside {expected} at {factors:?}");
        }
        for (found, expected) in found.material_damping.iter().zip(&expected.material_damping) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} beside {expected} at {factors:?}");
        }
    }
}

#[test]
fn live_attachments_are_refused_where_there_is_none_to_scale() {
    let live = |rest: &str| format!("[[parameter]]\nname = \"p\"\nrange = [0.5, 2.0]\n{rest}\n");
    for (rest, named) in [
        ("kind = \"stiffness\"\nattachment = \"mont\"", "did you mean `mount`?"),
        ("kind = \"stiffness\"\nattachment = \"motor\"", "`[[spring]]` or stiff `[[foundation]]`"),
        ("kind = \"mass\"\nattachment = \"mount\"", "`[[point_mass]]`"),
        ("kind = \"density\"\nattachment = \"motor\"", "`\"mass\"` or `\"damping\"`"),
        ("kind = \"mass\"", "the name of a `[[point_mass]]`"),
        ("kind = \"damping\"\nattachment = \"bed\"", "`[[dashpot]]` or damped `[[foundation]]`"),
    ] {
        let text = attached([1.0; 5], &live(rest));
        let refused =
            Problem::parse(&text, "beam.toml", std::path::PathBuf::new()).expect_err(rest).to_string();
        assert!(refused.contains("`parameter[0].attachment`") && refused.contains(named), "{refused}");
    }
}

#[test]
fn loss_factors_damp_by_strain_energy_and_follow_the_parameters() {
    // The root has a loss factor that is fixed, the tip one that is live.
    let text = BEAM
        .replacen("[[material]]\n", "[[material]]\nregion = \"body\"\nloss_factor = 0.02\n", 1)
        .replacen("[damping]", "[[material]]\nregion = \"tip\"\nyoung = 2.1e9\npoisson = 0.3\ndensity = 1200.0\nloss_factor = 0.1\n[damping]", 1)
        + "[[parameter]]\nname = \"loss\"\nkind = \"loss-factor\"\nregion = \"tip\"\nrange = [0.0, 0.2]\n";
    let problem = problem(&text);
    let built = build(&problem, &BuildOptions::default(), &Silent).expect("built").kept().expect("kept");
    let file = File::parse(&built.bytes).expect("a file");
    assert_eq!(numbers(&file, S::LiveLoss), [0.02, 0.02, 0.1]);
    let scenario = Scenario::parse(PUSH, "push.toml").expect("a scenario");
    for [root, tip, loss] in [[0.25, 4.0, 0.2], [4.0, 0.3, 0.05], [1.0, 1.0, 0.0]] {
        let at = |root: f64, tip: f64| [value("root", root), value("tip", tip), value("loss", loss)];
        let lambda = |root: f64, tip: f64| -> Vec<f64> {
            let (modes, _) = natural_modes(&problem, Some(6), None, &at(root, tip), &Silent).expect("modes");
            modes.frequencies_hz.iter().map(|hertz| (hertz * std::f64::consts::TAU).powi(2)).collect()
        };
        // The share of the energy in a region is the slope of the eigenvalue with its stiffness.
        let share = |k: usize, [root_slope, tip_slope]: [f64; 2]| {
            let [up, down] = [1.0, -1.0].map(|sign| {
                lambda(root * (1e-4 * sign * root_slope).exp(), tip * (1e-4 * sign * tip_slope).exp())[k]
            });
            (up / down).ln() / 2e-4
        };
        let body = at_values(&file, &at(root, tip), None).expect("set").expect("a model");
        let found = numbers(&File::parse(&body.bytes).expect("a file"), S::DampingRatios);
        for (k, found) in found.iter().take(3).enumerate() {
            let expected = 0.02 + 0.5 * (0.02 * share(k, [1.0, 0.0]) + loss * share(k, [0.0, 1.0]));
            assert!(
                (found - expected).abs() < 2e-5,
                "mode {k}: {found} beside {expected} at {root}, {tip}, {loss}"
            );
        }
        let [_, error, contact] = errors_at(&file, &problem, &scenario, &at(root, tip));
        assert!(error < 2e-3 && contact < 1e-2, "{error:e} {contact:e} at {root}, {tip}, {loss}");
    }
    let model = Parametric::new(&file).expect("a model");
    let modes = model.usual_modes();
    let (sizes, tangents) = (model.sizes(modes).expect("sizes"), model.tangent_sizes(modes));
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work.max(tangents.work)]);
    let mut lent = vec![0.0; tangents.memory];
    let mut values = vec![0.0; model.n_parameters()];
    model.nominal_into(&mut values);
    let tuned = model.solve(&values, modes, &mut memory, &mut work).expect("modes");
    let refused =
        vademecum_eval::Tangents::new(&model, tuned, &mut lent, &mut work).expect_err("loss factors");
    assert_eq!(refused, ParametricError::LossFactors);
}

#[test]
fn loss_factors_of_a_fixed_file_are_those_of_its_reference() {
    let text = BEAM.split_once("[[parameter]]").expect("parameters").0.replacen(
        "representation = \"parametric\"\n",
        "",
        1,
    );
    let text = text
        .replacen("[[material]]\n", "[[material]]\nregion = \"body\"\nloss_factor = 0.02\n", 1)
        .replacen("[damping]", "[[material]]\nregion = \"tip\"\nyoung = 2.1e9\npoisson = 0.3\ndensity = 1200.0\nloss_factor = 0.1\n[damping]", 1);
    let attached = "[[reference_point]]\nname = \"hub\"\nat = [1.0, 0.05, 0.06]\n\
                    [[coupling]]\nreference = \"hub\"\non = { group = \"x_max\" }\nkind = \"rigid\"\n\
                    [[spring]]\nfrom = \"hub\"\nstiffness = [1e4, 0, 5e4, 0, 0, 0]\n";
    let scenario = Scenario::parse(PUSH, "push.toml").expect("a scenario");
    for text in [text.clone(), text + attached] {
        let problem = problem(&text);
        let built = build(&problem, &BuildOptions::default(), &Silent).expect("built").kept().expect("kept");
        let file = File::parse(&built.bytes).expect("a file");
        let ratios = numbers(&file, S::DampingRatios);
        assert!(ratios.iter().all(|ratio| (0.02..0.07).contains(ratio)), "{ratios:?}");
        let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("prepared");
        let found = verify(&file, &PlayOptions::default(), &problem, &prepared, &scenario, &Silent)
            .expect("verified");
        let Figures::Linear(figures) = found.figures else { panic!("a linear body") };
        assert!(figures.truth.total_error < 2e-3, "{:e}", figures.truth.total_error);
    }
}

/// Sets a file to the values as built, or past them, and steps the body under a push.
fn set_and_stepped(bytes: &[u8]) -> Result<(), Box<dyn std::error::Error>> {
    let file = File::parse(bytes)?;
    let model = Parametric::new(&file)?;
    let mut values = vec![0.0; model.n_parameters()];
    model.nominal_into(&mut values);
    let bytes = model.body_at(&values, model.usual_modes())?;
    let mut simulation = Simulation::<f64>::with_options(bytes, &BodyOptions::default())?;
    simulation.step(1)?;
    Ok(())
}

#[test]
fn numbers_of_live_sections_that_make_no_sense_are_refused_or_stepped_without_a_panic() {
    let mut refused = 0;
    for name in ["parametric.vdm", "damped.vdm"] {
        let bytes = golden::named(name);
        set_and_stepped(&bytes).expect(name);
        let file = File::parse(&bytes).expect("a file");
        let live = file.sections().filter(|section| section.kind().number() >= 111);
        for kind in live.map(|section| section.kind()).collect::<Vec<_>>() {
            let raw = file.section(kind).expect("a section").raw().expect("raw");
            let width = if kind == S::LiveRegions || kind == S::LiveDampers { 4 } else { 8 };
            let wrong: Vec<Vec<u8>> = match width {
                4 => [1_u32, 7, u32::MAX].iter().map(|x| x.to_le_bytes().to_vec()).collect(),
                _ => [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300, 4e9]
                    .iter()
                    .map(|x| x.to_le_bytes().to_vec())
                    .collect(),
            };
            for (place, wrong) in
                (0..raw.len() / width).flat_map(|place| wrong.iter().map(move |w| (place, w)))
            {
                let mut own = raw.to_vec();
                own[place * width..(place + 1) * width].copy_from_slice(wrong);
                let changed = golden::with_raw(&bytes, kind, &own);
                refused += usize::from(set_and_stepped(&changed).is_err());
            }
            // A section that is cut, and one that is gone.
            let shorter = golden::with_raw(&bytes, kind, &raw[..raw.len() - width]);
            refused += usize::from(set_and_stepped(&shorter).is_err());
        }
    }
    assert!(refused > 200, "{refused}");
}

#[test]
fn contacts_near_each_other_are_as_flexible_as_those_of_the_full_model_at_the_values() {
    let output = "[output]\ncontact_patch = 0.15\n";
    let live = problem(&(BEAM.to_string() + output));
    let built = build(&live, &BuildOptions::default(), &Silent).expect("built").kept().expect("kept");
    let file = File::parse(&built.bytes).expect("a file");
    let [root, tip] = [0.4, 3.0];
    let asked = [value("root", root), value("tip", tip), value("step", 1e-3)];
    let body = at_values(&file, &asked, Some(24)).expect("set").expect("a model");
    let text = BEAM.split_once("[[parameter]]").expect("parameters").0.replacen(
        "representation = \"parametric\"\n",
        "",
        1,
    );
    let stiff = |factor: f64| format!("young = {:e}\npoisson = 0.3\ndensity = 1200.0\n", factor * 2.1e9);
    let (head, rest) = text.split_once("[[material]]\n").expect("a material");
    let (_, rest) = rest.split_once("density = 1200.0\n").expect("a density");
    let text = format!(
        "{head}[[material]]\nregion = \"body\"\n{}[[material]]\nregion = \"tip\"\n{}{rest}{output}contact_modes = 0\n",
        stiff(root),
        stiff(tip)
    );
    let fixed =
        build(&problem(&text), &BuildOptions::default(), &Silent).expect("built").kept().expect("kept");
    let [found, expected] = [&body.bytes, &fixed.bytes].map(|bytes| File::parse(bytes).expect("a file"));
    let pairs = |file: &File<'_>| file.section(S::PatchPairs).expect("pairs").raw().expect("raw").to_vec();
    assert_eq!(pairs(&found), pairs(&expected));
    assert!(found.section(S::ContactModes).is_none());
    // The whole flexibility between two nodes, of which a force at one of them is a row.
    let whole = |file: &File<'_>| -> Vec<f64> {
        let (m, blocks) = (file.metadata().n_modes as usize, numbers(file, S::PatchResidual));
        let (rows, lambda) = (numbers(file, S::SurfaceBasis), numbers(file, S::Eigenvalues));
        let row = |node: usize, c: usize| &rows[(3 * node + c) * m..][..m];
        let nodes: Vec<usize> = pairs(file)
            .chunks_exact(4)
            .map(|x| u32::from_le_bytes(x.try_into().expect("four")) as usize)
            .collect();
        let entry = |(place, block): (usize, &f64)| {
            let [a, b] = [nodes[2 * (place / 9)], nodes[2 * (place / 9) + 1]];
            let modes = row(a, place % 9 / 3).iter().zip(row(b, place % 3)).zip(&lambda);
            block + modes.map(|((a, b), lambda)| a * b / lambda).sum::<f64>()
        };
        blocks.iter().enumerate().map(entry).collect()
    };
    let (found, expected) = (whole(&found), whole(&expected));
    for (place, (found, expected)) in found.chunks_exact(9).zip(expected.chunks_exact(9)).enumerate() {
        let size = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
        let off = found.iter().zip(expected).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        assert!(off <= 0.05 * size, "pair {place}: {found:?} beside {expected:?}");
    }
}
