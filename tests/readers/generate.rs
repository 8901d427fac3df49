//! Generates the types of the clients from `/openapi.json` and `/api/v1/asyncapi.json`.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::{Map, Value};

/// Content of both documents.
pub(crate) struct Documents {
    api: Value,
    schemas: BTreeMap<String, Value>,
}

const MADE: &str =
    "Made of /openapi.json and /api/v1/asyncapi.json by tests/readers/generate.rs; UPDATE=1 makes it anew.";

impl Documents {
    pub(crate) fn new(api: &str, stream: &str) -> Self {
        let [api, stream] = [api, stream].map(|text| serde_json::from_str::<Value>(text).unwrap());
        let of = |document: &Value| document["components"]["schemas"].as_object().unwrap().clone();
        let schemas = of(&stream).into_iter().chain(of(&api)).collect();
        Self { api, schemas }
    }

    /// Paths with their operation, and the schema of a successful answer.
    fn operations(&self, method: &str) -> Vec<(&String, &Value, &Value)> {
        let paths = self.api["paths"].as_object().unwrap();
        paths
            .iter()
            .filter_map(|(path, operations)| {
                let operation = operations.get(method)?;
                let content = operation["responses"].get("200")?["content"].as_object().unwrap();
                let (_, media) = content.iter().find(|(media, _)| media.contains("json"))?;
                Some((path, operation, &media["schema"]))
            })
            .collect()
    }

    pub(crate) fn typescript(&self) -> String {
        let mut out = format!("// {MADE}\n");
        for (name, schema) in &self.schemas {
            let _ =
                write!(out, "\n{}export type {name} = {};\n", comment(schema, ""), typescript(schema, ""));
        }
        let mut map = |name: &str, what: &str, entries: Vec<(&String, String)>| {
            let _ = write!(out, "\n/** {what} */\nexport interface {name} {{\n");
            for (path, is) in entries {
                let _ = writeln!(out, "  {path:?}: {is};");
            }
            out.push_str("}\n");
        };
        let answers = |method: &str| -> Vec<(&String, String)> {
            let operations = self.operations(method).into_iter();
            operations.map(|(path, _, schema)| (path, typescript(schema, "  "))).collect()
        };
        map("Answers", "What is answered to GET, by path.", answers("get"));
        map("Orders", "What is answered to POST, by path.", answers("post"));
        let given = |parameter: &Value, is_shared: bool| {
            let optional = if parameter["required"] == true && !is_shared { "" } else { "?" };
            let is_list =
                parameter["description"].as_str().is_some_and(|text| text.contains("separated by commas"));
            let many = if is_list { " | string[]" } else { "" };
            let is = typescript(&parameter["schema"], "");
            format!("{}{optional}: {is}{many}", parameter["name"].as_str().unwrap())
        };
        let parameters = self.api["paths"].as_object().unwrap().iter().map(|(path, operations)| {
            let operations = operations.as_object().unwrap();
            // A parameter required by one method may be invalid for another.
            let is_shared = operations.len() > 1;
            let all = operations.values().flat_map(|operation| operation["parameters"].as_array().unwrap());
            let all: Vec<String> = all.map(|parameter| given(parameter, is_shared)).collect();
            (path, if all.is_empty() { "{}".to_owned() } else { format!("{{ {} }}", all.join("; ")) })
        });
        map("Parameters", "What a path takes, in it and behind the ?.", parameters.collect());
        out
    }

    pub(crate) fn python(&self) -> String {
        let mut out =
            format!("\"\"\"{MADE}\"\"\"\n\nfrom typing import Any, Literal, NotRequired, TypedDict, Union\n");
        for (name, schema) in &self.schemas {
            let mut definitions = Vec::new();
            let is = python(schema, name, &mut definitions);
            definitions.iter().for_each(|definition| out.push_str(definition));
            if is != format!("{name:?}") {
                let _ = write!(out, "\n{name} = {is}\n");
            }
        }
        out
    }
}

/// Description of a schema, as a comment.
fn comment(schema: &Value, indent: &str) -> String {
    let text = schema["description"].as_str().unwrap_or_default().replace("*/", "");
    if text.is_empty() { String::new() } else { format!("/** {} */\n{indent}", text.replace('\n', " ")) }
}

fn reference(schema: &Value) -> Option<&str> {
    schema["$ref"].as_str()?.rsplit('/').next()
}

/// Variants of a schema, if it has any.
fn variants(schema: &Value) -> Option<&Vec<Value>> {
    schema.get("oneOf").or_else(|| schema.get("anyOf"))?.as_array()
}

fn is_required(schema: &Value, name: &str) -> bool {
    schema["required"].as_array().is_some_and(|names| names.iter().any(|one| one == name))
}

