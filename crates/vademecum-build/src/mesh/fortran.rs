//! Real numbers as Fortran programs write them.

/// A finite real number: `D` may stand for `E`, and both may be left out before a signed exponent, so that
/// `1.5-3` is 0.0015.
pub(crate) fn real(text: &str) -> Option<f64> {
    let mut plain = String::new();
    let mut exponent = false;
    for c in text.trim().chars() {
        match c {
            '0'..='9' | '.' => {}
            'e' | 'E' | 'd' | 'D' if !exponent && !plain.is_empty() => {
                exponent = true;
                plain.push('e');
                continue;
            }
            '+' | '-' if plain.is_empty() || plain.ends_with('e') => {}
            '+' | '-' if !exponent => {
                exponent = true;
                plain.push('e');
            }
            _ => return None,
        }
        plain.push(c);
    }
    plain.parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_may_lack_their_letter() {
        let cases = [
            ("1.5-3", 1.5e-3),
            (".5", 0.5),
            ("1.+6", 1e6),
            ("1.0D3", 1e3),
            ("-6.9+10", -6.9e10),
            (" 7 ", 7.0),
            ("+.5d-1", 0.05),
            ("-1.E+2", -100.0),
            ("1.0000000000000-101", 1e-101),
        ];
        for (text, value) in cases {
            assert_eq!(real(text), Some(value), "{text}");
        }
        for text in
            ["", "-", "nan", "inf", "1e", "1.5 -3", "1e5e5", "1-2-3", "e5", "1+", "0x1", "1e999", "1,5"]
        {
            assert_eq!(real(text), None, "{text}");
        }
    }
}
