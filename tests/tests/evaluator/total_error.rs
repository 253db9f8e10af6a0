//! The record of `docs/measurements/total-error.md`, reduced to seconds: the same code on a small body.

use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_tests::total_error::{HISTORIES, Push, RealBody, Row, STEPS, markdown, measure, quantiles};

fn block() -> RealBody {
    RealBody {
        name: "block",
        what: "a block of 4 × 2 × 2 cells",
        vectors: 400,
        text: "[mesh]\nblock = { lengths = [0.2, 0.1, 0.1], divisions = [4, 2, 2], order = \"linear\" }\n\
               [[material]]\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n\
               [[support]]\non = { group = \"x_min\" }\n[load]\n"
            .into(),
    }
}

fn of(rows: &[Row], ratio: f64, modes: usize, history: usize) -> &Row {
    let is = |row: &&Row| row.ratio == ratio && row.modes == modes && row.history == history;
    rows.iter().find(is).expect("a row")
}

#[test]
fn the_bound_holds_and_the_static_part_helps_on_a_block() {
    let (conditions, rows) = measure(&block(), &[0.0, 0.02], &[4, 8], 2, |_, _| ());
    let text = markdown(&block(), &conditions, &rows);
    println!("{text}");
    assert_eq!(conditions.dofs, 108);
    assert_eq!(rows.len(), 2 * 2 * HISTORIES.len());
    assert_eq!(
        text.lines().filter(|line| line.starts_with("| 2 % |") || line.starts_with("| none |")).count(),
        32
    );
    for row in &rows {
        assert_eq!(row.samples.len(), 2);
        for sample in &row.samples {
            // The space closes on so small a body: the reference is exact, and the bound has no excuse.
            assert!(sample.reference <= 1e-11, "{sample:?}");
            assert!(sample.above == 0 && sample.bound >= 1.0 && sample.bound_of_total >= 1.0, "{sample:?}");
            // It is not idle either: the goal of the project for the median of many pushes.
            assert!(sample.bound < 10.0, "{sample:?}");
            let [alone, local, whole] = sample.error;
            assert!(whole < local && local < alone, "{sample:?}");
            assert!(sample.contact[1] < sample.contact[0], "{sample:?}");
        }
    }
    // More modes, more damping and gentler loads leave less: of each sample, on these two pushes.
    for history in 0..HISTORIES.len() {
        for push in 0..2 {
            let error = |ratio, modes, history| of(&rows, ratio, modes, history).samples[push].error[2];
            assert!(error(0.02, 8, history) < error(0.02, 4, history));
            assert!(error(0.02, 8, history) < error(0.0, 8, history));
            assert!(error(0.02, 8, 1) < error(0.02, 8, 0) && error(0.02, 8, 3) < error(0.02, 8, 2));
        }
    }
}

#[test]
fn pushes_are_the_same_every_time_and_fill_the_surface() {
    let problem = block().problem(1e-3, 4, 0.02);
    let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model");
    let (few, many) = (Push::draw(&prepared.body, 2), Push::draw(&prepared.body, 400));
    assert_eq!(format!("{few:?}"), format!("{:?}", &many[..2]));
    for push in &many {
        let sum: f64 = push.weights.iter().sum();
        let size: f64 = push.force.iter().map(|f| f * f).sum();
        assert!((sum - 1.0).abs() < 1e-15 && (size - 1.0).abs() < 1e-14, "{push:?}");
        assert!(push.weights.iter().all(|&weight| weight >= 0.0));
    }
    // The free end has a ninth of the surface that can move: 0.01 of 0.09 m². Four standard deviations.
    let at = |node: u32| prepared.body.model.mesh().nodes[node as usize][0];
    let at_end = |push: &&Push| push.nodes.iter().all(|&node| at(node) == 0.2);
    let found = many.iter().filter(at_end).count() as f64;
    let deviation = (400.0_f64 * (1.0 / 9.0) * (8.0 / 9.0)).sqrt();
    assert!((found - 400.0 / 9.0).abs() < 4.0 * deviation, "{found}");
    let mean: [f64; 3] = std::array::from_fn(|k| many.iter().map(|push| push.force[k]).sum::<f64>() / 400.0);
    // A component of a random direction varies by 1/√3.
    assert!(mean.iter().all(|m| m.abs() < 4.0 / (3.0_f64 * 400.0).sqrt()), "{mean:?}");
}

#[test]
fn the_bound_counts_jumps_and_ramps() {
    let of = |history: usize, angle: f64| HISTORIES[history].variation(angle);
    let released = of(0, 1.0);
    assert_eq!(released.len(), 1 + STEPS);
    // A field shows a load that jumps away at an instant as it was before.
    assert_eq!(
        [released[0], released[1], released[40], released[41], released[STEPS]],
        [0.0, 1.0, 1.0, 2.0, 2.0]
    );
    // A ramp of four steps counts a half where ωΔt = 1, and as a jump where the lowest frequency is slow.
    let ramps = of(1, 1.0);
    assert_eq!(
        [ramps[0], ramps[1], ramps[2], ramps[4], ramps[36], ramps[40]],
        [0.0, 0.25, 0.5, 0.5, 0.5, 1.0]
    );
    assert_eq!(
        [of(1, 0.1)[4], of(1, 0.1)[STEPS], of(3, 0.1)[STEPS], of(2, 0.1)[STEPS]],
        [1.0, 2.0, 1.0, 1.0]
    );
}

#[test]
fn quantiles_are_values_of_the_sample() {
    assert_eq!(quantiles((1..=200).rev().map(f64::from).collect()), [100.0, 190.0, 200.0]);
    assert_eq!(quantiles(vec![3.0]), [3.0; 3]);
    assert_eq!(quantiles(vec![2.0, 1.0]), [1.0, 2.0, 2.0]);
}
