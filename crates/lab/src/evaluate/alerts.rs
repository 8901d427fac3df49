//! Scores alerts against the truth: what an operator has to be shown, and what one is shown.
//!
//! An *item* is an alert from its beginning to its end. An *event* is a true violation of a protection volume, an aircraft inside an
//! alert area, or a transponder that lies. An item is compared with the truth of its aircraft within some seconds of it.

mod score;

use std::collections::{BTreeMap, BTreeSet};

use super::integrity::{AlertLine, Attack};
use super::labels::Labels;
use super::track_owners::TrackOwners;
use super::truth::{TrueTrack, Truth};
use super::types::{OutputPoint, Scoring};
use fusion::frames::Geodetic;
use fusion::time::{SECOND, Time};
use site::areas::{AlertAreas, Visitor};

pub use score::{AlertScore, MissedEvent, ScoredItem};

/// Time step along the true paths, nanoseconds.
const STEP_NS: i64 = SECOND / 2;
/// Two violations of a pair that are at most this many steps apart are one.
const APART_STEPS: usize = 20;
/// Minimum duration of an event, nanoseconds: conflicts are evaluated once a second, and two evaluations raise a level.
const EVENT_NS: i64 = 2 * SECOND;
/// Minimum duration of a lie, nanoseconds. Radar sees one in three drones for less than 15 s a minute.
const LIE_NS: i64 = 60 * SECOND;
/// Time after an event's end within which it is still raised: latency of the picture and of the evaluation, nanoseconds.
const LATE_NS: i64 = 10 * SECOND;
/// Time before a violation or an entry from which an item that lasts until then foresees it, nanoseconds.
const FORESEEN_NS: i64 = 10 * SECOND;
/// An aircraft reports its position at a time if it was received within this time before, nanoseconds.
const REPORTED_NS: i64 = 5 * SECOND;
/// Time ahead for which a warning foresees a violation, nanoseconds.
const WARNED_NS: i64 = 20 * SECOND;
/// Time after the end of an item within which another about the same is a duplicate, nanoseconds.
const AGAIN_NS: i64 = 60 * SECOND;
/// A conflict has something behind it if both come within this factor of the volume, horizontally and in height.
const NEAR: f64 = 2.0;
/// The factor for a critical item.
const NEAR_CRITICAL: f64 = 1.5;
/// Time around an item in which the truth is searched for its cause, nanoseconds.
const AROUND_NS: i64 = 10 * SECOND;
/// Kinds of events.
const CONFLICT: &str = "conflict";
const CONFLICT_UNREPORTED: &str = "conflict-unreported";
const AREA: &str = "area";
const LIE: &str = "integrity";

/// Inputs for scoring a flight's alerts.
#[derive(Clone, Copy, Debug)]
pub struct AlertFlight<'a> {
    /// True paths.
    pub truth: &'a Truth,
    /// The aircraft behind each plot and each report.
    pub labels: &'a Labels,
    /// Ids of crewed aircraft.
    pub crewed: &'a BTreeSet<String>,
    /// The output.
    pub output: &'a [OutputPoint],
    /// Lines of `replay --alerts`.
    pub alerts: &'a [AlertLine],
    /// Attacks on transponders.
    pub attacks: &'a [Attack],
    /// Areas that raise alerts, and the height of the geoid above the ellipsoid, metres.
    pub areas: (&'a AlertAreas, f64),
    /// Radius and half height of the volume between drones, and between a drone and a crewed aircraft, metres; `None`: there
    /// is none.
    pub volumes: [Option<(f64, f64)>; 2],
    /// Slot grid and latency.
    pub settings: &'a Scoring,
}

/// An alert from its beginning to its end.
struct Item<'a> {
    first: &'a AlertLine,
    last: &'a AlertLine,
    /// End; the end of the flight if it lasts.
    end: Time,
    is_critical: bool,
    /// Whether it is about what an earlier item is about.
    is_duplicate: bool,
    /// Indices of the aircraft in the truth; those of tracks that are none are missing.
    aircraft: BTreeSet<usize>,
    tracks: BTreeSet<&'a str>,
    identity: Option<&'a str>,
}

