//! ADS-B reports (CAT021) to fixes.

use asterix::cat021::{
    Emitter, EmitterCategory, GeometricHeight, QualityIndicators, Record, TargetReport, VerticalRate,
};
use nalgebra::Vector2;

use super::barometer::Barometer;
use super::normaliser::Normaliser;
use super::refusal::Refusal;
use fusion::report::{Aircraft, AircraftKind, Host, UasItems};
use fusion::time::Time;
use fusion::{Fix, Identity, SensorIndex};

/// Metres in a flight level: a hundred feet.
const FLIGHT_LEVEL_M: f64 = 30.48;
/// Radius that contains 95 % of the horizontal errors (estimated position uncertainty), in metres, by navigation accuracy
/// category from 1 on (DO-260B, table N-7).
const NACP_M: [f64; 11] = [18_520.0, 7_408.0, 3_704.0, 1_852.0, 926.0, 555.6, 185.2, 92.6, 30.0, 10.0, 3.0];
/// Radius for an unknown accuracy, in metres: that of category 5, the poorest with its own meaning for approaches.
const UNKNOWN_M: f64 = 926.0;
/// Ratio of the radii that contain 50 % and 95 % of normal errors: sqrt(ln 2 / ln 20).
pub(super) const HALF_OF_95: f64 = 0.481_022;
/// Standard deviation of the geometric altitude, in metres, by GVA from 1 on: the 95 % bound divided by 1.96.
const GVA_SIGMA_M: [f64; 2] = [150.0 / 1.96, 45.0 / 1.96];
/// Greatest exact height; counts above mean "greater" (I021/140).
const HEIGHT_MOST_M: f64 = 62_420.0;

/// Fix from a record of this receiver.
pub(super) fn fix(
    site: &Normaliser,
    sensor: SensorIndex,
    record: &Record,
    received: Time,
    barometer: &mut Barometer,
) -> Result<Fix, Refusal> {
    let time_of_day = record.position_time.or(record.position_reception).or(record.transmission_time);
    let time_of_day = time_of_day.ok_or(Refusal::NoTime)?;
    if let Some(refusal) = record.target_report.as_ref().and_then(doubted) {
        return Err(refusal);
    }
    let [latitude_deg, longitude_deg] = match (record.fine_position, record.position) {
        (Some(fine), _) => [fine.latitude_deg(), fine.longitude_deg()],
        (None, Some(coarse)) => [coarse.latitude_deg(), coarse.longitude_deg()],
        (None, None) => return Err(Refusal::NoPosition),
    };
    let address = record.target_address.ok_or(Refusal::NoIdentity)?.address();
    let identity = Identity::of_address(address);
    let time = site.time(time_of_day, received)?;
    let geometric_m =
        record.geometric_height.map(GeometricHeight::height_m).filter(|&height_m| height_m < HEIGHT_MOST_M);
    let pressure_m = record.flight_level.map(|level| level.flight_level() * FLIGHT_LEVEL_M);
    if let Some((height_m, altitude_m)) = geometric_m.zip(pressure_m) {
        barometer.learn(altitude_m, height_m, time);
    }
    let stated = record.quality.as_ref().and_then(geometric_sigma_m);
    let height = match (geometric_m, pressure_m) {
        (Some(height_m), _) => Some((height_m, stated)),
        (None, Some(altitude_m)) => site
            .height_by_pressure(altitude_m, time, barometer)
            .map(|(height_m, sigma_m)| (height_m, Some(sigma_m))),
        (None, None) => None,
    };
    let place = site.place([latitude_deg, longitude_deg], height.map(|height| height.0))?;
    let rate = record.geometric_rate.or(record.barometric_rate).filter(|rate| !rate.is_exceeded());
    let over_ground = record.ground_vector.filter(|vector| !vector.is_exceeded()).map(|vector| {
        let (sin, cos) = vector.track_deg().to_radians().sin_cos();
        Vector2::new(sin, cos) * vector.speed_m_s()
    });
    let (velocity, climb_m_s) = place.motion(over_ground, rate.map(VerticalRate::up_m_s));
    Ok(Fix {
        sensor,
        host: Host::default(),
        identity,
        items: UasItems::default(),
        aircraft: aircraft(record),
        time,
        position: place.position,
        height_measured: place.height_measured,
        accuracy_m: record.quality.as_ref().and_then(accuracy_m),
        height_sigma_m: height.and_then(|height| height.1),
        velocity,
        climb_m_s,
    })
}

/// Reason for rejecting a report by its target report descriptor.
fn doubted(report: &TargetReport) -> Option<Refusal> {
    let is_doubted = report.is_nogo()
        || report.is_compact_position_invalid()
        || report.has_position_jump()
        || report.is_out_of_range()
        || report.is_position_check_failed();
    if report.is_simulated() {
        Some(Refusal::Simulated)
    } else if report.is_test() || report.is_field_monitor() {
        Some(Refusal::TestTarget)
    } else {
        is_doubted.then_some(Refusal::NotBelieved)
    }
}

/// Radius that contains half of the horizontal errors, in metres; `None`: not stated.
fn accuracy_m(quality: &QualityIndicators) -> Option<f64> {
    // The first octet alone does not include the accuracy.
    let category = (quality.chain().octets().len() > 1).then(|| quality.accuracy_category())?;
    let radius_m =
        usize::from(category).checked_sub(1).map_or(Some(UNKNOWN_M), |at| NACP_M.get(at).copied())?;
    Some(radius_m * HALF_OF_95)
}

/// Standard deviation of the geometric height, in metres.
fn geometric_sigma_m(quality: &QualityIndicators) -> Option<f64> {
    GVA_SIGMA_M.get(usize::from(quality.geometric_category()).checked_sub(1)?).copied()
}

/// Data about the aircraft.
fn aircraft(record: &Record) -> Aircraft {
    use asterix::cat021::AddressType;

    let category = record.emitter.map(Emitter::category);
    let is_vehicle = record
        .target_report
        .as_ref()
        .is_some_and(|report| report.address_type() == AddressType::SurfaceVehicle);
    let kind = match category {
        Some(EmitterCategory::Unmanned) => AircraftKind::Unmanned,
        Some(
            EmitterCategory::EmergencyVehicle
            | EmitterCategory::ServiceVehicle
            | EmitterCategory::Obstruction
            | EmitterCategory::ObstacleCluster
            | EmitterCategory::ObstacleLine,
        ) => AircraftKind::Vehicle,
        _ if is_vehicle => AircraftKind::Vehicle,
        // An aircraft of unknown kind may have people on board.
        _ => AircraftKind::Crewed,
    };
    let mut callsign = [0; 8];
    if let Some(identification) = record.target_identification {
        let characters = identification.characters();
        let length = characters.iter().rposition(|&octet| octet != b' ').map_or(0, |last| last + 1);
        // Aircraft without a configured callsign send no valid characters.
        if characters[..length].iter().any(|&octet| octet != b'?') {
            callsign[..length].copy_from_slice(&characters[..length]);
        }
    }
    let emitter_category = record.emitter.map(|emitter| emitter.octets()[0]).filter(|&number| number > 0);
    Aircraft { kind, callsign, emitter_category, ..Aircraft::default() }
}

#[cfg(test)]
mod tests;
