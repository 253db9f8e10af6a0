//! Ports of a part, read of the sections of its file.

use crate::assembly::error::PartFault;
use crate::assembly::facet::{Facet, Nearest};
use crate::assembly::text::lines;
use crate::base::pose::Pose;
use vademecum_format::{
    File, Numbers, PORT_COLUMNS, PORT_FACET_NODES, PortKind, PortRange, SectionKind as S,
};

/// Numbers of a row of [`S::PortFrames`].
const FRAME: usize = 12;

/// Rows of a frame.
const MOTIONS: usize = 6;

/// Sections of the ports of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ports<'a> {
    names: &'a str,
    table: &'a [[[u8; 4]; PORT_COLUMNS]],
    frames: Option<Numbers<'a>>,
    nodes: &'a [[u8; 4]],
    facets: &'a [[u8; 4]],
    /// Rows of all ports.
    pub rows: usize,
}

/// A port at its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Port<'p> {
    pub kind: PortKind,
    /// Its first row among those of the part.
    pub first: usize,
    /// Number of its nodes.
    pub count: usize,
    /// Origin in the part, and axes.
    pub origin: [f64; 3],
    pub axes: [[f64; 3]; 3],
    nodes: &'p [[u8; 4]],
    facets: &'p [[u8; 4]],
}

fn missing(kind: S) -> PartFault {
    PartFault::Missing { kind }
}

impl<'a> Ports<'a> {
    /// Ports of a file, with every number that counts in a section compared with it.
    ///
    /// # Errors
    /// [`PartFault`].
    pub fn of(file: &File<'a>) -> Result<Self, PartFault> {
        let u32s = |kind| -> Result<&'a [[u8; 4]], PartFault> {
            Ok(file.section(kind).map(|section| section.u32s()).transpose()?.unwrap_or_default())
        };
        let table = file.port_table()?;
        let names = file.section(S::PortNames).map(|section| section.text()).transpose()?.unwrap_or("");
        let frames = file.section(S::PortFrames).map(|section| section.numbers()).transpose()?;
        let (nodes, facets) = (u32s(S::PortNodes)?, u32s(S::PortFacets)?);
        let rows = file.section(S::PortRows).map_or(0, |section| section.shape()[0]);
        let rows = usize::try_from(rows).map_err(|_| PartFault::Disagrees { kind: S::PortRows })?;
        if !table.is_empty() && file.section(S::PortRows).is_none() {
            return Err(missing(S::PortRows));
        }
        let ports = Self { names, table, frames, nodes, facets, rows };
        ports.check(file)?;
        Ok(ports)
    }

    fn check(&self, file: &File<'_>) -> Result<(), PartFault> {
        let fault = |kind| PartFault::Disagrees { kind };
        if self.frames.map_or(0, |frames| frames.len()) < FRAME.saturating_mul(self.table.len()) {
            return Err(fault(S::PortFrames));
        }
        if lines(self.names).count() != self.table.len() {
            return Err(fault(S::PortNames));
        }
        let surface = file.metadata().n_surface_nodes;
        let facets = self.facets.as_chunks::<PORT_FACET_NODES>().0;
        for row in self.table {
            let range = PortRange::of(row).ok_or(fault(S::PortTable))?;
            let within = |[first, count]: [usize; 2], all: usize| {
                first.checked_add(count).is_some_and(|end| end <= all)
            };
            let [facet, n_facets] = range.facets;
            let fits = within(range.rows, self.rows)
                && within(range.nodes, self.nodes.len())
                && within(range.facets, facets.len());
            if !fits {
                return Err(fault(S::PortTable));
            }
            let own = self.nodes.iter().skip(range.nodes[0]).take(range.nodes[1]);
            if own.clone().any(|node| u32::from_le_bytes(*node) >= surface) {
                return Err(fault(S::PortNodes));
            }
            for facet in facets.iter().skip(facet).take(n_facets) {
                let nodes = facet.map(u32::from_le_bytes);
                let count = nodes.iter().take_while(|node| **node != u32::MAX).count();
                let known = nodes.iter().take(count).all(|node| (*node as usize) < range.nodes[1]);
                if !known || !matches!(count, 3 | 4 | 6 | 8 | 9) {
                    return Err(fault(S::PortFacets));
                }
            }
        }
        for (kind, sides) in [
            (S::PortCompliance, [true, true]),
            (S::PortInertia, [true, true]),
            (S::PortResidual, [true, false]),
            (S::PortProbes, [true, false]),
            (S::PortPatterns, [true, false]),
        ] {
            let Some(section) = file.section(kind) else { continue };
            let [a, b, _] = section.shape();
            if (sides[0] && a != self.rows as u64) || (sides[1] && b != self.rows as u64) {
                return Err(fault(kind));
            }
        }
        Ok(())
    }

    /// Number of ports.
    pub const fn len(&self) -> usize {
        self.table.len()
    }

    /// The place of a port of this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        lines(self.names).position(|other| other == name)
    }

    /// The names.
    pub fn names(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        lines(self.names)
    }

    /// A port; `None` for one that there is not.
    pub fn get(&self, index: usize) -> Option<Port<'a>> {
        let range = PortRange::of(self.table.get(index)?)?;
        let frame = |k: usize| self.frames?.get(FRAME * index + k);
        let vector = |k: usize| Some([frame(k)?, frame(k + 1)?, frame(k + 2)?]);
        let [first, count] = range.nodes;
        let [facet, n_facets] = range.facets;
        let facets = self.facets.get(PORT_FACET_NODES * facet..PORT_FACET_NODES * (facet + n_facets))?;
        Some(Port {
            kind: range.kind,
            first: range.rows[0],
            count,
            origin: vector(0)?,
            axes: [vector(3)?, vector(6)?, vector(9)?],
            nodes: self.nodes.get(first..first + count)?,
            facets,
        })
    }
}

