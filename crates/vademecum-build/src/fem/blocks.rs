//! Matrices from small dense blocks: elements, springs, masses and beams under constraints.

use std::collections::BTreeMap;
use std::sync::Arc;

use faer::{Mat, MatRef};

use super::assembly::element_nodes;
use super::element::ElementError;
use super::elimination::Elimination;
use super::heat::{Heat, HeatedElement, Tensor};
use super::kernels::ElementKernels;
use super::material::{Cylinder, Law, Material};
use super::model_error::ModelError;
use super::pencil::{Pencil, RegionMatrices};
use super::prestress::Prestress;
use super::sparse::{Pattern, SymmetricMatrix};
use crate::mesh::Mesh;
use crate::mesh::shapes::{MAX_NODES, Point};
use crate::parallel;

/// Elements whose matrices are made at once.
const WAVE: usize = 2048;

/// Free dofs that a block may couple: a dense matrix of so many takes a quarter of a gigabyte.
const MOST_COUPLED: usize = 4096;

/// Stiffness and mass over a few dofs, shape (k, k).
#[derive(Clone, Debug)]
pub struct Block {
    /// Its dofs.
    pub dofs: Vec<u32>,
    /// Stiffness over them, symmetric.
    pub stiffness: Mat<f64>,
    /// Mass over them, symmetric.
    pub mass: Mat<f64>,
}

/// Groups of attachments that live parameters scale.
#[derive(Clone, Debug)]
pub struct BlockGroups {
    /// As many as there are.
    pub count: usize,
    /// Group of each block, counted from 1, or 0.
    pub of_blocks: Vec<usize>,
}

/// Stiffness and mass of single elements over three dofs a node, `3 · node + component`.
#[derive(Clone)]
pub struct ElementMatrices<'a> {
    mesh: &'a Mesh,
    materials: &'a [Material],
    /// True for each region whose mass is lumped.
    lumped: &'a [bool],
    kernels: Arc<ElementKernels>,
    /// Of each region the line about which the axes of its material turn.
    cylinders: &'a [Option<Cylinder>],
    /// First of nine dofs of each element whose incompatible modes are kept.
    inner: Vec<Option<u32>>,
    /// State about which the body moves.
    prestress: Option<&'a Prestress>,
    /// Its temperatures.
    heat: Option<Heat<'a>>,
}

impl<'a> ElementMatrices<'a> {
    /// Tabulates the shape functions. `materials` and `lumped` hold one entry for each region of the mesh; a
    /// lumped mass is that of Hinton, Rock and Zienkiewicz (1976): the diagonal of the consistent one, scaled
    /// to the mass of the element.
    ///
    /// # Panics
    /// If there are fewer entries than regions.
    pub fn new(mesh: &'a Mesh, materials: &'a [Material], lumped: &'a [bool]) -> Self {
        let regions = mesh.regions.len();
        assert!(materials.len() >= regions && lumped.len() >= regions, "one entry for each region");
        let kernels = Arc::new(ElementKernels::new(mesh));
        let (cylinders, inner, prestress, heat) = (&[][..], vec![], None, None);
        Self { mesh, materials, lumped, kernels, cylinders, inner, prestress, heat }
    }

    /// Turns the axes of materials: one entry for each region, or none at all.
    pub fn turn(&mut self, cylinders: &'a [Option<Cylinder>]) {
        self.cylinders = cylinders;
    }

    /// The same with the incompatible modes of 8-node hexahedra as dofs of their own, with a mass, as
    /// CalculiX has them: nine for each such element, numbered from `first` on. Gives the number behind
    /// the last.
    pub fn keep_inner_functions(&mut self, first: u32) -> u32 {
        let mut next = first;
        let number = |element: usize| {
            self.kernels.of(self.mesh, element).is_incompatible().then(|| {
                next += 9;
                next - 9
            })
        };
        self.inner = (0..self.mesh.element_count()).map(number).collect();
        next
    }

    /// The same about a static state.
    #[must_use]
    pub fn about(&self, prestress: &'a Prestress) -> Self {
        Self { prestress: Some(prestress), ..self.clone() }
    }

