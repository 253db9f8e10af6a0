//! Motions of a body under which no element, spring or foundation is strained, and no constraint is violated.
//!
//! In such a motion every part of the mesh moves as a rigid body, and every motion of a reference point is
//! one for itself. Constraints, held dofs and forces of springs are rows over these few unknowns: what no row
//! sees costs no energy.

use std::collections::BTreeSet;

use faer::Mat;

use super::blocks::Block;
use super::coupling::rigid_row;
use super::elimination::Constraints;
use crate::linalg::vec3::sub;
use crate::linalg::{NoConvergence, symmetric_eigen};

/// Motions of a rigid body: three shifts and three turns.
pub(super) const MOTIONS: usize = 6;

/// A row that sees less than this share of its terms is rounding.
const ROUNDING: f64 = 1e-9;

/// A motion is free if the rows see less than this share of the largest, in the square.
const UNSEEN: f64 = 1e-13;

/// Unknowns up to which mechanisms are looked for: beyond, a factorisation finds them.
const MOST_UNKNOWNS: usize = 900;

/// Dofs of a body: three for each node of its mesh, then six for each reference point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places<'a> {
    /// Nodes of the mesh.
    pub nodes: &'a [[f64; 3]],
    /// Reference points.
    pub points: &'a [[f64; 3]],
}

impl Places<'_> {
    /// Number of dofs of the mesh.
    pub(super) fn of_mesh(&self) -> usize {
        3 * self.nodes.len()
    }

    /// A dof under three shifts along the axes of space and three turns about a point.
    ///
    /// # Panics
    /// If there is no such dof.
    pub(super) fn row(&self, dof: u32, about: [f64; 3]) -> [f64; MOTIONS] {
        let dof = dof as usize;
        match dof.checked_sub(self.of_mesh()) {
            None => rigid_row(sub(self.nodes[dof / 3], about), dof % 3),
            Some(own) if own % MOTIONS < 3 => {
                rigid_row(sub(self.points[own / MOTIONS], about), own % MOTIONS)
            }
            Some(own) => std::array::from_fn(|k| f64::from(u8::from(k == own % MOTIONS))),
        }
    }
}

/// Freedom of a body as a whole: its holds, and the motions they leave.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Freedom {
    /// Rigid motions of the whole body that nothing sees.
    pub rigid: usize,
    /// Motions among `shift along x` … `turn about z` (through the middle of the body) that nothing sees.
    pub named: Vec<&'static str>,
    /// The first constraint, held dof or stiffness that sees one of them.
    pub holder: Option<String>,
    /// All motions without energy, if there are few enough unknowns to tell.
    pub all: Option<usize>,
}

const NAMES: [&str; MOTIONS] =
    ["shift along x", "shift along y", "shift along z", "turn about x", "turn about y", "turn about z"];

/// Rows over the unknowns: six for each part, then one for each motion of a reference point.
struct Rows<'a> {
    places: Places<'a>,
    /// Part of each node.
    part: Vec<u32>,
    parts: usize,
    middle: [f64; 3],
    size: f64,
    /// `Σ rᵀr` over the unknowns, if there are few.
    gram: Option<Mat<f64>>,
    /// The same for one rigid motion of everything.
    whole: Mat<f64>,
    holder: Option<String>,
}

impl Rows<'_> {
    /// A dof under the motions of the whole body, with turns by arms of its size.
    fn motion(&self, dof: u32) -> [f64; MOTIONS] {
        let mut row = self.places.row(dof, self.middle);
        row[3..].iter_mut().for_each(|turn| *turn /= self.size);
        row
    }

    /// Largest of them.
    fn weight(&self, dof: u32) -> f64 {
        self.motion(dof).into_iter().fold(0.0, |most, x| most.max(x.abs()))
    }

    /// Takes a row `Σ a u` in.
    fn take(&mut self, terms: &[(u32, f64)], scale: f64, holder: impl FnOnce() -> String) {
        if scale.is_nan() || scale <= 0.0 {
            return;
        }
        let mut whole = [0.0; MOTIONS];
        let mut own: Vec<(usize, f64)> = vec![];
        for &(dof, a) in terms {
            let (a, motion) = (a / scale, self.motion(dof));
            (0..MOTIONS).for_each(|k| whole[k] += a * motion[k]);
            match (dof as usize).checked_sub(self.places.of_mesh()) {
                None => {
                    let first = MOTIONS * self.part[dof as usize / 3] as usize;
                    own.extend((0..MOTIONS).map(|k| (first + k, a * motion[k])));
                }
                Some(place) => own.push((MOTIONS * self.parts + place, a * self.weight(dof))),
            }
        }
        if let Some(gram) = &mut self.gram {
            own.sort_unstable_by_key(|term| term.0);
            let mut row: Vec<(usize, f64)> = vec![];
            for (place, a) in own {
                match row.last_mut().filter(|last| last.0 == place) {
                    Some(last) => last.1 += a,
                    None => row.push((place, a)),
                }
            }
            row.retain(|term| term.1.abs() > ROUNDING);
            for &(i, a) in &row {
                row.iter().for_each(|&(j, b)| gram[(i, j)] += a * b);
            }
        }
        whole.iter_mut().filter(|x| x.abs() <= ROUNDING).for_each(|x| *x = 0.0);
        if whole.iter().any(|x| *x != 0.0) {
            (0..MOTIONS).for_each(|i| (0..MOTIONS).for_each(|j| self.whole[(i, j)] += whole[i] * whole[j]));
            self.holder.get_or_insert_with(holder);
        }
    }

    /// Takes the forces of a stiffness, or of a damping, in.
    fn take_block(&mut self, dofs: &[u32], matrix: &Mat<f64>, holder: &str) {
        let weights: Vec<f64> = dofs.iter().map(|&dof| self.weight(dof)).collect();
        let share = |i: usize, j: usize| weights[i] * matrix[(i, j)].abs() * weights[j];
        let n = dofs.len();
        let scale = (0..n).map(|i| (0..n).map(|j| share(i, j)).sum()).fold(0.0, f64::max);
        for i in 0..n {
            let terms = (0..n).map(|j| (dofs[j], weights[i] * matrix[(i, j)])).filter(|term| term.1 != 0.0);
            let terms: Vec<(u32, f64)> = terms.collect();
            self.take(&terms, scale, || holder.into());
        }
    }
}

