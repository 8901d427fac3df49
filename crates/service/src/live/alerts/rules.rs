//! Rules of `[alerts]`: which alerts are raised, with what severity and hold time, and in which areas.

use std::collections::{BTreeMap, BTreeSet};

use geo::{Intersects, MultiPolygon, Point};

use super::{AlertCause, AlertKind, Severity};
use fusion::Identity;
use picture::serial_text;
use site::areas::{AlertAreas, Areas};
use site::config;

/// Settings for raising alerts.
#[derive(Clone, Debug, Default)]
pub struct AlertSettings {
    /// Areas in which a track raises an alert.
    pub(super) areas: AlertAreas,
    rules: BTreeMap<AlertKind, AlertRule>,
}

#[derive(Clone, Debug)]
struct AlertRule {
    enabled: bool,
    severity: Option<Severity>,
    hold_ns: Option<u64>,
    /// Serial numbers of exempt transponders.
    allow: BTreeSet<String>,
    /// Areas to which the rule is limited; `None`: no limit.
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
    /// Settings of a configuration whose areas have been read.
    ///
    /// # Errors
    /// A rule names an area that does not exist.
    pub fn new(alerts: &config::Alerts, areas: &Areas) -> Result<Self, UnknownArea> {
        let rule = |rule: &config::AlertRule| Ok((rule.kind, AlertRule::new(rule, areas)?));
        let rules = alerts.rules.iter().map(rule).collect::<Result<_, _>>()?;
        Ok(Self { areas: areas.alerts(), rules })
    }

    /// These settings with other areas. The rules keep the areas that the configuration names.
    #[must_use]
    pub fn with_areas(&self, areas: AlertAreas) -> Self {
        Self { areas, rules: self.rules.clone() }
    }

    #[cfg(test)]
    pub(super) fn of(areas: AlertAreas) -> Self {
        Self { areas, rules: BTreeMap::new() }
    }

    /// Whether the rules admit an alert of that kind for this cause.
    pub(super) fn admits(&self, kind: AlertKind, found: &AlertCause) -> bool {
        self.rules.get(&kind).is_none_or(|rule| {
            rule.enabled && !rule.are_allowed(&found.transponders) && rule.is_among(&found.places)
        })
    }

    /// Whether a lie of this transponder raises an alert, which covers what follows from it.
    pub(super) fn reports_lies(&self, identity: Identity) -> bool {
        let rule = self.rules.get(&AlertKind::Integrity);
        rule.is_none_or(|rule| rule.enabled && !rule.are_allowed(&[Some(identity)]))
    }

    /// Severity of an alert of that kind; `own` unless a rule sets another.
    pub(super) fn severity(&self, kind: AlertKind, own: Severity) -> Severity {
        self.rules.get(&kind).and_then(|rule| rule.severity).unwrap_or(own)
    }

    /// Time for which the cause has to be absent until the alert ends, in nanoseconds.
    pub(super) fn hold_ns(&self, kind: AlertKind) -> u64 {
        let usual = || kind.usual_hold().as_nanos().unsigned_abs() as u64;
        self.rules.get(&kind).and_then(|rule| rule.hold_ns).unwrap_or_else(usual)
    }
}

impl AlertRule {
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

    /// Whether all transponders are exempt. An aircraft without a transponder (`None`) never is.
    fn are_allowed(&self, transponders: &[Option<Identity>]) -> bool {
        let is_allowed = |identity: &Option<Identity>| {
            identity.is_some_and(|identity| self.allow.contains(&serial_text(identity)))
        };
        !self.allow.is_empty() && !transponders.is_empty() && transponders.iter().all(is_allowed)
    }

    /// Whether one of the places (longitude and latitude, degrees) is inside the rule's areas, or the rule has no areas.
    fn is_among(&self, places: &[(f64, f64)]) -> bool {
        let is_in = |areas: &MultiPolygon| {
            places.iter().any(|&(longitude, latitude)| areas.intersects(&Point::new(longitude, latitude)))
        };
        self.places.as_ref().is_none_or(is_in)
    }
}
