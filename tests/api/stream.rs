//! The stream over sockets.

use std::collections::BTreeSet;

use axum::body::Body;
use axum::http::Request;
use fusion::time::Time;
use futures_util::StreamExt;
use tower::ServiceExt;
use utm_fusion::api::Options;
use utm_fusion::live::{PublishedPicture, SensorState};

use crate::common::{Reader, Site, flown};

const STREAM: &str = "/api/v1/stream";

#[tokio::test]
async fn a_snapshot_then_one_event_a_slot() {
    let mut site = Site::plain();
    site.publish(2).await;
    let address = site.listen().await;
    let mut reader = Reader::open(address, STREAM, "").await;
    let head = reader.head.to_lowercase();
    for line in ["200 ok", "text/event-stream", "x-accel-buffering: no", "cache-control: no-store"] {
        assert!(head.contains(line), "{line} is missing: {head}");
    }
    let snapshot = reader.next().await.unwrap();
    assert_eq!(snapshot.name, "snapshot");
    assert_eq!(snapshot.data, site.get("/api/v1/tracks").await.json());
    for slot in 1..=8 {
        site.publish(1).await;
        let event = reader.next().await.unwrap();
        assert_eq!(event.name, "tracks");
        assert_eq!(event.data["seq"].as_u64(), snapshot.data["seq"].as_u64().map(|seq| seq + slot));
        assert_eq!(event.data, site.get("/api/v1/tracks").await.json());
    }
    site.state.close();
    assert_eq!(reader.next().await.unwrap().name, "closed");
    assert!(reader.any().await.is_none(), "the stream ends");
}

#[tokio::test]
async fn filters_and_intervals() {
    let mut site = Site::plain();
    site.publish(1).await;
    let address = site.listen().await;
    let mut fused = Reader::open(address, "/api/v1/stream?source=fused", "").await;
    let mut slow = Reader::open(address, "/api/v1/stream?interval_ms=1000", "").await;
    let first = fused.next().await.unwrap();
    assert_eq!(first.data, site.get("/api/v1/tracks?source=fused").await.json());
    assert_eq!(slow.next().await.unwrap().name, "snapshot");
    site.publish(8).await;
    for step in 1..=8 {
        let event = loop {
            let event = fused.next().await.unwrap();
            if event.name == "tracks" {
                break event;
            }
        };
        assert_eq!(event.data["seq"].as_u64(), first.data["seq"].as_u64().map(|seq| seq + step));
        assert!(
            event.data["features"].as_array().unwrap().iter().all(|f| f["properties"]["source"] == "fused")
        );
    }
    for step in [4, 8] {
        let event = loop {
            let event = slow.next().await.unwrap();
            if event.name == "tracks" {
                break event;
            }
        };
        assert_eq!(event.data["seq"].as_u64(), first.data["seq"].as_u64().map(|seq| seq + step));
    }
}

#[tokio::test]
async fn reader_resumes_or_restarts() {
    let mut site = Site::plain();
    site.publish(2).await;
    let address = site.listen().await;
    let id = Reader::open(address, STREAM, "").await.next().await.unwrap().id;
    site.publish(3).await;
    let mut resumed = Reader::open(address, STREAM, &format!("Last-Event-ID: {id}\r\n")).await;
    let events =
        [resumed.next().await.unwrap(), resumed.next().await.unwrap(), resumed.next().await.unwrap()];
    assert!(events.iter().all(|event| event.name == "tracks"));
    let (start, number) = id.split_once('-').unwrap();
    let far = format!("{start}-{}", number.parse::<u64>().unwrap() + 1000);
    for strange in [far, format!("1-{number}"), "x".to_owned(), format!("{start}-")] {
        let mut reader = Reader::open(address, STREAM, &format!("Last-Event-ID: {strange}\r\n")).await;
        assert_eq!(reader.next().await.unwrap().name, "snapshot", "{strange}");
    }
    // The log holds 64 slots.
    for _ in 0..14 {
        site.publish(5).await;
    }
    let mut late = Reader::open(address, STREAM, &format!("Last-Event-ID: {id}\r\n")).await;
    assert_eq!(late.next().await.unwrap().name, "snapshot");
}

