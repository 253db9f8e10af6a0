//! A body reduced to its interfaces, and the files by which other programs read it.

mod description;
mod npz;
mod punch;

pub use description::{Description, InterfaceDescription};

use vademecum_build::Matrix;
use vademecum_build::field::DenseMatrix;
use vademecum_build::input::{InterfaceEntry, Problem};
use vademecum_build::mesh::Mesh;
use vademecum_build::prepared::{Prepared, interfaces, prepare};
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_build::superelement::{Request, Superelement, reduce};

use crate::error::StudyError;

/// A body reduced to its interfaces.
pub struct ReducedBody {
    /// The superelement.
    pub superelement: Superelement,
    title: String,
    units: String,
    prepared: Prepared,
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
        // Nothing is marched, so none is proposed.
        problem.time.step.get_or_insert(1.0);
        let prepared = prepare(&problem, &mut Stopwatch::new(listener), listener)?;
        let found = interfaces(&problem, &prepared.body, entries)?;
        let superelement = reduce(&problem, &prepared, found, request, listener)?;
        Ok(Self { superelement, title: problem.title, units: problem.units, prepared })
    }

    /// The contents of `superelement.json`.
    pub fn description(&self) -> Description {
        Description::new(self)
    }

    /// The bytes of `superelement.npz`; `full` with the matrices of the full order.
    ///
    /// # Errors
    /// [`StudyError::Archive`].
    pub fn npz(&self, full: bool) -> Result<Vec<u8>, StudyError> {
        npz::archive(self, full)
    }

    /// The matrices as DMIG entries of Nastran, with the grid points of the interfaces.
    pub fn punch(&self) -> String {
        punch::punch(self)
    }

    /// Free dofs of the full order.
    pub fn dofs(&self) -> usize {
        self.prepared.body.n_dof()
    }

    /// True of a body all of whose nodes are free and move by themselves: the rows of its matrices are the
    /// displacements of the nodes, in order.
    pub fn is_bare_and_free(&self) -> bool {
        let dofs = self.prepared.body.model.dofs();
        dofs.is_direct() && dofs.n_free() == dofs.n_dof()
    }

    fn mesh(&self) -> &Mesh {
        self.prepared.body.model.mesh()
    }

    /// Number of a node in the mesh file.
    fn node_id(&self, node: u32) -> u64 {
        self.mesh().node_ids.get(node as usize).copied().unwrap_or(u64::from(node))
    }
}

/// A dense matrix as files take it.
pub fn columns_of(matrix: &Matrix) -> DenseMatrix {
    let data = (0..matrix.ncols()).flat_map(|j| matrix.col_as_slice(j).iter().copied()).collect();
    DenseMatrix { rows: matrix.nrows(), columns: matrix.ncols(), data }
}
