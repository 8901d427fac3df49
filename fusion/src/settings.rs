//! The settings of an engine: slots, sensors, and the rules of a profile.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

pub use crate::filter::{Dynamics, Model, Models, RadarErrors, Singer};
use crate::frames::{Enu, RadarFrame};
pub use crate::integrity::{Action, IntegrityRules};
use crate::operational::DECIDED_AFTER;
use crate::report::SensorIndex;
use crate::slots::{RING, SlotGrid};

/// Slots, sensors and the profile. The default has slots of 0.25 s, a latency of 6.25 s, the [`Profile::Operational`] and no
/// sensors: [`Settings::add_radar`], [`Settings::add_receiver`] and
/// [`Settings::add_camera`] add them.
///
/// ```
/// use utm_fusion_engine::settings::{Radar, RadarErrors, Receiver};
/// use utm_fusion_engine::{Engine, Settings};
///
/// let mut settings = Settings::default();
/// // Standard deviations from the data sheet: 5 m in range, 1° in azimuth, 10 m in height.
/// let errors = RadarErrors::of_data_sheet(5.0, 1.0, 10.0);
/// let radar = settings.add_radar(Radar { errors, ..Radar::default() });
/// let receiver = settings.add_receiver(Receiver::default());
/// assert_ne!(radar, receiver);
/// let engine = Engine::new(settings)?;
/// # Ok::<(), utm_fusion_engine::settings::SettingsError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The slots. Durations below are whole slots where they can be, so that no two parts round differently.
    pub grid: SlotGrid,
    /// Slots that a slot waits before it is emitted (25: 6.25 s).
    pub latency_slots: i64,
    /// Slots in the window (100: 25 s): an older report is refused.
    pub window_slots: i64,
    /// How far ahead of its reception a report may be (1 s).
    pub max_future: SignedDuration,
    /// The sensors, by [`SensorIndex`].
    pub sensors: Vec<Sensor>,
    /// Track numbers reserved for transponders, by trimmed serial number.
    pub transponder_numbers: BTreeMap<Vec<u8>, u32>,
    /// By which rules reports become points.
    pub profile: Profile,
}

/// By which rules reports become points.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// The rules of the paper: association by distance threshold and ratio, weighted mean.
    Reference(ReferenceRules),
    /// One target per aircraft, associated by likelihood, filtered and smoothed.
    Operational(OperationalRules),
}

/// The numbers of [`Profile::Reference`], named as in the paper (`docs/ALGORITHM.md`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceRules {
    /// Longest gap between two reports of a transponder across which it is interpolated (25 s).
    pub max_gap: SignedDuration,
    /// Distance D(ρ) within which radar and transponder agree.
    pub threshold: Threshold,
    /// Least ratio for an association: the share of slots within the threshold among those where both are present, in
    /// millionths (900,000).
    pub min_ratio_ppm: u64,
    /// Least number of slots where both are present (4).
    pub min_samples: u32,
    /// Weights of a fused position.
    pub weights: Weights,
    /// A radar track alone is published once it has been a UAV for longer than this, seconds (8).
    pub radar_only_min_s: f64,
    /// A transponder alone is withheld this many slots around an association (16: 4 s).
    pub suppress_slots: i64,
}

/// Weights of radar and transponder in a fused position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Weights {
    /// The radar's (1).
    pub radar: f64,
    /// The transponder's (10).
    pub transponder: f64,
}

/// The numbers of [`Profile::Operational`].
#[derive(Clone, Debug, PartialEq)]
pub struct OperationalRules {
    /// How drones move.
    pub dynamics: Dynamics,
    /// Longest gap between two reports of a transponder across which it is compared with radar tracks (8 s).
    pub max_gap: SignedDuration,
    /// Whether each deadline also yields the picture of where aircraft are by then (yes).
    pub now: bool,
    /// Threads that share the work of a slot with much traffic (1). What is published is the same with any number.
    pub threads: NonZeroUsize,
    /// Whether transponders can be trusted.
    pub integrity: IntegrityRules,
}

