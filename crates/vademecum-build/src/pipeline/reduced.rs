//! The basis, and the sections of a file that depend on it and on no step.

use super::patch::PatchPlan;
use super::plan::{in_words, wants_residual};
use super::{BuildContext, BuildError};
use crate::basis::{Basis, BasisError, find_basis};
use crate::dynamics::uncouple;
use crate::export::{
    Draft, factor_sections, port_sections, reaction_sections, residual_sections, stress_order,
    stress_sections,
};
use crate::fem::{COMPONENTS, StressRows};
use crate::input::{BasisKind, Precision, Problem, STRESS_UNASKED};
use crate::limits::memory_in_words;
use crate::prepared::{Body, Prepared};
use crate::progress::Stopwatch;
use crate::reaction::reactions;
use crate::report::BuildPlan;
use crate::residual::{
    BlockMethod, ResidualBasis, ResidualFlexibility, port_flexibility, residual_flexibility, stress_residual,
};
use crate::store::Inputs;

/// The body on a basis.
pub struct ReducedModel {
    /// The basis.
    pub basis: Basis,
    /// Snapshots that it was found from.
    pub snapshots: usize,
    /// Residual flexibility, stress, reactions, and the factor of the stiffness where it is asked for.
    pub sections: Vec<Draft>,
    /// Residual flexibility between near contacts, where it is asked for.
    pub(super) patch: Option<PatchPlan>,
    /// True if the residual flexibility is among them.
    pub(crate) has_residual: bool,
    /// True if the factor is among them.
    pub(crate) has_factor: bool,
}

