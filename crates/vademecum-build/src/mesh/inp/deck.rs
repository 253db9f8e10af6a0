//! The card structure of Abaqus and CalculiX decks: keyword lines with parameters, data lines, included
//! files.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::mesh::error::{FaultSite, MeshError, shown};
use crate::mesh::load::load;
use crate::mesh::place::Location;

/// A keyword of an Abaqus or CalculiX deck with its parameters and data lines.
#[derive(Clone, Debug)]
pub struct InpCard {
    /// In capitals, without the star.
    pub keyword: String,
    /// Names in capitals, and values; empty for a flag.
    pub parameters: Vec<(String, String)>,
    /// Position of the keyword.
    pub place: LineLocation,
    /// Lines of data.
    pub data: Vec<DataLine>,
}

/// A line of data that is not blank.
#[derive(Clone, Debug)]
pub struct DataLine {
    /// The line, trimmed.
    pub text: String,
    /// Its position.
    pub place: LineLocation,
}

/// A line of one of the files of a deck.
#[derive(Clone, Debug)]
pub struct LineLocation {
    file: Rc<PathBuf>,
    line: usize,
}

impl LineLocation {
    pub(crate) fn at<'a>(&'a self, section: &'a str) -> FaultSite<'a> {
        FaultSite { file: &self.file, place: Location::Line(self.line), section }
    }

    pub(crate) fn place(&self) -> Location {
        Location::Line(self.line)
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// The line, counted from 1.
    pub fn line(&self) -> usize {
        self.line
    }
}

impl InpCard {
    /// The value of a parameter, empty for a flag; none if it is absent. Blanks in names do not count:
    /// `REFNODE` is `REF NODE`.
    pub fn parameter(&self, name: &str) -> Option<&str> {
        let letters = |text: &str| text.split(' ').collect::<String>();
        let wanted = letters(name);
        self.parameters.iter().find(|(key, _)| letters(key) == wanted).map(|(_, value)| value.as_str())
    }

    /// The keyword with its star.
    pub fn section(&self) -> String {
        format!("*{}", self.keyword)
    }
}

impl DataLine {
    /// Values between commas, trimmed, without empty ones at the end.
    pub fn fields(&self) -> Vec<&str> {
        let mut fields: Vec<&str> = self.text.split(',').map(str::trim).collect();
        while fields.last().is_some_and(|f| f.is_empty()) {
            fields.pop();
        }
        fields
    }
}

/// Reads the cards of a deck, with all files it includes.
pub(crate) fn cards(file: &Path, bytes: &[u8]) -> Result<Vec<InpCard>, MeshError> {
    let mut reader = DeckReader { cards: Vec::new(), open: Vec::new(), included: 0 };
    reader.read(file, bytes)?;
    Ok(reader.cards)
}

struct DeckReader {
    cards: Vec<InpCard>,
    /// Files being read, outermost first.
    open: Vec<PathBuf>,
    included: usize,
}

impl DeckReader {
    fn read(&mut self, file: &Path, bytes: &[u8]) -> Result<(), MeshError> {
        let name = Rc::new(file.to_path_buf());
        self.open.push(file.to_path_buf());
        let lossy = String::from_utf8_lossy(bytes);
        let mut lines = lossy.lines().zip(1..);
        while let Some((line, number)) = lines.next() {
            let line = line.trim();
            let place = LineLocation { file: name.clone(), line: number };
            if line.is_empty() || line.starts_with("**") {
                continue;
            }
            let Some(head) = line.strip_prefix('*') else {
                self.data_line(line, place)?;
                continue;
            };
            let mut head = head.to_string();
            while head.ends_with(',') {
                let Some((more, _)) = lines.next() else { break };
                head.push_str(more.trim());
            }
            self.keyword_line(&head, place)?;
        }
        self.open.pop();
        Ok(())
    }

    fn data_line(&mut self, line: &str, place: LineLocation) -> Result<(), MeshError> {
        match self.cards.last_mut() {
            Some(card) => {
                card.data.push(DataLine { text: line.to_string(), place });
                Ok(())
            }
            None => {
                Err(place.at("the deck").malformed(shown(line.as_bytes()), "a keyword line, like `*NODE`"))
            }
        }
    }

    fn keyword_line(&mut self, head: &str, place: LineLocation) -> Result<(), MeshError> {
        let mut parts = head.split(',');
        let keyword = one_space(parts.next().unwrap_or(""));
        let parameter = |part: &str| {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            (one_space(key), value.trim().trim_matches('"').to_string())
        };
        let parameters = parts.filter(|p| !p.trim().is_empty()).map(parameter).collect();
        let card = InpCard { keyword, parameters, place, data: Vec::new() };
        let input = card.parameter("INPUT").map(str::to_string);
        let mesh_card = matches!(card.keyword.as_str(), "NODE" | "ELEMENT" | "NSET" | "ELSET" | "SURFACE");
        let (include, place) = (card.keyword == "INCLUDE", card.place.clone());
        if !include {
            self.cards.push(card);
        }
        match input {
            Some(path) if include || mesh_card => self.include(&path, &place),
            None if include => Err(place.at("*INCLUDE").malformed("no INPUT", "INPUT=file")),
            _ => Ok(()),
        }
    }

    /// Reads another file in place of its keyword; its path is relative to the including file.
    fn include(&mut self, path: &str, place: &LineLocation) -> Result<(), MeshError> {
        let path = place.file.parent().unwrap_or(Path::new("")).join(path);
        self.included += 1;
        // A deck that includes itself would never end; one that doubles at each level nearly so.
        if self.open.contains(&path) || self.open.len() > 16 || self.included > 1000 {
            let found = format!("the file {} once more", path.display());
            return Err(place
                .at("*INCLUDE")
                .malformed(found, "at most 1000 files, 16 deep, none inside itself"));
        }
        let bytes = load(&path)?;
        self.read(&path, &bytes)
    }
}

/// In capitals, with single spaces.
fn one_space(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").to_ascii_uppercase()
}
