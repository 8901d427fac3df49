//! Compact position reporting (ICAO Annex 10 volume III, RTCA DO-260B appendix A.1.7): 17 bits each of latitude and
//! longitude, without the number of the zone. Two frames of different parity, or a place nearby, restore the position.

use std::f64::consts::PI;

/// An encoded position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CprPosition {
    /// Whether it uses the zones of odd frames.
    pub odd: bool,
    /// Latitude within the zone, in units of 2^-17 zone.
    pub latitude: u32,
    /// Longitude within the zone, in units of 2^-17 zone.
    pub longitude: u32,
}

/// Latitude and longitude, in degrees.
pub type LatLonDeg = [f64; 2];

/// Number of latitude zones of even frames; odd ones have one less.
const ZONES: f64 = 60.0;
/// Steps in a zone.
const STEPS: f64 = 131_072.0;
/// Degrees covered by all zones.
const ROUND: f64 = 360.0;
/// Degrees covered by all zones of frames from the ground: four times as fine, ambiguous every quarter.
const QUARTER: f64 = 90.0;
/// Radius of a spherical Earth, in metres.
const EARTH_M: f64 = 6_371_000.0;

impl CprPosition {
    fn fractions(self) -> (f64, f64) {
        (f64::from(self.latitude) / STEPS, f64::from(self.longitude) / STEPS)
    }
}

/// Number of longitude zones at this latitude (NL), 1 to 59.
fn zones_at(latitude_deg: f64) -> f64 {
    let latitude = latitude_deg.abs();
    if latitude >= 87.0 {
        return if latitude > 87.0 { 1.0 } else { 2.0 };
    }
    let cosine = libm::cos(PI / 180.0 * latitude);
    let within = 1.0 - (1.0 - libm::cos(PI / (ZONES / 2.0))) / (cosine * cosine);
    (2.0 * PI / libm::acos(within)).floor().clamp(1.0, ZONES - 1.0)
}

/// Place of an aircraft in the air from two frames of different parity, close in time: that of `newest`. `None` if the
/// frames are in different longitude zones, or from different aircraft.
pub fn pair(newest: CprPosition, other: CprPosition) -> Option<LatLonDeg> {
    let (latitudes, zone) = latitudes(newest, other, ROUND)?;
    let [latitude, other] =
        latitudes.map(|latitude| if latitude >= 270.0 { latitude - ROUND } else { latitude });
    if latitude.abs() > 90.0 || zones_at(latitude) != zones_at(other) {
        return None;
    }
    let longitude = longitude(newest, zone, latitude, ROUND);
    Some([latitude, if longitude >= 180.0 { longitude - ROUND } else { longitude }])
}

/// Place of an aircraft on the ground from two frames, which fit eight places: the nearest to `reference`.
pub fn surface_pair(newest: CprPosition, other: CprPosition, reference: LatLonDeg) -> Option<LatLonDeg> {
    let (latitudes, zone) = latitudes(newest, other, QUARTER)?;
    let is_south = (latitudes[0] - reference[0]).abs() > (latitudes[0] - QUARTER - reference[0]).abs();
    let [latitude, other] = latitudes.map(|latitude| if is_south { latitude - QUARTER } else { latitude });
    if zones_at(latitude) != zones_at(other) {
        return None;
    }
    let longitude = longitude(newest, zone, latitude, QUARTER);
    let quarters = ((reference[1] - longitude) / QUARTER).round();
    Some([latitude, turn(longitude + quarters * QUARTER)])
}

/// Latitudes of `newest` and `other` from 0 degrees, and the longitude fractions of the even and the odd frame.
fn latitudes(newest: CprPosition, other: CprPosition, round: f64) -> Option<([f64; 2], [f64; 2])> {
    let (even, odd) = match (newest.odd, other.odd) {
        (false, true) => (newest, other),
        (true, false) => (other, newest),
        _ => return None,
    };
    let ((even_latitude, even_longitude), (odd_latitude, odd_longitude)) =
        (even.fractions(), odd.fractions());
    let zone = ((ZONES - 1.0) * even_latitude - ZONES * odd_latitude + 0.5).floor();
    let of = |zones: f64, fraction: f64| round / zones * (zone.rem_euclid(zones) + fraction);
    let (even, odd) = (of(ZONES, even_latitude), of(ZONES - 1.0, odd_latitude));
    Some((if newest.odd { [odd, even] } else { [even, odd] }, [even_longitude, odd_longitude]))
}

/// Longitude of `newest` from 0 degrees.
fn longitude(newest: CprPosition, [even, odd]: [f64; 2], latitude: f64, round: f64) -> f64 {
    let most = zones_at(latitude);
    let zone = (even * (most - 1.0) - odd * most + 0.5).floor();
    let zones = (most - f64::from(u8::from(newest.odd))).max(1.0);
    round / zones * (zone.rem_euclid(zones) + if newest.odd { odd } else { even })
}

