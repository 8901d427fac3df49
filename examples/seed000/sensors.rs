//! Radar and camera: their detections, with errors and latencies.

use fusion::{SensorIndex, Time};
use rand::RngExt;
use tracker::{CameraModel, Quantity, RadarModel, Reading, ReadingOrigin};

use crate::encounter::SimulatedEncounter;
use crate::experiment::Draws;

/// Standard deviations and means of the sensors' errors in Table 2: range (metres), azimuth and elevation (degrees).
pub const RADAR_SIGMA: [f64; 3] = [2.5, 0.86, 1.0];
pub const RADAR_BIAS: [f64; 3] = [1.9, -2.3, -0.50];
pub const CAMERA_SIGMA: [f64; 2] = [0.10, 0.18];
pub const CAMERA_BIAS: [f64; 2] = [-2.3, -0.60];

/// Range of the first detection by the radar, and by the camera, metres.
pub const RADAR_FROM_M: f64 = 2950.0;
const CAMERA_FROM_M: f64 = 2250.0;
/// Periods of the radar's scans and of the camera's frames, seconds, and the valid share of each: 0.7 and 2.6 per
/// second.
const SCAN_S: f64 = 1.0;
const SCANS_VALID: f64 = 0.7;
const FRAME_S: f64 = 0.3;
const FRAMES_VALID: f64 = 0.79;
/// Latencies of detections of the radar and of the camera, seconds.
const RADAR_LATENCY_S: (f64, f64) = (0.2, 1.0);
const CAMERA_LATENCY_S: (f64, f64) = (0.05, 0.1);
/// Angular distance of a false alarm of the camera, degrees; one per encounter, as in the flight.
const FALSE_ALARM_DEG: (f64, f64) = (1.5, 3.0);

/// Time step of the tracker, seconds; time stamps are rounded to it.
pub const TICK_S: f64 = 0.1;

/// Range variance due to a time stamp error of up to half a step, at 75 m/s, m².
pub const STAMP_VARIANCE_M2: f64 = (75.0 * TICK_S) * (75.0 * TICK_S) / 12.0;

/// One detection.
pub struct SensorDetection {
    /// Time of the detection, seconds. `known` is the time at which the tracker receives it.
    pub at: f64,
    pub known: f64,
    /// Range (radar only), metres. `angles` are azimuth and elevation, radians.
    pub range: Option<f64>,
    pub angles: [f64; 2],
    /// Whether it is a detection of the intruder.
    pub is_true: bool,
}

/// The radar, number 0.
fn radar() -> RadarModel {
    let [range_m, azimuth, elevation] = RADAR_SIGMA;
    RadarModel {
        range_m: (range_m * range_m + STAMP_VARIANCE_M2).sqrt(),
        azimuth: azimuth.to_radians(),
        elevation: elevation.to_radians(),
        range_rate: None,
    }
}

impl SensorDetection {
    /// Reading for the tracker, at the nearest time step.
    pub fn reading(&self, encounter: &SimulatedEncounter) -> Option<Reading> {
        let stamp = (self.at / TICK_S).round() * TICK_S;
        let taken = |sensor| ReadingOrigin {
            time: time(stamp),
            sensor: SensorIndex(sensor),
            observer: encounter.observer(stamp),
        };
        let [azimuth, elevation] = CAMERA_SIGMA.map(f64::to_radians);
        match self.range {
            Some(range) => radar().reading(taken(0), [range, self.angles[0], self.angles[1]], None),
            None => CameraModel { azimuth, elevation }.reading(taken(1), self.angles),
        }
    }
}

/// Converts a time of the encounter for the tracker.
pub fn time(at: f64) -> Time {
    Time::from_nanos((at * 1e9).round() as i64)
}

/// All detections, in the order in which the tracker receives them.
pub fn detections(encounter: &SimulatedEncounter, draws: &mut Draws) -> Vec<SensorDetection> {
    let mut all = Vec::new();
    // Scans last a multiple of the time step, so that all time stamps of an encounter have the same error.
    let begin = encounter.when_apart(RADAR_FROM_M) + draws.0.random_range(0.0..TICK_S);
    for scan in 0.. {
        let at = begin + SCAN_S * f64::from(scan);
        if at >= 0.0 {
            break;
        }
        if scan > 0 && !draws.0.random_bool(SCANS_VALID) {
            continue;
        }
        let [range, azimuth, elevation] = seen(encounter, at);
        let [by_range, by_azimuth, by_elevation] = errors(RADAR_SIGMA, RADAR_BIAS, draws);
        all.push(SensorDetection {
            at,
            known: at + draws.0.random_range(RADAR_LATENCY_S.0..RADAR_LATENCY_S.1),
            range: Some(range + by_range),
            angles: [azimuth + by_azimuth.to_radians(), elevation + by_elevation.to_radians()],
            is_true: true,
        });
    }
    let begin = encounter.when_apart(CAMERA_FROM_M) + draws.0.random_range(0.0..FRAME_S);
    let frames = (-begin / FRAME_S).floor() as u32;
    let false_alarm = draws.0.random_range(0..frames);
    for frame in 0..frames {
        let at = begin + FRAME_S * f64::from(frame);
        if !draws.0.random_bool(FRAMES_VALID) && frame != false_alarm {
            continue;
        }
        let [_, azimuth, elevation] = seen(encounter, at);
        let [mut by_azimuth, mut by_elevation] = errors(CAMERA_SIGMA, CAMERA_BIAS, draws);
        if frame == false_alarm {
            let off = draws.0.random_range(FALSE_ALARM_DEG.0..FALSE_ALARM_DEG.1);
            let (sin, cos) = draws.0.random_range(0.0..std::f64::consts::TAU).sin_cos();
            (by_azimuth, by_elevation) = (by_azimuth + off * sin, by_elevation + off * cos);
        }
        all.push(SensorDetection {
            at,
            known: at + draws.0.random_range(CAMERA_LATENCY_S.0..CAMERA_LATENCY_S.1),
            range: None,
            angles: [azimuth + by_azimuth.to_radians(), elevation + by_elevation.to_radians()],
            is_true: frame != false_alarm,
        });
    }
    all.sort_by(|a, b| a.known.total_cmp(&b.known));
    all
}

/// Range, azimuth and elevation without errors.
fn seen(encounter: &SimulatedEncounter, at: f64) -> [f64; 3] {
    let (line, _) = encounter.line(at);
    let observer = encounter.observer(at);
    let position = observer.position.0 + line;
    [Quantity::Range, Quantity::Azimuth, Quantity::Elevation].map(|quantity| {
        let expected = quantity.expected(&observer, &position, &line);
        expected.expect("before the closest point they are tens of metres apart").value
    })
}

fn errors<const N: usize>(sigma: [f64; N], bias: [f64; N], draws: &mut Draws) -> [f64; N] {
    std::array::from_fn(|axis| bias[axis] + draws.normal(sigma[axis]))
}
