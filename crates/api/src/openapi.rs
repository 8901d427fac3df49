//! `/openapi.json`: OpenAPI 3.1 document, generated from the table of routes.

use axum::http::StatusCode;
use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, transform_subschemas};
use schemars::{Schema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::problem::ProblemJson;
use super::request::{ApiResult, JSON, json};
use super::route::{AllowedValues, MediaType, QueryParameter, Route};

/// Document of these routes.
pub fn document(routes: &[Route], needs_token: bool) -> ApiResult {
    let (mut generator, mut requests) = (generator(), generator_of_requests());
    let mut paths = Map::new();
    for route in routes {
        let method = if route.post { "post" } else { "get" };
        let path = paths.entry(route.path).or_insert_with(|| json!({}));
        path[method] = operation(route, needs_token, &mut generator, &mut requests);
    }
    let mut schemas = generator.take_definitions(true);
    schemas.extend(requests.take_definitions(true));
    let token = if needs_token { "This service asks for a bearer token." } else { UNITS };
    let document = json!({
        "openapi": "3.1.0",
        "info": {
            "title": "utm-fusion",
            "version": env!("CARGO_PKG_VERSION"),
            "description": format!("One air picture of drone traffic. {token}"),
            "license": { "name": "MIT OR Apache-2.0", "identifier": "MIT OR Apache-2.0" },
        },
        "servers": [{ "url": "/" }],
        "paths": paths,
        "components": {
            "schemas": schemas,
            "securitySchemes": { "token": { "type": "http", "scheme": "bearer" } },
        },
    });
    json(JSON, &document)
}

/// Generator of the schemas of responses.
pub(super) fn generator() -> SchemaGenerator {
    with_definitions(SchemaSettings::draft2020_12().for_serialize().with_transform(exact))
}

/// Generator of the schemas of requests, which have other optional properties.
fn generator_of_requests() -> SchemaGenerator {
    let complete_all = RecursiveTransform(|schema: &mut Schema| {
        schema.as_object_mut().into_iter().for_each(complete);
    });
    with_definitions(SchemaSettings::draft2020_12().for_deserialize().with_transform(complete_all))
}

fn with_definitions(mut settings: SchemaSettings) -> SchemaGenerator {
    settings.definitions_path = "/components/schemas".into();
    settings.meta_schema = None;
    settings.into_generator()
}

const UNITS: &str = "Metres, metres per second, degrees true, RFC 3339 UTC; what is unknown is left out.";

/// Adds what the types do not state: an object has no further properties, and an optional property is never null.
fn exact(schema: &mut Schema) {
    transform_subschemas(&mut exact, schema);
    if let Some(object) = schema.as_object_mut() {
        complete(object);
    }
    let Some(object) = schema.as_object_mut().filter(|object| object.contains_key("properties")) else {
        return;
    };
    match object.get_mut("oneOf") {
        // Each variant describes only some of the properties.
        Some(Value::Array(variants)) => {
            variants.iter_mut().filter_map(Value::as_object_mut).for_each(|variant| {
                variant.remove("additionalProperties");
            });
        }
        _ => drop(object.insert("additionalProperties".to_owned(), json!(false))),
    }
    let required = object.get("required").cloned().unwrap_or_default();
    let is_required = |name: &str| required.as_array().is_some_and(|all| all.iter().any(|one| one == name));
    let Some(Value::Object(properties)) = object.get_mut("properties") else { return };
    let optional = properties.iter_mut().filter(|(name, _)| !is_required(name));
    for property in optional.filter_map(|(_, property)| property.as_object_mut()) {
        if let Some(Value::Array(kinds)) = property.get("type") {
            property["type"] = kinds.first().cloned().unwrap_or_default();
            if let Some(Value::Array(values)) = property.get_mut("enum") {
                values.retain(|value| !value.is_null());
            }
        }
        if let Some(Value::Array(mut kinds)) = property.remove("anyOf") {
            property.extend(
                kinds
                    .first_mut()
                    .map(Value::take)
                    .and_then(|kind| kind.as_object().cloned())
                    .unwrap_or_default(),
            );
        }
    }
}

/// Completes a schema for generators of clients: the enum of a nullable value contains null, and every array has `items`.
fn complete(schema: &mut Map<String, Value>) {
    let is_of = |kind: &str| match schema.get("type") {
        Some(Value::Array(kinds)) => kinds.iter().any(|one| one == kind),
        Some(Value::String(one)) => one == kind,
        _ => false,
    };
    let (is_nullable, is_array) = (is_of("null"), is_of("array"));
    if let Some(Value::Array(values)) = schema.get_mut("enum")
        && is_nullable
        && !values.contains(&Value::Null)
    {
        values.push(Value::Null);
    }
    if is_array && !schema.contains_key("items") {
        let mut kinds: Vec<Value> = Vec::new();
        for kind in schema.get("prefixItems").and_then(Value::as_array).into_iter().flatten() {
            if !kinds.contains(kind) {
                kinds.push(kind.clone());
            }
        }
        let items = match kinds.len() {
            0 => json!({}),
            1 => kinds.remove(0),
            _ => json!({ "anyOf": kinds }),
        };
        schema.insert("items".to_owned(), items);
    }
}

/// Operation id such as `getTracksIdTrail`, unique as method and path are.
fn operation_id(route: &Route) -> String {
    let mut id = String::from(if route.post { "post" } else { "get" });
    let path = route.path.strip_prefix("/api/v1").unwrap_or(route.path);
    for part in path.split(|character: char| !character.is_ascii_alphanumeric()) {
        let mut characters = part.chars();
        id.extend(characters.next().map(|first| first.to_ascii_uppercase()));
        id.push_str(characters.as_str());
    }
    if path == "/" {
        id.push_str("Page");
    }
    id
}

fn operation(
    route: &Route,
    needs_token: bool,
    generator: &mut SchemaGenerator,
    requests: &mut SchemaGenerator,
) -> Value {
    let mut parameters: Vec<Value> = Vec::new();
    if let Some((name, _)) = route.path.split_once('{').and_then(|(_, rest)| rest.split_once('}')) {
        let schema = json!({ "type": "string" });
        parameters.push(json!({ "name": name, "in": "path", "required": true, "schema": schema }));
    }
    for parameter in route.parameters.unwrap_or(&[]) {
        parameters.push(json!({
            "name": parameter.name,
            "in": "query",
            "required": parameter.required,
            "description": parameter.description,
            "schema": schema(parameter),
        }));
    }
    let mut responses = Map::new();
    let reply = &route.reply;
    let content = bodies((reply.content_type, reply.schema), &reply.others, generator);
    responses.insert(
        reply.status.as_str().to_owned(),
        json!({ "description": route.summary, "content": content }),
    );
    let guarded: &[u16] = if route.scope.is_some() { &[401, 403] } else { &[] };
    // Every route checks the host, and for a POST also the origin and the content type.
    let sent: &[u16] = if route.post { &[400, 403, 413, 415, 421] } else { &[400, 421] };
    let limited: &[u16] = if route.limited { &[429] } else { &[] };
    for &status in sent.iter().chain(guarded).chain(route.problems).chain(limited) {
        let text =
            StatusCode::from_u16(status).ok().and_then(|status| status.canonical_reason()).unwrap_or("");
        let mut response = json!({ "description": text });
        if status != 304 {
            let schema = generator.subschema_for::<ProblemJson<'_>>();
            response["content"] = json!({ "application/problem+json": { "schema": schema } });
        }
        responses.insert(status.to_string(), response);
    }
    let mut operation = json!({
        "operationId": operation_id(route),
        "summary": route.summary,
        "parameters": parameters,
        "responses": responses,
        "security": [],
    });
    if let Some(body) = route.body {
        let content = bodies((route.body_type, body), &route.other_bodies, requests);
        operation["requestBody"] = json!({ "required": true, "content": content });
    }
    if let Some(scope) = route.scope {
        if needs_token {
            operation["security"] = json!([{ "token": [] }]);
        }
        operation["description"] = json!(format!("With tokens in force: scope {}.", scope.name()));
    }
    operation
}

/// Schemas of a body, by media type.
fn bodies(usual: MediaType, others: &[MediaType], generator: &mut SchemaGenerator) -> Value {
    let typed =
        |(media_type, schema): &MediaType| ((*media_type).to_owned(), json!({ "schema": schema(generator) }));
    [usual].iter().chain(others).map(typed).collect::<Map<_, _>>().into()
}

/// Schema of a parameter.
pub(super) fn schema(parameter: &QueryParameter) -> Value {
    let mut schema = match parameter.kind {
        "time" => json!({ "type": "string", "format": "date-time" }),
        kind => json!({ "type": kind }),
    };
    if let Some((least, greatest)) = parameter.range {
        // Whole numbers are written without a fraction.
        let bound = |value: f64| if value.fract() == 0.0 { json!(value as i64) } else { json!(value) };
        schema["minimum"] = bound(least);
        schema["maximum"] = bound(greatest);
    }
    if let Some(AllowedValues { names, is_list }) = parameter.values {
        if is_list {
            // A list is one text, because generators of clients would repeat the parameter.
            let one = names().join("|");
            schema["pattern"] = json!(format!("^({one})(,({one}))*$"));
        } else {
            schema["enum"] = json!(names());
        }
    }
    schema
}
