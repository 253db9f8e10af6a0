//! A place on a body: a short list of nodes with weights, where a force acts or a motion is read.

use core::fmt;

/// Largest number of nodes of a place.
pub const MAX_PLACE_NODES: usize = 16;

/// Largest size of a weight: a point further outside of its triangle is a mistake, and its numbers overflow.
const MAX_WEIGHT: f64 = 1e6;

/// Largest distance of the sum of weights from 1: printed weights, and those in single precision, pass.
const WEIGHT_TOLERANCE: f64 = 1e-6;

/// Frame number of a place that is a list of nodes.
const NO_FRAME: u32 = u32::MAX;

/// A short list of nodes with weights that sum to 1, and a radius; or a frame of the file.
///
/// A point of a triangle has three nodes, one of a quadrangle four, eight or nine. Radius 0 is a point. A
/// positive radius and frames are part of the interface and refused by this version. Whoever is given a place
/// checks it: a place in hand may be wrong. Its layout is that of C, so that an interface of C can hand its
/// own places over without a copy; every value of its numbers is allowed.
///
/// ```
/// use vademecum_eval::{Place, PlaceError};
///
/// let middle = Place::new(&[3, 4, 7, 8], &[0.25; 4])?;
/// assert_eq!(middle.nodes(), [3, 4, 7, 8]);
/// assert_eq!(Place::new(&[3, 4], &[0.5, 0.4]), Err(PlaceError::Sum { sum: 0.9 }));
/// # Ok::<(), PlaceError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Place {
    count: u32,
    frame: u32,
    nodes: [u32; MAX_PLACE_NODES],
    weights: [f64; MAX_PLACE_NODES],
    radius: f64,
}

impl Place {
    const EMPTY: Self = Self {
        count: 0,
        frame: NO_FRAME,
        nodes: [0; MAX_PLACE_NODES],
        weights: [0.0; MAX_PLACE_NODES],
        radius: 0.0,
    };

    /// A point between nodes, with a weight for each.
    ///
    /// # Errors
    /// [`PlaceError`].
    pub fn new(nodes: &[u32], weights: &[f64]) -> Result<Self, PlaceError> {
        if nodes.len() != weights.len() {
            return Err(PlaceError::Uneven { nodes: nodes.len(), weights: weights.len() });
        }
        if nodes.len() > MAX_PLACE_NODES {
            return Err(PlaceError::TooManyNodes { found: nodes.len() });
        }
        let mut place = Self { count: nodes.len() as u32, ..Self::EMPTY };
        place.nodes.iter_mut().zip(nodes).for_each(|(to, &from)| *to = from);
        place.weights.iter_mut().zip(weights).for_each(|(to, &from)| *to = from);
        place.check()?;
        Ok(place)
    }

    /// A point of a triangle, with its barycentric weights.
    #[must_use]
    pub const fn triangle([a, b, c]: [u32; 3], [u, v, w]: [f64; 3]) -> Self {
        let mut place = Self { count: 3, ..Self::EMPTY };
        (place.nodes[0], place.nodes[1], place.nodes[2]) = (a, b, c);
        (place.weights[0], place.weights[1], place.weights[2]) = (u, v, w);
        place
    }

    /// A node.
    #[must_use]
    pub const fn node(node: u32) -> Self {
        let mut place = Self { count: 1, ..Self::EMPTY };
        (place.nodes[0], place.weights[0]) = (node, 1.0);
        place
    }

    /// A frame of the file, by its number.
    #[must_use]
    pub const fn frame(index: u32) -> Self {
        Self { frame: index, ..Self::EMPTY }
    }

    /// The same place with a radius \[m\].
    #[must_use]
    pub const fn with_radius(self, radius: f64) -> Self {
        Self { radius, ..self }
    }

    /// Its nodes, in file order; none of a frame.
    #[must_use]
    #[inline]
    pub fn nodes(&self) -> &[u32] {
        self.nodes.get(..self.count as usize).unwrap_or_default()
    }

    /// The weight of each node.
    #[must_use]
    #[inline]
    pub fn weights(&self) -> &[f64] {
        self.weights.get(..self.count as usize).unwrap_or_default()
    }

    /// Nodes and weights.
    #[inline]
    pub fn entries(&self) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        self.nodes().iter().copied().zip(self.weights().iter().copied())
    }

    /// Nodes and weights as those of a triangle, with weights of zero where there are fewer than three nodes;
    /// `None` of a place with more.
    #[must_use]
    pub fn corners(&self) -> Option<([u32; 3], [f64; 3])> {
        let mut corners = ([0; 3], [0.0; 3]);
        let places = corners.0.iter_mut().zip(&mut corners.1);
        for ((node, weight), entry) in places.zip(self.entries()) {
            (*node, *weight) = entry;
        }
        (1..=3).contains(&self.count).then_some(corners)
    }

    /// Its radius \[m\].
    #[must_use]
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// The number of its frame, if it is one.
    #[must_use]
    pub const fn frame_index(&self) -> Option<u32> {
        if self.frame == NO_FRAME { None } else { Some(self.frame) }
    }

    /// Refuses a place that no force can act on and nothing can be read of.
    ///
    /// # Errors
    /// [`PlaceError`].
    #[inline]
    pub fn check(&self) -> Result<(), PlaceError> {
        let (mut sum, mut size) = (0.0, 0.0);
        for weight in self.weights() {
            sum += weight;
            size += weight.abs();
        }
        // Not a number fails every comparison, so it is not sound.
        let sound = (sum - 1.0).abs() <= WEIGHT_TOLERANCE && size <= MAX_WEIGHT;
        let sound = sound && self.radius == 0.0 && self.frame == NO_FRAME;
        if sound { Ok(()) } else { Err(self.refusal(sum)) }
    }

    #[cold]
    fn refusal(&self, sum: f64) -> PlaceError {
        if let Some(index) = self.frame_index() {
            return PlaceError::NoFrames { index };
        }
        if self.count == 0 {
            return PlaceError::Empty;
        }
        if !self.weights().iter().all(|weight| weight.abs() <= MAX_WEIGHT) {
            return PlaceError::NotFinite;
        }
        if self.radius > 0.0 {
            return PlaceError::Area { radius: self.radius };
        }
        if self.radius == 0.0 { PlaceError::Sum { sum } } else { PlaceError::Radius { radius: self.radius } }
    }
}

