//! A subject of the assessment: a sensor, or the picture; and its updates of each aircraft.

use std::collections::BTreeSet;

use super::recording::SensorReport;
use super::scene::AssessmentScene;
use crate::evaluate::{GeodeticPlace, OutputPoint, PointKind, ScoredPoint, ScoringReference, score_points};
use fusion::slots::Slot;
use fusion::time::{SECOND, Time};
use site::config::SensorKind;

/// Shortest gap, nanoseconds.
const GAP_MIN_NS: i64 = 3 * SECOND;

/// Kinds of subjects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SubjectKind {
    Radar,
    Receiver,
    Picture,
}

/// A sensor or the picture, with its points that count.
pub(super) struct AssessedSubject<'a> {
    /// Beginning of the keys of its figures.
    pub(super) key: String,
    pub(super) title: String,
    pub(super) kind: SubjectKind,
    /// Time between two updates.
    pub(super) period_ns: i64,
    /// Place from which ranges count.
    pub(super) origin: GeodeticPlace,
    /// Instrumented range, metres.
    pub(super) max_range_m: Option<f64>,
    /// Reports of the sensor; empty for the picture.
    pub(super) reports: &'a [SensorReport],
    /// Points of all reports, or of the picture.
    pub(super) points: &'a [OutputPoint],
    /// Points that count.
    pub(super) scored: Vec<ScoredPoint<'a>>,
    pub(super) updates: Updates,
}

/// Updates of the aircraft.
#[derive(Default)]
pub(super) struct Updates {
    /// Updates that were due.
    pub(super) due: Vec<DueUpdate>,
    /// Intervals between successive updates.
    pub(super) intervals: Vec<UpdateInterval>,
}

/// An update that was due.
pub(super) struct DueUpdate {
    pub(super) drone: usize,
    pub(super) time: Time,
    pub(super) is_made: bool,
    /// True place at that time.
    pub(super) place: GeodeticPlace,
}

/// Time between successive updates of an aircraft.
pub(super) struct UpdateInterval {
    pub(super) drone: usize,
    pub(super) until: Time,
    pub(super) length_ns: i64,
}

impl<'a> AssessedSubject<'a> {
    /// A sensor; `points` are those of its reports.
    pub(super) fn of_sensor(
        scene: &AssessmentScene<'_>,
        sensor: &site::config::Sensor,
        reports: &'a [SensorReport],
        points: &'a [OutputPoint],
    ) -> Self {
        let (kind, max_range_m) = match &sensor.kind {
            SensorKind::Radar(radar) => (SubjectKind::Radar, radar.max_range_m),
            _ => (SubjectKind::Receiver, None),
        };
        let origin = sensor.kind.place().map_or(scene.origin, |(latitude_deg, longitude_deg, height_m)| {
            GeodeticPlace { latitude_deg, longitude_deg, altitude_amsl_m: Some(height_m) }
        });
        let period_s = sensor.period_s.unwrap_or(sensor.kind.usual_period_s());
        let scored = score(scene, points);
        let period_ns = (period_s * SECOND as f64).round() as i64;
        Self {
            key: format!("sensor.{}", sensor.id),
            title: format!("{} ({})", sensor.id, sensor.kind.name()),
            kind,
            period_ns,
            origin,
            max_range_m,
            reports,
            points,
            updates: Updates::of_sensor(scene, &scored, period_ns),
            scored,
        }
    }

    /// The picture.
    pub(super) fn of_picture(scene: &AssessmentScene<'_>, points: &'a [OutputPoint]) -> Self {
        let scored = score(scene, points);
        Self {
            key: "picture".to_owned(),
            title: "picture".to_owned(),
            kind: SubjectKind::Picture,
            period_ns: scene.grid.slot().as_nanos() as i64,
            origin: scene.origin,
            max_range_m: None,
            reports: &[],
            points,
            updates: Updates::of_picture(scene, &scored),
            scored,
        }
    }

    pub(super) fn figure_key(&self, rest: &str) -> String {
        format!("{}.{rest}", self.key)
    }

    /// Whether the subject is to report an aircraft: a receiver reports those with a transponder.
    pub(super) fn covers(&self, scene: &AssessmentScene<'_>, drone: usize) -> bool {
        self.kind != SubjectKind::Receiver || scene.equipped[drone]
    }

    /// Interval above which updates are missing for long: three periods, and 3 s at least.
    pub(super) fn gap_ns(&self) -> i64 {
        (3 * self.period_ns).max(GAP_MIN_NS)
    }

