//! The residual flexibility outside of a parametric basis, over the box of its parameters.
//!
//! ```text
//! ρ_i(κ) = tr R_ii(κ) / tr R_ii(as built) ≈ Σ_j c_j / (s_j·κ)        c_j ≥ 0,  Σ c_j = 1
//! ```
//!
//! Each `s_j` is a unit weight: the region at the node, or a mixture of it with a neighbour, or with the mean
//! of all. The weights are fitted to the residual at samples by nonnegative least squares. The rule is
//! homogeneous of degree −1 and falls in every stiffness, as the true compliance does, and is exact where all
//! regions change alike. A file scales its blocks between nodes `i` and `j` by `√(ρ_i ρ_j)`, which keeps them
//! positive semidefinite.

use faer::Mat;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{MatRef, Par, Side};

use super::error::ResidualError;
use super::selected::free_rows;
use crate::fem::Pencil;
use crate::linalg::NoConvergence;
use crate::parallel;
use crate::prepared::{Body, Prepared};
use crate::progress::Listener;

/// Shares of a neighbour in a mixture.
const SHARES: [f64; 4] = [0.1, 0.3, 0.6, 1.0];
/// Neighbours of a region that mixtures are made with, at most.
const NEIGHBOURS: usize = 8;
/// Sweeps of the fit.
const SWEEPS: usize = 2000;

/// A term of the scale of a node: the node's place, two live regions, share of the second, weight. Region 0
/// is what is not live, and one past the last stands for the mean of all.
pub(crate) type ScaleTerm = [f64; 5];

/// Traces of the residual flexibility outside of a basis, at each node; none where entries of the inverse are
/// not at hand.
///
/// # Errors
/// [`ResidualError`]: a stiffness that does not factorise, a stop.
pub(crate) fn residual_traces(
    prepared: &Prepared,
    pencil: &Pencil,
    (vectors, reduced): (MatRef<'_, f64>, MatRef<'_, f64>),
    nodes: &[u32],
    listener: &dyn Listener,
) -> Result<Option<Vec<f64>>, ResidualError> {
    let (body, symbolic) = (&prepared.body, &prepared.symbolic);
    if !symbolic.has_entries() || body.model.mesh().elements.is_empty() {
        return Ok(None);
    }
    let lower = reduced.llt(Side::Lower).map_err(|_| NoConvergence { what: "the reduced stiffness" });
    let lower = lower.map_err(ResidualError::from)?;
    let factor = symbolic.take_factor_of(pencil.stiffness())?;
    let selected = factor.select(pencil.mass(), free_rows(body, nodes), listener)?;
    let dofs = body.model.dofs();
    let r = vectors.ncols();
    let trace = |place: usize| {
        let node = nodes[place] as usize;
        let mut rows = Mat::from_fn(r, 3, |k, c| dofs.value(3 * node + c, |free| vectors[(free, k)]));
        solve_lower_triangular_in_place(lower.L(), rows.as_mut(), Par::Seq);
        let whole = |c: usize| {
            let row = |i: usize| dofs.value(3 * node + c, |j| selected.inverse(i, j).unwrap_or(f64::NAN));
            dofs.value(3 * node + c, row)
        };
        let inside = |c: usize| rows.col(c).iter().map(|x| x * x).sum::<f64>();
        (0..3).map(|c| (whole(c) - inside(c)).max(0.0)).sum::<f64>()
    };
    Ok(Some(parallel::map(nodes.len(), &trace)))
}

/// Terms of the scale of every node from its traces at samples, the first of which is as built.
pub(crate) fn scale_terms(
    body: &Body,
    nodes: &[u32],
    (live_of, count): (&[u32], usize),
    samples: &[(Vec<f64>, Vec<f64>)],
) -> Vec<ScaleTerm> {
    let own = regions_of_nodes(body, live_of);
    let beside = neighbours(&own, count);
    let fit = |place: usize| {
        let node = nodes[place] as usize;
        let built = samples[0].1[place];
        if built <= 0.0 || !samples.iter().all(|sample| sample.1[place].is_finite()) {
            // Nothing is left out there, or nothing is known of it: as stiff as its region.
            let region = own[node].first().copied().unwrap_or(0);
            return vec![[place as f64, f64::from(region), f64::from(region), 0.0, 1.0]];
        }
        let candidates = candidates(&own[node], &beside, count);
        let ratios: Vec<f64> = samples.iter().map(|sample| sample.1[place] / built).collect();
        let rows: Vec<Vec<f64>> = samples
            .iter()
            .map(|(scales, _)| candidates.iter().map(|candidate| 1.0 / mixed(candidate, scales)).collect())
            .collect();
        let weights = nonnegative(&rows, &ratios);
        let sum: f64 = weights.iter().sum();
        let kept = candidates.iter().zip(&weights).filter(|(_, weight)| **weight > 1e-6 * sum);
        let term = |(&(first, second, share), weight): (&Candidate, &f64)| {
            [place as f64, f64::from(first), f64::from(second), share, weight / sum]
        };
        kept.map(term).collect()
    };
    parallel::map(nodes.len(), &fit).into_iter().flatten().collect()
}

