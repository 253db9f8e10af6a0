//! Width of lines, and links.

use std::collections::{BTreeMap, BTreeSet};

use crate::sources::{Source, files};
use vademecum_tests::program::repository;

/// The width that lines of code and of prose may have, in characters.
const WIDTH: usize = 110;

/// Lines of Rust and of Markdown prose that are too wide and could be broken.
///
/// Exempt are tables, blocks of code and records in Markdown, lines of code with a text in them (the
/// formatter leaves such lines alone, and a text that is read as one line is found as one), and lines whose
/// first word is what makes them wide: a link cannot be broken. A link of Markdown counts as one word.
pub fn wide_lines() -> Vec<String> {
    let code = files("rs").into_iter().flat_map(|source| wide(&source, is_code_or_comment()));
    let mut prose = files("md");
    prose.retain(|source| !source.path.contains("/records/"));
    let prose: Vec<String> = prose.iter().flat_map(|source| wide(source, is_prose())).collect();
    code.chain(prose).collect()
}

/// Lines of prose and comments with one of these phrases, each beside its better word. Exempt are records,
/// the history of the project, and lines that translate words: rows of the dictionary and aliases for a
/// search.
pub fn phrases(listed: &[(&str, &str)]) -> Vec<String> {
    let history = |path: &str| ["/records/", "/decisions/", "CHANGELOG"].iter().any(|of| path.contains(of));
    let mut found = vec![];
    for source in files("md").into_iter().chain(files("rs")) {
        let (is_page, translates) = (source.path.ends_with(".md"), source.path.ends_with("dictionary.md"));
        for (index, line) in source.text.lines().enumerate() {
            let is_prose = is_page || line.trim_start().starts_with("//");
            if !is_prose || translates || history(&source.path) {
                continue;
            }
            let line = line.to_lowercase();
            for (phrase, better) in listed.iter().filter(|(phrase, _)| line.contains(phrase)) {
                found.push(format!("{}:{}: {phrase}: {better}", source.path, index + 1));
            }
        }
    }
    found
}

fn wide(source: &Source, mut counts: impl FnMut(usize, &str) -> bool) -> Vec<String> {
    let mut found = vec![];
    for (index, line) in source.text.lines().enumerate() {
        let width = line.chars().count();
        if counts(index, line) && width > WIDTH && first_word_ends(line) <= WIDTH {
            found.push(format!("{}:{}: {width} characters", source.path, index + 1));
        }
    }
    found
}

/// Tells for line after line of a source whether its width counts: comments are prose, and code has no text
/// in it.
fn is_code_or_comment() -> impl FnMut(usize, &str) -> bool + Copy {
    let mut prose = is_prose();
    move |index, line| {
        let comment = ["//!", "///", "//"].iter().find_map(|mark| line.trim_start().strip_prefix(mark));
        match comment {
            Some(comment) => prose(index, comment),
            None => !has_text(line),
        }
    }
}

/// Whether a line of code holds a text, or a part of one that goes on.
fn has_text(line: &str) -> bool {
    !line.trim_start().starts_with("//") && (line.contains('"') || line.trim_end().ends_with('\\'))
}

/// Tells for line after line of a page whether it is prose: no table, not in a block of code.
fn is_prose() -> impl FnMut(usize, &str) -> bool + Copy {
    let mut in_code = false;
    move |index, line| {
        in_code &= index > 0;
        if line.trim_start().starts_with("```") {
            in_code = !in_code;
            return false;
        }
        !in_code && !line.trim_start().starts_with('|')
    }
}

/// Where the first word of a line ends, in characters: marks of comments, lists and quotations before it do
/// not count as words.
fn first_word_ends(line: &str) -> usize {
    let mut end = 0;
    let marks = ["//", "///", "//!", "-", "*", ">", "#", "##", "###"];
    let mut rest = line;
    loop {
        let blank = rest.len() - rest.trim_start().len();
        let word = word(rest.trim_start());
        end += rest[..blank + word.len()].chars().count();
        rest = &rest[blank + word.len()..];
        if rest.is_empty() || !(marks.contains(&word) || word.trim_end_matches('.').parse::<u32>().is_ok()) {
            return end;
        }
    }
}

