//! Fixed columns of blocks in Ansys files, as the Fortran format before each block gives them.

/// Widest column that is believed.
const WIDEST: usize = 64;

/// Columns of a line: whole numbers, then real ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Columns {
    /// Whole numbers in a line.
    pub(super) integers: usize,
    integer_width: usize,
    /// Real numbers in a line.
    pub(super) reals: usize,
    real_width: usize,
}

impl Columns {
    /// The columns of a format like `(3i9,6e21.13e3)`; none if it is not of this form.
    pub(super) fn parse(line: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(line.trim_ascii()).ok()?;
        let inner = text.strip_prefix('(')?.split(')').next()?;
        let mut columns = Self { integers: 0, integer_width: 0, reals: 0, real_width: 0 };
        for part in inner.split(',').map(str::trim) {
            let letter = part.find(|c: char| c.is_ascii_alphabetic())?;
            let (count, rest) = part.split_at(letter);
            let count = if count.is_empty() { 1 } else { count.parse().ok()? };
            let mut rest = rest.chars();
            let letter = rest.next()?.to_ascii_lowercase();
            let digits: String = rest.take_while(char::is_ascii_digit).collect();
            let width: usize = digits.parse().ok().filter(|width| (1..=WIDEST).contains(width))?;
            let is_first = if letter == 'i' { columns.integers == 0 } else { columns.reals == 0 };
            if !(1..=WIDEST).contains(&count) || !is_first {
                return None;
            }
            match letter {
                'i' => (columns.integers, columns.integer_width) = (count, width),
                'e' | 'f' | 'g' | 'd' => (columns.reals, columns.real_width) = (count, width),
                // Texts at the end of a line are not read.
                'a' => {}
                _ => return None,
            }
        }
        Some(columns).filter(|columns| columns.integers > 0)
    }

    /// The text of a whole number, trimmed; empty beyond the end of the line.
    pub(super) fn integer<'a>(&self, line: &'a [u8], index: usize) -> &'a [u8] {
        column(line, index * self.integer_width, self.integer_width)
    }

    /// The text of a real number, trimmed; empty beyond the end of the line.
    pub(super) fn real<'a>(&self, line: &'a [u8], index: usize) -> &'a [u8] {
        column(line, self.integers * self.integer_width + index * self.real_width, self.real_width)
    }
}

fn column(line: &[u8], from: usize, width: usize) -> &[u8] {
    line.get(from..(from + width).min(line.len())).unwrap_or_default().trim_ascii()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_columns() {
        let columns = Columns::parse(b"(3i8,6e20.13)\r").unwrap();
        assert_eq!((columns.integers, columns.reals), (3, 6));
        let line = b"      12      21       0 1.0000000000000E+00-5.0000000000000E-01";
        assert_eq!((columns.integer(line, 0), columns.integer(line, 1)), (&b"12"[..], &b"21"[..]));
        assert_eq!(columns.real(line, 0), b"1.0000000000000E+00");
        assert_eq!(columns.real(line, 1), b"-5.0000000000000E-01");
        assert_eq!((columns.real(line, 2), columns.real(line, 5)), (&b""[..], &b""[..]));
        assert_eq!(Columns::parse(b"(19I10)").map(|c| (c.integers, c.reals)), Some((19, 0)));
        assert_eq!(Columns::parse(b"(1i9,3e20.9e3)").map(|c| (c.integers, c.reals)), Some((1, 3)));
        assert_eq!(Columns::parse(b"(2i9,19a9)").map(|c| (c.integers, c.reals)), Some((2, 0)));
        for wrong in
            ["", "3i8", "()", "(i)", "(3x8)", "(3i8,3i9)", "(3i999)", "(99999i8)", "(6e20.13)", "(3i0)"]
        {
            assert_eq!(Columns::parse(wrong.as_bytes()), None, "{wrong}");
        }
    }
}
