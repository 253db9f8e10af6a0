//! The elimination tree of a factor, and how threads share it.
//!
//! Threads share the subtrees that are small compared with the whole. The groups above them are processed
//! group by group, and there threads share the rows of the dense products. Children are taken in one order,
//! so the bits never depend on the number of threads.
//!
//! The contribution of a group to its parent is kept in memory until then. In a factorisation that is a dense
//! matrix, so a few subtrees are processed at a time, and then their parents. In a solve it is a few numbers
//! for each row, so all subtrees come first and threads wait for each other once.

use std::collections::BTreeMap;

use crate::parallel;

/// Contribution of a group to its parent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Contribution {
    /// A dense matrix.
    Much,
    /// Some numbers for each of its rows.
    Little,
}

impl Contribution {
    /// Share of the whole work above which a subtree is no task of one thread.
    fn task(self) -> f64 {
        match self {
            Self::Much => 1.0 / 128.0,
            Self::Little => 1.0 / 32.0,
        }
    }

    /// Share of the whole work in the subtrees that threads share before some parent takes what they leave;
    /// all of it where that is little.
    fn at_once(self) -> Option<f64> {
        match self {
            Self::Much => Some(1.0 / 32.0),
            Self::Little => None,
        }
    }
}

/// A unit of traversal.
#[derive(Debug)]
enum Pass {
    /// The groups of some subtrees, one thread each; ascending.
    Subtrees(Vec<Vec<usize>>),
    /// A group that all threads work on.
    Group(usize),
}

/// Contributions of some groups to others.
type Contributions<L> = BTreeMap<usize, L>;

/// The elimination tree of the groups.
#[derive(Debug)]
pub(super) struct Tree {
    /// The group of the first row below each.
    parent: Vec<Option<usize>>,
    /// Ascending.
    children: Vec<Vec<usize>>,
    /// From the leaves to the roots.
    stages: Vec<Pass>,
}

impl Tree {
    /// The tree of groups by their parents; `work` is what each of them takes, and `leaves` what it leaves.
    pub(crate) fn new(parent: Vec<Option<usize>>, mut work: Vec<f64>, leaves: Contribution) -> Tree {
        let mut children = vec![vec![]; parent.len()];
        for (group, parent) in parent.iter().enumerate() {
            if let Some(parent) = *parent {
                children[parent].push(group);
                // A parent comes after its children.
                work[parent] += work[group];
            }
        }
        let roots = (0..work.len()).filter(|&group| parent[group].is_none());
        let total: f64 = roots.map(|group| work[group]).sum();
        // The root of the subtree that each group is in.
        let mut root: Vec<Option<usize>> = vec![None; work.len()];
        for group in (0..work.len()).rev().filter(|&group| work[group] <= leaves.task() * total) {
            root[group] = Some(parent[group].and_then(|parent| root[parent]).unwrap_or(group));
        }
        let mut subtrees: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (group, root) in root.iter().enumerate() {
            if let Some(root) = *root {
                subtrees.entry(root).or_default().push(group);
            }
        }
        let mut subtrees = subtrees.into_iter().peekable();
        let mut stages = vec![];
        let above = (0..work.len()).filter(|&group| root[group].is_none()).map(Some);
        let at_once = leaves.at_once();
        for next in above.chain([None]) {
            let is_next = |root: usize| at_once.is_none() || next.is_none_or(|next| root < next);
            while subtrees.peek().is_some_and(|(root, _)| is_next(*root)) {
                let (mut some, mut share) = (vec![], 0.0);
                while at_once.is_none_or(|most| share < most)
                    && let Some((root, groups)) = subtrees.next()
                {
                    share += work[root] / total;
                    some.push(groups);
                }
                stages.push(Pass::Subtrees(some));
            }
            stages.extend(next.map(Pass::Group));
        }
        Tree { parent, children, stages }
    }

    /// From the leaves to the roots. `task` gets a group, its part, and what its children left.
    ///
    /// # Errors
    /// The first one of the tasks.
    pub(crate) fn upwards<P: Send, L: Send, E: Send>(
        &self,
        parts: Vec<P>,
        task: impl Fn(usize, P, Vec<(usize, L)>) -> Result<L, E> + Sync,
    ) -> Result<(), E> {
        let climb = |groups: Vec<(usize, P)>, mut left: Contributions<L>| -> Result<Contributions<L>, E> {
            for (group, part) in groups {
                let of = |child: &usize| (*child, left.remove(child).expect("children come first"));
                let children = self.children[group].iter().map(of).collect();
                left.insert(group, task(group, part, children)?);
            }
            Ok(left)
        };
        let mut parts = Slots::new(parts);
        let mut left = Contributions::new();
        for stage in &self.stages {
            match stage {
                Pass::Group(group) => left = climb(parts.take(&[*group]), left)?,
                Pass::Subtrees(subtrees) => {
                    let some = subtrees.iter().map(|groups| parts.take(groups));
                    let climb = |_, groups| climb(groups, Contributions::new());
                    for done in parallel::map_of(some, &climb) {
                        left.append(&mut done?);
                    }
                }
            }
        }
        Ok(())
    }

