//! One target's measurements in the order of their time: a filter forward, a smoother backward.
//!
//! What came late is put in its place and everything behind it is filtered anew, so that the order of arrival plays no part.

use std::collections::VecDeque;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::gaussian::{Back, Gaussian};
use super::measurement::{By, Measurement, StateEstimate};
use super::state::{Jumps, Moves, State};
use crate::time::Time;

/// A measurement and what is known with it.
#[derive(Debug)]
struct Node<const P: usize, const M: usize, const H: usize, const S: usize> {
    measurement: Measurement,
    /// The last one up to it that says where the target is.
    placed: Option<Measurement>,
    state: State<P, M, H, S>,
    /// To the node before; `None` for the first.
    back: Option<(Back<P>, Back<H>)>,
    /// The same with everything that was measured later.
    smoothed: (Gaussian<P>, Gaussian<H>),
}

/// The filter of one target: `M` models of a state of `P` numbers over ground, one of `H` numbers above it, with the biases
/// of `S` radars in both.
#[derive(Debug)]
pub(super) struct Filter<K, const P: usize, const M: usize, const H: usize, const S: usize> {
    models: K,
    /// Each by itself: it has some 3.5 kB, and few are kept for long of those that there are for a moment, for which the room
    /// would stay.
    nodes: VecDeque<Box<Node<P, M, H, S>>>,
}

impl<K, const P: usize, const M: usize, const H: usize, const S: usize> Filter<K, P, M, H, S>
where
    K: Moves<P, M, H>,
{
    pub(super) const fn new(models: K) -> Self {
        Self { models, nodes: VecDeque::new() }
    }

    /// What the rest follows from, for a checkpoint: the first node, and what was measured after it.
    pub(super) fn write_down(&self) -> Vec<u8>
    where
        K: Serialize,
    {
        let first = self.nodes.front().map(|node| (&node.measurement, &node.placed, &node.state));
        let later: Vec<&Measurement> = self.nodes.iter().skip(1).map(|node| &node.measurement).collect();
        postcard::to_stdvec(&(&self.models, first, later)).expect("numbers can be written down")
    }

    /// The filter again; `None`: the octets are not one of this size.
    pub(super) fn read_back(octets: &[u8]) -> Option<Self>
    where
        K: DeserializeOwned,
    {
        type First<const P: usize, const M: usize, const H: usize, const S: usize> =
            (Measurement, Option<Measurement>, State<P, M, H, S>);
        let (models, first, later): (K, Option<First<P, M, H, S>>, Vec<Measurement>) =
            postcard::from_bytes(octets).ok()?;
        let mut filter = Self::new(models);
        if let Some((measurement, placed, state)) = first {
            let smoothed = (state.told, state.height);
            filter.nodes.push_back(Box::new(Node { measurement, placed, state, back: None, smoothed }));
            filter.measure(measurement.time, &later);
        }
        Some(filter)
    }

    /// Brings the measurements after `since` to these, which are in order of time; those before stay. What did not change
    /// is not filtered again.
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
                None => (State::first(measurement, &self.models), None),
                Some(last) => {
                    let dt = measurement.time.seconds_since(last.measurement.time);
                    let (state, (plane, height)) =
                        last.state.next(measurement, &measurements[index + 1..], dt, &self.models);
                    (state, Some((plane.back(), height.back())))
                }
            };
            let smoothed = (state.told, state.height);
            let placed = match measurement.is_partial() {
                true => self.nodes.back().and_then(|last| last.placed),
                false => Some(*measurement),
            };
            self.nodes.push_back(Box::new(Node { measurement: *measurement, placed, state, back, smoothed }));
        }
        self.smooth();
    }

    /// Number of nodes, of the first `count`, that do not change with the measurements behind them. A report that may have been a
    /// jump is judged by the next one, so it is filtered again; the first node stays, since the state before it is forgotten.
    fn settled(&self, count: usize) -> usize {
        let is_report = |node: &Node<P, M, H, S>| matches!(node.measurement.by, By::Transponder { .. });
        let last = self.nodes.iter().take(count).rposition(|node| is_report(node));
        last.filter(|&last| last > 0 && self.nodes[last].state.jumps.rests_on_next).unwrap_or(count)
    }

    /// How many nodes there are up to a time. Counted from the oldest on: few are kept that are settled.
    fn up_to(&self, time: Time) -> usize {
        self.nodes.iter().take_while(|node| node.measurement.time <= time).count()
    }

    /// Back from the newest.
    fn smooth(&mut self) {
        let mut nodes = self.nodes.iter_mut().rev();
        let Some(last) = nodes.next() else { return };
        last.smoothed = (last.state.told, last.state.height);
        let (mut next, mut back) = (&last.smoothed, &last.back);
        for node in nodes {
            let (told, height) = (&node.state.told, &node.state.height);
            node.smoothed = match back {
                Some((plane_back, height_back)) => {
                    (told.smoothed(plane_back, &next.0), height.smoothed(height_back, &next.1))
                }
                None => (*told, *height),
            };
            (next, back) = (&node.smoothed, &node.back);
        }
    }

    /// Forgets what lies before the last measurement up to `time`.
    pub(super) fn forget_before(&mut self, time: Time) {
        let keep = self.up_to(time).saturating_sub(1);
        self.nodes.drain(..keep);
    }

    /// The newest that says where it is.
    pub(super) fn newest(&self) -> Option<&Measurement> {
        self.nodes.back().and_then(|node| node.placed.as_ref())
    }

    /// Whether a report from `from` to `until` is known to have been a jump of its transponder.
    pub(super) fn has_jumped(&self, from: Time, until: Time) -> bool {
        // Those before the first node are forgotten, and each state knows the last jump before it.
        let nodes = self.nodes.iter().take_while(|node| node.measurement.time <= until);
        nodes.filter_map(|node| node.state.jumps.last).any(|last| last >= from)
    }

    /// Where the target is at `time`, from everything measured before and after; `None` if nothing was measured.
    pub(super) fn at(&self, time: Time) -> Option<StateEstimate> {
        let behind = self.up_to(time);
        let before = behind.checked_sub(1).map(|before| &self.nodes[before]);
        let next = self.nodes.get(behind);
        // What it rests on are measurements of its place.
        let since_s = before.and_then(|before| Some(time.seconds_since(before.placed.as_ref()?.time)));
        let placed = self.nodes.range(behind..).find(|node| !node.measurement.is_partial());
        let until_s = placed.map(|next| next.measurement.time.seconds_since(time));
        let here = match (before, next) {
            (Some(before), _) => {
                before.state.moved_to(time.seconds_since(before.measurement.time), &self.models)
            }
            // Before the first it is anywhere; what came after tells where.
            (None, Some(next)) => State::unmeasured(&next.measurement, &self.models),
            (None, None) => return None,
        };
        let Some(next) = next else {
            return Some(StateEstimate::of(&here.told, &here.height, &here.jumps, since_s, None));
        };
        let ahead_s = next.measurement.time.seconds_since(time);
        let (plane, height) = here.bridges(&next.measurement, ahead_s, &self.models);
        let plane = here.told.smoothed(&plane.back(), &next.smoothed.0);
        let height = here.height.smoothed(&height.back(), &next.smoothed.1);
        let jumps = Jumps::between(&here.jumps, &next.state.jumps);
        Some(StateEstimate::of(&plane, &height, &jumps, since_s, until_s))
    }
}
