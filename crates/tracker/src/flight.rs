//! Motion models of aircraft in space; the state is east, north, up (metres), their rates, and with Singer's model
//! their accelerations.

use super::tracker::TrackerEstimate;
use super::update::SEEN;
use fusion::filter::{
    Course, Gaussian, LinearMotion, MODELS, Mixture, Model, Models, Rows, Singer, SingerTransition,
    Symmetric, Vector,
};

/// Number of variables of a state with accelerations.
pub(super) const WITH_ACCELERATION: usize = 9;

/// Motion model of an aircraft. It is chosen by class: multirotors stop and turn on the spot, aeroplanes do not (the
/// variable structure of Rousseau et al., section 3.2.5).
#[derive(Clone, Debug, PartialEq)]
pub enum Flight {
    /// A correlated acceleration on each axis.
    Singer(Singer),
    /// The interacting models of the operational profile, designed for drones.
    Drone(Models),
    /// Constant velocity and turns at given rates, interacting.
    Turning(Turning),
}

/// Constant velocity and turns, interacting. All models have a constant climb with the same noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Turning {
    /// Rates of the turns in addition to straight flight, radians a second, clockwise positive; none is zero. At most
    /// six.
    pub rates: Vec<f64>,
    /// Power spectral density of the acceleration on each axis, m²/s³, for each model.
    pub noise: f64,
    /// Probability that a model continues for a second; the others share the remainder equally.
    pub stays: f64,
}

impl Turning {
    /// Models of crewed aeroplanes: turns of 2 (usual) and 6 degrees a second (maximum) to either side (Rousseau et
    /// al., section 3.1).
    pub fn crewed(noise: f64, stays: f64) -> Self {
        Self { rates: [-2.0_f64, 2.0, -6.0, 6.0].map(f64::to_radians).to_vec(), noise, stays }
    }

    /// Models of aircraft of any kind: adds turns of 9 degrees a second, as of fighters.
    pub fn any(noise: f64, stays: f64) -> Self {
        let mut any = Self::crewed(noise, stays);
        any.rates.extend([-9.0_f64, 9.0].map(f64::to_radians));
        any
    }

    /// The models, straight flight first; `None` if there are not `M`.
    pub(super) fn models<const M: usize>(&self) -> Option<InteractingModels<M>> {
        let noise = self.noise;
        let turns = self.rates.iter().map(|&rate| Model::Turn { rate, noise });
        let each: Vec<Model> = std::iter::once(Model::ConstantVelocity { noise }).chain(turns).collect();
        Some(InteractingModels { each: each.try_into().ok()?, stays: self.stays })
    }
}

/// `M` models of a state of `D` numbers.
pub(super) trait FlightMotion<const D: usize, const M: usize> {
    type Motion: LinearMotion<D>;

    /// The initial state.
    fn first(&self, estimate: &TrackerEstimate) -> Mixture<D, M>;

    /// Each model's motion over `dt` seconds.
    fn motions(&self, dt: f64) -> [Self::Motion; M];

    /// Probabilities of a change from one model to another within `dt` seconds.
    fn switch(&self, dt: f64) -> [[f64; M]; M];
}

/// Models with the same mean duration.
#[derive(Clone, Copy, Debug)]
pub(super) struct InteractingModels<const M: usize> {
    each: [Model; M],
    stays: f64,
}

impl<const M: usize> FlightMotion<SEEN, M> for InteractingModels<M> {
    type Motion = CourseInSpace;

    fn first(&self, estimate: &TrackerEstimate) -> Mixture<SEEN, M> {
        alike(estimate)
    }

    fn motions(&self, dt: f64) -> [CourseInSpace; M] {
        self.each.map(|model| CourseInSpace::of(&model, dt))
    }

    fn switch(&self, dt: f64) -> [[f64; M]; M] {
        let stays = if M == 1 { 1.0 } else { self.stays.powf(dt) };
        let others = (M - 1).max(1) as f64;
        std::array::from_fn(|from| {
            std::array::from_fn(|to| if from == to { stays } else { (1.0 - stays) / others })
        })
    }
}

