//! The entry points of FMI 3.0, under the names of the standard. Those for co-simulation work; the others are
//! there, as the standard wants it, and are refused by name.
//!
//! # Safety
//! An instance is one of [`fmi3InstantiateCoSimulation`] that was not freed, used by one thread at a time;
//! states are those of [`fmi3GetFMUState`] or [`fmi3DeserializeFMUState`] that were not freed, nor was the
//! instance they were taken from, which frees those that are left; arrays are as
//! long as the number beside them says; texts end with a zero. Null is refused.
#![allow(unsafe_code, non_snake_case)]

use core::ffi::{CStr, c_char, c_int, c_void};

use crate::boundary::{
    deserialize, free_state, get_state, give, guard, lent, lent_mut, refuse, serialize, set_state, text, with,
};
use crate::instance::{Given, Instance};
use crate::location::Location;
use crate::logger::{Callback, Callback3, Category, Logger, status};
use crate::mode::{Mode, Modes};
use crate::refusal::{Refusal, Trouble};
use crate::watch::{IntermediateUpdate, Watch};

/// `bool` of C; any other byte than 0 is true.
type Bool = u8;

/// Refusal of values other than numbers.
const FLOAT64_ONLY: &str = "all variables are of type Float64, but for the structural parameter";
/// Refusal of clocks.
const NO_CLOCKS: &str = "this FMU has no clocks";
/// Refusal of events.
const NO_EVENTS: &str = "this FMU has no events (hasEventMode = false)";
/// Refusal of continuous states and their derivatives.
const CO_SIMULATION_ONLY: &str = "this FMU is for co-simulation";
/// Refusal of derivatives in time.
const NO_DERIVATIVES: &str = "outputs have no derivatives in time (maxOutputDerivativeOrder = 0)";
/// Refusal of dependencies by element.
const NO_ELEMENTS: &str =
    "dependencies are those of the model description (providesPerElementDependencies = false)";

/// Version of the interface.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Asks for more than refusals in the log, or no longer.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    i: *mut c_void,
    logging_on: Bool,
    n_categories: usize,
    categories: *const *const c_char,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3SetDebugLogging", Modes::ALL, |instance| {
            let categories = lent(categories, n_categories)?;
            instance.set_logging(logging_on != 0, categories.iter().map(|&category| text(category)))
        })
    }
}

/// Makes an instance; null if that is refused, which the log tells.
///
/// # Safety
/// As the module says; the log may be called for as long as the instance lives.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instance_name: *const c_char,
    token: *const c_char,
    resource_path: *const c_char,
    _visible: Bool,
    logging_on: Bool,
    event_mode_used: Bool,
    early_return_allowed: Bool,
    intermediate_variables: *const u32,
    n_intermediate_variables: usize,
    environment: *mut c_void,
    log_message: Option<Callback3>,
    intermediate_update: Option<IntermediateUpdate>,
) -> *mut c_void {
    // SAFETY: as the module says.
    let (name, token, folder) = unsafe { (text(instance_name), text(token), text(resource_path)) };
    // SAFETY: as the caller promises.
    let logger = unsafe { Logger::new(Callback::Three(log_message), environment) };
    let refused = |why: &str| {
        logger.tell(c"", Category::Error, &[&"fmi3InstantiateCoSimulation: ", &why]);
        core::ptr::null_mut()
    };
    guard(core::ptr::null_mut(), || {
        let Some(name) = name.filter(|name: &&CStr| !name.is_empty()) else {
            return refused("an instance needs a name");
        };
        let Some(token) = token else { return refused("the instantiation token is missing") };
        let Some(folder) = folder else { return refused("the path of the resources is missing") };
        if event_mode_used != 0 {
            return refused(NO_EVENTS);
        }
        // SAFETY: as the module says.
        let watched = unsafe { lent(intermediate_variables, n_intermediate_variables) };
        let Ok(watched) = watched else { return refused("the intermediate variables are missing") };
        let (update, early_return) = (intermediate_update, early_return_allowed != 0);
        let watch = Watch { update, environment, early_return };
        let resources = Location::Folder(folder.to_bytes());
        let (token, logging) = (token.to_bytes(), logging_on != 0);
        let given = Given { name, token, resources, logging, watch, watched };
        Instance::make(&given, logger).map_or(core::ptr::null_mut(), |at| at.as_ptr().cast())
    })
}

