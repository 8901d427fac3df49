//! What the `operational` profile is told once, and what registration adds to it.

use crate::filter::{Dynamics, RadarErrors};
use crate::frames::Enu;
use crate::report::SensorIndex;
use crate::settings::{self, OperationalRules, RegistrationMode, Sensor};

/// The sensors as their data sheets have them, and the rules' numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// By sensor: `None` for a transponder receiver.
    pub radars: Vec<Option<Radar>>,
    /// By sensor: `None` for a radar.
    pub transponders: Vec<Option<Transponder>>,
    /// A transponder is not compared with radar tracks between two reports further apart, nanoseconds.
    pub max_gap_ns: i64,
    /// How drones move.
    pub motion: Dynamics,
}

impl Settings {
    /// From the sensors and the profile's rules.
    pub(crate) fn new(sensors: &[Sensor], rules: &OperationalRules) -> Self {
        let radar = |sensor: &Sensor| match sensor {
            Sensor::Radar(radar) => Some(Radar::from(radar)),
            Sensor::Receiver(_) => None,
        };
        let transponder = |sensor: &Sensor| match sensor {
            Sensor::Radar(_) => None,
            Sensor::Receiver(receiver) => Some(Transponder::from(receiver)),
        };
        Self {
            radars: sensors.iter().map(radar).collect(),
            transponders: sensors.iter().map(transponder).collect(),
            max_gap_ns: rules.max_gap.as_nanos() as i64,
            motion: rules.dynamics,
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
}

/// A radar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radar {
    /// Where it stands.
    pub position: Enu,
    /// How wrong it is when it is set up rightly.
    pub track_errors: RadarErrors,
    /// How wrong it is as it is set up.
    pub errors: RadarErrors,
    /// What is done about its being set up wrongly.
    pub registration: RegistrationMode,
    /// Seconds between two detections of one target.
    pub period_s: f64,
}

/// A transponder receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transponder {
    /// Deviation of a report over ground, of its distance from where it belongs, metres.
    pub horizontal_m: f64,
    /// Deviation of a report's height, metres.
    pub vertical_m: f64,
    /// Reports are stamped so long after their position was measured, seconds; `None`: not known, to be learnt with the
    /// radars' registration.
    pub delay_s: Option<f64>,
    /// And that is known to this, one standard deviation, seconds: 0 where it is configured.
    pub delay_sigma_s: f64,
    /// Seconds between two reports of one transponder.
    pub period_s: f64,
    /// So many identities that were not known before are let in a second, in the long run; at least 1.
    pub max_new_per_s: u32,
}

impl From<&settings::Radar> for Radar {
    fn from(radar: &settings::Radar) -> Self {
        let settings::Radar { position, errors, registration, period_s } = *radar;
        Self { position, track_errors: errors, errors, registration, period_s }
    }
}

impl From<&settings::Receiver> for Transponder {
    fn from(receiver: &settings::Receiver) -> Self {
        let settings::Receiver { horizontal_m, vertical_m, delay_s, period_s, max_new_per_s } = *receiver;
        Self { horizontal_m, vertical_m, delay_s, delay_sigma_s: 0.0, period_s, max_new_per_s }
    }
}
