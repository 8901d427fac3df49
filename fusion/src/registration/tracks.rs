//! A radar's tracks in order of arrival: kept or rejected, and steps of the misalignment.

use std::collections::VecDeque;

use nalgebra::Vector6;
use serde::{Deserialize, Serialize};

use super::along::{Information, MeanOffset, Sample};
use super::estimate::Misalignment;
use super::parameters::AXES;
use super::qmethod::AttitudeProfile;
use super::sums::{MisalignmentSums, Scatter, SolvedSums};
use crate::time::Time;

/// Time in which a track's weight decays to 1/e, seconds.
const MEMORY_S: f64 = 7200.0;

/// Result of adding a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one at a time")]
pub enum SampleOutcome {
    /// The track is part of the estimate.
    Kept,
    /// The track is an outlier, and is ignored while it remains one.
    Rejected,
    /// The latest tracks contradict the earlier ones: the radar was moved, or its clock or its transponders changed. The estimate
    /// restarts with the latest tracks.
    Step {
        /// Estimate without the latest tracks.
        before: Misalignment,
        /// Estimate from the latest tracks alone.
        after: Misalignment,
    },
}

/// One of the latest tracks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LatestTrack {
    pub(super) begun: Time,
    pub(super) time: Time,
    pub(super) axes: [Information; AXES],
    pub(super) kept: bool,
    pub(super) spread: Scatter,
}

/// Misalignment of one radar, learnt from its tracks.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Registration {
    pub(super) now: Time,
    /// Sums of the tracks before the latest.
    pub(super) settled: MisalignmentSums,
    /// Latest tracks, in order of their first sample.
    pub(super) latest: VecDeque<LatestTrack>,
}

/// Minimum number of tracks for a comparison of one with the others, or of the latest with the earlier ones.
const ENOUGH: usize = 8;
/// Number of latest tracks that are searched for a step. A step of one degree, in a radar with errors of one degree, takes eleven
/// tracks; one time in ten more than nineteen.
const LATEST: usize = 32;
/// Number of deviations from the other tracks above which a track is rejected.
const REJECTED: f64 = 4.0;
/// Maximum contribution of one track to a step, in deviations. A few outliers are then no step, but a rotation by any angle is.
const CLIPPED: f64 = 3.0;
/// Number of deviations between the latest and the earlier tracks above which there is a step. With 4.5, 10,000 tracks gave two
/// false steps, because each new track repeats three tests for each possible beginning.
const STEP: f64 = 5.0;

/// A radar without evidence.
impl Default for Registration {
    fn default() -> Self {
        Self { now: Time::from_nanos(i64::MIN), settled: MisalignmentSums::none(), latest: VecDeque::new() }
    }
}

impl Registration {
    /// Adds a segment of a track.
    pub fn add(&mut self, sample: &Sample) -> SampleOutcome {
        if sample.time > self.now {
            let passed_s = sample.time.seconds_since(self.now);
            self.settled.fade((-passed_s / MEMORY_S).exp());
            self.now = sample.time;
        }
        let place = self.add_to_track(sample);
        self.compare_latest();
        let taken = if self.latest[place].kept { SampleOutcome::Kept } else { SampleOutcome::Rejected };
        let step = self.step();
        if self.latest.len() > LATEST
            && let Some(oldest) = self.latest.pop_front()
        {
            let weight = self.weight(&oldest);
            if oldest.kept {
                self.settled.add(&MisalignmentSums::of(&oldest.axes, oldest.spread), weight);
            }
        }
        step.unwrap_or(taken)
    }

    /// Removes the track that began at this time, if it is one of the latest.
    pub fn withdraw(&mut self, begun: Time) {
        self.latest.retain(|track| track.begun != begun);
        self.compare_latest();
    }

    /// The estimated misalignment.
    pub fn estimate(&self) -> Misalignment {
        let mut sums = self.settled.clone();
        for track in self.latest.iter().filter(|track| track.kept) {
            sums.add(&MisalignmentSums::of(&track.axes, track.spread), self.weight(track));
        }
        Misalignment::of(&sums)
    }

    fn weight(&self, track: &LatestTrack) -> f64 {
        (-self.now.seconds_since(track.time) / MEMORY_S).exp()
    }

