//! Load cases at full order, and their projection on a basis.

use std::fmt::Debug;
use std::time::Instant;

use faer::Mat;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::learn::{LargeModel, at_load_nodes};
use crate::dynamics::large::{LargeDamping, LargeError, LargeMarch, LargeScheme, LargeWork, Newton};
use crate::dynamics::{Modes, Rayleigh, TrajectoryError, Work};
use crate::fem::{GreenStrain, SOFTENING, Symbolic};
use crate::input::Problem;
use crate::linalg::{Random, project, unit};
use crate::mesh::Mesh;
use crate::parallel;
use crate::prepared::Body;
use crate::progress::Listener;
use crate::store::{Inputs, StageCache};

/// Steps of the reference in a step of the file, where nothing else is asked for.
pub(crate) const PARTS: usize = 4;
/// Tolerance of Newton's method in the reference, far below the error of any reduced motion.
const TOLERANCE: f64 = 1e-5;
/// Load halvings before a load case is redrawn.
const HALVINGS: usize = 2;
/// Draws of a load case; those of the last draw are halved up to [`MAX_HALVINGS`] times.
const MAX_DRAWS: u64 = 8;
/// Load halvings of the last draw.
const MAX_HALVINGS: usize = 12;
/// Width of a push, as a part of the longest edge of the bounding box.
const WIDTH: f64 = 0.1;
/// Widths beyond which a push is not felt.
const REACH: f64 = 3.0;

/// Dynamic amplification of a linear body under a pulse of about its period, and under a push that
/// begins at once.
const PULSE: f64 = 1.6;
/// See [`PULSE`].
const HELD: f64 = 2.0;

/// A push by something blunt: a force spread over the loadable nodes around one of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Push {
    /// Unique name among the pushes of the body.
    pub(crate) name: String,
    /// Loadable nodes and their forces \[N\] at the height of the push.
    pub(crate) nodes: Vec<(u32, [f64; 3])>,
    /// The same over the free dofs.
    pub(crate) force: Vec<f64>,
    /// Duration \[s\].
    pub(crate) length: f64,
    /// True for a pulse shaped as a squared sine; otherwise the force is constant and ends at once.
    pub(crate) pulse: bool,
}

impl Push {
    /// Its share of the height at a time \[s\]; where it jumps the mean of both sides.
    pub(crate) fn at(&self, time: f64) -> f64 {
        let near = 1e-6 * self.length;
        0.5 * (self.within(time, time - near) + self.within(time, time + near))
    }

    /// The same with a part of the force.
    fn scaled(&self, part: f64) -> Push {
        let nodes = self.nodes.iter().map(|&(node, f)| (node, f.map(|f| part * f))).collect();
        Push { nodes, force: self.force.iter().map(|f| part * f).collect(), name: self.name.clone(), ..*self }
    }

    /// Its share at a time that belongs to the same side of a jump as another one.
    pub(crate) fn within(&self, time: f64, beside: f64) -> f64 {
        let acts = (0.0..=self.length).contains(&beside);
        match (acts, self.pulse) {
            (false, _) => 0.0,
            (true, true) => (std::f64::consts::PI * time / self.length).sin().powi(2),
            (true, false) => 1.0,
        }
    }
}

/// Largest displacement where the problem does not say, as a part of the longest edge around the body.
const DISPLACEMENT: f64 = 0.2;

/// The largest displacement of the loadable surface that a file of large displacements is made for \[m\]:
/// `large.displacement`, or a fifth of the longest edge of the box around the body.
pub fn asked_displacement(problem: &Problem, mesh: &Mesh) -> f64 {
    let asked = problem.large.as_ref().and_then(|large| large.displacement);
    asked.unwrap_or_else(|| DISPLACEMENT * longest_edge(mesh))
}

/// The longest edge of the box around a body \[m\].
fn longest_edge(mesh: &Mesh) -> f64 {
    let (low, high) = mesh.bounding_box();
    (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max)
}

/// Distribution of the pushes of a body.
pub(crate) struct PushFamily<'a> {
    /// The body.
    pub(crate) body: &'a Body,
    /// A few of its natural modes.
    pub(crate) modes: &'a Modes,
    /// Largest displacement \[m\].
    pub(crate) displacement: f64,
    /// Step of the file \[s\].
    pub(crate) time_step: f64,
}

