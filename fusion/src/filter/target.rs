//! The filter of one target, whichever the model.

use super::measurement::{Measurement, StateEstimate};
use super::motion::{MODELS, Models};
use super::singer::Singer;
use super::smoother::Filter;
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
#[derive(Clone, Debug)]
pub struct TargetFilter(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Imm(Filter<Models, { plane::STATES }, MODELS, { height::STATES }>),
    Singer(Filter<Singer, { plane::STATES_SINGER }, 1, { height::STATES_SINGER }>),
}

impl TargetFilter {
    /// Of a target of which nothing was measured.
    pub fn new(dynamics: &Dynamics) -> Self {
        Self(match *dynamics {
            Dynamics::Imm(models) => Kind::Imm(Filter::new(models)),
            Dynamics::Singer(singer) => Kind::Singer(Filter::new(singer)),
        })
    }

    /// Brings the measurements after `since` to these, which are in order of time; those before stay. What did not change
    /// is not filtered again.
    pub fn measure(&mut self, since: Time, measurements: &[Measurement]) {
        match &mut self.0 {
            Kind::Imm(filter) => filter.measure(since, measurements),
            Kind::Singer(filter) => filter.measure(since, measurements),
        }
    }

    /// Forgets what lies before the last measurement up to `time`.
    pub fn forget_before(&mut self, time: Time) {
        match &mut self.0 {
            Kind::Imm(filter) => filter.forget_before(time),
            Kind::Singer(filter) => filter.forget_before(time),
        }
    }

    /// The newest.
    pub fn newest(&self) -> Option<&Measurement> {
        match &self.0 {
            Kind::Imm(filter) => filter.newest(),
            Kind::Singer(filter) => filter.newest(),
        }
    }

    /// Where the target is at `time`, from everything measured before and after; `None` if nothing was measured.
    pub fn at(&self, time: Time) -> Option<StateEstimate> {
        match &self.0 {
            Kind::Imm(filter) => filter.at(time),
            Kind::Singer(filter) => filter.at(time),
        }
    }
}
