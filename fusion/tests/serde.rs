//! Data that users keep is serialised with serde and read back.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;
use utm_fusion_engine::settings::{Radar, Receiver};
use utm_fusion_engine::{Engine, Enu, Fix, Identity, Plot, RadarTrackKey, Report, Settings, Time};

/// Exact in a binary format. JSON rounds the last digit of some numbers, and must give the same text again.
fn kept<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) {
    let octets = postcard::to_stdvec(value).unwrap();
    assert_eq!(postcard::from_bytes::<T>(&octets).unwrap(), *value);
    let json = serde_json::to_value(value).unwrap();
    let again: T = serde_json::from_value(json.clone()).unwrap();
    assert_eq!(serde_json::to_value(&again).unwrap(), json);
}

#[test]
fn reports_and_picture_survive_serialisation() {
    let mut settings = Settings::default();
    let track = RadarTrackKey { sensor: settings.add_radar(Radar::default()), number: 7 };
    let receiver = settings.add_receiver(Receiver::default());
    let mut engine = Engine::new(settings).unwrap();
    let identity = Identity::new(b"DRONE-1", Some(b"NO")).unwrap();
    let (mut points, mut fused) = (0, 0);
    for second in 0..40 {
        let now: Time = Time::from_nanos((1_800_000_000 + second) * 1_000_000_000);
        for emission in engine.advance(now) {
            points += emission.points.len();
            fused += emission.points.iter().filter(|point| point.source.radar().is_some()).count();
            kept(&emission);
        }
        let place = Enu::new(10.3 * second as f64, 1000.1, 80.7);
        let plot = Plot::new(track, now, place, place.0.norm());
        for report in [
            Report::Plot(Plot { uav_probability: Some(0.9), ..plot }),
            Report::Fix(Fix::new(receiver, identity, now, place)),
        ] {
            kept(&report);
            engine.handle(report).unwrap();
        }
    }
    assert!(points > 50 && fused > 50, "{points} points, {fused} with a radar track");
}
