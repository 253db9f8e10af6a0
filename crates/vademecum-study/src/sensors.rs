//! Places of sensors by effective independence: where a test should measure to tell the modes of a file
//! apart.
//!
//! Each candidate is a node of the surface and an axis, with a row `φ` of the modes. Its effective
//! independence is `E = φ (ΦᵀΦ)⁻¹ φᵀ`, the share of a dimension of the span of the modes that is lost without
//! it; all of them sum to the number of modes. The candidate with the least is dropped, again and again,
//! until as many are left as there are sensors (Kammer 1991).

mod error;

use faer::Mat;
use serde::Serialize;
use vademecum_build::linalg::symmetric_eigen;
use vademecum_eval::SceneOptions;
use vademecum_format::{File, SectionKind};

pub use error::SensorError;

use crate::contents::{Geometry, indices, numbers};
use crate::error::{FileError, StudyError};
use crate::modal::ModalModel;

/// Candidates beyond which a tenth of them is dropped at once: one by one costs their square.
const MANY: usize = 10_000;
/// Smallest eigenvalue of `ΦᵀΦ` over the largest at which modes count as independent.
const INDEPENDENT: f64 = 1e-10;

/// Request for places of sensors.
#[derive(Clone, Debug)]
pub struct SensorRequest {
    /// Sensors.
    pub count: usize,
    /// The lowest modes that they should tell apart.
    pub modes: usize,
    /// Axes that are measured, 0 to 2.
    pub axes: Vec<usize>,
}

/// A sensor.
#[derive(Clone, Debug, Serialize)]
pub struct Sensor {
    /// Label of the node in the mesh file.
    pub node: u64,
    /// Its position \[m\].
    pub position: [f64; 3],
    /// `x`, `y` or `z`.
    pub axis: &'static str,
    /// Effective independence among those chosen.
    pub independence: f64,
}

/// Places of sensors, the most independent first.
#[derive(Clone, Debug, Serialize)]
pub struct SensorPlan {
    /// The sensors.
    pub sensors: Vec<Sensor>,
    /// Frequencies of the modes \[Hz\].
    pub frequencies_hz: Vec<f64>,
    /// Candidates.
    pub candidates: usize,
    /// Ratio of the largest and the smallest singular value of the modes at the sensors.
    pub condition: f64,
    /// Largest modal assurance between two of the modes at the sensors.
    pub largest_assurance: f64,
}

