//! Times at which zones apply.

use serde_json::{Value, json};

use super::super::schedule::Schedule;
use super::*;

fn schedule(applicability: &Value, time_zone: Option<&str>) -> Schedule {
    let text = json!({ "type": "Feature",
        "properties": { "type": "PROHIBITED", "limitedApplicability": applicability },
        "geometry": { "type": "Polygon", "coordinates": [[[10, 50], [11, 50], [11, 51], [10, 50]]] } })
    .to_string();
    let area = alert(|settings| settings.time_zone = time_zone.map(str::to_owned));
    let zones = contents(&text, &area).unwrap_or_else(|problem| panic!("{problem}")).zones;
    zones[0].schedule.clone()
}

/// The next `count` changes after `from`, and whether the schedule is active before the first of them.
fn course(schedule: &Schedule, from: &str, count: usize) -> (bool, Vec<String>) {
    let (mut now, mut changes) = (at(from), Vec::new());
    let is_active = schedule.is_active(now);
    while let Some(next) = schedule.changes_after(now).filter(|_| changes.len() < count) {
        let before = Time::from_nanos(next.nanos() - 1);
        assert_ne!(schedule.is_active(next), schedule.is_active(before));
        assert_eq!(schedule.is_active(now), schedule.is_active(before));
        changes.push(next.to_string()[..16].to_owned());
        now = next;
    }
    (is_active, changes)
}

#[test]
fn schedule_without_limits_is_always_active() {
    for applicability in [
        json!([]),
        json!([{ "startDateTime": "", "endDateTime": "", "schedule": [{ "day": "ANY", "startTime": "", "endTime": "" }] }]),
        json!([{ "startDateTime": "2026-01-01T00:00:00Z" }, { "endDateTime": null, "schedule": [] }]),
    ] {
        let schedule = schedule(&applicability, None);
        assert_eq!(
            (course(&schedule, "2020-01-01T00:00:00Z", 9), schedule.to_string()),
            match applicability[0]["startDateTime"].as_str() {
                Some("2026-01-01T00:00:00Z") =>
                    ((false, vec!["2026-01-01T00:00".to_owned()]), "from 2026-01-01 00:00 UTC".to_owned()),
                _ => ((true, vec![]), "always".to_owned()),
            }
        );
    }
}

#[test]
fn dates_and_hours() {
    // 2026-11-23 is a Monday.
    let weekend = json!([{ "startDateTime": "2026-11-20T00:00:00Z", "endDateTime": "2026-12-01T00:00:00Z",
        "schedule": [{ "day": ["SAT", "SUN"], "startTime": "17:00:00.00Z", "endTime": "23:00:00Z" }] }]);
    let weekend = schedule(&weekend, None);
    let times = [
        "2026-11-21T17:00",
        "2026-11-21T23:00",
        "2026-11-22T17:00",
        "2026-11-22T23:00",
        "2026-11-28T17:00",
        "2026-11-28T23:00",
        "2026-11-29T17:00",
        "2026-11-29T23:00",
    ];
    assert_eq!(course(&weekend, "2020-01-01T00:00:00Z", 99), (false, times.map(str::to_owned).to_vec()));
    assert_eq!(
        weekend.to_string(),
        "Sat Sun 17:00-23:00 UTC from 2026-11-20 00:00 UTC to 2026-12-01 00:00 UTC"
    );
    // The period begins and ends within its hours.
    let cut = schedule(
        &json!([{ "startDateTime": "2026-11-21T18:00:00Z", "endDateTime": "2026-11-22T18:00:00Z",
        "schedule": [{ "startTime": "17:00Z", "endTime": "19:00Z" }] }]),
        None,
    );
    let times = ["2026-11-21T18:00", "2026-11-21T19:00", "2026-11-22T17:00", "2026-11-22T18:00"];
    assert_eq!(course(&cut, "2026-11-21T17:30:00Z", 99), (false, times.map(str::to_owned).to_vec()));
}

