//! Datasets as text.

use std::fmt::Write as _;

use faer::c64;

/// Nodes in a row of dataset 82.
const PER_LINE: usize = 8;
/// An identification line that says nothing.
const NONE: &str = "NONE";

/// A text of datasets.
#[derive(Debug, Default)]
pub(super) struct Datasets(pub(super) String);

/// A node and a direction of a function: label (0 of none), 1 to 3 along x, y and z, negative against them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Dof {
    pub(super) name: String,
    pub(super) node: u64,
    pub(super) direction: i32,
}

/// A frequency response.
pub(super) struct Function<'a> {
    pub(super) number: usize,
    pub(super) response: &'a Dof,
    pub(super) reference: &'a Dof,
    /// Kind of data of the response: 8 displacement, 11 velocity, 12 acceleration.
    pub(super) kind: u32,
    /// Kind of data of the reference: 13 excitation force, 1 general.
    pub(super) reference_kind: u32,
    pub(super) frequencies: &'a [f64],
    pub(super) values: &'a [c64],
}

impl Datasets {
    fn dataset(&mut self, number: u32, lines: impl FnOnce(&mut String)) {
        let _ = writeln!(self.0, "    -1\n{number:>6}");
        lines(&mut self.0);
        self.0.push_str("    -1\n");
    }

    /// SI units.
    pub(super) fn units(&mut self) {
        self.dataset(164, |out| {
            let _ = writeln!(out, "{:>10}{:<20}{:>10}", 1, "SI: Meter (newton)", 2);
            let _ = writeln!(out, "{}{}{}", fortran(1.0, 25, 17), fortran(1.0, 25, 17), fortran(1.0, 25, 17));
            let _ = writeln!(out, "{}", fortran(273.15, 25, 17));
        });
    }

    pub(super) fn nodes(&mut self, nodes: &[(u64, [f64; 3])]) {
        self.dataset(15, |out| {
            for (label, at) in nodes {
                let _ = write!(out, "{label:>10}{:>10}{:>10}{:>10}", 0, 0, 11);
                at.iter().for_each(|x| out.push_str(&fortran(*x, 13, 5)));
                out.push('\n');
            }
        });
    }

    /// Lines between pairs of nodes.
    pub(super) fn lines(&mut self, title: &str, pairs: &[[u64; 2]]) {
        self.dataset(82, |out| {
            let _ = writeln!(out, "{:>10}{:>10}{:>10}\n{}", 1, 3 * pairs.len(), 11, identification(title));
            let traced: Vec<u64> = pairs.iter().flat_map(|[a, b]| [*a, *b, 0]).collect();
            for row in traced.chunks(PER_LINE) {
                row.iter().for_each(|node| {
                    let _ = write!(out, "{node:>10}");
                });
                out.push('\n');
            }
        });
    }

    /// A normal mode of modal mass 1: frequency \[Hz\], viscous damping ratio, displacement of each node.
    pub(super) fn mode(
        &mut self,
        title: &str,
        number: usize,
        [frequency, ratio]: [f64; 2],
        shape: impl Iterator<Item = (u64, [f64; 3])>,
    ) {
        self.dataset(55, |out| {
            let name = format!("mode {number}, {frequency:.6} Hz, mass-normalised");
            for line in [title, &name, NONE, NONE, NONE] {
                let _ = writeln!(out, "{}", identification(line));
            }
            // Structural; normal mode; three translations; displacement; real; three numbers a node.
            for field in [1, 2, 2, 8, 2, 3] {
                let _ = write!(out, "{field:>10}");
            }
            let _ = writeln!(out, "\n{:>10}{:>10}{:>10}{number:>10}", 2, 4, 1);
            for real in [frequency, 1.0, ratio, 0.0] {
                out.push_str(&fortran(real, 13, 5));
            }
            out.push('\n');
            for (label, moved) in shape {
                let _ = writeln!(out, "{label:>10}");
                moved.iter().for_each(|x| out.push_str(&fortran(*x, 13, 5)));
                out.push('\n');
            }
        });
    }

    /// A frequency response in double precision at frequencies of any spacing.
    pub(super) fn function(&mut self, title: &str, function: &Function<'_>) {
        let Function { number, response, reference, kind, reference_kind, frequencies, values } = *function;
        self.dataset(58, |out| {
            let name = format!("{} / {}", response.name, reference.name);
            for line in [title, &name, NONE, NONE, NONE] {
                let _ = writeln!(out, "{}", identification(line));
            }
            // Frequency response function; the two dofs.
            let _ = write!(out, "{:>5}{number:>10}{:>5}{:>10}", 4, 1, 0);
            for Dof { node, direction, .. } in [response, reference] {
                let _ = write!(out, " {NONE:<10}{node:>10}{direction:>4}");
            }
            // Complex double precision, uneven spacing.
            let zero = fortran(0.0, 13, 5);
            let _ = writeln!(out, "\n{:>10}{:>10}{:>10}{zero}{zero}{zero}", 6, values.len(), 0);
            let mut axis = |kind: u32, label: &str, unit: &str| {
                let _ = writeln!(out, "{kind:>10}{:>5}{:>5}{:>5} {label:<20} {unit:<20}", 0, 0, 0);
            };
            let unit = match kind {
                11 => "m/s",
                12 => "m/s^2",
                _ => "m",
            };
            axis(18, "Frequency", "Hz");
            axis(kind, "Response", unit);
            axis(reference_kind, "Reference", if reference_kind == 13 { "N" } else { NONE });
            axis(0, NONE, NONE);
            for (frequency, value) in frequencies.iter().zip(values) {
                let parts = [fortran(value.re, 20, 12), fortran(value.im, 20, 12)].concat();
                let _ = writeln!(out, "{}{parts}", fortran(*frequency, 13, 5));
            }
        });
    }
}

/// A number in columns: `{:E}` of Fortran, with a sign and two or three digits in the exponent.
fn fortran(value: f64, width: usize, digits: usize) -> String {
    let text = format!("{value:.digits$E}");
    let (mantissa, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>width$}", format!("{mantissa}E{sign}{:02}", exponent.abs()))
}

/// A line of at most 80 characters, all of them printable ASCII.
fn identification(text: &str) -> String {
    text.chars().map(|c| if (' '..='~').contains(&c) { c } else { '?' }).take(80).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_in_their_columns() {
        assert_eq!(fortran(-1.25e-7, 13, 5), " -1.25000E-07");
        assert_eq!(fortran(0.0, 13, 5), "  0.00000E+00");
        assert_eq!(fortran(1e120, 13, 5), " 1.00000E+120");
        assert_eq!(fortran(-1e-120, 13, 5), "-1.00000E-120");
        assert_eq!(fortran(1.0 / 3.0, 20, 12), "  3.333333333333E-01");
        assert_eq!(identification(&"é".repeat(90)), "?".repeat(80));
    }
}
