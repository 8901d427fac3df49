//! Detection of a common rotation in the azimuth offsets of several identities.
//!
//! A radar on the ground stands still, or is knocked. Offsets that rotate steadily come from transponders, or from a radar that
//! is not fixed: neither may be learnt. The accuracy of the slope is estimated by the jackknife, which leaves out one radar track
//! or one block of time at a time. The radar's stated errors are not used, because false positions derived from the radar's plots
//! hardly scatter.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::along::wrapped;
use crate::report::{Host, Identity};
use crate::time::{SECOND, Time};

/// Length of a bin over which an identity's offsets are averaged, nanoseconds.
pub(super) const BIN_NS: i64 = 2 * SECOND;
/// Windows in which a slope is estimated: length of a block in bins, and number of blocks. Several blocks help when few
/// identities are seen for long.
const WINDOWS: [(i64, i64); 20] = [
    (5, 1),
    (6, 1),
    (8, 1),
    (10, 1),
    (12, 1),
    (15, 1),
    (20, 1),
    (25, 1),
    (30, 1),
    (40, 1),
    (55, 1),
    (75, 1),
    (105, 1),
    (150, 1),
    (5, 3),
    (10, 3),
    (20, 3),
    (10, 6),
    (25, 6),
    (50, 3),
];
/// Number of bins kept per identity.
const KEPT: i64 = 150;
/// Maximum number of identities kept per radar.
const IDENTITIES_MAX: usize = 256;
/// Minimum number of deviations of a slope that is examined further.
const STEEP: f64 = 2.0;
/// Minimum number of witnesses, each weighted by its share in the slope.
const EFFECTIVE_MIN: f64 = 2.5;
/// Standard deviation of a change that is common to identities without a cause, radians, such as errors of satellite positions.
const COMMON: f64 = 0.02_f64.to_radians();
/// Number of positions at which a step is tested.
const STEPS: i64 = 16;
/// Maximum unknown delay of the transponders' reports, seconds. Drones that rotate together around the radar show it as a slope.
const DELAY_S: f64 = 0.3;

/// Azimuth offset of a plot of an identity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AzimuthOffset {
    pub(crate) time: Time,
    /// Beginning of the radar track.
    pub(crate) begun: Time,
    /// Plot minus target, radians.
    pub(crate) offset: f64,
    /// Rate of the target's azimuth, radians a second.
    pub(crate) rate: f64,
}

/// Azimuth offsets of the identities seen by one radar, over the last minutes.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct CreepMonitor {
    offsets: BTreeMap<(Host, Identity), VecDeque<OffsetBin>>,
}

/// Means of an identity over one bin.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct OffsetBin {
    /// Number of the bin since the epoch.
    index: i64,
    /// Beginning of the radar track.
    begun: Time,
    offset: f64,
    rate: f64,
    plots: u32,
}

/// A slope that is common to several identities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Trend {
    /// Host that reports these identities; `None`: several hosts.
    pub(crate) host: Option<Host>,
    /// Slope of the azimuth offsets, radians a second.
    pub(crate) rate: f64,
    /// Length of the window, seconds.
    pub(crate) window_s: f64,
    /// Distance of the slope from zero, standard deviations of a normal distribution.
    pub(crate) deviations: f64,
}

impl Trend {
    /// Change of the offsets over the window, radians.
    pub(crate) fn change(&self) -> f64 {
        (self.rate * self.window_s).abs()
    }
}

/// Weighted sums of bins: x is time in bins, y the offset, v the rate of the azimuth.
#[derive(Clone, Copy, Debug, Default)]
struct TrendSums {
    count: f64,
    x: f64,
    y: f64,
    v: f64,
    xx: f64,
    xy: f64,
    xv: f64,
    vy: f64,
    vv: f64,
}

impl TrendSums {
    fn add(&mut self, other: &Self, weight: f64) {
        let Self { count, x, y, v, xx, xy, xv, vy, vv } = other;
        self.count += weight * count;
        self.x += weight * x;
        self.y += weight * y;
        self.v += weight * v;
        self.xx += weight * xx;
        self.xy += weight * xy;
        self.xv += weight * xv;
        self.vy += weight * vy;
        self.vv += weight * vv;
    }

    /// The sums about their means.
    fn centred(&self) -> Self {
        let Self { count, x, y, v, xx, xy, xv, vy, vv } = *self;
        if count <= 0.0 {
            return Self::default();
        }
        Self {
            count,
            xx: (xx - x * x / count).max(0.0),
            xy: xy - x * y / count,
            xv: xv - x * v / count,
            vy: vy - v * y / count,
            vv: (vv - v * v / count).max(0.0),
            ..Self::default()
        }
    }

