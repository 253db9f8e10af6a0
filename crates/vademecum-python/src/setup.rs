//! Parts, pairs and joints of a world before it moves.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use vademecum_assembly::{
    AssemblyError, AssemblyFile, BoxEntry, ContactEntry, GivenPart, JointEntry, JointKind, NodesEntry,
    PartEntry, RigidEntry, WorldEntry, WorldSimulation,
};
use vademecum_eval::SceneOptions;

use crate::content::{Content, Shared};
use crate::refusal::{Refusal, unknown};

/// Words for a world that no file describes, in messages.
const NAME: &str = "the world";

/// Body of a part.
pub enum Own {
    /// A vademecum file, and options of its body.
    File(Arc<Content>, SceneOptions),
    /// A box from the origin on, of these lengths.
    Block([f64; 3]),
    /// Nodes and triangles of a closed surface.
    Surface(Vec<[f64; 3]>, Vec<[u32; 3]>),
}

impl Own {
    fn given(&self) -> GivenPart {
        match self {
            Self::File(content, options) => GivenPart::File(Box::new(Shared(Arc::clone(content))), *options),
            Self::Block(_) => GivenPart::Named,
            Self::Surface(nodes, triangles) => GivenPart::Surface(nodes.clone(), triangles.clone()),
        }
    }

    /// Its entry in an assembly file.
    fn rigid(&self, density: Option<f64>) -> Option<RigidEntry> {
        let entry = RigidEntry { block: None, surface: None, scale: 1.0, density };
        match self {
            Self::File(..) => None,
            Self::Block(lengths) => Some(RigidEntry { block: Some(BoxEntry { lengths: *lengths }), ..entry }),
            // The surface is at hand; the path of the entry is not read.
            Self::Surface(..) => Some(RigidEntry { surface: Some("arrays".into()), ..entry }),
        }
    }
}

/// Start of a part.
pub struct Start {
    pub position: [f64; 3],
    pub quaternion: [f64; 4],
    pub velocity: Option<[f64; 3]>,
    pub spin: Option<[f64; 3]>,
    pub density: Option<f64>,
}

/// A world that grows until it moves.
pub struct Setup {
    world: WorldEntry,
    parts: Vec<PartEntry>,
    own: Vec<Own>,
    joints: Vec<JointEntry>,
    contacts: Vec<ContactEntry>,
}

impl Setup {
    pub const fn new(world: WorldEntry) -> Self {
        Self { world, parts: vec![], own: vec![], joints: vec![], contacts: vec![] }
    }

    /// Adds a part and gives its name.
    pub fn add(&mut self, name: Option<String>, own: Own, start: &Start) -> PyResult<String> {
        let name = name.unwrap_or_else(|| format!("part{}", self.parts.len() + 1));
        let Start { position, quaternion, velocity, spin, density } = *start;
        let rigid = own.rigid(density);
        let file = if rigid.is_none() { "given".into() } else { Default::default() };
        self.parts.push(PartEntry {
            name: name.clone(),
            file,
            rigid,
            hash: None,
            parameters: BTreeMap::new(),
            position,
            rotation: quaternion,
            velocity,
            spin,
            copies: None,
            spacing: None,
            path: None,
            shake: None,
            entry: self.parts.len(),
        });
        self.own.push(own);
        let checked = self.file();
        if checked.is_err() {
            self.parts.pop();
            self.own.pop();
        }
        checked.map(|_| name)
    }

    /// Lets two parts touch.
    pub fn touch(
        &mut self,
        between: [String; 2],
        friction: f64,
        restitution: f64,
        nodes: &str,
    ) -> PyResult<()> {
        let nodes = match nodes {
            "both" => NodesEntry::Both,
            "first" => NodesEntry::First,
            "second" => NodesEntry::Second,
            _ => {
                let said = format!("nodes is `{nodes}`; expected `both`, `first` or `second`");
                return Err(PyValueError::new_err(said));
            }
        };
        self.known(&between)?;
        let entry = self.contacts.len();
        self.contacts.push(ContactEntry { between, friction, restitution, nodes, entry, is_meant: false });
        let checked = self.file();
        if checked.is_err() {
            self.contacts.pop();
        }
        checked.map(drop)
    }

    /// Joins two parts and gives the name of the joint.
    pub fn join(&mut self, kind: &str, entry: JointEntry) -> PyResult<String> {
        let kind = match kind {
            "ball" => JointKind::Ball,
            "hinge" => JointKind::Hinge,
            "slider" => JointKind::Slider,
            "cable" => JointKind::Cable,
            _ => {
                let said = format!("kind is `{kind}`; expected `ball`, `hinge`, `slider` or `cable`");
                return Err(PyValueError::new_err(said));
            }
        };
        let name = entry.name.unwrap_or_else(|| format!("joint{}", self.joints.len() + 1));
        let turns = kind != JointKind::Cable;
        self.joints.push(JointEntry { name: Some(name.clone()), kind, turns, ..entry });
        let checked = self.file();
        if checked.is_err() {
            self.joints.pop();
        }
        checked.map(|_| name)
    }

    fn known(&self, names: &[String]) -> PyResult<()> {
        let all: Vec<String> = self.parts.iter().map(|part| part.name.clone()).collect();
        names.iter().try_for_each(|name| {
            if all.contains(name) { Ok(()) } else { Err(unknown(NAME, "part", name, &all)) }
        })
    }

    pub const fn n_parts(&self) -> usize {
        self.parts.len()
    }

    /// The entries as an assembly file, checked.
    fn file(&self) -> PyResult<AssemblyFile> {
        let bonds = (self.joints.clone(), self.contacts.clone());
        let file = AssemblyFile::of_world(NAME, self.world, self.parts.clone(), bonds);
        Ok(file.map_err(|error| Refusal::from(AssemblyError::from(error)))?)
    }

    /// The parts bound, and the world over them.
    pub fn bind(&self, py: Python<'_>) -> PyResult<WorldSimulation> {
        let file = self.file()?;
        let given = self.own.iter().map(Own::given).collect();
        Ok(py.detach(|| WorldSimulation::new(file, given).map_err(Refusal::from))?)
    }
}
