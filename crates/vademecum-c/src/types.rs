//! What crosses the boundary.

/// Version of this interface: callers compare it with the header they were compiled with.
pub const VDM_ABI: u32 = 1;

/// What a call found.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmStatus {
    /// Done; the body moves or is loaded.
    VDM_OK = 0,
    /// Done; the body is at rest and further steps cost nothing.
    VDM_AT_REST = 1,
    /// A pointer is null, or an index or a name is not the file's.
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

/// Displacement or velocity; what calls name `field`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmField {
    /// m.
    VDM_DISPLACEMENT = 0,
    /// m/s.
    VDM_VELOCITY = 1,
}

/// What a file names; what calls name `kind`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmNamed {
    /// Probes.
    VDM_PROBES = 0,
    /// Load patterns.
    VDM_PATTERNS = 1,
    /// Live parameters.
    VDM_PARAMETERS = 2,
}

/// How a body is bound. Fill it with `vdm_default_options` first.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VdmOptions {
    /// In which numbers the body is stepped: a `VdmPrecision`.
    pub precision: i32,
    /// For so many contacts with nodes of their own there is room in the static residual.
    pub contacts: u32,
    /// 0: outputs show the modes only.
    pub residual: u32,
    /// An unloaded body whose state sums up to less is put at rest.
    pub rest_below: f64,
}

/// How much memory to lend, and what the file holds.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmNeeds {
    /// Bytes for the body, aligned to 16, for as long as it is used.
    pub memory: usize,
    /// Numbers of type `double`, while `vdm_bind` and `vdm_set_parameter` run.
    pub work: usize,
    /// Numbers that `vdm_save` writes.
    pub state: usize,
    /// Modes.
    pub modes: u32,
    /// Nodes of the body; those of the surface come first.
    pub nodes: u32,
    /// Nodes of the surface.
    pub surface_nodes: u32,
    /// Nodes that can be loaded; they come first.
    pub load_nodes: u32,
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

/// A place of the surface: three loadable nodes and their shares.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmPlace {
    /// Loadable nodes.
    pub nodes: [u32; 3],
    /// Their shares, which sum to 1.
    pub weights: [f64; 3],
    /// Where it is at rest, in m; what `vdm_locate` found.
    pub position: [f64; 3],
    /// How far that is from the point asked for, in m.
    pub distance: f64,
}
