//! The report of `vademecum mesh FILE`.

use std::fmt;

use serde::Serialize;

use super::check::{CheckedMesh, check};
use super::quality::{element_volume, shape_quality};
use super::raw::RawMesh;
use super::{ElementKind, Mesh, bounding_box};

/// Everything worth knowing about a mesh file, whether or not it can be computed with.
#[derive(Clone, Debug, Serialize)]
pub struct MeshReport {
    /// The file.
    pub file: String,
    /// Its format in words.
    pub format: String,
    /// Nodes in use.
    pub nodes: usize,
    /// Elements.
    pub elements: usize,
    /// Nodes of one element; 0 where elements of several kinds have several numbers.
    pub nodes_per_element: usize,
    /// Elements of each kind.
    pub(crate) kinds: Vec<KindReport>,
    /// Nodes that no element uses; they are dropped.
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

/// One kind of elements of a mesh.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct KindReport {
    /// Its name.
    pub(crate) kind: &'static str,
    /// Its elements.
    pub(crate) elements: usize,
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

/// Shape quality on the corners of elements: of tetrahedra q = 6√2 V/L³ (L the longest edge), of others the
/// least volume of three edges at a corner over the product of their lengths.
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
        nodes_per_element: mesh.kinds.uniform().map_or(0, ElementKind::nodes),
        kinds: kinds(&mesh),
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

fn kinds(mesh: &Mesh) -> Vec<KindReport> {
    let count = |kind: ElementKind| mesh.each().filter(|element| element.0 == kind).count();
    let report = |kind: ElementKind| KindReport { kind: kind.name(), elements: count(kind) };
    mesh.kinds.distinct().into_iter().map(report).collect()
}

fn regions(mesh: &Mesh) -> Vec<RegionReport> {
    let empty =
        |r: &super::Region| RegionReport { tag: r.tag, name: r.name.clone(), elements: 0, volume: 0.0 };
    let mut out: Vec<RegionReport> = mesh.regions.iter().map(empty).collect();
    for ((kind, element), &region) in mesh.each().zip(&mesh.element_region) {
        out[region as usize].elements += 1;
        out[region as usize].volume += element_volume(kind, &mesh.nodes, element);
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
    for (kind, element) in mesh.each() {
        let q = shape_quality(kind, &mesh.nodes, element);
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
        let [low, high] = self.bounding_box;
        writeln!(f, "file          {}", self.file)?;
        writeln!(f, "format        {}", self.format)?;
        writeln!(f, "nodes         {} ({} unused)", self.nodes, self.unused_nodes)?;
        if self.elements == 0 {
            writeln!(f, "elements      none that a body is made of")?;
            return self.fmt_remarks(f);
        }
        let turned = self.reoriented_elements;
        match self.nodes_per_element {
            4 => writeln!(f, "elements      {} linear tetrahedra ({turned} reoriented)", self.elements)?,
            10 => writeln!(f, "elements      {} quadratic tetrahedra ({turned} reoriented)", self.elements)?,
            _ => {
                writeln!(f, "elements      {} ({turned} reoriented)", self.elements)?;
                for KindReport { kind, elements: count } in &self.kinds {
                    writeln!(f, "              {count} × {kind}")?;
                }
            }
        }
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
