//! A radar's tracks in order of arrival: kept or rejected, and steps of the misalignment.

use std::collections::VecDeque;

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

use super::along::{Information, Offset, Sample};
use super::estimate::Misalignment;
use super::parameters::AXES;
use super::qmethod::AttitudeProfile;
use super::sums::{Scatter, Solved, Sums};
use crate::time::Time;

/// A track's weight falls to 1/e in this time, seconds.
const MEMORY_S: f64 = 7200.0;

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one at a time")]
pub enum Taken {
    /// It is part of the estimate.
    Kept,
    /// Its track is an outlier, and plays no part as long as it is one.
    Rejected,
    /// The latest tracks contradict those before: the radar was moved, or its clock or its transponders changed. The estimate
    /// begins anew with them.
    Step {
        /// The estimate without them.
        before: Misalignment,
        /// The estimate from them alone.
        after: Misalignment,
    },
}

/// One of the latest tracks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Latest {
    pub(super) begun: Time,
    pub(super) time: Time,
    pub(super) axes: [Information; AXES],
    pub(super) kept: bool,
    pub(super) spread: Scatter,
}

/// One radar's misalignment, learnt from its tracks.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Registration {
    pub(super) now: Time,
    /// The tracks before the latest.
    pub(super) settled: Sums,
    /// In the order in which they were first heard of.
    pub(super) latest: VecDeque<Latest>,
}

/// Fewer tracks are not compared: neither one with the others, nor the latest with those before.
const ENOUGH: usize = 8;
/// So many tracks are looked at when a step is looked for; one degree of a radar that errs by one takes eleven, one time in ten
/// more than nineteen.
const LATEST: usize = 32;
/// A track further from the others than this many deviations is rejected.
const REJECTED: f64 = 4.0;
/// What one track can say for a step, in its deviations: that a few strays are no step, but a turn by any angle is.
const CLIPPED: f64 = 3.0;
/// The latest tracks are further from those before than this many deviations: a step. With 4.5 two false ones were found in
/// 10,000 tracks, because each new track asks again, three times for each beginning that a step may have had.
const STEP: f64 = 5.0;

/// Of a radar about which nothing is known.
impl Default for Registration {
    fn default() -> Self {
        Self { now: Time::from_nanos(i64::MIN), settled: Sums::none(), latest: VecDeque::new() }
    }
}

impl Registration {
    /// What a piece of a track tells.
    pub fn take(&mut self, sample: &Sample) -> Taken {
        if sample.time > self.now {
            let passed_s = sample.time.seconds_since(self.now);
            self.settled.fade((-passed_s / MEMORY_S).exp());
            self.now = sample.time;
        }
        let place = self.put(sample);
        self.judge();
        let taken = if self.latest[place].kept { Taken::Kept } else { Taken::Rejected };
        let step = self.step();
        if self.latest.len() > LATEST
            && let Some(oldest) = self.latest.pop_front()
        {
            let weight = self.weight(&oldest);
            if oldest.kept {
                self.settled.add(&Sums::of(&oldest.axes, oldest.spread), weight);
            }
        }
        step.unwrap_or(taken)
    }

    /// Takes the track that began then out again, where it is one of the latest.
    pub fn withdraw(&mut self, begun: Time) {
        self.latest.retain(|track| track.begun != begun);
        self.judge();
    }

    /// The misalignment, as far as it is known.
    pub fn estimate(&self) -> Misalignment {
        let mut sums = self.settled.clone();
        for track in self.latest.iter().filter(|track| track.kept) {
            sums.add(&Sums::of(&track.axes, track.spread), self.weight(track));
        }
        Misalignment::of(&sums)
    }

    fn weight(&self, track: &Latest) -> f64 {
        (-self.now.seconds_since(track.time) / MEMORY_S).exp()
    }

    /// Puts a sample to its track; its place.
    fn put(&mut self, sample: &Sample) -> usize {
        if let Some(place) = self.latest.iter().rposition(|track| track.begun == sample.begun) {
            let track = &mut self.latest[place];
            for (sum, axis) in track.axes.iter_mut().zip(&sample.axes) {
                sum.add(axis, 1.0);
            }
            track.time = track.time.max(sample.time);
            return place;
        }
        let Sample { begun, time, axes } = *sample;
        self.latest.push_back(Latest { begun, time, axes, kept: true, spread: Scatter::default() });
        self.latest.len() - 1
    }

