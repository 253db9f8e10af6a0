//! The lowest natural modes of a problem: their damping, how much of the body moves with them, their shapes,
//! and how they compare with modes of another program.

use std::path::Path;

use faer::Mat;
use serde::Serialize;
use vademecum_build::dynamics::{lowest_modes, numerical_damping};
use vademecum_build::fem::Pencil;
use vademecum_build::field::read_npy;
use vademecum_build::input::Problem;
use vademecum_build::mesh::Mesh;
use vademecum_build::mesh_error::{DiscRequest, MeshEstimate, estimate};
use vademecum_build::prepared::{Body, prepare, proposed_time_step};
use vademecum_build::progress::{Listener, Stopwatch};

use crate::error::StudyError;
use crate::live::prepared_at;
use crate::parameters::ParameterValue;

/// The lowest natural modes of a problem, one number per mode in each list.
#[derive(Clone, Debug, Serialize)]
pub struct NaturalModes {
    /// Free dofs.
    pub dofs: usize,
    /// Rigid motions of no frequency before these modes: 6 of a body without supports, or 0.
    pub rigid_motions: usize,
    /// Step that the scheme's figures belong to \[s\]: the problem's.
    pub time_step: f64,
    /// Step for such a body \[s\]: a round number, with at least 40 steps in the first period.
    pub proposed_time_step: f64,
    /// Frequency \[Hz\], ascending.
    pub frequencies_hz: Vec<f64>,
    /// Relative residual of the eigenvalue problem.
    pub residuals: Vec<f64>,
    /// Damping ratio of the material.
    pub material_damping: Vec<f64>,
    /// Damping ratio that the time scheme adds; absent where the mode does not swing any more.
    pub scheme_damping: Vec<Option<f64>>,
    /// Relative elongation of the period by the time scheme; absent as above.
    pub period_elongation: Vec<Option<f64>>,
    /// Mass of the nodes that are free along x, y and z \[kg\]: `rᵀM r` of a unit translation `r` of them.
    pub free_mass: [f64; 3],
    /// Participation factors `φᵀM r` along x, y and z \[kg^½\], for modes with `φᵀM φ = 1`.
    pub participation: Vec<[f64; 3]>,
    /// Effective modal masses `(φᵀM r)²`, as shares of [`NaturalModes::free_mass`]; those of all modes of the
    /// body sum to 1.
    pub effective_mass: Vec<[f64; 3]>,
    /// Discretisation error, where it was asked for.
    pub mesh_error: Option<MeshEstimate>,
}

/// Natural modes with their shapes.
pub struct Shapes {
    body: Body,
    /// Over the free dofs, shape (n, count).
    vectors: Mat<f64>,
}

impl Shapes {
    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        self.body.model.mesh()
    }

    /// The displacement of every node in each mode, three numbers a node; the largest is 1 long.
    pub fn fields(&self) -> Vec<Vec<f64>> {
        let dofs = self.body.model.dofs();
        let field = |mode: usize| {
            let mut field = vec![0.0; dofs.n_dof()];
            dofs.expand_into(self.vectors.col_as_slice(mode), &mut field);
            let squares = field.as_chunks::<3>().0.iter().map(|u| u.iter().map(|x| x * x).sum::<f64>());
            let largest = squares.fold(0.0, f64::max).sqrt();
            field.iter_mut().for_each(|x| *x /= largest);
            field
        };
        (0..self.vectors.ncols()).map(field).collect()
    }

    /// Modal assurance criterion against the modes of another program, one row for each mode here:
    /// `(φᵀψ)² / (φᵀφ ψᵀψ)` over the free dofs (Allemang and Brown 1982). The file is a NumPy matrix with
    /// three rows for each node of the mesh and a column for each mode.
    ///
    /// # Errors
    /// [`StudyError::Field`]: a file that cannot be read; [`StudyError::ModeRows`]: other rows.
    pub fn assurance(&self, file: &Path) -> Result<Vec<Vec<f64>>, StudyError> {
        let others = read_npy(file)?;
        let dofs = self.body.model.dofs();
        let (found, expected) = (others.rows, dofs.n_dof());
        if found != expected {
            return Err(StudyError::ModeRows { file: file.to_path_buf(), found, expected });
        }
        let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let mut free = vec![0.0; self.body.n_dof()];
        let mut table = vec![vec![]; self.vectors.ncols()];
        for other in others.data.chunks_exact(expected) {
            dofs.restrict_into(other, &mut free);
            for (mode, row) in table.iter_mut().enumerate() {
                let own = self.vectors.col_as_slice(mode);
                let product: f64 = own.iter().zip(&free).map(|(a, b)| a * b).sum();
                let size = square(own) * square(&free);
                row.push(if size > 0.0 { product * product / size } else { 0.0 });
            }
        }
        Ok(table)
    }
}

