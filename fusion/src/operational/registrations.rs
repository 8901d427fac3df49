//! How each radar is aligned: what its tracks of equipped drones tell, and the correction of its plots by that.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::cycle::Cycle;
use super::ids::{TargetId, TrackletId};
use super::likelihood::Scales;
use super::residuals::{compared, residuals, seen};
use super::settings::{Delay, Radar, Settings};
use super::shared;
use super::targets::{Target, Targets};
use super::tracklets::Tracklets;
use super::transponder_types::TransponderTypes;
use super::tuning::{
    CAUTIOUS_SAMPLES, DELAY_DEVIATIONS, DELAY_PRIOR_S, ERROR_STEP, MISALIGNMENT_AZIMUTH_RAD,
    MISALIGNMENT_HEIGHT_M, MISALIGNMENT_RANGE_M, RADAR_VELOCITY_M_S, REMAINING_AT_NORTH_M, REMAINING_AT_UP_M,
    SEGMENT_S,
};
use crate::filter::RadarErrors;
use crate::frames::Enu;
use crate::learning::{
    LearningState, LearningStateError, LearntAxis, LearntRadar, RadarLearning, RangeRate, TrackLearning,
    VelocityVerdict,
};
use crate::registration::{
    Checked, Correction, Creep, CreepGuard, DelaySums, Misalignment, Registration, RegistrationState,
    RegistrationStateError, Taken, TrackComparison,
};
use crate::report::{Host, Identity, Plot, SensorIndex, TransponderType};
use crate::settings::RegistrationMode;
use crate::time::Time;

/// One radar's registration, and its errors.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Registered {
    registration: Registration,
    learning: RadarLearning,
    /// The errors as they have shown themselves, those of the data sheet before; `None` where they are not learnt.
    pub learnt: Option<LearntRadar>,
    correction: Correction,
    /// What the tracks tell so far.
    pub estimate: Misalignment,
    /// The latest step.
    pub step: Option<Step>,
    guard: CreepGuard,
}

/// A step of the misalignment: the latest tracks contradict those before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// When it was detected.
    pub time: Time,
    /// The estimate before.
    pub before: Misalignment,
    /// The estimate from the latest tracks.
    pub after: Misalignment,
}

/// Of a radar of which nothing is known.
impl Default for Registered {
    fn default() -> Self {
        Self::new(Registration::default())
    }
}

/// What of a radar's registration is used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Applied {
    learnt: Option<LearntRadar>,
    correction: Correction,
}

/// Nothing is known.
impl Default for Applied {
    fn default() -> Self {
        Self { learnt: None, correction: Registered::default().correction }
    }
}

impl Registered {
    fn new(registration: Registration) -> Self {
        let estimate = registration.estimate();
        let learning = RadarLearning::default();
        Self {
            registration,
            learning,
            learnt: None,
            correction: Correction::of(&estimate),
            estimate,
            step: None,
            guard: CreepGuard::default(),
        }
    }

    /// The latest alarm that the bearing which some identities show creeps.
    pub fn creep(&self) -> Option<Creep> {
        self.guard.alarm()
    }

    /// All that outlives a restart.
    pub fn to_state(&self) -> RegistrationState {
        self.registration.to_state()
    }

    /// Takes in a segment of a radar track, and gives to its transponder's type what it shows of that.
    fn take(
        &mut self,
        segment: &mut Segment,
        types: &mut TransponderTypes,
    ) -> Option<(TargetId, SensorIndex, Time, Time)> {
        let mut sample = segment.along.take()?;
        sample.weaken(self.guard.weight(segment.host, sample.time()));
        self.learning.take(&mut segment.learning, sample.time());
        match self.registration.take(&sample) {
            Taken::Kept => {
                types.take_sample(segment.kind, segment.sensor, &sample);
                types.take_own_sample(segment.identity, segment.kind, segment.sensor, &sample);
            }
            Taken::Rejected => {}
            Taken::Step { before, after } => {
                self.step = Some(Step { time: sample.time(), before, after });
                types.forget_radar(segment.sensor);
            }
        }
        self.estimate();
        Some((segment.target, segment.sensor, sample.begun(), sample.time()))
    }

    /// Takes the track that began then out again.
    fn withdraw(&mut self, begun: Time) {
        self.registration.withdraw(begun);
        self.estimate();
    }

    fn estimate(&mut self) {
        self.estimate = self.guard.used(self.registration.estimate());
        self.correction = Correction::of(&self.estimate);
    }

    /// Looks whether what the transponders show of its bearing creeps; whether there is an alarm.
    fn check(&mut self, now: Time) -> bool {
        let checked = self.guard.check(&mut self.registration, now);
        if checked != Checked::Unchanged {
            self.estimate();
        }
        checked == Checked::Alarm
    }

