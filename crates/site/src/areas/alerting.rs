//! Alert areas: which tracks are inside one, and which will enter one.

use geo::{Point, Rect};
use jiff::SignedDuration;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::entry::{Path, time_to_entry};
use super::zone::{Zone, ZoneKind};
use crate::config::{AlertArea, AreaSeverity};
use fusion::frames::Geodetic;
use fusion::time::Time;

/// The areas that raise alerts. Areas with the same label count as one.
#[derive(Clone, Debug, Default)]
pub struct AlertAreas {
    /// Sorted by label.
    zones: Vec<AlertZone>,
    /// Bounding boxes of the parts of the zones, in degrees, each with the index of its zone. A national file has thousands of
    /// zones, and an aircraft is near few of them.
    boxes: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
    /// Maximum prediction time of all areas, in seconds.
    predict_s: f64,
}

/// An area with its settings.
#[derive(Clone, Debug)]
struct AlertZone {
    label: String,
    zone: Zone,
    severity: AreaSeverity,
    allow: Vec<String>,
    predict_s: f64,
}

/// An aircraft at a time.
#[derive(Clone, Copy, Debug)]
pub struct Visitor<'a> {
    /// Position.
    pub place: Geodetic,
    /// Altitude, in metres above mean sea level; `None`: unknown.
    pub altitude_amsl_m: Option<f64>,
    /// Serial number of its transponder; `None`: it has none, or integrity checks speak against it.
    pub serial: Option<&'a str>,
    /// Time of the position.
    pub at: Time,
}

/// An aircraft is inside an area.
#[derive(Clone, Copy, Debug)]
pub struct Presence<'a> {
    /// Label of the area.
    pub label: &'a str,
    /// The area; of several with this label, the one with the highest severity.
    pub zone: &'a Zone,
    /// Severity of the presence.
    pub severity: AreaSeverity,
    /// Whether the aircraft may be above or below the area: its altitude is unknown, and the area is limited in height.
    pub is_height_unknown: bool,
}

/// An aircraft flies towards an area.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// Label of the area.
    pub label: &'a str,
    /// The area; of several with this label, the one that is entered first.
    pub zone: &'a Zone,
    /// Time to entry on the present course, in seconds; `None`: only a deviating course enters.
    pub time_s: Option<f64>,
    /// Time to entry, in seconds: the minimum of the present course and the courses deviating to either side.
    pub earliest_s: f64,
}

/// Severity of a presence inside the area. A setting overrides what the zone's authority states. `None`: no alert.
pub fn severity(settings: &AlertArea, kind: Option<ZoneKind>) -> Option<AreaSeverity> {
    let usual = match kind {
        Some(ZoneKind::NoRestriction) => return None,
        Some(ZoneKind::Prohibited | ZoneKind::Authorisation) => AreaSeverity::Critical,
        Some(ZoneKind::Conditional | ZoneKind::USpace) | None => AreaSeverity::Warning,
    };
    Some(settings.severity.unwrap_or(usual))
}

impl AlertAreas {
    /// The areas among these that raise alerts.
    pub(super) fn of<'a>(areas: impl Iterator<Item = (&'a AlertArea, &'a Zone)>) -> Self {
        let mut zones: Vec<AlertZone> = areas.filter_map(|(set, zone)| AlertZone::new(set, zone)).collect();
        zones.sort_by(|a, b| a.label.cmp(&b.label));
        let boxes = zones.iter().enumerate().flat_map(|(index, zone)| {
            zone.zone.volumes.iter().map(move |volume| {
                let envelope = envelope(&volume.shape.bounds);
                GeomWithData::new(Rectangle::from_aabb(envelope), index)
            })
        });
        let boxes = RTree::bulk_load(boxes.collect());
        let predict_s = zones.iter().map(|zone| zone.predict_s).fold(0.0, f64::max);
        Self { zones, boxes, predict_s }
    }

    /// The same areas with boxes that contain every position: a reference for tests of the boxes.
    #[cfg(test)]
    pub(super) fn without_boxes(&self) -> Self {
        let everywhere = Rectangle::from_aabb(AABB::from_corners([-1e9; 2], [1e9; 2]));
        let boxes = (0..self.zones.len()).map(|index| GeomWithData::new(everywhere, index)).collect();
        Self { boxes: RTree::bulk_load(boxes), ..self.clone() }
    }

    /// The areas that the aircraft is in and must not be in. `undulation_m`: height of the geoid above the ellipsoid.
    pub fn around<'a>(&'a self, visitor: Visitor<'_>, undulation_m: f64) -> Vec<Presence<'a>> {
        let place = Point::new(visitor.place.longitude_deg(), visitor.place.latitude_deg());
        let near = self.near(&[Rect::new(place.0, place.0)]);
        let worst = |zones: &[&'a AlertZone]| {
            // The schedule is more expensive to evaluate than the position.
            let found = zones.iter().filter_map(|zone| {
                let presence = zone.presence(&place, &visitor, undulation_m)?;
                zone.concerns(&visitor, visitor.at).then_some(presence)
            });
            found.max_by_key(|presence| {
                (presence.severity == AreaSeverity::Critical, !presence.is_height_unknown)
            })
        };
        near.chunk_by(|a, b| a.label == b.label).filter_map(worst).collect()
    }

    /// The areas that the aircraft enters on its path. `course_deviation`, in radians, is the uncertainty of its course;
    /// `flown_s`, in seconds, the part of the path already flown; `undulation_m` the height of the geoid above the ellipsoid.
    pub fn ahead<'a>(
        &'a self,
        visitor: Visitor<'_>,
        path: &Path,
        course_deviation: f64,
        flown_s: f64,
        undulation_m: f64,
    ) -> Vec<Entry<'a>> {
        let near = self.near(&path.reach(flown_s + self.predict_s));
        if near.is_empty() {
            return Vec::new();
        }
        let courses = [0.0, -course_deviation, course_deviation].map(|angle| path.turned(angle));
        let first = |zones: &[&'a AlertZone]| {
            let found = zones.iter().filter_map(|zone| zone.entry(&visitor, &courses, flown_s, undulation_m));
            found.min_by(|a, b| a.urgency().total_cmp(&b.urgency()))
        };
        near.chunk_by(|a, b| a.label == b.label).filter_map(first).collect()
    }

    /// The zones with a box that touches one of `boxes`, sorted by label.
    fn near(&self, boxes: &[Rect]) -> Vec<&AlertZone> {
        let touched = |near: &Rect| self.boxes.locate_in_envelope_intersecting(&envelope(near));
        let mut indices: Vec<usize> = boxes.iter().flat_map(touched).map(|found| found.data).collect();
        indices.sort_unstable();
        indices.dedup();
        indices.into_iter().map(|index| &self.zones[index]).collect()
    }
}

