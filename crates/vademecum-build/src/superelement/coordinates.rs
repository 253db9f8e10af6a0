//! The free dofs by the coordinates of the interfaces and the dofs that are left: `u = S (q, x)`.

use faer::{Mat, MatRef};

use super::error::SuperelementError;
use crate::fem::SymmetricMatrix;
use crate::prepared::{Interface, InterfaceRows};

/// A pivot that is a smaller share of its row's largest weight is rounding.
const ROUNDING: f64 = 1e-9;

/// `S`, by rows and by columns.
pub(super) struct Coordinates {
    /// Number m of coordinates of the interfaces.
    pub(super) interface: usize,
    /// Free dof of each coordinate behind them, ascending.
    pub(super) inside: Vec<u32>,
    /// Coordinates and weights of each free dof.
    rows: Vec<Vec<(u32, f64)>>,
    /// Free dofs and weights of each coordinate.
    columns: Vec<Vec<(u32, f64)>>,
}

/// A free dof that depends on coordinates, and on dofs that are left.
struct Dependent {
    dof: u32,
    coordinates: Vec<(u32, f64)>,
    others: Vec<(u32, f64)>,
}

impl Coordinates {
    /// The coordinates of `n` free dofs; `node` gives the number of a free dof's node, for messages.
    ///
    /// # Errors
    /// [`SuperelementError::Shared`], [`SuperelementError::Dependent`],
    /// [`SuperelementError::NothingInside`].
    pub(super) fn new(
        n: usize,
        interfaces: &[Interface],
        node: impl Fn(u32) -> u64,
    ) -> Result<Self, SuperelementError> {
        let mut owner = vec![usize::MAX; n];
        let mut taken = vec![false; n];
        let (mut first, mut dependent) = (0, vec![]);
        for (place, interface) in interfaces.iter().enumerate() {
            for dof in dofs_of(&interface.rows) {
                let before = std::mem::replace(&mut owner[dof as usize], place);
                if before != usize::MAX && before != place {
                    return Err(SuperelementError::Shared {
                        first: interfaces[before].name.clone(),
                        second: interface.name.clone(),
                        node: node(dof),
                    });
                }
            }
            let found = match &interface.rows {
                InterfaceRows::Followers(rows) => {
                    let follower = |&(dof, weights): &(u32, [f64; 6])| {
                        let own = (first..).zip(weights).filter(|term| term.1 != 0.0);
                        Dependent { dof, coordinates: own.collect(), others: vec![] }
                    };
                    Some(rows.iter().map(follower).collect())
                }
                InterfaceRows::Means(rows) => means(first, rows),
            };
            let count = interface.coordinates.len();
            let refused = || SuperelementError::Dependent { name: interface.name.clone(), count };
            let found: Vec<Dependent> = found.ok_or_else(refused)?;
            for Dependent { dof, .. } in &found {
                if std::mem::replace(&mut taken[*dof as usize], true) {
                    return Err(refused());
                }
            }
            dependent.extend(found);
            first += count as u32;
        }
        let inside: Vec<u32> = (0..n as u32).filter(|&dof| !taken[dof as usize]).collect();
        if inside.is_empty() {
            return Err(SuperelementError::NothingInside { free: n });
        }
        let mut rows = vec![vec![]; n];
        for (place, &dof) in (first..).zip(&inside) {
            rows[dof as usize] = vec![(place, 1.0)];
        }
        for Dependent { dof, mut coordinates, others } in dependent {
            let place = |other: u32| first + inside.partition_point(|&dof| dof < other) as u32;
            coordinates.extend(others.iter().map(|&(other, weight)| (place(other), weight)));
            rows[dof as usize] = coordinates;
        }
        let mut columns = vec![vec![]; first as usize + inside.len()];
        for (dof, row) in (0..).zip(&rows) {
            row.iter().for_each(|&(place, weight)| columns[place as usize].push((dof, weight)));
        }
        Ok(Self { interface: first as usize, inside, rows, columns })
    }

    /// Number of coordinates, and of dofs that are left.
    pub(super) fn count(&self) -> usize {
        self.columns.len()
    }

    /// Entries of both triangles of `SᵀAS`; each mirrored pair has one value.
    pub(super) fn transformed(&self, matrix: &SymmetricMatrix) -> Vec<(u32, u32, f64)> {
        let (pattern, values) = (matrix.pattern(), matrix.values());
        let (mut sums, mut touched) = (vec![0.0; self.count()], vec![]);
        let mut seen = vec![false; self.count()];
        let mut entries = vec![];
        for (column, terms) in self.columns.iter().enumerate() {
            for &(dof, weight) in terms {
                let range = pattern.range(dof as usize);
                for (&row, &value) in pattern.rows_of(dof as usize).iter().zip(&values[range]) {
                    for &(place, share) in &self.rows[row as usize] {
                        if place as usize >= column {
                            sums[place as usize] += share * value * weight;
                            if !std::mem::replace(&mut seen[place as usize], true) {
                                touched.push(place);
                            }
                        }
                    }
                }
            }
            touched.sort_unstable();
            for place in touched.drain(..) {
                let value = std::mem::take(&mut sums[place as usize]);
                seen[place as usize] = false;
                entries.push((place, column as u32, value));
                if place as usize > column {
                    entries.push((column as u32, place, value));
                }
            }
        }
        entries
    }

