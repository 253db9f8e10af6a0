//! Universal files of I-DEAS (`.unv`): datasets between lines of −1, each with its number.
//!
//! Nodes (15, 781, 2411), elements (780, 2412), groups (2429 to 2477) and units (164) are read, others are
//! passed over. Nodes of quadratic elements run round each face, corners and middles of edges in turn.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::error::MeshError;
use super::groups::Groups;
use super::kind::{ElementKind, FacetKind};
use super::raw::{CellKind, NodeIndex, RawMesh};
use super::shapes::MAX_NODES;
use super::text::{ParsedNumber, Text, tokens};

/// The line before and behind a dataset.
const BORDER: &[u8] = b"-1";

/// Datasets of groups, and the numbers of an entity in them.
const GROUPS: [(&[u8], usize); 7] =
    [(b"2429", 2), (b"2430", 2), (b"2432", 2), (b"2435", 4), (b"2452", 4), (b"2467", 4), (b"2477", 4)];

/// Places of our nodes in the order of the file.
const TET10: &[usize] = &[0, 2, 4, 9, 1, 3, 5, 6, 7, 8];
const HEX20: &[usize] = &[0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11];
const WEDGE15: &[usize] = &[0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8];
const TRI6: &[usize] = &[0, 2, 4, 1, 3, 5];
const QUAD8: &[usize] = &[0, 2, 4, 6, 1, 3, 5, 7];

/// True of a universal file: its first line is one of −1, the second one the number of a dataset.
pub(super) fn is_universal(head: &[u8]) -> bool {
    let mut lines = head.split(|b| *b == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
    let is_number = |line: &[u8]| tokens(line).next().is_some_and(|word| word.iter().all(u8::is_ascii_digit));
    lines.next() == Some(BORDER) && lines.next().is_some_and(is_number)
}

/// Reads a universal file.
pub(crate) fn parse(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut reader = Reader {
        text: Text::new(file, bytes),
        raw: RawMesh::new(file, "universal file"),
        index: NodeIndex::default(),
        cells: HashMap::new(),
        groups: vec![],
        others: BTreeMap::new(),
    };
    while let Some(line) = reader.text.next_line() {
        if line != BORDER {
            return Err(reader.text.malformed(line, "a line of -1 before a dataset"));
        }
        let header = reader.text.line("the number of a dataset")?;
        let number = tokens(header).next().unwrap_or_default();
        reader.text.section = format!("dataset {}", String::from_utf8_lossy(number));
        match number {
            b"15" => reader.nodes(false)?,
            b"781" | b"2411" => reader.nodes(true)?,
            b"780" => reader.elements([5, 7], 8)?,
            b"2412" => reader.elements([3, 5], 6)?,
            b"164" => reader.units()?,
            _ => match GROUPS.iter().find(|(known, _)| *known == number) {
                Some((_, width)) => reader.groups(*width)?,
                None => while reader.row()?.is_some() {},
            },
        }
    }
    reader.finish()
}

struct Reader<'a> {
    text: Text<'a>,
    raw: RawMesh,
    index: NodeIndex,
    /// Nodes of each element, and whether it is a facet.
    cells: HashMap<u64, (Vec<u32>, bool)>,
    /// Name of each group, and its entities: type and number.
    groups: Vec<(String, Vec<[u64; 2]>)>,
    /// Elements that are not read, by their type.
    others: BTreeMap<String, usize>,
}