/// A sensor.
#[derive(Clone, Debug, PartialEq)]
pub enum Sensor {
    /// A radar, which sends plots.
    Radar(Radar),
    /// A transponder receiver, which sends fixes.
    Receiver(Receiver),
    /// A camera, which sends bearings; the `reference` profile has no use for them.
    Camera(Camera),
}

/// A camera: an EO/IR head that measures angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands, in the site's frame.
    pub position: Enu,
    /// Standard deviation of an azimuth, radians.
    pub azimuth: f64,
    /// Standard deviation of an elevation, radians.
    pub elevation: f64,
}

/// A radar.
#[derive(Clone, Debug, PartialEq)]
pub struct Radar {
    /// Where it stands, and its axes.
    pub frame: RadarFrame,
    /// Its errors when it is aligned.
    pub errors: RadarErrors,
    /// Whether those are where to start from, to be learnt from its tracks, and its velocities with them; or what counts.
    pub learns_accuracy: bool,
    /// What is done about its misalignment.
    pub registration: RegistrationMode,
    /// Time between two detections of one target, seconds.
    pub period_s: f64,
}

/// A transponder receiver.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    /// Standard deviation of a reported position over ground, each axis, metres.
    pub horizontal_m: f64,
    /// Standard deviation of a reported height, metres.
    pub vertical_m: f64,
    /// Delay of a report's time stamp behind the measurement of its position, seconds; `None`: learnt with the radars'
    /// registration.
    pub delay_s: Option<f64>,
    /// Time between two reports of one transponder, seconds; 0 if not known.
    pub period_s: f64,
    /// Long-run limit of previously unknown identities admitted, per second; at least 1.
    pub max_new_per_s: u32,
}

/// What is done about a radar's misalignment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegistrationMode {
    /// Nothing.
    Off,
    /// It is estimated; plots stay as they are.
    Propose,
    /// It is estimated, and plots are corrected.
    Apply,
}

/// Why an engine cannot work with its [`Settings`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The latency is not shorter than the window, or too short for the profile.
    #[error(
        "a latency of {latency_slots} slots is not between {least} and {window_slots}, the window, less 1"
    )]
    Latency {
        /// [`Settings::latency_slots`].
        latency_slots: i64,
        /// The shortest latency of the profile.
        least: i64,
        /// [`Settings::window_slots`].
        window_slots: i64,
    },
    /// The window and the reports that wait ahead of it are too long.
    #[error("window and reports ahead of it take {0} slots, and {RING} is the most")]
    Window(i64),
    /// A number is outside its range.
    #[error("{name} = {value} is not {range}")]
    Number {
        /// The field.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            grid: SlotGrid::default(),
            latency_slots: 25,
            window_slots: 100,
            max_future: SignedDuration::from_secs(1),
            sensors: Vec::new(),
            transponder_numbers: BTreeMap::new(),
            profile: Profile::Operational(OperationalRules::default()),
        }
    }
}

impl Default for ReferenceRules {
    fn default() -> Self {
        Self {
            max_gap: SignedDuration::from_secs(25),
            threshold: Threshold { rows: vec![(333.33, 60.0), (4333.33, 300.0)] },
            min_ratio_ppm: 900_000,
            min_samples: 4,
            weights: Weights { radar: 1.0, transponder: 10.0 },
            radar_only_min_s: 8.0,
            suppress_slots: 16,
        }
    }
}

impl Default for OperationalRules {
    fn default() -> Self {
        Self {
            dynamics: Dynamics::Imm(Models::default()),
            max_gap: SignedDuration::from_secs(8),
            now: true,
            threads: NonZeroUsize::MIN,
            integrity: IntegrityRules::default(),
        }
    }
}

