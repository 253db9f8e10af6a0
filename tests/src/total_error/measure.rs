//! Pushes through files of a body beside the truth.

use vademecum_build::Matrix;
use vademecum_build::dynamics::{TimedLoad, Truth, TruthOptions, lowest_modes};
use vademecum_build::export::NodeOrder;
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_study::contact_error;

use super::bodies::RealBody;
use super::files::{Built, Shown};
use super::push::{HISTORIES, Push, STEPS};

/// Steps in the first period.
const STEPS_PER_PERIOD: f64 = 40.0;

/// What all rows of a body have in common.
#[derive(Clone, Debug)]
pub struct Conditions {
    /// Free dofs.
    pub dofs: usize,
    /// First natural period \[s\].
    pub period: f64,
    /// Pushes.
    pub pushes: usize,
}

/// One push in one way through one file.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Relative L2 error over all dofs and steps, mass norm: of the modes alone, with the residual at the
    /// contact, with whole static fields.
    pub error: [f64; 3],
    /// The same of the displacement under the force along it, while it acts: of the modes alone, with the
    /// residual.
    pub contact: [f64; 2],
    /// Estimate of the error of the reference itself.
    pub reference: f64,
    /// The bound over the error of whole fields, mass norm, at the instant at which it is least.
    pub bound: f64,
    /// The root of the sum of squares of the bound over all instants, over that of the error.
    pub bound_of_total: f64,
    /// Instants at which the error is above the bound.
    pub above: usize,
}

/// All pushes in one way through one file.
#[derive(Clone, Debug)]
pub struct Row {
    /// Damping ratio of all modes.
    pub ratio: f64,
    /// Natural modes of the file.
    pub modes: usize,
    /// How the pushes follow time: a place in [`HISTORIES`].
    pub history: usize,
    /// Push by push.
    pub samples: Vec<Sample>,
}

/// Pushes a body at `pushes` places, for each damping ratio and each number of modes in every way. `told` is
/// called with each number of pushes done.
///
/// # Panics
/// If the body cannot be built or stepped.
pub fn measure(
    body: &RealBody,
    ratios: &[f64],
    modes: &[usize],
    pushes: usize,
    mut told: impl FnMut(f64, usize),
) -> (Conditions, Vec<Row>) {
    let model = |step: f64, ratio: f64| -> Prepared {
        let problem = body.problem(step, modes[0], ratio);
        prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).unwrap_or_else(|error| panic!("{error}"))
    };
    let first = model(1.0, 0.0);
    let lowest = lowest_modes(first.body.model.pencil(), &first.symbolic, 1).expect("a first mode");
    let period = 1.0 / lowest.frequencies_hz()[0];
    let step = period / STEPS_PER_PERIOD;
    let order = NodeOrder::new(&first.body);
    let conditions = Conditions { dofs: first.body.n_dof(), period, pushes };
    let drawn = Push::draw(&first.body, pushes);
    let mut rows = vec![];
    for &ratio in ratios {
        let prepared = model(step, ratio);
        let made = |&modes: &usize| Built::new(body, (&prepared, &order), step, modes, ratio);
        let files: Vec<Built> = modes.iter().map(made).collect();
        let of_push = |(done, push): (usize, &Push)| {
            let samples = compare(&prepared, &order, &files, push, (step, body.vectors));
            told(ratio, done + 1);
            samples
        };
        let samples: Vec<Vec<Sample>> = drawn.iter().enumerate().map(of_push).collect();
        for (file, &modes) in modes.iter().enumerate() {
            for history in 0..HISTORIES.len() {
                let place = file * HISTORIES.len() + history;
                let samples = samples.iter().map(|all| all[place]).collect();
                rows.push(Row { ratio, modes, history, samples });
            }
        }
    }
    (conditions, rows)
}

/// One push through every file in every way, file by file.
fn compare(
    prepared: &Prepared,
    order: &NodeOrder,
    files: &[Built],
    push: &Push,
    (step, vectors): (f64, usize),
) -> Vec<Sample> {
    let (body, pencil) = (&prepared.body, prepared.body.model.pencil());
    let force = push.over_dofs(body);
    let loads: Vec<TimedLoad> =
        HISTORIES.iter().zip(0..).map(|(history, column)| history.timed(column, &force, step)).collect();
    let eigenvalues = &files.last().expect("a file").eigenvalues;
    let decay = |lambda: f64, _| prepared.ratios.decay(&prepared.rayleigh(), eigenvalues, lambda);
    let options = TruthOptions { vectors_per_force: vectors, ..TruthOptions::default() };
    let truth = Truth::find(pencil, &prepared.symbolic, &decay, &loads, (step, STEPS), &options, &Silent)
        .expect("a truth");
    let shown: Vec<Shown> = files.iter().map(|file| file.show(push, (prepared, order))).collect();

    // All that the files show lies in the span of these columns: of each file its basis, and two static
    // fields.
    let count: usize = files.iter().map(|file| file.modes + 2).sum();
    let mut columns = Matrix::zeros(body.n_dof(), count);
    let mut firsts = vec![];
    let mut at = 0;
    for (file, shown) in files.iter().zip(&shown) {
        firsts.push(at);
        columns.subcols_mut(at, file.modes).copy_from(&file.basis);
        for (place, field) in shown.statics.iter().enumerate() {
            columns.col_as_slice_mut(at + file.modes + place).copy_from_slice(field);
        }
        at += file.modes + 2;
    }
    let beside = truth.beside(columns);

    let mut samples = vec![];
    for ((file, shown), &first) in files.iter().zip(&shown).zip(&firsts) {
        let bound = file.bound(push, order);
        let last = file.eigenvalues.last().expect("a mode").sqrt();
        for (history, load) in loads.iter().enumerate() {
            let squares = |statics: Option<usize>| {
                let mut amplitudes = Matrix::zeros(count, 1 + STEPS);
                amplitudes.subrows_mut(first, file.modes).copy_from(&shown.coordinates[history]);
                if let Some(place) = statics {
                    for n in 1..=STEPS {
                        amplitudes[(first + file.modes + place, n)] = load.when.just_before(n as f64 * step);
                    }
                }
                beside.squares(history, amplitudes.as_ref())
            };
            let [alone, local, whole] = [None, Some(0), Some(1)].map(squares);
            let error = [&alone, &local, &whole].map(|s| (sum(&s.apart) / sum(&s.truth)).sqrt());
            let under = |shown: &Matrix| {
                let entry = (std::slice::from_ref(load), &[0][..]);
                contact_error(truth.trajectory(history), (entry, shown.as_ref()), step)
                    .expect("a point that moves")
            };
            let contact = [0, 1].map(|with| under(&shown.under[with][history]));
            let bounds = HISTORIES[history].variation(last * step);
            let bounds: Vec<f64> = bounds.iter().map(|share| share * bound).collect();
            let ratios =
                bounds[1..].iter().zip(&whole.apart[1..]).map(|(bound, square)| bound / square.sqrt());
            samples.push(Sample {
                error,
                contact,
                reference: truth.trajectory(history).estimate(),
                bound: ratios.clone().fold(f64::INFINITY, f64::min),
                bound_of_total: (bounds.iter().map(|b| b * b).sum::<f64>() / sum(&whole.apart)).sqrt(),
                above: ratios.filter(|&ratio| ratio < 1.0).count(),
            });
        }
    }
    samples
}

fn sum(squares: &[f64]) -> f64 {
    squares.iter().sum()
}
