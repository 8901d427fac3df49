//! Encoding of a track as a CAT062 record (`docs/CAT062.md`).

use std::collections::BTreeSet;

use asterix::cat062::{
    Age, AircraftAddress, AircraftDerivedData, AircraftIdentification, ClimbAccuracy, ClimbRate, Covariance,
    EmitterCategory, EstimatedAccuracies, GeometricHeight, HeightAccuracy, HeightSource,
    IdentificationSource, Position, PositionAccuracy, Record, ServiceIdentification, TargetIdentification,
    TrackNumber, TrackStatus, UpdateAges, Velocity, VelocityAccuracy,
};
use asterix::{DataSource, TimeOfDay};

use super::cat129::special_purpose;
use super::datagrams::pack_records;
use super::track_numbers::{NumberedTrack, ShortTrackNumbers};
use crate::{PictureTrack, TrackClass};
use fusion::Source;
use fusion::point::{Estimate, TransponderPart};
use fusion::report::Space;
use fusion::time::Time;
use input::normalise::time_of_day_count;
use site::config::{Config, PictureKind};

/// Time without an update after which I062/080 reports the sensor as missing, in seconds.
const LACKING_S: f64 = 5.0;

/// EMC of I062/380 for an unmanned aircraft.
const UNMANNED: u8 = 13;

/// LSB of horizontal position deviations in I062/500, in metres.
const PLACE_LSB_M: f64 = 0.5;
/// LSB of horizontal velocity deviations in I062/500, in metres per second.
const SPEED_LSB_M_S: f64 = 0.25;
/// LSB of height deviations in I062/500, in metres: 6.25 ft.
const HEIGHT_LSB_M: f64 = 6.25 * 0.3048;
/// LSB of vertical speed deviations in I062/500, in metres per second: 6.25 ft a minute.
const CLIMB_LSB_M_S: f64 = 6.25 * 0.3048 / 60.0;

/// Encoder for the pictures of one kind, in order. It assigns track numbers, and marks the first and last message of a track.
#[derive(Clone, Debug)]
pub struct Cat062Encoder {
    source: DataSource,
    service: Option<ServiceIdentification>,
    numbers: ShortTrackNumbers,
    /// Serial numbers of transponders on crewed aircraft.
    crewed: BTreeSet<String>,
}

impl Cat062Encoder {
    /// Track numbers in use.
    pub(super) const fn numbers(&self) -> &ShortTrackNumbers {
        &self.numbers
    }

    /// Continues with the track numbers of an earlier encoder.
    pub(super) fn resume(&mut self, numbers: ShortTrackNumbers) {
        self.numbers = numbers;
    }

    /// Creates an encoder for pictures of this kind.
    pub fn new(config: &Config, picture: PictureKind) -> Self {
        Self {
            source: DataSource { sac: config.site.sac, sic: config.site.sic },
            service: service(picture),
            numbers: ShortTrackNumbers::default(),
            crewed: config.conflicts.crewed.iter().cloned().collect(),
        }
    }