impl<'a> Reader<'a> {
    /// The next line of a dataset; none at its end.
    fn row(&mut self) -> Result<Option<&'a [u8]>, MeshError> {
        let line = self.text.line("a line of -1 behind the dataset")?;
        Ok((line != BORDER).then_some(line))
    }

    /// Whole numbers of a line.
    fn whole(&self, line: &[u8], expected: &str) -> Result<Vec<i64>, MeshError> {
        let numbers = tokens(line).map(i64::parse).collect::<Option<Vec<_>>>();
        numbers.ok_or_else(|| self.text.malformed(line, expected))
    }

    /// Nodes; a line of their own for coordinates, or the end of the first one.
    fn nodes(&mut self, apart: bool) -> Result<(), MeshError> {
        const EXPECTED: &str = "a node: number, two systems, colour; then x, y, z";
        while let Some(line) = self.row()? {
            let id = tokens(line).next().and_then(u64::parse);
            let id = id.ok_or_else(|| self.text.malformed(line, EXPECTED))?;
            let (line, from) = if apart { (self.text.line(EXPECTED)?, 0) } else { (line, 4) };
            let mut point = [0.0; 3];
            let mut words = tokens(line).skip(from);
            for x in &mut point {
                let number = words.next().and_then(f64::parse);
                *x = number.ok_or_else(|| self.text.malformed(line, EXPECTED))?;
            }
            self.index.insert(id, self.raw.nodes.len(), &self.text.at())?;
            self.raw.nodes.push(point);
            self.raw.node_ids.push(id);
        }
        Ok(())
    }

    /// Elements: places of the material and of the number of nodes in their first line, and its length.
    fn elements(&mut self, [material, count]: [usize; 2], length: usize) -> Result<(), MeshError> {
        const EXPECTED: &str = "an element: number, type, property, material, colour, number of nodes";
        while let Some(line) = self.row()? {
            let numbers = self.whole(line, EXPECTED)?;
            let place = self.text.place();
            let (Some(&id), Some(&code), true) = (numbers.first(), numbers.get(1), numbers.len() >= length)
            else {
                return Err(self.text.malformed(line, EXPECTED));
            };
            let material = numbers[material];
            let nodes = u64::try_from(numbers[count]).unwrap_or(u64::MAX);
            let nodes = self.text.bounded(nodes, 2, "nodes")?;
            // Beams have a line for their cross-section.
            if matches!(code, 11 | 21..=24 | 31 | 32) {
                self.text.line("the cross-section of a beam")?;
            }
            let mut given = Vec::with_capacity(nodes.min(32));
            while given.len() < nodes {
                let line = self.text.line("numbers of nodes")?;
                for id in self.whole(line, "numbers of nodes")? {
                    given.push(self.index.find(u64::try_from(id).unwrap_or(0), &self.text.at())?);
                }
            }
            let (kind, order) = match cell_kind(code, nodes) {
                Some(found) => found,
                None => {
                    *self.others.entry(words_of(code)).or_default() += 1;
                    // Of rigid elements with very many nodes groups do not hold copies.
                    if given.len() <= MAX_NODES {
                        self.cells.insert(id as u64, (given, false));
                    }
                    continue;
                }
            };
            if given.len() != kind.node_count() {
                let found = format!("{} nodes of an element of type {code}", given.len());
                return Err(self.text.at().malformed(found, format!("{}", kind.node_count())));
            }
            let ordered: Vec<u32> = match order {
                [] => given,
                order => order.iter().map(|&place| given[place]).collect(),
            };
            let tags = if kind.dimension() == 3 { &[material][..] } else { &[][..] };
            self.raw.push(kind, &ordered, tags, place);
            self.cells.insert(id as u64, (ordered, matches!(kind, CellKind::Facet(_))));
        }
        Ok(())
    }

    /// Groups of nodes (type 7) and of elements (type 8).
    fn groups(&mut self, width: usize) -> Result<(), MeshError> {
        const EXPECTED: &str =
            "a group: eight numbers, the last one that of its entities; its name; entities";
        while let Some(line) = self.row()? {
            let numbers = self.whole(line, EXPECTED)?;
            let count = numbers.last().and_then(|count| u64::try_from(*count).ok());
            let count = count.ok_or_else(|| self.text.malformed(line, EXPECTED))?;
            let count = self.text.bounded(count, 2 * width, "entities")?;
            let name = self.text.line("the name of a group")?;
            let name = String::from_utf8_lossy(name).into_owned();
            let mut entities = Vec::new();
            while entities.len() < count {
                let line = self.text.line("entities of a group")?;
                let numbers = self.whole(line, EXPECTED)?;
                if !numbers.len().is_multiple_of(width) {
                    return Err(self.text.malformed(line, EXPECTED));
                }
                let positive = |number: i64| u64::try_from(number).unwrap_or(0);
                entities.extend(numbers.chunks_exact(width).map(|e| [positive(e[0]), positive(e[1])]));
            }
            self.groups.push((name, entities));
        }
        Ok(())
    }

    /// Units: a factor from metres to the lengths of the file.
    fn units(&mut self) -> Result<(), MeshError> {
        let mut rows = vec![];
        while let Some(line) = self.row()? {
            rows.push(line);
        }
        let length = rows.get(1).and_then(|line| tokens(line).next()).and_then(f64::parse);
        if let Some(length) = length.filter(|length| *length > 0.0 && *length != 1.0) {
            self.raw.notes.push(format!(
                "dataset 164: {length} units of length are a metre; in a problem file `[mesh] scale = {:?}`",
                1.0 / length
            ));
        }
        Ok(())
    }

    fn finish(mut self) -> Result<RawMesh, MeshError> {
        if self.raw.nodes.is_empty() {
            return Err(self.text.at().malformed("the end of the file", "a dataset 2411 of nodes"));
        }
        let mut makers = Groups::of(&self.raw);
        for (name, entities) in self.groups {
            let mut nodes = vec![];
            for [kind, id] in entities {
                match (kind, self.cells.get(&id)) {
                    (7, _) => nodes.extend(self.index.get(id)),
                    (8, Some((of_cell, is_facet))) => {
                        nodes.extend_from_slice(of_cell);
                        if *is_facet {
                            let corners = [of_cell[0], of_cell[1], of_cell[2]];
                            self.raw.facet_groups.entry(name.clone()).or_default().push(corners);
                        }
                    }
                    _ => {}
                }
            }
            makers.add_nodes(&mut self.raw, name, nodes)?;
        }
        for (words, count) in self.others {
            self.raw.notes.push(format!("{count} {words} were left out"));
        }
        self.raw.name_regions();
        Ok(self.raw)
    }
}

