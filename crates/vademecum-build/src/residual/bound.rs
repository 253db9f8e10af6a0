//! Truncation bound of the static response: at a node over every direction, and over the surface.

use super::small::{Symmetric, eigen, form, full};

/// Share of a diagonal entry below which a pivot is rounding.
const LOST: f64 = 1e-14;

/// The axes, the diagonals of the faces of a cube and those of the cube; a bound is the same for a force and
/// its opposite.
const DIRECTIONS: [[f64; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// `‖R F‖_M / ‖K⁻¹F‖_M` over loadable nodes and directions of the force.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct StaticBound {
    /// True if it bounds the error at every instant, or estimates it.
    pub(crate) rigorous: bool,
    /// Largest over nodes and all directions.
    pub(crate) worst: f64,
    /// Median over nodes and 13 directions.
    pub(crate) median: f64,
    /// 95th percentile of the same.
    pub(crate) most: f64,
}

impl StaticBound {
    /// From `RᵀMR` and `K⁻¹MK⁻¹` of each node, and the largest relative bound there.
    pub(super) fn new(rigorous: bool, gram: &[Symmetric], answer: &[Symmetric], at_nodes: &[f64]) -> Self {
        let worst = at_nodes.iter().copied().fold(0.0, f64::max);
        let mut all: Vec<f64> = gram
            .iter()
            .zip(answer)
            .zip(at_nodes)
            .flat_map(|((gram, answer), &most)| {
                let along = move |d| relative(gram, answer, d).map(|bound| bound.min(most));
                DIRECTIONS.into_iter().filter_map(along)
            })
            .collect();
        all.sort_by(f64::total_cmp);
        let quantile = |share: f64| {
            let rank = (share * all.len() as f64).ceil().max(1.0) as usize;
            all.get(rank - 1).copied().unwrap_or(0.0)
        };
        Self { rigorous, worst, median: quantile(0.5), most: quantile(0.95) }
    }
}

/// The relative bound along a direction without its held components; `None` if nothing is left of it.
fn relative(gram: &Symmetric, answer: &Symmetric, direction: [f64; 3]) -> Option<f64> {
    let diagonal = [answer[0], answer[3], answer[5]];
    let free: [f64; 3] = std::array::from_fn(|c| if diagonal[c] > 0.0 { direction[c] } else { 0.0 });
    let whole = form(answer, free);
    (whole > 0.0).then(|| (form(gram, free).max(0.0) / whole).sqrt())
}

/// The root of the largest eigenvalue of `G x = μ S x`, held components left out: the largest relative bound
/// over all directions.
pub(super) fn relative_bound(gram: &Symmetric, answer: &Symmetric) -> f64 {
    let (gram, answer) = (full(gram), full(answer));
    // S = D L Lᵀ D with D the roots of its diagonal, row by row; a direction without an answer is left out.
    let mut lower = [[0.0; 3]; 3];
    let root: [f64; 3] = std::array::from_fn(|c| answer[c][c].max(0.0).sqrt());
    let scaled = |a: &[[f64; 3]; 3], i: usize, j: usize| {
        if root[i] > 0.0 && root[j] > 0.0 { a[i][j] / (root[i] * root[j]) } else { 0.0 }
    };
    for i in 0..3 {
        for j in 0..=i {
            let rest = scaled(&answer, i, j) - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
            lower[i][j] = match i == j {
                true if rest > LOST => rest.sqrt(),
                true => 0.0,
                false if lower[j][j] > 0.0 => rest / lower[j][j],
                false => 0.0,
            };
        }
    }
    // L⁻¹ D⁻¹ G D⁻¹ L⁻ᵀ, first from the left, then from the right.
    let mut image = [[0.0; 3]; 3];
    for j in 0..3 {
        for i in 0..3 {
            let rest = scaled(&gram, i, j) - (0..i).map(|k| lower[i][k] * image[k][j]).sum::<f64>();
            image[i][j] = if lower[i][i] > 0.0 { rest / lower[i][i] } else { 0.0 };
        }
    }
    for row in &mut image {
        for j in 0..3 {
            let rest = row[j] - (0..j).map(|k| lower[j][k] * row[k]).sum::<f64>();
            row[j] = if lower[j][j] > 0.0 { rest / lower[j][j] } else { 0.0 };
        }
    }
    let half = |i: usize, j: usize| 0.5 * (image[i][j] + image[j][i]);
    let (values, _) = eigen(&[half(0, 0), half(0, 1), half(0, 2), half(1, 1), half(1, 2), half(2, 2)]);
    values.into_iter().fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_ratio_over_all_directions_is_found() {
        let gram = [0.3, 0.1, -0.05, 0.2, 0.02, 0.5];
        let answer = [2.0, 0.7, 0.1, 1.0, -0.2, 3.0];
        let worst = relative_bound(&gram, &answer);
        let mut largest: f64 = 0.0;
        for i in 0..400 {
            for j in 0..800 {
                let (t, p) = (f64::from(i) * std::f64::consts::PI / 400.0, f64::from(j) * 0.00785398);
                let d = [t.sin() * p.cos(), t.sin() * p.sin(), t.cos()];
                largest = largest.max(relative(&gram, &answer, d).expect("an answer"));
            }
        }
        // The grid misses the direction by at most half its step, and the ratio is stationary there.
        assert!(largest <= worst * (1.0 + 1e-14) && largest > worst * (1.0 - 1e-4), "{largest} {worst}");
    }

    #[test]
    fn held_components_do_not_count() {
        let gram = [0.09, 0.0, 0.0, 0.0, 0.0, 0.04];
        let answer = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        assert_eq!(relative_bound(&gram, &answer), 0.3);
        assert_eq!(relative(&gram, &answer, [0.0, 1.0, 0.0]), None);
        assert_eq!(relative(&gram, &answer, [0.0, 1.0, 1.0]), Some(0.2));
        assert_eq!(relative_bound(&[0.0; 6], &[0.0; 6]), 0.0);
    }
}
