//! What outlives a restart of what is known of a type of transponders.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::LearningStateError;
use super::noise::{COUNT, WhiteNoise};
use super::transponders::TypeLearning;
use crate::decimals::Decimals;
use crate::registration::DelaySums;
use crate::report::{SensorIndex, TransponderType};
use crate::time::Time;

/// All that was learnt of a type of transponders, to be written down by serde in any format. Sensors are numbers, as they stand
/// in the engine's settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TypeState {
    version: u32,
    receiver: u16,
    manufacturer: Option<[u8; 3]>,
    model: Option<[u8; 3]>,
    /// Nanoseconds since the Unix epoch.
    heard: i64,
    reports: u64,
    noise: [Decimals; 2],
    delays: BTreeMap<u16, Decimals>,
}

/// The only version so far.
const VERSION: u32 = 1;
/// No logarithm of a weight is smaller, no information larger.
const LARGEST: f64 = 1e12;

impl TypeState {
    pub(crate) fn of(kind: &TransponderType, learning: &TypeLearning) -> Self {
        let &TransponderType { receiver, manufacturer, model } = kind;
        let delays =
            learning.delays.iter().map(|(radar, sums)| (radar.0, Decimals(sums.to_numbers().to_vec())));
        Self {
            version: VERSION,
            receiver: receiver.0,
            manufacturer,
            model,
            heard: learning.heard.nanos(),
            reports: learning.reports,
            noise: learning.noise.each_ref().map(|noise| Decimals(noise.weights().to_vec())),
            delays: delays.collect(),
        }
    }

    /// The type, and what is known of it.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not what is written.
    pub(crate) fn restored(&self) -> Result<(TransponderType, TypeLearning), LearningStateError> {
        if self.version != VERSION {
            return Err(LearningStateError::Version(self.version));
        }
        let are_sound = |numbers: &[f64]| match numbers.iter().all(|number| number.abs() <= LARGEST) {
            true => Ok(()),
            false => Err(LearningStateError::Senseless),
        };
        let mut learning = TypeLearning {
            reports: self.reports,
            heard: Time::from_nanos(self.heard),
            ..TypeLearning::default()
        };
        for (noise, saved) in learning.noise.iter_mut().zip(&self.noise) {
            let weights: &[f64; COUNT] = saved.checked()?;
            are_sound(weights)?;
            if weights.iter().any(|&log| log > 0.0) || !weights.contains(&0.0) {
                return Err(LearningStateError::Senseless);
            }
            *noise = WhiteNoise::from_weights(weights);
        }
        for (&radar, saved) in &self.delays {
            let numbers: &[f64; DelaySums::NUMBERS] = saved.checked()?;
            are_sound(numbers)?;
            learning.delays.insert(SensorIndex(radar), DelaySums::from_numbers(numbers));
        }
        let Self { receiver, manufacturer, model, .. } = *self;
        Ok((TransponderType { receiver: SensorIndex(receiver), manufacturer, model }, learning))
    }

    /// The same where the sensors have other numbers: without the radars that have none; `None` where the receiver has none.
    #[must_use]
    pub fn renumbered(mut self, number: impl Fn(SensorIndex) -> Option<SensorIndex>) -> Option<Self> {
        self.receiver = number(SensorIndex(self.receiver))?.0;
        let delays = std::mem::take(&mut self.delays).into_iter();
        self.delays =
            delays.filter_map(|(radar, sums)| Some((number(SensorIndex(radar))?.0, sums))).collect();
        Some(self)
    }

    /// When one of them was heard last.
    pub fn time(&self) -> Time {
        Time::from_nanos(self.heard)
    }

    /// Whether an engine could go on with it.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not what is written.
    pub fn check(&self) -> Result<(), LearningStateError> {
        self.restored().map(drop)
    }
}

#[cfg(test)]
mod tests;