    /// All that was learnt of its errors, to outlive a restart.
    pub fn learning_state(&self) -> LearningState {
        self.learning.to_state()
    }

    fn applied(&self) -> Applied {
        Applied { learnt: self.learnt, correction: self.correction }
    }
}

impl Applied {
    /// The radar as it has shown itself.
    fn apply_to(&self, radar: &mut Radar) {
        if let Some(learnt) = &self.learnt {
            let steps = |of: fn(&RadarErrors) -> f64| {
                let sheet = of(&radar.data_sheet);
                sheet * in_steps(of(&learnt.errors) / sheet)
            };
            let bias = |of: fn(&RadarErrors) -> f64, axis: &LearntAxis| {
                let sheet = of(&radar.data_sheet);
                sheet * in_steps(cautious(of(&learnt.errors) / sheet, axis.tracks))
            };
            radar.track_errors = RadarErrors {
                bias_range_m: bias(|errors| errors.bias_range_m, &learnt.range_m),
                bias_azimuth: bias(|errors| errors.bias_azimuth, &learnt.azimuth),
                bias_height_m: bias(|errors| errors.bias_height_m, &learnt.height_m),
                noise_range_m: steps(|errors| errors.noise_range_m),
                noise_azimuth: steps(|errors| errors.noise_azimuth),
                noise_height_m: steps(|errors| errors.noise_height_m),
                correlation_s: steps(|errors| errors.correlation_s),
            };
            radar.scales = Scales::of(learnt.unsure);
            radar.velocity_sigma_m_s = match learnt.velocity {
                VelocityVerdict::Used(errors) => Some(in_steps(errors.sigma_m_s.max(RADAR_VELOCITY_M_S))),
                VelocityVerdict::Unknown | VelocityVerdict::Ignored(_) => None,
            };
        }
        radar.errors = self.errors(radar);
    }

    /// The same with what is left of its misalignment.
    fn errors(&self, radar: &Radar) -> RadarErrors {
        let left = self.correction.remaining(Enu::new(0.0, REMAINING_AT_NORTH_M, REMAINING_AT_UP_M));
        let with = |bias: f64, left: f64, most: f64| match radar.registration {
            RegistrationMode::Apply => in_steps(bias.hypot(left.min(most))),
            RegistrationMode::Off | RegistrationMode::Propose => in_steps(bias.hypot(most)),
        };
        let errors = &radar.track_errors;
        RadarErrors {
            bias_range_m: with(errors.bias_range_m, left.range_m, MISALIGNMENT_RANGE_M),
            bias_azimuth: with(errors.bias_azimuth, left.azimuth, MISALIGNMENT_AZIMUTH_RAD),
            bias_height_m: with(errors.bias_height_m, left.height_m, MISALIGNMENT_HEIGHT_M),
            ..*errors
        }
    }
}

/// A bias over that of the data sheet, as far as so many independent samples let it be believed: that a radar is better than its
/// sheet, a few do not show, because what is off most has not been seen yet; that it is worse, they do.
fn cautious(of_sheet: f64, samples: f64) -> f64 {
    if of_sheet < 1.0 { of_sheet.powf(samples / (samples + CAUTIOUS_SAMPLES)) } else { of_sheet }
}

/// An error in relative steps.
fn in_steps(sigma: f64) -> f64 {
    ((sigma.ln() / ERROR_STEP).round() * ERROR_STEP).exp()
}

/// A part of a radar track that goes with a target.
#[derive(Debug, Serialize, Deserialize)]
struct Segment {
    sensor: SensorIndex,
    target: TargetId,
    host: Host,
    identity: Identity,
    kind: TransponderType,
    along: TrackComparison,
    learning: TrackLearning,
}

/// What a transponder has said so long before it is disbelieved is taken back, seconds.
const WITHDRAWN_S: f64 = 60.0;

/// The registrations of all radars.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Registrations {
    radars: BTreeMap<SensorIndex, Registered>,
    segments: BTreeMap<TrackletId, Segment>,
    /// What was taken in lately: from which target, for which radar, the beginning of the track's part, and when.
    lately: Vec<(TargetId, SensorIndex, Time, Time)>,
    /// Targets whose transponders are believed nothing.
    disbelieved: BTreeSet<TargetId>,
    /// Identities that an operator trusts: what they report counts, whatever their host.
    pub(super) trusted: BTreeSet<Identity>,
    /// Of radar tracks of which no transponder tells, where their radar tells velocities.
    rates: BTreeMap<TrackletId, RangeRate>,
    /// The transponders' delay as these radars show it.
    delay: Option<Delay>,
    /// What others have learnt; `None`: what it learns itself counts.
    pub(super) shared: Option<BTreeMap<SensorIndex, Applied>>,
}

