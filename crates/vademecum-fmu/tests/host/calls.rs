//! Calls come in order; everything else is refused by name.

use std::ffi::{CString, c_char};
use std::ptr::{null, null_mut};

use vademecum_fmu::fmi2::*;
use vademecum_fmu::fmi3::*;
use vademecum_fmu::variables::Variable as V;

use crate::unit::*;

#[test]
fn steps_are_multiples_at_the_right_time_and_calls_come_in_order() {
    let unit = Unit::new("fixed-f64.vdm");
    let log = Log::new();
    let one = unit.two(&log);
    let i = one.0;
    unsafe {
        let mut value = 0.0;
        log.refused(one.step(0.0, 1e-3), &["fmi2DoStep is not allowed now", "not initialized"]);
        log.refused(fmi2GetReal(i, &0, 1, &mut value), &["fmi2GetReal is not allowed now"]);
        log.refused(fmi2EnterInitializationMode(i), &["fmi2SetupExperiment"]);
        log.refused(fmi2ExitInitializationMode(i), &["fmi2ExitInitializationMode is not allowed now"]);
        log.refused(fmi2Terminate(i), &["fmi2Terminate is not allowed now"]);
        log.refused(fmi2SetupExperiment(i, 0, 0.0, f64::NAN, 0, 0.0), &["NaN"]);
        log.refused(fmi2SetupExperiment(i, 0, 0.0, 2.0, 1, 1.0), &["from 2.0 s to 1.0 s"]);
        assert_eq!(fmi2SetupExperiment(i, 0, 0.0, 0.0, 1, 4.0), 0);
        assert_eq!(fmi2EnterInitializationMode(i), 0);
        log.refused(fmi2SetupExperiment(i, 0, 0.0, 0.0, 0, 0.0), &["in its initialization"]);
        log.refused(one.step(0.0, 1e-3), &["fmi2DoStep is not allowed now"]);
        assert_eq!(fmi2ExitInitializationMode(i), 0);
    }
    let step = one.internal_step();
    for bad in [0.0, -step, 0.5 * step, 1.5 * step, step * (1.0 + 1e-6), f64::NAN, f64::INFINITY] {
        log.refused(one.step(0.0, bad), &["fmi2DoStep: the communication step", "no multiple", "internal"]);
    }
    log.refused(one.step(0.0, 1.5 * step), &[&format!("{:?}", 1.5 * step), &format!("{step:?}")]);
    log.refused(one.step(0.0, 1e12 * step), &["more than 1000000000 times"]);
    log.refused(one.step(0.5 * step, step), &["the communication point is", "the instance is at 0.0 s"]);
    log.refused(one.step(f64::NAN, step), &["NaN"]);
    // A master that adds up its steps, with all of their roundings.
    let mut time = 0.0;
    for _ in 0..1000 {
        let next = time + step;
        assert_eq!(one.step(time, next - time), 0);
        time = next;
    }
    assert_eq!(one.step(time, 7.0 * step), 0);
    log.refused(one.step(time + 7.0 * step, 1e6 * step), &["beyond the stop time, 4.0 s"]);
    unsafe {
        let (mut state, mut value) = (null_mut(), 0.0);
        log.refused(fmi2GetReal(i, &9999, 1, &mut value), &["value reference 9999"]);
        log.refused(fmi2GetReal(i, null(), 1, &mut value), &["null pointer"]);
        log.refused(fmi2GetReal(i, &0, 1, null_mut()), &["null pointer"]);
        log.refused(fmi2SetReal(i, &0, 1, &1.0), &["time", "cannot be set"]);
        log.refused(fmi2GetInteger(i, &0, 1, null_mut()), &["fmi2GetInteger", "Real"]);
        log.refused(fmi2SetString(i, &0, 1, null()), &["fmi2SetString", "Real"]);
        assert_eq!(fmi2GetBoolean(i, null(), 0, null_mut()), 0);
        let status = fmi2GetDirectionalDerivative(i, &0, 1, &0, 1, &0.0, &mut value);
        log.refused(status, &["fmi2GetDirectionalDerivative: time", "no input"]);
        log.refused(fmi2SetRealInputDerivatives(i, &0, 1, &1, &0.0), &["canInterpolateInputs"]);
        log.refused(fmi2CancelStep(i), &["fmi2CancelStep"]);
        log.refused(fmi2GetStatus(i, 0, null_mut()), &["fmi2GetStatus"]);
        assert_eq!(fmi2GetRealStatus(i, 2, &mut value), 0);
        assert!((value - 1007.0 * step).abs() < 1e-9);
        log.refused(fmi2SetFMUstate(i, null_mut()), &["fmi2SetFMUstate", "null"]);
        log.refused(fmi2GetFMUstate(i, null_mut()), &["fmi2GetFMUstate", "null"]);
        assert_eq!(fmi2FreeFMUstate(i, &mut state), 0, "null is free already");
        let mut small = [0; 8];
        assert_eq!(fmi2GetFMUstate(i, &mut state), 0);
        log.refused(fmi2SerializeFMUstate(i, state, small.as_mut_ptr(), 8), &["no room"]);
        assert_eq!(fmi2GetFMUstate(i, &mut state), 0, "written over");
        assert_eq!(fmi2FreeFMUstate(i, &mut state), 0);
        log.refused(fmi2SetDebugLogging(i, 1, 1, &c"logNothing".as_ptr()), &["logStatusError and logEvents"]);
        assert_eq!(fmi2SetDebugLogging(i, 1, 1, &c"logEvents".as_ptr()), 0);
        assert_eq!(fmi2Terminate(i), 0);
        log.refused(one.step(1.0, step), &["fmi2DoStep is not allowed now: the instance has terminated"]);
        assert_eq!(fmi2GetReal(i, &0, 1, &mut value), 0, "what was reached may still be read");
        assert_eq!(fmi2Reset(i), 0);
        // Null everywhere.
        assert_eq!(fmi2DoStep(null_mut(), 0.0, 1.0, 0), 3);
        assert_eq!(fmi3DoStep(null_mut(), 0.0, 1.0, 0, null_mut(), null_mut(), null_mut(), null_mut()), 3);
        fmi2FreeInstance(null_mut());
        fmi3FreeInstance(null_mut());
    }
}

