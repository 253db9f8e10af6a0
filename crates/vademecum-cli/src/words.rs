//! Numbers with units, as texts for people have them.

/// The factor and the letter of the prefix in which a number has one to three figures before its point.
pub(crate) fn prefix_of(value: f64) -> (f64, &'static str) {
    const PREFIXES: [(f64, &str); 9] = [
        (1e-12, "p"),
        (1e-9, "n"),
        (1e-6, "µ"),
        (1e-3, "m"),
        (1.0, ""),
        (1e3, "k"),
        (1e6, "M"),
        (1e9, "G"),
        (1e12, "T"),
    ];
    *PREFIXES.iter().rev().find(|(factor, _)| value.abs() >= *factor).unwrap_or(&PREFIXES[0])
}

/// A number of a unit with the prefix that suits it, with four figures at most.
pub(crate) fn quantity(value: f64, unit: &str) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value} {unit}");
    }
    let (factor, prefix) = prefix_of(value * (1.0 + 5e-5));
    let scaled = value / factor;
    let digits = match scaled.abs() {
        999.95.. => 0,
        99.995.. => 1,
        9.9995.. => 2,
        _ => 3,
    };
    let text = format!("{scaled:.digits$}");
    let text = if digits > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text} {prefix}{unit}")
}

/// A frequency.
pub(crate) fn hertz(value: f64) -> String {
    quantity(value, "Hz")
}

/// A time, with three figures; none below a picosecond.
pub(crate) fn duration(seconds: f64) -> String {
    if seconds <= 0.0 || seconds >= 1e3 {
        return format!("{seconds:.0} s");
    }
    let unit = 10_f64.powi(seconds.log10().floor() as i32 - 2);
    quantity((seconds / unit).round() * unit, "s")
}

/// A text that begins with a capital letter, unless a symbol stands there.
pub(crate) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) if first.is_ascii_lowercase() => {
            first.to_ascii_uppercase().to_string() + letters.as_str()
        }
        _ => text.into(),
    }
}

/// A number of bytes.
pub(crate) fn bytes(length: usize) -> String {
    match length {
        0..10_000 => format!("{length} bytes"),
        10_000..1_000_000 => format!("{:.1} kB", length as f64 / 1e3),
        _ => format!("{:.1} MB", length as f64 / 1e6),
    }
}

/// A share in percent, with two figures.
pub(crate) fn percent(share: f64) -> String {
    let text = format!("{:.1e}", 100.0 * share);
    match text.parse::<f64>() {
        Ok(percent) if percent == 0.0 || percent >= 1e-3 => format!("{percent} %"),
        _ => format!("{text} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_prefix_that_suits_them() {
        assert_eq!([440.0023, 0.0764, 12_345.6, 0.0].map(hertz), ["440 Hz", "76.4 mHz", "12.35 kHz", "0 Hz"]);
        assert_eq!(quantity(999.99, "m"), "1 km");
        assert_eq!(
            [2.0, 0.0581, 1e-3, 2.041e-7, 3.3e-10, 0.0, 4321.0].map(duration),
            ["2 s", "58.1 ms", "1 ms", "204 ns", "330 ps", "0 s", "4321 s"]
        );
        assert_eq!([9_999, 10_000, 1_234_567].map(bytes), ["9999 bytes", "10.0 kB", "1.2 MB"]);
        assert_eq!(["error bound", "σ"].map(sentence), ["Error bound", "σ"]);
        assert_eq!(
            [4.6e-4, 1.1e-2, 0.52, 1e-7, 0.0].map(percent),
            ["0.046 %", "1.1 %", "52 %", "1.0e-5 %", "0 %"]
        );
    }
}
