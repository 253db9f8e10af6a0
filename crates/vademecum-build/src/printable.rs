//! Texts of others in messages: names of a mesh, a problem or a file may hold anything, and a terminal obeys
//! control characters.

use std::borrow::Cow;

/// Most characters of a name that a message shows.
pub const MAX_SHOWN: usize = 64;

/// True of characters that a terminal obeys or that change how the text around them is read. Line ends and
/// tabs are those of the message itself.
fn is_harmful(c: char) -> bool {
    let is_direction =
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    (c.is_control() && c != '\n' && c != '\t') || is_direction || c == '\u{feff}'
}

/// The text with control characters, and those that turn the direction of a text, as `\u001b`: the escape of
/// JSON, so that JSON stays what it is.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_harmful) {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_harmful(c) { out.push_str(&format!("\\u{:04x}", c as u32)) } else { out.push(c) }
    }
    out.into()
}

/// The text with every piece in backticks cut after [`MAX_SHOWN`] characters: a name says which one it is
/// long before. Commands of the program stay whole.
pub fn shortened(text: &str) -> Cow<'_, str> {
    let is_long = |piece: &str| {
        !piece.starts_with("vademecum ")
            && piece.char_indices().nth(MAX_SHOWN).is_some()
            && !piece.contains('\n')
    };
    let quoted = text.split('`').skip(1).step_by(2);
    if !quoted.clone().any(is_long) {
        return text.into();
    }
    let mut out = String::new();
    for (place, piece) in text.split('`').enumerate() {
        if place > 0 {
            out.push('`');
        }
        match piece.char_indices().nth(MAX_SHOWN) {
            Some((end, _)) if place % 2 == 1 && is_long(piece) => {
                out.push_str(&piece[..end]);
                out.push('…');
            }
            _ => out.push_str(piece),
        }
    }
    out.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_escaped_and_json_stays_json() {
        assert_eq!(printable("a\u{1b}[2Jb\u{9b}c\u{202e}\n\td"), "a\\u001b[2Jb\\u009bc\\u202e\n\td");
        assert!(matches!(printable("Ü ✓ plain"), Cow::Borrowed(_)));
        let text = "{\"name\": \"a\u{9b}b\"}";
        let read: serde_json::Value = serde_json::from_str(&printable(text)).expect("JSON");
        assert_eq!(read["name"], "a\u{9b}b");
    }

    #[test]
    fn long_names_are_cut_and_commands_are_not() {
        let long = "é".repeat(3000);
        let text = shortened(&format!("no pattern `{long}`, there is `tip`")).into_owned();
        assert_eq!(text, format!("no pattern `{}…`, there is `tip`", "é".repeat(MAX_SHOWN)));
        let command = format!("`vademecum verify {long} --file-only` tells");
        assert_eq!(shortened(&command), command);
        assert_eq!(shortened("a lone ` stays"), "a lone ` stays");
    }
}
