//! The reduced methods compared: bases, and on each basis the ways to step it.

use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

use vademecum_build::Matrix;
use vademecum_build::basis::Basis;
use vademecum_build::dynamics::TimedLoad;
use vademecum_build::input::BasisKind;
use vademecum_build::progress::Listener;
use vademecum_eval::{Scalar, SceneOptions, StructureChoice};
use vademecum_format::File;
use vademecum_rewrite as rewrite;
use vademecum_study::bench::{ReducedSolver, Study, Timed, staged};
use vademecum_study::compare::coordinate_matrix;

use super::canonical::{self, Played};
use super::errors::thinned;
use crate::cmd::rewrite_failed;
use crate::cmd::verify::{file_nodes, free_basis};
use crate::console::Console;
use crate::failure::Failure;
use crate::player::{Track, play_in};

/// Relative error of fields that the quantised file may bring, and the level it is packed with: what is shipped.
const QUANTISED: f64 = 1e-4;
const ZSTD_LEVEL: i32 = 19;

/// A basis and the methods on it.
pub struct Group {
    /// Kind of the basis.
    pub kind: BasisKind,
    /// The basis.
    pub basis: Basis,
    /// Wall time up to the basis \[s\], in the offline time of each of its methods.
    pub shared_seconds: f64,
    /// The methods; one that differs from another stands after it.
    pub methods: Vec<Method>,
}

/// One row of the table.
pub struct Method {
    /// Basis, structure, precision.
    pub name: &'static str,
    /// Wall time of everything it needs \[s\].
    pub offline_seconds: f64,
    /// How it steps.
    pub stepper: Stepper,
    /// Terms over the live parameters, where there are any.
    pub terms: Option<usize>,
    /// The method of the group it differs from in one thing.
    pub differs: Option<(Part, usize)>,
    /// Its file as it is shipped, where shipping rounds the basis.
    pub shipped: Option<Shipped>,
}

/// A packed file whose basis is rounded.
pub struct Shipped {
    /// Bytes of the packed file.
    pub file_bytes: usize,
    /// The basis it holds, over the free dofs, shape (n, r).
    pub basis: Matrix,
}

/// What a method differs in from another one of its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Responses summed from terms instead of solved.
    Separation,
    /// f32 instead of f64, or a basis of 16 bits.
    Rounding,
}

/// How a method steps.
pub enum Stepper {
    /// Without a file.
    Solver {
        /// The solver.
        solver: Box<dyn ReducedSolver>,
        /// Whether it has no time scheme, hence none of its error.
        exact_in_time: bool,
    },
    /// A file through the evaluator.
    File {
        /// The file.
        bytes: Rc<Vec<u8>>,
        /// Structure of the step.
        structure: StructureChoice,
        /// f32 instead of f64.
        single: bool,
    },
    /// A file of the chapter's maps through the evaluator, in f64.
    Canonical {
        /// The file.
        bytes: Vec<u8>,
        /// The loads of each march; the answer is the sum of the marches.
        tracks: Rc<Vec<Track>>,
    },
}

/// Which rows a comparison has beside those it always has.
#[derive(Clone, Debug)]
pub struct Extent {
    /// Numbers of modes, ascending.
    pub modes: Vec<usize>,
    /// Numbers of modes with a separated file.
    pub separated: Vec<usize>,
    /// Tolerances of the separated files.
    pub tolerances: Vec<f64>,
    /// Numbers of modes with files of the chapter's representation.
    pub canonical: Vec<usize>,
}

/// All groups, by modes.
pub fn groups(study: &Study, extent: &Extent, console: &Console) -> Result<Vec<Group>, Failure> {
    let mut groups = vec![];
    for &r in &extent.modes {
        console.stage(&format!("bases and files, {r} modes"));
        let tolerances = if extent.separated.contains(&r) { &extent.tolerances[..] } else { &[] };
        groups.push(pod(study, r)?);
        groups.push(ritz(study, r, tolerances, console)?);
        groups.push(natural(study, r)?);
    }
    Ok(groups)
}

fn pod(study: &Study, modes: usize) -> Result<Group, Failure> {
    let Timed { value: basis, seconds } = study.basis(BasisKind::Pod, modes)?;
    let shared = study.prepare_seconds() + study.snapshot_seconds() + seconds;
    let dense = study.galerkin(&basis)?;
    let mut methods =
        vec![solver("pod-galerkin, dense solves f64", shared + dense.seconds, dense.value, false)];
    let names = ["pod block two-stage f64", "pod block f64", "pod block f32"];
    block(study, &basis, shared, names, &mut methods)?;
    Ok(Group { kind: BasisKind::Pod, basis, shared_seconds: shared, methods })
}