/// Number of eigenvalues of a positive semidefinite matrix that are zero.
fn nullity(gram: &Mat<f64>) -> Result<usize, NoConvergence> {
    let values = symmetric_eigen(gram.as_ref())?.0;
    let largest = values.last().copied().unwrap_or(0.0);
    Ok(values.iter().filter(|value| **value <= UNSEEN * largest).count())
}

impl Freedom {
    /// The freedom of a body under constraints and blocks; `part` gives the part of each node, of `parts`.
    ///
    /// # Errors
    /// [`NoConvergence`]: numbers that double precision does not hold.
    pub(super) fn new(
        places: Places<'_>,
        (part, parts): (Vec<u32>, usize),
        constraints: &Constraints,
        blocks: &[Block],
    ) -> Result<Freedom, NoConvergence> {
        let mut rows = Rows::new(places, (part, parts));
        for (terms, origin) in constraints.equations() {
            let scale = terms.iter().map(|&(dof, a)| a.abs() * rows.weight(dof)).sum();
            rows.take(terms, scale, || origin.into());
        }
        let mut involved: BTreeSet<u32> = constraints.dofs().collect();
        for Block { dofs, stiffness, mass } in blocks {
            rows.take_block(dofs, stiffness, "a spring or a foundation");
            let some = |row: usize| stiffness[(row, row)] != 0.0 || mass[(row, row)] != 0.0;
            involved.extend((0..dofs.len()).filter(|&row| some(row)).map(|row| dofs[row]));
        }
        let count = places.of_mesh() + MOTIONS * places.points.len();
        for dof in 0..count as u32 {
            let moves = (dof as usize) < places.of_mesh() || involved.contains(&dof);
            if constraints.holds(dof) && moves {
                let scale = rows.weight(dof);
                rows.take(&[(dof, 1.0)], scale, || "a support or a held reference point".into());
            } else if !moves {
                // Nothing has a part in it: it is held, and holds nothing.
                rows.forget(dof);
            }
        }
        rows.freedom()
    }
}

impl<'a> Rows<'a> {
    fn new(places: Places<'a>, (part, parts): (Vec<u32>, usize)) -> Rows<'a> {
        let corner = |pick: fn(f64, f64) -> f64| -> [f64; 3] {
            std::array::from_fn(|c| places.nodes.iter().map(|x| x[c]).reduce(pick).unwrap_or(0.0))
        };
        let (low, high) = (corner(f64::min), corner(f64::max));
        let size = (0..3).map(|c| high[c] - low[c]).fold(f64::MIN_POSITIVE, f64::max);
        let middle = std::array::from_fn(|c| 0.5 * (low[c] + high[c]));
        let unknowns = MOTIONS * (parts + places.points.len());
        let gram = (unknowns <= MOST_UNKNOWNS).then(|| Mat::zeros(unknowns, unknowns));
        let whole = Mat::zeros(MOTIONS, MOTIONS);
        Rows { places, part, parts, middle, size, gram, whole, holder: None }
    }

    /// Leaves a motion of a reference point out.
    fn forget(&mut self, dof: u32) {
        let unknown = MOTIONS * self.parts + dof as usize - self.places.of_mesh();
        if let Some(gram) = &mut self.gram {
            gram[(unknown, unknown)] += 1.0;
        }
    }

    fn freedom(self) -> Result<Freedom, NoConvergence> {
        let largest = (0..MOTIONS).map(|k| self.whole[(k, k)]).fold(0.0, f64::max);
        let unseen = (0..MOTIONS).filter(|&k| self.whole[(k, k)] <= UNSEEN * largest);
        let all = self.gram.as_ref().map(nullity).transpose()?;
        let rigid = if largest == 0.0 { MOTIONS } else { nullity(&self.whole)? };
        Ok(Freedom { rigid, named: unseen.map(|k| NAMES[k]).collect(), holder: self.holder, all })
    }
}

/// True of a damping that some rigid motion of the whole body meets.
pub(super) fn meets_rigid_motion(places: Places<'_>, dofs: &[u32], damping: &Mat<f64>) -> bool {
    let mut rows = Rows::new(places, (vec![0; places.nodes.len()], 1));
    rows.take_block(dofs, damping, "");
    rows.holder.is_some()
}