struct DueEvent {
    kind: &'static str,
    aircraft: BTreeSet<usize>,
    begin: Time,
    end: Time,
}

/// Scores the alerts of a flight.
pub fn score_alerts(flight: &AlertFlight<'_>) -> AlertScore {
    let paths = SampledPaths::of(flight.truth);
    let owners = TrackOwners::of(flight.truth, flight.labels, flight.output, flight.settings.grid);
    let Some((from, until)) = flight.truth.span() else { return AlertScore::default() };
    let items = items(flight, &owners, until);
    let duration_h = until.seconds_since(from) / 3600.0;
    let mut score = AlertScore { duration_h, items: items.len(), ..AlertScore::default() };
    for item in &items {
        *score.kinds.entry(item.first.kind.clone()).or_default() += 1;
        score.items_first_2_min += usize::from(item.first.since.nanos() - from.nanos() < 120 * SECOND);
        score.critical += usize::from(item.is_critical);
        let is_unfounded = !flight.is_founded(item, &paths);
        score.duplicates += usize::from(item.is_duplicate);
        score.unfounded += usize::from(is_unfounded);
        score.unfounded_critical += usize::from(is_unfounded && item.is_critical);
        if item.is_duplicate || is_unfounded {
            score.questionable.push(ScoredItem {
                id: item.first.id.clone(),
                is_critical: item.is_critical,
                is_duplicate: item.is_duplicate,
                is_unfounded,
                text: item.last.text.clone(),
            });
        }
    }
    let mut delays: BTreeMap<&'static str, Vec<f64>> = BTreeMap::new();
    for event in flight.events(&paths, &owners) {
        score.events.entry(event.kind).or_default().events += 1;
        match items.iter().filter_map(|item| item.raises(&event)).min_by(f64::total_cmp) {
            Some(delay_s) => delays.entry(event.kind).or_default().push(delay_s),
            None => score.missed.push(MissedEvent {
                kind: event.kind,
                aircraft: event
                    .aircraft
                    .iter()
                    .map(|&index| flight.truth.tracks()[index].id().to_owned())
                    .collect(),
                begin: event.begin.to_string(),
            }),
        }
    }
    for (kind, delays) in delays {
        let of_kind = score.events.entry(kind).or_default();
        of_kind.raised = delays.len();
        of_kind.mean_delay_s = Some(delays.iter().sum::<f64>() / delays.len() as f64);
        of_kind.longest_delay_s = delays.into_iter().max_by(f64::total_cmp);
    }
    score
}

/// The items, in order of their beginning.
fn items<'a>(flight: &AlertFlight<'a>, owners: &TrackOwners, until: Time) -> Vec<Item<'a>> {
    let mut by_id: BTreeMap<&str, Item<'_>> = BTreeMap::new();
    for line in flight.alerts {
        if !by_id.contains_key(line.id.as_str()) {
            let is_duplicate = by_id.values().any(|earlier| earlier.is_about_the_same(line, owners));
            let new = Item {
                first: line,
                last: line,
                end: until,
                is_critical: false,
                is_duplicate,
                aircraft: BTreeSet::new(),
                tracks: BTreeSet::new(),
                identity: line.identity.as_deref(),
            };
            by_id.insert(&line.id, new);
        }
        let Some(item) = by_id.get_mut(line.id.as_str()) else { continue };
        item.last = line;
        item.end = line.until.unwrap_or(until);
        item.is_critical |= line.is_critical;
        item.tracks.extend(line.tracks.iter().map(String::as_str));
    }
    let mut items: Vec<Item<'_>> = by_id.into_values().collect();
    for item in &mut items {
        let numbers = item.tracks.iter().filter_map(|id| number(id));
        item.aircraft =
            numbers.flat_map(|number| owners.drones(number, item.first.since, item.end)).collect();
        let carrier = item.identity.and_then(|name| flight.labels.transponder(Some(name), u32::MAX));
        item.aircraft.extend(carrier.and_then(|carrier| flight.truth.index_of(carrier.id?)));
    }
    items.sort_by(|one, other| (one.first.since, &one.first.id).cmp(&(other.first.since, &other.first.id)));
    items
}