    /// The same at temperatures; one entry for each region and each node of the mesh.
    #[must_use]
    pub fn heated(&self, heat: Heat<'a>) -> Self {
        Self { heat: Some(heat), ..self.clone() }
    }

    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.mesh.element_count()
    }

    /// Dofs of an element.
    fn dofs(&self, element: usize) -> impl Iterator<Item = u32> {
        let nodes = self.mesh.element(element).iter();
        let inner = self.inner.get(element).copied().flatten();
        nodes
            .flat_map(|&node| (0..3).map(move |c| 3 * node + c))
            .chain(inner.into_iter().flat_map(|first| first..first + 9))
    }

    /// The matrices of an element.
    ///
    /// # Errors
    /// [`ElementError`]: it folds over.
    pub fn block(&self, element: usize) -> Result<Block, ElementError> {
        let mut block = self.elastic_block(element)?;
        if let Some(state) = self.prestress {
            let (n, at) =
                (self.mesh.element(element).len(), element_nodes::<MAX_NODES>(self.mesh, element as u32));
            let kernel = self.kernels.of(self.mesh, element);
            let Block { dofs, stiffness, mass } = &mut block;
            state.add_to(
                (element as u32, kernel, (&self.law(element), &self.thermal_strain(element))),
                (&at[..n], dofs),
                (mass, stiffness),
            )?;
        }
        Ok(block)
    }

    /// The line about which the axes of an element turn.
    fn cylinder(&self, element: usize) -> Option<&'a Cylinder> {
        self.cylinders.get(self.mesh.element_region[element] as usize).and_then(Option::as_ref)
    }

    /// Temperatures of an element.
    fn heated_element(&self, element: usize) -> Option<HeatedElement<'a>> {
        let (kind, region) = (self.mesh.kinds.kind(element), self.mesh.element_region[element]);
        let kernel = self.kernels.of(self.mesh, element);
        self.heat?.of((kind, region), self.mesh.element(element), kernel)
    }

    /// The law of the material of an element at each of its points.
    fn law(&self, element: usize) -> impl Fn(&Point) -> Law {
        let material = self.materials[self.mesh.element_region[element] as usize];
        let (heated, cylinder) = (self.heated_element(element), self.cylinder(element));
        let (fixed, at) = (material.law(), element_nodes::<MAX_NODES>(self.mesh, element as u32));
        move |point| {
            let elasticity = heated.as_ref().and_then(|heated| heated.elasticity(point));
            let law = elasticity.map_or(fixed, |elasticity| Material { elasticity, ..material }.law());
            cylinder.map_or(law, |cylinder| law.about(cylinder, point.place(&at)))
        }
    }

    /// The thermal strain of an element at each of its points.
    fn thermal_strain(&self, element: usize) -> impl Fn(&Point) -> Tensor {
        let (heated, cylinder) = (self.heated_element(element), self.cylinder(element));
        let at = element_nodes::<MAX_NODES>(self.mesh, element as u32);
        move |point| {
            let axes = cylinder.map(|cylinder| cylinder.axes(point.place(&at)));
            heated.as_ref().map_or([[0.0; 3]; 3], |heated| heated.strain(point, axes))
        }
    }

    /// Dofs of an element, the forces of its thermal strain, and its energy without a displacement; none
    /// where there are no temperatures.
    pub(super) fn thermal_force(&self, element: usize) -> Result<Option<ThermalForce>, ElementError> {
        if self.heat.is_none() {
            return Ok(None);
        }
        let (n, at) =
            (self.mesh.element(element).len(), element_nodes::<MAX_NODES>(self.mesh, element as u32));
        let dofs: Vec<u32> = self.dofs(element).collect();
        let (law, strain) = (self.law(element), self.thermal_strain(element));
        let kernel = self.kernels.of(self.mesh, element);
        let (forces, energy) = kernel.thermal_force(&at[..n], (&law, &strain), dofs.len() > 3 * n)?;
        Ok(Some((dofs, forces, energy)))
    }

    /// The matrices of an element without the static state.
    fn elastic_block(&self, element: usize) -> Result<Block, ElementError> {
        let nodes = self.mesh.element(element);
        let (n, at) = (nodes.len(), element_nodes::<MAX_NODES>(self.mesh, element as u32));
        let kernel = self.kernels.of(self.mesh, element);
        let region = self.mesh.element_region[element] as usize;
        let (material, law) = (&self.materials[region], self.law(element));
        let dofs: Vec<u32> = self.dofs(element).collect();
        if dofs.len() > 3 * n {
            let [stiffness, mass] = kernel.with_inner_functions(&at[..n], &law, material.density)?;
            return Ok(Block { dofs, stiffness, mass });
        }
        let (mut mass, mut stiffness) = (vec![0.0; n * n], vec![0.0; 9 * n * n]);
        kernel.mass_into(&at[..n], material.density, &mut mass)?;
        kernel.stiffness_by(&at[..n], &law, &mut stiffness)?;
        if self.lumped[region] {
            lump(n, &mut mass);
        }
        let entry = |i: usize, j: usize| stiffness[(i / 3 * n + j / 3) * 9 + 3 * (i % 3) + j % 3];
        let heavy = |i: usize, j: usize| if i % 3 == j % 3 { mass[i / 3 * n + j / 3] } else { 0.0 };
        let [stiffness, mass] = [Mat::from_fn(3 * n, 3 * n, entry), Mat::from_fn(3 * n, 3 * n, heavy)];
        Ok(Block { dofs, stiffness, mass })
    }
}

