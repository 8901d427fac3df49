//! Estimated parameters of a radar, and their priors.

/// Number of parameters, in this order: bearing, tilt about east, tilt about north (radians), range, height (metres), time (s).
pub(super) const PARAMETERS: usize = 6;
pub(super) const BEARING: usize = 0;
pub(super) const TILT_EAST: usize = 1;
pub(super) const TILT_NORTH: usize = 2;
pub(super) const RANGE: usize = 3;
pub(super) const HEIGHT: usize = 4;
pub(super) const TIME: usize = 5;

/// Prior standard deviations: radars are aligned by compass and spirit level, or better.
pub(super) const PRIOR: [f64; PARAMETERS] =
    [5.0_f64.to_radians(), 1.0_f64.to_radians(), 1.0_f64.to_radians(), 20.0, 15.0, 0.2];

/// Standard deviation below which a value is observable. Each is at most half of the [`PRIOR`], so only tracks make a value
/// observable.
pub(super) const USEFUL: [f64; PARAMETERS] =
    [0.5_f64.to_radians(), 0.25_f64.to_radians(), 0.25_f64.to_radians(), 5.0, 5.0, 0.1];

/// Number of axes on which a plot is compared: azimuth, range, height.
pub(super) const AXES: usize = 3;
pub(super) const AZIMUTH: usize = 0;
/// Parameter that shifts each axis directly.
pub(super) const OWN: [usize; AXES] = [BEARING, RANGE, HEIGHT];
