//! The JSON Schema of problem, scenario and sweep files: it takes every fixture and every example of the
//! pages, refuses slips, and has exactly the keys of the pages.

use std::collections::BTreeSet;

use serde_json::{Value, json};
use vademecum_tests::program::{repository, vademecum};

fn schema(of: &str) -> Value {
    let ran = vademecum(&["schema", of]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let schema: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    schema
}

/// Keywords that say something of a value, and those that only tell people about it.
const CHECKED: [&str; 17] = [
    "$ref",
    "type",
    "properties",
    "required",
    "additionalProperties",
    "enum",
    "const",
    "oneOf",
    "anyOf",
    "items",
    "minItems",
    "maxItems",
    "minimum",
    "maximum",
    "exclusiveMinimum",
    "exclusiveMaximum",
    "$defs",
];
const TOLD: [&str; 6] = ["$schema", "title", "description", "default", "format", "prefixItems"];

/// Why a value is none of a schema; a keyword that is not known here is a fault of the schema.
fn fault(root: &Value, schema: &Value, value: &Value, at: &str) -> Option<String> {
    let Some(rules) = schema.as_object() else {
        return (schema == &Value::Bool(false)).then(|| format!("{at} is not allowed"));
    };
    for key in rules.keys() {
        assert!(CHECKED.contains(&key.as_str()) || TOLD.contains(&key.as_str()), "the schema has `{key}`");
    }
    let wrong = |what: &str| Some(format!("{at}: {value} is not {what}"));
    if let Some(path) = rules.get("$ref").and_then(Value::as_str) {
        let target = root.pointer(path.trim_start_matches('#')).expect("what is referred to");
        if let Some(fault) = fault(root, target, value, at) {
            return Some(fault);
        }
    }
    if let Some(types) = rules.get("type") {
        let types: Vec<&str> = match types {
            Value::Array(names) => names.iter().filter_map(Value::as_str).collect(),
            name => name.as_str().into_iter().collect(),
        };
        let is = |name: &&str| match *name {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "null" => value.is_null(),
            "integer" => value.is_i64() || value.is_u64(),
            "number" => value.is_number(),
            name => panic!("the schema has the type `{name}`"),
        };
        if !types.iter().any(is) {
            return wrong(&format!("of {types:?}"));
        }
    }
    if rules.get("const").is_some_and(|only| only != value) {
        return wrong("the constant");
    }
    if rules.get("enum").and_then(Value::as_array).is_some_and(|all| !all.contains(value)) {
        return wrong("one of the choices");
    }
    let number = |key: &str| rules.get(key).and_then(Value::as_f64);
    if let Some(found) = value.as_f64()
        && (number("minimum").is_some_and(|least| found < least)
            || number("maximum").is_some_and(|most| found > most)
            || number("exclusiveMinimum").is_some_and(|bound| found <= bound)
            || number("exclusiveMaximum").is_some_and(|bound| found >= bound))
    {
        return wrong("in its range");
    }
    if let Some(items) = value.as_array() {
        let count = items.len() as f64;
        if number("minItems").is_some_and(|least| count < least)
            || number("maxItems").is_some_and(|most| count > most)
        {
            return wrong("of that length");
        }
        if let Some(each) = rules.get("items") {
            let faults =
                items.iter().enumerate().map(|(i, item)| fault(root, each, item, &format!("{at}[{i}]")));
            if let Some(fault) = faults.flatten().next() {
                return Some(fault);
            }
        }
    }
    if let Some(object) = value.as_object() {
        let empty = serde_json::Map::new();
        let properties = rules.get("properties").and_then(Value::as_object).unwrap_or(&empty);
        let required = rules.get("required").and_then(Value::as_array);
        for key in required.into_iter().flatten().filter_map(Value::as_str) {
            if !object.contains_key(key) {
                return Some(format!("{at} has no `{key}`"));
            }
        }
        for (key, value) in object {
            let below = format!("{at}.{key}");
            let rule = properties.get(key).or(rules.get("additionalProperties"));
            if let Some(fault) = rule.and_then(|rule| fault(root, rule, value, &below)) {
                return Some(fault);
            }
        }
    }
    for (key, all) in [("oneOf", false), ("anyOf", true)] {
        let Some(choices) = rules.get(key).and_then(Value::as_array) else { continue };
        let faults: Vec<_> = choices.iter().map(|choice| fault(root, choice, value, at)).collect();
        let fits = faults.iter().filter(|fault| fault.is_none()).count();
        if fits == 0 || (fits > 1 && !all) {
            return Some(format!("{at} fits {fits} of {key}: {faults:?}"));
        }
    }
    None
}

fn of_toml(text: &str) -> Value {
    let table: toml::Table = text.parse().expect("TOML");
    serde_json::to_value(table).expect("JSON")
}

fn examples(page: &str) -> Vec<String> {
    let page = std::fs::read_to_string(repository().join("formats").join(page)).expect("a page");
    let blocks =
        page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().expect("closed").to_string());
    blocks.collect()
}