fn ritz(study: &Study, modes: usize, tolerances: &[f64], console: &Console) -> Result<Group, Failure> {
    let Timed { value: basis, seconds } = study.basis(BasisKind::Ritz, modes)?;
    let shared = study.prepare_seconds() + study.snapshot_seconds() + seconds;
    let mut methods = vec![];
    diagonal(study, &basis, shared, ["ritz diagonal f64", "ritz diagonal f32"], &mut methods)?;
    methods.push(quantised(study, &methods)?);
    let names = ["ritz block two-stage f64", "ritz block f64", "ritz block f32"];
    block(study, &basis, shared, names, &mut methods)?;
    let exact = methods.len() - 2;
    for &tolerance in tolerances {
        console.stage(&format!("separated file, {modes} modes, tolerance {tolerance:e}"));
        let file = study.separated_file(&basis, tolerance, console)?;
        let (bytes, terms) = file.value;
        let bytes = Rc::new(bytes);
        let seconds = shared + file.seconds;
        for (name, single) in [("ritz separated f64", false), ("ritz separated f32", true)] {
            let differs =
                if single { (Part::Rounding, methods.len() - 1) } else { (Part::Separation, exact) };
            let method = through_file(name, seconds, &bytes, StructureChoice::Block, single);
            methods.push(Method { terms: Some(terms), differs: Some(differs), ..method });
        }
    }
    Ok(Group { kind: BasisKind::Ritz, basis, shared_seconds: shared, methods })
}

/// The diagonal file, the first method, packed with a basis of 16 bits.
fn quantised(study: &Study, methods: &[Method]) -> Result<Method, Failure> {
    let name = Path::new("the bench's quantised file");
    let start = Instant::now();
    let exact = methods[0].bytes().expect("the diagonal structure is a file");
    let rewritten = |error| rewrite_failed(name, error);
    let packed = rewrite::pack_within(exact, ZSTD_LEVEL, QUANTISED).map_err(rewritten)?;
    let seconds = methods[0].offline_seconds + start.elapsed().as_secs_f64();
    let bytes = Rc::new(rewrite::unpack(&packed, rewrite::DECODED_LIMIT).map_err(rewritten)?);
    let file = File::parse(&bytes).map_err(|error| Failure::file(name, error))?;
    let body = &study.prepared().body;
    let basis = free_basis(name, &file, body, &file_nodes(name, &file, body)?)?;
    Ok(Method {
        differs: Some((Part::Rounding, 0)),
        shipped: Some(Shipped { file_bytes: packed.len(), basis }),
        ..through_file("ritz quantised f64", seconds, &bytes, StructureChoice::Diagonal, false)
    })
}

fn natural(study: &Study, modes: usize) -> Result<Group, Failure> {
    let Timed { value: basis, seconds } = study.basis(BasisKind::Modes, modes)?;
    let shared = study.prepare_seconds() + seconds;
    let exact = study.exact(&basis)?;
    let mut methods = vec![solver("natural modes, exact f64", shared + exact.seconds, exact.value, true)];
    let names = ["natural modes, diagonal f64", "natural modes, diagonal f32"];
    diagonal(study, &basis, shared, names, &mut methods)?;
    let names =
        ["natural modes, block two-stage f64", "natural modes, block f64", "natural modes, block f32"];
    block(study, &basis, shared, names, &mut methods)?;
    Ok(Group { kind: BasisKind::Modes, basis, shared_seconds: shared, methods })
}

