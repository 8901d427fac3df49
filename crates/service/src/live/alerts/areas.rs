//! Alerts about areas: tracks inside an area, and tracks about to enter one.

use std::collections::{BTreeMap, BTreeSet};

use jiff::SignedDuration;

use super::wording::{entering, inside};
use super::{AlertCause, AlertDetails, AlertKind, AlertMonitor, Severity};
use fusion::point::Estimate;
use fusion::time::Time;
use picture::{MAX_ACCURACY_M, Picture, PictureMaker, PictureTrack, serial_text};
use site::areas::{Path, Visitor};
use site::config::AreaSeverity;

/// Number of recent predictions kept per track and area, and how many of them must predict an entry to raise an alert. A
/// single prediction may be chance.
const REMEMBERED: u32 = 4;
const RAISING: u32 = 2;
/// Minimum ground speed at which a course is meaningful, in metres per second.
const SLOWEST: f64 = 0.5;

/// Picture from which entries are predicted.
#[derive(Clone, Copy, Debug)]
pub enum PredictionPicture<'a> {
    /// Predicted present positions.
    Now(&'a Picture),
    /// The published picture, with its age; used where no picture of the present is made.
    Lagged(&'a Picture, SignedDuration),
}

/// Tracks that are about to enter an area.
#[derive(Debug, Default)]
pub(super) struct Approaches(BTreeMap<ApproachKey, u32>);

/// Id of the track and name of the area. The map's value holds the latest predictions, one bit each: whether it predicts an
/// entry.
type ApproachKey = (String, String);

impl Approaches {
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Records for each track and area whether the latest prediction has it enter on its course, or inside already. Drops
    /// entries without such a prediction among the last ones.
    fn note(&mut self, found: &BTreeMap<ApproachKey, AlertCause>) {
        let enters = |found: &AlertCause| {
            matches!(found.details, AlertDetails::AreaPredicted { time_to_entry_s: Some(_), .. })
        };
        for (approach, _) in found.iter().filter(|(_, found)| enters(found)) {
            self.0.entry(approach.clone()).or_default();
        }
        self.0.retain(|approach, reached| {
            let is_reached = found.get(approach).is_some_and(enters);
            *reached = (*reached << 1 | u32::from(is_reached)) & ((1 << REMEMBERED) - 1);
            *reached != 0
        });
    }

    /// Whether enough predictions have the track enter.
    fn is_certain(&self, approach: &ApproachKey) -> bool {
        self.0.get(approach).is_some_and(|reached| reached.count_ones() >= RAISING)
    }
}

impl AlertMonitor {
    pub(super) fn note_areas(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let (now, settings) = (picture.time, self.settings.get());
        let mut found = Vec::new();
        let is_covered =
            |track: &&PictureTrack| track.failed().is_some_and(|liar| settings.reports_lies(liar));
        for track in picture.within(MAX_ACCURACY_M).filter(|track| !is_covered(track)) {
            let serial = serial(track);
            for presence in
                settings.areas.around(visitor(track, serial.as_deref(), now), maker.geoid_undulation_m())
            {
                let id = maker.track_id(track);
                let name = track.name.clone();
                let text = inside(&name, &presence);
                let severity = match presence.severity {
                    AreaSeverity::Warning => Severity::Warning,
                    AreaSeverity::Critical => Severity::Critical,
                };
                let details = AlertDetails::Area {
                    area: presence.zone.into(),
                    label: presence.label.to_owned(),
                    is_height_unknown: presence.is_height_unknown,
                };
                let area = presence.label.to_owned();
                let transponders = vec![track.trusted()];
                found.push(AlertCause {
                    past: format!("{name} was inside {area}"),
                    area,
                    details,
                    transponders,
                    ..AlertCause::new(&id, severity, text)
                });
            }
        }
        self.hold(AlertKind::Area, found, now, |_, _| true)
    }

    /// Predicts entries, once a second. Returns whether any alert changed.
    pub fn note_approaches(&mut self, ahead: PredictionPicture<'_>, maker: &PictureMaker) -> bool {
        let (picture, age) = match ahead {
            PredictionPicture::Now(picture) => (picture, SignedDuration::ZERO),
            PredictionPicture::Lagged(picture, age) => (picture, age),
        };
        let (kind, now) = (AlertKind::AreaPredicted, picture.time + age);
        let before = self.changes.len();
        let is_inside = self.lasting.keys().filter(|(kind, ..)| *kind == AlertKind::Area);
        let inside: BTreeSet<ApproachKey> =
            is_inside.map(|(_, track, area)| (track.clone(), area.clone())).collect();
        // A track that is published as inside no longer enters.
        self.end(kind, now, |(_, track, area), _| inside.contains(&(track.clone(), area.clone())));
        if !maker.begins_second(picture.slot) {
            return self.changes.len() > before;
        }
        let mut found = self.entries(picture, age, maker);
        found.retain(|approach, _| !inside.contains(approach));
        self.approaches.note(&found);
        found.retain(|approach, _| {
            let (track, area) = approach.clone();
            self.approaches.is_certain(approach) || self.lasting.contains_key(&(kind, track, area))
        });
        self.hold(kind, found.into_values().collect(), now, |_, _| true) || self.changes.len() > before
    }

    /// Entries predicted from a picture of that age.
    fn entries(
        &self,
        picture: &Picture,
        age: SignedDuration,
        maker: &PictureMaker,
    ) -> BTreeMap<ApproachKey, AlertCause> {
        let (now, settings) = (picture.time + age, self.settings.get());
        let areas = &settings.areas;
        let mut found = BTreeMap::new();
        let is_covered =
            |track: &&PictureTrack| track.failed().is_some_and(|liar| settings.reports_lies(liar));
        for track in picture.within(MAX_ACCURACY_M).filter(|track| !is_covered(track)) {
            let (Some(motion), Some(estimate)) = (&track.motion, &track.point.estimate) else { continue };
            let (velocity, serial) = (motion.velocity, serial(track));
            let is_moving = motion.speed() >= SLOWEST;
            let over_ground = if is_moving { velocity.xy() } else { Default::default() };
            let path =
                Path::new(&track.position, [over_ground.x, over_ground.y, velocity.z], track.altitude_amsl_m);
            let visitor = visitor(track, serial.as_deref(), now);
            let undulation_m = maker.geoid_undulation_m();
            for entry in
                areas.ahead(visitor, &path, course_deviation(estimate), age.as_secs_f64(), undulation_m)
            {
                let id = maker.track_id(track);
                let name = track.name.clone();
                let text = entering(&name, &entry);
                let area = entry.label.to_owned();
                let details = AlertDetails::AreaPredicted {
                    area: entry.zone.into(),
                    label: area.clone(),
                    time_to_entry_s: entry.time_s,
                    earliest_s: entry.earliest_s,
                };
                let raised = AlertCause {
                    area: area.clone(),
                    details,
                    past: format!("{name} was on course to enter {area}"),
                    transponders: vec![track.trusted()],
                    ..AlertCause::new(&id, Severity::Warning, text)
                };
                found.insert((id, area), raised);
            }
        }
        found
    }
}

/// Serial number of the track's transponder, unless the transponder is suspect or failed: then the number does not identify
/// the aircraft.
fn serial(track: &PictureTrack) -> Option<String> {
    track.trusted().map(serial_text)
}

fn visitor<'a>(track: &PictureTrack, serial: Option<&'a str>, at: Time) -> Visitor<'a> {
    Visitor { place: track.position, altitude_amsl_m: track.altitude_amsl_m, serial, at }
}

/// Standard deviation of the course, in radians; at most a right angle.
fn course_deviation(estimate: &Estimate) -> f64 {
    let velocity = estimate.velocity.xy();
    let speed = velocity.norm();
    let Some(along) = velocity.try_normalize(0.0) else { return 0.0 };
    let across = nalgebra::Vector2::new(-along.y, along.x);
    let variance = (across.transpose() * estimate.velocity_covariance * across)[(0, 0)];
    variance.max(0.0).sqrt().atan2(speed)
}