#[tokio::test]
async fn slow_reader_restarts_without_delaying_others() {
    let mut site = Site::plain();
    let address = site.listen().await;
    site.publish(1).await;
    let mut lazy = Reader::open(address, STREAM, "").await;
    let mut keen = Reader::open(address, STREAM, "").await;
    assert_eq!(keen.next().await.unwrap().name, "snapshot");
    // Far more than sockets buffer: the same slots, with new numbers.
    let frames = &flown().frames;
    let mut frame = frames[frames.len() / 2].clone();
    let mut tracks = frame.picture.tracks.clone();
    for _ in 0..6 {
        tracks.extend(tracks.clone());
    }
    frame.picture.tracks = tracks;
    for _ in 0..120 {
        site.writer.publish(next_slot(&mut frame));
        let event = keen.next().await.unwrap();
        assert_eq!((event.name.as_str(), event.data["seq"].as_u64()), ("tracks", Some(frame.seq)));
    }
    let mut names = Vec::new();
    while names.last().is_none_or(|name| name != "resync") {
        names.push(lazy.next().await.unwrap().name);
    }
    assert_eq!(names[0], "snapshot");
    let snapshot = lazy.next().await.unwrap();
    assert_eq!((snapshot.name.as_str(), snapshot.data["seq"].as_u64()), ("snapshot", Some(frame.seq)));
}

/// Tracks of the previous slot, one slot later, each with its new time.
fn next_slot(frame: &mut PublishedPicture) -> PublishedPicture {
    let later = |time: &mut Time| *time = *time + jiff::SignedDuration::from_millis(250);
    frame.seq += 1;
    later(&mut frame.due);
    later(&mut frame.published_at);
    later(&mut frame.picture.time);
    frame.picture.tracks.iter_mut().for_each(|track| later(&mut track.time));
    frame.clone()
}

#[tokio::test]
async fn only_changed_tracks_are_sent_again() {
    let mut site = Site::plain();
    site.publish(1).await;
    let address = site.listen().await;
    let mut readers = Vec::new();
    for query in ["", "?source=fused,radar,transponder", "?interval_ms=500"] {
        let mut reader = Reader::open(address, &format!("{STREAM}{query}"), "").await;
        assert_eq!(reader.next().await.unwrap().name, "snapshot");
        readers.push(reader);
    }
    // The first of the next two slots moves one track, the second another; everything else is unchanged.
    let mut frame = flown().frames[flown().frames.len() / 2].clone();
    let mut moved = Vec::new();
    for index in [2, 5] {
        let before = frame.picture.tracks.clone();
        let next = next_slot(&mut frame);
        for (place, track) in frame.picture.tracks.iter_mut().enumerate().filter(|(place, _)| *place != index)
        {
            *track = before[place].clone();
        }
        moved.push(flown().maker.track_id(&next.picture.tracks[index]));
        site.writer.publish(frame.clone());
    }
    let ids = |data: &serde_json::Value| -> Vec<String> {
        let features = data["features"].as_array().unwrap().iter();
        features.map(|feature| feature["id"].as_str().unwrap().to_owned()).collect()
    };
    for reader in &mut readers[..2] {
        for id in &moved {
            let event = reader.next().await.unwrap();
            assert_eq!((event.name.as_str(), ids(&event.data)), ("tracks", vec![id.clone()]));
            assert_eq!(event.data["numberReturned"], 1);
        }
    }
    let event = readers[2].next().await.unwrap();
    assert_eq!(ids(&event.data), [moved[1].clone(), moved[0].clone()]);
    site.shown(frame.seq).await;
    let all = site.get("/api/v1/tracks").await.json();
    assert_eq!(ids(&all).len(), frame.picture.tracks.len(), "the picture is whole");
    let kept = ids(&all).iter().position(|id| !moved.contains(id)).unwrap();
    assert_eq!(all["features"][kept]["properties"]["age_s"], 6.625, "its age goes on");
}

