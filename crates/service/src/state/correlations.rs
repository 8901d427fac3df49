//! `<name>.decisions.jsonl` beside a recording: the operators' decisions during it, one per line. They are about a radar
//! track and a transponder, about the trust in a transponder, about a radar's position (`relocations`), or about alerts
//! ([`AlertDecision`]).
//!
//! ```json
//! {"slot":7180675221,"time":"2026-11-20T10:05:05.125Z","sensor":"north","track_number":134,"serial":"1581F6GKB23C003","country":"NO","verdict":"correlated"}
//! {"slot":7180675301,"time":"2026-11-20T10:05:25.125Z","serial":"1581F6GKB23C003","country":"NO","verdict":"distrusted"}
//! ```
//!
//! In `[state] dir`, `decisions.jsonl` holds the decisions in force when the service ended. Those about a radar track have
//! `last_heard_ns`: the time of its last plot, in nanoseconds since 1970. After a restart such a decision is restored if
//! the radar reports the number again within its break; so a recording begins with such lines, too. Decisions about a
//! transponder alone are restored from the first slot on.
//!
//! `slot` counts the slots since 1970, in the configured length; `time`, its centre, is for human readers. Serial and
//! country are written as in `numbers.json`. A recording's file other than the first begins with the decisions in force.

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};
use tracing::warn;

use super::alerts::{AlertDecision, parse_alert};
use super::relocations::{RelocationLine, parse_relocation};
use super::{identity, is_serial_space, read, serial_space};
use fusion::integrity::{ActiveOverride, Trust, TrustOverride};
use fusion::operational::{ActiveAssociation, ManualAssociation, RadarRelocation, SavedAssociation, Verdict};
use fusion::slots::{Slot, SlotGrid};
use fusion::time::Time;
use fusion::{Identity, RadarTrackKey, SensorIndex};
use site::config::{Config, SensorKind};

/// End of the file's name.
pub const CORRELATIONS: &str = "decisions.jsonl";
/// Largest track number of a radar (I048/161).
const LARGEST: u16 = 4095;

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct DecisionLine {
    slot: i64,
    #[serde(default)]
    time: String,
    /// Together with `track_number`: the radar's track. Without both, the decision is about the transponder alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensor: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    track_number: Option<u16>,
    #[serde(default = "serial_space", skip_serializing_if = "is_serial_space")]
    space: String,
    serial: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    country: String,
    verdict: String,
    /// Nanoseconds since 1970; exact, because it decides about the restoration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    last_heard_ns: Option<i64>,
}

/// Decisions during a flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedDecisions {
    /// Decisions about tracks and transponders, in the order of their slots.
    decided: Vec<(DecisionLine, LineDecision)>,
    /// Decisions about radars' positions, in the order of their slots.
    relocations: Vec<RelocationLine>,
    /// Decisions about alerts, in the order in which they apply.
    alerts: Vec<AlertDecision>,
}

/// Contents of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
enum LineDecision {
    /// Decision about a radar's track and a transponder.
    Pair {
        sensor: String,
        track_number: u16,
        transponder: Identity,
        verdict: Verdict,
    },
    Word(TrustOverride),
}

/// Line of a decision that applies from this slot on, with its line feed.
pub fn correlation_line(slot: Slot, correlation: &ManualAssociation, config: &Config) -> String {
    text_of(slot, correlation, None, config)
}

/// Line of a trust setting that applies from this slot on, with its line feed.
pub fn word_line(slot: Slot, word: &TrustOverride, config: &Config) -> String {
    text(&DecisionLine { verdict: word.trust.name().to_owned(), ..line_of(slot, word.identity, config) })
}

/// Lines of the decisions and trust settings that are saved for a restart.
pub fn kept_lines(kept: &[SavedAssociation], words: &[ActiveOverride], config: &Config) -> String {
    let line = |&SavedAssociation { held, heard }: &SavedAssociation| {
        text_of(held.since, &held.correlation, Some(heard), config)
    };
    let words = words.iter().map(|held| word_line(held.since, &held.word, config));
    kept.iter().map(line).chain(words).collect()
}

