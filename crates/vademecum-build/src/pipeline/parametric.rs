//! Live regions by a parametric reduced-order model: one basis for the whole box, reduced matrices of each
//! region, and the exact step of the modes at any point of the box.

use std::time::Instant;

use faer::{Mat, MatRef};
use vademecum_format::SectionKind;

use super::exact::damping_section;
use super::file::{CertifiedFile, FileStep, encode_file};
use super::over_box::measured_over_box;
use super::patch::PatchPlan;
use super::reduced::ReducedModel;
use super::{BuildContext, BuildError, Built};
use crate::basis::{
    Basis, BasisError, ModePool, basis_of_pool, modes_of_sample, pool_memory, pool_modes, static_shapes,
};
use crate::certificate::{StructureMeasured, StructureReport};
use crate::dynamics::{fewest_rows, lowest_modes, time_in_words};
use crate::export::{Draft, RegionForms, live_sections};
use crate::fem::Solve;
use crate::input::Problem;
use crate::limits::memory_in_words;
use crate::linalg::{NoConvergence, symmetric_eigen, symmetric_part};
use crate::parallel;
use crate::prepared::{Design, LiveRegions, Prepared};
use crate::progress::{Quiet, Stopwatch};
use crate::report::{BuildPlan, CertificateReport};
use crate::residual::{ResidualError, ScaleTerm, residual_traces, scale_terms};
use crate::store::Inputs;

/// Sizes of the basis, smallest first.
const SIZES: [usize; 9] = [32, 48, 64, 96, 128, 192, 256, 384, 512];
/// Fresh points at which frequencies choose the first size that is tried.
const PROBED: usize = 8;
/// Frequencies that are compared there.
const FREQUENCIES: usize = 4;
/// Share of the tolerance that a basis should keep while it is small, and the size from which on the whole
/// tolerance will do: up to there the time to set it is short.
const EASY: f64 = 0.05;
/// See [`EASY`].
const LARGE: usize = 256;
/// Share of the tolerance that the errors at fresh points should keep: they are those of a few loads, and a
/// push at another place has several times their error (`docs/measurements/parameters.md`).
const MARGIN: f64 = 0.3;
/// Samples at which the residual flexibility is fitted, at most.
const RESIDUAL_SAMPLES: usize = 41;

/// Time of a search for the modes of a sample beside its factor, in that of as many solves as modes. Like
/// [`SEARCHES`] it was found on three bodies of 3 600 to 11 631 dofs, whose builds took 0.6 to 1.8 times the
/// estimate.
const SOLVES: f64 = 13.0;
/// Time that a build spends for each point, trained or fresh, in that of such a search.
const SEARCHES: f64 = 2.0;

/// A basis with all that a file has beside its modes.
struct Sized {
    model: ReducedModel,
    forms: RegionForms,
    scales: Vec<ScaleTerm>,
}

/// Builds the file: the smallest basis that keeps the tolerance at fresh points of the box.
pub(super) fn build(
    context: &BuildContext<'_>,
    problem: &Problem,
    mut plan: BuildPlan,
    watch: &mut Stopwatch<'_>,
) -> Result<Built, BuildError> {
    let BuildContext { prepared, kept, .. } = *context;
    let regions = &prepared.space.live_regions();
    let design = &Design::new(&prepared.space);
    let why = if problem.representation.is_some() { "as asked for" } else { "the default" };
    kept.listener.note(&format!(
        "live regions: a parametric reduced-order model ({why}) from natural modes at {} points of the box, {} a \
         point; `representation = \"separated\"` separates the time step instead",
        design.trained.len(),
        modes_of_sample(prepared, regions.factors)
    ));
    look_ahead(context, (design, regions.factors), &mut plan)?;
    let patch = &PatchPlan::new(context, problem)?;
    let pool = watch.stage("modes over the box", || pool_modes(prepared, design, regions.factors, kept))?;
    let first = first_size(context, problem, (&pool, design), regions, watch)?;
    let most = pool.singular_values.len();
    let mut sizes: Vec<usize> = match problem.basis.modes {
        Some(asked) if asked > most => {
            let path = problem.place("basis.modes");
            return Err(BasisError::TooManyPooled { path, asked, found: most }.into());
        }
        Some(asked) => vec![asked],
        None => SIZES.into_iter().filter(|&size| size >= first && size < most).chain([most]).collect(),
    };
    sizes.truncate(3);
    let last = sizes.len() - 1;
    for (place, &size) in sizes.iter().enumerate() {
        let mut sized = Sized::new(context, (problem, patch), (&pool, size), (regions, design), watch)?;
        context.estimate_mesh_error(None, watch)?;
        let is_taken = |error: f64| error <= MARGIN * problem.tolerance.error || place == last;
        let certified = certified(context, problem, (&mut sized, regions), (design, &is_taken), watch)?;
        let found = certified.certificate.diagonal.as_ref().map_or(f64::NAN, |found| found.trajectory_error);
        if is_taken(found) {
            let basis = (&sized.model.basis, pool.pooled);
            return Ok(certified.reported(context, problem, basis, plan, watch));
        }
        kept.listener
            .note(&format!("{size} vectors are off by more than {MARGIN} of the tolerance: more are tried"));
    }
    unreachable!("there is a last size")
}

