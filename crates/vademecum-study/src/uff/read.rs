//! Nodes and modes of a universal file: datasets 15 and 2411, 55, and the unit of length of 164. Others are
//! passed over.

use std::path::Path;

use faer::c64;
use vademecum_build::store::read_regular;

use super::error::UffError;

/// Contents of a universal file, in SI units of length.
#[derive(Debug, Default)]
pub struct UniversalFile {
    /// Label and place of each node \[m\], and the coordinate system of its displacements.
    pub nodes: Vec<(u64, [f64; 3], i64)>,
    /// Modes.
    pub modes: Vec<UniversalMode>,
}

/// A mode.
#[derive(Debug)]
pub struct UniversalMode {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Label of each node and its displacement.
    pub shape: Vec<(u64, [c64; 3])>,
}

/// Lines with their numbers, from 1.
struct Lines<'a> {
    path: &'a Path,
    lines: std::iter::Peekable<std::iter::Enumerate<std::str::Lines<'a>>>,
    at: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self, expected: &'static str) -> Result<&'a str, UffError> {
        let (at, line) = self.lines.next().ok_or_else(|| UffError::Malformed {
            file: self.path.to_path_buf(),
            line: self.at + 1,
            found: "the end of the file".into(),
            expected,
        })?;
        self.at = at + 1;
        Ok(line)
    }

    /// True at the line that ends a dataset.
    fn ends(&mut self) -> bool {
        self.lines.peek().is_none_or(|(_, line)| is_mark(line))
    }

    fn fault(&self, line: &str, expected: &'static str) -> UffError {
        let found = line.chars().filter(|c| !c.is_control()).take(60).collect();
        UffError::Malformed { file: self.path.to_path_buf(), line: self.at, found, expected }
    }

    /// Whole numbers of a line.
    fn integers<const N: usize>(&mut self, expected: &'static str) -> Result<[i64; N], UffError> {
        let line = self.next(expected)?;
        let mut numbers = line.split_whitespace().map(|word| word.parse().ok());
        let mut all = [0; N];
        for number in &mut all {
            *number = numbers.next().flatten().ok_or_else(|| self.fault(line, expected))?;
        }
        Ok(all)
    }

    /// Real numbers in columns of 13 or 25, over as many lines as they take, six or three in a line.
    fn reals(&mut self, count: usize, width: usize, expected: &'static str) -> Result<Vec<f64>, UffError> {
        let mut all: Vec<f64> = vec![];
        while all.len() < count {
            let line = self.next(expected)?;
            let before = all.len();
            for column in line.as_bytes().chunks(width).take(count - before) {
                let text = std::str::from_utf8(column).unwrap_or_default().trim().replace(['D', 'd'], "E");
                if text.is_empty() {
                    break;
                }
                let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
                all.push(number.ok_or_else(|| self.fault(line, expected))?);
            }
            if all.len() == before {
                return Err(self.fault(line, expected));
            }
        }
        Ok(all)
    }
}

fn is_mark(line: &str) -> bool {
    line.trim() == "-1"
}

impl UniversalFile {
    /// Reads a universal file.
    ///
    /// # Errors
    /// [`UffError`].
    pub fn read(path: &Path) -> Result<Self, UffError> {
        let bytes = read_regular(path).map_err(|source| UffError::Io { file: path.to_path_buf(), source })?;
        Self::parse(&String::from_utf8_lossy(&bytes), path)
    }

    fn parse(text: &str, path: &Path) -> Result<Self, UffError> {
        let mut lines = Lines { path, lines: text.lines().enumerate().peekable(), at: 0 };
        let (mut file, mut length) = (Self::default(), 1.0);
        while lines.lines.peek().is_some() {
            if !is_mark(lines.next("-1")?) {
                continue;
            }
            match lines.next("the number of a dataset")?.trim() {
                "164" => length = unit(&mut lines)?,
                "15" => file.nodes_15(&mut lines)?,
                "2411" => file.nodes_2411(&mut lines)?,
                "55" => file.mode(&mut lines)?,
                _ => {}
            }
            while !lines.ends() {
                lines.next("-1")?;
            }
            // The mark at the end.
            let _ = lines.lines.next();
        }
        file.nodes.iter_mut().for_each(|(_, at, _)| at.iter_mut().for_each(|x| *x /= length));
        Ok(file)
    }

    fn nodes_15(&mut self, lines: &mut Lines<'_>) -> Result<(), UffError> {
        const NODE: &str = "a node: its label, three numbers, and three coordinates";
        while !lines.ends() {
            let line = lines.next(NODE)?;
            let (head, tail) = line.split_at_checked(40).ok_or_else(|| lines.fault(line, NODE))?;
            let whole: Vec<i64> = head.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            let at: Vec<f64> = tail.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            match (&whole[..], &at[..]) {
                ([label, _, system, _], [x, y, z]) if *label >= 0 => {
                    self.nodes.push((*label as u64, [*x, *y, *z], *system));
                }
                _ => return Err(lines.fault(line, NODE)),
            }
        }
        Ok(())
    }

