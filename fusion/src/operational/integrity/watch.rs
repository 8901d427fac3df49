//! Observations of radar tracks from a transponder, second by second.

use std::collections::VecDeque;

use jiff::SignedDuration;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::filter::LineOfSight;
use crate::frames::Enu;
use crate::integrity::{MotionComparison, MotionStep, PersistentErrors, TrackObservation};
use crate::operational::cycle::{Cycle, EARLIEST};
use crate::operational::ids::{TargetId, TrackletId};
use crate::operational::settings::RadarSettings;
use crate::operational::tracklets::Tracklet;
use crate::operational::transponder::{CurveCursor, Transponder};
use crate::time::Time;

/// Duration of an observation.
pub(super) const SECOND: SignedDuration = SignedDuration::from_secs(1);
/// Factor on the persistent error of the azimuth, for turns in the worst case. The learnt value is a mean over all
/// flight.
const TURNS: f64 = 1.8;
/// Period before and after a second whose observations are used to judge it, seconds.
const AROUND_S: f64 = 6.0;
/// Period before and after a second over which the rate of the offset is measured, seconds.
const RATE_AROUND_S: f64 = 3.0;
/// Scale of the medians in range and azimuth, standard deviations, and maximum sum of squares of a near track.
const NEAR_SIGMAS: [f64; 2] = [2.0, 1.3];
const NEAR_MAX: f64 = 5.0;
/// Standard deviation of the offset of an honest receiver, each axis, metres.
const HONEST_M: f64 = 2.2;
/// Rate of the offset in range above which a radar track drifts off, metres a second.
const RATE_MAX_M_S: f64 = 4.5;
/// Rate of the offset in range and azimuth above which a radar track drifts off, in standard deviations; they include
/// the drift rate of a false position, metres a second.
const RATE_MAX_SIGMAS: f64 = 4.0;
const LIE_RATE_M_S: f64 = 1.7;
/// LLR by motion below which a track is another aircraft.
const OTHER_LLR: f64 = -4.0;
/// Number of near observations after which a radar track stays assigned to the aircraft.
const LOYAL_LOOKS: u32 = 6;

/// A transponder's curve, second by second, as far as it is known at a deadline.
#[derive(Debug)]
pub(super) struct SampledCurve<'a> {
    walk: CurveCursor<'a>,
    deadline: Time,
    /// End of the second that is evaluated.
    end: Time,
    /// Seconds from there on.
    seconds: VecDeque<CurveSecond>,
}

/// A second of a curve.
#[derive(Clone, Copy, Debug)]
struct CurveSecond {
    end: Time,
    /// Velocity over ground in the middle, metres a second.
    velocity: Vector2<f64>,
}

impl<'a> SampledCurve<'a> {
    /// The curve from the second that ends at `first`.
    pub(super) fn from(first: Time, transponder: &'a Transponder, cycle: &Cycle<'a>) -> Option<Self> {
        let Cycle { deadline, settings, .. } = *cycle;
        let heard = transponder.last_heard().unwrap_or(EARLIEST);
        let mut walk = transponder.walk(settings)?;
        let ends = (0..).map(|index| first + SECOND * index);
        let known = ends.take_while(|&end| end <= deadline && end + -SECOND < heard);
        let flown = |end| Some(CurveSecond { end, velocity: velocity(&mut walk, middle(end))? });
        let seconds = known.filter_map(flown).collect();
        Some(Self { walk, deadline, end: first, seconds })
    }

    /// Advances to the second that ends at `end`; returns the transponder's position in its middle.
    pub(super) fn advance(&mut self, end: Time) -> Option<Enu> {
        self.end = end;
        while self.seconds.front().is_some_and(|first| first.end < end) {
            self.seconds.pop_front();
        }
        Some(self.walk.at(middle(end))?.position)
    }
}

/// Middle of the second that ends at `end`.
fn middle(end: Time) -> Time {
    end + -SECOND / 2
}

/// The plots of a radar track within a second, compared with the transponder's curve.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct ComparedSecond {
    pub(super) look: TrackObservation,
    /// Mean difference of the heights, metres, if the radar measures them.
    pub(super) height_m: Option<f64>,
    steps: [MotionStep; 2],
}

