//! Lines of a text, and the two words of `part.port`. The searches of `str` for a character leave a panic in
//! the library that the compiler cannot rule out; those of bytes do not.

/// Lines between line ends, as many as these and one; none of an empty text.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = &str> + Clone {
    let all = text.as_bytes().split(|byte| *byte == b'\n').filter(|_| !text.is_empty());
    all.map(|line| core::str::from_utf8(line).unwrap_or_default())
}

/// The words before and after the first dot.
pub(crate) fn at_dot(name: &str) -> Option<(&str, &str)> {
    let at = name.as_bytes().iter().position(|byte| *byte == b'.')?;
    Some((name.get(..at)?, name.get(at.checked_add(1)?..)?))
}

#[cfg(test)]
mod tests {
    use super::{at_dot, lines};

    #[test]
    fn lines_and_words_are_those_of_the_library() {
        for text in ["", "a", "a\nü", "\n", "a\n\nb"] {
            let expected = text.split('\n').filter(|_| !text.is_empty());
            assert!(lines(text).eq(expected), "{text:?}");
        }
        for name in ["", "a", ".", "ü.b", "a.b.c"] {
            assert_eq!(at_dot(name), name.split_once('.'));
        }
    }
}
