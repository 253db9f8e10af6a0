//! Ranges of the numbers of a problem file: one table that feeds the checks, the JSON Schema and the page
//! `formats/problem-1.md`.
//!
//! Rules between keys are in `check`; a range is of one number alone.

use std::fmt::{Debug, Display, Formatter, Result as Written};
use std::ops::Bound::{self, Excluded, Included, Unbounded};
use std::ops::RangeBounds;

use schemars::Schema;
use serde_json::{Map, Value};
use vademecum_format::{MAX_MODES, MAX_TERMS};

use super::{ChapterEntry, FoundationEntry, LargeEntry, Problem, ProblemError};
use crate::limits::MAGNITUDE;
use crate::mesh::CELLS;

/// The range of the number, or of every number, at one key.
struct Row {
    /// The key; `[]` stands for the index of an entry.
    key: &'static str,
    /// The numbers at the key: one for each entry where it has `[]`.
    numbers: fn(&Problem) -> Vec<f64>,
    range: Range,
    /// Noun for the number, for messages.
    noun: &'static str,
    /// The reason, for messages; may be empty.
    why: &'static str,
}

#[derive(Clone, Copy)]
struct Range(Bound<f64>, Bound<f64>);

const POSITIVE: Range = Range(Included(MAGNITUDE.0), Included(MAGNITUDE.1));
const FACTOR: Range = Range(Included(0.0), Included(MAGNITUDE.1));
const DAMPING_RATIO: Range = between(0.0, 1000.0);

const fn between(lower: f64, upper: f64) -> Range {
    Range(Included(lower), Included(upper))
}

const fn at_least(lower: f64) -> Range {
    Range(Included(lower), Unbounded)
}

const fn row(
    key: &'static str,
    numbers: fn(&Problem) -> Vec<f64>,
    range: Range,
    noun: &'static str,
    why: &'static str,
) -> Row {
    Row { key, numbers, range, noun, why }
}

const HELD: &str = "the most a vademecum file holds";
const CARRIED: &str = "double precision can hold its products";

