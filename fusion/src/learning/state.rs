//! Saved state of a radar's learning, for a restart.

use serde::{Deserialize, Serialize};

use super::axis::{AXES, AxisSums, GatheredChanges};
use super::pyramid::LEVELS;
use super::radar::RadarLearning;
use super::sizes::{CLASSES, SizeHistogram};
use super::velocity::VelocitySums;
use crate::decimals::{Decimals, WrongNumbers};
use crate::time::Time;

/// State of a radar's learning, serialisable with serde in any format.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearningState {
    version: u32,
    /// Time of the last evidence, nanoseconds since the Unix epoch.
    now: i64,
    plots: Decimals,
    axes: [SavedAxis; AXES],
    /// Count, sum of variances (range rate only), then the histogram of sizes.
    velocity: Decimals,
    range_rate: Decimals,
}

/// Error in a [`LearningState`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LearningStateError {
    /// Written by another version of the service.
    #[error("learning state of version {0}, not {VERSION}")]
    Version(u32),
    /// A list of numbers has the wrong length, or values that are not finite.
    #[error("learning state: {0} numbers where {1} finite ones belong")]
    Numbers(usize, usize),
    /// The numbers contradict each other or are out of range.
    #[error("learning state: nothing follows from its numbers")]
    Senseless,
}

impl From<WrongNumbers> for LearningStateError {
    fn from(WrongNumbers(found, wanted): WrongNumbers) -> Self {
        Self::Numbers(found, wanted)
    }
}

/// Version of the state.
const VERSION: u32 = 1;
/// Maximum of every sum and mean.
const LARGEST: f64 = 1e12;
/// Relative tolerance between the count and the sum of the histogram, which are accumulated separately.
const SAME: f64 = 1e-6;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedAxis {
    changes: [Decimals; LEVELS],
    straight: Decimals,
    turning: Decimals,
}

/// The sums, followed by the histogram: index of the first class that is not empty, and the counts from it to the last
/// such class.
fn saved(sums: &[f64], sizes: &SizeHistogram) -> Decimals {
    let first = sizes.0.iter().position(|&count| count > 0.0).unwrap_or(CLASSES);
    let last = sizes.0.iter().rposition(|&count| count > 0.0).map_or(first, |last| last + 1);
    Decimals::of([sums, &[first as f64], &sizes.0[first..last]])
}

/// Restores sums and histogram. The first sum is a count, for which the histogram has `each` entries.
fn restored<const SUMS: usize>(
    saved: &Decimals,
    each: f64,
) -> Result<([f64; SUMS], SizeHistogram), LearningStateError> {
    let numbers = &saved.0;
    let is_sound = |number: &f64| (0.0..=LARGEST).contains(number);
    let Some((sums, [first, counts @ ..])) = numbers.split_first_chunk::<SUMS>() else {
        return Err(LearningStateError::Numbers(numbers.len(), SUMS + 1));
    };
    if !numbers.iter().all(is_sound) || *first as usize + counts.len() > CLASSES {
        return Err(LearningStateError::Senseless);
    }
    let mut sizes = SizeHistogram::NONE;
    sizes.0[*first as usize..][..counts.len()].copy_from_slice(counts);
    let (count, found) = (sums[0], counts.iter().sum::<f64>());
    let is_one = (found - each * count).abs() <= SAME * found
        && sums.iter().all(|sum| if count > 0.0 { sum / count <= LARGEST } else { *sum == 0.0 });
    if is_one { Ok((*sums, sizes)) } else { Err(LearningStateError::Senseless) }
}

fn saved_gathered(gathered: &GatheredChanges) -> Decimals {
    let GatheredChanges { sizes, count, spacing_s, slow, curve, constant } = gathered;
    saved(&[*count, *spacing_s, *slow, *curve, *constant], sizes)
}

fn gathered(saved: &Decimals) -> Result<GatheredChanges, LearningStateError> {
    let ([count, spacing_s, slow, curve, constant], sizes) = restored(saved, 1.0)?;
    Ok(GatheredChanges { sizes, count, spacing_s, slow, curve, constant })
}

impl RadarLearning {
    /// The state of the learning.
    pub(crate) fn to_state(&self) -> LearningState {
        let axis = |axis: &AxisSums| SavedAxis {
            changes: axis.changes.each_ref().map(saved_gathered),
            straight: saved_gathered(&axis.straight),
            turning: saved_gathered(&axis.turning),
        };
        let VelocitySums { paired, count, radial, radial_count, radial_variance } = &self.velocity;
        LearningState {
            version: VERSION,
            now: self.now.nanos(),
            plots: Decimals(self.plots.to_vec()),
            axes: self.axes.each_ref().map(axis),
            velocity: saved(&[*count], paired),
            range_rate: saved(&[*radial_count, *radial_variance], radial),
        }
    }

    /// Restores the learning.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not valid.
    pub(crate) fn from_state(state: &LearningState) -> Result<Self, LearningStateError> {
        if state.version != VERSION {
            return Err(LearningStateError::Version(state.version));
        }
        let axis = |saved: &SavedAxis| -> Result<AxisSums, LearningStateError> {
            let mut axis = AxisSums::NONE;
            for (change, saved) in axis.changes.iter_mut().zip(&saved.changes) {
                *change = gathered(saved)?;
            }
            (axis.straight, axis.turning) = (gathered(&saved.straight)?, gathered(&saved.turning)?);
            Ok(axis)
        };
        let [range, azimuth, height] = &state.axes;
        let &plots = state.plots.checked()?;
        if !plots.iter().all(|plots| (0.0..=LARGEST).contains(plots)) {
            return Err(LearningStateError::Senseless);
        }
        let ([count], paired) = restored(&state.velocity, 2.0)?;
        let ([radial_count, radial_variance], radial) = restored(&state.range_rate, 1.0)?;
        Ok(Self {
            now: Time::from_nanos(state.now),
            axes: [axis(range)?, axis(azimuth)?, axis(height)?],
            plots,
            velocity: VelocitySums { paired, count, radial, radial_count, radial_variance },
            ..Self::default()
        })
    }
}

impl LearningState {
    /// Time of the last evidence; `None` without any.
    pub fn time(&self) -> Option<Time> {
        (self.now > i64::MIN).then(|| Time::from_nanos(self.now))
    }

    /// Checks whether an engine can restore this state.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not valid.
    pub fn check(&self) -> Result<(), LearningStateError> {
        RadarLearning::from_state(self).map(drop)
    }
}
