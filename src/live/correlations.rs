//! An operator's decisions on their way to the engine, and which of them are in force.

use std::collections::BTreeSet;

use super::driver::Driver;
use super::requests::{Denied, Operators, Requests, requests};
use crate::picture::serial_text;
use fusion::operational::{Correlation, HeldCorrelation, NotCorrelated, Verdict};
use fusion::slots::Slot;
use fusion::{Identity, RadarTrackKey};

/// A decision that an operator asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wish {
    /// The radar track as it is now.
    pub radar: RadarTrackKey,
    /// The transponder.
    pub transponder: Named,
    /// The decision.
    pub verdict: Verdict,
}

/// A transponder as an operator names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// Its serial number, as it is shown.
    pub serial: String,
    /// Its registration country, as it is shown; needed where several have that serial number.
    pub country: Option<String>,
}

/// The operators' side, with the decisions in force; cheap to clone.
pub type Correlator = Operators<Wish, Vec<HeldCorrelation>>;

/// The engine's side.
#[derive(Debug)]
pub struct Correlations(Requests<Wish, Vec<HeldCorrelation>>);

/// Both sides.
pub(super) fn correlations() -> (Correlations, Correlator) {
    let (requests, operators) = requests();
    (Correlations(requests), operators)
}

impl Correlations {
    /// Carries out what was asked for; returns the decisions, each with the first slot that is published by it.
    pub fn obey(&self, driver: &mut Driver) -> Vec<(Slot, Correlation)> {
        self.0.obey(|wish| Ok((correlate(wish, driver)?, driver.pipeline().engine().correlations())))
    }

    /// Hands on what was asked for where the engines are elsewhere; of transponders these are known. What is then in force is
    /// what is `held`, and what was handed on.
    pub fn forward(
        &self,
        known: &BTreeSet<Identity>,
        held: &mut Vec<HeldCorrelation>,
        mut hand_on: impl FnMut(Correlation) -> Result<HeldCorrelation, Denied>,
    ) {
        self.0.obey(|wish| {
            let correlated = held.iter().map(|held| held.correlation.transponder);
            let transponder = wish.transponder.among(known.iter().copied().chain(correlated))?;
            let transponder = transponder.ok_or(NotCorrelated::NoTransponder)?;
            let decided = hand_on(Correlation { radar: wish.radar, transponder, verdict: wish.verdict })?;
            let is_same = |other: &HeldCorrelation| {
                let [one, other] = [&decided.correlation, &other.correlation];
                (one.radar, one.transponder) == (other.radar, other.transponder)
            };
            held.retain(|other| !is_same(other));
            held.extend((wish.verdict != Verdict::Automatic).then_some(decided));
            Ok(((), held.clone()))
        });
    }

    /// Publishes the decisions in force; whether they have changed.
    pub fn tell(&self, held: &[HeldCorrelation]) -> bool {
        self.0.tell(|known| *known != held, || held.to_vec())
    }
}

fn correlate(wish: &Wish, driver: &mut Driver) -> Result<(Slot, Correlation), Denied> {
    let engine = driver.pipeline().engine();
    // A transponder with a decision may have fallen silent since.
    let correlated = engine.correlations().into_iter().map(|held| held.correlation.transponder);
    let transponder = match wish.transponder.among(engine.transponders().chain(correlated))? {
        Some(transponder) => transponder,
        None if engine.knows_correlations() => return Err(NotCorrelated::NoTransponder.into()),
        None => return Err(NotCorrelated::Reference.into()),
    };
    let correlation = Correlation { radar: wish.radar, transponder, verdict: wish.verdict };
    Ok((driver.correlate(correlation)?, correlation))
}

impl Named {
    /// The one of these that is meant.
    pub(super) fn among(
        &self,
        identities: impl Iterator<Item = Identity>,
    ) -> Result<Option<Identity>, Denied> {
        let mut found: Vec<Identity> = identities.filter(|identity| self.means(*identity)).collect();
        found.sort_unstable();
        found.dedup();
        match found[..] {
            [] => Ok(None),
            [identity] => Ok(Some(identity)),
            _ => Err(Denied::Ambiguous(found.iter().map(country).collect())),
        }
    }

    fn means(&self, identity: Identity) -> bool {
        let is_serial = serial_text(identity) == self.serial;
        is_serial && self.country.as_ref().is_none_or(|wanted| *wanted == country(&identity))
    }
}

fn country(identity: &Identity) -> String {
    match identity.country() {
        [] => "none".to_owned(),
        octets => octets.escape_ascii().to_string(),
    }
}
