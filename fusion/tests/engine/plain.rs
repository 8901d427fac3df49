//! The reference profile as specified, recomputed from all reports at every slot; deliberately slow and plain. Only the
//! interpolation and the numbers are the engine's own: they are tested against SciPy and by unit tests.

use std::collections::{BTreeMap, BTreeSet};

use utm_fusion_engine::interpolation::{Knot, evaluate};
use utm_fusion_engine::numbering::{Keeping, Numbered, Numbers};
use utm_fusion_engine::point::{Association, AssociationEvidence, RadarPart, SlotRatio, TransponderPart};
use utm_fusion_engine::slots::Slot;
use utm_fusion_engine::time::Time;
use utm_fusion_engine::{
    Emission, Enu, Fix, Identity, Plot, Point, Profile, RadarTrackKey, Report, Settings, Source,
};

use crate::scenario::{Arrival, PERIODS_S, SLOT_NS};

struct Plain<'a> {
    settings: &'a Settings,
    reports: Vec<Report>,
    numbers: Numbers,
    /// First slots of radar tracks.
    first_seen: BTreeMap<RadarTrackKey, Slot>,
    next: i64,
    emissions: Vec<Emission>,
}

pub fn run(settings: &Settings, arrivals: &[Arrival]) -> Vec<Emission> {
    let mut plain = Plain {
        settings,
        reports: Vec::new(),
        numbers: Numbers::new(settings.grid, Keeping::ForGood, settings.transponder_numbers.clone()),
        first_seen: BTreeMap::new(),
        next: i64::MIN,
        emissions: Vec::new(),
    };
    let mut now: Option<i64> = None;
    for arrival in arrivals {
        let received = arrival.received.nanos();
        match now {
            Some(before) if received - before > 100 * SLOT_NS => {
                plain.flush();
                plain.reports.clear();
                plain.first_seen.clear();
                plain.next = i64::MIN;
            }
            _ => {}
        }
        if plain.next == i64::MIN {
            plain.next =
                (0..).map(|k| received / SLOT_NS - 200 + k).find(|k| SLOT_NS * (k + 25) > received).unwrap();
        }
        now = now.max(Some(received));
        while SLOT_NS * (plain.next + 25) <= now.unwrap() {
            plain.emit();
        }
        if slot(arrival.report.time()) >= plain.next - 75 {
            plain.reports.push(arrival.report);
        }
    }
    plain.flush();
    plain.emissions
}

fn slot(time: Time) -> i64 {
    time.nanos().div_euclid(SLOT_NS)
}

fn centre(slot: i64) -> Time {
    Time::from_nanos(slot * SLOT_NS + SLOT_NS / 2)
}

