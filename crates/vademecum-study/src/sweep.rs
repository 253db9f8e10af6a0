//! Many builds: what a sweep file asks for, one problem file for each job, and what became of them
//! (normative: `formats/sweep-1.md`).
//!
//! A job is a line that any scheduler can run, and that can be run again: a build finds its finished stages,
//! and does nothing where the file of its problem is there. So nobody has to keep a list of what is done. A
//! vademecum file holds the text of its problem and the hash of its mesh, which say what it belongs to.

mod look;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use vademecum_build::input::toml_file::{self, TomlError};
use vademecum_build::input::{FILE_KEYS, Problem, ProblemError};

pub use look::{Meshes, Outcome, State, look};

/// Version of [`Plan`].
pub const VERSION: u32 = 1;

/// Most jobs of a sweep.
const MAX_JOBS: usize = 100_000;

/// Problems to build, and keys that change from build to build.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// The problem files; relative paths start at the sweep file.
    #[schemars(length(min = 1))]
    pub problems: Vec<PathBuf>,
    /// Keys that change from job to job.
    #[serde(default)]
    pub(crate) vary: Vec<Vary>,
    /// Combine the first values of all keys, then the second ones, and so on; else every
    /// value of a key meets every one of the others.
    #[serde(default)]
    pub together: bool,
    /// More arguments of every build.
    #[serde(default)]
    pub(crate) arguments: Vec<String>,
}

/// One key of the problem file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Vary {
    /// Its path, such as `material[0].young`.
    pub(crate) key: String,
    /// Its values, of any type.
    #[schemars(schema_with = "some_values")]
    pub(crate) values: Vec<Value>,
}

fn some_values(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "minItems": 1 })
}

/// A sweep that means no jobs.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The file.
    #[error(transparent)]
    File(#[from] TomlError),
    /// A problem file, as it is.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// A problem with the values of a job.
    #[error("{job}, with {values}")]
    Job {
        /// The job.
        job: String,
        /// Its keys and values.
        values: String,
        /// Fault.
        source: Box<ProblemError>,
    },
    /// A key that no problem can have.
    #[error("{path}: `{key}` of `vary` cannot be set in {problem}: {reason}")]
    Key {
        /// The sweep file.
        path: String,
        /// The key.
        key: String,
        /// The problem file.
        problem: String,
        /// Last key of its path.
        reason: String,
    },
}

/// One build.
#[derive(Clone, Debug)]
pub struct Job {
    /// Its number with zeros before it, from 1: the name of its files.
    pub name: String,
    /// The problem file that it varies.
    pub from: PathBuf,
    /// Keys and values.
    pub values: Vec<(String, Value)>,
    /// Its problem file.
    pub text: String,
}

/// The jobs of a sweep, and their order.
#[derive(Clone, Debug)]
pub struct Jobs {
    /// All of them.
    pub jobs: Vec<Job>,
    /// More arguments of every build.
    pub arguments: Vec<String>,
}

