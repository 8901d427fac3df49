//! Two aircraft that fly straight on: when they are closest, how close, and how likely within a volume.

use std::f64::consts::SQRT_2;

use nalgebra::{Matrix2, Matrix4, Vector2};

use super::{Ahead, Aircraft, Steady};

/// Slower than this towards each other two aircraft stay where they are, metres a second.
pub(super) const RESTING: f64 = 0.1;
/// Points of the rule by which the density over a disc is summed.
const POINTS: usize = 64;
/// Standard deviations beyond which nothing is summed.
const TAIL: f64 = 8.0;
/// Of a probability, a part that is left out.
const NEGLIGIBLE: f64 = 1e-4;

/// An aircraft seen from another one, at one instant: b minus a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// Over ground: east and north, metres.
    pub position: Vector2<f64>,
    /// Over ground, metres a second.
    pub velocity: Vector2<f64>,
    /// Covariance of both: east, north, and their rates.
    pub covariance: Matrix4<f64>,
    /// `None`: the height of one of them is not known.
    pub vertical: Option<Vertical>,
}

/// The part above ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertical {
    /// Difference of the heights, metres.
    pub height_m: f64,
    /// Difference of the climbs, metres a second.
    pub climb: f64,
    /// Variance of the height, its covariance with the climb, variance of the climb: m², m²/s, m²/s².
    pub covariance: [f64; 3],
}

/// The closest point of approach over ground within the horizon, and the covariance of the miss there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Time until then, seconds: 0 where they fly apart, the horizon where they are still approaching by then.
    pub t_cpa_s: f64,
    /// From a to b then, over ground, metres.
    pub miss: Vector2<f64>,
    /// Its covariance where both fly straight on, m².
    pub straight: Matrix2<f64>,
    /// Its covariance where one of them turns, or has begun to.
    pub turning: Matrix2<f64>,
    /// Probability that both fly straight on until then.
    pub share: f64,
    /// Difference of the heights then, metres, and its variance, m².
    pub vertical: Option<(f64, f64)>,
    /// Unit vector in which the miss is known as `across_m`.
    pub across: Vector2<f64>,
    /// Whether the miss lies across the relative velocity: the closest point is not cut off by now or by the horizon.
    is_inside: bool,
}

impl Relative {
    /// `b` seen from `a`.
    pub fn of(a: &Aircraft, b: &Aircraft) -> Self {
        let vertical = a.vertical.zip(b.vertical).map(|(one, other)| Vertical {
            height_m: b.position.up() - a.position.up(),
            climb: b.velocity.z - a.velocity.z,
            covariance: std::array::from_fn(|at| one[at] + other[at]),
        });
        Self {
            position: (b.position.0 - a.position.0).xy(),
            velocity: (b.velocity - a.velocity).xy(),
            covariance: a.covariance + b.covariance,
            vertical,
        }
    }

    /// Standard deviation of the position over ground: mean of the axes, metres.
    pub(super) fn sigma_m(&self) -> f64 {
        ((self.covariance[(0, 0)] + self.covariance[(1, 1)]) / 2.0).sqrt()
    }

    /// The closest point of approach within the horizon.
    pub fn approach(&self, ahead: &Ahead) -> Approach {
        let Self { position, velocity, covariance, vertical } = self;
        let speed = velocity.norm();
        let unbounded_s = if speed < RESTING { 0.0 } else { -position.dot(velocity) / (speed * speed) };
        let t = unbounded_s.clamp(0.0, ahead.horizon_s);
        let is_inside = speed >= RESTING && unbounded_s > 0.0 && unbounded_s < ahead.horizon_s;
        let miss = position + velocity * t;
        let blocks = |place: f64, rate: f64| {
            let block = |row, column| covariance.fixed_view::<2, 2>(row, column);
            block(0, 0) * (place * place)
                + (block(0, 2) + block(2, 0)) * (place * rate * t)
                + block(2, 2) * (rate * rate * t * t)
        };
        let Steady { place, velocity: rate, height, climb: climbs } = ahead.steady;
        let along = if is_inside { Vector2::new(-velocity.y, velocity.x) } else { miss };
        let across = along.try_normalize(0.0).unwrap_or_else(Vector2::x);
        Approach {
            t_cpa_s: t,
            miss,
            straight: blocks(place, rate),
            // Of each of the two.
            turning: blocks(1.0, 1.0) + Matrix2::identity() * (2.0 * ahead.grown_m2(t)),
            share: (-t / ahead.straight_s).exp(),
            vertical: vertical.map(|Vertical { height_m, climb, covariance: [hh, hc, cc] }| {
                let m2 = height * height * hh + 2.0 * t * height * climbs * hc + t * t * climbs * climbs * cc;
                (height_m + climb * t, m2)
            }),
            // The sign of a normal is a matter of taste: across is how far b passes.
            across: if across.dot(&miss) < 0.0 { -across } else { across },
            is_inside,
        }
    }
}

