//! `/openapi.json`: OpenAPI 3.1 made of the table of routes.

use axum::http::StatusCode;
use serde_json::{Map, Value, json};

use super::ask::{Answer, Ask, JSON, json};
use super::routes::{Parameter, ROUTES, Route};
use super::schemas;

/// The document.
pub fn document(ask: &Ask) -> Answer {
    let mut paths = Map::new();
    for route in ROUTES {
        let method = if route.post { "post" } else { "get" };
        let path = paths.entry(route.path).or_insert_with(|| json!({}));
        path[method] = operation(route);
    }
    let mut document = json!({
        "openapi": "3.1.0",
        "info": {
            "title": "utm-fusion",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "One air picture of drone traffic. Metres, metres a second, degrees true, RFC 3339 UTC; what is unknown is left out.",
            "license": { "name": "MIT OR Apache-2.0", "identifier": "MIT OR Apache-2.0" },
        },
        "servers": [{ "url": "/" }],
        "paths": paths,
        "components": {
            "schemas": schemas::all(),
            "securitySchemes": { "token": { "type": "http", "scheme": "bearer" } },
        },
    });
    if ask.state.needs_token() {
        document["info"]["description"] =
            json!("One air picture of drone traffic. This service asks for a bearer token.");
    }
    json(JSON, &document)
}

fn operation(route: &Route) -> Value {
    let mut parameters: Vec<Value> = Vec::new();
    if route.path.contains("{id}") {
        let schema = json!({ "type": "string" });
        parameters.push(json!({ "name": "id", "in": "path", "required": true, "schema": schema }));
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
    let schema = match schemas::of(route.path) {
        Some(name) => json!({ "$ref": format!("#/components/schemas/{name}") }),
        None if route.content_type.contains("json") => json!({ "type": "object" }),
        None => json!({ "type": "string" }),
    };
    responses.insert(
        "200".to_owned(),
        json!({ "description": route.summary, "content": { route.content_type: { "schema": schema } } }),
    );
    let guarded: &[u16] = if route.scope.is_some() { &[401, 403] } else { &[] };
    // Host and, of a POST, Origin and Content-Type are looked at for every route.
    let sent: &[u16] = if route.post { &[400, 403, 413, 415, 421] } else { &[400, 421] };
    let limited: &[u16] = if route.limited { &[429] } else { &[] };
    for &status in sent.iter().chain(guarded).chain(route.problems).chain(limited) {
        let text =
            StatusCode::from_u16(status).ok().and_then(|status| status.canonical_reason()).unwrap_or("");
        let mut response = json!({ "description": text });
        if status != 304 {
            let schema = json!({ "$ref": "#/components/schemas/Problem" });
            response["content"] = json!({ "application/problem+json": { "schema": schema } });
        }
        responses.insert(status.to_string(), response);
    }
    let mut operation = json!({ "summary": route.summary, "parameters": parameters, "responses": responses });
    if let Some(scope) = route.scope {
        operation["security"] = json!([{}, { "token": [] }]);
        operation["description"] = json!(format!("With tokens in force: scope {}.", scope.name()));
    }
    operation
}

fn schema(parameter: &Parameter) -> Value {
    let mut schema = match parameter.kind {
        "time" => json!({ "type": "string", "format": "date-time" }),
        kind => json!({ "type": kind }),
    };
    if let Some((least, greatest)) = parameter.range {
        // A whole number is written as one.
        let bound = |value: f64| if value.fract() == 0.0 { json!(value as i64) } else { json!(value) };
        schema["minimum"] = bound(least);
        schema["maximum"] = bound(greatest);
    }
    schema
}
