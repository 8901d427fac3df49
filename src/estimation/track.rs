//! One target's measurements in the order of their time: a filter forward, a smoother backward.
//!
//! What came late is put in its place and everything behind it is filtered anew, so that the order of arrival plays no part.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::height::{self, Height};
use super::imm::{Bridge, Gaussian};
use super::motion::Models;
use super::plane::{self, Plane};
use super::slow::{SlowChange, SlowError};
use crate::normalise::Enu;
use crate::time::Time;

/// How wrong a radar is, one standard deviation each: an error that lasts for a while (registration included, where that is
/// not known), and one that is new with every plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarErrors {
    /// Slow error of the range, metres.
    pub slow_range_m: f64,
    /// Slow error of the azimuth, radians.
    pub slow_azimuth: f64,
    /// Slow error of the height, metres.
    pub slow_height_m: f64,
    /// Error of a plot's range, metres.
    pub fast_range_m: f64,
    /// Error of a plot's azimuth, radians.
    pub fast_azimuth: f64,
    /// Error of a plot's height, metres.
    pub fast_height_m: f64,
    /// The slow errors are forgotten to 1/e in this time, seconds.
    pub correlation_s: f64,
}

impl RadarErrors {
    /// Of a radar whose data sheet tells its accuracy, one standard deviation each, as metres, degrees, metres.
    ///
    /// A data sheet does not tell how much of that lasts: assumed are a slow error that is as large (in azimuth 1.3 times: turns
    /// make it larger), and a fast one that is a fraction of it.
    pub fn of_data_sheet(range_m: f64, azimuth_deg: f64, height_m: f64) -> Self {
        let azimuth = azimuth_deg.to_radians();
        Self {
            slow_range_m: 0.9 * range_m,
            slow_azimuth: 1.3 * azimuth,
            slow_height_m: 0.9 * height_m,
            fast_range_m: 0.4 * range_m,
            fast_azimuth: 0.2 * azimuth,
            fast_height_m: 0.3 * height_m,
            correlation_s: 20.0,
        }
    }
}

/// How a radar sees a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Distance over ground, metres.
    pub range_m: f64,
    /// Unit vector away from the radar.
    pub outward: Vector2<f64>,
    /// Unit vector of growing azimuth.
    pub clockwise: Vector2<f64>,
}

impl Seen {
    /// A place as the radar at `radar` sees it.
    pub fn from(radar: Enu, place: Enu) -> Self {
        let away = (place.0 - radar.0).xy();
        let range_m = away.norm().max(1.0);
        let outward = away / range_m;
        Self { range_m, outward, clockwise: Vector2::new(outward.y, -outward.x) }
    }

    /// Covariance over ground of these deviations, metres and radians.
    pub fn spread(&self, range_m: f64, azimuth: f64) -> Matrix2<f64> {
        let across = self.range_m * azimuth;
        self.outward * self.outward.transpose() * (range_m * range_m)
            + self.clockwise * self.clockwise.transpose() * (across * across)
    }
}

/// Something that was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// When.
    pub time: Time,
    /// Where.
    pub position: Enu,
    /// Whether the height was measured.
    pub height_measured: bool,
    /// Velocity over ground at that time, east and north, and the standard deviation of each; metres a second. One that is
    /// no number is not used.
    pub velocity: Option<(Vector2<f64>, f64)>,
    /// Rate of climb, and its standard deviation; metres a second. The same.
    pub climb: Option<(f64, f64)>,
    /// By what.
    pub by: By,
}

/// What measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum By {
    /// A transponder; deviations of its position over ground and in height from report to report, metres.
    Transponder {
        /// Over ground, each axis.
        horizontal_m: f64,
        /// In height.
        vertical_m: f64,
    },
    /// A track of a radar.
    Radar {
        /// Another one has another slow error.
        owner: Owner,
        /// What is known of that before.
        known: SlowError,
        /// How the radar sees the place.
        seen: Seen,
        /// Its errors.
        errors: RadarErrors,
    },
}

/// Whose slow error: a radar track, since when it has been the source of the position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    /// Tells radar tracks apart.
    pub tracklet: u64,
    /// The last report of a transponder before; `None`: there was none.
    pub since: Option<Time>,
}

/// Where a target is, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Position.
    pub position: Enu,
    /// Velocity east, north, up, metres a second.
    pub velocity: Vector3<f64>,
    /// Covariance of the position over ground, m².
    pub horizontal: Matrix2<f64>,
    /// Variance of the height, m².
    pub vertical: f64,
    /// Covariance of the velocity over ground, east and north, m²/s².
    pub velocity_spread: Matrix2<f64>,
    /// The later of the measurements it lies behind, and how long it is to the next one; seconds.
    pub since_s: f64,
    /// `None`: nothing was measured later, it is extrapolated.
    pub until_s: Option<f64>,
}

