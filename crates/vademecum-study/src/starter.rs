//! A problem file for a mesh that somebody has just found: everything that can be seen of the mesh is
//! proposed, said in a comment, and left to be changed.

mod known;
mod materials;
mod support;
mod text;
mod toml;

use std::path::{Path, PathBuf};

use vademecum_build::dynamics::lowest_modes;
use vademecum_build::input::Problem;
use vademecum_build::mesh::{self, Mesh, MeshError, Order};
use vademecum_build::mesh_error::{DiscRequest, MeshEstimate, estimate};
use vademecum_build::prepared::{Prepared, prepare, proposed_time_step};
use vademecum_build::progress::{Listener, Silent, Stopwatch, is_cancelled};
use vademecum_build::suggest::did_you_mean;

pub use known::KnownParts;
pub use materials::{MATERIALS, NamedMaterial};
pub use support::HoldError;

use self::support::{AXES, Shape, Supports, propose};
use self::text::Draft;
use crate::error::StudyError;

/// Modes proposed for a long body, and for a compact one, which rings in more of them; a small body has
/// fewer.
const MODES: [usize; 2] = [32, 64];

/// Longest step that is proposed \[s\]: fingers and frames of a game are faster than slow bodies.
const LONGEST_STEP: f64 = 1e-3;

/// A body with a longest side above this is not in metres.
const LARGEST_IN_METRES: f64 = 20.0;

/// A body with a longest side above this may be meant in metres or in millimetres: the user is asked.
const DOUBTFUL_IN_METRES: f64 = 3.0;

/// Linear meshes are raised to quadratic ones with fewer dofs than this, and the discretisation error of
/// larger ones is not estimated: it takes seconds below.
const MOST_RAISED_DOFS: usize = 100_000;

/// Format whose element types name their formulation, which stays as its author chose it.
const FORMULATED: &str = "Abaqus";

impl NamedMaterial {
    /// A material by its name.
    ///
    /// # Errors
    /// The words of a refusal, with the names that there are.
    pub fn find(name: &str) -> Result<Self, String> {
        let known = || MATERIALS.map(|material| material.name).join(", ");
        let nearest = || did_you_mean(name, MATERIALS.iter().map(|material| material.name));
        let found = MATERIALS.into_iter().find(|material| material.name == name);
        found.ok_or_else(|| format!("unknown material `{name}`; known: {}{}", known(), nearest()))
    }
}

/// Options; everything else is proposed.
#[derive(Clone, Debug)]
pub struct StarterOptions {
    /// Material of the body; steel if `None`, and rubber where no face is flat.
    pub material: Option<NamedMaterial>,
    /// Metres in a unit of the mesh; guessed from the size of the body if `None`.
    pub scale: Option<f64>,
    /// Support: `bottom`, `x_min` … `z_max`, `none`, or the name of a group; proposed if `None`.
    pub hold: Option<String>,
    /// Axis that points up, 0 to 2; guessed from the shape if `None`.
    pub up: Option<usize>,
    /// Parts that share no facet with the rest and have less than this share of the elements are left out.
    pub smallest_part: f64,
    /// Cells along the longest side of a surface; as many as its volume asks for if `None`.
    pub cells: Option<u32>,
    /// The mesh file as the problem file shall name it.
    pub mesh_name: String,
    /// Materials and supports of a deck.
    pub known: Option<KnownParts>,
}

/// Share of the elements below which a loose part is left out unless somebody asks for another.
pub const SMALLEST_PART: f64 = 0.01;

/// A proposed problem.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Starter {
    /// The text of the problem file.
    pub text: String,
    /// Metres in a unit of the mesh.
    pub scale: f64,
    /// True if the size leaves open whether the mesh is in metres or in millimetres.
    pub doubtful_scale: bool,
    /// Longest side \[m\].
    pub longest_side: f64,
    /// Axis that points up.
    pub up: &'static str,
    /// Name of the material.
    pub material: String,
    /// Description of the support.
    pub support: String,
    /// True if linear tetrahedra get mid-side nodes.
    pub raised: bool,
    /// Discretisation error of the frequencies of linear tetrahedra; absent of other meshes.
    pub linear_mesh_error: Option<MeshEstimate>,
    /// First natural frequency \[Hz\].
    pub frequency: f64,
    /// Proposed step \[s\].
    pub time_step: f64,
    /// Proposed number of modes.
    pub modes: usize,
    /// Free dofs.
    pub dofs: usize,
}