impl ComparedSecond {
    /// Compares a second; `None` without a plot.
    fn of(
        tracklet: &Tracklet,
        walk: &mut CurveCursor,
        flown: &CurveSecond,
        radar: &RadarSettings,
    ) -> Option<Self> {
        let plots = tracklet.between(flown.end + -SECOND, flown.end);
        let (mut count, mut heights) = (0.0, 0.0);
        let (mut up_m, mut curve_m2) = (0.0, 0.0);
        let (mut place, mut offset) = (Vector2::zeros(), [0.0; 2]);
        for plot in plots {
            let Some(curve) = walk.at(plot.time) else { continue };
            let seen = LineOfSight::from(radar.position, plot.position);
            let apart = (plot.position.0 - curve.position.0).xy();
            offset[0] += seen.outward.dot(&apart);
            offset[1] += seen.clockwise.dot(&apart);
            place += plot.position.0.xy();
            curve_m2 += curve.sigma_m * curve.sigma_m;
            count += 1.0;
            if plot.height_measured && curve.height_measured {
                up_m += plot.position.0.z - curve.position.0.z;
                heights += 1.0;
            }
        }
        if count == 0.0 {
            return None;
        }
        let (place, offset, curve_m2) = (place / count, offset.map(|sum| sum / count), curve_m2 / count);
        let seen = LineOfSight::from(radar.position, Enu::new(place.x, place.y, 0.0));
        let errors = &radar.track_errors;
        let noise_m = [errors.noise_range_m, errors.noise_azimuth * seen.range_m];
        let plots_m2 = noise_m.map(|sigma_m| sigma_m * sigma_m / count);
        let slow = PersistentErrors {
            range_m: errors.bias_range_m,
            azimuth: errors.bias_azimuth * TURNS,
            lasts_s: errors.correlation_s,
        };
        let misaligned = |with: f64, without: f64| (with * with - without * without).max(0.0).sqrt();
        let look = TrackObservation {
            time: middle(flown.end),
            radar: tracklet.key.sensor,
            track: tracklet.id.of_radar(),
            offset_m: offset,
            white_m2: plots_m2.map(|white_m2| white_m2 + curve_m2),
            axes: [seen.outward, seen.clockwise],
            range_m: seen.range_m,
            velocity: flown.velocity,
            slow,
            alignment: [
                misaligned(radar.errors.bias_range_m, errors.bias_range_m),
                misaligned(radar.errors.bias_azimuth, errors.bias_azimuth),
            ],
        };
        let slow_m = [slow.range_m, slow.azimuth * seen.range_m];
        let away = place - radar.position.0.xy();
        let flown_m = [seen.range_m, away.x.atan2(away.y) * seen.range_m];
        let step = |axis: usize| MotionStep {
            offset_m: offset[axis],
            flown_m: flown_m[axis],
            plots_m2: plots_m2[axis],
            curve_m2,
            slow_m: slow_m[axis],
            lasts_s: slow.lasts_s,
        };
        let height_m = (heights > 0.0).then(|| up_m / heights);
        Some(Self { look, height_m, steps: [step(0), step(1)] })
    }
}

/// Velocity of the transponder's curve over ground.
fn velocity(walk: &mut CurveCursor, time: Time) -> Option<Vector2<f64>> {
    let half = SECOND / 2;
    let [before, now, after] =
        [time + -half, time, time + half].map(|time| walk.at(time).map(|on_curve| on_curve.position.0.xy()));
    match (before, now, after) {
        (Some(before), _, Some(after)) => Some(after - before),
        (Some(before), Some(now), None) => Some((now - before) * 2.0),
        (None, Some(now), Some(after)) => Some((after - now) * 2.0),
        _ => None,
    }
}

/// Offset of a radar track from a transponder: mean of the plots minus the transponder's curve, outward and clockwise,
/// metres.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct WatchOffset {
    time: Time,
    offset_m: [f64; 2],
}

impl From<&TrackObservation> for WatchOffset {
    fn from(&TrackObservation { time, offset_m, .. }: &TrackObservation) -> Self {
        Self { time, offset_m }
    }
}

/// A second that is already known, and the motion of the radar track up to it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct KnownSecond {
    second: ComparedSecond,
    motion: MotionComparison,
    /// Log-likelihood of the second for another aircraft.
    other: f64,
}

impl From<ComparedSecond> for KnownSecond {
    /// Starts without a motion.
    fn from(second: ComparedSecond) -> Self {
        Self { second, motion: MotionComparison::default(), other: 0.0 }
    }
}

/// A radar track as observed from a transponder.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Watch {
    motion: MotionComparison,
    /// Observations of the last seconds, up to the one that is judged.
    past: VecDeque<WatchOffset>,
    /// The seconds after these, as known at a deadline.
    ahead: VecDeque<KnownSecond>,
    known: Time,
    /// Number of near observations.
    near: u32,
    /// Whether it moved relative to the transponder, like a radar track that drifts off or a transponder whose position
    /// jumps.
    walked_off: bool,
    /// Result of the last observation.
    last: Option<WatchResult>,
}

