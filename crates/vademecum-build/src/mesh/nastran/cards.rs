//! Cards of Nastran files: small, large and free fields, continuations, included files.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::mesh::error::{FaultSite, MeshError, shown};
use crate::mesh::fortran::real;
use crate::mesh::load::load;
use crate::mesh::place::Location;

/// An entry of the bulk data, with its continuations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Card {
    /// Name in capitals, without the star of large fields.
    pub name: String,
    /// Fields, trimmed, blank ones empty: the first is Nastran's field 2. Those of continuations follow,
    /// eight for each line. Blank fields at the end are left out.
    pub fields: Vec<String>,
    /// File that the card stands in.
    pub file: Arc<PathBuf>,
    /// Its first line, from 1.
    pub line: usize,
}

impl Card {
    /// A field; empty where there is none.
    pub fn field(&self, index: usize) -> &str {
        self.fields.get(index).map_or("", String::as_str)
    }

    /// A field as a whole number; none for a blank.
    ///
    /// # Errors
    /// [`MeshError`] if it is no whole number.
    pub fn id(&self, index: usize) -> Result<Option<u64>, MeshError> {
        self.value(index, "a whole number", |text| text.strip_prefix('+').unwrap_or(text).parse().ok())
    }

    /// A field as a real number; none for a blank.
    ///
    /// # Errors
    /// [`MeshError`] if it is no number.
    pub fn real(&self, index: usize) -> Result<Option<f64>, MeshError> {
        self.value(index, "a number", number)
    }

    fn value<T>(
        &self,
        index: usize,
        expected: &str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<Option<T>, MeshError> {
        let text = self.field(index);
        if text.is_empty() {
            return Ok(None);
        }
        let fault = || {
            let field = format!("{} in its field {}", shown(text.as_bytes()), index + 2);
            self.malformed(field, expected)
        };
        parse(text).map(Some).ok_or_else(fault)
    }

    /// The error that the card breaks the rules of the format.
    pub fn malformed(&self, found: impl Into<String>, expected: impl Into<String>) -> MeshError {
        self.at().malformed(found, expected)
    }

    /// The error that the card asks for something that is not supported.
    pub fn unsupported(
        &self,
        found: impl Into<String>,
        expected: impl Into<String>,
        remedy: impl Into<String>,
    ) -> MeshError {
        self.at().unsupported(found, expected, remedy)
    }

    pub(crate) fn at(&self) -> FaultSite<'_> {
        FaultSite { file: &self.file, place: self.place(), section: &self.name }
    }

    pub(crate) fn place(&self) -> Location {
        Location::Line(self.line)
    }
}

/// A Nastran file with everything that it includes.
#[derive(Clone, Debug, Default)]
pub struct Cards {
    /// Lines before `BEGIN BULK`, executive and case control, without comments, each with its number.
    pub executive: Vec<(usize, String)>,
    /// Bulk data, in order.
    pub bulk: Vec<Card>,
}

/// A real number as Nastran reads it: `1.5-3` is 0.0015, `1.0D3` is 1000.
pub fn number(text: &str) -> Option<f64> {
    real(text)
}

/// Reads the cards of a file, with all files it includes. A file without `BEGIN BULK`, `CEND` and `SOL` is
/// bulk data from its first line.
///
/// # Errors
/// [`MeshError`] with file and line if a line is no card, a file is included in itself or cannot be read, or
/// the model has superelements.
pub fn cards(file: &Path, bytes: &[u8]) -> Result<Cards, MeshError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = CardReader {
        found: Cards::default(),
        open: Vec::new(),
        included: 0,
        in_bulk: !lines(bytes).any(|(_, line)| opens_executive(line)),
        ended: false,
        waiting: HashMap::new(),
        places: Vec::new(),
    };
    reader.read(file, bytes)?;
    Ok(reader.found)
}

/// The paths that a file includes, as they stand in it.
pub(crate) fn inclusions(bytes: &[u8]) -> Vec<String> {
    let mut all = lines(bytes);
    let mut found = Vec::new();
    while let Some((_, line)) = all.next() {
        let line = line.trim_ascii_start();
        if starts_with(line, "INCLUDE") {
            found.extend(included(&whole(line, &mut all)));
        }
    }
    found
}