#[test]
fn three_refuses_by_name_what_it_does_not_do() {
    let unit = Unit::new("fixed-f64.vdm");
    let log = Log::new();
    let i = unit.three(&log);
    assert!(!i.is_null());
    unsafe {
        let mut value = 0.0;
        log.refused(fmi3EnterEventMode(i), &["fmi3EnterEventMode", "hasEventMode"]);
        log.refused(fmi3SetTime(i, 0.0), &["fmi3SetTime", "co-simulation"]);
        log.refused(fmi3EnterConfigurationMode(i), &["fmi3EnterConfigurationMode"]);
        log.refused(fmi3GetInt32(i, &0, 1, null_mut(), 1), &["fmi3GetInt32", "Float64"]);
        log.refused(fmi3GetClock(i, &0, 1, null_mut()), &["fmi3GetClock", "no clocks"]);
        log.refused(fmi3GetOutputDerivatives(i, &0, 1, &1, null_mut(), 1), &["fmi3GetOutputDerivatives"]);
        log.refused(fmi3Terminate(i), &["fmi3Terminate is not allowed now"]);
        assert_eq!(fmi3EnterInitializationMode(i, 0, 0.0, 0.0, 0, 0.0), 0);
        log.refused(fmi3GetFloat64(i, &0, 1, &mut value, 2), &["2 values for variables that have 1"]);
        assert_eq!(fmi3ExitInitializationMode(i), 0);
        let (mut a, mut b, mut c, mut last) = (9, 9, 9, 9.0);
        let status = fmi3DoStep(i, 0.0, 1e-3, 0, null_mut(), &mut b, &mut c, &mut last);
        log.refused(status, &["fmi3DoStep", "null"]);
        let status = fmi3DoStep(i, 0.0, 1.23e-5, 0, &mut a, &mut b, &mut c, &mut last);
        log.refused(status, &["fmi3DoStep", "0.0000123 s", "no multiple"]);
        assert_eq!((a, b, c, last), (0, 0, 0, 0.0));
        fmi3FreeInstance(i);
        let (token, environment) = (unit.token.as_ptr(), log.environment());
        let folder = c"/".as_ptr();
        let none = fmi3InstantiateModelExchange(c"x".as_ptr(), token, folder, 0, 0, environment, Some(hear3));
        log.not_made(none, &["fmi3InstantiateModelExchange", "co-simulation"]);
    }
}

