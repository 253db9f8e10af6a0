//! Names of what variables belong to, as the file has them.

use vademecum_eval::format::{File, SectionKind};

/// One name a line, as the file has them.
#[derive(Clone, Copy, Debug)]
pub struct Names {
    /// Of the load patterns.
    pub patterns: &'static str,
    /// Of the probes.
    pub probes: &'static str,
    /// Of the supports.
    pub supports: &'static str,
}

/// One line of a text, counted from 0; empty behind the last. (`str::lines` leaves a panic that the linker
/// cannot rule out.)
pub fn line(text: &'static str, index: u32) -> &'static str {
    let ends = || text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(at, _)| at);
    let start = match (index as usize).checked_sub(1) {
        None => 0,
        Some(before) => ends().nth(before).map_or(text.len(), |end| end + 1),
    };
    let end = ends().nth(index as usize).unwrap_or(text.len());
    text.get(start..end).unwrap_or_default()
}

/// Lines of a text section; none where it is absent or compressed.
pub fn text(file: &File<'static>, kind: SectionKind) -> &'static str {
    file.section(kind).and_then(|section| section.text().ok()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::line;

    #[test]
    fn lines_are_counted_from_zero() {
        let text = "tip\n\nroot";
        assert_eq!([0, 1, 2, 3].map(|index| line(text, index)), ["tip", "", "root", ""]);
        assert_eq!([0, 1].map(|index| line("tip\n", index)), ["tip", ""]);
        assert_eq!(line("", 0), "");
    }
}
