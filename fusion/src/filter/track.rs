//! What is measured of one target, and where it is by that.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::bias::Bias;
use super::filter::Filter;
use super::imm::Gaussian;
use super::motion::{MODELS, Models};
use super::singer::Singer;
use super::{height, plane};
use crate::frames::Enu;
use crate::time::Time;

/// How wrong a radar is, one standard deviation each: an error that lasts for a while (registration included, where that is
/// not known), and one that is new with every plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadarErrors {
    /// Slow error of the range, metres.
    pub bias_range_m: f64,
    /// Slow error of the azimuth, radians.
    pub bias_azimuth: f64,
    /// Slow error of the height, metres.
    pub bias_height_m: f64,
    /// Error of a plot's range, metres.
    pub noise_range_m: f64,
    /// Error of a plot's azimuth, radians.
    pub noise_azimuth: f64,
    /// Error of a plot's height, metres.
    pub noise_height_m: f64,
    /// The slow errors are forgotten to 1/e in this time, seconds.
    pub correlation_s: f64,
}

impl RadarErrors {
    /// Of a radar whose data sheet tells its accuracy, one standard deviation each, as metres, degrees, metres.
    ///
    /// A data sheet does not tell how much of that lasts: assumed are a slow error that is as large (in azimuth 1.3 times: turns
    /// make it larger), and a fast one that is a fraction of it.
    pub fn of_data_sheet(range_m: f64, azimuth_deg: f64, height_m: f64) -> Self {
        let azimuth = azimuth_deg.to_radians();
        Self {
            bias_range_m: 0.9 * range_m,
            bias_azimuth: 1.3 * azimuth,
            bias_height_m: 0.9 * height_m,
            noise_range_m: 0.4 * range_m,
            noise_azimuth: 0.2 * azimuth,
            noise_height_m: 0.3 * height_m,
            correlation_s: 20.0,
        }
    }
}

/// How a radar sees a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineOfSight {
    /// Distance over ground, metres.
    pub range_m: f64,
    /// Unit vector away from the radar.
    pub outward: Vector2<f64>,
    /// Unit vector of growing azimuth.
    pub clockwise: Vector2<f64>,
}

impl LineOfSight {
    /// A place as the radar at `radar` sees it.
    pub fn from(radar: Enu, place: Enu) -> Self {
        let away = (place.0 - radar.0).xy();
        let range_m = away.norm().max(1.0);
        let outward = away / range_m;
        Self { range_m, outward, clockwise: Vector2::new(outward.y, -outward.x) }
    }

    /// Covariance over ground of these deviations, metres and radians.
    pub fn spread(&self, range_m: f64, azimuth: f64) -> Matrix2<f64> {
        let across = self.range_m * azimuth;
        self.outward * self.outward.transpose() * (range_m * range_m)
            + self.clockwise * self.clockwise.transpose() * (across * across)
    }
}

/// Something that was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// When.
    pub time: Time,
    /// Where.
    pub position: Enu,
    /// Whether the height was measured.
    pub height_measured: bool,
    /// Velocity over ground at that time, east and north, and the standard deviation of each; metres a second. One that is
    /// no number is not used.
    pub velocity: Option<(Vector2<f64>, f64)>,
    /// Rate of climb, and its standard deviation; metres a second. The same.
    pub climb: Option<(f64, f64)>,
    /// By what.
    pub by: By,
}

/// What measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum By {
    /// A transponder; deviations of its position over ground and in height from report to report, metres.
    Transponder {
        /// Over ground, each axis.
        horizontal_m: f64,
        /// In height.
        vertical_m: f64,
    },
    /// A track of a radar.
    Radar {
        /// Another one has another slow error.
        owner: Owner,
        /// What is known of that before.
        known: Bias,
        /// How the radar sees the place.
        seen: LineOfSight,
        /// Its errors.
        errors: RadarErrors,
    },
}

