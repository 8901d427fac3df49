//! Settings of the `operational` profile, with the values that registration and learning add.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::heights::HeightCorrection;
use super::likelihood::Scales;
use super::tuning::{self, DELAY_BETWEEN_TRANSPONDERS_S};
use crate::filter::{Dynamics, LineOfSight, RadarErrors};
use crate::frames::{Enu, RadarFrame};
use crate::report::{Identity, SensorIndex, TransponderType};
pub(super) use crate::settings::Camera;
use crate::settings::{self, IntegrityRules, OperationalRules, RegistrationMode, Sensor};
use crate::time::SECOND;

/// Sensors with the errors of their data sheets, and the motion of drones.
#[derive(Clone, Debug, PartialEq)]
pub struct OperationalSettings {
    /// Radars by sensor index; `None` for other sensors.
    pub radars: Vec<Option<RadarSettings>>,
    /// Transponder receivers by sensor index; `None` for other sensors.
    pub transponders: Vec<Option<ReceiverSettings>>,
    /// Cameras by sensor index; `None` for other sensors.
    pub cameras: Vec<Option<Camera>>,
    /// Maximum gap between two reports across which a transponder's position is interpolated, nanoseconds.
    pub max_gap_ns: i64,
    /// Motion models of drones.
    pub motion: Dynamics,
    /// Number of threads that share the work of a slot.
    pub threads: NonZeroUsize,
    /// Time from the opening of a slot to its deadline.
    pub latency: SignedDuration,
    /// Whether each deadline also publishes positions predicted for that time.
    pub now: bool,
    /// Rules on the integrity of transponders.
    pub integrity: IntegrityRules,
    /// Default delay of transponders; learnt, not configured.
    pub(super) delay: TransponderDelay,
    /// Learnt delays by type of transponder.
    pub(super) delays: BTreeMap<TransponderType, TransponderDelay>,
    /// Learnt delays of single transponders.
    pub(super) own_delays: BTreeMap<Identity, TransponderDelay>,
    /// How the heights of single transponders are corrected.
    pub(super) heights: BTreeMap<Identity, HeightCorrection>,
}

impl OperationalSettings {
    /// Creates the settings from the sensors, the time from the opening of a slot to its deadline, and the profile's rules.
    pub(crate) fn new(sensors: &[Sensor], latency: SignedDuration, rules: &OperationalRules) -> Self {
        let radar = |sensor: &Sensor| match sensor {
            Sensor::Radar(radar) => Some(RadarSettings::from(radar)),
            Sensor::Receiver(_) | Sensor::Camera(_) => None,
        };
        let transponder = |sensor: &Sensor| match sensor {
            Sensor::Radar(_) | Sensor::Camera(_) => None,
            Sensor::Receiver(receiver) => Some(ReceiverSettings::from(receiver)),
        };
        let camera = |sensor: &Sensor| match sensor {
            Sensor::Camera(camera) => Some(*camera),
            Sensor::Radar(_) | Sensor::Receiver(_) => None,
        };
        Self {
            cameras: sensors.iter().map(camera).collect(),
            radars: sensors.iter().map(radar).collect(),
            transponders: sensors.iter().map(transponder).collect(),
            max_gap_ns: rules.max_gap.as_nanos() as i64,
            motion: rules.dynamics,
            threads: rules.threads,
            latency,
            now: rules.now,
            integrity: rules.integrity,
            delay: TransponderDelay::default(),
            delays: BTreeMap::new(),
            own_delays: BTreeMap::new(),
            heights: BTreeMap::new(),
        }
    }

    /// The radar with this index.
    pub(super) fn radar(&self, sensor: SensorIndex) -> Option<&RadarSettings> {
        self.radars.get(usize::from(sensor.0))?.as_ref()
    }

    /// All radars.
    pub(super) fn radars(&self) -> impl Iterator<Item = (SensorIndex, &RadarSettings)> {
        let radar = |(index, radar): (usize, _)| Some((SensorIndex(index as u16), Option::as_ref(radar)?));
        self.radars.iter().enumerate().filter_map(radar)
    }

    /// The transponder receiver with this index.
    pub(super) fn transponder(&self, sensor: SensorIndex) -> Option<&ReceiverSettings> {
        self.transponders.get(usize::from(sensor.0))?.as_ref()
    }

    /// The camera with this index.
    pub(super) fn camera(&self, sensor: SensorIndex) -> Option<&Camera> {
        self.cameras.get(usize::from(sensor.0))?.as_ref()
    }

    /// The offset that is taken off the heights of a transponder, metres.
    pub(super) fn height_offset_m(&self, identity: &Identity) -> f64 {
        self.heights.get(identity).map_or(0.0, |heights| heights.applied_m)
    }

