//! The residual flexibility at the ports of a body, by which assemblies join it to others.
//!
//! With the rows `G` of all ports, one under the other, one solve for each gives `R Gᵀ`; of it a file keeps
//! the compliance `G R Gᵀ`, its inertia `G R M R Gᵀ` (Rubin 1975; without it the synthesis is MacNeal's), and
//! its rows at the surface, at probes and under patterns.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::basis::ResidualBasis;
use super::complement::ResidualOperator;
use super::error::ResidualError;
use super::sweep::answers;
use crate::linalg::symmetric_part;
use crate::progress::Listener;

/// `R Gᵀ`, where a file keeps it.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct PortFlexibility {
    /// `G R Gᵀ` \[m/N\], row by row.
    pub(crate) compliance: Vec<f64>,
    /// `G R M R Gᵀ` \[kg m²/N²\], row by row.
    pub(crate) inertia: Vec<f64>,
    /// Per row of a port, the displacement of each surface node under a unit force along it.
    pub(crate) surface: Vec<Vec<[f64; 3]>>,
    /// Per row of a port, the value of each probe.
    pub(crate) probes: Vec<Vec<f64>>,
    /// Per row of a port, the work of each pattern.
    pub(crate) patterns: Vec<Vec<f64>>,
}

/// The residual flexibility at the ports of the body; `nodes` are those of the surface, in the order of the
/// file.
///
/// # Errors
/// [`ResidualError`].
pub(crate) fn port_flexibility(
    reduced: &ResidualBasis<'_>,
    nodes: &[u32],
    listener: &dyn Listener,
) -> Result<PortFlexibility, ResidualError> {
    let body = reduced.body;
    let operator = ResidualOperator::new(reduced)?;
    let rows: Vec<&Vec<(u32, f64)>> = body.ports.iter().flat_map(|port| &port.rows).collect();
    let fill = |row: usize, load: &mut [f64]| {
        rows[row].iter().for_each(|&(free, weight)| load[free as usize] += weight);
    };
    let found = answers(&operator, rows.len(), fill, listener, |column| {
        let surface: Vec<[f64; 3]> = nodes.iter().map(|&node| operator.row(column, node)).collect();
        let work = |(_, force): &(String, Vec<f64>)| -> f64 {
            force.iter().enumerate().map(|(free, force)| force * column[(free, 0)]).sum()
        };
        let patterns = body.patterns.iter().map(work).collect();
        let whole: Vec<f64> = (0..column.nrows()).map(|free| column[(free, 0)]).collect();
        (surface, operator.probe_values(column), patterns, whole)
    })?;
    let (mut surface, mut probes, mut patterns) = (vec![], vec![], vec![]);
    let mut columns = Mat::zeros(operator.pencil().n_dof(), rows.len());
    for (k, (at_surface, at_probes, of_patterns, whole)) in found.into_iter().enumerate() {
        surface.push(at_surface);
        probes.push(at_probes);
        patterns.push(of_patterns);
        columns.col_as_slice_mut(k).copy_from_slice(&whole);
    }
    let mut weighed = Mat::zeros(columns.nrows(), columns.ncols());
    operator.pencil().mass().mul_into(columns.as_ref(), weighed.as_mut());
    let mut inertia = Mat::zeros(rows.len(), rows.len());
    matmul(inertia.as_mut(), Accum::Replace, columns.transpose(), weighed.as_ref(), 1.0, Par::Seq);
    let value = |i: usize, j: usize| -> f64 {
        rows[i].iter().map(|&(free, weight)| weight * columns[(free as usize, j)]).sum()
    };
    let compliance = Mat::from_fn(rows.len(), rows.len(), value);
    Ok(PortFlexibility {
        compliance: symmetric(compliance.as_ref()),
        inertia: symmetric(inertia.as_ref()),
        surface,
        probes,
        patterns,
    })
}

/// The symmetric part of a matrix, row by row.
fn symmetric(a: MatRef<'_, f64>) -> Vec<f64> {
    let (n, part) = (a.nrows(), symmetric_part(a));
    (0..n * n).map(|k| part[(k / n, k % n)]).collect()
}
