//! Zones that operators activate, as API clients see them.

use std::path::PathBuf;

use axum::body::Body;
use axum::http::{Request, StatusCode};
use serde_json::{Value, json};
use tower::ServiceExt;
use utm_fusion::api::Options;
use utm_fusion::config::Auth;
use utm_fusion::live::{OperatorZones, now};
use utm_fusion::state::{StateHealth, ZoneStore};

use crate::common::{Site, flown};
use crate::schema::check;

/// SHA-256 of "watch-me".
const READER: &str = "443482e92b0b2c3da5a03ce39890d112332ca3d3534a784d7ffae903cc3879d1";

/// A site whose zones are kept in a directory, which is removed at the end.
struct Stage {
    site: Site,
    directory: PathBuf,
}

impl Stage {
    fn new(name: &str) -> Self {
        let directory =
            std::env::temp_dir().join(format!("utm-fusion-api-zones-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&directory);
        let store = ZoneStore::load(&directory, &StateHealth::default(), now());
        let (mut zones, requests) = OperatorZones::new(store);
        tokio::spawn(async move {
            while let Some(request) = zones.next().await {
                zones.carry_out(request, now(), |_| {});
            }
        });
        let options = Options { zones: Some(requests), ..Options::default() };
        Self { site: Site::with(options, |_| {}), directory }
    }

    async fn post(&self, path: &str, body: &str) -> (StatusCode, Value) {
        post(&self.site, path, body).await
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.directory);
    }
}

async fn post(site: &Site, path: &str, body: &str) -> (StatusCode, Value) {
    let request = Request::post(format!("/api/v1/zones/{path}"))
        .header("content-type", "application/json")
        .body(Body::from(body.to_owned()));
    let response = site.app.clone().oneshot(request.unwrap()).await.unwrap();
    let status = response.status();
    let octets = axum::body::to_bytes(response.into_body(), 1 << 20).await.unwrap();
    (status, serde_json::from_slice(&octets).unwrap())
}

fn zone(properties: &Value) -> String {
    let ring = "[[[-0.6,52.5],[-0.5,52.5],[-0.5,52.6],[-0.6,52.5]]]";
    format!(
        "{{\"type\":\"FeatureCollection\",\"features\":[{{\"type\":\"Feature\",\"properties\":{properties},\
         \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":{ring}}}}}]}}"
    )
}

#[tokio::test]
async fn activated_zone_is_listed_until_it_is_revoked() {
    let stage = Stage::new("listed");
    let site = &stage.site;
    let document = site.get("/openapi.json").await.json();
    let schema_of = |path: &str, method: &str| {
        document["paths"][path][method]["responses"]["200"]["content"]["application/json"]["schema"].clone()
    };
    assert_eq!(site.get("/api/v1/zones").await.json(), json!({ "available": true, "zones": [] }));

    let body = zone(&json!({ "name": "ignored", "floor_m": null, "ceiling_m": 120 }));
    let (status, activated) = stage.post("School%20%C3%B8%2F1?by=tower", &body).await;
    assert_eq!(status, StatusCode::OK, "{activated}");
    check(&document, &schema_of("/api/v1/zones/{id}", "post"), &activated, "activated");
    assert_eq!((&activated["name"], &activated["activated_by"]), (&json!("School ø/1"), &json!("tower")));
    assert_eq!((&activated["ceiling_m"], activated.get("floor_m")), (&json!(120.0), None));
    let list = site.get("/api/v1/zones").await.json();
    check(&document, &schema_of("/api/v1/zones", "get"), &list, "list");
    assert_eq!(list["zones"], json!([activated]));

    let areas = site.get("/api/v1/areas").await.json();
    let [area] = &areas["features"].as_array().unwrap()[..] else { panic!("{areas}") };
    let properties = &area["properties"];
    assert_eq!((&properties["name"], &properties["kind"]), (&json!("School ø/1"), &json!("alert")));
    assert_eq!((&properties["severity"], &properties["ceiling_m"]), (&json!("warning"), &json!(120.0)));
    assert_eq!(properties["activated_by"], "tower");
    assert_eq!(flown().config.areas.len(), 0);

    let (status, revoked) = stage.post("School%20%C3%B8%2F1/revoke?by=desk", "").await;
    assert_eq!((status, &revoked), (StatusCode::OK, &activated));
    assert_eq!(site.get("/api/v1/zones").await.json()["zones"], json!([]));
    assert_eq!(site.get("/api/v1/areas").await.json()["features"], json!([]));
}

