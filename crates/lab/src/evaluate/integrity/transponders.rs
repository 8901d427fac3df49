//! Transponders of a stream of points, and the one under attack.

use std::collections::BTreeMap;

use super::attacks::Attack;
use crate::evaluate::types::OutputPoint;
use fusion::time::Time;

/// Key of a transponder within a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum TransponderKey<'a> {
    /// The service's number, if the points do not state the identity.
    Number(u32),
    /// Name of the identity.
    Named(&'a str),
}

impl<'a> TransponderKey<'a> {
    /// Transponder of a point; `None` for a point of a radar.
    pub(super) fn of(point: &'a OutputPoint) -> Option<Self> {
        let number = point.transponder?;
        Some(point.identity.as_deref().map_or(Self::Number(number), Self::Named))
    }
}

/// Transponders of a stream, each with the service's number.
pub(super) struct StreamTransponders<'a>(BTreeMap<TransponderKey<'a>, u32>);

impl<'a> StreamTransponders<'a> {
    pub(super) fn of(points: &'a [OutputPoint]) -> Self {
        Self(
            points
                .iter()
                .filter_map(|point| Some((TransponderKey::of(point)?, point.transponder?)))
                .collect(),
        )
    }

    /// The transponder under attack: the one whose serial number is the attack's, since another transponder may already
    /// have taken that track number; else the one with that number.
    pub(super) fn attacked(&self, attack: &Attack) -> Option<TransponderKey<'a>> {
        let has_serial = |transponder: &TransponderKey<'_>| match transponder {
            TransponderKey::Named(name) => name.parse() == Ok(attack.number),
            TransponderKey::Number(_) => false,
        };
        let by_serial = self.0.keys().copied().find(has_serial);
        by_serial.or_else(|| self.0.iter().find(|of| *of.1 == attack.number).map(|of| *of.0))
    }

    /// Time from which each attacked transponder sends false reports.
    pub(super) fn attack_begins(&self, attacks: &[Attack]) -> BTreeMap<TransponderKey<'a>, Time> {
        let mut attack_begins = BTreeMap::new();
        for attack in attacks.iter().filter(|attack| attack.kind.is_attack()) {
            if let Some(transponder) = self.attacked(attack) {
                let from = attack_begins.entry(transponder).or_insert(attack.from);
                *from = attack.from.min(*from);
            }
        }
        attack_begins
    }
}
