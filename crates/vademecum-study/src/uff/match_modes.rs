//! Modal assurance of modes that were measured: a universal file against the modes of a problem.

use std::collections::HashMap;
use std::io::Read as _;
use std::path::Path;

use faer::c64;
use vademecum_build::store::open_regular;

use super::error::UffError;
use super::read::{UniversalFile, UniversalMode};
use crate::modes::Shapes;

/// Modal assurance against measured modes.
#[derive(Debug)]
pub struct Matched {
    /// A row for each mode of the problem, a number for each measured one.
    pub assurance: Vec<Vec<f64>>,
    /// Frequencies of the measured modes \[Hz\].
    pub frequencies: Vec<f64>,
    /// Nodes that were measured.
    pub nodes: usize,
    /// Largest distance of one from its node of the mesh \[m\].
    pub distance: f64,
}

/// True of a file that begins as universal files do.
pub fn is_universal(path: &Path) -> bool {
    let mut head = [0; 256];
    let read = open_regular(path).and_then(|mut file| file.read(&mut head));
    let head = &head[..read.unwrap_or(0)];
    let text = String::from_utf8_lossy(head);
    text.lines().find(|line| !line.trim().is_empty()).is_some_and(|line| line.trim() == "-1")
}

impl Matched {
    /// Modal assurance criterion `|φᵀψ|² / (φᵀφ ψᴴψ)` of each mode of a problem with each measured one
    /// (Allemang and Brown 1982), over the components that were measured: those that some mode of the file
    /// moves. Each measured node is taken at the nearest node of the mesh.
    ///
    /// # Errors
    /// [`UffError`].
    pub fn new(path: &Path, shapes: &Shapes) -> Result<Self, UffError> {
        let file = UniversalFile::read(path)?;
        let missing = |what, dataset| UffError::Missing { file: path.to_path_buf(), what, dataset };
        if file.nodes.is_empty() {
            return Err(missing("nodes", "15 or 2411"));
        }
        if file.modes.is_empty() {
            return Err(missing("normal or complex modes", "55"));
        }
        let fields = shapes.fields();
        let mesh = &shapes.mesh().nodes;
        let size = extent(mesh);
        // Labels, the node of the mesh and the components of each measured node.
        let (mut places, mut distance) = (vec![], 0.0_f64);
        let moved = moved(&file.modes);
        for &(label, at, system) in &file.nodes {
            let measured: Vec<usize> =
                moved.get(&label).map_or(vec![], |moves| (0..3).filter(|&c| moves[c]).collect());
            if measured.is_empty() {
                continue;
            }
            if !(0..=1).contains(&system) {
                return Err(UffError::LocalAxes { file: path.to_path_buf(), node: label, system });
            }
            let square = |node: &[f64; 3]| (0..3).map(|c| (node[c] - at[c]).powi(2)).sum::<f64>();
            let nearest = mesh.iter().enumerate().min_by(|a, b| square(a.1).total_cmp(&square(b.1)));
            let Some((node, place)) = nearest else { continue };
            let apart = square(place).sqrt();
            if apart > size {
                return Err(UffError::FarNode {
                    file: path.to_path_buf(),
                    node: label,
                    distance: apart,
                    size,
                });
            }
            distance = distance.max(apart);
            places.extend(measured.into_iter().map(|c| (label, 3 * node + c, c)));
        }
        let measured: Vec<Vec<c64>> = file.modes.iter().map(|mode| along(mode, &places)).collect();
        let row = |field: &Vec<f64>| -> Vec<f64> {
            let own: Vec<f64> = places.iter().map(|(_, dof, _)| field[*dof]).collect();
            measured.iter().map(|other| assurance(&own, other)).collect()
        };
        let mut nodes: Vec<u64> = places.iter().map(|(label, ..)| *label).collect();
        nodes.dedup();
        Ok(Self {
            assurance: fields.iter().map(row).collect(),
            frequencies: file.modes.iter().map(|mode| mode.frequency).collect(),
            nodes: nodes.len(),
            distance,
        })
    }
}

/// Components of each node that some mode moves.
fn moved(modes: &[UniversalMode]) -> HashMap<u64, [bool; 3]> {
    let mut moved = HashMap::new();
    for (label, displacement) in modes.iter().flat_map(|mode| &mode.shape) {
        let known = moved.entry(*label).or_insert([false; 3]);
        known.iter_mut().zip(displacement).for_each(|(known, part)| *known |= part.norm() > 0.0);
    }
    moved
}

/// Displacements of a measured mode at components of nodes; zero where it has none.
fn along(mode: &UniversalMode, places: &[(u64, usize, usize)]) -> Vec<c64> {
    let known: HashMap<u64, [c64; 3]> = mode.shape.iter().copied().collect();
    let zero = [c64::new(0.0, 0.0); 3];
    places.iter().map(|(label, _, c)| known.get(label).unwrap_or(&zero)[*c]).collect()
}

fn assurance(own: &[f64], other: &[c64]) -> f64 {
    let product = own.iter().zip(other).fold(c64::new(0.0, 0.0), |sum, (a, b)| sum + *b * *a);
    let size = own.iter().map(|a| a * a).sum::<f64>() * other.iter().map(c64::norm_sqr).sum::<f64>();
    if size > 0.0 { product.norm_sqr() / size } else { 0.0 }
}

/// Largest extent along an axis.
fn extent(nodes: &[[f64; 3]]) -> f64 {
    let along = |c: usize| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        nodes.iter().for_each(|node| (low, high) = (low.min(node[c]), high.max(node[c])));
        high - low
    };
    (0..3).map(along).fold(0.0, f64::max)
}
