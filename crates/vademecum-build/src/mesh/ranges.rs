//! Lists of numbers with ranges in them.

/// Numbers of nodes or elements as a file lists them: single ones, and all from a first to a last.
#[derive(Clone, Debug, Default)]
pub(crate) struct IdRanges(Vec<[u64; 2]>);

impl IdRanges {
    /// Adds all numbers from a first to a last.
    pub(crate) fn add(&mut self, range: [u64; 2]) {
        self.0.push(range);
    }

    /// Indices of the known numbers that are listed, each once; `known` is ascending by number. A range
    /// longer than the file costs nothing.
    pub(crate) fn members(&self, known: &[(u64, u32)]) -> Vec<u32> {
        let mut sorted = self.0.clone();
        sorted.sort_unstable();
        let (mut members, mut taken) = (Vec::new(), 0);
        for [first, last] in sorted {
            let from = taken.max(known.partition_point(|(id, _)| *id < first));
            let to = known.partition_point(|(id, _)| *id <= last);
            members.extend(known.get(from..to).unwrap_or_default().iter().map(|(_, index)| *index));
            taken = taken.max(to);
        }
        members
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_of_ranges_come_once() {
        let known = [(2, 0), (5, 1), (6, 2), (900, 3)];
        let mut ranges = IdRanges::default();
        [[5, u64::MAX], [6, 6], [1, 3], [5, 5], [4, 1]].into_iter().for_each(|range| ranges.add(range));
        assert_eq!(ranges.members(&known), [0, 1, 2, 3]);
        assert_eq!(IdRanges::default().members(&known), [0u32; 0]);
    }
}
