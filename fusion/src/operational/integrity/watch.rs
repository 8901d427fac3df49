//! What radar tracks show of a transponder, second by second.

use std::collections::VecDeque;

use jiff::SignedDuration;
use nalgebra::Vector2;

use crate::filter::LineOfSight;
use crate::frames::Enu;
use crate::integrity::{Look, Motion, Slow, Step};
use crate::operational::ids::{TargetId, TrackletId};
use crate::operational::settings::{Radar, Settings};
use crate::operational::tracklets::Tracklet;
use crate::operational::transponder::Transponder;
use crate::time::Time;

/// The length of a look.
pub(super) const SECOND: SignedDuration = SignedDuration::from_secs(1);
/// Turns make the slow error of an azimuth larger, by so much at worst: what is learnt is the mean over all flying.
const TURNS: f64 = 1.8;
/// A look is judged by those up to this before and after it, seconds;
const AROUND_S: i64 = 6;
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

/// The plots of a radar track within a second, and the transponder's curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Second {
    pub(super) look: Look,
    /// Mean difference of the heights, metres, where the radar measures them.
    pub(super) height_m: Option<f64>,
    steps: [Step; 2],
}

impl Second {
    /// The second that ends at `end`; `None` where there is no plot, or no curve.
    fn of(
        tracklet: &Tracklet,
        transponder: &Transponder,
        end: Time,
        radar: &Radar,
        settings: &Settings,
    ) -> Option<Self> {
        let middle = end + -SECOND / 2;
        let plots = tracklet.between(end + -SECOND, end);
        let (mut count, mut heights) = (0.0, 0.0);
        let (mut up_m, mut curve_m2) = (0.0, 0.0);
        let (mut place, mut offset) = (Vector2::zeros(), [0.0; 2]);
        for plot in plots {
            let Some(curve) = transponder.on_curve(plot.time, settings) else { continue };
            let seen = LineOfSight::from(radar.position, plot.position);
            let apart = (plot.position.0 - curve.position.0).xy();
            offset[0] += seen.outward.dot(&apart);
            offset[1] += seen.clockwise.dot(&apart);
            place += plot.position.0.xy();
            curve_m2 += curve.sigma_m * curve.sigma_m;
            count += 1.0;
            if plot.height_measured {
                up_m += plot.position.0.z - curve.position.0.z;
                heights += 1.0;
            }
        }
        if count == 0.0 {
            return None;
        }
        let velocity = velocity(transponder, middle, settings)?;
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
            time: middle,
            radar: tracklet.key.sensor,
            track: tracklet.id.0,
            offset_m: offset,
            white_m2: plots_m2.map(|white_m2| white_m2 + curve_m2),
            axes: [seen.outward, seen.clockwise],
            range_m: seen.range_m,
            velocity,
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
fn velocity(transponder: &Transponder, time: Time, settings: &Settings) -> Option<Vector2<f64>> {
    let half = SECOND / 2;
    let at = |time| Some(transponder.on_curve(time, settings)?.position.0.xy());
    let (before, now, after) = (at(time + -half), at(time), at(time + half));
    match (before, now, after) {
        (Some(before), _, Some(after)) => Some(after - before),
        (Some(before), Some(now), None) => Some((now - before) * 2.0),
        (None, Some(now), Some(after)) => Some((after - now) * 2.0),
        _ => None,
    }
}

/// A radar track as it is seen from a transponder.
#[derive(Debug)]
pub(super) struct Watch {
    motion: Motion,
    /// The looks of the last seconds, up to that which is judged.
    past: VecDeque<Second>,
    /// How many looks were near.
    near: u32,
    /// Whether it moved against the transponder, as a radar track that walks off does, or as a transponder's place that jumps.
    walked_off: bool,
    /// What is made of the last look.
    last: Option<Judged>,
}

/// What the association takes a radar track for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
#[derive(Clone, Copy, Debug)]
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
        Self { motion: Motion::default(), past: VecDeque::new(), near: 0, walked_off: false, last: None }
    }