const ROWS: &[Row] = &[
    row("mesh.scale", |p| vec![p.mesh.scale], POSITIVE, "a positive factor", CARRIED),
    row(
        "mesh.cells",
        |p| p.mesh.cells.map(f64::from).into_iter().collect(),
        between(*CELLS.start() as f64, *CELLS.end() as f64),
        "cells along the longest side of a surface",
        "",
    ),
    row(
        "mesh.smallest_part",
        |p| vec![p.mesh.smallest_part],
        between(0.0, 1.0),
        "a share of the elements",
        "",
    ),
    row("mesh.block.lengths", |p| block(p, |b| b.lengths), POSITIVE, "positive lengths", CARRIED),
    row("mesh.block.divisions", |p| block(p, |b| b.divisions.map(real)), at_least(1.0), "counts", ""),
    row(
        "material[].young",
        |p| p.materials.iter().map(|m| m.young.unwrap_or(1.0)).collect(),
        POSITIVE,
        "a positive modulus",
        CARRIED,
    ),
    row(
        "material[].poisson",
        |p| p.materials.iter().map(|m| m.poisson.unwrap_or(0.0)).collect(),
        Range(Excluded(-1.0), Excluded(0.5)),
        "a ratio",
        "",
    ),
    row(
        "material[].density",
        |p| p.materials.iter().map(|m| m.density).collect(),
        POSITIVE,
        "a positive density",
        CARRIED,
    ),
    row(
        "material[].loss_factor",
        |p| p.materials.iter().map(|m| m.loss_factor.unwrap_or(0.0)).collect(),
        between(0.0, 2.0),
        "twice a damping ratio",
        "",
    ),
    row(
        "point_mass[].mass",
        |p| p.point_masses.iter().map(|m| m.mass).collect(),
        FACTOR,
        "zero or a positive mass",
        CARRIED,
    ),
    row("tie[].distance", |p| p.ties.iter().map(|t| t.distance).collect(), FACTOR, "a distance", CARRIED),
    row("foundation[].normal", |p| grounds(p, |g| g.normal), FACTOR, "a stiffness per area", CARRIED),
    row("foundation[].tangential", |p| grounds(p, |g| g.tangential), FACTOR, "a stiffness per area", CARRIED),
    row(
        "foundation[].damping_normal",
        |p| grounds(p, |g| g.damping_normal),
        FACTOR,
        "a damping per area",
        CARRIED,
    ),
    row(
        "foundation[].damping_tangential",
        |p| grounds(p, |g| g.damping_tangential),
        FACTOR,
        "a damping per area",
        CARRIED,
    ),
    row("damping.alpha", |p| one(p.damping.alpha), FACTOR, "zero or a positive number", CARRIED),
    row("damping.beta", |p| one(p.damping.beta), FACTOR, "zero or a positive number", CARRIED),
    row("damping.ratio", |p| one(p.damping.ratio), DAMPING_RATIO, "a ratio", "1 is critical damping"),
    row(
        "damping.modal",
        |p| p.damping.modal.clone().unwrap_or_default(),
        DAMPING_RATIO,
        "ratios",
        "1 is critical damping",
    ),
    row(
        "prestress.speed",
        |p| one(p.prestress.as_ref().and_then(|p| p.speed)),
        POSITIVE,
        "a positive angular velocity in rad/s",
        CARRIED,
    ),
    row("time.step", |p| one(p.time.step), POSITIVE, "a positive time in seconds", CARRIED),
    row(
        "snapshots.positions",
        |p| vec![real(p.snapshots.positions)],
        between(1.0, 10_000.0),
        "a count",
        "a basis needs some tens of load positions, and each is marched in every direction",
    ),
    row("snapshots.hold", |p| one(p.snapshots.hold), POSITIVE, "a positive time in seconds", CARRIED),
    row("snapshots.duration", |p| one(p.snapshots.duration), POSITIVE, "a positive time in seconds", CARRIED),
    row("snapshots.stride", |p| count(p.snapshots.stride), at_least(1.0), "a count", ""),
    row("basis.modes", |p| count(p.basis.modes), between(1.0, MAX_MODES as f64), "a count", HELD),
    row("basis.energy", |p| one(p.basis.energy), Range(Excluded(0.0), Excluded(1.0)), "a fraction", ""),
    row(
        "basis.error",
        |p| one(p.basis.error),
        Range(Included(1e-5), Excluded(1.0)),
        "a share of the static response",
        "below 1e-5 rounding counts",
    ),
    row(
        "basis.oversampling",
        |p| vec![real(p.basis.oversampling)],
        between(1.0, 1000.0),
        "a count",
        "beyond some tens of POD vectors per mode the rest is rounding",
    ),
    row("tolerance.floor_ratio", |p| vec![p.tolerance.floor_ratio], at_least(1.0), "a ratio", ""),
    row(
        "tolerance.absolute",
        |p| vec![p.tolerance.absolute],
        at_least(1e-13),
        "an error",
        "the accuracy of double precision",
    ),
    row(
        "tolerance.error",
        |p| vec![p.tolerance.error],
        Range(Excluded(0.0), Excluded(f64::INFINITY)),
        "a finite number",
        "",
    ),
    row("tolerance.steps", |p| count(p.tolerance.steps), at_least(10.0), "a count", ""),
    row(
        "tolerance.map",
        |p| vec![p.tolerance.map],
        at_least(1e-11),
        "an error",
        "the accuracy of the separation in double precision",
    ),
    row(
        "tolerance.max_terms",
        |p| vec![real(p.tolerance.max_terms)],
        between(1.0, MAX_TERMS as f64),
        "a count",
        HELD,
    ),
    row(
        "output.contact_patch",
        |p| one(p.output.contact_patch),
        POSITIVE,
        "a positive length in metres",
        CARRIED,
    ),
    row("output.contact_modes", |p| count(p.output.contact_modes), between(0.0, 512.0), "a count", ""),
    row(
        "output.gauge[].length",
        |p| p.output.gauges.iter().map(|g| g.length).collect(),
        POSITIVE,
        "a positive length in metres",
        CARRIED,
    ),
    row(
        "canonical.tolerance",
        |p| chapter(p, |c| Some(c.tolerance)),
        Range(Included(1e-12), Excluded(1.0)),
        "an error",
        "",
    ),
    row(
        "canonical.max_terms",
        |p| chapter(p, |c| c.max_terms.map(real)),
        between(2.0, MAX_TERMS as f64),
        "a count",
        HELD,
    ),
    row("canonical.points", |p| chapter(p, |c| Some(real(c.points))), between(2.0, 1000.0), "a count", ""),
    row(
        "canonical.margin",
        |p| chapter(p, |c| Some(c.margin)),
        between(0.0, 1e6),
        "a share of the range",
        "",
    ),
    row(
        "canonical.positions",
        |p| chapter(p, |c| c.positions.map(real)),
        between(1.0, 10_000.0),
        "a count",
        "",
    ),
    row(
        "large.displacement",
        |p| large(p, |l| l.displacement),
        POSITIVE,
        "a positive length in metres",
        CARRIED,
    ),
    row("large.rows", |p| large(p, |l| l.rows.map(real)), between(0.0, 4096.0), "a count", ""),
    row("large.states", |p| large(p, |l| l.states.map(real)), between(1.0, 100_000.0), "a count", ""),
    row("large.pushes", |p| large(p, |l| l.pushes.map(real)), between(1.0, 1000.0), "a count", ""),
];

