//! Registration of the radars, for the interfaces.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tracing::info;

use super::learning::{VelocityUse, velocity_errors};
use fusion::Engine;
use fusion::frames::{AtRadar, Enu, Geodetic, TangentPlane};
use fusion::learning::LearntRadar;
use fusion::operational::Relocation;
use fusion::operational::{OrientedCamera, Step};
use fusion::registration::{BiasValue, Creep, Displacement, Misalignment};
use fusion::time::{SECOND, Time};
use site::config::{Config, Profile, Radar, Registration as Mode, SensorKind};

/// Time for which a step or a turned camera raises an alert, in nanoseconds.
const STEP_NS: u64 = 3600 * SECOND as u64;

/// Registration of a radar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegistrationStatus {
    /// Use of the registration.
    pub mode: Mode,
    /// Estimate from the radar's tracks; `None` if registration is off, and before the first slot.
    pub estimate: Option<Misalignment>,
    /// Minutes of aircraft that other radars see as well, on which bearing and range also rest.
    pub shared_minutes: Option<f64>,
    /// Learned errors; `None` if learning is off, and before the first slot.
    pub learnt: Option<LearntRadar>,
    /// Where it stands according to its tracks, relative to the position that is used.
    pub place: Option<PlaceStatus>,
    /// Where an operator moved it.
    pub relocated: Option<RelocatedRadar>,
    /// Latest step since the start.
    pub step: Option<Step>,
    /// Number of steps since the start.
    pub steps: u64,
    /// Text of the alert about a step, until the step is an hour old.
    pub alarm: Option<String>,
}

/// A radar that an operator moved from its configured position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RelocatedRadar {
    /// The correction of what is configured.
    pub by: Relocation,
    /// Latitude and longitude that are used, degrees.
    pub latitude_longitude_deg: [f64; 2],
}

impl RelocatedRadar {
    fn of(radar: &Radar, by: Relocation) -> Self {
        Self { by, latitude_longitude_deg: moved(radar, by) }
    }
}

/// Latitude and longitude of a radar that stands elsewhere than configured, degrees.
fn moved(radar: &Radar, by: Relocation) -> [f64; 2] {
    let configured = Geodetic::from_degrees(radar.latitude_deg, radar.longitude_deg, radar.height_amsl_m);
    let there = TangentPlane::<AtRadar>::at(configured).to_geodetic(Enu::new(by.east_m, by.north_m, 0.0));
    [there.latitude.to_degrees(), there.longitude.to_degrees()]
}

/// Where a radar stands according to its tracks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaceStatus {
    /// East of the position that is used, and standard deviation, metres.
    pub east_m: [f64; 2],
    /// North of it.
    pub north_m: [f64; 2],
    /// Latitude and longitude, degrees.
    pub latitude_longitude_deg: [f64; 2],
    /// The `bearing_correction_deg` that belongs to it.
    pub bearing_correction_deg: f64,
    /// Time of the tracks on which it rests, in minutes of one drone.
    pub drone_minutes: f64,
    /// Whether the tracks contradict the position that is used.
    pub contradicts: bool,
}

impl PlaceStatus {
    /// The status of a radar that was relocated by `used`.
    fn of(radar: &Radar, used: Relocation, found: &Displacement) -> Self {
        let to = used.beyond(found);
        let with_sigma = |value, axis| [value, found.covariance_m2[(axis, axis)].sqrt()];
        Self {
            east_m: with_sigma(found.east_m, 0),
            north_m: with_sigma(found.north_m, 1),
            latitude_longitude_deg: moved(radar, to),
            bearing_correction_deg: radar.bearing_correction_deg - to.bearing.to_degrees(),
            drone_minutes: found.drone_minutes,
            contradicts: found.contradicts,
        }
    }

