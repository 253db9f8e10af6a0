//! The table: what is stressed, how far, and what must come of it.

use vademecum_build::dynamics::SchemeKind;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::BuildError;

use super::bodies::{Beam, Cube, parse, timed};
use super::build::certified;
use super::{Cell, Expected, Scenario, drive, hostile, live, long, units};

/// Steps in the first natural period where nothing else is stressed.
const STEPS: f64 = 40.0;

/// All cells.
#[must_use]
pub fn cells() -> Vec<Cell> {
    let groups = [
        steps(),
        schemes(),
        materials(),
        contrasts(),
        shapes(),
        sizes(),
        supports(),
        modes(),
        stiff_modes(),
        damping(),
        marches(),
        parameters(),
    ];
    groups.into_iter().flatten().collect()
}

/// A cell that must be green.
fn green(
    group: &'static str,
    name: impl Into<String>,
    problem: impl Fn() -> Result<Problem, BuildError> + 'static,
    scenario: Scenario,
) -> Cell {
    let problem = Box::new(problem);
    Cell { group, name: name.into(), problem, scenario, expected: Expected::Green }
}

impl Cell {
    fn refused(self, name: &'static str) -> Self {
        Self { expected: Expected::Refused(name), ..self }
    }

    fn limit(self, name: &'static str) -> Self {
        Self { expected: Expected::Limit(name), ..self }
    }

    /// Undamped schemes drift in single precision.
    fn late_if_undamped(self, scheme: SchemeKind) -> Self {
        if undamped(scheme) { Self { expected: Expected::Late("f32, undamped"), ..self } } else { self }
    }
}

fn bathe() -> SchemeKind {
    SchemeKind::default()
}

/// Schemes that take nothing from any frequency.
fn undamped(scheme: SchemeKind) -> bool {
    use SchemeKind as S;
    let all = [
        S::RhoBathe { rho_infinity: 1.0 },
        S::Newmark { beta: 0.25, gamma: 0.5 },
        S::GeneralizedAlpha { rho_infinity: 1.0 },
    ];
    all.contains(&scheme)
}

/// Every time scheme, at the ends of its parameters.
fn all_schemes() -> Vec<SchemeKind> {
    use SchemeKind as S;
    vec![
        S::Bathe {},
        S::RhoBathe { rho_infinity: 0.0 },
        S::RhoBathe { rho_infinity: 1.0 },
        S::Newmark { beta: 0.25, gamma: 0.5 },
        S::Newmark { beta: 0.3025, gamma: 0.6 },
        S::HhtAlpha { alpha: -1.0 / 3.0 },
        S::GeneralizedAlpha { rho_infinity: 0.0 },
        S::GeneralizedAlpha { rho_infinity: 1.0 },
    ]
}

/// Δt from T1/5 to T1/1e5, with every scheme. Snapshots of three periods at T1/1e5 are long: natural modes
/// there.
fn steps() -> Vec<Cell> {
    let mut cells = vec![];
    for scheme in all_schemes() {
        for (steps, kind, scenario) in
            [(5.0, "ritz", certified as Scenario), (1e2, "ritz", certified), (1e5, "modes", drive::held)]
        {
            let beam = Beam::default().with(&format!("kind = \"{kind}\"\n"));
            let name = format!("{scheme}, T1/{steps}");
            let cell = green("time step", name, move || beam.problem(steps, scheme), scenario);
            cells.push(if steps < 10.0 { cell.late_if_undamped(scheme) } else { cell });
        }
    }
    cells
}

/// A long free march with every scheme.
fn schemes() -> Vec<Cell> {
    let trapezoidal = SchemeKind::Newmark { beta: 0.25, gamma: 0.5 };
    let cell = |scheme: SchemeKind| {
        let scenario = if scheme == bathe() || scheme == trapezoidal { long::longest } else { long::free };
        green("many steps", format!("{scheme}"), move || Beam::default().problem(STEPS, scheme), scenario)
            .late_if_undamped(scheme)
    };
    all_schemes().into_iter().map(cell).collect()
}

