//! One stage of the scheme as it is given to the engine, and how well the engine did.

use faer::Mat;

/// Coordinates of one kind: all ζ, all ζ̇, or the third family of the stage.
#[derive(Clone, Debug)]
pub struct StateFamily {
    /// Name of the axes, to which the number of the mode is added.
    pub name: String,
    /// Unit of the unscaled coordinate.
    pub unit: String,
    /// Range of each coordinate in its unit, as the snapshots give it.
    pub ranges: Vec<(f64, f64)>,
    /// Factor that makes the coordinate a scaled one: 1, Δt or Δt².
    pub scale: f64,
    /// Right-hand sides per unit of the *scaled* coordinate, `(n_rows, n_modes)`: `(h_M M + h_K K) φ_j`.
    pub columns: Mat<f64>,
}

/// One stage to be separated, in the form `A u = …` multiplied by Δt², as the scheme table has it.
#[derive(Clone, Debug)]
pub struct ChapterStage {
    /// The three families, in the order of the state.
    pub families: Vec<StateFamily>,
    /// Range of the load's magnitude, N. It should hold 0, a body without load.
    pub magnitude: (f64, f64),
    /// Ranges of the load's components, each an axis; empty when every position has its one direction.
    pub components: Vec<(f64, f64)>,
    /// Right-hand sides of a unit load, `(n_rows, n_positions · max(1, components))`, components of a
    /// position adjacent.
    pub loads: Mat<f64>,
    /// Points of a hat grid on a state axis, at least 2. (Magnitude and components have 2: the map is
    /// linear.)
    pub points: usize,
}

/// Relative errors of a stage map, in the energy norm given, over 200 fresh random points of the box: root
/// mean square of the error over root mean square of the exact map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageError {
    /// State and load together.
    pub total: f64,
    /// Without load; NaN when the magnitude cannot be 0.
    pub state: f64,
    /// Load on a body at rest; NaN when a coordinate cannot be 0.
    pub load: f64,
}
