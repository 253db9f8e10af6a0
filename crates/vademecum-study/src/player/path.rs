//! A contact that moves along the surface: places that hand the force over to each other.
//!
//! From place to place the shares of the force change linearly in time, and at any time they add to one. So
//! the load is linear between the instants of the places, whatever the step is, and all that march a scenario
//! are given the same load. Inside of one triangle this is the moving force itself.

use vademecum_format::File;

use crate::contents::Geometry;
use crate::error::StudyError;
use crate::scenario::MAX_LOADS;

/// Places on a mean edge of the loadable triangles.
const PLACES_ON_AN_EDGE: f64 = 4.0;

/// A place on a path and the instants of its share, see [`vademecum_build::dynamics::History::share`].
pub(super) struct Place {
    pub(crate) point: [f64; 3],
    pub(crate) share: [f64; 3],
}

/// Mean length of the edges of the loadable triangles.
pub(super) fn mean_edge(file: &File<'_>) -> Result<f64, StudyError> {
    let Geometry { nodes, triangles } = Geometry::of(file)?;
    let (mut sum, mut count) = (0.0, 0.0);
    for triangle in triangles.iter().take(file.metadata().n_load_triangles as usize) {
        for c in 0..3 {
            let [a, b] = [triangle[c], triangle[(c + 1) % 3]].map(|node| nodes[node as usize]);
            sum += distance(a, b);
            count += 1.0;
        }
    }
    Ok(sum / count)
}

/// The places of a path: its rows, and between two rows so many that neighbours are at most a quarter of
/// `edge` apart.
///
/// # Errors
/// [`StudyError::TooManyPlaces`].
pub(super) fn places(rows: &[(f64, [f64; 3])], edge: f64, contact: usize) -> Result<Vec<Place>, StudyError> {
    let mut stops: Vec<(f64, [f64; 3])> = rows.first().copied().into_iter().collect();
    for pair in rows.windows(2) {
        let [(t0, a), (t1, b)] = [pair[0], pair[1]];
        let parts = (PLACES_ON_AN_EDGE * distance(a, b) / edge).ceil().max(1.0);
        // A surface without any extent has no edge to count by.
        let parts = if parts.is_nan() { f64::INFINITY } else { parts };
        if stops.len() as f64 + parts > MAX_LOADS as f64 {
            return Err(StudyError::TooManyPlaces { contact, edge, most: MAX_LOADS });
        }
        for part in 1..parts as usize {
            let c = part as f64 / parts;
            stops.push((t0 + c * (t1 - t0), std::array::from_fn(|i| a[i] + c * (b[i] - a[i]))));
        }
        stops.push((t1, b));
    }
    let instant = |j: usize| stops[j].0;
    let place = |(j, &(top, point)): (usize, &(f64, [f64; 3]))| {
        let share = [instant(j.saturating_sub(1)), top, instant((j + 1).min(stops.len() - 1))];
        Place { point, share }
    };
    Ok(stops.iter().enumerate().map(place).collect())
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_close_and_their_shares_move_the_force_as_the_path_says() {
        let rows =
            [(0.5, [0.0, 0.0, 0.0]), (1.5, [2.0, 0.0, 0.0]), (2.0, [2.0, 0.0, 0.0]), (3.0, [2.0, 1.0, 0.0])];
        let places = places(&rows, 0.9, 0).expect("places");
        assert_eq!(places.len(), 1 + 9 + 1 + 5);
        let at = |t: f64| {
            let share = |place: &Place| {
                let [from, top, to] = place.share;
                if t < top {
                    if from < top { ((t - from) / (top - from)).max(0.0) } else { 1.0 }
                } else if top < to {
                    ((to - t) / (to - top)).max(0.0)
                } else {
                    1.0
                }
            };
            let sum = |c: usize| places.iter().map(|place| share(place) * place.point[c]).sum::<f64>();
            [sum(0), sum(1)]
        };
        for (t, [x, y]) in
            [(0.0, [0.0, 0.0]), (0.8, [0.6, 0.0]), (1.7, [2.0, 0.0]), (2.3, [2.0, 0.3]), (9.0, [2.0, 1.0])]
        {
            let [found_x, found_y] = at(t);
            assert!((found_x - x).abs() < 1e-14 && (found_y - y).abs() < 1e-14, "{t}: {found_x} {found_y}");
        }
        let endless = super::places(&[(0.0, [0.0; 3]), (1.0, [1e9, 0.0, 0.0])], 1.0, 7);
        assert!(matches!(endless, Err(StudyError::TooManyPlaces { contact: 7, .. })));
    }
}
