//! Lines of sight of two cameras: how they pass each other, and the position that follows.

use nalgebra::{Matrix2, Matrix3, Vector3};

use super::{CameraTrack, OrientedCamera};
use crate::filter::StateEstimate;
use crate::frames::Enu;
use crate::operational::settings::Camera;
use crate::operational::tuning::{
    CAMERA_BETWEEN_S, CAMERA_BETWEEN_SHARE, CAMERA_CLOCK_S, CAMERA_CROSSING_SINE, CAMERA_ELEVATION_MAX,
    CAMERA_LASTING2, CAMERA_NEAR_M,
};
use crate::registration::{CameraOrientation, direction, wrapped};
use crate::report::Bearing;
use crate::time::Time;

/// A line of sight in true directions. Angles in radians: azimuth, elevation.
#[derive(Clone, Copy, Debug)]
pub(super) struct SightLine {
    from: Vector3<f64>,
    angles: [f64; 2],
    /// Variances of errors that are new with each look.
    white2: [f64; 2],
    /// Variances of errors that last: orientation, lens, clock.
    lasting2: [f64; 2],
}

/// Two lines of sight where they are closest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Likeliest position.
    pub(super) position: Vector3<f64>,
    /// Covariance of the position, m².
    pub(super) covariance: Matrix3<f64>,
    /// Distance between the lines, with a sign, metres.
    pub(super) gap_m: f64,
    /// Standard deviation of that distance by new errors, metres.
    pub(super) white_m: f64,
    /// Standard deviation of that distance by lasting errors, metres.
    pub(super) lasting_m: f64,
}

/// Outcome of two lines of sight.
#[derive(Clone, Copy, Debug)]
pub(super) enum Passing {
    /// They pass each other in front of both cameras.
    Near(Crossing),
    /// They pass each other behind a camera, or too near to one.
    Behind,
    /// They are nearly parallel.
    Parallel,
}

impl SightLine {
    /// The line of sight at these angles as stated by a camera, changing at `rates`, radians a second. `None`: the camera's
    /// orientation is unknown, or the direction is too steep.
    pub(super) fn new(
        stated: [f64; 2],
        between2: [f64; 2],
        rates: [f64; 2],
        camera: &Camera,
        oriented: &OrientedCamera,
    ) -> Option<Self> {
        let orientation = &oriented.orientation;
        let angles = orientation.correct(stated[0], stated[1]);
        if angles[1].abs() > CAMERA_ELEVATION_MAX || !orientation.is_known(angles, true) {
            return None;
        }
        let own2 = [camera.azimuth.powi(2), camera.elevation.powi(2)];
        let turned2 = orientation.variances(angles);
        let lasting2 = |angle: usize| lasting2(own2[angle], turned2[angle], rates[angle]);
        Some(Self {
            from: camera.position.0,
            angles,
            white2: [own2[0] + between2[0], own2[1] + between2[1]],
            lasting2: [lasting2(0), lasting2(1)],
        })
    }

    fn direction(&self) -> Vector3<f64> {
        direction(self.angles[0], self.angles[1])
    }

    /// Changes of a point at this distance on the line with azimuth and elevation, metres per radian.
    fn sideways(&self, distance_m: f64) -> [Vector3<f64>; 2] {
        let ((east, north), (up, level)) = (self.angles[0].sin_cos(), self.angles[1].sin_cos());
        [
            Vector3::new(north, -east, 0.0) * (level * distance_m),
            Vector3::new(-up * east, -up * north, level) * distance_m,
        ]
    }

