//! State of the sensors (CAT063), for receivers of CAT062 tracks.

use asterix::cat063::{Record, SensorStatus, ServiceIdentification};
use asterix::{DataSource, TimeOfDay};

use super::datagrams::pack_records;
use fusion::time::Time;
use input::normalise::time_of_day_count;

/// A record for each sensor, in as few datagrams as possible.
pub(super) fn sensor_datagrams(
    source: DataSource,
    service: Option<ServiceIdentification>,
    time: Time,
    sensors: impl IntoIterator<Item = (DataSource, SensorStatus)>,
) -> Vec<Vec<u8>> {
    let time_of_day = TimeOfDay::from_count(time_of_day_count(time));
    pack_records(sensors.into_iter().map(|(sensor, status)| Record {
        data_source: Some(source),
        service_identification: service,
        time_of_day,
        sensor: Some(sensor),
        status: Some(status),
        ..Record::default()
    }))
}

#[cfg(test)]
mod tests {
    use asterix::cat063::Connection;

    use super::*;

    const OWN: DataSource = DataSource { sac: 25, sic: 1 };

    #[test]
    fn sensor_with_invalid_time_sets_the_bit() {
        let noon = Time::from_nanos(43_200_000_000_000);
        let service = ServiceIdentification::default().with_number(1);
        let status = SensorStatus::default().with_connection(Connection::Degraded).with_time_invalid(true);
        let sensor = DataSource { sac: 25, sic: 201 };
        // FSPEC 1111 1000: 010, 015, 030, 050, 060; CON 01 and FX, then TSV.
        let expected = vec![63, 0, 14, 0xf8, 25, 1, 1, 0x54, 0x60, 0, 25, 201, 0x41, 0x08];
        assert_eq!(sensor_datagrams(OWN, service, noon, [(sensor, status)]), [expected]);
        assert!(sensor_datagrams(OWN, service, noon, []).is_empty());
    }
}