impl Sweep {
    /// Reads and checks a sweep file.
    ///
    /// # Errors
    /// [`TomlError`].
    pub fn read(path: &Path) -> Result<Self, TomlError> {
        let name = path.display().to_string();
        let sweep: Sweep = toml_file::parse(&toml_file::read(path)?, &name)?;
        let impossible = |key: String, found: &str, expected: &'static str| {
            Err(TomlError::Impossible {
                path: name.clone(),
                key,
                found: found.into(),
                expected: expected.into(),
            })
        };
        if sweep.problems.is_empty() {
            return impossible("problems".into(), "empty", "one problem file or more");
        }
        for (i, vary) in sweep.vary.iter().enumerate() {
            if vary.values.is_empty() {
                return impossible(format!("vary[{i}].values"), "empty", "one value or more");
            }
            if sweep.vary[..i].iter().any(|other| other.key == vary.key) {
                let found = format!("{:?} a second time", vary.key);
                return impossible(format!("vary[{i}].key"), &found, "each key once");
            }
            if sweep.together && vary.values.len() != sweep.vary[0].values.len() {
                let found = format!("{} values", vary.values.len());
                return impossible(
                    format!("vary[{i}].values"),
                    &found,
                    "as many values for each key, where `together = true`",
                );
            }
        }
        let count = sweep.combinations().and_then(|count| count.checked_mul(sweep.problems.len()));
        if count.is_none_or(|count| count > MAX_JOBS) {
            return impossible("vary".into(), "too many jobs", "at most 100 000");
        }
        Ok(sweep)
    }

    /// Combinations of values; none if there are more than can be counted.
    fn combinations(&self) -> Option<usize> {
        match self.together {
            true => Some(self.vary.first().map_or(1, |vary| vary.values.len())),
            false => self.vary.iter().try_fold(1_usize, |count, vary| count.checked_mul(vary.values.len())),
        }
    }

    /// The values of a combination; the last key changes first.
    fn combination(&self, mut number: usize) -> Vec<(String, Value)> {
        let mut values: Vec<_> = self
            .vary
            .iter()
            .rev()
            .map(|vary| {
                let at = if self.together { number } else { number % vary.values.len() };
                if !self.together {
                    number /= vary.values.len();
                }
                (vary.key.clone(), vary.values[at].clone())
            })
            .collect();
        values.reverse();
        values
    }

    /// The jobs of a sweep that was read from `path`. Every problem is checked as a build checks it before it
    /// reads a mesh.
    ///
    /// # Errors
    /// [`SweepError`].
    pub fn jobs(&self, path: &Path) -> Result<Jobs, SweepError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let combinations = self.combinations().unwrap_or(0);
        let digits = (combinations * self.problems.len()).to_string().len();
        let mut jobs: Vec<Job> = vec![];
        for problem in &self.problems {
            let from = folder.join(problem);
            let found = Problem::read(&from)?;
            let mut table: Table = toml_file::table(&found.text, &found.path)?;
            for key in FILE_KEYS {
                with_whole_paths(&mut table, key, &found);
            }
            for number in 0..combinations {
                let values = self.combination(number);
                let name = format!("{:0digits$}", jobs.len() + 1);
                let mut own = table.clone();
                for (key, value) in &values {
                    set(&mut own, key, value).map_err(|reason| SweepError::Key {
                        path: path.display().to_string(),
                        key: key.clone(),
                        problem: from.display().to_string(),
                        reason,
                    })?;
                }
                let text = text_of(&name, &from, &values, &own);
                let checked = Problem::parse(&text, &format!("{name}.toml"), PathBuf::new());
                if let Err(source) = checked {
                    let (job, values) = (format!("job {name} of {}", path.display()), in_words(&values));
                    return Err(SweepError::Job { job, values, source: source.into() });
                }
                jobs.push(Job { name, from: from.clone(), values, text });
            }
        }
        Ok(Jobs { jobs, arguments: self.arguments.clone() })
    }
}

/// Makes the files that a key names whole paths, wherever the job's own file will lie.
fn with_whole_paths(table: &mut Table, key: &str, problem: &Problem) {
    let mut parts = key.split('.');
    let last = parts.next_back().unwrap_or_default();
    let mut at = Some(table);
    for part in parts {
        at = at.and_then(|table| table.get_mut(part)).and_then(Value::as_table_mut);
    }
    let whole = |value: &mut Value| {
        if let Value::String(path) = value {
            let path = problem.resolve(Path::new(&path));
            *value = std::path::absolute(&path).unwrap_or(path).display().to_string().into();
        }
    };
    match at.and_then(|table| table.get_mut(last)) {
        Some(Value::Array(paths)) => paths.iter_mut().for_each(whole),
        Some(value) => whole(value),
        None => {}
    }
}