    /// `S V`: the free dofs of columns over the coordinates.
    pub(super) fn expand(&self, columns: MatRef<'_, f64>) -> Mat<f64> {
        let mut free = Mat::zeros(self.rows.len(), columns.ncols());
        for k in 0..columns.ncols() {
            for (dof, row) in self.rows.iter().enumerate() {
                free[(dof, k)] = row.iter().map(|&(i, weight)| weight * columns[(i as usize, k)]).sum();
            }
        }
        free
    }
}

/// Free dofs of an interface.
fn dofs_of(rows: &InterfaceRows) -> Vec<u32> {
    match rows {
        InterfaceRows::Followers(rows) => rows.iter().map(|row| row.0).collect(),
        InterfaceRows::Means(rows) => rows.iter().flatten().map(|term| term.0).collect(),
    }
}

/// The dofs that take the place of coordinates from `first` on: a row of one dof names it, and of the others
/// some dofs are solved for. Nothing if a row follows from others.
fn means(first: u32, rows: &[Vec<(u32, f64)>]) -> Option<Vec<Dependent>> {
    let (mut found, mut open) = (vec![], vec![]);
    for (coordinate, row) in (first..).zip(rows) {
        match row.as_slice() {
            [(dof, 1.0)] => {
                found.push(Dependent { dof: *dof, coordinates: vec![(coordinate, 1.0)], others: vec![] });
            }
            _ => open.push((coordinate, row)),
        }
    }
    let mut dofs: Vec<u32> = open.iter().flat_map(|(_, row)| row.iter().map(|term| term.0)).collect();
    dofs.sort_unstable();
    dofs.dedup();
    let own = |dof: u32| found.iter().find(|one| one.dof == dof).map(|one| one.coordinates[0].0);
    let named: Vec<Option<u32>> = dofs.iter().map(|&dof| own(dof)).collect();
    let (g, width) = (open.len(), dofs.len());
    // Weights of the dofs, then those of the coordinates: Σ a u = Σ b q.
    let mut table = vec![vec![0.0; width + g]; g];
    for (i, (_, row)) in open.iter().enumerate() {
        let largest = row.iter().fold(0.0_f64, |most, term| most.max(term.1.abs()));
        for &(dof, weight) in *row {
            table[i][dofs.partition_point(|&other| other < dof)] += weight / largest;
        }
        table[i][width + i] = 1.0 / largest;
    }
    let pivots = eliminate(&mut table, |j| j < width && named[j].is_none())?;
    let done = |c: usize| pivots.contains(&c);
    for (i, &j) in pivots.iter().enumerate() {
        let row = &table[i];
        let of_rows = open.iter().enumerate().map(|(k, (coordinate, _))| (*coordinate, row[width + k]));
        let of_named = (0..width).filter_map(|c| Some((named[c]?, -row[c])));
        let others = (0..width).filter(|&c| named[c].is_none() && !done(c)).map(|c| (dofs[c], -row[c]));
        found.push(Dependent {
            dof: dofs[j],
            coordinates: of_rows.chain(of_named).filter(|term| term.1 != 0.0).collect(),
            others: others.filter(|term| term.1 != 0.0).collect(),
        });
    }
    Some(found)
}

/// Solves the rows for one usable column each, by Gauss and Jordan with the largest pivot of all rows and
/// columns that are left; gives the column of each row. Nothing if a row follows from others.
fn eliminate(table: &mut [Vec<f64>], usable: impl Fn(usize) -> bool) -> Option<Vec<usize>> {
    let (g, width) = (table.len(), table.first().map_or(0, Vec::len));
    let mut pivots = vec![usize::MAX; g];
    for _ in 0..g {
        let rows = (0..g).filter(|&i| pivots[i] == usize::MAX);
        let places = rows.flat_map(|i| (0..width).map(move |j| (i, j)));
        let open = places.filter(|&(_, j)| usable(j) && !pivots.contains(&j));
        let (i, j) = open.max_by(|a, b| table[a.0][a.1].abs().total_cmp(&table[b.0][b.1].abs()))?;
        let pivot = table[i][j];
        if pivot.abs() <= ROUNDING {
            return None;
        }
        pivots[i] = j;
        table[i].iter_mut().for_each(|x| *x /= pivot);
        let row = table[i].clone();
        for (_, other) in table.iter_mut().enumerate().filter(|(other, _)| *other != i) {
            let share = other[j];
            if share != 0.0 {
                other.iter_mut().zip(&row).for_each(|(x, a)| *x -= share * a);
                other[j] = 0.0;
            }
        }
    }
    Some(pivots)
}
