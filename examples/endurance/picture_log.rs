//! Published pictures, and checks on them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{Debug, Formatter, Result as Written};

use fusion::numbering::Given;
use fusion::time::Time;
use fusion::{Enu, Identity};
use utm_fusion::config::Profile;
use utm_fusion::picture::{Picture, PictureTrack, PublishedMotion};

/// A condition that was violated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation(pub String);

/// Published position of a transponder with its 95 % radius. The profile `reference` has no radius.
#[derive(Clone, Copy)]
pub struct PublishedPosition {
    position: Enu,
    motion: Option<PublishedMotion>,
}

impl PublishedPosition {
    fn of(track: &PictureTrack) -> Self {
        Self { position: track.point.position, motion: track.motion }
    }

    /// Whether both can be the same place: their distance is within the uncertainty of either.
    pub fn agrees(&self, other: &Self) -> bool {
        let (Some(here), Some(there)) = (self.motion, other.motion) else { return true };
        let apart = self.position.0 - other.position.0;
        apart.xy().norm() <= here.accuracy_h_m.max(there.accuracy_h_m)
            && apart.z.abs() <= here.accuracy_v_m.max(there.accuracy_v_m)
    }
}

impl Debug for PublishedPosition {
    fn fmt(&self, f: &mut Formatter<'_>) -> Written {
        let [east, north, up] = self.position.0.into();
        write!(f, "{east:.0}, {north:.0}, {up:.0}")?;
        match self.motion {
            Some(motion) => write!(f, " ± {:.0}, {:.0}", motion.accuracy_h_m, motion.accuracy_v_m),
            None => Ok(()),
        }
    }
}

/// All pictures published over all runs of a service.
#[derive(Debug, Default)]
pub struct PictureLog {
    /// Whether the profile is `reference`. It fuses each radar track near a transponder, so that a transponder may
    /// occur several times in a slot; a track number of a radar alone is the radar's own.
    is_reference: bool,
    /// Centre of the latest slot.
    latest: Option<Time>,
    /// Time that the clock showed before it was set back. Slots up to this time may be published once more.
    repeated_until: Option<Time>,
    /// Track number of each transponder.
    numbers: BTreeMap<Identity, u32>,
    /// Published transponders and positions in each slot; the latest ones if the clock repeated the slot.
    pub shown: BTreeMap<Time, BTreeMap<Identity, PublishedPosition>>,
    /// Number of slots.
    pub slots: u64,
}

impl PictureLog {
    /// An empty book for this profile.
    pub fn of(profile: Profile) -> Self {
        Self { is_reference: profile == Profile::Reference, ..Self::default() }
    }

    /// Notes that the clock is set back, from time `from`.
    pub fn set_back(&mut self, from: Time) {
        self.repeated_until = self.repeated_until.max(Some(from));
    }

    /// Adds a picture.
    ///
    /// # Errors
    /// The slot was published before, or an aircraft is in it twice.
    pub fn note(&mut self, picture: &Picture) -> Result<(), Violation> {
        if let Some(latest) = self.latest.filter(|latest| picture.time <= *latest)
            && self.repeated_until.take().is_none_or(|until| picture.time > until)
        {
            return Err(Violation(format!("slot {} is published after {latest}", picture.time)));
        }
        self.latest = Some(picture.time);
        self.slots += 1;
        let (mut numbers, mut places) = (BTreeSet::new(), BTreeMap::new());
        for track in &picture.tracks {
            let (number, source) = (track.point.number, &track.point.source);
            if !numbers.insert((number, self.is_reference.then(|| source.transponder().is_some()))) {
                return Err(Violation(format!("{number} is there twice in {}", picture.time)));
            }
            let Some(part) = track.point.source.transponder() else { continue };
            if places.insert(part.identity, PublishedPosition::of(track)).is_some() && !self.is_reference {
                return Err(Violation(format!("{:?} is there twice in {}", part.identity, picture.time)));
            }
        }
        self.shown.insert(picture.time, places);
        Ok(())
    }

    /// Notes the number of a transponder.
    ///
    /// # Errors
    /// The transponder had another number before.
    pub fn numbered(&mut self, given: &Given) -> Result<(), Violation> {
        let who = given.identity;
        let before = *self.numbers.entry(who).or_insert(given.number);
        if before == given.number {
            Ok(())
        } else {
            Err(Violation(format!("{who:?} was {before} and is {}", given.number)))
        }
    }
}
