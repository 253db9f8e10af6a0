//! Problems of the stress matrix, as text.

use std::fmt::Write as _;

use tempfile::TempDir;
use vademecum_build::dynamics::{SchemeKind, lowest_modes};
use vademecum_build::input::Problem;
use vademecum_build::mesh::{Order, block};
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};

/// A beam clamped at x = 0 and pulled at its end by the load pattern `pull`.
#[derive(Clone, Debug)]
pub struct Beam {
    /// Edge lengths.
    pub lengths: [f64; 3],
    /// Cells along each edge.
    pub divisions: [usize; 3],
    /// `linear` or `quadratic`.
    pub order: &'static str,
    /// Young's modulus.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density.
    pub density: f64,
    /// Modes.
    pub modes: usize,
    /// Pulling traction.
    pub traction: [f64; 3],
    /// The held nodes, as TOML; empty for none.
    pub support: &'static str,
    /// Keys of `[basis]` beside `modes`, and whole tables after it.
    pub more: String,
}

impl Default for Beam {
    /// Linear elements, 72 dofs, a polymer: hundreds of thousands of full-order steps are seconds.
    fn default() -> Self {
        Self {
            lengths: [1.0, 0.1, 0.1],
            divisions: [6, 1, 1],
            order: "linear",
            young: 2e9,
            poisson: 0.3,
            density: 1200.0,
            modes: 6,
            traction: [30.0, -20.0, 100.0],
            support: "{ group = \"x_min\" }",
            more: String::new(),
        }
    }
}

impl Beam {
    /// The same beam of quadratic elements (324 dofs).
    #[must_use]
    pub fn quadratic() -> Self {
        Self { order: "quadratic", ..Self::default() }
    }

    /// With other edge lengths in the same proportions.
    #[must_use]
    pub fn long(self, length: f64) -> Self {
        Self { lengths: [length, 0.1 * length, 0.1 * length], ..self }
    }

    /// With more TOML: keys of `[basis]` first.
    #[must_use]
    pub fn with(self, more: &str) -> Self {
        Self { more: more.into(), ..self }
    }

    /// The problem file's text; its step is a placeholder until [`timed`] sets it.
    #[must_use]
    pub fn text(&self) -> String {
        let Beam { lengths, divisions, order, young, poisson, density, modes, traction, support, more } =
            self;
        let mut text = String::from("title = \"a beam of the stress matrix\"\n");
        let mut table = |lines: &str| text.push_str(lines);
        table("[mesh]\n");
        table(&format!(
            "block = {{ lengths = {lengths:?}, divisions = {divisions:?}, order = \"{order}\" }}\n"
        ));
        table(&format!("[[material]]\nyoung = {young:e}\npoisson = {poisson}\ndensity = {density:e}\n"));
        if !support.is_empty() {
            table(&format!("[[support]]\non = {support}\n"));
        }
        table(&format!(
            "[load]\n[[load.pattern]]\nname = \"pull\"\ntraction = {traction:?}\non = {{ group = \"x_max\" \
             }}\n"
        ));
        table("[time]\nscheme.name = \"bathe\"\nstep = 1.0\n[snapshots]\npositions = 2\n[output]\n");
        let _ = write!(text, "[basis]\nmodes = {modes}\n{more}");
        text
    }

    /// The problem with `steps` steps in its first natural period.
    ///
    /// # Errors
    /// [`BuildError`] if the body has no first mode.
    pub fn problem(&self, steps: f64, scheme: SchemeKind) -> Result<Problem, BuildError> {
        timed(parse(&self.text()), steps, scheme)
    }
}

/// A problem from text.
///
/// # Panics
/// If the text is none: a fault of the table.
#[must_use]
pub fn parse(text: &str) -> Problem {
    Problem::parse(text, "stress.toml", ".".into()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Gives a problem a scheme and `steps` steps in its first natural period.
///
/// # Errors
/// [`BuildError`] if the body has no first mode.
pub fn timed(mut problem: Problem, steps: f64, scheme: SchemeKind) -> Result<Problem, BuildError> {
    let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent)?;
    let first = lowest_modes(prepared.body.model.pencil(), &prepared.symbolic, 1)?;
    problem.time.step = Some(1.0 / (steps * first.frequencies_hz()[0]));
    problem.time.scheme = Some(scheme);
    Ok(problem)
}

/// A unit cube of 4 × 4 × 4 cells, held at x = 0, its nodes moved or elements taken out: written to two
/// tables, as a user's mesh would come.
pub struct Cube {
    folder: TempDir,
}

impl Cube {
    /// Moves each node.
    #[must_use]
    pub fn warped(warp: fn([f64; 3]) -> [f64; 3]) -> Self {
        Self::written(warp, |_| true)
    }

    /// Keeps the elements whose middle is wanted.
    #[must_use]
    pub fn part(keep: fn([f64; 3]) -> bool) -> Self {
        Self::written(|p| p, keep)
    }

    fn written(warp: fn([f64; 3]) -> [f64; 3], keep: fn([f64; 3]) -> bool) -> Self {
        let mesh = block([1.0; 3], [4; 3], Order::Linear);
        let middle = |element: &&[u32]| {
            let at = |k: usize| element.iter().map(|&n| mesh.nodes[n as usize][k]).sum::<f64>() / 4.0;
            keep([at(0), at(1), at(2)])
        };
        let line = |numbers: &[f64]| numbers.iter().map(|x| format!("{x} ")).collect::<String>() + "\n";
        let nodes: String = mesh.nodes.iter().map(|&p| line(&warp(p))).collect();
        let kept = mesh.elements.chunks_exact(4).filter(middle);
        let elements: String =
            kept.map(|e| line(&e.iter().map(|&n| f64::from(n + 1)).collect::<Vec<_>>())).collect();
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("nodes.txt"), nodes).expect("written");
        std::fs::write(folder.path().join("elements.txt"), elements).expect("written");
        Self { folder }
    }

    /// Its problem; the step is a placeholder until [`timed`] sets it.
    #[must_use]
    pub fn problem(&self) -> Problem {
        let text = Beam { modes: 16, ..Beam::default() }.text();
        let (_, rest) = text.split_once("[[material]]").expect("a material");
        self.parse(&format!("[[material]]{rest}"))
    }

    /// A problem of this mesh from what follows it, with the groups of a block.
    #[must_use]
    pub fn parse(&self, rest: &str) -> Problem {
        let mesh = "mesh = { tables = { coordinates = \"nodes.txt\", connectivity = \"elements.txt\" } }\n";
        let text = format!("{mesh}{rest}")
            .replace("{ group = \"x_min\" }", "{ plane = { axis = \"x\", at = 0.0 } }")
            .replace("{ group = \"x_max\" }", "{ plane = { axis = \"x\", at = 1.0 } }");
        Problem::parse(&text, "stress.toml", self.folder.path().into())
            .unwrap_or_else(|error| panic!("{error}\n{text}"))
    }
}