/// Assignment of a radar track by the association.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum TrackAssociation {
    /// The transponder's aircraft.
    Own,
    /// The aircraft of another transponder.
    Another,
    /// An aircraft without a transponder.
    Nobodys(TargetId),
    /// No aircraft yet.
    Nothing,
}

/// Result of an observation.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct WatchResult {
    pub(super) second: ComparedSecond,
    /// Assignment of the radar track by the association.
    pub(super) taken_for: TrackAssociation,
    /// Log-likelihood of the observation for another aircraft.
    pub(super) other: f64,
    /// LLR by motion, for this aircraft against another one, up to this observation.
    pub(super) so_far: f64,
    /// Distance of the medians from the transponder; below [`NEAR_MAX`] the track is near.
    pub(super) away: f64,
    /// LLR by motion, including the observations ahead.
    pub(super) motion: f64,
    /// Whether it was near in enough observations to stay assigned to the aircraft.
    pub(super) is_loyal: bool,
    /// Whether it moves relative to the transponder like a track that drifts off.
    pub(super) walks_off: bool,
}

impl TrackAssociation {
    /// The aircraft without a transponder.
    pub(super) fn uncooperative_target(self) -> Option<TargetId> {
        match self {
            Self::Nobodys(target) => Some(target),
            _ => None,
        }
    }
}

impl WatchResult {
    /// Whether the association assigns it to the transponder's aircraft.
    pub(super) fn is_pair(&self) -> bool {
        self.taken_for == TrackAssociation::Own
    }

    /// Whether observations up to this one were weighed.
    pub(super) fn is_weighed(&self, until: Option<Time>) -> bool {
        until.is_some_and(|until| self.second.look.time <= until)
    }

    /// Whether it is at the transponder's reported position.
    pub(super) fn is_near(&self) -> bool {
        self.away < NEAR_MAX && self.motion > OTHER_LLR
    }
}

impl Watch {
    pub(super) fn new() -> Self {
        Self {
            motion: MotionComparison::default(),
            past: VecDeque::new(),
            ahead: VecDeque::new(),
            known: EARLIEST,
            near: 0,
            walked_off: false,
            last: None,
        }
    }

    /// Judges the curve's second, given those after it. `jumps`: the transponder's own positions jump, so the radar
    /// track does not drift off.
    pub(super) fn observe(
        &mut self,
        tracklet: &Tracklet,
        curve: &mut SampledCurve,
        (taken_for, jumps): (TrackAssociation, bool),
        radar: &RadarSettings,
    ) -> Option<&WatchResult> {
        let now = middle(curve.end);
        if self.known != curve.deadline {
            self.known = curve.deadline;
            let SampledCurve { walk, seconds, .. } = curve;
            let seconds = seconds.iter().filter_map(|flown| ComparedSecond::of(tracklet, walk, flown, radar));
            self.ahead.clear();
            self.ahead.extend(seconds.map(KnownSecond::from));
            self.foresee();
        }
        let passed = self.ahead.iter().take_while(|next| next.second.look.time < now).count();
        if passed > 0 {
            // The track was too far away to be observed then.
            self.ahead.drain(..passed);
            self.foresee();
        }
        self.ahead.front().filter(|next| next.second.look.time == now)?;
        let next = self.ahead.pop_front()?;
        self.evaluate_second(next, taken_for, jumps);
        self.last.as_ref()
    }

    /// Computes the motion over the seconds ahead.
    fn foresee(&mut self) {
        let (mut motion, mut before) = (self.motion, self.past.back().map(|last| last.time));
        for KnownSecond { second, motion: after, other } in &mut self.ahead {
            let time = second.look.time;
            *other = motion.update(second.steps, elapsed_s(before.replace(time), time));
            *after = motion;
        }
    }

