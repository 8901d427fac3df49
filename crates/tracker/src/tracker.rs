//! The tracker of one aircraft: readings of any sensor in order of time.
//!
//! A late reading is inserted at its time, and those after it are filtered again. The state is exactly that of readings
//! in time, without approximation (Fasano et al., section 3.1, figure 3).

use std::collections::VecDeque;
use std::fmt::Debug;

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::flight::{Flight, FlightMotion, InteractingModels};
use super::reading::Reading;
use super::update;
use fusion::filter::{BiasTransition, Gaussian, Mixture};
use fusion::frames::Enu;
use fusion::report::SensorIndex;
use fusion::time::Time;

/// Estimated state of an aircraft at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackerEstimate {
    /// Time of the estimate.
    pub time: Time,
    /// Position.
    pub position: Enu,
    /// Velocity east, north and up, metres a second.
    pub velocity: Vector3<f64>,
    /// Covariance of position and velocity: east, north, up, and their rates.
    pub covariance: Matrix6<f64>,
}

impl TrackerEstimate {
    /// Initial state from one reading, with a standard deviation `speed` of the velocity on each axis, metres a second.
    /// `None` if the reading gives no position ([`Reading::place`]).
    pub fn first(reading: &Reading, speed: f64) -> Option<Self> {
        Some(Self::placed(reading.origin().time, reading.place()?, speed))
    }

    /// Initial state from readings of two cameras at one instant. `None` if their lines of sight give no position
    /// ([`Reading::crossing`]).
    pub fn crossed(readings: [&Reading; 2], speed: f64) -> Option<Self> {
        let [one, other] = readings;
        Some(Self::placed(one.origin().time, one.crossing(other)?, speed))
    }

    fn placed(time: Time, (position, of_position): (Enu, Matrix3<f64>), speed: f64) -> Self {
        let mut covariance = Matrix6::from_diagonal_element(speed * speed);
        covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&of_position);
        Self { time, position, velocity: Vector3::zeros(), covariance }
    }

    fn of<const D: usize>(time: Time, state: &Gaussian<D>) -> Self {
        let mean = &state.mean;
        Self {
            time,
            position: Enu::new(mean[0], mean[1], mean[2]),
            velocity: Vector3::new(mean[3], mean[4], mean[5]),
            covariance: Matrix6::from_fn(|row, column| state.covariance.at(row, column)),
        }
    }
}

/// A reading older than those that the tracker still holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the reading is older than anything the tracker still holds")]
pub struct TooOld;

/// The filter of one aircraft.
#[derive(Debug)]
pub struct Tracker(Box<dyn Tracking>);

/// A tracker of any size.
trait Tracking: Debug + Send + Sync {
    fn update(&mut self, reading: Reading) -> Result<(), TooOld>;
    fn distance(&self, reading: &Reading) -> Option<(f64, usize)>;
    fn at(&self, time: Time) -> Option<TrackerEstimate>;
    fn probabilities(&self, time: Time) -> Option<Vec<f64>>;
    fn forget_before(&mut self, time: Time);
    fn unused(&self) -> usize;
}

impl Tracker {
    /// Creates a tracker with this initial state. `None` for a flight of more than seven models.
    pub fn begin(flight: &Flight, estimate: &TrackerEstimate) -> Option<Self> {
        macro_rules! turning {
            ($turning:expr, $($count:literal),*) => {
                match 1 + $turning.rates.len() {
                    $($count => {
                        let models: InteractingModels<$count> = $turning.models()?;
                        Box::new(ReadingHistory::begin(models, estimate))
                    })*
                    _ => return None,
                }
            };
        }
        Some(Self(match flight {
            Flight::Singer(singer) => Box::new(ReadingHistory::begin(*singer, estimate)),
            Flight::Drone(models) => Box::new(ReadingHistory::begin(*models, estimate)),
            Flight::Turning(turning) => turning!(turning, 1, 2, 3, 4, 5, 6, 7),
        }))
    }

    /// Adds a reading at its time.
    pub fn update(&mut self, reading: Reading) -> Result<(), TooOld> {
        self.0.update(reading)
    }

    /// Distance of a reading from the prediction by everything up to its time, for a gate: squared Mahalanobis
    /// distance, and the number of usable values. `None` if no value is usable, or the reading is too old.
    pub fn distance(&self, reading: &Reading) -> Option<(f64, usize)> {
        self.0.distance(reading)
    }

    /// State at `time` given the readings up to it; `None` before the first state held.
    pub fn at(&self, time: Time) -> Option<TrackerEstimate> {
        self.0.at(time)
    }

    /// Probabilities of the models given the readings up to `time`, in the order of the flight's, straight flight
    /// first.
    pub fn probabilities(&self, time: Time) -> Option<Vec<f64>> {
        self.0.probabilities(time)
    }

    /// Removes the readings before the last one up to `time`: older readings are then refused.
    pub fn forget_before(&mut self, time: Time) {
        self.0.forget_before(time);
    }

