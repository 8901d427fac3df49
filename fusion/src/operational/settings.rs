//! Settings of the `operational` profile, and what registration adds to it.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::likelihood::Scales;
use super::tuning::{self, DELAY_BETWEEN_TRANSPONDERS_S};
use crate::filter::{Dynamics, LineOfSight, RadarErrors};
use crate::frames::{Enu, RadarFrame};
use crate::report::{Identity, SensorIndex, TransponderType};
pub(super) use crate::settings::Camera;
use crate::settings::{self, IntegrityRules, OperationalRules, RegistrationMode, Sensor};
use crate::time::SECOND;

/// The sensors as their data sheets have them, and how drones move.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// By sensor: `None` for a transponder receiver.
    pub radars: Vec<Option<Radar>>,
    /// By sensor: `None` for a radar.
    pub transponders: Vec<Option<Transponder>>,
    /// By sensor: `None` for all others.
    pub cameras: Vec<Option<Camera>>,
    /// A transponder's position is interpolated between two reports no further apart than this, nanoseconds.
    pub max_gap_ns: i64,
    /// How drones move.
    pub motion: Dynamics,
    /// Threads that share the work of a slot.
    pub threads: NonZeroUsize,
    /// From the opening of a slot to its deadline.
    pub latency: SignedDuration,
    /// Whether each deadline also yields where aircraft are by then.
    pub now: bool,
    /// Whether transponders can be trusted.
    pub integrity: IntegrityRules,
    /// Delay of transponders of which no more is known, and by type; not read from the settings but learnt.
    pub(super) delay: Delay,
    pub(super) delays: BTreeMap<TransponderType, Delay>,
    /// The delays of single transponders of which radars tell.
    pub(super) own_delays: BTreeMap<Identity, Delay>,
}

impl Settings {
    /// From the sensors, the time from the opening of a slot to its deadline, and the profile's rules.
    pub(crate) fn new(sensors: &[Sensor], latency: SignedDuration, rules: &OperationalRules) -> Self {
        let radar = |sensor: &Sensor| match sensor {
            Sensor::Radar(radar) => Some(Radar::from(radar)),
            Sensor::Receiver(_) | Sensor::Camera(_) => None,
        };
        let transponder = |sensor: &Sensor| match sensor {
            Sensor::Radar(_) | Sensor::Camera(_) => None,
            Sensor::Receiver(receiver) => Some(Transponder::from(receiver)),
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
            delay: Delay::default(),
            delays: BTreeMap::new(),
            own_delays: BTreeMap::new(),
        }
    }

    /// The radar of that index.
    pub(super) fn radar(&self, sensor: SensorIndex) -> Option<&Radar> {
        self.radars.get(usize::from(sensor.0))?.as_ref()
    }

    /// All radars.
    pub(super) fn radars(&self) -> impl Iterator<Item = (SensorIndex, &Radar)> {
        let radar = |(index, radar): (usize, _)| Some((SensorIndex(index as u16), Option::as_ref(radar)?));
        self.radars.iter().enumerate().filter_map(radar)
    }

    /// The transponder receiver of that index.
    pub(super) fn transponder(&self, sensor: SensorIndex) -> Option<&Transponder> {
        self.transponders.get(usize::from(sensor.0))?.as_ref()
    }

    /// The camera of that index.
    pub(super) fn camera(&self, sensor: SensorIndex) -> Option<&Camera> {
        self.cameras.get(usize::from(sensor.0))?.as_ref()
    }

    /// The delay of a transponder of that type; `None`: there is no such receiver.
    pub(super) fn delay(&self, identity: &Identity, kind: &TransponderType) -> Option<Delay> {
        let receiver = self.transponder(kind.receiver)?;
        if let Some(configured) = receiver.delay_s.map(Delay::configured) {
            return Some(configured.of_one());
        }
        let of_type = || self.delays.get(kind).copied().unwrap_or(self.delay).of_one();
        Some(self.own_delays.get(identity).copied().unwrap_or_else(of_type))
    }
}

