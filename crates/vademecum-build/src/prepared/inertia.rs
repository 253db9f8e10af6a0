//! Mass and centre of a body by the mass matrix of another program. A matrix with a wrong entry may be
//! symmetric and positive definite all the same, which is checked elsewhere; here it shows.

/// Masses along two axes may differ by this share: matrices in text have six digits or more.
const ROUNDING: f64 = 1e-6;

/// Sums of a mass matrix over the nodes all of whose components are free.
pub(crate) struct Inertia {
    /// `1ᵀM1` between components \[kg\].
    mass: [[f64; 3]; 3],
    /// Centre of the mass along x \[m\].
    centre: [f64; 3],
}

impl Inertia {
    /// Of entries `(row, column, value)`, a row for each free dof, ascending.
    pub(crate) fn of(mass: &[(u32, u32, f64)], constrained: &[bool], nodes: &[[f64; 3]]) -> Self {
        let free: Vec<usize> = (0..constrained.len()).filter(|&dof| !constrained[dof]).collect();
        let is_whole: Vec<bool> = constrained.chunks_exact(3).map(|held| held == [false; 3]).collect();
        let mut found = Self { mass: [[0.0; 3]; 3], centre: [0.0; 3] };
        for &(row, column, value) in mass {
            let [a, b] = [row, column].map(|at| free[at as usize]);
            if is_whole[a / 3] && is_whole[b / 3] {
                found.mass[a % 3][b % 3] += value;
                if (a % 3, b % 3) == (0, 0) {
                    found.centre.iter_mut().zip(nodes[a / 3]).for_each(|(sum, x)| *sum += value * x);
                }
            }
        }
        found.centre = found.centre.map(|sum| sum / found.mass[0][0]);
        found
    }

    /// In sentences for the user.
    pub(crate) fn notes(&self) -> Vec<String> {
        let [x, y, z] = [0, 1, 2].map(|axis| self.mass[axis][axis]);
        if x == 0.0 && y == 0.0 && z == 0.0 {
            return vec![];
        }
        let [a, b, c] = self.centre;
        let mut notes = vec![format!(
            "the mass matrix has {x:.6e} kg along x, {y:.6e} along y and {z:.6e} along z over the nodes that are \
             free, with the centre ({a:.6}, {b:.6}, {c:.6})"
        )];
        let size = x.abs().max(y.abs()).max(z.abs());
        let differ = [x - y, y - z, x - z].into_iter().any(|difference| difference.abs() > ROUNDING * size);
        let [[_, xy, xz], [_, _, yz], _] = self.mass;
        let coupled = [xy, xz, yz].into_iter().any(|coupling| coupling.abs() > ROUNDING * size);
        if differ || coupled || x <= 0.0 {
            notes.push(
                "warning: a body has one mass along all axes, and none between them; this matrix does not: is an \
                 entry wrong, or is a mass of one direction (a fluid, a mechanism) meant?"
                    .into(),
            );
        }
        notes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACES: [[f64; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 3.0, 0.0]];

    /// Three nodes of 1, 2 and 3 kg coupled by half a kilogram; the last one is held along z.
    fn entries() -> (Vec<(u32, u32, f64)>, Vec<bool>) {
        let mut constrained = vec![false; 9];
        constrained[8] = true;
        let mut entries = vec![];
        for c in 0..3 {
            entries.extend([(c, c, 1.0), (3 + c, 3 + c, 2.0), (c, 3 + c, 0.5), (3 + c, c, 0.5)]);
        }
        entries.extend([(6, 6, 3.0), (7, 7, 3.0)]);
        (entries, constrained)
    }

    #[test]
    fn mass_and_centre_are_those_of_the_free_nodes() {
        let (entries, constrained) = entries();
        let found = Inertia::of(&entries, &constrained, &PLACES);
        assert_eq!(found.mass, [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]]);
        assert_eq!(found.centre, [2.5 / 4.0, 0.0, 0.0]);
        assert_eq!(found.notes().len(), 1);
    }

    #[test]
    fn one_entry_that_is_negated_or_scaled_is_seen() {
        let (sound, constrained) = entries();
        for (place, factor) in [(0, -1.0), (0, 1.01), (1, -1.0), (2, 10.0), (4, 0.5)] {
            let mut entries = sound.clone();
            entries[place].2 *= factor;
            let notes = Inertia::of(&entries, &constrained, &PLACES).notes();
            assert!(notes.len() > 1, "{place} {factor}: {notes:?}");
        }
    }
}
