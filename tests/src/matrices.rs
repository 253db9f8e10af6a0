//! A vademecum of two matrices without a mesh: the road of a build from the basis on, over one node whose
//! first components are the dofs.
//!
//! What the pipeline does with a body is done here with a pencil: stage responses from its factorisations,
//! then the file through the writer of the format. The node is loadable, so a contact on it is a force on the
//! dofs, and a load pattern `drive` is the force given.

use vademecum_build::Matrix;
use vademecum_build::fem::{Pencil, Symbolic};
use vademecum_build::response::StageResponse;
use vademecum_format::scheme::{SchemeTable, StepParameters, theta};
use vademecum_format::{Certificate, Element, MAX_PARAMETERS, Metadata, Parameter, SectionKind};

use crate::synthetic::{encode, stage_axis};

/// What a file of matrices is made of.
pub struct MatrixFile<'a> {
    /// `M` and `K`, at most three dofs.
    pub pencil: &'a Pencil,
    /// `B`, shape (n, r), `BᵀMB = I`.
    pub basis: &'a Matrix,
    /// `BᵀKB` is diagonal: write the diagonal structure too.
    pub diagonal: bool,
    /// The scheme.
    pub scheme: &'a SchemeTable,
    /// `Δt` \[s\].
    pub time_step: f64,
    /// Force over the dofs of the pattern `drive`, length n.
    pub drive: &'a [f64],
}

impl MatrixFile<'_> {
    /// The bytes of the file.
    ///
    /// # Panics
    /// If the matrices do not factorise or the writer refuses the file.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let (n, r) = (self.basis.nrows(), self.basis.ncols());
        assert!(n <= 3, "one node has three dofs");
        let responses = self.responses();
        let mut product = Matrix::zeros(n, r);
        self.pencil.stiffness().mul_into(self.basis.as_ref(), product.as_mut());
        let stiffness = self.basis.transpose() * product;
        let eigenvalues = (0..r).map(|k| stiffness[(k, k)]);
        let points = (0..responses.len()).map(|i| i as f64);
        let identity =
            |terms: usize| (0..terms * terms).map(move |k| f64::from(u8::from(k / terms == k % terms)));
        use SectionKind as S;
        let mut contents = vec![
            (S::NodeIds, Element::U64, 1u64.to_le_bytes().to_vec()),
            (S::NodeCoordinates, Element::F64, f64s([0.0; 3])),
            (S::Triangles, Element::U32, vec![]),
            (S::ReducedStiffness, Element::F64, f64s(row_major(&stiffness))),
            (S::SurfaceBasis, Element::F64, f64s(node_rows(self.basis))),
            (S::BlockState, Element::F64, f64s(responses.iter().flat_map(|s| row_major(&s.state)))),
            (S::BlockLoad, Element::F64, f64s(responses.iter().flat_map(|s| node_rows(&s.increment)))),
            (S::PatternBasis, Element::F64, f64s(self.reduced_drive(self.basis))),
            (
                S::PatternBlock,
                Element::F64,
                f64s(responses.iter().flat_map(|s| self.reduced_drive(&s.increment))),
            ),
            (S::PatternNames, Element::U8, b"drive".to_vec()),
            (S::AxisPoints, Element::F64, f64s(points)),
            (S::Factors, Element::F64, f64s(identity(responses.len()))),
        ];
        if self.diagonal {
            contents.insert(4, (S::Eigenvalues, Element::F64, f64s(eigenvalues)));
        }
        encode(&self.metadata(r, responses.len()), &contents)
    }

    fn responses(&self) -> Vec<StageResponse> {
        let step =
            StepParameters { time_step: self.time_step, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
        let symbolic = Symbolic::analyze(self.pencil).expect("a pattern");
        let response = |stage: usize| {
            let theta = theta(self.scheme, &step, stage).expect("a sound scheme");
            StageResponse::solve(self.pencil, &symbolic, self.basis.as_ref(), theta)
                .expect("M + θK is definite")
        };
        (0..self.scheme.active().len()).map(response).collect()
    }

    fn reduced_drive(&self, rows: &Matrix) -> Vec<f64> {
        let dot = |k: usize| self.drive.iter().enumerate().map(|(i, force)| force * rows[(i, k)]).sum();
        (0..rows.ncols()).map(dot).collect()
    }

    fn metadata(&self, n_modes: usize, n_stages: usize) -> Metadata<'static> {
        Metadata {
            program: "matrices 1",
            problem: "",
            units: "as the matrices",
            mesh_hash: [0; 16],
            n_nodes: 1,
            n_surface_nodes: 1,
            n_load_nodes: 1,
            n_triangles: 0,
            n_load_triangles: 0,
            n_modes: n_modes as u32,
            n_patterns: 1,
            n_probes: 0,
            n_regions: 1,
            n_parameters: 0,
            parameters: [Parameter::UNUSED; MAX_PARAMETERS],
            scheme_name: "scheme",
            scheme: *self.scheme,
            time_step: self.time_step,
            alpha: 0.0,
            beta: 0.0,
            axes: stage_axis(n_stages),
            n_axes: 1,
            n_terms: n_stages as u32,
            diagonal: self.diagonal,
            block: true,
            certificate: Certificate::default(),
        }
    }
}

fn f64s(numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(f64::to_le_bytes).collect()
}

fn row_major(matrix: &Matrix) -> impl Iterator<Item = f64> + '_ {
    (0..matrix.nrows()).flat_map(move |i| (0..matrix.ncols()).map(move |j| matrix[(i, j)]))
}

/// Rows at the three components of the node, zero where there is no dof.
fn node_rows(matrix: &Matrix) -> impl Iterator<Item = f64> + '_ {
    let row = move |i: usize| {
        (0..matrix.ncols()).map(move |j| if i < matrix.nrows() { matrix[(i, j)] } else { 0.0 })
    };
    (0..3).flat_map(row)
}
