//! Outputs of a state-space model, as they are written.

use std::fmt;
use std::str::FromStr;

use crate::frf::{Channel, Quantity};

/// Components of a stress, in the order of a tensor.
pub(super) const COMPONENTS: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "zx"];

/// Parts of a reaction, as columns of a run are named.
pub(super) const PARTS: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// An output of a state-space model. A text is
/// `CHANNEL`, `velocity:CHANNEL`, `acceleration:CHANNEL`, `stress:X,Y,Z,COMPONENT`, `reaction:SUPPORT` or
/// `reaction:SUPPORT.PART`.
#[derive(Clone, Debug, PartialEq)]
pub enum OutputSignal {
    /// Displacement, velocity or acceleration of a channel.
    Motion(Quantity, Channel),
    /// Component of the stress at the nearest node \[m\] that has one.
    Stress([f64; 3], usize),
    /// Force and moment of a support.
    Reaction(String),
}

impl FromStr for OutputSignal {
    type Err = SignalError;

    fn from_str(text: &str) -> Result<Self, SignalError> {
        let wrong = || SignalError(text.into());
        let motion = |quantity, channel: &str| {
            channel.parse().map(|channel| Self::Motion(quantity, channel)).map_err(|_| wrong())
        };
        match text.split_once(':') {
            Some(("displacement", channel)) => motion(Quantity::Displacement, channel),
            Some(("velocity", channel)) => motion(Quantity::Velocity, channel),
            Some(("acceleration", channel)) => motion(Quantity::Acceleration, channel),
            Some(("stress", place)) => stress(place).ok_or_else(wrong),
            Some(("reaction", support)) if !support.is_empty() => Ok(Self::Reaction(support.into())),
            Some(("reaction", _)) => Err(wrong()),
            _ => motion(Quantity::Displacement, text),
        }
    }
}

/// `X,Y,Z,COMPONENT`.
fn stress(text: &str) -> Option<OutputSignal> {
    let (place, component) = text.rsplit_once(',')?;
    let component = COMPONENTS.iter().position(|known| *known == component.trim())?;
    let numbers: Option<Vec<f64>> = place.split(',').map(|part| part.trim().parse().ok()).collect();
    match *numbers? {
        [x, y, z] if [x, y, z].iter().all(|number: &f64| number.is_finite()) => {
            Some(OutputSignal::Stress([x, y, z], component))
        }
        _ => None,
    }
}

impl fmt::Display for OutputSignal {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Motion(Quantity::Displacement, channel) => channel.fmt(out),
            Self::Motion(Quantity::Velocity, channel) => write!(out, "velocity:{channel}"),
            Self::Motion(Quantity::Acceleration, channel) => write!(out, "acceleration:{channel}"),
            Self::Stress([x, y, z], component) => {
                write!(out, "stress:({x} {y} {z}).{}", COMPONENTS[*component])
            }
            Self::Reaction(support) => write!(out, "reaction:{support}"),
        }
    }
}

/// A text that is no output.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "`{0}` is no output; write a channel such as tip or 1,0.04,0.1,-z, `velocity:` or `acceleration:` and a channel, \
     stress:0,0.04,0.1,xx, reaction:SUPPORT or reaction:SUPPORT.fx"
)]
pub struct SignalError(String);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_read_and_named() {
        let named = |text: &str| text.parse::<OutputSignal>().map(|signal| signal.to_string());
        for (text, name) in [
            ("tip", "tip"),
            ("displacement:tip", "tip"),
            ("velocity:1,0.04,0.1,-z", "velocity:(1 0.04 0.1) along (0 0 -1)"),
            ("acceleration:tip", "acceleration:tip"),
            ("stress:0, 0.04,0.1,xx", "stress:(0 0.04 0.1).xx"),
            ("reaction:foot", "reaction:foot"),
            ("reaction:foot.fx", "reaction:foot.fx"),
            // No quantity of this name: a probe whose name holds the sign.
            ("a:b", "a:b"),
        ] {
            assert_eq!(named(text).as_deref(), Ok(name), "{text}");
        }
        for text in [
            "",
            "velocity:",
            "velocity:1,2",
            "stress:1,2,xx",
            "stress:1,2,inf,xx",
            "stress:1,2,3,x",
            "reaction:",
        ] {
            assert_eq!(named(text), Err(SignalError(text.into())), "{text}");
        }
    }
}