/// Two live regions, and the share of the second.
type Candidate = (u32, u32, f64);

/// The stiffness of a mixture; `scales` are those of what is not live, of each live region, and their mean.
fn mixed(&(first, second, share): &Candidate, scales: &[f64]) -> f64 {
    (1.0 - share) * scales[first as usize] + share * scales[second as usize]
}

/// Live regions at each node of the mesh, ascending.
fn regions_of_nodes(body: &Body, live_of: &[u32]) -> Vec<Vec<u32>> {
    let mesh = body.model.mesh();
    let mut found = vec![vec![]; mesh.nodes.len()];
    for ((_, element), region) in mesh.each().zip(&mesh.element_region) {
        let live = live_of.get(*region as usize).copied().unwrap_or(0);
        for &node in element {
            let own: &mut Vec<u32> = &mut found[node as usize];
            if let Err(place) = own.binary_search(&live) {
                own.insert(place, live);
            }
        }
    }
    found
}

/// Regions that share nodes with each region.
fn neighbours(own: &[Vec<u32>], count: usize) -> Vec<Vec<u32>> {
    let mut shared = vec![vec![0_usize; count + 1]; count + 1];
    for regions in own.iter().filter(|regions| regions.len() > 1) {
        for &a in regions {
            for &b in regions.iter().filter(|&&b| b != a) {
                shared[a as usize][b as usize] += 1;
            }
        }
    }
    let most = |row: Vec<usize>| {
        let mut found: Vec<u32> = (0..row.len() as u32).filter(|&b| row[b as usize] > 0).collect();
        found.sort_by_key(|&b| (std::cmp::Reverse(row[b as usize]), b));
        found.truncate(NEIGHBOURS);
        found
    };
    shared.into_iter().map(most).collect()
}

fn candidates(own: &[u32], beside: &[Vec<u32>], count: usize) -> Vec<Candidate> {
    let mut found: Vec<Candidate> = own.iter().map(|&region| (region, region, 0.0)).collect();
    for &first in own {
        let mean = count as u32 + 1;
        for &second in beside[first as usize].iter().chain([&mean]) {
            found.extend(SHARES.iter().map(|&share| (first, second, share)));
        }
    }
    found
}

/// Nonnegative least squares of relative errors: `rows · c = wanted`, by descent along one coordinate after
/// the other.
fn nonnegative(rows: &[Vec<f64>], wanted: &[f64]) -> Vec<f64> {
    let n = rows[0].len();
    let scaled = |i: usize, j: usize| rows[i][j] / wanted[i].max(f64::MIN_POSITIVE);
    let mut gram = vec![vec![0.0; n]; n];
    let mut slope = vec![0.0; n];
    for i in 0..rows.len() {
        for a in 0..n {
            slope[a] += scaled(i, a);
            for b in 0..=a {
                gram[a][b] += scaled(i, a) * scaled(i, b);
            }
        }
    }
    for a in 0..n {
        for b in 0..a {
            gram[b][a] = gram[a][b];
        }
    }
    // The region of the node alone is the start.
    let mut c = vec![0.0; n];
    c[0] = 1.0;
    for _ in 0..SWEEPS {
        let mut moved: f64 = 0.0;
        for a in 0..n {
            let answer: f64 = gram[a].iter().zip(&c).map(|(g, c)| g * c).sum();
            let next = (c[a] + (slope[a] - answer) / gram[a][a]).max(0.0);
            moved = moved.max((next - c[a]).abs());
            c[a] = next;
        }
        if moved < 1e-8 {
            break;
        }
    }
    c
}

#[cfg(test)]
mod tests {
    use super::nonnegative;

    #[test]
    fn weights_that_made_the_data_are_found_and_none_is_negative() {
        let scales = |i: usize| [0.3 + 0.2 * i as f64, 3.0 / (1.0 + i as f64), 1.0];
        let rows: Vec<Vec<f64>> =
            (0..12).map(|i| scales(i).iter().map(|scale| 1.0 / scale).collect()).collect();
        let wanted: Vec<f64> = rows.iter().map(|row| 0.7 * row[0] + 0.3 * row[2]).collect();
        let found = nonnegative(&rows, &wanted);
        for (found, expected) in found.iter().zip([0.7, 0.0, 0.3]) {
            assert!((found - expected).abs() < 1e-4, "{found} beside {expected}");
        }
    }
}