/// Functions that make instances of other kinds: refused.
macro_rules! other_kinds {
    ($($name:ident($($rest:ty),*);)*) => {$(
        /// Refused: this FMU is for co-simulation.
        ///
        /// # Safety
        /// As the module says.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            _name: *const c_char,
            _token: *const c_char,
            _resources: *const c_char,
            _visible: Bool,
            _logging_on: Bool,
            environment: *mut c_void,
            log_message: Option<Callback3>,
            $(_: $rest),*
        ) -> *mut c_void {
            // SAFETY: as the caller promises.
            let logger = unsafe { Logger::new(Callback::Three(log_message), environment) };
            logger.tell(c"", Category::Error, &[&stringify!($name), &": ", &CO_SIMULATION_ONLY]);
            core::ptr::null_mut()
        }
    )*};
}

other_kinds! {
    fmi3InstantiateModelExchange();
    fmi3InstantiateScheduledExecution(*const c_void, *const c_void, *const c_void);
}

/// Frees an instance; null is free already.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(i: *mut c_void) {
    if let Some(instance) = core::ptr::NonNull::new(i.cast::<Instance>()) {
        // SAFETY: as the module says.
        guard((), || unsafe { Instance::free(instance) });
    }
}

/// Begins the initialization, and tells when the experiment starts and stops.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    i: *mut c_void,
    _tolerance_defined: Bool,
    _tolerance: f64,
    start: f64,
    stop_defined: Bool,
    stop: f64,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3EnterInitializationMode", Modes::only(Mode::Instantiated), |instance| {
            instance.set_up(start, (stop_defined != 0).then_some(stop))?;
            instance.begin()
        })
    }
}

/// Ends the initialization.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(i: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3ExitInitializationMode", Modes::only(Mode::Initialization), |instance| {
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
pub unsafe extern "C" fn fmi3Terminate(i: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3Terminate", Modes::only(Mode::Step), |instance| {
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
pub unsafe extern "C" fn fmi3Reset(i: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(i, "fmi3Reset", Modes::ALL, Instance::reset) }
}

/// Values of variables.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    i: *mut c_void,
    vr: *const u32,
    nvr: usize,
    values: *mut f64,
    n: usize,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3GetFloat64", Modes::GET, |instance| instance.get(lent(vr, nvr)?, lent_mut(values, n)?))
    }
}

/// Sets inputs and tunable parameters, all or none.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    i: *mut c_void,
    vr: *const u32,
    nvr: usize,
    values: *const f64,
    n: usize,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3SetFloat64", Modes::SET, |instance| instance.set(lent(vr, nvr)?, lent(values, n)?))
    }
}

/// Values of the structural parameter.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetUInt64(
    i: *mut c_void,
    vr: *const u32,
    nvr: usize,
    values: *mut u64,
    n: usize,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3GetUInt64", Modes::ALL, |instance| {
            instance.get_counts(lent(vr, nvr)?, lent_mut(values, n)?)
        })
    }
}

/// Sets the structural parameter.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetUInt64(
    i: *mut c_void,
    vr: *const u32,
    nvr: usize,
    values: *const u64,
    n: usize,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3SetUInt64", Modes::only(Mode::Configuration), |instance| {
            instance.set_counts(lent(vr, nvr)?, lent(values, n)?)
        })
    }
}

/// Goes to the configuration, in which the structural parameter is set.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterConfigurationMode(i: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(i, "fmi3EnterConfigurationMode", Modes::only(Mode::Instantiated), Instance::configure) }
}

/// Ends the configuration.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitConfigurationMode(i: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3ExitConfigurationMode", Modes::only(Mode::Configuration), |instance| {
            instance.go(Mode::Instantiated);
            Ok(())
        })
    }
}

fn nothing_of(nvr: usize, why: &'static str) -> Result<(), Trouble> {
    if nvr == 0 { Ok(()) } else { Err(Refusal::Unsupported(why).into()) }
}

/// Functions for values of other types, of which there are none.
macro_rules! other_types {
    ($why:ident: $($name:ident($($rest:ty),*);)*) => {$(
        /// There are no variables of this type: only an empty list is accepted.
        ///
        /// # Safety
        /// As the module says.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(i: *mut c_void, _vr: *const u32, nvr: usize, $(_: $rest),*) -> c_int {
            // SAFETY: as the module says.
            unsafe { with(i, stringify!($name), Modes::ALL, |_| nothing_of(nvr, $why)) }
        }
    )*};
}

