//! Elements of XML.

use std::fmt::Write as _;

/// One element with its attributes; empty ones are left out.
pub(super) struct Element(String);

impl Element {
    pub(crate) fn new(name: &str) -> Self {
        Self(format!("<{name}"))
    }

    pub(crate) fn with(mut self, name: &str, value: &str) -> Self {
        if !value.is_empty() {
            self = self.always(name, value);
        }
        self
    }

    pub(crate) fn always(mut self, name: &str, value: &str) -> Self {
        write!(self.0, " {name}=\"{}\"", escaped(value)).expect("writing to a string cannot fail");
        self
    }

    pub(crate) fn number(self, name: &str, value: Option<f64>) -> Self {
        // The digits that are read back as the same number.
        self.with(name, &value.map_or_else(String::new, |value| value.to_string()))
    }

    pub(crate) fn closed(self) -> String {
        self.0 + "/>"
    }

    pub(crate) fn around(self, name: &str, inside: &[String]) -> String {
        let lines: String = inside.join("\n").lines().map(|line| format!("  {line}\n")).collect();
        format!("{}>\n{lines}</{name}>", self.0)
    }
}

pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // What XML has no characters for.
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::escaped;

    #[test]
    fn what_xml_has_no_characters_for_is_replaced() {
        assert_eq!(escaped("a<b & \"c\"\n"), "a&lt;b &amp; &quot;c&quot; ");
    }
}