fn materials() -> Vec<Cell> {
    let cell = |(poisson, order): (f64, &'static str)| {
        let beam = Beam { poisson, order, ..Beam::default() };
        green(
            "Poisson's ratio",
            format!("{poisson}, {order}"),
            move || beam.problem(STEPS, bathe()),
            certified,
        )
    };
    let all =
        [(0.0, "linear"), (-0.9, "linear"), (0.49, "quadratic"), (0.499, "quadratic"), (0.499, "linear")];
    all.into_iter().map(cell).collect()
}

/// The outer half of the beam as a region of its own.
fn two_regions(young: f64, density: f64, more: &str) -> Problem {
    let beam = Beam { more: more.into(), ..Beam::default() };
    let region = "[[mesh.region]]\nname = \"tip\"\non = { fraction = { axis = \"x\", side = \"max\", \
        fraction = 0.5 } }\n";
    let tip =
        format!("[[material]]\nregion = \"tip\"\nyoung = {young:e}\npoisson = 0.3\ndensity = {density:e}\n");
    let text = beam.text().replacen("[[material]]\n", &format!("{region}{tip}[[material]]\n"), 1);
    parse(&text)
}

fn contrasts() -> Vec<Cell> {
    let cell = |group, factor: f64, problem: fn(f64) -> Problem| {
        green(group, format!("tip × {factor:e}"), move || timed(problem(factor), STEPS, bathe()), certified)
    };
    let stiffness = [1e6, 1e-6].map(|f| cell("stiffness contrast", f, |f| two_regions(f * 2e9, 1200.0, "")));
    let density = [1e4, 1e-4].map(|f| cell("density contrast", f, |f| two_regions(2e9, f * 1200.0, "")));
    stiffness.into_iter().chain(density).collect()
}

/// Thin elements in a compact body, and thin bodies.
fn shapes() -> Vec<Cell> {
    let thin = |name: &str, lengths, divisions| {
        let beam = Beam { lengths, divisions, ..Beam::quadratic() };
        green("mesh", name, move || beam.problem(STEPS, bathe()), certified)
    };
    let cube = |name: &str, warp: fn([f64; 3]) -> [f64; 3]| {
        let cube = Cube::warped(warp);
        green("mesh", name, move || timed(cube.problem(), STEPS, bathe()), certified)
    };
    vec![
        cube("cube graded to aspect 1e3", |[x, y, z]| [if x < 0.9 { 1e-3 * (x / 0.25) } else { x }, y, z]),
        cube("cube with slivers of 1e-3", |p| if p == [0.5; 3] { [0.25025, 0.5, 0.5] } else { p }),
        thin("plate of aspect 100", [1.0, 1.0, 1e-2], [2, 2, 1]),
        thin("plate of aspect 1e3", [1.0, 1.0, 1e-3], [2, 2, 1]).refused("lost in rounding"),
        thin("wire of aspect 1e3", [1.0, 1e-3, 1e-3], [4, 1, 1]).refused("lost in rounding"),
    ]
}

/// Bodies of 1 mm and 100 m, of steel and gel. Units are compared on a stocky one: the first frequency of a
/// slender one is itself known to some 1e-10 only (`docs/measurements/stability.md`).
fn sizes() -> Vec<Cell> {
    let mut cells = vec![];
    for (material, young, poisson, density) in [("steel", 2.1e11, 0.3, 7850.0), ("gel", 1e3, 0.49, 1000.0)] {
        for length in [1e-6, 1e-3, 1.0, 100.0] {
            let beam = Beam { young, poisson, density, ..Beam::quadratic().long(length) };
            let stocky =
                Beam { lengths: [length, 0.5 * length, 0.5 * length], divisions: [2, 1, 1], ..beam.clone() };
            let name = format!("{length} m of {material}");
            cells.push(green("size", name.clone(), move || beam.problem(STEPS, bathe()), certified));
            cells.push(green(
                "units",
                format!("{name}, SI and mm-t-MPa"),
                move || stocky.problem(STEPS, bathe()),
                units::same_answer,
            ));
        }
    }
    cells
}

