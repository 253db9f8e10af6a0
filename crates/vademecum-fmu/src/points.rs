//! `points.bin`: the named points of an FMU, located once at export, so that the instance searches nothing.
//!
//! ```text
//! 8 bytes   "VDMFMU04"
//! 8 bytes   number of points (u64)
//! 8 bytes   number of surface nodes (u64)
//! then for each point 264 bytes:
//!   4       number of its nodes (u32)
//!   16 × 4  nodes (u32)         16 × 8   weights (f64), zeros behind those that it has
//!   4       length of the name (u32)      64   name in UTF-8, the rest zeros
//! then for each surface node 4 bytes: its number in file order (u32)
//! then for each place whose stress is reported 72 bytes, up to the end:
//!   4       node (u32)
//!   4       length of the name (u32)      64   name in UTF-8, the rest zeros
//! ```
//!
//! All numbers are little-endian.

use crate::bytes::Cursor;
use vademecum_eval::{MAX_PLACE_NODES, Place};

/// First bytes of the table.
pub const MAGIC: [u8; 8] = *b"VDMFMU04";
/// Most bytes of a name.
pub const LONGEST_NAME: usize = 64;
/// Most points of an FMU, and most nodes of its arrays.
pub const MOST: usize = 4096;
/// Bytes of one point.
const RECORD: usize = 8 + 12 * MAX_PLACE_NODES + LONGEST_NAME;
/// Bytes of one place of a stress.
const STRESS_RECORD: usize = 72;

/// A named point of the loadable surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<'a> {
    /// Its name.
    pub name: &'a str,
    /// Nodes of its facet, in file order, and their shares.
    pub place: Place,
}

/// A named place whose stress is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StressPlace<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its node, in file order.
    pub node: u32,
}

/// The table.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    records: &'a [[u8; RECORD]],
    /// Nodes of the arrays.
    surface: &'a [[u8; 4]],
    stresses: &'a [[u8; STRESS_RECORD]],
}

impl<'a> Points<'a> {
    /// The table in these bytes, if it is one and all of its points could be points of a file with so many
    /// loadable nodes.
    #[must_use]
    pub fn parse(bytes: &'a [u8], n_load_nodes: u32) -> Option<Self> {
        let rest = bytes.strip_prefix(&MAGIC)?;
        let (count, rest) = rest.split_first_chunk()?;
        let count = usize::try_from(u64::from_le_bytes(*count)).ok()?;
        let (nodes, rest) = rest.split_first_chunk()?;
        let nodes = usize::try_from(u64::from_le_bytes(*nodes)).ok()?;
        let (points, rest) = rest.split_at_checked(count.checked_mul(RECORD)?)?;
        let (surface, rest) = rest.split_at_checked(nodes.checked_mul(4)?)?;
        let ((records, _), (stresses, behind)) = (points.as_chunks(), rest.as_chunks());
        let points = Self { records, surface: surface.as_chunks().0, stresses };
        let placed = (0..stresses.len()).all(|index| points.stress(index).is_some());
        let counted = placed && stresses.len() <= MOST && behind.is_empty();
        let sound = |point: Option<Point<'_>>| {
            point.is_some_and(|point| point.place.nodes().iter().all(|&node| node < n_load_nodes))
        };
        let few = records.len() <= MOST && nodes <= MOST;
        let all = few && (0..points.len()).all(|index| sound(points.get(index)));
        (counted && all).then_some(points)
    }

    /// Number of places where forces act: named points, then surface nodes.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.records.len() + self.surface.len()
    }

    /// Number of named points.
    #[must_use]
    pub const fn named(&self) -> usize {
        self.records.len()
    }

    /// Number of surface nodes.
    #[must_use]
    pub const fn surface(&self) -> usize {
        self.surface.len()
    }

    /// True without places.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of places with a stress.
    #[must_use]
    pub const fn stresses(&self) -> usize {
        self.stresses.len()
    }

    /// One of them.
    #[must_use]
    pub fn stress(&self, index: usize) -> Option<StressPlace<'a>> {
        let mut record = Cursor::new(self.stresses.get(index)?);
        let (node, length) = (record.u32()?, record.u32()? as usize);
        let name = core::str::from_utf8(record.take(length)?).ok()?;
        Some(StressPlace { name, node })
    }

    /// One of the places; a surface node has no name.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<Point<'a>> {
        if let Some(index) = index.checked_sub(self.records.len()) {
            let node = u32::from_le_bytes(*self.surface.get(index)?);
            return Some(Point { name: "", place: Place::new(&[node], &[1.0]).ok()? });
        }
        let mut record = Cursor::new(self.records.get(index)?);
        let count = record.u32()? as usize;
        let mut nodes = [0; MAX_PLACE_NODES];
        for node in &mut nodes {
            *node = record.u32()?;
        }
        let mut weights = [0.0; MAX_PLACE_NODES];
        record.numbers(&mut weights)?;
        let place = Place::new(nodes.get(..count)?, weights.get(..count)?).ok()?;
        let length = record.u32()? as usize;
        let name = core::str::from_utf8(record.take(length)?).ok()?;
        Some(Point { name, place })
    }
}

