//! How each radar is set up: what its tracks of equipped drones tell, and what of it is taken away from plots.

use super::settings::{Radar, Settings};
use super::target::Target;
use super::tracklet::Seen;
use super::{Moment, Operational};
use crate::filter::RadarErrors;
use crate::frames::Enu;
use crate::registration::{
    Correction, Misalignment, Registration, RegistrationState, RegistrationStateError, Residual, Taken,
    TrackComparison,
};
use crate::report::{Plot, SensorIndex};
use crate::settings::RegistrationMode;
use crate::time::{SECOND, Time};

/// A radar track tells of the registration in pieces of so many seconds, so that what turns out to be another drone spoils
/// no more than one of them.
const PIECE_S: f64 = 10.0;
/// Until the tracks tell, a radar is set up by compass and spirit level, one standard deviation: metres, radians, metres.
const SET_UP: (f64, f64, f64) = (5.0, 1.0_f64.to_radians(), 5.0);
/// Before radars tell of it, transponders' reports are stamped so late: mean and one standard deviation, seconds. Receivers
/// measure four to ten times a second, and what is sent has waited for its turn.
const DELAY_S: (f64, f64) = (0.1, 0.1);
/// Where what is left of a wrong set-up is told for all of a radar's tracks: north of it, metres over ground and up.
const THERE_M: (f64, f64) = (1500.0, 100.0);
/// Seconds to either side over which a transponder's velocity is taken.
const ASIDE_S: f64 = 0.5;

/// One radar's registration.
#[derive(Clone, Debug)]
pub struct Registered {
    registration: Registration,
    correction: Correction,
    /// What the tracks tell so far.
    pub estimate: Misalignment,
    /// The latest step.
    pub step: Option<Step>,
}

/// The latest tracks told something else than those before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// When it was found out.
    pub time: Time,
    /// What was estimated before.
    pub before: Misalignment,
    /// What the latest tracks tell.
    pub after: Misalignment,
}

impl Registered {
    fn new(registration: Registration) -> Self {
        let estimate = registration.estimate();
        Self { registration, correction: Correction::of(&estimate), estimate, step: None }
    }

    /// All that outlives a restart.
    pub fn to_state(&self) -> RegistrationState {
        self.registration.to_state()
    }

    /// A plot as it would be if the radar were set up rightly, as far as that is known and is to be applied.
    pub(super) fn correct(&self, mut plot: Plot, radar: &Radar) -> Plot {
        if radar.registration == RegistrationMode::Apply {
            let seen = plot.position.0 - radar.position.0;
            let right = match plot.height_measured {
                true => self.correction.apply(seen),
                false => self.correction.apply_without_height(seen),
            };
            plot.position = Enu(radar.position.0 + right);
        }
        plot
    }

    /// What a piece of a radar track told.
    pub(super) fn take(&mut self, along: &mut TrackComparison) {
        let Some(sample) = along.take() else { return };
        if let Taken::Step { before, after } = self.registration.take(&sample) {
            self.step = Some(Step { time: sample.time(), before, after });
        }
        self.estimate = self.registration.estimate();
        self.correction = Correction::of(&self.estimate);
    }

    /// The radar's errors, with what is left of a wrong set-up.
    fn errors(&self, radar: &Radar) -> RadarErrors {
        let place = nalgebra::Vector3::new(0.0, THERE_M.0, THERE_M.1);
        let left = self.correction.remaining(place);
        let (range_m, azimuth, height_m) = match radar.registration {
            RegistrationMode::Apply => {
                (left.range_m.min(SET_UP.0), left.azimuth.min(SET_UP.1), left.height_m.min(SET_UP.2))
            }
            RegistrationMode::Off | RegistrationMode::Propose => SET_UP,
        };
        RadarErrors {
            bias_range_m: in_steps(radar.track_errors.bias_range_m.hypot(range_m)),
            bias_azimuth: in_steps(radar.track_errors.bias_azimuth.hypot(azimuth)),
            bias_height_m: in_steps(radar.track_errors.bias_height_m.hypot(height_m)),
            ..radar.track_errors
        }
    }
}

/// A deviation to the nearest hundredth of it: what was filtered with one that hardly changed need not be filtered anew.
fn in_steps(deviation: f64) -> f64 {
    const STEP: f64 = 0.01;
    ((deviation.ln() / STEP).round() * STEP).exp()
}

