//! A model as its deck has it, in the units of the deck.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use vademecum_build::fem::{Cylinder, HeatLaw, Material};
use vademecum_build::mesh::Mesh;

use crate::left_out::LeftOut;
use crate::units::Units;

/// Index of a node: those of the mesh first, then the points.
pub type NodeNumber = u32;

/// A model: solids, and what holds, joins and loads them.
#[derive(Clone, Debug)]
pub struct Deck {
    /// The file.
    pub file: PathBuf,
    /// The program that the deck was written for, and the reason to think so.
    pub program: String,
    /// Units of its numbers.
    pub units: Units,
    /// The solid elements.
    pub mesh: Mesh,
    /// Nodes that no solid element has.
    pub points: Vec<Point>,
    /// Elasticity and density of each region; a density of zero is none.
    pub materials: Vec<Material>,
    /// Of each region the line about which the axes of its material turn; none at all where no axes do.
    pub cylinders: Vec<Option<Cylinder>>,
    /// Temperatures, if the deck has any.
    pub heat: Option<Temperatures>,
    /// True for each region whose mass is lumped.
    pub lumped: Vec<bool>,
    /// True of the dialect of CalculiX: incompatible modes are dofs with a mass, and motions about a loaded
    /// state take their strains about the displaced body.
    pub of_calculix: bool,
    /// Axes of nodes whose components are not those of space; rows are unit vectors.
    pub axes: BTreeMap<NodeNumber, [[f64; 3]; 3]>,
    /// Supports of all steps.
    pub supports: Vec<Support>,
    /// Couplings, ties and equations.
    pub links: Vec<Link>,
    /// Masses, springs, dashpots and beams.
    pub attachments: Vec<Attachment>,
    /// Damping of motions and of harmonic answers.
    pub damping: Damping,
    /// Steps in order.
    pub steps: Vec<Step>,
    /// Cards that were not taken.
    pub left_out: Vec<LeftOut>,
    /// Remarks.
    pub notes: Vec<String>,
}

/// Thermal constants, and the temperature without stress.
#[derive(Clone, Debug)]
pub struct Temperatures {
    /// Those of each region.
    pub laws: Vec<HeatLaw>,
    /// Initial temperature of each node of the mesh; none: those from which the coefficients count.
    pub initial: Vec<f64>,
    /// True if temperatures of hexahedra are of a lower order than displacements.
    pub lowered: bool,
}

/// A node outside of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Number in the deck.
    pub id: u64,
    /// Place.
    pub at: [f64; 3],
}

/// A displacement component with a given value: 0 to 2 along the axes of the node, 3 to 5 about them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// The node.
    pub node: NodeNumber,
    /// The component.
    pub component: u8,
    /// Displacement or rotation.
    pub value: f64,
}

/// Displacements that depend on each other.
#[derive(Clone, Debug, PartialEq)]
pub enum Link {
    /// `Σ a_i u_i = 0`.
    Equation {
        /// Node, component and coefficient; the first term is the dependent one.
        terms: Vec<(NodeNumber, u8, f64)>,
        /// Origin, for messages.
        origin: String,
    },
    /// Nodes that follow a reference node as a rigid body does.
    Rigid {
        /// Reference node.
        reference: NodeNumber,
        /// A node whose displacement is the rotation, where the program has it so.
        rotation: Option<NodeNumber>,
        /// Followers.
        nodes: Vec<NodeNumber>,
        /// Components that follow, along the axes of space and about them.
        components: [bool; 6],
        /// Origin, for messages.
        origin: String,
    },
    /// A reference node that follows the mean motion of others.
    Mean {
        /// Reference node.
        reference: NodeNumber,
        /// Nodes and weights.
        cloud: Vec<(NodeNumber, f64)>,
        /// Components of the reference that follow.
        components: [bool; 6],
        /// Origin, for messages.
        origin: String,
    },
    /// Nodes of a surface that follow the faces of another one.
    Tie {
        /// Followers.
        slaves: Vec<NodeNumber>,
        /// Three corners of each face.
        faces: Vec<[u32; 3]>,
        /// Largest distance that is tied; none: that of the nearest face of each node, up to the size of it.
        tolerance: Option<f64>,
        /// Origin, for messages.
        origin: String,
    },
}

