//! The pair `(M, K)` over the free dofs: all that dynamics, reduction and the vademecum need to know of a
//! body.
//!
//! `M = Σ_q M_q` and `K = Σ_q K_q`, one term per material region, all on one pattern. With one region the
//! total is the term and is stored once.

use std::sync::Arc;

use faer::MatRef;

use super::dampers::Dampers;
use super::late::Lazy;
use super::rigid::RigidBody;
use super::sparse::{Pattern, SymmetricMatrix};
use super::spread::SpreadMatrix;

/// Mass and stiffness of one region.
#[derive(Clone, Debug)]
pub(crate) struct RegionMatrices {
    pub(crate) mass: SymmetricMatrix,
    pub(crate) stiffness: SymmetricMatrix,
}

/// Mass and stiffness of a body over its free dofs, in total and per region.
#[derive(Clone, Debug)]
pub struct Pencil {
    mass: SymmetricMatrix,
    stiffness: SymmetricMatrix,
    /// Empty when there is one region.
    regions: Vec<RegionMatrices>,
    /// The node of each free dof, ascending; `None` when the matrices came without a mesh.
    dof_nodes: Option<Vec<u32>>,
    /// The rigid motions of a body without supports.
    rigid: Option<Arc<RigidBody>>,
    /// Source of matrices whose rows are on other ranks.
    away: Option<Arc<RemoteMatrices>>,
    /// Dashpots.
    dampers: Dampers,
    /// Loss factor of each region; none of a body without any.
    loss: Vec<f64>,
}

/// Source of matrices whose rows are on other ranks.
#[derive(Debug)]
pub(super) struct RemoteMatrices {
    /// The free dof at each place of the order in which rows are dealt.
    pub(crate) order: Arc<Vec<u32>>,
    /// Number of material regions.
    pub(crate) regions: usize,
    /// About how many numbers a factor has.
    pub(crate) factor_entries: usize,
    /// Both matrices in this process, once something needs their entries.
    pub(crate) here: Arc<Lazy<Pencil>>,
}

impl RemoteMatrices {
    /// The same behind matrices whose regions are scaled.
    fn scaled(&self, m: &[f64], k: &[f64]) -> RemoteMatrices {
        let (nominal, m, k) = (self.here.clone(), m.to_vec(), k.to_vec());
        RemoteMatrices {
            order: self.order.clone(),
            here: Arc::new(Lazy::new(move || nominal.get().scaled(&m, &k))),
            ..*self
        }
    }
}

/// Why two matrices are no pencil.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PencilError {
    /// Mass and stiffness are not square of one size.
    #[error("mass is {mass:?} and stiffness {stiffness:?}: both must be square of one size")]
    Shape {
        /// Rows and columns of the mass matrix.
        mass: (usize, usize),
        /// Rows and columns of the stiffness matrix.
        stiffness: (usize, usize),
    },
    /// An entry outside the matrix.
    #[error("entry ({row}, {column}) lies outside a matrix of size {n}")]
    OutOfBounds {
        /// Row of the entry.
        row: u32,
        /// Column of the entry.
        column: u32,
        /// Size of the matrix.
        n: usize,
    },
    /// Two mirrored entries differ.
    #[error("entries ({row}, {column}) and ({column}, {row}) differ: the matrix must be symmetric")]
    NotSymmetric {
        /// Row of one of the two.
        row: u32,
        /// Column of the same.
        column: u32,
    },
    /// An entry is infinite or not a number.
    #[error("entry ({row}, {column}) is not a finite number")]
    NotFinite {
        /// Row of the entry.
        row: u32,
        /// Column of the entry.
        column: u32,
    },
    /// More places than a 32-bit index can count.
    #[error("{entries} matrix entries exceed the {} an index can count", u32::MAX)]
    TooLarge {
        /// Entries needed.
        entries: usize,
    },
}

impl Pencil {
    /// Joins matrices on one pattern; `regions` holds one pair per region.
    pub(crate) fn from_regions(mut regions: Vec<RegionMatrices>, dof_nodes: Option<Vec<u32>>) -> Pencil {
        let (mass, stiffness) = if regions.len() == 1 {
            let only = regions.remove(0);
            (only.mass, only.stiffness)
        } else {
            let masses: Vec<_> = regions.iter().map(|r| (1.0, &r.mass)).collect();
            let stiffnesses: Vec<_> = regions.iter().map(|r| (1.0, &r.stiffness)).collect();
            (SymmetricMatrix::combine(&masses), SymmetricMatrix::combine(&stiffnesses))
        };
        Pencil {
            mass,
            stiffness,
            regions,
            dof_nodes,
            rigid: None,
            away: None,
            dampers: Dampers::default(),
            loss: vec![],
        }
    }