fn text_of(slot: Slot, correlation: &ManualAssociation, heard: Option<Time>, config: &Config) -> String {
    let ManualAssociation { radar, transponder, verdict } = correlation;
    let sensor = config.sensors.get(usize::from(radar.sensor.0));
    text(&DecisionLine {
        sensor: Some(sensor.map(|sensor| sensor.id.clone()).unwrap_or_default()),
        track_number: Some(radar.number),
        verdict: verdict.name().to_owned(),
        last_heard_ns: heard.map(Time::nanos),
        ..line_of(slot, *transponder, config)
    })
}

/// Line about a transponder, from this slot on.
fn line_of(slot: Slot, transponder: Identity, config: &Config) -> DecisionLine {
    DecisionLine {
        slot: slot.0,
        time: SlotGrid::new(config.fusion.slot).centre(slot).to_string(),
        sensor: None,
        track_number: None,
        space: transponder.space().key().to_owned(),
        serial: transponder.name().escape_ascii().to_string(),
        country: transponder.country().escape_ascii().to_string(),
        verdict: String::new(),
        last_heard_ns: None,
    }
}

fn text(line: &DecisionLine) -> String {
    serde_json::to_string(line).expect("numbers and text are JSON") + "\n"
}

/// Decisions in a file's text.
///
/// # Errors
/// The number of the first invalid line, and what is wrong with it.
pub fn parse_decisions(text: &str) -> Result<RecordedDecisions, String> {
    let mut correlations = RecordedDecisions::default();
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        correlations.read(line).map_err(|error| format!("line {}: {error}", index + 1))?;
    }
    correlations.sort();
    Ok(correlations)
}

fn parsed(line: &str) -> Result<(DecisionLine, LineDecision), String> {
    let line: DecisionLine = serde_json::from_str(line).map_err(|error| error.to_string())?;
    let identity = identity(&line.space, &line.serial, &line.country)
        .ok_or_else(|| format!("serial {:?} with country {:?} is no identity", line.serial, line.country))?;
    let verdict = |names: &str| format!("verdict {:?} is none of {names}", line.verdict);
    let decided = match (&line.sensor, line.track_number) {
        (Some(_), Some(number)) if number > LARGEST => {
            return Err(format!("track_number {number} is not 0 to {LARGEST}"));
        }
        (Some(sensor), Some(track_number)) => LineDecision::Pair {
            sensor: sensor.clone(),
            track_number,
            transponder: identity,
            verdict: Verdict::of_name(&line.verdict)
                .ok_or_else(|| verdict("correlated, decorrelated, automatic"))?,
        },
        (None, None) => {
            let trust = Trust::of_name(&line.verdict);
            LineDecision::Word(TrustOverride {
                identity,
                trust: trust.ok_or_else(|| verdict("trusted, distrusted, automatic"))?,
            })
        }
        _ => return Err("a radar's track needs both its sensor and its track_number".to_owned()),
    };
    Ok((line, decided))
}

/// Reads such a file.
///
/// # Errors
/// The file cannot be read (or does not exist), or is invalid; the error names the file and the line.
pub fn read_correlations(path: &Path) -> io::Result<RecordedDecisions> {
    read(path, parse_decisions)
}

impl RecordedDecisions {
    /// Number of decisions.
    pub fn len(&self) -> usize {
        self.decided.len() + self.relocations.len() + self.alerts.len()
    }

    /// Whether there are no decisions.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Adds the decisions of another file of the same flight, which may begin with known ones.
    pub fn join(&mut self, other: Self) {
        add_new(&mut self.decided, other.decided);
        add_new(&mut self.relocations, other.relocations);
        add_new(&mut self.alerts, other.alerts);
        self.sort();
    }

