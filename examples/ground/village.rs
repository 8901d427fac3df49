//! A village: houses along its streets, on built-up land.

use crate::feature::{Feature, Place};
use crate::shapes::{apart, beside, blob, chance, distance_to, rectangle};

/// Distance between the middle of a street and the middle of a house, metres.
const SETBACK_M: f64 = 17.0;
/// Minimum distance between the middles of two houses, metres.
const APART_M: f64 = 17.0;
/// Minimum distance of a house from the middle of a street, metres.
const STREET_M: f64 = 11.0;

/// A village about a place.
pub struct Village {
    /// Its name.
    pub name: &'static str,
    /// Its middle.
    pub middle: Place,
    /// Radius of the built-up land, metres.
    pub radius_m: f64,
}

impl Village {
    /// Land, houses and name. `streets` are lines that may lead elsewhere: houses stand along their parts within the village.
    pub fn features(&self, streets: &[Vec<Place>], key: u64) -> Vec<Feature> {
        let mut features = vec![
            Feature::area("landuse", "residential", 10, blob(self.middle, self.radius_m, key)),
            Feature::place("village", self.name, 10, self.middle),
        ];
        let mut houses: Vec<Place> = Vec::new();
        for (number, street) in streets.iter().enumerate() {
            for side in [-1.0, 1.0] {
                let row = beside(&dense(street), |_| side * SETBACK_M);
                for (index, pair) in row.windows(2).enumerate() {
                    let place = pair[0];
                    let key = key ^ ((number as u64) << 20) ^ ((index as u64) << 1) ^ u64::from(side > 0.0);
                    let is_free = apart(place, self.middle) < 0.85 * self.radius_m
                        && houses.iter().all(|house| apart(*house, place) > APART_M)
                        && streets.iter().all(|street| distance_to(street, place) > STREET_M);
                    if !is_free || chance(key) < 0.2 {
                        continue;
                    }
                    houses.push(place);
                    let bearing = (pair[1][0] - place[0]).atan2(pair[1][1] - place[1]).to_degrees();
                    let (length, width) = (9.0 + 6.0 * chance(key + 7), 7.0 + 3.0 * chance(key + 9));
                    features.push(Feature::area(
                        "building",
                        "house",
                        14,
                        rectangle(place, length, width, bearing),
                    ));
                }
            }
        }
        features
    }

    /// A street of its own through the village, at a bearing in degrees and a distance from the middle, metres.
    pub fn street(&self, bearing_deg: f64, aside_m: f64) -> Vec<Place> {
        let (east, north) = bearing_deg.to_radians().sin_cos();
        let half_m = (self.radius_m.powi(2) - aside_m.powi(2)).max(0.0).sqrt() * 0.8;
        [-half_m, 0.0, half_m]
            .map(|along| {
                [
                    self.middle[0] + along * east + aside_m * north,
                    self.middle[1] + along * north - aside_m * east,
                ]
            })
            .to_vec()
    }
}

/// The line with a place every 8 m.
fn dense(line: &[Place]) -> Vec<Place> {
    let mut places = Vec::new();
    for pair in line.windows(2) {
        let pieces = (apart(pair[0], pair[1]) / 8.0).ceil().max(1.0) as usize;
        places.extend(
            (0..pieces).map(|piece| crate::shapes::between(pair[0], pair[1], piece as f64 / pieces as f64)),
        );
    }
    places.extend(line.last());
    places
}
