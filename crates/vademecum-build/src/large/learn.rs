//! From a body to the strain maps that could stand in a file.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::basis::with_followers;
use super::map::{Pairs, ReducedStrain, StrainGram};
use super::prior::{Prior, columns};
use super::regression::StrainColumns;
use super::shapes::kept_states;
use super::states::{TrainingStates, draw};
use crate::dynamics::large::LargeError;
use crate::dynamics::{Modes, ModesError, lowest_modes};
use crate::fem::{Factor, FactorError, GreenError, GreenStrain, Symbolic};
use crate::linalg::NoConvergence;
use crate::parallel;
use crate::prepared::Body;
use crate::store::StageCache;

/// Seed of the states.
const SEED: u64 = 0x1A26_E001;
/// Ridges of the regressions, in mean squares of the products, each begun where the one before ended. With a
/// large one the prior stays nearly what it is; a small one asks for many states.
const RIDGES: [f64; 3] = [1.0, 1e-2, 1e-4];

/// Shares of the coordinates that are natural modes, ascending: one in so many.
const SPLITS: [usize; 3] = [6, 4, 2];
/// Strain maps to choose from at most: for each share the two priors, and the regressions on one of them.
pub(crate) const CANDIDATES: usize = SPLITS.len() * (2 + RIDGES.len());
/// States that show which shapes follow the modes, for each coordinate.
const FOLLOWED: usize = 8;
/// Displacement of training states relative to the requested one: beyond it the map extrapolates.
const MARGIN: f64 = 1.3;

/// Options of a reduced strain.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct LargeOptions {
    /// Largest displacement of the loadable surface \[m\].
    pub(crate) displacement: f64,
    /// Coordinates; all of them interact.
    pub(crate) coordinates: usize,
    /// Strain rows in addition to one for each coordinate.
    pub(crate) rows: usize,
    /// States that the strains are fitted to, half of them at coordinates of the fewest modes of any map;
    /// fewer show which shapes follow the modes.
    pub(crate) states: usize,
}

impl LargeOptions {
    /// States of a basis of `r` coordinates, by default twice as many as there are products of coordinates.
    /// With fewer, a regression bends products that the states hardly tell apart.
    pub(crate) fn states_of(coordinates: usize) -> usize {
        coordinates * (coordinates + 1)
    }

    /// Natural modes of the bases that are tried, ascending.
    fn natural_modes(&self) -> [usize; SPLITS.len()] {
        SPLITS.map(|share| self.coordinates.div_ceil(share))
    }
}

