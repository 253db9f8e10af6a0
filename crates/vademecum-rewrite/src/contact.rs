//! The rows of loadable nodes: how far rounding may turn what a force there does.

use vademecum_format::{File, SectionKind};

use super::error::RewriteError;
use super::numbers::decoded_of;

/// Compliance, beside the sum of all three directions, that is added to each: a direction in which no mode
/// moves is held to that.
const STIFFEST: f64 = 1e-6;

/// The inverse compliance of each loadable node, and the weights of its modes.
pub(super) struct NodeLimits {
    /// `C⁻¹` in the energy, and in the squares of the field: xx, xy, xz, yy, yz, zz; zeros where a component
    /// is held.
    of_node: Vec<[[f64; 6]; 2]>,
    /// `1/λ_k`.
    flexibility: Vec<f64>,
}

impl NodeLimits {
    /// From the rows of a basis and, where eigenvalues are known, the residual flexibility of the file.
    ///
    /// # Errors
    /// [`RewriteError`]: a section that cannot be decoded.
    pub(super) fn of(
        file: &File<'_>,
        basis: &[f64],
        eigenvalues: Option<&[f64]>,
    ) -> Result<Option<Self>, RewriteError> {
        let (nodes, r) = (file.metadata().n_load_nodes as usize, file.metadata().n_modes as usize);
        if nodes == 0 || r == 0 {
            return Ok(None);
        }
        let known = |kind| match eigenvalues {
            Some(_) => decoded_of(file, kind),
            None => Ok(None),
        };
        let residual = known(SectionKind::ContactResidual)?.unwrap_or_default();
        let gram = known(SectionKind::BoundMap)?.unwrap_or_default();
        let flexibility: Vec<f64> =
            eigenvalues.map_or(vec![1.0; r], |values| values.iter().map(|x| x.recip()).collect());
        let of_node = basis.chunks_exact(3 * r).take(nodes).enumerate().map(|(node, rows)| {
            let stored = |all: &[f64], width: usize| -> [f64; 6] {
                let own = all.get(width * node..width * node + 6).unwrap_or(&[0.0; 6]);
                std::array::from_fn(|i| own.get(i).copied().unwrap_or(0.0))
            };
            let mut sums = [stored(&residual, 6), stored(&gram, 7)];
            for (place, (a, b)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
                for (k, f) in flexibility.iter().enumerate() {
                    let product = rows[a * r + k] * rows[b * r + k];
                    sums[0][place] += product * f;
                    sums[1][place] += product * f * f;
                }
            }
            sums.map(|sum| inverse(&sum))
        });
        Ok(Some(Self { of_node: of_node.collect(), flexibility }))
    }

    /// The step of a number in the row of a loadable node; none of another node, or of a held component.
    pub(super) fn step(&self, node: usize, component: usize, mode: usize, tolerance: f64) -> Option<f64> {
        let diagonal = [0, 3, 5][component];
        let [energy, field] = self.of_node.get(node)?.map(|inverse| inverse[diagonal]);
        let f = self.flexibility[mode];
        let weight = (energy * f).max(field * f * f);
        (weight > 0.0).then(|| tolerance / (self.flexibility.len() as f64 * weight).sqrt())
    }

    /// The largest error of what a force at a loadable node does, relative to the whole of it:
    /// `2 (tr C⁻¹ Δ)^½` with `Δ = Σ_k δ_k δ_kᵀ / λ_k`, which no direction exceeds.
    pub(super) fn loss(&self, exact: &[f64], rounded: &[f64], row: usize, terms: &[f64]) -> f64 {
        let r = self.flexibility.len();
        let rows = exact.chunks_exact(row).zip(rounded.chunks_exact(row));
        let of_node = |(node, (exact, rounded)): (usize, (&[f64], &[f64]))| {
            let off = |term: usize, component: usize, mode: usize| {
                let c = (3 * term + component) * r + mode;
                terms[term] * (exact[c] - rounded[c])
            };
            let (inverses, mut sums) = (self.of_node[node], [0.0; 2]);
            for (mode, f) in self.flexibility.iter().enumerate() {
                for term in 0..terms.len() {
                    let d: [f64; 3] = std::array::from_fn(|component| off(term, component, mode));
                    if d == [0.0; 3] {
                        continue;
                    }
                    let [energy, field] = inverses.map(|[xx, xy, xz, yy, yz, zz]| {
                        let rest = 2.0 * (xy * d[0] * d[1] + xz * d[0] * d[2] + yz * d[1] * d[2]);
                        xx * d[0] * d[0] + yy * d[1] * d[1] + zz * d[2] * d[2] + rest
                    });
                    sums[0] += f * energy;
                    sums[1] += f * f * field;
                }
            }
            2.0 * sums[0].max(sums[1]).max(0.0).sqrt()
        };
        rows.take(self.of_node.len()).enumerate().map(of_node).fold(0.0, f64::max)
    }
}

/// The inverse of a symmetric 3 × 3 matrix (xx, xy, xz, yy, yz, zz) over the components that move, with
/// [`STIFFEST`] of its trace added to the diagonal; zeros for the others.
fn inverse(a: &[f64; 6]) -> [f64; 6] {
    let trace = a[0] + a[3] + a[5];
    let moves = [a[0] > 0.0, a[3] > 0.0, a[5] > 0.0];
    let held = |i: usize, j: usize| !(moves[i] && moves[j]);
    let given = [[a[0], a[1], a[2]], [a[1], a[3], a[4]], [a[2], a[4], a[5]]];
    let entry = |i: usize, j: usize| match (held(i, j), i == j) {
        (true, same) => f64::from(u8::from(same)),
        (false, true) => given[i][j] + STIFFEST * trace,
        (false, false) => given[i][j],
    };
    let minor = |i: usize, j: usize| {
        let at = |di: usize, dj: usize| entry((i + di) % 3, (j + dj) % 3);
        at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)
    };
    let determinant: f64 = (0..3).map(|j| entry(0, j) * minor(0, j)).sum();
    [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
        .map(|(i, j)| if held(i, j) { 0.0 } else { minor(i, j) / determinant })
}