fn envelope(bounds: &Rect) -> AABB<[f64; 2]> {
    AABB::from_corners(bounds.min().into(), bounds.max().into())
}

impl Entry<'_> {
    /// Sort key, in seconds, the most urgent first: entries on the present course come before those on a deviating one.
    fn urgency(&self) -> f64 {
        /// Longer than any prediction time.
        const BESIDE_S: f64 = 1e6;
        self.time_s.unwrap_or(BESIDE_S + self.earliest_s)
    }
}

impl AlertZone {
    /// `None` if the area raises no alerts.
    fn new(settings: &AlertArea, zone: &Zone) -> Option<Self> {
        Some(Self {
            label: zone.label(),
            zone: zone.clone(),
            severity: severity(settings, zone.kind)?,
            allow: settings.allow.clone(),
            predict_s: settings.predict_s.as_secs_f64(),
        })
    }

    /// Whether the aircraft must not be inside at that time.
    fn concerns(&self, visitor: &Visitor<'_>, at: Time) -> bool {
        let is_allowed =
            visitor.serial.is_some_and(|serial| self.allow.iter().any(|allowed| allowed == serial));
        !is_allowed && self.zone.schedule.is_active(at)
    }

    fn presence(&self, place: &Point, visitor: &Visitor<'_>, undulation_m: f64) -> Option<Presence<'_>> {
        let bands = self.zone.volumes.iter().filter(|volume| volume.shape.contains(place));
        let mut bands = bands
            .map(|volume| volume.band.above_sea(undulation_m))
            .filter(|band| band.contains(visitor.altitude_amsl_m))
            .peekable();
        bands.peek()?;
        let is_limited = bands.all(|band| band.floor_m.or(band.ceiling_m).is_some());
        Some(Presence {
            label: &self.label,
            zone: &self.zone,
            severity: self.severity,
            is_height_unknown: visitor.altitude_amsl_m.is_none() && is_limited,
        })
    }

    /// The entry into the zone. `flown_s`, in seconds, is the part already flown; the first of `courses` is the present course.
    fn entry(
        &self,
        visitor: &Visitor<'_>,
        courses: &[Path; 3],
        flown_s: f64,
        undulation_m: f64,
    ) -> Option<Entry<'_>> {
        if self.predict_s <= 0.0 {
            return None;
        }
        let horizon_s = flown_s + self.predict_s;
        let time_to_entry = |path: &Path| {
            let time_s = self.time_to_entry(path, horizon_s, undulation_m)?;
            Some((time_s - flown_s).max(0.0))
        };
        let [time_s, left_s, right_s] = courses.map(|path| time_to_entry(&path));
        let earliest_s = [time_s, left_s, right_s].into_iter().flatten().min_by(f64::total_cmp)?;
        let entered_s = time_s.unwrap_or(earliest_s);
        let is_concerned = self.concerns(visitor, visitor.at + SignedDuration::from_secs_f64(entered_s));
        is_concerned.then_some(Entry { label: &self.label, zone: &self.zone, time_s, earliest_s })
    }

    fn time_to_entry(&self, path: &Path, horizon_s: f64, undulation_m: f64) -> Option<f64> {
        let times = self.zone.volumes.iter().filter_map(|volume| {
            time_to_entry(&volume.shape, &volume.band.above_sea(undulation_m), path, horizon_s)
        });
        times.min_by(f64::total_cmp)
    }
}
