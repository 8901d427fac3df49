//! The transponders of a stream of points, and which of them an attack is on.

use std::collections::BTreeMap;

use super::attacks::Attack;
use crate::evaluate::types::OutputPoint;
use fusion::time::Time;

/// What tells a transponder from the others of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Transponder<'a> {
    /// The service's number, where the points do not state the identity.
    Number(u32),
    /// The name of its identity.
    Named(&'a str),
}

impl<'a> Transponder<'a> {
    /// That of a point; `None` of a radar's.
    pub(super) fn of(point: &'a OutputPoint) -> Option<Self> {
        let number = point.transponder?;
        Some(point.identity.as_deref().map_or(Self::Number(number), Self::Named))
    }
}

/// The transponders of a stream, each with the service's number.
pub(super) struct Transponders<'a>(BTreeMap<Transponder<'a>, u32>);

impl<'a> Transponders<'a> {
    pub(super) fn of(points: &'a [OutputPoint]) -> Self {
        Self(points.iter().filter_map(|point| Some((Transponder::of(point)?, point.transponder?))).collect())
    }

    /// The one that is attacked: whose serial number is the attack's, since another may have taken the number of that name
    /// before; else whose number it is.
    pub(super) fn attacked(&self, attack: &Attack) -> Option<Transponder<'a>> {
        let has_serial = |transponder: &Transponder<'_>| match transponder {
            Transponder::Named(name) => name.parse() == Ok(attack.number),
            Transponder::Number(_) => false,
        };
        let by_serial = self.0.keys().copied().find(has_serial);
        by_serial.or_else(|| self.0.iter().find(|of| *of.1 == attack.number).map(|of| *of.0))
    }

    /// From when on each of those lies that do.
    pub(super) fn lies(&self, attacks: &[Attack]) -> BTreeMap<Transponder<'a>, Time> {
        let mut lies = BTreeMap::new();
        for attack in attacks.iter().filter(|attack| attack.kind.is_lie()) {
            if let Some(transponder) = self.attacked(attack) {
                let from = lies.entry(transponder).or_insert(attack.from);
                *from = attack.from.min(*from);
            }
        }
        lies
    }
}