/// The table of these points, surface nodes and places; `None` if a name is too long or there are too many of
/// them.
#[cfg(not(feature = "bare"))]
#[must_use]
pub fn table(points: &[Point<'_>], surface: &[u32], stresses: &[StressPlace<'_>]) -> Option<Vec<u8>> {
    let mut names = points.iter().map(|point| point.name).chain(stresses.iter().map(|place| place.name));
    if points.len().max(surface.len()).max(stresses.len()) > MOST
        || names.any(|name| name.len() > LONGEST_NAME)
    {
        return None;
    }
    let mut bytes = MAGIC.to_vec();
    bytes.extend((points.len() as u64).to_le_bytes());
    bytes.extend((surface.len() as u64).to_le_bytes());
    for Point { name, place } in points {
        let start = bytes.len();
        bytes.extend((place.nodes().len() as u32).to_le_bytes());
        place.nodes().iter().for_each(|node| bytes.extend(node.to_le_bytes()));
        bytes.resize(start + 4 + 4 * MAX_PLACE_NODES, 0);
        place.weights().iter().for_each(|weight| bytes.extend(weight.to_le_bytes()));
        bytes.resize(start + 4 + 12 * MAX_PLACE_NODES, 0);
        bytes.extend((name.len() as u32).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.resize(start + RECORD, 0);
    }
    surface.iter().for_each(|node| bytes.extend(node.to_le_bytes()));
    for StressPlace { name, node } in stresses {
        let start = bytes.len();
        bytes.extend(node.to_le_bytes());
        bytes.extend((name.len() as u32).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.resize(start + STRESS_RECORD, 0);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::{MAGIC, Point, Points, StressPlace, table};
    use vademecum_eval::Place;

    #[test]
    fn a_table_is_read_back_and_a_damaged_one_is_refused() {
        let tip = Place::new(&[4, 0, 2, 3], &[0.25, 0.5, 0.125, 0.125]).expect("a place");
        let tip = Point { name: "tip", place: tip };
        let root = Point { name: "fuß", place: Place::triangle([1, 1, 1], [1.0, 0.0, 0.0]) };
        let hole = StressPlace { name: "hole", node: 77 };
        let bytes = table(&[tip, root], &[3, 0], &[hole]).expect("short names");
        let points = Points::parse(&bytes, 5).expect("its own table");
        assert_eq!((points.stresses(), points.stress(0), points.stress(1)), (1, Some(hole), None));
        assert_eq!((points.named(), points.get(0), points.get(1)), (2, Some(tip), Some(root)));
        let corner = Place::new(&[3], &[1.0]).expect("a place");
        assert_eq!((points.surface(), points.get(2)), (2, Some(Point { name: "", place: corner })));
        assert_eq!((points.len(), points.get(4)), (4, None));
        assert!(Points::parse(&bytes, 4).is_none(), "node 4 of 4");
        for end in 0..bytes.len() {
            // Where the places are cut off whole, a table without any is left.
            let whole = end == bytes.len() - 72;
            assert_eq!(Points::parse(&bytes[..end], 5).is_some(), whole, "cut at {end}");
        }
        // Magic, counts, nodes of the first point, its first weight, length of its name, the name, a node of
        // the surface.
        let of_first = [(24, 17), (24 + 75, 0xff), (24 + 196, 65), (24 + 200, 0xff)];
        for (place, value) in [(0, b'X'), (8, 3), (16, 3), (24 + 2 * 264, 9)].into_iter().chain(of_first) {
            let mut damaged = bytes.clone();
            damaged[place] = value;
            assert!(Points::parse(&damaged, 5).is_none(), "byte {place}");
        }
        assert!(Points::parse(&[&MAGIC[..], &[0; 16]].concat(), 0).is_some_and(|none| none.is_empty()));
    }
}
