//! The pages of `formats/` that say how files are written, as text for a terminal.
//!
//! The pages are Markdown with wide tables. Here a paragraph is wrapped, and a row of a table becomes its
//! first cells as a heading with the other cells below, each behind the name of its column.

/// Columns of a terminal that everybody has.
const WIDTH: usize = 80;

/// A page about a kind of file.
pub(crate) struct Page {
    /// Name on the command line.
    pub(crate) name: &'static str,
    /// Subject.
    pub(crate) about: &'static str,
    text: &'static str,
}

/// All pages inside the program.
pub(crate) const PAGES: [Page; 4] = [
    Page {
        name: "problem",
        about: "every key of the problem file, its range and its default",
        text: include_str!("../assets/problem-1.md"),
    },
    Page {
        name: "scenario",
        about: "every key of the scenario file, and what `run` and `verify` make of it",
        text: include_str!("../assets/scenario-1.md"),
    },
    Page {
        name: "sweep",
        about: "every key of the sweep file, and what `plan` makes of it",
        text: include_str!("../assets/sweep-1.md"),
    },
    Page {
        name: "json",
        about: "what each command prints with `--json`",
        text: include_str!("../assets/json-1.md"),
    },
];

impl Page {
    /// The whole page.
    pub(crate) fn whole(&self) -> String {
        render(self.text)
    }

    /// Names of its sections, without marks.
    pub(crate) fn sections(&self) -> Vec<String> {
        parts(self.text).into_iter().skip(1).map(title).collect()
    }

    /// The section of a name.
    pub(crate) fn section(&self, name: &str) -> Option<String> {
        let sought = name.to_lowercase();
        let mut all = parts(self.text).into_iter().skip(1);
        all.find(|part| title(part).to_lowercase() == sought).map(render)
    }
}

/// The page cut before each of its sections.
fn parts(text: &str) -> Vec<&str> {
    let mut cuts: Vec<usize> = vec![0];
    cuts.extend(text.match_indices("\n## ").map(|(at, _)| at + 1));
    cuts.push(text.len());
    cuts.windows(2).map(|ends| &text[ends[0]..ends[1]]).collect()
}

/// Name of a section: what stands behind its number signs, without brackets and backticks.
fn title(part: &str) -> String {
    let line = part.lines().next().unwrap_or_default();
    line.trim_start_matches('#').trim().replace(['`', '[', ']'], "")
}

/// Markdown as text of [`WIDTH`] columns.
fn render(text: &str) -> String {
    let mut out = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        if line.starts_with("```") {
            for line in lines.by_ref().take_while(|line| !line.starts_with("```")) {
                out.push_str(&format!("    {line}\n"));
            }
        } else if line.starts_with('#') {
            let (level, name) = (line.chars().take_while(|&c| c == '#').count(), plain(line));
            let name = name.trim_start_matches('#').trim();
            let mark = if level == 1 { "=" } else { "-" };
            out.push_str(&format!("{name}\n{}\n", mark.repeat(name.chars().count())));
        } else if line.starts_with('|') {
            let mut rows = vec![cells(line)];
            while let Some(row) = lines.next_if(|line| line.starts_with('|')) {
                rows.push(cells(row));
            }
            out.push_str(&table(&rows));
        } else if line.trim().is_empty() {
            out.push('\n');
        } else {
            // A paragraph or a point of a list goes on until something else begins.
            let mut paragraph = line.trim().to_string();
            let goes_on = |line: &&str| {
                !line.trim().is_empty()
                    && !line.starts_with(['#', '|', '`'])
                    && !line.trim_start().starts_with("- ")
            };
            while let Some(next) = lines.next_if(goes_on) {
                paragraph.push(' ');
                paragraph.push_str(next.trim());
            }
            let indent = if line.starts_with("- ") { "  " } else { "" };
            out.push_str(&wrapped(&plain(&paragraph), "", indent));
        }
    }
    out
}

/// Cells of a row of a table.
fn cells(row: &str) -> Vec<String> {
    let inner = row.trim().trim_start_matches('|').trim_end_matches('|');
    inner.split('|').map(|cell| plain(cell.trim())).collect()
}

/// A table as a list: the first row names the columns, the second draws a line.
fn table(rows: &[Vec<String>]) -> String {
    let Some((names, rest)) = rows.split_first() else { return String::new() };
    let mut out = String::new();
    for row in rest.iter().skip(1) {
        let mut said = row.iter().zip(names).filter(|(cell, _)| !cell.is_empty());
        if let Some((head, _)) = said.next() {
            out.push_str(&wrapped(head, "  ", "  "));
        }
        let details: Vec<String> = said
            .map(|(cell, name)| match name.as_str() {
                "" | "meaning" | "refused" | "key" => cell.clone(),
                name => format!("{name}: {cell}"),
            })
            .collect();
        out.push_str(&wrapped(&details.join("; "), "      ", "      "));
    }
    out
}

/// Text without the marks of Markdown: links become their names, and stars and backticks go.
fn plain(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(open) = rest.find('[') {
        let (before, behind) = rest.split_at(open);
        out.push_str(before);
        let link = behind.find("](").and_then(|middle| {
            let end = behind[middle..].find(')')?;
            Some((&behind[1..middle], &behind[middle + end + 1..]))
        });
        match link.filter(|(name, _)| !name.contains(['[', ']'])) {
            Some((name, after)) => {
                out.push_str(name);
                rest = after;
            }
            None => {
                out.push('[');
                rest = &behind[1..];
            }
        }
    }
    out.push_str(rest);
    out.replace("**", "").replace('`', "")
}

/// Words in lines of [`WIDTH`] columns; nothing of no words.
fn wrapped(text: &str, first: &str, others: &str) -> String {
    let (mut out, mut line) = (String::new(), first.to_string());
    let mut is_empty = true;
    for word in text.split_whitespace() {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            out.push_str(&line);
            out.push('\n');
            line = others.to_string();
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    if !is_empty {
        out.push_str(&line);
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markdown_becomes_text() {
        let text = "# The *page*, `one`\n\nA [link](to/it.md#x) and\n**more**.\n\n| key | type | meaning |\n|---|---|---|\n\
                    | `a` | 3 numbers | what it is |\n\n```toml\n[mesh]\nx = 1\n```\n\n- a point\n  goes on\n";
        let expected = "The *page*, one\n===============\n\nA link and more.\n\n  a\n      type: 3 numbers; what it is\n\n    \
                        [mesh]\n    x = 1\n\n- a point goes on\n";
        assert_eq!(render(text), expected);
    }

    #[test]
    fn no_page_has_a_line_that_a_terminal_breaks_but_in_its_examples() {
        for page in &PAGES {
            for line in page.whole().lines().filter(|line| !line.starts_with("    ")) {
                assert!(line.chars().count() <= WIDTH, "{}: {line}", page.name);
            }
        }
    }

    #[test]
    fn sections_go_by_their_names() {
        let problem = &PAGES[0];
        assert!(problem.sections().contains(&"basis".to_string()));
        let time = problem.section("Time").expect("a section");
        assert!(time.starts_with("[time]\n------\n") && time.contains("rho-bathe"), "{time}");
        assert!(!time.contains("[snapshots]\n---"), "one section only");
        assert!(problem.section("nothing").is_none());
    }
}
