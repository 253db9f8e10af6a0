//! Interfaces of a superelement, as a command names them: `NAME`, `NAME=KIND` or `NAME={ … }` in the language
//! of the problem file.

use schemars::JsonSchema;
use serde::Deserialize;

use super::toml_file::{self, TomlError};
use crate::mesh::select::Selection;

/// Origin of the text, for messages.
const PATH: &str = "--interface";

/// An interface of a superelement.
#[derive(Clone, Debug)]
pub struct InterfaceEntry {
    /// Its name; without `on` that of a port of the problem or of a group of the mesh.
    pub name: String,
    /// Its kind, where it is given.
    pub kind: Option<InterfaceKind>,
    /// Its nodes.
    pub on: Option<Selection>,
    /// Origin of a frame; absent: the centre of its nodes.
    pub at: Option<[f64; 3]>,
    /// Directions of the first and the second axis of a frame, perpendicular; absent: those of space.
    pub axes: Option<[[f64; 3]; 2]>,
}

/// Kind of an interface.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum InterfaceKind {
    /// Three displacements of each node of facets of the surface.
    Patch,
    /// Three displacements of each node.
    Nodes,
    /// Six motions of a frame that the nodes follow as a rigid body does (RBE2).
    Rigid,
    /// Six motions of a frame that follows the mean motion of facets (RBE3).
    Average,
}

impl InterfaceKind {
    const ALL: [Self; 4] = [Self::Patch, Self::Nodes, Self::Rigid, Self::Average];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Patch => "patch",
            Self::Nodes => "nodes",
            Self::Rigid => "rigid",
            Self::Average => "average",
        }
    }
}

/// Keys of an interface.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Keys {
    kind: Option<InterfaceKind>,
    on: Option<Selection>,
    at: Option<[f64; 3]>,
    axes: Option<[[f64; 3]; 2]>,
}

/// The text as a table of one key.
#[derive(Deserialize, JsonSchema)]
struct Text {
    interface: Keys,
}

impl InterfaceEntry {
    /// Reads the text of a command.
    ///
    /// # Errors
    /// [`TomlError::Malformed`]: what was found, and the three forms.
    pub fn parse(text: &str) -> Result<Self, TomlError> {
        let (name, rest) = text.split_once('=').unwrap_or((text, ""));
        let (name, rest) = (name.trim(), rest.trim());
        let refused = |message: String| TomlError::Malformed { path: PATH.into(), message };
        if name.is_empty() || name.contains(['"', '\n', ',', '{']) {
            let message = format!("`{text}` has no name; expected NAME, NAME=KIND or NAME={{ on = … }}");
            return Err(refused(message));
        }
        let none = Self { name: name.into(), kind: None, on: None, at: None, axes: None };
        if !text.contains('=') {
            return Ok(none);
        }
        if !rest.starts_with('{') {
            let kind = InterfaceKind::ALL.into_iter().find(|kind| kind.word() == rest.trim_matches('"'));
            let expected = "expected patch, nodes, rigid or average, or keys in braces";
            let refused = || refused(format!("`{rest}` is no kind of an interface; {expected}"));
            return Ok(Self { kind: Some(kind.ok_or_else(refused)?), ..none });
        }
        let found: Text = toml_file::parse(&format!("interface = {rest}"), PATH)?;
        let Keys { kind, on, at, axes } = found.interface;
        Ok(Self { kind, on, at, axes, ..none })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_forms_are_read_and_others_refused() {
        let bare = InterfaceEntry::parse("x_min").unwrap();
        assert!((bare.name.as_str(), bare.kind, bare.on.is_none()) == ("x_min", None, true));
        let kind = InterfaceEntry::parse("pin = rigid").unwrap();
        assert_eq!((kind.name.as_str(), kind.kind), ("pin", Some(InterfaceKind::Rigid)));
        let text = "pin={ kind = \"average\", on = { group = \"x_min\" }, at = [0, 1.0, 2] }";
        let keys = InterfaceEntry::parse(text).unwrap();
        assert_eq!((keys.kind, keys.at), (Some(InterfaceKind::Average), Some([0.0, 1.0, 2.0])));
        assert_eq!(keys.on, Some(Selection::Group("x_min".into())));
        for (text, words) in [
            ("= rigid", "has no name"),
            ("pin=soft", "`soft` is no kind of an interface; expected patch, nodes, rigid or average"),
            ("pin={ kind = \"soft\" }", "unknown variant `soft`"),
            ("pin={ where = 1 }", "unknown field `where`"),
            ("pin={ on = ", "--interface"),
        ] {
            let refused = InterfaceEntry::parse(text).unwrap_err().to_string();
            assert!(refused.contains(words), "{text}: {refused}");
        }
    }
}