    /// Looks at the second that ends at `end`, knowing those up to `known`. `jumps`: the transponder's places jump by
    /// themselves, so that it is not the radar track that moves away from them.
    pub(super) fn look(
        &mut self,
        tracklet: &Tracklet,
        transponder: &Transponder,
        (end, known): (Time, Time),
        (taken_for, jumps): (TakenFor, bool),
        radar: &Radar,
        settings: &Settings,
    ) {
        let of = |end| Second::of(tracklet, transponder, end, radar, settings);
        let Some(now) = of(end) else { return };
        let before = self.past.back().copied();
        self.past.push_back(now);
        let around = |second: &Second| now.look.time.seconds_since(second.look.time) <= AROUND_S as f64;
        while self.past.front().is_some_and(|first| !around(first)) {
            self.past.pop_front();
        }
        let ahead = (1..=AROUND_S).map(|ahead| end + SECOND * ahead as i32);
        let ahead = ahead.take_while(|&ahead| ahead <= known).filter_map(of);
        let seconds: Vec<Second> = self.past.iter().copied().chain(ahead).collect();
        let walks_off = walks_off(&seconds, &now);
        let other = match walks_off {
            true if jumps => 0.0,
            false if jumps && self.walked_off => {
                self.motion.take_elsewhere(now.steps, elapsed_s(before.as_ref(), &now))
            }
            _ => self.motion.take(now.steps, elapsed_s(before.as_ref(), &now)),
        };
        self.walked_off = walks_off;
        let so_far = self.motion.llr();
        let mut motion = self.motion;
        for pair in seconds[self.past.len() - 1..].windows(2) {
            motion.take(pair[1].steps, elapsed_s(Some(&pair[0]), &pair[1]));
        }
        let away = away(&seconds);
        let is_near = away < NEAR_MAX;
        self.near += u32::from(is_near);
        self.last = Some(Judged {
            second: now,
            taken_for,
            other,
            so_far,
            away,
            motion: motion.llr(),
            is_loyal: self.near >= LOYAL_LOOKS && so_far > OTHER_LLR,
            walks_off,
        });
    }

    /// What is made of the last look.
    pub(super) fn last(&self) -> Option<&Judged> {
        self.last.as_ref()
    }
}

fn elapsed_s(before: Option<&Second>, now: &Second) -> f64 {
    before.map_or(1.0, |before| now.look.time.seconds_since(before.look.time))
}

/// How far the medians of the offsets are from nothing, in squared deviations.
fn away(seconds: &[Second]) -> f64 {
    let Some(last) = seconds.last().map(|second| &second.look) else { return f64::INFINITY };
    let sigmas = [
        last.slow.range_m.hypot(last.alignment[0]).hypot(HONEST_M),
        (last.slow.azimuth.hypot(last.alignment[1]) * last.range_m).hypot(HONEST_M),
    ];
    let squared = |axis: usize| {
        let offsets = seconds.iter().map(|second| second.look.offset_m[axis]).collect();
        (median(offsets) / (NEAR_SIGMAS[axis] * sigmas[axis])).powi(2)
    };
    squared(0) + squared(1)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let half = values.len() / 2;
    if values.len() % 2 == 1 { values[half] } else { (values[half - 1] + values[half]) / 2.0 }
}

/// Whether the radar track moves against the transponder faster than a lie drifts.
fn walks_off(seconds: &[Second], now: &Second) -> bool {
    let from_now = |second: &&Second| second.look.time.seconds_since(now.look.time);
    let around: Vec<&Second> =
        seconds.iter().filter(|second| from_now(second).abs() <= RATE_AROUND_S).collect();
    let count = around.len() as f64;
    if around.len() < 3 {
        return false;
    }
    let mean_s = around.iter().map(from_now).sum::<f64>() / count;
    let spread_s2: f64 = around.iter().map(|second| (from_now(second) - mean_s).powi(2)).sum();
    let rate = |axis: usize| {
        let products = around.iter().map(|second| (from_now(second) - mean_s) * second.look.offset_m[axis]);
        products.sum::<f64>() / spread_s2
    };
    let Look { slow, range_m, white_m2, .. } = now.look;
    let sigma = |axis: usize| {
        let slow_m = [slow.range_m, slow.azimuth * range_m][axis];
        // A slow error walks by its deviation times sqrt(2 t / τ) in a time t.
        let slow_m2_s2 = slow_m * slow_m * 2.0 / (slow.lasts_s * (2.0 * RATE_AROUND_S));
        (LIE_RATE_M_S * LIE_RATE_M_S + slow_m2_s2 + white_m2[axis] / spread_s2).sqrt()
    };
    let deviations = [0, 1].map(|axis| rate(axis) / sigma(axis));
    rate(0).abs() > RATE_MAX_M_S || deviations[0].hypot(deviations[1]) > RATE_MAX_SIGMAS
}

/// The watches of a transponder, by radar track.
pub(super) type Watches = std::collections::BTreeMap<TrackletId, Watch>;
