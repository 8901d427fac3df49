//! Decoded reports that the engine refuses: every reason, for radar and transponder.

use asterix::cat048::{DetectionType, PolarPosition, TargetReport};
use asterix::cat129::Position;
use asterix::{Record, TimeOfDay, blocks, cat048, cat129, encode_block};
use utm_fusion::capture::Reception;

use super::common::{demo, fly};

/// First record of a category from the flight's sensors, and its reception.
fn first<R: Record<Edition = ()>>(receptions: &[Reception], is_ours: fn(&R) -> bool) -> (Reception, R) {
    let of = |reception: &Reception| {
        let mut blocks = blocks(&reception.payload).flatten().filter(|block| block.category == R::CATEGORY);
        let record =
            blocks.find_map(|block| block.records::<R>().flatten().map(|one| one.record).find(is_ours))?;
        Some((reception.clone(), record))
    };
    receptions.iter().find_map(of).unwrap()
}

/// Reason for refusing a record at this reception; `None` if it is accepted.
fn fate<R: Record>(reception: &Reception, record: R) -> Option<&'static str> {
    let mut payload = Vec::new();
    encode_block(&[record], &mut payload).unwrap();
    let flown = fly(&demo().config(), &[Reception { payload, ..reception.clone() }]);
    let tally = &flown.tally;
    assert_eq!(tally.accepted.values().sum::<u64>() + tally.refused.values().sum::<u64>(), 1);
    tally.refused.keys().next().map(|(_, reason)| *reason)
}

/// The time of day, this many seconds later.
fn later(time: TimeOfDay, seconds: f64) -> Option<TimeOfDay> {
    TimeOfDay::from_seconds((time.seconds() + seconds).rem_euclid(86_400.0))
}

#[test]
fn invalid_plot_is_refused_with_its_reason() {
    let is_ours = |record: &cat048::Record| record.data_source.is_some_and(|source| source.sac == 70);
    let (reception, plot) = first(&demo().receptions(), is_ours);
    let said =
        |change: fn(TargetReport) -> TargetReport| Some(change(TargetReport::new(DetectionType::Primary)));
    let at = plot.time_of_day.unwrap();
    let cases = [
        (plot.clone(), None),
        (cat048::Record { target_report: None, ..plot.clone() }, None),
        (cat048::Record { time_of_day: None, ..plot.clone() }, Some("no_time")),
        (cat048::Record { polar_position: None, ..plot.clone() }, Some("no_position")),
        (cat048::Record { track_number: None, ..plot.clone() }, Some("no_track_number")),
        (
            cat048::Record {
                target_report: said(|_| TargetReport::new(DetectionType::NoDetection)),
                ..plot.clone()
            },
            Some("no_detection"),
        ),
        (
            cat048::Record { target_report: said(|report| report.with_simulated(true)), ..plot.clone() },
            Some("simulated"),
        ),
        (
            cat048::Record { target_report: said(|report| report.with_test(true)), ..plot.clone() },
            Some("test_target"),
        ),
        (
            cat048::Record { polar_position: Some(PolarPosition::from_octets([0; 4])), ..plot.clone() },
            Some("zero_range"),
        ),
        (
            cat048::Record { time_of_day: Some(TimeOfDay::from_octets([0xff; 3])), ..plot.clone() },
            Some("time_out_of_range"),
        ),
        (cat048::Record { time_of_day: later(at, 5.0), ..plot.clone() }, Some("future")),
        (cat048::Record { time_of_day: later(at, -30.0), ..plot.clone() }, Some("late")),
        (cat048::Record { data_source: None, ..plot.clone() }, Some("no_data_source")),
    ];
    for (record, reason) in cases {
        assert_eq!(fate(&reception, record.clone()), reason, "{record:?}");
    }
}

#[test]
fn invalid_report_is_refused_with_its_reason() {
    let is_ours = |record: &cat129::Record| record.data_source.is_some_and(|source| source.sac == 0);
    let (reception, report) = first(&demo().receptions(), is_ours);
    let at = report.time_of_day.unwrap();
    let off_the_earth = Position::from_octets([0x20, 0, 0, 1, 0, 0, 0, 0]);
    let cases = [
        (report.clone(), None),
        (cat129::Record { registration_country: None, ..report.clone() }, None),
        (cat129::Record { time_of_day: None, ..report.clone() }, Some("no_time")),
        (cat129::Record { position: None, ..report.clone() }, Some("no_position")),
        (cat129::Record { serial_number: None, ..report.clone() }, Some("no_identity")),
        (cat129::Record { serial_number: Some(*b"        \0\0\0\0"), ..report.clone() }, Some("no_identity")),
        (
            cat129::Record { altitude_agl: report.altitude_amsl, altitude_amsl: None, ..report.clone() },
            Some("no_height"),
        ),
        (cat129::Record { position: Some(off_the_earth), ..report.clone() }, Some("position_out_of_range")),
        (cat129::Record { time_of_day: later(at, 120.0), ..report.clone() }, Some("future")),
        (cat129::Record { time_of_day: later(at, -120.0), ..report.clone() }, Some("late")),
    ];
    for (record, reason) in cases {
        assert_eq!(fate(&reception, record.clone()), reason, "{record:?}");
    }
}
