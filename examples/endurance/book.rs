//! What was published, and whether it may be so.

use std::collections::{BTreeMap, BTreeSet};

use fusion::Identity;
use fusion::numbering::Given;
use fusion::time::Time;
use utm_fusion::config::Profile;
use utm_fusion::picture::Picture;

/// What must hold and did not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken(pub String);

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
    /// Who was published in each slot, the latest where the clock repeated it.
    pub shown: BTreeMap<Time, BTreeSet<Identity>>,
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
        let (mut numbers, mut identities) = (BTreeSet::new(), BTreeSet::new());
        for track in &picture.tracks {
            let (number, source) = (track.point.number, &track.point.source);
            if !numbers.insert((number, self.is_reference.then(|| source.transponder().is_some()))) {
                return Err(Broken(format!("{number} is there twice in {}", picture.time)));
            }
            let Some(part) = track.point.source.transponder() else { continue };
            if !identities.insert(part.identity) && !self.is_reference {
                return Err(Broken(format!("{:?} is there twice in {}", part.identity, picture.time)));
            }
        }
        self.shown.insert(picture.time, identities);
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