impl PushFamily<'_> {
    /// Pushes at random places, one for each word whether it is a pulse, so strong that the linear motion
    /// under them reaches about 0.4 to 0.8 of the largest displacement.
    pub(crate) fn draw(&self, pulses: &[bool], seed: u64) -> Vec<Push> {
        let Self { body, modes, displacement, time_step } = *self;
        let (mesh, nodes) = (body.model.mesh(), &body.load_nodes);
        let moving = at_load_nodes(body, modes.vectors.as_ref());
        let period = std::f64::consts::TAU / modes.eigenvalues[0].sqrt();
        let width = WIDTH * longest_edge(mesh);
        let mut random = Random::new(seed);
        let mut draw = |(k, &pulse): (usize, &bool)| loop {
            let centre = mesh.nodes[nodes[random.below(nodes.len())] as usize];
            let along = unit(std::array::from_fn(|_| random.uniform() - 0.5));
            let (size, share) = (0.4 + 0.4 * random.uniform(), random.uniform());
            let mut push = vec![];
            for &node in nodes {
                let x = mesh.nodes[node as usize];
                let square: f64 = (0..3).map(|c| (x[c] - centre[c]).powi(2)).sum::<f64>() / (width * width);
                if square < REACH * REACH {
                    push.push((node, along.map(|d| d * (-square).exp())));
                }
            }
            let force = over_dofs(body, &push);
            let shares = project(modes.vectors.as_ref(), &force);
            let answer: Vec<f64> = shares.iter().zip(&modes.eigenvalues).map(|(f, l)| f / l).collect();
            let moved = |i: usize| (0..answer.len()).map(|j| moving[(i, j)] * answer[j]).sum::<f64>();
            let most = (0..nodes.len())
                .map(|p| (0..3).map(|c| moved(3 * p + c).powi(2)).sum::<f64>().sqrt())
                .fold(0.0, f64::max);
            // A push at held nodes moves nothing.
            if most > 0.0 {
                let scale = size * displacement / (most * if pulse { PULSE } else { HELD });
                let length = period * if pulse { 0.5 + 0.5 * share } else { 0.3 + 0.4 * share };
                return Push {
                    name: format!("push-{seed:x}-{k}"),
                    nodes: push.into_iter().map(|(node, f)| (node, f.map(|f| scale * f))).collect(),
                    force: force.into_iter().map(|f| scale * f).collect(),
                    length: (length / time_step).round().max(1.0) * time_step,
                    pulse,
                };
            }
        };
        pulses.iter().enumerate().map(&mut draw).collect()
    }
}

fn over_dofs(body: &Body, push: &[(u32, [f64; 3])]) -> Vec<f64> {
    let mut full = vec![0.0; body.n_dof()];
    for &(node, force) in push {
        body.model.add_point_force(&[node; 3], &[1.0, 0.0, 0.0], force, &mut full);
    }
    full
}

/// Full-order model of a body with its time scheme.
pub(crate) struct ReferenceModel<'a> {
    /// The strain.
    pub(crate) strain: &'a GreenStrain<'a>,
    /// Structure of the factor.
    pub(crate) symbolic: &'a Symbolic,
    /// Rayleigh damping; the part of the stiffness damps the rate of strain.
    pub(crate) damping: Rayleigh,
    /// Step of the file \[s\].
    pub(crate) time_step: f64,
    /// Steps of the reference in a step of the file.
    pub(crate) parts: usize,
}