/// Proposes a problem for a mesh. Reads and assembles it, and finds its first natural mode: one
/// factorisation.
///
/// # Errors
/// [`StarterError`]: a mesh that cannot be used, or that the proposed support does not hold.
pub fn starter(
    path: &Path,
    options: &StarterOptions,
    listener: &dyn Listener,
) -> Result<Starter, StarterError> {
    listener.stage("read mesh");
    let ReadMesh { mesh, cells, linear, raised, smallest_part } = read(path, options)?;
    let shape = Shape::of(&mesh);
    let longest = shape.longest_side();
    let guess = if longest > LARGEST_IN_METRES { 1e-3 } else { 1.0 };
    let scale = options.scale.unwrap_or(guess);
    let up = options.up.unwrap_or_else(|| shape.up());
    let supports = match &options.known {
        Some(known) if options.hold.is_none() => {
            Supports { on: known.supports.clone(), words: known.support_words.clone(), others: vec![] }
        }
        _ => propose(&shape, scale, options.hold.as_deref(), up)?,
    };
    let usual = if shape.has_flat_face() { "steel" } else { "rubber" };
    let material = options.material.or_else(|| MATERIALS.into_iter().find(|m| m.name == usual));
    let material = material.expect("the usual materials have names");
    let draft = Draft {
        mesh_name: &options.mesh_name,
        mesh: &mesh,
        shape: &shape,
        material,
        known: options.known.as_ref(),
        scale,
        raised,
        cells,
        smallest_part,
        supports: &supports,
    };

    let prepared = prepared(&draft, path, listener)?;
    let pencil = prepared.body.model.pencil();
    let dofs = pencil.n_dof();
    let modes = MODES[usize::from(shape.long_axis().is_none())].min(pencil.n_elastic());
    listener.stage("first natural mode");
    let first = lowest_modes(pencil, &prepared.symbolic, 1).map_err(StudyError::from)?;
    let frequency = first.frequencies_hz()[0];
    let known = options.known.as_ref();
    let proposed_step = proposed_time_step(1.0 / frequency).min(LONGEST_STEP);
    let time_step = known.and_then(|known| known.time_step).unwrap_or(proposed_step);
    let modes = known.and_then(|known| known.modes).unwrap_or(modes).min(pencil.n_elastic());

    // Where the first mode moves most, a probe looks.
    let moved = prepared.body.model.dofs();
    let mut field = vec![0.0; moved.n_dof()];
    moved.expand_into(first.vectors.col_as_slice(0), &mut field);
    let length = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let moved = field.as_chunks::<3>().0;
    let most = (0..moved.len()).max_by(|&a, &b| length(&moved[a]).total_cmp(&length(&moved[b])));
    let probe = most.filter(|&node| length(&moved[node]) > 0.0).map(|node| {
        let size = length(&moved[node]);
        // To a billionth of the body: what is left of a zero after rounding is not a coordinate.
        let grain = 1e-9 * longest;
        let point = mesh.nodes[node].map(|x| scale * ((x / grain).round() * grain));
        // A zero has no sign here.
        (point, moved[node].map(|x| (1000.0 * x / size).round() / 1000.0 + 0.0))
    });
    let text = draft.text(time_step, modes, &probe.into_iter().collect::<Vec<_>>());
    let linear_mesh_error = match linear {
        Linear::None => None,
        Linear::Large => Some(MeshEstimate::Unknown {
            reason: "the mesh is large, and this would take minutes: ask `vademecum modes --mesh-error`"
                .into(),
        }),
        Linear::Small => Some(linear_mesh_error(&Draft { raised: false, ..draft }, path, listener)?),
    };
    Ok(Starter {
        text,
        scale,
        doubtful_scale: options.scale.is_none() && scale == 1.0 && longest > DOUBTFUL_IN_METRES,
        longest_side: longest * scale,
        up: AXES[up],
        material: options.known.as_ref().map_or(material.name.into(), |known| known.material_words.clone()),
        support: supports.words,
        raised,
        linear_mesh_error,
        frequency,
        time_step,
        modes,
        dofs,
    })
}

/// The body of a draft. Any step will do until the first period is known.
fn prepared(draft: &Draft<'_>, path: &Path, listener: &dyn Listener) -> Result<Prepared, StarterError> {
    let text = draft.text(LONGEST_STEP, 1, &[]);
    let name = path.display().to_string();
    let mut problem = Problem::parse(&text, &name, PathBuf::new()).map_err(StarterError::Draft)?;
    problem.mesh.file = Some(path.to_path_buf());
    // Nothing is drawn yet.
    problem.output.embedded = None;
    Ok(prepare(&problem, &mut Stopwatch::new(listener), listener).map_err(StudyError::from)?)
}

