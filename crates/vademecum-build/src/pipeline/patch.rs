//! The residual flexibility between contacts that are near each other: announced before there is a basis,
//! made behind the residual flexibility.

use faer::Mat;

use super::{BuildContext, BuildError};
use crate::basis::Basis;
use crate::dynamics::{Modes, lowest_modes_kept};
use crate::export::{Draft, patch_sections};
use crate::input::{Precision, Problem};
use crate::limits::memory_in_words;
use crate::progress::{Listener, Stopwatch};
use crate::residual::{PatchFlexibility, Reaches, ResidualBasis, ResidualError, patch_flexibility};
use crate::store::Inputs;

/// Residual at which a further mode is one.
const CONVERGED: f64 = 1e-6;

/// Bytes of pairs and their blocks in a file at most.
const MAX_BYTES: usize = 256_000_000;

/// Sizes of a patch, known before anything is solved for.
#[derive(Clone)]
pub(super) struct PatchPlan {
    /// Distance from which on contacts have nothing between them \[m\].
    distance: f64,
    /// Further modes asked for.
    modes: usize,
    /// Pairs of loadable nodes.
    pairs: Vec<[u32; 2]>,
}

impl PatchPlan {
    /// Finds the pairs and announces the work, if the problem asks for a patch.
    ///
    /// # Errors
    /// [`BuildError::PatchSize`].
    pub(super) fn new(context: &BuildContext<'_>, problem: &Problem) -> Result<Option<Self>, BuildError> {
        let Some(distance) = problem.output.contact_patch else { return Ok(None) };
        let BuildContext { prepared, order, kept, .. } = *context;
        let (nodes, mesh) = (&order.nodes[..order.n_load], &prepared.body.model.mesh().nodes);
        let number =
            if problem.output.precision == Precision::F32 { size_of::<f32>() } else { size_of::<f64>() };
        let pair = 2 * size_of::<u32>() + 9 * number;
        let places: Vec<[f64; 3]> = nodes.iter().map(|&node| mesh[node as usize]).collect();
        let points = Reaches { places: &places, reach: &order.load_reach(mesh) };
        let most = MAX_BYTES / pair;
        let Some(pairs) = points.pairs(distance, most) else {
            let path = problem.place("output.contact_patch");
            let (limit, largest) = (MAX_BYTES as u64, points.largest_distance(most));
            return Err(BuildError::PatchSize { path, distance, limit, largest });
        };
        let modes = problem.contact_modes();
        let bytes = pair * pairs.len() + 3 * number * modes * nodes.len();
        let further = if modes > 0 { format!(", {modes} natural modes more") } else { String::new() };
        kept.listener.note(&format!(
            "contact patch of {distance} m: {} pairs of loadable nodes, {} static answers{further}; about {} in \
             the file",
            pairs.len(),
            3 * nodes.len(),
            memory_in_words(bytes as u64)
        ));
        Ok(Some(Self { distance, modes, pairs }))
    }

    /// The sections of the patch, beside the modes of a basis.
    ///
    /// # Errors
    /// [`BuildError::Residual`].
    pub(super) fn sections(
        &self,
        context: &BuildContext<'_>,
        problem: &Problem,
        (basis, reduced): (&Basis, &ResidualBasis<'_>),
        watch: &mut Stopwatch<'_>,
    ) -> Result<Vec<Draft>, BuildError> {
        let BuildContext { order, kept, .. } = *context;
        let nodes = &order.nodes[..order.n_load];
        let inputs = |inputs: Inputs| {
            let inputs = inputs.value(&self.modes).with(basis).indices(nodes);
            inputs.indices(self.pairs.as_flattened())
        };
        let make = || -> Result<PatchFlexibility, ResidualError> {
            let found = self.more_modes(context, basis.n_modes())?;
            patch_flexibility(reduced, found.as_ref(), nodes, &self.pairs, kept.listener)
        };
        let found = watch.stage("contact patch", || kept.stage("contact-patch", inputs, make))?;
        let precision = problem.output.precision;
        Ok(patch_sections(&found, &self.pairs, nodes.len(), self.distance, precision))
    }

    /// The modes of the basis and further ones, as many as the body has; none where no further ones are asked
    /// for.
    fn more_modes(&self, context: &BuildContext<'_>, r: usize) -> Result<Option<Modes>, ResidualError> {
        let BuildContext { prepared, kept, .. } = *context;
        let pencil = prepared.body.model.pencil();
        let asked = r + self.modes;
        let count = asked.min(pencil.n_elastic());
        if count <= r {
            note_fewer(0, self.modes, kept.listener);
            return Ok(None);
        }
        let solves = kept.solves(&prepared.symbolic.solver());
        let found = lowest_modes_kept(pencil, &prepared.symbolic, count, (&solves, None))?;
        solves.forget();
        // Where all modes of a body are asked for, the last ones may be none.
        let modes = converged(found);
        let count = modes.eigenvalues.len();
        note_fewer(count.saturating_sub(r), self.modes, kept.listener);
        Ok((count > r).then_some(modes))
    }
}

/// The modes of a list that have converged.
fn converged(modes: Modes) -> Modes {
    let Modes { eigenvalues, vectors, residuals } = modes;
    let kept: Vec<usize> = (0..residuals.len()).filter(|&k| residuals[k] <= CONVERGED).collect();
    Modes {
        eigenvalues: kept.iter().map(|&k| eigenvalues[k]).collect(),
        vectors: Mat::from_fn(vectors.nrows(), kept.len(), |i, k| vectors[(i, kept[k])]),
        residuals: kept.iter().map(|&k| residuals[k]).collect(),
    }
}

/// Notes fewer further modes than were asked for.
fn note_fewer(found: usize, asked: usize, listener: &dyn Listener) {
    if found < asked {
        listener.note(&format!(
            "no more natural modes are found to six digits: {found} further ones for contacts instead of {asked}"
        ));
    }
}