other_types! { FLOAT64_ONLY:
    fmi3GetFloat32(*mut f32, usize);
    fmi3GetInt8(*mut i8, usize);
    fmi3GetUInt8(*mut u8, usize);
    fmi3GetInt16(*mut i16, usize);
    fmi3GetUInt16(*mut u16, usize);
    fmi3GetInt32(*mut i32, usize);
    fmi3GetUInt32(*mut u32, usize);
    fmi3GetInt64(*mut i64, usize);
    fmi3GetBoolean(*mut Bool, usize);
    fmi3GetString(*mut *const c_char, usize);
    fmi3GetBinary(*mut usize, *mut *const u8, usize);
    fmi3SetFloat32(*const f32, usize);
    fmi3SetInt8(*const i8, usize);
    fmi3SetUInt8(*const u8, usize);
    fmi3SetInt16(*const i16, usize);
    fmi3SetUInt16(*const u16, usize);
    fmi3SetInt32(*const i32, usize);
    fmi3SetUInt32(*const u32, usize);
    fmi3SetInt64(*const i64, usize);
    fmi3SetBoolean(*const Bool, usize);
    fmi3SetString(*const *const c_char, usize);
    fmi3SetBinary(*const usize, *const *const u8, usize);
}

other_types! { NO_CLOCKS:
    fmi3GetClock(*mut Bool);
    fmi3SetClock(*const Bool);
    fmi3GetIntervalDecimal(*mut f64, *mut c_int);
    fmi3GetIntervalFraction(*mut u64, *mut u64, *mut c_int);
    fmi3GetShiftDecimal(*mut f64);
    fmi3GetShiftFraction(*mut u64, *mut u64);
    fmi3SetIntervalDecimal(*const f64);
    fmi3SetIntervalFraction(*const u64, *const u64);
    fmi3SetShiftDecimal(*const f64);
    fmi3SetShiftFraction(*const u64, *const u64);
}

other_types! { NO_DERIVATIVES:
    fmi3GetOutputDerivatives(*const i32, *mut f64, usize);
}

/// Functions for what this FMU does not do.
macro_rules! refused {
    ($($name:ident, $why:expr, ($($rest:ty),*);)*) => {$(
        /// Refused by name.
        ///
        /// # Safety
        /// As the module says.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(i: *mut c_void, $(_: $rest),*) -> c_int {
            // SAFETY: as the module says.
            unsafe { refuse(i, stringify!($name), $why) }
        }
    )*};
}

refused! {
    fmi3EnterEventMode, NO_EVENTS, ();
    fmi3EnterStepMode, NO_EVENTS, ();
    fmi3EvaluateDiscreteStates, NO_EVENTS, ();
    fmi3UpdateDiscreteStates, NO_EVENTS, (*mut Bool, *mut Bool, *mut Bool, *mut Bool, *mut Bool, *mut f64);
    fmi3GetNumberOfVariableDependencies, NO_ELEMENTS, (u32, *mut usize);
    fmi3GetVariableDependencies, NO_ELEMENTS, (u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize);
    fmi3EnterContinuousTimeMode, CO_SIMULATION_ONLY, ();
    fmi3CompletedIntegratorStep, CO_SIMULATION_ONLY, (Bool, *mut Bool, *mut Bool);
    fmi3SetTime, CO_SIMULATION_ONLY, (f64);
    fmi3SetContinuousStates, CO_SIMULATION_ONLY, (*const f64, usize);
    fmi3GetContinuousStateDerivatives, CO_SIMULATION_ONLY, (*mut f64, usize);
    fmi3GetEventIndicators, CO_SIMULATION_ONLY, (*mut f64, usize);
    fmi3GetContinuousStates, CO_SIMULATION_ONLY, (*mut f64, usize);
    fmi3GetNominalsOfContinuousStates, CO_SIMULATION_ONLY, (*mut f64, usize);
    fmi3GetNumberOfEventIndicators, CO_SIMULATION_ONLY, (*mut usize);
    fmi3GetNumberOfContinuousStates, CO_SIMULATION_ONLY, (*mut usize);
    fmi3ActivateModelPartition, CO_SIMULATION_ONLY, (u32, f64);
}

