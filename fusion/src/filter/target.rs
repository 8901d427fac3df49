//! The filter of one target, whichever the model.

use std::fmt::Debug;

use super::measurement::{Measurement, StateEstimate};
use super::motion::{MODELS, Models};
use super::singer::Singer;
use super::smoother::Filter;
use super::state::Moves;
use super::{height, plane};
use crate::time::Time;

/// How targets are taken to move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dynamics {
    /// Interacting multiple models: straight on, disturbed little or much, and turns.
    Imm(Models),
    /// One model, with an acceleration that lasts for a while.
    Singer(Singer),
}

/// The filter of one target.
#[derive(Debug)]
pub struct TargetFilter(Box<dyn Filtering>);

/// A filter of whichever size.
trait Filtering: Debug + Send + Sync {
    fn measure(&mut self, since: Time, measurements: &[Measurement]);
    fn forget_before(&mut self, time: Time);
    fn newest(&self) -> Option<&Measurement>;
    fn at(&self, time: Time) -> Option<StateEstimate>;
}

impl<K, const P: usize, const M: usize, const H: usize, const S: usize> Filtering for Filter<K, P, M, H, S>
where
    K: Moves<P, M, H> + Debug + Send + Sync,
{
    fn measure(&mut self, since: Time, measurements: &[Measurement]) {
        Self::measure(self, since, measurements);
    }

    fn forget_before(&mut self, time: Time) {
        Self::forget_before(self, time);
    }

    fn newest(&self) -> Option<&Measurement> {
        Self::newest(self)
    }

    fn at(&self, time: Time) -> Option<StateEstimate> {
        Self::at(self, time)
    }
}

/// A filter with the biases of so many radars.
macro_rules! filter_of {
    ($models:expr, $count:expr, $radars:literal, $states:ident) => {
        Box::new(
            Filter::<_, { plane::$states($radars) }, $count, { height::$states($radars) }, $radars>::new(
                $models,
            ),
        )
    };
}

impl TargetFilter {
    /// Of a target of which nothing was measured, on a site with so many radars: the biases of three of them at most are
    /// estimated at a time.
    pub fn new(dynamics: &Dynamics, radars: usize) -> Self {
        Self(match (*dynamics, radars) {
            (Dynamics::Imm(models), ..=1) => filter_of!(models, MODELS, 1, states),
            (Dynamics::Imm(models), 2) => filter_of!(models, MODELS, 2, states),
            (Dynamics::Imm(models), 3..) => filter_of!(models, MODELS, 3, states),
            (Dynamics::Singer(singer), ..=1) => filter_of!(singer, 1, 1, states_singer),
            (Dynamics::Singer(singer), 2) => filter_of!(singer, 1, 2, states_singer),
            (Dynamics::Singer(singer), 3..) => filter_of!(singer, 1, 3, states_singer),
        })
    }

    /// Brings the measurements after `since` to these, which are in order of time; those before stay. What did not change
    /// is not filtered again.
    pub fn measure(&mut self, since: Time, measurements: &[Measurement]) {
        self.0.measure(since, measurements);
    }

    /// Forgets what lies before the last measurement up to `time`.
    pub fn forget_before(&mut self, time: Time) {
        self.0.forget_before(time);
    }

    /// The newest.
    pub fn newest(&self) -> Option<&Measurement> {
        self.0.newest()
    }

    /// Where the target is at `time`, from everything measured before and after; `None` if nothing was measured.
    pub fn at(&self, time: Time) -> Option<StateEstimate> {
        self.0.at(time)
    }
}
