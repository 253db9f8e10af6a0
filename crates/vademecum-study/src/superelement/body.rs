//! A body reduced to its interfaces, with what its files say beside the matrices.

use vademecum_build::Matrix;
use vademecum_build::fem::Model;
use vademecum_build::field::DenseMatrix;
use vademecum_build::input::{BasisKind, InterfaceEntry, Problem};
use vademecum_build::prepared::{interfaces, prepare};
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_build::superelement::{Request, Superelement, reduce};

use crate::error::StudyError;

/// A body reduced to its interfaces.
pub struct ReducedBody {
    /// The superelement.
    pub superelement: Superelement,
    pub(super) title: String,
    pub(super) units: String,
    /// Places of the nodes of `T` \[m\].
    pub(super) nodes: Vec<[f64; 3]>,
    /// Numbers of the nodes in the mesh file.
    pub(super) node_ids: Vec<u64>,
    /// The linear triangles of the surface, outward.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Rayleigh damping \[1/s, s\].
    pub(super) rayleigh: [f64; 2],
    /// Free dofs of the full order, if they are known.
    pub(super) dofs: Option<usize>,
    /// The model at full order; none of a vademecum file.
    pub(super) model: Option<Model>,
}

impl ReducedBody {
    /// Reduces the body of a problem to interfaces; without any, to the ports of the problem. Live parameters
    /// are taken at the values of the problem file.
    ///
    /// # Errors
    /// [`StudyError`]: a problem that cannot be computed with, interfaces that do not fit it, modes that do
    /// not converge.
    pub fn new(
        problem: &Problem,
        entries: &[InterfaceEntry],
        request: Request,
        listener: &dyn Listener,
    ) -> Result<Self, StudyError> {
        let mut problem = problem.clone();
        if !problem.parameters.is_empty() {
            listener.note(
                "live parameters are left out: all matrices are those at the values of the problem file",
            );
            problem.parameters.clear();
        }
        // Nothing is marched: no step is proposed, and a free body is free by any scheme and basis.
        problem.time.step.get_or_insert(1.0);
        (problem.time.scheme, problem.basis.kind) = (None, Some(BasisKind::Modes));
        let prepared = prepare(&problem, &mut Stopwatch::new(listener), listener)?;
        let found = interfaces(&problem, &prepared.body, entries)?;
        let superelement = reduce(&problem, &prepared, found, request, listener)?;
        let rayleigh = prepared.rayleigh();
        let (body, mesh) = (&prepared.body, prepared.body.model.mesh());
        let numbered = mesh.node_ids.len() == mesh.nodes.len();
        Ok(Self {
            superelement,
            title: problem.title,
            units: problem.units,
            nodes: mesh.nodes.clone(),
            node_ids: if numbered { mesh.node_ids.clone() } else { (0..mesh.nodes.len() as u64).collect() },
            triangles: body.surface.clone(),
            rayleigh: [rayleigh.alpha, rayleigh.beta],
            dofs: Some(body.n_dof()),
            model: Some(prepared.body.model),
        })
    }

    /// True of a body all of whose nodes are free and move by themselves: the rows of its matrices are the
    /// displacements of the nodes, in order.
    pub fn is_bare_and_free(&self) -> bool {
        let dofs = self.model.as_ref().map(Model::dofs);
        dofs.is_some_and(|dofs| dofs.is_direct() && dofs.n_free() == dofs.n_dof())
    }

    /// Number of a node in the mesh file.
    pub(super) fn node_id(&self, node: u32) -> u64 {
        self.node_ids[node as usize]
    }
}

/// A dense matrix as files take it.
pub fn columns_of(matrix: &Matrix) -> DenseMatrix {
    let data = (0..matrix.ncols()).flat_map(|j| matrix.col_as_slice(j).iter().copied()).collect();
    DenseMatrix { rows: matrix.nrows(), columns: matrix.ncols(), data }
}
