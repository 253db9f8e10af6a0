//! What a scene is asked for, and how much memory it wants for it.

/// The two ways a step can be held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// One 3×3 block per mode: `9r` multiply-adds.
    Diagonal,
    /// One dense map: `9r²` multiply-adds.
    Block,
}

/// Which structure a scene shall take.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StructureChoice {
    /// The cheapest whose certificate keeps the tolerance, or else the one with the smaller certified error.
    #[default]
    Auto,
    /// The diagonal one.
    Diagonal,
    /// The block one.
    Block,
}

/// What a scene is bound to; [`SceneOptions::default`] is the file as it was built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneOptions {
    /// Structure of the step.
    pub structure: StructureChoice,
    /// Trajectory error (relative, as in the certificate) that [`StructureChoice::Auto`] accepts. A structure within 1.1 times
    /// its projection floor + 1e-6 is accepted in any case: no structure on this basis does better.
    pub tolerance: f64,
    /// `Δt` \[s\]; the file's if `None`.
    pub time_step: Option<f64>,
    /// Scale of the stiffness.
    pub stiffness: f64,
    /// Scale of the density.
    pub density: f64,
    /// Rayleigh `α` \[1/s\]; the file's if `None`.
    pub alpha: Option<f64>,
    /// Rayleigh `β` \[s\]; the file's if `None`.
    pub beta: Option<f64>,
    /// An unloaded body is put at rest once the sum of its `3r` absolute state numbers \[m kg^½\] is at or below this. With 0 it
    /// rests when every number has fallen below [`Scalar::FLOOR`](crate::Scalar::FLOOR).
    pub rest_below: f64,
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self {
            structure: StructureChoice::Auto,
            tolerance: 0.0,
            time_step: None,
            stiffness: 1.0,
            density: 1.0,
            alpha: None,
            beta: None,
            rest_below: 0.0,
        }
    }
}

/// How much memory to lend, in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Of `T`, to the scene.
    pub scene: usize,
    /// Of `f64`, to [`Scene::bind`](crate::Scene::bind) while it runs.
    pub work: usize,
    /// Of `T`, to each [`State`](crate::State).
    pub state: usize,
    /// Of `T`, to each [`Loads`](crate::Loads).
    pub loads: usize,
}

/// What a step found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// The body moves or is loaded.
    Moving,
    /// The body is unloaded and at rest: its state is zero and further steps cost nothing.
    AtRest,
}
