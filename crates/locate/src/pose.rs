//! Position, alignment and clock of a radar, and what it would measure.

use std::f64::consts::{PI, TAU};

use fusion::frames::{Enu, RadarFrame, TangentPlane};
use nalgebra::{SVector, Vector3};

use crate::path::PathPoint;
use crate::pieces::TimedPlot;

/// Number of parameters: antenna east, north, up; bearing; range offset and scale; time.
pub(crate) const PARAMETERS: usize = 7;
/// Position, alignment and clock of a radar.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub(crate) frame: RadarFrame,
    pub(crate) antenna: Vector3<f64>,
    pub(crate) bearing: f64,
    pub(crate) offset_m: f64,
    pub(crate) scale: f64,
    /// A plot with this time stamp belongs to the position that a transponder reports for this much later, seconds.
    pub(crate) later_s: f64,
}

impl Pose {
    pub(crate) fn new(site: &TangentPlane, antenna: Vector3<f64>, bearing: f64, later_s: f64) -> Self {
        let place = site.to_geodetic(Enu::from(antenna));
        Self { frame: RadarFrame::new(site, place), antenna, bearing, offset_m: 0.0, scale: 0.0, later_s }
    }

    /// The pose with its parameters changed.
    pub(crate) fn changed(&self, site: &TangentPlane, by: &SVector<f64, PARAMETERS>) -> Self {
        let antenna = self.antenna + by.fixed_rows::<3>(0);
        Self {
            offset_m: self.offset_m + by[4],
            scale: self.scale + by[5],
            ..Self::new(site, antenna, wrapped(self.bearing + by[3]), self.later_s + by[6])
        }
    }

    /// East, north and up of a point as seen from the radar.
    pub(crate) fn local(&self, position: Vector3<f64>) -> Vector3<f64> {
        self.frame.from_site(Enu::from(position)).0
    }

    /// The parameters, in their order.
    pub(crate) fn parameters(&self) -> SVector<f64, PARAMETERS> {
        let at = self.antenna;
        SVector::from([at.x, at.y, at.z, self.bearing, self.offset_m, self.scale, self.later_s])
    }
}

/// An angle between -π and π.
pub(crate) fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// A plot minus what the radar would measure of a path's point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PolarResidual {
    pub(crate) azimuth: f64,
    pub(crate) range_m: f64,
    pub(crate) over_ground_m: f64,
    pub(crate) local: Vector3<f64>,
}

/// Minimum distance over ground, metres: nearer, the azimuth is not a linear measurement.
const NEAREST_M: f64 = 30.0;

/// `None` if the point is at the radar.
pub(crate) fn residual(plot: &TimedPlot, point: &PathPoint, pose: &Pose) -> Option<PolarResidual> {
    let local = pose.local(point.position);
    let over_ground_m = local.xy().norm();
    if over_ground_m < NEAREST_M {
        return None;
    }
    let azimuth = wrapped(plot.azimuth - local.x.atan2(local.y) - pose.bearing);
    let range_m = plot.range_m - local.norm() * (1.0 + pose.scale) - pose.offset_m;
    Some(PolarResidual { azimuth, range_m, over_ground_m, local })
}
