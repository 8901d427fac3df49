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
    /// Alerts (docs/ALERTS.md).
    Alerts {
        /// Rules of kinds of alerts, one of a kind at most; a kind without one keeps the defaults.
        rules: Vec<AlertRule> = Vec::new(), tables(), reloaded;
        /// HTTP servers that alerts are posted to.
        webhooks: Vec<Webhook> = Vec::new(), tables();
        /// A broker of MQTT 5 that alerts are published on.
        mqtt: Option<Mqtt> = absent("none"), inline::<Mqtt>();
    } by hand {}
}

section! {
    /// What holds for the alerts of a kind.
    AlertRule {
        /// Of which kind.
        kind: AlertKind = need("kind = \"silent\", or another kind of alerts"), named();
        /// Whether there are any.
        enabled: bool = true, flag();
        /// How bad they are.
        severity: Option<Severity> = absent("as bad as what they are about"), named::<Severity>();
        /// An alert ends when what it is about has been over for longer than this, seconds: what comes and goes is one alert.
        hold_s: Option<SignedDuration> = absent("10 for silent and uncooperative, 4 for area-predicted, 3 for area, 0 for the others"),
            seconds("a hold is between 0 and 3600 seconds", |s| (0.0..=3600.0).contains(&s));
        /// Serial numbers of transponders that raise none; of a conflict both have to be named.
        allow: Vec<String> = Vec::new(), list(any_text());
        /// Names of `[[areas]]`, of any kind: there are none but in these, at any height.
        areas: Vec<String> = Vec::new(), list(any_text());
    } by hand {}
}

names! {
    /// What an alert is about.
    #[derive(Copy, Eq, PartialOrd, Ord, Hash)]
    AlertKind, "kind of alert" {
        /// A sensor is not operational.
        Sensor = "sensor",
        /// A track is inside an alert area.
        Area = "area",
        /// A track is about to enter one.
        AreaPredicted = "area-predicted",
        /// Something is wrong with the service itself.
        Service = "service",
        /// The alignment of a radar seems to have changed.
        Registration = "registration",
        /// A transponder may not be where it says it is, or whose.
        Integrity = "integrity",
        /// Many transponders fell silent at once.
        Jamming = "jamming",
        /// A transponder fell silent, and a radar still sees the aircraft.
        Silent = "silent",
        /// A drone flies without a transponder where one is to be heard.
        Uncooperative = "uncooperative",
        /// Two aircraft come near each other.
        Conflict = "conflict",
        /// An aircraft declares an emergency.
        Emergency = "emergency",
    }
}

names! {
    /// How bad an alert is.
    #[derive(Copy, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    Severity, "severity" {
        /// To look at.
        Warning = "warning",
        /// To act on.
        Critical = "critical",
    }
}
written_by_name!(AlertKind, Severity);

/// A blank.
impl Default for AlertKind {
    fn default() -> Self {
        Self::Sensor
    }
}

const _: () = assert!(AlertKind::ALL.len() == <AlertKind as tables::named::Named>::NAMES.len());

impl AlertKind {
    /// All kinds.
    pub const ALL: [Self; 11] = [
        Self::Sensor,
        Self::Area,
        Self::AreaPredicted,
        Self::Service,
        Self::Registration,
        Self::Integrity,
        Self::Jamming,
        Self::Silent,
        Self::Uncooperative,
        Self::Conflict,
        Self::Emergency,
    ];

    /// How long what an alert is about has to be over, where no rule says it. By judgement: who is inside an area may flicker
    /// at its edge or be missed by the radar; entries are foreseen once a second, and the fifth time that one is not it is
    /// over; an uncooperative track is remembered for so long; at the edge of a radar's sight
    /// the track of a silent transponder comes and goes for some seconds. The others have a hysteresis of their own.
    pub const fn usual_hold(self) -> SignedDuration {
        SignedDuration::from_secs(match self {
            Self::Area => 3,
            Self::AreaPredicted => 4,
            Self::Silent | Self::Uncooperative | Self::Emergency => 10,
            _ => 0,
        })
    }

    /// Whether its alerts are about transponders that can be named.
    const fn has_transponders(self) -> bool {
        matches!(
            self,
            Self::Area
                | Self::AreaPredicted
                | Self::Integrity
                | Self::Silent
                | Self::Conflict
                | Self::Emergency
        )
    }

    /// Whether its alerts are about a place.
    const fn has_place(self) -> bool {
        matches!(self, Self::Silent | Self::Uncooperative | Self::Conflict | Self::Emergency)
    }
}

/// One rule of a kind, one webhook of an id.
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

/// What a kind has.
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
