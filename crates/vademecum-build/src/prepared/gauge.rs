//! Virtual strain gauges: the mean strain of the surface between two points.
//!
//! A gauge of length `L` glued to the surface along `d` measures how much farther apart its ends have moved:
//! `ε = (u(x + ½ L d) − u(x − ½ L d))·d / L`, which is the mean of `d·ε d` along it. It is linear in the
//! displacements of the nodes around its ends, so it is a probe.

use vademecum_eval::nearest_in_triangle;

use super::quadrangle::in_quadrangle;
use crate::input::GaugeEntry;
use crate::mesh::shapes::quadrangle_shapes;
use crate::mesh::surface::Surface;
use crate::mesh::{FacetKind, Mesh};

/// Largest distance of an end from the surface, as a share of the gauge's length.
const OFF: f64 = 0.1;

/// A gauge that cannot be glued to the body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GaugeError {
    /// The body has no surface.
    #[error("the body has no triangles to which a gauge could be glued")]
    NoSurface,
    /// An end off the surface.
    #[error(
        "its end at ({:.6}, {:.6}, {:.6}) lies {distance:.3e} m off the surface; expected at most a tenth of \
         its length, {length:.3e} m: move it, turn it or make it shorter",
        .end[0], .end[1], .end[2]
    )]
    Off {
        /// The end \[m\].
        end: [f64; 3],
        /// Its distance \[m\].
        distance: f64,
        /// Length of the gauge \[m\].
        length: f64,
    },
}

/// The nodes that move a gauge, and what their displacements are multiplied by \[1/m\].
pub(super) fn nodes(
    mesh: &Mesh,
    surface: &Surface,
    gauge: &GaugeEntry,
) -> Result<Vec<(u32, [f64; 3])>, GaugeError> {
    let size = gauge.direction.iter().map(|c| c * c).sum::<f64>().sqrt();
    let direction = gauge.direction.map(|c| c / size);
    let mut found = vec![];
    for side in [1.0, -1.0] {
        let end = std::array::from_fn(|c| gauge.point[c] + 0.5 * side * gauge.length * direction[c]);
        let (weights, distance) = at_surface(mesh, surface, end).ok_or(GaugeError::NoSurface)?;
        if distance > OFF * gauge.length {
            return Err(GaugeError::Off { end, distance, length: gauge.length });
        }
        let along = |weight: f64| direction.map(|d| side * weight * d / gauge.length);
        found.extend(weights.into_iter().map(|(node, weight)| (node, along(weight))));
    }
    Ok(found)
}

/// Shape functions at the point of the surface nearest to `point`, and how far off that is.
fn at_surface(mesh: &Mesh, surface: &Surface, point: [f64; 3]) -> Option<(Vec<(u32, f64)>, f64)> {
    let of_triangle = |(place, triangle): (usize, &[u32; 3])| {
        let corners = triangle.map(|node| mesh.nodes[node as usize]);
        let weights = nearest_in_triangle(point, corners);
        let away = |c: usize| point[c] - (0..3).map(|k| weights[k] * corners[k][c]).sum::<f64>();
        (place, weights, (0..3).map(|c| away(c).powi(2)).sum::<f64>())
    };
    let all = surface.triangles.iter().enumerate().map(of_triangle);
    let (place, weights, square) = all.min_by(|a, b| a.2.total_cmp(&b.2))?;
    let index = surface.triangle_facet[place] as usize;
    let facet = surface.facet(index);
    let shapes: Vec<f64> = match surface.facet_kind(index) {
        FacetKind::Tri3 => weights.to_vec(),
        FacetKind::Tri6 => {
            let [a, b, c] = in_facet(facet, surface.triangles[place], weights);
            let corner = |l: f64| l * (2.0 * l - 1.0);
            vec![corner(a), corner(b), corner(c), 4.0 * a * b, 4.0 * b * c, 4.0 * c * a]
        }
        kind @ (FacetKind::Quad4 | FacetKind::Quad8 | FacetKind::Quad9) => {
            let [x, y] = in_quadrangle(facet, surface.triangles[place], weights);
            quadrangle_shapes(kind, x, y).0
        }
    };
    Some((facet.iter().copied().zip(shapes).collect(), square.sqrt()))
}

/// Barycentric coordinates in a 6-node facet of a place in one of its four triangles.
fn in_facet(facet: &[u32], triangle: [u32; 3], weights: [f64; 3]) -> [f64; 3] {
    const PLACES: [[f64; 3]; 6] = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.5, 0.5, 0.0],
        [0.0, 0.5, 0.5],
        [0.5, 0.0, 0.5],
    ];
    let mut sum = [0.0; 3];
    for (node, weight) in triangle.iter().zip(weights) {
        let place = facet.iter().position(|other| other == node).expect("a node of its facet");
        sum.iter_mut().zip(PLACES[place]).for_each(|(sum, l)| *sum += weight * l);
    }
    sum
}