    /// Mass and stiffness of a body whose rows lie on ranks.
    pub(super) fn spread([mass, stiffness]: [Arc<dyn SpreadMatrix>; 2], away: RemoteMatrices) -> Pencil {
        let away = Arc::new(away);
        let [of_mass, of_stiffness] = [(); 2].map(|()| away.clone());
        Pencil {
            mass: SymmetricMatrix::spread_over(mass, move || of_mass.here.get().mass.clone()),
            stiffness: SymmetricMatrix::spread_over(stiffness, move || {
                of_stiffness.here.get().stiffness.clone()
            }),
            regions: vec![],
            dof_nodes: None,
            rigid: None,
            away: Some(away),
            dampers: Dampers::default(),
            loss: vec![],
        }
    }

    /// Source of matrices whose rows are on other ranks.
    pub(super) fn away(&self) -> Option<&Arc<RemoteMatrices>> {
        self.away.as_ref()
    }

    /// The rows of mass and stiffness on the ranks, if they lie there.
    fn rows_on_ranks(&self) -> [Option<&Arc<dyn SpreadMatrix>>; 2] {
        [self.mass.spread(), self.stiffness.spread()]
    }

    /// True if something needed entries of matrices whose rows lie on ranks, and had them assembled here.
    pub(crate) fn was_assembled_here(&self) -> bool {
        self.away.as_ref().is_some_and(|away| away.here.is_made())
    }

    /// The same pencil, or that in this process where rows lie on ranks and entries are needed.
    fn here(&self) -> &Pencil {
        self.away.as_ref().map_or(self, |away| away.here.get())
    }

