//! The state of a registration that is kept across restarts.

use nalgebra::{Matrix3, Matrix6, Vector6};
use serde::{Deserialize, Serialize};

use super::along::Information;
use super::parameters::AXES;
use super::qmethod::AttitudeProfile;
use super::sums::{MisalignmentSums, Scatter};
use super::tracks::{LatestTrack, Registration};
use crate::decimals::{Decimals, WrongNumbers};
use crate::time::Time;

/// The complete state of a [`Registration`], serialisable in any format of serde.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegistrationState {
    version: u32,
    /// Nanoseconds since the Unix epoch.
    now: i64,
    settled: SavedSums,
    latest: Vec<SavedTrack>,
}

/// Error in a [`RegistrationState`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RegistrationStateError {
    /// The state is from another version of the service.
    #[error("registration state of version {0}, not {VERSION}")]
    Version(u32),
    /// The numbers are incomplete or not finite.
    #[error("registration state: {0} numbers where {1} finite ones belong")]
    Numbers(usize, usize),
}

/// Version of the layout; the only one so far.
const VERSION: u32 = 1;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedSums {
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
    /// The complete state.
    pub fn to_state(&self) -> RegistrationState {
        let profile = |profile: &AttitudeProfile| {
            let AttitudeProfile { matrix, by_height, by_time } = profile;
            Decimals::of([matrix.as_slice(), by_height.as_slice(), by_time.as_slice()])
        };
        let track = |track: &LatestTrack| SavedTrack {
            begun: track.begun.nanos(),
            time: track.time.nanos(),
            kept: track.kept,
            axes: axes(&track.axes),
            spread: spread(&track.spread),
        };
        RegistrationState {
            version: VERSION,
            now: self.now.nanos(),
            settled: SavedSums {
                axes: axes(&self.settled.axes),
                profiles: self.settled.profiles.each_ref().map(profile),
                tracks: Decimals(vec![self.settled.tracks]),
                spread: spread(&self.settled.spread),
            },
            latest: self.latest.iter().map(track).collect(),
        }
    }

    /// Restores a registration.
    ///
    /// # Errors
    /// The state has another version, or its numbers are incomplete or not finite.
    pub fn from_state(state: &RegistrationState) -> Result<Self, RegistrationStateError> {
        if state.version != VERSION {
            return Err(RegistrationStateError::Version(state.version));
        }
        let track = |track: &SavedTrack| {
            Ok(LatestTrack {
                begun: Time::from_nanos(track.begun),
                time: Time::from_nanos(track.time),
                axes: axes_of(&track.axes)?,
                kept: track.kept,
                spread: spread_of(&track.spread)?,
            })
        };
        let SavedSums { axes, profiles: [azimuths, heights], tracks, spread } = &state.settled;
        let &[tracks] = tracks.checked()?;
        Ok(Self {
            now: Time::from_nanos(state.now),
            settled: MisalignmentSums {
                axes: axes_of(axes)?,
                profiles: [profile_of(azimuths)?, profile_of(heights)?],
                tracks,
                spread: spread_of(spread)?,
            },
            latest: state.latest.iter().map(track).collect::<Result<_, RegistrationStateError>>()?,
        })
    }
}
