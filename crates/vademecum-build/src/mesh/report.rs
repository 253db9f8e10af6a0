//! The report of `vademecum mesh FILE`.

use std::fmt;

use serde::Serialize;

use super::check::{CheckedMesh, check};
use super::quality::{corners, element_volume, quality};
use super::raw::RawMesh;
use super::{Mesh, Order, bounding_box};

/// Everything worth knowing about a mesh file, whether or not it can be computed with.
#[derive(Clone, Debug, Serialize)]
pub struct MeshReport {
    /// The file.
    pub file: String,
    /// Its format in words.
    pub format: String,
    /// Nodes in use.
    pub nodes: usize,
    /// Tetrahedra.
    pub elements: usize,
    /// Nodes of one element, 4 or 10.
    pub nodes_per_element: usize,
    /// Nodes that no tetrahedron uses; they are dropped.
    pub(crate) unused_nodes: usize,
    /// Elements that were inverted; they are reoriented.
    pub(crate) reoriented_elements: usize,
    /// Lower and upper corner of the bounding box, in the mesh's unit of length.
    pub(crate) bounding_box: [[f64; 3]; 2],
    /// Volume of all elements, in that unit cubed.
    pub volume: f64,
    /// Regions with their elements and volumes.
    pub regions: Vec<RegionReport>,
    /// Groups with their sizes.
    pub(crate) groups: Vec<GroupReport>,
    /// Shape quality of the elements.
    pub quality: QualityReport,
    /// Flaws that exclude a computation, in sentences; empty if the mesh is sound.
    pub problems: Vec<String>,
    /// Repairs and omissions, in sentences.
    pub(crate) notes: Vec<String>,
}

/// One region of a mesh.
#[derive(Clone, Debug, Serialize)]
pub struct RegionReport {
    /// Number in the file.
    pub(crate) tag: i64,
    /// Name.
    pub name: String,
    /// Its elements.
    pub elements: usize,
    /// Its volume.
    pub(crate) volume: f64,
}

/// One group of a mesh.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct GroupReport {
    /// Name.
    pub(crate) name: String,
    /// Its nodes.
    pub(crate) nodes: usize,
    /// Its facets, 0 for a pure node group.
    pub(crate) facets: usize,
}

/// Shape quality q = 6√2 V/L³ (L the longest edge; on the corners of quadratic elements).
#[derive(Clone, Debug, Serialize)]
pub struct QualityReport {
    /// Smallest.
    pub min: f64,
    /// Mean.
    pub mean: f64,
    /// Element counts for q in [0, 0.1), [0.1, 0.2), … [0.9, 1].
    pub(crate) histogram: [usize; 10],
    /// File numbers of the corner nodes of the worst element.
    pub(crate) worst: Option<[u64; 4]>,
}

/// Looks at a mesh without refusing it.
pub fn inspect(raw: &RawMesh) -> MeshReport {
    let CheckedMesh { mesh, problems, unused_nodes, reoriented } = check(raw);
    let (low, high) = bounding_box(&mesh.nodes);
    let regions = regions(&mesh);
    MeshReport {
        file: raw.file.display().to_string(),
        format: raw.format.clone(),
        nodes: mesh.nodes.len(),
        elements: mesh.element_region.len(),
        nodes_per_element: mesh.order.nodes_per_element(),
        unused_nodes,
        reoriented_elements: reoriented,
        bounding_box: [low, high],
        volume: regions.iter().map(|r| r.volume).sum(),
        regions,
        groups: groups(&mesh),
        quality: qualities(&mesh),
        problems: problems.iter().map(|p| p.to_string()).collect(),
        notes: mesh.notes.clone(),
    }
}

fn regions(mesh: &Mesh) -> Vec<RegionReport> {
    let empty =
        |r: &super::Region| RegionReport { tag: r.tag, name: r.name.clone(), elements: 0, volume: 0.0 };
    let mut out: Vec<RegionReport> = mesh.regions.iter().map(empty).collect();
    let elements = mesh.elements.chunks_exact(mesh.order.nodes_per_element());
    for (element, &region) in elements.zip(&mesh.element_region) {
        out[region as usize].elements += 1;
        out[region as usize].volume += element_volume(mesh.order, &mesh.nodes, element);
    }
    out
}

fn groups(mesh: &Mesh) -> Vec<GroupReport> {
    let facets = |name: &str| mesh.facet_groups.get(name).map_or(0, Vec::len);
    let group = |(name, nodes): (&String, &Vec<u32>)| GroupReport {
        name: name.clone(),
        nodes: nodes.len(),
        facets: facets(name),
    };
    mesh.node_groups.iter().map(group).collect()
}

fn qualities(mesh: &Mesh) -> QualityReport {
    let mut out = QualityReport { min: f64::INFINITY, mean: 0.0, histogram: [0; 10], worst: None };
    for element in mesh.elements.chunks_exact(mesh.order.nodes_per_element()) {
        let q = quality(corners(&mesh.nodes, element));
        out.histogram[((q * 10.0).max(0.0) as usize).min(9)] += 1;
        out.mean += q;
        if q < out.min {
            out.min = q;
            out.worst = Some(std::array::from_fn(|i| mesh.node_ids[element[i] as usize]));
        }
    }
    match mesh.element_region.len() {
        0 => out.min = 0.0,
        n => out.mean /= n as f64,
    }
    out
}

impl fmt::Display for MeshReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind =
            if self.nodes_per_element == Order::Linear.nodes_per_element() { "linear" } else { "quadratic" };
        let [low, high] = self.bounding_box;
        writeln!(f, "file          {}", self.file)?;
        writeln!(f, "format        {}", self.format)?;
        writeln!(f, "nodes         {} ({} unused)", self.nodes, self.unused_nodes)?;
        if self.elements == 0 {
            writeln!(f, "elements      none that a body is made of")?;
            return self.fmt_remarks(f);
        }
        let turned = self.reoriented_elements;
        writeln!(f, "elements      {} {kind} tetrahedra ({turned} reoriented)", self.elements)?;
        for (axis, k) in ["x", "y", "z"].into_iter().zip(0..) {
            writeln!(f, "{axis}             {:.6e} to {:.6e}", low[k], high[k])?;
        }
        writeln!(f, "volume        {:.6e}", self.volume)?;
        for r in &self.regions {
            writeln!(
                f,
                "region        {} (tag {}): {} elements, volume {:.6e}",
                r.name, r.tag, r.elements, r.volume
            )?;
        }
        for g in &self.groups {
            writeln!(f, "group         {}: {} nodes, {} facets", g.name, g.nodes, g.facets)?;
        }
        self.fmt_quality(f)?;
        self.fmt_remarks(f)
    }
}

impl MeshReport {
    fn fmt_remarks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for note in &self.notes {
            writeln!(f, "note          {note}")?;
        }
        for problem in &self.problems {
            writeln!(f, "problem       {problem}")?;
        }
        Ok(())
    }

    fn fmt_quality(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "quality       min {:.2e}, mean {:.3}", self.quality.min, self.quality.mean)?;
        let most = self.quality.histogram.iter().copied().max().unwrap_or(0).max(1);
        for (bin, &count) in self.quality.histogram.iter().enumerate() {
            let bar = "#".repeat((count * 40).div_ceil(most));
            let low = bin as f64 / 10.0;
            writeln!(f, "  {low:.1} to {:.1}  {count:>8} {bar}", low + 0.1)?;
        }
        Ok(())
    }
}