/// At the origin, with an accuracy of 5 m, 1° and 10 m to start from, four detections per second, and registration applied.
impl Default for Radar {
    fn default() -> Self {
        Self {
            frame: RadarFrame::parallel(Enu::new(0.0, 0.0, 0.0)),
            errors: RadarErrors::of_data_sheet(5.0, 1.0, 10.0),
            learns_accuracy: true,
            registration: RegistrationMode::Apply,
            period_s: 0.25,
        }
    }
}

/// 3 m over ground, 5 m in height, an unknown delay and period, at most 50 new identities per second.
impl Default for Receiver {
    fn default() -> Self {
        Self { horizontal_m: 3.0, vertical_m: 5.0, delay_s: None, period_s: 0.0, max_new_per_s: 50 }
    }
}

impl Settings {
    /// Adds a radar; its plots carry this index.
    pub fn add_radar(&mut self, radar: Radar) -> SensorIndex {
        self.add(Sensor::Radar(radar))
    }

    /// Adds a transponder receiver; its fixes carry this index.
    pub fn add_receiver(&mut self, receiver: Receiver) -> SensorIndex {
        self.add(Sensor::Receiver(receiver))
    }

    /// Adds a camera; its bearings carry this index.
    pub fn add_camera(&mut self, camera: Camera) -> SensorIndex {
        self.add(Sensor::Camera(camera))
    }

    fn add(&mut self, sensor: Sensor) -> SensorIndex {
        self.sensors.push(sensor);
        SensorIndex((self.sensors.len() - 1) as u16)
    }

    /// Whether an engine can work with these.
    pub(crate) fn check(&self) -> Result<(), SettingsError> {
        let Self { latency_slots, window_slots, .. } = *self;
        let least = match self.profile {
            Profile::Operational(_) => 0,
            // Before, the slot is not over.
            Profile::Reference(_) => 1,
        };
        if !(least..window_slots).contains(&latency_slots) {
            return Err(SettingsError::Latency { latency_slots, least, window_slots });
        }
        // The ring also holds the slot that is about to leave the window.
        let held = 1 + window_slots + self.waiting_slots();
        if held > RING as i64 {
            return Err(SettingsError::Window(held));
        }
        if let Profile::Reference(ReferenceRules { weights, .. }) = &self.profile {
            not_negative("weights.radar", weights.radar)?;
            not_negative("weights.transponder", weights.transponder)?;
            above_zero("weights.radar + weights.transponder", weights.radar + weights.transponder)?;
        }
        if let Profile::Operational(OperationalRules { integrity, .. }) = &self.profile {
            let IntegrityRules { on, off, alert_limit_m, .. } = *integrity;
            not_negative("integrity.off", off)?;
            above_zero("integrity.on - integrity.off", on - off)?;
            above_zero("integrity.alert_limit_m", alert_limit_m)?;
        }
        self.sensors.iter().try_for_each(Sensor::check)
    }

    /// Length of the window.
    pub(crate) fn window(&self) -> SignedDuration {
        self.grid.slot() * self.window_slots as i32
    }

    /// How long before its deadline a slot is made, from what was received by then: the deadline waits for no arithmetic.
    /// Two fifths of a slot; nothing in the `reference` profile, where the deadline itself counts.
    pub fn lead(&self) -> SignedDuration {
        match self.profile {
            Profile::Operational(_) => self.grid.slot() * 2 / 5,
            Profile::Reference(_) => SignedDuration::ZERO,
        }
    }

    /// For so many slots after the one of the last report something is worth showing: none at the usual latency.
    pub(crate) fn lasting_slots(&self) -> i64 {
        match self.profile {
            Profile::Reference(_) => 0,
            Profile::Operational(_) => {
                let decided_slots = DECIDED_AFTER.as_nanos() / self.grid.slot().as_nanos();
                (decided_slots as i64 - self.latency_slots).max(0)
            }
        }
    }

