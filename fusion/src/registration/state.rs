//! What outlives a restart.

use nalgebra::{Matrix3, Matrix6, Vector6};
use serde::{Deserialize, Serialize};

use super::along::Information;
use super::parameters::AXES;
use super::qmethod::AttitudeProfile;
use super::sums::{Scatter, Sums};
use super::tracks::{Latest, Registration};
use crate::decimals::{Decimals, WrongNumbers};
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
    axes: [Decimals; AXES],
    profiles: [Decimals; 2],
    tracks: Decimals,
    spread: Decimals,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedTrack {
    begun: i64,
    time: i64,
    kept: bool,
    axes: [Decimals; AXES],
    spread: Decimals,
}

impl From<WrongNumbers> for RegistrationStateError {
    fn from(WrongNumbers(found, wanted): WrongNumbers) -> Self {
        Self::Numbers(found, wanted)
    }
}

fn information(numbers: &Decimals) -> Result<Information, RegistrationStateError> {
    let numbers: &[f64; 42] = numbers.checked()?;
    let (matrix, vector) = numbers.split_at(36);
    Ok(Information { matrix: Matrix6::from_column_slice(matrix), vector: Vector6::from_column_slice(vector) })
}

fn profile_of(numbers: &Decimals) -> Result<AttitudeProfile, RegistrationStateError> {
    let numbers: &[f64; 27] = numbers.checked()?;
    let matrix = |from: usize| Matrix3::from_column_slice(&numbers[from..from + 9]);
    Ok(AttitudeProfile { matrix: matrix(0), by_height: matrix(9), by_time: matrix(18) })
}

fn spread_of(numbers: &Decimals) -> Result<Scatter, RegistrationStateError> {
    let &[a, b, c, d, e, f] = numbers.checked()?;
    Ok(Scatter { squares: [a, b, c], count: [d, e, f] })
}

fn axes(axes: &[Information; AXES]) -> [Decimals; AXES] {
    axes.each_ref().map(|axis| Decimals::of([axis.matrix.as_slice(), axis.vector.as_slice()]))
}

fn axes_of(
    [azimuth, range, height]: &[Decimals; AXES],
) -> Result<[Information; AXES], RegistrationStateError> {
    Ok([information(azimuth)?, information(range)?, information(height)?])
}

fn spread(spread: &Scatter) -> Decimals {
    Decimals::of([spread.squares.as_slice(), spread.count.as_slice()])
}

impl Registration {
    /// All that is known.
    pub fn to_state(&self) -> RegistrationState {
        let profile = |profile: &AttitudeProfile| {
            let AttitudeProfile { matrix, by_height, by_time } = profile;
            Decimals::of([matrix.as_slice(), by_height.as_slice(), by_time.as_slice()])
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
                tracks: Decimals(vec![self.settled.tracks]),
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
                spread: spread_of(&track.spread)?,
            })
        };
        let Settled { axes, profiles: [azimuths, heights], tracks, spread } = &state.settled;
        let &[tracks] = tracks.checked()?;
        Ok(Self {
            now: Time::from_nanos(state.now),
            settled: Sums {
                axes: axes_of(axes)?,
                profiles: [profile_of(azimuths)?, profile_of(heights)?],
                tracks,
                spread: spread_of(spread)?,
            },
            latest: state.latest.iter().map(track).collect::<Result<_, RegistrationStateError>>()?,
        })
    }
}