impl AsRef<Self> for Place {
    fn as_ref(&self) -> &Self {
        self
    }
}

/// Why a place is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlaceError {
    /// It has no nodes.
    Empty,
    /// It has more nodes than [`MAX_PLACE_NODES`].
    TooManyNodes {
        /// Nodes given.
        found: usize,
    },
    /// There is not one weight for each node.
    Uneven {
        /// Nodes given.
        nodes: usize,
        /// Weights given.
        weights: usize,
    },
    /// A weight is not finite or above 1e6 in size.
    NotFinite,
    /// The weights do not sum to 1 within 1e-6.
    Sum {
        /// Their sum.
        sum: f64,
    },
    /// The radius is negative or not a number.
    Radius {
        /// The radius.
        radius: f64,
    },
    /// The radius is positive, and this version takes points only.
    Area {
        /// The radius.
        radius: f64,
    },
    /// The file has no frames.
    NoFrames {
        /// The frame asked for.
        index: u32,
    },
    /// A moment was given for a list of nodes.
    Moment,
}

impl fmt::Display for PlaceError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Empty => write!(out, "a place without nodes: it needs 1 to {MAX_PLACE_NODES}"),
            Self::TooManyNodes { found } => {
                write!(out, "a place of {found} nodes: at most {MAX_PLACE_NODES} are taken")
            }
            Self::Uneven { nodes, weights } => {
                write!(out, "a place of {nodes} nodes and {weights} weights: each node needs one weight")
            }
            Self::NotFinite => write!(out, "a weight of the place is not finite or above 1e6 in size"),
            Self::Sum { sum } => write!(out, "the weights of the place sum to {sum}, expected 1"),
            Self::Radius { radius } => {
                write!(out, "a place of radius {radius} m: expected 0 for a point, or a positive number")
            }
            Self::Area { radius } => {
                write!(out, "a place of radius {radius} m: this version takes points only, radius 0")
            }
            Self::NoFrames { index } => write!(out, "frame {index}: this file has no frames"),
            Self::Moment => {
                write!(out, "a moment acts on a frame, and this place is a list of nodes")
            }
        }
    }
}

impl core::error::Error for PlaceError {}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::string::ToString;

    #[test]
    fn each_wrong_place_is_refused_in_its_own_words() {
        let point = Place::triangle([1, 2, 3], [0.2, 0.3, 0.5]);
        let refused = [
            (Place::new(&[], &[]), PlaceError::Empty),
            (Place::new(&[0; 17], &[1.0; 17]), PlaceError::TooManyNodes { found: 17 }),
            (Place::new(&[0; 2], &[1.0]), PlaceError::Uneven { nodes: 2, weights: 1 }),
            (Place::new(&[0; 2], &[1.0, f64::NAN]), PlaceError::NotFinite),
            (Place::new(&[0; 2], &[1.0, f64::INFINITY]), PlaceError::NotFinite),
            (Place::new(&[0; 3], &[1.0, 1e300, -1e300]), PlaceError::NotFinite),
            (Place::new(&[0; 2], &[1.0, 1.0]), PlaceError::Sum { sum: 2.0 }),
            (point.with_radius(-1.0).check().map(|()| point), PlaceError::Radius { radius: -1.0 }),
            (point.with_radius(0.01).check().map(|()| point), PlaceError::Area { radius: 0.01 }),
            (Place::frame(2).check().map(|()| point), PlaceError::NoFrames { index: 2 }),
        ];
        let mut words = std::vec::Vec::new();
        for (found, expected) in refused {
            assert_eq!(found, Err(expected));
            words.push(expected.to_string());
        }
        assert!(matches!(point.with_radius(f64::NAN).check(), Err(PlaceError::Radius { .. })));
        words.sort();
        words.dedup();
        assert_eq!(words.len(), 8);
    }

    #[test]
    fn sixteen_nodes_and_rounded_weights_are_a_place() {
        let nodes: [u32; MAX_PLACE_NODES] = core::array::from_fn(|k| k as u32);
        let place = Place::new(&nodes, &[1.0 / 16.0; MAX_PLACE_NODES]).expect("a place");
        assert_eq!(place.nodes(), nodes);
        assert_eq!(place.corners(), None);
        let rounded = Place::new(&[0, 1, 2], &[0.333_333_3; 3]).expect("a place");
        assert_eq!(rounded.corners(), Some(([0, 1, 2], [0.333_333_3; 3])));
        assert_eq!(Place::node(7).corners(), Some(([7, 0, 0], [1.0, 0.0, 0.0])));
    }
}
