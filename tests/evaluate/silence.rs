//! Metrics that do not reward missing points, computed by hand.
//!
//! ALPHA, with transponder 7, hovers at latitude 0, longitude 0; BRAVO, without a transponder, hovers 80 m east of it.
//! Both are at sea level from 0 to 40 s. Slots 40 to 129 count: 90 slots or 0.375 min per drone.

use std::collections::BTreeSet;

use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use utm_fusion::evaluate::{
    Covariance, Evaluation, GeodeticPlace, InputsAlone, Label, Labels, Nees, OutputPoint, PointFlags,
    PointSource, Scoring, Truth, evaluate,
};

use super::common::{east, north};

const MINUTES: f64 = 0.375;

fn centre(slot: i64) -> Time {
    SlotGrid::default().centre(Slot(slot))
}

fn place(east_m: f64, north_m: f64, altitude_amsl_m: Option<f64>) -> GeodeticPlace {
    GeodeticPlace { latitude_deg: north(north_m), longitude_deg: east(east_m), altitude_amsl_m }
}

/// A point of transponder 7, this far east of ALPHA.
fn own(slot: i64, east_m: f64) -> OutputPoint {
    OutputPoint {
        time: centre(slot),
        place: place(east_m, 0.0, Some(0.0)),
        source: PointSource::Transponder,
        number: 7,
        radar_track: None,
        sensor: None,
        transponder: Some(7),
        identity: None,
        covariance: None,
        flags: PointFlags::default(),
    }
}

/// A point of a radar track alone, this far east of ALPHA, without height.
fn radars(slot: i64, track: u16, east_m: f64) -> OutputPoint {
    OutputPoint {
        place: place(east_m, 0.0, None),
        source: PointSource::Radar,
        number: track.into(),
        radar_track: Some(track),
        transponder: None,
        ..own(slot, 0.0)
    }
}

fn hovering() -> Truth {
    let samples = |east_m: f64| {
        (0..=8).map(move |step| (Time::from_nanos(step * 5_000_000_000), place(east_m, 0.0, Some(0.0))))
    };
    Truth::new(
        [("ALPHA", 0.0), ("BRAVO", 80.0)].map(|(id, east_m)| (id.to_owned(), samples(east_m).collect())),
    )
}

/// Track 11 is ALPHA, 12 is BRAVO and 13 is a bird in every slot; track 14 has no labels.
fn labels() -> Labels {
    let row = |slot, sensor: &str, number, id: Option<&str>| Label {
        time: centre(slot),
        sensor: sensor.to_owned(),
        number,
        id: id.map(str::to_owned),
        seduced: false,
        identity: None,
    };
    let of_slot = |slot| {
        [
            row(slot, "squitter", 7, Some("ALPHA")),
            row(slot, "radar", 11, Some("ALPHA")),
            row(slot, "radar", 12, Some("BRAVO")),
            row(slot, "radar", 13, None),
        ]
    };
    Labels::with_receivers((40..130).flat_map(of_slot).collect(), &BTreeSet::from(["squitter".to_owned()]))
}

fn scored(output: &[OutputPoint], alone: Option<&InputsAlone>) -> Evaluation {
    evaluate(&hovering(), Some(&labels()), output, alone, &Scoring::default())
}

fn near(told: Option<f64>, expected: f64) {
    assert!((told.unwrap() - expected).abs() < 1e-9, "{told:?} is not {expected}");
}

#[test]
fn a_gap_slot_needs_a_point_near_the_drone() {
    // The transponder interpolates in slots 40 to 49: 80 of ALPHA's 90 slots are gaps.
    let alone =
        InputsAlone { transponder: (40..50).map(|slot| own(slot, 0.0)).collect(), ..InputsAlone::default() };
    let high = |east_m, up_m| OutputPoint { place: place(east_m, 0.0, Some(up_m)), ..radars(63, 11, 0.0) };
    let output = [
        radars(45, 11, 0.0),                       // not a gap
        radars(60, 11, 49.9),                      // near
        radars(61, 11, 50.1),                      // counts for PU, but is too far away
        radars(62, 11, 51.0),                      // too far away as well, but
        radars(62, 14, 3.0),                       // another point is near
        high(30.0, 41.0),                          // 50.8 m in 3-D
        radars(64, 11, -30.0),                     // without a height: over ground
        OutputPoint { number: 8, ..own(64, 0.0) }, // in a slot that counts already
        radars(65, 12, 80.0),                      // BRAVO's, which has no gaps
    ];
    let told = scored(&output, Some(&alone));
    near(told.fused.all.gap_within_50_m_percent, 100.0 * 3.0 / 80.0);
    near(told.fused.all.pu_gap_percent, 100.0 * 5.0 / 80.0);
    near(told.fused.equipped.gap_within_50_m_percent, 100.0 * 3.0 / 80.0);
    assert_eq!(told.fused.unequipped.gap_within_50_m_percent, None);
    assert_eq!(scored(&output, None).fused.all.gap_within_50_m_percent, None, "gaps need the inputs alone");
}