    /// Text of the alert about a radar that does not stand where it is configured; `None` if it does.
    fn alarm(&self) -> Option<String> {
        let Self { east_m: [east_m, _], north_m: [north_m, _], drone_minutes, .. } = *self;
        let [latitude_deg, longitude_deg] = self.latitude_longitude_deg;
        let sigma_m = self.east_m[1].max(self.north_m[1]);
        self.contradicts.then(|| {
            format!(
                "its tracks of {drone_minutes:.0} drone-minutes contradict its position: it stands {:.0} ± {sigma_m:.0} m away, at \
                 {latitude_deg:.6}, {longitude_deg:.6} (bearing_correction_deg {:.2}). If it was moved, or its position was \
                 mistyped, apply this position (in the radar's panel of the map; one click undoes it), and then set it in the \
                 configuration. If the radar stands where it should, check the positions of the transponders",
                east_m.hypot(north_m),
                self.bearing_correction_deg,
            )
        })
    }
}

impl RegistrationStatus {
    /// Whether any estimated value corrects the plots.
    pub fn is_applied(&self) -> bool {
        let is_observable =
            |estimate: &Misalignment| values(estimate).iter().any(|(.., value)| value.observable);
        self.mode == Mode::Apply && self.estimate.as_ref().is_some_and(is_observable)
    }

    /// Remark that raises no alert.
    pub fn hint(&self) -> Option<String> {
        let estimate = self.estimate.as_ref().filter(|estimate| estimate.doubtful())?;
        Some(format!(
            "doubtful: its tracks differ from one another more than its errors, as they are configured, let expect (residual \
             {:.1}); look for a wrong accuracy in the configuration, for a radar that moves, for transponders that err",
            estimate.residual.unwrap_or_default()
        ))
    }

    /// Text of the alert about a creeping bearing.
    pub fn creep_alarm(creep: &Creep) -> String {
        let host = match creep.host {
            Some(host) => host.to_string(),
            None => "several hosts".to_owned(),
        };
        format!(
            "the bearing that transponders reported by {host} show turned by {:+.1}° in {:.0} s, all alike: a radar that is fixed \
             does not. What was learnt since is dropped, its bearing stays at {:+.1}°, and nothing more is learnt from this \
             host until the service is restarted, except of transponders that an operator trusts. Look 1. whether it is a \
             receiver of yours, and whether its transponders are there; 2. whether the radar turns on its mount",
            (creep.rate * creep.window_s).to_degrees(),
            creep.window_s,
            creep.bearing.value.to_degrees(),
        )
    }

    /// Text of the alert about a step; `None` if the step is more than an hour old.
    pub fn alarm(step: &Step, now: Time) -> Option<String> {
        if now.nanos().abs_diff(step.time.nanos()) > STEP_NS {
            return None;
        }
        let (before, after) = (values(&step.before), values(&step.after));
        let shown = before.iter().zip(&after).filter(|((name, ..), _)| STEPPING.contains(name));
        let shown: Vec<String> = shown
            .map(|((name, unit, before), (.., after))| {
                format!("{name} {:+.1} then {:+.1}{unit}", before.value, after.value)
            })
            .collect();
        Some(format!(
            "its latest tracks tell another set-up than those before, and its registration begins anew with them: {}. Look \
             1. whether it was moved, knocked, put back or set anew: then this is right, and nothing is to be done; \
             2. whether its clock or height reference changed, and whether other radars are alarmed too: then it is the \
             transponders; 3. neither: set registration = \"propose\" until you know",
            shown.join(", ")
        ))
    }
}

/// Text of the alert about a camera that was turned; `None` if it was not, or more than an hour ago.
pub(super) fn turned_camera(oriented: &OrientedCamera, now: Time) -> Option<String> {
    let turned = oriented.turned.filter(|turned| now.nanos().abs_diff(turned.nanos()) <= STEP_NS)?;
    let found = oriented.orientation.misalignment();
    let value = |name, value: BiasValue| format!("{name} {:+.1}°", value.value.to_degrees());
    Some(format!(
        "since {turned} its bearings contradict the orientation known before. It is learnt again: {}, {}, {}. If it \
         was turned, moved or given a new setting, this is right, and nothing is to be done. Otherwise check its mount and its clock",
        value("bearing", found.bearing),
        value("tilt east", found.tilt_east),
        value("tilt north", found.tilt_north),
    ))
}

/// Values in which steps are detected.
const STEPPING: [&str; 3] = ["bearing", "range", "height"];

