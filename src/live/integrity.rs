//! Whether transponders can be trusted: what is known of each, and operators' words on their way to the engine.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::correlations::Named;
use super::driver::Driver;
use super::requests::{Denied, Operators, Requests, requests};
use fusion::Identity;
use fusion::integrity::{Assessment, HeldWord, Reason, Trust, Word};
use fusion::operational::NotCorrelated;
use fusion::slots::Slot;
use fusion::time::{SECOND, Time};

/// What an operator says of a transponder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Saying {
    /// Which one.
    pub transponder: Named,
    /// What.
    pub trust: Trust,
}

/// What is known of transponders; published once a second, and at once where a state has changed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Integrities {
    /// Of the latest slot; `None` before the first.
    pub at: Option<Time>,
    /// Those heard in the last hour.
    pub assessments: Vec<Assessment>,
    /// Operators' words in force.
    pub words: Vec<HeldWord>,
    /// Flags of each reason since the start.
    pub flags: BTreeMap<Reason, u64>,
}

/// The operators' side, with what is known; cheap to clone.
pub type IntegrityDesk = Operators<Saying, Integrities>;

/// The engine's side.
#[derive(Debug)]
pub struct IntegrityRequests(Requests<Saying, Integrities>);

/// Both sides.
pub(super) fn integrity() -> (IntegrityRequests, IntegrityDesk) {
    let (requests, operators) = requests();
    (IntegrityRequests(requests), operators)
}

impl IntegrityRequests {
    /// Carries out what was asked for; returns the words, each with the first slot that is published by it.
    pub fn obey(&self, driver: &mut Driver) -> Vec<(Slot, Word)> {
        let at = driver.latest();
        self.0.obey(|saying| Ok((say(saying, driver)?, Integrities::of(driver, at))))
    }

    /// Hands on what was asked for where the engines are elsewhere; of transponders these are known, and what `held` has.
    pub fn forward(
        &self,
        known: &BTreeSet<Identity>,
        held: &mut Integrities,
        mut hand_on: impl FnMut(Word) -> Result<HeldWord, Denied>,
    ) {
        self.0.obey(|saying| {
            let judged = held.assessments.iter().map(|assessment| assessment.identity);
            let spoken = held.words.iter().map(|held| held.word.identity);
            let identity = saying.transponder.among(known.iter().copied().chain(judged).chain(spoken))?;
            let identity = identity.ok_or(NotCorrelated::NoTransponder)?;
            let said = hand_on(Word { identity, trust: saying.trust })?;
            held.words.retain(|held| held.word.identity != identity);
            held.words.extend((saying.trust != Trust::Automatic).then_some(said));
            Ok(((), held.clone()))
        });
    }

    /// Publishes what is known where the engine is.
    pub fn show(&self, known: &Integrities) {
        self.0.tell(|before| before != known, || known.clone());
    }

    /// Publishes what is known as of the driver's latest slot, where a second has passed or a state has changed.
    pub fn tell(&self, driver: &Driver) -> bool {
        let Some(at) = driver.latest() else { return false };
        self.0.tell(|known| known.is_outdated(driver, at), || Integrities::of(driver, Some(at)))
    }
}

impl Integrities {
    /// The word in force on an identity.
    pub fn word(&self, identity: Identity) -> Option<&HeldWord> {
        self.words.iter().find(|held| held.word.identity == identity)
    }

    /// As of the driver's latest slot.
    pub(crate) fn of(driver: &Driver, at: Option<Time>) -> Self {
        let engine = driver.pipeline().engine();
        Self {
            at,
            assessments: engine.assessments().cloned().collect(),
            words: engine.words(),
            flags: driver.flags().counts().clone(),
        }
    }

    fn is_outdated(&self, driver: &Driver, at: Time) -> bool {
        // It is asked far more often than there are slots.
        if self.at == Some(at) {
            return false;
        }
        let second = |time: Time| time.nanos().div_euclid(SECOND);
        let state = |one: &Assessment| (one.identity, one.integrity.state, one.is_silent, one.twin);
        let engine = driver.pipeline().engine();
        self.at.map(second) != Some(second(at))
            || self.words != engine.words()
            || !self.assessments.iter().map(state).eq(engine.assessments().map(state))
    }
}

fn say(saying: &Saying, driver: &mut Driver) -> Result<(Slot, Word), Denied> {
    let engine = driver.pipeline().engine();
    // One that fell silent long ago may still be spoken of.
    let known = engine.assessments().map(|assessment| assessment.identity);
    let known = known.chain(engine.words().into_iter().map(|held| held.word.identity));
    let identity = saying.transponder.among(known)?.ok_or(NotCorrelated::NoTransponder)?;
    let word = Word { identity, trust: saying.trust };
    Ok((driver.say(word).ok_or(Denied::NotJudged)?, word))
}