    /// Adds a sample to its track. Returns the track's index.
    fn add_to_track(&mut self, sample: &Sample) -> usize {
        if let Some(place) = self.latest.iter().rposition(|track| track.begun == sample.begun) {
            let track = &mut self.latest[place];
            for (sum, axis) in track.axes.iter_mut().zip(&sample.axes) {
                sum.add(axis, 1.0);
            }
            track.time = track.time.max(sample.time);
            return place;
        }
        let Sample { begun, time, axes, .. } = *sample;
        self.latest.push_back(LatestTrack { begun, time, axes, kept: true, spread: Scatter::default() });
        self.latest.len() - 1
    }

    /// Least squares over the settled and the kept latest tracks: before each of the latest, and finally over all.
    fn accumulated(&self) -> impl Iterator<Item = MisalignmentSums> {
        let settled = MisalignmentSums { profiles: [AttitudeProfile::none(); 2], ..self.settled.clone() };
        let with = |sums: &mut MisalignmentSums, track: &LatestTrack| {
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

    /// Compares each of the latest tracks with all others.
    fn compare_latest(&mut self) {
        let Some(mut all) = self.accumulated().last() else { return };
        let enough = all.tracks > ENOUGH as f64 || self.latest.len() > ENOUGH;
        let factors = all.spread.factors();
        for place in 0..self.latest.len() {
            let track = &self.latest[place];
            let weight = self.weight(track);
            let mut others = all.axes;
            if track.kept {
                add_axes(&mut others, &track.axes, -weight);
            }
            let solved = SolvedSums::from(&others, &factors);
            let (mut spread, mut far) = (Scatter::default(), false);
            for (axis, factor) in factors.iter().enumerate() {
                let Some(offset) = track.axes[axis].offset(axis) else { continue };
                let (distance, own, theirs) = solved.compare(&offset, axis);
                let square = distance * distance;
                far |= square > REJECTED * REJECTED * (factor * own + theirs);
                // Both variances exclude the factor, because it is to be determined.
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

    /// Tests whether the latest tracks, rejected ones included, contradict the earlier ones. If so, only the latest remain.
    fn step(&mut self) -> Option<SampleOutcome> {
        let (mut most, mut start) = (STEP, None);
        let offsets = self.latest.iter().map(|track| offsets(&track.axes));
        let offsets: Vec<[Option<MeanOffset>; AXES]> = offsets.collect();
        let before: Vec<MisalignmentSums> = self.accumulated().take(offsets.len()).collect();
        for (from, before) in before.iter().enumerate().rev() {
            if before.tracks < ENOUGH as f64 {
                break;
            }
            // Scatter of the earlier tracks: the step itself must not increase it and hide the step.
            let factors = before.spread.factors();
            let solved = SolvedSums::from(&before.axes, &factors);
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
        // A step that most likely began later has too few tracks so far.
        let start = start.filter(|start| self.latest.len() - start >= ENOUGH)?;
        let mut before = self.settled.clone();
        for track in self.latest.iter().take(start).filter(|track| track.kept) {
            before.add(&MisalignmentSums::of(&track.axes, track.spread), self.weight(track));
        }
        self.latest.drain(..start);
        self.settled = MisalignmentSums { spread: self.settled.spread, ..MisalignmentSums::none() };
        for track in &mut self.latest {
            track.kept = true;
        }
        self.compare_latest();
        Some(SampleOutcome::Step { before: Misalignment::of(&before), after: self.estimate() })
    }
}

/// Mean distance of these offsets on an axis from `solved`, in deviations.
fn distance<'a>(
    offsets: impl Iterator<Item = &'a MeanOffset>,
    axis: usize,
    solved: &SolvedSums,
    factor: f64,
) -> f64 {
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

/// Mean offset on each axis.
fn offsets(axes: &[Information; AXES]) -> [Option<MeanOffset>; AXES] {
    std::array::from_fn(|axis| axes[axis].offset(axis))
}

fn add_axes(sum: &mut [Information; AXES], axes: &[Information; AXES], weight: f64) {
    for (sum, axis) in sum.iter_mut().zip(axes) {
        sum.add(axis, weight);
    }
}
