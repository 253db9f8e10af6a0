//! Named sets of a deck, in order and found by name.

use std::collections::HashMap;

/// Origin of a set.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    /// By `ELSET=` or `NSET=` where its members are defined.
    Creation,
    /// By *ELSET or *NSET.
    Explicit,
    /// By *ELSET with the flag INTERNAL, which a program wrote for itself.
    Internal,
}

/// A named set of indices.
pub(crate) struct Set {
    pub(crate) name: String,
    pub(crate) members: Vec<usize>,
    pub(crate) family: Family,
    in_assembly: bool,
}

/// Sets in order of their first definition, found without regard to case.
#[derive(Default)]
pub(crate) struct Sets {
    pub(crate) all: Vec<Set>,
    index: HashMap<String, usize>,
}

impl Sets {
    /// Adds members to a set. A set of the assembly that has the name of a set of the part gets `assembly.`
    /// before it.
    pub(crate) fn add(&mut self, name: &str, members: Vec<usize>, family: Family, in_assembly: bool) {
        let mut name = name.to_string();
        if self.get(&name).is_some_and(|set| set.in_assembly != in_assembly) {
            name = format!("assembly.{name}");
        }
        let next = self.all.len();
        let place = *self.index.entry(name.to_ascii_uppercase()).or_insert(next);
        if place == next {
            self.all.push(Set { name, members, family, in_assembly });
        } else {
            self.all[place].members.extend(members);
        }
    }

    pub(crate) fn get(&self, name: &str) -> Option<&Set> {
        self.index.get(&name.to_ascii_uppercase()).map(|&i| &self.all[i])
    }
}