/// Kind of the elements of a type, and the places of our nodes in them, none where they are the same.
fn cell_kind(code: i64, nodes: usize) -> Option<(CellKind, &'static [usize])> {
    use CellKind::{Facet, OtherVolume, Solid};
    Some(match code {
        111 => (Solid(ElementKind::Tet4), &[]),
        118 => (Solid(ElementKind::Tet10), TET10),
        112 => (Solid(ElementKind::Wedge6), &[]),
        113 => (Solid(ElementKind::Wedge15), WEDGE15),
        115 => (Solid(ElementKind::Hex8), &[]),
        116 => (Solid(ElementKind::Hex20), HEX20),
        114 => (OtherVolume("cubic wedge", nodes), &[]),
        117 => (OtherVolume("cubic brick", nodes), &[]),
        // Membranes, plates and shells: faces of solids in files of mesh programs.
        41..=46 | 51..=56 | 61..=66 | 71..=76 | 81..=86 | 91..=96 | 101..=106 => match (code % 10, nodes) {
            (1, 3) => (Facet(FacetKind::Tri3), &[]),
            (2, 6) => (Facet(FacetKind::Tri6), TRI6),
            (4, 4) => (Facet(FacetKind::Quad4), &[]),
            (5, 8) => (Facet(FacetKind::Quad8), QUAD8),
            _ => return None,
        },
        _ => return None,
    })
}

/// Elements of a type that is not read.
fn words_of(code: i64) -> String {
    let name = match code {
        11 => "rods",
        21..=24 => "beams",
        31 | 32 => "pipes",
        121 | 122 => "rigid elements",
        136..=139 => "springs",
        141 | 142 => "dampers",
        161 => "lumped masses",
        _ => "elements",
    };
    format!("{name} of type {code}")
}
