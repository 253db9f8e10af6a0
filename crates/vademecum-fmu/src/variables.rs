//! Which variable a value reference is: the same list for the model description and for the instance.
//!
//! The references of a kind are consecutive, and kinds follow each other in the order of [`Variable`].

/// How many there are of everything that is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Named points.
    pub points: u32,
    /// Load patterns of the file.
    pub patterns: u32,
    /// Probes of the file.
    pub probes: u32,
    /// Parameters of the file.
    pub parameters: u32,
}

/// What a value reference means. Points, patterns, probes and parameters are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// Time \[s\], the independent variable.
    Time,
    /// `Δt` \[s\], the internal step.
    Step,
    /// Kinetic plus elastic energy \[J\].
    Energy,
    /// Component 0 to 2 of the force on a point \[N\].
    Force(u32, u32),
    /// Component 0 to 2 of a point's displacement \[m\].
    Displacement(u32, u32),
    /// Component 0 to 2 of a point's velocity \[m/s\].
    Velocity(u32, u32),
    /// Amplitude of a load pattern.
    Pattern(u32),
    /// Displacement of a probe \[m\].
    Probe(u32),
    /// Velocity of a probe \[m/s\].
    ProbeVelocity(u32),
    /// A parameter of the file.
    Parameter(u32),
}

impl Variable {
    /// First part of its name, and last part for a component: `force.NAME.x`.
    #[must_use]
    pub const fn kind(self) -> (&'static str, Option<&'static str>) {
        const fn component(component: u32) -> Option<&'static str> {
            match component {
                0 => Some("x"),
                1 => Some("y"),
                _ => Some("z"),
            }
        }
        match self {
            Self::Time => ("time", None),
            Self::Step => ("internal_step", None),
            Self::Energy => ("energy", None),
            Self::Force(_, c) => ("force", component(c)),
            Self::Displacement(_, c) => ("displacement", component(c)),
            Self::Velocity(_, c) => ("velocity", component(c)),
            Self::Pattern(_) => ("pattern", None),
            Self::Probe(_) => ("probe", None),
            Self::ProbeVelocity(_) => ("probe_velocity", None),
            Self::Parameter(_) => ("parameter", None),
        }
    }
}

impl Counts {
    /// How many references of each kind there are, in their order.
    const fn lengths(&self) -> [u32; 10] {
        let Self { points, patterns, probes, parameters } = *self;
        let components = 3 * points;
        [1, 1, 1, components, components, components, patterns, probes, probes, parameters]
    }

    /// The variable of a reference.
    #[must_use]
    pub fn variable(&self, reference: u32) -> Option<Variable> {
        use Variable as V;
        let mut at = reference;
        for (kind, length) in self.lengths().into_iter().enumerate() {
            let Some(beyond) = at.checked_sub(length) else {
                let (item, component) = (at / 3, at % 3);
                return Some(match kind {
                    0 => V::Time,
                    1 => V::Step,
                    2 => V::Energy,
                    3 => V::Force(item, component),
                    4 => V::Displacement(item, component),
                    5 => V::Velocity(item, component),
                    6 => V::Pattern(at),
                    7 => V::Probe(at),
                    8 => V::ProbeVelocity(at),
                    _ => V::Parameter(at),
                });
            };
            at = beyond;
        }
        None
    }

    /// All variables in the order of their references, which count from 0.
    pub fn all(&self) -> impl Iterator<Item = Variable> {
        let count = self.lengths().into_iter().fold(0, u32::wrapping_add);
        let counts = *self;
        (0..count).filter_map(move |reference| counts.variable(reference))
    }
}

#[cfg(test)]
mod tests {
    use super::{Counts, Variable as V};

    #[test]
    fn references_follow_each_other() {
        let counts = Counts { points: 2, patterns: 1, probes: 2, parameters: 1 };
        let all: Vec<V> = counts.all().collect();
        assert_eq!(all.len(), 3 + 3 * 6 + 1 + 2 * 2 + 1);
        assert_eq!(all[..5], [V::Time, V::Step, V::Energy, V::Force(0, 0), V::Force(0, 1)]);
        assert_eq!(all[8..10], [V::Force(1, 2), V::Displacement(0, 0)]);
        let tail = [V::Velocity(1, 2), V::Pattern(0), V::Probe(0), V::Probe(1), V::ProbeVelocity(0)];
        assert_eq!(all[20..25], tail);
        assert_eq!(all[25..], [V::ProbeVelocity(1), V::Parameter(0)]);
        assert_eq!(counts.variable(all.len() as u32), None);
        assert_eq!(Counts::default().all().count(), 3);
    }
}
