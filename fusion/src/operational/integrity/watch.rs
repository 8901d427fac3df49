//! What radar tracks show of a transponder, second by second.

use std::collections::VecDeque;

use jiff::SignedDuration;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::filter::LineOfSight;
use crate::frames::Enu;
use crate::integrity::{Look, Motion, Slow, Step};
use crate::operational::cycle::{Cycle, EARLIEST};
use crate::operational::ids::{TargetId, TrackletId};
use crate::operational::settings::Radar;
use crate::operational::tracklets::Tracklet;
use crate::operational::transponder::{Transponder, Walk};
use crate::time::Time;

/// The length of a look.
pub(super) const SECOND: SignedDuration = SignedDuration::from_secs(1);
/// Turns make the slow error of an azimuth larger, by so much at worst: what is learnt is the mean over all flying.
const TURNS: f64 = 1.8;
/// A look is judged by those up to this before and after it, seconds;
const AROUND_S: f64 = 6.0;
/// and by how the offset changes within this, seconds.
const RATE_AROUND_S: f64 = 3.0;
/// Near: so many standard deviations of the medians in range and azimuth, and their squares' sum.
const NEAR_SIGMAS: [f64; 2] = [2.0, 1.3];
const NEAR_MAX: f64 = 5.0;
/// Offset of an honest receiver, each axis, metres.
const HONEST_M: f64 = 2.2;
/// A radar track that moves faster than this against the transponder walks off, metres a second in range;
const RATE_MAX_M_S: f64 = 4.5;
/// or by more than so many deviations in range and azimuth together, where a lie may drift so fast, metres a second.
const RATE_MAX_SIGMAS: f64 = 4.0;
const LIE_RATE_M_S: f64 = 1.7;
/// Against this the way it flies speaks for another aircraft.
const OTHER_LLR: f64 = -4.0;
/// Looks after which a radar track that was near stays the aircraft's own.
const LOYAL_LOOKS: u32 = 6;

/// A transponder's curve, second by second as far as it is known at a deadline.
#[derive(Debug)]
pub(super) struct Curve<'a> {
    walk: Walk<'a>,
    deadline: Time,
    /// The second that is looked at ends then.
    end: Time,
    /// From there on.
    seconds: VecDeque<Flown>,
}

/// A second of a curve.
#[derive(Clone, Copy, Debug)]
struct Flown {
    end: Time,
    /// Over ground in the middle, metres a second.
    velocity: Vector2<f64>,
}

impl<'a> Curve<'a> {
    /// From the second on that ends at `first`.
    pub(super) fn from(first: Time, transponder: &'a Transponder, cycle: &Cycle<'a>) -> Option<Self> {
        let Cycle { deadline, settings, .. } = *cycle;
        let heard = transponder.last_heard().unwrap_or(EARLIEST);
        let mut walk = transponder.walk(settings)?;
        let ends = (0..).map(|index| first + SECOND * index);
        let known = ends.take_while(|&end| end <= deadline && end + -SECOND < heard);
        let flown = |end| Some(Flown { end, velocity: velocity(&mut walk, middle(end))? });
        let seconds = known.filter_map(flown).collect();
        Some(Self { walk, deadline, end: first, seconds })
    }

    /// The second that ends at `end` is looked at; where the transponder was in its middle.
    pub(super) fn turn(&mut self, end: Time) -> Option<Enu> {
        self.end = end;
        while self.seconds.front().is_some_and(|first| first.end < end) {
            self.seconds.pop_front();
        }
        Some(self.walk.at(middle(end))?.position)
    }
}

/// The middle of the second that ends at `end`.
fn middle(end: Time) -> Time {
    end + -SECOND / 2
}

/// The plots of a radar track within a second, and the transponder's curve.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Second {
    pub(super) look: Look,
    /// Mean difference of the heights, metres, where the radar measures them.
    pub(super) height_m: Option<f64>,
    steps: [Step; 2],
}

