//! The entry points of FMI 2.0 for co-simulation, under the names of the standard.
//!
//! # Safety
//! A component is one of [`fmi2Instantiate`] that was not freed, used by one thread at a time; states are
//! those of [`fmi2GetFMUstate`] or [`fmi2DeSerializeFMUstate`] that were not freed, nor was the component
//! they were taken from, which frees those that are left; arrays are as long as the number beside them says;
//! texts end with a zero. Null is refused.
#![allow(unsafe_code, non_snake_case)]

use core::ffi::{CStr, c_char, c_int, c_void};

use crate::boundary::{
    deserialize, free_state, get_state, give, guard, lent, lent_mut, refuse, serialize, set_state, text, with,
};
use crate::instance::{Given, Instance};
use crate::location::Location;
use crate::logger::{Callback, Callback2, Category, Logger};
use crate::mode::{Mode, Modes};
use crate::refusal::Refusal;
use crate::watch::Watch;

/// `fmi2CallbackFunctions`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CallbackFunctions {
    /// The log.
    pub logger: Option<Callback2>,
    /// Not used, as the model description says.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not used.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not used: every step has ended when its call returns.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// Text for the log.
    pub environment: *mut c_void,
}

/// `fmi2CoSimulation`.
const CO_SIMULATION: c_int = 1;
/// `fmi2LastSuccessfulTime`.
const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2Terminated`.
const TERMINATED: c_int = 3;

/// Refusal of values other than numbers.
const REALS_ONLY: &str = "all variables are of type Real";
/// Refusal of derivatives of inputs and outputs.
const NO_DERIVATIVES: &str =
    "inputs are held over a step and outputs have no derivatives (canInterpolateInputs = false)";
/// Refusal of status requests for a step.
const NOT_PENDING: &str = "every step has ended when fmi2DoStep returns; only fmi2LastSuccessfulTime and \
                           fmi2Terminated have an answer";

/// Platform of the types.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// Version of the interface.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// Asks for more than refusals in the log, or no longer.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: *mut c_void,
    logging_on: c_int,
    n_categories: usize,
    categories: *const *const c_char,
) -> c_int {
    // SAFETY (both): as the module says.
    unsafe {
        with(c, "fmi2SetDebugLogging", Modes::ALL, |instance| {
            let categories = lent(categories, n_categories)?;
            instance.set_logging(logging_on != 0, categories.iter().map(|&category| text(category)))
        })
    }
}

/// Makes an instance; null if that is refused, which the log tells.
///
/// # Safety
/// As the module says; the callbacks may be called for as long as the instance lives.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resource_location: *const c_char,
    functions: *const CallbackFunctions,
    _visible: c_int,
    logging_on: c_int,
) -> *mut c_void {
    // SAFETY: as the module says.
    let (name, guid, uri, functions) =
        unsafe { (text(instance_name), text(guid), text(resource_location), functions.as_ref()) };
    let Some(functions) = functions else { return core::ptr::null_mut() };
    // SAFETY: as the caller promises.
    let logger = unsafe { Logger::new(Callback::Two(functions.logger), functions.environment) };
    let refused = |name: &CStr, why: &str| {
        logger.tell(name, Category::Error, &[&"fmi2Instantiate: ", &why]);
        core::ptr::null_mut()
    };
    guard(core::ptr::null_mut(), || {
        let Some(name) = name.filter(|name| !name.is_empty()) else {
            return refused(c"", "an instance needs a name");
        };
        let Some(guid) = guid else { return refused(name, "the GUID is missing") };
        let Some(uri) = uri else { return refused(name, "the resource location is missing") };
        if fmu_type != CO_SIMULATION {
            return refused(name, "this FMU is for co-simulation");
        }
        let resources = Location::Uri(uri.to_bytes());
        let given = Given {
            name,
            token: guid.to_bytes(),
            resources,
            logging: logging_on != 0,
            watch: Watch::NONE,
            watched: &[],
        };
        Instance::make(&given, logger).map_or(core::ptr::null_mut(), |at| at.as_ptr().cast())
    })
}

/// Frees an instance; null is free already.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: *mut c_void) {
    if let Some(instance) = core::ptr::NonNull::new(c.cast::<Instance>()) {
        // SAFETY: as the module says.
        guard((), || unsafe { Instance::free(instance) });
    }
}

/// Tells when the experiment starts and stops.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: *mut c_void,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start: f64,
    stop_defined: c_int,
    stop: f64,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2SetupExperiment", Modes::only(Mode::Instantiated), |instance| {
            instance.set_up(start, (stop_defined != 0).then_some(stop))
        })
    }
}

/// Begins the initialization.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(c, "fmi2EnterInitializationMode", Modes::only(Mode::Instantiated), Instance::begin) }
}

/// Ends the initialization.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2ExitInitializationMode", Modes::only(Mode::Initialization), |instance| {
            instance.go(Mode::Step);
            Ok(())
        })
    }
}

/// Ends the simulation.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2Terminate", Modes::only(Mode::Step), |instance| {
            instance.go(Mode::Terminated);
            Ok(())
        })
    }
}

/// Makes the instance what it was when it was made.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(c, "fmi2Reset", Modes::ALL, Instance::reset) }
}

/// Values of variables.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: *mut c_void, vr: *const u32, nvr: usize, value: *mut f64) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2GetReal", Modes::GET, |instance| instance.get(lent(vr, nvr)?, lent_mut(value, nvr)?))
    }
}

/// Sets inputs and tunable parameters, all or none.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: *mut c_void, vr: *const u32, nvr: usize, value: *const f64) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(c, "fmi2SetReal", Modes::SET, |instance| instance.set(lent(vr, nvr)?, lent(value, nvr)?)) }
}

/// Functions for values of other types: none of them is there.
macro_rules! other_types {
    ($($name:ident, $pointer:ty;)*) => {$(
        /// There are no variables of this type: only an empty list is accepted.
        ///
        /// # Safety
        /// As the module says.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(c: *mut c_void, _vr: *const u32, nvr: usize, _value: $pointer) -> c_int {
            // SAFETY: as the module says.
            unsafe {
                with(c, stringify!($name), Modes::ALL, |_| {
                    if nvr == 0 { Ok(()) } else { Err(Refusal::Unsupported(REALS_ONLY).into()) }
                })
            }
        }
    )*};
}

other_types! {
    fmi2GetInteger, *mut c_int;
    fmi2GetBoolean, *mut c_int;
    fmi2GetString, *mut *const c_char;
    fmi2SetInteger, *const c_int;
    fmi2SetBoolean, *const c_int;
    fmi2SetString, *const *const c_char;
}

/// Saves everything that can change.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(c, "fmi2GetFMUstate", Modes::ALL, |instance| get_state(instance, state)) }
}

/// Takes back what was saved.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(c, "fmi2SetFMUstate", Modes::ALL, |instance| set_state(instance, state)) }
}

/// Frees a state.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(c, "fmi2FreeFMUstate", Modes::ALL, |_| free_state(state)) }
}

/// Bytes of a serialized state.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: *mut c_void,
    _state: *mut c_void,
    size: *mut usize,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2SerializedFMUstateSize", Modes::ALL, |instance| Ok(give(size, instance.saved_len())?))
    }
}

/// Copies a state to bytes.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(c, "fmi2SerializeFMUstate", Modes::ALL, |_| serialize(state, bytes, size)) }
}

/// Makes a state of bytes.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2DeSerializeFMUstate", Modes::ALL, |instance| deserialize(instance, bytes, size, state))
    }
}

/// Derivatives of outputs along seeds of inputs, which the last step held.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: *mut c_void,
    unknowns: *const u32,
    n_unknown: usize,
    knowns: *const u32,
    n_known: usize,
    seed: *const f64,
    sensitivity: *mut f64,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2GetDirectionalDerivative", Modes::DERIVE, |instance| {
            let (unknowns, knowns) = (lent(unknowns, n_unknown)?, lent(knowns, n_known)?);
            let (seed, sensitivity) = (lent(seed, n_known)?, lent_mut(sensitivity, n_unknown)?);
            instance.directional(unknowns, knowns, seed, sensitivity)
        })
    }
}

/// Inputs are held over a step: only an empty list is accepted.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: *mut c_void,
    _vr: *const u32,
    nvr: usize,
    _order: *const c_int,
    _value: *const f64,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2SetRealInputDerivatives", Modes::ALL, |_| {
            if nvr == 0 { Ok(()) } else { Err(Refusal::Unsupported(NO_DERIVATIVES).into()) }
        })
    }
}

/// Outputs have no derivatives: only an empty list is accepted.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: *mut c_void,
    _vr: *const u32,
    nvr: usize,
    _order: *const c_int,
    _value: *mut f64,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2GetRealOutputDerivatives", Modes::ALL, |_| {
            if nvr == 0 { Ok(()) } else { Err(Refusal::Unsupported(NO_DERIVATIVES).into()) }
        })
    }
}

/// Takes a communication step, a multiple of the internal step.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(c: *mut c_void, point: f64, size: f64, _no_set_prior: c_int) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(c, "fmi2DoStep", Modes::only(Mode::Step), |instance| instance.advance(point, size)) }
}

/// Refused: no step is ever under way between two calls.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { refuse(c, "fmi2CancelStep", "every step has ended when fmi2DoStep returns") }
}

/// Refused: see [`fmi2CancelStep`].
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: *mut c_void, _kind: c_int, _value: *mut c_int) -> c_int {
    // SAFETY: as the module says.
    unsafe { refuse(c, "fmi2GetStatus", NOT_PENDING) }
}

/// Time up to which the instance has stepped.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: *mut c_void, kind: c_int, value: *mut f64) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2GetRealStatus", Modes::ALL, |instance| match kind {
            LAST_SUCCESSFUL_TIME => Ok(give(value, instance.time())?),
            _ => Err(Refusal::Unsupported(NOT_PENDING).into()),
        })
    }
}

/// Refused: see [`fmi2CancelStep`].
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(c: *mut c_void, _kind: c_int, _value: *mut c_int) -> c_int {
    // SAFETY: as the module says.
    unsafe { refuse(c, "fmi2GetIntegerStatus", NOT_PENDING) }
}

/// Request of the instance to end the simulation: never.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: *mut c_void, kind: c_int, value: *mut c_int) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(c, "fmi2GetBooleanStatus", Modes::ALL, |_| match kind {
            TERMINATED => Ok(give(value, 0)?),
            _ => Err(Refusal::Unsupported(NOT_PENDING).into()),
        })
    }
}

/// Refused: see [`fmi2CancelStep`].
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: *mut c_void,
    _kind: c_int,
    _value: *mut *const c_char,
) -> c_int {
    // SAFETY: as the module says.
    unsafe { refuse(c, "fmi2GetStringStatus", NOT_PENDING) }
}
