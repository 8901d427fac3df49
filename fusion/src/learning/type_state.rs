//! The state of a type of transponders that is kept across restarts.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::noise::{COUNT, WhiteNoise};
use super::state::LearningStateError;
use super::transponders::TypeLearning;
use crate::decimals::Decimals;
use crate::registration::DelaySums;
use crate::report::{SensorIndex, TransponderType};
use crate::time::Time;

/// The learnt properties of a type of transponders, serialisable in any format of serde. Sensors have the indices of the engine's
/// settings.
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

/// Version of the layout; the only one so far.
const VERSION: u32 = 1;
/// Bound of the logarithms of weights and of the information.
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

    /// The type and its learnt properties.
    ///
    /// # Errors
    /// The state has another version, or its numbers are invalid.
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

    /// The state with other sensor indices. Radars without an index are left out; `None` if the receiver has none.
    #[must_use]
    pub fn renumbered(mut self, number: impl Fn(SensorIndex) -> Option<SensorIndex>) -> Option<Self> {
        self.receiver = number(SensorIndex(self.receiver))?.0;
        let delays = std::mem::take(&mut self.delays).into_iter();
        self.delays =
            delays.filter_map(|(radar, sums)| Some((number(SensorIndex(radar))?.0, sums))).collect();
        Some(self)
    }

    /// Time of the latest report of the type.
    pub fn time(&self) -> Time {
        Time::from_nanos(self.heard)
    }

    /// Checks whether an engine can restore the state.
    ///
    /// # Errors
    /// The state has another version, or its numbers are invalid.
    pub fn check(&self) -> Result<(), LearningStateError> {
        self.restored().map(drop)
    }
}

#[cfg(test)]
mod tests;