    /// Delay of a transponder of this type; `None`: the receiver is not configured.
    pub(super) fn delay(&self, identity: &Identity, kind: &TransponderType) -> Option<TransponderDelay> {
        let receiver = self.transponder(kind.receiver)?;
        if let Some(configured) = receiver.delay_s.map(TransponderDelay::configured) {
            return Some(configured.of_one());
        }
        let of_type = || self.delays.get(kind).copied().unwrap_or(self.delay).of_one();
        Some(self.own_delays.get(identity).copied().unwrap_or_else(of_type))
    }
}

/// Delay of transponders' time stamps behind the measurement, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TransponderDelay {
    /// Mean of the estimate.
    /// Standard deviation of the estimate.
    pub(super) mean_s: f64,
    pub(super) sigma_s: f64,
    /// Delay that is applied: the mean, but never below zero.
    pub(super) applied_s: f64,
}

impl TransponderDelay {
    pub(super) fn configured(delay_s: f64) -> Self {
        Self { mean_s: delay_s, sigma_s: 0.0, applied_s: delay_s }
    }

    /// Delay of one transponder when only that of its type is known.
    pub(super) fn of_one(self) -> Self {
        Self { sigma_s: self.sigma_s.hypot(DELAY_BETWEEN_TRANSPONDERS_S), ..self }
    }

    /// The delay with `mean_s` added to its applied part, and this standard deviation. No report is sent before it is measured.
    pub(super) fn apart(&self, mean_s: f64, sigma_s: f64) -> Self {
        let mean_s = self.applied_s + mean_s;
        Self { mean_s, sigma_s, applied_s: mean_s.max(0.0) }
    }
}

/// A radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarSettings {
    /// Position.
    pub position: Enu,
    /// The radar's own axes.
    pub frame: RadarFrame,
    /// Errors of an aligned radar according to its data sheet.
    pub data_sheet: RadarErrors,
    /// Errors of an aligned radar: learnt, or those of the data sheet.
    pub track_errors: RadarErrors,
    /// Multiples of these errors that are possible; learning narrows them towards 1.
    pub(super) scales: Scales,
    /// Errors of the radar with its present alignment, set by the registration.
    pub errors: RadarErrors,
    /// Handling of the radar's misalignment.
    pub registration: RegistrationMode,
    /// Whether the radar's errors are learnt.
    pub learns_accuracy: bool,
    /// Sigma of the radar's velocities, each axis, metres a second, possibly learnt; `None`: velocities are ignored.
    pub velocity_sigma_m_s: Option<f64>,
    /// Time between two detections of one target, seconds.
    pub period_s: f64,
}

impl RadarSettings {
    /// Minimum silence after which a track number means another track.
    pub(super) fn track_break(&self) -> SignedDuration {
        tuning::TRACK_BREAK.max(periods(tuning::TRACK_BREAK_PERIODS, self.period_s))
    }

    /// Sigma of a plot at `place` due to its bias alone: root mean square of the axes over ground, metres.
    pub(super) fn plot_sigma_m(&self, place: Enu) -> f64 {
        let covariance = LineOfSight::from(self.position, place)
            .spread(self.errors.bias_range_m, self.errors.bias_azimuth);
        (covariance.trace() / 2.0).sqrt()
    }
}

/// A transponder receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverSettings {
    /// Standard deviation of a report's horizontal distance from the true position, metres.
    pub horizontal_m: f64,
    /// Standard deviation of a report's height, metres.
    pub vertical_m: f64,
    /// Delay of the time stamps behind the measurement, seconds; `None`: learnt with the registration of the radars.
    pub delay_s: Option<f64>,
    /// Time between two reports of one transponder, seconds.
    pub period_s: f64,
    /// Long-run limit of previously unknown identities admitted, per second; at least 1.
    pub max_new_per_s: u32,
}

impl From<&settings::Radar> for RadarSettings {
    fn from(radar: &settings::Radar) -> Self {
        let settings::Radar { frame, errors, learns_accuracy, registration, period_s } = *radar;
        Self {
            position: frame.origin(),
            frame,
            data_sheet: errors,
            track_errors: errors,
            scales: Scales::of_data_sheet(),
            errors,
            registration,
            learns_accuracy,
            velocity_sigma_m_s: Some(tuning::RADAR_VELOCITY_M_S),
            period_s,
        }
    }
}

impl From<&settings::Receiver> for ReceiverSettings {
    fn from(receiver: &settings::Receiver) -> Self {
        let settings::Receiver { horizontal_m, vertical_m, delay_s, period_s, max_new_per_s } = *receiver;
        Self { horizontal_m, vertical_m, delay_s, period_s, max_new_per_s }
    }
}

/// Duration of a number of periods.
pub(super) fn periods(count: f64, period_s: f64) -> SignedDuration {
    SignedDuration::from_nanos((count * period_s * SECOND as f64) as i64)
}
