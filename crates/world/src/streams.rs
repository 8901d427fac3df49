//! Random numbers: each entity has its own stream, so that adding one entity leaves the others unchanged.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Exp1, StandardNormal};

use crate::scenario::Span;

/// Kind of entity that draws random numbers. The discriminants are part of every seed. Multirotors and fixed wings are
/// counted separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entity {
    /// The flight of a drone.
    Drone = 0,
    /// The flight of a single bird.
    Bird = 1,
    /// The flight of a flock.
    Flock = 2,
    /// The path of a vehicle.
    Vehicle = 3,
    /// The position of clutter.
    Clutter = 4,
    /// A radar's classification of a target other than a drone.
    Character = 5,
    /// The transponder of a drone.
    Transponder = 6,
    /// A radar's detections of one target, by [`radar_target`].
    Sight = 7,
    /// A radar's processing.
    Radar = 8,
    /// A radar's line to the service.
    Line = 9,
    /// The equipment of a drone.
    Role = 10,
    /// The network.
    Network = 11,
    /// Frozen velocities that one radar reports for the tracks of one target, by [`radar_target`].
    Velocity = 12,
    /// The flight of a crewed aircraft, or the path of a surface vehicle.
    Crewed = 13,
    /// The ADS-B of a crewed aircraft or surface vehicle.
    Adsb = 14,
    /// The Remote ID of a drone.
    Beacon = 15,
    /// The choice of drones with Remote ID.
    BeaconRole = 16,
    /// A fake drone, which exists only in Remote ID.
    Fake = 17,
    /// A camera's detections of one target, by [`radar_target`].
    View = 18,
    /// The network of ADS-B, Remote ID and cameras.
    OtherNetwork = 19,
    /// The flight that the drones of a formation share.
    Formation = 20,
    /// Errors of a transponder beyond GNSS errors and delays.
    TransponderFault = 21,
    /// The second transponder of a drone.
    SecondTransponder = 22,
    /// Multipath ghosts of one drone in one radar, by [`radar_target`].
    Ghost = 23,
    /// A parameter of a random world.
    RandomWorld = 24,
}

/// Stream number of radar number `radar` and target number `target`.
pub fn radar_target(radar: usize, target: usize) -> usize {
    radar << 32 | target
}

/// The random streams of a scenario and seed.
#[derive(Clone, Copy, Debug)]
pub struct RandomStreams {
    seed: u64,
    scenario: u64,
}

impl RandomStreams {
    /// The streams for a scenario's name and a seed.
    pub fn new(scenario: &str, seed: u64) -> Self {
        Self { seed, scenario: fnv1a(scenario.as_bytes()) }
    }

    /// Returns the stream of the entity with this number, from its beginning.
    pub fn of(&self, entity: Entity, number: usize) -> RandomStream {
        let mut key = [0; 32];
        for (part, word) in
            key.chunks_exact_mut(8).zip([self.seed, self.scenario, entity as u64, number as u64])
        {
            part.copy_from_slice(&word.to_le_bytes());
        }
        RandomStream(ChaCha8Rng::from_seed(key))
    }
}

/// The random stream of one entity.
#[derive(Clone, Debug)]
pub struct RandomStream(ChaCha8Rng);

impl RandomStream {
    /// Uniform over a span.
    pub fn within(&mut self, span: Span) -> f64 {
        span.low + (span.high - span.low) * self.0.random::<f64>()
    }

    /// Uniform over 0 to `n` - 1.
    pub fn below(&mut self, n: usize) -> usize {
        self.0.random_range(0..n)
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// Normal with mean 0 and this standard deviation.
    pub fn normal(&mut self, sigma: f64) -> f64 {
        let unit: f64 = StandardNormal.sample(&mut self.0);
        sigma * unit
    }

    /// Exponential; infinite for an infinite mean.
    pub fn exponential(&mut self, mean: f64) -> f64 {
        let unit: f64 = Exp1.sample(&mut self.0);
        mean * unit
    }

    /// A direction, radians clockwise from north.
    pub fn heading(&mut self) -> f64 {
        std::f64::consts::TAU * self.0.random::<f64>()
    }

    /// Random octets.
    pub fn octets(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.0.random()).collect()
    }
}

/// A stationary first-order Gauss–Markov process with mean 0 and autocorrelation exp(-t / time constant).
#[derive(Clone, Copy, Debug)]
pub struct GaussMarkov {
    sigma: f64,
    time_constant_s: f64,
    value: f64,
    at_s: f64,
}

impl GaussMarkov {
    /// Draws the first value from the stationary distribution, at time `at_s`.
    pub fn new(sigma: f64, time_constant_s: f64, at_s: f64, stream: &mut RandomStream) -> Self {
        Self { sigma, time_constant_s, value: stream.normal(sigma), at_s }
    }

    /// Returns the value at `t_s`, which must not decrease from call to call.
    pub fn at(&mut self, t_s: f64, stream: &mut RandomStream) -> f64 {
        let kept = (-(t_s - self.at_s) / self.time_constant_s).exp();
        self.value = kept * self.value + stream.normal(self.sigma * (1.0 - kept * kept).sqrt());
        self.at_s = t_s;
        self.value
    }
}

/// FNV-1a, 64 bits: maps names to numbers, identically on every machine.
fn fnv1a(octets: &[u8]) -> u64 {
    octets.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &octet| {
        (hash ^ u64::from(octet)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