fn fixtures(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(repository().join("fixtures").join(folder)).expect("fixtures");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let toml = paths.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
    toml.map(|path| std::fs::read_to_string(path).expect("readable")).collect()
}

const BEAM: &str = "[mesh]\nblock = { lengths = [1.0, 0.1, 0.1], divisions = [4, 1, 1] }\n[[material]]\nyoung = 2e9\n\
                    poisson = 0.3\ndensity = 1200\n[[support]]\non = { group = \"x_min\" }\n";

#[test]
fn fixtures_and_examples_fit_the_schema_and_slips_do_not() {
    let problem = schema("problem");
    let fits = |schema: &Value, text: &str| fault(schema, schema, &of_toml(text), "");
    assert_eq!(fits(&problem, BEAM), None);
    for text in fixtures("problems") {
        assert_eq!(fits(&problem, &text), None, "{text}");
    }
    for mut text in examples("problem-1.md") {
        if !text.contains("[mesh") {
            text += "\n[mesh]\nfile = \"a.msh\"\n";
        }
        assert_eq!(fits(&problem, &text), None, "{text}");
    }
    for word in ["block", "chapter", "canonical"] {
        let text = format!("representation = \"{word}\"\n{BEAM}");
        assert_eq!(fits(&problem, &text), None, "{text}");
    }
    for (from, to) in [
        ("young", "yung"),
        ("[[material]]", "[material]"),
        ("2e9", "\"2e9\""),
        ("[1.0, 0.1, 0.1]", "[1.0, 0.1]"),
        ("[4, 1, 1]", "[4, 1, 1.5]"),
        ("[4, 1, 1]", "[-4, 1, 1]"),
        ("{ group = \"x_min\" }", "{ grup = \"x_min\" }"),
        ("{ group = \"x_min\" }", "{ group = \"x_min\", nodes = [1] }"),
        ("density = 1200\n", ""),
        ("poisson = 0.3", "poisson = 0.5"),
        ("2e9", "0.0"),
        ("[4, 1, 1]", "[4, 0, 1]"),
        ("[1.0, 0.1, 0.1]", "[1.0, 0.0, 0.1]"),
        ("[mesh]", "[basis]\nmodes = 5000\n[mesh]"),
        ("[mesh]", "model = \"large-displacement\"\nlarge = { pushes = 0 }\n[mesh]"),
        ("[mesh]", "[time]\nscheme = { name = \"bathe\", beta = 1.0 }\n[mesh]"),
        ("[mesh]", "[time]\nscheme = { name = \"newmark\", beta = 1.0 }\n[mesh]"),
        ("[mesh]", "representation = \"blok\"\n[mesh]"),
        ("[mesh]", "text = \"\"\n[mesh]"),
    ] {
        assert!(BEAM.contains(from), "{from}");
        let slip = BEAM.replacen(from, to, 1);
        assert!(fits(&problem, &slip).is_some(), "{slip}");
    }

    let scenario = schema("scenario");
    for text in fixtures("scenarios").into_iter().chain(examples("scenario-1.md")) {
        assert_eq!(fits(&scenario, &text), None, "{text}");
    }
    for slip in [
        "duraton = 1.0",
        "duration = \"1\"",
        "duration = 1.0\n[[contact]]\npoint = [0.0, 0.0]\n",
        "duration = 1.0\n[[contact]]\nsinusoid = { frequenzy = 1.0 }\n",
        "duration = 1.0\n[output]\nfields = \"all\"\n",
        "duration = 1.0\n[[output.probe]]\nname = \"a\"\n",
    ] {
        assert!(fits(&scenario, slip).is_some(), "{slip}");
    }

    let sweep = schema("sweep");
    for text in examples("sweep-1.md") {
        assert_eq!(fits(&sweep, &text), None, "{text}");
    }
    for slip in [
        "problem = [\"a.toml\"]",
        "problems = []",
        "problems = [\"a.toml\"]\n[[vary]]\nkey = \"basis.modes\"\n",
        "problems = [\"a.toml\"]\n[[vary]]\nkey = \"basis.modes\"\nvalues = []\n",
    ] {
        assert!(fits(&sweep, slip).is_some(), "{slip}");
    }
}

