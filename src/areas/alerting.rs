//! Where a track raises an alert, and where one is about to.

use geo::{Point, Rect};
use jiff::SignedDuration;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::entry::{Path, time_to_entry};
use super::zone::{Zone, ZoneKind};
use crate::config::{AlertArea, AreaSeverity};
use fusion::frames::Geodetic;
use fusion::time::Time;

/// Where a track raises an alert: areas of one name are one.
#[derive(Clone, Debug, Default)]
pub struct AlertAreas {
    /// By their labels.
    zones: Vec<AlertZone>,
    /// The boxes around their parts, degrees, each with the place of its zone in the list: a country has thousands of zones,
    /// and an aircraft is near few.
    boxes: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
    /// The furthest that any of them looks ahead, seconds.
    predict_s: f64,
}

/// An area with what is set of it.
#[derive(Clone, Debug)]
struct AlertZone {
    label: String,
    zone: Zone,
    severity: AreaSeverity,
    allow: Vec<String>,
    predict_s: f64,
}

/// Who may be inside, and when.
#[derive(Clone, Copy, Debug)]
pub struct Visitor<'a> {
    /// Where.
    pub place: Geodetic,
    /// How high, metres above mean sea level; `None`: nobody knows.
    pub altitude_amsl_m: Option<f64>,
    /// The serial number of its transponder, unless something speaks against that: then it is nobody's.
    pub serial: Option<&'a str>,
    /// When.
    pub at: Time,
}

/// Somebody is inside an area.
#[derive(Clone, Copy, Debug)]
pub struct Presence<'a> {
    /// How the area is called.
    pub label: &'a str,
    /// The area, of several of that name the worst.
    pub zone: &'a Zone,
    /// How bad that is.
    pub severity: AreaSeverity,
    /// Whether it is inside only if its height is.
    pub is_height_unknown: bool,
}

/// Somebody flies towards an area.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// How the area is called.
    pub label: &'a str,
    /// The area, of several of that name the one that is entered first.
    pub zone: &'a Zone,
    /// When it enters at its course, seconds; `None`: only at one beside it.
    pub time_s: Option<f64>,
    /// The least of that at its course and at those a deviation beside it.
    pub earliest_s: f64,
}

/// How bad it is to be inside: the authority's word, unless the configuration has its own. `None`: not at all.
pub fn severity(settings: &AlertArea, kind: Option<ZoneKind>) -> Option<AreaSeverity> {
    let usual = match kind {
        Some(ZoneKind::NoRestriction) => return None,
        Some(ZoneKind::Prohibited | ZoneKind::Authorisation) => AreaSeverity::Critical,
        Some(ZoneKind::Conditional | ZoneKind::USpace) | None => AreaSeverity::Warning,
    };
    Some(settings.severity.unwrap_or(usual))
}

impl AlertAreas {
    /// Those of these areas that not everybody may be in.
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

    /// The same with every zone near to everything: what the boxes have to agree with.
    #[cfg(test)]
    pub(super) fn without_boxes(&self) -> Self {
        let everywhere = Rectangle::from_aabb(AABB::from_corners([-1e9; 2], [1e9; 2]));
        let boxes = (0..self.zones.len()).map(|index| GeomWithData::new(everywhere, index)).collect();
        Self { boxes: RTree::bulk_load(boxes), ..self.clone() }
    }

    /// The areas that a visitor is in and has to be outside of, where the geoid is that far above the ellipsoid.
    pub fn around<'a>(&'a self, visitor: Visitor<'_>, undulation_m: f64) -> Vec<Presence<'a>> {
        let place = Point::new(visitor.place.longitude_deg(), visitor.place.latitude_deg());
        let near = self.near(&[Rect::new(place.0, place.0)]);
        let worst = |zones: &[&'a AlertZone]| {
            // Hours cost more than places.
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

    /// The areas that a visitor on a path enters, where the geoid is that far above the ellipsoid. Its course has this
    /// deviation, radians; of the path so much is flown already, seconds.
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

    /// The zones with a part whose box touches one of these, by their labels.
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
    /// The least is the worst, seconds: an entry at its course is worse than any beside it.
    fn urgency(&self) -> f64 {
        /// Longer than any prediction.
        const BESIDE_S: f64 = 1e6;
        self.time_s.unwrap_or(BESIDE_S + self.earliest_s)
    }
}

impl AlertZone {
    /// `None` where everybody may be inside.
    fn new(settings: &AlertArea, zone: &Zone) -> Option<Self> {
        Some(Self {
            label: zone.label(),
            zone: zone.clone(),
            severity: severity(settings, zone.kind)?,
            allow: settings.allow.clone(),
            predict_s: settings.predict_s.as_secs_f64(),
        })
    }

    /// Whether the visitor has to be outside then.
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

    /// When it is entered at the first of these courses, of which so much is flown already, and at the earliest of them.
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