/// Place from one frame, less than half a zone (180 NM; on the ground 45 NM) from `reference`.
pub fn near(frame: CprPosition, on_ground: bool, reference: LatLonDeg) -> Option<LatLonDeg> {
    let round = if on_ground { QUARTER } else { ROUND };
    let (latitude, longitude) = frame.fractions();
    let parity = f64::from(u8::from(frame.odd));
    let nearest = |zone: f64, reference: f64, fraction: f64| {
        zone * ((reference / zone - fraction + 0.5).floor() + fraction)
    };
    let latitude = nearest(round / (ZONES - parity), reference[0], latitude);
    if latitude.abs() > 90.0 {
        return None;
    }
    let zones = (zones_at(latitude) - parity).max(1.0);
    Some([latitude, turn(nearest(round / zones, reference[1], longitude))])
}

/// Normalises an angle to -180 to 180 degrees.
fn turn(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(ROUND) - 180.0
}

/// Distance of two places on a sphere, in metres.
pub fn distance_m(a: LatLonDeg, b: LatLonDeg) -> f64 {
    let radians = |degrees: f64| degrees * PI / 180.0;
    let half = |difference: f64| {
        let sine = libm::sin(radians(difference) / 2.0);
        sine * sine
    };
    let cosines = libm::cos(radians(a[0])) * libm::cos(radians(b[0]));
    2.0 * EARTH_M * libm::asin((half(a[0] - b[0]) + cosines * half(a[1] - b[1])).min(1.0).sqrt())
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Frame of a place, as an aircraft encodes it.
    pub(crate) fn compact([latitude, longitude]: LatLonDeg, odd: bool, on_ground: bool) -> CprPosition {
        let round = if on_ground { QUARTER } else { ROUND };
        let parity = f64::from(u8::from(odd));
        let steps = |zone: f64, value: f64| (STEPS * (value / zone).rem_euclid(1.0) + 0.5).floor();
        let zone = round / (ZONES - parity);
        let count = steps(zone, latitude);
        let sent = zone * (count / STEPS + (latitude / zone).floor());
        let zones = (zones_at(sent) - parity).max(1.0);
        let wrapped = |count: f64| count as u32 & 0x1_ffff;
        CprPosition { odd, latitude: wrapped(count), longitude: wrapped(steps(round / zones, longitude)) }
    }

    #[test]
    fn zones_match_the_standard() {
        // DO-260B table A-21: latitudes at which NL decreases.
        let falls =
            [(10.470_471_30, 59.0), (44.194_549_51, 43.0), (59.954_592_77, 30.0), (86.535_369_98, 3.0)];
        for (latitude, zones) in falls {
            assert_eq!([zones_at(latitude - 1e-7), zones_at(latitude + 1e-7)], [zones, zones - 1.0]);
            assert_eq!(zones_at(1e-7 - latitude), zones, "south");
        }
        assert_eq!([0.0, 87.0, 87.1, 90.0].map(zones_at), [59.0, 2.0, 1.0, 1.0]);
    }

    #[test]
    fn published_pair_decodes_to_its_position() {
        // The Mode S book (mode-s.org/1090mhz), chapter on airborne positions: 52.2572 N, 3.91937 E.
        let even = CprPosition { odd: false, latitude: 93_000, longitude: 51_372 };
        let odd = CprPosition { odd: true, latitude: 74_158, longitude: 50_194 };
        let [latitude, longitude] = pair(even, odd).unwrap();
        assert!((latitude - 52.257_202).abs() < 1e-6 && (longitude - 3.919_373).abs() < 1e-6);
        let [latitude, longitude] = near(even, false, [52.258, 3.918]).unwrap();
        assert!((latitude - 52.257_202).abs() < 1e-6 && (longitude - 3.919_373).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn encoded_position_decodes_to_itself(
            latitude in -86.0..86.0, longitude in -180.0..180.0_f64, odd: bool, north in -0.3..0.3, east in -0.3..0.3,
        ) {
            let place = [latitude, longitude];
            for on_ground in [false, true] {
                let frames = [odd, !odd].map(|odd| compact(place, odd, on_ground));
                let reference = [latitude + north, longitude + east];
                let found = near(frames[0], on_ground, reference).unwrap();
                prop_assert!(distance_m(found, place) < 6.0, "{found:?}");
                let found = if on_ground {
                    surface_pair(frames[0], frames[1], reference)
                } else {
                    pair(frames[0], frames[1])
                };
                // Near the edge of a zone the two frames may be in different zones.
                if let Some(found) = found {
                    prop_assert!(distance_m(found, place) < 6.0, "{found:?}");
                }
            }
        }

        #[test]
        fn any_frame_decodes_to_a_valid_position_or_none(a: [u32; 2], b: [u32; 2], latitude in -90.0..90.0, longitude in -180.0..180.0) {
            let of = |[latitude, longitude]: [u32; 2], odd| CprPosition { odd, latitude: latitude & 0x1_ffff, longitude: longitude & 0x1_ffff };
            let frames = (of(a, false), of(b, true));
            let reference = [latitude, longitude];
            for place in [
                pair(frames.0, frames.1), pair(frames.1, frames.0), near(frames.0, false, reference),
                near(frames.1, true, reference), surface_pair(frames.1, frames.0, reference),
            ].into_iter().flatten() {
                prop_assert!(place[0].abs() <= 91.6 && place[1].abs() <= 180.0, "{place:?}");
            }
        }
    }
}