    /// Slope for this delay; requires centred sums.
    fn slope(&self, delay_s: f64) -> f64 {
        (self.xy - delay_s * self.xv) / self.xx
    }

    /// Delay that, with a slope, explains most of the offsets, seconds; requires centred sums.
    fn delay_s(&self) -> f64 {
        let Self { xx, xy, xv, vy, vv, .. } = *self;
        let determinant = xx * vv - xv * xv;
        if determinant <= 1e-9 * xx * vv {
            return 0.0;
        }
        ((xx * vy - xv * xy) / determinant).clamp(-DELAY_S, DELAY_S)
    }
}

impl CreepMonitor {
    /// Adds a plot of an identity. Returns false if too many identities are kept.
    pub(crate) fn add(&mut self, of: (Host, Identity), turned: &AzimuthOffset) -> bool {
        let AzimuthOffset { time, begun, offset, rate } = *turned;
        let index = bin(time);
        if self.offsets.len() >= IDENTITIES_MAX && !self.offsets.contains_key(&of) {
            return false;
        }
        let bins = self.offsets.entry(of).or_default();
        match bins.back_mut() {
            Some(last) if last.index == index && last.begun == begun => {
                last.plots += 1;
                let share = 1.0 / f64::from(last.plots);
                last.offset += wrapped(offset - last.offset) * share;
                last.rate += (rate - last.rate) * share;
            }
            Some(last) if last.index > index => {}
            _ => bins.push_back(OffsetBin { index, begun, offset, rate, plots: 1 }),
        }
        true
    }

    /// Number of identities per host.
    pub(crate) fn identities(&self) -> BTreeMap<Host, usize> {
        let mut number = BTreeMap::new();
        self.offsets.keys().for_each(|(host, _)| *number.entry(*host).or_default() += 1);
        number
    }

    /// Removes the identities of these hosts.
    pub(crate) fn remove(&mut self, hosts: &BTreeSet<Host>) {
        self.offsets.retain(|(host, _), _| !hosts.contains(host));
    }

    /// Slopes of the windows that end with the last complete bin before `now`. Slopes that a step explains better are left out.
    pub(crate) fn trends(&mut self, now: Time) -> Vec<Trend> {
        let end = bin(now);
        for bins in self.offsets.values_mut() {
            while bins.front().is_some_and(|first| first.index < end - KEPT) {
                bins.pop_front();
            }
        }
        self.offsets.retain(|_, bins| !bins.is_empty());
        let hosts = self.identities();
        let several = (hosts.len() > 1).then_some(None);
        let groups = hosts.into_keys().map(Some).chain(several);
        let windows = groups.flat_map(|host| WINDOWS.into_iter().map(move |window| (host, window)));
        windows.filter_map(|(host, window)| self.trend_of(host, end, window)).collect()
    }

