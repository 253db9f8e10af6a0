//! Directional and adjoint derivatives against differences over a step, and against each other.

use vademecum_eval::format::File;
use vademecum_fmu::fmi2::*;
use vademecum_fmu::fmi3::*;
use vademecum_fmu::variables::{Counts, Variable as V};

use crate::unit::*;

/// References of all inputs, and of all outputs.
fn inputs_and_outputs(counts: &Counts) -> [Vec<u32>; 2] {
    let all = || (0..).zip(counts.all());
    let inputs = all().filter(|(_, v)| matches!(v, V::Force(..) | V::Pattern(_)));
    let outputs = all().filter(|(_, v)| v.is_output());
    [inputs.map(|(reference, _)| reference).collect(), outputs.map(|(reference, _)| reference).collect()]
}

impl Two {
    fn numbers(&self, references: &[u32]) -> Vec<f64> {
        self.bits(references).into_iter().map(f64::from_bits).collect()
    }

    fn put(&self, references: &[u32], values: &[f64]) {
        let status = unsafe { fmi2SetReal(self.0, references.as_ptr(), values.len(), values.as_ptr()) };
        assert_eq!(status, 0);
    }

    fn along(&self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Vec<f64> {
        let mut change = vec![f64::NAN; unknowns.len()];
        let (m, n) = (unknowns.len(), knowns.len());
        let status = unsafe {
            let (u, k) = (unknowns.as_ptr(), knowns.as_ptr());
            fmi2GetDirectionalDerivative(self.0, u, m, k, n, seed.as_ptr(), change.as_mut_ptr())
        };
        assert_eq!(status, 0);
        change
    }
}

/// The largest of some numbers.
fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, x| x.abs().max(most))
}

/// Files whose step is linear, with both structures, filtered residuals, reactions and stress.
const LINEAR: [&str; 8] = [
    "exact-f64.vdm",
    "fixed-f64.vdm",
    "fixed-f32.vdm",
    "parameters.vdm",
    "parametric.vdm",
    "quadratic.vdm",
    "reactions.vdm",
    "stress.vdm",
];

#[test]
fn derivatives_are_those_of_a_step_by_central_differences() {
    for name in LINEAR {
        let unit = Unit::new(name);
        assert!(unit.counts.linear, "{name}");
        let log = Log::new();
        let one = unit.two(&log);
        one.start();
        let [inputs, outputs] = inputs_and_outputs(&unit.counts);
        let held: Vec<f64> =
            inputs.iter().map(|&reference| 2.0 + 3.0 * (f64::from(reference)).sin()).collect();
        let seed: Vec<f64> = inputs.iter().map(|&reference| (1.7 * f64::from(reference)).cos()).collect();
        // Nothing has acted yet.
        assert_eq!(one.along(&outputs, &inputs, &seed), vec![0.0; outputs.len()], "{name}");
        let (step, mut time) = (one.internal_step(), 0.0);
        // The first step, several internal ones, and one of another length where there are such.
        let cut = if unit.counts.exact != 0 { 1.5 } else { 4.0 };
        for (turn, length) in [1.0, 1.0, 3.0, cut, 1.0].into_iter().enumerate() {
            let saved = one.serialized();
            let at = |share: f64| {
                assert_eq!(one.take(&saved), 0);
                let moved: Vec<f64> = held.iter().zip(&seed).map(|(x, d)| x + share * d).collect();
                one.put(&inputs, &moved);
                assert_eq!(one.step(time, length * step), 0);
                one.numbers(&outputs)
            };
            let (above, below) = (at(0.5), at(-0.5));
            at(0.0);
            let found = one.along(&outputs, &inputs, &seed);
            // Outputs differ in unit: each kind is compared with its own largest.
            let kinds = |k: usize| unit.counts.variable(outputs[k]).map(|variable| variable.kind().0);
            for k in 0..outputs.len() {
                let of_kind: Vec<usize> = (0..outputs.len()).filter(|&j| kinds(j) == kinds(k)).collect();
                let pick = |numbers: &[f64]| of_kind.iter().map(|&j| numbers[j]).collect::<Vec<f64>>();
                // What a stress or an energy was at both ends bounds the digits of their difference.
                let size = largest(&pick(&above)).max(largest(&pick(&below))).max(largest(&pick(&found)));
                let difference = above[k] - below[k];
                let is_curved = kinds(k) == Some("von_mises");
                if !is_curved {
                    let apart = (found[k] - difference).abs();
                    assert!(
                        apart <= 1e-7 * largest(&pick(&found)) + 1e-12 * size,
                        "{name} {turn} {:?}",
                        kinds(k)
                    );
                }
            }
            assert!(largest(&found) > 0.0, "{name}");
            // A curved output by small differences.
            let small = 1e-4;
            let (above, below) = (at(small), at(-small));
            at(0.0);
            for (k, found) in found.iter().enumerate() {
                let difference = (above[k] - below[k]) / (2.0 * small);
                let apart = (found - difference).abs();
                if kinds(k) == Some("von_mises") {
                    assert!(
                        apart <= 1e-7 * found.abs() && *found != 0.0,
                        "{name} {turn}: {found} {difference}"
                    );
                }
            }
            time += length * step;
        }
    }
}

