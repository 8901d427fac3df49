//! Hand-built flights: detections of each rule, and cases that it must ignore.

mod duplicate;
mod flood;
mod frozen;
mod jump;
mod places;
mod properties;
mod replay;
mod silence;
mod swapped;
mod velocity;

use std::collections::BTreeSet;

use nalgebra::{Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::report::SensorIndex;
use crate::time::SECOND;

/// Delay between time stamp and arrival of a report, seconds.
const LATE_S: f64 = 0.5;
const SLOT_S: f64 = 0.25;

fn at(seconds: f64) -> Time {
    Time::from_nanos((seconds * SECOND as f64).round() as i64)
}

fn identity(number: u32) -> Identity {
    let mut serial_number = [b' '; 12];
    serial_number[..9].copy_from_slice(format!("{number:09}").as_bytes());
    Identity::new(&serial_number, None).unwrap()
}

/// A report of the identity with this number.
fn fix(number: u32, seconds: f64, position: [f64; 3]) -> Fix {
    Fix::new(SensorIndex(1), identity(number), at(seconds), Enu::from(Vector3::from(position)))
}

/// A report, and its time of arrival, seconds.
type Arrival = (f64, Fix);

/// Reports of one identity with this period, between two times, of a receiver with this white noise, metres on each
/// axis.
fn flight(
    number: u32,
    period_s: f64,
    (from_s, until_s): (f64, f64),
    noise_m: f64,
    place: impl Fn(f64) -> [f64; 3],
) -> Vec<Arrival> {
    let mut random = ChaCha8Rng::seed_from_u64(number.into());
    let mut noise = || noise_m * (0..12).map(|_| random.random::<f64>() - 0.5).sum::<f64>();
    let reports = ((until_s - from_s) / period_s).ceil() as u32;
    (0..reports)
        .map(|report| {
            let seconds = from_s + period_s * f64::from(report);
            let [east, north, up] = place(seconds);
            let position = [east + noise(), north + noise(), up + noise()];
            (seconds + LATE_S, fix(number, seconds, position))
        })
        .collect()
}

/// Straight to the east at 12 m/s.
fn eastward(seconds: f64) -> [f64; 3] {
    [12.0 * seconds, 300.0, 80.0]
}

/// Adds a reported velocity to each report.
fn stating(reports: Vec<Arrival>, velocity: impl Fn(f64) -> [f64; 2]) -> Vec<Arrival> {
    let state = |(arrives_s, fix): Arrival| {
        let seconds = fix.time.seconds_since(at(0.0));
        (arrives_s, Fix { velocity: Some(Vector2::from(velocity(seconds))), ..fix })
    };
    reports.into_iter().map(state).collect()
}

/// Runs slot by slot until 3 s after the last arrival.
fn run(reports: &[Arrival], mut each: impl FnMut(f64, &ReportRules)) -> ReportRules {
    let mut reports: Vec<&Arrival> = reports.iter().collect();
    reports.sort_by(|(one_s, one), (next_s, next)| one_s.total_cmp(next_s).then(one.time.cmp(&next.time)));
    let end_s = reports.last().map_or(0.0, |(arrives_s, _)| arrives_s + 3.0);
    let mut rules = ReportRules::default();
    let mut next = reports.into_iter().peekable();
    let mut slot = 0;
    while f64::from(slot) * SLOT_S < end_s {
        slot += 1;
        let deadline_s = f64::from(slot) * SLOT_S;
        let mut came: Vec<Fix> = Vec::new();
        while let Some((_, fix)) = next.next_if(|(arrives_s, _)| *arrives_s <= deadline_s) {
            came.push(*fix);
        }
        came.sort_by_key(|fix| (fix.time, fix.identity));
        rules.add_reports(&came);
        rules.evaluate(at(deadline_s));
        each(deadline_s, &rules);
    }
    rules
}

/// The first time at which a rule fires for an identity, seconds, and whether it was certain then.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fired {
    number: u32,
    reason: Reason,
    failed: bool,
    at_s: f64,
}

fn fired(reports: &[Arrival], numbers: &[u32]) -> Vec<Fired> {
    let mut fired: Vec<Fired> = Vec::new();
    let mut known = BTreeSet::new();
    run(reports, |at_s, rules| {
        for &number in numbers {
            let finding = rules.finding(identity(number));
            assert_eq!(finding.suspect.or(finding.failed), finding.suspect);
            for (set, failed) in [(finding.failed, true), (finding.suspect, false)] {
                for reason in set.iter() {
                    if known.insert((number, reason, failed)) {
                        fired.push(Fired { number, reason, failed, at_s });
                    }
                }
            }
        }
    });
    fired
}

/// The time at which a rule first fires, seconds.
fn first(fired: &[Fired], number: u32, reason: Reason, failed: bool) -> Option<f64> {
    let wanted = |fired: &&Fired| (fired.number, fired.reason, fired.failed) == (number, reason, failed);
    fired.iter().find(wanted).map(|fired| fired.at_s)
}

#[track_caller]
fn assert_silent(reports: &[Arrival], numbers: &[u32]) {
    assert_eq!(fired(reports, numbers), []);
}

#[track_caller]
fn assert_fires(reports: &[Arrival], number: u32, reason: Reason, failed: bool, within_s: (f64, f64)) {
    let fired = fired(reports, &[number]);
    let first_s = first(&fired, number, reason, failed);
    assert!(first_s.is_some_and(|first_s| (within_s.0..=within_s.1).contains(&first_s)), "{fired:?}");
}