#[test]
fn two_numbers_at_once_are_one_too_many() {
    let output = [
        own(40, 0.0),
        radars(40, 11, 5.0), // two
        own(41, 0.0),
        OutputPoint { number: 7, ..radars(41, 11, 5.0) }, // two points of one number
        own(42, 0.0),
        radars(43, 11, 5.0), // one after the other
        own(44, 0.0),
        radars(44, 12, 80.0), // of two drones
        radars(45, 12, 80.0),
        radars(45, 14, 81.0), // unlabelled, and BRAVO is nearest: two
    ];
    let alone = InputsAlone { radar: output.to_vec(), ..InputsAlone::default() };
    let told = scored(&output, Some(&alone));
    near(told.fused.drones[0].two_numbers_percent, 100.0 / 90.0);
    near(told.fused.drones[1].two_numbers_percent, 100.0 / 90.0);
    near(told.fused.all.two_numbers_percent, 100.0 * 2.0 / 180.0);
    assert_eq!(told.radar.unwrap().all.two_numbers_percent, None, "numbers of plots are the radars'");
}

#[test]
fn ghost_is_a_second_track_beside_a_drone() {
    let fused =
        OutputPoint { source: PointSource::Fused, number: 70011, radar_track: Some(11), ..own(43, 0.0) };
    let output = [
        own(40, 0.0),
        radars(40, 11, -59.9), // a ghost
        own(41, 0.0),
        radars(41, 11, -60.1), // too far
        radars(42, 11, 0.0),   // the only point of ALPHA
        fused,
        radars(43, 13, -50.0), // a bird beside it: a ghost
        own(44, 0.0),
        radars(44, 12, 30.0), // BRAVO's, nearer to ALPHA
        own(45, 0.0),
        radars(45, 13, 1.0),
        radars(45, 13, 2.0), // the same track: once
        own(46, 0.0),
        radars(46, 13, -61.0), // a bird too far away
        own(47, 0.0),
        radars(47, 14, 10.0), // unlabelled: ALPHA's, as the nearest, and a ghost
        radars(48, 13, 60.0), // beside BRAVO, which has no point of its own
    ];
    let alone = InputsAlone { radar: output.to_vec(), ..InputsAlone::default() };
    let told = scored(&output, Some(&alone));
    let four_slots = 4.0 * 0.25 / MINUTES;
    near(told.fused.all.ghosts_s, four_slots);
    near(told.fused.equipped.ghosts_s, four_slots);
    near(told.fused.drones[0].ghosts_s, four_slots);
    near(told.fused.unequipped.ghosts_s, 0.0);
    assert_eq!(told.radar.unwrap().all.ghosts_s, None, "an input alone has none");
    // Without labels, the point of slot 44 is not known to be BRAVO's.
    let unlabelled = evaluate(&hovering(), None, &output, None, &Scoring::default());
    near(unlabelled.fused.all.ghosts_s, four_slots + 0.25 / MINUTES);
}

/// ALPHA flies east at 10 m/s, and turns by 10 degrees per second from 20 s on.
fn turning() -> Truth {
    let (speed_m_s, rate) = (10.0, 10_f64.to_radians());
    let at = |step: i64| {
        let second = step as f64 * 0.1;
        let (straight_s, angle) = (second.min(20.0), rate * (second - 20.0).max(0.0));
        let radius_m = speed_m_s / rate;
        let (east_m, north_m) =
            (speed_m_s * straight_s + radius_m * angle.sin(), radius_m * (1.0 - angle.cos()));
        (Time::from_nanos(step * 100_000_000), place(east_m, north_m, Some(0.0)))
    };
    Truth::new([("ALPHA".to_owned(), (0..=400).map(at).collect())])
}

#[test]
fn nees_is_split_by_drone_and_track_state() {
    let truth = turning();
    let off = |slot: i64, north_m: f64| {
        let mut at = truth.tracks()[0].at(centre(slot)).unwrap();
        at.latitude_deg += north(north_m);
        let covariance = Covariance { east_m2: 1.0, north_m2: 1.0, east_north_m2: 0.0, vertical_m2: 1.0 };
        OutputPoint { place: at, covariance: Some(covariance), ..radars(slot, 11, 0.0) }
    };
    let seduced = |slot, seduced| Label {
        time: centre(slot),
        sensor: "radar".to_owned(),
        number: 11,
        id: Some("ALPHA".to_owned()),
        seduced,
        identity: None,
    };
    // The track is seduced at 27.6 s, in slot 110, and has no further plots.
    let rows = (40..110).map(|slot| seduced(slot, false)).chain([seduced(110, true)]);
    let labels = Labels::with_receivers(rows.collect(), &BTreeSet::new());
    let output = [
        off(60, 2.0),                                        // straight on: 4 / 2
        off(70, 4.0),                                        // still: 16 / 2
        off(100, 6.0),                                       // turning: 36 / 2
        off(110, 10.0),                                      // seduced: 100 / 2
        off(120, 12.0),                                      // 2.5 s after its last plot: 144 / 2
        off(123, 2.0),                                       // 3.25 s after: turning
        OutputPoint { covariance: None, ..off(101, 999.0) }, // without a covariance
    ];
    let told = evaluate(&truth, Some(&labels), &output, None, &Scoring::default());
    let holds = |nees: Option<Nees>, count: u64, mean: f64| {
        let nees = nees.unwrap();
        assert_eq!(nees.count, count);
        assert!((nees.horizontal - mean).abs() < 1e-3, "{nees:?} is not {mean}");
    };
    let all = &told.fused.all;
    holds(all.nees, 6, (2.0 + 8.0 + 18.0 + 50.0 + 72.0 + 2.0) / 6.0);
    holds(all.nees_straight, 2, 5.0);
    holds(all.nees_turning, 2, 10.0);
    holds(all.nees_walked_off, 2, 61.0);
}
