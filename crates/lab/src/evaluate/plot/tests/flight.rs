//! Synthetic flights for the tests: drones on ellipses, observed with noise.

use crate::evaluate::place::{GeodeticPlace, LocalOffset};
use crate::evaluate::types::{
    ErrorSample, ErrorStatistics, Evaluation, PointSource, PolarPlace, ScoredStream, StreamMetrics, TrueDrone,
};
use fusion::time::{SECOND, Time};

const START: i64 = 1_781_999_970 * SECOND;
pub(super) const RADAR: GeodeticPlace =
    GeodeticPlace { latitude_deg: 52.5065, longitude_deg: -0.588, altitude_amsl_m: Some(105.0) };

/// Size of a flight, and its faults.
pub(super) struct Flight {
    pub(super) drones: usize,
    pub(super) seconds: usize,
    pub(super) radar: bool,
    pub(super) transponder: bool,
    /// Interval of radar plots that are off by kilometres, in plots; 0: none.
    pub(super) outlier_every: usize,
}

pub(super) const FLIGHT: Flight =
    Flight { drones: 2, seconds: 390, radar: true, transponder: true, outlier_every: 0 };

/// Deterministic pseudo-random numbers in (-1, 1).
struct Noise(u64);

impl Noise {
    fn flat(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }

    fn bell(&mut self, deviation: f64) -> f64 {
        deviation * (self.flat() + self.flat() + self.flat())
    }
}

/// Place at metres east and north of the radar, and height.
fn at(east_m: f64, north_m: f64, altitude_amsl_m: f64) -> GeodeticPlace {
    let latitude_deg = RADAR.latitude_deg + north_m / 111_270.0;
    let longitude_deg = RADAR.longitude_deg + east_m / (111_400.0 * RADAR.latitude_deg.to_radians().cos());
    GeodeticPlace { latitude_deg, longitude_deg, altitude_amsl_m: Some(altitude_amsl_m) }
}

fn true_metres(drone: usize, seconds: f64) -> (f64, f64, f64) {
    let (shift, angle) = ((drone % 9) as f64, seconds * 0.035 + drone as f64);
    let (east, north) =
        (700.0 + 350.0 * angle.cos() - 90.0 * shift, 900.0 + 520.0 * angle.sin() - 410.0 * shift);
    (east, north, 160.0 + 25.0 * shift + 14.0 * (3.0 * angle).sin())
}

pub(super) type Truth = Vec<(String, Vec<(Time, GeodeticPlace)>)>;

impl Flight {
    pub(super) fn truth(&self) -> Truth {
        let path = |drone| {
            let known = (0..=self.seconds).filter(|second| !(100..130).contains(second));
            let point = |second: usize| {
                let (east, north, height) = true_metres(drone, second as f64);
                (Time::from_nanos(START + second as i64 * SECOND), at(east, north, height))
            };
            (format!("D{drone} <&\"'>"), known.map(point).collect())
        };
        (0..self.drones).map(path).collect()
    }

    /// A point of each drone every quarter of a second.
    fn samples(
        &self,
        noise: &mut Noise,
        deviation: f64,
        source: fn(usize) -> PointSource,
    ) -> Vec<ErrorSample> {
        let mut samples = Vec::new();
        for slot in 0..4 * self.seconds {
            for drone in 0..self.drones {
                let (east, north, height) = true_metres(drone, slot as f64 / 4.0);
                let source = source(slot);
                let deviation = if source == PointSource::Radar { 18.0 } else { deviation };
                let [mut east_m, north_m, up_m] =
                    [deviation, deviation, deviation / 3.0].map(|deviation| noise.bell(deviation));
                if self.outlier_every > 0 && source == PointSource::Radar && slot % self.outlier_every == 7 {
                    east_m += 4000.0;
                }
                samples.push(ErrorSample {
                    time: Time::from_nanos(START + slot as i64 * SECOND / 4),
                    place: at(east + east_m, north + north_m, height + up_m),
                    source,
                    number: drone as u32,
                    drone: Some(drone),
                    error: Some(LocalOffset { east_m, north_m, up_m: Some(up_m) }),
                    seen: Some(PolarPlace {
                        range_m: east.hypot(north),
                        azimuth_deg: east.atan2(north).to_degrees().rem_euclid(360.0),
                    }),
                });
            }
            if slot % 9 == 0 {
                samples.push(ErrorSample {
                    time: Time::from_nanos(START + slot as i64 * SECOND / 4),
                    place: at(300.0 + 500.0 * noise.flat() + slot as f64, 500.0 + 20.0 * noise.flat(), 190.0),
                    source: PointSource::Radar,
                    number: 999,
                    drone: None,
                    error: None,
                    seen: None,
                });
            }
        }
        samples
    }

    pub(super) fn evaluation(&self) -> Evaluation {
        let mut noise = Noise(7);
        let drones = (0..self.drones)
            .map(|drone| TrueDrone { id: format!("D{drone} <&\"'>"), equipped: Some(drone % 2 == 0) })
            .collect();
        let fused = |slot: usize| match slot % 400 {
            0..40 => PointSource::Radar,
            360..400 => PointSource::Transponder,
            _ => PointSource::Fused,
        };
        Evaluation {
            drones,
            fused: self.scored(self.samples(&mut noise, 2.0, fused), 5.1305),
            radar: self
                .radar
                .then(|| self.scored(self.samples(&mut noise, 18.0, |_| PointSource::Radar), 59.6589)),
            transponder: self
                .transponder
                .then(|| self.scored(self.samples(&mut noise, 1.6, |_| PointSource::Transponder), 4.25)),
        }
    }

    pub(super) fn scored(&self, samples: Vec<ErrorSample>, mean_m: f64) -> ScoredStream {
        let statistics = |mean_m: f64| {
            Some(ErrorStatistics {
                count: 9,
                mean_m,
                sem_m: 0.0278,
                p50_m: 0.9 * mean_m,
                p95_m: 2.0 * mean_m,
            })
        };
        let score = StreamMetrics {
            pu_percent: Some(100.0 - 0.5 * mean_m),
            epos: statistics(mean_m),
            eposh: statistics(0.9 * mean_m),
            eposv: statistics(0.2 * mean_m),
            precision: Some(0.9876),
            id_changes: Some(f64::NAN),
            gospa_m: Some(12_345.678),
            ..StreamMetrics::default()
        };
        ScoredStream {
            all: score.clone(),
            equipped: score.clone(),
            unequipped: score.clone(),
            drones: vec![score; self.drones],
            samples,
        }
    }
}