/// A frame, followed by slots that each lack one more track.
fn dwindling() -> (PublishedPicture, impl FnMut() -> (PublishedPicture, Option<String>)) {
    let mut frame = flown().frames[flown().frames.len() / 2].clone();
    // Enough tracks to remove one per slot.
    let tracks = frame.picture.tracks.clone();
    for copy in 1..8 {
        frame.picture.tracks.extend(tracks.iter().cloned().map(|mut track| {
            track.point.number += 1_000 * copy;
            track
        }));
    }
    let first = frame.clone();
    let next = move || {
        let gone = frame.picture.tracks.pop().map(|track| flown().maker.track_id(&track));
        (next_slot(&mut frame), gone)
    };
    (first, next)
}

#[tokio::test]
async fn an_interval_holds_also_where_tracks_end_in_every_slot() {
    let site = Site::plain();
    let (first, mut next) = dwindling();
    let start = first.seq;
    site.writer.publish(first);
    site.shown(start).await;
    let address = site.listen().await;
    let mut reader = Reader::open(address, "/api/v1/stream?interval_ms=2000", "").await;
    assert_eq!(reader.next().await.unwrap().name, "snapshot");
    let (mut gone, mut seq) = (Vec::new(), 0);
    for _ in 0..48 {
        let (frame, left) = next();
        seq = frame.seq;
        gone.push(left.expect("there are enough of them"));
        site.writer.publish(frame);
    }
    site.shown(seq).await;
    site.state.close();
    let (mut slots, mut ended) = (Vec::new(), Vec::new());
    while let Some(event) = reader.next().await {
        match &*event.name {
            "tracks" => slots.push(event.data["seq"].as_u64().unwrap() - start),
            "ended" => {
                assert_eq!(slots.last().map(|slot| slot % 8), Some(0), "ended comes with the tracks");
                ended.extend(
                    event.data["ids"].as_array().unwrap().iter().map(|id| id.as_str().unwrap().to_owned()),
                );
            }
            _ => {}
        }
    }
    assert_eq!(slots, [8, 16, 24, 32, 40, 48]);
    // A track ends 2 s after the last slot with it.
    let mut owed: Vec<String> = gone[..41].to_vec();
    owed.sort();
    ended.sort();
    assert_eq!(ended, owed);
}

#[tokio::test]
async fn track_that_returns_within_interval_has_not_ended() {
    let site = Site::plain();
    let mut frame = flown().frames[flown().frames.len() / 2].clone();
    let start = frame.seq;
    site.writer.publish(frame.clone());
    site.shown(start).await;
    let address = site.listen().await;
    let mut reader = Reader::open(address, "/api/v1/stream?interval_ms=5000", "").await;
    assert_eq!(reader.next().await.unwrap().name, "snapshot");
    let id = flown().maker.track_id(&frame.picture.tracks[0]);
    for slot in 1..=20 {
        let mut shown = next_slot(&mut frame);
        if (2..=12).contains(&slot) {
            shown.picture.tracks.remove(0);
        }
        site.writer.publish(shown);
    }
    site.shown(frame.seq).await;
    site.state.close();
    let tracks = reader.next().await.unwrap();
    assert_eq!((tracks.name.as_str(), tracks.data["seq"].as_u64()), ("tracks", Some(start + 20)));
    assert!(tracks.data["features"].as_array().unwrap().iter().any(|feature| feature["id"] == id.as_str()));
    assert_eq!(reader.next().await.unwrap().name, "closed");
}

