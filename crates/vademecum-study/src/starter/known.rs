//! Parts of a proposal that a deck gives.

/// Materials and supports that are known, as a problem file writes them.
#[derive(Clone, Debug)]
pub struct KnownParts {
    /// Tables of materials.
    pub materials: String,
    /// Description of the materials.
    pub material_words: String,
    /// Selections, and components if not all are held.
    pub supports: Vec<String>,
    /// Description of the supports.
    pub support_words: String,
    /// Lines of comments.
    pub comments: Vec<String>,
}
