//! Static equilibrium under a load at large displacements.

use super::balance::{LastPoint, StageBalance};
use super::error::{LargeError, check_length};
use super::newton::{Newton, NewtonStop};
use super::space::MotionSpace;
use super::vectors::sum;
use crate::fem::{GreenStrain, Symbolic};

/// Options of load stepping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestOptions {
    /// Parts into which the load path is cut at first; longer ones are tried after parts that were easy.
    pub parts: usize,
    /// Most halvings of a part.
    pub halvings: usize,
    /// Newton's method.
    pub newton: Newton,
}

impl Default for RestOptions {
    fn default() -> Self {
        // Load steps are long: an old factor costs more corrections than it saves.
        Self { parts: 1, halvings: 10, newton: Newton { keep: 0.0, ..Newton::default() } }
    }
}

/// A body at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticSolution {
    /// Displacement over the free dofs \[m\].
    pub displacement: Vec<f64>,
    /// Load steps that were taken.
    pub(crate) load_steps: usize,
    /// Newton's corrections in those.
    pub iterations: usize,
    /// Size of each correction of the last load step, as a part of the energy, its root.
    pub(crate) corrections: Vec<f64>,
}

/// The rest of a held body at the end of a load path: `load(s, f)` writes the load \[N\] at the part
/// `s ∈ [0, 1]` of the path, and `start` is a rest at `s = 0`.
///
/// A load step without convergence is halved, and the shortest ones are tried with a line search. A
/// factorisation for each correction.
///
/// # Errors
/// [`LargeError`]: a body without supports, a load that is no number, no rest.
pub fn rest(
    strain: &GreenStrain<'_>,
    symbolic: &Symbolic,
    start: &[f64],
    load: &mut dyn FnMut(f64, &mut [f64]),
    options: &RestOptions,
) -> Result<StaticSolution, LargeError> {
    let n = strain.n_dof();
    check_length("the start", start.len(), n)?;
    if strain.model().pencil().rigid().is_some() {
        return Err(LargeError::FreeBody);
    }
    let mut found =
        StaticSolution { displacement: start.to_vec(), load_steps: 0, iterations: 0, corrections: vec![] };
    let space = MotionSpace::Whole(symbolic);
    let whole = 1.0 / options.parts.max(1) as f64;
    let (mut reached, mut part, mut force) = (0.0, whole, vec![0.0; n]);
    let mut way = vec![0.0; n];
    while reached < 1.0 {
        // The last part ends at 1, whatever the rounding.
        let next = if reached + 1.001 * part >= 1.0 { 1.0 } else { reached + part };
        force.fill(0.0);
        load(next, &mut force);
        if !force.iter().all(|f| f.is_finite()) {
            return Err(LargeError::Load { at: next });
        }
        let mut stage = StageBalance {
            strain,
            start: &found.displacement,
            midpoint: false,
            linear: None,
            force: force.clone(),
            weight: 1.0,
            history: vec![],
            energy: 0.0,
            last: LastPoint::default(),
        };
        // Where the last load step leads.
        let mut increment: Vec<f64> = way.iter().map(|d| (next - reached) * d).collect();
        let shortest = 0.5 * (next - reached) < whole * 0.5_f64.powi(options.halvings as i32);
        let solved = options.newton.solve(&mut stage, space, &mut None, &mut increment, shortest);
        let displacement = stage.displacement();
        let inside_out = solved.is_ok() && strain.least_stretch(&displacement) <= 0.0;
        match solved {
            Ok(course) if !inside_out => {
                let change = sum(&displacement, -1.0, &found.displacement);
                way = change.iter().map(|d| d / (next - reached)).collect();
                found.displacement = displacement;
                found.load_steps += 1;
                found.iterations += course.corrections.len();
                if course.corrections.len() <= 6 {
                    part = (2.0 * part).min(whole);
                }
                found.corrections = course.corrections;
                reached = next;
            }
            Err(NewtonStop::Factor(error)) => return Err(error.into()),
            failed => {
                part = 0.5 * (next - reached);
                match failed {
                    Ok(_) if shortest => return Err(LargeError::InsideOut { reached }),
                    Err(NewtonStop::Unbalanced { residual, iterations }) if shortest => {
                        return Err(LargeError::NoRest { reached, step: 2.0 * part, residual, iterations });
                    }
                    _ => {}
                }
            }
        }
    }
    Ok(found)
}
