//! The JSON Schema of study files (draft 7, which editors support best).

use serde_json::{Map, Value, json};

use super::keys::STUDY;
use crate::keys::{Key, Range, Table, Type, Variant};

/// The text of the schema file, referenced by `#:schema ./study.schema.json` at the top of a study.
pub fn schema() -> String {
    format!("{:#}\n", json_schema())
}

/// The schema, generated from the description of the tables.
pub fn json_schema() -> Value {
    let mut schema = table(&STUDY);
    schema.insert("$schema".to_owned(), json!("http://json-schema.org/draft-07/schema#"));
    schema.insert("title".to_owned(), json!("luenberger study"));
    Value::Object(schema)
}

fn table(table: &Table) -> Map<String, Value> {
    match &table.variants {
        None => object(table.about, table.keys.iter().copied(), None),
        Some(variants) => {
            let one = |variant: &Variant| {
                let keys = table.keys.iter().chain(variant.keys()).copied();
                Value::Object(object(variant.about, keys, Some((variants.tag, variant.name))))
            };
            let mut all = Map::new();
            all.insert("description".to_owned(), json!(table.about));
            all.insert("type".to_owned(), json!("object"));
            all.insert("required".to_owned(), json!([variants.tag]));
            all.insert("oneOf".to_owned(), Value::Array((variants.of)().iter().map(one).collect()));
            all
        }
    }
}

fn object(about: &str, keys: impl Iterator<Item = Key>, tag: Option<(&str, &str)>) -> Map<String, Value> {
    let mut properties = Map::new();
    let mut required = Vec::new();
    if let Some((tag, name)) = tag {
        properties.insert(tag.to_owned(), json!({ "const": name, "description": about }));
        required.push(json!(tag));
    }
    for key in keys {
        let mut value = kind(&key.value);
        if let Value::Object(value) = &mut value {
            value.insert("description".to_owned(), json!(key.about));
        }
        properties.insert(key.name.to_owned(), value);
        if key.required {
            required.push(json!(key.name));
        }
    }
    let mut object = Map::new();
    object.insert("description".to_owned(), json!(about));
    object.insert("type".to_owned(), json!("object"));
    object.insert("properties".to_owned(), Value::Object(properties));
    object.insert("required".to_owned(), Value::Array(required));
    object.insert("additionalProperties".to_owned(), json!(false));
    object
}

fn number(range: Range) -> Value {
    match range {
        Range::Any => json!({ "type": "number" }),
        Range::Positive => json!({ "type": "number", "exclusiveMinimum": 0 }),
        Range::NotNegative => json!({ "type": "number", "minimum": 0 }),
    }
}

fn list(items: &Value) -> Value {
    json!({ "type": "array", "items": items, "minItems": 1 })
}

fn kind(kind: &Type) -> Value {
    let rows = || list(&list(&number(Range::Any)));
    let expression = || json!({ "type": ["number", "string"] });
    let end = || json!({ "anyOf": [{ "type": "number" }, { "enum": ["inf", "-inf"] }] });
    let pair = || json!({ "type": "array", "items": end(), "minItems": 2, "maxItems": 2 });
    let choice = |choices: &[(&str, &str)]| {
        let one = |(name, about): &(&str, &str)| json!({ "const": name, "description": about });
        json!({ "oneOf": choices.iter().map(one).collect::<Vec<_>>() })
    };
    match kind {
        Type::Text | Type::Name => json!({ "type": "string" }),
        Type::Choice(choices) => choice(choices),
        Type::Switch => json!({ "type": "boolean" }),
        Type::Number(range) => number(*range),
        Type::Count(least) => json!({ "type": "integer", "minimum": least }),
        Type::Numbers(range) => list(&number(*range)),
        Type::Texts | Type::Names(1..) => list(&json!({ "type": "string" })),
        Type::Columns | Type::Names(0) => json!({ "type": "array", "items": { "type": "string" } }),
        Type::NameLists(least) => list(&json!({ "type": "array", "items": { "type": "string" }, "minItems": least })),
        Type::Choices(choices) => list(&choice(choices)),
        Type::Rows => rows(),
        Type::Expressions => list(&expression()),
        Type::ExpressionRows => json!({ "anyOf": [list(&expression()), list(&list(&expression()))] }),
        Type::Weight => json!({ "anyOf": [number(Range::Any), list(&number(Range::Any)), rows()] }),
        Type::Covariance => json!({ "anyOf": [number(Range::Any), list(&expression()), rows()] }),
        Type::Poles => {
            let complex = json!({ "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 });
            list(&json!({ "anyOf": [{ "type": "number" }, complex] }))
        }
        Type::Bounds => list(&pair()),
        Type::Bound => pair(),
        Type::Named => json!({ "type": "object", "additionalProperties": { "type": ["number", "string"] } }),
        Type::NamedBounds => json!({ "type": "object", "additionalProperties": pair() }),
        Type::Units => {
            let table = json!({ "type": "object", "additionalProperties": { "type": "string" } });
            json!({ "anyOf": [table, list(&json!({ "type": "string" }))] })
        }
        Type::NamedTables(inner) => json!({ "type": "object", "additionalProperties": table(inner) }),
        Type::Table(inner) => Value::Object(table(inner)),
        Type::Tables(inner) => list(&Value::Object(table(inner))),
    }
}
