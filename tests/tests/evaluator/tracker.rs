//! Tracking of damage at 1 kHz: one of four regions loses 30 % of its stiffness while a known broadband load
//! shakes the beam. The beam that is measured has a richer basis, all of whose modes move.

use std::time::Instant;

use vademecum_eval::{
    Field, ParameterError, Parametric, ParametricError, Sensor, Tracked, Tracker, TrackerOptions,
};
use vademecum_format::File;
use vademecum_format::exact::Propagator;
use vademecum_tests::live_beam::LiveBeam;
use vademecum_tests::normal::Normal;

const STEPS: usize = 12_000;
const H: f64 = 1e-3;

/// Stiffness of the regions after so many steps: the second loses 30 % between 3 and 9 s.
fn truth(step: usize) -> [f64; 5] {
    let share = ((step as f64 * H - 3.0) / 6.0).clamp(0.0, 1.0);
    [1.0, 1.0 - 0.3 * share, 1.0, 1.0, 1e-4]
}

/// Probes of the sensors: two components at each of three places.
const PROBES: [usize; 6] = [1, 2, 4, 5, 7, 8];

/// Velocities of the sensors after each step of a beam whose stiffness changes every 20 steps.
fn measure(model: &Parametric<'_>, loads: &[[f64; 2]], nodes: [usize; 2]) -> Vec<[f64; 6]> {
    let r = model.n_basis();
    let sizes = model.sizes(r).expect("sizes");
    let mut memory = [vec![0.0; sizes.memory], vec![0.0; sizes.memory]];
    let mut work = vec![0.0; sizes.work.max(2 * r)];
    let row = |probe: usize| {
        let mut row = vec![0.0; r];
        model.probe_row(probe, &mut row).expect("a probe");
        row
    };
    let rows = PROBES.map(row);
    let forces = force_rows(model, nodes);
    let (mut q, mut v) = (vec![0.0; r], vec![0.0; r]);
    let mut out = vec![];
    let mut current = 0;
    for step in 0..STEPS {
        if step % 20 == 0 {
            let [first, second] = &mut memory;
            let (new, old) = if current == 0 { (second, first) } else { (first, second) };
            let tuned = model.solve(&truth(step), r, new, &mut work).expect("solved");
            if step > 0 {
                let mut other = vec![0.0; sizes.memory];
                // The modes before, found again in memory of their own.
                let before = model.solve(&truth(step - 20), r, &mut other, &mut work).expect("solved");
                for part in [&mut q, &mut v] {
                    let from = part.clone();
                    tuned.carry(&before, &from, part, &mut work).expect("carried");
                }
            }
            let _ = old;
            current = 1 - current;
        }
        let own = &memory[current];
        let (lambda, shapes) = (&own[5..5 + r], &own[5 + r..5 + r + r * r]);
        let along = |row: &[f64], k: usize| -> f64 {
            row.iter().zip(&shapes[k * r..(k + 1) * r]).map(|(a, b)| a * b).sum()
        };
        let (start, end) = (loads[step], loads[step + 1]);
        for k in 0..r {
            let load = [along(&forces[0], k), along(&forces[1], k)];
            let [f0, f1] = [start, end].map(|amplitude| amplitude[0] * load[0] + amplitude[1] * load[1]);
            let sigma = 0.5 * (1.0 + 1e-4 * lambda[k]);
            let p = Propagator::new(lambda[k], sigma, H);
            let y = [q[k], H * v[k]];
            let next = |i: usize| {
                y[i] + p.d[2 * i] * y[0] + p.d[2 * i + 1] * y[1] + p.held[i] * f0 + p.rising[i] * (f1 - f0)
            };
            (q[k], v[k]) = (next(0), next(1) / H);
        }
        out.push(std::array::from_fn(|i| (0..r).map(|k| along(&rows[i], k) * v[k]).sum()));
    }
    out
}

fn force_rows(model: &Parametric<'_>, nodes: [usize; 2]) -> [Vec<f64>; 2] {
    [(nodes[0], [0.0, 1.0, 1.0]), (nodes[1], [0.0, -1.0, 1.0])].map(|(node, direction)| {
        let mut row = vec![0.0; model.n_basis()];
        model.node_row(node, direction, &mut row).expect("a node");
        row
    })
}

/// The loadable node nearest to a point.
fn node_at(file: &File<'_>, point: [f64; 3]) -> usize {
    let nodes: Vec<f64> = file
        .section(vademecum_format::SectionKind::NodeCoordinates)
        .expect("nodes")
        .numbers()
        .expect("raw")
        .iter()
        .collect();
    let square = |node: &[f64]| node.iter().zip(point).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let loadable = nodes.chunks_exact(3).take(file.metadata().n_load_nodes as usize).enumerate();
    loadable.min_by(|a, b| square(a.1).total_cmp(&square(b.1))).expect("a node").0
}