    /// How it passes another line of sight at the same time.
    pub(super) fn passing(&self, other: &Self) -> Passing {
        let lines = [self, other];
        let along = lines.map(Self::direction);
        let (cosine, between) = (along[0].dot(&along[1]), other.from - self.from);
        let normal = along[0].cross(&along[1]);
        let sine2 = normal.norm_squared();
        if sine2 < CAMERA_CROSSING_SINE.powi(2) {
            return Passing::Parallel;
        }
        let normal = normal / sine2.sqrt();
        let distances_m = [
            (between.dot(&along[0]) - cosine * between.dot(&along[1])) / sine2,
            (cosine * between.dot(&along[0]) - between.dot(&along[1])) / sine2,
        ];
        if distances_m.iter().any(|&distance_m| distance_m < CAMERA_NEAR_M) {
            return Passing::Behind;
        }
        let across = [0, 1].map(|line| {
            let sideways = lines[line].sideways(distances_m[line]).map(|away| away.dot(&normal));
            let sum =
                |angles2: [f64; 2]| -> f64 { (0..2).map(|at| sideways[at].powi(2) * angles2[at]).sum() };
            [sum(lines[line].white2), sum(lines[line].lasting2)]
        });
        let weight = |line: usize| across[1 - line][0] + across[1 - line][1];
        let points = [0, 1].map(|line| lines[line].from + along[line] * distances_m[line]);
        let position = (points[0] * weight(0) + points[1] * weight(1)) / (weight(0) + weight(1));
        let mut information = Matrix3::zeros();
        for (line, distance_m) in lines.iter().zip(distances_m) {
            for (angle, sideways) in line.sideways(distance_m).iter().enumerate() {
                let variance = line.white2[angle] + line.lasting2[angle];
                information += sideways * sideways.transpose() / (sideways.norm_squared().powi(2) * variance);
            }
        }
        match information.try_inverse() {
            Some(covariance) => Passing::Near(Crossing {
                position,
                covariance,
                gap_m: normal.dot(&between),
                white_m: (across[0][0] + across[1][0]).sqrt(),
                lasting_m: (across[0][1] + across[1][1]).sqrt(),
            }),
            None => Passing::Parallel,
        }
    }

    /// Differences of azimuth and elevation to a position, radians, and their variances without those of the position; `None`: it
    /// is too near.
    pub(super) fn off(&self, position: &Vector3<f64>) -> Option<([f64; 2], [f64; 2], [Vector3<f64>; 2])> {
        let away = position - self.from;
        let ground_m = away.xy().norm();
        if ground_m < CAMERA_NEAR_M {
            return None;
        }
        let there = Self { angles: [away.x.atan2(away.y), away.z.atan2(ground_m)], ..*self };
        let azimuth = wrapped(self.angles[0] - there.angles[0]);
        let variances = [0, 1].map(|angle| self.white2[angle] + self.lasting2[angle]);
        let rows = there.sideways(away.norm()).map(|sideways| sideways / sideways.norm_squared());
        Some(([azimuth, self.angles[1] - there.angles[1]], variances, rows))
    }
}

/// Variance of the errors of an angle that last, radians²; `own2`: that of a look, `turned2`: by the orientation; `rate`: change of
/// the angle, radians a second.
fn lasting2(own2: f64, turned2: f64, rate: f64) -> f64 {
    own2 + turned2 + CAMERA_LASTING2 + (rate * CAMERA_CLOCK_S).powi(2)
}

/// Information on a position by the lasting errors of one camera, m⁻²; `None`: it is too near, or too steep.
pub(super) fn lasting_information(
    camera: &Camera,
    orientation: &CameraOrientation,
    place: &StateEstimate,
) -> Option<Matrix3<f64>> {
    let away = place.position.0 - camera.position.0;
    let angles = [away.x.atan2(away.y), away.z.atan2(away.xy().norm())];
    if away.xy().norm() < CAMERA_NEAR_M || angles[1].abs() > CAMERA_ELEVATION_MAX {
        return None;
    }
    let line = SightLine { from: camera.position.0, angles, white2: [0.0; 2], lasting2: [0.0; 2] };
    let (own2, turned2) = ([camera.azimuth.powi(2), camera.elevation.powi(2)], orientation.variances(angles));
    let mut information = Matrix3::zeros();
    for (angle, sideways) in line.sideways(away.norm()).into_iter().enumerate() {
        let row = sideways / sideways.norm_squared();
        let variance = lasting2(own2[angle], turned2[angle], row.dot(&place.velocity));
        information += row * row.transpose() / variance;
    }
    Some(information)
}

