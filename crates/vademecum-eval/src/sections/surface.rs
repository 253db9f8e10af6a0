//! Finding the point of the loadable surface nearest to a point in space.
//!
//! Brute force over all loadable triangles, without an index: contacts are looked up when a hand or a tool
//! moves, and 10 000 triangles take a fraction of a millisecond. For more of them, and for the surface as it
//! has moved, there is [`SurfaceTree`](crate::SurfaceTree).

use crate::base::error::OutputError;
use crate::base::vec3::{dot, minus};
use crate::sections::place::Place;
use crate::sections::quadrangle::place_in;
use vademecum_format::{File, FormatError, Numbers, Quadrangles, SectionKind};

/// The loadable surface of a file, at rest.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'m> {
    coordinates: Numbers<'m>,
    n_nodes: usize,
    triangles: &'m [[u8; 4]],
    quadrangles: Quadrangles<'m>,
}

/// A point of the loadable surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Nodes of its facet and their shape functions there: of a triangle three, with the barycentric weights;
    /// of a quadrangle all that it has.
    pub place: Place,
    /// Its position \[m\], on a triangle. In a quadrangle that is warped, or whose edges are bent, `Σ w x`
    /// over the place lies beside it.
    pub position: [f64; 3],
    /// Distance \[m\] from the point that was asked for.
    pub distance: f64,
}

impl AsRef<Place> for SurfacePoint {
    fn as_ref(&self) -> &Place {
        &self.place
    }
}

impl<'m> Surface<'m> {
    /// The loadable surface of `file`.
    ///
    /// # Errors
    /// [`OutputError::Missing`] if coordinates or triangles are not in the file, or if these or the
    /// quadrangles are compressed; [`OutputError::OutOfRange`] if a triangle names a node that there is not,
    /// or a quadrangle one that is not loadable.
    pub fn new(file: &File<'m>) -> Result<Self, OutputError> {
        let metadata = file.metadata();
        Self::of(file, metadata.n_load_triangles, metadata.n_load_nodes)
    }

    /// The whole surface of `file`, the loadable triangles first: for a [`SurfaceTree`](crate::SurfaceTree)
    /// that knows what lies in front of what.
    ///
    /// # Errors
    /// As for [`Surface::new`].
    pub fn whole(file: &File<'m>) -> Result<Self, OutputError> {
        Self::of(file, u32::MAX, file.metadata().n_surface_nodes)
    }

    /// The first triangles, and the first nodes, among which theirs are.
    fn of(file: &File<'m>, n_triangles: u32, n_nodes: u32) -> Result<Self, OutputError> {
        let section = |kind| file.section(kind).ok_or(OutputError::Missing { kind });
        let missing = |kind| move |_| OutputError::Missing { kind };
        let kind = SectionKind::NodeCoordinates;
        let coordinates = section(kind)?.numbers().map_err(missing(kind))?;
        let kind = SectionKind::Triangles;
        let all = file.indices(kind).map_err(unusable(kind))?.ok_or(OutputError::Missing { kind })?;
        let triangles = all.get(..(n_triangles as usize).saturating_mul(3)).unwrap_or(all);
        let quadrangles = file.quadrangles().map_err(unusable(SectionKind::Quadrangles))?;
        Ok(Self { coordinates, n_nodes: n_nodes as usize, triangles, quadrangles })
    }

    /// The point of a triangle with these nodes and barycentric weights, shared over the nodes of the facet
    /// that the triangle is part of.
    pub(crate) fn place(&self, triangle: usize, nodes: [u32; 3], weights: [f64; 3]) -> Place {
        let facet = u32::try_from(triangle).ok().and_then(|triangle| self.quadrangles.of_triangle(triangle));
        let shared = facet.and_then(|facet| place_in(&facet, nodes, weights));
        shared.unwrap_or(Place::triangle(nodes, weights))
    }

    /// Its triangles.
    pub(crate) const fn n_triangles(&self) -> usize {
        self.triangles.len() / 3
    }

    /// Its nodes are among so many first ones of the file.
    pub(crate) const fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    /// Nodes of a triangle.
    pub(crate) fn triangle(&self, triangle: usize) -> Option<[u32; 3]> {
        self.triangles.as_chunks::<3>().0.get(triangle).map(|nodes| nodes.map(u32::from_le_bytes))
    }

    /// A coordinate at rest \[m\], three a node.
    pub(crate) fn coordinate(&self, at: usize) -> Option<f64> {
        self.coordinates.get(at)
    }