    /// Datagrams of the next picture, of time `time`, each a block of at most [`DATAGRAM_MAX`](super::DATAGRAM_MAX) octets: its
    /// tracks in order, then the last messages of tracks that have been missing for 10 s.
    pub fn encode<'a>(
        &mut self,
        time: Time,
        tracks: impl IntoIterator<Item = &'a PictureTrack>,
    ) -> Vec<Vec<u8>> {
        let mut records = Vec::new();
        for track in tracks {
            if let Some(numbered) = self.numbers.number(track) {
                records.extend(self.record(track, numbered));
            }
        }
        let ended = self.numbers.end(time);
        records.extend(ended.into_iter().map(|number| self.last(number, time)));
        pack_records(records)
    }

    /// Record of a track; `None` for a position that is not on Earth.
    fn record(&self, track: &PictureTrack, numbered: NumberedTrack) -> Option<Record> {
        let position = Position::new(track.position.latitude_deg(), track.position.longitude_deg())?;
        let height = track.altitude_amsl_m.and(Some(track.position.height_m));
        let height = height.and_then(|height_m| GeometricHeight::default().with_height_m(height_m));
        let motion = track.motion.as_ref();
        let transponder = track.point.source.transponder();
        let identification = transponder.and_then(identification);
        Some(Self::without_empty_items(Record {
            position: Some(position),
            velocity: motion.and_then(|motion| Velocity::new(motion.velocity.x, motion.velocity.y)),
            target_identification: identification
                .map(|name| TargetIdentification::new(IdentificationSource::Downlinked, name)),
            aircraft_derived: transponder.map(|transponder| AircraftDerivedData {
                address: address(transponder),
                identification,
                emitter: self.emitter(track),
                ..AircraftDerivedData::default()
            }),
            track_status: Some(status(track, numbered.is_first, height.is_some())),
            update_ages: Some(ages(track)),
            geometric_altitude: height,
            climb_rate: track
                .vertical_motion()
                .and_then(|motion| ClimbRate::default().with_up_m_s(motion.climb())),
            accuracies: track.point.estimate.as_ref().map(|known| accuracies(known, height.is_some())),
            special_purpose: Some(special_purpose(track)),
            ..self.blank(numbered.number, track.time)
        }))
    }

    /// Last message of a track, with the mandatory items only.
    fn last(&self, number: u16, time: Time) -> Record {
        let status = TrackStatus::default().with_last(true);
        Record { track_status: Some(status), ..self.blank(number, time) }
    }

    /// Items common to all records.
    fn blank(&self, number: u16, time: Time) -> Record {
        Record {
            data_source: Some(self.source),
            service_identification: self.service,
            time_of_day: TimeOfDay::from_count(time_of_day_count(time)),
            track_number: Some(TrackNumber::new(number)),
            ..Record::default()
        }
    }

    /// Leaves out compound items without any value.
    fn without_empty_items(record: Record) -> Record {
        let Record { aircraft_derived, update_ages, .. } = record;
        Record {
            aircraft_derived: aircraft_derived.filter(|data| *data != AircraftDerivedData::default()),
            update_ages: update_ages.filter(|ages| *ages != UpdateAges::default()),
            ..record
        }
    }

    /// EMC of I062/380: the transponder's category (I021/020), else unmanned aircraft for a drone.
    fn emitter(&self, track: &PictureTrack) -> Option<EmitterCategory> {
        let said =
            track.point.source.transponder().and_then(|transponder| transponder.aircraft.emitter_category);
        let is_drone = TrackClass::of(&track.point.source, &self.crewed) == TrackClass::Drone;
        let code = match said {
            Some(0) | None if is_drone => UNMANNED,
            Some(0) | None => return None,
            // The vortex classes small, medium and large of I021/020 are one weight class here.
            Some(2..=4) => 3,
            Some(code) => code,
        };
        EmitterCategory::default().with_code(code)
    }
}

/// I062/015 and I063/015: the two pictures are two services.
pub(super) fn service(picture: PictureKind) -> Option<ServiceIdentification> {
    ServiceIdentification::default().with_number(match picture {
        PictureKind::Lagged => 1,
        PictureKind::Now => 2,
    })
}

/// Callsign, or else the last eight characters of the serial number; `None` if a character is not allowed in I062/245.
fn identification(transponder: &TransponderPart) -> Option<AircraftIdentification> {
    let callsign = str::from_utf8(&transponder.aircraft.callsign).ok()?.trim_end_matches('\0');
    if !callsign.is_empty() {
        return AircraftIdentification::new(callsign);
    }
    let serial = transponder.identity.serial()?;
    let last = &serial[serial.len().saturating_sub(8)..];
    AircraftIdentification::new(str::from_utf8(last).ok()?)
}

/// ADR of I062/380, for an aircraft with an ICAO address.
fn address(transponder: &TransponderPart) -> Option<AircraftAddress> {
    let identity = transponder.identity;
    let digits = str::from_utf8(identity.name()).ok().filter(|_| identity.space() == Space::Address)?;
    AircraftAddress::new(u32::from_str_radix(digits, 16).ok()?)
}