/// All names of properties, and of choices that are keys.
fn properties(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            if let Some(Value::Object(all)) = object.get("properties") {
                names.extend(all.keys().cloned());
            }
            object.values().for_each(|value| properties(value, names));
        }
        Value::Array(items) => items.iter().for_each(|item| properties(item, names)),
        _ => {}
    }
}

/// Keys in the first cells of the tables of a page whose first column is called `key`, and of the table of
/// schemes.
fn keys(page: &str) -> BTreeSet<String> {
    let page = std::fs::read_to_string(repository().join("formats").join(page)).expect("a page");
    let page =
        page.split("## Refusals").next().expect("a page").split("## What `verify`").next().expect("a page");
    let mut found = BTreeSet::new();
    let mut inside = false;
    for line in page.lines() {
        inside = line.starts_with("| key |") || (inside && line.starts_with('|'));
        let first = line.trim_start_matches('|').split('|').next().unwrap_or_default();
        if inside {
            let quoted = first.split('`').skip(1).step_by(2);
            let parts = quoted.flat_map(|key| key.split(['.', '[', ']'])).filter(|part| !part.is_empty());
            found.extend(parts.map(str::to_string));
        }
    }
    found
}

#[test]
fn the_schema_has_every_key_of_the_page_and_the_page_every_key_of_the_schema() {
    for (of, page) in [("problem", "problem-1.md"), ("scenario", "scenario-1.md"), ("sweep", "sweep-1.md")] {
        let (mut known, written) = (BTreeSet::new(), keys(page));
        properties(&schema(of), &mut known);
        assert!(written.len() > 5, "{written:?}");
        let missing: Vec<_> = written.difference(&known).collect();
        assert!(missing.is_empty(), "{missing:?} of {page} are not in the schema");
        let text = std::fs::read_to_string(repository().join("formats").join(page)).expect("a page");
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        let spans = text.split('`').skip(1).step_by(2);
        let words: BTreeSet<&str> = spans.flat_map(|span| span.split(|c| !is_part(c))).collect();
        let told = |key: &String| words.contains(key.as_str()) || written.contains(key);
        let untold: Vec<_> = known.iter().filter(|key| !told(key)).collect();
        assert!(untold.is_empty(), "{untold:?} of the schema are not on {page}");
    }
}

/// Every range of the table of checks stands on the page and in the schema; between its markers the page has
/// nothing else.
#[test]
fn the_page_has_the_ranges_that_are_checked() {
    let page = std::fs::read_to_string(repository().join("formats/problem-1.md")).expect("a page");
    let block = page.split("<!-- ranges -->\n\n").nth(1).expect("the beginning of the ranges");
    let block = block.split("\n<!-- end -->").next().expect("their end");
    let table = vademecum_build::input::range_table();
    assert!(block == table, "formats/problem-1.md must have between its markers\n\n{table}");
    let bounded = table.lines().count() - 2;
    let schema = schema("problem").to_string();
    let bounds = schema.matches("inimum\":").count();
    assert!(bounds >= bounded, "{bounds} lower bounds in the schema, {bounded} keys with a range");
}

#[test]
fn descriptions_are_for_people() {
    for of in ["problem", "scenario", "sweep"] {
        let text = schema(of).to_string();
        for rust in ["](", "\\\\[", "crate::", "super::"] {
            assert!(!text.contains(rust), "`{rust}` in the schema of the {of}");
        }
    }
    assert_eq!(schema("problem")["properties"]["time"]["description"], json!("Scheme and step."));
}

#[test]
fn completions_and_manual_pages_know_the_commands() {
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let ran = vademecum(&["completions", shell]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        for word in ["vademecum", "verify", "keep-missed", "schema"] {
            assert!(ran.stdout.contains(word), "`{word}` for {shell}");
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let pages = folder.path().join("man1").display().to_string();
    let ran = vademecum(&["man", &pages]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let page = |name: &str| std::fs::read_to_string(folder.path().join("man1").join(name)).expect("a page");
    assert!(page("vademecum.1").contains("build"), "the program's page names its commands");
    let build = page("vademecum-build.1");
    assert!(build.contains(".TH vademecum-build 1") && build.contains("keep\\-missed"), "{build}");
    assert!(page("vademecum-export-matrices.1").contains("basis"));
    assert_eq!(vademecum(&["man", &pages]).code, Some(0), "the same pages again");
    std::fs::write(folder.path().join("man1/vademecum-run.1"), "mine").expect("written");
    vademecum(&["man", &pages]).fails(2, &["vademecum-run.1", "--force"]);
}