/// A line with those after it until its quote is closed, over which a path may go on.
fn whole<'a>(line: &[u8], rest: &mut impl Iterator<Item = (usize, &'a [u8])>) -> String {
    let mut whole = String::from_utf8_lossy(line).trim_end().to_string();
    for _ in 0..20 {
        let quote = whole.chars().find(|c| ['\'', '"'].contains(c));
        if quote.is_none_or(|quote| whole.matches(quote).count() != 1) {
            break;
        }
        let Some((_, more)) = rest.next() else { break };
        whole.push_str(String::from_utf8_lossy(more).trim());
    }
    whole
}

/// The path of an `INCLUDE` line; none for another line.
fn included(line: &str) -> Option<String> {
    let line = line.trim();
    let rest = line.get(..7).filter(|word| word.eq_ignore_ascii_case("INCLUDE")).and(line.get(7..))?;
    let quote = rest.trim_start().chars().next().filter(|c| ['\'', '"'].contains(c));
    if quote.is_none() && !rest.starts_with(char::is_whitespace) {
        return None;
    }
    let path = match quote {
        Some(quote) => rest.split(quote).nth(1).unwrap_or(""),
        None => rest.split('$').next().unwrap_or(""),
    };
    Some(path.trim().replace('\\', "/"))
}

/// Lines with their numbers, from 1.
fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let plain = |line: &'_ [u8]| line.len() - usize::from(line.ends_with(b"\r"));
    (1..).zip(bytes.split(|b| *b == b'\n').map(move |line| &line[..plain(line)]))
}

/// True if the line begins with this word, in any case.
fn starts_with(line: &[u8], word: &str) -> bool {
    line.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word.as_bytes()))
}

/// True for a line that only a file with executive control has.
fn opens_executive(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    let words: Vec<&[u8]> = line
        .split(|b| b.is_ascii_whitespace() || *b == b',')
        .filter(|word| !word.is_empty())
        .take(2)
        .collect();
    match words[..] {
        [only] => only.eq_ignore_ascii_case(b"CEND"),
        [first, second] => {
            first.eq_ignore_ascii_case(b"CEND")
                || (first.eq_ignore_ascii_case(b"BEGIN") && second.eq_ignore_ascii_case(b"BULK"))
                || (first.eq_ignore_ascii_case(b"SOL") && second.iter().all(u8::is_ascii_alphanumeric))
        }
        _ => false,
    }
}

/// A line of bulk data.
struct BulkLine {
    /// The first field.
    head: String,
    /// Fields without blank ones at the end.
    fields: Vec<String>,
    /// Fields that the line has: eight, or four wide ones.
    width: usize,
    /// Name of the continuation that follows.
    tail: String,
}

struct CardReader {
    found: Cards,
    /// Files being read, outermost first.
    open: Vec<PathBuf>,
    included: usize,
    in_bulk: bool,
    /// `ENDDATA` was read.
    ended: bool,
    /// Cards by the name of the continuation that they wait for.
    waiting: HashMap<String, usize>,
    /// Fields on the lines of each card, blank ones at the end counted.
    places: Vec<usize>,
}

impl CardReader {
    fn read(&mut self, file: &Path, bytes: &[u8]) -> Result<(), MeshError> {
        let name = Arc::new(file.to_path_buf());
        self.open.push(file.to_path_buf());
        let mut all = lines(bytes);
        while let Some((line, text)) = all.next() {
            if self.ended {
                break;
            }
            let plain = text.trim_ascii_start();
            if plain.is_empty() || plain.starts_with(b"$") {
                continue;
            }
            let at = FaultSite { file, place: Location::Line(line), section: "the bulk data" };
            if starts_with(plain, "INCLUDE")
                && let Some(path) = included(&whole(plain, &mut all))
            {
                self.include(&path, &at)?;
                continue;
            }
            let text = text.split(|b| *b == b'$').next().unwrap_or_default().trim_ascii_end();
            if self.in_bulk {
                self.bulk_line(text, &name, &at)?;
            } else {
                self.executive_line(line, text);
            }
        }
        self.open.pop();
        Ok(())
    }

