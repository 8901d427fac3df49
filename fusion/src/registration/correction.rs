//! Correction of plots by the misalignment.

use nalgebra::{Matrix6, UnitQuaternion, Vector2, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use super::along::rows;
use super::estimate::Misalignment;
use super::parameters::AXES;
use super::qmethod::rotation_vector;
use crate::frames::{AtRadar, Enu};

/// The negative of the observable part of the estimated misalignment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Correction {
    /// Whether nothing is observable: plots are then not changed by a single bit.
    nothing: bool,
    back: UnitQuaternion<f64>,
    range_m: f64,
    height_m: f64,
    left: Matrix6<f64>,
}

/// Standard deviations of the remaining misalignment at a position. Time is excluded, because its effect depends on the velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemainingMisalignment {
    /// Slant range, metres.
    pub range_m: f64,
    /// Azimuth, radians.
    pub azimuth: f64,
    /// Height, metres.
    pub height_m: f64,
}

impl Correction {
    /// Creates the correction from the observable values. Time is excluded, because it belongs to the transponders.
    pub fn of(estimate: &Misalignment) -> Self {
        let Misalignment { bearing, tilt_east, tilt_north, range_m, height_m, .. } = estimate;
        let taken = [bearing, tilt_east, tilt_north, range_m, height_m]
            .map(|value| if value.observable { value.value } else { 0.0 });
        let [bearing, tilt_east, tilt_north, range_m, height_m] = taken;
        let turn = rotation_vector(&Vector6::new(bearing, tilt_east, tilt_north, range_m, height_m, 0.0));
        Self {
            nothing: taken.iter().all(|&value| value == 0.0),
            back: UnitQuaternion::from_scaled_axis(-turn),
            range_m,
            height_m,
            left: estimate.left,
        }
    }

    /// Corrects a plot with a measured height.
    pub fn apply(&self, plot: Enu<AtRadar>) -> Enu<AtRadar> {
        if self.nothing {
            return plot;
        }
        let height_m = plot.up() - self.height_m;
        (self.back * self.at_range(plot.0, height_m)).into()
    }

    /// Corrects azimuth and slant range of a plot with an assumed height, which is kept.
    pub fn apply_without_height(&self, plot: Enu<AtRadar>) -> Enu<AtRadar> {
        if self.nothing {
            return plot;
        }
        let height_m = plot.up();
        let turned = self.back * self.at_range(plot.0, height_m);
        let range_m = turned.norm();
        at(turned.xy(), range_m, height_m).into()
    }

    /// Remaining misalignment at a position.
    pub fn remaining(&self, plot: Enu<AtRadar>) -> RemainingMisalignment {
        let rows: [_; AXES] = rows(&plot.0, &Vector3::zeros(), 0.0);
        let [azimuth, range_m, height_m] = rows.map(|row| row.dot(&(self.left * row)).max(0.0).sqrt());
        RemainingMisalignment { range_m, azimuth, height_m }
    }

    fn at_range(&self, plot: Vector3<f64>, height_m: f64) -> Vector3<f64> {
        at(plot.xy(), (plot.norm() - self.range_m).max(0.0), height_m)
    }
}

/// Position in this direction over ground, at this slant range and height.
fn at(direction: Vector2<f64>, range_m: f64, height_m: f64) -> Vector3<f64> {
    let ground_m = (range_m * range_m - height_m * height_m).max(0.0).sqrt();
    let outward = direction.try_normalize(0.0).unwrap_or_else(Vector2::zeros) * ground_m;
    Vector3::new(outward.x, outward.y, height_m)
}
