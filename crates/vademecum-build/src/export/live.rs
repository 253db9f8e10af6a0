//! Sections of live parameters of a parametric reduced-order model.

use faer::{Mat, MatRef};
use vademecum_format::{ParameterRole, SectionKind};

use super::draft::Draft;
use crate::dynamics::ModalRatios;
use crate::fem::{Pencil, SymmetricMatrix};
use crate::linalg::symmetric_part;
use crate::parallel;
use crate::prepared::{LiveParameter, LiveRegions, Prepared};
use crate::residual::ScaleTerm;

/// A point of the box at which a file was measured.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct PointMeasured {
    /// Values of the parameters.
    pub values: Vec<f64>,
    /// True if it trained the basis.
    pub trained: bool,
    /// Relative error of the trajectories there, of the worst load.
    pub error: f64,
}

/// A point of the box at which a file was measured closer.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct PointWitnessed {
    /// Values of the parameters.
    pub values: Vec<f64>,
    /// Relative error of the trajectories there, of the worst load.
    pub error: f64,
    /// Relative distance of the reference of that error from a march at full order.
    pub reference: f64,
    /// Truncation of the static answer to a point load, relative, in the mass norm: median, 95 % and largest
    /// over all loadable nodes and directions.
    pub bound: Option<[f64; 3]>,
}

/// Reduced matrices of what is not live and of each live region, in the basis of the file.
pub(crate) struct RegionForms {
    /// `BᵀK_qB`.
    pub(crate) stiffness: Vec<Mat<f64>>,
    /// `BᵀM_qB`, if a density is live.
    pub(crate) mass: Option<Vec<Mat<f64>>>,
}

impl RegionForms {
    pub(crate) fn new(prepared: &Prepared, regions: &LiveRegions, basis: MatRef<'_, f64>) -> Self {
        let pencil = prepared.body.model.pencil();
        let of = |matrix: fn(&Pencil, usize) -> &SymmetricMatrix| {
            let mut sums = vec![Mat::<f64>::zeros(basis.ncols(), basis.ncols()); 1 + regions.count];
            for (region, &live) in regions.of_mesh.iter().enumerate() {
                let mut image = Mat::zeros(basis.nrows(), basis.ncols());
                matrix(pencil, region).mul_into(basis, image.as_mut());
                sums[live as usize] += symmetric_part((basis.transpose() * image).as_ref());
            }
            sums
        };
        let stiffness = of(Pencil::region_stiffness);
        let mass = regions.density.then(|| of(Pencil::region_mass));
        Self { stiffness, mass }
    }

    /// The reduced stiffness at scales of what is not live and of each live region.
    pub(crate) fn stiffness_at(&self, scales: &[f64]) -> Mat<f64> {
        weighted(&self.stiffness, scales)
    }

    /// The reduced mass at such scales, without factors of the whole body.
    pub(crate) fn mass_at(&self, scales: &[f64]) -> Mat<f64> {
        let r = self.stiffness[0].nrows();
        self.mass.as_ref().map_or_else(|| Mat::identity(r, r), |mass| weighted(mass, scales))
    }
}

/// `Σ scale · form`.
fn weighted(forms: &[Mat<f64>], scales: &[f64]) -> Mat<f64> {
    let r = forms[0].nrows();
    let mut sum = Mat::zeros(r, r);
    for (form, &scale) in forms.iter().zip(scales) {
        sum += form * faer::Scale(scale);
    }
    sum
}

/// Lower triangles, row by row, one matrix after the other.
fn packed(kind: SectionKind, forms: &[Mat<f64>]) -> Draft {
    let r = forms[0].nrows();
    let rows = parallel::map(forms.len(), &|q| -> Vec<f64> {
        (0..r).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|place| forms[q][place]).collect()
    });
    Draft::f64s(kind, [forms.len(), r * (r + 1) / 2, 1], rows.into_iter().flatten())
}

/// Number of a role in the file, and its region.
fn role_numbers(role: ParameterRole, regions: &LiveRegions) -> [f64; 2] {
    let live = |region: u32| f64::from(regions.of_mesh[region as usize] - 1);
    match role {
        ParameterRole::Stiffness => [0.0, 0.0],
        ParameterRole::RegionStiffness { region } => [1.0, live(region)],
        ParameterRole::Density => [2.0, 0.0],
        ParameterRole::RegionDensity { region } => [3.0, live(region)],
        ParameterRole::Alpha => [4.0, 0.0],
        ParameterRole::Beta => [5.0, 0.0],
        ParameterRole::LossFactor { region } => [7.0, live(region)],
        ParameterRole::Damping { group } => [8.0, f64::from(group)],
        _ => [6.0, 0.0],
    }
}

/// The sections of the parameters and of what they scale; `ratios` are those of the modes that no loss factor
/// makes, all alike.
pub(crate) fn live_sections(
    (parameters, ratios): (&[LiveParameter], &ModalRatios),
    regions: &LiveRegions,
    forms: &RegionForms,
    residual: &[ScaleTerm],
) -> Vec<Draft> {
    let row = |p: &LiveParameter| {
        let [role, region] = role_numbers(p.role, regions);
        [role, region, f64::from(u8::from(p.log)), p.lower, p.upper, p.nominal]
    };
    let (count, n_mesh) = (parameters.len(), regions.n_mesh);
    let mut drafts = vec![
        Draft::f64s(SectionKind::LiveParameters, [count, 6, 1], parameters.iter().flat_map(row)),
        Draft::names(SectionKind::LiveNames, parameters.iter().map(|p| p.name.as_str())),
        packed(SectionKind::LiveStiffness, &forms.stiffness),
        Draft::u32s(SectionKind::LiveRegions, [n_mesh, 1, 1], regions.of_mesh[..n_mesh].iter().copied()),
    ];
    drafts.extend(forms.mass.as_deref().map(|mass| packed(SectionKind::LiveMass, mass)));
    if !regions.loss.is_empty() {
        let mut loss = vec![ratios.of(0); 1 + regions.count];
        for (&live, &eta) in regions.of_mesh.iter().zip(&regions.loss).filter(|(live, _)| **live > 0) {
            loss[live as usize] = eta;
        }
        drafts.push(Draft::f64s(SectionKind::LiveLoss, [loss.len(), 1, 1], loss));
    }
    if !residual.is_empty() {
        let numbers = residual.iter().flatten().copied();
        drafts.push(Draft::f64s(SectionKind::LiveResidual, [residual.len(), 5, 1], numbers));
    }
    drafts
}

/// The section of the points that were measured.
pub(crate) fn live_certificate(points: &[PointMeasured]) -> Draft {
    let columns = points.first().map_or(0, |point| point.values.len()) + 2;
    let row = |point: &PointMeasured| {
        let last = [f64::from(u8::from(point.trained)), point.error];
        point.values.iter().copied().chain(last).collect::<Vec<_>>()
    };
    Draft::f64s(SectionKind::LiveCertificate, [points.len(), columns, 1], points.iter().flat_map(row))
}

/// The section of the points that were measured closer.
pub(crate) fn live_witnesses(points: &[PointWitnessed]) -> Draft {
    let row = |point: &PointWitnessed| {
        let last = [point.error, point.reference].into_iter().chain(point.bound.into_iter().flatten());
        point.values.iter().copied().chain(last).collect::<Vec<_>>()
    };
    let rows: Vec<Vec<f64>> = points.iter().map(row).collect();
    let columns = rows.first().map_or(0, Vec::len);
    Draft::f64s(SectionKind::LiveWitnesses, [points.len(), columns, 1], rows.into_iter().flatten())
}
