//! A file against a motion that is exact in time: its whole error, and what makes it.
//!
//! A march at full order has the error of its time scheme, and the file was made with the same scheme. So the
//! two may agree to six digits where both are wrong in the second. The reference here marches nothing
//! ([`ReferenceSolution`]).

use faer::MatRef;
use serde::Serialize;
use vademecum_build::dynamics::{
    Decay, MotionPart, ReferenceDistance, ReferenceError, ReferenceOptions, ReferenceSolution,
    ReferenceTrajectory, TimedLoad, TrajectoryError,
};
use vademecum_build::fem::{Pencil, Symbolic};
use vademecum_build::limits::memory_in_words;
use vademecum_build::progress::Listener;

/// Errors of a file against a motion that is exact in time; each is relative L2 over all steps and, where
/// nothing else is said, in the mass norm over all dofs.
#[derive(Clone, Debug, Serialize)]
pub struct TruthErrors {
    /// Of the file's displacement.
    pub total_error: f64,
    /// Estimate of the error of the reference itself.
    pub truth_error: f64,
    /// Vectors of the space of the reference.
    pub truth_vectors: usize,
    /// Of the march at full order with the file's scheme: what the scheme does to the motion. None of a file
    /// that moves its modes exactly.
    pub time_error: Option<f64>,
    /// Of the projection of the exact motion on the basis: the projection error.
    pub basis_error: f64,
    /// Of the file against the projection of the march at full order by its own scheme, or of the exact
    /// motion where it has none: what its coordinates add. Relative to that motion.
    pub rest_error: f64,
    /// Of the displacement under a contact, along its force, while the force acts; the largest of all
    /// contacts. None if the scenario has no contact that moves its point.
    pub contact_error: Option<f64>,
    /// The same of each contact, in the order of the scenario.
    pub contact_errors: Vec<Option<f64>>,
}

/// Vectors of the reference for each force: without damping a point force that jumps would take as many as
/// there are, and what the last ones add is far below what a file misses.
const MAX_VECTORS_PER_FORCE: usize = 200;

/// Vectors of the reference for all forces, or three for each: to keep them orthogonal takes a time that
/// grows with their square.
const MAX_VECTORS: usize = 4_000;

/// The reference for the loads of a scenario.
///
/// # Errors
/// [`ReferenceError`].
pub fn find_truth<'a>(
    pencil: &'a Pencil,
    symbolic: &Symbolic,
    decay: Decay<'_>,
    loads: &[TimedLoad],
    steps: (f64, usize),
    listener: &dyn Listener,
) -> Result<ReferenceSolution<'a>, ReferenceError> {
    listener.stage("find the motion that is exact in time");
    // Places of a path share the vectors: their forces are nearly the same and rise gently.
    let forces = loads.len() + pencil.dampers().starts();
    let vectors_per_force = MAX_VECTORS_PER_FORCE.min(MAX_VECTORS / forces.max(1)).max(3);
    let options = ReferenceOptions { vectors_per_force, ..ReferenceOptions::default() };
    let n = pencil.n_dof();
    let most = options.most_vectors(forces, n);
    let bytes = memory_in_words(8 * (most * n) as u64);
    listener
        .note(&format!("the reference that is exact in time: at most {most} vectors of {n} dofs, {bytes}"));
    ReferenceSolution::find(pencil, symbolic, decay, loads, steps, &options, listener)
}