/// The diagonal structure in both precisions.
fn diagonal(
    study: &Study,
    basis: &Basis,
    shared: f64,
    names: [&'static str; 2],
    methods: &mut Vec<Method>,
) -> Result<(), Failure> {
    let file = study.file(basis, None)?;
    both_precisions(names, shared + file.seconds, &Rc::new(file.value), StructureChoice::Diagonal, methods);
    Ok(())
}

/// The block structure: stage by stage, and fused in both precisions.
fn block(
    study: &Study,
    basis: &Basis,
    shared: f64,
    [staged, double, single]: [&'static str; 3],
    methods: &mut Vec<Method>,
) -> Result<(), Failure> {
    let responses = study.responses(basis)?;
    let shared = shared + responses.seconds;
    let two_stage = study.two_stage(basis, &responses.value)?;
    let file = study.file(basis, Some(&responses.value))?;
    methods.push(solver(staged, shared + two_stage.seconds, two_stage.value, false));
    let bytes = Rc::new(file.value);
    both_precisions([double, single], shared + file.seconds, &bytes, StructureChoice::Block, methods);
    Ok(())
}

fn both_precisions(
    [double, single]: [&'static str; 2],
    seconds: f64,
    bytes: &Rc<Vec<u8>>,
    structure: StructureChoice,
    methods: &mut Vec<Method>,
) {
    let exact = methods.len();
    methods.push(through_file(double, seconds, bytes, structure, false));
    let rounded = through_file(single, seconds, bytes, structure, true);
    methods.push(Method { differs: Some((Part::Rounding, exact)), ..rounded });
}

fn solver(
    name: &'static str,
    offline_seconds: f64,
    solver: impl ReducedSolver + 'static,
    exact_in_time: bool,
) -> Method {
    let stepper = Stepper::Solver { solver: Box::new(solver), exact_in_time };
    Method { name, offline_seconds, stepper, terms: None, differs: None, shipped: None }
}

fn through_file(
    name: &'static str,
    offline_seconds: f64,
    bytes: &Rc<Vec<u8>>,
    structure: StructureChoice,
    single: bool,
) -> Method {
    let stepper = Stepper::File { bytes: Rc::clone(bytes), structure, single };
    Method { name, offline_seconds, stepper, terms: None, differs: None, shipped: None }
}

impl Group {
    /// The files of its methods.
    pub fn file(&self) -> impl Iterator<Item = &[u8]> {
        self.methods.iter().filter_map(Method::bytes)
    }
}

/// What a march of a method needs.
#[derive(Clone, Copy)]
pub struct March<'a> {
    /// What errors about a file in memory call it.
    pub name: &'a Path,
    /// The scenario, as files take it.
    pub track: &'a Track,
    /// The scenario, as solvers without a file take it.
    pub loads: &'a [TimedLoad],
    /// Δt \[s\], for files only: a solver has its own.
    pub time_step: f64,
    /// Steps.
    pub steps: usize,
    /// Every so many instants are kept.
    pub stride: usize,
}

impl Method {
    /// Its file, if it has one.
    pub fn bytes(&self) -> Option<&[u8]> {
        match &self.stepper {
            Stepper::Solver { .. } => None,
            Stepper::File { bytes, .. } => Some(bytes),
            Stepper::Canonical { bytes, .. } => Some(bytes),
        }
    }

    /// Bytes of the file as it is shipped.
    pub fn file_bytes(&self) -> Option<usize> {
        let shipped = self.shipped.as_ref().map(|shipped| shipped.file_bytes);
        shipped.or_else(|| self.bytes().map(<[u8]>::len))
    }

    /// Marches from rest whose sum is its answer.
    pub fn n_marches(&self) -> usize {
        match &self.stepper {
            Stepper::Canonical { tracks, .. } => tracks.len(),
            _ => 1,
        }
    }

    /// Whether no time scheme stands between it and the exact motion.
    pub fn exact_in_time(&self) -> bool {
        matches!(self.stepper, Stepper::Solver { exact_in_time: true, .. })
    }

    /// Its coordinates from rest at the instants kept, the start included; shape (r, instants). Or why it has none.
    pub fn play(&self, march: &March<'_>) -> Result<Played, Failure> {
        let all = self.play_all(march)?;
        Ok(if march.stride == 1 { all } else { all.map(|all| thinned(&all, march.stride)) })
    }

    fn play_all(&self, march: &March<'_>) -> Result<Played, Failure> {
        Ok(Ok(match &self.stepper {
            Stepper::Solver { solver, .. } => staged::play(solver.as_ref(), march.loads, march.steps),
            Stepper::File { bytes, structure, single: false } => play_file::<f64>(bytes, *structure, march)?,
            Stepper::File { bytes, structure, single: true } => play_file::<f32>(bytes, *structure, march)?,
            Stepper::Canonical { bytes, tracks } => return canonical::play(bytes, tracks, march),
        }))
    }
}

fn play_file<T: Scalar>(
    bytes: &[u8],
    structure: StructureChoice,
    march: &March<'_>,
) -> Result<Matrix, Failure> {
    let file = File::parse(bytes).map_err(|error| Failure::file(march.name, error))?;
    let options = SceneOptions { structure, time_step: Some(march.time_step), ..SceneOptions::default() };
    let mut coordinates = vec![];
    play_in::<T>(march.name, &file, &options, march.track, march.steps, |_, body| {
        coordinates.extend(body.zeta().iter().map(|z| z.to_f64()));
        Ok(())
    })?;
    Ok(coordinate_matrix(file.metadata().n_modes as usize, &coordinates))
}