#[test]
fn what_does_not_belong_together_is_not_made() {
    let unit = Unit::new("fixed-f64.vdm");
    let log = Log::new();
    let (token, uri) = (unit.token.clone(), unit.uri());
    let foreign = c"{8c4e810f-3df3-4a00-8276-176fa3c9f000}";
    log.not_made(unit.two_with(&log, foreign, &uri, 1), &["GUID", "export"]);
    log.not_made(unit.two_with(&log, &token, c"http://example.org/resources", 1), &["file:///"]);
    log.not_made(unit.two_with(&log, &token, c"file:///nowhere", 1), &["body.vdm", "cannot be opened"]);
    log.not_made(unit.two_with(&log, &token, &uri, 0), &["fmi2Instantiate", "co-simulation"]);
    let functions = log.functions();
    let make = |name: *const c_char, token: *const c_char, uri: *const c_char, functions| unsafe {
        fmi2Instantiate(name, 1, token, uri, functions, 0, 1)
    };
    let (name, id, place) = (c"beam".as_ptr(), token.as_ptr(), uri.as_ptr());
    log.not_made(make(null(), id, place, &functions), &["needs a name"]);
    log.not_made(make(name, null(), place, &functions), &["GUID"]);
    log.not_made(make(name, id, null(), &functions), &["location"]);
    assert!(make(name, id, place, null()).is_null());
    // Without a log it works all the same.
    let silent = Two(make(name, id, place, &CallbackFunctions { logger: None, ..functions }));
    assert!(!silent.0.is_null());
    silent.start();
    assert_eq!(silent.step(7.0, 1.0), 3);
    // Bytes in the resources that are no longer those of the token.
    for place in [0, unit.bytes.len() / 2, unit.bytes.len() - 1] {
        let mut damaged = unit.bytes.clone();
        damaged[place] ^= 1;
        std::fs::write(unit.resources.join("body.vdm"), damaged).expect("written");
        log.not_made(unit.two_with(&log, &token, &uri, 1), &["GUID"]);
    }
    // A file that is none, under its own token.
    let table = std::fs::read(unit.resources.join("points.bin")).expect("a table");
    for (file, table, words) in [
        (b"no vademecum".to_vec(), table.clone(), ["body.vdm", "refused"]),
        (unit.bytes.clone(), b"VDMFMU01 and no more".to_vec(), ["points.bin", "no table"]),
    ] {
        std::fs::write(unit.resources.join("body.vdm"), &file).expect("written");
        std::fs::write(unit.resources.join("points.bin"), &table).expect("written");
        let token = CString::new(vademecum_fmu::token::token(&file, &table)).expect("a token");
        log.not_made(unit.two_with(&log, &token, &uri, 1), &words);
    }
}

#[test]
fn instances_know_nothing_of_each_other() {
    let unit = Unit::new("fixed-f64.vdm");
    let log = Log::new();
    let step = {
        let one = unit.two(&log);
        log.last(&["vademecum", "3 modes", "internal step"]);
        one.start();
        one.internal_step()
    };
    let turn = |one: &Two, k: u32, turn: u32| {
        assert_eq!(one.set(unit.reference(V::Force(0, 2)), f64::from(k + turn)), 0);
        assert_eq!(one.step(f64::from(turn) * step, step), 0);
    };
    let alone = |k: u32| {
        let log = Log::new();
        let one = unit.two(&log);
        one.start();
        (0..50).for_each(|t| turn(&one, k, t));
        one.all(&unit)
    };
    let wanted: Vec<Vec<u64>> = (0..4).map(alone).collect();
    assert_ne!(wanted[0], wanted[1]);
    // In threads, and side by side in one thread.
    let found: Vec<Vec<u64>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|k| scope.spawn(move || alone(k))).collect();
        threads.into_iter().map(|thread| thread.join().expect("a thread")).collect()
    });
    assert_eq!(found, wanted);
    let all: Vec<Two> = (0..4).map(|_| unit.two(&log)).collect();
    all.iter().for_each(Two::start);
    for t in 0..50 {
        (0..).zip(&all).for_each(|(k, one)| turn(one, k, t));
    }
    let found: Vec<Vec<u64>> = all.iter().map(|one| one.all(&unit)).collect();
    assert_eq!(found, wanted);
}
