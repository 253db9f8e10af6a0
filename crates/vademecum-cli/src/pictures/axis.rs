//! An axis: where a value is on it, and its numbers, all in one style.

/// Least and largest value of an axis, and its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// The least value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
    /// True of a logarithmic axis, whose values are positive.
    pub log: bool,
}

/// The numbers of an axis.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Ticks {
    /// Values, and their numbers.
    pub(crate) named: Vec<(f64, String)>,
    /// Values between them that have a mark alone.
    pub(crate) minor: Vec<f64>,
    /// The power of ten that all numbers are to be multiplied with, such as `×10⁻³`; empty without one.
    pub(crate) factor: String,
}

impl Axis {
    /// Where a value is: 0 at the least, 1 at the largest one.
    pub(crate) fn place(&self, value: f64) -> f64 {
        if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// Numbers of which about `most` have room.
    pub(crate) fn ticks(&self, most: f64) -> Ticks {
        if self.log { self.logarithmic() } else { self.linear(most) }
    }

    fn linear(&self, most: f64) -> Ticks {
        let step = round_step((self.high - self.low) / most);
        let slack = 1e-9 * step;
        let first = ((self.low - slack) / step).ceil();
        let count = ((self.high + slack) / step).floor() - first;
        let values: Vec<f64> =
            (0..=count.clamp(0.0, 100.0) as usize).map(|i| (first + i as f64) * step).collect();
        let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let plain = largest == 0.0 || (1e-2..1e5).contains(&largest);
        // Powers of a thousand, which are read as the prefix of a unit.
        let power = if plain { 0 } else { 3 * (largest.log10() / 3.0).floor() as i32 };
        let scale = 10_f64.powi(-power);
        let decimals = (-((step * scale).log10() + 1e-9).floor()).clamp(0.0, 17.0) as usize;
        let label = |value: f64| signed(&format!("{:.decimals$}", value * scale));
        Ticks {
            named: values.into_iter().map(|value| (value, label(value))).collect(),
            minor: vec![],
            factor: if power == 0 { String::new() } else { format!("×10{}", raised(power)) },
        }
    }

    fn logarithmic(&self) -> Ticks {
        let values = round_numbers(self.low, self.high);
        let [Some(&first), Some(&last)] = [values.first(), values.last()] else {
            return Ticks::default();
        };
        let plain = first >= 1e-2 && last < 1e5;
        let label = |&value: &f64| (value, if plain { number(value) } else { power_of_ten(value) });
        let minor = |power: i32| (2..10).map(move |digit| f64::from(digit) * 10_f64.powi(power));
        let (low, high) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let decades = high - low <= 11 && self.high / self.low > 1e3;
        let between = (low..high).filter(|_| decades).flat_map(minor);
        Ticks {
            named: values.iter().map(label).collect(),
            minor: between.filter(|value| (self.low..=self.high).contains(value)).collect(),
            factor: String::new(),
        }
    }
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least `least`.
fn round_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0];
    let fits = steps.into_iter().find(|step| step * power >= least * (1.0 - 1e-9));
    fits.unwrap_or(10.0) * power
}

/// Numbers for a logarithmic axis: 1, 2 and 5 of each decade while that is not too many, powers of ten
/// beyond.
fn round_numbers(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let steps: &[f64] = match (high / low).log10() {
        ..=0.8 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
        ..=3.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let stride = 1 + (last - first) as usize / 10;
    // Read from decimals: powers of ten are not exact.
    let number = |power: i32, step: f64| format!("{step}e{power}").parse().unwrap_or(f64::NAN);
    let decade = |power: i32| steps.iter().map(move |&step| number(power, step));
    let all = (first..=last).step_by(stride).flat_map(decade);
    all.filter(|v| (low..=high).contains(v)).collect()
}

/// A number of at most four figures: whole ones without a point, very small and very large ones with a power
/// of ten.
pub(crate) fn number(value: f64) -> String {
    if value != 0.0 && !(1e-2..1e5).contains(&value.abs()) {
        return power_of_ten(value);
    }
    let text = format!("{value:.3}");
    signed(text.trim_end_matches('0').trim_end_matches('.'))
}

/// A number of two figures with its power of ten, such as `2.5×10⁻⁷`, or `10³`.
fn power_of_ten(value: f64) -> String {
    let text = format!("{value:.1e}");
    let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
    let power = raised(power.parse().unwrap_or(0));
    match digits.trim_end_matches(".0") {
        "1" => format!("10{power}"),
        "-1" => format!("−10{power}"),
        digits => format!("{}×10{power}", signed(digits)),
    }
}

/// A number in raised figures.
fn raised(power: i32) -> String {
    let figure = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    power.to_string().chars().map(figure).collect()
}

/// A written number with the sign of mathematics; a zero has none.
fn signed(text: &str) -> String {
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| "0.".contains(c)) => digits.into(),
        Some(digits) => format!("−{digits}"),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, log: bool) -> Vec<String> {
        Axis { low, high, log }.ticks(8.0).named.into_iter().map(|tick| tick.1).collect()
    }

    #[test]
    fn a_logarithmic_axis_has_round_numbers() {
        assert_eq!(round_numbers(0.4, 2.1), [0.4, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0]);
        assert_eq!(round_numbers(2e-7, 6e-6), [2e-7, 5e-7, 1e-6, 2e-6, 5e-6]);
        assert_eq!(round_numbers(0.5, 2e5), [1.0, 10.0, 100.0, 1e3, 1e4, 1e5]);
        assert!(round_numbers(1e-300, 1e300).len() <= 11);
    }

    #[test]
    fn the_numbers_of_an_axis_are_of_one_style() {
        assert_eq!(labels(0.5, 2e4, true), ["1", "10", "100", "1000", "10000"]);
        assert_eq!(labels(0.5, 2e5, true), ["10⁰", "10¹", "10²", "10³", "10⁴", "10⁵"]);
        assert_eq!(labels(2e-7, 6e-6, true), ["2×10⁻⁷", "5×10⁻⁷", "10⁻⁶", "2×10⁻⁶", "5×10⁻⁶"]);
        assert_eq!(labels(-1.0, 1.0, false), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(labels(0.0, 700.0, false), ["0", "100", "200", "300", "400", "500", "600", "700"]);
        let small = Axis { low: 0.0, high: 3e-4, log: false }.ticks(4.0);
        assert_eq!(small.factor, "×10⁻⁶");
        assert_eq!(small.named.iter().map(|tick| &*tick.1).collect::<Vec<_>>(), ["0", "100", "200", "300"]);
    }

    #[test]
    fn a_value_is_where_its_axis_says() {
        assert_eq!(Axis { low: 1.0, high: 100.0, log: true }.place(10.0), 0.5);
        assert_eq!(Axis { low: -1.0, high: 3.0, log: false }.place(0.0), 0.25);
        assert!(Axis { low: 5.0, high: 5.0 + 1e-12, log: false }.ticks(8.0).named.len() < 101);
    }

    #[test]
    fn numbers_are_short_and_exact() {
        let labels = [0.0, 1.0, 20.0, 0.25, -3.5, 12000.0, 1e6, 2.5e-7, -0.0001].map(number);
        assert_eq!(labels, ["0", "1", "20", "0.25", "−3.5", "12000", "10⁶", "2.5×10⁻⁷", "−10⁻⁴"]);
    }
}