    /// Points of each aircraft, by time.
    pub(super) fn by_drone(&self, scene: &AssessmentScene<'_>) -> Vec<Vec<&ScoredPoint<'a>>> {
        let mut drones = vec![Vec::new(); scene.drones().len()];
        for scored in &self.scored {
            if let Some(drone) = scored.drone {
                drones[drone].push(scored);
            }
        }
        drones.iter_mut().for_each(|points| points.sort_by_key(|scored| scored.point.time));
        drones
    }
}

fn score<'a>(scene: &AssessmentScene<'_>, points: &'a [OutputPoint]) -> Vec<ScoredPoint<'a>> {
    let reference =
        ScoringReference { truth: scene.truth, labels: None, counted: &scene.counted, grid: scene.grid };
    score_points(points, PointKind::Output, reference)
}

impl Updates {
    /// Slots of each aircraft that count, and those with a point of it.
    fn of_picture(scene: &AssessmentScene<'_>, scored: &[ScoredPoint<'_>]) -> Self {
        let mut slots: Vec<BTreeSet<Slot>> = vec![BTreeSet::new(); scene.drones().len()];
        for scored in scored {
            if let Some(drone) = scored.drone {
                slots[drone].insert(scored.slot);
            }
        }
        let mut updates = Self::default();
        for drone in scene.drones() {
            for &(first, last) in scene.counted.intervals(drone) {
                let mut before = None;
                for slot in (first.0..=last.0).map(Slot) {
                    let (time, is_made) = (scene.grid.centre(slot), slots[drone].contains(&slot));
                    updates.due(scene, drone, time, is_made);
                    if is_made {
                        updates.interval(drone, before, time);
                        before = Some(time);
                    }
                }
            }
        }
        updates
    }

    /// Updates by a sensor of this period: those made, and as many between two of them as there are whole periods (rounded) less
    /// one. Before the first and after the last, whole periods count. Reports less than half a period after an update repeat it.
    fn of_sensor(scene: &AssessmentScene<'_>, scored: &[ScoredPoint<'_>], period_ns: i64) -> Self {
        let mut times: Vec<Vec<Time>> = vec![Vec::new(); scene.drones().len()];
        for scored in scored {
            if let Some(drone) = scored.drone {
                times[drone].push(scored.point.time);
            }
        }
        let mut updates = Self::default();
        for (drone, times) in times.iter_mut().enumerate() {
            times.sort_unstable();
            for (from, until) in scene.spans(drone) {
                let made = times.iter().copied().filter(|time| (from..until).contains(time));
                updates.span(scene, drone, (from, until), made, period_ns);
            }
        }
        updates
    }

    fn span(
        &mut self,
        scene: &AssessmentScene<'_>,
        drone: usize,
        (from, until): (Time, Time),
        made: impl Iterator<Item = Time>,
        period_ns: i64,
    ) {
        let later = |time: Time, by_ns: i64| Time::from_nanos(time.nanos() + by_ns);
        let mut before: Option<Time> = None;
        for time in made {
            match before {
                None => {
                    let missed = (time.nanos() - from.nanos()) / period_ns;
                    for index in (1..=missed).rev() {
                        self.due(scene, drone, later(time, -index * period_ns), false);
                    }
                }
                Some(last) => {
                    let length_ns = time.nanos() - last.nanos();
                    let periods = (2 * length_ns + period_ns) / (2 * period_ns);
                    if periods == 0 {
                        continue;
                    }
                    for index in 1..periods {
                        self.due(scene, drone, later(last, index * length_ns / periods), false);
                    }
                }
            }
            self.due(scene, drone, time, true);
            self.interval(drone, before, time);
            before = Some(time);
        }
        // Without any update, the middles of the periods.
        let start = before.unwrap_or(later(from, -period_ns / 2));
        let end = before.map_or(later(until, -period_ns / 2), |_| until);
        for index in 1..=(end.nanos() - start.nanos()) / period_ns {
            self.due(scene, drone, later(start, index * period_ns), false);
        }
    }

    fn due(&mut self, scene: &AssessmentScene<'_>, drone: usize, time: Time, is_made: bool) {
        if let Some(place) = scene.place(drone, time) {
            self.due.push(DueUpdate { drone, time, is_made, place });
        }
    }

    fn interval(&mut self, drone: usize, before: Option<Time>, until: Time) {
        if let Some(before) = before {
            self.intervals.push(UpdateInterval { drone, until, length_ns: until.nanos() - before.nanos() });
        }
    }
}
