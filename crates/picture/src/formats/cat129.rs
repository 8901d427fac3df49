//! Encoding of a track as a CAT129 record (`docs/CAT129.md`).

use asterix::cat129::fusion_report::{Deviation, Flags, Source as ReportSource, UavProbability};
use asterix::cat129::{
    Altitude, FusionReport, GnssAccuracy, HorizontalVelocity, Position, Record, VerticalVelocity, WholeSerial,
};
use asterix::{DataSource, Explicit, TimeOfDay, encode_block};

use crate::PictureTrack;
use fusion::Source;
use fusion::integrity::State;
use input::normalise::time_of_day_count;
use site::config::{Config, SerialSource};

/// Encoder of tracks: one record per block, as edition 1.2 of the category requires.
#[derive(Clone, Copy, Debug)]
pub struct Cat129Encoder {
    /// SAC/SIC of the service (I129/010).
    pub source: DataSource,
    /// Content of I129/040.
    pub serial: SerialSource,
}

impl Cat129Encoder {
    /// Creates the encoder of a configuration.
    pub fn of(config: &Config) -> Self {
        let source = DataSource { sac: config.site.sac, sic: config.site.sic };
        Self { source, serial: config.output.serial }
    }

    /// Appends the block of a track. Returns `false` without appending if CAT129 cannot represent the position (height beyond
    /// ±838 km).
    pub fn encode(&self, track: &PictureTrack, out: &mut Vec<u8>) -> bool {
        let Some(record) = self.record(track) else { return false };
        encode_block(&[record], out).is_ok()
    }

    fn record(&self, track: &PictureTrack) -> Option<Record> {
        let point = &track.point;
        let position = &track.position;
        let transponder = point.source.transponder();
        let number = decimal(point.number);
        let items = transponder.map(|part| &part.items);
        let altitude = track.altitude_amsl_m.map(|metres| Altitude::from_metres(metres).ok_or(()));
        let motion = track.motion.as_ref();
        Some(Record {
            data_source: Some(self.source),
            manufacturer: items.map_or(Some(*b"RDR"), |items| items.manufacturer),
            model: items.map_or(Some(*b"UNK"), |items| items.model),
            serial_number: Some(match (items, self.serial) {
                (Some(items), SerialSource::Uas) => items.serial_number,
                _ => number,
            }),
            registration_country: Some(items.and_then(|items| items.registration_country).unwrap_or(*b"ZZ")),
            time_of_day: TimeOfDay::from_count(time_of_day_count(track.time)),
            position: Some(Position::new(position.latitude_deg(), position.longitude_deg())?),
            altitude_amsl: altitude.transpose().ok()?,
            // Rounded up to whole metres, so that the accuracy is not overstated.
            gnss_accuracy: motion.and_then(|motion| GnssAccuracy::from_metres(motion.half_h_m.ceil())),
            horizontal_velocity: motion
                .and_then(|motion| HorizontalVelocity::new(motion.velocity.x, motion.velocity.y)),
            vertical_velocity: track
                .vertical_motion()
                .and_then(|motion| VerticalVelocity::new(motion.climb())),
            special_purpose: Some(special_purpose(track)),
            ..Record::default()
        })
    }
}

/// Special purpose field for values without an item, including a serial number too long for I129/040.
pub(super) fn special_purpose(track: &PictureTrack) -> Explicit {
    let transponder = track.point.source.transponder();
    let serial = transponder.and_then(|part| part.identity.serial()).filter(|serial| serial.len() > 12);
    match serial.and_then(WholeSerial::new) {
        Some(serial) => report(track).to_field_with(&serial),
        None => report(track).to_field(),
    }
}

fn report(track: &PictureTrack) -> FusionReport {
    let point = &track.point;
    let (radar, transponder) = (point.source.radar(), point.source.transponder());
    let state = point.integrity.map(|integrity| integrity.state);
    let flag = |set, flag| if set { flag } else { Flags::default() };
    let deviation = |metres: Option<f64>| metres.map_or(Deviation::UNKNOWN, Deviation::from_metres);
    FusionReport {
        source: match point.source {
            Source::Fused(..) => ReportSource::Fused,
            Source::Radar(_) => ReportSource::Radar,
            Source::Transponder(_) => ReportSource::Transponder,
            Source::Cameras => ReportSource::Camera,
        },
        track_number: point.number,
        radar_track: radar.map(|part| part.track.number),
        transponder: transponder.map(|part| part.number),
        horizontal_deviation: deviation(track.motion.map(|motion| motion.deviation_h_m)),
        vertical_deviation: deviation(track.vertical_motion().map(|motion| motion.deviation_v_m)),
        flags: flag(track.is_interpolated(), Flags::INTERPOLATED)
            .with(flag(track.is_extrapolated(), Flags::EXTRAPOLATED))
            .with(flag(track.radar_height_missing(), Flags::HEIGHT_NOT_MEASURED))
            .with(flag(state.is_some_and(State::is_flagged), Flags::INTEGRITY_SUSPECT))
            .with(flag(state == Some(State::Failed), Flags::INTEGRITY_FAILED))
            .with(flag(track.is_uncooperative, Flags::UNCOOPERATIVE)),
        uav_probability: radar
            .and_then(|part| part.uav_probability)
            .map_or(UavProbability::UNKNOWN, UavProbability::from_probability),
    }
}

/// Decimal number, right-justified with zeros to 12 characters.
fn decimal(mut number: u32) -> [u8; 12] {
    let mut digits = [b'0'; 12];
    for digit in digits.iter_mut().rev() {
        *digit += (number % 10) as u8;
        number /= 10;
    }
    digits
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_are_right_justified_with_zeros() {
        assert_eq!(&super::decimal(0), b"000000000000");
        assert_eq!(&super::decimal(4_294_964_095), b"004294964095");
    }
}