/// Track number of a track's id: `U-10004`, `R-north-17-1795748484`, `U-67-1795748484.125`.
fn number(id: &str) -> Option<u32> {
    let mut parts = id.split('-');
    let first = parts.next()?;
    let parts: Vec<&str> = parts.collect();
    match (first, &parts[..]) {
        ("U" | "F" | "T", [number, ..]) => number.parse().ok(),
        ("R", [.., number, _]) => number.parse().ok(),
        _ => None,
    }
}

impl Item<'_> {
    /// Whether a later item is about the same as this one so far, which lasts or has just ended: the same aircraft, or two of
    /// them for a conflict.
    fn is_about_the_same(&self, later: &AlertLine, owners: &TrackOwners) -> bool {
        let is_over = self.last.until.is_some_and(|end| later.since.nanos() > end.nanos() + AGAIN_NS);
        let least = if self.first.kind == CONFLICT { 2 } else { 1 };
        let tracks: BTreeSet<&str> = later.tracks.iter().map(String::as_str).collect();
        let drones = |tracks: &BTreeSet<&str>| -> BTreeSet<usize> {
            let numbers = tracks.iter().filter_map(|id| number(id));
            numbers.flat_map(|number| owners.drones(number, self.first.since, later.since)).collect()
        };
        let is_shared = tracks.intersection(&self.tracks).nth(least - 1).is_some()
            || drones(&tracks).intersection(&drones(&self.tracks)).nth(least - 1).is_some()
            || (self.identity.is_some() && self.identity == later.identity.as_deref());
        self.first.kind == later.kind && self.first.area == later.area && !is_over && is_shared
    }

    /// Time from the beginning of the event until this item raises it, seconds; `None` if it does not.
    fn raises(&self, event: &DueEvent) -> Option<f64> {
        let kinds: &[&str] = match event.kind {
            AREA => &[AREA, "area-predicted"],
            CONFLICT | CONFLICT_UNREPORTED => &[CONFLICT],
            _ => &[LIE],
        };
        let is_of_kind = kinds.contains(&self.first.kind.as_str());
        let is_about = event.aircraft.is_subset(&self.aircraft);
        let earliest = event.begin.nanos() - FORESEEN_NS;
        let is_timely =
            self.end.nanos() >= earliest && self.first.since.nanos() <= event.end.nanos() + LATE_NS;
        (is_of_kind && is_about && is_timely).then(|| self.first.since.seconds_since(event.begin))
    }
}