    /// Adds the decision of a line.
    fn read(&mut self, line: &str) -> Result<(), String> {
        if let Some(decision) = parse_alert(line)? {
            self.alerts.push(decision);
        } else if let Some(decision) = parse_relocation(line)? {
            self.relocations.push(decision);
        } else {
            self.decided.push(parsed(line)?);
        }
        Ok(())
    }

    /// Stable: decisions of the same slot keep their order.
    fn sort(&mut self) {
        self.decided.sort_by_key(|(line, _)| line.slot);
        self.relocations.sort_by_key(|line| line.slot);
        self.alerts.sort_by_key(|decision| decision.after);
    }

    /// Decisions for an engine of this configuration; those that do not apply to it are logged.
    pub fn plan(&self, config: &Config) -> CorrelationPlan {
        let relocations: Vec<_> = self.relocations.iter().filter_map(|line| line.decided(config)).collect();
        let unused = self.relocations.len() - relocations.len();
        let mut plan = CorrelationPlan {
            alerts: self.alerts.clone(),
            relocations,
            unused,
            ..CorrelationPlan::default()
        };
        for (line, decided) in &self.decided {
            let since = Slot(line.slot);
            let (named, number, transponder, verdict) = match decided {
                LineDecision::Pair { sensor, track_number, transponder, verdict } => {
                    (sensor, *track_number, *transponder, *verdict)
                }
                LineDecision::Word(word) => {
                    plan.words.push((since, *word));
                    continue;
                }
            };
            let is_radar = |sensor: &site::config::Sensor| {
                sensor.id == *named && matches!(sensor.kind, SensorKind::Radar(_))
            };
            let Some(index) = config.sensors.iter().position(is_radar) else {
                warn!(decided = line.time, radar = named, "decision is not used: there is no such radar");
                plan.unused += 1;
                continue;
            };
            let radar = RadarTrackKey { sensor: SensorIndex(index as u16), number };
            let correlation = ManualAssociation { radar, transponder, verdict };
            match line.last_heard_ns {
                Some(nanos) => {
                    let held = ActiveAssociation { correlation, since };
                    plan.kept.push(SavedAssociation { held, heard: Time::from_nanos(nanos) });
                }
                None => plan.correlated.push((since, correlation)),
            }
        }
        plan
    }
}

/// Decisions for an engine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CorrelationPlan {
    /// Decisions of the flight, each with the slot from which it applies ([`Engine::plan`](fusion::Engine::plan)).
    pub correlated: Vec<(Slot, ManualAssociation)>,
    /// Decisions in force before a restart ([`Engine::resume`](fusion::Engine::resume)).
    pub kept: Vec<SavedAssociation>,
    /// Trust settings, each with the slot from which it applies ([`Engine::plan_trust_overrides`](fusion::Engine::plan_trust_overrides)).
    pub words: Vec<(Slot, TrustOverride)>,
    /// Radars' positions, each with the slot from which it applies ([`Engine::plan_relocations`](fusion::Engine::plan_relocations)).
    pub relocations: Vec<(Slot, RadarRelocation)>,
    /// Decisions about alerts, in the order in which they apply.
    pub alerts: Vec<AlertDecision>,
    /// Number of decisions about radars that are not configured.
    pub unused: usize,
}