#[test]
fn adjoint_derivatives_are_the_transposed_ones() {
    let unit = Unit::new("reactions.vdm");
    let (log, two_log) = (Log::new(), Log::new());
    let (three, two) = (unit.three(&log), unit.two(&two_log));
    two.start();
    let [inputs, outputs] = inputs_and_outputs(&unit.counts);
    let values: Vec<f64> = inputs.iter().map(|&reference| f64::from(reference)).collect();
    let step = two.internal_step();
    two.put(&inputs, &values);
    assert_eq!(two.step(0.0, 3.0 * step), 0);
    let (m, n) = (outputs.len(), inputs.len());
    let (mut flags, mut last) = ([0; 3], 0.0);
    let [a, b, c] = &mut flags;
    let weights: Vec<f64> = outputs.iter().map(|&reference| 1.0 / (1.0 + f64::from(reference))).collect();
    let (mut adjoint, mut change) = (vec![f64::NAN; n], vec![f64::NAN; m]);
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(three, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!(fmi3ExitInitializationMode(three), 0);
        assert_eq!(fmi3SetFloat64(three, inputs.as_ptr(), n, values.as_ptr(), n), 0);
        assert_eq!(fmi3DoStep(three, 0.0, 3.0 * step, 1, a, b, c, &mut last), 0);
        let (u, k, w) = (outputs.as_ptr(), inputs.as_ptr(), weights.as_ptr());
        assert_eq!(fmi3GetAdjointDerivative(three, u, m, k, n, w, m, adjoint.as_mut_ptr(), n), 0);
        let ones = vec![1.0; n];
        let out = change.as_mut_ptr();
        assert_eq!(fmi3GetDirectionalDerivative(three, u, m, k, n, ones.as_ptr(), n, out, m), 0);
        let status = fmi3GetAdjointDerivative(three, u, m, k, n, w, m - 1, adjoint.as_mut_ptr(), n);
        log.refused(status, &["fmi3GetAdjointDerivative", "values for"]);
        let status = fmi3GetDirectionalDerivative(three, u, m, k, n, ones.as_ptr(), n + 1, out, m);
        log.refused(status, &["fmi3GetDirectionalDerivative", "values for"]);
    }
    // Both versions agree to the bit, and column by column with the adjoint.
    assert_eq!(change, two.along(&outputs, &inputs, &vec![1.0; n]));
    for (k, &found) in adjoint.iter().enumerate() {
        let mut seed = vec![0.0; n];
        seed[k] = 1.0;
        let column = two.along(&outputs, &inputs, &seed);
        let wanted: f64 = column.iter().zip(&weights).map(|(change, weight)| change * weight).sum();
        assert!((found - wanted).abs() <= 1e-12 * wanted.abs(), "input {k}: {found} {wanted}");
    }
    unsafe { fmi3FreeInstance(three) };
}

#[test]
fn derivatives_come_back_with_a_state_and_are_refused_by_name() {
    let unit = Unit::new("parameters.vdm");
    let file = File::parse(&unit.bytes).expect("a file");
    let log = Log::new();
    let (one, other) = (unit.two(&log), unit.two(&log));
    one.start();
    other.start();
    let [inputs, outputs] = inputs_and_outputs(&unit.counts);
    let seed = vec![1.0; inputs.len()];
    let step = one.internal_step();
    one.put(&inputs, &seed);
    assert_eq!(one.step(0.0, 2.0 * step), 0);
    let found = one.along(&outputs, &inputs, &seed);
    assert_eq!(other.take(&one.serialized()), 0);
    assert_eq!(other.along(&outputs, &inputs, &seed), found);
    // Inputs that no step has seen change nothing.
    one.put(&inputs, &vec![9.0; inputs.len()]);
    assert_eq!(one.along(&outputs, &inputs, &seed), found);
    let ask = |unknown: u32, known: u32, seed: f64| unsafe {
        fmi2GetDirectionalDerivative(one.0, &unknown, 1, &known, 1, &seed, &mut 0.0)
    };
    log.refused(ask(outputs[0], outputs[0], 1.0), &["fmi2GetDirectionalDerivative", "no input"]);
    log.refused(ask(inputs[0], inputs[0], 1.0), &["force.root.x", "no output"]);
    log.refused(ask(outputs[0], inputs[0], f64::NAN), &["force.root.x", "NaN"]);
    log.refused(ask(outputs[0], inputs[0], f64::MAX), &["too large"]);
    log.refused(ask(outputs[0], 9999, 1.0), &["value reference 9999"]);
    let parameter = file.parameters().position(|p| p.role != vademecum_eval::format::ParameterRole::TimeStep);
    let parameter = parameter.expect("a parameter") as u32;
    let own = file.parameters().nth(parameter as usize).expect("the same");
    assert_eq!(one.set(unit.reference(V::Parameter(parameter)), own.upper), 0);
    log.refused(ask(outputs[0], inputs[0], 1.0), &["a parameter has changed since the last step"]);
    assert_eq!(one.step(2.0 * step, step), 0);
    assert_eq!(ask(outputs[0], inputs[0], 1.0), 0);

    // A parameter that is set before the first step is no change since one.
    assert_eq!(other.take(&unit.two(&log).serialized()), 0);
    other.start();
    assert_eq!(other.set(unit.reference(V::Parameter(parameter)), own.upper), 0);
    assert_eq!(other.along(&outputs, &inputs, &seed), vec![0.0; outputs.len()]);

    let free = Unit::new("free.vdm");
    let one = free.two(&log);
    one.start();
    let [inputs, outputs] = inputs_and_outputs(&free.counts);
    let status =
        unsafe { fmi2GetDirectionalDerivative(one.0, &outputs[0], 1, &inputs[0], 1, &1.0, &mut 0.0) };
    log.refused(status, &["this body has no derivatives", "flies"]);
}
