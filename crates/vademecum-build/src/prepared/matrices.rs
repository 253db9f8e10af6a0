//! From the matrices of another program to a model: which row is which dof, where the nodes lie, what the
//! surface is.
//!
//! The model has nodes and no elements. Rows may come in any order; they are renamed to the order of the
//! dofs, node by node. A dof without a row is held.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::fem::{Pencil, PencilError};
use crate::field::{self, DofRow, FieldError, MarketMatrix, PointRow};
use crate::input::{MatricesSource, Problem};
use crate::mesh::{Fault, Location, Mesh, Order, Region, bounding_box};
use crate::prepared::inertia::Inertia;

/// Name of the only region.
const REGION: &str = "body";

/// The place of a node may differ between two lines by this share of the body's size: many programs write
/// single precision.
const SAME_PLACE: f64 = 1e-6;

/// Why matrices and tables make no model.
#[derive(Debug, thiserror::Error)]
pub enum MatricesError {
    /// A file cannot be read, or contradicts another one.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A matrix of another size.
    #[error("{}: {found} rows; expected {expected}, as {} has", .file.display(), .dofs.display())]
    Size {
        /// The matrix.
        file: PathBuf,
        /// Its rows.
        found: usize,
        /// The table of the rows.
        dofs: PathBuf,
        /// Its rows.
        expected: usize,
    },
    /// The two matrices make no pencil.
    #[error("mass and stiffness do not fit each other")]
    Pencil(#[from] PencilError),
    /// More nodes than can be counted.
    #[error("{}: {nodes} nodes are more than a file can hold", .file.display())]
    TooManyNodes {
        /// The table of the nodes.
        file: PathBuf,
        /// Its nodes.
        nodes: usize,
    },
}

/// Content of the files of `mesh.matrices`.
#[derive(Clone, Debug)]
pub(crate) struct MatrixModel {
    /// Nodes without elements, in one region.
    pub(crate) mesh: Mesh,
    /// True if each dof is held, three per node.
    pub(crate) constrained: Vec<bool>,
    /// The matrices, one row per free dof, ascending.
    pub(crate) pencil: Pencil,
    /// Triangles of the surface by mesh node; none without their table.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl MatrixModel {
    /// Reads the files.
    ///
    /// # Errors
    /// [`MatricesError`], by file and line where there is one.
    pub(crate) fn read(problem: &Problem, source: &MatricesSource) -> Result<Self, MatricesError> {
        let dofs_file = problem.resolve(&source.dofs);
        let rows = in_order(&dofs_file, field::read_dofs(&dofs_file)?)?;
        let nodes = match &source.nodes {
            Some(path) => NodeTable::new(problem.resolve(path), field::read_points(&problem.resolve(path))?)?,
            None => NodeTable::of_rows(dofs_file.clone(), &rows)?,
        };
        let dof_of_row = nodes.dofs_of(&dofs_file, &rows)?;
        let mut constrained = vec![true; 3 * nodes.points.len()];
        dof_of_row.iter().for_each(|&dof| constrained[dof as usize] = false);
        let name = ranks(&dof_of_row);
        let matrix = |path: &Path| -> Result<MarketMatrix, MatricesError> {
            let file = problem.resolve(path);
            let matrix = field::read_matrix_market(&file)?;
            let (found, expected) = (matrix.n, rows.len());
            let size = |file| MatricesError::Size { file, found, dofs: dofs_file.clone(), expected };
            if found == expected { Ok(matrix) } else { Err(size(file)) }
        };
        // One after the other, so that the text of only one file is in memory.
        let mass = matrix(&source.mass)?.both_triangles(&name);
        let stiffness = matrix(&source.stiffness)?.both_triangles(&name);
        let pencil = Pencil::from_triplets(rows.len(), &mass, &stiffness)?;
        let mut mesh = nodes.mesh(problem.mesh.scale);
        mesh.notes = Inertia::of(&mass, &constrained, &mesh.nodes).notes();
        let triangles = match &source.triangles {
            Some(path) => nodes.triangles(&problem.resolve(path))?,
            None => vec![],
        };
        Ok(Self { mesh, constrained, pencil, triangles })
    }
}

/// The rows of the table in the order of the matrices; every row once.
fn in_order(file: &Path, mut rows: Vec<DofRow>) -> Result<Vec<DofRow>, FieldError> {
    rows.sort_by_key(|row| row.row);
    let n = rows.len() as u64;
    for (expected, row) in (0..).zip(&rows) {
        if row.row != expected {
            let found = format!("row {}", row.row);
            let expected = format!("each of the rows 0 to {} once; row {expected} is next", n - 1);
            return Err(contradiction(file, row.line, found, expected));
        }
    }
    Ok(rows)
}

/// Place of each dof among all of them, ascending: what the rows of the matrices are called in the model.
fn ranks(dof_of_row: &[u32]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..dof_of_row.len() as u32).collect();
    order.sort_unstable_by_key(|&row| dof_of_row[row as usize]);
    let mut rank = vec![0; order.len()];
    order.iter().zip(0..).for_each(|(&row, place)| rank[row as usize] = place);
    rank
}

