//! Plots that are not passed to the engine of an overloaded node. Sans-IO.
//!
//! Transponder reports and the first plots of a radar track are always passed on.

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

/// Plots to leave out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Shed {
    /// None.
    #[default]
    Nothing,
    /// Plots of radar tracks that are certainly no drones.
    Unlikely,
    /// Plots of radar tracks that are certainly no drones, and every second plot of aircraft with an active transponder.
    Halved,
}

/// State of the radar tracks whose plots may be left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shedding {
    shed: Shed,
    /// Time since which a radar track is unlikely to be a drone, and time of its latest plot.
    unlikely: BTreeMap<RadarTrackKey, (Time, Time)>,
    /// Radar tracks of aircraft with an active transponder, and whether their last plot was left out.
    joined: BTreeMap<RadarTrackKey, bool>,
}

impl Shedding {
    /// Sets which plots are left out.
    pub fn set(&mut self, shed: Shed) {
        self.shed = shed;
        if shed < Shed::Halved {
            self.joined.clear();
        }
    }

    /// Sets the radar tracks of aircraft with an active transponder, as of the latest slot.
    pub fn join(&mut self, tracks: impl Iterator<Item = RadarTrackKey>) {
        if self.shed == Shed::Halved {
            self.joined =
                tracks.map(|track| (track, self.joined.get(&track).copied().unwrap_or(false))).collect();
        }
    }

    /// Whether a plot is passed to the engine.
    pub(super) fn takes(&mut self, plot: &Plot) -> bool {
        let is_unlikely = plot.uav_probability.is_some_and(|probability| probability < UNLIKELY);
        if !is_unlikely {
            self.unlikely.remove(&plot.track);
        } else {
            let (since, latest) = self.unlikely.entry(plot.track).or_insert((plot.time, plot.time));
            // The track number has been reused for another track.
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

    /// Removes radar tracks without a plot for a minute.
    pub fn forget(&mut self, now: Time) {
        self.unlikely.retain(|_, (_, latest)| now - *latest <= FORGOTTEN);
    }
}

impl Pipeline {
    /// Sets which plots are left out during overload.
    pub fn shed(&mut self, shed: Shed) {
        match (&mut self.shedding, shed) {
            (shedding, Shed::Nothing) => *shedding = None,
            (Some(shedding), shed) => shedding.set(shed),
            (shedding, shed) => shedding.insert(Shedding::default()).set(shed),
        }
    }

    /// The state of shedding, while there is an overload.
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
    fn plots_of_certain_non_drones_are_shed_after_the_first() {
        let mut shedding = Shedding::default();
        shedding.set(Shed::Unlikely);
        let taken = |shedding: &mut Shedding, from: i64| {
            (from..from + 20).filter(|second| shedding.takes(&plot(7, *second, 0.001))).count()
        };
        assert_eq!(taken(&mut shedding, 0), 11);
        // The track resembles a drone once: it has to be unlikely for 10 s again.
        assert!(shedding.takes(&plot(7, 20, 0.5)));
        assert_eq!(taken(&mut shedding, 21), 11);
        // Minutes later the number belongs to another bird.
        assert_eq!(taken(&mut shedding, 200), 11);
        shedding.set(Shed::Nothing);
        assert!(shedding.takes(&plot(7, 220, 0.001)));
    }

    #[test]
    fn every_second_plot_is_shed_with_an_active_transponder() {
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
