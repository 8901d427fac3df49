//! Matching of the same aircraft in the pictures of two cells.

use serde::{Deserialize, Serialize};

use super::cell_message::Sighting;
use fusion::slots::Slot;
use fusion::time::Time;
use picture::PictureTrack;

/// Identifies an aircraft within one engine: its number there, and the time of its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub(super) struct EngineTrackId {
    pub(super) number: u32,
    pub(super) since: Time,
}

impl EngineTrackId {
    pub(super) const fn of(track: &PictureTrack) -> Self {
        Self { number: track.point.number, since: track.point.first_seen }
    }
}

/// Time within which a radar's track number is not reused, in seconds.
const SAME_TRACK_S: f64 = 25.0;
/// Maximum squared Mahalanobis distance between two sightings of the same aircraft.
const GATE: f64 = 9.0;
/// Maximum squared Mahalanobis distance to an aircraft that was not seen for a while and may have turned. A match only delays
/// its start.
const WIDE_GATE: f64 = 25.0;
/// Metres per radian of latitude, and of longitude at the equator, accurate to 0.5 %.
const RADIAN_M: f64 = 6_367_000.0;

impl Sighting {
    /// Sighting of a track in a picture.
    pub(super) fn of(track: &PictureTrack, slot: Slot) -> Self {
        let source = &track.point.source;
        let estimate = track.point.estimate.as_ref();
        Self {
            identity: source.transponder().map(|part| part.identity),
            radar: source.radar().map(|part| (part.track, part.time)),
            slot,
            time: track.time,
            position: track.position,
            velocity: track.motion.as_ref().map_or([0.0; 2], |motion| [motion.velocity.x, motion.velocity.y]),
            covariance: estimate.map(|estimate| {
                let of = &estimate.horizontal;
                [of[(0, 0)], of[(1, 1)], of[(0, 1)]]
            }),
        }
    }

    fn is_same_identity(&self, other: &Self) -> bool {
        self.identity.is_some() && self.identity == other.identity
    }

    fn is_same_track(&self, other: &Self) -> bool {
        let (Some((track, time)), Some((of, at))) = (self.radar, other.radar) else { return false };
        track == of && time.seconds_since(at).abs() <= SAME_TRACK_S
    }

    /// Whether both have the same transponder or the same radar track.
    pub(super) fn is_certainly(&self, other: &Self) -> bool {
        self.is_same_identity(other) || self.is_same_track(other)
    }

    /// Whether no identities contradict that both are the same aircraft.
    fn may_be(&self, other: &Self) -> bool {
        let (Some(one), Some(other)) = (self.identity, other.identity) else { return true };
        one == other
    }

    /// Whether an aircraft that was offered unseen may be the one seen now.
    pub(super) fn may_have_been(&self, other: &Self) -> bool {
        self.may_be(other) && self.away(other).is_some_and(|away| away < WIDE_GATE)
    }

    /// Squared distance in standard deviations, after extrapolation of this sighting to the other's time.
    fn away(&self, other: &Self) -> Option<f64> {
        let ([ee, nn, en], [oee, onn, oen]) = (self.covariance?, other.covariance?);
        let after_s = other.time.seconds_since(self.time);
        let north =
            (other.position.latitude - self.position.latitude) * RADIAN_M - self.velocity[1] * after_s;
        let east =
            (other.position.longitude - self.position.longitude) * RADIAN_M * self.position.latitude.cos()
                - self.velocity[0] * after_s;
        let (ee, nn, en) = (ee + oee, nn + onn, en + oen);
        let determinant = ee * nn - en * en;
        let away = (east * east * nn - 2.0 * east * north * en + north * north * ee) / determinant;
        (determinant > 0.0).then_some(away)
    }
}

/// Finds the aircraft `wanted` in `seen`: by identity, else by radar track, else by position if exactly one is near.
pub(super) fn find<'a>(
    wanted: &Sighting,
    seen: &(impl Iterator<Item = (EngineTrackId, &'a Sighting)> + Clone),
) -> Option<EngineTrackId> {
    let first = |of: &dyn Fn(&Sighting) -> bool| {
        seen.clone().find(|(_, other)| of(other)).map(|(track_id, _)| track_id)
    };
    let by_name = first(&|other| wanted.is_same_identity(other));
    let by_track = || first(&|other| wanted.may_be(other) && wanted.is_same_track(other));
    by_name.or_else(by_track).or_else(|| {
        let is_near =
            |other: &Sighting| wanted.may_be(other) && wanted.away(other).is_some_and(|away| away < GATE);
        let mut near = seen.clone().filter(|(_, other)| is_near(other));
        near.next().filter(|_| near.next().is_none()).map(|(track_id, _)| track_id)
    })
}
