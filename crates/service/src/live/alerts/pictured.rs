//! Alerts that follow from a slot's picture.

use std::collections::{BTreeMap, BTreeSet};

use geo::{ConvexHull, LineString, MultiPoint, Point, Winding};

use super::wording::{
    at, contradicted_height, emergency, jamming, lying, resolved, silent, uncooperative, was_contradicted,
    were_jammed,
};
use super::{AlertCause, AlertDetails, AlertInput, AlertKind, AlertMonitor, Severity};
use fusion::integrity::{Concern, State};
use fusion::time::{SECOND, Time};
use fusion::{Enu, Identity};
use input::json::rounded;
use picture::{Picture, PictureMaker, PictureTrack, serial_text, short_serial};

/// Margin around the last positions of jammed transponders, in metres.
const HULL_MARGIN_M: f64 = 100.0;
/// Time for which a name is remembered, in nanoseconds.
const NAMED_NS: u64 = 600 * SECOND as u64;
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
            self.pasts.clear();
            self.names.clear();
            self.situations.clear();
        }
        self.note_names(picture);
        self.derive(AlertInput::Picture, now);
        went_back
            | self.note_transponders(picture, maker)
            | self.note_areas(picture, maker)
            | self.note_uncooperative(picture, maker)
            | self.note_emergencies(picture, maker)
    }

    /// No hold is needed here: the engine decides when a concern ends.
    fn note_transponders(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let lies = Lies::of(picture);
        let kinds = [AlertKind::Integrity, AlertKind::Silent, AlertKind::Height, AlertKind::Jamming];
        let mut found = BTreeMap::from(kinds.map(|kind| (kind, Vec::new())));
        for concern in picture.concerns.iter().filter(|concern| !self.is_covered(concern, &lies)) {
            let (kind, raised) = self.raised(concern, picture, maker);
            found.entry(kind).or_default().push(raised);
        }
        let mut is_new = false;
        for (kind, found) in found {
            is_new |= self.hold(kind, found, picture.time, |_, _| true);
        }
        is_new
    }

    /// Whether the alert about a lying transponder covers this one: the lie explains its silence and its heights.
    fn is_covered(&self, concern: &Concern, lies: &Lies) -> bool {
        match concern {
            Concern::Silent { identity, .. } | Concern::Height { identity, .. } => {
                lies.identities.contains(identity) && self.settings.get().reports_lies(*identity)
            }
            Concern::Integrity { .. } | Concern::Jamming { .. } => false,
        }
    }

    /// Records the names of transponders, for alerts about those that are no longer in the picture.
    fn note_names(&mut self, picture: &Picture) {
        let now = picture.time;
        self.names.retain(|_, (_, seen)| now.nanos().abs_diff(seen.nanos()) <= NAMED_NS);
        for track in &picture.tracks {
            let Some(part) = track.point.source.transponder() else { continue };
            let (name, seen) = self.names.entry(part.identity).or_default();
            name.clone_from(&track.name);
            *seen = now;
        }
    }

    fn transponder_name(&self, identity: Identity) -> String {
        self.names.get(&identity).map_or_else(|| short_serial(identity), |(name, _)| name.clone())
    }

    fn raised(&self, concern: &Concern, picture: &Picture, maker: &PictureMaker) -> (AlertKind, AlertCause) {
        let id_of = |number: Option<u32>| {
            let track = picture.tracks.iter().find(|track| Some(track.point.number) == number)?;
            Some(maker.track_id(track))
        };
        let name_of = |identity: Identity, number: Option<u32>| {
            let is_of = |track: &&PictureTrack| {
                let part = track.point.source.transponder();
                Some(track.point.number) == number && part.is_some_and(|part| part.identity == identity)
            };
            let track = picture.tracks.iter().find(is_of);
            track.map_or_else(|| self.transponder_name(identity), |track| track.name.clone())
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
                let name = name_of(*identity, *track);
                let twin = picture.tracks.iter().find(|track| Some(track.point.number) == *twin);
                let twin = twin.map(|track| track.name.clone());
                let text = lying(&name, twin.as_deref(), &details, since);
                let was = if *state == State::Failed { "not to be trusted" } else { "suspect" };
                let past = format!("transponder {name} was {was} from {} on", at(since));
                let transponders = vec![Some(*identity)];
                (
                    kind,
                    AlertCause { details, transponders, past, ..AlertCause::new(&subject, severity, text) },
                )
            }
            Concern::Silent { identity, track, heard } => {
                let (kind, subject) = (AlertKind::Silent, subject(*identity));
                let track_id = id_of(*track);
                let name = name_of(*identity, *track);
                let text = silent(&name, *heard);
                let past = format!("transponder {name} was silent from {} on", at(*heard));
                let details = AlertDetails::Silent { identity: *identity, track_id };
                let seen = picture.tracks.iter().filter(|one| Some(one.point.number) == *track);
                let (places, transponders) = (seen.map(place).collect(), vec![Some(*identity)]);
                (
                    kind,
                    AlertCause {
                        details,
                        transponders,
                        places,
                        past,
                        ..AlertCause::new(&subject, Severity::Warning, text)
                    },
                )
            }
            Concern::Height { identity, track, offset_m, deviation_m } => {
                let (kind, subject) = (AlertKind::Height, subject(*identity));
                let (since, _) = self.lasting(kind, &subject, picture.time);
                let track_id = id_of(*track);
                let name = name_of(*identity, *track);
                let text = contradicted_height(&name, (*offset_m, *deviation_m), since);
                let past = was_contradicted(&name, *offset_m);
                let offset_m = Some(offset_m.round());
                let details = AlertDetails::Height { identity: *identity, track_id, offset_m };
                let transponders = vec![Some(*identity)];
                (
                    kind,
                    AlertCause {
                        details,
                        transponders,
                        past,
                        ..AlertCause::new(&subject, Severity::Warning, text)
                    },
                )
            }
            Concern::Jamming { identities, places, since } => {
                let details =
                    AlertDetails::Jamming { identities: identities.clone(), hull: hull(places, maker) };
                let names: Vec<String> = identities.iter().map(|&one| self.transponder_name(one)).collect();
                let text = jamming(&names, *since);
                let past = were_jammed(&names, *since);
                (
                    AlertKind::Jamming,
                    AlertCause { details, past, ..AlertCause::new("transponders", Severity::Warning, text) },
                )
            }
        }
    }

    fn note_uncooperative(&mut self, picture: &Picture, maker: &PictureMaker) -> bool {
        let (kind, now) = (AlertKind::Uncooperative, picture.time);
        let lies = Lies::of(picture);
        let settings = self.settings.get();
        // The aircraft of a lying transponder is known.
        let is_twin = |track: &&PictureTrack| {
            let liar = lies.twins.get(&track.point.number);
            liar.is_some_and(|&identity| settings.reports_lies(identity))
        };
        let marked = picture.tracks.iter().filter(|track| track.is_uncooperative && !is_twin(track));
        let found = marked.map(|track| {
            let id = maker.track_id(track);
            let name = track.name.clone();
            let text = uncooperative(&name, self.lasting(kind, &id, now).0);
            let details = AlertDetails::Uncooperative { is_resolved: false };
            AlertCause {
                details,
                past: format!("{name} flew without a transponder where one would be heard"),
                places: vec![place(track)],
                ..AlertCause::new(&id, Severity::Warning, text)
            }
        });
        let found: Vec<AlertCause> = found.collect();
        let over: Vec<String> = picture.resolved.iter().map(|resolved| resolved.id.clone()).collect();
        for one in &picture.resolved {
            let key = (kind, one.id.clone(), String::new());
            let track = picture.tracks.iter().find(|track| maker.track_id(track) == one.id);
            let name = track.map(|track| track.name.clone());
            let transponder = one.identity.map(|identity| self.transponder_name(identity));
            if let Some((alert, _)) = self.lasting.get_mut(&key) {
                alert.text = resolved(name.as_deref(), transponder.as_deref());
                self.pasts.remove(&key);
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
            let name = track.name.clone();
            let text = emergency(&name, self.lasting(kind, &subject, now).0);
            let past = format!("{name} declared an emergency");
            let details = AlertDetails::Emergency { identity, track_id: Some(id) };
            let (places, transponders) = (vec![place(track)], vec![Some(identity)]);
            AlertCause {
                details,
                transponders,
                places,
                past,
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

/// Failed transponders of a picture, and the tracks that radar sees in their place. A suspect transponder may be right.
struct Lies {
    identities: BTreeSet<Identity>,
    /// Transponder of each track that radar sees in place of it, by track number.
    twins: BTreeMap<u32, Identity>,
}

impl Lies {
    fn of(picture: &Picture) -> Self {
        let mut lies = Self { identities: BTreeSet::new(), twins: BTreeMap::new() };
        for concern in &picture.concerns {
            if let Concern::Integrity { identity, twin, state: State::Failed, .. } = concern {
                lies.identities.insert(*identity);
                lies.twins.extend(twin.map(|twin| (twin, *identity)));
            }
        }
        lies
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
