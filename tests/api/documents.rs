//! The OpenAPI document matches the router, and Prometheus can read the metrics.

use std::collections::BTreeSet;

use axum::http::{Method, Request, StatusCode};
use jiff::SignedDuration;
use serde_json::{Value, json};
use utm_fusion::api::routes::ROUTES;

use crate::auth::site as guarded;
use crate::common::{Site, flown};

#[tokio::test]
async fn the_document_and_the_router_agree_both_ways() {
    let mut site = Site::plain();
    site.publish(1).await;
    let document = site.get("/openapi.json").await.json();
    assert_eq!(document["openapi"], "3.1.0");
    let mut described = BTreeSet::new();
    for (path, operations) in document["paths"].as_object().unwrap() {
        for (method, operation) in operations.as_object().unwrap() {
            described.insert((path.clone(), method.clone()));
            let is_well = if path.ends_with("/ws") { "101" } else { "200" };
            assert!(operation["responses"][is_well]["content"].is_object(), "{path}");
            let is_probe = path == "/healthz" || path == "/readyz";
            assert_eq!(operation["responses"]["429"].is_object(), !is_probe, "{path}");
            // A stream has no end, so its existence is shown by a refused request.
            let probe = match path.as_str() {
                "/api/v1/stream" => format!("{path}?interval_ms=0"),
                _ => path.replace("{id}", "nobody").replace("{identity}", "nobody"),
            };
            let method = Method::from_bytes(method.to_uppercase().as_bytes()).unwrap();
            let answer = site.ask(Request::builder().method(method.clone()).uri(&probe)).await;
            assert_ne!(answer.status, StatusCode::METHOD_NOT_ALLOWED, "{path}");
            let documented = &operation["responses"][answer.status.as_str()]["content"];
            assert!(documented.get(answer.header("content-type")).is_some(), "{path}: {}", answer.status);
            for parameter in operation["parameters"].as_array().unwrap() {
                // A ticket and the name of an operator may be any text.
                if parameter["in"] == "query" && parameter["name"] != "ticket" && parameter["name"] != "by" {
                    let name = parameter["name"].as_str().unwrap();
                    let absurd = format!("{path}?{name}=,,");
                    let answer = site.ask(Request::builder().method(method.clone()).uri(absurd)).await;
                    assert_eq!(answer.status, StatusCode::BAD_REQUEST, "{path} {name}");
                    let detail = answer.json()["detail"].as_str().unwrap().to_owned();
                    assert!(!detail.contains("no such parameter"), "{path} does not know {name}");
                }
            }
        }
    }
    let routed: BTreeSet<_> = ROUTES
        .iter()
        .map(|route| (route.path.to_owned(), if route.post { "post" } else { "get" }.to_owned()))
        .collect();
    assert_eq!(described, routed);
}