    /// Least squares over the settled tracks and the latest that are kept: those before each place, and at last all.
    fn kept(&self) -> impl Iterator<Item = Sums> {
        let settled = Sums { profiles: [AttitudeProfile::none(); 2], ..self.settled.clone() };
        let with = |sums: &mut Sums, track: &Latest| {
            if track.kept {
                let weight = self.weight(track);
                add_axes(&mut sums.axes, &track.axes, weight);
                sums.tracks += weight;
                sums.spread.add(&track.spread, weight);
            }
            Some(sums.clone())
        };
        std::iter::once(settled.clone()).chain(self.latest.iter().scan(settled, with))
    }

    /// Compares each of the latest with all others.
    fn judge(&mut self) {
        let Some(mut all) = self.kept().last() else { return };
        let enough = all.tracks > ENOUGH as f64 || self.latest.len() > ENOUGH;
        let factors = all.spread.factors();
        for place in 0..self.latest.len() {
            let track = &self.latest[place];
            let weight = self.weight(track);
            let mut others = all.axes;
            if track.kept {
                add_axes(&mut others, &track.axes, -weight);
            }
            let solved = Solved::from(&others, &factors);
            let (mut spread, mut far) = (Scatter::default(), false);
            for (axis, factor) in factors.iter().enumerate() {
                let Some(offset) = track.axes[axis].offset(axis) else { continue };
                let (distance, own, theirs) = solved.compare(&offset, axis);
                let square = distance * distance;
                far |= square > REJECTED * REJECTED * (factor * own + theirs);
                // Both variances without the factor: what is looked for is the factor.
                let share = own / (own + theirs / factor);
                spread.squares[axis] = share * square / (own + theirs / factor);
                spread.count[axis] = share;
            }
            let kept = !(enough && far);
            if kept != track.kept {
                let sign = if kept { weight } else { -weight };
                add_axes(&mut all.axes, &track.axes, sign);
            }
            let track = &mut self.latest[place];
            (track.kept, track.spread) = (kept, spread);
        }
    }

    /// Whether the latest tracks, the rejected ones included, tell something else than those before; if so, they are what
    /// remains.
    fn step(&mut self) -> Option<Taken> {
        let (mut most, mut start) = (STEP, None);
        let offsets = self.latest.iter().map(|track| offsets(&track.axes));
        let offsets: Vec<[Option<Offset>; AXES]> = offsets.collect();
        let before: Vec<Sums> = self.kept().take(offsets.len()).collect();
        for (from, before) in before.iter().enumerate().rev() {
            if before.tracks < ENOUGH as f64 {
                break;
            }
            // The spread of those before: what a step adds to it is not to hide the step.
            let factors = before.spread.factors();
            let solved = Solved::from(&before.axes, &factors);
            for (axis, factor) in factors.iter().enumerate() {
                let distance = distance(
                    offsets[from..].iter().filter_map(|track| track[axis].as_ref()),
                    axis,
                    &solved,
                    *factor,
                );
                if distance > most {
                    (most, start) = (distance, Some(from));
                }
            }
        }
        // A step that is likeliest to have been later than that has too few tracks yet.
        let start = start.filter(|start| self.latest.len() - start >= ENOUGH)?;
        let mut before = self.settled.clone();
        for track in self.latest.iter().take(start).filter(|track| track.kept) {
            before.add(&Sums::of(&track.axes, track.spread), self.weight(track));
        }
        self.latest.drain(..start);
        self.settled = Sums { spread: self.settled.spread, ..Sums::none() };
        for track in &mut self.latest {
            track.kept = true;
        }
        self.judge();
        Some(Taken::Step { before: Misalignment::of(&before), after: self.estimate() })
    }
}

/// How far, in deviations, these offsets in an axis lie together from `solved`.
fn distance<'a>(offsets: impl Iterator<Item = &'a Offset>, axis: usize, solved: &Solved, factor: f64) -> f64 {
    let (mut weights, mut sum) = (0.0, 0.0);
    let mut rows = Vector6::zeros();
    for offset in offsets {
        let (distance, own, theirs) = solved.compare(offset, axis);
        let own = factor * own;
        let most = CLIPPED * (own + theirs).sqrt();
        weights += 1.0 / own;
        sum += distance.clamp(-most, most) / own;
        rows += offset.row / own;
    }
    if weights == 0.0 {
        return 0.0;
    }
    let row = rows / weights;
    let variance = 1.0 / weights + row.dot(&(solved.covariance * row));
    (sum / weights).abs() / variance.sqrt()
}

/// The mean offset of each axis.
fn offsets(axes: &[Information; AXES]) -> [Option<Offset>; AXES] {
    std::array::from_fn(|axis| axes[axis].offset(axis))
}

fn add_axes(sum: &mut [Information; AXES], axes: &[Information; AXES], weight: f64) {
    for (sum, axis) in sum.iter_mut().zip(axes) {
        sum.add(axis, weight);
    }
}
