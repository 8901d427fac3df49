//! What an engine is not given while its machine cannot keep up. Sans-IO.
//!
//! Reports of transponders are never left out, nor the first plots of a radar track.

use std::collections::BTreeMap;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::Pipeline;
use fusion::time::Time;
use fusion::{Plot, RadarTrackKey};

/// UAV probability below which a radar track is unlikely to be a drone.
const UNLIKELY: f64 = 0.01;
/// A radar track is certainly no drone once it has been unlikely for this duration.
const CERTAIN: SignedDuration = SignedDuration::from_secs(10);
/// A radar track without a plot for this duration is forgotten.
const FORGOTTEN: SignedDuration = SignedDuration::from_secs(60);

/// Which plots are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Shed {
    /// None.
    #[default]
    Nothing,
    /// Those of tracks that are certainly no drones.
    Unlikely,
    /// These, and every second one of aircraft whose transponder speaks.
    Halved,
}

/// Who is left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shedding {
    shed: Shed,
    /// Since when a radar takes its track for no drone, and the latest plot of it.
    unlikely: BTreeMap<RadarTrackKey, (Time, Time)>,
    /// Tracks of aircraft whose transponder speaks, and whether their last plot was left out.
    joined: BTreeMap<RadarTrackKey, bool>,
}

impl Shedding {
    /// Leaves that out from now on.
    pub fn set(&mut self, shed: Shed) {
        self.shed = shed;
        if shed < Shed::Halved {
            self.joined.clear();
        }
    }

    /// Which radar tracks are of aircraft whose transponder speaks, as of the slot that was made last.
    pub fn join(&mut self, tracks: impl Iterator<Item = RadarTrackKey>) {
        if self.shed == Shed::Halved {
            self.joined =
                tracks.map(|track| (track, self.joined.get(&track).copied().unwrap_or(false))).collect();
        }
    }

    /// Whether the engine is given a plot.
    pub(super) fn takes(&mut self, plot: &Plot) -> bool {
        let is_unlikely = plot.uav_probability.is_some_and(|probability| probability < UNLIKELY);
        if !is_unlikely {
            self.unlikely.remove(&plot.track);
        } else {
            let (since, latest) = self.unlikely.entry(plot.track).or_insert((plot.time, plot.time));
            // Another track has the number since.
            if plot.time - *latest > FORGOTTEN {
                *since = plot.time;
            }
            *latest = plot.time;
            if self.shed >= Shed::Unlikely && plot.time - *since > CERTAIN {
                return false;
            }
        }
        match self.joined.get_mut(&plot.track) {
            Some(is_left_out) => {
                *is_left_out = !*is_left_out;
                !*is_left_out
            }
            None => true,
        }
    }

    /// Forgets who was not heard for a minute.
    pub fn forget(&mut self, now: Time) {
        self.unlikely.retain(|_, (_, latest)| now - *latest <= FORGOTTEN);
    }
}

impl Pipeline {
    /// What is left out from now on, for a machine that cannot keep up.
    pub fn shed(&mut self, shed: Shed) {
        match (&mut self.shedding, shed) {
            (shedding, Shed::Nothing) => *shedding = None,
            (Some(shedding), shed) => shedding.set(shed),
            (shedding, shed) => shedding.insert(Shedding::default()).set(shed),
        }
    }

    /// Who is left out, where somebody is.
    pub const fn shedding_mut(&mut self) -> Option<&mut Shedding> {
        self.shedding.as_mut()
    }
}

#[cfg(test)]
mod tests {
    use fusion::{Enu, SensorIndex};

    use super::*;

    fn plot(number: u16, second: i64, probability: f64) -> Plot {
        let track = RadarTrackKey { sensor: SensorIndex(0), number };
        let time = Time::from_nanos((1_800_000_000 + second) * 1_000_000_000);
        let plot = Plot::new(track, time, Enu::new(0.0, 1000.0, 100.0), 1000.0);
        Plot { uav_probability: Some(probability), ..plot }
    }

    #[test]
    fn what_is_certainly_no_drone_is_left_out_after_its_first_plots() {
        let mut shedding = Shedding::default();
        shedding.set(Shed::Unlikely);
        let taken = |shedding: &mut Shedding, from: i64| {
            (from..from + 20).filter(|second| shedding.takes(&plot(7, *second, 0.001))).count()
        };
        assert_eq!(taken(&mut shedding, 0), 11);
        // It looks like a drone for once: it has to be certain anew.
        assert!(shedding.takes(&plot(7, 20, 0.5)));
        assert_eq!(taken(&mut shedding, 21), 11);
        // Minutes later the number is another bird's.
        assert_eq!(taken(&mut shedding, 200), 11);
        shedding.set(Shed::Nothing);
        assert!(shedding.takes(&plot(7, 220, 0.001)));
    }

    #[test]
    fn every_second_plot_is_enough_where_a_transponder_speaks() {
        let mut shedding = Shedding::default();
        shedding.set(Shed::Halved);
        let track = plot(7, 0, 0.9).track;
        let taken = |shedding: &mut Shedding, number| {
            (0..20).filter(|second| shedding.takes(&plot(number, *second, 0.9))).count()
        };
        assert_eq!(taken(&mut shedding, 7), 20, "nobody knows yet that it has one");
        shedding.join([track].into_iter());
        assert_eq!((taken(&mut shedding, 7), taken(&mut shedding, 8)), (10, 20));
        shedding.set(Shed::Unlikely);
        assert_eq!(taken(&mut shedding, 7), 20);
    }
}
