//! `/api/v1/asyncapi.json`: AsyncAPI 3 document of the stream, generated from the table of its events.

use serde_json::{Map, Value, json};

use super::events;
use super::openapi;
use super::request::{ApiResult, JSON, json};
use super::route::QueryParameter;

/// The document, with the parameters of the stream and of the WebSocket.
pub fn document(stream: &[QueryParameter], websocket: &[QueryParameter]) -> ApiResult {
    let mut generator = openapi::generator();
    let (mut messages, mut framed) = (Map::new(), Map::new());
    for kind in events::ALL {
        let message = |payload: Value| json!({ "name": kind.name, "title": kind.name, "summary": kind.summary, "contentType": JSON, "payload": payload });
        messages.insert(kind.name.to_owned(), message(json!((kind.schema)(&mut generator))));
        framed.insert(format!("{}_message", kind.name), message(kind.message(&mut generator)));
    }
    let of = |messages: &Map<String, Value>| -> Map<String, Value> {
        let to = |name: &String| json!({ "$ref": format!("#/components/messages/{name}") });
        messages.keys().map(|name| (name.clone(), to(name))).collect()
    };
    let query = |parameters: &[QueryParameter]| {
        let property = |parameter: &QueryParameter| {
            let mut schema = openapi::schema(parameter);
            schema["description"] = json!(parameter.description);
            (parameter.name.to_owned(), schema)
        };
        let properties: Map<String, Value> = parameters.iter().map(property).collect();
        json!({ "type": "object", "properties": properties, "additionalProperties": false })
    };
    let document = json!({
        "asyncapi": "3.0.0",
        "info": {
            "title": "utm-fusion: the stream",
            "version": env!("CARGO_PKG_VERSION"),
            "description": "The events of the air picture, as Server-Sent Events and as messages of a WebSocket.",
            "license": { "name": "MIT OR Apache-2.0" },
        },
        "defaultContentType": JSON,
        "channels": {
            "stream": {
                "address": "/api/v1/stream",
                "title": "Server-Sent Events",
                "description": "The name of an event is its event:, the id its id:, the payload its data:, which is one line.",
                "messages": of(&messages),
            },
            "websocket": {
                "address": "/api/v1/stream/ws",
                "title": "WebSocket",
                "description": "Each message is a text: an object of event, id and data. A client sends no messages.",
                "messages": of(&framed),
                "bindings": { "ws": { "method": "GET", "query": query(websocket), "bindingVersion": "0.1.0" } },
            },
        },
        "operations": {
            "sendEvents": {
                "action": "send",
                "channel": { "$ref": "#/channels/stream" },
                "bindings": { "http": { "method": "GET", "query": query(stream), "bindingVersion": "0.3.0" } },
            },
            "sendMessages": { "action": "send", "channel": { "$ref": "#/channels/websocket" } },
        },
        "components": {
            "messages": messages.into_iter().chain(framed).collect::<Map<_, _>>(),
            "schemas": generator.take_definitions(true),
        },
    });
    json(JSON, &document)
}
