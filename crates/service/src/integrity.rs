//! Counts of transponders flagged.

use std::collections::{BTreeMap, BTreeSet};

use fusion::Identity;
use fusion::integrity::{Concern, Reason, Reasons};

/// Flags since the start. A flag is the moment at which a reason first speaks against an identity.
#[derive(Clone, Debug, Default)]
pub struct Flags {
    /// Reasons against each identity in the latest slot.
    lasting: BTreeMap<Identity, Reasons>,
    counts: BTreeMap<Reason, u64>,
    identities: BTreeSet<Identity>,
}

impl Flags {
    /// Updates the counts with the concerns of a slot.
    pub fn note(&mut self, concerns: &[Concern]) {
        let before = std::mem::take(&mut self.lasting);
        for concern in concerns {
            let Concern::Integrity { identity, reasons, .. } = *concern else { continue };
            let known = before.get(&identity).copied().unwrap_or_default();
            let begun = reasons.iter().filter(|&reason| !known.contains(reason));
            begun.for_each(|reason| *self.counts.entry(reason).or_default() += 1);
            self.lasting.insert(identity, reasons);
            self.identities.insert(identity);
        }
    }

    /// Number of flags by reason, without reasons that never occurred.
    pub fn counts(&self) -> &BTreeMap<Reason, u64> {
        &self.counts
    }

    /// Identities with a flag, including those flagged by an operator only.
    pub fn identities(&self) -> &BTreeSet<Identity> {
        &self.identities
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fusion::integrity::State;

    fn flagged(serial: &[u8; 12], reasons: &[Reason]) -> Concern {
        Concern::Integrity {
            identity: Identity::new(serial, None).unwrap(),
            track: None,
            twin: None,
            state: State::Suspect,
            reasons: reasons.iter().copied().collect(),
            offset_m: None,
        }
    }

    #[test]
    fn flag_is_counted_each_time_it_is_raised() {
        let (alpha, beta) = (b"ALPHA       ", b"BETA        ");
        let mut flags = Flags::default();
        for slot in [
            vec![flagged(alpha, &[Reason::Radar])],
            vec![flagged(alpha, &[Reason::Radar, Reason::Jump]), flagged(beta, &[Reason::Radar])],
            vec![flagged(beta, &[Reason::Radar])],
            vec![flagged(alpha, &[Reason::Radar]), flagged(beta, &[])],
        ] {
            flags.note(&slot);
        }
        assert_eq!(*flags.counts(), [(Reason::Radar, 3), (Reason::Jump, 1)].into());
        assert_eq!(flags.identities().len(), 2);
    }
}
