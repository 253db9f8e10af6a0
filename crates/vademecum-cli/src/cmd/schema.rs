//! `vademecum schema`: what an editor needs to know about the files that people write.

use serde_json::Value;
use vademecum_assembly::AssemblyFile;
use vademecum_build::input::problem_schema;
use vademecum_study::scenario::Scenario;
use vademecum_study::sweep::Sweep;

use crate::print::print_json;

/// Prints the JSON Schema of the problem, scenario, sweep or assembly file, for editors that complete and
/// check TOML.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum schema problem > problem.schema.json
  vademecum schema scenario > scenario.schema.json
  vademecum schema sweep > sweep.schema.json
  vademecum schema assembly > assembly.schema.json
With taplo, or \"Even Better TOML\" in VS Code, the first line of a problem file then says where it is:
  #:schema ./problem.schema.json
The schema knows keys, types, choices and defaults (draft 2020-12). Ranges, and what goes with what, are
checked by the program: `vademecum help problem`")]
pub(crate) struct Schema {
    /// Of which file.
    #[arg(value_enum)]
    of: SchemaKind,
}

/// A file that people write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum SchemaKind {
    /// The problem file.
    Problem,
    /// The scenario file.
    Scenario,
    /// The sweep file.
    Sweep,
    /// The assembly file.
    Assembly,
}

impl Schema {
    pub(crate) fn run(&self) {
        let (schema, title) = match self.of {
            SchemaKind::Problem => (problem_schema(), "The problem file of vademecum, version 1"),
            SchemaKind::Scenario => {
                (schemars::schema_for!(Scenario), "The scenario file of vademecum, version 1")
            }
            SchemaKind::Sweep => (schemars::schema_for!(Sweep), "The sweep file of vademecum, version 1"),
            SchemaKind::Assembly => {
                (schemars::schema_for!(AssemblyFile), "The assembly file of vademecum, version 1")
            }
        };
        let mut schema = schema.to_value();
        plain(&mut schema);
        if let Some(object) = schema.as_object_mut() {
            object.insert("title".into(), title.into());
        }
        print_json(&schema);
    }
}

/// Descriptions are written for Rust: links to types become their names, and brackets lose their backslash.
/// And TOML has no null: a key is there or it is not.
fn plain(value: &mut Value) {
    match value {
        Value::Object(object) => {
            without_null(object);
            for (key, value) in object {
                match value {
                    Value::String(text) if key == "description" => *text = without_links(text),
                    value => plain(value),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(plain),
        _ => {}
    }
}

/// Takes `null` from the types that a value may have.
fn without_null(rules: &mut serde_json::Map<String, Value>) {
    if let Some(Value::Array(types)) = rules.get_mut("type") {
        types.retain(|name| name != "null");
        if let [only] = &types[..] {
            let only = only.clone();
            rules.insert("type".into(), only);
        }
    }
    let null = serde_json::json!({ "type": "null" });
    let Some(Value::Array(choices)) = rules.get_mut("anyOf") else { return };
    choices.retain(|choice| *choice != null);
    if let [Value::Object(only)] = &choices[..] {
        let only = only.clone();
        rules.remove("anyOf");
        rules.extend(only);
    }
}

fn without_links(text: &str) -> String {
    let text = text.replace('\n', " ").replace("\\[", "\u{1}").replace("\\]", "\u{2}");
    let mut out = String::new();
    let mut rest = text.as_str();
    while let Some(middle) = rest.find("](") {
        let (before, behind) = (&rest[..middle], &rest[middle..]);
        let (open, close) = (before.rfind('['), behind.find(')'));
        let (Some(open), Some(close)) = (open, close) else { break };
        let after = &behind[close + 1..];
        // A link in parentheses of its own is for readers of the sources alone.
        if let (Some(text), Some(after)) = (before[..open].strip_suffix(" ("), after.strip_prefix(')')) {
            out.push_str(text);
            rest = after;
            continue;
        }
        out.push_str(&before[..open]);
        out.push_str(&before[open + 1..]);
        rest = after;
    }
    out.push_str(rest);
    out.replace('\u{1}', "[").replace('\u{2}', "]")
}

#[cfg(test)]
mod tests {
    use super::{plain, without_links};

    #[test]
    fn there_is_no_null_in_toml() {
        let mut schema = serde_json::json!({ "properties": {
            "a": { "type": ["number", "null"] },
            "b": { "anyOf": [{ "$ref": "#/$defs/B" }, { "type": "null" }], "description": "b" },
        } });
        plain(&mut schema);
        let expected = serde_json::json!({ "properties": {
            "a": { "type": "number" },
            "b": { "$ref": "#/$defs/B", "description": "b" },
        } });
        assert_eq!(schema, expected);
    }

    #[test]
    fn descriptions_lose_what_only_rust_reads() {
        let text = "Δt \\[s\\]; absent: [`proposed`](crate::proposed) of it, or\nanother";
        assert_eq!(without_links(text), "Δt [s]; absent: `proposed` of it, or another");
        assert_eq!(without_links("a kind ([`Kind`](crate::Kind)), so"), "a kind, so");
    }
}