    /// Slope of a window; `None` with too few identities, or if it is not steep.
    fn trend_of(&self, host: Option<Host>, end: i64, (length, number): (i64, i64)) -> Option<Trend> {
        let group = || self.offsets.iter().filter(move |((of, _), _)| host.is_none_or(|host| *of == host));
        let window = length * number;
        let begin = end - window;
        // A window longer than the data would exaggerate the change.
        let first = group().filter_map(|(_, bins)| bins.front()).map(|bin| bin.index).min()?;
        if first > begin + 1 {
            return None;
        }
        // With one block, all tracks share one constant, and each radar track is a witness. With several, each block of an
        // identity has its own constant, and is a witness. Two hosts that report the same identity count as one witness.
        let has_own = number > 1;
        let zero = group().next()?.1.front()?.offset;
        let mut parts = Vec::<((Identity, i64), TrendSums)>::new();
        for ((_, identity), bins) in group() {
            for bin in within(bins, begin..end) {
                let block = (bin.index - begin) / length;
                let x = (bin.index - begin - block * length) as f64;
                let part = (*identity, if has_own { block } else { bin.begun.nanos() });
                let of_bin = bin.sums(x, wrapped(bin.offset - zero));
                match parts.last_mut() {
                    Some((last, sums)) if *last == part => sums.add(&of_bin, 1.0),
                    _ => parts.push((part, of_bin)),
                }
            }
        }
        parts.sort_by_key(|(part, _)| *part);
        parts.dedup_by(|(part, sums), (before, all)| {
            let is_same = part == before;
            if is_same {
                all.add(sums, 1.0);
            }
            is_same
        });
        let mut parts: Vec<TrendSums> = parts.into_iter().map(|(_, sums)| sums).collect();
        let mut total = TrendSums::default();
        if has_own {
            parts.iter_mut().for_each(|part| *part = part.centred());
        }
        parts.iter().for_each(|part| total.add(part, 1.0));
        let all = if has_own { total } else { total.centred() };
        let mean = if has_own { 0.0 } else { total.x / total.count };
        let xx = |part: &TrendSums| part.xx - 2.0 * mean * part.x + mean * mean * part.count;
        let squares: f64 = parts.iter().map(|part| xx(part) * xx(part)).sum();
        let effective = if squares > 0.0 { all.xx * all.xx / squares } else { 0.0 };
        if effective < EFFECTIVE_MIN {
            return None;
        }
        let common = COMMON / window as f64;
        // The smaller result of two: without delay, and with the delay that explains most.
        let [(slope, deviations), other] = [0.0, all.delay_s()].map(|delay_s| {
            let slope = all.slope(delay_s);
            // Jackknife: the slope without each witness.
            let without = parts.iter().map(|part| {
                let mut rest = total;
                rest.add(part, -1.0);
                let rest = if has_own { rest } else { rest.centred() };
                let off = if rest.xx > 1e-9 * all.xx { rest.slope(delay_s) - slope } else { slope };
                off * off
            });
            let count = parts.len() as f64;
            let variance = (count - 1.0) / count * without.sum::<f64>() + common * common;
            (slope, normal(slope / variance.sqrt(), effective - 1.0))
        });
        let (slope, deviations) = if other.1 < deviations { other } else { (slope, deviations) };
        let explained = all.xy * all.xy / all.xx;
        if deviations < STEEP || self.is_step(&group(), (begin, length, number), explained) {
            return None;
        }
        let bin_s = BIN_NS as f64 / SECOND as f64;
        Some(Trend { host, rate: slope / bin_s, window_s: window as f64 * bin_s, deviations })
    }

    /// Whether a step at some bin explains more of the offsets than a slope.
    fn is_step<'a>(
        &self,
        group: &(impl Iterator<Item = (&'a (Host, Identity), &'a VecDeque<OffsetBin>)> + Clone),
        (begin, length, number): (i64, i64, i64),
        explained: f64,
    ) -> bool {
        let zero = group.clone().find_map(|(_, bins)| bins.front()).map_or(0.0, |bin| bin.offset);
        let (end, apart) = (begin + length * number, (length * number / STEPS).max(1));
        // The bins with their offsets, which are the same for each step.
        let turned = |bin: &OffsetBin| (*bin, wrapped(bin.offset - zero));
        let known: Vec<Vec<(OffsetBin, f64)>> =
            group.clone().map(|(_, bins)| within(bins, begin..end).map(turned).collect()).collect();
        (begin + 1..end).step_by(apart as usize).any(|step| {
            let from = begin + (step - begin) / length * length;
            let mut total = TrendSums::default();
            for bins in &known {
                let mut own = TrendSums::default();
                let first = bins.partition_point(|(bin, _)| bin.index < from);
                for (bin, y) in bins[first..].iter().take_while(|(bin, _)| bin.index < from + length) {
                    own.add(&bin.sums(f64::from(u8::from(bin.index >= step)), *y), 1.0);
                }
                total.add(&if number > 1 { own.centred() } else { own }, 1.0);
            }
            let all = if number > 1 { total } else { total.centred() };
            all.xx > 0.0 && all.xy * all.xy / all.xx > explained
        })
    }
}

impl OffsetBin {
    /// Sums of this bin at `x`; `y` is its offset.
    fn sums(&self, x: f64, y: f64) -> TrendSums {
        let (v, count) = (self.rate, f64::from(self.plots));
        let mut sums = TrendSums::default();
        let one = TrendSums { count: 1.0, x, y, v, xx: x * x, xy: x * y, xv: x * v, vy: v * y, vv: v * v };
        sums.add(&one, count);
        sums
    }
}

pub(super) fn bin(time: Time) -> i64 {
    time.nanos().div_euclid(BIN_NS)
}

/// The bins of an identity in a window.
fn within(bins: &VecDeque<OffsetBin>, window: Range<i64>) -> impl Iterator<Item = &OffsetBin> {
    let begin = bins.partition_point(|bin| bin.index < window.start);
    let end = bins.partition_point(|bin| bin.index < window.end);
    bins.range(begin..end)
}

/// Quantile of the normal distribution with the probability of Student's t (D. L. Wallace, 1959).
fn normal(t: f64, freedom: f64) -> f64 {
    (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0) * (freedom * (t * t / freedom).ln_1p()).sqrt()
}