fn real(count: usize) -> f64 {
    count as f64
}

fn one(number: Option<f64>) -> Vec<f64> {
    number.into_iter().collect()
}

fn count(count: Option<usize>) -> Vec<f64> {
    one(count.map(real))
}

fn grounds(problem: &Problem, of: fn(&FoundationEntry) -> f64) -> Vec<f64> {
    problem.foundations.iter().map(of).collect()
}

fn block(problem: &Problem, of: fn(&super::BlockSource) -> [f64; 3]) -> Vec<f64> {
    problem.mesh.block.iter().flat_map(of).collect()
}

fn chapter(problem: &Problem, of: fn(&ChapterEntry) -> Option<f64>) -> Vec<f64> {
    problem.canonical.iter().filter_map(of).collect()
}

fn large(problem: &Problem, of: fn(&LargeEntry) -> Option<f64>) -> Vec<f64> {
    problem.large.iter().filter_map(of).collect()
}

impl Problem {
    /// Checks every number that has a row in the table.
    pub(super) fn check_ranges(&self) -> Result<(), ProblemError> {
        for row in ROWS {
            for (i, number) in (row.numbers)(self).into_iter().enumerate() {
                if !row.range.contains(number) {
                    let key = row.key.replace("[]", &format!("[{i}]"));
                    return self.require_with(false, &key, || found(number), row.expected());
                }
            }
        }
        Ok(())
    }
}

/// A number as the file has it: counts are whole, and other numbers have a decimal point or an exponent.
fn found(number: f64) -> String {
    if number.fract() == 0.0 && number.abs() < 1e19 { format!("{number}") } else { format!("{number:?}") }
}

impl Row {
    fn expected(&self) -> String {
        let reason = if self.why.is_empty() { String::new() } else { format!(": {}", self.why) };
        format!("{} {}{reason}", self.noun, self.range)
    }
}

impl Range {
    fn contains(self, number: f64) -> bool {
        (self.0, self.1).contains(&number)
    }