impl Approach {
    /// The miss over ground, metres.
    pub fn horizontal_m(&self) -> f64 {
        self.miss.norm()
    }

    /// Variance of the miss in the direction of `across`, m², whether they turn or not.
    pub fn across_m2(&self) -> f64 {
        let of = |covariance: &Matrix2<f64>| (self.across.transpose() * covariance * self.across).x;
        self.share * of(&self.straight) + (1.0 - self.share) * of(&self.turning)
    }

    /// Probability that the miss is within `horizontal_m` over ground and, where heights are known, `vertical_m` above it;
    /// 0 where it is less than `least`.
    pub fn probability(&self, horizontal_m: f64, vertical_m: f64, least: f64) -> f64 {
        let above = self.vertical.map_or(1.0, |(height_m, m2)| within(vertical_m, height_m, m2));
        if above < least {
            return 0.0;
        }
        let parts = [(self.share, &self.straight), (1.0 - self.share, &self.turning)];
        let weighed = parts.map(|(weight, covariance)| {
            // What cannot matter is not summed.
            let most = above * weight * self.at_most(horizontal_m, covariance);
            if most < NEGLIGIBLE { 0.0 } else { weight * self.over_ground(horizontal_m, covariance) }
        });
        let probability = above * (weighed[0] + weighed[1]);
        if probability < least { 0.0 } else { probability }
    }

    fn over_ground(&self, radius_m: f64, covariance: &Matrix2<f64>) -> f64 {
        if self.is_inside {
            let variance = (self.across.transpose() * covariance * self.across).x;
            within(radius_m, self.across.dot(&self.miss), variance)
        } else {
            in_disc(radius_m, &self.miss, covariance)
        }
    }

    /// A bound of the same for a disc, which is the dear one to sum: at most the highest density times the disc's area, and
    /// at most what lies on this side of its edge.
    fn at_most(&self, radius_m: f64, covariance: &Matrix2<f64>) -> f64 {
        if self.is_inside {
            return 1.0;
        }
        let determinant = covariance.determinant();
        let dense = if determinant > 0.0 { radius_m * radius_m / (2.0 * determinant.sqrt()) } else { 1.0 };
        let beyond_m = self.miss.norm() - radius_m;
        let is_far = beyond_m > 0.0 && beyond_m * beyond_m > TAIL * TAIL * covariance.trace();
        if is_far { 0.0 } else { dense }
    }
}

/// Probability that a normal variable lies within ± `half`.
fn within(half: f64, mean: f64, variance: f64) -> f64 {
    between(-half, half, mean, variance.max(0.0).sqrt())
}

fn between(from: f64, to: f64, mean: f64, sigma: f64) -> f64 {
    if sigma <= 0.0 {
        return f64::from(from <= mean && mean <= to);
    }
    // The tails of erfc keep their digits where those of erf cancel.
    let beyond = |x: f64| 0.5 * libm::erfc((x - mean) / (sigma * SQRT_2));
    (beyond(from) - beyond(to)).max(0.0)
}

/// Probability that a normal place over ground lies in the disc of this radius around the origin: along the axis that is
/// known worse by the midpoint rule, across it exactly.
fn in_disc(radius: f64, mean: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let eigen = covariance.symmetric_eigen();
    let (wide, narrow) = if eigen.eigenvalues.x >= eigen.eigenvalues.y { (0, 1) } else { (1, 0) };
    let sigma = |axis: usize| eigen.eigenvalues[axis].max(0.0).sqrt();
    let along = |axis: usize| eigen.eigenvectors.column(axis).dot(mean);
    let (sigma_x, x) = (sigma(wide), along(wide));
    if sigma_x <= 0.0 {
        return f64::from(mean.norm() <= radius);
    }
    let (from, to) = ((x - TAIL * sigma_x).max(-radius), (x + TAIL * sigma_x).min(radius));
    let step = (to - from).max(0.0) / POINTS as f64;
    let slice = |index: usize| {
        let at = from + (index as f64 + 0.5) * step;
        let half = (radius * radius - at * at).max(0.0).sqrt();
        between(at - step / 2.0, at + step / 2.0, x, sigma_x)
            * between(-half, half, along(narrow), sigma(narrow))
    };
    (0..POINTS).map(slice).sum()
}
