//! A build whose matrices lie elsewhere: what it asks of an engine, and that it never needs their entries.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use faer::{Mat, MatMut, MatRef};
use vademecum_format::{File, SectionKind};

use super::{BuildOptions, Outcome, build};
use crate::fem::{
    AT_ONCE, AssemblyPlan, Engine, EngineError, Factor, FactorError, ModelError, Pencil, PencilRows,
    RigidBody, Search, Solve, SpreadFactor, SpreadMatrix, Symbolic, SymmetricMatrix, pencil_rows,
};
use crate::input::Problem;
use crate::progress::Listener;

/// One rank that keeps what it assembles to itself.
#[derive(Debug, Default)]
struct Alone(Known);

/// Its matrices, by their numbers.
type Known = Arc<Mutex<Vec<StageCache>>>;

#[derive(Clone, Debug)]
struct StageCache {
    known: Known,
    number: usize,
    pencil: Pencil,
    of_mass: bool,
    diagonal: Vec<f64>,
}

#[derive(Debug)]
struct Made {
    pencil: Pencil,
    /// Of the stiffness that springs hold, if it takes any.
    held: Arc<Factor>,
    /// Of a body without supports as a search takes it.
    factor: Arc<Factor>,
}

impl StageCache {
    fn new(known: &Known, pencil: Pencil, of_mass: bool) -> Self {
        let mut all = known.lock().unwrap();
        let mut kept =
            StageCache { known: known.clone(), number: all.len(), pencil, of_mass, diagonal: vec![] };
        kept.diagonal = (0..kept.pencil.n_dof()).map(|i| kept.matrix().diagonal(i)).collect();
        all.push(kept.clone());
        kept
    }

    fn matrix(&self) -> &SymmetricMatrix {
        if self.of_mass { self.pencil.mass() } else { self.pencil.stiffness() }
    }
}

impl Engine for Alone {
    fn ranks(&self) -> usize {
        1
    }

    fn assemble(&self, body: &AssemblyPlan) -> Result<[Arc<dyn SpreadMatrix>; 2], ModelError> {
        let part = body.part(0..body.order().len());
        let pencil = part.assemble()?;
        let in_order = |(free, place): (usize, i64)| body.order()[place as usize] as usize == free;
        assert!(part.free_places().into_iter().enumerate().all(in_order), "one part is the body");
        let keep = |of_mass| -> Arc<dyn SpreadMatrix> {
            Arc::new(StageCache::new(&self.0, pencil.clone(), of_mass))
        };
        Ok([true, false].map(keep))
    }

    fn deal(&self, _: &SymmetricMatrix, _: &[u32]) -> Result<Arc<dyn SpreadMatrix>, EngineError> {
        unreachable!("nothing is dealt")
    }

    fn factorize(
        &self,
        matrix: &dyn SpreadMatrix,
        _: &[u32],
        _: Option<MatRef<'_, f64>>,
        rigid: Option<&Arc<RigidBody>>,
    ) -> Result<Arc<dyn SpreadFactor>, FactorError> {
        let kept = self.0.lock().unwrap()[matrix.number() as usize].clone();
        let Some(rigid) = rigid else {
            let factor = Symbolic::analyze(&kept.pencil)?.factor_of(kept.matrix())?;
            return Ok(Arc::new(Made { pencil: kept.pencil, held: factor.clone(), factor }));
        };
        let held = Symbolic::analyze(&kept.pencil)?.factor_of(&rigid.held(kept.matrix()))?;
        let pencil = kept.pencil.clone().with_rigid(RigidBody::clone(rigid));
        let factor = Symbolic::analyze(&pencil)?.factor_of(kept.matrix())?;
        Ok(Arc::new(Made { pencil, held, factor }))
    }
}

impl SpreadMatrix for StageCache {
    fn number(&self) -> u64 {
        self.number as u64
    }

    fn diagonal(&self) -> &[f64] {
        &self.diagonal
    }

    fn mul_into(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) {
        self.matrix().mul_into(x, y);
    }

    fn scaled(&self, weight: f64) -> Arc<dyn SpreadMatrix> {
        let [m, k] = if self.of_mass { [weight, 1.0] } else { [1.0, weight] };
        let pencil = self.pencil.scaled(&[m], &[k]);
        Arc::new(StageCache::new(&self.known, pencil, self.of_mass))
    }
}