    fn executive_line(&mut self, line: usize, text: &[u8]) {
        let text = text.trim_ascii();
        if starts_with(text, "BEGIN") && opens_executive(text) {
            self.in_bulk = true;
        } else {
            self.found.executive.push((line, String::from_utf8_lossy(text).into_owned()));
        }
    }

    fn bulk_line(&mut self, text: &[u8], file: &Arc<PathBuf>, at: &FaultSite<'_>) -> Result<(), MeshError> {
        let plain = text.trim_ascii_start();
        if starts_with(plain, "ENDDATA") {
            self.ended = true;
            return Ok(());
        }
        if starts_with(plain, "BEGIN ") {
            if self.found.bulk.is_empty() && opens_executive(plain) {
                return Ok(());
            }
            let remedy = "write the model as one residual structure";
            return Err(at.unsupported(shown(plain), "one BEGIN BULK", remedy));
        }
        let line = if text.contains(&b',') { free(text, at)? } else { fixed(text) };
        if line.head.starts_with('=') {
            let remedy = "write every card with all its fields";
            return Err(at.unsupported(format!("a repetition {}", shown(plain)), "a card", remedy));
        }
        if line.head.is_empty() || line.head.starts_with(['+', '*']) {
            return self.go_on(line, at, plain);
        }
        let name = line.head.trim_end_matches('*').trim_end().to_ascii_uppercase();
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !is_name {
            return Err(at.malformed(shown(plain), "a card, like `GRID`"));
        }
        if !line.tail.is_empty() {
            self.waiting.insert(line.tail, self.found.bulk.len());
        }
        let card = Card { name, fields: line.fields, file: file.clone(), line: line_of(at) };
        self.found.bulk.push(card);
        self.places.push(line.width);
        Ok(())
    }

    /// Appends a continuation to the card that waits for its name, else to the last one.
    fn go_on(&mut self, line: BulkLine, at: &FaultSite<'_>, text: &[u8]) -> Result<(), MeshError> {
        let name = continuation(&line.head);
        let place = self.waiting.remove(&name).unwrap_or(self.found.bulk.len().wrapping_sub(1));
        let (Some(card), Some(before)) = (self.found.bulk.get_mut(place), self.places.get_mut(place)) else {
            return Err(at.malformed(shown(text), "a card before its continuation"));
        };
        // A pair of lines of wide fields is one line of small ones.
        if *before % 8 == 4 && line.width == 8 {
            *before += 4;
        }
        if !line.fields.is_empty() {
            card.fields.resize(*before, String::new());
            card.fields.extend(line.fields);
        }
        *before += line.width;
        if !line.tail.is_empty() {
            self.waiting.insert(line.tail, place);
        }
        Ok(())
    }

    /// Reads another file in place of its line; its path is relative to the including file.
    fn include(&mut self, path: &str, at: &FaultSite<'_>) -> Result<(), MeshError> {
        let at = FaultSite { file: at.file, place: at.place, section: "INCLUDE" };
        if path.is_empty() {
            return Err(at.malformed("no file", "the name of a file"));
        }
        let path = at.file.parent().unwrap_or(Path::new("")).join(path);
        self.included += 1;
        // A file that includes itself would never end; one that doubles at each level nearly so.
        if self.open.contains(&path) || self.open.len() > 16 || self.included > 1000 {
            let found = format!("the file {} once more", path.display());
            return Err(at.malformed(found, "at most 1000 files, 16 deep, none inside itself"));
        }
        let bytes = load(&path)?;
        self.read(&path, &bytes)
    }
}

fn line_of(at: &FaultSite<'_>) -> usize {
    match at.place {
        Location::Line(line) => line,
        _ => 0,
    }
}

/// Name of a continuation, without its mark.
fn continuation(field: &str) -> String {
    field.trim_start_matches(['+', '*']).trim().to_ascii_uppercase()
}

fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.trim_ascii()).into_owned()
}