/// Dofs, forces over them, and an energy.
type ThermalForce = (Vec<u32>, Vec<f64>, f64);

/// The diagonal, scaled to the sum of all entries.
fn lump(n: usize, mass: &mut [f64]) {
    let whole: f64 = mass.iter().sum();
    let diagonal: f64 = (0..n).map(|a| mass[a * n + a]).sum();
    for a in 0..n {
        for b in 0..n {
            mass[a * n + b] *= if a == b { whole / diagonal } else { 0.0 };
        }
    }
}

impl Block {
    /// The block over free dofs, `TᵀKT` and `TᵀMT`; what falls on held dofs is left out.
    fn eliminated(&self, elimination: &Elimination) -> Block {
        let n_free = elimination.n_free() as u32;
        if let Some(block) = self.selected(elimination, n_free) {
            return block;
        }
        let mut places: BTreeMap<u32, usize> = BTreeMap::new();
        for &dof in &self.dofs {
            for &(index, _) in elimination.terms(dof as usize).iter().filter(|term| term.0 < n_free) {
                places.insert(index, 0);
            }
        }
        for (place, slot) in places.values_mut().enumerate() {
            *slot = place;
        }
        let mut t: Mat<f64> = Mat::zeros(self.dofs.len(), places.len());
        for (row, &dof) in self.dofs.iter().enumerate() {
            for &(index, a) in elimination.terms(dof as usize).iter().filter(|term| term.0 < n_free) {
                t[(row, places[&index])] += a;
            }
        }
        let dofs: Vec<u32> = places.into_keys().collect();
        let of = |matrix: &Mat<f64>| {
            let product = t.transpose() * (matrix * &t);
            Mat::from_fn(dofs.len(), dofs.len(), |i, j| 0.5 * (product[(i, j)] + product[(j, i)]))
        };
        Block { stiffness: of(&self.stiffness), mass: of(&self.mass), dofs }
    }
}

impl Block {
    /// The same where no dof is dependent: rows and columns of free dofs, ascending.
    fn selected(&self, elimination: &Elimination, n_free: u32) -> Option<Block> {
        let mut kept = Vec::with_capacity(self.dofs.len());
        for (row, &dof) in self.dofs.iter().enumerate() {
            match *elimination.terms(dof as usize) {
                [(index, 1.0)] if index < n_free => kept.push((index, row)),
                [(_, 1.0)] => {}
                _ => return None,
            }
        }
        kept.sort_unstable();
        if kept.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return None;
        }
        let of =
            |matrix: &Mat<f64>| Mat::from_fn(kept.len(), kept.len(), |i, j| matrix[(kept[i].1, kept[j].1)]);
        let dofs = kept.iter().map(|kept| kept.0).collect();
        Some(Block { dofs, stiffness: of(&self.stiffness), mass: of(&self.mass) })
    }
}

/// Mass and stiffness of elements and further blocks under constraints: `TᵀMT` and `TᵀKT` over the free dofs.
/// The dofs of the elements come first. All regions together: the pencil has one.
///
/// Elements in parallel, the same bits for any number of threads.
///
/// # Errors
/// [`ModelError::FoldedElement`], [`ModelError::TooLarge`], [`ModelError::Coupled`],
/// [`ModelError::NothingFree`].
pub fn assemble_blocks(
    elements: &ElementMatrices<'_>,
    others: &[Block],
    elimination: &Elimination,
) -> Result<Pencil, ModelError> {
    assemble_split(elements, others, None, elimination)
}