/// Adds the items that are not known yet.
fn add_new<T: PartialEq>(known: &mut Vec<T>, others: Vec<T>) {
    for other in others {
        if !known.contains(&other) {
            known.push(other);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config() -> Config {
        let site = include_str!("../../../../testdata/demo/site.toml");
        Config::parse(site, "site.toml", std::iter::empty()).unwrap()
    }

    fn radar(config: &Config) -> SensorIndex {
        let radar = |sensor: &site::config::Sensor| matches!(sensor.kind, SensorKind::Radar(_));
        SensorIndex(config.sensors.iter().position(radar).unwrap() as u16)
    }

    #[test]
    fn decisions_are_read_in_slot_order() {
        let config = config();
        let correlation = |number, serial: &[u8; 12], verdict| ManualAssociation {
            radar: RadarTrackKey { sensor: radar(&config), number },
            transponder: Identity::new(serial, Some(b"NO")).unwrap(),
            verdict,
        };
        let correlations = [
            (Slot(12), correlation(4095, b"a\"b\\c'd\n\x00\x80\xff ", Verdict::Decorrelated)),
            (Slot(7), correlation(0, b"PLAIN       ", Verdict::Correlated)),
            (Slot(7), correlation(0, b"PLAIN       ", Verdict::Automatic)),
        ];
        let text: String = correlations
            .iter()
            .map(|(slot, correlation)| correlation_line(*slot, correlation, &config))
            .collect();
        let mut read = parse_decisions(&text).unwrap();
        let plan = read.plan(&config);
        assert_eq!(plan.correlated, [correlations[1], correlations[2], correlations[0]]);
        assert!(plan.unused == 0 && plan.kept.is_empty());
        let held = ActiveAssociation { correlation: correlations[0].1, since: Slot(12) };
        let kept = SavedAssociation { held, heard: Time::from_nanos(1_795_000_000_123_456_789) };
        let again = parse_decisions(&kept_lines(&[kept], &[], &config)).unwrap().plan(&config);
        assert_eq!((again.kept, again.correlated), (vec![kept], vec![]));
        read.join(parse_decisions(&text).unwrap());
        assert_eq!(read.len(), 3, "what is known already");

        let word = |trust| TrustOverride { identity: correlations[0].1.transponder, trust };
        let said = [(Slot(7), word(Trust::Distrusted)), (Slot(9), word(Trust::Automatic))];
        let lines = said.map(|(slot, word)| word_line(slot, &word, &config)).concat();
        let plan = parse_decisions(&(text.clone() + &lines)).unwrap().plan(&config);
        assert_eq!((plan.words, plan.correlated.len()), (said.to_vec(), 3));
        let held = ActiveOverride { word: word(Trust::Trusted), since: Slot(12) };
        let again = parse_decisions(&kept_lines(&[kept], &[held], &config)).unwrap().plan(&config);
        assert_eq!((again.kept, again.words), (vec![kept], vec![(held.since, held.word)]));

        let other = text.replace("\"sensor\":\"", "\"sensor\":\"no-");
        let CorrelationPlan { correlated, unused, .. } = parse_decisions(&other).unwrap().plan(&config);
        assert!(correlated.is_empty() && unused == 3);
    }

    #[test]
    fn damaged_line_is_reported_with_its_number() {
        let good = r#"{"slot":1,"sensor":"r","track_number":1,"serial":"A","verdict":"correlated"}"#;
        assert_eq!(parse_decisions(&format!("{good}\n\n{good}\n")).unwrap().len(), 2);
        assert!(parse_decisions("").unwrap().is_empty());
        for (bad, why) in [
            (&good[..40], "EOF"),
            (&good.replace("correlated", "maybe"), "verdict \"maybe\""),
            (&good.replace("\"A\"", "\"\""), "is no identity"),
            (&good.replace(":1,\"serial", ":4096,\"serial"), "track_number 4096"),
            (&good.replace("slot", "slots"), "unknown field"),
            (&good.replace("\"sensor\":\"r\",", ""), "needs both"),
            (
                &good.replace("\"sensor\":\"r\",\"track_number\":1,", ""),
                "none of trusted, distrusted, automatic",
            ),
            (&good.replace("correlated", "trusted"), "none of correlated"),
        ] {
            let error = parse_decisions(&format!("{good}\n{bad}\n")).unwrap_err();
            assert!(error.starts_with("line 2: ") && error.contains(why), "{error}");
        }
    }
}
