//! A straight line fitted to positions: recursive least squares of position and rate.

/// Position and rate on `N` axes with equal errors, as the information of what was added so far. Times are relative to one
/// instant, in seconds.
#[derive(Clone, Copy)]
pub(super) struct LineFit<const N: usize> {
    /// Information of the position, of both, and of the rate.
    information: [f64; 3],
    of_position: [f64; N],
    of_rate: [f64; N],
}

/// Solution at the instant to which times are relative.
#[derive(Clone, Copy)]
pub(super) struct FittedLine<const N: usize> {
    pub(super) position: [f64; N],
    pub(super) rate: [f64; N],
    /// Variance of the position, covariance of position and rate, variance of the rate, on each axis.
    pub(super) covariance: [f64; 3],
}

impl<const N: usize> LineFit<N> {
    /// A fit with one position and a rate, each with its variance.
    pub(super) fn new(t: f64, position: [f64; N], position_m2: f64, rate: [f64; N], rate_m2s2: f64) -> Self {
        let mut fit = Self { information: [0.0; 3], of_position: [0.0; N], of_rate: [0.0; N] };
        fit.add(t, position, position_m2);
        let weight = rate_m2s2.recip();
        fit.information[2] += weight;
        for (sum, rate) in fit.of_rate.iter_mut().zip(rate) {
            *sum += weight * rate;
        }
        fit
    }

    /// Adds a position at time `t`.
    pub(super) fn add(&mut self, t: f64, position: [f64; N], position_m2: f64) {
        let weight = position_m2.recip();
        let [place, both, rate] = &mut self.information;
        *place += weight;
        *both += weight * t;
        *rate += weight * t * t;
        for (axis, position) in position.into_iter().enumerate() {
            self.of_position[axis] += weight * position;
            self.of_rate[axis] += weight * t * position;
        }
    }

    /// Square of the normalised difference between a position and the line, mean of the axes.
    pub(super) fn away(&self, t: f64, position: [f64; N], position_m2: f64) -> f64 {
        let FittedLine { position: expected, rate, covariance } = self.solve();
        let square =
            (0..N).map(|axis| (expected[axis] + rate[axis] * t - position[axis]).powi(2)).sum::<f64>();
        square / N as f64 / (position_m2 + after(covariance, t)[0])
    }

    pub(super) fn solve(&self) -> FittedLine<N> {
        let [place, both, rate] = self.information;
        let scale = (place * rate - both * both).recip();
        let covariance = [rate * scale, -both * scale, place * scale];
        let of = |of_position: f64, of_rate: f64| {
            std::array::from_fn(|axis| of_position * self.of_position[axis] + of_rate * self.of_rate[axis])
        };
        let [pp, pv, vv] = covariance;
        FittedLine { position: of(pp, pv), rate: of(pv, vv), covariance }
    }
}

/// Covariance of position and rate after `t` seconds.
pub(super) fn after([pp, pv, vv]: [f64; 3], t: f64) -> [f64; 3] {
    [pp + t * (2.0 * pv + t * vv), pv + t * vv, vv]
}