/// Announces memory and time of the build, or refuses them.
fn look_ahead(
    context: &BuildContext<'_>,
    (design, factors): (&Design, usize),
    plan: &mut BuildPlan,
) -> Result<(), BuildError> {
    let BuildContext { prepared, options, kept, .. } = *context;
    let samples = design.trained.len();
    let pool = pool_memory(prepared, samples, factors);
    plan.memory_bytes = plan.memory_bytes.max(prepared.body.model.pencil().bytes() as f64 + pool);
    let instead = ": fewer live regions, a coarser mesh";
    options.memory().check(plan.memory_bytes, instead, || format!("natural modes at {samples} points"))?;
    let points = samples + design.fresh.len();
    plan.work.seconds = SEARCHES * points as f64 * seconds_per_sample(prepared, factors)?;
    plan.work.check(options.long, || format!("natural modes at {samples} points of the box"))?;
    let (time, memory) = (time_in_words(plan.work.seconds), memory_in_words(plan.memory_bytes as u64));
    kept.listener.note(&format!(
        "estimate: natural modes at {samples} points and a certificate at {} others, about {time}; {memory} of \
         memory at least",
        design.fresh.len()
    ));
    Ok(())
}

/// Wall time of the modes of a sample \[s\], from one factor of the stiffness and a block of solves; 0 of
/// ranks, which are not asked.
fn seconds_per_sample(prepared: &Prepared, factors: usize) -> Result<f64, BuildError> {
    let symbolic = &prepared.symbolic;
    if symbolic.is_spread() {
        return Ok(0.0);
    }
    let begin = Instant::now();
    let factor = symbolic.factorize(prepared.body.model.pencil().stiffness().clone())?;
    let factorized = begin.elapsed().as_secs_f64();
    let count = modes_of_sample(prepared, factors);
    let mut block = Mat::from_fn(symbolic.n(), count, |i, k| ((i + k) % 7) as f64);
    let mut solve = Solve::new(symbolic, count, false);
    let begin = Instant::now();
    solve.solve_in_place(&factor, block.as_mut());
    let solved = begin.elapsed().as_secs_f64();
    Ok(factorized + SOLVES * solved)
}

/// The size at which frequencies of fresh points are found well enough for the tolerance of trajectories.
fn first_size(
    context: &BuildContext<'_>,
    problem: &Problem,
    (pool, design): (&ModePool, &Design),
    regions: &LiveRegions,
    watch: &mut Stopwatch<'_>,
) -> Result<usize, BuildError> {
    if problem.basis.modes.is_some() {
        return Ok(0);
    }
    let prepared = context.prepared;
    let nominal = prepared.body.model.pencil();
    let count = FREQUENCIES.min(nominal.n_elastic());
    let most = pool.singular_values.len();
    watch.stage("size of the basis", || {
        let basis = basis_of_pool(prepared, pool, most, &Mat::zeros(prepared.body.n_dof(), 0))?;
        let forms = RegionForms::new(prepared, regions, basis.vectors.as_ref());
        // Leading vectors of the pool in the coordinates of the whole basis: `BᵀMV`.
        let mut image = Mat::zeros(prepared.body.n_dof(), most);
        nominal.mass().mul_into(pool.vectors.as_ref(), image.as_mut());
        let leading = basis.vectors.transpose() * image;
        let points: Vec<&Vec<f64>> =
            design.fresh.iter().step_by(design.fresh.len().div_ceil(PROBED)).collect();
        let exact = |at: usize| -> Result<Vec<f64>, BuildError> {
            let setting = prepared.space.setting(points[at]);
            Ok(lowest_modes(&setting.pencil(nominal), &prepared.symbolic, count)?.eigenvalues)
        };
        let exact = if prepared.symbolic.is_spread() {
            (0..points.len()).map(exact).collect::<Result<Vec<_>, _>>()?
        } else {
            parallel::try_map(points.len(), &exact)?
        };
        for size in SIZES.into_iter().filter(|&size| size < most) {
            let mut worst: f64 = 0.0;
            for (values, exact) in points.iter().zip(&exact) {
                let found = eigenvalues(prepared, (&forms, regions), leading.subcols(0, size), values)?;
                let errors = exact.iter().zip(&found).map(|(exact, found)| (found / exact - 1.0).abs());
                worst = errors.fold(worst, f64::max);
            }
            // Three periods of the first mode: a phase error of 3·2π·½ of that of its eigenvalue.
            let (error, tolerance) = (10.0 * worst, problem.tolerance.error);
            if error <= EASY * tolerance || (size >= LARGE && error <= tolerance) {
                return Ok(size);
            }
        }
        Ok(most)
    })
}