#[tokio::test]
async fn a_connection_that_ends_within_an_interval_loses_nothing() {
    let mut site = Site::plain();
    site.publish(1).await;
    let address = site.listen().await;
    let path = "/api/v1/stream?interval_ms=2000";
    let id = Reader::open(address, path, "").await.next().await.unwrap().id;
    // A track changes in the next slot only. The connection ends one slot later.
    let mut frame = flown().frames[flown().frames.len() / 2].clone();
    let mut still = frame.picture.tracks.clone();
    let moved = next_slot(&mut frame).picture.tracks[3].clone();
    still[3] = moved.clone();
    let mut publish = |site: &Site| {
        frame.picture.tracks = still.clone();
        site.writer.publish(frame.clone());
        let seq = frame.seq;
        next_slot(&mut frame);
        seq
    };
    publish(&site);
    let seq = publish(&site);
    site.shown(seq).await;
    let (start, number) = id.split_once('-').unwrap();
    let last = number.parse::<u64>().unwrap() + 2;
    let mut resumed = Reader::open(address, path, &format!("Last-Event-ID: {start}-{last}\r\n")).await;
    for _ in 0..8 {
        publish(&site);
    }
    let event = resumed.next().await.unwrap();
    assert_eq!(event.name, "tracks");
    let id = flown().maker.track_id(&moved);
    assert!(
        event.data["features"].as_array().unwrap().iter().any(|feature| feature["id"] == id.as_str()),
        "{event:?}"
    );
}

#[tokio::test]
async fn replay_that_jumps_back_restarts_all_readers() {
    let mut site = Site::plain();
    site.publish(4).await;
    let address = site.listen().await;
    let mut readers = Vec::new();
    for query in ["", "?source=fused", "?interval_ms=1000"] {
        let mut reader = Reader::open(address, &format!("{STREAM}{query}"), "").await;
        assert_eq!(reader.next().await.unwrap().name, "snapshot");
        readers.push(reader);
    }
    let frames = &flown().frames;
    let earlier =
        PublishedPicture { seq: frames.last().unwrap().seq + 1, ..frames[frames.len() / 3].clone() };
    site.writer.publish(earlier.clone());
    for reader in &mut readers {
        assert_eq!(reader.next().await.unwrap().name, "resync");
        let snapshot = reader.next().await.unwrap();
        assert_eq!((snapshot.name.as_str(), &snapshot.data["seq"]), ("snapshot", &earlier.seq.into()));
        assert_eq!(snapshot.data["time"], earlier.picture.time.to_string());
    }
}

#[tokio::test]
async fn a_snapshot_has_trails_where_they_are_asked_for() {
    let mut site = Site::plain();
    site.publish(40).await;
    let address = site.listen().await;
    let mut reader = Reader::open(address, "/api/v1/stream?trail_s=5", "").await;
    let snapshot = reader.next().await.unwrap();
    assert_eq!(snapshot.data, site.get("/api/v1/tracks?trail_s=5").await.json());
    let features = snapshot.data["features"].as_array().unwrap();
    assert!(features.iter().any(|f| f["properties"]["trail"].is_object()), "{features:?}");
    site.publish(1).await;
    let event = reader.next().await.unwrap();
    assert!(event.data["features"][0]["properties"].get("trail").is_none(), "those who listen have it");
}

#[tokio::test]
async fn tracks_that_no_longer_come_have_ended() {
    for query in ["", "?source=fused,radar,transponder"] {
        let mut site = Site::plain();
        site.publish(1).await;
        let address = site.listen().await;
        let mut reader = Reader::open(address, &format!("{STREAM}{query}"), "").await;
        let snapshot = reader.next().await.unwrap();
        let frames = &flown().frames;
        let mut frame = frames[frames.len() / 2].clone();
        let gone = frame.picture.tracks.remove(0);
        let id = flown().maker.track_id(&gone);
        assert!(snapshot.data["features"].as_array().unwrap().iter().any(|f| f["id"] == id.as_str()));
        for slot in 1..=8 {
            site.writer.publish(next_slot(&mut frame));
            assert_eq!(reader.next().await.unwrap().name, "tracks", "{slot}");
        }
        let ended = reader.next().await.unwrap();
        assert_eq!((ended.name.as_str(), &ended.data["ids"]), ("ended", &serde_json::json!([id])));
    }
}