/// Friday's hours continue into Saturday; a day begins and ends at midnight.
#[test]
fn hours_may_cross_midnight() {
    let night = schedule(
        &json!([{ "schedule": [{ "day": ["FRI"], "startTime": "22:00:00Z", "endTime": "06:00:00Z" }] }]),
        None,
    );
    let times = ["2026-11-27T22:00", "2026-11-28T06:00", "2026-12-04T22:00"];
    assert_eq!(course(&night, "2026-11-23T00:00:00Z", 3), (false, times.map(str::to_owned).to_vec()));
    for end in ["24:00:00Z", "00:00:00Z"] {
        let whole = schedule(
            &json!([{ "schedule": [{ "day": ["FRI", "SAT"], "startTime": "00:00:00Z", "endTime": end }] }]),
            None,
        );
        let times = ["2026-11-27T00:00", "2026-11-29T00:00"];
        assert_eq!(course(&whole, "2026-11-23T00:00:00Z", 2), (false, times.map(str::to_owned).to_vec()));
    }
    let daily = schedule(
        &json!([{ "schedule": [{ "day": ["ANY"], "startTime": "00:00:00Z", "endTime": "24:00:00Z" }] }]),
        None,
    );
    assert_eq!(course(&daily, "2026-11-23T05:00:00Z", 2), (true, vec![]), "every day is always");
}

/// Hours in a time zone follow its summer time and its days.
#[test]
fn time_zones() {
    let zurich = |applicability: Value| schedule(&applicability, Some("Europe/Zurich"));
    let hours =
        zurich(json!([{ "schedule": [{ "day": ["SUN"], "startTime": "00:30:00", "endTime": "12:00:00" }] }]));
    // Summer time ends on 2026-10-25 at 01:00 UTC.
    let times = [
        "2026-10-17T22:30",
        "2026-10-18T10:00",
        "2026-10-24T22:30",
        "2026-10-25T11:00",
        "2026-10-31T23:30",
        "2026-11-01T11:00",
    ];
    assert_eq!(course(&hours, "2026-10-15T00:00:00Z", 6), (false, times.map(str::to_owned).to_vec()));
    assert_eq!(hours.to_string(), "Sun 00:30-12:00 Europe/Zurich");
    let fixed = schedule(
        &json!([{ "schedule": [{ "day": ["SUN"], "startTime": "00:30:00+02:00", "endTime": "12:00:00+02:00" }] }]),
        None,
    );
    let times = ["2026-10-17T22:30", "2026-10-18T10:00", "2026-10-24T22:30", "2026-10-25T10:00"];
    assert_eq!(course(&fixed, "2026-10-15T00:00:00Z", 4), (false, times.map(str::to_owned).to_vec()));
    assert_eq!(fixed.to_string(), "Sun 00:30-12:00 +02");
    // A time with an offset keeps it.
    let both =
        zurich(json!([{ "startDateTime": "2026-07-01T12:00:00", "endDateTime": "2026-07-02T12:00:00Z" }]));
    assert_eq!(course(&both, "2026-01-01T00:00:00Z", 9).1, ["2026-07-01T10:00", "2026-07-02T12:00"]);
    let days = zurich(json!([{ "schedule": [{ "day": ["SUN"] }] }]));
    assert_eq!(course(&days, "2026-07-01T00:00:00Z", 2).1, ["2026-07-04T22:00", "2026-07-05T22:00"]);
}

#[test]
fn adjacent_periods_merge_without_a_change() {
    let both = schedule(
        &json!([
            { "endDateTime": "2026-06-01T00:00:00Z" },
            { "startDateTime": "2026-06-01T00:00:00Z", "endDateTime": "2026-07-01T00:00:00Z" },
            { "startDateTime": "2030-01-01T00:00:00Z", "schedule": [{ "startTime": "10:00Z", "endTime": "11:00Z" }] },
        ]),
        None,
    );
    let times = ["2026-07-01T00:00", "2030-01-01T10:00", "2030-01-01T11:00"];
    assert_eq!(course(&both, "2026-01-01T00:00:00Z", 3), (true, times.map(str::to_owned).to_vec()));
}

/// An entry counts only if the zone applies at the time of entry.
#[test]
fn zone_that_opens_before_the_entry_is_entered() {
    let text = json!({ "type": "Feature",
        "properties": { "type": "PROHIBITED", "limitedApplicability": [{ "startDateTime": "2026-11-23T12:00:30Z" }] },
        "geometry": { "type": "Polygon", "coordinates": [[[10, 50], [11, 50], [11, 51], [10, 51], [10, 50]]] } })
    .to_string();
    let alerts = areas(&text, &alert(|_| {})).alerts();
    let here = visitor(9.99, 50.5, None);
    // The edge is 709 m away.
    for (speed, found) in [(20.0, true), (30.0, false)] {
        let path = Path::new(&here.place, [speed, 0.0, 0.0], None);
        assert_eq!(alerts.ahead(here, &path, 0.0, 0.0, 0.0).len() == 1, found, "{speed} m/s");
    }
    assert_eq!(alerts.around(visitor(10.5, 50.5, None), 0.0).len(), 0, "not yet");
}
