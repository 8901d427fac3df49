//! Fixes from Remote ID positions (ASTM F3411 Location).

use nalgebra::Vector2;

use ::remote_id::{BasicId, HeightAbove, IdType, Location, System};

use super::adsb::HALF_OF_95;
use super::barometer::Barometer;
use super::normaliser::Normaliser;
use super::refusal::Refusal;
use fusion::declaration::{Declaration, DeclaredHeight, OperatorPlace};
use fusion::report::{Aircraft, Host, Space, UasItems};
use fusion::time::{SECOND, Time};
use fusion::{Fix, Identity, SensorIndex};

/// Nanoseconds of an hour.
const HOUR: i64 = 3600 * SECOND;
/// Number of standard deviations in the half width that contains 95 % of the errors.
const HALF_WIDTH: f64 = 1.96;

/// Identity in a Basic ID; `None`: not stated. Some transmitters state no identity type and send their serial number.
pub fn identity(id: &BasicId) -> Option<Identity> {
    match id.id_type() {
        IdType::SerialNumber | IdType::None => Identity::new(id.id(), None),
        IdType::Registration => Identity::of_name(Space::Registration, id.id()),
        IdType::UtmAssigned => Identity::of_name(Space::Flight, id.id()),
        IdType::SpecificSession => Identity::of_name(Space::Session, id.id()),
        IdType::Reserved(_) => None,
    }
}

/// Units per metre of declared heights.
const HALVES: f64 = 2.0;
/// Units per degree.
const DEGREE: f64 = 1e7;

/// Operator's position in a System message; `None`: not stated.
pub fn operator(system: &System) -> Option<OperatorPlace> {
    let content = system.content();
    let place = content.operator_deg?;
    let is_on_earth = place[0].abs() <= 90.0 && place[1].abs() <= 180.0;
    is_on_earth.then(|| OperatorPlace {
        place: place.map(|degrees| (degrees * DEGREE).round() as i32),
        half_metres: content.operator_altitude_m.map(|metres| (metres * HALVES).round() as i32),
        kind: content.location_type,
    })
}

/// Declarations of a Location, and of its transmitter's other messages.
fn declared(location: &Location, known: Declaration) -> Declaration {
    let height = location.height_m().map(|(metres, above)| DeclaredHeight {
        half_metres: (metres * HALVES).round() as i32,
        is_above_ground: above == HeightAbove::Ground,
    });
    Declaration { status: Some(location.status_number()), height, ..known }
}

/// Fix from a drone's Location, received by this receiver; `stamped` is the time of reception that the gateway states.
pub(super) fn fix(
    site: &Normaliser,
    sensor: SensorIndex,
    (identity, location, known): (Identity, &Location, Declaration),
    received: Time,
    stamped: Option<Time>,
    barometer: &mut Barometer,
) -> Result<Fix, Refusal> {
    if location.place_counts() == [0, 0] {
        return Err(Refusal::NoFix);
    }
    let time = match location.seconds_of_hour() {
        Some(seconds) => nearest_hour(seconds, received),
        // A position without a time has that of its reception.
        None => stamped.unwrap_or(received),
    };
    let time = site.not_ahead(time, received)?;
    let geodetic_m = location.geodetic_altitude_m();
    let pressure_m = location.pressure_altitude_m();
    let height = match (geodetic_m, pressure_m) {
        (Some(height_m), _) => Some((height_m, location.accuracy_v_m().map(|half_m| half_m / HALF_WIDTH))),
        (None, Some(altitude_m)) => site
            .height_by_pressure(altitude_m, time, barometer)
            .map(|(height_m, sigma_m)| (height_m, Some(sigma_m))),
        (None, None) => None,
    };
    let place = site.place(location.place_deg(), height.map(|height| height.0))?;
    let over_ground = match (location.speed_m_s(), location.course_deg()) {
        (Some(0.0), _) => Some(Vector2::zeros()),
        (Some(speed_m_s), Some(course_deg)) => {
            let (sin, cos) = course_deg.to_radians().sin_cos();
            Some(Vector2::new(sin, cos) * speed_m_s)
        }
        _ => None,
    };
    let (velocity, climb_m_s) = place.motion(over_ground, location.climb_m_s());
    Ok(Fix {
        host: Host::default(),
        items: UasItems::of(identity),
        aircraft: Aircraft { declared: declared(location, known), ..Aircraft::default() },
        height_measured: place.height_measured,
        accuracy_m: location.accuracy_h_m().map(|radius_m| radius_m * HALF_OF_95),
        height_sigma_m: height.and_then(|height| height.1),
        velocity,
        climb_m_s,
        ..Fix::new(sensor, identity, time, place.position)
    })
}

/// The time nearest to a reception that is this number of seconds after a full hour.
fn nearest_hour(seconds: f64, received: Time) -> Time {
    let into = (seconds * SECOND as f64).round() as i64;
    let off = (into - received.nanos() + HOUR / 2).rem_euclid(HOUR) - HOUR / 2;
    Time::from_nanos(received.nanos().saturating_add(off))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hour_is_the_nearest_to_the_reception() {
        let at = |seconds: f64| Time::from_nanos((seconds * 1e9) as i64 + 1_700_000 * HOUR);
        assert_eq!(nearest_hour(3599.5, at(0.2)), at(-0.5));
        assert_eq!(nearest_hour(0.1, at(3599.9)), at(3600.1));
        assert_eq!(nearest_hour(3600.0, at(3600.0)), at(3600.0));
        assert_eq!(nearest_hour(1800.0, at(1799.0)), at(1800.0));
    }
}