    /// Number of values, in the readings held, that were too close to the sensor to be used.
    pub fn unused(&self) -> usize {
        self.0.unused()
    }
}

/// The state after a reading or, without one, at the start.
#[derive(Clone, Debug)]
struct TrackerNode<const D: usize, const M: usize> {
    time: Time,
    reading: Option<Reading>,
    state: Mixture<D, M>,
    /// The Gaussian that approximates the mixture.
    combined: Gaussian<D>,
    /// Number of unusable values of the reading.
    unused: usize,
}

impl<const D: usize, const M: usize> TrackerNode<D, M> {
    /// Sort key of readings for the filter.
    fn key(&self) -> (Time, Option<SensorIndex>) {
        (self.time, self.reading.as_ref().map(|reading| reading.origin().sensor))
    }

    fn moved<K: FlightMotion<D, M>>(&self, time: Time, flight: &K) -> (Mixture<D, M>, Gaussian<D>) {
        let dt = time.seconds_since(self.time);
        let (state, bridge) = self.state.predicted(
            &self.combined,
            &flight.motions(dt),
            &BiasTransition::NONE,
            &flight.switch(dt),
        );
        (state, bridge.predicted)
    }

    /// The node of the next reading.
    fn next<K: FlightMotion<D, M>>(&self, reading: Reading, flight: &K) -> Self {
        let time = reading.origin().time;
        let (mut state, combined) = self.moved(time, flight);
        let used = update::usable(&reading, state.parts.iter().chain([&combined]).map(|part| &part.mean));
        let unused =
            reading.values().len() - used.iter().take(reading.values().len()).filter(|used| **used).count();
        if let Some(whitening) = reading.whitening(used) {
            let fits = state.parts.each_mut().map(|part| update::apply_reading(part, &reading, &whitening));
            if fits.iter().all(Option::is_some) {
                let fits = fits.map(|fit| fit.expect("of each part"));
                state.update_weights(
                    &fits.map(|fit| fit.distance),
                    fits.map(|fit| fit.determinant.sqrt().recip()),
                );
            }
        }
        Self { time, reading: Some(reading), combined: state.combined(), state, unused }
    }
}

/// The readings held, with the state at each.
#[derive(Debug)]
struct ReadingHistory<K, const D: usize, const M: usize> {
    flight: K,
    /// Never empty.
    nodes: VecDeque<TrackerNode<D, M>>,
}

impl<K: FlightMotion<D, M>, const D: usize, const M: usize> ReadingHistory<K, D, M> {
    fn begin(flight: K, estimate: &TrackerEstimate) -> Self {
        let state = flight.first(estimate);
        let combined = state.combined();
        let beginning = TrackerNode { time: estimate.time, reading: None, state, combined, unused: 0 };
        Self { flight, nodes: VecDeque::from([beginning]) }
    }

    /// The last node up to a time.
    fn before(&self, time: Time) -> Option<&TrackerNode<D, M>> {
        self.nodes.iter().rev().find(|node| node.time <= time)
    }
}

impl<K, const D: usize, const M: usize> Tracking for ReadingHistory<K, D, M>
where
    K: FlightMotion<D, M> + Debug + Send + Sync,
{
    fn update(&mut self, reading: Reading) -> Result<(), TooOld> {
        let key = (reading.origin().time, Some(reading.origin().sensor));
        let later = self.nodes.iter().rev().take_while(|node| node.key() > key).count();
        let place = self.nodes.len() - later;
        if place == 0 {
            return Err(TooOld);
        }
        let again: Vec<Reading> = self.nodes.drain(place..).filter_map(|node| node.reading).collect();
        for reading in std::iter::once(reading).chain(again) {
            let last = self.nodes.back().expect("never empty: what lies before the reading stays");
            let next = last.next(reading, &self.flight);
            self.nodes.push_back(next);
        }
        Ok(())
    }

    fn distance(&self, reading: &Reading) -> Option<(f64, usize)> {
        let (_, expected) = self.before(reading.origin().time)?.moved(reading.origin().time, &self.flight);
        let whitening = reading.whitening(update::usable(reading, [&expected.mean]))?;
        let count = whitening.places().len();
        let fit = update::fit(&expected, reading, &whitening).filter(|_| count > 0)?;
        Some((fit.distance, count))
    }

    fn at(&self, time: Time) -> Option<TrackerEstimate> {
        Some(TrackerEstimate::of(time, &self.before(time)?.moved(time, &self.flight).1))
    }

    fn probabilities(&self, time: Time) -> Option<Vec<f64>> {
        Some(self.before(time)?.state.weights.to_vec())
    }

    fn forget_before(&mut self, time: Time) {
        let settled = self.nodes.iter().take_while(|node| node.time <= time).count().saturating_sub(1);
        self.nodes.drain(..settled);
    }

    fn unused(&self) -> usize {
        self.nodes.iter().map(|node| node.unused).sum()
    }
}