impl ReferenceModel<'_> {
    /// Estimated work of `steps` steps of the file at full order, counted once for each push and
    /// measured on a few under one of them.
    ///
    /// # Errors
    /// [`LargeError`].
    pub(crate) fn work(&self, push: &Push, steps: f64, listener: &dyn Listener) -> Result<Work, LargeError> {
        const FEW: usize = 3;
        let start = Instant::now();
        self.follow(push, FEW, listener)?;
        let one = start.elapsed().as_secs_f64() / FEW as f64;
        let side_by_side = rayon::current_num_threads().min(2) as f64;
        Ok(Work { steps: self.parts as f64 * steps, seconds: steps * one / side_by_side })
    }

    /// `count` pushes and the motions under them, pulses and held ones in turn, marched by Bathe's method
    /// with a part of the step. A push under which some element is compressed to less than [`SOFTENING`],
    /// where the law describes no body any more, is halved, and one that moves the surface further than was
    /// asked for is made weaker. Where two such steps are not enough another one is drawn: next to a support
    /// no push moves the surface far without crushing it. Each motion is kept.
    ///
    /// # Errors
    /// [`LargeError`].
    pub(crate) fn references(
        &self,
        drawn: &PushFamily<'_>,
        (count, seed): (usize, u64),
        steps: usize,
        kept: &StageCache<'_>,
    ) -> Result<Vec<ReferenceRun>, LargeError> {
        let mut found: Vec<Option<ReferenceRun>> = vec![None; count];
        for draw in 0..MAX_DRAWS {
            let missing: Vec<usize> = (0..count).filter(|&k| found[k].is_none()).collect();
            let pulses: Vec<bool> = missing.iter().map(|k| k.is_multiple_of(2)).collect();
            let weaker = if draw + 1 == MAX_DRAWS { MAX_HALVINGS } else { HALVINGS };
            let pushes = drawn.draw(&pulses, seed + draw);
            let march = |at: usize| self.march(&pushes[at], drawn, (steps, weaker), kept);
            let marched = parallel::try_map(pushes.len(), &march)?;
            missing.into_iter().zip(marched).for_each(|(k, reference)| found[k] = reference);
        }
        Ok(found.into_iter().flatten().collect())
    }

    /// The motion under a push, made weaker so often at most until the law bears it and the surface moves no
    /// further than was asked for.
    fn march(
        &self,
        push: &Push,
        drawn: &PushFamily<'_>,
        (steps, weaker): (usize, usize),
        kept: &StageCache<'_>,
    ) -> Result<Option<ReferenceRun>, LargeError> {
        /// Of the displacement that was asked for.
        const WITHIN: f64 = 0.95;
        let asked = drawn.displacement;
        self.kept(&push.name, push, (steps, weaker, asked), kept, || {
            let mut push = push.clone();
            for _ in 0..=weaker {
                match self.follow(&push, steps, kept.listener) {
                    Ok(found) if found.least_stretch >= SOFTENING => {
                        let moved = found.largest_displacement(drawn.body);
                        if moved <= asked {
                            return Ok(Some(found));
                        }
                        push = push.scaled(WITHIN * asked / moved);
                    }
                    Ok(_) | Err(LargeError::NoStep { .. }) => push = push.scaled(0.5),
                    Err(error) => return Err(error),
                }
            }
            Ok(None)
        })
    }

    /// Cached motion under a push.
    fn kept<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        push: &Push,
        limits: impl Debug,
        kept: &StageCache<'_>,
        march: impl FnOnce() -> Result<T, LargeError>,
    ) -> Result<T, LargeError> {
        let inputs = |inputs: Inputs| {
            let own = (limits, self.time_step, self.parts, self.damping, push.length, push.pulse);
            inputs.value(&own).numbers(&push.force)
        };
        kept.stage(name, inputs, march)
    }

    /// The motion under one push; the march ends where the law does.
    ///
    /// # Errors
    /// [`LargeError`].
    pub(crate) fn follow(
        &self,
        push: &Push,
        steps: usize,
        listener: &dyn Listener,
    ) -> Result<ReferenceRun, LargeError> {
        let begun = Instant::now();
        let Self { strain, symbolic, damping, time_step, parts } = *self;
        let damping = LargeDamping { mass: damping.alpha, stiffness: 0.0, strain_rate: damping.beta };
        let step = time_step / parts as f64;
        let newton = Newton { tolerance: TOLERANCE, ..Newton::default() };
        let march = LargeMarch::new(strain, symbolic, LargeScheme::bathe(), step, damping, newton)?;
        let mut force = |time: f64, out: &mut [f64]| {
            // Before time 0 there is nothing whose mean could be taken.
            let share = if time > 0.0 { push.at(time) } else { push.within(0.0, 0.5 * step) };
            out.iter_mut().zip(&push.force).for_each(|(out, f)| *out += share * f);
        };
        let rest = vec![0.0; strain.n_dof()];
        let mut state = march.start(&rest, &rest, &mut force)?;
        let (mut kept, mut least, mut work) = (Vec::with_capacity(steps), 1.0_f64, LargeWork::default());
        while kept.len() < steps && least >= SOFTENING {
            for _ in 0..parts {
                march.step(&mut state, &mut force, &mut work)?;
            }
            least = least.min(strain.least_stretch(&state.displacement));
            kept.push(state.displacement.clone());
            listener.checkpoint(kept.len(), steps)?;
        }
        let seconds_per_step = begun.elapsed().as_secs_f64() / kept.len() as f64;
        Ok(ReferenceRun {
            push: push.clone(),
            displacements: kept,
            least_stretch: least,
            own_error: f64::NAN,
            seconds_per_step,
        })
    }
}

