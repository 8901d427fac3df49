//! Registration of each radar from its tracks of drones with a transponder, and correction of its plots.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::cycle::Cycle;
use super::ids::{TargetId, TrackletId};
use super::likelihood::Scales;
use super::lookalikes::Lookalikes;
use super::residuals::{compared, rate_plot, residuals};
use super::settings::{OperationalSettings, RadarSettings, TransponderDelay};
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
    Correction, Creep, CreepGuard, DelaySums, Displacement, GuardResult, HeightAlignment, LearntFromRadars,
    Misalignment, MutualAlignment, PlaceCheck, Registration, RegistrationState, RegistrationStateError,
    SampleOutcome, SharedComparison, TrackComparison,
};
use crate::report::{Host, Identity, Plot, SensorIndex, TransponderType};
use crate::settings::RegistrationMode;
use crate::time::Time;

mod heights;
mod shared_aircraft;

/// Registration and errors of one radar.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Registered {
    registration: Registration,
    learning: RadarLearning,
    /// Learnt errors, beginning with those of the data sheet; `None` if errors are not learnt.
    pub learnt: Option<LearntRadar>,
    correction: Correction,
    /// Misalignment estimated from the tracks so far.
    pub estimate: Misalignment,
    /// The latest step of the misalignment.
    pub step: Option<Step>,
    place: PlaceCheck,
    guard: CreepGuard,
    /// Its tilts and height where those of transponders have offsets, and the share of that which is used.
    heights: Option<(HeightAlignment, f64)>,
    /// Information from aircraft that other radars see as well.
    by_radars: Option<LearntFromRadars>,
}

/// A step of the misalignment: the latest tracks contradict earlier ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Time of the detection.
    pub time: Time,
    /// Estimate before the step.
    pub before: Misalignment,
    /// Estimate from the latest tracks.
    pub after: Misalignment,
}

/// A radar without evidence.
impl Default for Registered {
    fn default() -> Self {
        Self::new(Registration::default())
    }
}

/// Values of a radar's registration that are applied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct AppliedRegistration {
    learnt: Option<LearntRadar>,
    correction: Correction,
}

/// No correction, and no learnt errors.
impl Default for AppliedRegistration {
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
            place: PlaceCheck::default(),
            guard: CreepGuard::default(),
            heights: None,
            by_radars: None,
        }
    }

    /// The latest alarm on a creeping bearing.
    pub fn creep(&self) -> Option<Creep> {
        self.guard.alarm()
    }

    /// Information from aircraft that other radars see as well.
    pub fn by_radars(&self) -> Option<&LearntFromRadars> {
        self.by_radars.as_ref()
    }

    /// Where the radar stands according to its tracks.
    pub fn place(&self) -> Option<&Displacement> {
        self.place.found()
    }

    /// The registration, for a restart.
    pub fn to_state(&self) -> RegistrationState {
        self.registration.to_state()
    }

    /// Adds a segment of a radar track, also to the evidence on its transponder and the type. A step ends what other radars show.
    fn add_segment(
        &mut self,
        segment: &mut TrackSegment,
        types: &mut TransponderTypes,
        mutual: &mut MutualAlignment,
    ) -> Option<(TargetId, SensorIndex, Time, Time)> {
        let mut sample = segment.along.take_sample()?;
        sample.weaken(self.guard.weight(segment.host, sample.time()));
        self.learning.add_evidence(&mut segment.learning, sample.time());
        self.place.add(segment.identity, &sample);
        types.heights.add_segment(segment.identity, segment.sensor, &sample, segment.height_m);
        match self.registration.add(&sample) {
            SampleOutcome::Kept => {
                types.take_sample(segment.kind, segment.sensor, &sample);
                types.take_own_sample(segment.identity, segment.kind, segment.sensor, &sample);
            }
            SampleOutcome::Rejected => {}
            SampleOutcome::Step { before, after } => {
                self.step = Some(Step { time: sample.time(), before, after });
                types.forget_radar(segment.sensor);
                mutual.forget(segment.sensor);
                self.by_radars = None;
            }
        }
        self.estimate();
        Some((segment.target, segment.sensor, sample.begun(), sample.time()))
    }

    /// Removes the track that began at this time.
    fn withdraw(&mut self, begun: Time) {
        self.registration.withdraw(begun);
        self.estimate();
    }

    /// The estimate without other radars.
    fn own_estimate(&self) -> Misalignment {
        let own = self.guard.used(self.registration.estimate());
        match &self.heights {
            Some((alignment, share)) => own.with_heights(alignment, *share),
            None => own,
        }
    }

    fn estimate(&mut self) {
        let own = self.own_estimate();
        self.estimate = self.by_radars.as_ref().map_or(own, |learnt| own.with_radars(learnt));
        self.correction = Correction::of(&self.estimate);
    }

    /// Checks whether the bearing creeps. Returns whether there is an alarm.
    fn check(&mut self, now: Time) -> bool {
        let checked = self.guard.check(&mut self.registration, now);
        if checked != GuardResult::Unchanged {
            self.estimate();
        }
        checked == GuardResult::Alarm
    }

    /// The learnt errors, for a restart.
    pub fn learning_state(&self) -> LearningState {
        self.learning.to_state()
    }

    fn applied(&self) -> AppliedRegistration {
        AppliedRegistration { learnt: self.learnt, correction: self.correction }
    }
}

