//! Rows of couplings between a reference point, which has six motions, and the nodes of a surface.

use faer::Mat;

use crate::linalg::symmetric_eigen;
use crate::linalg::vec3::sub;

/// A direction in which a cloud is thinner than this share of its size has no rotation of its own.
const FLAT: f64 = 1e-10;

/// Row `c` of `u = u_r + θ × d`: weights of the three displacements and three rotations of a reference point
/// in component `c` of a point at `d` from it.
pub fn rigid_row(d: [f64; 3], c: usize) -> [f64; 6] {
    let (next, last) = ((c + 1) % 3, (c + 2) % 3);
    let mut row = [0.0; 6];
    row[c] = 1.0;
    row[3 + next] = d[last];
    row[3 + last] = -d[next];
    row
}

/// Mean motion of a cloud of points and weights, at the place of a reference point: of each point the weights
/// of its three displacements in the three displacements and three rotations.
///
/// `θ = J⁻¹ Σ w r × u` about the centre of the cloud, `u_r = Σ w u + θ × (x_r − c)` with weights that sum to
/// one. A cloud on a line has no rotation about it.
pub fn mean_rows(reference: [f64; 3], cloud: &[([f64; 3], f64)]) -> Vec<[[f64; 3]; 6]> {
    let whole: f64 = cloud.iter().map(|(_, w)| w).sum();
    let centre: [f64; 3] = std::array::from_fn(|c| cloud.iter().map(|(at, w)| w / whole * at[c]).sum());
    let mut inertia = [[0.0; 3]; 3];
    for &(at, w) in cloud {
        let r = sub(at, centre);
        let square: f64 = r.iter().map(|x| x * x).sum();
        for i in 0..3 {
            for j in 0..3 {
                inertia[i][j] += w / whole * (if i == j { square } else { 0.0 } - r[i] * r[j]);
            }
        }
    }
    let (inverse, d) = (inverted(inertia), sub(reference, centre));
    let rows = |&(at, w): &([f64; 3], f64)| {
        let (r, w) = (sub(at, centre), w / whole);
        // (r × u)_a = Σ_c cross[a][c] u_c.
        let cross = [[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]];
        let rotation = |i: usize| -> [f64; 3] {
            std::array::from_fn(|c| w * (0..3).map(|a| inverse[i][a] * cross[a][c]).sum::<f64>())
        };
        let turn: [[f64; 3]; 3] = std::array::from_fn(rotation);
        std::array::from_fn(|k| match k {
            0..3 => {
                // (θ × d)_k = θ_next d_last − θ_last d_next.
                let (next, last) = ((k + 1) % 3, (k + 2) % 3);
                let of = |c: usize| turn[next][c] * d[last] - turn[last][c] * d[next];
                std::array::from_fn(|c| if c == k { w } else { 0.0 } + of(c))
            }
            _ => turn[k - 3],
        })
    };
    cloud.iter().map(rows).collect()
}

/// The inverse of a symmetric matrix in the directions in which it is not singular.
fn inverted(a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let matrix = Mat::from_fn(3, 3, |i, j| a[i][j]);
    let Ok((values, vectors)) = symmetric_eigen(matrix.as_ref()) else { return [[0.0; 3]; 3] };
    let largest = (0..3).map(|k| values[k]).fold(0.0, f64::max);
    let share = |k: usize| if values[k] > FLAT * largest { 1.0 / values[k] } else { 0.0 };
    std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..3).map(|k| vectors[(i, k)] * share(k) * vectors[(j, k)]).sum())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::vec3::cross;

    #[test]
    fn the_mean_of_a_rigid_motion_is_that_motion() {
        let (shift, turn, reference) = ([0.1, -0.2, 0.3], [0.7, 0.4, -0.5], [0.3, 2.0, -1.0]);
        let cloud = [[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [0.3, 1.0, 0.5], [0.1, 0.4, 2.0]];
        let cloud: Vec<_> = cloud.into_iter().zip([1.0, 2.0, 0.5, 3.0]).collect();
        let rows = mean_rows(reference, &cloud);
        let motion = |at: [f64; 3], c: usize| {
            let row = rigid_row(sub(at, reference), c);
            (0..3).map(|k| row[k] * shift[k] + row[3 + k] * turn[k]).sum::<f64>()
        };
        for (c, expected) in shift.into_iter().chain(turn).enumerate() {
            let of = |(row, &(at, _)): (&[[f64; 3]; 6], &([f64; 3], f64))| {
                (0..3).map(|k| row[c][k] * motion(at, k)).sum::<f64>()
            };
            let found: f64 = rows.iter().zip(&cloud).map(of).sum();
            assert!((found - expected).abs() < 1e-13, "{c}: {found} for {expected}");
        }
        let d = sub(cloud[1].0, reference);
        let turned = cross(turn, d);
        assert!((0..3).all(|c| (motion(cloud[1].0, c) - shift[c] - turned[c]).abs() < 1e-15));
    }
}