impl Crossing {
    /// Standard deviation of the position: mean of the axes, metres.
    pub(super) fn sigma_m(&self) -> f64 {
        (self.covariance.trace() / 3.0).sqrt()
    }

    /// Whether both may be the position of one aircraft: within five standard deviations.
    pub(super) fn may_be(&self, other: &Self) -> bool {
        let away = self.position - other.position;
        let covariance = self.covariance + other.covariance;
        covariance.cholesky().is_none_or(|root| away.dot(&root.solve(&away)) <= 25.0)
    }

    /// The position as an estimate, with an unknown velocity.
    pub(super) fn estimate(&self) -> StateEstimate {
        StateEstimate {
            position: Enu::from(self.position),
            velocity: Vector3::zeros(),
            horizontal: self.covariance.fixed_view::<2, 2>(0, 0).into(),
            vertical: self.covariance[(2, 2)],
            velocity_covariance: Matrix2::zeros(),
            position_velocity: Matrix2::zeros(),
            height_climb: 0.0,
            climb: 0.0,
            since_s: None,
            until_s: None,
        }
    }
}

impl CameraTrack {
    /// Line of sight at a time, between looks before and after it; `None` without such looks.
    pub(super) fn line_at(
        &self,
        time: Time,
        camera: &Camera,
        oriented: &OrientedCamera,
    ) -> Option<SightLine> {
        let after = self.looks.partition_point(|look| look.time < time);
        let next = self.looks.get(after)?;
        let angles = |look: &Bearing| Some([look.azimuth, look.elevation?]);
        let at_s = |look: &Bearing| look.time.seconds_since(time);
        let before = after.checked_sub(1).and_then(|index| self.looks.get(index));
        let is_near = |one: &Bearing, other: &Bearing| {
            other.time.seconds_since(one.time) <= CAMERA_BETWEEN_S
                && other.elevation.is_some()
                && one.elevation.is_some()
        };
        let rates = |one: &Bearing, other: &Bearing| {
            let (first, second) = (angles(one)?, angles(other)?);
            let dt = at_s(other) - at_s(one);
            Some([0, 1].map(|angle| wrapped(second[angle] - first[angle]) / dt))
        };
        if next.time == time {
            let beside = before.filter(|before| is_near(before, next)).map(|before| (before, next));
            let beside = beside
                .or_else(|| Some((next, self.looks.get(after + 1).filter(|look| is_near(next, look))?)));
            let rates = beside.and_then(|(one, other)| rates(one, other)).unwrap_or_default();
            return SightLine::new(angles(next)?, [0.0; 2], rates, camera, oriented);
        }
        let before = before.filter(|before| is_near(before, next))?;
        // Two looks on either side, if there are, else one.
        let outer =
            after.checked_sub(2).and_then(|index| self.looks.get(index)).zip(self.looks.get(after + 1));
        let outer = outer.filter(|(first, last)| is_near(first, before) && is_near(next, last));
        let start = angles(before)?;
        let (knots, share) = match outer {
            Some((first, last)) => (vec![first, before, next, last], CAMERA_BETWEEN_SHARE[1]),
            None => (vec![before, next], CAMERA_BETWEEN_SHARE[0]),
        };
        let mut stated = [0.0; 2];
        for (index, knot) in knots.iter().enumerate() {
            // Lagrange's interpolation, at time zero.
            let others =
                knots.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, other)| other);
            let weight: f64 = others.map(|other| at_s(other) / (at_s(other) - at_s(knot))).product();
            let there = angles(knot)?;
            for angle in 0..2 {
                stated[angle] += weight * wrapped(there[angle] - start[angle]);
            }
        }
        let rates = rates(before, next)?;
        let between_s = at_s(next) - at_s(before);
        SightLine::new(
            [start[0] + stated[0], start[1] + stated[1]],
            rates.map(|rate| (share * rate * between_s).powi(2)),
            rates,
            camera,
            oriented,
        )
    }
}