/// The discretisation error of the frequencies of a draft on linear elements. An estimate that fails is a
/// reason, not an error: the proposal does not depend on it.
fn linear_mesh_error(
    draft: &Draft<'_>,
    path: &Path,
    listener: &dyn Listener,
) -> Result<MeshEstimate, StarterError> {
    listener.stage("mesh error");
    // Its notes are about a mesh that is not proposed.
    let prepared = prepared(draft, path, &Silent)?;
    match estimate(&prepared, None, DiscRequest::None, listener) {
        Err(error) if is_cancelled(&error) => Err(StudyError::from(error).into()),
        Err(error) => Ok(MeshEstimate::Unknown { reason: error.to_string() }),
        Ok(found) => Ok(found),
    }
}

/// The mesh of a proposal.
struct ReadMesh {
    /// As it is to be built.
    mesh: Mesh,
    /// Cells along the longest side of a surface that was filled.
    cells: Option<u32>,
    linear: Linear,
    raised: bool,
    /// Smallest share of a part, where parts are left out.
    smallest_part: Option<f64>,
}

/// Linear elements of a mesh file.
enum Linear {
    /// There are none, or not only linear tetrahedra.
    None,
    /// Few enough to be raised.
    Small,
    /// More than that.
    Large,
}

fn read(path: &Path, options: &StarterOptions) -> Result<ReadMesh, StarterError> {
    let raw = mesh::parse_with_cells(path, options.cells)?;
    let cells = raw.cells;
    let parts = mesh::part_sizes(&raw);
    let elements: usize = parts.iter().sum();
    // Couplings and ties join the parts of a deck.
    let joined = options.known.as_ref().is_some_and(|known| !known.attachments.is_empty());
    let share = if joined { 0.0 } else { options.smallest_part };
    let stays = |size: &&usize| **size as f64 >= share * elements as f64;
    let kept: Vec<usize> = parts.iter().take(1).chain(parts.iter().skip(1).filter(stays)).copied().collect();
    if kept.len() > 1 && !joined {
        return Err(StarterError::Parts { file: path.to_path_buf(), kept, elements });
    }
    let smallest_part = (parts.len() > 1 && !joined).then_some(share);
    let formulated = raw.format.starts_with(FORMULATED);
    let mesh = if joined { mesh::repaired_apart(&raw)? } else { mesh::repaired(raw, share)? };
    if mesh.tetrahedra() != Some(Order::Linear) {
        return Ok(ReadMesh { mesh, cells, linear: Linear::None, raised: false, smallest_part });
    }
    let is_small = |mesh: &Mesh| 3 * mesh.nodes.len() < MOST_RAISED_DOFS;
    let raised = is_small(&mesh).then(|| mesh.clone().raised()).filter(is_small);
    let linear = if raised.is_some() { Linear::Small } else { Linear::Large };
    Ok(match raised {
        Some(mesh) if !formulated => ReadMesh { mesh, cells, linear, raised: true, smallest_part },
        _ => ReadMesh { mesh, cells, linear, raised: false, smallest_part },
    })
}

/// Errors of a proposal.
#[derive(Debug, thiserror::Error)]
pub enum StarterError {
    /// The mesh cannot be used.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Large parts that share no facet.
    #[error(
        "{}: the mesh has {} parts that share no facet, with {} of {elements} elements: an edge or a node between them is a \
         hinge",
        .file.display(), .kept.len(), listed(.kept)
    )]
    Parts {
        /// The mesh.
        file: PathBuf,
        /// Elements of the parts that are too large to be left out, the largest first.
        kept: Vec<usize>,
        /// Elements of the mesh.
        elements: usize,
    },
    /// The mesh has no such group or end.
    #[error(transparent)]
    Hold(#[from] HoldError),
    /// The proposal is no problem.
    #[error(transparent)]
    Draft(vademecum_build::input::ProblemError),
    /// The proposal cannot be computed with.
    #[error(transparent)]
    Study(#[from] StudyError),
}

/// Numbers of elements, at most eight of them.
fn listed(sizes: &[usize]) -> String {
    let shown: Vec<String> = sizes.iter().take(8).map(usize::to_string).collect();
    let more = if sizes.len() > 8 { format!(" and {} more", sizes.len() - 8) } else { String::new() };
    shown.join(", ") + &more
}
