//! The three sensor configurations, and their measurements.

use fusion::{SensorIndex, Time};
use tracker::{CameraModel, InterrogatorModel, Quantity, RadarModel, Reading, ReadingOrigin};

use crate::experiment::Draws;
use crate::scenario::{Intruder, observer};

const RADAR_SIGMA: [f64; 4] = [50.0, 1.0_f64.to_radians(), 1.0_f64.to_radians(), 2.5];
const RADAR_S: f64 = 2.0;
/// Ten percent of the altitude.
const IFF_SIGMA: [f64; 3] = [150.0, 3.0_f64.to_radians(), 310.0];
const IFF_S: f64 = 1.0;
const CAMERA_SIGMA: [f64; 2] = [0.2_f64.to_radians(), 0.2_f64.to_radians()];
const CAMERA_S: f64 = 0.1;

/// Sensors of a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorConfiguration {
    pub name: &'static str,
    /// Radar; otherwise an interrogator.
    radar: bool,
    camera: bool,
}

pub const CONFIGURATIONS: [SensorConfiguration; 3] = [
    SensorConfiguration { name: "1: radar", radar: true, camera: false },
    SensorConfiguration { name: "2: IFF and EO/IR", radar: false, camera: true },
    SensorConfiguration { name: "3: radar and EO/IR", radar: true, camera: true },
];

/// Converts a time of the scenario for the tracker.
pub fn time(at: f64) -> Time {
    Time::from_nanos((at * 1e9).round() as i64)
}

impl SensorConfiguration {
    /// Readings of a flight, in order of time; at equal times, readings with a range come first. Each sensor has its
    /// own random draws, so that configurations share the readings of common sensors.
    pub fn readings(&self, intruder: &Intruder, seed: u64) -> Vec<Reading> {
        let mut readings = Vec::new();
        if self.radar {
            let mut draws = Draws::of(2 * seed);
            readings.extend(every(RADAR_S, intruder).filter_map(|at| radar(intruder, at, &mut draws)));
        } else {
            let mut draws = Draws::of(2 * seed);
            readings.extend(every(IFF_S, intruder).filter_map(|at| iff(intruder, at, &mut draws)));
        }
        if self.camera {
            let mut draws = Draws::of(2 * seed + 1);
            readings.extend(every(CAMERA_S, intruder).filter_map(|at| camera(intruder, at, &mut draws)));
        }
        readings.sort_by_key(|reading| (reading.origin().time, reading.origin().sensor));
        readings
    }
}

fn every(period_s: f64, intruder: &Intruder) -> impl Iterator<Item = f64> {
    let count = (intruder.end_s() / period_s).floor() as u32;
    (0..=count).map(move |number| f64::from(number) * period_s)
}

fn taken(at: f64, sensor: u16) -> ReadingOrigin {
    ReadingOrigin { time: time(at), sensor: SensorIndex(sensor), observer: observer(at) }
}

/// Measurement of these quantities, with noise.
fn measured<const N: usize>(
    intruder: &Intruder,
    at: f64,
    quantities: [Quantity; N],
    sigma: [f64; N],
    draws: &mut Draws,
) -> Option<[f64; N]> {
    let (position, velocity) = intruder.at(at);
    let mut values = [0.0; N];
    for (value, (quantity, sigma)) in values.iter_mut().zip(quantities.into_iter().zip(sigma)) {
        *value = quantity.expected(&observer(at), &position, &velocity)?.value + draws.normal(sigma);
    }
    Some(values)
}

fn radar(intruder: &Intruder, at: f64, draws: &mut Draws) -> Option<Reading> {
    let quantities = [Quantity::Range, Quantity::Azimuth, Quantity::Elevation, Quantity::RangeRate];
    let [range, azimuth, elevation, rate] = measured(intruder, at, quantities, RADAR_SIGMA, draws)?;
    let [range_m, of_azimuth, of_elevation, of_rate] = RADAR_SIGMA;
    let radar =
        RadarModel { range_m, azimuth: of_azimuth, elevation: of_elevation, range_rate: Some(of_rate) };
    radar.reading(taken(at, 0), [range, azimuth, elevation], Some(rate))
}

fn iff(intruder: &Intruder, at: f64, draws: &mut Draws) -> Option<Reading> {
    let quantities = [Quantity::Range, Quantity::Azimuth, Quantity::Altitude];
    let [range, azimuth, altitude] = measured(intruder, at, quantities, IFF_SIGMA, draws)?;
    let [range_m, of_azimuth, altitude_m] = IFF_SIGMA;
    InterrogatorModel { range_m, azimuth: of_azimuth, altitude_m }.reading(
        taken(at, 0),
        [range, azimuth],
        Some(altitude),
    )
}

fn camera(intruder: &Intruder, at: f64, draws: &mut Draws) -> Option<Reading> {
    let quantities = [Quantity::Azimuth, Quantity::Elevation];
    let angles = measured(intruder, at, quantities, CAMERA_SIGMA, draws)?;
    let [azimuth, elevation] = CAMERA_SIGMA;
    CameraModel { azimuth, elevation }.reading(taken(at, 1), angles)
}
