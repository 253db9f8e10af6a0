//! Lists that are longer than their keys take. Reading a list of a fixed length stops at its end, and what is
//! behind would be lost in silence.

use serde_json::Value as Schema;
use toml::{Table, Value};

/// A list with more items than its key takes: the key, how many there are, how many may be.
pub(super) fn too_long(table: &Table, schema: &Schema) -> Option<(String, usize, usize)> {
    in_table(table, schema, schema, "")
}

fn in_table(table: &Table, schema: &Schema, root: &Schema, above: &str) -> Option<(String, usize, usize)> {
    table.iter().find_map(|(name, value)| {
        let key = if above.is_empty() { name.clone() } else { format!("{above}.{name}") };
        in_value(value, schema.pointer(&format!("/properties/{name}"))?, root, &key)
    })
}

fn in_value(value: &Value, schema: &Schema, root: &Schema, key: &str) -> Option<(String, usize, usize)> {
    let schema = resolved(schema, root);
    // Of several forms, those that the value may have; it is too long if it is so for each of them.
    let in_forms = || {
        let forms = forms(schema).filter(|form| may_be(value, form, root));
        let found: Option<Vec<_>> = forms.map(|form| in_value(value, form, root, key)).collect();
        found.and_then(|found| found.into_iter().next())
    };
    match value {
        Value::Array(items) => {
            let most = schema["maxItems"].as_u64().and_then(|most| usize::try_from(most).ok());
            if let Some(most) = most.filter(|most| items.len() > *most) {
                return Some((key.into(), items.len(), most));
            }
            let mut inside = items.iter().enumerate();
            inside.find_map(|(at, item)| in_value(item, &schema["items"], root, &format!("{key}[{at}]")))
        }
        Value::Table(table) => in_table(table, schema, root, key),
        _ => None,
    }
    .or_else(in_forms)
}

/// The schema that a reference stands for.
fn resolved<'a>(schema: &'a Schema, root: &'a Schema) -> &'a Schema {
    let referred = schema["$ref"].as_str().and_then(|place| root.pointer(place.trim_start_matches('#')));
    referred.unwrap_or(schema)
}

/// The forms of which a schema asks for one.
fn forms(schema: &Schema) -> impl Iterator<Item = &Schema> {
    ["anyOf", "oneOf"].into_iter().filter_map(|word| schema[word].as_array()).flatten()
}

/// True if a value is of the type of a form, and a table has no other keys than it.
fn may_be(value: &Value, form: &Schema, root: &Schema) -> bool {
    let form = resolved(form, root);
    let properties = &form["properties"];
    let is_known = |name: &String| properties.is_null() || !properties[name].is_null();
    match (value, form["type"].as_str()) {
        (Value::Array(_), Some("array")) => true,
        (Value::Table(table), Some("object")) => table.keys().all(is_known),
        (_, None) => forms(form).any(|form| may_be(value, form, root)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(serde::Deserialize, schemars::JsonSchema)]
    #[allow(dead_code)]
    struct Whole {
        pair: Option<[f64; 2]>,
        pairs: Vec<[[f64; 2]; 2]>,
        inner: Vec<Inner>,
        place: Option<Place>,
        any: Vec<f64>,
    }

    #[derive(serde::Deserialize, schemars::JsonSchema)]
    #[serde(untagged)]
    #[allow(dead_code)]
    enum Inner {
        One(f64),
        Two([f64; 2]),
        Table { point: [f64; 3] },
    }

    #[derive(serde::Deserialize, schemars::JsonSchema)]
    #[serde(tag = "kind", rename_all = "lowercase")]
    #[allow(dead_code)]
    enum Place {
        Point { at: [f64; 3] },
        Line { from: [f64; 3], to: [f64; 3] },
    }

    #[test]
    fn lists_of_fixed_lengths_are_found_wherever_they_stand() {
        let schema = schemars::schema_for!(Whole);
        let found = |text: &str| {
            let table: Table = text.parse().unwrap();
            too_long(&table, schema.as_value()).map(|(key, found, most)| format!("{key} {found} {most}"))
        };
        let said = |text: &str| found(text).unwrap_or_default();
        assert_eq!(said("pair = [1, 2, 3]"), "pair 3 2");
        assert_eq!(said("pairs = [[[1, 2], [3, 4]], [[1, 2], [3, 4, 5]]]"), "pairs[1][1] 3 2");
        assert_eq!(said("inner = [1, [1, 2, 3]]"), "inner[1] 3 2");
        assert_eq!(said("[[inner]]\npoint = [1, 2, 3, 4]"), "inner[0].point 4 3");
        assert_eq!(said("place = { kind = \"line\", from = [1, 2, 3], to = [1, 2, 3, 4] }"), "place.to 4 3");
        assert_eq!(said("place = { kind = \"point\", at = [1, 2, 3, 4] }"), "place.at 4 3");
        let sound = "pair = [1, 2]\npairs = [[[1, 2], [3, 4]]]\ninner = [1, [1, 2]]\nany = [1, 2, 3, 4, 5]";
        assert_eq!(found(sound), None);
    }
}