#[tokio::test]
async fn metrics_are_strictly_prometheus_text() {
    let mut site = Site::plain();
    site.publish_status(flown().status.clone()).await;
    site.publish(1).await;
    let mut late = flown().frames.last().unwrap().clone();
    late.published_at = late.due + SignedDuration::from_millis(3);
    site.writer.publish_live(late, 0);
    let text = site.get("/metrics").await.text;
    let (mut family, mut kind) = (String::new(), "");
    let mut seen = BTreeSet::new();
    let mut samples = BTreeSet::new();
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("# HELP ") {
            family = rest.split(' ').next().unwrap().to_owned();
            assert!(seen.insert(family.clone()), "{family} comes twice");
        } else if let Some(rest) = line.strip_prefix("# TYPE ") {
            let name;
            (name, kind) = rest.split_once(' ').unwrap();
            assert_eq!(name, family);
            assert!(matches!(kind, "counter" | "gauge" | "summary" | "histogram"));
            assert_eq!(kind == "counter", name.ends_with("_total"), "{name}");
        } else {
            assert_eq!(line.contains("quantile="), kind == "summary", "the label is reserved: {line}");
            assert_eq!(line.contains("{le="), kind == "histogram" && line.contains("_bucket"), "{line}");
            let (series, value) = line.rsplit_once(' ').unwrap();
            assert!(value.parse::<f64>().unwrap().is_finite(), "{line}");
            assert!(samples.insert(series), "{series} comes twice");
            let name = series.split('{').next().unwrap();
            let parts = if kind == "histogram" { &["_bucket", "_sum", "_count"][..] } else { &[""] };
            assert!(parts.iter().any(|part| name.strip_suffix(part) == Some(&family)), "{line}");
            let is_ours = name.starts_with("utm_fusion_") || name.starts_with("process_");
            assert!(is_ours && name.bytes().all(|c| c == b'_' || c.is_ascii_lowercase()));
            if let Some(labels) = series.strip_prefix(name).filter(|labels| !labels.is_empty()) {
                let labels = labels.strip_prefix('{').and_then(|l| l.strip_suffix('}')).unwrap();
                for label in labels.split("\",") {
                    let (key, value) = label.split_once("=\"").unwrap();
                    assert!(key.bytes().all(|c| c == b'_' || c.is_ascii_lowercase()), "{line}");
                    assert!(!value.trim_end_matches('"').contains('"'), "{line}");
                }
            }
        }
    }
    for name in [
        "utm_fusion_slots_published_total",
        "utm_fusion_reports_accepted_total",
        "utm_fusion_lateness_seconds",
        "utm_fusion_slot_lateness_seconds",
        "utm_fusion_slot_latency_seconds",
    ] {
        assert!(seen.contains(name), "{name}");
    } // 3 ms late, and 6.125 s old.
    for (line, count) in [
        ("utm_fusion_slot_lateness_seconds_bucket{le=\"0.002\"}", 0),
        ("utm_fusion_slot_lateness_seconds_bucket{le=\"0.005\"}", 1),
        ("utm_fusion_slot_lateness_seconds_bucket{le=\"+Inf\"}", 1),
        ("utm_fusion_slot_latency_seconds_bucket{le=\"6\"}", 0),
        ("utm_fusion_slot_latency_seconds_bucket{le=\"6.25\"}", 1),
    ] {
        assert!(text.contains(&format!("\n{line} {count}\n")), "{line} {count}\n{text}");
    }
    assert!(text.contains("\nutm_fusion_slot_latency_seconds_sum 6.128\n"), "{text}");
    if cfg!(target_os = "linux") {
        for name in
            ["cpu_seconds_total", "resident_memory_bytes", "open_fds", "max_fds", "start_time_seconds"]
        {
            assert!(seen.contains(&format!("process_{name}")), "{name}");
        }
    }
}

/// Metrics of the traffic are counted by kind. A replay has no lateness.
#[tokio::test]
async fn published_tracks_are_counted_by_source() {
    let mut site = Site::plain();
    site.publish(1).await;
    let (text, picture) = (site.get("/metrics").await.text, site.get("/api/v1/tracks").await.json());
    assert!(!text.contains("slot_late") && !text.contains("slot_latency"), "{text}");
    let features = picture["features"].as_array().unwrap();
    for source in ["fused", "radar", "transponder"] {
        let count = features.iter().filter(|track| track["properties"]["source"] == source).count();
        let line = format!("utm_fusion_tracks_of_source{{source=\"{source}\"}} {count}\n");
        assert!(text.contains(&line), "{line}{text}");
    }
    assert!(text.contains("\nutm_fusion_alerts{kind=\"area\",severity=\"warning\"} 0\n"), "{text}");
}