impl Plain<'_> {
    fn flush(&mut self) {
        while self.reports.iter().any(|report| slot(report.time()) >= self.next) {
            self.emit();
        }
    }

    fn emit(&mut self) {
        let k = self.next;
        self.next += 1;
        let Profile::Reference(rules) = &self.settings.profile else {
            panic!("a plain engine of the other profile")
        };
        let window = k - 75..=k + 24;
        let known: Vec<&Report> = self.reports.iter().filter(|r| window.contains(&slot(r.time()))).collect();

        let mut detections: BTreeMap<(RadarTrackKey, i64), Plot> = BTreeMap::new();
        let mut knots: BTreeMap<Identity, BTreeMap<Time, Fix>> = BTreeMap::new();
        for report in known {
            match *report {
                Report::Plot(plot) => {
                    let place = detections.entry((plot.track, slot(plot.time))).or_insert(plot);
                    if plot.time >= place.time {
                        *place = plot;
                    }
                }
                Report::Fix(fix) => {
                    knots.entry(fix.identity).or_default().insert(fix.time, fix);
                }
                // The paper has no cameras.
                Report::Bearing(_) => {}
            }
        }
        let mut curves: BTreeMap<Identity, BTreeMap<i64, Enu>> = BTreeMap::new();
        for (&identity, fixes) in &knots {
            let knots: Vec<Knot> =
                fixes.values().map(|fix| Knot { time: fix.time, position: fix.position.0 }).collect();
            let in_long_gap = |time: Time| {
                knots.windows(2).any(|pair| {
                    pair[0].time < time && time < pair[1].time && pair[1].time - pair[0].time > rules.max_gap
                })
            };
            let curve = window
                .clone()
                .filter(|&s| !in_long_gap(centre(s)))
                .filter_map(|s| evaluate(&knots, centre(s)).map(|point| (s, Enu::from(point))));
            curves.insert(identity, curve.collect());
        }
        let distance = |plot: &Plot, point: &Enu| {
            let offset = plot.position.0 - point.0;
            if plot.height_measured { offset.norm() } else { offset.xy().norm() }
        };
        let associated = |identity: Identity, track: RadarTrackKey, at: i64| -> Option<SlotRatio> {
            let mut ratio = SlotRatio { co_present: 0, within: 0 };
            let mut within_now = false;
            for s in *window.start()..=at {
                within_now = false;
                if let (Some(plot), Some(point)) = (detections.get(&(track, s)), curves[&identity].get(&s)) {
                    ratio.co_present += 1;
                    within_now = distance(plot, point) <= rules.threshold.at(plot.slant_range_m);
                    ratio.within += u32::from(within_now);
                }
            }
            let enough = ratio.co_present >= rules.min_samples && 10 * ratio.within >= 9 * ratio.co_present;
            (within_now && enough).then_some(ratio)
        };
        let tracks: BTreeSet<RadarTrackKey> = detections.keys().map(|key| key.0).collect();

        let mut points = Vec::new();
        let mut explained = BTreeSet::new();
        for (&identity, curve) in &curves {
            let Some(point) = curve.get(&k) else { continue };
            let Numbered { number, since } = self.numbers.of(identity, Slot(k)).unwrap();
            let last_received = self.reports.iter().rev().find_map(|report| match report {
                Report::Fix(fix) if fix.identity == identity => Some((fix.sensor, fix.items)),
                _ => None,
            });
            let (sensor, items) = last_received.unwrap();
            let transponder = TransponderPart {
                number,
                identity,
                sensor,
                time: None,
                items,
                aircraft: Default::default(),
                height_measured: true,
            };
            for &track in &tracks {
                let Some(ratio) = associated(identity, track, k) else { continue };
                let plot = &detections[&(track, k)];
                explained.insert(track);
                let mut position = (plot.position.0 * rules.weights.radar
                    + point.0 * rules.weights.transponder)
                    / (rules.weights.radar + rules.weights.transponder);
                if !plot.height_measured {
                    position.z = point.up();
                }
                let association = Association {
                    distance_m: distance(plot, point),
                    because: AssociationEvidence::Ratio {
                        threshold_m: rules.threshold.at(plot.slant_range_m),
                        ratio,
                    },
                };
                points.push((
                    0,
                    Point::new(
                        number * 10_000 + u32::from(track.number),
                        position.into(),
                        centre(since.0),
                        Source::Fused(radar_part(plot), transponder, association),
                    ),
                ));
            }
            let nearby = (k - rules.suppress_slots).max(k - 75)..=(k + rules.suppress_slots).min(k + 24);
            let suppressed =
                nearby.into_iter().any(|s| tracks.iter().any(|&t| associated(identity, t, s).is_some()));
            if !suppressed {
                let source = Source::Transponder(transponder);
                points.push((2, Point::new(number, *point, centre(since.0), source)));
            }
        }
        for &track in &tracks {
            let Some(plot) = detections.get(&(track, k)) else { continue };
            let since = *self.first_seen.entry(track).or_insert(Slot(k));
            let uav = (k - 75..=k)
                .filter(|&s| detections.get(&(track, s)).is_some_and(|plot| plot.uav_probability > Some(0.0)))
                .count();
            if !explained.contains(&track) && uav as f64 * PERIODS_S[usize::from(track.sensor.0)] > 8.0 {
                points.push((
                    1,
                    Point::new(
                        track.number.into(),
                        plot.position,
                        centre(since.0),
                        Source::Radar(radar_part(plot)),
                    ),
                ));
            }
        }
        points.sort_by_key(|(rank, point)| {
            (*rank, point.number, point.source.radar().map(|radar| radar.track))
        });
        // A radar track counts as new again once it has no plot up to the last slot that can still change this output.
        let horizon = (k + rules.suppress_slots).min(k + 24);
        self.first_seen
            .retain(|track, _| detections.keys().any(|(other, s)| other == track && *s <= horizon));
        let points = points.into_iter().map(|(_, point)| point).collect();
        let numbers = self.numbers.take_changes();
        self.emissions.push(Emission {
            slot: Slot(k),
            time: centre(k),
            points,
            numbers,
            newcomers: Vec::new(),
            jumping: Vec::new(),
            concerns: Vec::new(),
            now: None,
        });
    }
}

fn radar_part(plot: &Plot) -> RadarPart {
    RadarPart {
        track: plot.track,
        time: plot.time,
        height_measured: plot.height_measured,
        uav_probability: plot.uav_probability,
    }
}
