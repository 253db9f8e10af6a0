//! Types that cross the boundary.

use core::ffi::c_char;

/// Version of this interface: callers compare it with the header they were compiled with. `VDM_ABI` 4 holds:
/// later versions add calls and change none.
pub const VDM_ABI: u32 = 4;

/// Largest number of nodes of a place.
pub const VDM_MAX_PLACE_NODES: usize = 16;

/// `VdmPlace.frame` of a place that is a list of nodes.
pub const VDM_NO_FRAME: u32 = u32::MAX;

/// Result of a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmStatus {
    /// Done; the body moves or is loaded.
    VDM_OK = 0,
    /// Done; the body is at rest and further steps cost nothing.
    VDM_AT_REST = 1,
    /// Done; the state that was restored was saved at other parameters or in another precision: displacement
    /// and velocity are what they were.
    VDM_CARRIED = 2,
    /// A pointer is null or not aligned, or an index or a name is not the file's.
    VDM_ARGUMENT = -1,
    /// Lent memory is too short or not aligned to 16 bytes.
    VDM_MEMORY = -2,
    /// The bytes are no vademecum file that can be stepped.
    VDM_FILE = -3,
    /// The file does not allow these options or this value.
    VDM_BIND = -4,
    /// The load is refused: not finite, or at a place that is not loadable.
    VDM_LOAD = -5,
    /// The step is refused; the state is unchanged.
    VDM_STEP = -6,
    /// The file does not hold what is asked for.
    VDM_OUTPUT = -7,
    /// The bytes are no saved state of this body.
    VDM_STATE = -8,
    /// The world cannot have this member, pair or joint, or an option is not finite or negative.
    VDM_WORLD = -9,
}

/// In which numbers a body is stepped.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmPrecision {
    /// `float`: half the memory, and twice as fast.
    VDM_SINGLE = 0,
    /// `double`.
    VDM_DOUBLE = 1,
}

/// Structure of a step: the values of `structure`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmStructure {
    /// The exact one if the file was built for it, else the cheapest that keeps the tolerance.
    VDM_AUTO = 0,
    /// One 3 by 3 block for each mode.
    VDM_DIAGONAL = 1,
    /// One dense map, for live regions.
    VDM_BLOCK = 2,
    /// One 2 by 2 block for each mode, without error of time.
    VDM_EXACT = 3,
    /// Large displacements.
    VDM_STRAIN = 4,
}

/// Displacement or velocity; what calls name `field`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmField {
    /// m.
    VDM_DISPLACEMENT = 0,
    /// m/s.
    VDM_VELOCITY = 1,
}

/// Kinds of named things in a file: the values of `kind`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmNamed {
    /// Probes.
    VDM_PROBES = 0,
    /// Load patterns.
    VDM_PATTERNS = 1,
    /// Live parameters.
    VDM_PARAMETERS = 2,
    /// Supports whose reactions the file gives.
    VDM_SUPPORTS = 3,
    /// Ports, where joints of a world hold.
    VDM_PORTS = 4,
}

/// Options of binding a body. Fill it with `vdm_default_options` first.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VdmOptions {
    /// In which numbers the body is stepped: a `VdmPrecision`.
    pub precision: i32,
    /// Structure of a step: a `VdmStructure`.
    pub structure: i32,
    /// For so many contacts with nodes of their own there is room in the residual flexibility.
    pub contacts: u32,
    /// With `beta`: filtered forces of so many nodes are kept for the residual flexibility; 0: of all
    /// loadable nodes. A node counts until its filtered force is below 1e-12 of the largest.
    pub filtered_nodes: u32,
    /// 0: outputs show the modes only.
    pub residual: u32,
    /// `vdm_compliance` and `vdm_free_motion` take so many places at most.
    pub places: u32,
    /// Not 0: there is room for `vdm_keep_loads`.
    pub keep_loads: u32,
    /// Not 0: there is room for `vdm_solve_statics`, where the file has the factor of its stiffness.
    pub static_field: u32,
    /// Not 0: a body without supports flies, and `vdm_step` moves its frame, too. 0: the host moves the frame
    /// and gives its angular velocity to `vdm_push_spin`.
    pub flight: u32,
    /// Of the separated solution only the first so many terms; 0: all.
    pub terms: u32,
    /// Sub-steps of a step at large displacements; 0: those the file was built with.
    pub substeps: u32,
    /// Modes that are stepped of a file with live regions; 0: 32, or all of fewer.
    pub modes: u32,
    /// Relative error of a trajectory that `VDM_AUTO` accepts.
    pub tolerance: f64,
    /// Step in s; 0: the file's.
    pub time_step: f64,
    /// Factor on the stiffness of the whole body.
    pub stiffness: f64,
    /// Factor on the density of the whole body.
    pub density: f64,
    /// Rayleigh damping by mass, in 1/s; negative: the file's.
    pub alpha: f64,
    /// Rayleigh damping by stiffness, in s; negative: the file's.
    pub beta: f64,
    /// An unloaded body whose state sums up to less is put at rest.
    pub rest_below: f64,
    /// Numerical viscosity of strain rows at large displacements; 0 keeps the energy exactly.
    pub viscosity: f64,
}

