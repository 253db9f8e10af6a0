//! Nodes of an element.

/// Polynomial order of the displacement in an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// 4-node tetrahedra.
    Linear,
    /// 10-node tetrahedra, mid-side nodes on edges (0,1) (1,2) (2,0) (0,3) (1,3) (2,3).
    Quadratic,
}

impl Order {
    /// Nodes of one element.
    pub fn nodes_per_element(self) -> usize {
        match self {
            Order::Linear => 4,
            Order::Quadratic => 10,
        }
    }
}
