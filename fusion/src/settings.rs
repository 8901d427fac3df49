//! The settings of an engine: slots, sensors, and the rules of a profile.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

pub use crate::filter::{Dynamics, Model, Models, RadarErrors, Singer};
use crate::frames::{Enu, RadarFrame};
pub use crate::integrity::{Action, IntegrityRules};
use crate::report::SensorIndex;
use crate::slots::{RING, SlotGrid};

/// Minimum time from a slot's opening to its association, whatever the latency. Later reports reveal walk-offs and exchanged
/// track numbers, and late reports arrive in time. With 3.25 s, eight seeds of `crossing` and `dense` had errors larger by 2 to
/// 6 % at every shorter latency.
pub(crate) const DECIDED_AFTER: SignedDuration = SignedDuration::from_millis(6250);

/// Slots, sensors and profile. The default has slots of 0.25 s, a latency of 6.25 s, the [`Profile::Operational`] and
/// no sensors; add them with [`Settings::add_radar`], [`Settings::add_receiver`] and [`Settings::add_camera`].
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
    /// The slots. The durations below are whole slots where possible, so that no two modules round differently.
    pub grid: SlotGrid,
    /// Latency: time from a slot's start to its emission, in slots (25: 6.25 s).
    pub latency_slots: i64,
    /// Length of the window, in slots (100: 25 s). An older report is refused.
    pub window_slots: i64,
    /// How far a report's time may be ahead of its reception (1 s).
    pub max_future: SignedDuration,
    /// The sensors, by [`SensorIndex`].
    pub sensors: Vec<Sensor>,
    /// Track numbers reserved for transponders, by trimmed serial number.
    pub transponder_numbers: BTreeMap<Vec<u8>, u32>,
    /// The rules by which reports become points.
    pub profile: Profile,
}

/// The rules by which reports become points.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// The rules of the paper: association by distance threshold and ratio, weighted mean.
    Reference(ReferenceRules),
    /// One target per aircraft, associated by likelihood, filtered and smoothed.
    Operational(OperationalRules),
}

/// Parameters of [`Profile::Reference`], named as in the paper (`docs/ALGORITHM.md`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceRules {
    /// Longest gap between two reports of a transponder across which it is interpolated (25 s).
    pub max_gap: SignedDuration,
    /// Distance D(ρ) within which radar and transponder agree.
    pub threshold: Threshold,
    /// Minimum ratio for an association, in millionths (900,000): the share of slots within the threshold among those
    /// in which both are present.
    pub min_ratio_ppm: u64,
    /// Minimum number of slots in which both are present (4).
    pub min_samples: u32,
    /// Weights of a fused position.
    pub weights: Weights,
    /// A radar track without a transponder is published once it was a UAV for longer than this, seconds (8).
    pub radar_only_min_s: f64,
    /// A transponder without a radar track is withheld for this many slots around an association (16: 4 s).
    pub suppress_slots: i64,
}

/// Weights of radar and transponder in a fused position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Weights {
    /// Weight of the radar (1).
    pub radar: f64,
    /// Weight of the transponder (10).
    pub transponder: f64,
}

/// Parameters of [`Profile::Operational`].
#[derive(Clone, Debug, PartialEq)]
pub struct OperationalRules {
    /// Motion models of drones.
    pub dynamics: Dynamics,
    /// Longest gap between two reports of a transponder across which it is compared with radar tracks (8 s).
    pub max_gap: SignedDuration,
    /// Whether each deadline also returns the predicted current positions of aircraft (yes).
    pub now: bool,
    /// Number of threads that share the work of a slot with much traffic (1). It does not change the output.
    pub threads: NonZeroUsize,
    /// Rules for the integrity of transponders.
    pub integrity: IntegrityRules,
}

/// A sensor.
#[derive(Clone, Debug, PartialEq)]
pub enum Sensor {
    /// A radar, which sends plots.
    Radar(Radar),
    /// A transponder receiver, which sends fixes.
    Receiver(Receiver),
    /// A camera, which sends bearings; the `reference` profile ignores them.
    Camera(Camera),
}

/// A camera: an EO/IR head that measures angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position in the site's frame.
    pub position: Enu,
    /// Standard deviation of an azimuth, radians.
    pub azimuth: f64,
    /// Standard deviation of an elevation, radians.
    pub elevation: f64,
    /// Standard deviation of the configured orientation about each axis, radians; 0: it is exact.
    pub orientation: f64,
}

/// A radar.
#[derive(Clone, Debug, PartialEq)]
pub struct Radar {
    /// Position and axes.
    pub frame: RadarFrame,
    /// Errors of the aligned radar.
    pub errors: RadarErrors,
    /// Whether `errors` are only initial values: the errors, and whether the radar's velocities are usable, are then
    /// learnt from its tracks. Otherwise `errors` stay as they are.
    pub learns_accuracy: bool,
    /// Handling of the radar's misalignment.
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
    /// Delay of a report's time stamp behind the measurement of its position, seconds; `None`: it is estimated together
    /// with the radars' registration.
    pub delay_s: Option<f64>,
    /// Time between two reports of one transponder, seconds; 0: not known.
    pub period_s: f64,
    /// Long-run limit of new identities admitted, per second; at least 1.
    pub max_new_per_s: u32,
}

/// Handling of a radar's misalignment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegistrationMode {
    /// The misalignment is not estimated.
    Off,
    /// The misalignment is estimated, but plots are not corrected.
    Propose,
    /// The misalignment is estimated, and plots are corrected.
    Apply,
}

/// Error in the [`Settings`] of an engine.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The latency is not shorter than the window, or is too short for the profile.
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
    /// The window and the reports that wait ahead of it do not fit the ring of slots.
    #[error("window and reports ahead of it take {0} slots, and {RING} is the most")]
    Window(i64),
    /// A number is outside its range.
    #[error("{name} = {value} is not {range}")]
    Number {
        /// Name of the field.
        name: &'static str,
        /// Value of the field.
        value: f64,
        /// Permitted range.
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

/// A radar at the origin with an initial accuracy of 5 m, 1° and 10 m, four detections per second, and registration
/// applied.
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

    /// Checks that an engine can work with these settings.
    pub(crate) fn check(&self) -> Result<(), SettingsError> {
        let Self { latency_slots, window_slots, .. } = *self;
        let least = match self.profile {
            Profile::Operational(_) => 0,
            // Earlier the slot has not ended.
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

    /// Time between making a slot and its deadline. A slot is made from what was received by then, so that the deadline
    /// does not wait for the computation. Two fifths of a slot; zero in the `reference` profile, where the deadline
    /// itself counts.
    pub fn lead(&self) -> SignedDuration {
        match self.profile {
            Profile::Operational(_) => self.grid.slot() * 2 / 5,
            Profile::Reference(_) => SignedDuration::ZERO,
        }
    }

    /// Number of slots after the last report's slot that are still worth a picture; zero at the usual latency.
    pub(crate) fn lasting_slots(&self) -> i64 {
        match self.profile {
            Profile::Reference(_) => 0,
            Profile::Operational(_) => {
                let decided_slots = DECIDED_AFTER.as_nanos() / self.grid.slot().as_nanos();
                (decided_slots as i64 - self.latency_slots).max(0)
            }
        }
    }

    /// Number of slots ahead of the window for which reports are accepted.
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
    /// Pairs of slant range and distance, metres; the ranges increase.
    rows: Vec<(f64, f64)>,
}

impl Threshold {
    /// Creates a threshold from pairs of slant range and distance, metres; `None` if there are none, or if ranges do
    /// not increase.
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
