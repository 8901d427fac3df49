//! Alerts that follow from a slot's picture.

use std::collections::BTreeMap;

use geo::{ConvexHull, LineString, MultiPoint, Point, Winding};

use super::wording::{contradicted_height, emergency, jamming, lying, resolved, silent, uncooperative};
use super::{AlertCause, AlertDetails, AlertInput, AlertKind, AlertMonitor, Severity};
use fusion::integrity::{Concern, State};
use fusion::time::Time;
use fusion::{Enu, Identity};
use input::json::rounded;
use picture::{Picture, PictureMaker, PictureTrack, serial_text};

/// Margin around the last positions of jammed transponders, in metres.
const HULL_MARGIN_M: f64 = 100.0;
/// Number of corners of a circle around a position.
const CORNERS: usize = 24;

impl AlertMonitor {
    /// Updates the alerts from a slot's picture. Returns whether any changed.
    pub fn note_picture(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let now = picture.time;
        // A replay went back: later alerts have not begun yet.
        let went_back = self.pictured.replace(now).is_some_and(|before| now < before);
        if went_back {
            self.lasting.clear();
            self.ended.clear();
            self.changes.clear();
            self.decisions.rewind();
            self.approaches.clear();
        }
        self.derive(AlertInput::Picture, now);
        went_back
            | self.note_areas(picture, maker)
            | self.note_transponders(picture, maker)
            | self.note_uncooperative(picture, maker)
            | self.note_emergencies(picture, maker)
    }

    /// No hold is needed here: the engine decides when a concern ends.
    fn note_transponders(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let kinds = [AlertKind::Integrity, AlertKind::Silent, AlertKind::Height, AlertKind::Jamming];
        let mut found = BTreeMap::from(kinds.map(|kind| (kind, Vec::new())));
        for concern in &picture.concerns {
            let (kind, raised) = self.raised(concern, picture, maker);
            found.entry(kind).or_default().push(raised);
        }
        let mut is_new = false;
        for (kind, found) in found {
            is_new |= self.hold(kind, found, picture.time, |_, _| true);
        }
        is_new
    }

    fn raised(&self, concern: &Concern, picture: &Picture, maker: &PictureMaker) -> (AlertKind, AlertCause) {
        let id_of = |number: Option<u32>| {
            let track = picture.tracks.iter().find(|track| Some(track.point.number) == number)?;
            Some(maker.track_id(track))
        };
        match concern {
            Concern::Integrity { identity, track, twin, state, reasons, offset_m } => {
                let (kind, subject) = (AlertKind::Integrity, subject(*identity));
                let (since, before) = self.lasting(kind, &subject, picture.time);
                let (known_track, known_twin) = match before {
                    Some(AlertDetails::Integrity { track_id, twin_id, .. }) => {
                        (track_id.clone(), twin_id.clone())
                    }
                    _ => (None, None),
                };
                // A track without a point in this slot keeps the id of its last one.
                let details = AlertDetails::Integrity {
                    identity: *identity,
                    track_id: id_of(*track).or(known_track.filter(|_| track.is_some())),
                    twin_id: id_of(*twin).or(known_twin.filter(|_| twin.is_some())),
                    state: *state,
                    reasons: *reasons,
                    offset_m: offset_m.map(f64::round),
                };
                let severity = match state {
                    State::Failed => Severity::Critical,
                    _ => Severity::Warning,
                };
                let text = lying(&details, since);
                let transponders = vec![Some(*identity)];
                (kind, AlertCause { details, transponders, ..AlertCause::new(&subject, severity, text) })
            }
            Concern::Silent { identity, track, heard } => {
                let (kind, subject) = (AlertKind::Silent, subject(*identity));
                let track_id = id_of(*track);
                let text = silent(*identity, track_id.as_deref(), *heard);
                let details = AlertDetails::Silent { identity: *identity, track_id };
                let seen = picture.tracks.iter().filter(|one| Some(one.point.number) == *track);
                let (places, transponders) = (seen.map(place).collect(), vec![Some(*identity)]);
                (
                    kind,
                    AlertCause {
                        details,
                        transponders,
                        places,
                        ..AlertCause::new(&subject, Severity::Warning, text)
                    },
                )
            }
            Concern::Height { identity, track, offset_m, deviation_m } => {
                let (kind, subject) = (AlertKind::Height, subject(*identity));
                let (since, _) = self.lasting(kind, &subject, picture.time);
                let track_id = id_of(*track);
                let text =
                    contradicted_height(*identity, track_id.as_deref(), (*offset_m, *deviation_m), since);
                let offset_m = Some(offset_m.round());
                let details = AlertDetails::Height { identity: *identity, track_id, offset_m };
                let transponders = vec![Some(*identity)];
                (
                    kind,
                    AlertCause {
                        details,
                        transponders,
                        ..AlertCause::new(&subject, Severity::Warning, text)
                    },
                )
            }
            Concern::Jamming { identities, places, since } => {
                let details =
                    AlertDetails::Jamming { identities: identities.clone(), hull: hull(places, maker) };
                let text = jamming(identities, *since);
                (
                    AlertKind::Jamming,
                    AlertCause { details, ..AlertCause::new("transponders", Severity::Warning, text) },
                )
            }
        }
    }

