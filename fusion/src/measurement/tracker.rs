//! The tracker of one aircraft: readings of any sensor in the order of their time.
//!
//! A reading that comes late is put in its place, and those after it are filtered again: the state is the one that would be
//! known had it come in time, with nothing approximated (Fasano et al., section 3.1, figure 3).

use std::collections::VecDeque;
use std::fmt::Debug;

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::flight::{Flight, Interacting, Moves};
use super::reading::Reading;
use super::update;
use crate::filter::{Gaussian, Mixture, Slow};
use crate::frames::Enu;
use crate::report::SensorIndex;
use crate::time::Time;

/// What is known of an aircraft at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// When.
    pub time: Time,
    /// Where.
    pub position: Enu,
    /// East, north, up, metres a second.
    pub velocity: Vector3<f64>,
    /// Covariance of position and velocity: east, north, up, and their rates.
    pub covariance: Matrix6<f64>,
}

impl Estimate {
    /// Of an aircraft that was seen once, with any velocity of that standard deviation on each axis, metres a second.
    /// `None` where the reading does not say where it is ([`Reading::place`]).
    pub fn first(reading: &Reading, speed: f64) -> Option<Self> {
        Some(Self::placed(reading.taken().time, reading.place()?, speed))
    }

    /// The same of an aircraft that two cameras saw at one instant. `None` where their lines of sight do not say where it is
    /// ([`Reading::crossing`]).
    pub fn crossed(readings: [&Reading; 2], speed: f64) -> Option<Self> {
        let [one, other] = readings;
        Some(Self::placed(one.taken().time, one.crossing(other)?, speed))
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

/// A reading from before what the tracker still holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the reading is older than anything the tracker still holds")]
pub struct TooOld;

/// The filter of one aircraft.
#[derive(Debug)]
pub struct Tracker(Box<dyn Tracking>);

/// A tracker of whichever size.
trait Tracking: Debug + Send + Sync {
    fn take(&mut self, reading: Reading) -> Result<(), TooOld>;
    fn distance(&self, reading: &Reading) -> Option<(f64, usize)>;
    fn at(&self, time: Time) -> Option<Estimate>;
    fn probabilities(&self, time: Time) -> Option<Vec<f64>>;
    fn forget_before(&mut self, time: Time);
    fn unused(&self) -> usize;
}

impl Tracker {
    /// Of an aircraft of which this is known. `None` for a flight of more than seven models.
    pub fn begin(flight: &Flight, estimate: &Estimate) -> Option<Self> {
        macro_rules! turning {
            ($turning:expr, $($count:literal),*) => {
                match 1 + $turning.rates.len() {
                    $($count => {
                        let models: Interacting<$count> = $turning.models()?;
                        Box::new(History::begin(models, estimate))
                    })*
                    _ => return None,
                }
            };
        }
        Some(Self(match flight {
            Flight::Singer(singer) => Box::new(History::begin(*singer, estimate)),
            Flight::Drone(models) => Box::new(History::begin(*models, estimate)),
            Flight::Turning(turning) => turning!(turning, 1, 2, 3, 4, 5, 6, 7),
        }))
    }

    /// Takes a reading in, at its time.
    pub fn take(&mut self, reading: Reading) -> Result<(), TooOld> {
        self.0.take(reading)
    }

    /// How far a reading is from what is expected by everything up to its time: squared Mahalanobis distance, and the count
    /// of its values that say something. For a gate. `None` where none does, or the reading is too old.
    pub fn distance(&self, reading: &Reading) -> Option<(f64, usize)> {
        self.0.distance(reading)
    }

    /// What is known at `time` by the readings up to it; `None` before anything that is held.
    pub fn at(&self, time: Time) -> Option<Estimate> {
        self.0.at(time)
    }

    /// How likely each model is by the readings up to `time`, in the order of the flight's, straight flight first.
    pub fn probabilities(&self, time: Time) -> Option<Vec<f64>> {
        self.0.probabilities(time)
    }

    /// Forgets what lies before the last reading up to `time`: nothing older comes any more.
    pub fn forget_before(&mut self, time: Time) {
        self.0.forget_before(time);
    }

    /// Of the readings that are held, the count of values that were too close to the sensor to be used.
    pub fn unused(&self) -> usize {
        self.0.unused()
    }
}

/// What is known once a reading was taken in; without one, at the beginning.
#[derive(Clone, Debug)]
struct Node<const D: usize, const M: usize> {
    time: Time,
    reading: Option<Reading>,
    state: Mixture<D, M>,
    /// The one Gaussian that stands for that mixture.
    combined: Gaussian<D>,
    /// Values of the reading that said nothing.
    unused: usize,
}

impl<const D: usize, const M: usize> Node<D, M> {
    /// The order in which readings are filtered.
    fn key(&self) -> (Time, Option<SensorIndex>) {
        (self.time, self.reading.as_ref().map(|reading| reading.taken().sensor))
    }

    fn moved<K: Moves<D, M>>(&self, time: Time, flight: &K) -> (Mixture<D, M>, Gaussian<D>) {
        let dt = time.seconds_since(self.time);
        let (state, bridge) =
            self.state.predicted(&self.combined, &flight.motions(dt), &Slow::NONE, &flight.switch(dt));
        (state, bridge.predicted)
    }

    /// The node of the next reading.
    fn next<K: Moves<D, M>>(&self, reading: Reading, flight: &K) -> Self {
        let time = reading.taken().time;
        let (mut state, combined) = self.moved(time, flight);
        let used = update::usable(&reading, state.parts.iter().chain([&combined]).map(|part| &part.mean));
        let unused =
            reading.values().len() - used.iter().take(reading.values().len()).filter(|used| **used).count();
        if let Some(whitening) = reading.whitening(used) {
            let fits = state.parts.each_mut().map(|part| update::take_in(part, &reading, &whitening));
            if fits.iter().all(Option::is_some) {
                let fits = fits.map(|fit| fit.expect("of each part"));
                state.weigh(&fits.map(|fit| fit.distance), fits.map(|fit| fit.determinant.sqrt().recip()));
            }
        }
        Self { time, reading: Some(reading), combined: state.combined(), state, unused }
    }
}

/// The readings that are held, with what was known at each.
#[derive(Debug)]
struct History<K, const D: usize, const M: usize> {
    flight: K,
    /// Never empty.
    nodes: VecDeque<Node<D, M>>,
}

impl<K: Moves<D, M>, const D: usize, const M: usize> History<K, D, M> {
    fn begin(flight: K, estimate: &Estimate) -> Self {
        let state = flight.first(estimate);
        let combined = state.combined();
        let beginning = Node { time: estimate.time, reading: None, state, combined, unused: 0 };
        Self { flight, nodes: VecDeque::from([beginning]) }
    }

    /// The last node up to a time.
    fn before(&self, time: Time) -> Option<&Node<D, M>> {
        self.nodes.iter().rev().find(|node| node.time <= time)
    }
}

impl<K, const D: usize, const M: usize> Tracking for History<K, D, M>
where
    K: Moves<D, M> + Debug + Send + Sync,
{
    fn take(&mut self, reading: Reading) -> Result<(), TooOld> {
        let key = (reading.taken().time, Some(reading.taken().sensor));
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
        let (_, expected) = self.before(reading.taken().time)?.moved(reading.taken().time, &self.flight);
        let whitening = reading.whitening(update::usable(reading, [&expected.mean]))?;
        let count = whitening.places().len();
        let fit = update::fit(&expected, reading, &whitening).filter(|_| count > 0)?;
        Some((fit.distance, count))
    }

    fn at(&self, time: Time) -> Option<Estimate> {
        Some(Estimate::of(time, &self.before(time)?.moved(time, &self.flight).1))
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
