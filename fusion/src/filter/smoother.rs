//! One target's measurements in the order of their time: a filter forward, a smoother backward.
//!
//! What came late is put in its place and everything behind it is filtered anew, so that the order of arrival plays no part.

use nalgebra::Vector2;

use super::bias::{Bias, SlowChange};
use super::errors::RadarErrors;
use super::height::{self, AboveGround};
use super::imm::{Back, Bridge, Gaussian, Mixture};
use super::measurement::{By, Measurement, Owner, StateEstimate};
use super::plane::{self, OverGround};
use crate::time::Time;

/// A measurement and what is known with it.
#[derive(Clone, Debug)]
struct Node<const P: usize, const M: usize, const H: usize> {
    measurement: Measurement,
    /// The radar track whose bias is estimated, and that radar.
    owner: Option<(Owner, RadarErrors)>,
    plane: Mixture<P, M>,
    /// The one Gaussian that stands for that mixture.
    told: Gaussian<P>,
    height: Gaussian<H>,
    /// How far the transponder has jumped from where the motion led, metres over ground: it is wrong now, or was before.
    jumped: Vector2<f64>,
    /// To the node before; `None` for the first.
    back: Option<(Back<P>, Back<H>)>,
}

/// The filter of one target: `M` models of a state of `P` numbers over ground, one of `H` numbers above it.
#[derive(Clone, Debug)]
pub(super) struct Filter<K, const P: usize, const M: usize, const H: usize> {
    models: K,
    nodes: Vec<Node<P, M, H>>,
}

/// A transponder further from where the motion led (squared Mahalanobis distance) has not flown there: turns and stops stay
/// below half of it.
const LEAP: f64 = 100.0;
/// A receiver's false place is forgotten to 1/e in this time, seconds.
const JUMP_LASTS_S: f64 = 30.0;
/// A position, velocity or climb further off than this is given less weight (squared Mahalanobis distance).
const FAR: f64 = 16.0;

impl<K, const P: usize, const M: usize, const H: usize> Filter<K, P, M, H>
where
    K: OverGround<P, M> + AboveGround<H>,
{
    pub(super) const fn new(models: K) -> Self {
        Self { models, nodes: Vec::new() }
    }

    /// Brings the measurements after `since` to these, which are in order of time; those before stay. What did not change
    /// is not filtered again.
    pub(super) fn measure(&mut self, since: Time, measurements: &[Measurement]) {
        let old = self.nodes.partition_point(|node| node.measurement.time <= since);
        let same = self.nodes[old..]
            .iter()
            .zip(measurements)
            .take_while(|(node, measurement)| node.measurement == **measurement)
            .count();
        self.nodes.truncate(old + same);
        for measurement in &measurements[same..] {
            let node = match self.nodes.last() {
                None => Node::first(*measurement, &self.models),
                Some(last) => last.next(*measurement, &self.models),
            };
            self.nodes.push(node);
        }
    }

    /// Forgets what lies before the last measurement up to `time`.
    pub(super) fn forget_before(&mut self, time: Time) {
        let keep = self.nodes.partition_point(|node| node.measurement.time <= time).saturating_sub(1);
        self.nodes.drain(..keep);
    }

    /// The newest.
    pub(super) fn newest(&self) -> Option<&Measurement> {
        self.nodes.last().map(|node| &node.measurement)
    }

    /// Where the target is at `time`, from everything measured before and after; `None` if nothing was measured.
    pub(super) fn at(&self, time: Time) -> Option<StateEstimate> {
        let behind = self.nodes.partition_point(|node| node.measurement.time <= time);
        let before = behind.checked_sub(1).map(|before| &self.nodes[before]);
        let next = self.nodes.get(behind);
        let since_s = before.map(|before| time.seconds_since(before.measurement.time));
        let until_s = next.map(|next| next.measurement.time.seconds_since(time));
        let here = match (before.zip(since_s), next) {
            (Some((before, since_s)), _) => before.moved_to(since_s, &self.models),
            // Before the first it is anywhere; what came after tells where.
            (None, Some(next)) => Node::unmeasured(next.measurement, &self.models),
            (None, None) => return None,
        };
        let (plane, height) = (here.told, here.height);
        let Some((next, until_s)) = next.zip(until_s) else {
            return Some(StateEstimate::of(&plane, &height, here.jumped, since_s, None));
        };
        // Back from the newest to the next one.
        let last = self.nodes.last()?;
        let (mut plane_after, mut height_after) = (last.told, last.height);
        for pair in self.nodes[behind..].windows(2).rev() {
            let Some((plane_back, height_back)) = &pair[1].back else { continue };
            plane_after = pair[0].told.smoothed(plane_back, &plane_after);
            height_after = pair[0].height.smoothed(height_back, &height_after);
        }
        // And from there to here.
        let (_, plane_bridge, _, height_bridge) =
            here.ahead_to(&next.measurement, next.owner, until_s, &self.models);
        let plane = plane.smoothed(&plane_bridge.back(), &plane_after);
        let height = height.smoothed(&height_bridge.back(), &height_after);
        let jumped = if next.jumped.norm() > here.jumped.norm() { next.jumped } else { here.jumped };
        Some(StateEstimate::of(&plane, &height, jumped, since_s, Some(until_s)))
    }
}

