//! Copies of a part of a world, and pairs of parts by the beginning of their names.

use crate::file::{AssemblyFile, PartEntry};
use crate::names::{ANY, means};

impl PartEntry {
    /// The part, or its copies in their places, `name1`, `name2`, … along x first.
    fn copied(self, entry: usize) -> Vec<Self> {
        let Some([nx, ny, nz]) = self.copies else { return vec![Self { entry, ..self }] };
        let places = (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        let spacing = self.spacing.unwrap_or_default();
        let copy = |(number, at): (usize, [usize; 3])| Self {
            name: format!("{}{}", self.name, number + 1),
            position: std::array::from_fn(|k| self.position[k] + at[k] as f64 * spacing[k]),
            entry,
            ..self.clone()
        };
        places.enumerate().map(copy).collect()
    }

    /// Number of parts that it stands for; `None` if they are too many to count.
    pub(crate) fn count(&self) -> Option<usize> {
        let [nx, ny, nz] = self.copies.unwrap_or([1; 3]);
        nx.checked_mul(ny)?.checked_mul(nz)
    }
}

impl AssemblyFile {
    /// Puts the copies of each part in its place.
    pub(crate) fn copy_parts(&mut self) {
        let parts = std::mem::take(&mut self.parts);
        self.parts = parts.into_iter().enumerate().flat_map(|(i, part)| part.copied(i)).collect();
    }

    /// Puts the pairs that each entry of a contact means in its place: of two different parts, not both
    /// rigid, and no pair that an entry before it means.
    pub(crate) fn name_pairs(&mut self) {
        let named = std::mem::take(&mut self.contacts);
        let mut seen = std::collections::HashSet::new();
        for (entry, contact) in named.into_iter().enumerate() {
            let is_meant = contact.between.iter().any(|name| name.ends_with(ANY));
            let [of_a, of_b] = contact.between.each_ref().map(|pattern| {
                let meant = |part: &usize| means(pattern, &self.parts[*part].name);
                (0..self.parts.len()).filter(meant).collect::<Vec<_>>()
            });
            for &a in &of_a {
                for &b in &of_b {
                    let rigid = self.parts[a].rigid.is_some() && self.parts[b].rigid.is_some();
                    if a == b || rigid || !seen.insert([a.min(b), a.max(b)]) {
                        continue;
                    }
                    let between = [a, b].map(|part| self.parts[part].name.clone());
                    self.contacts.push(crate::entries::ContactEntry { between, entry, is_meant, ..contact });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_stand_in_rows_and_pairs_are_meant_once() {
        let text = "format = 1\n[world]\ntime = 1.0\n[[part]]\nname = \"c\"\nfile = \"c.vdm\"\ncopies = [2, 1, 2]\n\
                    spacing = [0.5, 1.0, 2.0]\nposition = [1, 0, 0]\n[[part]]\nname = \"box1\"\n\
                    rigid = { box = { lengths = [1, 1, 1] } }\n[[part]]\nname = \"box2\"\n\
                    rigid = { box = { lengths = [1, 1, 1] } }\n[[contact]]\nbetween = [\"c*\", \"c*\"]\n\
                    [[contact]]\nbetween = [\"*\", \"box*\"]\nfriction = 0.5\n";
        let file = AssemblyFile::parse(text, "copies.toml", std::path::PathBuf::new()).expect("a world");
        let names: Vec<&str> = file.parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, ["c1", "c2", "c3", "c4", "box1", "box2"]);
        assert_eq!(file.parts[3].position, [1.5, 0.0, 2.0]);
        assert_eq!((file.parts[3].entry, file.parts[5].entry), (0, 2));
        // Six pairs of copies, and four copies on two boxes.
        assert_eq!(file.contacts.len(), 6 + 8);
        assert!(file.contacts[6..].iter().all(|contact| contact.friction == 0.5 && contact.entry == 1));
    }
}