#[tokio::test]
async fn refused_zone_is_a_problem_with_reason() {
    let stage = Stage::new("refused");
    let whole = zone(&Value::Null);
    for (path, body, status, why) in [
        ("a", "{", 400, "is no GeoJSON"),
        ("a", "", 400, "is no GeoJSON"),
        ("a", &*zone(&json!({ "floor_m": 9, "ceiling_m": 9 })), 400, "the ceiling is not above the floor"),
        ("a?by=a%0Ab", &whole, 400, "a line of at most 100"),
        ("a?who=me", &whole, 400, "there is no such parameter"),
        (&*"x".repeat(65), &whole, 400, "1 to 64 octets"),
        ("a%00", &whole, 400, "without control characters"),
        ("a", &" ".repeat(70_000), 413, "at most 65536 octets"),
        ("a/revoke", "", 404, "no operator has activated"),
    ] {
        let (answered, problem) = stage.post(path, body).await;
        assert_eq!(answered.as_u16(), status, "{path}: {problem}");
        assert!(problem["detail"].as_str().unwrap().contains(why), "{path}: {problem}");
    }
    for number in 0..100 {
        let (status, answer) = stage.post(&format!("{number}"), &whole).await;
        assert_eq!(status, StatusCode::OK, "{answer}");
    }
    assert_eq!(stage.post("100", &whole).await.0, StatusCode::CONFLICT);
    assert_eq!(stage.post("99", &whole).await.0, StatusCode::OK, "one is replaced");

    std::fs::remove_dir_all(&stage.directory).unwrap();
    std::fs::write(&stage.directory, "no directory").unwrap();
    let (status, problem) = stage.post("99", &whole).await;
    assert_eq!(status, StatusCode::SERVICE_UNAVAILABLE, "{problem}");
    assert_eq!(stage.site.get("/api/v1/zones").await.json()["zones"].as_array().unwrap().len(), 100);
    std::fs::remove_file(&stage.directory).unwrap();
}

#[tokio::test]
async fn zone_is_refused_where_none_is_kept() {
    let site = Site::plain();
    assert_eq!(site.get("/api/v1/zones").await.json(), json!({ "available": false, "zones": [] }));
    for path in ["a", "a/revoke"] {
        let (status, problem) = post(&site, path, &zone(&Value::Null)).await;
        assert_eq!(status, StatusCode::CONFLICT, "{problem}");
    }
}

#[tokio::test]
async fn zone_needs_the_scope_control() {
    let file = std::env::temp_dir().join(format!("utm-fusion-zone-tokens-{}.toml", std::process::id()));
    std::fs::write(&file, format!("reader = {{ sha256 = \"{READER}\", scopes = [\"read\", \"stream\"] }}\n"))
        .unwrap();
    let site = Site::with(Options::default(), |config| {
        config.http.auth = Auth::Tokens { tokens_file: file.clone() };
    });
    let ask = |path: &str, token: &str| {
        Request::post(format!("/api/v1/zones/{path}")).header("authorization", format!("Bearer {token}"))
    };
    for path in ["a", "a/revoke"] {
        assert_eq!(site.ask(ask(path, "watch-me")).await.status, StatusCode::FORBIDDEN, "{path}");
        assert_eq!(site.ask(ask(path, "nobody")).await.status, StatusCode::UNAUTHORIZED, "{path}");
    }
    std::fs::remove_file(file).unwrap();
}
