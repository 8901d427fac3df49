//! Expensive answers do not delay others.

use std::num::NonZeroU32;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use axum::body::Body;
use axum::http::Request;
use tower::ServiceExt;
use utm_fusion::api::Options;

use crate::common::{Reader, Site};

#[tokio::test]
async fn health_is_answered_before_pictures_with_trails() {
    const TRAILS: usize = 24;
    let mut site = Site::plain();
    site.publish(40).await;
    let written = Arc::<AtomicUsize>::default();
    let ask = |path: String| {
        let (app, written) = (site.app.clone(), written.clone());
        tokio::spawn(async move {
            let is_trail = path.contains("trail_s");
            let answer = app.oneshot(Request::get(path).body(Body::empty()).unwrap()).await.unwrap();
            assert_eq!(answer.status(), if is_trail { 200 } else { answer.status().as_u16() });
            match is_trail {
                true => written.fetch_add(1, Ordering::Relaxed),
                false => written.load(Ordering::Relaxed),
            }
        })
    };
    // The tasks run in turn on one thread, in this order.
    let trails: Vec<_> = (1..=TRAILS).map(|s| ask(format!("/api/v1/tracks?trail_s={s}"))).collect();
    let probes = ["/healthz", "/readyz"].map(|path| ask(path.to_owned()));
    for probe in probes {
        let before = probe.await.unwrap();
        // All of them if probes shared the lane; a few if the system delays the probe's thread.
        assert!(before < TRAILS / 2, "{before} pictures were written before it");
    }
    for trail in trails {
        trail.await.unwrap();
    }
    assert_eq!(written.load(Ordering::Relaxed), TRAILS);
}

#[tokio::test]
async fn requests_are_counted_by_what_they_cost() {
    let site = Site::with(Options::default(), |config| {
        (config.http.requests_per_s, config.http.requests_burst) = (NonZeroU32::new(1), 30);
    });
    let address = site.listen().await;
    let status = async |path: &str| {
        let reader = Reader::open(address, path, "Connection: close\r\n").await;
        reader.head.split(' ').nth(1).unwrap().to_owned()
    };
    let day = "/api/v1/tracks/T-1/trail?since=2026-01-01T00:00:00Z&until=2026-01-02T00:00:00Z";
    // 18 of 30; then one of the remaining 12, but not 17 more.
    assert_eq!(status(day).await, "404", "there is no history");
    assert_eq!(status(day).await, "429");
    assert_eq!(status("/api/v1/info").await, "200");
}

#[tokio::test]
async fn picture_with_trails_is_made_once_per_slot() {
    let mut site = Site::plain();
    site.publish(20).await;
    let first = site.get("/api/v1/tracks?trail_s=3").await;
    let longer = site.get("/api/v1/tracks?trail_s=4").await;
    let again = site.get("/api/v1/tracks?trail_s=3").await;
    assert_eq!(first.text, again.text);
    assert_ne!(first.text, longer.text);
    assert_eq!(first.header("content-length"), first.text.len().to_string());
    site.publish(4).await;
    assert_ne!(first.text, site.get("/api/v1/tracks?trail_s=3").await.text);
}
