//! Bricks with repeated corners, by which many programs write wedges, pyramids and tetrahedra.

use super::{ElementKind, FacetKind, Order};

/// Stands for the node in the middle of an edge that a file leaves out.
pub(crate) const MISSING: u32 = u32::MAX;

/// True if a corner of the element stands in it twice.
pub(crate) fn repeats_corner(kind: ElementKind, nodes: &[u32]) -> bool {
    let corners = &nodes[..kind.corners()];
    corners.iter().enumerate().any(|(i, corner)| corners[..i].contains(corner))
}

/// The element that is left of one with repeated corners, by its faces; `None` if it is no tetrahedron,
/// pyramid or wedge, or if an edge has two different nodes in its middle.
///
/// Middles of edges that are left out ([`MISSING`]) stay so.
pub(crate) fn collapsed(kind: ElementKind, nodes: &[u32]) -> Option<(ElementKind, Vec<u32>)> {
    let given = &nodes[kind.corners()..];
    let quadratic = kind.order() == Order::Quadratic;
    // Nodes in the middle of faces have no place in the element that is left.
    if given.len() != if quadratic { kind.edges().len() } else { 0 } {
        return None;
    }
    let faces = kind.faces().iter().filter_map(|face| remaining(face, nodes)).collect::<Vec<_>>();
    let corners = corners_of(&faces)?;
    let simpler = ElementKind::with_corners(corners.len(), kind.order())?;
    let mut all = corners.clone();
    if quadratic {
        let mut middles: Vec<([u32; 2], u32)> = Vec::with_capacity(given.len());
        for (ends, &middle) in kind.edges().iter().zip(given) {
            let ends = edge(ends.map(|end| nodes[end]));
            if ends[0] == ends[1] || middle == MISSING {
                continue;
            }
            match middles.iter().find(|(known, _)| *known == ends) {
                Some((_, known)) if *known != middle => return None,
                Some(_) => {}
                None => middles.push((ends, middle)),
            }
        }
        let middle = |ends: &[usize; 2]| {
            let ends = edge(ends.map(|end| corners[end]));
            middles.iter().find(|(known, _)| *known == ends).map_or(MISSING, |(_, middle)| *middle)
        };
        all.extend(simpler.edges().iter().map(middle));
    }
    Some((simpler, all))
}