/// The values with names and units, angles in degrees.
pub fn values(estimate: &Misalignment) -> [(&'static str, &'static str, BiasValue); 6] {
    let degrees = |value: BiasValue| BiasValue {
        value: value.value.to_degrees(),
        deviation: value.deviation.to_degrees(),
        observable: value.observable,
    };
    [
        ("bearing", "°", degrees(estimate.bearing)),
        ("tilt east", "°", degrees(estimate.tilt_east)),
        ("tilt north", "°", degrees(estimate.tilt_north)),
        ("range", " m", estimate.range_m),
        ("height", " m", estimate.height_m),
        ("time", " s", estimate.time_s),
    ]
}

/// Follows the registrations of the radars.
#[derive(Debug)]
pub(super) struct Registrar {
    /// Mode by sensor; `None` for all sensors but radars in the operational profile.
    modes: Vec<Option<Mode>>,
    /// Radars by sensor.
    radars: Vec<Option<Radar>>,
    /// Time of each radar's latest step, and the number of steps.
    steps: BTreeMap<usize, (Time, u64)>,
    /// Ids by sensor, for the log, and the last logged use of each radar's velocities.
    ids: Vec<String>,
    verdicts: BTreeMap<usize, &'static str>,
}

impl Registrar {
    pub(super) fn new(config: &Config) -> Self {
        let mode = |sensor: &site::config::Sensor| match &sensor.kind {
            SensorKind::Radar(radar) if config.fusion.profile == Profile::Operational => {
                Some(radar.registration)
            }
            _ => None,
        };
        Self {
            modes: config.sensors.iter().map(mode).collect(),
            radars: config.sensors.iter().map(|sensor| sensor.kind.radar().cloned()).collect(),
            steps: BTreeMap::new(),
            ids: config.sensors.iter().map(|sensor| sensor.id.clone()).collect(),
            verdicts: BTreeMap::new(),
        }
    }

    /// Registration status by sensor.
    pub(super) fn statuses(&mut self, engine: &Engine, now: Time) -> Vec<Option<RegistrationStatus>> {
        let status = |&mode: &Option<Mode>| {
            Some(RegistrationStatus {
                mode: mode?,
                estimate: None,
                shared_minutes: None,
                learnt: None,
                place: None,
                relocated: None,
                step: None,
                steps: 0,
                alarm: None,
            })
        };
        let mut statuses: Vec<_> = self.modes.iter().map(status).collect();
        let relocated = engine.relocations();
        for (sensor, registered) in engine.registered() {
            let index = usize::from(sensor.0);
            let Some(Some(status)) = statuses.get_mut(index) else { continue };
            status.estimate = Some(registered.estimate);
            status.shared_minutes = registered.by_radars().map(|learnt| learnt.minutes);
            status.learnt = registered.learnt;
            if let (Some(learnt), Some(id)) = (&registered.learnt, self.ids.get(index)) {
                let verdict = VelocityUse::from(&learnt.velocity).name();
                if self.verdicts.insert(index, verdict).unwrap_or("unknown") != verdict {
                    let off_m_s = velocity_errors(&learnt.velocity).map(|errors| errors.sigma_m_s);
                    info!(radar = %id, verdict, off_m_s, "velocities of a radar are judged anew");
                }
            }
            if let Some(radar) = self.radars.get(index).and_then(Option::as_ref) {
                let by = relocated.iter().find(|active| active.radar == sensor).map(|active| active.to);
                status.relocated = by.map(|by| RelocatedRadar::of(radar, by));
                let found = registered.place();
                status.place = found.map(|found| PlaceStatus::of(radar, by.unwrap_or_default(), found));
            }
            status.alarm = registered.creep().map(|creep| RegistrationStatus::creep_alarm(&creep));
            status.alarm = status.alarm.take().or_else(|| status.place.as_ref()?.alarm());
            status.step = registered.step;
            if let Some(step @ Step { time, .. }) = registered.step {
                status.alarm = status.alarm.take().or_else(|| RegistrationStatus::alarm(&step, now));
                let (latest, count) = self.steps.entry(index).or_insert((time, 1));
                if *latest != time {
                    (*latest, *count) = (time, *count + 1);
                }
                status.steps = *count;
            }
        }
        statuses
    }
}