    /// The keywords of JSON Schema.
    fn keywords(self) -> impl Iterator<Item = (&'static str, Value)> {
        let named = |bound, included, excluded| match bound {
            Included(at) => Some((included, at)),
            Excluded(at) => Some((excluded, at)),
            Unbounded => None,
        };
        let bounds =
            [named(self.0, "minimum", "exclusiveMinimum"), named(self.1, "maximum", "exclusiveMaximum")];
        let whole = |at: f64| at.fract() == 0.0 && at.abs() < 1e15;
        let json = move |at: f64| if whole(at) { (at as i64).into() } else { at.into() };
        bounds.into_iter().flatten().filter(|(_, at)| at.is_finite()).map(move |(word, at)| (word, json(at)))
    }
}

/// Words that follow a noun: `from 1 to 10 000`, `above 0 and below 1`.
impl Display for Range {
    fn fmt(&self, out: &mut Formatter<'_>) -> Written {
        match (self.0, self.1) {
            (Included(a), Included(b)) => write!(out, "from {:?} to {:?}", Number(a), Number(b)),
            (Included(a), Excluded(b)) => {
                write!(out, "of at least {:?} and below {:?}", Number(a), Number(b))
            }
            (Excluded(a), Excluded(b)) if b.is_finite() => {
                write!(out, "above {:?} and below {:?}", Number(a), Number(b))
            }
            (Included(a), _) => write!(out, "of at least {:?}", Number(a)),
            (Excluded(a), _) => write!(out, "above {:?}", Number(a)),
            (Unbounded, _) => Ok(()),
        }
    }
}

/// A number in a message: `0.3`, `65 536`, `1e-30`.
struct Number(f64);

impl Debug for Number {
    fn fmt(&self, out: &mut Formatter<'_>) -> Written {
        let Self(number) = *self;
        match number.abs() {
            _ if number.fract() != 0.0 => write!(out, "{number:?}"),
            0.0..1e4 => write!(out, "{number}"),
            1e4..1e6 => write!(out, "{} {:03}", (number / 1e3).trunc(), (number % 1e3).abs()),
            _ => write!(out, "{number:e}"),
        }
    }
}

/// The JSON Schema of a problem file: keys, types, choices and defaults of the types, ranges of the table.
pub fn problem_schema() -> Schema {
    let mut schema = schemars::schema_for!(Problem);
    let mut root = Value::Object(schema.as_object().cloned().unwrap_or_default());
    for row in ROWS {
        let steps = row.key.split('.').map(|step| step.trim_end_matches("[]"));
        if let Some(place) = place_of(&root, steps)
            && let Some(Value::Object(number)) = root.pointer_mut(&place)
        {
            number.extend(row.range.keywords().map(|(word, bound)| (word.to_string(), bound)));
        }
    }
    if let Value::Object(root) = root {
        schema = root.into();
    }
    schema
}

/// The pointer to the schema of the numbers at a key.
fn place_of<'a>(root: &Value, steps: impl Iterator<Item = &'a str>) -> Option<String> {
    let mut place = String::new();
    for step in steps {
        place = table(root, place)?;
        place.push_str(&format!("/properties/{step}"));
        root.pointer(&place)?;
    }
    // Of an array the range is that of its items.
    while root.pointer(&place)?.get("items").is_some() {
        place.push_str("/items");
    }
    Some(place)
}

/// Follows items, choices and references to the schema with properties.
fn table(root: &Value, mut place: String) -> Option<String> {
    loop {
        let here: &Map<String, Value> = root.pointer(&place)?.as_object()?;
        if let Some(Value::String(target)) = here.get("$ref") {
            place = target.trim_start_matches('#').to_string();
        } else if here.contains_key("anyOf") {
            place.push_str("/anyOf/0");
        } else if here.contains_key("items") {
            place.push_str("/items");
        } else {
            return Some(place);
        }
    }
}

/// The table of ranges of the page, in Markdown.
pub fn range_table() -> String {
    let words = |range: Range| range.to_string().trim_start_matches("of ").to_string();
    let line = |row: &Row| format!("| `{}` | {} |\n", row.key, words(row.range));
    format!("| key | range |\n|---|---|\n{}", ROWS.iter().map(line).collect::<String>())
}
