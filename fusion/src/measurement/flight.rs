//! How aircraft move in space; the state is east, north, up (metres), their rates, and with Singer's model their
//! accelerations.

use super::tracker::Estimate;
use super::update::SEEN;
use crate::filter::{
    Axis, Course, Gaussian, MODELS, Mixture, Model, Models, Motion, Rows, Singer, Symmetric, Vector,
};

/// Numbers of a state with accelerations.
pub(super) const WITH_ACCELERATION: usize = 9;

/// How an aircraft is taken to move. Which, is a choice by class: multirotors stop and turn on the spot, aeroplanes do not
/// (the variable structure of Rousseau et al., section 3.2.5).
#[derive(Clone, Debug, PartialEq)]
pub enum Flight {
    /// An acceleration that lasts for a while, on each axis by itself.
    Singer(Singer),
    /// The interacting models of the operational profile, made for drones.
    Drone(Models),
    /// Straight on, and turns at given rates.
    Turning(Turning),
}

/// Straight on and turns, interacting. Upward all fly straight on, with the same noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Turning {
    /// Rates of the turns beside straight flight, radians a second, clockwise positive; none is zero. At most six.
    pub rates: Vec<f64>,
    /// Power spectral density of the acceleration on each axis, m²/s³: of each model.
    pub noise: f64,
    /// Probability that a model holds for a second; the others share the rest.
    pub stays: f64,
}

impl Turning {
    /// Of crewed aeroplanes: turns of 2 and 6 degrees a second either way, what is usual and what is the most (Rousseau et
    /// al., section 3.1).
    pub fn crewed(noise: f64, stays: f64) -> Self {
        Self { rates: [-2.0_f64, 2.0, -6.0, 6.0].map(f64::to_radians).to_vec(), noise, stays }
    }

    /// Of aircraft of any kind: also turns of 9 degrees a second, those of fighters.
    pub fn any(noise: f64, stays: f64) -> Self {
        let mut any = Self::crewed(noise, stays);
        any.rates.extend([-9.0_f64, 9.0].map(f64::to_radians));
        any
    }

    /// The models, straight flight first; `None` where they are not as many.
    pub(super) fn models<const M: usize>(&self) -> Option<Interacting<M>> {
        let noise = self.noise;
        let turns = self.rates.iter().map(|&rate| Model::Turn { rate, noise });
        let each: Vec<Model> = std::iter::once(Model::ConstantVelocity { noise }).chain(turns).collect();
        Some(Interacting { each: each.try_into().ok()?, stays: self.stays })
    }
}

/// `M` models of a state of `D` numbers.
pub(super) trait Moves<const D: usize, const M: usize> {
    type Motion: Motion<D>;

    /// What is known at first.
    fn first(&self, estimate: &Estimate) -> Mixture<D, M>;

    /// Each model's motion over `dt` seconds.
    fn motions(&self, dt: f64) -> [Self::Motion; M];

    /// Probabilities to change from one model to another within `dt` seconds.
    fn switch(&self, dt: f64) -> [[f64; M]; M];
}

/// Models of which each holds equally long.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interacting<const M: usize> {
    each: [Model; M],
    stays: f64,
}

impl<const M: usize> Moves<SEEN, M> for Interacting<M> {
    type Motion = InSpace;

    fn first(&self, estimate: &Estimate) -> Mixture<SEEN, M> {
        alike(estimate)
    }

    fn motions(&self, dt: f64) -> [InSpace; M] {
        self.each.map(|model| InSpace::of(&model, dt))
    }

    fn switch(&self, dt: f64) -> [[f64; M]; M] {
        let stays = if M == 1 { 1.0 } else { self.stays.powf(dt) };
        let others = (M - 1).max(1) as f64;
        std::array::from_fn(|from| {
            std::array::from_fn(|to| if from == to { stays } else { (1.0 - stays) / others })
        })
    }
}

impl Moves<SEEN, MODELS> for Models {
    type Motion = InSpace;

    fn first(&self, estimate: &Estimate) -> Mixture<SEEN, MODELS> {
        alike(estimate)
    }

    fn motions(&self, dt: f64) -> [InSpace; MODELS] {
        self.each.map(|model| InSpace::of(&model, dt))
    }

    fn switch(&self, dt: f64) -> [[f64; MODELS]; MODELS] {
        self.switch(dt)
    }
}

impl Moves<WITH_ACCELERATION, 1> for Singer {
    type Motion = Accelerating;

    fn first(&self, estimate: &Estimate) -> Mixture<WITH_ACCELERATION, 1> {
        let mut part = gaussian(estimate);
        for (axis, sigma) in [self.horizontal, self.horizontal, self.vertical].into_iter().enumerate() {
            part.covariance.add_at(SEEN + axis, SEEN + axis, sigma * sigma);
        }
        Mixture { weights: [1.0], parts: [part] }
    }

    fn motions(&self, dt: f64) -> [Accelerating; 1] {
        [Accelerating { over_ground: self.over(dt, self.horizontal), up: self.over(dt, self.vertical) }]
    }

    fn switch(&self, _: f64) -> [[f64; 1]; 1] {
        [[1.0]]
    }
}

/// Each model equally likely.
fn alike<const M: usize>(estimate: &Estimate) -> Mixture<SEEN, M> {
    Mixture { weights: [1.0 / M as f64; M], parts: [gaussian(estimate); M] }
}

/// A state that begins with what is estimated; the rest is zero, and certain.
fn gaussian<const D: usize>(estimate: &Estimate) -> Gaussian<D> {
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

/// A course over ground and, upward, straight on.
#[derive(Clone, Copy, Debug)]
pub(super) struct InSpace {
    course: Course,
    dt: f64,
}

impl InSpace {
    fn of(model: &Model, dt: f64) -> Self {
        Self { course: model.over(dt), dt }
    }
}

impl Motion<SEEN> for InSpace {
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
pub(super) struct Accelerating {
    over_ground: Axis,
    up: Axis,
}

impl Accelerating {
    fn axes(&self) -> [(&Axis, [usize; 3]); 3] {
        [(&self.over_ground, [0, 3, 6]), (&self.over_ground, [1, 4, 7]), (&self.up, [2, 5, 8])]
    }
}

impl Motion<WITH_ACCELERATION> for Accelerating {
    const MOVING: usize = WITH_ACCELERATION;

    fn carry<const N: usize>(&self, rows: &mut Rows<N, WITH_ACCELERATION>) {
        self.axes().into_iter().for_each(|(axis, states)| axis.carry(rows, states));
    }

    fn add_noise(&self, covariance: &mut Symmetric<WITH_ACCELERATION>) {
        self.axes().into_iter().for_each(|(axis, states)| axis.add_noise(covariance, states));
    }
}
