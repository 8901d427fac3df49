//! The picture "now": its differences from the lagged picture.

use std::collections::BTreeSet;

use axum::http::{Request, StatusCode};
use serde_json::Value;
use utm_fusion::api::Options;

use crate::common::{Reader, Site, estimated};

fn ids(collection: &Value) -> BTreeSet<String> {
    let features = collection["features"].as_array().unwrap().iter();
    features.map(|feature| feature["id"].as_str().unwrap().to_owned()).collect()
}

fn time(collection: &Value) -> jiff::Timestamp {
    collection["time"].as_str().unwrap().parse().unwrap()
}

#[tokio::test]
async fn picture_now_is_of_the_opening_slot() {
    let mut site = Site::operational();
    let before = site.get("/api/v1/tracks?at=now").await.json();
    assert_eq!((&before["at"], ids(&before).len(), before.get("time")), (&Value::from("now"), 0, None));
    site.publish(3).await;
    let lagged = site.get("/api/v1/tracks").await;
    let now = site.get("/api/v1/tracks?at=now").await;
    assert_ne!(lagged.header("etag"), now.header("etag"));
    let again = Request::get("/api/v1/tracks?at=now").header("if-none-match", now.header("etag"));
    assert_eq!(site.ask(again).await.status, StatusCode::NOT_MODIFIED);
    let (lagged, now) = (lagged.json(), now.json());
    assert_eq!(lagged, site.get("/api/v1/tracks?at=lagged").await.json());
    assert_eq!((lagged.get("at"), lagged["latency_s"].as_f64()), (None, Some(6.25)));
    assert_eq!((&now["at"], now["latency_s"].as_f64()), (&Value::from("now"), Some(0.0)));
    assert_eq!(now["published_at"], lagged["published_at"]);
    assert_eq!((time(&now) - time(&lagged)).total(jiff::Unit::Second).unwrap(), 6.25);
    assert!(ids(&now).len() > 4, "{now}");
    for feature in now["features"].as_array().unwrap() {
        let properties = &feature["properties"];
        assert_eq!(properties["extrapolated"], true);
        assert_eq!(properties["age_s"], -0.125, "a slot's centre ahead");
        assert_eq!(properties["time"], now["time"]);
        assert!(
            properties["accuracy_ellipse"]["major_m"].as_f64()
                >= properties["accuracy_ellipse"]["minor_m"].as_f64()
        );
    }
    for feature in lagged["features"].as_array().unwrap() {
        assert_eq!(feature["properties"].get("accuracy_ellipse"), None);
    }
    // The filters of the picture apply.
    let some = site.get("/api/v1/tracks?at=now&source=transponder,fused&limit=2").await.json();
    assert_eq!(some["numberReturned"], 2);
    let info = site.get("/api/v1/info").await.json();
    assert_eq!(info["now"], true);
}

#[tokio::test]
async fn stream_of_picture_now_has_each_slot() {
    let mut site = Site::operational();
    site.publish(1).await;
    let address = site.listen().await;
    let mut lagged = Reader::open(address, "/api/v1/stream", "").await;
    let mut now = Reader::open(address, "/api/v1/stream?at=now", "").await;
    let mut seldom = Reader::open(address, "/api/v1/stream?at=now&interval_ms=1000", "").await;
    for reader in [&mut now, &mut seldom] {
        let snapshot = reader.next().await.unwrap();
        assert_eq!((snapshot.name.as_str(), &snapshot.data["at"]), ("snapshot", &Value::from("now")));
    }
    let plain = lagged.next().await.unwrap();
    assert_eq!((plain.name.as_str(), plain.data.get("at")), ("snapshot", None));
    let mut last = Value::Null;
    for _ in 0..8 {
        site.publish(1).await;
        let expected = site.get("/api/v1/tracks?at=now").await.json();
        let mut event = now.next().await.unwrap();
        while event.name == "ended" {
            event = now.next().await.unwrap();
        }
        assert_eq!((event.name.as_str(), &event.data), ("tracks", &expected));
        last = expected;
    }
    let mut event = seldom.next().await.unwrap();
    while event.data["time"] != last["time"] {
        assert!(["tracks", "ended"].contains(&event.name.as_str()));
        event = seldom.next().await.unwrap();
    }
    // A reader that reconnects continues at its last event.
    let id = format!("Last-Event-ID: {}\r\n", event.id);
    let mut again = Reader::open(address, "/api/v1/stream?at=now", &id).await;
    site.publish(1).await;
    let mut event = again.next().await.unwrap();
    while event.name == "ended" {
        event = again.next().await.unwrap();
    }
    assert_eq!((event.name.as_str(), &event.data["at"]), ("tracks", &Value::from("now")));
}

#[tokio::test]
async fn late_reader_starts_with_the_latest_picture_now() {
    let mut site = Site::operational();
    site.publish(1).await;
    let address = site.listen().await;
    let mut first = Reader::open(address, "/api/v1/stream?at=now", "").await;
    let snapshot = first.next().await.unwrap();
    drop(first);
    // Tracks predicted more than two seconds ago are no longer returned.
    site.publish(20).await;
    let id = format!("Last-Event-ID: {}\r\n", snapshot.id);
    let mut again = Reader::open(address, "/api/v1/stream?at=now", &id).await;
    let mut times = Vec::new();
    while times.last() != Some(&site.get("/api/v1/tracks?at=now").await.json()["time"]) {
        let event = again.next().await.unwrap();
        if event.name == "tracks" {
            times.push(event.data["time"].clone());
        }
    }
    assert!(!times.is_empty() && times.len() < 12, "{} slots", times.len());
}

#[tokio::test]
async fn absent_picture_now_is_reported() {
    for (site, at) in [
        (Site::operational(), "then"),
        (Site::with(Options::default(), |config| config.fusion.now = false), "now"),
    ] {
        for path in ["tracks", "stream"] {
            let answer = site.get(&format!("/api/v1/{path}?at={at}")).await;
            assert_eq!(
                (answer.status, &answer.json()["parameter"]),
                (StatusCode::BAD_REQUEST, &Value::from("at"))
            );
        }
    }
    assert!(estimated().frames.iter().all(|frame| frame.now.get().is_some()));
}
