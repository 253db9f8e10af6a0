//! A walk through space that seldom jumps: the Hilbert curve.
//!
//! Nodes in its order have their neighbours close by, so the rows of a mode change little from one to the
//! next (which is what compresses), and the three nodes of a contact lie in few pages. Coordinates are
//! rounded to a grid of 2¹⁶ cells; from there on all is integers, so the order is the same on every machine.
//!
//! The transform between a point and its place on the curve is that of J. Skilling, "Programming the Hilbert
//! curve" (2004).

const BITS: u32 = 16;

/// Place of each point on the curve through the points' bounding cube.
pub fn places(points: &[[f64; 3]]) -> Vec<u64> {
    let bound = |better: fn(f64, f64) -> f64, start: f64| -> [f64; 3] {
        points.iter().fold([start; 3], |b, p| std::array::from_fn(|i| better(b[i], p[i])))
    };
    let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
    let side = (0..3).map(|i| high[i] - low[i]).fold(f64::MIN_POSITIVE, f64::max);
    let cells = f64::from((1u32 << BITS) - 1);
    let cell = |p: &[f64; 3]| std::array::from_fn(|i| ((p[i] - low[i]) / side * cells) as u32);
    points.iter().map(|p| place(cell(p))).collect()
}

fn place(mut x: [u32; 3]) -> u64 {
    for bit in (1..BITS).rev() {
        let (mask, below) = (1 << bit, (1 << bit) - 1);
        for i in 0..3 {
            if x[i] & mask != 0 {
                x[0] ^= below;
            } else {
                let swap = (x[0] ^ x[i]) & below;
                x[0] ^= swap;
                x[i] ^= swap;
            }
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let flips = (1..BITS).filter(|&bit| x[2] & (1 << bit) != 0);
    let flip = flips.fold(0, |flip, bit| flip ^ ((1u32 << bit) - 1));
    let gray = x.map(|x| x ^ flip);
    (0..BITS).rev().flat_map(|bit| gray.map(|x| u64::from(x >> bit & 1))).fold(0, |key, bit| key << 1 | bit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_on_the_curve_are_neighbours_in_space() {
        // The 512 cells of an 8 × 8 × 8 cube at the origin of the grid: the curve fills it before it leaves
        // it.
        let cells = (0..512u32).map(|i| [i & 7, i >> 3 & 7, i >> 6]);
        let mut walk: Vec<(u64, [u32; 3])> = cells.map(|cell| (place(cell), cell)).collect();
        walk.sort_unstable();
        assert!(walk.iter().enumerate().all(|(i, (key, _))| *key == i as u64));
        for pair in walk.windows(2) {
            let steps: u32 = (0..3).map(|i| pair[0].1[i].abs_diff(pair[1].1[i])).sum();
            assert_eq!(steps, 1, "{pair:?}");
        }
    }

    #[test]
    fn flat_and_single_bodies_have_places_too() {
        assert_eq!(places(&[[1.0, 2.0, 3.0]]), [0]);
        assert_eq!(places(&[]), [0u64; 0]);
        let line = places(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        assert_eq!(line.len(), 3);
    }
}
