//! What outlives a restart.
//!
//! Numbers are lists of decimal text, separated by spaces: what is read is to the bit what was written. (As JSON numbers they
//! would be so only with serde_json's `float_roundtrip`; without it the last digit may differ.)

use nalgebra::{Matrix3, Matrix6, Vector6};
use serde::{Deserialize, Serialize};

use super::along::Information;
use super::parameters::AXES;
use super::qmethod::AttitudeProfile;
use super::sums::{Scatter, Sums};
use super::tracks::{Latest, Registration};
use crate::time::Time;

/// All that a [`Registration`] knows, to be written down by serde in any format.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegistrationState {
    version: u32,
    /// Nanoseconds since the Unix epoch.
    now: i64,
    settled: Settled,
    latest: Vec<SavedTrack>,
}

/// A [`RegistrationState`] that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RegistrationStateError {
    /// Written by another version of the service.
    #[error("registration state of version {0}, not {VERSION}")]
    Version(u32),
    /// Not what is written.
    #[error("registration state: {0} numbers where {1} finite ones belong")]
    Numbers(usize, usize),
}

/// The only version so far.
const VERSION: u32 = 1;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settled {
    axes: [Numbers; AXES],
    profiles: [Numbers; 2],
    tracks: Numbers,
    spread: Numbers,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedTrack {
    begun: i64,
    time: i64,
    kept: bool,
    axes: [Numbers; AXES],
    spread: Numbers,
}

/// Numbers as text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
struct Numbers(Vec<f64>);

impl From<Numbers> for String {
    fn from(numbers: Numbers) -> Self {
        let texts: Vec<String> = numbers.0.iter().map(|number| format!("{number:?}")).collect();
        texts.join(" ")
    }
}

impl TryFrom<String> for Numbers {
    type Error = std::num::ParseFloatError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.split_whitespace().map(str::parse).collect::<Result<_, _>>().map(Self)
    }
}

impl Numbers {
    fn of<'a>(parts: impl IntoIterator<Item = &'a [f64]>) -> Self {
        Self(parts.into_iter().flatten().copied().collect())
    }

    fn checked<const COUNT: usize>(&self) -> Result<&[f64; COUNT], RegistrationStateError> {
        let wrong = RegistrationStateError::Numbers(self.0.len(), COUNT);
        let numbers = <&[f64; COUNT]>::try_from(self.0.as_slice()).map_err(|_| wrong.clone())?;
        if numbers.iter().all(|number| number.is_finite()) { Ok(numbers) } else { Err(wrong) }
    }

    fn information(&self) -> Result<Information, RegistrationStateError> {
        let numbers: &[f64; 42] = self.checked()?;
        let (matrix, vector) = numbers.split_at(36);
        Ok(Information {
            matrix: Matrix6::from_column_slice(matrix),
            vector: Vector6::from_column_slice(vector),
        })
    }

    fn profile(&self) -> Result<AttitudeProfile, RegistrationStateError> {
        let numbers: &[f64; 27] = self.checked()?;
        let matrix = |from: usize| Matrix3::from_column_slice(&numbers[from..from + 9]);
        Ok(AttitudeProfile { matrix: matrix(0), by_height: matrix(9), by_time: matrix(18) })
    }

    fn spread(&self) -> Result<Scatter, RegistrationStateError> {
        let &[a, b, c, d, e, f] = self.checked()?;
        Ok(Scatter { squares: [a, b, c], count: [d, e, f] })
    }
}

fn axes(axes: &[Information; AXES]) -> [Numbers; AXES] {
    axes.each_ref().map(|axis| Numbers::of([axis.matrix.as_slice(), axis.vector.as_slice()]))
}

fn axes_of(
    [azimuth, range, height]: &[Numbers; AXES],
) -> Result<[Information; AXES], RegistrationStateError> {
    Ok([azimuth.information()?, range.information()?, height.information()?])
}

fn spread(spread: &Scatter) -> Numbers {
    Numbers::of([spread.squares.as_slice(), spread.count.as_slice()])
}

impl Registration {
    /// All that is known.
    pub fn to_state(&self) -> RegistrationState {
        let profile = |profile: &AttitudeProfile| {
            let AttitudeProfile { matrix, by_height, by_time } = profile;
            Numbers::of([matrix.as_slice(), by_height.as_slice(), by_time.as_slice()])
        };
        let track = |track: &Latest| SavedTrack {
            begun: track.begun.nanos(),
            time: track.time.nanos(),
            kept: track.kept,
            axes: axes(&track.axes),
            spread: spread(&track.spread),
        };
        RegistrationState {
            version: VERSION,
            now: self.now.nanos(),
            settled: Settled {
                axes: axes(&self.settled.axes),
                profiles: self.settled.profiles.each_ref().map(profile),
                tracks: Numbers(vec![self.settled.tracks]),
                spread: spread(&self.settled.spread),
            },
            latest: self.latest.iter().map(track).collect(),
        }
    }

    /// Goes on where that was written.
    ///
    /// # Errors
    /// The state is of another version, or its numbers are not what is written.
    pub fn from_state(state: &RegistrationState) -> Result<Self, RegistrationStateError> {
        if state.version != VERSION {
            return Err(RegistrationStateError::Version(state.version));
        }
        let track = |track: &SavedTrack| {
            Ok(Latest {
                begun: Time::from_nanos(track.begun),
                time: Time::from_nanos(track.time),
                axes: axes_of(&track.axes)?,
                kept: track.kept,
                spread: track.spread.spread()?,
            })
        };
        let Settled { axes, profiles: [azimuths, heights], tracks, spread } = &state.settled;
        let &[tracks] = tracks.checked()?;
        Ok(Self {
            now: Time::from_nanos(state.now),
            settled: Sums {
                axes: axes_of(axes)?,
                profiles: [azimuths.profile()?, heights.profile()?],
                tracks,
                spread: spread.spread()?,
            },
            latest: state.latest.iter().map(track).collect::<Result<_, RegistrationStateError>>()?,
        })
    }
}