/// Modes that are found where no number is given.
pub const COUNT: usize = 12;

/// The `count` lowest modes, 12 or as many as there are without a number, and their shapes; the
/// discretisation error of the lowest six, and of the displacement under a traction, where it is asked for;
/// at these values of live parameters, and those of the problem otherwise.
///
/// # Errors
/// [`StudyError::Build`]: a problem that cannot be computed with, modes that do not converge.
pub fn natural_modes(
    problem: &Problem,
    count: Option<usize>,
    mesh_error: Option<DiscRequest>,
    settings: &[ParameterValue],
    listener: &dyn Listener,
) -> Result<(NaturalModes, Shapes), StudyError> {
    let mut prepared = prepare(problem, &mut Stopwatch::new(listener), listener)?;
    prepared_at(&mut prepared, settings)?;
    listener.stage("natural modes");
    let space = &prepared.space;
    let scaled =
        (!settings.is_empty()).then(|| space.setting(&space.nominal()).pencil(prepared.body.model.pencil()));
    let pencil = scaled.as_ref().unwrap_or(prepared.body.model.pencil());
    let count = count.unwrap_or(COUNT.min(pencil.n_elastic()));
    let modes = lowest_modes(pencil, &prepared.symbolic, count)?;
    let mesh_error = mesh_error
        .map(|disc| {
            listener.stage("mesh error");
            estimate(&prepared, Some((&modes.eigenvalues, modes.vectors.as_ref())), disc, listener)
        })
        .transpose()?;
    let frequencies_hz = modes.frequencies_hz();
    let ratios = prepared.ratios_along(pencil, &modes.eigenvalues, modes.vectors.as_ref());
    let material_damping: Vec<f64> = frequencies_hz
        .iter()
        .enumerate()
        .map(|(k, &f)| prepared.rayleigh().ratio(f) + ratios.of(k))
        .collect();
    let damping = |(&value, &ratio): (&f64, &f64)| {
        numerical_damping(prepared.file_scheme(), value.sqrt() * prepared.step.time_step, ratio)
    };
    let numerical: Vec<_> = modes.eigenvalues.iter().zip(&material_damping).map(damping).collect();
    let added = numerical.iter().zip(&material_damping).map(|(n, m)| n.ratio.map(|r| r - m));
    let (free_mass, participation) = participation(&prepared.body, pencil, &modes.vectors);
    // A direction in which everything is held has no mass to share.
    let share = |factors: &[f64; 3]| {
        std::array::from_fn(|c| if free_mass[c] > 0.0 { factors[c] * factors[c] / free_mass[c] } else { 0.0 })
    };
    let figures = NaturalModes {
        dofs: pencil.n_dof(),
        rigid_motions: pencil.n_dof() - pencil.n_elastic(),
        time_step: prepared.step.time_step,
        proposed_time_step: proposed_time_step(1.0 / frequencies_hz[0]),
        scheme_damping: added.collect(),
        period_elongation: numerical.iter().map(|n| n.period_elongation).collect(),
        frequencies_hz,
        residuals: modes.residuals,
        material_damping,
        effective_mass: participation.iter().map(share).collect(),
        free_mass,
        participation,
        mesh_error,
    };
    Ok((figures, Shapes { body: prepared.body, vectors: modes.vectors }))
}

/// Mass that is free along each axis, and the participation factors of modes.
fn participation(body: &Body, pencil: &Pencil, vectors: &Mat<f64>) -> ([f64; 3], Vec<[f64; 3]>) {
    let n = body.n_dof();
    let dofs = body.model.dofs();
    let mut translations = Mat::zeros(n, 3);
    for c in 0..3 {
        let along: Vec<f64> = (0..dofs.n_dof()).map(|dof| if dof % 3 == c { 1.0 } else { 0.0 }).collect();
        dofs.restrict_into(&along, translations.col_as_slice_mut(c));
    }
    let mut moved = Mat::zeros(n, 3);
    pencil.mass().mul_into(translations.as_ref(), moved.as_mut());
    let (mass, factors) = (translations.transpose() * &moved, vectors.transpose() * &moved);
    let free_mass = std::array::from_fn(|c| mass[(c, c)]);
    let participation = (0..vectors.ncols()).map(|k| std::array::from_fn(|c| factors[(k, c)])).collect();
    (free_mass, participation)
}
