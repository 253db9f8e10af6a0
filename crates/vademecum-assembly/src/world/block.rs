//! The surface of a box.

/// Corners and triangles of a box from the origin on; the triangles turn counterclockwise from outside.
pub(crate) fn block(lengths: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let corner = |i: u32| std::array::from_fn(|k| if i >> k & 1 == 1 { lengths[k] } else { 0.0 });
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = squares.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    ((0..8).map(corner).collect(), halves.collect())
}
