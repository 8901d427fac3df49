//! Adds attacks to a real flight: changes the reports of its transponder as the simulator does.

use asterix::cat129::{self, Position};
use asterix::{Record as _, TimeOfDay, blocks, encode_block};
use fusion::time::Time;
use jiff::SignedDuration;
use utm_fusion::capture::Reception;
use utm_fusion::evaluate::AttackKind;
use utm_fusion::normalise::nearest_day;

/// Distance of a drift or jump, metres, to the north. `SECOND_AWAY_M` is the distance of a second transmitter.
const AWAY_M: f64 = 100.0;
const SECOND_AWAY_M: f64 = 500.0;
/// Duration of a drift, seconds.
const DRIFT_S: f64 = 60.0;
/// Length of the earlier recording that a replay repeats, seconds.
const REPLAY_S: f64 = 60.0;
/// Delay of a second transmitter's reports after the first one's, seconds: half of the period in these flights.
const BETWEEN_S: f64 = 1.0;
/// Metres per degree of latitude.
const METRES_A_DEGREE: f64 = 111_200.0;

/// A received report of the attacked transponder. The recordings have one report per datagram.
struct ReceivedReport {
    record: cat129::Record,
    received: Time,
    reception: Reception,
}

/// Receptions under an attack.
pub struct AttackedReceptions {
    pub receptions: Vec<Reception>,
    /// Time stamps of the reports that the drone did not send.
    pub foreign: Vec<Time>,
}

/// Changes the receptions of the transponder with this serial number from `from` on. In order of reception.
pub fn attacked(
    receptions: Vec<Reception>,
    serial: &[u8],
    kind: AttackKind,
    from: Time,
) -> AttackedReceptions {
    let mut attacked = AttackedReceptions { receptions: Vec::new(), foreign: Vec::new() };
    let mut before: Vec<ReceivedReport> = Vec::new();
    let mut rounds = 0;
    for reception in receptions {
        let Some(report) = report(&reception, serial) else {
            attacked.receptions.push(reception);
            continue;
        };
        if report.received < from {
            attacked.receptions.push(reception);
            before.push(report);
            continue;
        }
        let elapsed_s = report.received.seconds_since(from);
        match kind {
            AttackKind::Drift => {
                attacked.receptions.extend(report.moved(AWAY_M * (elapsed_s / DRIFT_S).min(1.0)));
            }
            AttackKind::Jump => attacked.receptions.extend(report.moved(AWAY_M)),
            AttackKind::Frozen => {
                let last = before.last().map_or(&report.record, |last| &last.record);
                let (position, altitude_amsl) = (last.position, last.altitude_amsl);
                attacked.receptions.extend(report.with(|record| {
                    (record.position, record.altitude_amsl) = (position, altitude_amsl);
                }));
            }
            AttackKind::Duplicate => {
                let second = report.later(BETWEEN_S);
                attacked.receptions.push(reception);
                attacked.foreign.extend(second.stamped());
                attacked.receptions.extend(second.moved(SECOND_AWAY_M));
            }
            // The drone's own reports are dropped; a round of earlier reports is inserted when the previous round is
            // over.
            AttackKind::Replay => {
                while f64::from(rounds) * REPLAY_S <= elapsed_s {
                    rounds += 1;
                    let earlier =
                        before.iter().filter(|report| from.seconds_since(report.received) <= REPLAY_S);
                    for again in earlier.map(|report| report.later(f64::from(rounds) * REPLAY_S)) {
                        attacked.foreign.extend(again.stamped());
                        attacked.receptions.extend(again.moved(0.0));
                    }
                }
            }
            AttackKind::Swapped | AttackKind::Time | AttackKind::Jammed => {
                attacked.receptions.push(reception);
            }
        }
    }
    attacked.receptions.sort_by_key(|reception| reception.received); // stable
    attacked
}

/// Report of that transponder in a datagram.
fn report(reception: &Reception, serial: &[u8]) -> Option<ReceivedReport> {
    let is_report = |block: &asterix::Block<'_>| block.category == cat129::Record::CATEGORY;
    let block = blocks(&reception.payload).find_map(|block| block.ok().filter(is_report))?;
    let record = block.records::<cat129::Record>().find_map(Result::ok)?.record;
    let own = record.serial_number?;
    let is_its = own.trim_ascii_end() == serial;
    is_its.then_some(ReceivedReport { record, received: reception.received?, reception: reception.clone() })
}

impl ReceivedReport {
    /// Copy of the report, measured and received later by this time.
    fn later(&self, seconds: f64) -> Self {
        let mut record = self.record.clone();
        let counts = (seconds * f64::from(TimeOfDay::PER_SECOND)).round() as u32;
        let later = |time: TimeOfDay| TimeOfDay::from_count((time.count() + counts) % TimeOfDay::PER_DAY);
        record.time_of_day = record.time_of_day.and_then(later);
        let received = self.received + SignedDuration::from_nanos((seconds * 1e9) as i64);
        Self { record, received, reception: self.reception.clone() }
    }