/// Damping of a deck: a natural mode decays by `½ (α + β λ) + ξ √λ`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Damping {
    /// Damping proportional to mass \[1 per unit of time\].
    pub alpha: f64,
    /// Damping proportional to stiffness \[unit of time\].
    pub beta: f64,
    /// Damping ratio of each natural mode, in ascending order of their frequencies.
    pub ratios: Vec<f64>,
}

/// Something at nodes that is no solid element.
#[derive(Clone, Debug, PartialEq)]
pub enum Attachment {
    /// A mass, and moments of inertia about the axes of space: xx, yy, zz, xy, xz, yz.
    Mass {
        /// The node.
        node: NodeNumber,
        /// Mass.
        mass: f64,
        /// Moments and products of inertia.
        inertia: [f64; 6],
    },
    /// A spring.
    Spring(Spring),
    /// A dashpot: a spring whose stiffness is a damping.
    Dashpot(Spring),
    /// A beam: stiffness (12, 12) over displacements and rotations of its ends, row by row, and its mass.
    Beam {
        /// Its ends.
        ends: [NodeNumber; 2],
        /// Stiffness.
        stiffness: Vec<f64>,
        /// Mass that falls on each end.
        mass: f64,
    },
}

/// A stiffness between two nodes, or between a node and the ground.
#[derive(Clone, Debug, PartialEq)]
pub enum Spring {
    /// Along the line between two nodes.
    Line {
        /// Its ends.
        ends: [NodeNumber; 2],
        /// Stiffness.
        stiffness: f64,
    },
    /// Between components of two nodes, or of one and the ground.
    Components {
        /// Its ends.
        ends: Vec<(NodeNumber, u8)>,
        /// Stiffness.
        stiffness: f64,
    },
}

/// A step of the analysis.
#[derive(Clone, Debug)]
pub struct Step {
    /// Its name, or its number from 1.
    pub name: String,
    /// Its kind.
    pub kind: StepKind,
    /// Loads that act in it.
    pub loads: Vec<Load>,
    /// Supports that hold in it, with those of the model.
    pub supports: Vec<Support>,
    /// Temperature of each node of the mesh; none: the initial ones.
    pub temperatures: Vec<f64>,
    /// The static step before it about whose state it moves; absent: it moves about the body without load.
    pub about: Option<usize>,
    /// The line that begins it.
    pub line: usize,
}

/// Kind of a step.
#[derive(Clone, Debug, PartialEq)]
pub enum StepKind {
    /// A static answer to loads.
    Static,
    /// Natural frequencies, so many if the deck says.
    Frequency(Option<usize>),
    /// Motion over time.
    Dynamic(Dynamic),
    /// Answer to harmonic loads.
    Harmonic(Harmonic),
    /// Another kind, as the deck names it.
    Other(String),
}

impl StepKind {
    /// Nodes whose displacements the deck asks for, of a motion over time or a harmonic answer.
    pub(crate) fn printed(&mut self) -> Option<&mut Vec<NodeNumber>> {
        match self {
            StepKind::Dynamic(Dynamic { printed, .. }) | StepKind::Harmonic(Harmonic { printed, .. }) => {
                Some(printed)
            }
            _ => None,
        }
    }
}

/// A motion over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Dynamic {
    /// True of a sum of modes.
    pub modal: bool,
    /// Time step.
    pub increment: f64,
    /// Duration.
    pub duration: f64,
    /// Factors on loads over time by the name of their amplitude, linear between rows; 1 without rows.
    pub courses: Vec<(String, Vec<[f64; 2]>)>,
    /// Index of the course of each of the last loads of the step; those before them are constant.
    pub follows: Vec<usize>,
    /// Nodes whose displacements the deck asks for.
    pub printed: Vec<NodeNumber>,
}

/// Answers to harmonic loads over a range of frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonic {
    /// First and last frequency \[cycles per unit of time\].
    pub range: [f64; 2],
    /// Nodes whose displacements the deck asks for.
    pub printed: Vec<NodeNumber>,
}

/// Part of the model that a load acts on.
#[derive(Clone, Debug, PartialEq)]
pub enum Extent {
    /// All elements and masses.
    All,
    /// Elements, ascending.
    Elements(Vec<u32>),
}

