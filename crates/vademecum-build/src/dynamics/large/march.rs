//! The march: each stage of a scheme is a balance that Newton's method finds, and a step that fails is
//! halved.
//!
//! Velocities and accelerations follow from displacements by the forms of the scheme's table. Where the
//! strain rate is damped, strain follows the same forms: `ż` is to `z` what `u̇` is to `u`, so that a
//! rotation has no strain rate whatever the step, and each stage stays the gradient of a potential.

use faer::MatRef;
use vademecum_format::scheme::{HISTORY, SchemeTable, Stage as TableStage};

use super::balance::{LastPoint, StageBalance};
use super::error::{LargeError, check_length};
use super::newton::{Newton, NewtonStop, NewtonWork};
use super::scheme::{LargeDamping, LargeScheme};
use super::space::{MotionSpace, SpaceFactor};
use super::vectors::{add, dot, sum, times};
use crate::dynamics::INSTANTS;
use crate::fem::{GreenStrain, Symbolic, SymmetricMatrix};
use crate::progress::Listener;

/// Most halvings of a step.
const HALVINGS: usize = 6;

/// A body marching at large displacements with one scheme, one step length and one damping.
pub struct LargeMarch<'a> {
    strain: &'a GreenStrain<'a>,
    space: MotionSpace<'a>,
    scheme: LargeScheme,
    time_step: f64,
    damping: LargeDamping,
    newton: Newton,
}

/// A moving body at one instant; vectors over the free dofs.
#[derive(Clone, Debug, PartialEq)]
pub struct LargeState {
    /// Steps taken.
    pub steps: usize,
    /// Displacement \[m\].
    pub displacement: Vec<f64>,
    /// Velocity \[m/s\].
    pub velocity: Vec<f64>,
    /// Acceleration \[m/s²\]; zero throughout with the energy-momentum scheme, which has none.
    pub acceleration: Vec<f64>,
    /// `z`, `ż` and `z̈` where the strain rate is damped and the scheme is a table; empty elsewhere.
    strain: [Vec<f64>; 3],
}

/// Cost of the steps, and the factors that are reused between them.
#[derive(Default)]
pub struct LargeWork {
    /// Corrections of Newton's method, those of failed attempts left out.
    pub(crate) corrections: usize,
    /// Factorisations, those of failed attempts left out.
    pub(crate) factorisations: usize,
    /// Steps that were halved.
    pub halvings: usize,
    factors: Vec<Option<SpaceFactor>>,
}

/// A force that depends on time alone: writes the load \[N\] over the free dofs at a time \[s\] into zeros.
type ForceAt<'f> = dyn FnMut(f64, &mut [f64]) + 'f;