/// Errors of a file against the reference. `file` is its basis with its coordinates, then what fields show
/// beside them. `contacts` are the loads of the scenario's contacts, the number of the contact that each
/// belongs to, and what the file shows under each, along its force and times its size, shape (loads,
/// instants); `same_scheme` is the file beside the march at full order by its own scheme, and
/// that march beside the truth; if it has a scheme.
pub(crate) fn truth_errors(
    truth: &ReferenceSolution<'_>,
    file: &[MotionPart<'_>],
    contacts: (Entries<'_>, MatRef<'_, f64>),
    time_step: f64,
    same_scheme: Option<(TrajectoryError, f64)>,
) -> TruthErrors {
    let distance = truth.trajectory(0).distance(file);
    let ReferenceDistance { error, floor } = distance;
    let TrajectoryError { error, floor } =
        same_scheme.map_or(TrajectoryError { error, floor }, |same| same.0);
    let contact_errors = contact_errors(truth.trajectory(0), contacts, time_step);
    TruthErrors {
        total_error: distance.error,
        truth_error: truth.trajectory(0).estimate(),
        truth_vectors: truth.vectors(),
        time_error: same_scheme.map(|same| same.1),
        basis_error: distance.floor,
        // The two are legs and hypotenuse; below the rounding of the squares nothing is left.
        rest_error: ((error - floor).max(0.0) * (error + floor)).sqrt(),
        contact_error: largest_error(&contact_errors),
        contact_errors,
    }
}

/// Loads, and the number of the contact that each belongs to.
pub(crate) type Entries<'a> = (&'a [TimedLoad], &'a [usize]);

/// The relative L2 error of what is shown under each contact, the displacement along its force, over the
/// instants at which the force acts. Components of a force and places on a path are summed. `shown` has shape
/// (loads, instants), times the size of each force. None of a contact that does not move its point.
pub fn contact_errors(
    truth: ReferenceTrajectory<'_>,
    ((contacts, entries), shown): (Entries<'_>, MatRef<'_, f64>),
    time_step: f64,
) -> Vec<Option<f64>> {
    // Squares of the error and of the displacement, contact by contact.
    let mut sums = vec![[0.0; 2]; entries.iter().max().map_or(0, |last| last + 1)];
    let rows: Vec<_> = contacts.iter().map(force_row).collect();
    for (first, exact) in truth.along_windows(&rows) {
        for ((&entry, load), c) in entries.iter().zip(contacts).zip(0..) {
            let sums: &mut [f64; 2] = &mut sums[entry];
            for t in (0..exact.ncols()).filter(|&t| load.when.factor((first + t) as f64 * time_step) != 0.0) {
                let (exact, shown): (f64, f64) = (exact[(c, t)], shown[(c, first + t)]);
                sums[0] += (exact - shown).powi(2);
                sums[1] += exact.powi(2);
            }
        }
    }
    relative_errors(&sums)
}

/// Relative errors from squares of an error and of what it is a share of; none of what does not move.
pub(crate) fn relative_errors(sums: &[[f64; 2]]) -> Vec<Option<f64>> {
    sums.iter().map(|[error, norm]| (*norm != 0.0).then(|| (error / norm).sqrt())).collect()
}

/// The largest of the errors that there are.
pub fn largest_error(errors: &[Option<f64>]) -> Option<f64> {
    // `maximum` of IEEE 754: what is no number is not passed over.
    let larger = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    errors.iter().copied().flatten().reduce(larger)
}

/// A force as weights on its dofs: what it does per displacement, so the displacement along it but for a
/// factor.
pub(crate) fn force_row(load: &TimedLoad) -> Vec<(u32, f64)> {
    let acts = load.force.iter().enumerate().filter(|(_, force)| **force != 0.0);
    acts.map(|(dof, force)| (dof as u32, *force)).collect()
}

#[cfg(test)]
mod tests {
    use faer::{Mat, mat};
    use vademecum_build::dynamics::{Interval, Rayleigh};
    use vademecum_build::progress::Silent;

    use super::*;

    #[test]
    fn a_contact_counts_while_its_force_acts_and_the_worst_contact_counts() {
        // Two masses on springs of their own; the file shows each by one coordinate.
        let mass = mat![[1.0, 0.0], [0.0, 2.0]];
        let stiffness = mat![[3.0, 0.0], [0.0, 5.0]];
        let pencil = Pencil::from_matrices(mass.as_ref(), stiffness.as_ref()).expect("a pencil");
        let symbolic = Symbolic::analyze(&pencil).expect("a pattern");
        let load = |force: [f64; 2], end: f64| TimedLoad {
            column: 0,
            force: force.to_vec(),
            when: Interval { start: 0.0, end, ramp: 0.0 }.into(),
        };
        let contacts = [load([-7.0, 0.0], 1.0), load([0.0, 4.0], 2.0)];
        let damping = Rayleigh { alpha: 0.1, beta: 0.01 };
        let decay = |lambda, _| damping.decay(lambda);
        let truth = find_truth(&pencil, &symbolic, &decay, &contacts, (0.1, 30), &Silent).expect("a truth");
        let exact = truth.trajectory(0).along(&[vec![(0, 1.0)], vec![(1, 1.0)]]);
        // The first is 1 % off while its force acts, the second 2 %; later both are anywhere.
        let shown = Mat::from_fn(2, 31, |i, n| match n {
            0..10 => exact[(i, n)] * [1.01, 0.98][i],
            10..20 => exact[(i, n)] * [9.0, 0.98][i],
            _ => 1e3,
        });
        // What is shown under a contact is the displacement along its force, times its size.
        let under = |contacts: &[TimedLoad]| {
            Mat::from_fn(contacts.len(), 31, |c, n| {
                (0..2).map(|i| contacts[c].force[i] * shown[(i, n)]).sum::<f64>()
            })
        };
        let errors = |contacts: &[TimedLoad]| {
            let entries: Vec<usize> = (0..contacts.len()).collect();
            contact_errors(truth.trajectory(0), ((contacts, &entries), under(contacts).as_ref()), 0.1)
        };
        let error = |contacts: &[TimedLoad]| largest_error(&errors(contacts));
        let close =
            |found: Option<f64>, expected: f64| (found.expect("moved") / expected - 1.0).abs() < 1e-12;
        assert!(close(error(&contacts[..1]), 0.01));
        assert!(close(error(&contacts), 0.02));
        // Each by itself.
        let each = errors(&contacts);
        assert!(each.len() == 2 && close(each[0], 0.01) && close(each[1], 0.02), "{each:?}");
        // No contact, and one that pushes nothing.
        assert_eq!(error(&[]), None);
        assert_eq!(error(&[load([0.0; 2], 1.0)]), None);
    }
}