/// The places of a request.
///
/// # Errors
/// [`StudyError::Sensors`]; [`StudyError::File`]: a file without its surface.
pub fn sensor_plan(
    file: &File<'_>,
    options: &SceneOptions,
    request: &SensorRequest,
) -> Result<SensorPlan, StudyError> {
    let SensorRequest { count, modes, .. } = *request;
    let reduced = ModalModel::of(file, options)?;
    let (shapes, rates) = reduced.normal_modes();
    let r = rates.len();
    if !(1..=r).contains(&modes) {
        return Err(SensorError::Modes { asked: modes, known: r }.into());
    }
    let mut order: Vec<usize> = (0..r).collect();
    order.sort_by(|&a, &b| rates[a][0].total_cmp(&rates[b][0]));
    let kind = SectionKind::SurfaceBasis;
    let basis = numbers(file, kind)?;
    let n_nodes = file.metadata().n_surface_nodes as usize;
    let rows = basis.get(..3 * n_nodes * r).ok_or(FileError::Missing { kind })?;
    let candidates: Vec<usize> =
        (0..n_nodes).flat_map(|node| request.axes.iter().map(move |axis| 3 * node + axis)).collect();
    if count < modes || count > candidates.len() {
        return Err(SensorError::Count { count, modes, candidates: candidates.len() }.into());
    }
    let row = |dof: usize| -> Vec<f64> {
        let along = |k: usize| (0..r).map(|i| rows[dof * r + i] * shapes[(i, k)]).sum();
        order[..modes].iter().map(|&k| along(k)).collect()
    };
    let all: Vec<Vec<f64>> = candidates.iter().map(|&dof| row(dof)).collect();
    let mut kept: Vec<usize> = (0..all.len()).collect();
    independence(&all, &kept)?;
    while kept.len() > count.max(MANY) {
        let (_, values) = independence(&all, &kept)?;
        let mut ranked: Vec<usize> = (0..kept.len()).collect();
        ranked.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
        ranked.truncate((kept.len() - kept.len() / 10).max(count.max(MANY)));
        ranked.sort_unstable();
        kept = ranked.into_iter().map(|place| kept[place]).collect();
    }
    let (inverse, mut values) = independence(&all, &kept)?;
    drop_one_by_one(&all, &mut kept, &mut values, inverse, count);
    let (_, values) = independence(&all, &kept)?;
    let geometry = Geometry::of(file)?;
    let labels = indices(file, SectionKind::NodeIds)?;
    let sensor = |(&place, &independence): (&usize, &f64)| {
        let dof = candidates[place];
        let node = labels.get(dof / 3).copied().unwrap_or(dof as u64 / 3 + 1);
        Sensor { node, position: geometry.nodes[dof / 3], axis: ["x", "y", "z"][dof % 3], independence }
    };
    let mut sensors: Vec<Sensor> = kept.iter().zip(&values).map(sensor).collect();
    sensors.sort_by(|a, b| b.independence.total_cmp(&a.independence));
    let frequency = |&k: &usize| rates[k][0] / std::f64::consts::TAU;
    Ok(SensorPlan {
        sensors,
        frequencies_hz: order[..modes].iter().map(frequency).collect(),
        candidates: candidates.len(),
        condition: condition(&all, &kept),
        largest_assurance: largest_assurance(&all, &kept),
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `ΦᵀΦ` of the candidates that are kept.
fn information(all: &[Vec<f64>], kept: &[usize]) -> Mat<f64> {
    let k = all.first().map_or(0, Vec::len);
    Mat::from_fn(k, k, |i, j| kept.iter().map(|&place| all[place][i] * all[place][j]).sum())
}

/// Eigenvalues of `ΦᵀΦ`, scaled to a unit diagonal so that the units of modes do not count, its inverse, and
/// the square root of the ratio of the outer eigenvalues.
fn inverted(information: &Mat<f64>) -> (Mat<f64>, f64) {
    let k = information.nrows();
    let scale: Vec<f64> = (0..k).map(|i| information[(i, i)].sqrt()).collect();
    let scaled = Mat::from_fn(k, k, |i, j| match scale[i] * scale[j] {
        0.0 => 0.0,
        product => information[(i, j)] / product,
    });
    let Ok((values, vectors)) = symmetric_eigen(scaled.as_ref()) else {
        return (Mat::zeros(k, k), f64::INFINITY);
    };
    let (low, high) =
        values.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &x| (low.min(x), high.max(x)));
    if low <= INDEPENDENT * high {
        return (Mat::zeros(k, k), (high / low.max(0.0)).sqrt());
    }
    let entry = |i: usize, j: usize| -> f64 {
        let sum: f64 = values.iter().enumerate().map(|(p, x)| vectors[(i, p)] * vectors[(j, p)] / x).sum();
        sum / (scale[i] * scale[j])
    };
    (Mat::from_fn(k, k, entry), (high / low).sqrt())
}

/// `(ΦᵀΦ)⁻¹`, and the effective independence of each candidate that is kept.
fn independence(all: &[Vec<f64>], kept: &[usize]) -> Result<(Mat<f64>, Vec<f64>), SensorError> {
    let (inverse, condition) = inverted(&information(all, kept));
    if condition > INDEPENDENT.recip().sqrt() {
        return Err(SensorError::Dependent { condition });
    }
    let values = kept.iter().map(|&place| dot(&all[place], &times(&inverse, &all[place]))).collect();
    Ok((inverse, values))
}

fn times(matrix: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    (0..x.len()).map(|i| x.iter().enumerate().map(|(j, x)| matrix[(i, j)] * x).sum()).collect()
}

/// Drops the least independent candidate until `count` are left. Without a row `φ` the inverse is
/// `P + P φᵀ φ P / (1 − E)` (Sherman and Morrison 1950).
fn drop_one_by_one(
    all: &[Vec<f64>],
    kept: &mut Vec<usize>,
    values: &mut Vec<f64>,
    mut inverse: Mat<f64>,
    count: usize,
) {
    while kept.len() > count {
        let least = values.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        let Some((least, &value)) = least else { return };
        let image = times(&inverse, &all[kept[least]]);
        kept.remove(least);
        values.remove(least);
        let share = 1.0 / (1.0 - value).max(f64::EPSILON);
        for (place, value) in kept.iter().zip(values.iter_mut()) {
            let product = dot(&all[*place], &image);
            *value += share * product * product;
        }
        for (i, a) in image.iter().enumerate() {
            image.iter().enumerate().for_each(|(j, b)| inverse[(i, j)] += share * a * b);
        }
    }
}

/// Ratio of the singular values of the modes at the sensors, each mode of length 1 there.
fn condition(all: &[Vec<f64>], kept: &[usize]) -> f64 {
    inverted(&information(all, kept)).1
}

/// Largest modal assurance between two modes at the sensors.
fn largest_assurance(all: &[Vec<f64>], kept: &[usize]) -> f64 {
    let gram = information(all, kept);
    let pairs = (0..gram.nrows()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let assurance = |(i, j): (usize, usize)| gram[(i, j)].powi(2) / (gram[(i, i)] * gram[(j, j)]);
    pairs.map(assurance).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Modes `sin` of a string at eleven places.
    fn string(modes: usize) -> Vec<Vec<f64>> {
        let at = |place: usize, mode: usize| (std::f64::consts::PI * place as f64 * mode as f64 / 12.0).sin();
        (1..12).map(|place| (1..=modes).map(|mode| at(place, mode)).collect()).collect()
    }

    #[test]
    fn independence_sums_to_the_number_of_modes_and_a_dropped_row_is_gone() {
        let all = string(3);
        let mut kept: Vec<usize> = (0..all.len()).collect();
        let (inverse, mut values) = independence(&all, &kept).unwrap();
        assert!((values.iter().sum::<f64>() - 3.0).abs() < 1e-12);
        drop_one_by_one(&all, &mut kept, &mut values, inverse, 4);
        let (_, again) = independence(&all, &kept).unwrap();
        values.iter().zip(&again).for_each(|(a, b)| assert!((a - b).abs() < 1e-12, "{values:?} {again:?}"));
        // One sensor more than modes: each matters.
        assert!(again.iter().all(|value| (0.0..=1.0 + 1e-12).contains(value)));
    }

    #[test]
    fn modes_that_look_alike_are_refused() {
        let all: Vec<Vec<f64>> = (1..6).map(|i| vec![f64::from(i), 2.0 * f64::from(i)]).collect();
        let kept: Vec<usize> = (0..all.len()).collect();
        assert!(matches!(independence(&all, &kept), Err(SensorError::Dependent { .. })));
    }
}
