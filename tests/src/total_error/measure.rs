//! Pushes through files of a body beside the truth.

use vademecum_build::Matrix;
use vademecum_build::dynamics::{ReferenceOptions, ReferenceSolution, TimedLoad, lowest_modes};
use vademecum_build::export::NodeOrder;
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_study::contact_errors;

use super::bodies::RealBody;
use super::files::{Built, SHOWN};
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

/// Files of one damping ratio.
struct Damped {
    prepared: Prepared,
    files: Vec<Built>,
}

/// Pushes a body at `pushes` places, for each number of modes and each damping ratio in every way. The ratios
/// ascend: the space that the least damping needs serves all. `told` is called after each
/// push with what there is so far: what fewer pushes would give.
///
/// # Panics
/// If the body cannot be built or stepped.
pub fn measure(
    body: &RealBody,
    ratios: &[f64],
    modes: &[usize],
    pushes: usize,
    mut told: impl FnMut(&Conditions, &[Row]),
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
    let mut conditions = Conditions { dofs: first.body.n_dof(), period, pushes: 0 };
    let damped = |&ratio: &f64| {
        let prepared = model(step, ratio);
        let made = |&modes: &usize| Built::new(body, (&prepared, &order), step, modes, ratio);
        Damped { files: modes.iter().map(made).collect(), prepared }
    };
    let damped: Vec<Damped> = ratios.iter().map(damped).collect();
    let keys = ratios.iter().flat_map(|&ratio| modes.iter().map(move |&modes| (ratio, modes)));
    let row = |(ratio, modes)| {
        (0..HISTORIES.len()).map(move |history| Row { ratio, modes, history, samples: vec![] })
    };
    let mut rows: Vec<Row> = keys.flat_map(row).collect();
    for push in &Push::draw(&first.body, pushes) {
        let samples = compare(&damped, &order, push, (step, body.vectors));
        rows.iter_mut().zip(samples).for_each(|(row, sample)| row.samples.push(sample));
        conditions.pushes += 1;
        told(&conditions, &rows);
    }
    (conditions, rows)
}

/// One push through every file in every way, in the order of the rows.
fn compare(damped: &[Damped], order: &NodeOrder, push: &Push, (step, vectors): (f64, usize)) -> Vec<Sample> {
    let Damped { prepared, files } = &damped[0];
    let pencil = prepared.body.model.pencil();
    let force = push.over_dofs(&prepared.body);
    let loads: Vec<TimedLoad> =
        HISTORIES.iter().zip(0..).map(|(history, column)| history.timed(column, &force, step)).collect();
    let options = ReferenceOptions { vectors_per_force: vectors, ..ReferenceOptions::default() };
    let decay = |lambda: f64, _| damped[0].decay(lambda);
    let truth =
        ReferenceSolution::find(pencil, &prepared.symbolic, &decay, &loads, (step, STEPS), &options, &Silent);
    let mut truth = truth.expect("a truth");

    // All that the files show lies in the span of these columns, whatever the damping: of each file its
    // basis, then what it shows beside it.
    let statics: Vec<_> = files.iter().map(|file| file.statics(push, (prepared, order))).collect();
    let count: usize = files.iter().map(|file| file.modes + SHOWN).sum();
    let mut columns = Matrix::zeros(pencil.n_dof(), count);
    let mut at = 0;
    for (file, statics) in files.iter().zip(&statics) {
        columns.subcols_mut(at, file.modes).copy_from(&file.basis);
        for (place, field) in statics.iter().enumerate() {
            columns.col_as_slice_mut(at + file.modes + place).copy_from_slice(field);
        }
        at += file.modes + SHOWN;
    }
    let complement = truth.complement(columns);

    let mut samples = vec![];
    for (place, damped) in damped.iter().enumerate() {
        if place > 0 {
            truth = truth.damped(&|lambda, _| damped.decay(lambda), &Silent).expect("a truth");
        }
        let exact: Vec<Matrix> =
            (0..loads.len()).map(|history| truth.trajectory(history).coordinates()).collect();
        let mut first = 0;
        for file in &damped.files {
            for (history, load) in loads.iter().enumerate() {
                let shown = file.show(push, order, history);
                let apart = |statics: Option<usize>| {
                    let mut amplitudes = Matrix::zeros(count, 1 + STEPS);
                    amplitudes.subrows_mut(first, file.modes).copy_from(&shown.coordinates);
                    if let Some(place) = statics {
                        for n in 1..=STEPS {
                            amplitudes[(first + file.modes + place, n)] =
                                load.when.just_before(n as f64 * step);
                        }
                    }
                    complement.squares_apart(exact[history].clone(), amplitudes.as_ref())
                };
                let under = |under: &Matrix| {
                    let entry = (std::slice::from_ref(load), &[0][..]);
                    let errors = contact_errors(truth.trajectory(history), (entry, under.as_ref()), step);
                    errors[0].expect("a point that moves")
                };
                let [alone, local, whole] = [None, Some(0), Some(1)].map(apart);
                let norm = exact[history].squared_norm_l2();
                let last = file.eigenvalues.last().expect("a mode").sqrt();
                let bound = file.bound(push, order);
                let bounds = HISTORIES[history].variation(last * step).into_iter().map(|share| share * bound);
                let bounds: Vec<f64> = bounds.collect();
                let ratios =
                    || bounds[1..].iter().zip(&whole[1..]).map(|(bound, square)| bound / square.sqrt());
                samples.push(Sample {
                    error: [&alone, &local, &whole].map(|squares| (sum(squares) / norm).sqrt()),
                    contact: [0, 1].map(|with| under(&shown.under[with])),
                    reference: truth.trajectory(history).estimate(),
                    bound: ratios().fold(f64::INFINITY, f64::min),
                    bound_of_total: (bounds.iter().map(|b| b * b).sum::<f64>() / sum(&whole)).sqrt(),
                    above: ratios().filter(|&ratio| ratio < 1.0).count(),
                });
            }
            first += file.modes + SHOWN;
        }
    }
    samples
}

impl Damped {
    /// Decay of a mode by its `λ`.
    fn decay(&self, lambda: f64) -> f64 {
        let eigenvalues = &self.files[0].eigenvalues;
        self.prepared.ratios.decay(&self.prepared.rayleigh(), eigenvalues, lambda)
    }
}

fn sum(squares: &[f64]) -> f64 {
    squares.iter().sum()
}