/// Lowest eigenvalues of leading vectors at values of the parameters.
fn eigenvalues(
    prepared: &Prepared,
    (forms, regions): (&RegionForms, &LiveRegions),
    leading: MatRef<'_, f64>,
    values: &[f64],
) -> Result<Vec<f64>, BuildError> {
    let setting = prepared.space.setting(values);
    let stiffness = forms.stiffness_at(&regions.scales(&setting.stiffness));
    let stiffness = leading.transpose() * stiffness * leading;
    let mass = leading.transpose() * forms.mass_at(&regions.scales(&setting.density)) * leading;
    let lower = mass.llt(faer::Side::Lower).map_err(|_| no_convergence())?;
    let mut half = stiffness;
    lower.L().solve_lower_triangular_in_place(half.as_mut());
    let mut turned = half.transpose().to_owned();
    lower.L().solve_lower_triangular_in_place(turned.as_mut());
    let symmetric = symmetric_part(turned.as_ref());
    let (found, _) = symmetric_eigen(symmetric.as_ref()).map_err(BasisError::from)?;
    let scale = setting.step.stiffness / setting.step.density;
    Ok(found.into_iter().map(|value| scale * value).collect())
}

fn no_convergence() -> BuildError {
    let what = "the reduced mass";
    BasisError::NoConvergence(NoConvergence { what }).into()
}

impl Sized {
    fn new(
        context: &BuildContext<'_>,
        (problem, patch): (&Problem, &Option<PatchPlan>),
        (pool, size): (&ModePool, usize),
        (regions, design): (&LiveRegions, &Design),
        watch: &mut Stopwatch<'_>,
    ) -> Result<Self, BuildError> {
        let prepared = context.prepared;
        let find = || {
            let mut basis = basis_of_pool(prepared, pool, size, &Mat::zeros(prepared.body.n_dof(), 0))?;
            if problem.basis.modes.is_none() {
                let nodes = &context.order.nodes[..context.order.n_load];
                let shapes = static_shapes(prepared, &basis, nodes)?;
                context.kept.listener.note(&format!(
                    "{size} vectors of the modes and {} static shapes of the loads that move the body least",
                    shapes.ncols()
                ));
                basis = basis_of_pool(prepared, pool, size, &shapes)?;
            }
            let forms = RegionForms::new(prepared, regions, basis.vectors.as_ref());
            Ok::<_, BuildError>((basis, forms))
        };
        let (basis, forms) = watch.stage("reduced matrices", find)?;
        let mut model = ReducedModel::of_basis(context, problem, (basis, pool.pooled), watch)?;
        model.patch.clone_from(patch);
        model.add_residual(context, problem, watch)?;
        let scales = if model.has_residual {
            let fit = || residual_scales(context, (&model.basis, &forms), (regions, design));
            watch.stage("residual flexibility over the box", fit)?
        } else {
            vec![]
        };
        Ok(Self { model, forms, scales })
    }
}