#[test]
fn a_region_that_loses_stiffness_is_tracked_and_deviations_are_honest() {
    let [rich, lean] = [192, 48].map(|modes| {
        LiveBeam { regions: 4, height: 0.12, modes, both_ends: false, fine: 2, step: 1e-3 }.build(None)
    });
    let [rich, lean] = [&rich, &lean].map(|bytes| File::parse(bytes).expect("a file"));
    let [real, model] = [&rich, &lean].map(|file| Parametric::new(file).expect("a model"));
    let nodes = [node_at(&rich, [1.0, 0.1, 0.12]), node_at(&rich, [0.5, 0.1, 0.12])];
    assert_eq!(nodes, [node_at(&lean, [1.0, 0.1, 0.12]), node_at(&lean, [0.5, 0.1, 0.12])]);
    let mut normal = Normal::new(5);
    let loads: Vec<[f64; 2]> = (0..=STEPS).map(|_| [10.0 * normal.draw(), 10.0 * normal.draw()]).collect();
    let clean = measure(&real, &loads, nodes);
    let rms: [f64; 6] =
        std::array::from_fn(|i| (clean.iter().map(|row| row[i] * row[i]).sum::<f64>() / STEPS as f64).sqrt());

    let tracked: [Tracked; 4] =
        std::array::from_fn(|parameter| Tracked { parameter, deviation: 0.05, drift: 0.02 });
    let sensors: [Sensor; 6] = std::array::from_fn(|i| Sensor {
        probe: PROBES[i],
        field: Field::Velocity,
        deviation: 0.02 * rms[i],
    });
    let options = TrackerOptions {
        modes: 32,
        tracked: &tracked,
        sensors: &sensors,
        load_deviation: 1e-2,
        resolve: 0.01,
    };
    let mut memory = vec![0.0; model.tracker_len(&options).expect("a length")];
    let mut tracker = Tracker::new(&model, &options, &truth(0), &mut memory).expect("a tracker");
    let forces = force_rows(&model, nodes);
    let force = |amplitude: [f64; 2]| -> Vec<f64> {
        forces[0].iter().zip(&forces[1]).map(|(a, b)| amplitude[0] * a + amplitude[1] * b).collect()
    };
    let mut squares = [0.0; 4];
    let (mut inside, mut last, mut seconds) = ([0; 4], [0.0; 4], 0.0);
    for step in 0..STEPS {
        let measured: Vec<f64> =
            clean[step].iter().zip(rms).map(|(value, rms)| value + 0.02 * rms * normal.draw()).collect();
        let (start, end) = (force(loads[step]), force(loads[step + 1]));
        let clock = Instant::now();
        tracker.step(&start, &end, &measured).expect("a step");
        seconds += clock.elapsed().as_secs_f64();
        for place in 0..4 {
            let error = (tracker.values()[place] / truth(step)[place]).ln();
            squares[place] += error * error / STEPS as f64;
            inside[place] += usize::from(error.abs() <= 2.0 * tracker.deviation(place));
            last[place] = error;
        }
    }
    let chi = tracker.take_consistency().expect("measured");
    let root = squares.map(|square: f64| 100.0 * square.sqrt());
    let share = inside.map(|count| 100.0 * count as f64 / STEPS as f64);
    println!("errors (root of the mean square) {root:.2?} %, at the end {:.2?} %", last.map(|e| 100.0 * e));
    println!("within two deviations {share:.1?} % of the steps; innovations {chi:.3}");
    println!(
        "{} eigenproblems in {STEPS} steps, {:.1} µs a step in the mean",
        tracker.solved(),
        1e6 * seconds / STEPS as f64
    );
    let loss = tracker.values()[1];
    assert!((loss / 0.7 - 1.0).abs() < 0.03 && root[1] < 3.0, "{loss} {root:?}");
    for place in [0, 2, 3] {
        assert!(share[place] >= 95.0, "region {place}: {share:?}");
    }
    assert!((0.8..1.3).contains(&chi), "{chi}");
}

#[test]
fn settings_of_a_tracker_are_checked() {
    let bytes = vademecum_tests::golden::named("parametric.vdm");
    let file = File::parse(&bytes).expect("a file");
    let model = Parametric::new(&file).expect("a model");
    let sensors = [Sensor { probe: 0, field: Field::Displacement, deviation: 1e-6 }];
    let tracked = [Tracked { parameter: 7, deviation: 0.1, drift: 0.0 }];
    let options =
        TrackerOptions { modes: 3, tracked: &tracked, sensors: &sensors, load_deviation: 0.0, resolve: 0.01 };
    let values = [1.0, 1.0, 1.0, 1e-6];
    let needed = model.tracker_len(&options).expect("a length");
    let mut memory = vec![0.0; needed];
    let refused = Tracker::new(&model, &options, &values, &mut memory).err();
    assert_eq!(refused, Some(ParameterError::Unknown { index: 7 }.into()));
    let tracked = [Tracked { parameter: 1, ..tracked[0] }];
    let options = TrackerOptions { tracked: &tracked, ..options };
    let short = Tracker::new(&model, &options, &values, &mut memory[1..]).err();
    let found = needed - 1;
    assert_eq!(short, Some(ParametricError::LentMemory { what: "numbers of memory", found, needed }));
    let sensors = [Sensor { probe: 99, ..sensors[0] }];
    let options = TrackerOptions { sensors: &sensors, ..options };
    let none = Tracker::new(&model, &options, &values, &mut memory).err();
    assert!(matches!(none, Some(ParametricError::Row { index: 99, .. })), "{none:?}");
    let options = TrackerOptions { modes: 4, ..options };
    assert!(model.tracker_len(&options).is_err());
}