    /// Time stamp of the report.
    fn stamped(&self) -> Option<Time> {
        nearest_day(self.record.time_of_day?.count(), self.received)
    }

    fn moved(&self, north_m: f64) -> Option<Reception> {
        self.with(|record| {
            if let Some(position) = record.position.filter(|_| north_m != 0.0) {
                let latitude_deg = position.latitude_deg() + north_m / METRES_A_DEGREE;
                record.position = Position::new(latitude_deg, position.longitude_deg());
            }
        })
    }

    fn with(&self, change: impl FnOnce(&mut cat129::Record)) -> Option<Reception> {
        let mut record = self.record.clone();
        change(&mut record);
        let mut payload = Vec::new();
        encode_block(&[record], &mut payload).ok()?;
        Some(Reception { received: Some(self.received), payload, ..self.reception.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asterix::DataSource;
    use asterix::cat129::Altitude;
    use utm_fusion::capture::ReceptionKind;

    const NOON_S: f64 = 43_200.0;

    /// A report every 2 s, each 10 m further east; received half a second later.
    fn honest() -> Vec<Reception> {
        let report = |step: u32| {
            let second = f64::from(step) * 2.0;
            let record = cat129::Record {
                data_source: Some(DataSource { sac: 0, sic: 0 }),
                serial_number: Some(*b"ALPHA       "),
                registration_country: Some(*b"GB"),
                time_of_day: TimeOfDay::from_seconds(NOON_S + second),
                position: Position::new(52.0, 1e-4 * f64::from(step)),
                altitude_amsl: Altitude::from_metres(50.0),
                ..cat129::Record::default()
            };
            let mut payload = Vec::new();
            encode_block(&[record], &mut payload).unwrap();
            Reception {
                received: Some(at(second + 0.5)),
                input: 0,
                from: None,
                kind: ReceptionKind::Datagram,
                origin: 0,
                payload,
            }
        };
        (0..100).map(report).collect()
    }

    fn at(second: f64) -> Time {
        Time::from_nanos(((NOON_S + second) * 1e9) as i64)
    }

    /// Time of reception, distance north in metres, and longitude in steps of the honest reports, for each report from
    /// 120 s on.
    fn sent(kind: AttackKind) -> (Vec<(f64, f64, f64)>, Vec<f64>) {
        let attacked = attacked(honest(), b"ALPHA", kind, at(120.0));
        let seconds = |time: Time| time.seconds_since(at(0.0));
        let report = |reception: &Reception| {
            let report = report(reception, b"ALPHA").unwrap();
            let position = report.record.position.unwrap();
            let north_m = (position.latitude_deg() - 52.0) * METRES_A_DEGREE;
            (seconds(report.received), north_m.round(), (position.longitude_deg() * 1e4).round())
        };
        let sent: Vec<_> = attacked.receptions.iter().map(report).collect();
        assert!(sent.is_sorted_by(|a, b| a.0 <= b.0));
        assert_eq!(
            sent.iter().take(60).map(|sent| sent.2).collect::<Vec<_>>(),
            (0..60).map(f64::from).collect::<Vec<_>>()
        );
        (sent[60..].to_vec(), attacked.foreign.into_iter().map(seconds).collect())
    }

    #[test]
    fn attacked_receptions_match_their_attack_kind() {
        let (drift, _) = sent(AttackKind::Drift);
        assert_eq!(
            [drift[0], drift[15], drift[30]],
            [(120.5, 1.0, 60.0), (150.5, 51.0, 75.0), (180.5, 100.0, 90.0)]
        );
        let (jump, foreign) = sent(AttackKind::Jump);
        assert!(jump.iter().all(|report| report.1 == 100.0) && foreign.is_empty());
        let (frozen, _) = sent(AttackKind::Frozen);
        assert!(frozen.iter().all(|report| (report.1, report.2) == (0.0, 59.0)) && frozen.len() == 40);
        let (duplicate, foreign) = sent(AttackKind::Duplicate);
        assert_eq!(duplicate[..3], [(120.5, 0.0, 60.0), (121.5, 500.0, 60.0), (122.5, 0.0, 61.0)]);
        assert_eq!((foreign.len(), foreign[0]), (40, 121.0), "by its stamp");
        let (replay, foreign) = sent(AttackKind::Replay);
        // Reports received from 60.5 to 118.5 s, repeated 60 s later.
        assert_eq!(
            [replay[0], replay[29], replay[30]],
            [(120.5, 0.0, 30.0), (178.5, 0.0, 59.0), (180.5, 0.0, 30.0)]
        );
        assert_eq!((replay.len(), foreign[0]), (60, 120.0));
    }
}
