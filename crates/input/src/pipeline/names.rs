//! Equal serial numbers from several kinds of sources are one aircraft.
//!
//! A transponder (CAT129) states a serial number of at most 12 octets with a registration country; Remote ID states one of at
//! most 20 without. They are one aircraft if their last 12 octets are equal, one number ends with the other, and they do not
//! state different countries. The identity that was received first represents both.

use serde::{Deserialize, Serialize};

use super::generations::Generations;
use fusion::Identity;
use fusion::time::Time;

/// Number of octets of a serial number that every source can state (I129/040).
const COMMON: usize = 12;

/// Recent identities by the octets of their serial numbers that every source can state.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Names(Generations<Vec<u8>, Identity>);

impl Names {
    /// The identity that represents this one.
    pub(super) fn settle(&mut self, identity: Identity, now: Time) -> Identity {
        let Some(serial) = identity.serial() else { return identity };
        let common = &serial[serial.len().saturating_sub(COMMON)..];
        let Some(known) = self.0.of(common.to_vec(), now, || identity) else { return identity };
        let has_one = |identity: &Identity| !identity.country().is_empty();
        let is_shorter = |one: &Identity, other: &Identity| one.name().ends_with(other.name());
        let is_one = is_shorter(known, &identity) || is_shorter(&identity, known);
        let contradicts = has_one(known) && has_one(&identity) && known.country() != identity.country();
        if is_one && !contradicts { *known } else { identity }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(serial: &[u8], country: Option<&[u8; 2]>) -> Identity {
        Identity::new(serial, country).unwrap()
    }

    #[test]
    fn first_identity_names_both_sources() {
        let (mut names, now) = (Names::default(), Time::default());
        let transponder = of(b"D2291000A4B2", Some(b"NO"));
        let remote_id = of(b"1581F4FKD2291000A4B2", None);
        assert_eq!(names.settle(transponder, now), transponder);
        assert_eq!(names.settle(remote_id, now), transponder);
        let (mut names, bare) = (Names::default(), of(b"A12", None));
        assert_eq!(names.settle(bare, now), bare);
        assert_eq!(names.settle(of(b"A12", Some(b"NO")), now), bare);
    }

    #[test]
    fn other_identities_stay_distinct() {
        let (mut names, now) = (Names::default(), Time::default());
        for identity in [
            of(b"A12", Some(b"NO")),
            of(b"A12", Some(b"SE")),
            of(b"0A12", None),
            Identity::of_address(0xA12),
            of(b"1581F4FKD2291000A4B2", None),
            of(b"1596F4FKD2291000A4B2", None),
        ] {
            assert_eq!(names.settle(identity, now), identity);
        }
    }
}