impl Second {
    /// That of the curve; `None` where there is no plot.
    fn of(tracklet: &Tracklet, walk: &mut Walk, flown: &Flown, radar: &Radar) -> Option<Self> {
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
        let slow = Slow {
            range_m: errors.bias_range_m,
            azimuth: errors.bias_azimuth * TURNS,
            lasts_s: errors.correlation_s,
        };
        let misaligned = |with: f64, without: f64| (with * with - without * without).max(0.0).sqrt();
        let look = Look {
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
        let step = |axis: usize| Step {
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
fn velocity(walk: &mut Walk, time: Time) -> Option<Vector2<f64>> {
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

/// Where a radar track was seen from a transponder: mean of the plots less the transponder's curve, outward and clockwise,
/// metres.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Offset {
    time: Time,
    offset_m: [f64; 2],
}

impl From<&Look> for Offset {
    fn from(&Look { time, offset_m, .. }: &Look) -> Self {
        Self { time, offset_m }
    }
}

/// A second that is known already, and how the radar track flies up to it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Ahead {
    second: Second,
    motion: Motion,
    /// Log-likelihood of the second if it is another aircraft.
    other: f64,
}

impl From<Second> for Ahead {
    /// How it flies is not known yet.
    fn from(second: Second) -> Self {
        Self { second, motion: Motion::default(), other: 0.0 }
    }
}

/// A radar track as it is seen from a transponder.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Watch {
    motion: Motion,
    /// The looks of the last seconds, up to that which is judged.
    past: VecDeque<Offset>,
    /// The seconds after these, as they were known at a deadline.
    ahead: VecDeque<Ahead>,
    known: Time,
    /// How many looks were near.
    near: u32,
    /// Whether it moved against the transponder, as a radar track that walks off does, or as a transponder's place that jumps.
    walked_off: bool,
    /// What is made of the last look.
    last: Option<Judged>,
}

/// What the association takes a radar track for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum TakenFor {
    /// The transponder's aircraft.
    Own,
    /// That of another transponder.
    Another,
    /// An aircraft without a transponder.
    Nobodys(TargetId),
    /// None yet.
    Nothing,
}

/// What is made of a look.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Judged {
    pub(super) second: Second,
    /// What the association takes the radar track for.
    pub(super) taken_for: TakenFor,
    /// Log-likelihood of the look if it is another aircraft.
    pub(super) other: f64,
    /// How much likelier it flies as the aircraft itself than as another one: by the looks up to this one;
    pub(super) so_far: f64,
    /// How far the medians are from the transponder; below [`NEAR_MAX`] it is near.
    pub(super) away: f64,
    /// and by those ahead, too.
    pub(super) motion: f64,
    /// Whether it was near for so long that it stays the aircraft's own.
    pub(super) is_loyal: bool,
    /// Whether it moves against the transponder as a track that walks off does.
    pub(super) walks_off: bool,
}

impl TakenFor {
    /// The aircraft without a transponder.
    pub(super) fn nobodys(self) -> Option<TargetId> {
        match self {
            Self::Nobodys(target) => Some(target),
            _ => None,
        }
    }
}

impl Judged {
    /// Whether the association takes them for one.
    pub(super) fn is_pair(&self) -> bool {
        self.taken_for == TakenFor::Own
    }

    /// Whether looks up to that one were weighed.
    pub(super) fn is_weighed(&self, until: Option<Time>) -> bool {
        until.is_some_and(|until| self.second.look.time <= until)
    }

    /// Whether it is where the transponder says.
    pub(super) fn is_near(&self) -> bool {
        self.away < NEAR_MAX && self.motion > OTHER_LLR
    }
}

impl Watch {
    pub(super) fn new() -> Self {
        Self {
            motion: Motion::default(),
            past: VecDeque::new(),
            ahead: VecDeque::new(),
            known: EARLIEST,
            near: 0,
            walked_off: false,
            last: None,
        }
    }

    /// Looks at the curve's second, knowing those after it; what is made of it. `jumps`: the transponder's places jump by
    /// themselves, so that it is not the radar track that moves away from them.
    pub(super) fn look(
        &mut self,
        tracklet: &Tracklet,
        curve: &mut Curve,
        (taken_for, jumps): (TakenFor, bool),
        radar: &Radar,
    ) -> Option<&Judged> {
        let now = middle(curve.end);
        if self.known != curve.deadline {
            self.known = curve.deadline;
            let Curve { walk, seconds, .. } = curve;
            let seconds = seconds.iter().filter_map(|flown| Second::of(tracklet, walk, flown, radar));
            self.ahead.clear();
            self.ahead.extend(seconds.map(Ahead::from));
            self.foresee();
        }
        let passed = self.ahead.iter().take_while(|next| next.second.look.time < now).count();
        if passed > 0 {
            // It was too far away to be looked at then.
            self.ahead.drain(..passed);
            self.foresee();
        }
        self.ahead.front().filter(|next| next.second.look.time == now)?;
        let next = self.ahead.pop_front()?;
        self.judge(next, taken_for, jumps);
        self.last.as_ref()
    }