impl ReferenceRun {
    /// Largest displacement of the surface \[m\].
    pub(crate) fn largest_displacement(&self, body: &Body) -> f64 {
        self.displacements.iter().map(|u| body.largest_displacement(u)).fold(0.0, f64::max)
    }

    /// The same with steps half as long, and what it is off by: both are of second order in the step.
    ///
    /// # Errors
    /// [`LargeError`].
    pub(crate) fn refined(
        self,
        full: &ReferenceModel<'_>,
        kept: &StageCache<'_>,
    ) -> Result<ReferenceRun, LargeError> {
        let finer = ReferenceModel { parts: 2 * full.parts, ..*full };
        let (push, steps) = (&self.push, self.displacements.len());
        let march = || finer.follow(push, steps, kept.listener);
        let fine = finer.kept(&format!("{}-refined", push.name), push, steps, kept, march)?;
        let mass = full.strain.model().pencil().mass();
        let (mut off, mut whole) = (0.0, 0.0);
        for (a, b) in self.displacements.iter().zip(&fine.displacements) {
            let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            off += mass.inner(&difference, &difference);
            whole += mass.inner(b, b);
        }
        let seconds_per_step = self.seconds_per_step;
        Ok(ReferenceRun { own_error: (off / whole).sqrt() / 3.0, seconds_per_step, ..fine })
    }
}

/// A push, and the motion under it at full order.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[doc(alias = "validation load case")]
pub(crate) struct ReferenceRun {
    /// The push as it was marched.
    pub(crate) push: Push,
    /// Displacements over the free dofs after each step of the file \[m\].
    pub(crate) displacements: Vec<Vec<f64>>,
    /// The least principal stretch in any element and step.
    pub(crate) least_stretch: f64,
    /// Discretisation error in time of the motion itself: relative, over all dofs and steps, in the mass
    /// norm; not a number where nobody looked.
    pub(crate) own_error: f64,
    /// Wall time of a step of the file \[s\], with as many marches side by side as there are cores.
    pub(crate) seconds_per_step: f64,
}

/// A reference run projected on a basis.
pub(crate) struct ProjectedRun {
    /// Coordinates after each step, one a column.
    pub(crate) coordinates: Mat<f64>,
    /// Square of the projection error in the mass norm, summed over the steps.
    pub(crate) projection_residual: f64,
    /// The same of everything.
    pub(crate) whole: f64,
}

impl ProjectedRun {
    /// Error of a motion against what the basis sees of a reference: relative, over all dofs and steps, in
    /// the mass norm; and what no motion in this basis can be below.
    pub(crate) fn error(&self, found: &Mat<f64>) -> TrajectoryError {
        let off = (&self.coordinates - found).squared_norm_l2();
        let root = |x: f64| (x / self.whole).sqrt();
        TrajectoryError { error: root(off + self.projection_residual), floor: root(self.projection_residual) }
    }

    /// Distance of two motions in the basis, relative to the reference.
    pub(crate) fn apart(&self, one: &Mat<f64>, other: &Mat<f64>) -> f64 {
        (one - other).norm_l2() / self.whole.sqrt()
    }
}

impl LargeModel {
    /// Projects a reference run on the basis.
    pub(crate) fn see(&self, body: &Body, reference: &ReferenceRun) -> ProjectedRun {
        let (n, reference) = (self.basis.vectors.nrows(), &reference.displacements);
        let u = Mat::from_fn(n, reference.len(), |i, s| reference[s][i]);
        let mut momenta = Mat::zeros(n, reference.len());
        body.model.pencil().mass().mul_into(u.as_ref(), momenta.as_mut());
        let coordinates = self.basis.vectors.transpose() * &momenta;
        let dot =
            |s: usize| u.col_as_slice(s).iter().zip(momenta.col_as_slice(s)).map(|(a, b)| a * b).sum::<f64>();
        let whole: f64 = (0..reference.len()).map(dot).sum();
        ProjectedRun {
            projection_residual: (whole - coordinates.squared_norm_l2()).max(0.0),
            coordinates,
            whole,
        }
    }
}
