//! Status of the service (CAT065), so that silence means a failure and not an empty picture.

use asterix::cat065::{self, MessageKind, MessageType, OperationalStatus, SystemStatus};
use asterix::{DataSource, TimeOfDay, encode_block};

use fusion::time::Time;
use input::normalise::time_of_day_count;

/// A block with one system status; `degraded` means that the service has a problem.
pub fn status_block(source: DataSource, time: Time, degraded: bool) -> Vec<u8> {
    let status = if degraded { OperationalStatus::Degraded } else { OperationalStatus::Operational };
    let kind = MessageType::default().with_kind(MessageKind::SystemStatus);
    let time_of_day = TimeOfDay::from_count(time_of_day_count(time));
    let record = cat065::Record::builder(source, kind, time_of_day)
        .system_status(SystemStatus::default().with_operational_status(status))
        .build();
    let mut block = Vec::new();
    if let Ok(record) = record {
        // A single record fits every block.
        let _ = encode_block(&[record], &mut block);
    }
    block
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn status_matches_the_specification() {
        let noon = Time::from_nanos(43_200_000_000_000);
        // FSPEC 1101 0100: 010, 000, 030, 040; then NOGO in the two highest bits.
        let block = |degraded| status_block(DataSource { sac: 25, sic: 1 }, noon, degraded);
        assert_eq!(block(false), [65, 0, 11, 0xd4, 25, 1, 1, 0x54, 0x60, 0, 0]);
        assert_eq!(block(true).last(), Some(&0x40));
    }
}
