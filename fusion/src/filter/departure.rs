//! A transponder's report far from the predicted position: the aircraft has turned or stopped, or its receiver has
//! jumped.
//!
//! An aircraft that turned or stopped has another velocity afterwards, and the change of velocity explains its
//! displacement. A receiver that jumped, because it takes a reflection for a satellite, flies on beside its path or
//! returns to it. So the next report decides.

use nalgebra::SVector;

/// Largest acceleration of a drone, metres a second squared.
const MOST_M_S2: f64 = 15.0;
/// Largest rate of turn of an aircraft that is so fast that its turns need a larger acceleration, radians a second.
const MOST_TURN: f64 = 0.5;
/// Minimum share of the displacement that the change of velocity must explain. Steady acceleration over the whole
/// interval explains twice the displacement, a sudden one at its start exactly the displacement.
const EXPLAINED: f64 = 0.5;
/// Bound on the uncertainty of the predicted position, standard deviations.
const SIGMAS: f64 = 3.0;

/// A report far from the predicted position, on some axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Departure<const D: usize> {
    /// Displacement from the predicted position to the report, metres.
    pub(super) away: SVector<f64, D>,
    /// Standard deviation of the predicted position along the displacement, metres.
    pub(super) sigma_m: f64,
    /// Velocity before the report, metres a second.
    pub(super) velocity: SVector<f64, D>,
    /// Time since the transponder's previous report, seconds.
    pub(super) within_s: f64,
}

/// The cause of a departure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    /// The aircraft has turned, stopped or begun to fly.
    Motion,
    /// The receiver has jumped.
    Receiver,
    /// The next report decides.
    Undecided,
}

impl<const D: usize> Departure<D> {
    /// Whether an aircraft can have flown there.
    pub(super) fn is_in_reach(&self) -> bool {
        let accelerating_m = 0.5 * self.most_m_s2() * self.within_s.powi(2);
        self.away.norm() <= accelerating_m + SIGMAS * self.sigma_m
    }

    fn most_m_s2(&self) -> f64 {
        MOST_M_S2.max(MOST_TURN * self.velocity.norm())
    }

    /// Cause of the departure; `next` is the mean velocity from this report to the next one, metres a second, and the
    /// time between them, seconds.
    pub(super) fn cause(&self, next: Option<(SVector<f64, D>, f64)>) -> Cause {
        if !self.is_in_reach() {
            return Cause::Receiver;
        }
        let Some((velocity, after_s)) = next else { return Cause::Undecided };
        let change = velocity - self.velocity;
        let away_m = self.away.norm();
        let explained_m = change.dot(&self.away) / away_m * self.within_s;
        let can_be = change.norm() <= self.most_m_s2() * (self.within_s + after_s);
        if can_be && explained_m >= EXPLAINED * away_m { Cause::Motion } else { Cause::Receiver }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Vector2, vector};

    use super::*;

    /// An aircraft flies eastward at 16 m/s and reports every 2 s. The arguments are the positions of its second and
    /// third report, relative to the first.
    fn cause(second: Vector2<f64>, third: Option<Vector2<f64>>) -> Cause {
        let velocity = vector![16.0, 0.0];
        let departure = Departure { away: second - velocity * 2.0, sigma_m: 1.0, velocity, within_s: 2.0 };
        departure.cause(third.map(|third| ((third - second) / 2.0, 2.0)))
    }

    #[test]
    fn stops_and_turns_are_motion() {
        // Braking over the whole interval; braking at its start; a turn to the north.
        for (second, third) in [
            (vector![16.0, 0.0], vector![16.0, 0.0]),
            (vector![8.0, 0.0], vector![8.0, 0.0]),
            (vector![18.0, 14.0], vector![18.0, 46.0]),
        ] {
            assert_eq!(cause(second, None), Cause::Undecided);
            assert_eq!(cause(second, Some(third)), Cause::Motion, "{second} {third}");
        }
    }

    #[test]
    fn flight_beside_the_path_is_a_jump() {
        for third in [vector![64.0, 25.0], vector![64.0, 0.0], vector![60.0, 20.0]] {
            assert_eq!(cause(vector![32.0, 25.0], Some(third)), Cause::Receiver, "{third}");
        }
    }

    #[test]
    fn place_out_of_reach_is_a_jump() {
        assert_eq!(cause(vector![32.0, 40.0], None), Cause::Receiver);
        // The velocity afterwards is out of reach, too.
        assert_eq!(cause(vector![32.0, 25.0], Some(vector![32.0, 225.0])), Cause::Receiver);
    }
}