    /// Judges a second by those around it.
    fn evaluate_second(&mut self, next: KnownSecond, taken_for: TrackAssociation, jumps: bool) {
        let now = next.second;
        let time = now.look.time;
        let before = self.past.back().map(|last| last.time);
        self.past.push_back(WatchOffset::from(&now.look));
        let is_around = |one: Time, other: Time| other.seconds_since(one) <= AROUND_S;
        while self.past.front().is_some_and(|first| !is_around(first.time, time)) {
            self.past.pop_front();
        }
        let ahead = self.ahead.iter().map(|ahead| &ahead.second.look);
        let ahead = ahead.take_while(|ahead| is_around(time, ahead.time));
        let last = ahead.clone().last().unwrap_or(&now.look);
        let mut offsets = Vec::with_capacity(self.past.len() + self.ahead.len());
        offsets.extend(self.past.iter().copied());
        offsets.extend(ahead.clone().map(WatchOffset::from));
        let count_ahead = offsets.len() - self.past.len();
        let (walks_off, away) = (walks_off(&offsets, &now.look), squared_distance(&offsets, last));
        let is_special = jumps && (walks_off || self.walked_off);
        let other = match (is_special, walks_off) {
            (true, true) => 0.0,
            (true, false) => self.motion.take_elsewhere(now.steps, elapsed_s(before, time)),
            (false, _) => {
                self.motion = next.motion;
                next.other
            }
        };
        if is_special {
            self.foresee();
        }
        self.walked_off = walks_off;
        let so_far = self.motion.llr();
        let furthest = count_ahead.checked_sub(1).and_then(|last| self.ahead.get(last));
        let is_near = away < NEAR_MAX;
        self.near += u32::from(is_near);
        self.last = Some(WatchResult {
            second: now,
            taken_for,
            other,
            so_far,
            away,
            motion: furthest.map_or(so_far, |ahead| ahead.motion.llr()),
            is_loyal: self.near >= LOYAL_LOOKS && so_far > OTHER_LLR,
            walks_off,
        });
    }

    /// Releases the seconds ahead after the last observation at a deadline; they are computed again at the next one.
    /// There are many watches, and their memory matters more than a reused buffer.
    pub(super) fn discard_ahead(&mut self) {
        self.ahead = VecDeque::new();
    }

    /// Result of the last observation.
    pub(super) fn last(&self) -> Option<&WatchResult> {
        self.last.as_ref()
    }
}

/// Time from the previous observation to `time`, seconds; one second if there is none.
fn elapsed_s(before: Option<Time>, time: Time) -> f64 {
    before.map_or(1.0, |before| time.seconds_since(before))
}

/// Squared distance of the medians of the offsets from zero, in standard deviations at the last of them.
fn squared_distance(offsets: &[WatchOffset], last: &TrackObservation) -> f64 {
    let sigmas = [
        last.slow.range_m.hypot(last.alignment[0]).hypot(HONEST_M),
        (last.slow.azimuth.hypot(last.alignment[1]) * last.range_m).hypot(HONEST_M),
    ];
    let mut values = Vec::with_capacity(offsets.len());
    let mut squared = |axis: usize| {
        values.clear();
        values.extend(offsets.iter().map(|offset| offset.offset_m[axis]));
        (median(&mut values) / (NEAR_SIGMAS[axis] * sigmas[axis])).powi(2)
    };
    squared(0) + squared(1)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let half = values.len() / 2;
    if values.len() % 2 == 1 { values[half] } else { (values[half - 1] + values[half]) / 2.0 }
}

/// Whether the radar track moves relative to the transponder faster than a false position drifts.
fn walks_off(offsets: &[WatchOffset], now: &TrackObservation) -> bool {
    let from_now = |offset: &WatchOffset| offset.time.seconds_since(now.time);
    // The offsets are ordered by time.
    let first = offsets.partition_point(|offset| from_now(offset) < -RATE_AROUND_S);
    let around = offsets[first..].iter().take_while(|offset| from_now(offset) <= RATE_AROUND_S);
    let (mut count, mut sum_s) = (0.0, 0.0);
    for offset in around.clone() {
        count += 1.0;
        sum_s += from_now(offset);
    }
    if count < 3.0 {
        return false;
    }
    let mean_s = sum_s / count;
    // Sums of squares of the times, and of the products of times and offsets.
    let (mut spread_s2, mut products) = (0.0, [0.0; 2]);
    for offset in around {
        let time_s = from_now(offset) - mean_s;
        spread_s2 += time_s * time_s;
        for (product, offset_m) in products.iter_mut().zip(offset.offset_m) {
            *product += time_s * offset_m;
        }
    }
    let rates = products.map(|product| product / spread_s2);
    let TrackObservation { slow, range_m, white_m2, .. } = *now;
    let sigma = |axis: usize| {
        let slow_m = [slow.range_m, slow.azimuth * range_m][axis];
        // A persistent error changes by its deviation times sqrt(2 t / τ) in a time t.
        let slow_m2_s2 = slow_m * slow_m * 2.0 / (slow.lasts_s * (2.0 * RATE_AROUND_S));
        (LIE_RATE_M_S * LIE_RATE_M_S + slow_m2_s2 + white_m2[axis] / spread_s2).sqrt()
    };
    let deviations = [0, 1].map(|axis| rates[axis] / sigma(axis));
    rates[0].abs() > RATE_MAX_M_S || deviations[0].hypot(deviations[1]) > RATE_MAX_SIGMAS
}

/// The watches of a transponder, by radar track.
pub(super) type TrackWatches = std::collections::BTreeMap<TrackletId, Watch>;
