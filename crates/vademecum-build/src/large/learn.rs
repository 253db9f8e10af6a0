//! From a body to the strain maps that could stand in a file.

use faer::{Mat, MatRef};

use super::basis::with_followers;
use super::kept::kept_states;
use super::map::{Columns, Pairs, StrainMap};
use super::prior::{Prior, columns};
use super::states::{States, draw};
use crate::dynamics::large::LargeError;
use crate::dynamics::{Modes, ModesError, lowest_modes};
use crate::fem::{FactorError, GreenError, GreenStrain, Symbolic};
use crate::linalg::NoConvergence;
use crate::prepared::Body;
use crate::store::Kept;

/// Where the states are drawn.
const SEED: u64 = 0x1A26_E001;
/// Ridges of the regressions, in mean squares of the products, each begun where the one before ended. A large
/// one is gentle. With a small one products that the states hardly know are bent for the sake of others: a
/// slender body is lost with it, and a compact one gains.
const RIDGES: [f64; 3] = [100.0, 10.0, 1.0];

/// Shares of the coordinates that are natural modes: one in so many.
const SPLITS: [usize; 3] = [6, 4, 2];
/// Strain maps that [`learn`] gives: for each share the two priors and the regressions.
pub const CANDIDATES: usize = SPLITS.len() * (2 + RIDGES.len());

/// What is asked of a strain map.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LargeOptions {
    /// Largest displacement of the loadable surface \[m\].
    pub displacement: f64,
    /// Coordinates; all of them interact.
    pub coordinates: usize,
    /// Strain rows beside one for each coordinate.
    pub rows: usize,
    /// States to learn from.
    pub states: usize,
}

/// Why no strain map was learnt.
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

/// A basis and the strain map over it.
#[derive(Clone, Debug)]
pub struct Learnt {
    /// In words.
    pub name: String,
    /// The basis, shape (n, R), its mass the identity, eigenvalues ascending.
    pub vectors: Mat<f64>,
    /// Diagonal of its stiffness.
    pub eigenvalues: Vec<f64>,
    /// The strain map.
    pub map: StrainMap,
    /// Coordinates of the states, one a column.
    pub states: Mat<f64>,
    /// Their energies \[J\].
    pub energies: Vec<f64>,
}

/// Strain maps to choose from, [`CANDIDATES`] of them: with a part of the coordinates natural modes and the
/// others shapes that follow them, each as the priors have it and as regressions on states move the
/// condensed one.
///
/// # Errors
/// [`LearnError`].
pub fn learn(
    body: &Body,
    symbolic: &Symbolic,
    options: &LargeOptions,
    kept: &Kept<'_>,
) -> Result<Vec<Learnt>, LearnError> {
    let (strain, pencil) = (GreenStrain::new(&body.model)?, body.model.pencil());
    let r = options.coordinates.min(pencil.n_dof());
    let splits = SPLITS.map(|share| r.div_ceil(share));
    let most = splits[SPLITS.len() - 1];
    let Modes { vectors: modes, eigenvalues, .. } = lowest_modes(pencil, symbolic, most)?;
    let momenta = times_mass(body, modes.as_ref());
    let moving = at_load_nodes(body, modes.as_ref());
    let factor = symbolic.factor_of(pencil.stiffness())?;
    let mut found = vec![];
    for n_modes in splits {
        let part = |x: &'_ Mat<f64>| x.subcols(0, n_modes).to_owned();
        let (modes, momenta) = (part(&modes), part(&momenta));
        let own = (moving.subcols(0, n_modes), &eigenvalues[..n_modes]);
        let drawn = draw(own.0, own.1, options.displacement, options.states, SEED);
        let states = kept_states(kept, &strain, symbolic, modes.as_ref(), drawn.as_ref())?;
        if 4 * states.len() < 3 * options.states {
            let (asked, displacement) = (options.states, options.displacement);
            return Err(LearnError::FewStates { found: states.len(), asked, displacement });
        }
        let own = (modes.as_ref(), momenta.as_ref(), &eigenvalues[..n_modes]);
        let (vectors, values) = sorted(with_followers(pencil, own, &states, r - n_modes)?);
        let states = States::new(&strain, times_mass(body, vectors.as_ref()).as_ref(), &states);
        let pairs = Pairs { interacting: values.len(), coupled: 0 };
        for prior in [Prior::Condensed, Prior::Galerkin] {
            let basis = (vectors.as_ref(), values.as_slice());
            let mut columns = columns(&strain, basis, pairs, prior, (symbolic, &factor));
            let mut keep = |columns: &Columns, name: &str| {
                found.push(Learnt {
                    name: format!("{n_modes} modes, {} shapes that follow, {name}", values.len() - n_modes),
                    vectors: vectors.clone(),
                    eigenvalues: values.clone(),
                    map: columns.rows(states.coordinates.as_ref(), options.rows)?,
                    states: states.coordinates.clone(),
                    energies: states.energies.clone(),
                });
                Ok::<_, LearnError>(())
            };
            if prior == Prior::Galerkin {
                keep(&columns, "Galerkin")?;
                continue;
            }
            keep(&columns, "condensed")?;
            for ridge in RIDGES {
                columns.fit(&states, ridge)?;
                keep(&columns, &format!("condensed, fitted with ridge {ridge}"))?;
            }
        }
    }
    Ok(found)
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

/// The same basis with ascending eigenvalues.
fn sorted((vectors, values): (Mat<f64>, Vec<f64>)) -> (Mat<f64>, Vec<f64>) {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let vectors = Mat::from_fn(vectors.nrows(), order.len(), |i, k| vectors[(i, order[k])]);
    (vectors, order.iter().map(|&k| values[k]).collect())
}
