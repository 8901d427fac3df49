//! The engine's picture as published by its cell.

use serde::{Deserialize, Serialize};

use super::matching::EngineTrackId;
use fusion::integrity::Concern;
use fusion::point::Rival;
use fusion::time::Time;
use fusion::{Identity, Source};
use picture::{Picture, PictureTrack};

/// Name of an aircraft, permanent and the same in every cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PublicName {
    pub(super) id: String,
    pub(super) number: u32,
    pub(super) first_seen: Time,
}

/// Reduces a picture to the published aircraft and the statements about them. `number` returns the number of an identity.
pub(super) fn publish(
    picture: &mut Picture,
    published: impl Fn(EngineTrackId) -> Option<PublicName>,
    number: impl Fn(Identity) -> Option<u32>,
) {
    let called: Vec<(u32, EngineTrackId, Option<PublicName>)> = picture
        .tracks
        .iter()
        .map(|track| (track.point.number, EngineTrackId::of(track), published(EngineTrackId::of(track))))
        .collect();
    // An engine's numbers are unique within one picture.
    let of_number = |track_id: u32| {
        let found = called.iter().find(|(number, ..)| *number == track_id);
        found.and_then(|(.., public)| public.as_ref())
    };
    let mut publics = called.iter().map(|(.., public)| public.clone());
    picture.tracks.retain_mut(|track| {
        let Some(public) = publics.next().flatten() else { return false };
        let disputed: Vec<&PublicName> =
            track.point.disputed.iter().filter_map(|number| of_number(*number)).collect();
        track.disputed = disputed.iter().map(|other| other.id.clone()).collect();
        track.point.disputed = disputed.iter().map(|other| other.number).collect();
        rename(track, public, &number);
        true
    });
    picture.tracks.sort_by_key(PictureTrack::order);
    // The owner's cell reports on an aircraft that this cell does not own.
    picture.concerns.retain_mut(|concern| match concern {
        Concern::Integrity { track, twin, .. } => {
            *twin = twin.and_then(&of_number).map(|twin| twin.number);
            is_own(track, of_number)
        }
        Concern::Silent { track, .. } | Concern::Height { track, .. } => is_own(track, of_number),
        Concern::Jamming { .. } => true,
    });
    picture.resolved.retain_mut(|resolved| {
        let inner_id = |number: u32, since: Time| match number {
            10_000.. => format!("U-{number}"),
            _ => format!("U-{number}-{}", since.as_seconds()),
        };
        let own =
            called.iter().find(|(number, track_id, _)| inner_id(*number, track_id.since) == resolved.id);
        let public = own.and_then(|(.., public)| public.as_ref());
        public.map(|public| resolved.id.clone_from(&public.id)).is_some()
    });
}

fn is_own<'a>(track: &mut Option<u32>, of_number: impl Fn(u32) -> Option<&'a PublicName>) -> bool {
    *track = track.and_then(of_number).map(|public| public.number);
    track.is_some()
}

fn rename(track: &mut PictureTrack, public: PublicName, number: impl Fn(Identity) -> Option<u32>) {
    let point = &mut track.point;
    (point.number, point.first_seen) = (public.number, public.first_seen);
    track.id = Some(public.id);
    if let Source::Fused(_, part, _) | Source::Transponder(part) = &mut point.source {
        part.number = number(part.identity).unwrap_or(part.number);
    }
    for part in &mut point.also {
        part.number = number(part.identity).unwrap_or(part.number);
    }
    for competitor in &mut point.competitors {
        if let Rival::Transponder { number: of, identity, .. } = &mut competitor.who {
            *of = number(*identity);
        }
    }
}
