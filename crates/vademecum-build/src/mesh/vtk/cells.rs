//! Common parts of legacy VTK and VTU files: cell types, and the mesh made of their arrays.

use crate::mesh::error::{FaultSite, MeshError};
use crate::mesh::place::Location;
use crate::mesh::raw::{CellKind, RawMesh};
use crate::mesh::{ElementKind, FacetKind};

/// Names under which programs store the material of a cell.
const REGION_NAMES: [&str; 12] = [
    "material",
    "mat_id",
    "mat",
    "materialid",
    "material_id",
    "region",
    "region_id",
    "regionid",
    "attribute",
    "medit:ref",
    "gmsh:physical",
    "cellentityids",
];

/// Names under which programs store the group of a node.
const NODE_GROUP_NAMES: [&str; 3] = ["node_groups", "node_group", "group"];

/// The arrays of an unstructured grid.
#[derive(Default)]
pub(crate) struct Grid {
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) connectivity: Vec<i64>,
    /// End of each cell in `connectivity`.
    pub(crate) offsets: Vec<i64>,
    pub(crate) types: Vec<i64>,
    /// Integer data with one value per cell.
    pub(crate) cell_data: Vec<(String, Vec<i64>)>,
    /// Integer data with one value per point.
    pub(crate) point_data: Vec<(String, Vec<i64>)>,
}

/// VTK's cell type numbers (`vtkCellType.h`). Our quadratic order is VTK's.
fn cell_kind(code: i64, nodes: usize) -> Option<CellKind> {
    use CellKind::{Line, OtherSurface, OtherVolume};
    Some(match code {
        0 => Line(nodes),
        1 => CellKind::Point,
        2 | 3 | 4 | 21 | 35 | 68 => Line(nodes),
        5 => CellKind::Facet(FacetKind::Tri3),
        6 => OtherSurface("triangle strip", nodes),
        7 => OtherSurface("polygon", nodes),
        8 | 9 => CellKind::Facet(FacetKind::Quad4),
        10 => CellKind::Solid(ElementKind::Tet4),
        11 | 12 => CellKind::Solid(ElementKind::Hex8),
        13 => CellKind::Solid(ElementKind::Wedge6),
        14 => CellKind::Solid(ElementKind::Pyramid5),
        15 | 16 => OtherVolume("prism", nodes),
        22 => CellKind::Facet(FacetKind::Tri6),
        23 => CellKind::Facet(FacetKind::Quad8),
        28 => CellKind::Facet(FacetKind::Quad9),
        30 | 36 => OtherSurface("quadratic polygon", nodes),
        24 => CellKind::Solid(ElementKind::Tet10),
        25 => CellKind::Solid(ElementKind::Hex20),
        26 => CellKind::Solid(ElementKind::Wedge15),
        31 | 32 => OtherVolume("quadratic wedge", nodes),
        27 => CellKind::Solid(ElementKind::Pyramid13),
        37 => OtherVolume("quadratic pyramid", nodes),
        29 => CellKind::Solid(ElementKind::Hex27),
        33 => OtherVolume("24-node hexahedron", nodes),
        34 => OtherSurface("7-node triangle", 7),
        42 => OtherVolume("polyhedron", nodes),
        69 | 70 | 75 | 76 => OtherSurface("high-order surface cell", nodes),
        71 | 78 => OtherVolume("high-order tetrahedron", nodes),
        72 | 73 | 74 | 79 | 80 | 81 => OtherVolume("high-order volume cell", nodes),
        _ => return None,
    })
}

/// Builds the mesh from the arrays of a grid; faults are placed at `at`.
pub(crate) fn build(mut raw: RawMesh, grid: &Grid, at: &FaultSite<'_>) -> Result<RawMesh, MeshError> {
    if grid.types.len() != grid.offsets.len() {
        let found = format!("{} cell types", grid.types.len());
        return Err(at.malformed(found, format!("one for each of {} cells", grid.offsets.len())));
    }
    raw.nodes.clone_from(&grid.points);
    raw.node_ids = (0..grid.points.len() as u64).collect();
    node_groups(&mut raw, grid);
    let region = grid.cell_data.iter().find(|(name, values)| {
        REGION_NAMES.contains(&name.to_ascii_lowercase().as_str()) && values.len() == grid.types.len()
    });
    if let Some((name, _)) = region {
        raw.notes.push(format!("regions were taken from the cell data `{name}`"));
    }
    let mut start = 0;
    for (cell, (&end, &code)) in grid.offsets.iter().zip(&grid.types).enumerate() {
        let mut nodes = cell_nodes(grid, start, end, cell, at)?;
        let kind = cell_kind(code, nodes.len()).ok_or_else(|| {
            at.unsupported(
                format!("cell type {code} of cell {cell}"),
                "a VTK cell type",
                "convert to tetrahedra",
            )
        })?;
        if nodes.len() != kind.node_count() {
            let found = format!("{} nodes of cell {cell}, type {code}", nodes.len());
            return Err(at.malformed(found, format!("{} nodes", kind.node_count())));
        }
        match code {
            // Pixels and voxels run through their corners row by row.
            8 => nodes.swap(2, 3),
            11 => {
                nodes.swap(2, 3);
                nodes.swap(6, 7);
            }
            _ => {}
        }
        let value = region.map_or(0, |(_, values)| values[cell]);
        let grouped = region.is_some() && (kind.dimension() == 3 || value != 0);
        let tags = [value];
        raw.push(kind, &nodes, if grouped { &tags } else { &[] }, Location::Cell(cell));
        start = end;
    }
    raw.name_regions();
    Ok(raw)
}

fn cell_nodes(
    grid: &Grid,
    start: i64,
    end: i64,
    cell: usize,
    at: &FaultSite<'_>,
) -> Result<Vec<u32>, MeshError> {
    let range = usize::try_from(start).ok().zip(usize::try_from(end).ok());
    let nodes = range.and_then(|(a, b)| grid.connectivity.get(a..b)).ok_or_else(|| {
        let found = format!("cell {cell} from {start} to {end}");
        at.malformed(found, format!("ascending offsets up to {}", grid.connectivity.len()))
    })?;
    let valid = |n: &i64| u32::try_from(*n).ok().filter(|n| (*n as usize) < grid.points.len());
    nodes
        .iter()
        .map(|n| {
            valid(n).ok_or_else(|| {
                at.malformed(
                    format!("node {n} in cell {cell}"),
                    format!("0 to {}", grid.points.len().saturating_sub(1)),
                )
            })
        })
        .collect()
}

fn node_groups(raw: &mut RawMesh, grid: &Grid) {
    for (name, values) in &grid.point_data {
        let known = NODE_GROUP_NAMES.contains(&name.to_ascii_lowercase().as_str());
        if !known || values.len() != grid.points.len() {
            continue;
        }
        for (&value, node) in values.iter().zip(0..) {
            if value != 0 {
                raw.node_groups.entry(format!("vertices {value}")).or_default().push(node);
            }
        }
    }
}