fn supports() -> Vec<Cell> {
    let cell = |name: &str, support: &'static str| {
        let beam = Beam { support, ..Beam::default() };
        green("supports", name, move || beam.problem(STEPS, bathe()), certified)
    };
    let hinged = |name: &str, keep: fn([f64; 3]) -> bool| {
        let cube = Cube::part(keep);
        green("supports", name, move || timed(cube.problem(), STEPS, bathe()), certified)
            .refused("lost in rounding")
    };
    vec![
        cell("none", "").refused("unsupported"),
        cell("one node", "{ nodes = [1] }").refused("unsupported"),
        cell("one edge: a hinge", "{ all = [{ group = \"x_min\" }, { group = \"z_min\" }] }")
            .refused("unsupported"),
        cell("three nodes, not in a line", "{ nodes = [1, 8, 15] }"),
        hinged("two halves that share an edge", |[x, y, _]| (x < 0.5) == (y < 0.5)),
        hinged("two parts that share a node", |[x, y, z]| (x < 0.5) == (y < 0.5) && (y < 0.5) == (z < 0.5)),
    ]
}

fn modes() -> Vec<Cell> {
    let cell = |modes: usize, kind: &str, positions: usize| {
        let beam = Beam { modes, ..Beam::default() }.with(&format!("kind = \"{kind}\"\n"));
        let text = beam.text().replace("positions = 2\n", &format!("positions = {positions}\n"));
        let name = format!("{modes} of 72, {kind}, {positions} positions");
        green("modes", name, move || timed(parse(&text), STEPS, bathe()), certified)
    };
    let alike = |modes: usize, kind: &str, directions: &str| {
        let beam = Beam { modes, ..Beam::default() }.with(&format!("kind = \"{kind}\"\n"));
        let text =
            beam.text().replace("positions = 2\n", &format!("positions = 1\ndirections = {directions}\n"));
        let name = format!("{modes} modes, {kind}, directions {directions}");
        green("snapshots alike", name, move || timed(parse(&text), STEPS, bathe()), certified)
    };
    let (one, two) = ("[[0, 0, 1]]", "[[0, 0, 1], [0, 1e-9, 1]]");
    let spanned = "more modes than the snapshots span";
    vec![
        cell(1, "ritz", 2),
        cell(1, "pod", 2),
        cell(16, "ritz", 2),
        cell(16, "pod", 2),
        cell(32, "ritz", 12),
        cell(64, "ritz", 12),
        cell(64, "pod", 12),
        cell(64, "ritz", 1).refused(spanned),
        cell(64, "modes", 2),
        cell(72, "modes", 2),
        cell(80, "modes", 2).refused("more modes than dofs"),
        alike(6, "ritz", one),
        alike(6, "ritz", two),
        alike(16, "ritz", two),
        alike(8, "pod", two).refused("tolerance missed"),
        alike(64, "ritz", two).refused(spanned),
    ]
}

/// Nearly as many modes as the body has dofs, at a coarse step: the highest are far above what the step
/// resolves.
fn stiff_modes() -> Vec<Cell> {
    let cell = |scheme: SchemeKind, kind: &'static str, scenario| {
        let text = Beam { modes: 64, ..Beam::default() }.with(&format!("kind = \"{kind}\"\n")).text();
        let text = text.replace("positions = 2\n", "positions = 12\n");
        green(
            "64 modes at T1/5",
            format!("{kind}, {scheme}"),
            move || timed(parse(&text), 5.0, scheme),
            scenario,
        )
    };
    let mut cells = vec![];
    for scheme in all_schemes() {
        let (open, closed) = (cell(scheme, "pod", certified), cell(scheme, "modes", long::stiff));
        // What the step does not resolve never dies without damping, and on a basis that is not closed it
        // feeds on the rest.
        cells.push(if undamped(scheme) { open.refused("tolerance missed") } else { open });
        // Its third eigenvalue is −1 at any step: beside a pair that comes close, rounding moves all three.
        let defective = scheme == SchemeKind::GeneralizedAlpha { rho_infinity: 1.0 };
        cells.push(if defective {
            closed.refused("tolerance missed")
        } else {
            closed.late_if_undamped(scheme)
        });
    }
    cells
}

