//! Values of a scenario that cannot be.

use vademecum_build::dynamics::Interval;
use vademecum_build::input::toml_file::{self, TomlError};

use super::ScenarioError;
use super::courses::TimeCourse;
use super::entries::Total;
use super::entries::{
    ChirpEntry, ContactEntry, FreeEntry, OutputPlan, OutputProbe, PatternUse, Scenario, SinusoidEntry,
    StressEntry,
};
use super::tables::LARGEST;

/// Most contacts, and most load patterns, of a scenario. Each contact is looked for on the whole surface,
/// which takes a fraction of a millisecond.
pub(crate) const MAX_LOADS: usize = 100_000;

/// Most probes of a scenario: each of them is a column of the table.
const MAX_PROBES: usize = 10_000;

/// Highest frequency \[Hz\] and largest phase \[rad\] and mean of a sinusoid: beyond, none of its digits is
/// left after the first periods. Also the largest velocity, angular velocity and gravity of a free body.
const FASTEST: f64 = 1e9;

impl Scenario {
    pub(super) fn check(&self, path: &str, text: &str) -> Result<(), ScenarioError> {
        // Where a key stands is looked for once, in the end: the whole text is read again for it.
        self.fault().map_or(Ok(()), |Fault { key, found, expected }| {
            let path = toml_file::place(path, text, &key);
            Err(TomlError::Impossible { path, key, found, expected: expected.into() }.into())
        })
    }

    /// The first value that cannot be.
    fn fault(&self) -> Option<Fault> {
        let fault = |key: &str, found: String, expected| Some(Fault { key: key.into(), found, expected });
        if !(self.duration > 0.0 && self.duration.is_finite()) {
            return fault("duration", self.duration.to_string(), "a positive time in seconds");
        }
        if self.output.probes_every == 0 {
            return fault("output.probes_every", "0".into(), "at least 1");
        }
        let totals = &self.output.quantities;
        if let Some(Total(twice)) = (1..totals.len())
            .map(|i| totals[i])
            .find(|&total| totals.iter().filter(|other| **other == total).count() > 1)
        {
            return fault("output.quantities", format!("`{}` twice", twice.name()), "each of them once");
        }
        for (key, count) in [("contact", self.contacts.len()), ("pattern", self.patterns.len())] {
            if count > MAX_LOADS {
                return fault(key, format!("a list of {count}"), "at most 100 000 of them");
            }
        }
        if let Some(FreeEntry { velocity, spin, gravity }) = self.free {
            for (key, vector) in [("free.velocity", velocity), ("free.spin", spin), ("free.gravity", gravity)]
            {
                if !vector.iter().all(|x| x.abs() <= FASTEST) {
                    return fault(key, numbers(&vector), "finite numbers of at most 1e9 in size");
                }
            }
        }
        let probes = &self.output.probes;
        let stresses = &self.output.stresses;
        for (key, count) in [("output.probe", probes.len()), ("output.stress", stresses.len())] {
            if count > MAX_PROBES {
                return fault(key, format!("a list of {count}"), "at most 10 000 of them");
            }
        }
        if let Some(base) = self
            .base
            .as_ref()
            .filter(|base| base.amplitude.abs().min(f64::MAX) > LARGEST || base.amplitude.is_nan())
        {
            return fault(
                "base.amplitude",
                base.amplitude.to_string(),
                "a finite number of at most 1e75 in size",
            );
        }
        let contacts = self.contacts.iter().enumerate();
        let patterns = self.patterns.iter().enumerate();
        contacts
            .map(|(i, contact)| contact.fault(i))
            .chain(patterns.map(|(i, pattern)| pattern.fault(i)))
            .chain((0..probes.len()).map(|i| probe_fault(probes, i)))
            .chain((0..stresses.len()).map(|i| self.output.stress_fault(i)))
            .find_map(|fault| fault)
    }
}

/// A value that cannot be.
struct Fault {
    key: String,
    found: String,
    expected: &'static str,
}

impl ContactEntry {
    fn fault(&self, index: usize) -> Option<Fault> {
        let at = || format!("contact[{index}]");
        for (name, vector) in [("point", self.point), ("force", self.force)] {
            let Some(vector) = vector.filter(|vector| !vector.iter().all(|v| v.abs() <= LARGEST)) else {
                continue;
            };
            let expected = "finite numbers of at most 1e75 in size, whose squares are finite too";
            return Some(Fault { key: format!("{}.{name}", at()), found: numbers(&vector), expected });
        }
        if self.point.is_some() == self.path.is_some() {
            let found = if self.point.is_some() { "`point` beside `path`" } else { "without a place" };
            let expected = "`point` or `path`, one of them";
            return Some(Fault { key: at(), found: found.into(), expected });
        }
        if self.force.is_none() && self.table.is_none() {
            let expected = "`force`, or a `table` of `time,fx,fy,fz`";
            return Some(Fault { key: at(), found: "without a force".into(), expected });
        }
        self.varying().fault(&at)
    }
}

