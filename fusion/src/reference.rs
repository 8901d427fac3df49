//! The rules of the `reference` profile: which points are published in a slot.

mod association;
mod radar;
mod transponder;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::frames::Enu;
use crate::numbering::{Numbered, Numbers};
use crate::point::{Association, AssociationEvidence, Point, RadarPart, Source, TransponderPart};
use crate::report::{self, Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, UasItems};
use crate::settings::{ReferenceRules, Sensor, Settings, Weights};
use crate::slots::{SlotGrid, SlotSet, Window};
use association::TrackAgreements;
use radar::{Detection, Detections};
use transponder::IdentityCurve;

/// The reports of the window, by aircraft and radar track.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Reference {
    setup: Setup,
    detections: Detections,
    aircraft: BTreeMap<Identity, ReferenceAircraft>,
}

/// The settings of these rules.
#[derive(Debug, Serialize, Deserialize)]
struct Setup {
    grid: SlotGrid,
    rules: ReferenceRules,
    /// Duration that one detection counts for, seconds, by sensor: the radar's period, at least a slot.
    detection_s: Vec<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
struct ReferenceAircraft {
    curve: IdentityCurve,
    pairs: TrackAgreements,
    items: UasItems,
    says: report::Aircraft,
    sensor: SensorIndex,
}

impl Reference {
    pub(super) fn new(settings: &Settings, rules: &ReferenceRules) -> Self {
        let grid = settings.grid;
        let detection_s = |sensor: &Sensor| match sensor {
            Sensor::Radar(radar) => radar.period_s.max(grid.slot_s()),
            Sensor::Receiver(_) | Sensor::Camera(_) => 0.0,
        };
        let setup = Setup {
            grid,
            rules: rules.clone(),
            detection_s: settings.sensors.iter().map(detection_s).collect(),
        };
        let detections = Detections::new(grid, rules.threshold.clone());
        Self { setup, detections, aircraft: BTreeMap::new() }
    }

    /// Accepts a report.
    pub(super) fn handle(&mut self, report: Report) {
        match report {
            Report::Plot(plot) => self.detections.insert(plot),
            Report::Fix(fix) => {
                self.aircraft
                    .entry(fix.identity)
                    .or_insert_with(|| ReferenceAircraft::new(&fix))
                    .handle(&fix);
            }
            // The paper has no cameras.
            Report::Bearing(_) => {}
        }
    }

    /// The points of the emitted slot, in order.
    pub(super) fn emit(&mut self, window: &Window, numbers: &mut Numbers) -> Vec<Point> {
        let stale = self.detections.sort_evaluated(window);
        self.detections.remove(window.first.plus(-1));
        let Self { setup, aircraft, detections } = self;
        aircraft.retain(|_, aircraft| {
            aircraft.update(window, stale, detections, setup);
            !aircraft.curve.is_empty()
        });
        let points = self.points(window, numbers);
        self.detections.mark_seen(window.emitted);
        points
    }

    fn points(&mut self, window: &Window, numbers: &mut Numbers) -> Vec<Point> {
        let Self { setup, detections, aircraft } = self;
        let mut points = Vec::new();
        for (&identity, aircraft) in aircraft {
            if !aircraft.curve.present().contains(window.emitted) {
                continue;
            }
            match numbers.of(identity, window.emitted) {
                Some(numbered) => {
                    aircraft.publish(identity, numbered, window, detections, setup, &mut points);
                }
                None => numbers.note_unnumbered(),
            }
        }
        let mut explained: Vec<RadarTrackKey> =
            points.iter().filter_map(|point| point.source.radar()).map(|radar| radar.track).collect();
        explained.sort_unstable();
        let unexplained = |detection: &&Detection| explained.binary_search(&detection.plot.track).is_err();
        points.extend(
            detections
                .of_slot(window.emitted)
                .iter()
                .filter(unexplained)
                .filter_map(|detection| radar_only(detection, window, detections, setup)),
        );
        // The sort is stable: points of two radars with one number are already ordered by sensor.
        points.sort_by_key(|point| (point.source.rank(), point.number));
        points
    }
}

impl ReferenceAircraft {
    fn new(fix: &Fix) -> Self {
        Self {
            curve: IdentityCurve::new(),
            pairs: TrackAgreements::default(),
            items: fix.items,
            says: fix.aircraft,
            sensor: fix.sensor,
        }
    }