type Ahead<const P: usize, const M: usize, const H: usize> =
    (Mixture<P, M>, Bridge<P>, Gaussian<H>, Bridge<H>);

impl<const P: usize, const M: usize, const H: usize> Node<P, M, H> {
    /// Of a target of which nothing is known but that it will be measured so.
    fn unmeasured(measurement: Measurement, models: &(impl OverGround<P, M> + AboveGround<H>)) -> Self {
        let owner = match &measurement.by {
            By::Transponder { .. } => None,
            By::Radar { owner, errors, .. } => Some((*owner, *errors)),
        };
        let slow = owner.as_ref().map(|(_, errors)| Bias::of(errors));
        let plane = OverGround::first(models, measurement.position.0.xy(), slow.as_ref());
        Self {
            owner,
            told: plane.combined(),
            plane,
            height: AboveGround::first(
                models,
                measurement.position.0.z,
                measurement.height_measured,
                slow.as_ref(),
            ),
            jumped: Vector2::zeros(),
            back: None,
            measurement,
        }
    }

    fn first(measurement: Measurement, models: &(impl OverGround<P, M> + AboveGround<H>)) -> Self {
        let mut node = Self::unmeasured(measurement, models);
        let told = node.told;
        node.observe(&told);
        let (plane, height) = (node.plane.combined(), node.height);
        node.observe_motion(&plane, &height);
        node.told = node.plane.combined();
        node
    }

    /// The same `dt` seconds later, without a measurement.
    fn moved_to(&self, dt: f64, models: &(impl OverGround<P, M> + AboveGround<H>)) -> Self {
        let slow = self.owner.map_or(SlowChange::NONE, |(_, radar)| SlowChange::after(&radar, dt));
        let (plane, Bridge { predicted: told, .. }, height, _) = self.moved(dt, &slow, models);
        let Self { measurement, owner, jumped, .. } = *self;
        Self { measurement, owner, plane, told, height, jumped, back: None }
    }

    /// The state where the next measurement is; `owner`: whose bias is estimated there.
    fn ahead_to(
        &self,
        next: &Measurement,
        owner: Option<(Owner, RadarErrors)>,
        dt: f64,
        models: &(impl OverGround<P, M> + AboveGround<H>),
    ) -> Ahead<P, M, H> {
        let same = self.owner.map(|(owner, _)| owner) == owner.map(|(owner, _)| owner);
        let slow = match (&owner, &next.by) {
            (_, By::Radar { known, .. }) if !same => SlowChange::anew(*known),
            (Some((_, radar)), _) => SlowChange::after(radar, dt),
            (None, _) => SlowChange::NONE,
        };
        self.moved(dt, &slow, models)
    }

