//! A uniform body is never built twice: the diagonal structure of one file takes any stiffness, density, time
//! step and Rayleigh damping in closed form. Here it is stepped at 20 random sets of them beside files built
//! anew for each set.
//!
//! The basis is the lowest natural modes, which uniform scales do not turn, so that both files span the same
//! space although the second one assembled, factorised and iterated with other numbers.

use std::path::PathBuf;

use vademecum_build::dynamics::lowest_modes;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{Contact, Field, Place, SceneOptions, StructureChoice};
use vademecum_tests::largest::largest_eigenvalue;
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::Random;

const MODES: usize = 5;
/// Steps under a contact, and free ones after it.
const STEPS: [usize; 2] = [60, 140];

/// What the diagonal structure takes in closed form.
#[derive(Clone, Copy, Debug)]
struct Uniform {
    young: f64,
    density: f64,
    time_step: f64,
    alpha: f64,
    beta: f64,
}

const BUILT: Uniform = Uniform { young: 2e9, density: 1200.0, time_step: 1e-3, alpha: 0.4, beta: 2e-6 };

impl Uniform {
    /// Stiffness over two decades, density over a factor 4, the time step over one, damping from none to
    /// much.
    fn random(random: &mut Random) -> Self {
        let mut times = |factor: f64| factor.powf(random.number());
        let (young, density, time_step) = (2e9 * times(10.0), 1200.0 * times(2.0), 1e-3 * times(3.16));
        let mut share = || 0.5 * (1.0 + random.number());
        Self { young, density, time_step, alpha: 10.0 * share(), beta: 1e-4 * share() }
    }

    /// A short beam made of this.
    fn problem(&self) -> Problem {
        let Self { young, density, time_step, alpha, beta } = self;
        let text = format!(
            "[mesh]\nblock = {{ lengths = [1.0, 0.16, 0.1], divisions = [6, 1, 1] }}\n\
             [[material]]\nyoung = {young:e}\npoisson = 0.3\ndensity = {density:e}\n\
             [damping]\nalpha = {alpha:e}\nbeta = {beta:e}\n\
             [[support]]\non = {{ group = \"x_min\" }}\n[load]\n[time]\nscheme.name = \"bathe\"\nstep = {time_step:e}\n\
             [basis]\nkind = \"modes\"\nmodes = {MODES}\n[tolerance]\nsteps = 10\n"
        );
        Problem::parse(&text, "uniform.toml", PathBuf::new()).expect("a problem")
    }

    /// The beam's file.
    fn file(&self) -> Vec<u8> {
        // Five natural modes show little of a push at one node; what they show is compared.
        build(&self.problem(), &BuildOptions::default(), &Silent).expect("built").either().bytes
    }

    /// Options that turn the file of `BUILT` into this.
    fn options(&self) -> SceneOptions {
        SceneOptions {
            stiffness: self.young / BUILT.young,
            density: self.density / BUILT.density,
            time_step: Some(self.time_step),
            alpha: Some(self.alpha),
            beta: Some(self.beta),
            ..diagonal()
        }
    }
}

/// The file as it was built, in its diagonal structure.
fn diagonal() -> SceneOptions {
    SceneOptions { structure: StructureChoice::Diagonal, ..SceneOptions::default() }
}

/// Displacement of the surface \[m\] after every step of a push and a free run.
fn motion(bytes: &[u8], options: &SceneOptions) -> Vec<Vec<f64>> {
    with_scene::<f64, _>(bytes, options, |scene, state, loads| {
        let tip = scene.metadata().n_load_nodes - 1;
        let contact = Contact::new(Place::triangle([tip; 3], [1.0, 0.0, 0.0]), [3.0, -2.0, 10.0]);
        let mut motion = vec![];
        for (pushed, steps) in [true, false].into_iter().zip(STEPS) {
            loads.clear();
            if pushed {
                loads.add_contact(scene, &contact).expect("a contact");
            }
            for _ in 0..steps {
                scene.step(state, loads).expect("a step");
                let mut field = vec![0.0; 3 * scene.metadata().n_surface_nodes as usize];
                scene.surface_into(state, Field::Displacement, &mut field).expect("a field");
                motion.push(field);
            }
        }
        motion
    })
}

/// Largest difference of two motions over all steps and components, relative to the largest displacement.
fn apart(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = || a.iter().flatten().zip(b.iter().flatten());
    let largest = pairs().map(|(a, b)| a.abs().max(b.abs())).fold(0.0, f64::max);
    pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// What rounding alone may do, relative to the motion: assembled matrices are off by ε of their largest
/// eigenvalue, so the two builds' λ₁ differ by ε λ_max/λ₁ of itself, static displacements by as much, and the
/// phase ω₁T of the first mode by half of it per build. Higher modes are off by less: ε λ_max/λ_k × ω_k T
/// falls with ω_k. That is the worst case; found is 9e-11 at most.
struct Rounding {
    relative: f64,
    first: f64,
}

impl Rounding {
    fn new() -> Self {
        let prepared = prepare(&BUILT.problem(), &mut Stopwatch::new(&Silent), &Silent).expect("a model");
        let pencil = prepared.body.model.pencil();
        let first = lowest_modes(pencil, &prepared.symbolic, 1).expect("a mode").eigenvalues[0];
        let largest = largest_eigenvalue(pencil, &prepared.symbolic);
        Self { relative: f64::EPSILON * largest / first, first: first.sqrt() }
    }

    fn of(&self, values: &Uniform) -> f64 {
        let first = self.first * (values.young / BUILT.young * BUILT.density / values.density).sqrt();
        let time = values.time_step * STEPS.iter().sum::<usize>() as f64;
        self.relative * (1.0 + first * time)
    }
}

#[test]
fn one_file_steps_as_twenty_built_anew_would() {
    let built = BUILT.file();
    let mut random = Random::new(5);
    let rounding = Rounding::new();
    for _ in 0..20 {
        let values = Uniform::random(&mut random);
        let (closed, anew) = (motion(&built, &values.options()), motion(&values.file(), &diagonal()));
        assert!(apart(&closed, &motion(&built, &diagonal())) > 0.1, "{values:?} moves another way");
        let error = apart(&closed, &anew);
        let tolerance = rounding.of(&values);
        println!("{values:?}: {error:.1e}, rounding may do {tolerance:.1e}");
        assert!(error <= tolerance, "{values:?}: {error:e} > {tolerance:e}");
    }
}
