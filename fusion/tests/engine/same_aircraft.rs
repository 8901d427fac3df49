//! Two transponder identities of one aircraft: their link is part of the state, and independent of the order of
//! reports.

use utm_fusion_engine::settings::OperationalRules;
use utm_fusion_engine::time::{SECOND, Time};
use utm_fusion_engine::{Enu, Fix, Identity, Plot, Profile, RadarTrackKey, Report, SensorIndex, Settings};

use crate::checkpoint::reloaded;
use crate::scenario::{self, Arrival, Scenario, run};

fn settings() -> Settings {
    let scenario = Scenario { arrivals: Vec::new(), max_gap_s: 25, suppress_slots: 16 };
    let profile = Profile::Operational(OperationalRules::default());
    Settings { profile, ..scenario::settings(&scenario) }
}

/// A drone at 12 m/s with two transponders, detected by a radar. The identities separate after 140 s.
fn arrivals() -> Vec<Arrival> {
    let mut arrivals = Vec::new();
    let mut receive = |time: Time, report| {
        arrivals.push(Arrival { received: Time::from_nanos(time.nanos() + SECOND / 5), report });
    };
    for half in 0..340_i64 {
        let time = Time::from_nanos(1_700_000_000 * SECOND + half * SECOND / 2);
        let seconds = half as f64 / 2.0;
        let away_m = 8.0 * (seconds - 140.0).max(0.0);
        let place = |north_m: f64| -> Enu { Enu::new(12.0 * seconds - 500.0, 600.0 + north_m, 80.0) };
        let track = RadarTrackKey { sensor: SensorIndex(0), number: 7 };
        let plot = Plot::new(track, time, place(2.0), place(2.0).0.norm());
        receive(time, Report::Plot(Plot { uav_probability: Some(0.9), ..plot }));
        let is_first = half % 2 == 0;
        let name = if is_first { b"U1" } else { b"U2" };
        let north_m = if is_first { 0.0 } else { 1.0 + away_m };
        let fix = Fix::new(SensorIndex(2), Identity::new(name, None).unwrap(), time, place(north_m));
        receive(time, Report::Fix(fix));
    }
    arrivals
}

#[test]
fn link_and_its_end_outlive_a_checkpoint() {
    let (settings, arrivals) = (settings(), arrivals());
    let kept = run(&settings, &arrivals);
    let linked = kept.iter().filter(|emission| emission.points.iter().any(|point| !point.also.is_empty()));
    assert!(linked.count() > 60, "the flight has to reach a link");
    assert_eq!(kept[kept.len() - 20].points.len(), 2, "and its end");
    assert_eq!(reloaded(&settings, &arrivals, 7), kept);
}

#[test]
fn link_does_not_depend_on_the_order_of_reports() {
    let (settings, arrivals) = (settings(), scenario::indifferent_to_order(arrivals()));
    let kept = run(&settings, &arrivals);
    for seed in 0..3 {
        assert_eq!(run(&settings, &scenario::permuted(&arrivals, settings.lead(), seed)), kept);
    }
}