/// The first value of a probe that cannot be.
fn probe_fault(probes: &[OutputProbe], index: usize) -> Option<Fault> {
    let OutputProbe { name, point, direction, .. } = &probes[index];
    let fault = |key: &str, found, expected| {
        Some(Fault { key: format!("output.probe[{index}].{key}"), found, expected })
    };
    let twice = probes[..index].iter().any(|other| other.name == *name);
    if name.is_empty() || name.contains(['\n', ',', '"']) || twice {
        return fault("name", format!("{name:?}"), "a name of one line that no other probe has");
    }
    if !point.iter().all(|x| x.abs() <= LARGEST) {
        return fault("point", numbers(point), "finite numbers of at most 1e75 in size");
    }
    let length: f64 = direction.iter().map(|x| x * x).sum();
    if !(length > 0.0 && length.is_finite()) {
        return fault("direction", numbers(direction), "a vector of some length");
    }
    None
}

impl OutputPlan {
    fn stress_fault(&self, index: usize) -> Option<Fault> {
        let StressEntry { name, point, .. } = &self.stresses[index];
        let fault = |key: &str, found, expected| {
            Some(Fault { key: format!("output.stress[{index}].{key}"), found, expected })
        };
        let probes = self.probes.iter().map(|probe| &probe.name);
        let mut others = probes.chain(self.stresses[..index].iter().map(|stress| &stress.name));
        if name.is_empty() || name.contains(['\n', ',', '"']) || others.any(|other| other == name) {
            return fault(
                "name",
                format!("{name:?}"),
                "a name of one line that no other probe or stress has",
            );
        }
        if !point.iter().all(|x| x.abs() <= LARGEST) {
            return fault("point", numbers(point), "finite numbers of at most 1e75 in size");
        }
        None
    }
}

impl PatternUse {
    fn fault(&self, index: usize) -> Option<Fault> {
        let at = || format!("pattern[{index}]");
        if self.amplitude.abs() <= LARGEST {
            return self.varying().fault(&at);
        }
        let expected = "a finite number of at most 1e75 in size, whose square is finite too";
        Some(Fault { key: format!("{}.amplitude", at()), found: self.amplitude.to_string(), expected })
    }
}

fn interval_fault(key: &dyn Fn() -> String, when: Interval) -> Option<Fault> {
    let Interval { start, end, ramp } = when;
    if start >= 0.0 && end > start && ramp >= 0.0 && ramp.is_finite() {
        return None;
    }
    let found = format!("start {}, end {}, ramp {}", time(start), time(end), time(ramp));
    Some(Fault { key: key(), found, expected: "0 ≤ start < end and a finite ramp ≥ 0" })
}

/// Numbers as a scenario has them.
fn numbers(vector: &[f64]) -> String {
    let numbers: Vec<String> = vector.iter().map(|&x| time(x)).collect();
    format!("[{}]", numbers.join(", "))
}

/// A number in as few digits as tell it; very large and very small ones with an exponent.
fn time(x: f64) -> String {
    let plain = x == 0.0 || !x.is_finite() || (1e-4..1e16).contains(&x.abs());
    if plain { x.to_string() } else { format!("{x:e}") }
}

impl TimeCourse<'_> {
    /// The first value that cannot be; `key` is that of the load.
    fn fault(&self, key: &dyn Fn() -> String) -> Option<Fault> {
        let Interval { ramp, .. } = self.when;
        if let Some(fault) = interval_fault(key, self.when) {
            return Some(fault);
        }
        let fault = |name: &str, found: String, expected| {
            let key = if name.is_empty() { key() } else { format!("{}.{name}", key()) };
            Some(Fault { key, found, expected })
        };
        let kinds =
            [("table", self.table), ("sinusoid", self.sinusoid.is_some()), ("chirp", self.chirp.is_some())];
        let named: Vec<String> =
            kinds.iter().filter(|kind| kind.1).map(|kind| format!("`{}`", kind.0)).collect();
        if named.len() > 1 {
            return fault("", named.join(" beside "), "at most one of `table`, `sinusoid` and `chirp`");
        }
        if self.table && ramp > 0.0 {
            return fault("ramp", time(ramp), "none beside `table`, whose rows say how the load rises");
        }
        const FREQUENCY: &str = "a frequency from 0 to 1e9 Hz";
        const SMALL: &str = "a finite number of at most 1e9 in size";
        let frequency = |f: f64| (0.0..=FASTEST).contains(&f);
        let small = |x: f64| x.abs() <= FASTEST;
        if let Some(SinusoidEntry { frequency: f, phase, mean }) = self.sinusoid {
            if !frequency(f) {
                return fault("sinusoid.frequency", time(f), FREQUENCY);
            }
            for (name, value) in [("sinusoid.phase", phase), ("sinusoid.mean", mean)] {
                if !small(value) {
                    return fault(name, time(value), SMALL);
                }
            }
        }
        if let Some(ChirpEntry { from, to, phase }) = self.chirp {
            for (name, value) in [("chirp.from", from), ("chirp.to", to)] {
                if !frequency(value) {
                    return fault(name, time(value), FREQUENCY);
                }
            }
            if !small(phase) {
                return fault("chirp.phase", time(phase), SMALL);
            }
        }
        None
    }
}
