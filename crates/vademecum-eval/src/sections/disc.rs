//! A force over a disc of the surface: a uniform traction over what of the surface lies within a radius around
//! a point, as consistent weights of nodes.
//!
//! ```text
//! w_a = ∫ N_a dA / ∫ dA        over the facets within the radius that look as the point does, not away from it
//! ```
//!
//! The weights sum to 1, so a force of 1 N stays one on every mesh; `Σ w_a u_a` is the mean displacement of the
//! disc, which is conjugate to the force. A ball cuts the plane of a triangle in a circle, and triangle and
//! circle are integrated exactly: each edge spans with the centre of the circle a triangle where it is inside
//! and a sector where it is outside, with a sign. Shape functions of quadrangles are taken at points of a
//! quadrature that is exact for them.

use crate::base::vec3::{add, cross, dot, minus};
use crate::sections::place::Place;
use crate::sections::surface::Surface;

/// Points and weights of a triangle, exact for polynomials of degree 4 (Strang and Fix 1973): the first two
/// numbers are barycentric, the third is `1 − a − b`.
const IN_TRIANGLE: [[f64; 3]; 6] = [
    [0.445_948_490_915_965, 0.445_948_490_915_965, 0.223_381_589_678_011],
    [0.445_948_490_915_965, 0.108_103_018_168_070, 0.223_381_589_678_011],
    [0.108_103_018_168_070, 0.445_948_490_915_965, 0.223_381_589_678_011],
    [0.091_576_213_509_771, 0.091_576_213_509_771, 0.109_951_743_655_322],
    [0.091_576_213_509_771, 0.816_847_572_980_459, 0.109_951_743_655_322],
    [0.816_847_572_980_459, 0.091_576_213_509_771, 0.109_951_743_655_322],
];

/// Gauss's points and weights on `[0, 1]`.
const GAUSS: [[f64; 2]; 4] = [
    [0.069_431_844_202_974, 0.173_927_422_568_727],
    [0.330_009_478_207_572, 0.326_072_577_431_273],
    [0.669_990_521_792_428, 0.326_072_577_431_273],
    [0.930_568_155_797_026, 0.173_927_422_568_727],
];

/// Largest angle of a sector that is integrated at once.
const SECTOR: f64 = core::f64::consts::FRAC_PI_8;

/// Direction in which the surface looks around a place: of all triangles at its nodes, by their areas.
fn outward(surface: &Surface<'_>, place: &Place) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for triangle in 0..surface.n_triangles() {
        let Some((nodes, corners)) = corners(surface, triangle) else { continue };
        let shared = place.entries().filter(|(node, weight)| *weight != 0.0 && nodes.contains(node));
        let share: f64 = shared.map(|(_, weight)| weight.abs()).sum();
        if share > 0.0 {
            sum = add(sum, share, normal(corners));
        }
    }
    sum
}

/// Nodes of a triangle and where they are.
fn corners(surface: &Surface<'_>, triangle: usize) -> Option<([u32; 3], [[f64; 3]; 3])> {
    let nodes = surface.triangle(triangle)?;
    let [Some(a), Some(b), Some(c)] = nodes.map(|node| surface.position(node)) else { return None };
    Some((nodes, [a, b, c]))
}

/// Normal of a triangle, as long as twice its area.
fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    cross(minus(b, a), minus(c, a))
}

