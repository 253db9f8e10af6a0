//! The reduced methods compared: bases, and on each basis the ways to step it.

use std::rc::Rc;
use std::time::Instant;

use vademecum_build::basis::Basis;
use vademecum_build::input::BasisKind;
use vademecum_build::progress::Listener;
use vademecum_format::File;
use vademecum_rewrite::{DECODED_LIMIT, pack_within, unpack};
use vademecum_study::parts::{Study, Timed, file_nodes};
use vademecum_study::verify::free_basis;

use super::method::{Group, Method, Part, Shipped, Way};
use super::{DenseGalerkin, ExactModes, TwoStage};
use vademecum_study::StudyError;

/// Relative error of fields that the quantised file may bring, and the level it is packed with: what is
/// shipped.
const QUANTISED: f64 = 1e-4;
const ZSTD_LEVEL: i32 = 19;

/// Optional rows of a comparison.
#[derive(Clone, Debug)]
pub(super) struct Extent {
    /// Numbers of modes, ascending.
    pub modes: Vec<usize>,
    /// Tolerances of the separated files.
    pub tolerances: Vec<f64>,
}

impl Extent {
    /// Files with a live parameter take long to make: those with a few modes only.
    fn tolerances(&self, modes: usize) -> &[f64] {
        if (8..=16).contains(&modes) { &self.tolerances } else { &[] }
    }
}

/// All groups, by modes.
pub(super) fn groups(
    study: &Study,
    extent: &Extent,
    listener: &dyn Listener,
) -> Result<Vec<Group>, StudyError> {
    let mut groups = vec![];
    for &r in &extent.modes {
        listener.stage(&format!("bases and files, {r} modes"));
        groups.push(pod(study, r)?);
        groups.push(ritz(study, r, extent.tolerances(r), listener)?);
        groups.push(natural(study, r)?);
    }
    Ok(groups)
}

fn pod(study: &Study, modes: usize) -> Result<Group, StudyError> {
    let Timed { value: basis, seconds } = study.basis(BasisKind::Pod, modes)?;
    let shared = study.prepare_seconds() + study.snapshot_seconds() + seconds;
    let dense = DenseGalerkin::of_study(study, &basis);
    let mut methods = vec![Method::solver(Way::DenseSolves, shared + dense.seconds, dense.value)];
    block(study, &basis, shared, &mut methods)?;
    Ok(Group { kind: BasisKind::Pod, basis, shared_seconds: shared, methods })
}

fn ritz(
    study: &Study,
    modes: usize,
    tolerances: &[f64],
    listener: &dyn Listener,
) -> Result<Group, StudyError> {
    let Timed { value: basis, seconds } = study.basis(BasisKind::Ritz, modes)?;
    let shared = study.prepare_seconds() + study.snapshot_seconds() + seconds;
    let mut methods = vec![];
    diagonal(study, &basis, shared, &mut methods)?;
    methods.push(quantised(study, &methods)?);
    block(study, &basis, shared, &mut methods)?;
    let solved = methods.len() - 2;
    for &tolerance in tolerances {
        listener.stage(&format!("separated file, {modes} modes, tolerance {tolerance:e}"));
        let Timed { value: (bytes, terms), seconds } = study.separated_file(&basis, tolerance, listener)?;
        let bytes = Rc::new(bytes);
        let method = || Method {
            terms: Some(terms),
            differs: Some((Part::Separation, solved)),
            ..Method::file(Way::Separated, shared + seconds, &bytes)
        };
        let exact = methods.len();
        methods.extend([method(), method().rounded(exact)]);
    }
    Ok(Group { kind: BasisKind::Ritz, basis, shared_seconds: shared, methods })
}

/// The diagonal file, the first method, packed with a basis of 16 bits.
fn quantised(study: &Study, methods: &[Method]) -> Result<Method, StudyError> {
    let start = Instant::now();
    let exact = methods[0].bytes().expect("the diagonal structure is a file");
    let packed = pack_within(exact, ZSTD_LEVEL, QUANTISED)?;
    let seconds = methods[0].offline_seconds + start.elapsed().as_secs_f64();
    let bytes = Rc::new(unpack(&packed, DECODED_LIMIT)?);
    let file = File::parse(&bytes)?;
    let body = &study.prepared().body;
    let basis = free_basis(&file, body, &file_nodes(&file, body)?)?;
    Ok(Method {
        differs: Some((Part::Rounding, 0)),
        shipped: Some(Shipped { file_bytes: packed.len(), basis }),
        ..Method::file(Way::Quantised, seconds, &bytes)
    })
}

fn natural(study: &Study, modes: usize) -> Result<Group, StudyError> {
    let Timed { value: basis, seconds } = study.basis(BasisKind::Modes, modes)?;
    let shared = study.prepare_seconds() + seconds;
    let exact = ExactModes::of_study(study, &basis);
    let mut methods = vec![Method::solver(Way::ExactMotion, shared + exact.seconds, exact.value)];
    let steps = study.exact_file(&basis)?;
    both_precisions(Way::Exact, shared + steps.seconds, steps.value, &mut methods);
    diagonal(study, &basis, shared, &mut methods)?;
    block(study, &basis, shared, &mut methods)?;
    Ok(Group { kind: BasisKind::Modes, basis, shared_seconds: shared, methods })
}

/// The diagonal structure in both precisions.
fn diagonal(study: &Study, basis: &Basis, shared: f64, methods: &mut Vec<Method>) -> Result<(), StudyError> {
    let file = study.file(basis, None)?;
    both_precisions(Way::Diagonal, shared + file.seconds, file.value, methods);
    Ok(())
}

/// The block structure: stage by stage, and fused in both precisions.
fn block(study: &Study, basis: &Basis, shared: f64, methods: &mut Vec<Method>) -> Result<(), StudyError> {
    let responses = study.responses(basis)?;
    let shared = shared + responses.seconds;
    let two_stage = TwoStage::of_study(study, basis, &responses.value)?;
    let file = study.file(basis, Some(&responses.value))?;
    methods.push(Method::solver(Way::TwoStage, shared + two_stage.seconds, two_stage.value));
    both_precisions(Way::Block, shared + file.seconds, file.value, methods);
    Ok(())
}

fn both_precisions(way: Way, seconds: f64, bytes: Vec<u8>, methods: &mut Vec<Method>) {
    let (exact, bytes) = (methods.len(), Rc::new(bytes));
    methods.push(Method::file(way, seconds, &bytes));
    methods.push(Method::file(way, seconds, &bytes).rounded(exact));
}