/// Takes a line apart by its commas.
fn free(text: &[u8], at: &FaultSite<'_>) -> Result<BulkLine, MeshError> {
    let mut parts = text.split(|b| *b == b',').map(text_of);
    let head = parts.next().unwrap_or_default();
    let width = if is_wide(&head) { 4 } else { 8 };
    let fields: Vec<String> = parts.by_ref().take(width).collect();
    let tail = parts.next().unwrap_or_default();
    // A value there would be lost without a word.
    if number(&tail).is_some() || parts.any(|part| !part.is_empty()) {
        let expected = format!("a name, {width} fields, and the mark of a continuation");
        return Err(at.malformed(shown(text.trim_ascii_start()), expected));
    }
    Ok(BulkLine { head, fields: filled(fields), width, tail: continuation(&tail) })
}

/// Takes a line apart by columns: eight, or sixteen after a star.
fn fixed(text: &[u8]) -> BulkLine {
    let text = expanded(text);
    let columns = |from: usize, width: usize| {
        let end = (from + width).min(text.len());
        text.get(from..end).map(text_of).unwrap_or_default()
    };
    let head = columns(0, 8);
    let width = if is_wide(&head) { 16 } else { 8 };
    let fields: Vec<String> = (8..72).step_by(width).map(|from| columns(from, width)).collect();
    BulkLine { head, width: fields.len(), fields: filled(fields), tail: continuation(&columns(72, 8)) }
}

/// Fields without blank ones at the end.
fn filled(mut fields: Vec<String>) -> Vec<String> {
    let filled = fields.iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1);
    fields.truncate(filled);
    fields.shrink_to_fit();
    fields
}

fn is_wide(head: &str) -> bool {
    head.starts_with('*') || head.ends_with('*')
}