/// Sets a key such as `material[0].young`; tables on the way are made, entries of a list are not.
fn set(table: &mut Table, key: &str, value: &Value) -> Result<(), String> {
    let (part, rest) = key.split_once('.').map_or((key, None), |(part, rest)| (part, Some(rest)));
    let (name, index) = match part.split_once('[') {
        Some((name, index)) => {
            let index = index.strip_suffix(']').and_then(|index| index.parse::<usize>().ok());
            (name, Some(index.ok_or_else(|| format!("`{part}` is no name, and no `name[number]`"))?))
        }
        None => (part, None),
    };
    if name.is_empty() {
        return Err("a part of it is empty".into());
    }
    let place = match index {
        Some(index) => {
            let list = table.get_mut(name).and_then(Value::as_array_mut);
            let list = list.ok_or_else(|| format!("there is no list `{name}`"))?;
            let length = list.len();
            list.get_mut(index).ok_or_else(|| format!("`{name}` has {length} entries, the first is [0]"))?
        }
        None if rest.is_some() => table.entry(name).or_insert_with(|| Value::Table(Table::new())),
        None => {
            table.insert(name.into(), value.clone());
            return Ok(());
        }
    };
    match (rest, place) {
        (None, place) => {
            *place = value.clone();
            Ok(())
        }
        (Some(rest), Value::Table(inner)) => set(inner, rest, value),
        (Some(_), Value::Array(_)) => Err(format!("`{name}` is a list: say which entry, as in `{name}[0]`")),
        (Some(_), _) => Err(format!("`{part}` is a value and has no keys")),
    }
}

fn text_of(name: &str, from: &Path, values: &[(String, Value)], table: &Table) -> String {
    let with = if values.is_empty() { String::new() } else { format!(" with {}", in_words(values)) };
    let head = format!("job {name}: {}{with}", from.display());
    // A name may hold what would end a comment.
    let head: String = head.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    format!("# {head}\n{table}")
}

fn in_words(values: &[(String, Value)]) -> String {
    values.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

impl Jobs {
    /// The list of jobs: for each a line of a shell, which can be run from anywhere. `folder` is where the
    /// files of the jobs lie.
    ///
    /// # Errors
    /// The folder has no whole path.
    pub fn lines(&self, folder: &Path) -> std::io::Result<Vec<String>> {
        let folder = std::path::absolute(folder)?;
        let line = |job: &Job| {
            let file = |ending: &str| folder.join(format!("{}.{ending}", job.name)).display().to_string();
            let mut line = format!("vademecum build {} -o {}", quoted(&file("toml")), quoted(&file("vdm")));
            line.push_str(" --once --quiet");
            for argument in &self.arguments {
                write!(line, " {}", quoted(argument)).expect("a string");
            }
            line
        };
        Ok(self.jobs.iter().map(line).collect())
    }

    /// Plan for the collection of the jobs, whose files are in `folder`.
    ///
    /// # Errors
    /// As [`Jobs::lines`].
    pub fn plan(&self, folder: &Path) -> std::io::Result<Plan> {
        let planned = |(job, line): (&Job, String)| PlannedJob {
            name: job.name.clone(),
            problem: job.from.display().to_string(),
            values: job.values.iter().cloned().collect(),
            line,
        };
        Ok(Plan { version: VERSION, jobs: self.jobs.iter().zip(self.lines(folder)?).map(planned).collect() })
    }
}

/// For a shell: as it is where nothing in it means anything to one, else between single quotes.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=+,:@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.into()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

/// The jobs of a folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Of this description.
    pub version: u32,
    /// All jobs, in the order of their list.
    pub jobs: Vec<PlannedJob>,
}

/// A job as it was planned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedJob {
    /// The name of its files.
    pub name: String,
    /// The problem file that it varies.
    pub problem: String,
    /// Keys and values.
    pub values: Table,
    /// Command line.
    pub line: String,
}
