//! Volumes in space and time: the interval for which straight flight stays inside a volume.
//!
//! A volume is violated while the aircraft are too close over ground and in height at the same time. The definitions are
//! those of DO-365 as NASA states them (C. Muñoz et al., *DAIDALUS: detect and avoid alerting logic for unmanned systems*,
//! DASC 2015; A. Narkawicz et al., *A TCAS-II resolution advisory detection algorithm* for modified tau), with a threshold
//! of zero for the time to co-altitude.

use nalgebra::Vector2;

/// A time interval, seconds from now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Begin, seconds.
    pub entry_s: f64,
    /// End, seconds.
    pub exit_s: f64,
}

impl Interval {
    /// The whole time axis.
    const ALWAYS: Self = Self { entry_s: f64::NEG_INFINITY, exit_s: f64::INFINITY };

    /// The common part of two intervals; `None` if it has no duration.
    pub fn and(self, other: Self) -> Option<Self> {
        let (entry_s, exit_s) = (self.entry_s.max(other.entry_s), self.exit_s.min(other.exit_s));
        (entry_s < exit_s).then_some(Self { entry_s, exit_s })
    }
}

/// Straight relative motion over ground, in axes along and across the relative velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Course {
    /// Relative speed, metres a second.
    pub(super) speed: f64,
    /// Unit vector of the relative velocity; east for aircraft at rest relative to each other.
    pub(super) along: Vector2<f64>,
    /// Present coordinate along the velocity, metres: negative while the aircraft approach.
    pub(super) along_m: f64,
    /// Coordinate across it, to the left, metres: constant in straight flight.
    pub(super) across_m: f64,
}

impl Course {
    pub(super) fn of(position: &Vector2<f64>, velocity: &Vector2<f64>) -> Self {
        let speed = velocity.norm();
        let along = if speed > 0.0 { velocity / speed } else { Vector2::x() };
        let across = Vector2::new(-along.y, along.x);
        Self { speed, along, along_m: position.dot(&along), across_m: position.dot(&across) }
    }

    /// Unit vector across the velocity, to the left.
    pub(super) fn across(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }

    /// Time until the coordinate along the velocity has this value, seconds; minus or plus infinity for aircraft at rest.
    pub(super) fn time_at(&self, along_m: f64) -> f64 {
        let away_m = along_m - self.along_m;
        if self.speed > 0.0 { away_m / self.speed } else { away_m.signum() * f64::INFINITY }
    }

    /// Time for which the aircraft are within a cross-section, in the past and in the future.
    fn within(&self, section: &CrossSection) -> Option<Interval> {
        let chord = section.chord(self.across_m, self.speed)?;
        if self.speed > 0.0 {
            return Some(Interval {
                entry_s: self.time_at(-chord.ahead_m),
                exit_s: self.time_at(chord.behind_m),
            });
        }
        (self.along_m.abs() < chord.behind_m).then_some(Interval::ALWAYS)
    }
}

/// Horizontal extent of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CrossSection {
    /// Radius, metres.
    pub(super) radius_m: f64,
    /// Threshold of modified tau, seconds; 0: none.
    pub(super) tau_s: f64,
}

/// Part of a line along the relative velocity that lies inside a volume: from `-ahead_m` to `behind_m`, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chord {
    pub(super) ahead_m: f64,
    pub(super) behind_m: f64,
}

impl CrossSection {
    /// The chord at a distance of `across_m` beside the centre; `None` if the line misses the volume.
    ///
    /// Modified tau is (R² - r²) / (p·v). While the aircraft approach and their lines pass within R, it is at most τ if
    /// x² + τ v x + y² - R² <= 0, with x along and y across the relative velocity.
    pub(super) fn chord(&self, across_m: f64, speed: f64) -> Option<Chord> {
        let square_m2 = (self.radius_m - across_m) * (self.radius_m + across_m);
        (square_m2 >= 0.0).then(|| self.chord_of(square_m2.sqrt(), speed))
    }

    /// The chord whose half length in the cylinder is `half_m`.
    pub(super) fn chord_of(&self, half_m: f64, speed: f64) -> Chord {
        let early_m = self.tau_s * speed;
        let ahead_m = if early_m > 0.0 { (early_m + early_m.hypot(2.0 * half_m)) / 2.0 } else { half_m };
        Chord { ahead_m, behind_m: half_m }
    }
}

/// Time for which two aircraft in straight flight are within `radius_m` over ground, or have a modified tau of at most
/// `tau_s` while they approach and their lines pass within `radius_m`; in the past and in the future.
///
/// `position` is in metres, `velocity` in metres a second, both relative. A touch at one instant yields an interval
/// without duration. Aircraft at rest on the rim are outside. `None`: they never come that near.
pub fn interval_over_ground(
    position: &Vector2<f64>,
    velocity: &Vector2<f64>,
    radius_m: f64,
    tau_s: f64,
) -> Option<Interval> {
    Course::of(position, velocity).within(&CrossSection { radius_m, tau_s })
}

/// Time for which the heights of two aircraft in straight flight differ by less than `half_m`, in the past and in the
/// future. `height_m` is the present difference in metres, `climb` its rate in metres a second. `None`: never.
pub fn interval_in_height(height_m: f64, climb: f64, half_m: f64) -> Option<Interval> {
    if climb == 0.0 {
        return (height_m.abs() < half_m).then_some(Interval::ALWAYS);
    }
    let at = |level_m: f64| (level_m - height_m) / climb;
    let (low_s, high_s) = (at(-half_m), at(half_m));
    Some(Interval { entry_s: low_s.min(high_s), exit_s: low_s.max(high_s) })
}