/// Terms by which the residual flexibility of each loadable node follows the parameters.
fn residual_scales(
    context: &BuildContext<'_>,
    (basis, forms): (&Basis, &RegionForms),
    (regions, design): (&LiveRegions, &Design),
) -> Result<Vec<ScaleTerm>, BuildError> {
    let BuildContext { prepared, order, kept, .. } = *context;
    if regions.count == 0 {
        return Ok(vec![]);
    }
    let nodes = &order.nodes[..order.n_load];
    let stride = design.trained.len().div_ceil(RESIDUAL_SAMPLES);
    let points: Vec<&Vec<f64>> = design.trained.iter().step_by(stride).collect();
    let inputs = |inputs: Inputs| inputs.value(&points).with(basis).indices(nodes);
    let terms: Vec<Vec<f64>> = kept.stage("residual-over-box", inputs, || -> Result<_, BuildError> {
        let mut samples = vec![];
        for (at, values) in points.iter().enumerate() {
            let setting = prepared.space.setting(values).regional();
            let pencil = setting.pencil(prepared.body.model.pencil());
            let mut scales = regions.scales(&setting.stiffness);
            // Mixtures with the mean of all live regions.
            scales.push(scales[1..].iter().sum::<f64>() / regions.count as f64);
            let reduced = forms.stiffness_at(&scales);
            let basis = (basis.vectors.as_ref(), reduced.as_ref());
            let quiet = Quiet(kept.listener);
            let Some(traces) = residual_traces(prepared, &pencil, basis, nodes, &quiet)? else {
                return Ok(vec![]);
            };
            samples.push((scales, traces));
            let stopped = |cancelled| BuildError::Residual(ResidualError::from(cancelled));
            kept.listener.checkpoint(at + 1, points.len()).map_err(stopped)?;
        }
        let terms = scale_terms(&prepared.body, nodes, (&regions.of_mesh, regions.count), &samples);
        Ok(terms.into_iter().map(|term| term.to_vec()).collect())
    })?;
    Ok(terms.into_iter().filter_map(|term| term.try_into().ok()).collect())
}

/// The file with what was measured of it at fresh points of the box; more of one that is taken for its error.
fn certified(
    context: &BuildContext<'_>,
    problem: &Problem,
    (sized, regions): (&mut Sized, &LiveRegions),
    (design, is_taken): (&Design, &dyn Fn(f64) -> bool),
    watch: &mut Stopwatch<'_>,
) -> Result<CertifiedFile, BuildError> {
    let Sized { model, forms, scales } = sized;
    let prepared = context.prepared;
    let basis = &model.basis;
    let live = live_sections((&prepared.space.parameters, &prepared.ratios), regions, forms, scales);
    let damping = damping_sections(context, problem, basis)?;
    let sections: Vec<&Draft> = model.sections.iter().chain(&live).chain(&damping).collect();
    let bytes = encode_file(context, problem, basis, FileStep::unmeasured(None), sections.iter().copied())?;
    let measure = || measured_over_box(context, (&bytes, basis), (design, is_taken));
    let (measured, of_points) = watch.stage("certificate over the box", measure)?;
    let step = FileStep::measured(None, &measured, &StructureMeasured::default());
    let sections = sections.into_iter().chain(&of_points);
    let bytes = watch.stage("encode", || encode_file(context, problem, basis, step, sections))?;
    let certificate = CertificateReport {
        diagonal: Some(StructureReport::measured(&measured)),
        parametric: true,
        ..CertificateReport::within(&problem.tolerance)
    };
    Ok(CertifiedFile { bytes, certificate, separation: None, large: None })
}

/// Damping of the modes beside Rayleigh's: ratios, and the rows of dashpots with their groups.
fn damping_sections(
    context: &BuildContext<'_>,
    problem: &Problem,
    basis: &Basis,
) -> Result<Vec<Draft>, BuildError> {
    let (pencil, r) = (context.prepared.body.model.pencil(), basis.n_modes());
    let (dampers, vectors) = (pencil.dampers(), basis.vectors.as_ref());
    let values = basis.eigenvalues.as_deref().unwrap_or(&[]);
    let ratios = context.prepared.modal_ratios(pencil, values, vectors);
    let mut drafts: Vec<Draft> = damping_section(&ratios, r).into_iter().collect();
    if dampers.is_empty() {
        return Ok(drafts);
    }
    let (mut numbers, mut groups) = (vec![], vec![]);
    for group in 0..=dampers.n_groups() {
        let rows = fewest_rows(dampers.of_group(group).along(vectors)).map_err(BasisError::from)?;
        numbers.extend((0..rows.nrows()).flat_map(|i| (0..r).map(move |k| (i, k))).map(|at| rows[at]));
        groups.resize(groups.len() + rows.nrows(), group as u32);
    }
    if groups.len() > r {
        let (path, rows) = (problem.place("dashpot"), groups.len());
        return Err(BuildError::DashpotsBeyond { path, rows, modes: r });
    }
    drafts.push(Draft::f64s(SectionKind::DampingRows, [groups.len(), r, 1], numbers));
    drafts.push(Draft::u32s(SectionKind::LiveDampers, [groups.len(), 1, 1], groups));
    Ok(drafts)
}
