//! A point of the box of live parameters with a push there, and the errors of a file under it.

use std::fmt::Write as _;

use vademecum_build::input::Problem;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_format::{File, ParameterRole, SectionKind};
use vademecum_study::live::{at_values, prepared_at};
use vademecum_study::modes::natural_modes;
use vademecum_study::parameters::ParameterValue;
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::Scenario;
use vademecum_study::verify::{Figures, verify};

use crate::synthetic::Random;

/// Steps of the push, which is one period of the first natural frequency at the point, and of a run.
pub const STEPS: [f64; 2] = [40.0, 200.0];

/// A point of the box, and a push of one period there.
#[derive(Clone, Debug)]
pub struct LivePoint {
    /// Values of the parameters but the time step.
    pub values: Vec<ParameterValue>,
    /// Step \[s\].
    pub time_step: f64,
    /// Place of the pushed node.
    pub place: [f64; 3],
    /// Direction of the push.
    pub direction: [f64; 3],
}

impl LivePoint {
    /// A random point or corner with a push at a random loadable node in a random direction.
    ///
    /// # Panics
    /// If the file is not one of the problem.
    pub fn draw(problem: &Problem, file: &File<'_>, corner: bool, dice: &mut Random) -> Self {
        let mut values: Vec<ParameterValue> = vec![];
        for parameter in file.parameters() {
            let share = 0.5 * (1.0 + dice.number());
            let share = if corner { share.round() } else { share };
            let (lower, upper) = (parameter.lower, parameter.upper);
            let value = match parameter.log {
                true => lower * (upper / lower).powf(share),
                false => lower + share * (upper - lower),
            };
            if parameter.role != ParameterRole::TimeStep {
                values.push(ParameterValue { name: parameter.name.into(), value: value.clamp(lower, upper) });
            }
        }
        let (first, _) = natural_modes(problem, Some(1), None, &values, &Silent).expect("a first mode");
        let time_step = 1.0 / (STEPS[0] * first.frequencies_hz[0]);
        let [place, direction] = push(file, dice);
        Self { values, time_step, place, direction }
    }

    /// Errors of the file here: of the motion over all unknowns and steps, of its projection on the stepped
    /// modes, and of the displacement under the push; relative to the motion of the full model that is exact
    /// in time. `modes` of a parametric model are stepped.
    ///
    /// # Panics
    /// If the file cannot be set or stepped.
    pub fn errors(&self, problem: &Problem, file: &File<'_>, modes: usize) -> [f64; 3] {
        let (mut values, mut options) = (self.values.clone(), PlayOptions::default());
        match file.parameters().find(|parameter| parameter.role == ParameterRole::TimeStep) {
            Some(step) => {
                let value = self.time_step.clamp(step.lower, step.upper);
                values.push(ParameterValue { name: step.name.into(), value });
            }
            None => options.scene.time_step = Some(self.time_step),
        }
        let mut prepared = prepare(problem, &mut Stopwatch::new(&Silent), &Silent).expect("prepared");
        let body = at_values(file, &values, Some(modes)).expect("set");
        let at = match &body {
            Some(body) => {
                prepared_at(&mut prepared, &body.values).expect("values of the problem");
                File::parse(&body.bytes).expect("a file")
            }
            None => {
                for ParameterValue { name, value } in &values {
                    let place = file.parameters().position(|own| own.name == name).expect("a parameter");
                    options.scene.set(file.metadata(), &[(place, *value)]).expect("set");
                }
                *file
            }
        };
        let scenario = self.scenario();
        let found = verify(&at, &options, problem, &prepared, &scenario, &Silent).expect("verified");
        let Figures::Linear(figures) = found.figures else { panic!("a linear body") };
        let truth = figures.truth;
        [truth.total_error, truth.basis_error, truth.contact_error.unwrap_or(f64::NAN)]
    }

    fn scenario(&self) -> Scenario {
        let [end, duration] = STEPS.map(|steps| steps * self.time_step);
        let (point, direction) = (self.place, self.direction);
        let mut text = String::new();
        write!(
            text,
            "duration = {duration:e}\n[[contact]]\npoint = {point:?}\nforce = {direction:?}\nend = {end:e}\n"
        )
        .expect("text");
        Scenario::parse(&text, "push.toml").expect("a scenario")
    }
}

/// Place of a random loadable node, and a random direction.
fn push(file: &File<'_>, dice: &mut Random) -> [[f64; 3]; 2] {
    let nodes = file.section(SectionKind::NodeCoordinates).expect("nodes").numbers().expect("numbers");
    let count = f64::from(file.metadata().n_load_nodes);
    let basis = file.section(SectionKind::SurfaceBasis).expect("a basis").numbers().expect("numbers");
    let width = 3 * file.metadata().n_modes as usize;
    // A held node carries no push.
    let moves = |node: usize| (0..width).any(|k| basis.get(width * node + k) != Some(0.0));
    let node = loop {
        let node = ((0.5 * (1.0 + dice.number()) * count) as usize).min(count as usize - 1);
        if moves(node) {
            break node;
        }
    };
    let place = std::array::from_fn(|c| nodes.get(3 * node + c).expect("a coordinate"));
    let direction = loop {
        let vector = [dice.number(), dice.number(), dice.number()];
        let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (0.1..=1.0).contains(&length) {
            break vector.map(|x| x / length);
        }
    };
    [place, direction]
}