impl Registrations {
    /// Each radar that is registered.
    pub(super) fn radars(&self) -> impl Iterator<Item = (SensorIndex, &Registered)> {
        self.radars.iter().map(|(&sensor, registered)| (sensor, registered))
    }

    /// Takes over a radar's registration of before a restart.
    pub(super) fn restore(
        &mut self,
        sensor: SensorIndex,
        state: &RegistrationState,
    ) -> Result<(), RegistrationStateError> {
        let registration = Registration::from_state(state)?;
        let learning = self.radars.remove(&sensor).map(|known| known.learning).unwrap_or_default();
        let mut registered = Registered { learning, ..Registered::new(registration) };
        registered.guard.restore(&registered.registration);
        self.radars.insert(sensor, registered);
        Ok(())
    }

    /// Takes over what was learnt of a radar's errors before a restart.
    pub(super) fn restore_learning(
        &mut self,
        sensor: SensorIndex,
        state: &LearningState,
    ) -> Result<(), LearningStateError> {
        let learning = RadarLearning::from_state(state)?;
        self.radars.entry(sensor).or_default().learning = learning;
        Ok(())
    }

    /// The same radars, without tracks.
    pub(super) fn without_tracks(self) -> Self {
        Self { radars: self.radars, shared: self.shared, ..Self::default() }
    }

    fn correction(&self, sensor: SensorIndex) -> Option<&Correction> {
        match &self.shared {
            Some(shared) => shared.get(&sensor).map(|applied| &applied.correction),
            None => self.radars.get(&sensor).map(|registered| &registered.correction),
        }
    }

    /// What was learnt of a radar.
    pub(super) fn learnt(&self, sensor: SensorIndex) -> Option<Applied> {
        self.radars.get(&sensor).map(Registered::applied)
    }

    /// What was learnt of the transponders' delay.
    pub(super) fn delay(&self) -> Option<Delay> {
        self.delay
    }

    /// A plot as an aligned radar would have it, as far as that is known and is to be applied.
    pub(super) fn correct(&self, mut plot: Plot, radar: &Radar) -> Plot {
        if radar.registration == RegistrationMode::Apply
            && let Some(correction) = self.correction(plot.track.sensor)
        {
            let seen = radar.frame.from_site(plot.position);
            let corrected = match plot.height_measured {
                true => correction.apply(seen),
                false => correction.apply_without_height(seen),
            };
            plot.position = radar.frame.to_site(corrected);
        }
        plot
    }

    /// The settings with what is known now: errors and delays.
    pub(super) fn settings(&mut self, settings: &Settings, types: &mut TransponderTypes) -> Settings {
        let mut now = settings.clone();
        let (mean_s, sigma_s) = DELAY_PRIOR_S;
        let (mut information, mut vector) = (sigma_s.powi(-2), mean_s * sigma_s.powi(-2));
        let mut applied: Vec<SensorIndex> = Vec::new();
        for (index, radar) in now.radars.iter_mut().enumerate() {
            let Some(radar) = radar.as_mut().filter(|radar| radar.registration != RegistrationMode::Off)
            else {
                continue;
            };
            let sensor = SensorIndex(index as u16);
            let registered = self.radars.entry(sensor).or_default();
            registered.learnt = radar.learns_accuracy.then(|| registered.learning.learnt(&radar.data_sheet));
            match &self.shared {
                Some(shared) => shared.get(&sensor).cloned().unwrap_or_default().apply_to(radar),
                None => registered.applied().apply_to(radar),
            }
            if radar.registration == RegistrationMode::Apply {
                let time = registered.estimate.time_information();
                information += time.inverse_variance;
                vector += time.weighted_mean;
                applied.push(sensor);
            }
        }
        // What radars show of time is the transponders' delay: radars have clocks to go by, a transponder's time is that of
        // its transmission.
        now.delay = Delay::default().apart(vector / information, information.powf(-0.5));
        let given = |sensor: SensorIndex, sums: &DelaySums| {
            let radar = applied.contains(&sensor).then(|| self.radars.get(&sensor))??;
            Some(sums.given(&radar.estimate).weakened(DELAY_DEVIATIONS))
        };
        now.delays = types.delays(now.delay, given);
        now.own_delays = types.own_delays(now.delay, given);
        self.delay = Some(now.delay);
        if let Some(shared) = &types.shared {
            now.delay = shared.delay.unwrap_or_else(|| Delay::default().apart(mean_s, sigma_s));
            now.delays.clone_from(&shared.delays);
            // A cell has not learnt of transponders that come from another cell.
            now.own_delays.clear();
        }
        now
    }