    fn handle(&mut self, fix: &Fix) {
        self.items = fix.items;
        self.says = fix.aircraft.or(self.says);
        self.sensor = fix.sensor;
        self.curve.insert(fix);
    }

    /// Publishes the points of the emitted slot, in which the curve has a point: one for each associated pair, or the
    /// transponder alone if no pair was associated nearby.
    fn publish(
        &self,
        identity: Identity,
        Numbered { number, since }: Numbered,
        window: &Window,
        detections: &Detections,
        setup: &Setup,
        points: &mut Vec<Point>,
    ) {
        let Self { curve, pairs, items, says, sensor } = self;
        let slot = window.emitted;
        let position = curve.point(slot);
        let first_seen = setup.grid.centre(since);
        let transponder = TransponderPart {
            number,
            identity,
            sensor: *sensor,
            time: None,
            items: *items,
            aircraft: *says,
            height_measured: true,
        };
        let before = points.len();
        for pair in pairs.iter() {
            let both = curve.present().and(detections.track(pair.track).present);
            if let Some(ratio) = pair.associated(slot, window, both, &setup.rules)
                && let Some(detection) = detections.detection(pair.track, slot)
            {
                let distance_m = detection.distance_m(position);
                let association = Association {
                    distance_m,
                    because: AssociationEvidence::Ratio { threshold_m: detection.threshold_m, ratio },
                };
                points.push(Point::new(
                    number * 10_000 + u32::from(pair.track.number),
                    fuse(detection, position, setup.rules.weights),
                    first_seen,
                    Source::Fused(RadarPart::of(detection), transponder, association),
                ));
            }
        }
        let nearby = (slot.plus(-setup.rules.suppress_slots).max(window.first), window.horizon);
        if points.len() == before && !pairs.any_associated(nearby, window, curve, detections, &setup.rules) {
            points.push(Point::new(number, position, first_seen, Source::Transponder(transponder)));
        }
    }

    fn update(&mut self, window: &Window, stale: SlotSet, detections: &Detections, setup: &Setup) {
        let changed = self.curve.update(window, setup.grid, setup.rules.max_gap);
        self.pairs.update(window, changed.or(stale), &self.curve, detections);
    }
}

/// The point of a detection without a transponder, if its track was a UAV for long enough.
fn radar_only(
    detection: &Detection,
    window: &Window,
    detections: &Detections,
    setup: &Setup,
) -> Option<Point> {
    let Plot { track: key, position, .. } = detection.plot;
    let track = detections.track(key);
    let so_far = SlotSet::span(window.first, window.emitted);
    let uav_s =
        f64::from(track.uav.and(so_far).count()) * setup.detection_s.get(usize::from(key.sensor.0))?;
    (uav_s > setup.rules.radar_only_min_s).then(|| {
        Point::new(
            key.number.into(),
            position,
            setup.grid.centre(track.first_seen.unwrap_or(window.emitted)),
            Source::Radar(RadarPart::of(detection)),
        )
    })
}

/// The weighted mean; the height is the transponder's if the radar measured none.
fn fuse(detection: &Detection, transponder: Enu, Weights { radar, transponder: by }: Weights) -> Enu {
    let mut fused = (detection.plot.position.0 * radar + transponder.0 * by) / (radar + by);
    if !detection.plot.height_measured {
        fused.z = transponder.0.z;
    }
    fused.into()
}

impl RadarPart {
    fn of(detection: &Detection) -> Self {
        let plot = &detection.plot;
        Self {
            track: plot.track,
            time: plot.time,
            height_measured: plot.height_measured,
            uav_probability: plot.uav_probability,
        }
    }
}
