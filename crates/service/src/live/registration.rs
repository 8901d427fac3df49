//! Registration of the radars, for the interfaces.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tracing::info;

use super::learning::{VelocityUse, velocity_errors};
use fusion::Engine;
use fusion::learning::LearntRadar;
use fusion::operational::{OrientedCamera, Step};
use fusion::registration::{BiasValue, Creep, Misalignment};
use fusion::time::{SECOND, Time};
use site::config::{Config, Profile, Registration as Mode, SensorKind};

/// Time for which a step or a turned camera raises an alert, in nanoseconds.
const STEP_NS: u64 = 3600 * SECOND as u64;

/// Registration of a radar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegistrationStatus {
    /// Use of the registration.
    pub mode: Mode,
    /// Estimate from the radar's tracks; `None` if registration is off, and before the first slot.
    pub estimate: Option<Misalignment>,
    /// Learned errors; `None` if learning is off, and before the first slot.
    pub learnt: Option<LearntRadar>,
    /// Latest step since the start.
    pub step: Option<Step>,
    /// Number of steps since the start.
    pub steps: u64,
    /// Text of the alert about a step, until the step is an hour old.
    pub alarm: Option<String>,
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
                learnt: None,
                step: None,
                steps: 0,
                alarm: None,
            })
        };
        let mut statuses: Vec<_> = self.modes.iter().map(status).collect();
        for (sensor, registered) in engine.registered() {
            let index = usize::from(sensor.0);
            let Some(Some(status)) = statuses.get_mut(index) else { continue };
            status.estimate = Some(registered.estimate);
            status.learnt = registered.learnt;
            if let (Some(learnt), Some(id)) = (&registered.learnt, self.ids.get(index)) {
                let verdict = VelocityUse::from(&learnt.velocity).name();
                if self.verdicts.insert(index, verdict).unwrap_or("unknown") != verdict {
                    let off_m_s = velocity_errors(&learnt.velocity).map(|errors| errors.sigma_m_s);
                    info!(radar = %id, verdict, off_m_s, "velocities of a radar are judged anew");
                }
            }
            status.alarm = registered.creep().map(|creep| RegistrationStatus::creep_alarm(&creep));
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