    /// From the roots to the leaves. `task` gets a group, its part, and what its parent left.
    pub(crate) fn downwards<P: Send, L: Send + Sync>(
        &self,
        parts: Vec<P>,
        task: impl Fn(usize, P, Option<&L>) -> L + Sync,
    ) {
        // What a group left, and how many of its children have not taken it.
        type Pending<L> = Contributions<(usize, L)>;
        let taken = |group: usize, left: &mut Pending<L>| {
            let parent = self.parent[group].and_then(|parent| left.get_mut(&parent).map(|of| (parent, of)));
            if let Some((parent, (children, _))) = parent {
                *children -= 1;
                if *children == 0 {
                    left.remove(&parent);
                }
            }
        };
        // `above` is what was left outside the subtree.
        let descend = |groups: Vec<(usize, P)>, left: &mut Pending<L>, above: Option<&Pending<L>>| {
            for (group, part) in groups.into_iter().rev() {
                let from = self.parent[group].and_then(|parent| {
                    let from = left.get(&parent).or_else(|| above?.get(&parent));
                    from.map(|(_, from)| from)
                });
                let done = task(group, part, from);
                taken(group, left);
                if !self.children[group].is_empty() {
                    left.insert(group, (self.children[group].len(), done));
                }
            }
        };
        let mut parts = Slots::new(parts);
        let mut left = Contributions::new();
        for stage in self.stages.iter().rev() {
            match stage {
                Pass::Group(group) => descend(parts.take(&[*group]), &mut left, None),
                Pass::Subtrees(subtrees) => {
                    let some = subtrees.iter().map(|groups| parts.take(groups));
                    parallel::for_each_of(some, &|_, groups| {
                        descend(groups, &mut Contributions::new(), Some(&left));
                    });
                    subtrees
                        .iter()
                        .filter_map(|groups| groups.last())
                        .for_each(|&root| taken(root, &mut left));
                }
            }
        }
    }
}

/// The parts of the groups, each of them taken once.
struct Slots<P>(Vec<Option<P>>);

impl<P> Slots<P> {
    fn new(parts: Vec<P>) -> Self {
        Self(parts.into_iter().map(Some).collect())
    }

    fn take(&mut self, groups: &[usize]) -> Vec<(usize, P)> {
        groups.iter().map(|&group| (group, self.0[group].take().expect("one stage for each group"))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_group_meets_its_children_and_its_parent() {
        // A binary tree of 255 groups, numbered so that subtrees are not in one piece: each level at a time.
        let parent: Vec<Option<usize>> =
            (0..255).map(|group| (group < 254).then_some(128 + group / 2)).collect();
        for (work, leaves) in [
            (1.0, Contribution::Much),
            (300.0, Contribution::Much),
            (1.0, Contribution::Little),
            (300.0, Contribution::Little),
        ] {
            // The second one has all the work in a leaf.
            let shares = (0..255).map(|group| if group == 3 { work } else { 1.0 }).collect();
            let tree = Tree::new(parent.clone(), shares, leaves);
            let sizes = std::sync::Mutex::new(vec![0; 255]);
            let climb = |group: usize, part: usize, children: Vec<(usize, usize)>| {
                assert_eq!(group, part);
                let own = 1 + children.iter().map(|(_, size)| size).sum::<usize>();
                sizes.lock().expect("no panic")[group] = own;
                if group == 400 { Err(()) } else { Ok(own) }
            };
            tree.upwards((0..255).collect(), climb).expect("no error");
            assert_eq!(sizes.lock().expect("no panic")[254], 255);
            let depths = std::sync::Mutex::new(vec![0; 255]);
            tree.downwards((0..255).collect(), |group, part: usize, above: Option<&usize>| {
                assert_eq!(group, part);
                assert_eq!(above.is_none(), group == 254);
                let own = above.map_or(0, |above| above + 1);
                depths.lock().expect("no panic")[group] = own;
                own
            });
            let depths = depths.into_inner().expect("no panic");
            assert_eq!([depths[0], depths[253], depths[254]], [7, 1, 0]);
        }
    }
}
