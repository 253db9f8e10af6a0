//! Load patterns that are temperatures: the thermal strain of each element, and the stress that it takes off.

use super::body_error::BodyError;
use super::places::select;
use crate::fem::{COMPONENTS, Model, StressPoint, element_stress};
use crate::input::{PatternEntry, Problem};
use crate::mesh::{ElementKind, Mesh};

/// A symmetric tensor along the axes of space.
type Tensor = [[f64; 3]; 3];

/// The thermal strain of each element under a pattern, from that of one kelvin in each region; none of a
/// pattern that is no temperature.
pub(super) fn strain(
    problem: &Problem,
    index: usize,
    entry: &PatternEntry,
    (mesh, of_regions): (&Mesh, &[Tensor]),
) -> Result<Option<Vec<Tensor>>, BodyError> {
    let Some(rise) = entry.temperature else { return Ok(None) };
    let key = || format!("load.pattern[{index}].on");
    let chosen = entry.on.as_ref().map(|on| select(problem, on, mesh, key)).transpose()?;
    let heated = |kind: ElementKind, nodes: &[u32]| {
        let inside = |node| chosen.as_ref().is_none_or(|chosen| chosen.binary_search(node).is_ok());
        nodes[..kind.corners()].iter().all(inside)
    };
    let elements = mesh.each().zip(&mesh.element_region);
    let strain: Vec<Tensor> = elements
        .map(|((kind, nodes), &region)| {
            let rise = if heated(kind, nodes) { rise } else { 0.0 };
            of_regions[region as usize].map(|row| row.map(|coefficient| rise * coefficient))
        })
        .collect();
    if strain.iter().flatten().flatten().all(|entry| *entry == 0.0) && rise != 0.0 {
        return Err(BodyError::NotHeated { path: problem.place(&key()), name: entry.name.clone() });
    }
    Ok(Some(strain))
}

/// `D ε_T` at points, the mean over the elements of each point, for each of so many patterns; empty of
/// patterns that are no temperature.
pub(super) fn stress(
    model: &Model,
    (count, thermal): (usize, &[(usize, Vec<Tensor>)]),
    points: &[StressPoint],
) -> Vec<Vec<[f64; COMPONENTS]>> {
    let mut found = vec![vec![]; count];
    let (mesh, materials) = (model.mesh(), model.materials());
    for (pattern, strain) in thermal {
        // By region and node, as the points are.
        let count = mesh.nodes.len();
        let mut sums = vec![[0.0; COMPONENTS + 1]; count * mesh.regions.len()];
        for (e, (_, nodes)) in mesh.each().enumerate() {
            let region = mesh.element_region[e] as usize;
            let stress = element_stress(&materials[region], &strain[e]);
            for &node in nodes {
                let own = stress.into_iter().chain([1.0]);
                sums[region * count + node as usize].iter_mut().zip(own).for_each(|(sum, s)| *sum += s);
            }
        }
        let at = |point: &StressPoint| {
            let sum = sums[point.region as usize * count + point.node as usize];
            std::array::from_fn(|k| sum[k] / sum[COMPONENTS].max(1.0))
        };
        found[*pattern] = points.iter().map(at).collect();
    }
    found
}