impl Operational {
    /// What is known of each radar that is registered.
    pub(crate) fn registered(&self) -> impl Iterator<Item = (SensorIndex, &Registered)> {
        self.registered.iter().map(|(&sensor, registered)| (sensor, registered))
    }

    /// Goes on where an earlier life ended.
    pub(crate) fn restore(
        &mut self,
        sensor: SensorIndex,
        state: &RegistrationState,
    ) -> Result<(), RegistrationStateError> {
        let registration = Registration::from_state(state)?;
        self.registered.insert(sensor, Registered::new(registration));
        Ok(())
    }

    /// Goes on with what was known of the radars before a fresh start.
    pub(crate) fn inherit(&mut self, before: Self) {
        self.registered = before.registered;
    }

    /// The settings with what the registration tells now: errors and delays.
    pub(super) fn registered_settings(&mut self, settings: &Settings) -> Settings {
        let mut now = settings.clone();
        let (mut information, mut vector) = (DELAY_S.1.powi(-2), DELAY_S.0 * DELAY_S.1.powi(-2));
        for (index, radar) in now.radars.iter_mut().enumerate() {
            let Some(radar) = radar.as_mut().filter(|radar| radar.registration != RegistrationMode::Off)
            else {
                continue;
            };
            let registered = self
                .registered
                .entry(SensorIndex(index as u16))
                .or_insert_with(|| Registered::new(Registration::new()));
            radar.errors = registered.errors(radar);
            if radar.registration == RegistrationMode::Apply {
                let told = registered.estimate.told_of_time();
                information += told.0;
                vector += told.1;
            }
        }
        // What radars tell of time is the transponders': radars have clocks to go by, a transponder's time is that of its
        // transmission. Nothing is sent before it is measured.
        let learnt_s = (vector / information).max(0.0);
        for receiver in now.transponders.iter_mut().flatten().filter(|receiver| receiver.delay_s.is_none()) {
            receiver.delay_s = Some(learnt_s);
            receiver.delay_sigma_s = information.powf(-0.5);
        }
        now
    }

    /// Compares radar tracks with the transponders they belong to, for the plots since the last slot.
    pub(super) fn register(&mut self, moment: &Moment, settings: &Settings) {
        let Self { tracklets, targets, registered, .. } = self;
        for tracklet in tracklets.values_mut() {
            let Some(radar) = settings.radar(tracklet.key.sensor) else { continue };
            let Some(registered) = registered.get_mut(&tracklet.key.sensor) else { continue };
            let known = tracklet.target.and_then(|id| Some((id, targets.get(&id)?)));
            let Some((id, target)) = known.filter(|(_, target)| target.transponder.is_some()) else {
                tracklet.compared = None;
                continue;
            };
            let mut compared = tracklet.compared.take().filter(|(with, _)| *with == id);
            let seen = tracklet.seen_between(moment.since, moment.time);
            for residual in seen.filter_map(|seen| residual(seen, target, radar, settings)) {
                // The radar's own errors: what is left of a wrong set-up is what is asked for.
                compared
                    .get_or_insert_with(|| (id, TrackComparison::new(&radar.track_errors)))
                    .1
                    .add(&residual);
            }
            if let Some((_, along)) = &mut compared
                && along.gathered_s() >= PIECE_S
            {
                registered.take(along);
            }
            tracklet.compared = compared;
        }
    }
}

/// A plot against where the target's transponder, whose time is taken as it is stamped, says it was.
fn residual(seen: &Seen, target: &Target, radar: &Radar, settings: &Settings) -> Option<Residual> {
    let receiver = settings.transponder(target.transponder.as_ref()?.sensor)?;
    let delay_s = receiver.delay_s.unwrap_or(0.0);
    let at = |after_s: f64| {
        let time = seen.plot.time.nanos() + ((after_s - delay_s) * SECOND as f64).round() as i64;
        target.on_curve(Time::from_nanos(time), settings)
    };
    let (here, before, after) = (at(0.0)?, at(-ASIDE_S)?, at(ASIDE_S)?);
    Some(Residual {
        time: seen.plot.time,
        plot: seen.raw.0 - radar.position.0,
        target: here.position.0 - radar.position.0,
        velocity: (after.position.0 - before.position.0) / (2.0 * ASIDE_S),
        height_measured: seen.plot.height_measured,
        sigma_m: here.sigma_m.hypot(receiver.horizontal_m),
    })
}