/// [`assemble_blocks`] with matrices of each region: those of the mesh, then one of the further blocks that
/// have no group, then those of the groups.
///
/// # Errors
/// As there.
pub(super) fn assemble_split(
    elements: &ElementMatrices<'_>,
    others: &[Block],
    groups: Option<&BlockGroups>,
    elimination: &Elimination,
) -> Result<Pencil, ModelError> {
    let n = elimination.n_free();
    if n == 0 {
        return Err(ModelError::NothingFree);
    }
    let mesh = elements.mesh;
    let count = mesh.element_count();
    let n_free = n as u32;
    let indices = |dofs: &mut dyn Iterator<Item = u32>| -> Vec<u32> {
        let terms = dofs.flat_map(|dof| elimination.terms(dof as usize));
        let mut found: Vec<u32> = terms.map(|term| term.0).filter(|index| *index < n_free).collect();
        found.sort_unstable();
        found.dedup();
        found
    };
    let of_element = |element: usize| indices(&mut elements.dofs(element));
    let of_mesh = mesh.regions.len();
    let region = |k: usize| match (groups, k.checked_sub(count)) {
        (None, _) => 0,
        (Some(_), None) => mesh.element_region[k] as usize,
        (Some(groups), Some(other)) => of_mesh + groups.of_blocks[other],
    };
    let regions = groups.map_or(1, |groups| of_mesh + 1 + groups.count);
    let mut coupled = parallel::map(count, &of_element);
    coupled.extend(others.iter().map(|block| indices(&mut block.dofs.iter().copied())));
    if let Some(dofs) = coupled[count..].iter().map(Vec::len).find(|dofs| *dofs > MOST_COUPLED) {
        return Err(ModelError::Coupled { dofs, most: MOST_COUPLED });
    }
    let pattern = Arc::new(pattern_of(n, &coupled)?);
    let [mut mass, mut stiffness] = [(); 2].map(|()| vec![vec![0.0; pattern.n_stored()]; regions]);
    for first in (0..coupled.len()).step_by(WAVE) {
        let block = |k: usize| match k.checked_sub(count) {
            Some(other) => Ok(others[other].eliminated(elimination)),
            None => match elements.block(k) {
                Ok(block) => Ok(block.eliminated(elimination)),
                Err(source) => Err(ModelError::FoldedElement { element: k as u32, source }),
            },
        };
        let blocks = parallel::try_map(WAVE.min(coupled.len() - first), &|at| block(first + at))?;
        for (k, block) in (first..).zip(blocks) {
            add(&block, &pattern, &mut stiffness[region(k)], &mut mass[region(k)]);
        }
    }
    let matrix = |values| SymmetricMatrix::new(pattern.clone(), values);
    let of_region = |(mass, stiffness)| RegionMatrices { mass: matrix(mass), stiffness: matrix(stiffness) };
    let nodes = elimination.free().iter().map(|dof| dof / 3).collect();
    Ok(Pencil::from_regions(mass.into_iter().zip(stiffness).map(of_region).collect(), Some(nodes)))
}

/// `K u` over all dofs: the forces that hold a body in a displacement.
///
/// # Errors
/// [`ModelError::FoldedElement`].
pub fn internal_forces(
    elements: &ElementMatrices<'_>,
    others: &[Block],
    displacement: &[f64],
) -> Result<Vec<f64>, ModelError> {
    let field = |block: &Block| product(&block.stiffness, |row| displacement[block.dofs[row] as usize]);
    let mut forces = element_forces(elements, displacement.len(), |_, block| Some(field(block)))?;
    for block in others {
        block.dofs.iter().zip(field(block)).for_each(|(&dof, force)| forces[dof as usize] += force);
    }
    Ok(forces)
}