/// Nodes in their order, found again by number.
struct NodeTable {
    file: PathBuf,
    points: Vec<PointRow>,
    by_id: HashMap<u64, u32>,
}

impl NodeTable {
    /// Every number once.
    fn new(file: PathBuf, points: Vec<PointRow>) -> Result<Self, MatricesError> {
        if points.len() > vademecum_format::MAX_NODES as usize {
            return Err(MatricesError::TooManyNodes { file, nodes: points.len() });
        }
        let mut by_id = HashMap::with_capacity(points.len());
        for (point, place) in points.iter().zip(0..) {
            if by_id.insert(point.node, place).is_some() {
                let found = format!("node {} a second time", point.node);
                return Err(contradiction(&file, point.line, found, "every node once").into());
            }
        }
        Ok(Self { file, points, by_id })
    }

    /// The nodes of the rows, each where its first row has it.
    fn of_rows(file: PathBuf, rows: &[DofRow]) -> Result<Self, MatricesError> {
        let mut seen = std::collections::HashSet::new();
        let first = rows.iter().filter(|row| seen.insert(row.node));
        let point = |row: &DofRow| PointRow { node: row.node, position: row.position, line: row.line };
        Self::new(file, first.map(point).collect())
    }

    /// Dof of each row: `3 · node + component`, every one once.
    fn dofs_of(&self, file: &Path, rows: &[DofRow]) -> Result<Vec<u32>, FieldError> {
        let positions: Vec<[f64; 3]> = self.points.iter().map(|point| point.position).collect();
        let (low, high) = bounding_box(&positions);
        let tolerance = SAME_PLACE * distance(low, high);
        let mut taken = vec![false; 3 * self.points.len()];
        let dof = |row: &DofRow| {
            let refused = |found: String, expected: String| contradiction(file, row.line, found, expected);
            let Some(&node) = self.by_id.get(&row.node) else {
                let expected = format!("a node of {}", self.file.display());
                return Err(refused(format!("node {}", row.node), expected));
            };
            let known = self.points[node as usize];
            // An infinite distance of huge coordinates is refused too.
            let same_place = distance(known.position, row.position) <= tolerance;
            if !same_place {
                let found = format!("node {} at {:?}", row.node, row.position);
                let expected =
                    format!("{:?}, as line {} of {} has it", known.position, known.line, self.file.display());
                return Err(refused(found, expected));
            }
            let dof = 3 * node as usize + row.component;
            if std::mem::replace(&mut taken[dof], true) {
                let component = ["x", "y", "z"][row.component];
                let found = format!("component {component} of node {} a second time", row.node);
                return Err(refused(found, "one row per component".into()));
            }
            Ok(dof as u32)
        };
        rows.iter().map(dof).collect()
    }

    fn triangles(&self, file: &Path) -> Result<Vec<[u32; 3]>, FieldError> {
        let mut triangles = vec![];
        for row in field::read_triangles(file)? {
            let [a, b, c] = row.nodes.map(|id| self.by_id.get(&id).copied().ok_or(id));
            let corner = |corner: Result<u32, u64>| {
                corner.map_err(|id| {
                    let expected = format!("a node of {}", self.file.display());
                    contradiction(file, row.line, format!("node {id}"), expected)
                })
            };
            triangles.push([corner(a)?, corner(b)?, corner(c)?]);
        }
        Ok(triangles)
    }

    fn mesh(&self, scale: f64) -> Mesh {
        Mesh {
            nodes: self.points.iter().map(|point| point.position.map(|x| scale * x)).collect(),
            node_ids: self.points.iter().map(|point| point.node).collect(),
            kinds: Order::Linear.into(),
            elements: vec![],
            element_region: vec![],
            regions: vec![Region::new(1, REGION)],
            node_groups: Default::default(),
            facet_groups: Default::default(),
            notes: vec![],
        }
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

/// Two lines that do not fit each other.
fn contradiction(file: &Path, line: usize, found: String, expected: impl Into<String>) -> FieldError {
    FieldError::Faulty(Box::new(Fault {
        file: file.to_path_buf(),
        place: Location::Line(line),
        section: "the table".into(),
        found,
        expected: expected.into(),
        remedy: "write matrices and tables again from one model; formats/matrices-1.md has the columns"
            .into(),
    }))
}
