use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::{PairLikelihood, TargetId, Tracklet};

use crate::operational::tests::two_drones::{START, TRACKS, place, reports, settings};
use crate::report::Report;
use crate::time::{SECOND, Time};
use crate::{Emission, Engine, Point};

#[test]
fn a_number_that_goes_to_another_drone_at_once_is_another_track() {
    // One radar track number for a drone up to 30 s, and from then on for another one 2 km further east.
    let mut engine = Engine::new(settings(true)).unwrap();
    let mut emissions = Vec::new();
    for (received, report) in reports(60) {
        emissions.extend(engine.advance(received));
        if let Report::Plot(mut plot) = report
            && plot.track.number == TRACKS[0]
        {
            plot.position.0.x +=
                if plot.time < Time::from_nanos((START + 30) * SECOND) { 0.0 } else { 2000.0 };
            engine.handle(Report::Plot(plot)).unwrap();
        }
    }
    emissions.extend(engine.finish());
    let off_m = |emission: &Emission, point: &Point, moved_m: f64| {
        let place = place(0, emission.time).0 + Vector3::new(moved_m, 0.0, 0.0);
        (point.position.0 - place).xy().norm()
    };
    let (mut first, mut second) = (BTreeSet::new(), BTreeSet::new());
    for (emission, point) in
        emissions.iter().flat_map(|emission| emission.points.iter().map(move |point| (emission, point)))
    {
        let [here, there] = [0.0, 2000.0].map(|moved_m| off_m(emission, point, moved_m) < 150.0);
        assert!(here || there, "{point:?}");
        if here { &mut first } else { &mut second }.insert(point.number);
    }
    assert_eq!((first.len(), second.len()), (1, 1));
    assert_ne!(first, second);
}

impl Tracklet {
    /// Sets the pair as if it had been compared with this target.
    pub(in crate::operational) fn set_pair(&mut self, target: TargetId, pair: PairLikelihood) {
        self.pairs.retain(|known| known.0 != target);
        self.pairs.push((target, pair));
        self.pairs.sort_by_key(|pair| pair.0);
    }
}