/// A load.
#[derive(Clone, Debug, PartialEq)]
pub enum Load {
    /// A force or a moment along an axis of a node.
    Force {
        /// The node.
        node: NodeNumber,
        /// The component.
        component: u8,
        /// Force or moment.
        value: f64,
    },
    /// A body force per mass.
    Acceleration {
        /// Where it acts.
        on: Extent,
        /// Acceleration.
        value: [f64; 3],
    },
    /// The centrifugal force of a rotation.
    Rotation {
        /// Where it acts.
        on: Extent,
        /// Square of the angular velocity.
        speed_squared: f64,
        /// A point of the axis.
        point: [f64; 3],
        /// Its direction, of length 1.
        axis: [f64; 3],
    },
    /// A pressure against faces.
    Pressure {
        /// Three corners of each face.
        faces: Vec<[u32; 3]>,
        /// Pressure.
        value: f64,
    },
    /// A force per area of faces.
    Traction {
        /// Three corners of each face.
        faces: Vec<[u32; 3]>,
        /// Force per area.
        value: [f64; 3],
    },
}

impl Deck {
    /// A model of solids and points alone.
    pub(crate) fn new(file: &Path, program: &str, mesh: Mesh, points: Vec<Point>) -> Deck {
        Deck {
            file: file.to_path_buf(),
            program: program.into(),
            units: Units::guessed(None),
            notes: mesh.notes.clone(),
            mesh,
            points,
            materials: vec![],
            cylinders: vec![],
            heat: None,
            lumped: vec![],
            of_calculix: false,
            axes: BTreeMap::new(),
            supports: vec![],
            links: vec![],
            attachments: vec![],
            damping: Damping::default(),
            steps: vec![],
            left_out: vec![],
        }
    }

    /// Number of nodes, those of the mesh and points.
    pub fn node_count(&self) -> usize {
        self.mesh.nodes.len() + self.points.len()
    }

    /// Place of a node.
    ///
    /// # Panics
    /// If there is no such node.
    pub fn place(&self, node: NodeNumber) -> [f64; 3] {
        let node = node as usize;
        self.mesh.nodes.get(node).copied().unwrap_or_else(|| self.points[node - self.mesh.nodes.len()].at)
    }

    /// Number of a node in the deck.
    ///
    /// # Panics
    /// If there is no such node.
    pub fn id(&self, node: NodeNumber) -> u64 {
        let node = node as usize;
        self.mesh.node_ids.get(node).copied().unwrap_or_else(|| self.points[node - self.mesh.nodes.len()].id)
    }

    /// The lowest node of each body: elements that share nodes.
    pub fn parts(&self) -> Vec<NodeNumber> {
        let mut parent: Vec<u32> = (0..self.mesh.nodes.len() as u32).collect();
        let root = |parent: &mut [u32], mut node: u32| {
            while parent[node as usize] != node {
                parent[node as usize] = parent[parent[node as usize] as usize];
                node = parent[node as usize];
            }
            node
        };
        for (_, element) in self.mesh.each() {
            for &node in &element[1..] {
                let (a, b) = (root(&mut parent, element[0]), root(&mut parent, node));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
        (0..parent.len() as u32).filter(|&node| parent[node as usize] == node).collect()
    }

    /// True if every region has a density.
    pub fn has_mass(&self) -> bool {
        self.materials.iter().all(|material| material.density > 0.0)
    }
}

/// Nodes of a deck by their numbers.
pub(crate) struct Numbers(HashMap<u64, NodeNumber>);

impl Numbers {
    /// Numbers the nodes of a mesh, and after them the points that the mesh left out.
    pub(crate) fn new(mesh: &Mesh, all: impl Iterator<Item = (u64, [f64; 3])>) -> (Numbers, Vec<Point>) {
        let mut numbers: HashMap<u64, NodeNumber> = mesh.node_ids.iter().copied().zip(0..).collect();
        let mut points = Vec::new();
        for (id, at) in all {
            let next = (mesh.nodes.len() + points.len()) as NodeNumber;
            numbers.entry(id).or_insert_with(|| {
                points.push(Point { id, at });
                next
            });
        }
        (Numbers(numbers), points)
    }

    pub(crate) fn get(&self, id: u64) -> Option<NodeNumber> {
        self.0.get(&id).copied()
    }
}