/// The first word: up to a blank, a link of Markdown taken whole.
fn word(text: &str) -> &str {
    let start = text.trim_start_matches(['(', '!', '"']);
    let skipped = text.len() - start.len();
    let link = start
        .starts_with('[')
        .then(|| start.find("](").and_then(|middle| start[middle..].find(')').map(|end| middle + end)));
    let from = link.flatten().map_or(0, |end| skipped + end);
    let end = text[from..].find(char::is_whitespace).map_or(text.len(), |end| from + end);
    &text[..end]
}

/// Relative links that lead nowhere, anchors included.
pub fn broken_links() -> Vec<String> {
    let pages = files("md");
    let anchors: BTreeMap<&str, BTreeSet<String>> =
        pages.iter().map(|page| (page.path.as_str(), anchors(&page.text))).collect();
    let mut broken = vec![];
    let mut seen = 0;
    for page in &pages {
        for (line, target) in links(&page.text) {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            seen += 1;
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() { page.path.clone() } else { beside(&page.path, file) };
            let there = repository().join(&path).exists();
            let known = anchor.is_empty() || anchors.get(path.as_str()).is_none_or(|a| a.contains(anchor));
            if !there || !known {
                broken.push(format!("{}:{line}: {target}", page.path));
            }
        }
    }
    assert!(seen > 50, "only {seen} links found: the reading of links is broken");
    broken
}

/// A relative path from the folder of `page`, without `.` and `..`.
fn beside(page: &str, file: &str) -> String {
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in file.split('/') {
        match part {
            "." | "" => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// Line and target of every link outside code.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut found = vec![];
    let mut in_code = false;
    for (index, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            in_code = !in_code;
        }
        if in_code {
            continue;
        }
        let line_without_code = without_code(line);
        let mut rest = line_without_code.as_str();
        while let Some(at) = rest.find("](") {
            rest = &rest[at + 2..];
            let end = rest.find(')').unwrap_or(rest.len());
            let target = rest[..end].split_whitespace().next().unwrap_or_default();
            found.push((index + 1, target.trim_matches(['<', '>']).to_string()));
        }
        // `[name]: target`
        if let Some((name, target)) = line.split_once("]: ")
            && name.starts_with('[')
        {
            found.push((index + 1, target.split_whitespace().next().unwrap_or_default().to_string()));
        }
    }
    found
}

/// A line with its code spans left out.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("`")
}

/// The anchors of the headings of a page, as GitHub makes them, and those set by hand.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut in_code = false;
    for line in text.lines() {
        in_code ^= line.trim_start().starts_with("```");
        for mark in ["id=\"", "name=\""] {
            found
                .extend(line.split(mark).skip(1).filter_map(|rest| rest.split('"').next()).map(String::from));
        }
        let title = line.trim_start_matches('#');
        if in_code || title.len() == line.len() || !title.starts_with(' ') {
            continue;
        }
        let plain: String = title.trim().to_lowercase().chars().filter_map(slug).collect();
        let mut anchor = plain.clone();
        for again in 1.. {
            if found.insert(anchor.clone()) {
                break;
            }
            anchor = format!("{plain}-{again}");
        }
    }
    found
}

fn slug(c: char) -> Option<char> {
    match c {
        ' ' => Some('-'),
        '-' | '_' => Some(c),
        c if c.is_alphanumeric() => Some(c),
        _ => None,
    }
}

#[test]
fn a_line_is_wide_where_it_could_be_broken() {
    let long = "x".repeat(120);
    for (line, wide) in [
        (format!("/// {long}"), false),
        (format!("/// see {long}"), true),
        (format!("- [two words]({long}), and more"), false),
        (format!("- see [two words]({long})"), true),
        (format!("1. {long}"), false),
        (format!("    let x = \"{long}\";"), true),
    ] {
        assert_eq!(first_word_ends(&line) <= WIDTH, wide, "{line}");
    }
}

#[test]
fn anchors_are_githubs() {
    let page = "# A page: of `code`, 1.0\n## Twice\n## Twice\n```\n# no\n```\n<a id=\"own\"></a>\n";
    let expected = ["a-page-of-code-10", "own", "twice", "twice-1"];
    assert_eq!(anchors(page).iter().map(String::as_str).collect::<Vec<_>>(), expected);
}
