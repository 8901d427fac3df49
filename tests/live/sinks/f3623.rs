//! Observations for surveillance supplementary data: the posts match the interface of Flight Blender.

use std::net::TcpListener;
use std::time::Duration;

use serde_json::Value;
use utm_fusion::live::PublishedPicture;
use utm_fusion::picture::PictureTrack;
use utm_fusion::sinks::SinkLoss;

use super::{Site, flown, tracks, wait_for};
use crate::common::Scratch;
use crate::notices::receiver::{Posted, Receiver, Say};

const PATH: &str = "/flight_stream/set_air_traffic/4d0a1f2e-8d66-4b52-9a57-0c3e8f1b7a90";

fn sink(port: u16, more: &str) -> String {
    format!("[[output.f3623]]\nid = \"sdsp\"\nurl = \"http://127.0.0.1:{port}{PATH}\"\n{more}\n")
}

/// Checks a body against the interface (`ArrayOfObservations`); returns the observations.
fn observations(posted: &Posted) -> Vec<Value> {
    assert_eq!((&*posted.path, &*posted.headers["content-type"]), (PATH, "application/json"));
    let json = posted.json();
    let observations = json["observations"].as_array().unwrap().clone();
    for observation in &observations {
        let number =
            |name: &str| observation[name].as_f64().unwrap_or_else(|| panic!("{name}: {observation}"));
        assert!((-90.0..=90.0).contains(&number("lat_dd")) && (-180.0..=180.0).contains(&number("lon_dd")));
        assert!(number("altitude_mm").is_finite());
        let id = observation["icao_address"].as_str().unwrap();
        assert!(!id.is_empty() && id.len() <= 24, "{id}");
        assert!([5, 8, 11].contains(&observation["traffic_source"].as_i64().unwrap()));
        assert!((0..=1).contains(&observation["source_type"].as_i64().unwrap()));
        // Whole milliseconds: values below 1e12 would be taken for seconds.
        assert!(observation["timestamp"].as_i64().unwrap() > 1_000_000_000_000);
        assert!(observation["metadata"].is_object());
    }
    observations
}

fn is_of(observation: &Value, track: &PictureTrack) -> bool {
    let near =
        |name: &str, value: f64, within: f64| (observation[name].as_f64().unwrap() - value).abs() < within;
    observation["icao_address"] == flown().maker.track_id(track)
        && near("lat_dd", track.position.latitude_deg(), 1e-7)
        && near("lon_dd", track.position.longitude_deg(), 1e-7)
        && near("altitude_mm", track.position.height_m * 1000.0, 1.0)
        && observation["timestamp"] == track.time.nanos() / 1_000_000
        && observation["metadata"]["source"] == track.source_name()
        && observation["metadata"]["id"] == observation["icao_address"]
}

/// Tracks with a height, and the number of tracks without one.
fn split(frame: &PublishedPicture) -> (Vec<&PictureTrack>, u64) {
    let (known, unknown): (Vec<_>, Vec<_>) =
        tracks(frame).into_iter().partition(|track| track.altitude_amsl_m.is_some());
    (known, unknown.len() as u64)
}

/// A second whose last track has no height.
fn without_a_height(second: usize) -> PublishedPicture {
    let mut frame = flown().frames[second].clone();
    frame.picture.tracks.last_mut().unwrap().altitude_amsl_m = None;
    frame
}

#[test]
fn each_second_is_posted_with_the_present_token() {
    let scratch = Scratch::new();
    let token = scratch.file("token", "first\n");
    let receiver = Receiver::start(&[Say::Status(201, ""), Say::Status(201, "")]);
    let more = format!("token_file = \"{}\"", token.display());
    let mut site = Site::open(&sink(receiver.port, &more));
    let frame = without_a_height(3);
    site.writer.publish(frame.clone());
    let posted = receiver.next();
    assert_eq!(posted.headers["authorization"], "Bearer first");
    let (known, unknown) = split(&frame);
    let seen = observations(&posted);
    assert_eq!(seen.len(), known.len());
    assert!(seen.iter().zip(known).all(|(observation, track)| is_of(observation, track)), "{seen:?}");
    wait_for("it is counted", || site.counts("f3623:sdsp").sent == 1);
    assert_eq!((unknown > 0, site.counts("f3623:sdsp").left_out), (true, unknown));
    scratch.file("token", "second\n");
    site.publish();
    assert_eq!(receiver.next().headers["authorization"], "Bearer second");
    site.close();
}

#[test]
fn failed_posts_are_counted_and_the_newest_is_posted() {
    let receiver =
        Receiver::start(&[Say::Status(401, ""), Say::Nothing, Say::Status(503, "Retry-After: 1\r\n")]);
    let mut site = Site::open(&sink(receiver.port, "timeout_s = 0.5"));
    site.publish();
    receiver.next();
    wait_for("it is refused", || site.lost("f3623:sdsp", SinkLoss::Refused) == 1);
    site.publish();
    site.publish();
    receiver.next();
    wait_for("it is not answered", || site.lost("f3623:sdsp", SinkLoss::Unreachable) == 2);
    site.publish();
    receiver.next();
    wait_for("it cannot now", || site.lost("f3623:sdsp", SinkLoss::Unreachable) == 3);
    let last = site.publish();
    let seen = observations(&receiver.next());
    assert!(is_of(&seen[0], split(last).0[0]));
    wait_for("it is taken", || site.counts("f3623:sdsp").sent == 1);
    assert!(!site.counts("f3623:sdsp").is_failing && receiver.is_done());
    site.close();
}

#[test]
fn unreachable_receiver_delays_no_slot_and_no_end() {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let mut site = Site::open(&sink(port, ""));
    (0..6).for_each(|_| _ = site.publish());
    wait_for("it fails", || site.counts("f3623:sdsp").failed >= 1);
    let began = std::time::Instant::now();
    site.close();
    assert!(began.elapsed() < Duration::from_secs(2));
    assert_eq!(site.counts("f3623:sdsp").sent, 0);
}
