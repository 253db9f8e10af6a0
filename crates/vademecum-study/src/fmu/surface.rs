//! The surface nodes of the arrays of an FMU.

use vademecum_fmu::points::MOST;
use vademecum_format::{File, SectionKind};

use super::error::FmuError;
use super::version::FmiVersion;
use crate::contents::numbers;
use crate::error::FileError;

/// Nodes of the loadable surface in the arrays of an FMU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SurfaceNodes {
    /// No arrays.
    #[default]
    None,
    /// So many, spread over the surface.
    Spread(usize),
    /// All that the file has.
    All,
}

/// First dimension of the arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArrayRows {
    /// A structural parameter, which the master may set.
    #[default]
    Structural,
    /// A number, for masters without structural parameters.
    Fixed,
}

/// Numbers of the nodes in file order: each is the one that lies furthest from those before it, so that any
/// first part of the list is spread over the surface. `O(n k)` for `k` of `n` loadable nodes.
///
/// # Errors
/// [`FmuError`]: arrays in FMI 2, a file without a surface, more nodes than there are or than an FMU holds.
pub(super) fn place_surface(
    file: &File<'_>,
    asked: SurfaceNodes,
    version: FmiVersion,
) -> Result<Vec<u32>, FmuError> {
    if asked == SurfaceNodes::None {
        return Ok(vec![]);
    }
    if version == FmiVersion::Two {
        return Err(FmuError::ArraysOfThree);
    }
    let held = [SectionKind::NodeCoordinates, SectionKind::SurfaceBasis];
    if let Some(kind) = held.into_iter().find(|&kind| file.section(kind).is_none()) {
        return Err(FileError::Missing { kind }.into());
    }
    vademecum_rewrite::check_coordinates(file)?;
    let all = numbers(file, SectionKind::NodeCoordinates)?;
    let nodes = all.as_chunks::<3>().0;
    let known = nodes.len().min(file.metadata().n_load_nodes as usize);
    if known == 0 {
        return Err(FileError::NoSurface.into());
    }
    let count = match asked {
        SurfaceNodes::Spread(count) => count,
        _ => known,
    };
    if count == 0 || count > known {
        return Err(FmuError::SurfaceNodes { found: count, known });
    }
    if count > MOST {
        return Err(FmuError::TooManySurfaceNodes { found: count });
    }
    Ok(spread(&nodes[..known], count))
}

/// The first is the node furthest from the mean of all; of equal ones the first in file order.
fn spread(nodes: &[[f64; 3]], count: usize) -> Vec<u32> {
    let mean = [0, 1, 2].map(|c| nodes.iter().map(|node| node[c]).sum::<f64>() / nodes.len() as f64);
    let square = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
    let mut apart: Vec<f64> = nodes.iter().map(|&node| square(node, mean)).collect();
    let mut taken: Vec<u32> = vec![];
    while taken.len() < count {
        let far = apart.iter().enumerate().rev().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(k, _)| k);
        if taken.is_empty() {
            apart.fill(f64::INFINITY);
        }
        taken.push(far as u32);
        for (apart, &node) in apart.iter_mut().zip(nodes) {
            *apart = apart.min(square(node, nodes[far]));
        }
        // Nodes at one place are all taken in the end, each once.
        apart[far] = -1.0;
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn any_first_part_is_spread() {
        let line: Vec<[f64; 3]> = (0..9).map(|k| [f64::from(k), 0.0, 0.0]).collect();
        assert_eq!(spread(&line, 5), [0, 8, 4, 2, 6]);
        let mut all = spread(&line, 9);
        all.sort_unstable();
        assert_eq!(all, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        let mut one_place = spread(&[[1.0; 3]; 3], 3);
        one_place.sort_unstable();
        assert_eq!(one_place, [0, 1, 2]);
    }
}