/// Delay of transponders' times behind the measurement, seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Delay {
    /// The best guess, and its standard deviation.
    pub(super) mean_s: f64,
    pub(super) sigma_s: f64,
    /// The delay that is applied: the best guess, never below zero.
    pub(super) applied_s: f64,
}

impl Delay {
    pub(super) fn configured(delay_s: f64) -> Self {
        Self { mean_s: delay_s, sigma_s: 0.0, applied_s: delay_s }
    }

    /// The delay of one transponder where only that of its type is known.
    pub(super) fn of_one(self) -> Self {
        Self { sigma_s: self.sigma_s.hypot(DELAY_BETWEEN_TRANSPONDERS_S), ..self }
    }

    /// Apart from the part of this that is applied by `mean_s`, with this standard deviation. Nothing is sent before it is
    /// measured.
    pub(super) fn apart(&self, mean_s: f64, sigma_s: f64) -> Self {
        let mean_s = self.applied_s + mean_s;
        Self { mean_s, sigma_s, applied_s: mean_s.max(0.0) }
    }
}

/// A radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radar {
    /// Position.
    pub position: Enu,
    /// Its own axes.
    pub frame: RadarFrame,
    /// Errors of an aligned radar as its data sheet has them.
    pub data_sheet: RadarErrors,
    /// The same or, where they are learnt, as they have shown themselves; the latter not read from the settings.
    pub track_errors: RadarErrors,
    /// The multiples of their size that they may have; nearer to 1 the better they are known. Not read from the settings.
    pub(super) scales: Scales,
    /// Errors of the radar as it is aligned now; not read from the settings but set by the registration.
    pub errors: RadarErrors,
    /// What is done about misalignment.
    pub registration: RegistrationMode,
    /// Whether its errors are learnt.
    pub learns_accuracy: bool,
    /// Sigma of the velocities that it tells, each axis, metres a second; `None`: they are not used. Not read from the settings
    /// but, where errors are learnt, set by what is.
    pub velocity_sigma_m_s: Option<f64>,
    /// Time between two detections of one target, seconds.
    pub period_s: f64,
}

impl Radar {
    /// A track number heard again after a longer silence is another track.
    pub(super) fn track_break(&self) -> SignedDuration {
        tuning::TRACK_BREAK.max(periods(tuning::TRACK_BREAK_PERIODS, self.period_s))
    }

    /// Sigma of a place as its plots have it, from their bias alone: mean of the axes over ground, metres.
    pub(super) fn plot_sigma_m(&self, place: Enu) -> f64 {
        let covariance = LineOfSight::from(self.position, place)
            .spread(self.errors.bias_range_m, self.errors.bias_azimuth);
        (covariance.trace() / 2.0).sqrt()
    }
}

/// A transponder receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transponder {
    /// Standard deviation of a report's horizontal distance from the true position, metres.
    pub horizontal_m: f64,
    /// Standard deviation of a report's height, metres.
    pub vertical_m: f64,
    /// Delay of the reports' time stamps behind the measurement, seconds; `None`: learnt with the registration of the radars.
    pub delay_s: Option<f64>,
    /// Time between two reports of one transponder, seconds.
    pub period_s: f64,
    /// Long-run limit of previously unknown identities admitted, per second; at least 1.
    pub max_new_per_s: u32,
}

impl From<&settings::Radar> for Radar {
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

impl From<&settings::Receiver> for Transponder {
    fn from(receiver: &settings::Receiver) -> Self {
        let settings::Receiver { horizontal_m, vertical_m, delay_s, period_s, max_new_per_s } = *receiver;
        Self { horizontal_m, vertical_m, delay_s, period_s, max_new_per_s }
    }
}

/// So many periods.
pub(super) fn periods(count: f64, period_s: f64) -> SignedDuration {
    SignedDuration::from_nanos((count * period_s * SECOND as f64) as i64)
}