    fn moved(
        &self,
        dt: f64,
        slow: &SlowChange,
        models: &(impl OverGround<P, M> + AboveGround<H>),
    ) -> Ahead<P, M, H> {
        let (plane, plane_bridge) =
            self.plane.predicted(&self.told, &models.motions(dt, slow), &models.switch(dt));
        let height_bridge = self.height.predicted(&models.motion(dt, slow));
        (plane, plane_bridge, height_bridge.predicted, height_bridge)
    }

    fn next(&self, measurement: Measurement, models: &(impl OverGround<P, M> + AboveGround<H>)) -> Self {
        let dt = measurement.time.seconds_since(self.measurement.time);
        let owner = match measurement.by {
            By::Transponder { .. } => self.owner,
            By::Radar { owner, errors, .. } => Some((owner, errors)),
        };
        let jumped = self.jumped * (-dt / JUMP_LASTS_S).exp();
        let (plane, mut plane_bridge, height, height_bridge) = self.ahead_to(&measurement, owner, dt, models);
        let told = plane_bridge.predicted;
        let mut node = Self { measurement, owner, plane, told, height, jumped, back: None };
        node.leap(&mut plane_bridge.predicted);
        node.observe(&plane_bridge.predicted);
        node.observe_motion(&plane_bridge.predicted, &height);
        node.told = node.plane.combined();
        node.back = Some((plane_bridge.back(), height_bridge.back()));
        node
    }

    /// A transponder that is far from where the motion led has jumped: its receiver takes a reflection for a satellite, or
    /// no longer does. That says nothing of the speed.
    fn leap(&mut self, predicted: &mut Gaussian<P>) {
        let By::Transponder { horizontal_m, .. } = self.measurement.by else { return };
        let place = self.measurement.position.0.xy();
        if predicted.distance(&plane::fix(place, horizontal_m)) <= LEAP {
            return;
        }
        let away = place - predicted.mean.fixed_rows::<2>(0);
        self.jumped += away;
        let spread = away * away.transpose();
        plane::spread(predicted, &spread);
        self.plane.parts.iter_mut().for_each(|part| plane::spread(part, &spread));
    }

    fn observe(&mut self, predicted: &Gaussian<P>) {
        let Measurement { position, height_measured, by, .. } = &self.measurement;
        let place = position.0.xy();
        let (mut over_ground, (sigma_m, slow)) = match by {
            By::Transponder { horizontal_m, vertical_m } => {
                (plane::fix(place, *horizontal_m), (*vertical_m, false))
            }
            By::Radar { seen, errors, .. } => {
                (plane::plot(place, seen, errors), (errors.noise_height_m, true))
            }
        };
        let distance = predicted.distance(&over_ground);
        if distance > FAR {
            over_ground.noise *= distance / FAR;
        }
        self.plane.observe(&over_ground);
        if *height_measured {
            self.height.observe(&height::height(position.0.z, sigma_m, slow));
        }
    }

    /// Takes in what is told of the motion. How far off it is goes by what was known without this measurement's position,
    /// which may be the one that is wrong.
    fn observe_motion(&mut self, plane: &Gaussian<P>, height: &Gaussian<H>) {
        let Measurement { velocity, climb, .. } = self.measurement;
        if let Some((velocity, deviation)) = velocity.filter(|(v, _)| v.iter().all(|rate| rate.is_finite())) {
            self.plane.observe(&plane.bounded(plane::velocity(velocity, deviation), FAR));
        }
        if let Some((climb, deviation)) = climb.filter(|(climb, _)| climb.is_finite()) {
            self.height.observe(&height.bounded(height::climb(climb, deviation), FAR));
        }
    }
}