impl FlightMotion<SEEN, MODELS> for Models {
    type Motion = CourseInSpace;

    fn first(&self, estimate: &TrackerEstimate) -> Mixture<SEEN, MODELS> {
        alike(estimate)
    }

    fn motions(&self, dt: f64) -> [CourseInSpace; MODELS] {
        self.each.map(|model| CourseInSpace::of(&model, dt))
    }

    fn switch(&self, dt: f64) -> [[f64; MODELS]; MODELS] {
        self.switch(dt)
    }
}

impl FlightMotion<WITH_ACCELERATION, 1> for Singer {
    type Motion = AcceleratingMotion;

    fn first(&self, estimate: &TrackerEstimate) -> Mixture<WITH_ACCELERATION, 1> {
        let mut part = gaussian(estimate);
        for (axis, sigma) in [self.horizontal, self.horizontal, self.vertical].into_iter().enumerate() {
            part.covariance.add_at(SEEN + axis, SEEN + axis, sigma * sigma);
        }
        Mixture { weights: [1.0], parts: [part] }
    }

    fn motions(&self, dt: f64) -> [AcceleratingMotion; 1] {
        [AcceleratingMotion { over_ground: self.over(dt, self.horizontal), up: self.over(dt, self.vertical) }]
    }

    fn switch(&self, _: f64) -> [[f64; 1]; 1] {
        [[1.0]]
    }
}

/// A mixture in which each model is equally likely.
fn alike<const M: usize>(estimate: &TrackerEstimate) -> Mixture<SEEN, M> {
    Mixture { weights: [1.0 / M as f64; M], parts: [gaussian(estimate); M] }
}

/// A state that begins with the estimate; the other variables are zero, and certain.
fn gaussian<const D: usize>(estimate: &TrackerEstimate) -> Gaussian<D> {
    let mut mean: Vector<D> = [0.0; D];
    mean[..3].copy_from_slice(estimate.position.0.as_slice());
    mean[3..SEEN].copy_from_slice(estimate.velocity.as_slice());
    let mut covariance = Symmetric::ZERO;
    for row in 0..SEEN {
        for column in row..SEEN {
            covariance.add_at(row, column, estimate.covariance[(row, column)]);
        }
    }
    Gaussian { mean, covariance }
}

/// A course over ground, and a constant climb.
#[derive(Clone, Copy, Debug)]
pub(super) struct CourseInSpace {
    course: Course,
    dt: f64,
}

impl CourseInSpace {
    fn of(model: &Model, dt: f64) -> Self {
        Self { course: model.over(dt), dt }
    }
}

impl LinearMotion<SEEN> for CourseInSpace {
    const MOVING: usize = SEEN;

    fn carry<const N: usize>(&self, rows: &mut Rows<N, SEEN>) {
        self.course.carry_at(rows, [0, 1], [3, 4]);
        let climb = rows[5];
        rows[2].iter_mut().zip(climb).for_each(|(up, climb)| *up += self.dt * climb);
    }

    fn add_noise(&self, covariance: &mut Symmetric<SEEN>) {
        (0..3).for_each(|axis| self.course.add_noise_at(covariance, (axis, axis + 3)));
    }
}

/// Singer's motion on three axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct AcceleratingMotion {
    over_ground: SingerTransition,
    up: SingerTransition,
}

impl AcceleratingMotion {
    fn axes(&self) -> [(&SingerTransition, [usize; 3]); 3] {
        [(&self.over_ground, [0, 3, 6]), (&self.over_ground, [1, 4, 7]), (&self.up, [2, 5, 8])]
    }
}

impl LinearMotion<WITH_ACCELERATION> for AcceleratingMotion {
    const MOVING: usize = WITH_ACCELERATION;

    fn carry<const N: usize>(&self, rows: &mut Rows<N, WITH_ACCELERATION>) {
        self.axes().into_iter().for_each(|(axis, states)| axis.carry(rows, states));
    }

    fn add_noise(&self, covariance: &mut Symmetric<WITH_ACCELERATION>) {
        self.axes().into_iter().for_each(|(axis, states)| axis.add_noise(covariance, states));
    }
}
