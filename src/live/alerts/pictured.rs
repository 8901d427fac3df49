//! Alerts that follow from a slot's picture.

use std::collections::BTreeMap;

use geo::{ConvexHull, LineString, MultiPoint, Point, Winding};

use super::wording::{emergency, jamming, lying, resolved, silent, uncooperative};
use super::{AlertKind, Alerts, Basis, Details, Found, Severity};
use crate::json::rounded;
use crate::picture::{Picture, PictureMaker, PictureTrack, serial_text};
use fusion::integrity::{Concern, State};
use fusion::time::Time;
use fusion::{Enu, Identity};

/// Around the places where jammed transponders were heard last, metres.
const HULL_MARGIN_M: f64 = 100.0;
/// Corners of a circle around a place.
const CORNERS: usize = 24;

impl Alerts {
    /// Looks at a slot's picture; whether there is anything new to show.
    pub fn note_picture(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let now = picture.time;
        // A replay went back: what was wrong later is not wrong yet.
        let went_back = self.pictured.replace(now).is_some_and(|before| now < before);
        if went_back {
            self.lasting.clear();
            self.ended.clear();
            self.changes.clear();
            self.operators.rewind();
            self.approaches.clear();
        }
        self.derive(Basis::Picture, now);
        went_back
            | self.note_areas(picture, maker)
            | self.note_transponders(picture, maker)
            | self.note_uncooperative(picture, maker)
            | self.note_emergencies(picture, maker)
    }

    /// The engine says for how long a concern lasts.
    fn note_transponders(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let kinds = [AlertKind::Integrity, AlertKind::Silent, AlertKind::Jamming];
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

    fn raised(&self, concern: &Concern, picture: &Picture, maker: &PictureMaker) -> (AlertKind, Found) {
        let id_of = |number: Option<u32>| {
            let track = picture.tracks.iter().find(|track| Some(track.point.number) == number)?;
            Some(maker.track_id(track))
        };
        match concern {
            Concern::Integrity { identity, track, twin, state, reasons, offset_m } => {
                let (kind, subject) = (AlertKind::Integrity, subject(*identity));
                let (since, before) = self.lasting(kind, &subject, picture.time);
                let (known_track, known_twin) = match before {
                    Some(Details::Integrity { track_id, twin_id, .. }) => (track_id.clone(), twin_id.clone()),
                    _ => (None, None),
                };
                // Without a point in this slot it is known by its last one.
                let details = Details::Integrity {
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
                (kind, Found { details, transponders, ..Found::new(&subject, severity, text) })
            }
            Concern::Silent { identity, track, heard } => {
                let (kind, subject) = (AlertKind::Silent, subject(*identity));
                let track_id = id_of(*track);
                let text = silent(*identity, track_id.as_deref(), *heard);
                let details = Details::Silent { identity: *identity, track_id };
                let seen = picture.tracks.iter().filter(|one| Some(one.point.number) == *track);
                let (places, transponders) = (seen.map(place).collect(), vec![Some(*identity)]);
                (
                    kind,
                    Found { details, transponders, places, ..Found::new(&subject, Severity::Warning, text) },
                )
            }
            Concern::Jamming { identities, places, since } => {
                let details = Details::Jamming { identities: identities.clone(), hull: hull(places, maker) };
                let text = jamming(identities, *since);
                (AlertKind::Jamming, Found { details, ..Found::new("transponders", Severity::Warning, text) })
            }
        }
    }

    fn note_uncooperative(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let (kind, now) = (AlertKind::Uncooperative, picture.time);
        let marked = picture.tracks.iter().filter(|track| track.is_uncooperative);
        let found = marked.map(|track| {
            let id = maker.track_id(track);
            let text = uncooperative(track, &id, self.lasting(kind, &id, now).0);
            let details = Details::Uncooperative { is_resolved: false };
            Found { details, places: vec![place(track)], ..Found::new(&id, Severity::Warning, text) }
        });
        let found: Vec<Found> = found.collect();
        let over: Vec<String> = picture.resolved.iter().map(|resolved| resolved.id.clone()).collect();
        for one in &picture.resolved {
            if let Some((alert, _)) = self.lasting.get_mut(&(kind, one.id.clone(), String::new())) {
                alert.text = resolved(&one.id, one.identity);
                alert.details = Details::Uncooperative { is_resolved: true };
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
            let details = Details::Emergency { identity, track_id: Some(id) };
            let (places, transponders) = (vec![place(track)], vec![Some(identity)]);
            Found { details, transponders, places, ..Found::new(&subject, Severity::Critical, text) }
        });
        let found: Vec<Found> = found.collect();
        self.hold(kind, found, now, |_, _| true)
    }

    /// Since when there is an alert about that, and what it said; from `now` on where there is none.
    fn lasting(&self, kind: AlertKind, subject: &str, now: Time) -> (Time, Option<&Details>) {
        let known = self.lasting.get(&(kind, subject.to_owned(), String::new()));
        known.map_or((now, None), |(alert, _)| (alert.since, Some(&alert.details)))
    }
}

/// Longitude and latitude, degrees.
fn place(track: &PictureTrack) -> (f64, f64) {
    (track.position.longitude_deg(), track.position.latitude_deg())
}

/// What tells an identity from all others, in a line.
fn subject(identity: Identity) -> String {
    format!("{} {}", serial_text(identity), identity.country().escape_ascii())
}

/// A closed ring around the places, at least the margin away from each.
fn hull(places: &[Enu], maker: &PictureMaker) -> Vec<(f64, f64)> {
    // A polygon of that radius has its edges nearer.
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