impl AlertFlight<'_> {
    /// Volume of a pair, radius and half height, metres; `None` between crewed aircraft, and if none is configured.
    fn volume(&self, pair: [usize; 2]) -> Option<(f64, f64)> {
        let crewed = pair.map(|index| self.crewed.contains(self.truth.tracks()[index].id()));
        match crewed {
            [false, false] => self.volumes[0],
            [true, true] => None,
            _ => self.volumes[1],
        }
    }

    /// The events that have to be raised.
    fn events(&self, paths: &SampledPaths, owners: &TrackOwners) -> Vec<DueEvent> {
        let mut events = Vec::new();
        let count = self.truth.tracks().len();
        for a in 0..count {
            for b in a + 1..count {
                let Some(volume) = self.volume([a, b]) else { continue };
                for (begin, end) in paths.meetings([a, b], volume) {
                    let is_long = end.nanos() - begin.nanos() >= EVENT_NS;
                    // An aircraft that no sensor has shown cannot be warned of.
                    if is_long && [a, b].iter().all(|&index| owners.is_shown(index, begin, end)) {
                        let is_known = |&index: &usize| {
                            self.reports(index, begin, end) && owners.has_height(index, begin, end)
                        };
                        let are_known = [a, b].iter().all(is_known);
                        let kind = if are_known { CONFLICT } else { CONFLICT_UNREPORTED };
                        events.push(DueEvent { kind, aircraft: [a, b].into(), begin, end });
                    }
                }
            }
        }
        let is_due = |attack: &&Attack| {
            attack.kind.is_attack() && attack.until.nanos() - attack.from.nanos() >= LIE_NS
        };
        for attack in self.attacks.iter().filter(is_due) {
            if let Some(index) = self.truth.index_of(&attack.id) {
                let (begin, end) = (attack.from, attack.until);
                events.push(DueEvent { kind: LIE, aircraft: [index].into(), begin, end });
            }
        }
        for index in 0..count {
            events.extend(
                self.entries(index)
                    .into_iter()
                    .filter(|event| owners.is_shown(index, event.begin, event.end)),
            );
        }
        events.sort_by_key(|event| event.begin);
        events
    }

    /// Whether an aircraft reports its true position all the time from just before `begin` until `end`.
    fn reports(&self, index: usize, begin: Time, end: Time) -> bool {
        let id = self.truth.tracks()[index].id();
        let is_attacked =
            self.attacks.iter().any(|attack| attack.id == id && attack.from <= end && attack.until >= begin);
        let times = self.labels.report_times(id);
        !is_attacked
            && steps(begin, end).all(|at| {
                let latest = times.partition_point(|time| *time <= at).checked_sub(1);
                latest.is_some_and(|latest| at.nanos() - times[latest].nanos() <= REPORTED_NS)
            })
    }

    /// Stays of an aircraft inside alert areas.
    fn entries(&self, index: usize) -> Vec<DueEvent> {
        let (from, until) = self.truth.tracks()[index].span();
        let mut stays: Vec<(Time, Time)> = Vec::new();
        let mut was_inside = false;
        for at in steps(from, until) {
            let is_inside = self.is_inside(index, at, None);
            match stays.last_mut() {
                Some((_, end)) if is_inside && was_inside => *end = at,
                _ if is_inside => stays.push((at, at)),
                _ => {}
            }
            was_inside = is_inside;
        }
        stays.retain(|(begin, end)| end.nanos() - begin.nanos() >= EVENT_NS);
        let event = |(begin, end)| DueEvent { kind: AREA, aircraft: [index].into(), begin, end };
        stays.into_iter().map(event).collect()
    }

    /// Whether an aircraft is inside an alert area, of that name if one is given.
    fn is_inside(&self, index: usize, at: Time, name: Option<&str>) -> bool {
        let (areas, undulation_m) = self.areas;
        let Some(place) = self.truth.tracks()[index].at(at) else { return false };
        let height_m = place.altitude_amsl_m.unwrap_or(0.0) + undulation_m;
        let geodetic = Geodetic::from_degrees(place.latitude_deg, place.longitude_deg, height_m);
        let visitor = Visitor { place: geodetic, altitude_amsl_m: place.altitude_amsl_m, serial: None, at };
        let inside = areas.around(visitor, undulation_m);
        inside.iter().any(|presence| name.is_none_or(|name| presence.zone.name == name))
    }

    /// Whether the truth has a cause for an item.
    fn is_founded(&self, item: &Item<'_>, paths: &SampledPaths) -> bool {
        let from = Time::from_nanos(item.first.since.nanos() - AROUND_NS);
        let until = Time::from_nanos(item.end.nanos() + AROUND_NS);
        match item.first.kind.as_str() {
            CONFLICT => {
                let (factor, ahead_ns) =
                    if item.is_critical { (NEAR_CRITICAL, 0) } else { (NEAR, WARNED_NS) };
                let span = (from, Time::from_nanos(until.nanos() + ahead_ns));
                let members: Vec<usize> = item.aircraft.iter().copied().collect();
                let pairs =
                    members.iter().flat_map(|&a| members.iter().map(move |&b| [a, b])).filter(|[a, b]| a < b);
                pairs.into_iter().any(|pair| {
                    let volume =
                        self.volume(pair).map(|(radius_m, height_m)| (factor * radius_m, factor * height_m));
                    volume.is_some_and(|volume| paths.come_within(pair, volume, span))
                })
            }
            "area" | "area-predicted" => item.aircraft.iter().any(|&index| {
                steps(from, Time::from_nanos(until.nanos() + AGAIN_NS))
                    .any(|at| self.is_inside(index, at, item.first.area.as_deref()))
            }),
            "integrity" => {
                let carrier = item.identity.and_then(|name| self.labels.transponder(Some(name), u32::MAX));
                // A transponder without an aircraft is a fake.
                carrier.is_none_or(|carrier| carrier.id.is_none())
                    || self.attacks.iter().any(|attack| {
                        let carrier = carrier.and_then(|carrier| carrier.id);
                        carrier == Some(attack.id.as_str()) && attack.from <= until && attack.until >= from
                    })
            }
            "uncooperative" => {
                let equipped = self.labels.equipped();
                item.aircraft.iter().any(|&index| !equipped.contains(self.truth.tracks()[index].id()))
            }
            "silent" => {
                let name = item.identity.unwrap_or_default();
                let mut reports =
                    self.labels.rows().iter().filter(|row| row.identity.as_deref() == Some(name));
                let quiet = from.nanos()..item.first.since.nanos();
                !reports.any(|row| quiet.contains(&row.time.nanos()))
            }
            _ => true,
        }
    }
}