impl ReducedModel {
    /// Finds the basis and all that depends on it alone, without the residual flexibility.
    ///
    /// # Errors
    /// [`BuildError`], by stage.
    pub fn new(
        context: &BuildContext<'_>,
        problem: &Problem,
        plan: &BuildPlan,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Self, BuildError> {
        let BuildContext { prepared, full, runs, kept, .. } = *context;
        kept.listener.note(&format!("estimate: {}", in_words(plan)));
        let patch = PatchPlan::new(context, problem)?;
        let find = || find_basis(problem, prepared, full, runs, kept);
        let found = watch.stage("snapshots and basis", find)?;
        Ok(Self { patch, ..Self::of_basis(context, problem, found, watch)? })
    }

    /// The same of a basis that was found, with the number of snapshots behind it, without a contact patch.
    ///
    /// # Errors
    /// [`BuildError`], by stage.
    pub(super) fn of_basis(
        context: &BuildContext<'_>,
        problem: &Problem,
        (mut basis, snapshots): (Basis, usize),
        watch: &mut Stopwatch<'_>,
    ) -> Result<Self, BuildError> {
        let BuildContext { prepared, .. } = *context;
        let dampers = prepared.body.model.pencil().dampers();
        // Matrices of live regions are over the vectors as they are.
        let turned = !dampers.is_empty() && !prepared.is_parametric(problem);
        if let Some(eigenvalues) = basis.eigenvalues.as_deref().filter(|_| turned) {
            uncouple(|modes| dampers.along(modes), eigenvalues, &mut basis.vectors)
                .map_err(BasisError::from)?;
        }
        let loadable = wants_residual(problem, prepared) && context.order.n_load > 0;
        let has_residual = loadable && basis.eigenvalues.is_some();
        let stress = stress(context, problem, &basis, has_residual, watch)?;
        let reactions = support_reactions(context, problem, &basis, watch)?;
        let ports = ports(context, problem, &basis, watch)?;
        // Without loadable nodes there is no residual, and nothing for the factor to add to.
        let has_factor = problem.output.static_fields == Some(true) && has_residual;
        let factor = if has_factor { factor(context, problem, watch)? } else { vec![] };
        let sections = stress.into_iter().chain(reactions).chain(ports).chain(factor).collect();
        Ok(Self { basis, snapshots, sections, patch: None, has_residual, has_factor })
    }

    /// Adds the residual flexibility, and that between near contacts, where the file has it. It may use the
    /// factor of the stiffness up, so whatever solves with that comes before.
    ///
    /// # Errors
    /// [`BuildError::Residual`].
    pub fn add_residual(
        &mut self,
        context: &BuildContext<'_>,
        problem: &Problem,
        watch: &mut Stopwatch<'_>,
    ) -> Result<(), BuildError> {
        let Some(eigenvalues) = self.basis.eigenvalues.as_ref().filter(|_| self.has_residual) else {
            return Ok(());
        };
        let residual = residual(context, problem, (&self.basis, eigenvalues), watch)?;
        self.sections.splice(..0, residual_sections(&residual, problem.output.precision));
        if let Some(patch) = &self.patch {
            let reduced = reduced(context, &self.basis, eigenvalues, problem);
            self.sections.extend(patch.sections(context, problem, (&self.basis, &reduced), watch)?);
        }
        Ok(())
    }
}

/// The residual flexibility of the basis.
fn residual(
    context: &BuildContext<'_>,
    problem: &Problem,
    (basis, eigenvalues): (&Basis, &[f64]),
    watch: &mut Stopwatch<'_>,
) -> Result<ResidualFlexibility, BuildError> {
    let BuildContext { prepared, order, kept, .. } = *context;
    let body = &prepared.body;
    let reduced = reduced(context, basis, eigenvalues, problem);
    let nodes = &order.nodes[..order.n_load];
    let pairs = order.load_pairs();
    let way = BlockMethod::cheaper(body, &prepared.symbolic, eigenvalues.len(), nodes.len());
    let inputs = |inputs: Inputs| {
        let probes: Vec<_> = body.probes.iter().map(|probe| &probe.nodes).collect();
        let inputs = inputs.value(&(reduced.rigorous, way, probes)).with(basis).indices(nodes);
        let inputs = inputs.indices(pairs.as_flattened());
        body.patterns.iter().fold(inputs, |inputs, (_, force)| inputs.numbers(force))
    };
    let solve = || residual_flexibility(&reduced, way, nodes, &pairs, kept.listener);
    Ok(watch.stage("residual flexibility", || kept.stage("residual", inputs, solve))?)
}

/// Sections of the stress, with what the modes leave out of it if the file has a `residual`.
fn stress(
    context: &BuildContext<'_>,
    problem: &Problem,
    basis: &Basis,
    residual: bool,
    watch: &mut Stopwatch<'_>,
) -> Result<Vec<Draft>, BuildError> {
    let BuildContext { prepared, order, kept, .. } = *context;
    let Body { model, stress, .. } = &prepared.body;
    if stress.is_empty() {
        return Ok(vec![]);
    }
    let (output, nodes) = (&problem.output, &order.nodes[..order.n_load]);
    let points = stress_order(stress, order);
    let bytes = (size_of::<f64>() * 3 * COMPONENTS * points.len() * nodes.len()) as u64;
    let contacts = residual && output.stress_residual.unwrap_or(bytes <= STRESS_UNASKED);
    if residual && !contacts && output.stress_residual.is_none() {
        let size = memory_in_words(bytes);
        kept.listener.note(&format!(
            "stress at {} points shows the modes alone under contacts: with all of it the file would hold {size} \
             more; `output.stress_residual = true` keeps it, and so do fewer nodes in `output.stress`",
            points.len()
        ));
    }
    let vectors = basis.vectors.as_ref();
    let make = || {
        let rows = StressRows::new(model, points)?;
        let eigenvalues = basis.eigenvalues.as_deref().unwrap_or(&[]);
        let reduced = reduced(context, basis, eigenvalues, problem);
        let solve = || stress_residual(&reduced, &rows, nodes, contacts, kept.listener);
        let inputs = |inputs: Inputs| {
            let inputs = inputs.value(&(contacts, &rows.points)).with(basis).indices(nodes);
            prepared.body.patterns.iter().fold(inputs, |inputs, (_, force)| inputs.numbers(force))
        };
        let mut found = if residual { Some(kept.stage("stress", inputs, solve)?) } else { None };
        if let Some(found) = &mut found {
            found.less(&prepared.body.thermal_stress(&rows.points));
        }
        let body = (order, model.dofs(), model.materials());
        Ok(stress_sections(&rows, found.as_ref(), vectors, body, output.precision))
    };
    watch.stage("stress", make)
}

/// The basis beside the body.
fn reduced<'b>(
    context: &BuildContext<'b>,
    basis: &'b Basis,
    eigenvalues: &'b [f64],
    problem: &Problem,
) -> ResidualBasis<'b> {
    let prepared = context.prepared;
    let Prepared { body, symbolic, exact, .. } = prepared;
    // A scheme without stages is exact in time. Dashpots push modes that the basis leaves out.
    let alone = body.model.pencil().dampers().is_empty();
    let natural = problem.basis_kind() == BasisKind::Modes && !prepared.is_parametric(problem);
    let rigorous = natural && *exact && alone;
    ResidualBasis {
        body,
        pencil: body.model.pencil(),
        symbolic,
        vectors: basis.vectors.as_ref(),
        eigenvalues,
        rigorous,
    }
}

