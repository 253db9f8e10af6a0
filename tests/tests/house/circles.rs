//! Circles in a graph of uses.

use std::collections::{BTreeMap, BTreeSet};

use crate::modules::{Graph, Use};

impl Graph {
    /// Sets of files of which each reaches each other: the strongly connected components of more than one.
    pub fn circles(&self) -> Vec<Vec<String>> {
        let reached: BTreeMap<&str, BTreeSet<&str>> =
            self.uses.keys().map(|file| (file.as_str(), self.reached(file))).collect();
        let mut circles = vec![];
        let mut seen = BTreeSet::new();
        for (file, there) in &reached {
            if !there.contains(file) || !seen.insert(*file) {
                continue;
            }
            let circle: Vec<String> = there
                .iter()
                .filter(|other| reached.get(*other).is_some_and(|back| back.contains(file)))
                .map(|other| (*other).to_string())
                .collect();
            seen.extend(there.iter().filter(|other| circle.iter().any(|x| x == *other)));
            circles.push(circle);
        }
        circles
    }

    /// The graph without the uses between the two files of each pair.
    pub fn without(&self, pairs: &[[&str; 2]]) -> Self {
        let mut rest = Self { uses: self.uses.clone() };
        for [a, b] in pairs {
            for (from, to) in [(a, b), (b, a)] {
                rest.uses.entry((*from).to_string()).or_default().remove(*to);
            }
        }
        rest
    }

    /// Whether each of the two files uses the other.
    pub fn is_pair(&self, [a, b]: [&str; 2]) -> bool {
        let uses = |from: &str, to: &str| self.uses.get(from).is_some_and(|uses| uses.contains_key(to));
        uses(a, b) && uses(b, a)
    }

    /// Files that a file uses, and what they use, and so on.
    fn reached(&self, file: &str) -> BTreeSet<&str> {
        let mut found = BTreeSet::new();
        let mut open = vec![file];
        while let Some(next) = open.pop() {
            for to in self.uses.get(next).into_iter().flat_map(BTreeMap::keys) {
                if found.insert(to.as_str()) {
                    open.push(to);
                }
            }
        }
        found
    }

    /// The uses inside a circle, one a line.
    pub fn lines(&self, circle: &[String]) -> String {
        let inside = |from: &String| -> Vec<String> {
            let to = self.uses[from].iter().filter(|(to, _)| circle.contains(to));
            to.map(|(to, Use { place, text })| format!("  {from} uses {to} ({place}): {text}")).collect()
        };
        circle.iter().flat_map(inside).collect::<Vec<_>>().join("\n")
    }

    /// The same for rooms: a file counts as its folder or, at the top, as itself.
    pub fn rooms(&self) -> Self {
        let mut rooms = Self::default();
        for (from, uses) in &self.uses {
            let room_uses = rooms.uses.entry(room(from)).or_default();
            for (to, found) in uses.iter().filter(|(to, _)| room(to) != room(from)) {
                room_uses.entry(room(to)).or_insert_with(|| found.clone());
            }
        }
        rooms
    }
}

/// `a` for `a.rs`, `a/mod.rs` and everything else in `a/`.
fn room(file: &str) -> String {
    file.split('/').next().unwrap_or_default().trim_end_matches(".rs").to_string()
}

#[test]
fn circles_are_found_and_a_pair_excuses_only_itself() {
    let edge = |to: &str| (to.to_string(), Use { place: "here".into(), text: String::new() });
    let uses = |from: &str, to: &[&str]| (from.to_string(), to.iter().map(|to| edge(to)).collect());
    let graph = Graph {
        uses: BTreeMap::from([
            uses("a.rs", &["b.rs", "r/x.rs"]),
            uses("b.rs", &["a.rs", "c.rs"]),
            uses("c.rs", &["d.rs"]),
            uses("d.rs", &["e.rs"]),
            uses("e.rs", &["c.rs"]),
            uses("r/x.rs", &["r/y.rs"]),
            uses("r/y.rs", &["a.rs"]),
        ]),
    };
    let all = [vec!["a.rs", "b.rs", "r/x.rs", "r/y.rs"], vec!["c.rs", "d.rs", "e.rs"]];
    assert_eq!(graph.circles(), all);
    assert!(graph.is_pair(["a.rs", "b.rs"]) && !graph.is_pair(["c.rs", "d.rs"]));
    let rest = graph.without(&[["a.rs", "b.rs"]]);
    assert_eq!(rest.circles(), [vec!["a.rs", "r/x.rs", "r/y.rs"], vec!["c.rs", "d.rs", "e.rs"]]);
    assert_eq!(graph.rooms().circles(), [vec!["a", "b", "r"], vec!["c", "d", "e"]]);
    assert!(
        graph
            .lines(&all[1].clone().into_iter().map(String::from).collect::<Vec<_>>())
            .contains("d.rs uses e.rs (here)")
    );
}
