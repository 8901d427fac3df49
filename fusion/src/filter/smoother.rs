//! The measurements of one target in order of time: forward filter and backward smoother.
//!
//! A late measurement is inserted at its time, and all later ones are filtered again, so the order of arrival does not
//! matter.

use std::collections::VecDeque;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::gaussian::{BackwardStep, Gaussian};
use super::measurement::{By, Measurement, StateEstimate};
use super::state::{FilterState, Jumps, StateMotion};
use crate::time::Time;

/// A measurement, and the state after it.
#[derive(Debug)]
struct SmootherNode<const P: usize, const M: usize, const H: usize, const S: usize> {
    measurement: Measurement,
    /// The last measurement up to this one with a position over ground.
    placed: Option<Measurement>,
    state: FilterState<P, M, H, S>,
    /// Smoother's way back to the previous node; `None` for the first.
    back: Option<(BackwardStep<P>, BackwardStep<H>)>,
    /// The state given all measurements, including later ones.
    smoothed: (Gaussian<P>, Gaussian<H>),
}

/// The filter of one target: `M` models of a state of `P` variables over ground, one of `H` variables in height, with
/// the biases of `S` radars in both.
#[derive(Debug)]
pub(super) struct SmoothedFilter<K, const P: usize, const M: usize, const H: usize, const S: usize> {
    models: K,
    /// Each node is boxed, because it has about 3.5 kB: the queue would keep its peak capacity, and long-lived filters
    /// have few nodes.
    nodes: VecDeque<Box<SmootherNode<P, M, H, S>>>,
}