    /// The transponders of these targets are believed nothing, nor are those that were not disbelieved before what they said of
    /// the last minute.
    pub(super) fn disbelieve(&mut self, targets: BTreeSet<TargetId>, now: Time) {
        self.lately.retain(|taken| now.seconds_since(taken.3) <= WITHDRAWN_S);
        let new: Vec<TargetId> = targets.difference(&self.disbelieved).copied().collect();
        self.segments.retain(|_, segment| !targets.contains(&segment.target));
        let Self { radars, lately, .. } = self;
        lately.retain(|&(target, sensor, begun, _)| {
            let is_lie = new.contains(&target);
            if is_lie && let Some(registered) = radars.get_mut(&sensor) {
                registered.withdraw(begun);
            }
            !is_lie
        });
        self.disbelieved = targets;
    }

    /// The identities of hosts of which some radar learns nothing any more.
    pub(super) fn doubted(&self, targets: &Targets) -> BTreeSet<Identity> {
        let is_excluded = |host: Host| self.radars.values().any(|registered| registered.guard.excludes(host));
        let transponders = targets.iter().filter_map(Target::transponder);
        let doubted = transponders.filter(|transponder| is_excluded(transponder.host));
        doubted.map(|transponder| transponder.identity).collect()
    }

    /// Takes in the segments of tracklets that have been dropped.
    pub(super) fn end(&mut self, tracklets: &Tracklets, types: &mut TransponderTypes) {
        let Self { radars, segments, rates, lately, .. } = self;
        rates.retain(|&id, _| tracklets.get(id).is_some());
        segments.retain(|&id, segment| {
            let is_left = tracklets.get(id).is_some();
            if !is_left && let Some(registered) = radars.get_mut(&segment.sensor) {
                lately.extend(registered.take(segment, types));
            }
            is_left
        });
    }

    /// Compares radar tracks with the transponders they go with, for the plots since the last slot.
    pub(super) fn register(
        &mut self,
        tracklets: &Tracklets,
        targets: &Targets,
        types: &mut TransponderTypes,
        cycle: &Cycle,
    ) {
        let residuals =
            shared::map(cycle.settings.threads, tracklets.as_slice(), |one| residuals(one, targets, cycle));
        for (&sensor, registered) in &mut self.radars {
            if registered.check(cycle.centre) {
                types.forget_radar(sensor);
                self.segments.retain(|_, segment| {
                    segment.sensor != sensor || !registered.guard.excludes(segment.host)
                });
            }
        }
        for (tracklet, residuals) in tracklets.iter().zip(residuals) {
            let sensor = tracklet.key.sensor;
            let Some(radar) = cycle.settings.radar(sensor) else { continue };
            let Some(registered) = self.radars.get_mut(&sensor) else { continue };
            let believed = tracklet.target().filter(|target| !self.disbelieved.contains(target));
            let paired = believed.and_then(|target| Some((target, targets.get(target)?.transponder()?)));
            let paired = paired.filter(|(_, transponder)| {
                !registered.guard.excludes(transponder.host) || self.trusted.contains(&transponder.identity)
            });
            let Some((target, transponder)) = paired else {
                self.segments.remove(&tracklet.id);
                if registered.learning.asks_for_rates() {
                    let plots = tracklet.between(cycle.previous, cycle.centre);
                    let seen = plots.filter_map(|plot| seen(plot, radar));
                    for seen in seen {
                        let rate = self.rates.entry(tracklet.id).or_default();
                        rate.add(seen, &radar.track_errors)
                            .iter()
                            .for_each(|off| registered.learning.take_rate(off));
                    }
                }
                continue;
            };
            if self.segments.get(&tracklet.id).is_some_and(|segment| segment.target != target) {
                self.segments.remove(&tracklet.id);
            }
            for (plot, residual) in residuals {
                // The radar's own errors: what is left of its misalignment is what is asked for.
                let segment = self.segments.entry(tracklet.id).or_insert_with(|| Segment {
                    sensor,
                    target,
                    host: transponder.host,
                    identity: transponder.identity,
                    kind: transponder.kind(),
                    along: TrackComparison::new(&radar.track_errors),
                    learning: TrackLearning::new(radar.track_errors.correlation_s),
                });
                let of = (transponder.host, transponder.identity);
                let turned = residual.turned(segment.along.begun().unwrap_or(residual.time));
                if turned.is_none_or(|turned| registered.guard.add(of, &turned)) {
                    segment.along.add(&residual);
                }
                if let Some(compared) =
                    compared(&residual, plot, &registered.correction, transponder, cycle.settings)
                {
                    segment.learning.add(&compared);
                }
            }
            if let Some(segment) = self.segments.get_mut(&tracklet.id)
                && segment.along.gathered_s() >= SEGMENT_S
            {
                self.lately.extend(registered.take(segment, types));
            }
        }
    }
}