/// The reactions of the supports as the file keeps them, where they are asked for.
fn support_reactions(
    context: &BuildContext<'_>,
    problem: &Problem,
    basis: &Basis,
    watch: &mut Stopwatch<'_>,
) -> Result<Vec<Draft>, BuildError> {
    let BuildContext { prepared, order, .. } = *context;
    let Prepared { body, symbolic, .. } = prepared;
    if !problem.output.reactions {
        return Ok(vec![]);
    }
    let nodes = &order.nodes[..order.n_load];
    let live = prepared.is_parametric(problem).then(|| prepared.space.live_regions());
    let find = || reactions(body, symbolic, basis.vectors.as_ref(), nodes, live.as_ref());
    let found = watch.stage("reactions", find).map_err(BuildError::Reactions)?;
    let density = live.is_some_and(|live| live.density);
    Ok(reaction_sections(&body.supports, &found, density))
}

/// Sections of the ports.
fn ports(
    context: &BuildContext<'_>,
    problem: &Problem,
    basis: &Basis,
    watch: &mut Stopwatch<'_>,
) -> Result<Vec<Draft>, BuildError> {
    let BuildContext { prepared, order, kept, .. } = *context;
    let body = &prepared.body;
    let Some(eigenvalues) = basis.eigenvalues.as_ref().filter(|_| !body.ports.is_empty()) else {
        return Ok(vec![]);
    };
    let reduced = reduced(context, basis, eigenvalues, problem);
    let nodes = &order.nodes[..order.n_surface];
    let inputs = |inputs: Inputs| {
        let rows = body.ports.iter().map(|port| &port.rows);
        let probes = body.probes.iter().map(|probe| &probe.nodes);
        let inputs = inputs.value(&(rows.collect::<Vec<_>>(), probes.collect::<Vec<_>>())).with(basis);
        body.patterns.iter().fold(inputs.indices(nodes), |inputs, (_, force)| inputs.numbers(force))
    };
    let solve = || port_flexibility(&reduced, nodes, kept.listener);
    let found = watch.stage("ports", || kept.stage("ports", inputs, solve))?;
    Ok(port_sections(body, order, basis.vectors.as_ref(), &found, problem.output.precision))
}

/// Bytes of the factor in a file, without its indices.
pub(super) fn factor_bytes(context: &BuildContext<'_>, problem: &Problem) -> usize {
    let bytes = context.prepared.symbolic.factor_bytes();
    if problem.output.precision == Precision::F32 { bytes / 2 } else { bytes }
}

/// The factor of the stiffness as the file keeps it.
pub(super) fn factor(
    context: &BuildContext<'_>,
    problem: &Problem,
    watch: &mut Stopwatch<'_>,
) -> Result<Vec<Draft>, BuildError> {
    let BuildContext { prepared, order, kept, .. } = *context;
    let bytes = memory_in_words(factor_bytes(context, problem) as u64);
    kept.listener.note(&format!(
        "the file keeps the factor of the stiffness, about {bytes}: whole fields show the whole static answer"
    ));
    let precision = problem.output.precision;
    let sections = || factor_sections(&prepared.body, &prepared.symbolic, order, precision);
    Ok(watch.stage("factor for whole fields", sections)?)
}