impl SpreadFactor for Made {
    fn solve_in_place(&self, rhs: MatMut<'_, f64>) {
        Solve::new(self.held.symbolic(), rhs.ncols(), false).solve_in_place(&self.held, rhs);
    }

    fn begin<'a>(
        &'a self,
        mass: Arc<dyn SpreadMatrix>,
        search: &Search,
    ) -> Result<Box<dyn PencilRows + 'a>, EngineError> {
        let mut image = Mat::<f64>::zeros(self.pencil.n_dof(), AT_ONCE);
        mass.mul_into(image.clone().as_ref(), image.as_mut());
        pencil_rows(&self.pencil, &self.factor, search)
    }
}

/// Keeps what a build says.
#[derive(Default)]
struct Said(Mutex<Vec<String>>);

impl Listener for Said {
    fn stage(&self, _: &str) {}
    fn advance(&self, _: usize, _: usize) {}
    fn note(&self, text: &str) {
        self.0.lock().unwrap().push(text.into());
    }
}

const BEAM: &str = r#"
[mesh]
block = { lengths = [1.0, 0.1, 0.1], divisions = [8, 2, 2], order = "quadratic" }
[[material]]
young = 2.1e9
poisson = 0.3
density = 1200.0
[load]
surface = { group = "x_max" }
[[load.pattern]]
name = "gravity"
acceleration = [1.0, 2.0, -9.81]
[basis]
kind = "modes"
modes = 6
[time]
step = 1e-3
[[output.probe]]
name = "tip"
point = [1.0, 0.1, 0.1]
direction = [0.0, 0.0, 1.0]
"#;

const HELD: &str = r#"
[[support]]
on = { group = "x_min" }
"#;

/// The bytes of a file and what was said of its build.
fn built(text: &str, engine: Option<&Arc<dyn Engine>>) -> (Vec<u8>, Vec<String>) {
    let problem = Problem::parse(text, "beam.toml", PathBuf::new()).unwrap();
    let said = Said::default();
    let options = BuildOptions {
        store: None,
        repair: false,
        long: false,
        memory: None,
        engine,
        precision: Default::default(),
    };
    let (Outcome::Kept(built) | Outcome::Missed(built)) = build(&problem, &options, &said).unwrap();
    (built.bytes, said.0.into_inner().unwrap())
}

#[test]
fn a_file_that_is_exact_in_time_is_built_from_products_and_solves() {
    let alone: Arc<dyn Engine> = Arc::new(Alone::default());
    let live = "[[parameter]]\nname = \"E\"\nkind = \"stiffness\"\nrange = [0.5, 2.0]\n";
    for text in [format!("{BEAM}{HELD}"), BEAM.into(), format!("{BEAM}{HELD}{live}")] {
        let ((here, _), (there, said)) = (built(&text, None), built(&text, Some(&alone)));
        assert!(!said.iter().any(|note| note.contains("assembled")), "{said:#?}");
        assert_eq!(sections(&here), sections(&there), "the same numbers in another place give other bytes");
    }
}

/// The sections of a file, without the discretisation error: it needs the elements in this process.
fn sections(bytes: &[u8]) -> Vec<(SectionKind, Vec<u8>)> {
    let file = File::parse(bytes).unwrap();
    let all = file.sections().filter(|section| section.kind() != SectionKind::MeshError);
    all.map(|section| (section.kind(), section.stored().to_vec())).collect()
}

#[test]
fn what_needs_entries_assembles_them_here() {
    let alone: Arc<dyn Engine> = Arc::new(Alone::default());
    // One mode misses the tolerance for whole fields, so the file keeps the factor.
    let text = format!("{BEAM}{HELD}[output]\nfields = \"body\"\n").replace("modes = 6", "modes = 1");
    let text = text.replace(
        "[[output.probe]]\nname = \"tip\"\npoint = [1.0, 0.1, 0.1]\ndirection = [0.0, 0.0, 1.0]\n",
        "",
    );
    let (_, said) = built(&text, Some(&alone));
    assert!(said.iter().any(|note| note.contains("assembled them whole")), "{said:#?}");
}