/// All references of a document resolve, and its channels are complete.
#[tokio::test]
async fn asyncapi_describes_both_streams_with_valid_references() {
    fn references<'a>(value: &'a Value, found: &mut Vec<&'a str>) {
        match value {
            Value::Object(members) => {
                found.extend(members.get("$ref").and_then(Value::as_str));
                members.values().for_each(|member| references(member, found));
            }
            Value::Array(items) => items.iter().for_each(|item| references(item, found)),
            _ => {}
        }
    }
    let mut site = Site::plain();
    site.publish(1).await;
    let document = site.get("/api/v1/asyncapi.json").await.json();
    assert_eq!(document["asyncapi"], "3.0.0");
    let mut found = Vec::new();
    references(&document, &mut found);
    assert!(found.len() > 20);
    found.iter().for_each(|to| assert!(document.pointer(&to[1..]).is_some(), "{to}"));
    let api = site.get("/openapi.json").await.json();
    for (channel, operation) in [("stream", "sendEvents"), ("websocket", "sendMessages")] {
        let described = &document["channels"][channel];
        let path = described["address"].as_str().unwrap();
        let query = match channel {
            "stream" => &document["operations"][operation]["bindings"]["http"]["query"],
            _ => &described["bindings"]["ws"]["query"],
        };
        let names: BTreeSet<&str> =
            query["properties"].as_object().unwrap().keys().map(String::as_str).collect();
        let parameters = api["paths"][path]["get"]["parameters"].as_array().unwrap();
        assert_eq!(names, parameters.iter().map(|parameter| parameter["name"].as_str().unwrap()).collect());
        assert_eq!(document["operations"][operation]["channel"]["$ref"], format!("#/channels/{channel}"));
        assert!(described["messages"].as_object().unwrap().len() >= 10);
    }
}

/// The page loads from this service only, and needs no exception from the content security policy.
#[tokio::test]
async fn the_page_of_the_api_is_all_here() {
    let site = Site::plain();
    let page = site.get("/api/docs").await;
    assert_eq!(page.header("content-type"), "text/html; charset=utf-8");
    assert!(page.header("content-security-policy").starts_with("default-src 'self'; frame-ancestors"));
    for part in
        ["<html lang=\"en\">", "name=\"viewport\"", "<main ", "<nav aria-label=", "<h1>", "<noscript>"]
    {
        assert!(page.text.contains(part), "{part}");
    }
    assert!(
        !page.text.contains("style=") && !page.text.contains("<script>") && !page.text.contains("onclick")
    );
    let links =
        page.text.split(['"']).filter(|part| part.contains('.') && !part.contains([' ', '<', ':', '=']));
    let mut count = 0;
    for link in links {
        let path = match link.strip_prefix("../") {
            Some(path) => format!("/{path}"),
            None => format!("/api/{link}"),
        };
        assert_eq!(site.get(&path).await.status, StatusCode::OK, "{path}");
        count += 1;
    }
    assert!(count >= 5, "{count}");
    for path in ["/api/docs.js", "/api/docs.css"] {
        let text = site.get(path).await.text;
        assert!(!text.contains("http:") && !text.contains("https:") && !text.contains("innerHTML"), "{path}");
    }
    assert!(site.get("/api/docs.css").await.text.contains("prefers-color-scheme: dark"));
}

/// `docs/API.md` refers to the reference for the properties of a track.
#[tokio::test]
async fn reference_describes_each_property_of_a_track() {
    let document = Site::plain().get("/openapi.json").await.json();
    for schema in ["TrackProperties", "UasId", "AircraftJson", "Contributor", "Competitor", "Ellipse"] {
        let properties = document["components"]["schemas"][schema]["properties"].as_object();
        let properties = properties.unwrap_or_else(|| panic!("no schema {schema}"));
        for (name, property) in properties {
            let description = property["description"].as_str().unwrap_or_default();
            assert!(!description.is_empty(), "{schema}.{name}");
        }
    }
}

/// Calls `look` with every object of a document and its path.
fn each_object(value: &Value, place: &str, look: &mut impl FnMut(&serde_json::Map<String, Value>, &str)) {
    match value {
        Value::Object(object) => {
            look(object, place);
            object.iter().for_each(|(name, value)| each_object(value, &format!("{place}/{name}"), look));
        }
        Value::Array(values) => values.iter().for_each(|value| each_object(value, place, look)),
        _ => {}
    }
}