    /// A pencil of two dense symmetric matrices `(n, n)`; zeros of both are not stored.
    ///
    /// # Errors
    /// [`PencilError`] for shapes, asymmetry (mirrored entries must be equal) or entries that are not finite.
    pub fn from_matrices(mass: MatRef<'_, f64>, stiffness: MatRef<'_, f64>) -> Result<Pencil, PencilError> {
        let n = mass.nrows();
        if [mass.ncols(), stiffness.nrows(), stiffness.ncols()] != [n; 3] {
            return Err(PencilError::Shape {
                mass: (n, mass.ncols()),
                stiffness: (stiffness.nrows(), stiffness.ncols()),
            });
        }
        let entries = |a: MatRef<'_, f64>| -> Vec<(u32, u32, f64)> {
            let all = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
            all.map(|(i, j)| (i as u32, j as u32, a[(i, j)])).filter(|e| e.2 != 0.0).collect()
        };
        Pencil::from_triplets(n, &entries(mass), &entries(stiffness))
    }

    /// A pencil of size `n` from `(row, column, value)` entries of both triangles; repeated entries add up in
    /// order.
    ///
    /// # Errors
    /// As [`Pencil::from_matrices`].
    pub fn from_triplets(
        n: usize,
        mass: &[(u32, u32, f64)],
        stiffness: &[(u32, u32, f64)],
    ) -> Result<Pencil, PencilError> {
        let pattern = Arc::new(common_pattern(n, [mass, stiffness])?);
        let matrix = |triplets| -> Result<SymmetricMatrix, PencilError> {
            let matrix = SymmetricMatrix::new(pattern.clone(), values_on(&pattern, triplets));
            check_symmetry(&matrix)?;
            Ok(matrix)
        };
        let (mass, stiffness) = (matrix(mass)?, matrix(stiffness)?);
        let regions = RegionMatrices { mass, stiffness };
        Ok(Pencil::from_regions(vec![regions], None))
    }

    /// The same pencil with the node of each free dof, ascending, so that its elimination order dissects
    /// nodes.
    ///
    /// # Panics
    /// If there is not one node per dof.
    pub(crate) fn with_dof_nodes(self, dof_nodes: Vec<u32>) -> Pencil {
        assert_eq!(dof_nodes.len(), self.n_dof());
        Pencil { dof_nodes: Some(dof_nodes), ..self }
    }

    /// The same pencil with dashpots.
    pub(crate) fn with_dampers(self, dampers: Dampers) -> Pencil {
        Pencil { dampers, ..self }
    }

    /// The dashpots of the body.
    pub fn dampers(&self) -> &Dampers {
        &self.dampers
    }

    /// The same pencil with a loss factor of each region, or none at all.
    ///
    /// # Panics
    /// If there is not one for each region.
    pub(crate) fn with_loss(self, loss: Vec<f64>) -> Pencil {
        assert!(loss.is_empty() || loss.len() == self.n_regions());
        Pencil { loss, ..self }
    }

    /// True if a region has a loss factor, be it zero.
    pub(crate) fn has_loss(&self) -> bool {
        !self.loss.is_empty()
    }

    /// `Σ η_q K_q` of the loss factors `η`; `None` without any.
    pub(crate) fn loss(&self) -> Option<SymmetricMatrix> {
        let terms = self.loss.iter().enumerate().map(|(q, &eta)| (eta, self.region_stiffness(q)));
        self.has_loss().then(|| SymmetricMatrix::combine(&terms.collect::<Vec<_>>()))
    }

    /// The same pencil as that of a body without supports.
    pub(crate) fn with_rigid(self, rigid: RigidBody) -> Pencil {
        Pencil { rigid: Some(Arc::new(rigid)), ..self }
    }

    /// The same pencil as that of a body without supports, three dofs for each of these nodes.
    ///
    /// # Panics
    /// If there are not three dofs per node, or the nodes lie on a line.
    pub fn of_free_body(self, nodes: &[[f64; 3]]) -> Pencil {
        let rigid = RigidBody::new(nodes, &self.mass);
        self.with_rigid(rigid)
    }

    /// The same pencil as that of a body without supports, over free dofs from which all others follow:
    /// `rows` gives the free dofs under three shifts along the axes of space and three turns about a point,
    /// `solid` is true of dofs of the mesh.
    pub fn of_free_rows(
        self,
        rows: impl Fn([f64; 3]) -> Vec<[f64; 6]>,
        solid: impl Fn(usize) -> bool,
    ) -> Pencil {
        let rigid = RigidBody::of_rows(&self.mass, rows, solid, vec![]);
        self.with_rigid(rigid)
    }

    /// The rigid motions of a body without supports; `None` of a body that is held.
    pub fn rigid(&self) -> Option<&Arc<RigidBody>> {
        self.rigid.as_ref()
    }

    /// Number of free dofs `n`.
    pub fn n_dof(&self) -> usize {
        self.mass.n()
    }

    /// Number of natural modes that are no rigid motion.
    pub fn n_elastic(&self) -> usize {
        self.n_dof().saturating_sub(if self.rigid.is_some() { 6 } else { 0 })
    }

    /// Memory of all matrices in this process \[bytes\]; none where their rows lie on ranks.
    pub fn bytes(&self) -> usize {
        if self.away.is_some() {
            return 0;
        }
        let stored = self.mass.pattern().n_stored();
        stored.saturating_mul(size_of::<u32>() + 2 * size_of::<f64>() * (1 + self.regions.len()))
    }

    /// Number of material regions, at least 1.
    pub(crate) fn n_regions(&self) -> usize {
        self.away.as_ref().map_or(self.regions.len().max(1), |away| away.regions)
    }

    /// Consistent mass `M`, kg.
    pub fn mass(&self) -> &SymmetricMatrix {
        &self.mass
    }

    /// Stiffness `K`, N/m.
    pub fn stiffness(&self) -> &SymmetricMatrix {
        &self.stiffness
    }

    /// Mass `M_q` of region `q`.
    pub(crate) fn region_mass(&self, q: usize) -> &SymmetricMatrix {
        let here = self.here();
        here.regions.get(q).map_or(&here.mass, |r| &r.mass)
    }

    /// Stiffness `K_q` of region `q`.
    pub(crate) fn region_stiffness(&self, q: usize) -> &SymmetricMatrix {
        let here = self.here();
        here.regions.get(q).map_or(&here.stiffness, |r| &r.stiffness)
    }

    /// `m M + k K`.
    pub fn combine(&self, m: f64, k: f64) -> SymmetricMatrix {
        SymmetricMatrix::combine(&[(m, &self.mass), (k, &self.stiffness)])
    }

    /// A pencil whose regions are scaled: `M = Σ_q m_q M_q`, `K = Σ_q k_q K_q`, as another material choice
    /// gives it. The rigid motions of a free body stay those of the pencil as it is: they are the same as
    /// long as all regions have one weight.
    ///
    /// # Panics
    /// If the two slices do not hold one weight per region, or weights that are alike where the matrices of
    /// all regions are one.
    pub fn scaled(&self, m: &[f64], k: &[f64]) -> Pencil {
        let all_alike = |weights: &[f64]| weights.iter().all(|&weight| weight == weights[0]);
        let (m, k) = match self.n_regions() {
            1 if all_alike(m) && all_alike(k) => (&m[..1], &k[..1]),
            _ => (m, k),
        };
        assert!(m.len() == self.n_regions() && k.len() == self.n_regions());
        if m.iter().chain(k).all(|&weight| weight == 1.0) {
            return self.clone();
        }
        let alike = |weights: &[f64]| weights.iter().all(|&weight| weight == weights[0]);
        if let (Some(away), [Some(mass), Some(stiffness)]) = (&self.away, self.rows_on_ranks())
            && alike(m)
            && alike(k)
        {
            let times = |rows: &Arc<dyn SpreadMatrix>, weight: f64| match weight {
                1.0 => rows.clone(),
                _ => rows.scaled(weight),
            };
            let rows = [times(mass, m[0]), times(stiffness, k[0])];
            let (rigid, dampers, loss) = (self.rigid.clone(), self.dampers.clone(), self.loss.clone());
            return Pencil { rigid, dampers, loss, ..Pencil::spread(rows, away.scaled(m, k)) };
        }
        let regions = (0..self.n_regions())
            .map(|q| RegionMatrices {
                mass: SymmetricMatrix::combine(&[(m[q], self.region_mass(q))]),
                stiffness: SymmetricMatrix::combine(&[(k[q], self.region_stiffness(q))]),
            })
            .collect();
        let (rigid, dampers, loss) = (self.rigid.clone(), self.dampers.clone(), self.loss.clone());
        Pencil { rigid, dampers, loss, ..Pencil::from_regions(regions, self.here().dof_nodes.clone()) }
    }

    /// The node each free dof belongs to, ascending; `None` for matrices without a mesh.
    pub(crate) fn dof_nodes(&self) -> Option<&[u32]> {
        self.here().dof_nodes.as_deref()
    }
}