/// Whose slow error: a radar track, since when it has been the source of the position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    /// Tells radar tracks apart.
    pub tracklet: u64,
    /// The last report of a transponder before; `None`: there was none.
    pub since: Option<Time>,
}

/// Where a target is, and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateEstimate {
    /// Position.
    pub position: Enu,
    /// Velocity east, north, up, metres a second.
    pub velocity: Vector3<f64>,
    /// Covariance of the position over ground, m².
    pub horizontal: Matrix2<f64>,
    /// Variance of the height, m².
    pub vertical: f64,
    /// Covariance of the velocity over ground, east and north, m²/s².
    pub velocity_covariance: Matrix2<f64>,
    /// How long ago the last measurement was, seconds; `None`: nothing was measured earlier, it is extrapolated backward.
    pub since_s: Option<f64>,
    /// How long it is to the next one, seconds; `None`: nothing was measured later, it is extrapolated.
    pub until_s: Option<f64>,
}

impl StateEstimate {
    /// Of a state over ground and one above it. `jumped`: see [`super::filter`].
    pub(super) fn of<const P: usize, const H: usize>(
        plane: &Gaussian<P>,
        height: &Gaussian<H>,
        jumped: Vector2<f64>,
        since_s: Option<f64>,
        until_s: Option<f64>,
    ) -> Self {
        Self {
            position: Enu::new(plane.mean[0], plane.mean[1], height.mean[0]),
            velocity: Vector3::new(plane.mean[2], plane.mean[3], height.mean[1]),
            horizontal: plane.covariance.fixed_view::<2, 2>(0, 0) + jumped * jumped.transpose(),
            vertical: height.covariance[(0, 0)],
            velocity_covariance: plane.covariance.fixed_view::<2, 2>(2, 2).into_owned(),
            since_s,
            until_s,
        }
    }

    /// Standard deviation over ground, metres: of each axis in the mean.
    pub fn sigma_m(&self) -> f64 {
        (self.horizontal.trace() / 2.0).max(0.0).sqrt()
    }
}

/// How targets are taken to move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dynamics {
    /// Interacting multiple models: straight on, disturbed little or much, and turns.
    Imm(Models),
    /// One model, with an acceleration that lasts for a while.
    Singer(Singer),
}

/// The filter of one target.
#[derive(Clone, Debug)]
pub struct TargetFilter(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Imm(Filter<Models, { plane::STATES }, MODELS, { height::STATES }>),
    Singer(Filter<Singer, { plane::STATES_SINGER }, 1, { height::STATES_SINGER }>),
}

impl TargetFilter {
    /// Of a target of which nothing was measured.
    pub fn new(dynamics: &Dynamics) -> Self {
        Self(match *dynamics {
            Dynamics::Imm(models) => Kind::Imm(Filter::new(models)),
            Dynamics::Singer(singer) => Kind::Singer(Filter::new(singer)),
        })
    }

    /// Brings the measurements after `since` to these, which are in order of time; those before stay. What did not change
    /// is not filtered again.
    pub fn measure(&mut self, since: Time, measurements: &[Measurement]) {
        match &mut self.0 {
            Kind::Imm(filter) => filter.measure(since, measurements),
            Kind::Singer(filter) => filter.measure(since, measurements),
        }
    }

    /// Forgets what lies before the last measurement up to `time`.
    pub fn forget_before(&mut self, time: Time) {
        match &mut self.0 {
            Kind::Imm(filter) => filter.forget_before(time),
            Kind::Singer(filter) => filter.forget_before(time),
        }
    }

    /// The newest.
    pub fn newest(&self) -> Option<&Measurement> {
        match &self.0 {
            Kind::Imm(filter) => filter.newest(),
            Kind::Singer(filter) => filter.newest(),
        }
    }

    /// Where the target is at `time`, from everything measured before and after; `None` if nothing was measured.
    pub fn at(&self, time: Time) -> Option<StateEstimate> {
        match &self.0 {
            Kind::Imm(filter) => filter.at(time),
            Kind::Singer(filter) => filter.at(time),
        }
    }
}