/// Rules of the linters and generators that `scripts/openapi-clients` runs, without a network.
#[tokio::test]
async fn documents_satisfy_client_generators() {
    let site = Site::plain();
    for path in ["/openapi.json", "/api/v1/asyncapi.json"] {
        let document = site.get(path).await.json();
        each_object(&document, "", &mut |object, place| {
            let kinds: Vec<&Value> = match object.get("type") {
                Some(Value::Array(kinds)) => kinds.iter().collect(),
                Some(kind) => vec![kind],
                None => Vec::new(),
            };
            if kinds.iter().any(|kind| *kind == "array") {
                assert!(object.get("items").is_some_and(Value::is_object), "{path}: {place}: no items");
            }
            if let Some(Value::Array(values)) = object.get("enum")
                && !kinds.is_empty()
            {
                let is_nullable = kinds.iter().any(|kind| *kind == "null");
                assert_eq!(values.contains(&Value::Null), is_nullable, "{path}: {place}: null in its enum");
                let distinct: BTreeSet<String> = values.iter().map(Value::to_string).collect();
                assert_eq!(distinct.len(), values.len(), "{path}: {place}: a value twice");
            }
            if let Some(Value::String(reference)) = object.get("$ref") {
                let target = document.pointer(reference.strip_prefix('#').unwrap());
                assert!(target.is_some(), "{path}: {place}: {reference} leads nowhere");
            }
        });
    }
}

/// Generators omit bodies of unknown media types; openapi-python-client knows only these.
#[tokio::test]
async fn each_body_has_a_media_type_that_generators_know() {
    let document = Site::plain().get("/openapi.json").await.json();
    let is_json = |kind: &str| kind == "application/json" || kind.ends_with("+json");
    let is_known = |kind: &str| is_json(kind) || kind == "application/octet-stream";
    for (path, operations) in document["paths"].as_object().unwrap() {
        for operation in operations.as_object().unwrap().values() {
            if let Some(sent) = operation["requestBody"]["content"].as_object() {
                assert!(sent.keys().any(|kind| is_known(kind)), "{path}: {sent:?}");
            }
            for (status, response) in operation["responses"].as_object().unwrap() {
                let Some(content) = response["content"].as_object() else { continue };
                let is_known = |kind: &String| is_known(kind) || kind.starts_with("text/");
                assert!(content.keys().any(is_known), "{path}: {status}: {content:?}");
            }
        }
    }
}

/// Schemas of requests require exactly the fields that the service requires.
#[tokio::test]
async fn bodies_require_what_the_service_requires() {
    let document = Site::plain().get("/openapi.json").await.json();
    for (schema, required) in [
        ("AlertWord", json!(null)),
        ("AlertShelf", json!(["minutes"])),
        ("IntegrityVerdict", json!(["verdict"])),
        ("RemoteIdLine", json!(["transmitter", "message"])),
    ] {
        let schema = &document["components"]["schemas"][schema];
        assert_eq!(schema["required"], required, "{schema}");
    }
}

#[tokio::test]
async fn operations_have_ids_and_the_security_in_force() {
    for (site, needs_token) in [(Site::plain(), false), (guarded(), true)] {
        let document = site.get("/openapi.json").await.json();
        let mut ids = BTreeSet::new();
        for (path, operations) in document["paths"].as_object().unwrap() {
            for operation in operations.as_object().unwrap().values() {
                let id = operation["operationId"].as_str().unwrap();
                assert!(id.bytes().all(|octet| octet.is_ascii_alphanumeric()), "{id}");
                assert!(ids.insert(id.to_owned()), "{id} twice");
                let is_guarded = operation["description"].as_str().is_some_and(|text| text.contains("scope"));
                let expected = if needs_token && is_guarded { json!([{ "token": [] }]) } else { json!([]) };
                assert_eq!(operation["security"], expected, "{path}");
            }
        }
    }
}

/// The enum of sensor kinds contains every kind of the configuration.
#[tokio::test]
async fn document_has_the_configured_sensor_kinds() {
    let document = Site::plain().get("/openapi.json").await.json();
    let kinds = &document["components"]["schemas"]["SensorProperties"]["properties"]["kind"]["enum"];
    assert_eq!(*kinds, json!(["radar", "transponder", "adsb", "remote-id", "camera"]));
}
