//! A host that forges a radar's plots, and copies its datagrams to appear as a redundant line.

use std::net::SocketAddr;

use asterix::{TimeOfDay, blocks, cat048, encode_block};
use fusion::SensorIndex;
use fusion::time::Time;
use jiff::SignedDuration;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Config, Input};
use utm_fusion::pipeline::{ContestReason, Event};

use crate::common::{Flown, demo, fly};

const RADAR: &str = "10.0.0.1:4000";
const FORGER: &str = "10.0.0.66:4000";

/// Datagrams that the forger copies.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Copies {
    /// One datagram every 5 s is copied.
    Some,
    /// Every datagram is copied.
    All,
    /// No datagram is copied; only plots are forged.
    None,
}

fn from(text: &str) -> Option<SocketAddr> {
    Some(text.parse().unwrap())
}

fn later(reception: &Reception, milliseconds: i64) -> Time {
    reception.received.unwrap() + SignedDuration::from_millis(milliseconds)
}

/// Moves the plots of a datagram to the other side of the radar, at the current time; `None` if it has none.
fn forged(payload: &[u8], now: Time) -> Option<Vec<u8>> {
    let block = blocks(payload).next()?.ok().filter(|block| block.category == 48)?;
    let mut records: Vec<cat048::Record> = block.records().map(|record| record.unwrap().record).collect();
    let count = now.since_midnight() as i128 * 128 / 1_000_000_000;
    for record in &mut records {
        record.time_of_day = TimeOfDay::from_count(count as u32);
        let polar = record.polar_position?;
        record.polar_position = polar.with_azimuth_deg((polar.azimuth_deg() + 180.0) % 360.0);
    }
    let mut octets = Vec::new();
    encode_block(&records, &mut octets).ok()?;
    Some(octets)
}

/// The flight from the radar's own address; the same with the forger; and the number of forged records.
fn attacked(copies: Copies) -> (Vec<Reception>, Vec<Reception>, u64) {
    let clean: Vec<Reception> = demo()
        .receptions()
        .into_iter()
        .map(|reception| Reception { from: from(RADAR), ..reception })
        .collect();
    let (mut all, mut count) = (clean.clone(), 0);
    let (mut copied, mut forging) = (Time::default(), Time::default());
    let begins = later(&clean[0], 5_000);
    for reception in clean.iter().filter(|reception| reception.payload[0] == 48) {
        let at = reception.received.unwrap();
        if at < begins {
            continue;
        }
        let is_due = match copies {
            Copies::Some => at - copied > SignedDuration::from_secs(5),
            Copies::All => true,
            Copies::None => false,
        };
        if is_due {
            copied = at;
            let received = Some(later(reception, 20));
            all.push(Reception { received, from: from(FORGER), ..reception.clone() });
        }
        if at - forging > SignedDuration::from_millis(200) {
            forging = at;
            let received = later(reception, 40);
            if let Some(payload) = forged(&reception.payload, received) {
                count += blocks(&payload).next().unwrap().unwrap().records::<cat048::Record>().count() as u64;
                all.push(Reception {
                    received: Some(received),
                    from: from(FORGER),
                    kind: ReceptionKind::Datagram,
                    payload,
                    ..reception.clone()
                });
            }
        }
    }
    all.sort_by_key(|reception| reception.received);
    assert!(count > 20, "{count} forged records");
    (clean, all, count)
}

/// Flies both. Checks that the picture is the same, that forged records are refused for this reason, and that the
/// forger is named.
fn is_refused(config: &Config, copies: Copies, reason: ContestReason) {
    let (clean, all, count) = attacked(copies);
    let radar = config.sensors.iter().position(|sensor| sensor.kind.is_radar()).unwrap();
    let radar = SensorIndex(radar as u16);
    let (expected, found) = (fly(config, &clean), fly(config, &all));
    assert!(!expected.emissions.is_empty());
    assert_eq!(format!("{:?}", found.emissions), format!("{:?}", expected.emissions), "{copies:?}");
    let accepted = |flown: &Flown| flown.tally.accepted.get(&radar).copied();
    assert_eq!(accepted(&found), accepted(&expected), "{copies:?}");
    // Records with another fault (coasted, wrong time) are refused for that fault.
    let refused = found.tally.refused.get(&(Some(radar), reason.name())).copied().unwrap_or(0);
    assert!(2 * refused > count, "{copies:?}: {refused} of {count}");
    let contests: Vec<_> = found
        .events
        .iter()
        .flatten()
        .filter_map(|event| match event {
            Event::Contested(contest) => Some(*contest),
            _ => None,
        })
        .collect();
    assert!(!contests.is_empty(), "{copies:?}: the forger is not named");
    for contest in contests {
        assert_eq!((Some(contest.refused), contest.sensor, contest.reason), (from(FORGER), radar, reason));
    }
}

#[test]
fn forger_that_repeats_datagrams_is_refused_and_named() {
    for copies in [Copies::None, Copies::Some, Copies::All] {
        is_refused(&demo().config(), copies, ContestReason::OtherSender);
    }
}

#[test]
fn source_of_one_input_refuses_a_forger_on_every_line() {
    let mut config = demo().config();
    let sensor = config.sensors.iter_mut().find(|sensor| sensor.kind.is_radar()).unwrap();
    let site = include_str!("../../config/demo.toml");
    let demo = Config::parse(site, "site.toml", std::iter::empty()).unwrap();
    let line = Input { source: Some([10, 0, 0, 1].into()), ..demo.sensors[0].inputs[0] };
    assert!(sensor.inputs.iter().all(|input| input.source.is_none()));
    sensor.inputs.push(line);
    for copies in [Copies::None, Copies::Some] {
        is_refused(&config, copies, ContestReason::ForeignSource);
    }
}
