//! Reports of transponders that do not exist.

use asterix::cat129::Record;
use asterix::{TimeOfDay, blocks, encode_block};
use fusion::time::{SECOND, Time};
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Config, SensorKind};

/// Their serials begin so; those of simulated drones do not.
pub const PREFIX: &[u8] = b"FLOOD";

/// The report `like` another one of CAT129, at `time`, of a transponder with a serial of this number.
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

/// Whether a datagram is such a report.
pub fn is_invented(payload: &[u8]) -> bool {
    payload.first() == Some(&129) && payload.windows(PREFIX.len()).any(|octets| octets == PREFIX)
}

/// A datagram as a capture hands it to the pipeline.
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

/// Every transponder receiver admits this many new identities per second, in the long run.
pub fn admit(config: &mut Config, max_new_per_s: u32) {
    for sensor in &mut config.sensors {
        if let SensorKind::Transponder(transponder) = &mut sensor.kind {
            transponder.max_new_per_s = max_new_per_s;
        }
    }
}