impl<'a> LargeMarch<'a> {
    /// Sets up a march. Nothing is factorised yet.
    ///
    /// # Errors
    /// [`LargeError`]: a step or damping that makes no sense, a scheme that does not suit.
    pub fn new(
        strain: &'a GreenStrain<'a>,
        symbolic: &'a Symbolic,
        scheme: LargeScheme,
        time_step: f64,
        damping: LargeDamping,
        newton: Newton,
    ) -> Result<LargeMarch<'a>, LargeError> {
        if !(time_step > 0.0 && time_step.is_finite()) {
            return Err(LargeError::TimeStep(time_step));
        }
        if !damping.is_sound() {
            return Err(LargeError::Damping(damping));
        }
        if !scheme.is_suitable() {
            return Err(LargeError::Scheme);
        }
        Ok(LargeMarch { strain, space: MotionSpace::Whole(symbolic), scheme, time_step, damping, newton })
    }

    /// The same among the motions of a basis alone, shape (n, r), orthonormal in the mass: Galerkin's method.
    /// The strain stays that of all elements; only the systems that Newton's method solves become those of
    /// `VᵀKV`. A march must start in the span of the basis.
    ///
    /// # Errors
    /// [`LargeError::Length`]: a basis of another height.
    pub fn within(self, basis: MatRef<'a, f64>) -> Result<LargeMarch<'a>, LargeError> {
        check_length("the basis", basis.nrows(), self.strain.n_dof())?;
        Ok(LargeMarch { space: MotionSpace::Span(basis), ..self })
    }

    /// Step length \[s\].
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// The state at time 0, with the acceleration that the forces demand.
    ///
    /// # Errors
    /// [`LargeError`]: lengths, a load that is no number, a mass that is not positive definite.
    pub fn start(
        &self,
        displacement: &[f64],
        velocity: &[f64],
        force: &mut ForceAt<'_>,
    ) -> Result<LargeState, LargeError> {
        let n = self.strain.n_dof();
        check_length("the initial displacement", displacement.len(), n)?;
        check_length("the initial velocity", velocity.len(), n)?;
        let mut state = LargeState {
            steps: 0,
            displacement: displacement.to_vec(),
            velocity: velocity.to_vec(),
            acceleration: vec![0.0; n],
            strain: Default::default(),
        };
        if self.scheme == LargeScheme::EnergyMomentum {
            return Ok(state);
        }
        let pencil = self.strain.model().pencil();
        let rows = self.strain.n_rows();
        let (mut z, mut rate) = (vec![0.0; rows], vec![0.0; rows]);
        self.strain.strain(displacement, &mut z);
        self.strain.rate(displacement, velocity, &mut rate);
        let stress = sum(&z, self.damping.strain_rate, &rate);
        let mut elastic = vec![0.0; n];
        self.strain.transpose(displacement, &stress, &mut elastic);
        let mut missing = load_at(0.0, n, force)?;
        add(&mut missing, -1.0, &elastic);
        if self.damping.mass > 0.0 {
            add(&mut missing, -self.damping.mass, &times(pencil.mass(), velocity));
        }
        if self.damping.stiffness > 0.0 {
            add(&mut missing, -self.damping.stiffness, &times(pencil.stiffness(), velocity));
        }
        state.acceleration = self.space.acceleration(pencil, &missing)?;
        if self.damping.strain_rate > 0.0 {
            let (mut second, mut square) = (vec![0.0; rows], vec![0.0; rows]);
            self.strain.rate(displacement, &state.acceleration, &mut second);
            self.strain.bilinear(velocity, velocity, &mut square);
            add(&mut second, 2.0, &square);
            state.strain = [z, rate, second];
        }
        Ok(state)
    }

    /// One step. Where Newton's method finds no balance, the step is made of two halves, and so on.
    ///
    /// # Errors
    /// [`LargeError::NoStep`] with the state as it was; a load that is no number; memory.
    pub fn step(
        &self,
        state: &mut LargeState,
        force: &mut ForceAt<'_>,
        work: &mut LargeWork,
    ) -> Result<(), LargeError> {
        let start = state.steps as f64 * self.time_step;
        let mut next = state.clone();
        self.advance(&mut next, [start, self.time_step], 0, force, work)?;
        next.steps += 1;
        *state = next;
        Ok(())
    }

    /// Kinetic and strain energy \[J\].
    pub fn energy(&self, state: &LargeState) -> f64 {
        let mass = self.strain.model().pencil().mass();
        0.5 * mass.inner(&state.velocity, &state.velocity) + self.strain.energy(&state.displacement)
    }

    fn advance(
        &self,
        state: &mut LargeState,
        [start, length]: [f64; 2],
        depth: usize,
        force: &mut ForceAt<'_>,
        work: &mut LargeWork,
    ) -> Result<(), LargeError> {
        let mut own = vec![];
        let factors = if depth == 0 { &mut work.factors } else { &mut own };
        factors.resize(INSTANTS, None);
        let tried = match &self.scheme {
            LargeScheme::Table(table) => self.table_step(table, state, [start, length], force, factors)?,
            LargeScheme::EnergyMomentum => self.midpoint_step(state, [start, length], force, factors)?,
        };
        match tried {
            Ok(courses) => {
                work.corrections += courses.iter().map(|course| course.corrections.len()).sum::<usize>();
                work.factorisations += courses.iter().map(|course| course.factorisations).sum::<usize>();
                Ok(())
            }
            Err(NewtonStop::Factor(error)) => Err(error.into()),
            Err(NewtonStop::Unbalanced { residual, iterations }) => {
                factors.fill(None);
                if depth == HALVINGS {
                    let (step, halvings) = (state.steps, depth);
                    return Err(LargeError::NoStep { step, time: start, residual, iterations, halvings });
                }
                work.halvings += 1;
                let half = 0.5 * length;
                self.advance(state, [start, half], depth + 1, force, work)?;
                self.advance(state, [start + half, half], depth + 1, force, work)
            }
        }
    }

    /// The stages of a table; the state is as it was where one of them fails.
    fn table_step(
        &self,
        table: &SchemeTable,
        state: &mut LargeState,
        [start, dt]: [f64; 2],
        force: &mut ForceAt<'_>,
        factors: &mut [Option<SpaceFactor>],
    ) -> Result<Result<Vec<NewtonWork>, NewtonStop>, LargeError> {
        let n = self.strain.n_dof();
        let instants = table.instants();
        let mut loads: [Option<Vec<f64>>; INSTANTS] = Default::default();
        for (j, at) in instants.iter().enumerate() {
            if table.active().iter().any(|stage| stage.load[j] != 0.0) {
                loads[j] = Some(load_at(start + at * dt, n, force)?);
            }
        }
        let motion = StepHistory::new(dt, &state.velocity, &state.acceleration);
        let damped = self.damping.strain_rate > 0.0;
        let strains = if damped {
            StepHistory::new(dt, &state.strain[1], &state.strain[2])
        } else {
            StepHistory::default()
        };
        let (mut motion, mut strains) = (motion, strains);
        let mut courses = vec![];
        for (stage, factor) in table.active().iter().zip(factors) {
            let mut balance = self.stage(stage, state, dt, &motion, &strains, &loads);
            // Where the velocity leads.
            let mut increment: Vec<f64> = motion.parts[0].iter().map(|v| stage.time * v).collect();
            match self.newton.solve(&mut balance, self.space, factor, &mut increment, true) {
                Ok(course) => courses.push(course),
                Err(stopped) => return Ok(Err(stopped)),
            }
            if damped {
                strains.parts.push(sum(&balance.last.strain, -1.0, &state.strain[0]));
            }
            motion.parts.push(increment);
        }
        let [u, v, a] = motion.finish(table, dt);
        add(&mut state.displacement, 1.0, &u);
        (state.velocity, state.acceleration) = (v, a);
        if damped {
            let [z, rate, second] = strains.finish(table, dt);
            add(&mut state.strain[0], 1.0, &z);
            (state.strain[1], state.strain[2]) = (rate, second);
        }
        Ok(Ok(courses))
    }

    /// The equations of a stage, in the unit of its mass.
    fn stage<'s>(
        &'s self,
        stage: &TableStage,
        state: &'s LargeState,
        dt: f64,
        motion: &StepHistory,
        strains: &StepHistory,
        loads: &[Option<Vec<f64>>; INSTANTS],
    ) -> StageBalance<'s> {
        let pencil = self.strain.model().pencil();
        let n = self.strain.n_dof();
        let LargeDamping { mass: alpha, stiffness: beta, strain_rate } = self.damping;
        let mut force = vec![0.0; n];
        for (load, weight) in loads.iter().zip(stage.load) {
            if let Some(load) = load {
                add(&mut force, dt * dt * weight, load);
            }
        }
        let weights = |p: usize| stage.mass_history[p] + alpha * dt * stage.damping_history[p];
        add(&mut force, 1.0, &times(pencil.mass(), &motion.combine(std::array::from_fn(weights), n)));
        let mut parts = vec![(stage.mass + alpha * dt * stage.damping, pencil.mass())];
        if beta > 0.0 {
            let old = motion.combine(stage.damping_history.map(|w| beta * dt * w), n);
            add(&mut force, 1.0, &times(pencil.stiffness(), &old));
            parts.push((beta * dt * stage.damping, pencil.stiffness()));
        }
        let mut history = vec![];
        if strain_rate > 0.0 {
            let scale = -strain_rate * dt;
            history = strains.combine(stage.damping_history.map(|w| scale * w), self.strain.n_rows());
            add(&mut history, scale * stage.damping, &state.strain[0]);
        }
        let velocity = &motion.parts[0];
        StageBalance {
            strain: self.strain,
            start: &state.displacement,
            midpoint: false,
            linear: Some(SymmetricMatrix::combine(&parts)),
            force,
            weight: dt * dt + strain_rate * dt * stage.damping,
            history,
            energy: 0.5 * dot(velocity, &times(pencil.mass(), velocity)),
            last: LastPoint::default(),
        }
    }

    /// A step of the energy-momentum scheme; the state is as it was where it fails.
    fn midpoint_step(
        &self,
        state: &mut LargeState,
        [start, dt]: [f64; 2],
        force: &mut ForceAt<'_>,
        factors: &mut [Option<SpaceFactor>],
    ) -> Result<Result<Vec<NewtonWork>, NewtonStop>, LargeError> {
        let pencil = self.strain.model().pencil();
        let n = self.strain.n_dof();
        let LargeDamping { mass: alpha, stiffness: beta, strain_rate } = self.damping;
        let way: Vec<f64> = state.velocity.iter().map(|v| dt * v).collect();
        let momentum = times(pencil.mass(), &way);
        let mut load: Vec<f64> = momentum.iter().map(|p| 2.0 * p).collect();
        for time in [start, start + dt] {
            add(&mut load, 0.5 * dt * dt, &load_at(time, n, force)?);
        }
        let mut history = vec![0.0; self.strain.n_rows()];
        self.strain.strain(&state.displacement, &mut history);
        history.iter_mut().for_each(|z| *z *= 0.5 * dt * dt - strain_rate * dt);
        let parts = [(2.0 + alpha * dt, pencil.mass()), (beta * dt, pencil.stiffness())];
        let mut balance = StageBalance {
            strain: self.strain,
            start: &state.displacement,
            midpoint: true,
            linear: Some(SymmetricMatrix::combine(&parts)),
            force: load,
            weight: 0.5 * dt * dt + strain_rate * dt,
            history,
            energy: 0.5 * dot(&way, &momentum),
            last: LastPoint::default(),
        };
        let mut increment = way;
        // The tangent is not the derivative, so a new factor is no better than one of a few corrections ago.
        let keep = if self.newton.keep > 0.0 { self.newton.keep.max(0.3) } else { 0.0 };
        let newton = Newton { keep, ..self.newton };
        let solved = newton.solve(&mut balance, self.space, &mut factors[0], &mut increment, true);
        let course = match solved {
            Ok(course) => course,
            Err(stopped) => return Ok(Err(stopped)),
        };
        for (v, d) in state.velocity.iter_mut().zip(&increment) {
            *v = 2.0 / dt * d - *v;
        }
        add(&mut state.displacement, 1.0, &increment);
        Ok(Ok(vec![course]))
    }
}

