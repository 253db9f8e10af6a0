//! Sections of the strain structure: a body whose strain is a quadratic map of its coordinates.

use faer::MatRef;
use vademecum_format::SectionKind as S;

use super::draft::Draft;
use crate::input::Precision;

/// A strain map `z(q)` as a file holds it, with the matrices as built: the energy is `½|z|²`.
///
/// Coordinates are those of the basis, in its order, and all of them interact. Rows are one for each
/// coordinate, and others without linear part:
///
/// ```text
/// z_k = Σ_j linear_kj q_j + Σ_pairs quadratic_k,ab q_a q_b
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct StrainMap<'a> {
    /// `n`: coordinates that interact.
    pub(crate) interacting: usize,
    /// `L` of the first `r` rows, `(r, r)` \[1/s\]; the other rows have no linear part.
    pub(crate) linear: MatRef<'a, f64>,
    /// `Q`, `(m, pairs)`: a column for each product of coordinates in the order of [`pair_list`]. The number
    /// is the factor of the product `q_a q_b`, so a product of two different coordinates has both halves of a
    /// symmetric matrix.
    ///
    /// [`pair_list`]: vademecum_format::StrainSizes::pair_list
    pub(crate) quadratic: MatRef<'a, f64>,
    /// Natural frequency of each coordinate that is a natural mode \[rad/s\], 0 of the others, `r` of them: a
    /// step fits the inertia of those to it.
    pub(crate) modes: &'a [f64],
    /// Sub-steps of a step for which the file is certified, at least 1.
    pub(crate) substeps: usize,
    /// Where the training was; without it nobody can say that a state leaves it.
    pub(crate) training: Option<TrainingBox<'a>>,
}

/// How far from rest the states of the training were.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrainingBox<'a> {
    /// `W`, `(any, r)`: a state is as far from rest as `|W q|`. `WᵀW` is the inverse of the mean of `q qᵀ`
    /// over the training: `W = Cᵀ` with its lower Cholesky factor `C`.
    pub(crate) distance: MatRef<'a, f64>,
    /// The largest `|W q|` of the training.
    pub(crate) largest_distance: f64,
    /// The largest energy of the training \[J\], kinetic and elastic.
    pub(crate) largest_energy: f64,
}

/// Sections 60 to 66. Lengths are those that [`StrainMap`] says; the format refuses others.
#[must_use]
pub(crate) fn strain_sections(map: &StrainMap<'_>, precision: Precision) -> Vec<Draft> {
    let sizes = [map.interacting, 0, map.quadratic.nrows(), map.substeps].map(|n| n as u32);
    let rows = |a: MatRef<'_, f64>| -> Vec<f64> {
        (0..a.nrows()).flat_map(|i| (0..a.ncols()).map(move |j| a[(i, j)])).collect()
    };
    let (linear, quadratic) = (map.linear, map.quadratic);
    let mut drafts = vec![
        Draft::u32s(S::StrainSizes, [4, 1, 1], sizes),
        Draft::f64s(S::StrainLinear, [linear.nrows(), linear.ncols(), 1], rows(linear)),
    ];
    let shape = [quadratic.nrows(), quadratic.ncols(), 1];
    drafts.push(Draft::fitting(S::StrainQuadratic, precision, shape, &rows(quadratic)));
    if map.modes.iter().any(|&omega| omega != 0.0) {
        drafts.push(Draft::f64s(S::StrainModes, [map.modes.len(), 1, 1], map.modes.iter().copied()));
    }
    if let Some(training) = &map.training {
        let w = training.distance;
        drafts.push(Draft::f64s(S::StrainBox, [w.nrows(), w.ncols(), 1], rows(w)));
        let limits = [training.largest_distance, training.largest_energy];
        drafts.push(Draft::f64s(S::StrainLimits, [2, 1, 1], limits));
    }
    drafts
}