/// Why no reduced strain was fitted.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// No strain.
    #[error(transparent)]
    Strain(#[from] GreenError),
    /// No modes.
    #[error("natural modes, for large displacements")]
    Modes(#[from] ModesError),
    /// The stiffness.
    #[error("a stiffness of large displacements does not factorise")]
    Factor(#[from] FactorError),
    /// Dense algebra.
    #[error("the strain map")]
    Dense(#[from] NoConvergence),
    /// Most states could not be found.
    #[error(
        "only {found} of {asked} shapes of least energy were found with displacements of up to {displacement} m: the \
         law of St. Venant and Kirchhoff lets elements collapse under strong compression; ask for less in \
         `large.displacement`"
    )]
    FewStates {
        /// Found.
        found: usize,
        /// Asked for.
        asked: usize,
        /// Largest displacement \[m\].
        displacement: f64,
    },
    /// A search that cannot begin, or was stopped.
    #[error("shapes of least energy")]
    Shapes(#[from] LargeError),
}

/// Natural modes and condensed shapes (static modal derivatives).
#[derive(Clone, Debug)]
#[doc(alias("followers", "static modal derivatives", "static condensation"))]
pub(crate) struct CondensedBasis {
    /// Shape (n, R); their mass is the identity, their eigenvalues ascend.
    pub(crate) vectors: Mat<f64>,
    /// Diagonal of their stiffness.
    pub(crate) eigenvalues: Vec<f64>,
    /// Natural frequencies of the coordinates that are natural modes \[rad/s\], 0 of the others.
    pub(crate) natural: Vec<f64>,
}

/// A basis and the reduced strain over it.
#[derive(Clone, Debug)]
#[doc(alias = "reduced-order model")]
pub(crate) struct LargeModel {
    /// In words.
    pub(crate) name: String,
    /// Natural modes of the basis; the other shapes follow them.
    pub(crate) modes: usize,
    prior: Prior,
    /// Kind of its coordinates.
    pub(crate) basis: CondensedBasis,
    /// The strain map.
    pub(crate) map: ReducedStrain,
    /// Coordinates of the states, one a column.
    pub(crate) states: Mat<f64>,
    /// Their energies \[J\].
    pub(crate) energies: Vec<f64>,
}

/// Input of the regression of a body's reduced strain.
pub(crate) struct StrainLearner<'a> {
    body: &'a Body,
    symbolic: &'a Symbolic,
    strain: GreenStrain<'a>,
    factor: Arc<Factor>,
    modes: Modes,
    options: LargeOptions,
    kept: &'a StageCache<'a>,
}

impl<'a> StrainLearner<'a> {
    /// Finds the natural modes.
    ///
    /// # Errors
    /// [`LearnError`].
    pub(crate) fn new(
        body: &'a Body,
        symbolic: &'a Symbolic,
        options: &LargeOptions,
        kept: &'a StageCache<'a>,
    ) -> Result<StrainLearner<'a>, LearnError> {
        let (strain, pencil) = (GreenStrain::new(&body.model)?, body.model.pencil());
        let options = LargeOptions { coordinates: options.coordinates.min(pencil.n_dof()), ..*options };
        let [.., most] = options.natural_modes();
        let modes = lowest_modes(pencil, symbolic, most)?;
        let factor = symbolic.factor_of(pencil.stiffness())?;
        Ok(StrainLearner { body, symbolic, strain, factor, modes, options, kept })
    }

    /// Strain maps before any regression: with a part of the coordinates natural modes and the others
    /// shapes that follow them, each with the two priors.
    ///
    /// # Errors
    /// [`LearnError`].
    pub(crate) fn priors(&self) -> Result<Vec<LargeModel>, LearnError> {
        let Self { body, options, .. } = self;
        let mut found = vec![];
        for n_modes in options.natural_modes() {
            let few = options.states.min(FOLLOWED * options.coordinates);
            let states = self.states(n_modes, few, options.displacement)?;
            let (modes, eigenvalues) = (self.modes(n_modes), &self.modes.eigenvalues[..n_modes]);
            let momenta = times_mass(body, modes);
            let own = (modes, momenta.as_ref(), eigenvalues);
            let shapes = options.coordinates - n_modes;
            let basis = sorted(with_followers(body.model.pencil(), own, &states, shapes)?, n_modes);
            let states = self.seen(&basis.vectors, &states);
            for prior in [Prior::Relaxed, Prior::Galerkin] {
                let gram = self.columns(&basis, prior).gram();
                found.push(self.learnt(String::new(), (n_modes, prior), &basis, &gram, &states)?);
            }
        }
        Ok(found)
    }

    /// Regressions on many states that begin at a strain map, over the same basis.
    ///
    /// # Errors
    /// [`LearnError`].
    pub(crate) fn fitted(&self, from: &LargeModel) -> Result<Vec<LargeModel>, LearnError> {
        let states = self.mixed(from.modes)?;
        let basis = &from.basis;
        let states = self.seen(&basis.vectors, &states);
        let grams = self.columns(basis, from.prior).fitted(&states, &RIDGES)?;
        let of = |at: usize| {
            let (ridge, gram) = (RIDGES[at], &grams[at]);
            let name = format!(", fitted with ridge {ridge}");
            self.learnt(name, (from.modes, from.prior), basis, gram, &states)
        };
        parallel::try_map(RIDGES.len(), &of)
    }

    /// The lowest modes.
    fn modes(&self, count: usize) -> MatRef<'_, f64> {
        self.modes.vectors.subcols(0, count)
    }

    /// The states of a regression: half of them at coordinates of some modes, half at coordinates of the
    /// fewest modes of any map, in which the further modes lie where the least energy has them.
    fn mixed(&self, n_modes: usize) -> Result<Vec<Vec<f64>>, LearnError> {
        let LargeOptions { states: count, displacement, .. } = self.options;
        let [fewest, ..] = self.options.natural_modes();
        let of_fewest = if n_modes > fewest { count / 2 } else { 0 };
        let mut states = self.states(fewest, of_fewest, MARGIN * displacement)?;
        states.extend(self.states(n_modes, count - of_fewest, MARGIN * displacement)?);
        Ok(states)
    }

    /// Shapes of least energy at coordinates of some modes, up to a displacement \[m\].
    fn states(&self, n_modes: usize, count: usize, displacement: f64) -> Result<Vec<Vec<f64>>, LearnError> {
        let (modes, eigenvalues) = (self.modes(n_modes), &self.modes.eigenvalues[..n_modes]);
        let drawn = draw(at_load_nodes(self.body, modes).as_ref(), eigenvalues, displacement, count, SEED);
        let (modes, factor) = ((modes, eigenvalues), (self.symbolic, &*self.factor));
        let states = kept_states(self.kept, &self.strain, modes, factor, drawn.as_ref())?;
        if 4 * states.len() < 3 * count {
            return Err(LearnError::FewStates { found: states.len(), asked: count, displacement });
        }
        Ok(states)
    }

    fn seen(&self, vectors: &Mat<f64>, states: &[Vec<f64>]) -> TrainingStates {
        TrainingStates::new(&self.strain, times_mass(self.body, vectors.as_ref()).as_ref(), states)
    }

    fn columns(&self, basis: &CondensedBasis, prior: Prior) -> StrainColumns {
        let CondensedBasis { vectors, eigenvalues, .. } = basis;
        let pairs = Pairs { interacting: eigenvalues.len() };
        columns(&self.strain, (vectors.as_ref(), eigenvalues), pairs, prior, (self.symbolic, &self.factor))
    }

    fn learnt(
        &self,
        fitted: String,
        (modes, prior): (usize, Prior),
        basis: &CondensedBasis,
        gram: &StrainGram,
        states: &TrainingStates,
    ) -> Result<LargeModel, LearnError> {
        let prior_name = match prior {
            Prior::Relaxed => "relaxed",
            Prior::Galerkin => "Galerkin",
        };
        let shapes = basis.eigenvalues.len() - modes;
        Ok(LargeModel {
            name: format!("{modes} modes, {shapes} shapes that follow, {prior_name}{fitted}"),
            modes,
            prior,
            basis: basis.clone(),
            map: gram.rows(states.coordinates.as_ref(), self.options.rows)?,
            states: states.coordinates.clone(),
            energies: states.energies.clone(),
        })
    }
}