/// Times from one to another.
fn steps(from: Time, until: Time) -> impl Iterator<Item = Time> {
    let count = (until.nanos() - from.nanos()) / STEP_NS;
    (0..=count).map(move |step| Time::from_nanos(from.nanos() + step * STEP_NS))
}

/// True positions at all steps: east, north and up of a common origin, metres.
struct SampledPaths {
    begin: Time,
    /// By aircraft and step; `None`: not known. An unknown height is not a number.
    places: Vec<Vec<Option<[f64; 3]>>>,
}

impl SampledPaths {
    fn of(truth: &Truth) -> Self {
        let (begin, end) = truth.span().unwrap_or_default();
        let origin = truth.tracks().first().map(|track| track.samples()[0].1);
        let place = |track: &TrueTrack, at: Time| {
            let offset = track.at(at)?.offset_from(&origin?);
            Some([offset.east_m, offset.north_m, offset.up_m.unwrap_or(f64::NAN)])
        };
        let places =
            truth.tracks().iter().map(|track| steps(begin, end).map(|at| place(track, at)).collect());
        Self { begin, places: places.collect() }
    }

    fn at(&self, step: usize) -> Time {
        Time::from_nanos(self.begin.nanos() + step as i64 * STEP_NS)
    }

    /// Whether two aircraft are within a volume at each step. An unknown height counts as equal.
    fn within(&self, [a, b]: [usize; 2], (radius_m, height_m): (f64, f64)) -> impl Iterator<Item = bool> {
        self.places[a].iter().zip(&self.places[b]).map(move |pair| {
            let (Some(one), Some(other)) = pair else { return false };
            let [east_m, north_m, up_m] = [0, 1, 2].map(|axis| one[axis] - other[axis]);
            let is_apart = east_m.abs() >= radius_m || up_m.abs() >= height_m;
            !is_apart && east_m.hypot(north_m) < radius_m
        })
    }

    /// Beginning and end of each time that two aircraft are within a volume.
    fn meetings(&self, pair: [usize; 2], volume: (f64, f64)) -> Vec<(Time, Time)> {
        let mut meetings: Vec<(usize, usize)> = Vec::new();
        for (step, _) in self.within(pair, volume).enumerate().filter(|(_, is_within)| *is_within) {
            match meetings.last_mut() {
                Some((_, end)) if step - *end <= APART_STEPS => *end = step,
                _ => meetings.push((step, step)),
            }
        }
        meetings.into_iter().map(|(begin, end)| (self.at(begin), self.at(end))).collect()
    }

    /// Whether two aircraft are within a volume at some time of a span.
    fn come_within(&self, pair: [usize; 2], volume: (f64, f64), (from, until): (Time, Time)) -> bool {
        let is_timely = |step: usize| (from..=until).contains(&self.at(step));
        self.within(pair, volume).enumerate().any(|(step, is_within)| is_within && is_timely(step))
    }
}

#[cfg(test)]
mod tests;
