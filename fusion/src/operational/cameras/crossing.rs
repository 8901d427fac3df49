//! Lines of sight of two cameras: how they pass each other, and the position that follows.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::{CameraTrack, OrientedCamera};
use crate::filter::StateEstimate;
use crate::frames::Enu;
use crate::operational::settings::Camera;
use crate::operational::tuning::{
    CAMERA_BETWEEN_S, CAMERA_BETWEEN_SHARE, CAMERA_CLOCK_S, CAMERA_CROSSING_SINE, CAMERA_ELEVATION_MAX,
    CAMERA_LASTING_MAX_M, CAMERA_LASTING2, CAMERA_NEAR_M,
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

/// Offset of a line of sight from the direction to a position: azimuth and elevation.
#[derive(Clone, Copy, Debug)]
pub(super) struct SightOffset {
    /// Differences, radians.
    pub(super) angles: [f64; 2],
    /// Their variances without those of the position, radians².
    pub(super) variances: [f64; 2],
    /// Their derivatives by the position, radians per metre.
    pub(super) rows: [Vector3<f64>; 2],
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
        if sine_over_ground(&along[0], &along[1]) < CAMERA_CROSSING_SINE || sine2 == 0.0 {
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

    /// Offset from the direction to a position; `None`: it is too near.
    pub(super) fn off(&self, position: &Vector3<f64>) -> Option<SightOffset> {
        let away = position - self.from;
        let ground_m = away.xy().norm();
        if ground_m < CAMERA_NEAR_M {
            return None;
        }
        let there = Self { angles: [away.x.atan2(away.y), away.z.atan2(ground_m)], ..*self };
        let azimuth = wrapped(self.angles[0] - there.angles[0]);
        let variances = [0, 1].map(|angle| self.white2[angle] + self.lasting2[angle]);
        let rows = there.sideways(away.norm()).map(|sideways| sideways / sideways.norm_squared());
        Some(SightOffset { angles: [azimuth, self.angles[1] - there.angles[1]], variances, rows })
    }
}

/// Variance of the errors of an angle that last, radians²; `own2`: that of a look, `turned2`: by the orientation; `rate`: change of
/// the angle, radians a second.
fn lasting2(own2: f64, turned2: f64, rate: f64) -> f64 {
    own2 + turned2 + CAMERA_LASTING2 + (rate * CAMERA_CLOCK_S).powi(2)
}

/// Sine of the angle between two directions over ground. Azimuths alone measure the position over ground in the filter.
pub(super) fn sine_over_ground(one: &Vector3<f64>, other: &Vector3<f64>) -> f64 {
    let (one, other) = (one.xy(), other.xy());
    one.perp(&other).abs() / (one.norm() * other.norm()).max(f64::MIN_POSITIVE)
}

/// A camera's view of a place: unit vectors over ground, and the lasting errors there.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastingErrors {
    outward: Vector2<f64>,
    /// Tangent of the elevation.
    slope: f64,
    /// Variance across the line of sight over ground, m².
    across_m2: f64,
    /// Variance of the height at a known distance, m².
    height_m2: f64,
}

impl LastingErrors {
    /// `None`: the place is too near to the camera, or too steep.
    pub(super) fn of(
        camera: &Camera,
        orientation: &CameraOrientation,
        place: &StateEstimate,
    ) -> Option<Self> {
        let away = place.position.0 - camera.position.0;
        let ground_m = away.xy().norm();
        let angles = [away.x.atan2(away.y), away.z.atan2(ground_m)];
        if ground_m < CAMERA_NEAR_M || angles[1].abs() > CAMERA_ELEVATION_MAX {
            return None;
        }
        let line = SightLine { from: camera.position.0, angles, white2: [0.0; 2], lasting2: [0.0; 2] };
        let sideways = line.sideways(away.norm());
        let own2 = [camera.azimuth.powi(2), camera.elevation.powi(2)];
        let turned2 = orientation.variances(angles);
        let [azimuth2, elevation2] = [0, 1].map(|angle| {
            let rate = sideways[angle].dot(&place.velocity) / sideways[angle].norm_squared();
            lasting2(own2[angle], turned2[angle], rate)
        });
        Some(Self {
            outward: away.xy() / ground_m,
            slope: away.z / ground_m,
            across_m2: ground_m * ground_m * azimuth2,
            height_m2: elevation2 * (away.norm_squared() / ground_m).powi(2),
        })
    }
}

/// Covariance of a position over ground, and variance of its height, m², by the lasting errors of several cameras; `None` for fewer
/// than two.
pub(super) fn lasting_m2(errors: &[LastingErrors]) -> Option<(Matrix2<f64>, f64)> {
    if errors.len() < 2 {
        return None;
    }
    let mut information = Matrix2::identity() / CAMERA_LASTING_MAX_M.powi(2);
    for one in errors {
        let clockwise = Vector2::new(one.outward.y, -one.outward.x);
        information += clockwise * clockwise.transpose() / one.across_m2;
    }
    let horizontal = information.try_inverse()?;
    let of_height = |one: &LastingErrors| {
        let along_m2 = (one.outward.transpose() * horizontal * one.outward).x;
        1.0 / (one.height_m2 + one.slope * one.slope * along_m2)
    };
    Some((horizontal, 1.0 / errors.iter().map(of_height).sum::<f64>()))
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

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Line of sight from a camera to a place, with errors of these standard deviations, degrees, and an error drawn.
    fn line(
        from: Vector3<f64>,
        to: Vector3<f64>,
        [white_deg, lasting_deg]: [f64; 2],
        draw: &mut impl FnMut() -> f64,
    ) -> SightLine {
        let away = to - from;
        let (white, lasting) = (white_deg.to_radians(), lasting_deg.to_radians());
        let mut error = || draw() * white.hypot(lasting);
        SightLine {
            from,
            angles: [away.x.atan2(away.y) + error(), away.z.atan2(away.xy().norm()) + error()],
            white2: [white * white; 2],
            lasting2: [lasting * lasting; 2],
        }
    }

    fn crossing(one: &SightLine, other: &SightLine) -> Crossing {
        match one.passing(other) {
            Passing::Near(crossing) => crossing,
            other => panic!("{other:?}"),
        }
    }

    fn places(rng: &mut ChaCha8Rng) -> [Vector3<f64>; 3] {
        let place = |rng: &mut ChaCha8Rng, up_m: f64| {
            Vector3::new(rng.random_range(-500.0..500.0), rng.random_range(-500.0..500.0), up_m)
        };
        [place(rng, 5.0), place(rng, 20.0), place(rng, 90.0)]
    }

    fn is_wide([one, other, drone]: &[Vector3<f64>; 3]) -> bool {
        let (first, second) = (drone - one, drone - other);
        sine_over_ground(&first, &second) > 0.3 && first.norm().min(second.norm()) > 150.0
    }

    #[test]
    fn exact_lines_cross_at_the_aircraft() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..200 {
            let places = places(&mut rng);
            if !is_wide(&places) {
                continue;
            }
            let [one, other, drone] = places;
            let sight = |from| line(from, drone, [0.1, 0.1], &mut || 0.0);
            let crossing = crossing(&sight(one), &sight(other));
            assert!((crossing.position - drone).norm() < 1e-6 && crossing.gap_m.abs() < 1e-6, "{crossing:?}");
        }
    }

    #[test]
    fn errors_of_position_and_gap_are_as_stated() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let (mut squares, mut gaps, mut count) = (0.0, 0.0, 0.0);
        while count < 2000.0 {
            let places = places(&mut rng);
            if !is_wide(&places) {
                continue;
            }
            let [one, other, drone] = places;
            let mut draw = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
            let first = line(one, drone, [0.1, 0.2], &mut draw);
            let second = line(other, drone, [0.3, 0.05], &mut draw);
            let crossing = crossing(&first, &second);
            let off = crossing.position - drone;
            squares += (off.transpose() * crossing.covariance.try_inverse().unwrap() * off).x / 3.0;
            gaps += crossing.gap_m.powi(2) / (crossing.white_m.powi(2) + crossing.lasting_m.powi(2));
            count += 1.0;
        }
        println!("position {:.2}, gap {:.2}", squares / count, gaps / count);
        assert!((0.9..1.1).contains(&(squares / count)), "{}", squares / count);
        assert!((0.9..1.1).contains(&(gaps / count)), "{}", gaps / count);
    }

    #[test]
    fn lines_that_meet_behind_a_camera_do_not_cross() {
        let drone = Vector3::new(0.0, 300.0, 80.0);
        let first = line(Vector3::zeros(), drone, [0.1, 0.1], &mut || 0.0);
        let mut second = line(Vector3::new(300.0, 300.0, 0.0), drone, [0.1, 0.1], &mut || 0.0);
        second.angles[0] += std::f64::consts::PI;
        assert!(matches!(first.passing(&second), Passing::Behind));
        let beside = line(Vector3::new(1.0, 0.0, 0.0), drone, [0.1, 0.1], &mut || 0.0);
        assert!(matches!(first.passing(&beside), Passing::Parallel));
    }
}