    fn note_uncooperative(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let (kind, now) = (AlertKind::Uncooperative, picture.time);
        let marked = picture.tracks.iter().filter(|track| track.is_uncooperative);
        let found = marked.map(|track| {
            let id = maker.track_id(track);
            let text = uncooperative(track, &id, self.lasting(kind, &id, now).0);
            let details = AlertDetails::Uncooperative { is_resolved: false };
            AlertCause {
                details,
                places: vec![place(track)],
                ..AlertCause::new(&id, Severity::Warning, text)
            }
        });
        let found: Vec<AlertCause> = found.collect();
        let over: Vec<String> = picture.resolved.iter().map(|resolved| resolved.id.clone()).collect();
        for one in &picture.resolved {
            if let Some((alert, _)) = self.lasting.get_mut(&(kind, one.id.clone(), String::new())) {
                alert.text = resolved(&one.id, one.identity);
                alert.details = AlertDetails::Uncooperative { is_resolved: true };
            }
        }
        let before = self.changes.len();
        self.end(kind, now, |(_, subject, _), _| over.contains(subject));
        self.hold(kind, found, now, |_, _| true) || self.changes.len() > before
    }

    fn note_emergencies(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let (kind, now) = (AlertKind::Emergency, picture.time);
        let declaring = picture.tracks.iter().filter_map(|track| {
            let part = track.point.source.transponder()?;
            part.aircraft.declared.is_emergency().then_some((track, part.identity))
        });
        let found = declaring.map(|(track, identity)| {
            let (id, subject) = (maker.track_id(track), subject(identity));
            let text = emergency(track, &id, self.lasting(kind, &subject, now).0);
            let details = AlertDetails::Emergency { identity, track_id: Some(id) };
            let (places, transponders) = (vec![place(track)], vec![Some(identity)]);
            AlertCause {
                details,
                transponders,
                places,
                ..AlertCause::new(&subject, Severity::Critical, text)
            }
        });
        let found: Vec<AlertCause> = found.collect();
        self.hold(kind, found, now, |_, _| true)
    }

    /// Start and data of the active alert; `now` and `None` if there is none.
    fn lasting(&self, kind: AlertKind, subject: &str, now: Time) -> (Time, Option<&AlertDetails>) {
        let known = self.lasting.get(&(kind, subject.to_owned(), String::new()));
        known.map_or((now, None), |(alert, _)| (alert.since, Some(&alert.details)))
    }
}

/// Longitude and latitude, in degrees.
fn place(track: &PictureTrack) -> (f64, f64) {
    (track.position.longitude_deg(), track.position.latitude_deg())
}

/// Identifies a transponder in one line: serial number and country.
fn subject(identity: Identity) -> String {
    format!("{} {}", serial_text(identity), identity.country().escape_ascii())
}

/// A closed ring around the places, at least the margin away from each.
fn hull(places: &[Enu], maker: &PictureMaker) -> Vec<(f64, f64)> {
    // Enlarged radius, so that the polygon's edges too keep the margin.
    let radius_m = HULL_MARGIN_M / (std::f64::consts::PI / CORNERS as f64).cos();
    let corners = places.iter().flat_map(|place| {
        (0..CORNERS).map(move |corner| {
            let (sin, cos) = (corner as f64 * std::f64::consts::TAU / CORNERS as f64).sin_cos();
            Point::new(place.east() + radius_m * cos, place.north() + radius_m * sin)
        })
    });
    let mut ring: LineString = corners.collect::<MultiPoint>().convex_hull().exterior().clone();
    ring.make_ccw_winding();
    let place = |corner: &geo::Coord| {
        let place = maker.place(Enu::new(corner.x, corner.y, 0.0));
        (rounded(place.longitude_deg(), 6), rounded(place.latitude_deg(), 6))
    };
    ring.0.iter().map(place).collect()
}
