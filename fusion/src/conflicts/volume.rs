//! The volumes that aircraft keep around themselves.

use super::{Approach, Relative};

/// A foot, metres.
const FOOT_M: f64 = 0.3048;
/// A nautical mile, metres.
const MILE_M: f64 = 1852.0;

/// What an aircraft is to a volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Nobody is on board.
    #[default]
    Drone,
    /// Somebody is.
    Crewed,
}

/// Which aircraft a volume is about: one of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Of this kind.
    Only(Kind),
    /// Of any.
    Any,
}

impl Side {
    fn is(self, kind: Kind) -> bool {
        match self {
            Self::Only(only) => only == kind,
            Self::Any => true,
        }
    }
}

/// A cylinder that no other aircraft is to enter.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Name on every interface.
    pub name: String,
    /// Radius, metres.
    pub horizontal_m: f64,
    /// Half of its height, metres.
    pub vertical_m: f64,
    /// Modified tau up to which it counts as entered by aircraft that approach, seconds; 0: it does not.
    pub tau_s: f64,
    /// Between whom, in either order.
    pub between: [Side; 2],
}

impl Volume {
    /// Whether it is about such a pair.
    pub fn is_between(&self, a: Kind, b: Kind) -> bool {
        let [one, other] = self.between;
        (one.is(a) && other.is(b)) || (one.is(b) && other.is(a))
    }

    /// Whether the volume, made larger by a factor, is entered now: by where they are, or by modified tau.
    pub(super) fn is_entered(&self, now: &Relative, approach: &Approach, factor: f64) -> bool {
        let (horizontal_m, vertical_m) = (factor * self.horizontal_m, factor * self.vertical_m);
        let apart_in_height = now.vertical.is_some_and(|vertical| vertical.height_m.abs() > vertical_m);
        let is_near = now.position.norm() <= horizontal_m;
        !apart_in_height && (is_near || self.is_entered_by_tau(now, approach, horizontal_m, factor))
    }

    /// Modified tau, (R² - |p|²) / (p·v): time until the range would be R if it closed as it does now.
    fn is_entered_by_tau(&self, now: &Relative, approach: &Approach, horizontal_m: f64, factor: f64) -> bool {
        let closing = now.position.dot(&now.velocity);
        if self.tau_s <= 0.0 || closing >= 0.0 || approach.horizontal_m() > horizontal_m {
            return false;
        }
        let tau_s = (horizontal_m * horizontal_m - now.position.norm_squared()) / closing;
        (0.0..=factor * self.tau_s).contains(&tau_s)
    }
}

/// Volumes that others have defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Well clear in en-route airspace: NASA DAIDALUS configuration `DO_365B`.
    Do365Enroute,
    /// Well clear in terminal areas: the same, `Phase_II`.
    Do365Terminal,
    /// Well clear of aircraft without transponder: the same.
    Do365Noncooperative,
    /// Well clear of small drones: ASTM F3442. Its figures are known from reviews, not from the standard itself.
    F3442,
    /// Near mid-air collision: DAIDALUS.
    Nmac,
}

impl Preset {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Do365Enroute, Self::Do365Terminal, Self::Do365Noncooperative, Self::F3442, Self::Nmac];

    /// Name in the configuration, and of the volume where it has no other.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Do365Enroute => "do365-enroute",
            Self::Do365Terminal => "do365-terminal",
            Self::Do365Noncooperative => "do365-noncooperative",
            Self::F3442 => "f3442",
            Self::Nmac => "nmac",
        }
    }

    /// The volume, between any two aircraft.
    pub fn volume(self) -> Volume {
        let (horizontal_m, feet, tau_s) = match self {
            Self::Do365Enroute => (0.66 * MILE_M, 450.0, 35.0),
            Self::Do365Terminal => (1500.0 * FOOT_M, 450.0, 0.0),
            Self::Do365Noncooperative => (2200.0 * FOOT_M, 450.0, 0.0),
            Self::F3442 => (2000.0 * FOOT_M, 250.0, 0.0),
            Self::Nmac => (500.0 * FOOT_M, 100.0, 0.0),
        };
        let name = self.name().to_owned();
        Volume { name, horizontal_m, vertical_m: feet * FOOT_M, tau_s, between: [Side::Any; 2] }
    }
}
