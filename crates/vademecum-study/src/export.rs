//! A model as other programs march it: matrices, loads, a reduced basis, and what a march needs to know
//! beside them.

use serde::Serialize;
use vademecum_build::dynamics::{Course, History, SchemeKind, Wave};
use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::field;
use vademecum_build::input::{BasisKind, Problem};
use vademecum_build::progress::Listener;

use crate::error::StudyError;
use crate::scenario::{STEPS_AT_FULL_ORDER, Scenario};
use crate::scenario_loads::ScenarioLoads;
use crate::study::Study;
use crate::superelement::columns_of;

/// Data of the time integration: `model.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Model {
    /// Version of this list.
    pub(crate) version: u32,
    /// Title of the problem.
    pub(crate) title: String,
    /// Units of the problem.
    pub(crate) units: String,
    /// Free dofs n.
    pub dofs: usize,
    /// Time scheme.
    pub scheme: SchemeKind,
    /// Δt \[s\].
    pub time_step: f64,
    /// Steps to march.
    pub steps: usize,
    /// Rayleigh `α` \[1/s\].
    pub alpha: f64,
    /// Rayleigh `β` \[s\].
    pub beta: f64,
    /// Kind of the basis.
    pub basis: BasisKind,
    /// Modes r.
    pub modes: usize,
    /// Time course of each column of the loads.
    pub loads: Vec<LoadCourse>,
}

/// Time course of a column of the loads; absent factors are 1.
#[derive(Clone, Debug, Serialize)]
pub struct LoadCourse {
    /// First instant \[s\].
    pub start: f64,
    /// First instant without the load \[s\]; absent: to the end.
    pub end: Option<f64>,
    /// Time to full force \[s\].
    pub ramp: f64,
    /// A factor: time from the start \[s\] and value, row by row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<Vec<[f64; 2]>>,
    /// A factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) wave: Option<WaveFactor>,
    /// A factor that rises from 0 at the first instant \[s\] to 1 at the second and falls to 0 at the third:
    /// a place on the path of a contact. Where two instants are the same, it is 1 on that side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<[f64; 3]>,
}

/// `mean + sin(phase + 2π (f₀ t + ½ (f₁ − f₀) t²/sweep))`, with `t` from the start of the load.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct WaveFactor {
    /// `f₀` and `f₁` \[Hz\].
    pub(crate) frequency: [f64; 2],
    /// Time from one to the other \[s\].
    pub(crate) sweep: f64,
    /// Phase at the start \[rad\].
    pub(crate) phase: f64,
    /// Mean value.
    pub(crate) mean: f64,
}

impl From<&History> for LoadCourse {
    fn from(History { during, share, course }: &History) -> Self {
        let table = match course {
            Course::Table(table, column) => Some(table.rows(*column).collect()),
            _ => None,
        };
        let wave = match *course {
            Course::Wave(Wave { frequency, sweep, phase, mean }) => {
                Some(WaveFactor { frequency, sweep, phase, mean })
            }
            _ => None,
        };
        let end = (during.end < f64::MAX).then_some(during.end);
        Self { start: during.start, end, ramp: during.ramp, table, wave, share: *share }
    }
}

/// One row of the matrices.
#[derive(Clone, Copy, Debug)]
pub struct FreeDof {
    /// Id of its node in the mesh file.
    pub node: u64,
    /// Component of the displacement, 0 to 2.
    pub component: usize,
    /// Position of the node \[m\].
    pub place: [f64; 3],
}

/// A model with loads and a basis.
pub struct ExportedModel {
    study: Study,
    /// Data of the time integration.
    pub model: Model,
    /// The basis, shape (n, r).
    pub basis: field::DenseMatrix,
    /// Forces \[N\], shape (n, loads).
    pub loads: field::DenseMatrix,
}

impl ExportedModel {
    /// Makes a problem's matrices, a basis of so many modes, and the loads of a scenario; without one, of
    /// [`Study::push`]. Of the scenario's steps at most `steps` are to be marched.
    ///
    /// # Errors
    /// [`StudyError`]: as the build it starts as; a scenario that does not fit the problem.
    pub fn new(
        problem: &Problem,
        scenario: Option<&Scenario>,
        kind: BasisKind,
        modes: usize,
        steps: Option<usize>,
        listener: &dyn Listener,
    ) -> Result<Self, StudyError> {
        if problem.has_attachments() {
            return Err(StudyError::AttachedMatrices);
        }
        let study = Study::new(problem, modes, listener)?;
        let scenario = scenario.cloned().map_or_else(|| study.push(), Ok)?;
        listener.stage("basis");
        let basis = study.basis(kind, modes)?.value;
        // Contacts find their triangle through a file, as they do when it is stepped.
        let file = study.file(&study.basis(BasisKind::Modes, 1)?.value, None)?.value;
        let prepared = study.prepared();
        let loads = ScenarioLoads::new(&file, &scenario, &prepared.body)?.loads;
        let all = scenario.steps_within(study.time_step(), STEPS_AT_FULL_ORDER, steps.is_some())?;
        let model = Model {
            version: 1,
            title: problem.title.clone(),
            units: problem.units.clone(),
            dofs: prepared.body.n_dof(),
            scheme: problem.scheme(),
            time_step: study.time_step(),
            steps: steps.unwrap_or(all).clamp(1, all),
            alpha: prepared.rayleigh().alpha,
            beta: prepared.rayleigh().beta,
            basis: kind,
            modes: basis.n_modes(),
            loads: loads.iter().map(|load| (&load.when).into()).collect(),
        };
        let data = loads.iter().flat_map(|load| load.force.iter().copied()).collect();
        let loads = field::DenseMatrix { rows: model.dofs, columns: loads.len(), data };
        Ok(Self { model, basis: columns_of(&basis.vectors), loads, study })
    }

    /// The mass matrix \[kg\].
    pub fn mass(&self) -> &SymmetricMatrix {
        self.study.mass()
    }

    /// The stiffness matrix \[N/m\].
    pub fn stiffness(&self) -> &SymmetricMatrix {
        self.study.prepared().body.model.pencil().stiffness()
    }

    /// Node and component of each row of the matrices.
    pub fn free_dofs(&self) -> impl Iterator<Item = FreeDof> {
        let model = &self.study.prepared().body.model;
        let mesh = model.mesh();
        model.dofs().dof_of_free().iter().map(|&dof| {
            let (index, component) = (dof as usize / 3, dof as usize % 3);
            FreeDof { node: self.node_id(index), component, place: mesh.nodes[index] }
        })
    }

    /// Id and place \[m\] of every node, in the order of the mesh; those without a free dof are among them.
    pub fn nodes(&self) -> impl Iterator<Item = (u64, [f64; 3])> {
        let nodes = &self.study.prepared().body.model.mesh().nodes;
        nodes.iter().enumerate().map(|(index, &place)| (self.node_id(index), place))
    }

    /// Triangles of the whole surface by node id, outward.
    pub fn triangles(&self) -> impl Iterator<Item = [u64; 3]> {
        let surface = &self.study.prepared().body.surface;
        surface.iter().map(|triangle| triangle.map(|node| self.node_id(node as usize)))
    }

    /// The id a node has in the mesh file.
    fn node_id(&self, index: usize) -> u64 {
        self.study.prepared().body.model.mesh().node_ids.get(index).copied().unwrap_or(index as u64)
    }
}
