//! Parts of a proposal that a deck gives.

/// Materials and supports that are known, as a problem file writes them.
#[derive(Clone, Debug)]
pub struct KnownParts {
    /// True if numbers are in units of their own.
    pub own_units: bool,
    /// Tables of materials.
    pub materials: String,
    /// Tables of attachments.
    pub attachments: String,
    /// Tables of load patterns.
    pub patterns: String,
    /// Lines of the damping; absent: that of the deck is none.
    pub damping: Option<String>,
    /// Tables of probes.
    pub probes: String,
    /// Time step \[s\].
    pub time_step: Option<f64>,
    /// Number of modes of a sum of modes, which has no residual flexibility.
    pub modes: Option<usize>,
    /// Description of the materials.
    pub material_words: String,
    /// Selections, and components if not all are held.
    pub supports: Vec<String>,
    /// Description of the supports.
    pub support_words: String,
    /// Lines of comments.
    pub comments: Vec<String>,
}
