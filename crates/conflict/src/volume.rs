//! Protected volumes around aircraft.

use super::encounter::{Relative, Vertical};
use super::interval::{CrossSection, Interval, interval_in_height, interval_over_ground};

/// A foot, metres.
const FOOT_M: f64 = 0.3048;
/// A nautical mile, metres.
const MILE_M: f64 = 1852.0;

/// Kind of an aircraft, as volumes distinguish it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TrafficKind {
    /// No person is on board.
    #[default]
    Drone,
    /// Persons are on board.
    Crewed,
}

/// Kinds of aircraft that a volume accepts for one of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AcceptedKinds {
    /// Only this kind.
    Only(TrafficKind),
    /// Any kind.
    Any,
}

impl AcceptedKinds {
    fn is(self, kind: TrafficKind) -> bool {
        match self {
            Self::Only(only) => only == kind,
            Self::Any => true,
        }
    }
}

/// A cylinder around an aircraft that no other aircraft should enter.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Name on every interface.
    pub name: String,
    /// Radius, metres.
    pub horizontal_m: f64,
    /// Half of its height, metres.
    pub vertical_m: f64,
    /// Modified tau up to which an approaching pair counts as inside the volume, seconds; 0: tau is not used.
    pub tau_s: f64,
    /// Kinds of both aircraft, in either order.
    pub between: [AcceptedKinds; 2],
}

impl Volume {
    /// Whether the volume applies to a pair of these kinds.
    pub fn is_between(&self, a: TrafficKind, b: TrafficKind) -> bool {
        let [one, other] = self.between;
        (one.is(a) && other.is(b)) || (one.is(b) && other.is(a))
    }

    /// Time within `horizon_s` seconds for which straight flight from `now` stays inside the volume; `None`: it does not
    /// enter it. A volume that is violated now has an entry of 0. A touch at one instant is no entry. If a height is not
    /// known, the heights count as equal.
    pub fn interval(&self, now: &Relative, horizon_s: f64) -> Option<Interval> {
        self.interval_of(now, horizon_s, 1.0)
    }

    /// [`Self::interval`] of the volume enlarged by a factor.
    pub(super) fn interval_of(&self, now: &Relative, horizon_s: f64, factor: f64) -> Option<Interval> {
        let (radius_m, tau_s) = (factor * self.horizontal_m, factor * self.tau_s);
        let ahead = Interval { entry_s: 0.0, exit_s: horizon_s };
        let ground = interval_over_ground(&now.position, &now.velocity, radius_m, tau_s)?.and(ahead)?;
        let Some(Vertical { height_m, climb, .. }) = now.vertical else { return Some(ground) };
        interval_in_height(height_m, climb, factor * self.vertical_m)?.and(ground)
    }

    /// Whether the volume, enlarged by a factor, is violated now.
    pub(super) fn is_entered(&self, now: &Relative, factor: f64) -> bool {
        self.interval_of(now, 1.0, factor).is_some_and(|inside| inside.entry_s <= 0.0)
    }

    /// Horizontal extent.
    pub(super) fn section(&self) -> CrossSection {
        CrossSection { radius_m: self.horizontal_m, tau_s: self.tau_s }
    }
}

/// Volumes of published standards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Well clear in en-route airspace: NASA DAIDALUS configuration `DO_365B`.
    Do365Enroute,
    /// Well clear in terminal areas: NASA DAIDALUS configuration `DO_365B`, `Phase_II`.
    Do365Terminal,
    /// Well clear of aircraft without transponder: NASA DAIDALUS configuration `DO_365B`.
    Do365Noncooperative,
    /// Well clear of small drones: ASTM F3442. The figures are from reviews, not from the standard itself.
    F3442,
    /// Near mid-air collision: NASA DAIDALUS.
    Nmac,
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 5] =
        [Self::Do365Enroute, Self::Do365Terminal, Self::Do365Noncooperative, Self::F3442, Self::Nmac];

    /// Name in the configuration, and default name of the volume.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Do365Enroute => "do365-enroute",
            Self::Do365Terminal => "do365-terminal",
            Self::Do365Noncooperative => "do365-noncooperative",
            Self::F3442 => "f3442",
            Self::Nmac => "nmac",
        }
    }

    /// The volume, for any two aircraft.
    pub fn volume(self) -> Volume {
        let (horizontal_m, feet, tau_s) = match self {
            Self::Do365Enroute => (0.66 * MILE_M, 450.0, 35.0),
            Self::Do365Terminal => (1500.0 * FOOT_M, 450.0, 0.0),
            Self::Do365Noncooperative => (2200.0 * FOOT_M, 450.0, 0.0),
            Self::F3442 => (2000.0 * FOOT_M, 250.0, 0.0),
            Self::Nmac => (500.0 * FOOT_M, 100.0, 0.0),
        };
        let name = self.name().to_owned();
        Volume { name, horizontal_m, vertical_m: feet * FOOT_M, tau_s, between: [AcceptedKinds::Any; 2] }
    }
}
