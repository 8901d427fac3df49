//! Operator actions on alerts, as API clients see them.

use axum::body::Body;
use axum::http::{Request, StatusCode};
use serde_json::{Value, json};
use tower::ServiceExt;
use utm_fusion::live::SensorState;

use crate::common::{Reader, Site};
use crate::schema::check;

/// Sets the state of the first sensor.
async fn sensed(site: &Site, state: SensorState) {
    let mut status = site.status();
    for sensor in &mut status.sensors {
        (sensor.state, sensor.reasons) = (SensorState::Operational, Vec::new());
    }
    (status.sensors[0].state, status.sensors[0].reasons) = (state, vec!["silent".to_owned()]);
    site.publish_status(status).await;
}

/// Active and ended alerts of sensors.
async fn listed(site: &Site, query: &str) -> [Vec<Value>; 2] {
    let answer = site.get(&format!("/api/v1/alerts?kind=sensor{query}")).await.json();
    ["alerts", "ended"].map(|name| answer[name].as_array().unwrap().clone())
}

async fn post(site: &Site, path: &str, body: &Value) -> (StatusCode, Value) {
    let request = Request::post(format!("/api/v1/alerts/{path}"))
        .header("content-type", "application/json")
        .body(Body::from(body.to_string()));
    let response = site.app.clone().oneshot(request.unwrap()).await.unwrap();
    let status = response.status();
    let octets = axum::body::to_bytes(response.into_body(), 1 << 20).await.unwrap();
    (status, serde_json::from_slice(&octets).unwrap())
}

#[tokio::test]
async fn alert_actions_are_published_to_all_readers() {
    let site = Site::plain();
    let address = site.listen().await;
    sensed(&site, SensorState::Degraded).await;
    let [lasting, _] = listed(&site, "").await;
    let [alert] = &lasting[..] else { panic!("{lasting:?}") };
    let id = alert["id"].as_str().unwrap();
    let mut reader = Reader::open(address, "/api/v1/stream", "").await;
    let document = site.get("/openapi.json").await.json();

    for (path, body, field, by) in [
        ("acknowledge", json!({ "by": "tower", "note": "on it" }), "acknowledged", json!("tower")),
        ("shelve", json!({ "minutes": 30 }), "shelved", json!("somebody without a token")),
        ("unshelve", json!({}), "shelved", Value::Null),
    ] {
        let (status, answer) = post(&site, &format!("{id}/{path}"), &body).await;
        assert_eq!(status, StatusCode::OK, "{answer}");
        let operation = &document["paths"][format!("/api/v1/alerts/{{id}}/{path}")]["post"];
        let schema = &operation["responses"]["200"]["content"]["application/json"]["schema"];
        check(&document, schema, &answer, path);
        assert_eq!(answer[field].get("by").cloned().unwrap_or_default(), by, "{answer}");
        let [lasting, _] = listed(&site, "").await;
        assert_eq!(lasting, std::slice::from_ref(&answer));
        let event = loop {
            let event = reader.next().await.unwrap();
            if event.name == "alert" && event.data[field] == answer[field] {
                break event;
            }
        };
        assert_eq!(event.data, answer);
    }
    let [lasting, _] = listed(&site, "").await;
    assert_eq!(lasting[0]["acknowledged"]["note"], "on it");
    sensed(&site, SensorState::Outage).await;
    let [lasting, _] = listed(&site, "").await;
    assert!(lasting[0]["severity"] == "critical" && lasting[0].get("acknowledged").is_none(), "{lasting:?}");
}

#[tokio::test]
async fn impossible_alert_action_is_a_problem_with_reason() {
    let site = Site::plain();
    sensed(&site, SensorState::Outage).await;
    let [lasting, _] = listed(&site, "").await;
    let id = lasting[0]["id"].as_str().unwrap().to_owned();
    for (path, body, status, why) in [
        ("sensor-99/acknowledge", json!({}), 404, "no such alert"),
        (&*format!("{id}/unshelve"), json!({}), 409, "is not shelved"),
        (&*format!("{id}/shelve"), json!({}), 400, "missing field `minutes`"),
        (&*format!("{id}/shelve"), json!({ "minutes": 0 }), 400, "at most 480 minutes"),
        (&*format!("{id}/shelve"), json!({ "minutes": 481 }), 400, "at most 480 minutes"),
        (&*format!("{id}/acknowledge"), json!({ "who": "me" }), 400, "unknown field"),
        (&*format!("{id}/acknowledge"), json!({ "by": "a\nb" }), 400, "a line of at most 100"),
        (&*format!("{id}/acknowledge"), json!({ "note": "x".repeat(501) }), 400, "a line of at most 500"),
    ] {
        let (answered, problem) = post(&site, path, &body).await;
        assert_eq!(answered.as_u16(), status, "{path} {body}: {problem}");
        assert!(problem["detail"].as_str().unwrap().contains(why), "{body}: {problem}");
    }
    sensed(&site, SensorState::Operational).await;
    // A critical alert that has ended waits for an acknowledgement.
    let (status, alert) = post(&site, &format!("{id}/acknowledge"), &json!({})).await;
    assert!(
        status == StatusCode::OK && alert["until"].is_string() && alert.get("latched").is_none(),
        "{alert}"
    );
    let (status, problem) = post(&site, &format!("{id}/acknowledge"), &json!({})).await;
    assert_eq!((status, &problem["detail"]), (StatusCode::CONFLICT, &json!("the alert has ended")));
}

#[tokio::test]
async fn ended_alerts_are_found_by_kind_and_time() {
    let site = Site::plain();
    for _ in 0..3 {
        sensed(&site, SensorState::Outage).await;
        sensed(&site, SensorState::Operational).await;
    }
    let [_, ended] = listed(&site, "").await;
    assert_eq!(ended.len(), 3, "{ended:?}");
    let until = ended[0]["until"].as_str().unwrap();
    assert_eq!(listed(&site, &format!("&since={until}")).await[1].len(), 3, "all of one moment");
    assert_eq!(listed(&site, "&since=2200-01-01T00:00:00Z").await[1], [Value::Null; 0]);
    assert_eq!(listed(&site, "&until=1999-01-01T00:00:00Z").await[1], [Value::Null; 0]);
    let page = site.get("/api/v1/alerts?kind=sensor,area&limit=2").await.json();
    assert_eq!((page["ended"].as_array().unwrap().len(), &page["more"]), (2, &json!(true)), "{page}");
    assert_eq!(site.get("/api/v1/alerts?kind=area,conflict").await.json()["ended"], json!([]));
    for (query, why) in [
        ("kind=loud", "kinds of alerts, separated by commas"),
        ("limit=0", "1 to 5000"),
        ("since=2026-01-02T00:00:00Z&until=2026-01-01T00:00:00Z", "not before since"),
    ] {
        let answer = site.get(&format!("/api/v1/alerts?{query}")).await;
        assert!(answer.status == StatusCode::BAD_REQUEST && answer.text.contains(why), "{}", answer.text);
    }
}