/// I062/080.
fn status(track: &PictureTrack, is_first: bool, has_height: bool) -> TrackStatus {
    let source = &track.point.source;
    let height_source = match source {
        _ if !has_height => HeightSource::None,
        Source::Radar(_) => HeightSource::Radar3D,
        Source::Fused(..) | Source::Transponder(_) => HeightSource::Gnss,
        Source::Cameras => HeightSource::Triangulation,
    };
    let is_flagged = track.point.integrity.is_some_and(|known| known.state.is_flagged());
    let lacks = |seen: Option<Time>| seen.is_none_or(|seen| track.time.seconds_since(seen) > LACKING_S);
    TrackStatus::default()
        .with_monosensor(!matches!(source, Source::Fused(..) | Source::Cameras))
        .with_geometric_reliable(has_height)
        .with_height_source(height_source)
        .with_first(is_first)
        .with_adsb_inconsistent(is_flagged)
        .with_coasted(track.is_coasting())
        .with_primary_lacking(lacks(source.radar().map(|radar| radar.time)))
        .with_secondary_lacking(true)
        .with_mode_s_lacking(true)
        .with_adsb_lacking(lacks(heard(track)))
        .with_surveillance(match source {
            Source::Fused(..) => 0,
            Source::Transponder(_) => 1,
            Source::Radar(_) | Source::Cameras => 2,
        })
        .unwrap_or_default()
}

/// Time of the transponder's last report. The `reference` profile keeps nothing older than its window, and does not state the
/// time.
fn heard(track: &PictureTrack) -> Option<Time> {
    let transponder = track.point.source.transponder()?;
    transponder.time.or(track.point.estimate.is_none().then_some(track.time))
}

/// I062/290.
fn ages(track: &PictureTrack) -> UpdateAges {
    // A measurement in the second half of its slot has age 0.
    let age = |time: Time| Age::from_seconds(track.time.seconds_since(time).max(0.0));
    let source = &track.point.source;
    UpdateAges {
        track: track.motion.and_then(|motion| motion.last_measurement).and_then(age),
        psr: source.radar().and_then(|radar| age(radar.time)),
        squitter: source.transponder().and_then(|transponder| transponder.time).and_then(age),
        ..UpdateAges::default()
    }
}

/// I062/500. Deviations are rounded up, so that no accuracy is overstated. Values out of range are left out.
fn accuracies(known: &Estimate, has_height: bool) -> EstimatedAccuracies {
    let up = |variance: f64, lsb: f64| (variance.max(0.0).sqrt() / lsb).ceil() * lsb;
    let (place, speed) = (known.horizontal, known.velocity_covariance);
    let height = has_height.then_some(known.vertical_m2);
    let climb = has_height.then_some(known.climb_m2s2);
    EstimatedAccuracies {
        position: PositionAccuracy::default()
            .with_east_m(up(place.m11, PLACE_LSB_M))
            .and_then(|item| item.with_north_m(up(place.m22, PLACE_LSB_M))),
        covariance: covariance(place.m12),
        geometric: height.and_then(|m2| HeightAccuracy::default().with_metres(up(m2, HEIGHT_LSB_M))),
        velocity: VelocityAccuracy::default()
            .with_east_m_s(up(speed.m11, SPEED_LSB_M_S))
            .and_then(|item| item.with_north_m_s(up(speed.m22, SPEED_LSB_M_S))),
        climb: climb.and_then(|m2s2| ClimbAccuracy::default().with_up_m_s(up(m2s2, CLIMB_LSB_M_S))),
        ..EstimatedAccuracies::default()
    }
}

/// COV of I062/500, rounded towards zero. With deviations rounded up it remains a valid covariance.
fn covariance(m2: f64) -> Option<Covariance> {
    let root = (m2.abs().sqrt() / PLACE_LSB_M).floor() * PLACE_LSB_M;
    Covariance::default().with_metres(root.copysign(m2))
}

#[cfg(test)]
mod tests;