/// Ends of an edge, ascending.
pub(crate) fn edge([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Name under which an element with repeated corners is refused.
pub(crate) fn repeated_name(kind: ElementKind) -> &'static str {
    match kind.corners() {
        4 => "tetrahedron with a repeated corner",
        5 => "pyramid with a repeated corner",
        6 => "wedge with repeated corners that is neither a pyramid nor a tetrahedron",
        _ => "hexahedron with repeated corners that is no wedge, pyramid or tetrahedron",
    }
}

/// Note on elements that were replaced.
pub(crate) fn note(count: usize) -> String {
    format!("{count} elements with repeated corners are read as the wedges, pyramids or tetrahedra they are")
}

/// Corners of a face without repeats, in turn; none of a face that has become a line or a point.
fn remaining((facet, places): &(FacetKind, &[usize]), nodes: &[u32]) -> Option<Vec<u32>> {
    let mut ring: Vec<u32> = places[..facet.corners()].iter().map(|&place| nodes[place]).collect();
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    Some(ring).filter(|ring| ring.len() > 2)
}

/// Corners of the element with these faces, in the order of its kind.
fn corners_of(faces: &[Vec<u32>]) -> Option<Vec<u32>> {
    let directed = |face: &'_ Vec<u32>| -> Vec<[u32; 2]> {
        (0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]]).collect()
    };
    let edges: Vec<[u32; 2]> = faces.iter().flat_map(directed).collect();
    // Closed: every edge once in each sense.
    let once = |edge: [u32; 2]| edges.iter().filter(|&&other| other == edge).count() == 1;
    if !edges.iter().all(|&[a, b]| a != b && once([a, b]) && once([b, a])) {
        return None;
    }
    let mut distinct: Vec<u32> = faces.concat();
    distinct.sort_unstable();
    distinct.dedup();
    let (quads, triangles): (Vec<_>, Vec<_>) = faces.iter().partition(|face| face.len() == 4);
    let beyond = |base: &[u32]| distinct.iter().copied().find(|node| !base.contains(node));
    // Faces are seen from outside, the first one of each kind from inside.
    match (quads.as_slice(), triangles.as_slice(), distinct.len()) {
        ([], [first, ..], 4) if triangles.len() == 4 => {
            let [a, b, c] = first[..] else { return None };
            Some(vec![a, c, b, beyond(first)?])
        }
        ([base], [..], 5) if triangles.len() == 4 => {
            let [a, b, c, d] = base[..] else { return None };
            Some(vec![a, d, c, b, beyond(base)?])
        }
        ([_, _, _], [first, _], 6) => {
            let [a, b, c] = first[..] else { return None };
            let above = |node: u32| {
                edges.iter().find(|[from, to]| *from == node && !first.contains(to)).map(|e| e[1])
            };
            Some(vec![a, c, b, above(a)?, above(c)?, above(b)?])
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(corners: [u32; 8]) -> Option<(ElementKind, Vec<u32>)> {
        assert!(repeats_corner(ElementKind::Hex8, &corners));
        collapsed(ElementKind::Hex8, &corners)
    }

    #[test]
    fn bricks_become_what_is_left_of_them() {
        assert_eq!(linear([0, 1, 2, 2, 4, 5, 6, 6]), Some((ElementKind::Wedge6, vec![0, 1, 2, 4, 5, 6])));
        assert_eq!(linear([0, 1, 2, 3, 4, 4, 4, 4]), Some((ElementKind::Pyramid5, vec![0, 1, 2, 3, 4])));
        assert_eq!(linear([0, 1, 2, 2, 4, 4, 4, 4]), Some((ElementKind::Tet4, vec![0, 1, 2, 4])));
        // Two edges of the wedge collapsed, and one.
        assert_eq!(linear([0, 1, 2, 2, 0, 1, 6, 6]), Some((ElementKind::Tet4, vec![0, 1, 2, 6])));
        assert_eq!(linear([0, 1, 2, 2, 0, 5, 6, 6]).map(|found| found.0), Some(ElementKind::Pyramid5));
        // A side collapsed to an edge.
        assert_eq!(linear([0, 1, 2, 3, 0, 5, 6, 3]), Some((ElementKind::Wedge6, vec![0, 5, 1, 3, 6, 2])));
        // Seven corners, a flat brick, a brick in a knot, a single point.
        for corners in [[0, 1, 2, 3, 4, 5, 6, 6], [0, 1, 2, 3, 0, 1, 2, 3], [0, 1, 0, 1, 4, 5, 4, 5], [7; 8]]
        {
            assert_eq!(linear(corners), None, "{corners:?}");
        }
        let wedge = [0, 1, 2, 3, 3, 3];
        assert_eq!(collapsed(ElementKind::Wedge6, &wedge), Some((ElementKind::Tet4, vec![0, 1, 2, 3])));
        assert_eq!(collapsed(ElementKind::Tet4, &[0, 1, 1, 2]), None);
        assert!(!repeats_corner(ElementKind::Tet4, &[0, 1, 3, 2]));
    }

    /// A brick of the second order by its corners; the middle of `ab` is `100 + 10 a + b`.
    fn quadratic(corners: [u32; 8]) -> Vec<u32> {
        let middle = |ends: &[usize; 2]| {
            let [a, b] = edge(ends.map(|end| corners[end]));
            if a == b { a } else { 100 + 10 * a + b }
        };
        corners.into_iter().chain(ElementKind::Hex20.edges().iter().map(middle)).collect()
    }

    #[test]
    fn middles_of_the_remaining_edges_stay() {
        let cases = [
            ([0, 1, 2, 2, 4, 5, 6, 6], ElementKind::Wedge15),
            ([0, 1, 2, 3, 4, 4, 4, 4], ElementKind::Pyramid13),
            ([0, 1, 2, 2, 4, 4, 4, 4], ElementKind::Tet10),
        ];
        for (corners, kind) in cases {
            let (found, nodes) = collapsed(ElementKind::Hex20, &quadratic(corners)).unwrap();
            assert_eq!(found, kind);
            for (ends, middle) in kind.edges().iter().zip(&nodes[kind.corners()..]) {
                let [a, b] = edge(ends.map(|end| nodes[end]));
                assert_eq!(*middle, 100 + 10 * a + b, "{kind:?}");
            }
        }
        let mut nodes = quadratic([0, 1, 2, 2, 4, 5, 6, 6]);
        nodes[18] = MISSING;
        assert!(!collapsed(ElementKind::Hex20, &nodes).unwrap().1.contains(&MISSING));
        nodes[19] = MISSING;
        assert_eq!(collapsed(ElementKind::Hex20, &nodes).unwrap().1[14], MISSING);
        // One edge with two middles.
        (nodes[18], nodes[19]) = (150, 151);
        assert_eq!(collapsed(ElementKind::Hex20, &nodes), None);
        let cubic: Vec<u32> = quadratic([0, 1, 2, 2, 4, 5, 6, 6]).into_iter().chain(200..207).collect();
        assert_eq!(collapsed(ElementKind::Hex27, &cubic), None);
    }
}