/// From next to none to beyond critical. β in first periods.
fn damping() -> Vec<Cell> {
    let cell = |alpha: f64, beta: f64| {
        let problem = move || {
            let mut problem = Beam::default().problem(STEPS, bathe())?;
            let period = STEPS * problem.time.step.expect("a step");
            (problem.damping.alpha, problem.damping.beta) = (Some(alpha / period), Some(beta * period));
            Ok(problem)
        };
        green("damping", format!("α = {alpha:e}/T1, β = {beta:e} T1"), problem, certified)
    };
    [(1e-12, 0.0), (0.0, 1e-12), (100.0, 0.0), (0.0, 0.1), (0.0, 1e3), (1e3, 1e3)]
        .map(|(a, b)| cell(a, b))
        .into()
}

fn marches() -> Vec<Cell> {
    let cell = |name: &str, scheme: SchemeKind, scenario| {
        green("loads", format!("{name}, {scheme}"), move || Beam::default().problem(STEPS, scheme), scenario)
    };
    let mut cells = vec![];
    for scheme in all_schemes() {
        cells.push(cell("switched every step", scheme, drive::switched));
        cells.push(cell("at resonance", scheme, drive::resonant));
    }
    let fine = || Beam::default().with("kind = \"modes\"\n").problem(1e5, bathe());
    cells.push(green("loads", "1e-12 ×, bathe, T1/1e5", fine, drive::tiny).limit("f32 floor"));
    for (name, scenario) in [
        ("1e12 ×", drive::huge as Scenario),
        ("1e-12 ×", drive::tiny),
        ("denormal", drive::denormal),
        ("NaN, ±∞", hostile::not_finite),
    ] {
        cells.push(cell(name, bathe(), scenario));
    }
    cells
}

const UNIFORM: &str = "\
[[parameter]]\nname = \"stiffness\"\nkind = \"stiffness\"\nrange = [0.5, 2.0]\nscale = \"log\"\n\
[[parameter]]\nname = \"density\"\nkind = \"density\"\nrange = [0.5, 2.0]\n";

const WIDE: &str = "\
[[parameter]]\nname = \"stiffness\"\nkind = \"stiffness\"\nrange = [1e-3, 1e3]\nscale = \"log\"\n\
[[parameter]]\nname = \"alpha\"\nkind = \"alpha\"\nrange = [0.0, 1e3]\n\
[[parameter]]\nname = \"beta\"\nkind = \"beta\"\nrange = [0.0, 1.0]\n";

const REGIONS: &str = "[[parameter]]\nname = \"tip\"\nkind = \"stiffness\"\nregion = \"tip\"\nrange = [0.5, \
    2.0]\nscale = \"log\"\n";

fn parameters() -> Vec<Cell> {
    let uniform = Beam::default().with(UNIFORM);
    let slow = uniform.clone();
    let regions = || timed(two_regions(2e9, 1200.0, REGIONS), STEPS, bathe());
    let wide = Beam::default().with(WIDE);
    let group = "parameters set every step";
    vec![
        green(group, "uniform, period T1/6", move || uniform.problem(STEPS, bathe()), live::fast),
        green(group, "uniform, period 10 T1", move || slow.problem(STEPS, bathe()), live::slow),
        green(
            group,
            "stiffness × 1e-3 … 1e3, α, β, period 10 T1",
            move || wide.problem(STEPS, bathe()),
            live::slow,
        ),
        green(group, "a region's, period 10 T1", regions, live::slow),
        green(
            group,
            "a region's, contrast 1e6, period 10 T1",
            || timed(two_regions(2e3, 1200.0, REGIONS), STEPS, bathe()),
            live::slow,
        ),
        green(group, "a region's, period T1/6", regions, live::fast).limit("fast regions"),
    ]
}