    /// Slots ahead of the window that a report may be of.
    pub(crate) fn waiting_slots(&self) -> i64 {
        (self.max_future.as_nanos() / self.grid.slot().as_nanos()) as i64 + 1
    }
}

impl Sensor {
    fn check(&self) -> Result<(), SettingsError> {
        match self {
            Self::Radar(Radar { errors, period_s, .. }) => {
                above_zero("errors.bias_range_m", errors.bias_range_m)?;
                above_zero("errors.bias_azimuth", errors.bias_azimuth)?;
                above_zero("errors.bias_height_m", errors.bias_height_m)?;
                above_zero("errors.noise_range_m", errors.noise_range_m)?;
                above_zero("errors.noise_azimuth", errors.noise_azimuth)?;
                above_zero("errors.noise_height_m", errors.noise_height_m)?;
                above_zero("errors.correlation_s", errors.correlation_s)?;
                not_negative("period_s", *period_s)
            }
            Self::Receiver(Receiver { horizontal_m, vertical_m, delay_s, period_s, max_new_per_s }) => {
                above_zero("horizontal_m", *horizontal_m)?;
                above_zero("vertical_m", *vertical_m)?;
                not_negative("delay_s", delay_s.unwrap_or(0.0))?;
                not_negative("period_s", *period_s)?;
                above_zero("max_new_per_s", f64::from(*max_new_per_s))
            }
            Self::Camera(Camera { azimuth, elevation, .. }) => {
                above_zero("azimuth", *azimuth)?;
                above_zero("elevation", *elevation)
            }
        }
    }
}

fn above_zero(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let range = "a finite number above 0";
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(SettingsError::Number { name, value, range }) }
}

fn not_negative(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let range = "a finite number, 0 or more";
    if value.is_finite() && value >= 0.0 { Ok(()) } else { Err(SettingsError::Number { name, value, range }) }
}

/// The association threshold D(ρ): piecewise linear in slant range, constant beyond its ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Threshold {
    /// Slant range and distance, metres; ranges increase.
    rows: Vec<(f64, f64)>,
}

impl Threshold {
    /// From rows of slant range and distance, metres; `None` without a row, or where ranges do not increase.
    pub fn new(rows: Vec<(f64, f64)>) -> Option<Self> {
        let increasing = rows.windows(2).all(|pair| pair[0].0 < pair[1].0);
        (!rows.is_empty() && increasing).then_some(Self { rows })
    }

    /// D at a slant range, metres.
    pub fn at(&self, slant_range_m: f64) -> f64 {
        let above = self.rows.partition_point(|&(range, _)| range <= slant_range_m);
        if above == 0 {
            return self.rows[0].1;
        }
        let (range, distance) = self.rows[above - 1];
        match self.rows.get(above) {
            Some(&(next_range, next_distance)) => {
                distance + (next_distance - distance) * (slant_range_m - range) / (next_range - range)
            }
            None => distance,
        }
    }

    /// The slant ranges between which D is linear, metres.
    pub fn corners(&self) -> impl Iterator<Item = f64> {
        self.rows.iter().map(|row| row.0)
    }

    /// The largest D, metres.
    pub fn widest_m(&self) -> f64 {
        self.rows.iter().map(|row| row.1).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_is_linear_between_its_rows_and_constant_beyond() {
        let threshold = Threshold::new(vec![(0.0, 60.0), (333.33, 60.0), (4333.33, 300.0)]).unwrap();
        for (range, expected) in
            [(1.0, 60.0), (333.33, 60.0), (2333.33, 180.0), (4333.33, 300.0), (9000.0, 300.0)]
        {
            assert!((threshold.at(range) - expected).abs() < 1e-9, "{range}");
        }
        assert_eq!(threshold.widest_m(), 300.0);
        assert_eq!(Threshold::new(vec![]), None);
        assert_eq!(Threshold::new(vec![(5.0, 1.0), (5.0, 2.0)]), None);
    }
}
