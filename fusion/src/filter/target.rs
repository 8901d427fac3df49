//! The filter of one target, with any motion model.

use std::fmt::Debug;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize, Serializer};

use super::measurement::{Measurement, StateEstimate};
use super::motion::{MODELS, Models};
use super::singer::Singer;
use super::smoother::SmoothedFilter;
use super::state::StateMotion;
use super::{height, plane};
use crate::time::Time;

/// Motion models of targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dynamics {
    /// Interacting multiple models: constant velocity with little or much noise, and turns.
    Imm(Models),
    /// One model, with an acceleration that is correlated in time.
    Singer(Singer),
}

/// The filter of one target.
#[derive(Debug, Deserialize)]
#[serde(try_from = "SavedFilter")]
pub struct TargetFilter {
    size: FilterSize,
    filter: Box<dyn Filtering>,
}

/// Size of a filter's state.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct FilterSize {
    is_singer: bool,
    /// Number of radars whose biases are estimated at a time, 1 to 3.
    radars: u8,
}

/// A filter in a checkpoint.
#[derive(Debug, Serialize, Deserialize)]
struct SavedFilter(FilterSize, Vec<u8>);

/// A filter of any size.
trait Filtering: Debug + Send + Sync {
    fn write_down(&self) -> Vec<u8>;
    fn measure(&mut self, since: Time, measurements: &[Measurement]);
    fn forget_before(&mut self, time: Time);
    fn newest(&self) -> Option<&Measurement>;
    fn has_jumped(&self, from: Time, until: Time) -> bool;
    fn at(&self, time: Time) -> Option<StateEstimate>;
}

impl<K, const P: usize, const M: usize, const H: usize, const S: usize> Filtering
    for SmoothedFilter<K, P, M, H, S>
where
    K: StateMotion<P, M, H> + Debug + Send + Sync + Serialize + DeserializeOwned,
{
    fn write_down(&self) -> Vec<u8> {
        Self::write_down(self)
    }

    fn measure(&mut self, since: Time, measurements: &[Measurement]) {
        Self::measure(self, since, measurements);
    }

    fn forget_before(&mut self, time: Time) {
        Self::forget_before(self, time);
    }

    fn newest(&self) -> Option<&Measurement> {
        Self::newest(self)
    }

    fn has_jumped(&self, from: Time, until: Time) -> bool {
        Self::has_jumped(self, from, until)
    }

    fn at(&self, time: Time) -> Option<StateEstimate> {
        Self::at(self, time)
    }
}

/// The filter of these models with the biases of `$radars` radars.
macro_rules! sized {
    ($models:ty, $count:expr, $radars:literal, $states:ident) => {
        SmoothedFilter<$models, { plane::$states($radars) }, { $count }, { height::$states($radars) }, $radars>
    };
}

type Imm1 = sized!(Models, MODELS, 1, states);
type Imm2 = sized!(Models, MODELS, 2, states);
type Imm3 = sized!(Models, MODELS, 3, states);
type Singer1 = sized!(Singer, 1, 1, states_singer);
type Singer2 = sized!(Singer, 1, 2, states_singer);
type Singer3 = sized!(Singer, 1, 3, states_singer);

/// Boxes a filter that was restored from a checkpoint.
fn read_back<F: Filtering + 'static>(read: Option<F>) -> Option<Box<dyn Filtering>> {
    read.map(|filter| Box::new(filter) as Box<dyn Filtering>)
}

impl Serialize for TargetFilter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        SavedFilter(self.size, self.filter.write_down()).serialize(serializer)
    }
}

impl TryFrom<SavedFilter> for TargetFilter {
    type Error = &'static str;

    fn try_from(SavedFilter(size, octets): SavedFilter) -> Result<Self, Self::Error> {
        let filter = match (size.is_singer, size.radars) {
            (false, 1) => read_back(Imm1::read_back(&octets)),
            (false, 2) => read_back(Imm2::read_back(&octets)),
            (false, 3) => read_back(Imm3::read_back(&octets)),
            (true, 1) => read_back(Singer1::read_back(&octets)),
            (true, 2) => read_back(Singer2::read_back(&octets)),
            (true, 3) => read_back(Singer3::read_back(&octets)),
            _ => None,
        };
        Ok(Self { size, filter: filter.ok_or("no filter")? })
    }
}

impl TargetFilter {
    /// Creates the filter of a target without measurements, at a site with `radars` radars: the biases of at most three
    /// of them are estimated at a time.
    pub fn new(dynamics: &Dynamics, radars: usize) -> Self {
        let size = FilterSize {
            is_singer: matches!(dynamics, Dynamics::Singer(_)),
            radars: radars.clamp(1, 3) as u8,
        };
        let filter: Box<dyn Filtering> = match (*dynamics, size.radars) {
            (Dynamics::Imm(models), ..=1) => Box::new(Imm1::new(models)),
            (Dynamics::Imm(models), 2) => Box::new(Imm2::new(models)),
            (Dynamics::Imm(models), 3..) => Box::new(Imm3::new(models)),
            (Dynamics::Singer(singer), ..=1) => Box::new(Singer1::new(singer)),
            (Dynamics::Singer(singer), 2) => Box::new(Singer2::new(singer)),
            (Dynamics::Singer(singer), 3..) => Box::new(Singer3::new(singer)),
        };
        Self { size, filter }
    }

    /// Replaces the measurements after `since` by these, which are in order of time; earlier ones stay. Unchanged
    /// measurements are not filtered again.
    pub fn measure(&mut self, since: Time, measurements: &[Measurement]) {
        self.filter.measure(since, measurements);
    }

    /// Removes the measurements before the last one up to `time`.
    pub fn forget_before(&mut self, time: Time) {
        self.filter.forget_before(time);
    }

    /// The newest measurement with a position over ground.
    pub fn newest(&self) -> Option<&Measurement> {
        self.filter.newest()
    }

    /// Whether a report of its transponder from `from` to `until` was recognised as a jump.
    pub fn has_jumped(&self, from: Time, until: Time) -> bool {
        self.filter.has_jumped(from, until)
    }

    /// State of the target at `time`, from all measurements before and after; `None` if there are none.
    pub fn at(&self, time: Time) -> Option<StateEstimate> {
        self.filter.at(time)
    }
}
