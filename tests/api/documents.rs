//! The OpenAPI document and the router say the same; the metrics are what Prometheus reads.

use std::collections::BTreeSet;

use axum::http::{Method, Request, StatusCode};
use utm_fusion::api::routes::ROUTES;

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
            assert!(operation["responses"]["200"]["content"].is_object(), "{path}");
            let is_probe = path == "/healthz" || path == "/readyz";
            assert_eq!(operation["responses"]["429"].is_object(), !is_probe, "{path}");
            // A stream does not end: that it is there is seen by what it refuses.
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
                if parameter["in"] == "query" && parameter["name"] != "ticket" {
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
    site.tell(flown().status.clone()).await;
    site.publish(1).await;
    let text = site.get("/metrics").await.text;
    let mut family = String::new();
    let mut is_summary = false;
    let mut seen = BTreeSet::new();
    let mut samples = BTreeSet::new();
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("# HELP ") {
            family = rest.split(' ').next().unwrap().to_owned();
            assert!(seen.insert(family.clone()), "{family} comes twice");
        } else if let Some(rest) = line.strip_prefix("# TYPE ") {
            let (name, kind) = rest.split_once(' ').unwrap();
            assert_eq!(name, family);
            assert!(matches!(kind, "counter" | "gauge" | "summary"));
            is_summary = kind == "summary";
            assert_eq!(kind == "counter", name.ends_with("_total"), "{name}");
        } else {
            assert_eq!(line.contains("quantile="), is_summary, "the label is reserved: {line}");
            let (series, value) = line.rsplit_once(' ').unwrap();
            assert!(value.parse::<f64>().unwrap().is_finite(), "{line}");
            assert!(samples.insert(series), "{series} comes twice");
            let name = series.split('{').next().unwrap();
            assert_eq!(name, family, "{line}");
            assert!(
                name.starts_with("utm_fusion_") && name.bytes().all(|c| c == b'_' || c.is_ascii_lowercase())
            );
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
    ] {
        assert!(seen.contains(name), "{name}");
    }
}
