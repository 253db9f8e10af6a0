//! Pairs of points that are near each other.

use std::collections::HashMap;

/// Halvings of an interval in the search for a distance.
const HALVINGS: usize = 40;

/// Points, each with a reach of its own.
#[derive(Clone, Copy)]
pub(crate) struct Reaches<'a> {
    /// Their places \[m\].
    pub(crate) places: &'a [[f64; 3]],
    /// Reach of each \[m\].
    pub(crate) reach: &'a [f64],
}

impl Reaches<'_> {
    /// Pairs whose distance is at most `distance` and both reaches, the first at most the second, ascending,
    /// each point with itself among them; `None` of more than `most`.
    pub(crate) fn pairs(self, distance: f64, most: usize) -> Option<Vec<[u32; 2]>> {
        let mut pairs = vec![];
        self.visit(distance, |pair| {
            pairs.push(pair);
            pairs.len() <= most
        })
        .then(|| {
            pairs.sort_unstable();
            pairs
        })
    }

    /// The largest distance of at most `most` pairs, to its last digits; `None` where it is not even 0.
    pub(crate) fn largest_distance(self, most: usize) -> Option<f64> {
        let fits = |distance: f64| {
            let mut count = 0;
            self.visit(distance, |_| {
                count += 1;
                count <= most
            })
        };
        if !fits(0.0) {
            return None;
        }
        let bound = |better: fn(f64, f64) -> f64, start: f64| -> [f64; 3] {
            self.places.iter().fold([start; 3], |b, p| std::array::from_fn(|i| better(b[i], p[i])))
        };
        let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
        let (mut lower, mut upper) = (0.0, distance_of(low, high));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (lower + upper);
            if fits(middle) { lower = middle } else { upper = middle }
        }
        Some(lower)
    }

    /// Shows each pair once while `go_on` is true; true if all were shown. Points are found by cells as wide
    /// as the largest distance of a pair.
    fn visit(self, distance: f64, mut go_on: impl FnMut([u32; 2]) -> bool) -> bool {
        let largest = self.reach.iter().fold(0.0, |m: f64, x| m.max(*x));
        let width = (distance + 2.0 * largest).max(f64::MIN_POSITIVE);
        let cell = |p: &[f64; 3]| p.map(|x| (x / width).floor() as i64);
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for (place, p) in self.places.iter().enumerate() {
            cells.entry(cell(p)).or_default().push(place as u32);
        }
        for (a, p) in self.places.iter().enumerate() {
            let own = cell(p);
            for step in 0..27 {
                let other = [own[0] + step % 3 - 1, own[1] + step / 3 % 3 - 1, own[2] + step / 9 - 1];
                let Some(points) = cells.get(&other) else { continue };
                // Points of a cell ascend.
                let first = points.partition_point(|&b| (b as usize) < a);
                for &b in &points[first..] {
                    let allowed = distance + self.reach[a] + self.reach[b as usize];
                    let near = distance_of(*p, self.places[b as usize]) <= allowed;
                    if near && !go_on([a as u32, b]) {
                        return false;
                    }
                }
            }
        }
        true
    }
}

fn distance_of(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Random;

    #[test]
    fn pairs_are_those_of_a_plain_search_and_the_largest_distance_is_that_of_its_pairs() {
        let mut random = Random::new(5);
        let places: Vec<[f64; 3]> = (0..200).map(|_| [0; 3].map(|_| random.uniform() - 0.5)).collect();
        let reach: Vec<f64> = places.iter().map(|_| 0.1 * random.uniform()).collect();
        let points = Reaches { places: &places, reach: &reach };
        let mut gaps = vec![];
        for distance in [0.0, 0.07, 0.3, 5.0] {
            let mut expected = vec![];
            gaps.clear();
            for a in 0..200 {
                for b in a..200 {
                    let gap = distance_of(places[a], places[b]) - reach[a] - reach[b];
                    gaps.push(gap);
                    if gap <= distance {
                        expected.push([a as u32, b as u32]);
                    }
                }
            }
            assert!(expected.len() >= 200);
            assert_eq!(points.pairs(distance, expected.len()), Some(expected.clone()));
            assert_eq!(points.pairs(distance, expected.len() - 1), None);
        }
        gaps.sort_by(f64::total_cmp);
        let most = 3000;
        let largest = points.largest_distance(most).expect("a distance");
        assert!(gaps[most - 1] - 1e-9 <= largest && largest < gaps[most], "{largest}");
        assert_eq!(points.largest_distance(199), None);
    }
}