/// `(Δt ẋ, Δt² ẍ, x₁ − x, x₂ − x, …)`: what the forms of a table act on. The increments take `x` out of them.
#[derive(Default)]
struct StepHistory {
    parts: Vec<Vec<f64>>,
}

impl StepHistory {
    fn new(dt: f64, rate: &[f64], second: &[f64]) -> StepHistory {
        let scaled = |x: &[f64], w: f64| x.iter().map(|x| w * x).collect();
        StepHistory { parts: vec![scaled(rate, dt), scaled(second, dt * dt)] }
    }

    /// A form; its weight of `x` itself is left out.
    fn combine(&self, form: [f64; HISTORY], n: usize) -> Vec<f64> {
        let mut out = vec![0.0; n];
        for (part, &weight) in self.parts.iter().zip(&form[1..]) {
            if weight != 0.0 {
                add(&mut out, weight, part);
            }
        }
        out
    }

    /// The increment of the step, and the new rates.
    fn finish(&self, table: &SchemeTable, dt: f64) -> [Vec<f64>; 3] {
        let units = [1.0, dt, dt * dt];
        let n = self.parts[0].len();
        std::array::from_fn(|k| self.combine(table.finish[k].map(|w| w / units[k]), n))
    }
}

/// The load at a time.
fn load_at(time: f64, n: usize, force: &mut ForceAt<'_>) -> Result<Vec<f64>, LargeError> {
    let mut load = vec![0.0; n];
    force(time, &mut load);
    if load.iter().all(|f| f.is_finite()) { Ok(load) } else { Err(LargeError::Load { at: time }) }
}

/// Marches from a displacement and velocity at time 0 and shows each state to `observe`, the start too.
///
/// # Errors
/// [`LargeError`], or the listener stops it.
pub fn march_large(
    march: &LargeMarch<'_>,
    [displacement, velocity]: [&[f64]; 2],
    force: &mut ForceAt<'_>,
    steps: usize,
    listener: &dyn Listener,
    mut observe: impl FnMut(&LargeState),
) -> Result<LargeWork, LargeError> {
    let mut work = LargeWork::default();
    let mut state = march.start(displacement, velocity, force)?;
    observe(&state);
    for step in 0..steps {
        march.step(&mut state, force, &mut work)?;
        observe(&state);
        listener.checkpoint(step + 1, steps)?;
    }
    Ok(work)
}