/// Gives `add` the nodes of the disc around a place and their integrals `∫ N_a dA` \[m²\], a node as often as
/// it is met; the area. `O(triangles)`.
pub(crate) fn integrals(surface: &Surface<'_>, place: &Place, mut add_to: impl FnMut(u32, f64)) -> f64 {
    let radius = place.radius();
    let at = |(node, weight)| surface.position(node).map(|x| x.map(|x| weight * x)).unwrap_or_default();
    let centre = place.entries().map(at).fold([0.0; 3], |sum, x| add(sum, 1.0, x));
    let up = outward(surface, place);
    let mut area = 0.0;
    for triangle in 0..surface.n_triangles() {
        let Some((nodes, corners)) = corners(surface, triangle) else { continue };
        let normal = normal(corners);
        let twice = libm::sqrt(dot(normal, normal));
        let looks_away = dot(normal, up) <= 0.0 || twice == 0.0;
        if looks_away || !near(corners, centre, radius) {
            continue;
        }
        let normal = normal.map(|x| x / twice);
        let away = dot(normal, minus(centre, corners[0]));
        let square = radius * radius - away * away;
        if square <= 0.0 {
            continue;
        }
        // Coordinates in the plane of the triangle, from the centre of the circle.
        let side = minus(corners[1], corners[0]);
        let length = libm::sqrt(dot(side, side));
        let first = side.map(|x| x / length);
        let second = cross(normal, first);
        let flat = corners.map(|x| [dot(minus(x, centre), first), dot(minus(x, centre), second)]);
        // Linear shape functions need no more than area and centre.
        let linear = surface.is_linear(triangle);
        let (mut own, mut moment) = (0.0, [0.0; 2]);
        circle_and_triangle(flat, libm::sqrt(square), &mut |[x, y], weight| {
            own += weight;
            moment = [moment[0] + weight * x, moment[1] + weight * y];
            if !linear {
                let shares = surface.place(triangle, nodes, barycentric(flat, [x, y]));
                shares.entries().for_each(|(node, share)| add_to(node, weight * share));
            }
        });
        // Rounding of a triangle that the circle only touches.
        if own <= 1e-15 * twice {
            continue;
        }
        area += own;
        if linear {
            let shares = barycentric(flat, moment.map(|x| x / own));
            nodes.into_iter().zip(shares).for_each(|(node, share)| add_to(node, own * share));
        }
    }
    area
}

/// `false` if the box around a triangle is farther away than the radius.
fn near(corners: [[f64; 3]; 3], centre: [f64; 3], radius: f64) -> bool {
    (0..3).all(|axis| {
        let [a, b, c] = corners.map(|x| x[axis]);
        a.min(b).min(c) <= centre[axis] + radius && a.max(b).max(c) >= centre[axis] - radius
    })
}

/// Barycentric weights of a point of the plane.
fn barycentric([a, b, c]: [[f64; 2]; 3], x: [f64; 2]) -> [f64; 3] {
    let area =
        |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let whole = area(a, b, c);
    let (v, w) = (area(a, x, c) / whole, area(a, b, x) / whole);
    [1.0 - v - w, v, w]
}

/// Points and weights of a quadrature over what a triangle and the circle around the origin have in common.
fn circle_and_triangle(corners: [[f64; 2]; 3], radius: f64, sample: &mut impl FnMut([f64; 2], f64)) {
    for k in 0..3 {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let at = |t: f64| [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])];
        // Where the edge crosses the circle.
        let along = [to[0] - from[0], to[1] - from[1]];
        let (a, b) = (along[0] * along[0] + along[1] * along[1], from[0] * along[0] + from[1] * along[1]);
        let root = b * b - a * (from[0] * from[0] + from[1] * from[1] - radius * radius);
        let crossings = if root > 0.0 {
            let root = libm::sqrt(root);
            [((-b - root) / a).clamp(0.0, 1.0), ((-b + root) / a).clamp(0.0, 1.0)]
        } else {
            [0.0, 0.0]
        };
        let cuts = [0.0, crossings[0], crossings[1], 1.0];
        for piece in 0..3 {
            let (start, end) = (cuts[piece], cuts[piece + 1]);
            if start < end {
                // Between the crossings the edge is inside.
                match piece {
                    1 => triangle(at(start), at(end), sample),
                    _ => sector(at(start), at(end), radius, sample),
                }
            }
        }
    }
}

