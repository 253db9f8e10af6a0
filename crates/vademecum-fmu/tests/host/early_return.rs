//! Steps that the master watches from inside, and steps that end early.

use std::ffi::c_void;
use std::sync::atomic::{AtomicPtr, Ordering};

use vademecum_fmu::fmi3::*;
use vademecum_fmu::variables::Variable as V;

use crate::unit::*;

/// The instance that a callback reads: each test has its own callback, and place of its instance.
type Place = AtomicPtr<c_void>;

/// Starts an instance.
fn start(i: *mut c_void) {
    assert!(!i.is_null());
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(i, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!(fmi3ExitInitializationMode(i), 0);
    }
}

fn get(i: *mut c_void, reference: u32) -> f64 {
    let mut value = f64::NAN;
    assert_eq!(unsafe { fmi3GetFloat64(i, &reference, 1, &mut value, 1) }, 0);
    value
}

fn put(i: *mut c_void, reference: u32, value: f64) {
    assert_eq!(unsafe { fmi3SetFloat64(i, &reference, 1, &value, 1) }, 0);
}

/// Status, early return, and time of a step.
fn step(i: *mut c_void, point: f64, size: f64) -> (i32, bool, f64) {
    let (mut flags, mut last) = ([9_u8; 3], f64::NAN);
    let [event, ended, early] = &mut flags;
    let status = unsafe { fmi3DoStep(i, point, size, 1, event, ended, early, &mut last) };
    assert_eq!((*event, *ended), (0, 0));
    (status, *early == 1, last)
}

/// Energies at the internal steps that were told.
static TOLD: std::sync::Mutex<Vec<(f64, f64)>> = std::sync::Mutex::new(vec![]);
static WATCHED: Place = AtomicPtr::new(std::ptr::null_mut());

unsafe extern "C" fn watch(
    _: *mut c_void,
    time: f64,
    set: u8,
    get_allowed: u8,
    finished: u8,
    can_return: u8,
    requested: *mut u8,
    at: *mut f64,
) {
    assert_eq!((set, get_allowed, finished), (0, 1, 1));
    let i = WATCHED.load(Ordering::SeqCst);
    let energy = get(i, 2);
    let mut told = TOLD.lock().expect("a list");
    told.push((time, energy));
    // Within a step nothing may be set, and no other step be taken.
    unsafe {
        assert_eq!(fmi3SetFloat64(i, &3, 1, &1.0, 1), 3);
        assert_eq!(fmi3Reset(i), 3);
        if told.len() == 3 && can_return == 1 {
            // Half way through the sixth internal step, which is the first to end after that.
            (*requested, *at) = (1, time + 2.5 * (time / 3.0));
        }
    }
}

#[test]
fn a_master_reads_within_a_step_and_ends_it() {
    let unit = Unit::new("exact-f64.vdm");
    let log = Log::new();
    let force = unit.reference(V::Force(1, 2));
    let [one, deaf] = [true, false].map(|is_watched| {
        let update = is_watched.then_some(watch as _);
        unit.three_with(&log, update, is_watched, &[unit.reference(V::Energy)])
    });
    for i in [one, deaf] {
        start(i);
        put(i, force, -20.0);
    }
    let dt = get(one, 1);
    WATCHED.store(one, Ordering::SeqCst);
    let (status, early, last) = step(one, 0.0, 10.0 * dt);
    assert_eq!((status, early), (0, true));
    assert!((last - 6.0 * dt).abs() < 1e-12, "{last}");
    let told = std::mem::take(&mut *TOLD.lock().expect("a list"));
    assert_eq!(told.len(), 6);
    for (k, &(time, energy)) in told.iter().enumerate() {
        assert_eq!(step(deaf, k as f64 * dt, dt).0, 0);
        assert!((time - (k as f64 + 1.0) * dt).abs() < 1e-12);
        assert_eq!(energy, get(deaf, 2), "internal step {k}");
    }
    // Derivatives are those of all six, as of one step that is not watched.
    let (shown, seed) = (unit.reference(V::Displacement(1, 2)), 1.0);
    let along = |i| unsafe {
        let mut change = f64::NAN;
        assert_eq!(fmi3GetDirectionalDerivative(i, &shown, 1, &force, 1, &seed, 1, &mut change, 1), 0);
        change
    };
    let early_change = along(one);
    let whole = unit.three(&log);
    start(whole);
    put(whole, force, -20.0);
    assert_eq!(step(whole, 0.0, 6.0 * dt), (0, false, 6.0 * dt));
    assert_eq!(early_change, along(whole));
    // It goes on from where it is, and to the end where nobody asks.
    TOLD.lock().expect("a list").extend([(0.0, 0.0); 5]);
    assert_eq!(step(one, last, 4.0 * dt), (0, false, last + 4.0 * dt));
    TOLD.lock().expect("a list").clear();
    // A step that is refused leaves all as it was.
    let before = get(one, 2);
    put(one, force, f64::MAX);
    let (status, early, time) = step(one, last + 4.0 * dt, 2.0 * dt);
    assert_eq!((status, early, time), (3, false, last + 4.0 * dt));
    assert_eq!(get(one, 2), before);
    put(one, force, -20.0);
    TOLD.lock().expect("a list").extend([(0.0, 0.0); 5]);
    assert_eq!(step(one, last + 4.0 * dt, dt).0, 0);
    [one, deaf, whole].into_iter().for_each(|i| unsafe { fmi3FreeInstance(i) });
    // Inputs are held: they cannot be watched.
    let none = unit.three_with(&log, Some(watch), true, &[force]);
    log.not_made(none, &["within a step outputs may be read"]);
}

#[test]
fn a_body_that_bends_far_stops_where_it_leaves_its_training() {
    let unit = Unit::new("bent.vdm");
    let log = Log::new();
    let [free, bound] = [true, false].map(|early| unit.three_with(&log, None, early, &[]));
    let energy = unit.reference(V::Energy);
    let pattern = unit.reference(V::Pattern(0));
    [free, bound].into_iter().for_each(start);
    let dt = get(free, 1);
    // A load that grows until the body leaves.
    let (mut time, mut left) = (0.0, None);
    for turn in 1..60 {
        let amplitude = f64::from(turn * turn);
        [free, bound].into_iter().for_each(|i| put(i, pattern, amplitude));
        let (status, early, last) = step(free, time, 8.0 * dt);
        assert_eq!(status, 0);
        if early {
            assert!(last > time && last < time + 7.5 * dt);
            left = Some(last);
            break;
        }
        assert_eq!(step(bound, time, 8.0 * dt), (0, false, last));
        assert_eq!(get(free, energy), get(bound, energy));
        time = last;
    }
    let last = left.expect("it leaves");
    // Outside it goes on without a stop, as one that may not return early does all the way.
    assert_eq!(step(bound, time, 8.0 * dt), (0, false, time + 8.0 * dt));
    let rest = time + 8.0 * dt - last;
    let (status, _, end) = step(free, last, (rest / dt).round() * dt);
    assert_eq!(status, 0);
    assert!((end - time - 8.0 * dt).abs() < 1e-12);
    assert_eq!(get(free, energy), get(bound, energy));
    [free, bound].into_iter().for_each(|i| unsafe { fmi3FreeInstance(i) });
}