impl AppliedRegistration {
    /// Replaces the errors of a radar by the learnt ones.
    fn apply_to(&self, radar: &mut RadarSettings) {
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

    /// The learnt errors with the remaining misalignment.
    fn errors(&self, radar: &RadarSettings) -> RadarErrors {
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

/// Ratio of a learnt bias to the data sheet's, limited by the number of independent samples. A few samples do not prove that a
/// radar is better than its data sheet, because the largest biases may not have been seen yet. They do prove that it is worse.
fn cautious(of_sheet: f64, samples: f64) -> f64 {
    if of_sheet < 1.0 { of_sheet.powf(samples / (samples + CAUTIOUS_SAMPLES)) } else { of_sheet }
}

/// Rounds an error to relative steps.
fn in_steps(sigma: f64) -> f64 {
    ((sigma.ln() / ERROR_STEP).round() * ERROR_STEP).exp()
}

/// A segment of a radar track associated with a target.
#[derive(Debug, Serialize, Deserialize)]
struct TrackSegment {
    sensor: SensorIndex,
    target: TargetId,
    host: Host,
    identity: Identity,
    kind: TransponderType,
    /// Sigma of what lasts of its heights' errors, metres.
    height_m: f64,
    along: TrackComparison,
    learning: TrackLearning,
}

/// Maximum age of the samples that are withdrawn when a transponder is first ignored, seconds.
const WITHDRAWN_S: f64 = 60.0;

/// The registrations of all radars.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Registrations {
    radars: BTreeMap<SensorIndex, Registered>,
    segments: BTreeMap<TrackletId, TrackSegment>,
    /// Samples added lately: target, radar, beginning of the radar track, end of the segment.
    lately: Vec<(TargetId, SensorIndex, Time, Time)>,
    /// Targets whose transponders are ignored.
    disbelieved: BTreeSet<TargetId>,
    /// Identities that an operator trusts. Their reports count, whatever their host.
    pub(super) trusted: BTreeSet<Identity>,
    lookalikes: Lookalikes,
    mutual: MutualAlignment,
    /// Comparisons of the tracks of two radars of one aircraft.
    shared_tracks: BTreeMap<(TrackletId, TrackletId), SharedComparison>,
    /// Range rates of radar tracks without a transponder, for radars that report velocities.
    rates: BTreeMap<TrackletId, RangeRate>,
    /// The transponders' delay estimated by these radars.
    delay: Option<TransponderDelay>,
    /// Values learnt by other engines, used instead of its own; `None`: its own values are used.
    pub(super) shared: Option<BTreeMap<SensorIndex, AppliedRegistration>>,
}

impl Registrations {
    /// All radars with a registration.
    pub(super) fn radars(&self) -> impl Iterator<Item = (SensorIndex, &Registered)> {
        self.radars.iter().map(|(&sensor, registered)| (sensor, registered))
    }

    /// Restores a radar's registration after a restart.
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

    /// Restores a radar's learnt errors after a restart.
    pub(super) fn restore_learning(
        &mut self,
        sensor: SensorIndex,
        state: &LearningState,
    ) -> Result<(), LearningStateError> {
        let learning = RadarLearning::from_state(state)?;
        self.radars.entry(sensor).or_default().learning = learning;
        Ok(())
    }

    /// Restarts a radar's registration, because the radar was moved. Its errors do not depend on where it stands.
    pub(super) fn restart(&mut self, sensor: SensorIndex) {
        if let Some(known) = self.radars.remove(&sensor) {
            let anew = Registered { learning: known.learning, ..Registered::default() };
            self.radars.insert(sensor, anew);
        }
        self.segments.retain(|_, segment| segment.sensor != sensor);
        self.mutual.forget(sensor);
        self.shared_tracks
            .retain(|(one, other), _| one.track.sensor != sensor && other.track.sensor != sensor);
        self.lately.retain(|taken| taken.1 != sensor);
    }

    /// The registrations without tracks.
    pub(super) fn without_tracks(self) -> Self {
        Self { radars: self.radars, mutual: self.mutual, shared: self.shared, ..Self::default() }
    }

    /// Whether the transponder of this target is ignored.
    pub(super) fn ignores(&self, target: TargetId) -> bool {
        self.disbelieved.contains(&target)
    }

    fn correction(&self, sensor: SensorIndex) -> Option<&Correction> {
        match &self.shared {
            Some(shared) => shared.get(&sensor).map(|applied| &applied.correction),
            None => self.radars.get(&sensor).map(|registered| &registered.correction),
        }
    }

    /// Values learnt for a radar.
    pub(super) fn learnt(&self, sensor: SensorIndex) -> Option<AppliedRegistration> {
        self.radars.get(&sensor).map(Registered::applied)
    }

    /// The learnt delay of the transponders.
    pub(super) fn delay(&self) -> Option<TransponderDelay> {
        self.delay
    }

    /// Corrects a plot by the radar's misalignment, if it is observable and corrections are applied.
    pub(super) fn correct(&self, mut plot: Plot, radar: &RadarSettings) -> Plot {
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

    /// The settings with the current errors and delays.
    pub(super) fn settings(
        &mut self,
        settings: &OperationalSettings,
        types: &mut TransponderTypes,
    ) -> OperationalSettings {
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
        // A time bias seen by radars is the transponders' delay: radars have clocks, whereas a transponder's time is that of its
        // transmission.
        now.delay = TransponderDelay::default().apart(vector / information, information.powf(-0.5));
        let given = |sensor: SensorIndex, sums: &DelaySums| {
            let radar = applied.contains(&sensor).then(|| self.radars.get(&sensor))??;
            Some(sums.given(&radar.estimate).weakened(DELAY_DEVIATIONS))
        };
        now.delays = types.delays(now.delay, given);
        now.own_delays = types.own_delays(now.delay, given);
        now.heights = types.heights.corrections();
        self.delay = Some(now.delay);
        if let Some(shared) = &types.shared {
            now.delay = shared.delay.unwrap_or_else(|| TransponderDelay::default().apart(mean_s, sigma_s));
            now.delays.clone_from(&shared.delays);
            // A cell has not learnt the delays of transponders that come from another cell.
            now.own_delays.clear();
            now.heights.clear();
        }
        now
    }

    /// Ignores the transponders of these targets. For targets not ignored before, it also withdraws the samples of the last
    /// minute.
    pub(super) fn exclude_targets(&mut self, targets: BTreeSet<TargetId>, now: Time) {
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

    /// Identities of hosts from which some radar learns nothing any more.
    pub(super) fn doubted(&self, targets: &Targets) -> BTreeSet<Identity> {
        let is_excluded = |host: Host| self.radars.values().any(|registered| registered.guard.excludes(host));
        let transponders = targets.iter().filter_map(Target::transponder);
        let doubted = transponders.filter(|transponder| is_excluded(transponder.host));
        doubted.map(|transponder| transponder.identity).collect()
    }

    /// Adds the segments of dropped tracklets.
    pub(super) fn end(&mut self, tracklets: &Tracklets, types: &mut TransponderTypes) {
        let Self { radars, segments, rates, lately, lookalikes, mutual, .. } = self;
        rates.retain(|&id, _| tracklets.get(id).is_some());
        lookalikes.end(tracklets);
        segments.retain(|&id, segment| {
            let is_left = tracklets.get(id).is_some();
            if !is_left && let Some(registered) = radars.get_mut(&segment.sensor) {
                lately.extend(registered.add_segment(segment, types, mutual));
            }
            is_left
        });
    }

    /// Compares radar tracks with the associated transponders, for the plots since the last slot.
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
        let places = &Lookalikes::places(targets, cycle);
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
                if let Some((identity, sample)) =
                    self.lookalikes.compare(tracklet, radar, (targets, places), cycle)
                {
                    registered.place.add(identity, &sample);
                }
                if registered.learning.asks_for_rates() {
                    let plots = tracklet.between(cycle.previous, cycle.centre);
                    let seen = plots.filter_map(|plot| rate_plot(plot, radar));
                    for seen in seen {
                        let rate = self.rates.entry(tracklet.id).or_default();
                        rate.add(seen, &radar.track_errors)
                            .iter()
                            .for_each(|off| registered.learning.take_rate(off));
                    }
                }
                continue;
            };
            self.lookalikes.forget(tracklet.id);
            if self.segments.get(&tracklet.id).is_some_and(|segment| segment.target != target) {
                self.segments.remove(&tracklet.id);
            }
            let bias = transponder.bias(cycle.settings);
            for (plot, residual) in residuals {
                // The radar's own errors, because the misalignment is the quantity to be estimated.
                let segment = self.segments.entry(tracklet.id).or_insert_with(|| TrackSegment {
                    sensor,
                    target,
                    host: transponder.host,
                    identity: transponder.identity,
                    kind: transponder.kind(),
                    height_m: bias.map_or(radar.errors.bias_height_m, |bias| bias.vertical_m2.sqrt()),
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
                self.lately.extend(registered.add_segment(segment, types, &mut self.mutual));
            }
        }
        self.judge_heights(types, cycle);
        self.compare_radars(tracklets, targets, cycle);
    }
}