/// The 80 columns of a line, its tabs as blanks up to the next multiple of eight.
fn expanded(text: &[u8]) -> Cow<'_, [u8]> {
    if !text.contains(&b'\t') {
        return Cow::Borrowed(text);
    }
    let mut columns = Vec::with_capacity(88);
    for &byte in text {
        if byte == b'\t' {
            columns.resize((columns.len() / 8 + 1) * 8, b' ');
        } else {
            columns.push(byte);
        }
        if columns.len() >= 80 {
            break;
        }
    }
    Cow::Owned(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bulk(text: &str) -> Vec<(String, Vec<String>)> {
        let found = cards(Path::new("a.bdf"), text.as_bytes()).unwrap_or_else(|e| panic!("{e}"));
        found.bulk.into_iter().map(|card| (card.name, card.fields)).collect()
    }

    fn one(text: &str) -> Vec<String> {
        let all = bulk(text);
        assert_eq!(all.len(), 1, "{all:?}");
        all.into_iter().next().map(|card| card.1).unwrap_or_default()
    }

    #[test]
    fn fields_are_small_large_and_free() {
        let expected = ["7", "", "1.5", "-2.5-3", "3."];
        for text in [
            "GRID    7               1.5     -2.5-3  3.",
            "GRID*   7                               1.5             -2.5-3\n*       3.",
            "GRID*                  7                             1.5          -2.5-3*G7\n*G7                   3.",
            "GRID,7,,1.5,-2.5-3,3.",
            "grid, 7 , , 1.5,-2.5-3 ,3.,,,,+ $ a comment",
            "GRID*,7,,1.5,-2.5-3,+\n*,3.",
            "GRID\t7\t\t1.5\t-2.5-3\t3.",
            "  GRID,7,,1.5,-2.5-3,3.\r\n",
        ] {
            assert_eq!(one(text), expected, "{text}");
        }
    }

    #[test]
    fn continuations_are_explicit_and_implicit() {
        let expected: Vec<String> = (1..=10).map(|i| i.to_string()).collect();
        for (mark, next) in [("+", "+"), ("+A1", "+A1"), ("", ""), ("", "+")] {
            let mut text = String::from("CHEXA   ");
            (1..=8).for_each(|i| text += &format!("{i:<8}"));
            text += &format!("{mark}\n$ between\n{next:<8}9       10\n");
            assert_eq!(one(&text), expected, "{text}");
        }
        assert_eq!(one("CHEXA,1,2,3,4,5,6,7,8,+\n+,9,10"), expected);
        assert_eq!(one("CHEXA,1,2,3,4,5,6,7,8\n,9,10\n\n"), expected);
        assert_eq!(one("CHEXA*,1,2,3,4\n*,5,6,7,8\n+,9,10"), expected);
        // Short lines are filled up, continuations out of order find their cards.
        assert_eq!(one("A,1,2\n,3"), ["1", "2", "", "", "", "", "", "", "3"]);
        assert_eq!(one("A*,1\n+,3"), ["1", "", "", "", "", "", "", "", "3"]);
        let text = "A,1,,,,,,,,+X\nB,2,,,,,,,,+Y\n+Y,3\n+X,4\n";
        let last = |card: &(String, Vec<String>)| card.1.last().cloned();
        assert_eq!(bulk(text).iter().map(last).collect::<Vec<_>>(), [Some("4".into()), Some("3".into())]);
    }

    #[test]
    fn executive_control_ends_at_begin_bulk() {
        let text = "$ a\nSOL 101 $ b\nCEND\nTITLE = GRID,1\n SPC = 2\nBEGIN BULK\nGRID,1\nENDDATA\n1,2,3\n";
        let found = cards(Path::new("a.bdf"), text.as_bytes()).unwrap();
        let lines: Vec<(usize, &str)> = found.executive.iter().map(|(n, line)| (*n, line.as_str())).collect();
        assert_eq!(lines, [(2, "SOL 101"), (3, "CEND"), (4, "TITLE = GRID,1"), (5, "SPC = 2")]);
        assert_eq!((found.bulk.len(), found.bulk[0].line), (1, 7));
        assert_eq!(bulk("GRID,1\n$\nGRID,2\nENDDATA").len(), 2);
    }

    #[test]
    fn lines_that_are_no_cards_are_refused() {
        let cases = [
            ("+,1", "a card before its continuation"),
            ("GRID,1\n12,3\n", "line 2"),
            ("GRID,1\n=,*1,=\n", "every card with all its fields"),
            ("SPC1,1,2,3,4,5,6,7,8,9", "the mark of a continuation"),
            ("SPC1,1,2,3,4,5,6,7,8,+,10", "the mark of a continuation"),
            ("BEGIN BULK\nGRID,1\nBEGIN SUPER=1\n", "residual structure"),
            ("INCLUDE ''", "the name of a file"),
            ("INCLUDE 'a.bdf'", "none inside itself"),
        ];
        for (text, part) in cases {
            let said = cards(Path::new("a.bdf"), text.as_bytes()).unwrap_err().to_string();
            assert!(said.contains(part), "{text}: {said}");
        }
    }

    #[test]
    fn included_files_stand_in_place_of_their_line() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("deep")).unwrap();
        std::fs::write(at("deep/b.bdf"), "GRID,2\ninclude \"c.txt\"\n").unwrap();
        std::fs::write(at("deep/c.txt"), "GRID,3\n").unwrap();
        let text = "CEND\nBEGIN BULK\nGRID,1\nINCLUDE 'deep/\n   b.bdf'\nGRID,4\n";
        let found = cards(&at("a.bdf"), text.as_bytes()).unwrap();
        assert_eq!(found.bulk.iter().map(|card| card.field(0)).collect::<Vec<_>>(), ["1", "2", "3", "4"]);
        assert_eq!(*found.bulk[2].file, at("deep/c.txt"));
        std::fs::write(at("deep/c.txt"), "INCLUDE b.bdf\n").unwrap();
        let said = cards(&at("a.bdf"), text.as_bytes()).unwrap_err().to_string();
        assert!(said.contains("once more") && said.contains("INCLUDE"), "{said}");
        assert_eq!(included("INCLUDE 'a b.bdf' $ c").as_deref(), Some("a b.bdf"));
        assert_eq!(included("include d\\e.bdf $ c").as_deref(), Some("d/e.bdf"));
        assert_eq!(included("INCLUDED,1"), None);
    }
}