impl Port<'_> {
    /// The node of the file that is a node of the port.
    pub fn node(&self, index: usize) -> usize {
        self.nodes.get(index).map_or(usize::MAX, |node| u32::from_le_bytes(*node) as usize)
    }

    /// Its axes in space.
    pub fn placed_axes(&self, pose: &Pose) -> [[f64; 3]; 3] {
        self.axes.map(|axis| pose.turn(axis))
    }

    /// The place nearest to a point on its facets, which have their nodes at `place`: nodes of the port and
    /// their weights. `None` without facets.
    pub fn nearest(
        &self,
        point: [f64; 3],
        place: impl Fn(usize) -> [f64; 3],
    ) -> Option<([usize; PORT_FACET_NODES], Nearest)> {
        let mut best: Option<([usize; PORT_FACET_NODES], Nearest)> = None;
        for numbers in self.facets.as_chunks::<PORT_FACET_NODES>().0 {
            let nodes = numbers.map(u32::from_le_bytes);
            let count = nodes.iter().take_while(|node| **node != u32::MAX).count();
            let places = nodes.map(|node| if node == u32::MAX { [0.0; 3] } else { place(node as usize) });
            let Some(facet) = Facet::new(places.get(..count).unwrap_or_default()) else { continue };
            if best.is_some_and(|(_, best)| best.distance <= facet.least_distance(point)) {
                continue;
            }
            let found = facet.nearest(point);
            if best.is_none_or(|(_, best)| found.distance < best.distance) {
                best = Some((nodes.map(|node| node as usize), found));
            }
        }
        best
    }

    /// A row under a motion of the part before it is moved to its place: the motion of a point, and its
    /// rotation; `place` is that of a node of the file.
    pub fn row(
        &self,
        row: usize,
        place: impl Fn(usize) -> [f64; 3],
        moved: impl Fn([f64; 3]) -> [f64; 3],
        turned: [f64; 3],
    ) -> f64 {
        let component = |v: [f64; 3], k: usize| v.get(k).copied().unwrap_or(0.0);
        let along = |k: usize, v: [f64; 3]| self.axes.get(k).map_or(0.0, |a| crate::base::vec3::dot(*a, v));
        match (self.kind, row) {
            (PortKind::Patch, _) => component(moved(place(self.node(row / 3))), row % 3),
            (PortKind::Frame, 0..3) => along(row, moved(self.origin)),
            (PortKind::Frame, _) => along(row - 3, turned),
        }
    }

    /// Number of its rows.
    pub const fn rows(&self) -> usize {
        match self.kind {
            PortKind::Patch => 3 * self.count,
            PortKind::Frame => MOTIONS,
        }
    }
}