/// The places of all entries and of the diagonal, each once, sorted by column and row.
fn common_pattern(n: usize, matrices: [&[(u32, u32, f64)]; 2]) -> Result<Pattern, PencilError> {
    let key = |row: u32, column: u32| u64::from(column) << 32 | u64::from(row);
    let mut places: Vec<u64> = (0..n as u32).map(|j| key(j, j)).collect();
    for &(row, column, value) in matrices.into_iter().flatten() {
        if row as usize >= n || column as usize >= n {
            return Err(PencilError::OutOfBounds { row, column, n });
        }
        if !value.is_finite() {
            return Err(PencilError::NotFinite { row, column });
        }
        places.push(key(row, column));
    }
    places.sort_unstable();
    places.dedup();
    if places.len() > u32::MAX as usize {
        return Err(PencilError::TooLarge { entries: places.len() });
    }
    let mut starts = vec![0u32; n + 1];
    places.iter().for_each(|place| starts[(place >> 32) as usize + 1] += 1);
    for j in 0..n {
        starts[j + 1] += starts[j];
    }
    Ok(Pattern::new(starts, places.iter().map(|&place| place as u32).collect()))
}

/// Sums of the entries at each place of a pattern that has them all, added in order.
fn values_on(pattern: &Pattern, triplets: &[(u32, u32, f64)]) -> Vec<f64> {
    let mut values = vec![0.0; pattern.n_stored()];
    for &(row, column, value) in triplets {
        let at = pattern.rows_of(column as usize).binary_search(&row);
        values[pattern.range(column as usize).start + at.expect("a place of the pattern")] += value;
    }
    values
}

/// Every entry has a mirror image and equals it.
fn check_symmetry(matrix: &SymmetricMatrix) -> Result<(), PencilError> {
    let pattern = matrix.pattern();
    for column in 0..pattern.n() {
        for (&row, &value) in pattern.rows_of(column).iter().zip(&matrix.values()[pattern.range(column)]) {
            if matrix.get(column, row as usize) != Some(value) {
                return Err(PencilError::NotSymmetric { row, column: column as u32 });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triplets_add_up_on_one_pattern_with_the_diagonal() {
        let mass = [(1, 1, 2.0), (0, 0, 1.0)];
        let stiffness = [(2, 0, -1.0), (0, 0, 3.0), (0, 2, -0.5), (0, 2, -0.5), (0, 0, 4.0)];
        let pencil = Pencil::from_triplets(3, &mass, &stiffness).unwrap();
        let pattern = pencil.mass().pattern();
        let rows: Vec<&[u32]> = (0..3).map(|j| pattern.rows_of(j)).collect();
        assert_eq!(rows, [&[0, 2][..], &[1], &[0, 2]]);
        assert_eq!(pencil.mass().values(), [1.0, 0.0, 2.0, 0.0, 0.0]);
        assert_eq!(pencil.stiffness().values(), [7.0, -1.0, 0.0, -1.0, 0.0]);
    }

    #[test]
    fn triplets_that_are_no_symmetric_matrix_are_refused() {
        let refused = |entries: &[(u32, u32, f64)]| Pencil::from_triplets(2, entries, &[]).unwrap_err();
        assert_eq!(refused(&[(0, 2, 1.0)]), PencilError::OutOfBounds { row: 0, column: 2, n: 2 });
        assert_eq!(refused(&[(0, 1, f64::INFINITY)]), PencilError::NotFinite { row: 0, column: 1 });
        assert_eq!(refused(&[(1, 0, 1.0)]), PencilError::NotSymmetric { row: 1, column: 0 });
        assert!(matches!(refused(&[(1, 0, 1.0), (0, 1, 1.5)]), PencilError::NotSymmetric { .. }));
    }
}
