//! An engine's picture as its cell publishes it.

use serde::{Deserialize, Serialize};

use super::matching::Inner;
use crate::picture::{Picture, PictureTrack};
use fusion::integrity::Concern;
use fusion::point::Rival;
use fusion::time::Time;
use fusion::{Identity, Source};

/// What an aircraft is called, for life and in every cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Public {
    pub(super) id: String,
    pub(super) number: u32,
    pub(super) first_seen: Time,
}

/// Leaves the aircraft that are published, with what is said of them; `number`: that of an identity.
pub(super) fn publish(
    picture: &mut Picture,
    published: impl Fn(Inner) -> Option<Public>,
    number: impl Fn(Identity) -> Option<u32>,
) {
    let called: Vec<(u32, Inner, Option<Public>)> = picture
        .tracks
        .iter()
        .map(|track| (track.point.number, Inner::of(track), published(Inner::of(track))))
        .collect();
    // Within one picture an engine's numbers are unique.
    let of_number = |inner: u32| {
        let found = called.iter().find(|(number, ..)| *number == inner);
        found.and_then(|(.., public)| public.as_ref())
    };
    let mut publics = called.iter().map(|(.., public)| public.clone());
    picture.tracks.retain_mut(|track| {
        let Some(public) = publics.next().flatten() else { return false };
        let disputed: Vec<&Public> =
            track.point.disputed.iter().filter_map(|number| of_number(*number)).collect();
        track.disputed = disputed.iter().map(|other| other.id.clone()).collect();
        track.point.disputed = disputed.iter().map(|other| other.number).collect();
        rename(track, public, &number);
        true
    });
    picture.tracks.sort_by_key(PictureTrack::order);
    // Of an aircraft that is not this cell's its own cell speaks.
    picture.concerns.retain_mut(|concern| match concern {
        Concern::Integrity { track, twin, .. } => {
            *twin = twin.and_then(&of_number).map(|twin| twin.number);
            is_own(track, of_number)
        }
        Concern::Silent { track, .. } => is_own(track, of_number),
        Concern::Jamming { .. } => true,
    });
    picture.resolved.retain_mut(|resolved| {
        let inner_id = |number: u32, since: Time| match number {
            10_000.. => format!("U-{number}"),
            _ => format!("U-{number}-{}", since.as_seconds()),
        };
        let own = called.iter().find(|(number, inner, _)| inner_id(*number, inner.since) == resolved.id);
        let public = own.and_then(|(.., public)| public.as_ref());
        public.map(|public| resolved.id.clone_from(&public.id)).is_some()
    });
}

fn is_own<'a>(track: &mut Option<u32>, of_number: impl Fn(u32) -> Option<&'a Public>) -> bool {
    *track = track.and_then(of_number).map(|public| public.number);
    track.is_some()
}

fn rename(track: &mut PictureTrack, public: Public, number: impl Fn(Identity) -> Option<u32>) {
    let point = &mut track.point;
    (point.number, point.first_seen) = (public.number, public.first_seen);
    track.id = Some(public.id);
    if let Source::Fused(_, part, _) | Source::Transponder(part) = &mut point.source {
        part.number = number(part.identity).unwrap_or(part.number);
    }
    for competitor in &mut point.competitors {
        if let Rival::Transponder { number: of, identity, .. } = &mut competitor.who {
            *of = number(*identity);
        }
    }
}