/// The triangle of the origin and two points, with its sign.
fn triangle(p: [f64; 2], q: [f64; 2], sample: &mut impl FnMut([f64; 2], f64)) {
    let area = 0.5 * (p[0] * q[1] - p[1] * q[0]);
    for [a, b, weight] in IN_TRIANGLE {
        sample([a * p[0] + b * q[0], a * p[1] + b * q[1]], weight * area);
    }
}

/// The sector of the circle between two directions, with its sign.
fn sector(p: [f64; 2], q: [f64; 2], radius: f64, sample: &mut impl FnMut([f64; 2], f64)) {
    let angle = libm::atan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1]);
    let start = libm::atan2(p[1], p[0]);
    let parts = libm::ceil(angle.abs() / SECTOR).max(1.0);
    for part in 0..parts as u32 {
        for [t, across] in GAUSS {
            let theta = start + angle * (f64::from(part) + t) / parts;
            for [s, along] in GAUSS {
                let r = radius * s;
                let weight = across * along * radius * r * angle / parts;
                sample([r * libm::cos(theta), r * libm::sin(theta)], weight);
            }
        }
    }
}

/// Writes nodes and weights of the disc around a place: their number, or `None` if there are more than there
/// is room for, or none.
pub(crate) fn spread<T: crate::base::scalar::Scalar>(
    surface: &Surface<'_>,
    place: &Place,
    out: &mut [[T; 2]],
) -> Option<usize> {
    let (mut count, mut fits) = (0, true);
    let area = integrals(surface, place, |node, share| {
        let number = T::from_f64(f64::from(node));
        let known = out.iter().take(count).position(|[other, _]| *other == number);
        match out.get_mut(known.unwrap_or(count)) {
            Some(entry) if known.is_some() => entry[1] += T::from_f64(share),
            Some(entry) => {
                *entry = [number, T::from_f64(share)];
                count += 1;
            }
            None => fits = false,
        }
    });
    if !fits || count == 0 {
        return None;
    }
    let scale = T::from_f64(1.0 / area);
    out.iter_mut().take(count).for_each(|[_, share]| *share = scale * *share);
    Some(count)
}

/// Largest radius up to that of a place whose disc has no more nodes than there is room for; 0 if none has.
pub(crate) fn largest<T: crate::base::scalar::Scalar>(
    surface: &Surface<'_>,
    place: &Place,
    out: &mut [[T; 2]],
) -> f64 {
    let (mut fits, mut more) = (0.0, place.radius());
    for _ in 0..20 {
        let middle = 0.5 * (fits + more);
        match spread(surface, &place.with_radius(middle), out) {
            Some(_) => fits = middle,
            None => more = middle,
        }
    }
    fits
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area and first moments of a circle and a triangle, with the squares as well.
    fn moments(corners: [[f64; 2]; 3], radius: f64) -> [f64; 4] {
        let mut sum = [0.0; 4];
        circle_and_triangle(corners, radius, &mut |[x, y], weight| {
            let more = [1.0, x, y, x * x];
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += weight * more);
        });
        sum
    }

    #[test]
    fn circles_and_triangles_are_integrated() {
        let pi = core::f64::consts::PI;
        let around = |found: [f64; 4], expected: [f64; 4]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {expected:?}");
        };
        // The whole circle, a quarter of it, a whole triangle, and none of a far one.
        around(moments([[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]], 2.0), [4.0 * pi, 0.0, 0.0, 4.0 * pi]);
        let quarter = [pi / 4.0, 1.0 / 3.0, 1.0 / 3.0, pi / 16.0];
        around(moments([[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]], 1.0), quarter);
        let whole = [0.5, 0.5 / 3.0, 0.5 / 3.0, 1.0 / 12.0];
        around(moments([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 3.0), whole);
        around(moments([[5.0, 0.0], [6.0, 0.0], [5.0, 1.0]], 1.0), [0.0; 4]);
        // Half of it through an edge that leaves the circle twice.
        around(moments([[-4.0, 0.0], [4.0, 0.0], [0.0, 40.0]], 1.0), [pi / 2.0, 0.0, 2.0 / 3.0, pi / 8.0]);
    }
}
