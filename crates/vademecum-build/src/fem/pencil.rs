//! The pair `(M, K)` over the free dofs: all that dynamics, reduction and the vademecum need to know of a body.
//!
//! `M = Σ_q M_q` and `K = Σ_q K_q`, one term per material region, all on one pattern. With one region the total is the
//! term and is stored once.

use std::collections::BTreeMap;
use std::sync::Arc;

use faer::MatRef;

use super::sparse::{Pattern, SymmetricMatrix};

/// Mass and stiffness of one region.
#[derive(Clone, Debug)]
pub(crate) struct RegionMatrices {
    pub mass: SymmetricMatrix,
    pub stiffness: SymmetricMatrix,
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
    /// An entry lies outside the matrix.
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
        Pencil { mass, stiffness, regions, dof_nodes }
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

    /// A pencil of size `n` from `(row, column, value)` entries of both triangles; repeated entries add up in order.
    ///
    /// # Errors
    /// As [`Pencil::from_matrices`].
    pub fn from_triplets(
        n: usize,
        mass: &[(u32, u32, f64)],
        stiffness: &[(u32, u32, f64)],
    ) -> Result<Pencil, PencilError> {
        // Keyed (column, row), the order of the pattern; the diagonal always has its place.
        let mut entries: BTreeMap<(u32, u32), [f64; 2]> = (0..n as u32).map(|j| ((j, j), [0.0; 2])).collect();
        for (which, triplets) in [mass, stiffness].into_iter().enumerate() {
            for &(row, column, value) in triplets {
                if row as usize >= n || column as usize >= n {
                    return Err(PencilError::OutOfBounds { row, column, n });
                }
                if !value.is_finite() {
                    return Err(PencilError::NotFinite { row, column });
                }
                entries.entry((column, row)).or_default()[which] += value;
            }
        }
        if entries.len() > u32::MAX as usize {
            return Err(PencilError::TooLarge { entries: entries.len() });
        }
        for (&(column, row), value) in &entries {
            if entries.get(&(row, column)) != Some(value) {
                return Err(PencilError::NotSymmetric { row, column });
            }
        }
        let mut starts = vec![0u32; n + 1];
        for &(column, _) in entries.keys() {
            starts[column as usize + 1] += 1;
        }
        for j in 0..n {
            starts[j + 1] += starts[j];
        }
        let pattern = Arc::new(Pattern::new(starts, entries.keys().map(|key| key.1).collect()));
        let matrix = |which: usize| {
            SymmetricMatrix::new(pattern.clone(), entries.values().map(|v| v[which]).collect())
        };
        Ok(Pencil { mass: matrix(0), stiffness: matrix(1), regions: Vec::new(), dof_nodes: None })
    }

    /// Number of free dofs `n`.
    pub fn n_dof(&self) -> usize {
        self.mass.n()
    }

    /// Number of material regions, at least 1.
    pub fn n_regions(&self) -> usize {
        self.regions.len().max(1)
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
    pub fn region_mass(&self, q: usize) -> &SymmetricMatrix {
        self.regions.get(q).map_or(&self.mass, |r| &r.mass)
    }

    /// Stiffness `K_q` of region `q`.
    pub fn region_stiffness(&self, q: usize) -> &SymmetricMatrix {
        self.regions.get(q).map_or(&self.stiffness, |r| &r.stiffness)
    }

    /// `m M + k K`.
    pub fn combine(&self, m: f64, k: f64) -> SymmetricMatrix {
        SymmetricMatrix::combine(&[(m, &self.mass), (k, &self.stiffness)])
    }

    /// A pencil whose regions are scaled: `M = Σ_q m_q M_q`, `K = Σ_q k_q K_q`, as another material choice gives it.
    ///
    /// # Panics
    /// If the two slices do not hold one weight per region.
    pub fn scaled(&self, m: &[f64], k: &[f64]) -> Pencil {
        assert!(m.len() == self.n_regions() && k.len() == self.n_regions());
        let regions = (0..self.n_regions())
            .map(|q| RegionMatrices {
                mass: SymmetricMatrix::combine(&[(m[q], self.region_mass(q))]),
                stiffness: SymmetricMatrix::combine(&[(k[q], self.region_stiffness(q))]),
            })
            .collect();
        Pencil::from_regions(regions, self.dof_nodes.clone())
    }

    /// The node each free dof belongs to, ascending; `None` for matrices without a mesh.
    pub fn dof_nodes(&self) -> Option<&[u32]> {
        self.dof_nodes.as_deref()
    }
}
