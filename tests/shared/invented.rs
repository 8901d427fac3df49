//! Reports of transponders that do not exist.

use asterix::cat129::Record;
use asterix::{TimeOfDay, blocks, encode_block};
use fusion::time::{SECOND, Time};
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Config, SensorKind};

/// Prefix of their serial numbers, which simulated drones do not use.
pub const PREFIX: &[u8] = b"FLOOD";

/// A CAT129 report copied from `like`, at `time`, with a serial number derived from `number`.
pub fn invented(like: &[u8], number: u64, time: Time) -> Vec<u8> {
    let block = blocks(like).next().expect("a block").expect("it is whole");
    let mut record = block.records::<Record>().next().expect("a record").expect("it is whole").record;
    let mut serial = [b'0'; 12];
    serial[..PREFIX.len()].copy_from_slice(PREFIX);
    serial[PREFIX.len()..].copy_from_slice(format!("{number:07}").as_bytes());
    record.serial_number = Some(serial);
    record.time_of_day = TimeOfDay::from_seconds(time.since_midnight() as f64 / SECOND as f64);
    let mut octets = Vec::new();
    encode_block(&[record], &mut octets).expect("what was read can be written");
    octets
}

/// Whether a datagram is an invented report.
pub fn is_invented(payload: &[u8]) -> bool {
    payload.first() == Some(&129) && payload.windows(PREFIX.len()).any(|octets| octets == PREFIX)
}

/// A datagram as the pipeline receives it from a capture.
pub fn received(received: Time, payload: Vec<u8>) -> Reception {
    Reception {
        received: Some(received),
        input: 0,
        from: None,
        kind: ReceptionKind::Datagram,
        origin: 0,
        payload,
    }
}

/// Sets the rate of new identities that every transponder receiver admits, per second.
pub fn admit(config: &mut Config, max_new_per_s: u32) {
    for sensor in &mut config.sensors {
        if let SensorKind::Transponder(transponder) = &mut sensor.kind {
            transponder.max_new_per_s = max_new_per_s;
        }
    }
}