fn typescript(schema: &Value, indent: &str) -> String {
    if let Some(name) = reference(schema) {
        return name.to_owned();
    }
    if let Some(value) = schema.get("const") {
        return value.to_string();
    }
    let join = |parts: Vec<String>| parts.join(" | ");
    if let Some(values) = schema["enum"].as_array() {
        return join(values.iter().map(Value::to_string).collect());
    }
    let one_of = variants(schema).map(|all| join(all.iter().map(|one| typescript(one, indent)).collect()));
    match (schema["properties"].as_object(), one_of) {
        (Some(properties), None) => fields(schema, properties, indent),
        (Some(properties), Some(one_of)) => format!("{} & ({one_of})", fields(schema, properties, indent)),
        (None, Some(one_of)) => one_of,
        (None, None) => match &schema["type"] {
            Value::Array(kinds) => join(kinds.iter().map(|kind| simple(kind, schema, indent)).collect()),
            kind => simple(kind, schema, indent),
        },
    }
}

fn fields(schema: &Value, properties: &Map<String, Value>, indent: &str) -> String {
    let inner = format!("{indent}  ");
    let mut out = "{\n".to_owned();
    for (name, property) in properties {
        let optional = if is_required(schema, name) { "" } else { "?" };
        let is = typescript(property, &inner);
        let key = if name.contains(|c: char| !c.is_alphanumeric() && c != '_') {
            format!("{name:?}")
        } else {
            name.clone()
        };
        let _ = writeln!(out, "{inner}{}{key}{optional}: {is};", comment(property, &inner));
    }
    out + indent + "}"
}

fn simple(kind: &Value, schema: &Value, indent: &str) -> String {
    match kind.as_str() {
        Some("integer" | "number") => "number".to_owned(),
        Some("array") => match schema["prefixItems"].as_array() {
            Some(items) => {
                format!(
                    "[{}]",
                    items.iter().map(|item| typescript(item, indent)).collect::<Vec<_>>().join(", ")
                )
            }
            None => format!("Array<{}>", typescript(&schema["items"], indent)),
        },
        Some("object") => match &schema["additionalProperties"] {
            of @ Value::Object(_) => format!("Record<string, {}>", typescript(of, indent)),
            _ => "Record<string, unknown>".to_owned(),
        },
        Some(plain) => plain.to_owned(),
        None => "unknown".to_owned(),
    }
}

/// Type of a schema. Types that need a name are defined before it; names of later types are quoted.
fn python(schema: &Value, name: &str, definitions: &mut Vec<String>) -> String {
    if let Some(name) = reference(schema) {
        return format!("{name:?}");
    }
    let literal = |value: &Value| match value {
        Value::Bool(value) => if *value { "True" } else { "False" }.to_owned(),
        Value::Null => "None".to_owned(),
        value => value.to_string(),
    };
    if let Some(value) = schema.get("const") {
        return format!("Literal[{}]", literal(value));
    }
    if let Some(values) = schema["enum"].as_array() {
        return format!("Literal[{}]", values.iter().map(literal).collect::<Vec<_>>().join(", "));
    }
    if let Some(properties) = schema["properties"].as_object() {
        let mut all = Map::new();
        let optional = variants(schema).into_iter().flatten().filter_map(|one| one["properties"].as_object());
        optional.flatten().for_each(|(key, property)| drop(all.insert(key.clone(), property.clone())));
        all.extend(properties.clone());
        let mut entries = String::new();
        for (key, property) in &all {
            let is = python(property, &format!("{name}{}", capital(key)), definitions);
            let is = if is_required(schema, key) { is } else { format!("NotRequired[{is}]") };
            let _ = writeln!(entries, "        {key:?}: {is},");
        }
        definitions.push(format!("\n{name} = TypedDict(\n    {name:?},\n    {{\n{entries}    }},\n)\n"));
        return format!("{name:?}");
    }
    if let Some(all) = variants(schema) {
        let of = |(index, one): (usize, &Value)| {
            let label =
                one["properties"]["event"]["const"].as_str().map_or_else(|| (index + 1).to_string(), capital);
            python(one, &format!("{name}{label}"), definitions)
        };
        let all: Vec<String> = all.iter().enumerate().map(of).collect();
        return format!("Union[{}]", all.join(", "));
    }
    let kinds = match &schema["type"] {
        Value::Array(kinds) => kinds.clone(),
        kind => vec![kind.clone()],
    };
    let of = |kind: &Value| match kind.as_str() {
        Some("integer") => "int".to_owned(),
        Some("number") => "float".to_owned(),
        Some("string") => "str".to_owned(),
        Some("boolean") => "bool".to_owned(),
        Some("null") => "None".to_owned(),
        Some("array") => match schema.get("items") {
            Some(items) if items.is_object() => {
                format!("list[{}]", python(items, &format!("{name}Item"), definitions))
            }
            _ => "list[Any]".to_owned(),
        },
        Some("object") => match &schema["additionalProperties"] {
            of @ Value::Object(_) => {
                format!("dict[str, {}]", python(of, &format!("{name}Value"), definitions))
            }
            _ => "dict[str, Any]".to_owned(),
        },
        _ => "Any".to_owned(),
    };
    let kinds: Vec<String> = kinds.iter().map(of).collect();
    if kinds.len() == 1 { kinds.concat() } else { format!("Union[{}]", kinds.join(", ")) }
}

fn capital(text: &str) -> String {
    let part = |part: &str| {
        let (first, rest) = part.split_at(part.len().min(1));
        first.to_uppercase() + rest
    };
    text.split(['_', '-']).map(part).collect()
}
