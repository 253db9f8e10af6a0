//! From weights of the corners of a triangle to a place on it.

use crate::base::vec3::{add, cross, dot, minus};

/// Gradient with respect to a place in the plane of a triangle \[1/m of the scalar\], from that with respect
/// to the weights of its corners ([`Adjoint::place`](crate::Adjoint::place)): a move `d` of the place along
/// the triangle changes the scalar by the gradient times `d`. Corners are positions \[m\]
/// ([`Body::position`](crate::Body::position)). Zeros for a triangle without area.
///
/// ```
/// let corners = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0]];
/// // The weights of (x, y) are 1 − (x + y)/2, x/2 and y/2; their sum with 0, 10 and 4 rises by 5 and by 2.
/// let gradient = vademecum_eval::gradient_on_triangle(&corners, &[0.0, 10.0, 4.0]);
/// assert_eq!(gradient, [5.0, 2.0, 0.0]);
/// ```
#[must_use]
pub fn gradient_on_triangle(corners: &[[f64; 3]; 3], of_weights: &[f64; 3]) -> [f64; 3] {
    let [a, b, c] = *corners;
    let normal = cross(minus(b, a), minus(c, a));
    let square = dot(normal, normal);
    if square == 0.0 {
        return [0.0; 3];
    }
    // The gradient of a weight is the opposite edge, turned in the plane, over twice the area.
    let edges = [minus(c, b), minus(a, c), minus(b, a)];
    edges
        .into_iter()
        .zip(of_weights)
        .fold([0.0; 3], |sum, (edge, own)| add(sum, own / square, cross(normal, edge)))
}
