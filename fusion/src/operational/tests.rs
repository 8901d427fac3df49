//! Small hand-built cases of the passes, and two drones whose flight other tests use.

mod ahead;
mod associating;
mod barometric;
mod comparing;
mod handover;
mod hypotheses;
mod initiating;
mod now;
mod publishing;
mod registering;
mod relocating;
mod same_aircraft;
mod several_radars;
pub(super) mod two_drones;
mod unexplained;

use super::cycle::EARLIEST;
use super::ids::{TargetId, TrackletId};
use super::likelihood::PairLikelihood;
use super::reacquisition::MeasuredPositions;
use super::*;
use crate::frames::Enu;
use crate::numbering::Keeping;
use crate::point::Rival;
use crate::report::RadarTrackKey;
use crate::settings::OperationalRules;

const GRID: SlotGrid = SlotGrid::new(jiff::SignedDuration::from_millis(250));
const LATENCY: jiff::SignedDuration = jiff::SignedDuration::from_millis(6250);
/// Centre of the slot of most cases, seconds.
const NOW_S: f64 = 100.125;

/// Radars 0 and 2 at one position, and receiver 1; radar tracks and transponders 1500 m north of the radars, 100 m up.
struct Case {
    air: Operational,
    settings: OperationalSettings,
    numbers: Numbers,
    /// Number of slots in which a track or transponder began.
    begun: i64,
}

fn at(second: f64) -> Time {
    Time::from_nanos((second * SECOND as f64) as i64)
}

/// Times every half second between two limits.
fn halves(from_s: f64, to_s: f64) -> Vec<f64> {
    (0..).map(|half| from_s + 0.5 * f64::from(half)).take_while(|&second| second <= to_s).collect()
}

fn identity(which: usize) -> Identity {
    let mut serial = [b' '; 12];
    serial[0] = b'A' + which as u8;
    Identity::new(&serial, None).unwrap()
}

impl Case {
    fn new() -> Self {
        let mut sensors = two_drones::settings(true).sensors;
        sensors.push(sensors[0].clone());
        let settings = OperationalSettings::new(&sensors, LATENCY, &OperationalRules::default());
        let numbers = Numbers::new(GRID, Keeping::ADay, BTreeMap::new());
        Self { air: Operational::default(), settings, numbers, begun: 0 }
    }

    /// A plot of a radar's track at this distance east, with this probability of a drone.
    fn plot(&mut self, (radar, number): (u16, u16), second: f64, east_m: f64, uav_probability: f64) {
        self.air.handle(Report::Plot(Plot {
            track: RadarTrackKey { sensor: SensorIndex(radar), number },
            time: at(second),
            position: Enu::new(east_m, 1500.0, 100.0),
            height_measured: true,
            slant_range_m: 1500.0,
            uav_probability: Some(uav_probability),
            velocity: None,
        }));
    }

    /// A radar track with plots at these seconds.
    fn track(&mut self, key: (u16, u16), seconds: &[f64], east_m: f64, uav_probability: f64) -> TrackletId {
        seconds.iter().for_each(|&second| self.plot(key, second, east_m, uav_probability));
        self.begun += 1;
        self.air.sort_plots(Slot(self.begun), &self.settings);
        let track = RadarTrackKey { sensor: SensorIndex(key.0), number: key.1 };
        self.air.tracklets.iter().filter(|tracklet| tracklet.key == track).last().unwrap().id
    }

    fn fix(&mut self, which: usize, second: f64, east_m: f64) {
        let place = Enu::new(east_m, 1500.0, 100.0);
        self.air.handle(Report::Fix(Fix::new(SensorIndex(1), identity(which), at(second), place)));
    }

    /// A transponder with reports at these seconds, at least two.
    fn transponder(&mut self, which: usize, seconds: &[f64], east_m: f64) -> TargetId {
        seconds.iter().for_each(|&second| self.fix(which, second, east_m));
        self.air.pass(at(seconds[0]), &self.settings);
        self.begun += 1;
        self.air.sort_fixes(Slot(self.begun), &self.settings);
        self.air.targets.of_identity(identity(which)).unwrap()
    }

    /// Sets the likelihood of a pair.
    fn pair(&mut self, tracklet: TrackletId, target: TargetId, llr: f64) {
        let pair = PairLikelihood::with_llr(llr, None);
        self.air.tracklets.get_mut(tracklet).unwrap().set_pair(target, pair);
    }

    /// Runs these passes.
    fn run(&mut self, passes: impl FnOnce(&mut Operational, &mut Numbers, &Cycle)) {
        let slot = GRID.of(at(NOW_S));
        let deadline = GRID.open(slot) + self.settings.latency;
        passes(&mut self.air, &mut self.numbers, &Cycle::new(slot, deadline, GRID, None, &self.settings));
    }

    fn decide(&mut self, tracklet: TrackletId, which: usize, verdict: Verdict) {
        let radar = self.air.tracklets.get(tracklet).unwrap().key;
        let correlation = ManualAssociation { radar, transponder: identity(which), verdict };
        self.air.correlations.apply(tracklet, correlation, Slot(0), &self.air.tracklets);
    }

    fn associate(&mut self) {
        self.run(|air, _, cycle| {
            let decided = air.correlations.decided(&air.tracklets, &air.targets);
            let measured = MeasuredPositions::of(&air.targets);
            association::associate(&mut air.tracklets, &mut air.targets, &measured, &decided, cycle);
        });
    }

    /// Publishes the slots between two times by all passes, with the reports of the six seconds after each.
    fn publish(
        &mut self,
        from_s: f64,
        to_s: f64,
        mut heard: impl FnMut(&mut Self, f64),
    ) -> Vec<(f64, Vec<Point>)> {
        let slots = GRID.of(at(from_s)).0..GRID.of(at(to_s)).0;
        let publish = |slot| {
            heard(self, slot as f64 / 4.0);
            self.numbers.begin_slot(Slot(slot));
            let points = self.air.emit(Slot(slot), GRID, &self.settings, &mut self.numbers).points;
            self.numbers.take_changes();
            (GRID.centre(Slot(slot)).seconds_since(at(0.0)), points)
        };
        slots.map(publish).collect()
    }

    fn target(&self, tracklet: TrackletId) -> Option<TargetId> {
        self.air.tracklets.get(tracklet).unwrap().target()
    }
}