/// Sizes of the memory to lend, and counts of the file.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmNeeds {
    /// Bytes for the body, aligned to 16, for as long as it is used.
    pub memory: usize,
    /// Modes; of a file with live regions those that are stepped.
    pub modes: u32,
    /// Nodes of the body; those of the surface come first.
    pub nodes: u32,
    /// Nodes of the surface.
    pub surface_nodes: u32,
    /// Nodes that can be loaded; they come first.
    pub load_nodes: u32,
    /// Triangles of the surface.
    pub triangles: u32,
    /// Triangles that can be touched; they come first.
    pub load_triangles: u32,
    /// Probes.
    pub probes: u32,
    /// Load patterns.
    pub patterns: u32,
    /// Live parameters.
    pub parameters: u32,
    /// Step, in s.
    pub time_step: f64,
}

/// A body, behind a handle.
pub struct VdmBody {
    _private: [u8; 0],
}

/// A place: a list of nodes with weights, and a radius; or a frame of the file.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmPlace {
    /// Number of nodes, 1 to `VDM_MAX_PLACE_NODES`; 0 of a frame.
    pub count: u32,
    /// The frame, or `VDM_NO_FRAME`. No file has frames yet, so others are refused.
    pub frame: u32,
    /// The nodes; those behind `count` do not matter.
    pub nodes: [u32; VDM_MAX_PLACE_NODES],
    /// Their weights, which sum to 1.
    pub weights: [f64; VDM_MAX_PLACE_NODES],
    /// Radius in m; 0 of a point. This version refuses a positive one.
    pub radius: f64,
    /// Position at rest, in m, as `vdm_locate` found it.
    pub position: [f64; 3],
    /// Distance from the point asked for, in m.
    pub distance: f64,
}

/// Mass, centre and moments of inertia of a free body.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmRigidBody {
    /// In kg.
    pub mass: f64,
    /// Its centre in m, in the coordinates of the file.
    pub centre: [f64; 3],
    /// Principal moments of inertia about the centre, in kg m².
    pub moments: [f64; 3],
    /// The principal axes in the coordinates of the file, one a row.
    pub axes: [[f64; 3]; 3],
}

/// The rigid motion of a free body.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmMotion {
    /// Position of the centre in space, in m.
    pub position: [f64; 3],
    /// Orientation: a quaternion of length one, the real part first, that turns directions of the
    /// body into those of space.
    pub attitude: [f64; 4],
    /// Momentum in space, in kg m/s.
    pub momentum: [f64; 3],
    /// Angular momentum about the centre, in space, in kg m²/s.
    pub angular_momentum: [f64; 3],
}

/// A live parameter.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmParameter {
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// The value that the file was built around.
    pub nominal: f64,
    /// The value that the body has now.
    pub value: f64,
    /// Not 0: its range is best walked in the logarithm.
    pub logarithmic: u32,
}

/// Energies of the last change of live parameters, in J.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmCarried {
    /// Kinetic energy that the stepped modes at the new values do not hold.
    pub lost_kinetic: f64,
    /// Elastic energy that they do not hold.
    pub lost_elastic: f64,
    /// Work of the change of stiffness on the displacement as it is.
    pub work: f64,
}

/// Cost of a step of a body. Bytes are those of the file, apart from `step_bytes`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmCost {
    /// Terms of the separated solution that binding adds up.
    pub terms: usize,
    /// Read by binding and by every change of a parameter.
    pub bind_bytes: usize,
    /// Multiply-adds of a step, which reads nothing of the file.
    pub step_operations: usize,
    /// Lent memory that a step reads or writes.
    pub step_bytes: usize,
    /// Rows that a contact reads when it is added.
    pub contact_rows: usize,
    /// Read when a contact is added.
    pub contact_bytes: usize,
    /// Read when a load pattern is added.
    pub pattern_bytes: usize,
    /// Read by one probe.
    pub probe_bytes: usize,
    /// Read by one node.
    pub node_bytes: usize,
    /// Read by the surface.
    pub surface_bytes: usize,
    /// Read by the whole body.
    pub body_bytes: usize,
}

/// Many instances of a body, behind a handle.
pub struct VdmBatch {
    _private: [u8; 0],
}

/// Result of a step of many instances.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmBatchStatus {
    /// Instances that moved or are loaded.
    pub moving: usize,
    /// Instances at rest.
    pub at_rest: usize,
    /// Instances whose new state would not be finite; they keep the old one.
    pub refused: usize,
}

/// A row of the table of quantities.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmQuantity {
    /// Its name.
    pub name: [c_char; 24],
    /// Its unit.
    pub unit: [c_char; 8],
    /// Unit of its velocity; empty where it has none.
    pub rate_unit: [c_char; 8],
    /// Not 0: one number is all of it.
    pub scalar: u32,
}
