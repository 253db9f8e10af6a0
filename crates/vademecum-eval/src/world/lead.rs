//! The way of a member that its host leads: stops, and a shake.

/// Displacement over time of a member that its host leads: a way from stop to stop, and a shake beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lead<'m> {
    /// Instants \[s\] in ascending order and displacements \[m\] of the stops. The member is at rest at each;
    /// before the first and after the last it stands there.
    pub stops: &'m [[f64; 4]],
    /// Amplitude of the shake \[m\].
    pub amplitude: [f64; 3],
    /// Frequency of the shake \[Hz\].
    pub frequency: f64,
    /// Time over which the shake grows to its amplitude \[s\]; 0 at once.
    pub ramp: f64,
}

impl Lead<'_> {
    /// Displacement \[m\] at a time \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> [f64; 3] {
        let share = if self.ramp > 0.0 { (time / self.ramp).clamp(0.0, 1.0) } else { 1.0 };
        let size = share * libm::sin(core::f64::consts::TAU * self.frequency * time);
        let stops = self.between(time);
        core::array::from_fn(|k| stops[k] + size * self.amplitude[k])
    }

    fn between(&self, time: f64) -> [f64; 3] {
        let after = self.stops.iter().position(|stop| stop[0] > time).unwrap_or(self.stops.len());
        let before = after.checked_sub(1).and_then(|before| self.stops.get(before));
        match (before, self.stops.get(after)) {
            (Some(&[start, from @ ..]), Some(&[end, to @ ..])) => {
                let share = (time - start) / (end - start);
                // At rest at both ends.
                let share = share * share * (3.0 - 2.0 * share);
                core::array::from_fn(|k| from[k] + share * (to[k] - from[k]))
            }
            (Some(&[_, at @ ..]), None) | (None, Some(&[_, at @ ..])) => at,
            (None, None) => [0.0; 3],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_rests_at_its_stops_and_a_shake_grows() {
        let stops = [[1.0, 0.0, 0.0, 1.0], [3.0, 2.0, 0.0, 1.0]];
        let way = Lead { stops: &stops, ..Lead::default() };
        assert_eq!([0.0, 2.0, 3.0, 9.0].map(|time| way.at(time)[0]), [0.0, 1.0, 2.0, 2.0]);
        assert!(way.at(1.001)[0] < 1e-5 && way.at(2.001)[0] - 1.0 > 1e-3, "slow at a stop, fast between");
        let shake = Lead { amplitude: [0.0, 0.1, 0.0], frequency: 0.25, ramp: 2.0, ..Lead::default() };
        assert!((shake.at(1.0)[1] - 0.05).abs() < 1e-15 && (shake.at(5.0)[1] - 0.1).abs() < 1e-15);
        assert_eq!(Lead::default().at(3.0), [0.0; 3]);
    }
}
