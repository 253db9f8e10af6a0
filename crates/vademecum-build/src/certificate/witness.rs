//! A reference solution beside the model at full order.

use faer::Mat;
use vademecum_format::scheme::SchemeTable;

use super::error::CertificateError;
use crate::dynamics::{ErrorMeter, FullOrder, Rayleigh, ReferenceSolution, TimedLoad, march_full_order};
use crate::fem::{Pencil, Symbolic};
use crate::linalg::project;
use crate::progress::Listener;

/// Part of the motion at full order that the space of a reference leaves out: the largest distance of the
/// march in that space from the march at full order, both with the same scheme and step \[s\], relative L2
/// over all dofs and `steps` steps, mass norm. The time error of both is the same and falls out.
///
/// The damping of both is `αM + βK` alone, without loss factors and dashpots. Costs one factor for each
/// stage of the scheme, and a solve of all trajectories for each stage of each step.
///
/// # Errors
/// [`CertificateError`]: a march that cannot start or is stopped.
pub(crate) fn distance_at_full_order(
    (pencil, symbolic): (&Pencil, &Symbolic),
    truth: &ReferenceSolution<'_>,
    (scheme, time_step, damping): (&SchemeTable, f64, Rayleigh),
    (loads, steps): (&[TimedLoad], usize),
    listener: &dyn Listener,
) -> Result<f64, CertificateError> {
    let (space, m) = (truth.space(), truth.vectors());
    let columns = loads.iter().map(|load| load.column + 1).max().unwrap_or(0);
    let projected = Pencil::from_matrices(Mat::<f64>::identity(m, m).as_ref(), truth.stiffness().as_ref())?;
    let analysed = Symbolic::analyze(&projected)?;
    let march = FullOrder::new(&projected, &analysed, scheme, time_step, damping)?;
    let along = |load: &TimedLoad| TimedLoad { force: project(space, &load.force), ..load.clone() };
    let shares: Vec<TimedLoad> = loads.iter().map(along).collect();
    let mut coordinates = Vec::with_capacity(1 + steps);
    march_full_order(&march, &shares, columns, steps, listener, |_, state| {
        coordinates.push(state.displacement.clone());
    })?;
    let march = FullOrder::new(pencil, symbolic, scheme, time_step, damping)?;
    let mut meter = ErrorMeter::new(pencil.mass(), space, columns);
    march_full_order(&march, loads, columns, steps, listener, |step, state| {
        meter.add(state.displacement.as_ref(), coordinates[step].as_ref());
    })?;
    // A distance that is not a number is none of 0.
    let larger = |most: f64, found: f64| if found > most || found.is_nan() { found } else { most };
    Ok(meter.errors().iter().map(|found| found.error).fold(0.0, larger))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::schemes::bathe;
    use crate::dynamics::{Interval, ReferenceOptions};
    use crate::fem::test_mesh::{block, hold};
    use crate::fem::{Material, Model};
    use crate::progress::Silent;

    #[test]
    fn a_small_space_is_far_from_the_full_order_and_a_large_one_near() {
        let mesh = block([6, 3, 3], [0.3, 0.1, 0.12]);
        let held = hold(&mesh, |p| p[0] == 0.0);
        let model = Model::assemble(mesh, &[Material::isotropic(1e7, 0.3, 1000.0)], &held).unwrap();
        let (pencil, n) = (model.pencil(), model.pencil().n_dof());
        let symbolic = Symbolic::analyze(pencil).unwrap();
        let (time_step, steps, damping) = (1e-3, 100, Rayleigh { alpha: 0.0, beta: 1e-5 });
        let load = |column: usize| TimedLoad {
            column,
            force: (0..n).map(|i| f64::from(u8::from(i == n / (2 + column)))).collect(),
            when: Interval { start: 0.0, end: 0.02, ramp: 0.0 }.into(),
        };
        let loads = [load(0), load(1)];
        let decay = |lambda: f64, _| 0.5 * (damping.alpha + damping.beta * lambda);
        let distance = |vectors_per_force: usize| {
            let options = ReferenceOptions { tolerance: 1e-12, vectors_per_force, bytes: u64::MAX };
            let span = (time_step, steps);
            let truth =
                ReferenceSolution::find(pencil, &symbolic, &decay, &loads, span, &options, &Silent).unwrap();
            let step = (&bathe(), time_step, damping);
            let found =
                distance_at_full_order((pencil, &symbolic), &truth, step, (&loads, steps), &Silent).unwrap();
            let estimated = (0..2).map(|column| truth.trajectory(column).estimate()).fold(0.0, f64::max);
            (found, estimated)
        };
        let ((small, estimated), (large, _)) = (distance(6), distance(60));
        assert!(small > 1e-4 && small < estimated, "{small} {estimated}");
        assert!(large < 1e-8, "{large}");
    }
}