/// A measurement and what is known with it.
#[derive(Clone, Debug)]
struct Node {
    measurement: Measurement,
    /// The radar track whose slow error is estimated, and that radar.
    owner: Option<(Owner, RadarErrors)>,
    plane: Plane,
    height: Height,
    /// How far the transponder has jumped from where the motion led, metres over ground: it is wrong now, or was before.
    jumped: Vector2<f64>,
    /// From the node before; `None` for the first.
    bridges: Option<(Bridge<{ plane::STATES }>, Bridge<{ height::STATES }>)>,
}

/// The filter of one target.
#[derive(Clone, Debug, Default)]
pub struct Track {
    nodes: Vec<Node>,
}

/// A transponder further from where the motion led (squared Mahalanobis distance) has not flown there: turns and stops stay
/// below half of it.
const LEAP: f64 = 100.0;
/// A receiver's false place is forgotten to 1/e in this time, seconds.
const JUMP_LASTS_S: f64 = 30.0;
/// A position, velocity or climb further off than this is given less weight (squared Mahalanobis distance).
const FAR: f64 = 16.0;

impl Track {
    /// Brings the measurements after `since` to these, which are in order of time; those before stay. What did not change
    /// is not filtered again.
    pub fn measure(&mut self, since: Time, measurements: &[Measurement], models: &Models) {
        let old = self.nodes.partition_point(|node| node.measurement.time <= since);
        let same = self.nodes[old..]
            .iter()
            .zip(measurements)
            .take_while(|(node, measurement)| node.measurement == **measurement)
            .count();
        self.nodes.truncate(old + same);
        for measurement in &measurements[same..] {
            let node = match self.nodes.last() {
                None => Node::first(*measurement),
                Some(last) => last.next(*measurement, models),
            };
            self.nodes.push(node);
        }
    }

    /// Forgets what lies before the last measurement up to `time`.
    pub fn forget_before(&mut self, time: Time) {
        let keep = self.nodes.partition_point(|node| node.measurement.time <= time).saturating_sub(1);
        self.nodes.drain(..keep);
    }

    /// When the newest was.
    pub fn newest(&self) -> Option<Time> {
        self.nodes.last().map(|node| node.measurement.time)
    }

    /// Where the target is at `time`, from everything measured before and after; `None` before its first measurement.
    pub fn at(&self, time: Time, models: &Models) -> Option<Estimate> {
        let behind = self.nodes.partition_point(|node| node.measurement.time <= time);
        let before = &self.nodes[behind.checked_sub(1)?];
        let since_s = time.seconds_since(before.measurement.time);
        let (plane, _, height_here, _) = before.ahead(since_s, models);
        let plane_here = plane.combined();
        let Some(next) = self.nodes.get(behind) else {
            return Some(Estimate::of(&plane_here, &height_here, before.jumped, since_s, None));
        };
        // Back from the newest to the next one.
        let last = self.nodes.last()?;
        let (mut plane_after, mut height_after) = (last.plane.combined(), last.height);
        for pair in self.nodes[behind..].windows(2).rev() {
            let Some((plane_bridge, height_bridge)) = &pair[1].bridges else { continue };
            plane_after = pair[0].plane.combined().smoothed(plane_bridge, &plane_after);
            height_after = pair[0].height.smoothed(height_bridge, &height_after);
        }
        // And from there to here.
        let until_s = next.measurement.time.seconds_since(time);
        let here = Node { plane, height: height_here, ..before.clone() };
        let (_, plane_bridge, _, height_bridge) = here.ahead_to(next, until_s, models);
        let plane = plane_here.smoothed(&plane_bridge, &plane_after);
        let height = height_here.smoothed(&height_bridge, &height_after);
        let jumped = if next.jumped.norm() > before.jumped.norm() { next.jumped } else { before.jumped };
        Some(Estimate::of(&plane, &height, jumped, since_s, Some(until_s)))
    }
}

impl Estimate {
    fn of(
        plane: &Gaussian<{ plane::STATES }>,
        height: &Height,
        jumped: Vector2<f64>,
        since_s: f64,
        until_s: Option<f64>,
    ) -> Self {
        Self {
            position: Enu::new(plane.mean[0], plane.mean[1], height.mean[0]),
            velocity: Vector3::new(plane.mean[2], plane.mean[3], height.mean[1]),
            horizontal: plane.covariance.fixed_view::<2, 2>(0, 0) + jumped * jumped.transpose(),
            vertical: height.covariance[(0, 0)],
            velocity_spread: plane.covariance.fixed_view::<2, 2>(2, 2).into_owned(),
            since_s,
            until_s,
        }
    }

    /// Standard deviation over ground, metres: of each axis in the mean.
    pub fn deviation_m(&self) -> f64 {
        (self.horizontal.trace() / 2.0).max(0.0).sqrt()
    }
}

type Ahead = (Plane, Bridge<{ plane::STATES }>, Height, Bridge<{ height::STATES }>);