/// Derivatives, whose seeds and sensitivities are as many as their variables have values.
macro_rules! derivatives {
    ($($name:ident, $of:ident;)*) => {$(
        /// Derivatives of outputs with respect to inputs, which the last step held.
        ///
        /// # Safety
        /// As the module says.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            i: *mut c_void,
            unknowns: *const u32,
            n_unknowns: usize,
            knowns: *const u32,
            n_knowns: usize,
            seed: *const f64,
            n_seed: usize,
            sensitivity: *mut f64,
            n_sensitivity: usize,
        ) -> c_int {
            // SAFETY: as the module says.
            unsafe {
                with(i, stringify!($name), Modes::DERIVE, |instance| {
                    let (unknowns, knowns) = (lent(unknowns, n_unknowns)?, lent(knowns, n_knowns)?);
                    let (seed, sensitivity) = (lent(seed, n_seed)?, lent_mut(sensitivity, n_sensitivity)?);
                    instance.$of(unknowns, knowns, seed, sensitivity)
                })
            }
        }
    )*};
}

derivatives! {
    fmi3GetDirectionalDerivative, directional;
    fmi3GetAdjointDerivative, adjoint;
}

/// Saves everything that can change.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(i: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(i, "fmi3GetFMUState", Modes::ALL, |instance| get_state(instance, state)) }
}

/// Takes back what was saved.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(i: *mut c_void, state: *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(i, "fmi3SetFMUState", Modes::ALL, |instance| set_state(instance, state)) }
}

/// Frees a state.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(i: *mut c_void, state: *mut *mut c_void) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(i, "fmi3FreeFMUState", Modes::ALL, |_| free_state(state)) }
}

/// Bytes of a serialized state.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    i: *mut c_void,
    _state: *mut c_void,
    size: *mut usize,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3SerializedFMUStateSize", Modes::ALL, |instance| Ok(give(size, instance.saved_len())?))
    }
}

/// Copies a state to bytes.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    i: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> c_int {
    // SAFETY: as the module says.
    unsafe { with(i, "fmi3SerializeFMUState", Modes::ALL, |_| serialize(state, bytes, size)) }
}

/// Makes a state of bytes.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    i: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> c_int {
    // SAFETY: as the module says.
    unsafe {
        with(i, "fmi3DeserializeFMUState", Modes::ALL, |instance| deserialize(instance, bytes, size, state))
    }
}

/// Takes a communication step. A master that gave a callback hears of each internal step, and may end the
/// communication step there. Where it allows early return, a body that bends far ends the step itself as it
/// leaves its training.
///
/// # Safety
/// As the module says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    i: *mut c_void,
    point: f64,
    size: f64,
    _no_set_prior: Bool,
    event_handling_needed: *mut Bool,
    terminate_simulation: *mut Bool,
    early_return: *mut Bool,
    last_successful_time: *mut f64,
) -> c_int {
    let (mut watch, mut course) = (Watch::NONE, None);
    // SAFETY: as the module says.
    let status = unsafe {
        with(i, "fmi3DoStep", Modes::only(Mode::Step), |instance| {
            for flag in [event_handling_needed, terminate_simulation, early_return] {
                give(flag, 0)?;
            }
            give(last_successful_time, instance.time())?;
            watch = instance.watch();
            course = instance.depart(point, size)?;
            if course.is_none() {
                instance.advance(point, size)?;
            }
            Ok(give(last_successful_time, instance.time())?)
        })
    };
    let Some(mut course) = course else { return status };
    loop {
        // SAFETY: as the module says.
        let status = unsafe {
            with(i, "fmi3DoStep", Modes::only(Mode::Intermediate), |instance| {
                // A step that is refused takes the instance back to the communication point.
                let taken = instance.proceed(&mut course);
                give(last_successful_time, instance.time())?;
                taken
            })
        };
        if status != status::OK {
            return status;
        }
        let ends = course.is_done();
        // SAFETY: as the module says; the instance is not borrowed.
        if let Some(time) = unsafe { watch.tell(course.time(), ends) } {
            course.end_at(time);
        }
        let is_early = course.ends_here();
        if ends || is_early {
            // SAFETY: as the module says.
            return unsafe {
                with(i, "fmi3DoStep", Modes::only(Mode::Intermediate), |instance| {
                    instance.go(Mode::Step);
                    Ok(give(early_return, Bool::from(is_early))?)
                })
            };
        }
    }
}
