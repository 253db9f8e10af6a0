//! The full-order march a file is held against, and the basis read back from the file.

use std::collections::HashMap;

use vademecum_build::Matrix;
use vademecum_build::dynamics::{ErrorMeter, INSTANTS, TrajectoryError};
use vademecum_build::dynamics::{FullOrder, StageLoads, State};
use vademecum_build::prepared::Body;
use vademecum_build::prepared::Prepared;
use vademecum_eval::format::File;
use vademecum_format::SectionKind;

/// What happens to a body: the load pattern's amplitude at the instants of each step, and the live parameters
/// in it.
pub trait Story {
    /// Amplitude at the instants of step `n`, given as fractions of it.
    fn amplitude(&self, n: usize, instants: [f64; INSTANTS]) -> [f64; INSTANTS];
    /// Values of the live parameters in step `n`.
    fn parameters(&self, _: usize) -> Vec<f64> {
        vec![]
    }
}

/// `B` over the free dofs, shape (n, r), as the file holds it.
pub fn basis_of(bytes: &[u8], body: &Body) -> Matrix {
    let file = File::parse(bytes).expect("a file");
    let r = file.metadata().n_modes as usize;
    let ids = file.section(SectionKind::NodeIds).expect("ids").u64s().expect("numbers");
    let mesh = body.model.mesh();
    let place: HashMap<u64, usize> = mesh.node_ids.iter().enumerate().map(|(i, &id)| (id, i)).collect();
    let rows = [SectionKind::SurfaceBasis, SectionKind::InteriorBasis]
        .into_iter()
        .filter_map(|kind| file.section(kind))
        .flat_map(|section| section.numbers().expect("numbers").iter().collect::<Vec<f64>>());
    let rows: Vec<f64> = rows.collect();
    let mut basis = Matrix::zeros(body.n_dof(), r);
    for (row, values) in rows.chunks_exact(r).enumerate() {
        let node = place[&u64::from_le_bytes(ids[row / 3])];
        if let Some(free) = body.model.dofs().free(3 * node + row % 3) {
            (0..r).for_each(|k| basis[(free as usize, k)] = values[k]);
        }
    }
    basis
}

/// Marches the story at full order beside reduced coordinates `zeta` (one list per step) of each of several
/// marches.
///
/// # Panics
/// If the body does not march.
pub fn errors(
    prepared: &Prepared,
    basis: &Matrix,
    story: &dyn Story,
    marches: &[&Vec<Vec<f64>>],
) -> Vec<TrajectoryError> {
    let mass = prepared.body.model.pencil().mass();
    let mut meters: Vec<ErrorMeter<'_>> =
        marches.iter().map(|_| ErrorMeter::new(mass, basis.as_ref(), 1)).collect();
    let steps = marches.first().map_or(0, |march| march.len());
    full_order(prepared, story, steps, |step, displacement| {
        for (meter, march) in meters.iter_mut().zip(marches) {
            let zeta = &march[step];
            meter.add(displacement.as_ref(), Matrix::from_fn(zeta.len(), 1, |k, _| zeta[k]).as_ref());
        }
    });
    meters.iter().map(|meter| meter.errors()[0]).collect()
}

/// The story from rest, with matrices of its own for every stretch of equal parameters; shows the
/// displacement (n, 1) after each step.
fn full_order(prepared: &Prepared, story: &dyn Story, steps: usize, mut observe: impl FnMut(usize, &Matrix)) {
    let Prepared { body, symbolic, scheme, space, .. } = prepared;
    let force = &body.patterns[0].1;
    let mut state = State::rest(body.n_dof(), 1);
    let mut time_step = None;
    let mut step = 0;
    while step < steps {
        let values = story.parameters(step);
        let setting = space.setting(&values);
        let pencil = setting.pencil(body.model.pencil());
        let dt = setting.step.time_step;
        carry(&mut state, dt / time_step.replace(dt).unwrap_or(dt));
        let full = FullOrder::new(&pencil, symbolic, scheme, dt, setting.rayleigh()).expect("a march");
        let mut work = full.workspace(1, true);
        while step < steps && story.parameters(step) == values {
            let at = story.amplitude(step, scheme.instants());
            let forces = at.map(|a| Matrix::from_fn(force.len(), 1, |i, _| a * force[i]));
            let loads: StageLoads<'_> = std::array::from_fn(|j| Some(forces[j].as_ref()));
            full.step(&mut state, &loads, &mut work);
            observe(step, &state.displacement);
            step += 1;
        }
    }
}

/// The same motion in a state scaled by another step.
fn carry(state: &mut State, ratio: f64) {
    for i in 0..state.displacement.nrows() {
        state.dt_velocity[(i, 0)] *= ratio;
        state.dt2_acceleration[(i, 0)] *= ratio * ratio;
    }
}