impl Node {
    fn first(measurement: Measurement) -> Self {
        let place = measurement.position.0.xy();
        let up = measurement.position.0.z;
        let (spread, deviation_m, owner) = match &measurement.by {
            By::Transponder { horizontal_m, vertical_m } => {
                (Matrix2::identity() * (horizontal_m * horizontal_m), *vertical_m, None)
            }
            By::Radar { owner, seen, errors, .. } => (
                plane::plot_spread(seen, errors),
                errors.fast_height_m.hypot(errors.slow_height_m),
                Some((*owner, *errors)),
            ),
        };
        let radar = owner.as_ref().map(|(_, errors)| SlowError::of(errors));
        let radar = radar.as_ref();
        let height = measurement.height_measured.then_some((up, deviation_m));
        let mut node = Self {
            owner,
            plane: plane::first(place, spread, radar),
            height: height::first(height, up, radar),
            jumped: Vector2::zeros(),
            bridges: None,
            measurement,
        };
        let (plane, height) = (node.plane.combined(), node.height);
        node.observe_motion(&plane, &height);
        node
    }

    /// The state `dt` seconds ahead, without a measurement.
    fn ahead(&self, dt: f64, models: &Models) -> Ahead {
        let slow = self.owner.map_or(SlowChange::NONE, |(_, radar)| SlowChange::after(&radar, dt));
        self.moved(dt, &slow, models)
    }

    /// The state where the next measurement is.
    fn ahead_to(&self, next: &Self, dt: f64, models: &Models) -> Ahead {
        let same = self.owner.map(|(owner, _)| owner) == next.owner.map(|(owner, _)| owner);
        let slow = match (&next.owner, &next.measurement.by) {
            (_, By::Radar { known, .. }) if !same => SlowChange::anew(*known),
            (Some((_, radar)), _) => SlowChange::after(radar, dt),
            (None, _) => SlowChange::NONE,
        };
        self.moved(dt, &slow, models)
    }

    fn moved(&self, dt: f64, slow: &SlowChange, models: &Models) -> Ahead {
        let motions = plane::motions(&models.each, dt, slow);
        let (plane, plane_bridge) = self.plane.predicted(&motions, &models.switch(dt));
        let height_bridge = self.height.predicted(&height::motion(dt, slow));
        (plane, plane_bridge, height_bridge.predicted, height_bridge)
    }

    fn next(&self, measurement: Measurement, models: &Models) -> Self {
        let dt = measurement.time.seconds_since(self.measurement.time);
        let owner = match measurement.by {
            By::Transponder { .. } => self.owner,
            By::Radar { owner, errors, .. } => Some((owner, errors)),
        };
        let jumped = self.jumped * (-dt / JUMP_LASTS_S).exp();
        let mut node =
            Self { measurement, owner, plane: self.plane, height: self.height, jumped, bridges: None };
        let (plane, mut plane_bridge, height, height_bridge) = self.ahead_to(&node, dt, models);
        node.plane = plane;
        node.height = height;
        node.leap(&mut plane_bridge.predicted);
        node.observe(&plane_bridge.predicted);
        node.observe_motion(&plane_bridge.predicted, &height);
        node.bridges = Some((plane_bridge, height_bridge));
        node
    }

    /// A transponder that is far from where the motion led has jumped: its receiver takes a reflection for a satellite, or
    /// no longer does. That says nothing of the speed.
    fn leap(&mut self, predicted: &mut Gaussian<{ plane::STATES }>) {
        let By::Transponder { horizontal_m, .. } = self.measurement.by else { return };
        let place = self.measurement.position.0.xy();
        let here = plane::fix(place, horizontal_m);
        let distance = predicted.distance(&here);
        if distance <= LEAP {
            return;
        }
        let away = place - predicted.mean.fixed_rows::<2>(0);
        self.jumped += away;
        let spread = away * away.transpose();
        plane::spread(predicted, &spread);
        self.plane.parts.iter_mut().for_each(|part| plane::spread(part, &spread));
    }

    fn observe(&mut self, predicted: &Gaussian<{ plane::STATES }>) {
        let Measurement { position, height_measured, by, .. } = &self.measurement;
        let place = position.0.xy();
        let (mut over_ground, (deviation_m, slow)) = match by {
            By::Transponder { horizontal_m, vertical_m } => {
                (plane::fix(place, *horizontal_m), (*vertical_m, false))
            }
            By::Radar { seen, errors, .. } => {
                (plane::plot(place, seen, errors), (errors.fast_height_m, true))
            }
        };
        let distance = predicted.distance(&over_ground);
        if distance > FAR {
            over_ground.noise *= distance / FAR;
        }
        self.plane.observe(&over_ground);
        if *height_measured {
            self.height.observe(&height::height(position.0.z, deviation_m, slow));
        }
    }

    /// Takes in what is told of the motion. How far off it is goes by what was known without this measurement's position,
    /// which may be the one that is wrong.
    fn observe_motion(&mut self, plane: &Gaussian<{ plane::STATES }>, height: &Height) {
        let Measurement { velocity, climb, .. } = self.measurement;
        if let Some((velocity, deviation)) = velocity.filter(|(v, _)| v.iter().all(|rate| rate.is_finite())) {
            self.plane.observe(&plane.bounded(plane::velocity(velocity, deviation), FAR));
        }
        if let Some((climb, deviation)) = climb.filter(|(climb, _)| climb.is_finite()) {
            self.height.observe(&height.bounded(height::climb(climb, deviation), FAR));
        }
    }
}