fn times_mass(body: &Body, x: MatRef<'_, f64>) -> Mat<f64> {
    let mut image = Mat::zeros(x.nrows(), x.ncols());
    body.model.pencil().mass().mul_into(x, image.as_mut());
    image
}

/// Rows of the loadable nodes, three for each; zero where a dof is held.
pub(super) fn at_load_nodes(body: &Body, vectors: MatRef<'_, f64>) -> Mat<f64> {
    let mut place = vec![None; body.model.dofs().n_dof()];
    for (free, &dof) in body.model.dofs().dof_of_free().iter().enumerate() {
        place[dof as usize] = Some(free);
    }
    let nodes = &body.load_nodes;
    Mat::from_fn(3 * nodes.len(), vectors.ncols(), |i, k| {
        place[3 * nodes[i / 3] as usize + i % 3].map_or(0.0, |free: usize| vectors[(free, k)])
    })
}

/// A basis whose first vectors are natural modes, with ascending eigenvalues.
fn sorted((vectors, values): (Mat<f64>, Vec<f64>), n_modes: usize) -> CondensedBasis {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let natural = |&k: &usize| if k < n_modes { values[k].sqrt() } else { 0.0 };
    CondensedBasis {
        vectors: Mat::from_fn(vectors.nrows(), order.len(), |i, k| vectors[(i, order[k])]),
        eigenvalues: order.iter().map(|&k| values[k]).collect(),
        natural: order.iter().map(natural).collect(),
    }
}
