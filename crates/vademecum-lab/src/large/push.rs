//! Default scenario of a body of large displacements.

use vademecum_build::dynamics::lowest_modes;
use vademecum_build::input::Problem;
use vademecum_build::large::asked_displacement;
use vademecum_build::prepared::Prepared;

use vademecum_study::StudyError;
use vademecum_study::scenario::{ContactEntry, Scenario, SinusoidEntry};

/// Modes that tell how far a force moves the place where it acts.
const MODES: usize = 8;

/// Displacement of the linear body there, as a part of the displacement that the file is made for: the most
/// that the pushes of a certificate have.
const SHARE: f64 = 0.8;

/// Dynamic amplification of a body of one frequency under a squared sine of one period.
const SWING: f64 = 1.7;

/// First periods of the scenario.
const PERIODS: f64 = 5.0;

/// A push where the first natural mode moves the loadable surface most, along that motion: it comes and goes
/// as a squared sine of one first period, and then the body swings for four more. A push that begins at once
/// would make fast modes swing that no method here resolves, and hide what tells the methods apart.
///
/// With the compliance `c` of the place along the push, that of the first eight modes, a linear body swings
/// out to about `1.7 c F` under a force of height `F`. It is so large that this is four fifths of what
/// `large.displacement` asks for: the body itself moves by about as much, and stays where the file has been
/// trained.
///
/// # Errors
/// [`StudyError::NothingToPush`]; [`StudyError::Build`]: no natural modes.
pub(super) fn push(problem: &Problem, prepared: &Prepared) -> Result<Scenario, StudyError> {
    let (body, time_step) = (&prepared.body, prepared.step.time_step);
    let (pencil, mesh) = (body.model.pencil(), body.model.mesh());
    let modes = lowest_modes(pencil, &prepared.symbolic, MODES.min(pencil.n_dof()))?;
    let moved = |triangle: &[u32; 3], mode: usize| -> [f64; 3] {
        let at =
            |dof: usize| body.model.dofs().free(dof).map_or(0.0, |free| modes.vectors[(free as usize, mode)]);
        std::array::from_fn(|c| triangle.iter().map(|&node| at(3 * node as usize + c)).sum::<f64>() / 3.0)
    };
    let size = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let far = |triangle: &&[u32; 3]| size(moved(triangle, 0));
    let place = body.loadable.iter().max_by(|a, b| far(a).total_cmp(&far(b)));
    let place = place.filter(|place| far(place) > 0.0).ok_or(StudyError::NothingToPush)?;
    let along = moved(place, 0).map(|x| x / far(&place));
    let share = |mode: usize| moved(place, mode).iter().zip(along).map(|(x, a)| x * a).sum::<f64>();
    let compliance: f64 =
        modes.eigenvalues.iter().enumerate().map(|(mode, value)| share(mode).powi(2) / value).sum();
    let force = SHARE * asked_displacement(problem, mesh) / (SWING * compliance);
    let point = std::array::from_fn(|c| place.iter().map(|&n| mesh.nodes[n as usize][c]).sum::<f64>() / 3.0);
    let period = std::f64::consts::TAU / modes.eigenvalues[0].sqrt();
    let steps = |periods: f64| (periods * period / time_step).round().max(1.0) * time_step;
    let end = steps(1.0);
    // `½ (1 + sin(2π t/T − π/2))` is `sin²(π t/T)`.
    let pulse = SinusoidEntry { frequency: 1.0 / end, phase: -std::f64::consts::FRAC_PI_2, mean: 1.0 };
    let mut push = ContactEntry::push(point, along.map(|a| 0.5 * force * a), end);
    push.sinusoid = Some(pulse);
    Ok(Scenario { duration: steps(PERIODS), contacts: vec![push], ..Scenario::default() })
}
