//! Attacks put into a real flight: its transponder's reports changed as the simulator does.

use asterix::cat129::{self, Position};
use asterix::{Record as _, TimeOfDay, blocks, encode_block};
use fusion::time::Time;
use jiff::SignedDuration;
use utm_fusion::capture::Reception;
use utm_fusion::evaluate::AttackKind;
use utm_fusion::normalise::nearest_day;

/// How far a position drifts, jumps, and a second transmitter is, metres; all to the north.
const AWAY_M: f64 = 100.0;
const SECOND_AWAY_M: f64 = 500.0;
/// How long it drifts, seconds.
const DRIFT_S: f64 = 60.0;
/// The time before it that is sent again and again, seconds.
const REPLAY_S: f64 = 60.0;
/// A second transmitter reports so long after the first, seconds: half of the period of these flights.
const BETWEEN_S: f64 = 1.0;
/// Metres of a degree of latitude.
const METRES_A_DEGREE: f64 = 111_200.0;

/// A report of the transponder that is to lie, as it was received. The recordings have one report a datagram.
struct Heard {
    record: cat129::Record,
    received: Time,
    reception: Reception,
}

/// What is received under an attack.
pub struct Lied {
    pub receptions: Vec<Reception>,
    /// Stamps of the reports that are not the drone's own.
    pub foreign: Vec<Time>,
}

/// The receptions, those of the transponder with this serial number changed from then on. In order of reception.
pub fn lied(receptions: Vec<Reception>, serial: &[u8], kind: AttackKind, from: Time) -> Lied {
    let mut lied = Lied { receptions: Vec::new(), foreign: Vec::new() };
    let mut before: Vec<Heard> = Vec::new();
    let mut rounds = 0;
    for reception in receptions {
        let Some(heard) = heard(&reception, serial) else {
            lied.receptions.push(reception);
            continue;
        };
        if heard.received < from {
            lied.receptions.push(reception);
            before.push(heard);
            continue;
        }
        let elapsed_s = heard.received.seconds_since(from);
        match kind {
            AttackKind::Drift => lied.receptions.extend(heard.moved(AWAY_M * (elapsed_s / DRIFT_S).min(1.0))),
            AttackKind::Jump => lied.receptions.extend(heard.moved(AWAY_M)),
            AttackKind::Frozen => {
                let last = before.last().map_or(&heard.record, |last| &last.record);
                let (position, altitude_amsl) = (last.position, last.altitude_amsl);
                lied.receptions.extend(heard.with(|record| {
                    (record.position, record.altitude_amsl) = (position, altitude_amsl);
                }));
            }
            AttackKind::Duplicate => {
                let second = heard.later(BETWEEN_S);
                lied.receptions.push(reception);
                lied.foreign.extend(second.stamped());
                lied.receptions.extend(second.moved(SECOND_AWAY_M));
            }
            // What was its own is not received; in its place a round of earlier reports, when the last one is over.
            AttackKind::Replay => {
                while f64::from(rounds) * REPLAY_S <= elapsed_s {
                    rounds += 1;
                    let earlier =
                        before.iter().filter(|heard| from.seconds_since(heard.received) <= REPLAY_S);
                    for again in earlier.map(|heard| heard.later(f64::from(rounds) * REPLAY_S)) {
                        lied.foreign.extend(again.stamped());
                        lied.receptions.extend(again.moved(0.0));
                    }
                }
            }
            AttackKind::Swapped | AttackKind::Time | AttackKind::Jammed => lied.receptions.push(reception),
        }
    }
    lied.receptions.sort_by_key(|reception| reception.received); // stable
    lied
}

/// The report of that transponder in a datagram.
fn heard(reception: &Reception, serial: &[u8]) -> Option<Heard> {
    let is_report = |block: &asterix::Block<'_>| block.category == cat129::Record::CATEGORY;
    let block = blocks(&reception.payload).find_map(|block| block.ok().filter(is_report))?;
    let record = block.records::<cat129::Record>().find_map(Result::ok)?.record;
    let own = record.serial_number?;
    let is_its = own.trim_ascii_end() == serial;
    is_its.then_some(Heard { record, received: reception.received?, reception: reception.clone() })
}

impl Heard {
    /// Received, and made, so much later.
    fn later(&self, seconds: f64) -> Self {
        let mut record = self.record.clone();
        let counts = (seconds * f64::from(TimeOfDay::PER_SECOND)).round() as u32;
        let later = |time: TimeOfDay| TimeOfDay::from_count((time.count() + counts) % TimeOfDay::PER_DAY);
        record.time_of_day = record.time_of_day.and_then(later);
        let received = self.received + SignedDuration::from_nanos((seconds * 1e9) as i64);
        Self { record, received, reception: self.reception.clone() }
    }

    /// Its time stamp.
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

    /// A report every 2 s, 10 m further east each; heard half a second later.
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

    /// When each is received, how far north, metres, and its longitude in steps of the honest one; from 120 s on.
    fn sent(kind: AttackKind) -> (Vec<(f64, f64, f64)>, Vec<f64>) {
        let lied = lied(honest(), b"ALPHA", kind, at(120.0));
        let seconds = |time: Time| time.seconds_since(at(0.0));
        let report = |reception: &Reception| {
            let heard = heard(reception, b"ALPHA").unwrap();
            let position = heard.record.position.unwrap();
            let north_m = (position.latitude_deg() - 52.0) * METRES_A_DEGREE;
            (seconds(heard.received), north_m.round(), (position.longitude_deg() * 1e4).round())
        };
        let sent: Vec<_> = lied.receptions.iter().map(report).collect();
        assert!(sent.is_sorted_by(|a, b| a.0 <= b.0));
        assert_eq!(
            sent.iter().take(60).map(|sent| sent.2).collect::<Vec<_>>(),
            (0..60).map(f64::from).collect::<Vec<_>>()
        );
        (sent[60..].to_vec(), lied.foreign.into_iter().map(seconds).collect())
    }

    #[test]
    fn each_attack_is_what_it_is_called() {
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
        // What was received from 60.5 to 118.5 s, 60 s later and again.
        assert_eq!(
            [replay[0], replay[29], replay[30]],
            [(120.5, 0.0, 30.0), (178.5, 0.0, 59.0), (180.5, 0.0, 30.0)]
        );
        assert_eq!((replay.len(), foreign[0]), (60, 120.0));
    }
}
