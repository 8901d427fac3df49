//! The rules of the `reference` profile: who is put out in a slot, and where.

mod association;
mod radar;
mod transponder;

use std::collections::BTreeMap;

use crate::frames::Enu;
use crate::numbering::{Numbered, Numbers};
use crate::point::{Association, Because, Point, RadarPart, Source, TransponderPart};
use crate::report::{Fix, Identity, Plot, RadarTrackKey, Report, SensorIndex, UasItems};
use crate::settings::Settings;
use crate::slots::{SlotSet, Window};
use association::Pairs;
use radar::{Detection, Detections};
use transponder::Curve;

pub use association::Evidence;

/// The window of reports.
#[derive(Debug)]
pub(super) struct Reference {
    detections: Detections,
    aircraft: BTreeMap<Identity, Aircraft>,
}

#[derive(Debug)]
struct Aircraft {
    curve: Curve,
    pairs: Pairs,
    items: UasItems,
    sensor: SensorIndex,
}

impl Reference {
    pub(super) fn new(settings: &Settings) -> Self {
        Self { detections: Detections::new(settings.grid, settings.gate.clone()), aircraft: BTreeMap::new() }
    }

    /// Takes a report in.
    pub(super) fn handle(&mut self, report: Report) {
        match report {
            Report::Plot(plot) => self.detections.insert(plot),
            Report::Fix(fix) => {
                self.aircraft.entry(fix.identity).or_insert_with(|| Aircraft::new(&fix)).handle(&fix);
            }
        }
    }

    /// The points of the slot that is emitted, in order.
    pub(super) fn emit(&mut self, window: &Window, settings: &Settings, numbers: &mut Numbers) -> Vec<Point> {
        let stale = self.detections.settle(window);
        self.detections.remove(window.first.plus(-1));
        let Self { aircraft, detections } = self;
        aircraft.retain(|_, aircraft| {
            aircraft.update(window, stale, detections, settings);
            !aircraft.curve.is_empty()
        });
        let points = self.points(window, settings, numbers);
        self.detections.mark_seen(window.emitted);
        points
    }

    fn points(&mut self, window: &Window, settings: &Settings, numbers: &mut Numbers) -> Vec<Point> {
        let Self { detections, aircraft } = self;
        let mut points = Vec::new();
        for (&identity, aircraft) in aircraft {
            if !aircraft.curve.present().contains(window.emitted) {
                continue;
            }
            match numbers.of(identity, window.emitted) {
                Some(numbered) => {
                    aircraft.put_out(identity, numbered, window, detections, settings, &mut points);
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
                .filter_map(|detection| radar_only(detection, window, detections, settings)),
        );
        // Stable: points with one number, of two radars, stand by sensor already.
        points.sort_by_key(|point| (point.source.rank(), point.number));
        points
    }
}

impl Aircraft {
    fn new(fix: &Fix) -> Self {
        Self { curve: Curve::new(), pairs: Pairs::default(), items: fix.items, sensor: fix.sensor }
    }

    fn handle(&mut self, fix: &Fix) {
        self.items = fix.items;
        self.sensor = fix.sensor;
        self.curve.insert(fix);
    }

    /// The points of the emitted slot, in which the curve has one: of every associated pair, or of the transponder alone
    /// where none was associated nearby.
    fn put_out(
        &self,
        identity: Identity,
        Numbered { number, since }: Numbered,
        window: &Window,
        detections: &Detections,
        settings: &Settings,
        points: &mut Vec<Point>,
    ) {
        let Self { curve, pairs, items, sensor, .. } = self;
        let slot = window.emitted;
        let position = curve.point(slot);
        let first_seen = settings.grid.centre(since);
        let transponder = TransponderPart { number, identity, sensor: *sensor, time: None, items: *items };
        let before = points.len();
        for pair in pairs.iter() {
            let both = curve.present().and(detections.track(pair.track).present);
            if let Some(evidence) = pair.associated(slot, window, both, settings)
                && let Some(detection) = detections.detection(pair.track, slot)
            {
                let distance_m = detection.distance_m(position);
                let association = Association {
                    distance_m,
                    because: Because::Ratio { gate_m: detection.gate_m, evidence },
                };
                points.push(Point {
                    number: number * 10_000 + u32::from(pair.track.number),
                    position: fuse(detection, position, settings),
                    first_seen,
                    source: Source::Fused(RadarPart::of(detection), transponder, association),
                    estimate: None,
                    competitors: Vec::new(),
                });
            }
        }
        let nearby = (slot.plus(-settings.suppress_slots).max(window.first), window.horizon);
        if points.len() == before && !pairs.any_associated(nearby, window, curve, detections, settings) {
            points.push(Point {
                number,
                position,
                first_seen,
                source: Source::Transponder(transponder),
                estimate: None,
                competitors: Vec::new(),
            });
        }
    }

    fn update(&mut self, window: &Window, stale: SlotSet, detections: &Detections, settings: &Settings) {
        let changed = self.curve.update(window, settings.grid, settings.max_gap_ns);
        self.pairs.update(window, changed.or(stale), &self.curve, detections);
    }
}

/// The point of a detection that no transponder explains, when its track was a UAV for long enough.
fn radar_only(
    detection: &Detection,
    window: &Window,
    detections: &Detections,
    settings: &Settings,
) -> Option<Point> {
    let Plot { track: key, position, .. } = detection.plot;
    let track = detections.track(key);
    let so_far = SlotSet::span(window.first, window.emitted);
    let uav_s = f64::from(track.uav.and(so_far).count()) * settings.period_s[usize::from(key.sensor.0)];
    (uav_s > settings.radar_only_min_s).then(|| Point {
        number: key.number.into(),
        position,
        first_seen: settings.grid.centre(track.first_seen.unwrap_or(window.emitted)),
        source: Source::Radar(RadarPart::of(detection)),
        estimate: None,
        competitors: Vec::new(),
    })
}

/// The weighted mean; the height is the transponder's alone where the radar measured none.
fn fuse(detection: &Detection, transponder: Enu, settings: &Settings) -> Enu {
    let (radar, by) = (settings.weight_radar, settings.weight_transponder);
    let mut fused = (detection.plot.position.0 * radar + transponder.0 * by) / (radar + by);
    if !detection.plot.height_measured {
        fused.z = transponder.0.z;
    }
    Enu(fused)
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