    /// How it flies by the seconds ahead.
    fn foresee(&mut self) {
        let (mut motion, mut before) = (self.motion, self.past.back().map(|last| last.time));
        for Ahead { second, motion: after, other } in &mut self.ahead {
            let time = second.look.time;
            *other = motion.take(second.steps, elapsed_s(before.replace(time), time));
            *after = motion;
        }
    }

    /// Judges a second by those around it.
    fn judge(&mut self, next: Ahead, taken_for: TakenFor, jumps: bool) {
        let now = next.second;
        let time = now.look.time;
        let before = self.past.back().map(|last| last.time);
        self.past.push_back(Offset::from(&now.look));
        let is_around = |one: Time, other: Time| other.seconds_since(one) <= AROUND_S;
        while self.past.front().is_some_and(|first| !is_around(first.time, time)) {
            self.past.pop_front();
        }
        let ahead = self.ahead.iter().map(|ahead| &ahead.second.look);
        let ahead = ahead.take_while(|ahead| is_around(time, ahead.time));
        let last = ahead.clone().last().unwrap_or(&now.look);
        let mut offsets = Vec::with_capacity(self.past.len() + self.ahead.len());
        offsets.extend(self.past.iter().copied());
        offsets.extend(ahead.clone().map(Offset::from));
        let count_ahead = offsets.len() - self.past.len();
        let (walks_off, away) = (walks_off(&offsets, &now.look), away(&offsets, last));
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
        self.last = Some(Judged {
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

    /// The last look at a deadline has been taken: what is ahead is worked out anew at the next one. There are many watches, and
    /// their memory is worth more than a buffer that is at hand.
    pub(super) fn rest(&mut self) {
        self.ahead = VecDeque::new();
    }

    /// What is made of the last look.
    pub(super) fn last(&self) -> Option<&Judged> {
        self.last.as_ref()
    }
}

/// From the look before to one at `time`, seconds; a second where there is none.
fn elapsed_s(before: Option<Time>, time: Time) -> f64 {
    before.map_or(1.0, |before| time.seconds_since(before))
}

/// How far the medians of the offsets are from nothing, in squared deviations as they are at the last of them.
fn away(offsets: &[Offset], last: &Look) -> f64 {
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

/// Whether the radar track moves against the transponder faster than a lie drifts.
fn walks_off(offsets: &[Offset], now: &Look) -> bool {
    let from_now = |offset: &Offset| offset.time.seconds_since(now.time);
    // The offsets come by time.
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
    // Of the times, and of these with the offsets.
    let (mut spread_s2, mut products) = (0.0, [0.0; 2]);
    for offset in around {
        let time_s = from_now(offset) - mean_s;
        spread_s2 += time_s * time_s;
        for (product, offset_m) in products.iter_mut().zip(offset.offset_m) {
            *product += time_s * offset_m;
        }
    }
    let rates = products.map(|product| product / spread_s2);
    let Look { slow, range_m, white_m2, .. } = *now;
    let sigma = |axis: usize| {
        let slow_m = [slow.range_m, slow.azimuth * range_m][axis];
        // A slow error walks by its deviation times sqrt(2 t / τ) in a time t.
        let slow_m2_s2 = slow_m * slow_m * 2.0 / (slow.lasts_s * (2.0 * RATE_AROUND_S));
        (LIE_RATE_M_S * LIE_RATE_M_S + slow_m2_s2 + white_m2[axis] / spread_s2).sqrt()
    };
    let deviations = [0, 1].map(|axis| rates[axis] / sigma(axis));
    rates[0].abs() > RATE_MAX_M_S || deviations[0].hypot(deviations[1]) > RATE_MAX_SIGMAS
}

/// The watches of a transponder, by radar track.
pub(super) type Watches = std::collections::BTreeMap<TrackletId, Watch>;
