//! What was published, and whether it may be so.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{Debug, Formatter, Result as Written};

use fusion::numbering::Given;
use fusion::time::Time;
use fusion::{Enu, Identity};
use utm_fusion::config::Profile;
use utm_fusion::picture::{Motion, Picture, PictureTrack};

/// What must hold and did not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken(pub String);

/// Where a transponder is shown, and how far from there it is in one case of twenty; the profile `reference` does not say.
#[derive(Clone, Copy)]
pub struct Place {
    position: Enu,
    motion: Option<Motion>,
}

impl Place {
    fn of(track: &PictureTrack) -> Self {
        Self { position: track.point.position, motion: track.motion }
    }

    /// Whether it can be the same place: one is as near to the other as that may be from the truth.
    pub fn agrees(&self, other: &Self) -> bool {
        let (Some(here), Some(there)) = (self.motion, other.motion) else { return true };
        let apart = self.position.0 - other.position.0;
        apart.xy().norm() <= here.accuracy_h_m.max(there.accuracy_h_m)
            && apart.z.abs() <= here.accuracy_v_m.max(there.accuracy_v_m)
    }
}

impl Debug for Place {
    fn fmt(&self, f: &mut Formatter<'_>) -> Written {
        let [east, north, up] = self.position.0.into();
        write!(f, "{east:.0}, {north:.0}, {up:.0}")?;
        match self.motion {
            Some(motion) => write!(f, " ± {:.0}, {:.0}", motion.accuracy_h_m, motion.accuracy_v_m),
            None => Ok(()),
        }
    }
}

/// All that was published over all lives of a service.
#[derive(Debug, Default)]
pub struct Book {
    /// Whether it is by the rules of `reference`: each radar track near a transponder is fused with it, so that one may be in a slot
    /// several times, and its number alone is that of the radar's track of the same number.
    is_reference: bool,
    /// The centre of the latest slot.
    latest: Option<Time>,
    /// What the clock showed before it was set back: times up to that may come again, from one on, once.
    repeated_until: Option<Time>,
    /// Which number each transponder has had.
    numbers: BTreeMap<Identity, u32>,
    /// Who was published in each slot, and where; the latest where the clock repeated it.
    pub shown: BTreeMap<Time, BTreeMap<Identity, Place>>,
    /// How many slots.
    pub slots: u64,
}

impl Book {
    /// An empty one for that profile.
    pub fn of(profile: Profile) -> Self {
        Self { is_reference: profile == Profile::Reference, ..Self::default() }
    }

    /// The clock is set back, from that time on.
    pub fn set_back(&mut self, from: Time) {
        self.repeated_until = self.repeated_until.max(Some(from));
    }

    /// Notes a picture.
    ///
    /// # Errors
    /// Its slot was published before, or an aircraft is in it twice.
    pub fn note(&mut self, picture: &Picture) -> Result<(), Broken> {
        if let Some(latest) = self.latest.filter(|latest| picture.time <= *latest)
            && self.repeated_until.take().is_none_or(|until| picture.time > until)
        {
            return Err(Broken(format!("slot {} is published after {latest}", picture.time)));
        }
        self.latest = Some(picture.time);
        self.slots += 1;
        let (mut numbers, mut places) = (BTreeSet::new(), BTreeMap::new());
        for track in &picture.tracks {
            let (number, source) = (track.point.number, &track.point.source);
            if !numbers.insert((number, self.is_reference.then(|| source.transponder().is_some()))) {
                return Err(Broken(format!("{number} is there twice in {}", picture.time)));
            }
            let Some(part) = track.point.source.transponder() else { continue };
            if places.insert(part.identity, Place::of(track)).is_some() && !self.is_reference {
                return Err(Broken(format!("{:?} is there twice in {}", part.identity, picture.time)));
            }
        }
        self.shown.insert(picture.time, places);
        Ok(())
    }

    /// Notes the number of a transponder.
    ///
    /// # Errors
    /// It had another one before.
    pub fn numbered(&mut self, given: &Given) -> Result<(), Broken> {
        let who = given.identity;
        let before = *self.numbers.entry(who).or_insert(given.number);
        if before == given.number {
            Ok(())
        } else {
            Err(Broken(format!("{who:?} was {before} and is {}", given.number)))
        }
    }
}
