//! Pareto front of points of time and error.

/// Points are on the front if no faster one comes within this factor of their error: digits that differ
/// behind the second figure are no reason to step slower.
pub(super) const BETTER: f64 = 0.99;

/// The points (time, error) that no other point beats in both, fastest first.
pub fn front(points: impl IntoIterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = points.into_iter().collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    points.retain(|p| {
        let better = p.1 < BETTER * least;
        least = least.min(p.1);
        better
    });
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_falls() {
        let points = [(3.0, 0.5), (1.0, 0.9), (2.0, 1.0), (4.0, 0.6), (5.0, 0.1), (6.0, 0.0999)];
        assert_eq!(front(points), [(1.0, 0.9), (3.0, 0.5), (5.0, 0.1)]);
    }
}
