//! Radars that operators moved to where their tracks show them.

use std::collections::BTreeMap;

use nalgebra::{Rotation3, Vector3};
use serde::{Deserialize, Serialize};

use super::settings::{OperationalSettings, RadarSettings};
use crate::registration::Displacement;
use crate::report::{Plot, SensorIndex};
use crate::slots::Slot;

/// Correction of a radar's configured position and bearing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Relocation {
    /// Metres that the radar stands east of its configured position, in its own axes.
    pub east_m: f64,
    /// Metres that it stands north of it.
    pub north_m: f64,
    /// Angle taken off its azimuths, radians clockwise.
    pub bearing: f64,
}

/// An operator's decision on a radar's position; `None`: the configured one holds again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RadarRelocation {
    /// The radar.
    pub radar: SensorIndex,
    /// The correction of what is configured.
    pub to: Option<Relocation>,
}

/// A relocation in force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActiveRelocation {
    /// The radar.
    pub radar: SensorIndex,
    /// The correction of what is configured.
    pub to: Relocation,
    /// First slot with it.
    pub since: Slot,
}

impl Relocation {
    /// This correction and what the tracks show beyond it.
    pub fn beyond(self, found: &Displacement) -> Self {
        Self {
            east_m: self.east_m + found.east_m,
            north_m: self.north_m + found.north_m,
            bearing: self.bearing + found.bearing.value,
        }
    }

    /// Whether all values are numbers, and no distance exceeds the range in which plots can be associated.
    pub fn is_plausible(&self) -> bool {
        const FARTHEST_M: f64 = 10_000.0;
        self.east_m.abs() <= FARTHEST_M
            && self.north_m.abs() <= FARTHEST_M
            && self.bearing.abs() <= std::f64::consts::PI
    }

    /// The plot with the radar at its corrected position; `radar` has that already.
    fn apply(&self, mut plot: Plot, radar: &RadarSettings) -> Plot {
        let moved = Vector3::new(self.east_m, self.north_m, 0.0);
        let seen = radar.frame.from_site(plot.position).0 + moved;
        // Azimuths are clockwise: a positive angle taken off turns the plot counterclockwise.
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), self.bearing) * seen;
        plot.position = radar.frame.to_site(turned.into());
        plot
    }
}

/// The relocations in force.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Relocations(BTreeMap<SensorIndex, ActiveRelocation>);

impl Relocations {
    /// Moves a radar, or puts it back.
    pub(crate) fn set(&mut self, decided: RadarRelocation, since: Slot) {
        let RadarRelocation { radar, to } = decided;
        match to {
            Some(to) => self.0.insert(radar, ActiveRelocation { radar, to, since }),
            None => self.0.remove(&radar),
        };
    }

    /// By radar.
    pub(crate) fn all(&self) -> impl Iterator<Item = ActiveRelocation> {
        self.0.values().copied()
    }

    /// Moves the radars in the settings.
    pub(crate) fn apply(&self, settings: &mut OperationalSettings) {
        for ActiveRelocation { radar, to, .. } in self.0.values() {
            if let Some(Some(radar)) = settings.radars.get_mut(usize::from(radar.0)) {
                radar.frame = radar.frame.moved(Vector3::new(to.east_m, to.north_m, 0.0));
                radar.position = radar.frame.origin();
            }
        }
    }

    /// The plot with its radar at the corrected position.
    pub(crate) fn place(&self, plot: Plot, radar: &RadarSettings) -> Plot {
        match self.0.get(&plot.track.sensor) {
            Some(active) => active.to.apply(plot, radar),
            None => plot,
        }
    }
}
