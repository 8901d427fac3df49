//! ADSB_VEHICLE as CAT021: an aircraft received by an ADS-B receiver on board or on the ground.

use asterix::cat021::{
    AircraftAddress, AircraftIdentification, BarometricLevel, Emitter, EmitterCategory, GeometricHeight,
    GroundVector, Position, Record, TargetReport, VerticalRate,
};
use asterix::{BuildError, DataSource, encode_block};
use egm96::egm96_compute_altitude_offset;
use fusion::time::{SECOND, Time};

use super::{MavlinkDropReason, MavlinkPayload};
use crate::gateways::time_of_day;

/// Number and checksum seed of the message.
pub(super) const ADSB_VEHICLE: (u32, u8) = (246, 184);

/// `ADSB_FLAGS`: valid fields, and whether the aircraft is simulated.
const COORDINATES: u16 = 1;
const ALTITUDE: u16 = 2;
const COURSE: u16 = 4;
const SPEED: u16 = 8;
const CALLSIGN: u16 = 16;
const SIMULATED: u16 = 64;
const CLIMB: u16 = 128;
/// `ADSB_ALTITUDE_TYPE`: barometric.
const BAROMETRIC: u8 = 0;
/// Metres in a hundred feet.
const FLIGHT_LEVEL_M: f64 = 30.48;

/// Record of a message, from the sensor `source`.
pub(super) fn record(
    source: DataSource,
    contents: &MavlinkPayload,
    received: Time,
) -> Result<Vec<u8>, MavlinkDropReason> {
    let flags = contents.u16(22);
    let is_valid = |flag| flags & flag != 0;
    let [latitude, longitude] = [4, 8].map(|at| contents.i32(at));
    if !is_valid(COORDINATES) || latitude == 0 && longitude == 0 {
        return Err(MavlinkDropReason::NoPosition);
    }
    let place = [latitude, longitude].map(|count| f64::from(count) * 1e-7);
    let position = Position::new(place[0], place[1]).ok_or(MavlinkDropReason::OutOfRange)?;
    let address = u32::from_le_bytes(contents.at(0));
    let address = AircraftAddress::new(address).ok_or(MavlinkDropReason::OutOfRange)?;
    // Seconds since the last reception of the aircraft.
    let age_ns = i64::from(contents.at::<1>(37)[0]) * SECOND;
    let time = time_of_day(Time::from_nanos(received.nanos().saturating_sub(age_ns)));
    let descriptor = TargetReport::default();
    let descriptor = if is_valid(SIMULATED) { descriptor.with_simulated(true) } else { descriptor };
    let is_barometric = contents.at::<1>(26)[0] == BAROMETRIC;
    let build = || -> Result<Vec<u8>, BuildError> {
        let mut builder = Record::builder(source, descriptor, address)
            .fine_position(Some(position))
            .position_reception(time);
        if is_valid(ALTITUDE) {
            let metres = f64::from(contents.i32(12)) / 1000.0;
            builder = if is_barometric {
                builder.flight_level(BarometricLevel::default().with_flight_level(metres / FLIGHT_LEVEL_M))
            } else {
                // The message states the height above mean sea level.
                let undulation_m = egm96_compute_altitude_offset(place[0], place[1]);
                let height = GeometricHeight::default().with_height_m(metres + undulation_m);
                builder.geometric_height(height)
            };
        }
        if is_valid(COURSE) && is_valid(SPEED) {
            let [course, speed] = [16, 18].map(|at| f64::from(contents.u16(at)) / 100.0);
            builder = builder.ground_vector(GroundVector::new(speed, course));
        }
        if is_valid(CLIMB) {
            let rate = VerticalRate::default().with_up_m_s(f64::from(contents.i16(20)) / 100.0);
            builder =
                if is_barometric { builder.barometric_rate(rate) } else { builder.geometric_rate(rate) };
        }
        if is_valid(CALLSIGN) {
            builder = builder.target_identification(callsign(contents.at(27)));
        }
        if let Some(category) = category(contents.at::<1>(36)[0]) {
            builder = builder.emitter(Some(Emitter::default().with_category(category)));
        }
        let mut datagram = Vec::new();
        // A record is always shorter than the maximum of a block.
        let _ = encode_block(&[builder.build()?], &mut datagram);
        Ok(datagram)
    };
    build().map_err(|_| MavlinkDropReason::OutOfRange)
}

/// Eight characters and a NUL.
fn callsign(characters: [u8; 9]) -> Option<AircraftIdentification> {
    let end = characters.iter().position(|octet| *octet == 0).unwrap_or(characters.len());
    let text = str::from_utf8(&characters[..end]).ok()?.trim();
    if text.is_empty() { None } else { AircraftIdentification::new(text) }
}

/// `ADSB_EMITTER_TYPE`; `None` for codes without information.
fn category(code: u8) -> Option<EmitterCategory> {
    Some(match code {
        1 => EmitterCategory::Light,
        2 => EmitterCategory::Small,
        3 => EmitterCategory::Medium,
        4 => EmitterCategory::HighVortex,
        5 => EmitterCategory::Heavy,
        6 => EmitterCategory::HighPerformance,
        7 => EmitterCategory::Rotorcraft,
        9 => EmitterCategory::Glider,
        10 => EmitterCategory::LighterThanAir,
        11 => EmitterCategory::Parachutist,
        12 => EmitterCategory::Ultralight,
        14 => EmitterCategory::Unmanned,
        15 => EmitterCategory::Space,
        17 => EmitterCategory::EmergencyVehicle,
        18 => EmitterCategory::ServiceVehicle,
        19 => EmitterCategory::Obstruction,
        _ => return None,
    })
}
