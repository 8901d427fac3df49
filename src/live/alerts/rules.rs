//! Which alerts are raised, how bad they are and how long they are held: `[alerts]`, with the areas that it names.

use std::collections::{BTreeMap, BTreeSet};

use geo::{Intersects, MultiPolygon, Point};

use super::{AlertKind, Found, Severity};
use crate::areas::{AlertAreas, Areas};
use crate::config;
use crate::picture::serial_text;
use fusion::Identity;

/// What alerts are raised by.
#[derive(Clone, Debug, Default)]
pub struct AlertSettings {
    /// A track inside one of them raises one.
    pub(super) areas: AlertAreas,
    rules: BTreeMap<AlertKind, Rule>,
}

#[derive(Clone, Debug)]
struct Rule {
    enabled: bool,
    severity: Option<Severity>,
    hold_ns: Option<u64>,
    /// Serial numbers.
    allow: BTreeSet<String>,
    /// `None`: everywhere.
    places: Option<MultiPolygon>,
}

/// A rule names an area that is not configured.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("alerts.rules, kind \"{kind}\": no area is called \"{name}\"; the areas are: {known}")]
pub struct UnknownArea {
    kind: &'static str,
    name: String,
    known: String,
}

impl AlertSettings {
    /// Those of a configuration, whose areas have been read.
    ///
    /// # Errors
    /// A rule names an area that is not there.
    pub fn new(alerts: &config::Alerts, areas: &Areas) -> Result<Self, UnknownArea> {
        let rule = |rule: &config::AlertRule| Ok((rule.kind, Rule::new(rule, areas)?));
        let rules = alerts.rules.iter().map(rule).collect::<Result<_, _>>()?;
        Ok(Self { areas: areas.alerts(), rules })
    }

    #[cfg(test)]
    pub(super) fn of(areas: AlertAreas) -> Self {
        Self { areas, rules: BTreeMap::new() }
    }

    /// Whether there are alerts of that kind about what was found.
    pub(super) fn admits(&self, kind: AlertKind, found: &Found) -> bool {
        self.rules.get(&kind).is_none_or(|rule| {
            rule.enabled && !rule.are_allowed(&found.transponders) && rule.is_among(&found.places)
        })
    }

    /// How bad an alert of that kind is, that would be `own`.
    pub(super) fn severity(&self, kind: AlertKind, own: Severity) -> Severity {
        self.rules.get(&kind).and_then(|rule| rule.severity).unwrap_or(own)
    }

    /// How long what an alert of that kind is about has to be over until it ends, nanoseconds.
    pub(super) fn hold_ns(&self, kind: AlertKind) -> u64 {
        let usual = || kind.usual_hold().as_nanos().unsigned_abs() as u64;
        self.rules.get(&kind).and_then(|rule| rule.hold_ns).unwrap_or_else(usual)
    }
}

impl Rule {
    fn new(rule: &config::AlertRule, areas: &Areas) -> Result<Self, UnknownArea> {
        let mut polygons = Vec::new();
        for name in &rule.areas {
            let before = polygons.len();
            let named = areas.parts().filter(|part| part.zone.name == *name);
            named.for_each(|named| polygons.extend(named.polygon));
            if polygons.len() == before {
                let known: BTreeSet<String> = areas.zones().map(|(_, zone)| zone.name.clone()).collect();
                let known = known.into_iter().collect::<Vec<_>>().join(", ");
                return Err(UnknownArea { kind: rule.kind.name(), name: name.clone(), known });
            }
        }
        Ok(Self {
            enabled: rule.enabled,
            severity: rule.severity,
            hold_ns: rule.hold_s.map(|hold| hold.as_nanos().unsigned_abs() as u64),
            allow: rule.allow.iter().cloned().collect(),
            places: (!rule.areas.is_empty()).then(|| MultiPolygon::new(polygons)),
        })
    }

    /// Whether all of them are; an aircraft without a transponder (`None`) never is.
    fn are_allowed(&self, transponders: &[Option<Identity>]) -> bool {
        let is_allowed = |identity: &Option<Identity>| {
            identity.is_some_and(|identity| self.allow.contains(&serial_text(identity)))
        };
        !self.allow.is_empty() && !transponders.is_empty() && transponders.iter().all(is_allowed)
    }

    /// Whether one of the places (longitude and latitude, degrees) is inside the areas, or there is no limit.
    fn is_among(&self, places: &[(f64, f64)]) -> bool {
        let is_in = |areas: &MultiPolygon| {
            places.iter().any(|&(longitude, latitude)| areas.intersects(&Point::new(longitude, latitude)))
        };
        self.places.as_ref().is_none_or(is_in)
    }
}