impl<K, const P: usize, const M: usize, const H: usize, const S: usize> SmoothedFilter<K, P, M, H, S>
where
    K: StateMotion<P, M, H>,
{
    pub(super) const fn new(models: K) -> Self {
        Self { models, nodes: VecDeque::new() }
    }

    /// The minimal state for a checkpoint: the first node, and the measurements after it.
    pub(super) fn write_down(&self) -> Vec<u8>
    where
        K: Serialize,
    {
        let first = self.nodes.front().map(|node| (&node.measurement, &node.placed, &node.state));
        let later: Vec<&Measurement> = self.nodes.iter().skip(1).map(|node| &node.measurement).collect();
        postcard::to_stdvec(&(&self.models, first, later)).expect("numbers can be written down")
    }

    /// Restores the filter; `None`: the octets are not of a filter of this size.
    pub(super) fn read_back(octets: &[u8]) -> Option<Self>
    where
        K: DeserializeOwned,
    {
        type FirstState<const P: usize, const M: usize, const H: usize, const S: usize> =
            (Measurement, Option<Measurement>, FilterState<P, M, H, S>);
        let (models, first, later): (K, Option<FirstState<P, M, H, S>>, Vec<Measurement>) =
            postcard::from_bytes(octets).ok()?;
        let mut filter = Self::new(models);
        if let Some((measurement, placed, state)) = first {
            let smoothed = (state.combined, state.height);
            filter.nodes.push_back(Box::new(SmootherNode {
                measurement,
                placed,
                state,
                back: None,
                smoothed,
            }));
            filter.measure(measurement.time, &later);
        }
        Some(filter)
    }

    /// Replaces the measurements after `since` by these, which are in order of time; earlier ones stay. Unchanged
    /// measurements are not filtered again.
    pub(super) fn measure(&mut self, since: Time, measurements: &[Measurement]) {
        let old = self.up_to(since);
        let same = self
            .nodes
            .range(old..)
            .zip(measurements)
            .take_while(|(node, measurement)| node.measurement == **measurement)
            .count();
        if same == measurements.len() && old + same == self.nodes.len() {
            return;
        }
        let kept = self.settled(old + same);
        let anew: Vec<Measurement> = self.nodes.drain(kept..).map(|node| node.measurement).collect();
        let again = (old + same - kept).min(anew.len());
        let measurements = [&anew[..again], &measurements[same..]].concat();
        for (index, measurement) in measurements.iter().enumerate() {
            let (state, back) = match self.nodes.back() {
                None => (FilterState::first(measurement, &self.models), None),
                Some(last) => {
                    let dt = measurement.time.seconds_since(last.measurement.time);
                    let (state, (plane, height)) =
                        last.state.next(measurement, &measurements[index + 1..], dt, &self.models);
                    (state, Some((plane.back(), height.back())))
                }
            };
            let smoothed = (state.combined, state.height);
            let placed = match measurement.is_partial() {
                true => self.nodes.back().and_then(|last| last.placed),
                false => Some(*measurement),
            };
            self.nodes.push_back(Box::new(SmootherNode {
                measurement: *measurement,
                placed,
                state,
                back,
                smoothed,
            }));
        }
        self.smooth();
    }

    /// Number of nodes, of the first `count`, that do not depend on later measurements. A report that may have been a
    /// jump is decided by the next one, so it is filtered again. The first node stays, because the state before it is
    /// discarded.
    fn settled(&self, count: usize) -> usize {
        let is_report =
            |node: &SmootherNode<P, M, H, S>| matches!(node.measurement.by, By::Transponder { .. });
        let last = self.nodes.iter().take(count).rposition(|node| is_report(node));
        last.filter(|&last| last > 0 && self.nodes[last].state.jumps.rests_on_next).unwrap_or(count)
    }

    /// Number of nodes up to a time. Counted from the oldest node, because few old nodes are kept.
    fn up_to(&self, time: Time) -> usize {
        self.nodes.iter().take_while(|node| node.measurement.time <= time).count()
    }

    /// Smooths backward from the newest node.
    fn smooth(&mut self) {
        let mut nodes = self.nodes.iter_mut().rev();
        let Some(last) = nodes.next() else { return };
        last.smoothed = (last.state.combined, last.state.height);
        let (mut next, mut back) = (&last.smoothed, &last.back);
        for node in nodes {
            let (combined, height) = (&node.state.combined, &node.state.height);
            node.smoothed = match back {
                Some((plane_back, height_back)) => {
                    (combined.smoothed(plane_back, &next.0), height.smoothed(height_back, &next.1))
                }
                None => (*combined, *height),
            };
            (next, back) = (&node.smoothed, &node.back);
        }
    }

    /// Removes the nodes before the last measurement up to `time`.
    pub(super) fn forget_before(&mut self, time: Time) {
        let keep = self.up_to(time).saturating_sub(1);
        self.nodes.drain(..keep);
    }

    /// The newest measurement with a position over ground.
    pub(super) fn newest(&self) -> Option<&Measurement> {
        self.nodes.back().and_then(|node| node.placed.as_ref())
    }

    /// Whether a transponder report from `from` to `until` was recognised as a jump.
    pub(super) fn has_jumped(&self, from: Time, until: Time) -> bool {
        // Nodes before the first are discarded, and each state stores the last jump before it.
        let nodes = self.nodes.iter().take_while(|node| node.measurement.time <= until);
        nodes.filter_map(|node| node.state.jumps.last).any(|last| last >= from)
    }

    /// State of the target at `time`, from all measurements before and after; `None` if there are none.
    pub(super) fn at(&self, time: Time) -> Option<StateEstimate> {
        let behind = self.up_to(time);
        let before = behind.checked_sub(1).map(|before| &self.nodes[before]);
        let next = self.nodes.get(behind);
        // The times count measurements with a position over ground.
        let since_s = before.and_then(|before| Some(time.seconds_since(before.placed.as_ref()?.time)));
        let placed = self.nodes.range(behind..).find(|node| !node.measurement.is_partial());
        let until_s = placed.map(|next| next.measurement.time.seconds_since(time));
        let here = match (before, next) {
            (Some(before), _) => {
                before.state.moved_to(time.seconds_since(before.measurement.time), &self.models)
            }
            // Before the first measurement the position is unknown; the smoother derives it from later ones.
            (None, Some(next)) => FilterState::unmeasured(&next.measurement, &self.models),
            (None, None) => return None,
        };
        let Some(next) = next else {
            return Some(StateEstimate::of(&here.combined, &here.height, &here.jumps, since_s, None));
        };
        let ahead_s = next.measurement.time.seconds_since(time);
        let (plane, height) = here.bridges(&next.measurement, ahead_s, &self.models);
        let plane = here.combined.smoothed(&plane.back(), &next.smoothed.0);
        let height = here.height.smoothed(&height.back(), &next.smoothed.1);
        let jumps = Jumps::between(&here.jumps, &next.state.jumps);
        Some(StateEstimate::of(&plane, &height, &jumps, since_s, until_s))
    }
}
