//! From a certified step to the bytes of a file and its report.

use vademecum_format::{Certificate, SectionKind};

use super::{BuildContext, BuildError, Built};
use crate::basis::Basis;
use crate::certificate::{FIGURES, FileFigures, LargeReport, StructureMeasured};
use crate::dynamics::{ModalRatios, ModeRow, mode_table, table_matrix};
use crate::export::{Draft, Parts, encode, mesh_error_section, program};
use crate::input::Problem;
use crate::parametric::SeparationRecord;
use crate::prepared::Prepared;
use crate::progress::Stopwatch;
use crate::report::{BuildPlan, BuildReport, CertificateReport};
use crate::response::BlockTerms;

/// The scheme of large displacements, for people.
const STRAIN_SCHEME: &str = "polarised strain";

/// A whole file and what was measured of it.
pub struct CertifiedFile {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// The certificate as a report shows it.
    pub certificate: CertificateReport,
    /// Record of the separation over live parameters, where there was one.
    pub separation: Option<SeparationRecord>,
    /// Report of large displacements, where they are asked for.
    pub large: Option<LargeReport>,
}

/// The step of a file, and what was measured of it.
#[derive(Default)]
pub struct FileStep<'a> {
    /// The diagonal structure is offered, where the basis allows it.
    pub diagonal: bool,
    /// Terms of the block structure.
    pub block: Option<BlockTerms<'a>>,
    /// The certificate of the metadata.
    pub certificate: Certificate,
    /// The figures beside it.
    pub figures: FileFigures,
    /// Record of the separation over live parameters.
    pub separation: Option<&'a SeparationRecord>,
}

impl<'a> FileStep<'a> {
    /// A step of both structures, or of one where nothing was measured of the other.
    pub(super) fn measured(
        block: Option<BlockTerms<'a>>,
        diagonal: &StructureMeasured,
        of_block: &StructureMeasured,
    ) -> Self {
        let certificate = Certificate { diagonal: diagonal.known(), block: of_block.known() };
        let figures =
            FileFigures { diagonal: diagonal.figures, block: of_block.figures, ..FileFigures::default() };
        Self { diagonal: true, block, certificate, figures, separation: None }
    }

    /// The same before anything is measured.
    pub(super) fn unmeasured(block: Option<BlockTerms<'a>>) -> Self {
        let none = StructureMeasured::default();
        Self::measured(block, &none, &none)
    }
}

/// The bytes of a file with this step, this basis and these sections beside them.
///
/// # Errors
/// [`BuildError::Format`]: numbers that a file cannot hold.
pub fn encode_file<'d>(
    context: &BuildContext<'_>,
    problem: &Problem,
    basis: &Basis,
    step: FileStep<'_>,
    sections: impl IntoIterator<Item = &'d Draft>,
) -> Result<Vec<u8>, BuildError> {
    let BuildContext { prepared, order, .. } = *context;
    let FileStep { diagonal, block, certificate, figures, separation } = step;
    let figures = Draft::f64s(SectionKind::StructureFigures, [3, FIGURES, 1], figures.numbers());
    let mut others = vec![&figures];
    for section in sections {
        others.push(section);
    }
    let mesh_error = context.mesh_error.get().and_then(mesh_error_section);
    others.extend(&mesh_error);
    let scheme = if problem.is_large() { STRAIN_SCHEME.into() } else { problem.scheme().to_string() };
    let parts = Parts {
        program: program(prepared.symbolic.solver()),
        problem,
        body: &prepared.body,
        order,
        basis,
        scheme_name: &scheme,
        scheme: prepared.file_scheme(),
        time_step: prepared.step.time_step,
        rayleigh: prepared.rayleigh(),
        diagonal,
        block,
        others,
        // Those of a parametric model are in sections of their own.
        parameters: (!prepared.is_parametric(problem)).then_some(&prepared.space),
        separation,
        certificate,
        mode_table: table_matrix(&modes(context, basis)),
    };
    Ok(encode(&parts)?)
}

/// Damping ratios of the modes of a basis in addition to Rayleigh's.
pub(super) fn ratios_of(prepared: &Prepared, basis: &Basis) -> ModalRatios {
    match &basis.eigenvalues {
        Some(eigenvalues) => {
            prepared.ratios_along(prepared.body.model.pencil(), eigenvalues, basis.vectors.as_ref())
        }
        None => prepared.ratios.clone(),
    }
}

/// One row per mode.
fn modes(context: &BuildContext<'_>, basis: &Basis) -> Vec<ModeRow> {
    let prepared = context.prepared;
    let (time_step, rayleigh) = (prepared.step.time_step, prepared.rayleigh());
    let ratios = ratios_of(prepared, basis);
    let damping = (&rayleigh, &ratios);
    mode_table(&basis.quotients(), &basis.energy, prepared.file_scheme(), damping, time_step)
}

impl CertifiedFile {
    /// The file with the report of its build.
    pub fn reported(
        self,
        context: &BuildContext<'_>,
        problem: &Problem,
        (basis, snapshots): (&Basis, usize),
        plan: BuildPlan,
        watch: &Stopwatch<'_>,
    ) -> Built {
        let BuildContext { prepared, first_period, .. } = *context;
        let body = &prepared.body;
        let report = BuildReport {
            title: problem.title.clone(),
            nodes: body.model.mesh().nodes.len(),
            elements: body.model.mesh().element_region.len(),
            dofs: body.n_dof(),
            modes: basis.n_modes(),
            steps_per_first_period: first_period / prepared.step.time_step,
            mode_table: modes(context, basis),
            singular_values: basis.singular_values.clone(),
            snapshots,
            certificate: self.certificate,
            test_loads: match self.large {
                Some(_) => vec![],
                None => context.unseen.places(&body.model.mesh().nodes),
            },
            separation: self.separation,
            timings: watch.timings(),
            file_bytes: self.bytes.len(),
            plan,
            large: self.large,
            mesh_error: context.mesh_error.get().cloned(),
        };
        Built { bytes: self.bytes, report }
    }
}