/// `K t` and `M t` over the free dofs, for displacements `t` of the held dofs of the mesh, shape (dofs of the
/// mesh, columns), of the regions that count, as [`assemble_split`] has them; shape (n_free, columns). Dofs
/// that depend on held ones follow them.
pub(crate) fn held_columns(
    elements: &ElementMatrices<'_>,
    (others, groups): (&[Block], Option<&BlockGroups>),
    elimination: &Elimination,
    t: MatRef<'_, f64>,
    is_counted: &dyn Fn(usize) -> bool,
) -> Result<[Mat<f64>; 2], ModelError> {
    let (n, columns) = (elimination.n_free(), t.ncols());
    let held =
        |index: u32| index.checked_sub(n as u32).map(|place| elimination.held()[place as usize].0 as usize);
    let moved = |dof: usize, column: usize| -> f64 {
        let terms = elimination.terms(dof).iter().filter_map(|&(index, a)| Some((held(index)?, a)));
        terms.filter(|(dof, _)| *dof < t.nrows()).map(|(dof, a)| a * t[(dof, column)]).sum()
    };
    let whole = Mat::from_fn(elimination.n_dof(), columns, moved);
    let mut sums = [Mat::zeros(n, columns), Mat::zeros(n, columns)];
    let mut take = |block: &Block| {
        let x = Mat::from_fn(block.dofs.len(), columns, |row, c| whole[(block.dofs[row] as usize, c)]);
        if x.norm_max() == 0.0 {
            return;
        }
        for (matrix, sums) in [&block.stiffness, &block.mass].into_iter().zip(&mut sums) {
            let forces = matrix * &x;
            for (row, &dof) in block.dofs.iter().enumerate() {
                for &(index, a) in elimination.terms(dof as usize).iter().filter(|term| (term.0 as usize) < n)
                {
                    (0..columns).for_each(|c| sums[(index as usize, c)] += a * forces[(row, c)]);
                }
            }
        }
    };
    let mesh = elements.mesh;
    for element in (0..mesh.element_count()).filter(|&k| is_counted(mesh.element_region[k] as usize)) {
        if elements.dofs(element).any(|dof| (0..columns).any(|c| whole[(dof as usize, c)] != 0.0)) {
            let folded = |source| ModelError::FoldedElement { element: element as u32, source };
            take(&elements.block(element).map_err(folded)?);
        }
    }
    for (place, block) in others.iter().enumerate() {
        if is_counted(mesh.regions.len() + groups.map_or(0, |groups| groups.of_blocks[place])) {
            take(block);
        }
    }
    Ok(sums)
}

/// `M a` of the elements that have an acceleration, linear in the place, over `n` dofs.
///
/// # Errors
/// [`ModelError::FoldedElement`].
pub fn inertia_forces(
    elements: &ElementMatrices<'_>,
    n: usize,
    field: impl Fn(usize, [f64; 3]) -> Option<[f64; 3]> + Sync,
) -> Result<Vec<f64>, ModelError> {
    element_forces(elements, n, |element, block| {
        let nodes = elements.mesh.element(element);
        let at = |node: &u32| field(element, elements.mesh.nodes[*node as usize]);
        let accelerations: Option<Vec<[f64; 3]>> = nodes.iter().map(at).collect();
        let accelerations = accelerations?;
        // Inner functions are zero at the nodes, and an acceleration that is linear has none of them.
        let at = |row: usize| accelerations.get(row / 3).map_or(0.0, |a| a[row % 3]);
        Some(product(&block.mass, at))
    })
}

/// `A x`.
fn product(matrix: &Mat<f64>, x: impl Fn(usize) -> f64) -> Vec<f64> {
    let n = matrix.nrows();
    (0..n).map(|i| (0..n).map(|j| matrix[(i, j)] * x(j)).sum()).collect()
}

/// Sums forces that the matrices of single elements give, in the order of the mesh.
fn element_forces(
    elements: &ElementMatrices<'_>,
    n: usize,
    of: impl Fn(usize, &Block) -> Option<Vec<f64>> + Sync,
) -> Result<Vec<f64>, ModelError> {
    let one = |element: usize| match elements.block(element) {
        Ok(block) => Ok(of(element, &block).map(|forces| (block.dofs, forces))),
        Err(source) => Err(ModelError::FoldedElement { element: element as u32, source }),
    };
    let count = elements.mesh.element_count();
    let mut sums = vec![0.0; n];
    for first in (0..count).step_by(WAVE) {
        let wave = parallel::try_map(WAVE.min(count - first), &|at| one(first + at))?;
        for (dofs, forces) in wave.into_iter().flatten() {
            dofs.iter().zip(forces).for_each(|(&dof, force)| sums[dof as usize] += force);
        }
    }
    Ok(sums)
}

