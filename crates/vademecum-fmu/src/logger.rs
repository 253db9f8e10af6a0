//! Sentences for the log of the master.
#![allow(unsafe_code)]

use core::ffi::{CStr, c_char, c_int, c_void};

use crate::words::{Say, Words};

/// `fmi2CallbackLogger`.
pub type Callback2 = unsafe extern "C" fn(
    environment: *mut c_void,
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
    ...
);

/// `fmi3LogMessageCallback`.
pub type Callback3 = unsafe extern "C" fn(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
);

/// The callback of the master.
#[derive(Clone, Copy, Debug)]
pub enum Callback {
    /// A master of FMI 2.
    Two(Option<Callback2>),
    /// A master of FMI 3.
    Three(Option<Callback3>),
}

/// Statuses that both versions number alike.
pub mod status {
    use core::ffi::c_int;

    /// Done.
    pub const OK: c_int = 0;
    /// Refused.
    pub const ERROR: c_int = 3;
}

/// Category of a message, as a model description names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// A refusal. Those are always told.
    Error,
    /// Anything else. Those are logged if the master asks for them.
    Event,
}

impl Category {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Error, Self::Event];

    /// Its name in the model description.
    #[must_use]
    pub const fn name(self) -> &'static CStr {
        match self {
            Self::Error => c"logStatusError",
            Self::Event => c"logEvents",
        }
    }
}

/// The log of a master.
#[derive(Clone, Copy, Debug)]
pub struct Logger {
    callback: Callback,
    environment: *mut c_void,
}

impl Logger {
    /// A log behind a callback.
    ///
    /// # Safety
    /// The callback may be called with `environment` for as long as the logger is used.
    #[must_use]
    pub const unsafe fn new(callback: Callback, environment: *mut c_void) -> Self {
        Self { callback, environment }
    }

    /// Writes a sentence. `instance` is its name.
    pub fn tell(&self, instance: &CStr, category: Category, text: &[&dyn Say]) {
        let mut words = Words::default();
        text.iter().for_each(|part| part.say(&mut words));
        let status = if category == Category::Error { status::ERROR } else { status::OK };
        let (category, message) = (category.name().as_ptr(), words.as_ptr());
        match self.callback {
            Callback::Two(Some(callback)) => {
                // The message is a format: a percent sign in a name is doubled, so that it means itself. (A
                // `%s` with the message behind it would be lost on masters that look at no more arguments.)
                let format = words.as_format();
                // SAFETY: as the maker of the logger promised; the format asks for no more arguments.
                unsafe { callback(self.environment, instance.as_ptr(), status, category, format.as_ptr()) };
            }
            // SAFETY: the same.
            Callback::Three(Some(callback)) => unsafe {
                callback(self.environment, status, category, message);
            },
            Callback::Two(None) | Callback::Three(None) => {}
        }
    }
}