    /// The nearest point of the loadable surface at rest to `point` \[m\], however far away it is; `None` if
    /// nothing is loadable or `point` is not finite. [`Body::locate`](crate::Body::locate) refuses points
    /// beyond [`Surface::reach`].
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let bytes = BODY;
    /// let file = File::parse(bytes)?;
    /// let surface = Surface::new(&file)?;
    /// let above = surface.locate([0.0, 0.0, 0.25]).ok_or("nothing to touch")?;
    /// assert_eq!((above.position, above.distance), ([0.0; 3], 0.25));
    /// assert_eq!(above.place.weights().iter().sum::<f64>(), 1.0);
    /// assert_eq!(surface.locate([f64::NAN; 3]), None);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn locate(&self, point: [f64; 3]) -> Option<SurfacePoint> {
        let mut nearest = None;
        let mut reached = f64::INFINITY;
        for (index, triangle) in self.triangles.as_chunks::<3>().0.iter().enumerate() {
            let nodes = triangle.map(u32::from_le_bytes);
            let [Some(a), Some(b), Some(c)] = nodes.map(|node| self.node(node)) else {
                continue;
            };
            let weights = nearest_in_triangle(point, [a, b, c]);
            let position = [0, 1, 2].map(|i| weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i]);
            let away = minus(point, position);
            let distance = libm::sqrt(dot(away, away));
            // Not a number is not below, and neither is infinity.
            if distance < reached {
                reached = distance;
                nearest = Some((index, nodes, weights, position));
            }
        }
        let (index, nodes, weights, position) = nearest?;
        Some(SurfacePoint { place: self.place(index, nodes, weights), position, distance: reached })
    }

    /// Diagonal \[m\] of the box around all nodes of the file. A point that is further away from the surface
    /// is most likely in another unit.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.reach_from(f64::INFINITY)
    }

    /// The diagonal of the box around the first nodes, once it is at least `enough`; else [`Surface::reach`].
    /// So a point near the surface costs a few nodes.
    pub(crate) fn reach_from(&self, enough: f64) -> f64 {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut diagonal = 0.0;
        for node in (0..).map_while(|node| self.node(node)) {
            let corners = low.iter_mut().zip(&mut high).zip(node);
            corners.for_each(|((low, high), x)| (*low, *high) = (low.min(x), high.max(x)));
            let sides = minus(high, low);
            diagonal = libm::sqrt(dot(sides, sides));
            if diagonal >= enough {
                break;
            }
        }
        diagonal
    }

    fn node(&self, node: u32) -> Option<[f64; 3]> {
        let at = (node as usize).checked_mul(3)?;
        Some([
            self.coordinates.get(at)?,
            self.coordinates.get(at.checked_add(1)?)?,
            self.coordinates.get(at.checked_add(2)?)?,
        ])
    }
}

/// Why indices of a file cannot be used.
fn unusable(kind: SectionKind) -> impl Fn(FormatError) -> OutputError {
    move |error| match error {
        FormatError::Index { found, count, .. } => {
            OutputError::OutOfRange { index: found as usize, count: count as usize }
        }
        _ => OutputError::Missing { kind },
    }
}

/// Barycentric weights of the point of the triangle `a b c` nearest to `p`: the inside if the projection lies
/// there, else the best of the three edges. A triangle without area gives its edges' answer.
///
/// ```
/// use vademecum_eval::{nearest_in_triangle, Place};
///
/// let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// assert_eq!(nearest_in_triangle([0.5, -2.0, 7.0], triangle), [0.5, 0.5, 0.0]);
/// ```
#[must_use]
pub fn nearest_in_triangle(p: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (minus(b, a), minus(c, a), minus(p, a));
    let (bb, bc, cc) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));
    let (pb, pc) = (dot(ap, ab), dot(ap, ac));
    let area = bb * cc - bc * bc;
    let (v, w) = ((cc * pb - bc * pc) / area, (bb * pc - bc * pb) / area);
    if area > 0.0 && v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        return [1.0 - v - w, v, w];
    }
    let edges = [(a, b, [0, 1]), (b, c, [1, 2]), (c, a, [2, 0])];
    let mut best = ([1.0, 0.0, 0.0], f64::INFINITY);
    for (from, to, places) in edges {
        let (along, away) = (minus(to, from), minus(p, from));
        let share = (dot(along, away) / dot(along, along)).clamp(0.0, 1.0);
        let share = if share.is_finite() { share } else { 0.0 };
        let rest = minus(away, along.map(|x| share * x));
        if dot(rest, rest) < best.1 {
            let mut weights = [0.0; 3];
            weights[places[0]] = 1.0 - share;
            weights[places[1]] = share;
            best = (weights, dot(rest, rest));
        }
    }
    best.0
}