    fn nodes_2411(&mut self, lines: &mut Lines<'_>) -> Result<(), UffError> {
        while !lines.ends() {
            let [label, _, system, _] = lines.integers("the label of a node and three numbers")?;
            let at = lines.reals(3, 25, "three coordinates")?;
            self.nodes.push((label as u64, [at[0], at[1], at[2]], system));
        }
        Ok(())
    }

    /// A normal mode or a complex one; other data at nodes are passed over.
    fn mode(&mut self, lines: &mut Lines<'_>) -> Result<(), UffError> {
        for _ in 0..5 {
            lines.next("a line of identification")?;
        }
        let [_, analysis, _, _, kind, each] = lines.integers("six numbers that define the data")?;
        let [integers, reals] = lines.integers("how many parameters follow")?;
        // Two stand in the line already.
        for _ in 0..(integers.clamp(0, 100) + 1) / 8 {
            lines.next("parameters of the data")?;
        }
        let own = lines.reals(reals.clamp(1, 100) as usize, 13, "parameters of the mode")?;
        let frequency = match analysis {
            2 => own[0],
            // The size of the eigenvalue.
            3 | 7 => own.iter().take(2).map(|part| part * part).sum::<f64>().sqrt() / std::f64::consts::TAU,
            _ => return Ok(()),
        };
        let (each, complex) = (each.clamp(1, 100) as usize, kind == 5 || kind == 6);
        let mut shape = vec![];
        while !lines.ends() {
            let [label] = lines.integers("the label of a node")?;
            let numbers = lines.reals(each * if complex { 2 } else { 1 }, 13, "data of the node")?;
            let value = |c: usize| match (c < each, complex) {
                (false, _) => c64::new(0.0, 0.0),
                (true, false) => c64::new(numbers[c], 0.0),
                (true, true) => c64::new(numbers[2 * c], numbers[2 * c + 1]),
            };
            shape.push((label as u64, [0, 1, 2].map(value)));
        }
        self.modes.push(UniversalMode { frequency, shape });
        Ok(())
    }
}

/// Length of a metre in the unit of the file.
fn unit(lines: &mut Lines<'_>) -> Result<f64, UffError> {
    const FACTORS: &str = "factors of length, force and temperature above 0";
    lines.next("the code of the units")?;
    let factors = lines.reals(3, 25, FACTORS)?;
    if factors[0] > 0.0 { Ok(factors[0]) } else { Err(lines.fault(&factors[0].to_string(), FACTORS)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "    -1
   164
         4Millimeter (milli-newton)  2
  1.0000000000000000D+03  1.0000000000000000D+03  1.00000000000000000D+00
  2.73149999999999977D+02
    -1
    -1
    15
        11         0         0        11  1.00000E+03  0.00000E+00 -5.00000E+02
        12         0         1        11  0.00000E+00  2.50000E+02  0.00000E+00
    -1
    -1
   151
a dataset that nobody asks for
    -1
    -1
    55
NONE
NONE
NONE
NONE
NONE
         1         3         2         8         5         3
         2         6         1         1
 -3.00000E+00  4.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00
        11
  1.00000E+00  5.00000E-01  0.00000E+00  0.00000E+00 -2.00000E+00  1.00000E+00
        12
  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  1.00000E+00-1.00000E+00
    -1
";

    #[test]
    fn nodes_are_in_metres_and_complex_modes_are_read() {
        let file = UniversalFile::parse(FILE, Path::new("f.uff")).unwrap();
        assert_eq!(file.nodes, [(11, [1.0, 0.0, -0.5], 0), (12, [0.0, 0.25, 0.0], 1)]);
        let mode = &file.modes[0];
        assert!((mode.frequency - 5.0 / std::f64::consts::TAU).abs() < 1e-12);
        let [first, second] = &mode.shape[..] else { panic!("two nodes") };
        assert_eq!(first, &(11, [c64::new(1.0, 0.5), c64::new(0.0, 0.0), c64::new(-2.0, 1.0)]));
        assert_eq!(second.1[2], c64::new(1.0, -1.0));
    }

    #[test]
    fn faults_name_the_line() {
        let said = |text: &str| UniversalFile::parse(text, Path::new("f.uff")).unwrap_err().to_string();
        let cut =
            said(&FILE[..FILE.find("  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  1.0").unwrap()]);
        assert!(cut.contains("f.uff:29: found `the end of the file`; expected data of the node"), "{cut}");
        let wrong = said(&FILE.replace("  2.50000E+02  0.00000E+00\n", "  2.5OOOOE+02  0.00000E+00\n"));
        assert!(wrong.contains("f.uff:10: found `        12"), "{wrong}");
        let wrong = said(&FILE.replace("  1.0000000000000000D+03  1.0", " -1.0000000000000000D+03  1.0"));
        assert!(wrong.contains("above 0"), "{wrong}");
    }
}