/// Adds a block to the entries of both matrices.
fn add(block: &Block, pattern: &Pattern, stiffness: &mut [f64], mass: &mut [f64]) {
    for (j, &column) in block.dofs.iter().enumerate() {
        let (rows, start) = (pattern.rows_of(column as usize), pattern.range(column as usize).start);
        let mut place = 0;
        // Both lists ascend.
        for (i, &row) in block.dofs.iter().enumerate() {
            place += rows[place..].partition_point(|&r| r < row);
            stiffness[start + place] += block.stiffness[(i, j)];
            mass[start + place] += block.mass[(i, j)];
        }
    }
}

/// The pattern in which the dofs of each group are coupled.
fn pattern_of(n: usize, groups: &[Vec<u32>]) -> Result<Pattern, ModelError> {
    let mut starts = vec![0_usize; n + 1];
    for &dof in groups.iter().flatten() {
        starts[dof as usize + 1] += 1;
    }
    for dof in 0..n {
        starts[dof + 1] += starts[dof];
    }
    let mut next = starts.clone();
    let mut of_dof = vec![0_u32; starts[n]];
    for (group, dofs) in groups.iter().enumerate() {
        for &dof in dofs {
            of_dof[next[dof as usize]] = group as u32;
            next[dof as usize] += 1;
        }
    }
    let column = |dof: usize| {
        let of_dof = &of_dof[starts[dof]..starts[dof + 1]];
        let mut rows: Vec<u32> =
            of_dof.iter().flat_map(|&group| groups[group as usize].iter().copied()).collect();
        rows.push(dof as u32);
        rows.sort_unstable();
        rows.dedup();
        rows
    };
    let columns = parallel::map(n, &column);
    let (mut starts, mut rows) = (vec![0], Vec::with_capacity(columns.iter().map(Vec::len).sum()));
    for column in columns {
        rows.extend_from_slice(&column);
        starts.push(u32::try_from(rows.len()).map_err(|_| ModelError::TooLarge)?);
    }
    Ok(Pattern::new(starts, rows))
}

#[cfg(test)]
mod tests {
    use super::super::elimination::Constraints;
    use super::super::model::Model;
    use super::super::test_mesh::{block, quadratic};
    use super::*;

    const SOLID: Material = Material::isotropic(7.0, 0.3, 2.0);

    #[test]
    fn blocks_without_constraints_are_the_assembled_matrices() {
        let mesh = quadratic(&block([2, 2, 1], [1.0, 0.7, 0.4]));
        let mut constraints = Constraints::default();
        let held: Vec<bool> = (0..3 * mesh.nodes.len()).map(|dof| mesh.nodes[dof / 3][0] == 0.0).collect();
        (0..held.len()).filter(|&dof| held[dof]).for_each(|dof| constraints.hold(dof as u32, 0.0));
        let materials = [SOLID];
        let elements = ElementMatrices::new(&mesh, &materials, &[false]);
        let elimination = constraints.eliminate(held.len()).unwrap();
        let found = assemble_blocks(&elements, &[], &elimination).unwrap();
        let model = Model::assemble(mesh.clone(), &materials, &held).unwrap();
        let expected = model.pencil();
        assert_eq!(found.mass().pattern(), expected.mass().pattern());
        let pairs = [(found.mass(), expected.mass()), (found.stiffness(), expected.stiffness())];
        for (found, expected) in pairs {
            let most = expected.values().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let off = found.values().iter().zip(expected.values()).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-13 * most);
        }
    }

    #[test]
    fn a_lumped_mass_keeps_the_mass_and_is_diagonal() {
        let mesh = quadratic(&block([2, 2, 1], [1.0, 0.7, 0.4]));
        let materials = [SOLID];
        let [consistent, lumped] = [false, true]
            .map(|lumped| ElementMatrices::new(&mesh, &materials, &[lumped]).block(0).unwrap().mass);
        let sum = |m: &Mat<f64>| m.col_iter().map(|column| column.iter().sum::<f64>()).sum::<f64>();
        assert!((sum(&lumped) / sum(&consistent) - 1.0).abs() < 1e-12);
        let n = lumped.nrows();
        assert!((0..n).all(|i| (0..n).all(|j| (i == j) == (lumped[(i, j)] != 0.0))));
    }
}