#[tokio::test]
async fn a_heartbeat_each_second_and_news_of_sensors() {
    let site = Site::plain();
    let address = site.listen().await;
    let mut status = flown().status.clone();
    site.publish_status(status.clone()).await;
    let mut reader = Reader::open(address, STREAM, "").await;
    assert_eq!(reader.next().await.unwrap().name, "snapshot");
    let other = &flown().config.sensors[1].id;
    let mut elsewhere = Reader::open(address, &format!("{STREAM}?sensor={other}"), "").await;
    assert_eq!(elsewhere.next().await.unwrap().name, "snapshot");
    loop {
        let event = reader.any().await.unwrap();
        if event.name == "heartbeat" {
            assert_eq!(event.data["seq"], 0);
            break;
        }
    }
    status.sensors[0].state = SensorState::Outage;
    status.sensors[0].reasons = vec!["it is dark".to_owned()];
    site.publish_status(status.clone()).await;
    let (sensor, alert) = sensor_and_alert(&mut reader).await;
    assert_eq!(sensor["state"], "outage");
    assert!(alert["text"].as_str().unwrap().ends_with("outage: it is dark"), "{alert}");
    assert_eq!((&alert["severity"], alert.get("until")), (&"critical".into(), None));
    let alerts = site.get("/api/v1/alerts").await.json();
    assert_eq!(alerts["alerts"][0]["since"], alert["since"]);
    status.sensors[0].state = SensorState::Operational;
    site.publish_status(status).await;
    let (sensor, over) = sensor_and_alert(&mut reader).await;
    assert_eq!((&sensor["state"], &over["id"]), (&"operational".into(), &alert["id"]));
    assert!(over["until"].is_string());
    let alerts = site.get("/api/v1/alerts").await.json();
    assert_eq!((alerts["alerts"].as_array().unwrap().len(), &alerts["ended"][0]["id"]), (0, &alert["id"]));
    // A reader of another sensor receives the alerts only.
    for id in [&alert["id"], &over["id"]] {
        let event = elsewhere.next().await.unwrap();
        assert_eq!((event.name.as_str(), &event.data["id"]), ("alert", id));
    }
}

/// The next two events, in either order.
async fn sensor_and_alert(reader: &mut Reader) -> (serde_json::Value, serde_json::Value) {
    let (one, other) = (reader.next().await.unwrap(), reader.next().await.unwrap());
    let (sensor, alert) = if one.name == "sensor" { (one, other) } else { (other, one) };
    assert_eq!((sensor.name.as_str(), alert.name.as_str()), ("sensor", "alert"));
    (sensor.data, alert.data)
}

#[tokio::test]
async fn streams_are_limited() {
    let site = Site::with(Options { streams_per_address: 2, ..Options::default() }, |_| {});
    let address = site.listen().await;
    let first = Reader::open(address, STREAM, "").await;
    let _second = Reader::open(address, STREAM, "").await;
    let third = Reader::open(address, STREAM, "").await;
    assert!(
        third.head.contains("429") && third.head.to_lowercase().contains("retry-after"),
        "{}",
        third.head
    );
    drop(first);
    for _ in 0..100 {
        if Reader::open(address, STREAM, "").await.head.contains("200 OK") {
            return;
        }
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    }
    panic!("the place is not given back");
}

#[tokio::test]
async fn a_thousand_readers_get_the_same_octets() {
    let mut site = Site::plain();
    site.publish(1).await;
    let mut bodies = Vec::new();
    for _ in 0..1_000 {
        let request = Request::get(STREAM).body(Body::empty()).unwrap();
        let mut events = site.app.clone().oneshot(request).await.unwrap().into_body().into_data_stream();
        assert!(events.next().await.unwrap().unwrap().starts_with(b"id: "));
        bodies.push(events);
    }
    site.publish(1).await;
    let mut places = BTreeSet::new();
    for events in &mut bodies {
        // A heartbeat may come in between; it is shared too.
        let mut octets = events.next().await.unwrap().unwrap();
        while !octets.windows(13).any(|part| part == b"event: tracks") {
            octets = events.next().await.unwrap().unwrap();
        }
        places.insert(octets.as_ptr() as usize);
    }
    assert_eq!(places.len(), 1, "the event was written more than once");
}
