//! Rows of a matrix, dealt to ranks; or the elements that a rank assembles its rows of.

use std::ops::Range;

use vademecum_build::fem::{AssemblyPart, Elasticity, EngineError, Material, Stiffness, SymmetricMatrix};
use vademecum_build::mesh::{ElementKind, Hexahedra};

use crate::ranks::Ranks;

/// Rows of a rank in the order in which they are dealt.
pub struct Share {
    /// Start of each row, and the end.
    pub starts: Vec<i64>,
    /// Columns by the same order, ascending in each row.
    pub columns: Vec<i64>,
    /// Values.
    pub values: Vec<f64>,
}

impl Share {
    /// Some rows of a matrix, whose columns stand at such places.
    pub fn of(matrix: &SymmetricMatrix, rows: &[u32], place: impl Fn(u32) -> i64) -> Self {
        let pattern = matrix.pattern();
        let entries = rows.iter().map(|&row| pattern.rows_of(row as usize).len()).sum();
        let (mut starts, mut columns) = (vec![0], Vec::with_capacity(entries));
        let mut values = Vec::with_capacity(entries);
        let mut entries: Vec<(i64, f64)> = vec![];
        for &row in rows {
            // A column of a symmetric matrix is its row.
            let columns_of = pattern.rows_of(row as usize).iter().map(|&column| place(column));
            entries.clear();
            entries.extend(columns_of.zip(matrix.values()[pattern.range(row as usize)].iter().copied()));
            entries.sort_unstable_by_key(|&(column, _)| column);
            columns.extend(entries.iter().map(|&(column, _)| column));
            values.extend(entries.iter().map(|&(_, value)| value));
            starts.push(columns.len() as i64);
        }
        Self { starts, columns, values }
    }

    /// Sends it all.
    pub fn send(&self, ranks: &Ranks, to: usize) -> Result<(), EngineError> {
        ranks.send_list(&self.starts, to)?;
        ranks.send_list(&self.columns, to)?;
        ranks.send_list(&self.values, to)
    }

    /// Receives it.
    pub fn receive(ranks: &Ranks, from: usize) -> Result<Self, EngineError> {
        Ok(Self {
            starts: ranks.receive_list(from)?,
            columns: ranks.receive_list(from)?,
            values: ranks.receive_list(from)?,
        })
    }
}

/// The rows of the part that are at its places: their numbers in the part, in the order of the places.
pub fn own_rows(part: &AssemblyPart, places: &[i64]) -> Vec<u32> {
    let first = part.rows.start as i64;
    let mut rows = vec![0; part.rows.len()];
    for (row, place) in places.iter().enumerate() {
        if let Some(at) = usize::try_from(place - first).ok().filter(|&at| at < rows.len()) {
            rows[at] = row as u32;
        }
    }
    rows
}

/// Numbers of a material: its density; Young's modulus and Poisson's ratio; a stiffness, zeros of an
/// isotropic one.
fn constants_of(material: &Material) -> [f64; 39] {
    let mut numbers = [0.0; 39];
    numbers[0] = material.density;
    match &material.elasticity {
        Elasticity::Isotropic { young, poisson } => (numbers[1], numbers[2]) = (*young, *poisson),
        Elasticity::Anisotropic(Stiffness(rows)) => numbers[3..].copy_from_slice(rows.as_flattened()),
    }
    numbers
}

/// The material of its numbers.
fn material_of(numbers: &[f64; 39]) -> Material {
    let [density, young, poisson, rows @ ..] = numbers;
    let elasticity = if *young > 0.0 {
        Elasticity::Isotropic { young: *young, poisson: *poisson }
    } else {
        Elasticity::Anisotropic(Stiffness(std::array::from_fn(|i| std::array::from_fn(|j| rows[6 * i + j]))))
    };
    Material { elasticity, density: *density }
}

/// Sends a part of a body.
pub fn send_part(part: &AssemblyPart, ranks: &Ranks, to: usize) -> Result<(), EngineError> {
    let wide = |list: &[u32]| list.iter().map(|&number| number.into()).collect::<Vec<u64>>();
    let constants: Vec<f64> = part.materials.iter().flat_map(constants_of).collect();
    let kinds: Vec<u32> = (0..part.regions.len()).map(|element| part.kinds.kind(element) as u32).collect();
    let hexahedra: Vec<u32> = part.hexahedra.iter().map(|named| named.map_or(0, |h| 1 + h as u32)).collect();
    ranks.send(&[part.rows.start as u64, part.rows.end as u64], to)?;
    ranks.send_list(part.nodes.as_flattened(), to)?;
    for list in [&part.elements, &part.regions, &part.numbers, &kinds, &hexahedra] {
        ranks.send_list(&wide(list), to)?;
    }
    ranks.send_list(&constants, to)?;
    ranks.send_list(&part.places, to)
}

/// Receives one.
pub fn receive_part(ranks: &Ranks, from: usize) -> Result<AssemblyPart, EngineError> {
    let narrow = |list: Vec<u64>| list.into_iter().map(|number| number as u32).collect();
    let rows: Vec<u64> = ranks.receive(2, from)?;
    let nodes: Vec<f64> = ranks.receive_list(from)?;
    let list = || Ok::<Vec<u32>, EngineError>(narrow(ranks.receive_list(from)?));
    let (elements, regions, numbers, kinds, hexahedra) = (list()?, list()?, list()?, list()?, list()?);
    let kind = |&number: &u32| ElementKind::all().nth(number as usize);
    let formulation = |&number: &u32| Hexahedra::ALL.get((number as usize).wrapping_sub(1)).copied();
    let constants: Vec<f64> = ranks.receive_list(from)?;
    Ok(AssemblyPart {
        kinds: kinds.iter().filter_map(kind).collect(),
        hexahedra: hexahedra.iter().map(formulation).collect(),
        nodes: nodes.as_chunks().0.to_vec(),
        elements,
        regions,
        numbers,
        materials: constants.as_chunks().0.iter().map(material_of).collect(),
        places: ranks.receive_list(from)?,
        rows: Range { start: rows[0] as usize, end: rows[1] as usize },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vademecum_build::fem::Pencil;
    use vademecum_build::mesh::Order;

    #[test]
    fn shares_are_the_rows_of_the_permuted_matrix() {
        let entries = [(0, 0, 1.0), (1, 1, 2.0), (2, 2, 3.0), (0, 2, 4.0), (2, 0, 4.0)];
        let pencil = Pencil::from_triplets(3, &entries, &entries).expect("a pencil");
        let order = [2, 1, 0];
        let share = |places: Range<usize>| Share::of(pencil.mass(), &order[places], |row| 2 - i64::from(row));
        let first = share(0..1);
        assert_eq!((first.starts, first.columns, first.values), (vec![0, 2], vec![0, 2], vec![3.0, 4.0]));
        let rest = share(1..3);
        assert_eq!((rest.starts, rest.columns), (vec![0, 1, 3], vec![1, 0, 2]));
        assert_eq!(rest.values, vec![2.0, 4.0, 1.0]);
    }

    #[test]
    fn own_rows_of_a_part_are_found_by_their_places() {
        let part = AssemblyPart {
            kinds: Order::Linear.into(),
            hexahedra: vec![],
            nodes: vec![],
            elements: vec![],
            regions: vec![],
            numbers: vec![],
            materials: vec![],
            places: vec![],
            rows: 4..7,
        };
        assert_eq!(own_rows(&part, &[9, 6, 4, 0, 5]), [2, 4, 1]);
    }
}
