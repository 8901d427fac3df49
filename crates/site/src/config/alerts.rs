//! `[alerts]`.

use std::collections::BTreeSet;

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::receivers::{Mqtt, Webhook};
use tables::kinds::{any_text, flag, inline, list, named, seconds, tables};
use tables::reader::Section;
use tables::section;
use tables::table::{ByHand, absent, need};
use tables::{names, written_by_name};

section! {
    /// Alerts and their receivers (docs/ALERTS.md).
    Alerts {
        /// Rules per kind of alert, at most one per kind. A kind without a rule keeps the defaults.
        rules: Vec<AlertRule> = Vec::new(), tables(), reloaded;
        /// HTTP servers to which alerts are posted.
        webhooks: Vec<Webhook> = Vec::new(), tables();
        /// MQTT 5 broker to which alerts are published.
        mqtt: Option<Mqtt> = absent("none"), inline::<Mqtt>();
    } by hand {}
}

section! {
    /// Settings for one kind of alert.
    AlertRule {
        /// Kind of alert that the rule applies to.
        kind: AlertKind = need("kind = \"silent\", or another kind of alerts"), named();
        /// Whether alerts of this kind are raised.
        enabled: bool = true, flag();
        /// Severity of these alerts.
        severity: Option<Severity> = absent("as bad as what they are about"), named::<Severity>();
        /// Time after which an alert ends once its condition is over, in seconds. A condition that returns within this time
        /// continues the same alert.
        hold_s: Option<SignedDuration> = absent("10 for conflict, emergency, height, silent and uncooperative, 4 for area-predicted, 3 for area, 0 for the others"),
            seconds("a hold is between 0 and 3600 seconds", |s| (0.0..=3600.0).contains(&s));
        /// Serial numbers of transponders that raise no alert of this kind. A conflict raises none only if both aircraft are
        /// listed.
        allow: Vec<String> = Vec::new(), list(any_text());
        /// Names of `[[areas]]`, of any kind. If given, alerts of this kind are raised only inside these areas, at any height.
        areas: Vec<String> = Vec::new(), list(any_text());
    } by hand {}
}

names! {
    /// Kind of alert, by its condition.
    #[derive(Copy, Eq, PartialOrd, Ord, Hash)]
    AlertKind, "kind of alert" {
        /// A sensor is not operational.
        Sensor = "sensor",
        /// A track is inside an alert area.
        Area = "area",
        /// A track is predicted to enter an alert area.
        AreaPredicted = "area-predicted",
        /// A part of the service itself has a problem.
        Service = "service",
        /// The alignment of a radar seems to have changed.
        Registration = "registration",
        /// The position or identity that a transponder reports is in doubt.
        Integrity = "integrity",
        /// Many transponders fell silent at the same time.
        Jamming = "jamming",
        /// A transponder fell silent while a radar still sees the aircraft.
        Silent = "silent",
        /// A transponder's heights contradict those of radars, and their reference is unknown.
        Height = "height",
        /// A drone flies without a transponder where a receiver should hear one.
        Uncooperative = "uncooperative",
        /// Two aircraft are predicted to come too close to each other.
        Conflict = "conflict",
        /// An aircraft declares an emergency.
        Emergency = "emergency",
    }
}

names! {
    /// Severity of an alert.
    #[derive(Copy, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    Severity, "severity" {
        /// Needs attention.
        Warning = "warning",
        /// Needs action.
        Critical = "critical",
    }
}
written_by_name!(AlertKind, Severity);

/// Placeholder of a rule whose kind is not read yet.
impl Default for AlertKind {
    fn default() -> Self {
        Self::Sensor
    }
}

const _: () = assert!(AlertKind::ALL.len() == <AlertKind as tables::named::Named>::NAMES.len());

impl AlertKind {
    /// All kinds of alerts.
    pub const ALL: [Self; 12] = [
        Self::Sensor,
        Self::Area,
        Self::AreaPredicted,
        Self::Service,
        Self::Registration,
        Self::Integrity,
        Self::Jamming,
        Self::Silent,
        Self::Height,
        Self::Uncooperative,
        Self::Conflict,
        Self::Emergency,
    ];

    /// Default of `hold_s`, chosen by judgement. The other kinds have a hysteresis of their own.
    ///
    /// - `Area`: a track may flicker at the edge of an area, or the radar may miss it.
    /// - `AreaPredicted`: entries are predicted once a second; the alert ends at the fifth prediction without one.
    /// - `Conflict`: two aircraft that circle each other are one situation.
    /// - `Uncooperative`: an uncooperative track is remembered for this time.
    /// - `Silent`: at the limit of a radar's coverage, the track of a silent transponder comes and goes for some seconds.
    pub const fn usual_hold(self) -> SignedDuration {
        SignedDuration::from_secs(match self {
            Self::Area => 3,
            Self::AreaPredicted => 4,
            Self::Conflict | Self::Silent | Self::Height | Self::Uncooperative | Self::Emergency => 10,
            _ => 0,
        })
    }

    /// Whether alerts of this kind concern transponders, so that `allow` applies.
    const fn has_transponders(self) -> bool {
        matches!(
            self,
            Self::Area
                | Self::AreaPredicted
                | Self::Integrity
                | Self::Silent
                | Self::Height
                | Self::Conflict
                | Self::Emergency
        )
    }

    /// Whether alerts of this kind have a position, so that `areas` applies.
    const fn has_place(self) -> bool {
        matches!(self, Self::Silent | Self::Uncooperative | Self::Conflict | Self::Emergency)
    }
}

/// Rejects two rules of one kind and two webhooks of one id.
impl ByHand for Alerts {
    fn more(&mut self, section: &mut Section<'_>) {
        let mut kinds = BTreeSet::new();
        if let Some(twice) = self.rules.iter().find(|rule| !kinds.insert(rule.kind)) {
            section.contradict(
                &["rules"],
                format!("there are two rules of kind \"{}\"; make one of them", twice.kind.name()),
            );
        }
        let mut ids = BTreeSet::new();
        if let Some(twice) = self.webhooks.iter().find(|webhook| !ids.insert(&webhook.id)) {
            section.contradict(
                &["webhooks"],
                format!("there are two webhooks of id \"{}\"; rename one", twice.id),
            );
        }
    }
}

/// Rejects keys that do not apply to the rule's kind.
impl ByHand for AlertRule {
    fn more(&mut self, section: &mut Section<'_>) {
        if !section.is_sound(&["kind"]) {
            return;
        }
        let kind = self.kind.name();
        if !self.allow.is_empty() && !self.kind.has_transponders() {
            section.contradict(
                &["allow"],
                format!(
                    "alerts of kind \"{kind}\" are about no transponder that can be named; remove the key"
                ),
            );
        }
        if !self.areas.is_empty() && !self.kind.has_place() {
            section.contradict(
                &["areas"],
                format!(
                    "only alerts of kind silent, uncooperative and conflict can be limited to areas, not \"{kind}\"; remove \
                     the key"
                ),
            );
        }
    }
}
