//! Phases of a simulation, and which calls are allowed in them.

/// Phases of a simulation; one bit each, so that a set of them is a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// Made; values at the start may be set.
    Instantiated = 1,
    /// Between entering and leaving the initialization.
    Initialization = 2,
    /// Stepping.
    Step = 4,
    /// Ended; outputs may still be read.
    Terminated = 8,
    /// Between entering and leaving the configuration.
    Configuration = 16,
    /// Within a step, where the master watches it.
    Intermediate = 32,
}

impl Mode {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Instantiated => "the instance was made and is not initialized",
            Self::Initialization => "the instance is in its initialization",
            Self::Step => "the instance steps",
            Self::Terminated => "the instance has terminated",
            Self::Configuration => "the instance is in its configuration",
            Self::Intermediate => "the instance is within a step",
        }
    }

    /// The mode of a number.
    pub const fn of_number(number: u8) -> Option<Self> {
        match number {
            1 => Some(Self::Instantiated),
            2 => Some(Self::Initialization),
            4 => Some(Self::Step),
            8 => Some(Self::Terminated),
            16 => Some(Self::Configuration),
            _ => None,
        }
    }
}

/// A set of modes.
#[derive(Clone, Copy, Debug)]
pub struct Modes(u8);

impl Modes {
    /// Always, but not within a step.
    pub const ALL: Self = Self(31);
    /// Before the first step.
    pub const START: Self = Self(Mode::Instantiated as u8 | Mode::Initialization as u8);
    /// When inputs and tunable parameters may be set.
    pub const SET: Self = Self(Self::START.0 | Mode::Step as u8);
    /// When derivatives are known.
    pub const DERIVE: Self = Self(Mode::Initialization as u8 | Mode::Step as u8);
    /// When there is something to read.
    pub const GET: Self = Self(Self::DERIVE.0 | Mode::Terminated as u8 | Mode::Intermediate as u8);

    /// One mode.
    #[must_use]
    pub const fn only(mode: Mode) -> Self {
        Self(mode as u8)
    }

    /// True if a mode is one of them.
    pub const fn holds(self, mode: Mode) -> bool {
        self.0 & mode as u8 != 0
    }
}
